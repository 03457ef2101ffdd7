"""Change of state: published stringing and sag-tension tables, the parabola, the kernel."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import gallop_fmu as gf
from gallop_fmu.line.conductors import find_conductor
from gallop_fmu.scene.sag_tension import changed_tension, ruling_span, unstretched_length

POUND, FOOT, G = 4.4482216, 0.3048, 9.80665


@pytest.mark.parametrize(
    ("span", "at_10", "at_80"),
    [
        (250, 2009.21, None),
        (300, 1953.705, 1363.500),
        (350, 1911.642, None),
        (450, 1859.15, 1527.709),
    ],
)
def test_a_published_stringing_table_in_kilograms(span, at_10, at_80):
    """Scribd 195492334, "Sagging Calculation": 1762.069 kg at 27 C, 0.987 kg/m, 243 mm2."""
    wire = {
        "axial_stiffness": 7700.0 * 243.0,
        "weight": 0.987,
        "new_weight": 0.987,
        "expansion": 18.9e-6,
    }
    for expected, temperature in ((at_10, 10.0), (at_80, 80.0)):
        if expected is not None:
            found = changed_tension(
                1762.069, span=span, temperature_change=temperature - 27.0, **wire
            )
            assert found == pytest.approx(expected, rel=6e-4)  # observed: -4.2e-4 to 2.5e-4


# Drake, 700 ft, Table 14.5 of Grigsby (ed.), Electric Power Generation, Transmission, and
# Distribution: final tension [lb] by temperature [F] and load [lb/ft]; starts from the 60 F row.
# Computed there with nonlinear strands.
FINAL = [
    (0, 1.094, 7301),
    (30, 1.094, 6242),
    (90, 1.094, 4809),
    (120, 1.094, 4330),
    (32, 2.094, 9224),
    (0, 2.509, 11318),
]


@pytest.mark.parametrize(("fahrenheit", "load", "published"), FINAL)
def test_a_published_sag_tension_table(fahrenheit, load, published):
    drake = find_conductor("Drake")
    found = changed_tension(
        5429.0 * POUND,
        span=700.0 * FOOT,
        weight=1.094 * POUND / FOOT,
        new_weight=load * POUND / FOOT,
        axial_stiffness=drake.axial_stiffness,
        temperature_change=(fahrenheit - 60.0) / 1.8,
        expansion=drake.thermal_expansion,
    )
    assert found / POUND == pytest.approx(published, rel=0.022)  # observed: -0.6 to +1.9 %


@pytest.mark.parametrize("kelvin", [-40.0, 25.0, 60.0])
def test_a_taut_span_follows_the_cubic_of_the_parabola(kelvin):
    span, EA, expansion, w0, w, H0 = 300.0, 35e6, 19e-6, 16.0, 24.0, 28e3
    found = changed_tension(
        H0,
        span=span,
        weight=w0,
        new_weight=w,
        axial_stiffness=EA,
        temperature_change=kelvin,
        expansion=expansion,
    )
    b = EA * (w0**2 * span**2 / (24.0 * H0**2) + expansion * kelvin) - H0
    roots = np.roots([1.0, b, 0.0, -EA * w**2 * span**2 / 24.0])
    (cubic,) = roots[(np.abs(roots.imag) < 1e-6) & (roots.real > 0.0)].real
    assert found == pytest.approx(cubic, rel=5e-4)  # observed: 2.4 to 3.5e-4


def test_the_kernel_agrees_with_the_change_of_state():
    """With the new tension and the ice, the kernel has the same length of conductor."""
    line = {
        "conductor": "Drake",
        "span": 300.0,
        "stringing_tension": 28000.0,
        "ice_thickness": 0.02,
    }
    line |= {"ice_shape": "radial", "temperature": 15.0, "height_difference": 0.0}
    iced = gf.Scene.from_dict({"line": line, "numerics": {"elements": 40}})
    bare = iced.with_values({"ice.mass_per_length": 0.0, "span.horizontal_tension": 28000.0})
    lengths = []
    for scene in (bare, iced):
        hanging = gf.Model(scene).equilibrium()
        x = hanging.x
        chord = np.linalg.norm(np.diff(x, axis=0), axis=1).sum()
        weight = (scene.conductor.mass_per_length + scene.ice.mass_per_length) * 9.81
        c = hanging.horizontal_tension / weight
        mean = (
            0.5 * hanging.horizontal_tension * (1.0 + c / 300.0 * math.sinh(300.0 / c))
        )  # mean of T ds / dx
        lengths.append(chord - mean * 300.0 / scene.conductor.axial_stiffness)
    assert iced.span.horizontal_tension > 1.5 * 28000.0
    assert lengths[1] == pytest.approx(
        lengths[0], abs=1e-4
    )  # of 300 m; the ice stretches it by 0.2 m


def test_the_unstretched_length_of_a_stiff_conductor_is_the_catenarys():
    c = 28e3 / 16.0
    level = 2.0 * c * math.sinh(150.0 / c)
    assert unstretched_length(300.0, 16.0, 28e3, 1e30) == pytest.approx(level, rel=1e-14)
    inclined = math.hypot(level, 40.0)  # s^2 = v^2 + (2c sinh(l/2c))^2
    assert unstretched_length(300.0, 16.0, 28e3, 1e30, 40.0) == pytest.approx(inclined, rel=1e-12)


def test_ruling_span():
    assert ruling_span([300.0]) == pytest.approx(300.0)
    assert ruling_span([200.0, 400.0]) == pytest.approx(math.sqrt((8e6 + 64e6) / 600.0))


def elastic_catenary_tension(
    tension, span, weight, new_weight, axial_stiffness, temperature_change, expansion
):
    """Irvine (1981), eq. 2.22: chord of an elastic catenary with mass per unstretched length."""

    def chord(h, total, rest):
        return h * rest / axial_stiffness + 2.0 * h * rest / total * math.asinh(total / (2.0 * h))

    hanging = 2.0 * tension / weight * math.sinh(weight * span / (2.0 * tension))
    rest = brentq(
        lambda s: chord(tension, weight * hanging, s) - span, 0.9 * span, 1.5 * span, xtol=1e-12
    )
    rest *= 1.0 + expansion * temperature_change
    return brentq(
        lambda h: chord(h, new_weight * hanging, rest) - span,
        0.05 * tension,
        20.0 * tension,
        xtol=1e-9,
    )


def test_weight_per_hanging_length_makes_little_difference():
    rng, worst = np.random.default_rng(1), 0.0
    for _ in range(40):
        span, weight = rng.uniform(60.0, 600.0), 9.81 * rng.uniform(0.3, 2.0)
        state = {
            "span": span,
            "weight": weight,
            "new_weight": weight * rng.uniform(1.0, 2.5),
            "axial_stiffness": rng.uniform(8e6, 5e7),
            "temperature_change": rng.uniform(-50.0, 60.0),
            "expansion": 19e-6,
        }
        tension = weight * span * rng.uniform(1.5, 8.0)
        worst = max(
            worst,
            abs(
                changed_tension(tension, **state) / elastic_catenary_tension(tension, **state) - 1.0
            ),
        )
    assert 5e-4 < worst < 1.3e-3  # observed 1.07e-3; 1.22e-3 of 200
