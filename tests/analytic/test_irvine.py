"""In-plane frequencies of a shallow elastic cable (Irvine, Caughey, Proc. R. Soc. A 341, 1974)."""

import math

import pytest
from scipy.optimize import brentq

import gallop_fmu as gf
import modal

LENGTH, MASS, GRAVITY = 100.0, 1.5, 9.81
SAG_RATIO = 0.002
"""Small, since the theory is the limit of no sag; the difference grows with its square."""


def irvine_ratio(lambda_squared):
    """In-plane over out-of-plane frequency: tan x = x - 4 x^3 / lambda^2 with x = w L / (2 c)."""

    def without_poles(x):
        return (x - 4.0 * x**3 / lambda_squared) * math.cos(x) - math.sin(x)

    return brentq(without_poles, 0.5 * math.pi, 1.5 * math.pi, xtol=1e-14) / (0.5 * math.pi)


def shallow_cable(lambda_squared):
    """lambda^2 = (m g L / H)^2 EA L / (H Le) with Le = L (1 + 8 (sag/L)^2)."""
    tension = MASS * GRAVITY * LENGTH / (8.0 * SAG_RATIO)
    stretch_length = 1.0 + 8.0 * SAG_RATIO**2
    return gf.load_scene("example1").with_values(
        {
            "span": {"length": LENGTH, "sag": SAG_RATIO * LENGTH, "gravity": GRAVITY},
            "conductor.mass_per_length": MASS,
            "conductor.axial_stiffness": (
                lambda_squared * tension * stretch_length / (8.0 * SAG_RATIO) ** 2
            ),
            "numerics.elements": 40,
        }
    )


@pytest.mark.parametrize(
    ("lambda_squared", "ratio"),
    [(1.0, 1.040200), (10.0, 1.345125), (30.0, 1.826435), (4.0 * math.pi**2, 2.0)],
)
def test_the_transcendental_equation_has_the_known_roots(lambda_squared, ratio):
    assert irvine_ratio(lambda_squared) == pytest.approx(
        ratio, abs=1e-6
    )  # observed 5e-7, the digits printed


@pytest.mark.parametrize("lambda_squared", [1.0, 10.0, 30.0, 4.0 * math.pi**2, 100.0])
def test_the_frequency_ratio_is_irvines(lambda_squared):
    ratio = modal.frequency_ratio(shallow_cable(lambda_squared)).ratio
    assert ratio == pytest.approx(
        irvine_ratio(lambda_squared), rel=8e-6
    )  # observed at most 4.7e-6, at lambda^2 = 1


@pytest.mark.parametrize(("lambda_squared", "loops"), [(30.0, 1), (50.0, 3)])
def test_the_first_symmetric_mode_has_inner_nodes_beyond_the_crossover(lambda_squared, loops):
    first = next(
        mode
        for mode in modal.natural_modes(shallow_cable(lambda_squared))
        if mode.family == "vertical" and mode.symmetric
    )
    assert first.loops == loops


def test_out_of_plane_frequencies_are_those_of_a_string():
    wave_speed = math.sqrt(GRAVITY * LENGTH / (8.0 * SAG_RATIO))  # sqrt(H/m)
    modes = [
        mode for mode in modal.natural_modes(shallow_cable(10.0)) if mode.family == "horizontal"
    ]
    for loops, mode in enumerate(modes[:4], start=1):
        assert mode.loops == loops
        # observed 6e-7, -1.4e-6, -2e-7 and, with the mesh error, 4.3e-6
        assert mode.frequency_hz == pytest.approx(loops * wave_speed / (2.0 * LENGTH), rel=7e-6)
