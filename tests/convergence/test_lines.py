"""Order of convergence of lines with strings and bundles, in step and mesh."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.engine.model import Model

CONDUCTOR = {
    "diameter": 0.02814,
    "mass_per_length": 1.628,
    "axial_stiffness": 29.0e6,
    "torsional_stiffness": 159.0,
    "torsional_inertia": 2e-4,
}
PULSE = {"kind": "pulse", "peak": 1.0, "rise": 0.8, "fall_start": 1.0, "fall": 0.8}
"""Smooth, so that it excites no axial waves that the steps do not resolve."""

STRING = {"kind": "string", "length": 2.4, "weight": 600.0, "stiffness": 1e6}


def twin(elements=6, **numerics):
    """Two uneven spans of a twin bundle on a yoke, with a spacer in each."""
    return gf.LineScene.from_dict(
        {
            "title": "twin",
            "section": {
                "horizontal_tension": 25e3,
                "spans": [{"length": 100.0}, {"length": 80.0, "height_difference": 4.0}],
                "suspensions": [STRING],
            },
            "bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 1, "arm_stiffness": 1e5},
            "conductor": CONDUCTOR,
            "loads": [{"span": 1, "position": 0.5, "force": [0.0, 60.0, 60.0], "law": PULSE}],
            "numerics": {"elements": elements, "newton_tolerance": 1e-12, **numerics},
        }
    )


def moved(**numerics):
    """u1 u2 u3 of all nodes after the pulse."""
    state = Model(twin(**numerics)).start()
    state.advance(2.0)
    return state.motion()[0][:, :3]


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.parametrize(
    ("integrator", "steps", "order"),
    [("newmark", (0.02, 0.01, 0.005), 2.0), ("generalised_alpha", (0.02, 0.01, 0.005), 2.0)],
)
def test_order_in_the_step(integrator, steps, order):
    exact = moved(integrator="gauss6", time_step=0.001)
    errors = [
        float(np.sqrt(np.mean((moved(integrator=integrator, time_step=h) - exact) ** 2)))
        for h in steps
    ]
    assert orders(errors)[-1] == pytest.approx(order, abs=0.05)  # 1.98 and 1.99 seen


def test_gauss_gains_a_digit_and_more_by_half_the_step():
    exact = moved(integrator="gauss6", time_step=0.005)
    errors = [
        float(np.sqrt(np.mean((moved(integrator="gauss6", time_step=h) - exact) ** 2)))
        for h in (0.08, 0.04, 0.02)
    ]
    assert orders(errors)[-1] > 5.0


def test_order_of_frequencies_in_the_mesh():
    found = [
        np.array([mode.frequency_hz for mode in modal.natural_modes(twin(elements=n), count=6)])
        for n in (4, 8, 16, 32)
    ]
    errors = [float(np.abs(f / found[-1] - 1.0).max()) for f in found[:-1]]
    assert orders(errors)[0] > 3.5
