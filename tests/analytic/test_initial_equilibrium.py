"""The initial equilibrium against the catenary: exact, as the weight is uniform along the cable."""

import numpy as np
import pytest
from scipy.optimize import brentq

from gallop_fmu.engine.model import Model
from gallop_fmu.scene.scene import Scene

HEIGHTS = (0.0, 40.0, -90.0)
SAG_ERROR = {0.0: 1e-8, 40.0: 1e-6, -90.0: 4e-6}
"""Observed 4e-9, 3.6e-7 and 1.6e-6: on a sloping span mid-span lies between nodes."""


@pytest.fixture(params=HEIGHTS, ids="height {}".format)
def height(request):
    return request.param


def solved(span, height, given):
    scene = Scene.from_dict(
        span | {"span": {"length": 300.0, "height_difference": height, **given}}
    )
    return scene, Model(scene).equilibrium()


def test_sag_from_horizontal_tension(span, exact_cable, height):
    scene, found = solved(span, height, {"horizontal_tension": 20000.0})
    exact = exact_cable(scene)
    assert found.horizontal_tension == pytest.approx(20000.0, rel=1e-11)
    assert found.sag == pytest.approx(exact.sag, rel=SAG_ERROR[height])
    assert found.length == pytest.approx(exact.arc, rel=2e-10)  # observed 4e-11


def test_horizontal_tension_from_sag(span, exact_cable, height):
    scene, found = solved(span, height, {"sag": 9.0})
    exact = exact_cable(scene)
    assert found.sag == pytest.approx(9.0, rel=1e-11)
    assert found.horizontal_tension == pytest.approx(
        exact.horizontal_tension, rel=SAG_ERROR[height]
    )


@pytest.mark.parametrize("rise", [0.0, 0.4])
@pytest.mark.parametrize("part", [0.3, 0.7, 1.0, 2.0, 5.0])
def test_a_deep_sag_has_the_tension_of_the_catenary(span, part, rise):
    deep = {"length": 300.0, "height_difference": 300.0 * rise, "sag": 300.0 * part}
    scene = Scene.from_dict(span | {"span": deep, "numerics": {"elements": 120}})
    found = Model(scene).equilibrium()

    def depth(c):  # below the chord at mid-span of a catenary of parameter c, over a rise
        lowest = 150.0 - c * np.arcsinh(150.0 * rise / (c * np.sinh(150.0 / c)))
        return 150.0 * rise - c * (np.cosh((150.0 - lowest) / c) - np.cosh(lowest / c))

    c = brentq(lambda c: depth(c) - deep["sag"], 20.0, 3000.0, rtol=1e-13)
    assert found.sag == pytest.approx(deep["sag"], rel=1e-8)
    assert found.horizontal_tension == pytest.approx(
        1.6 * 9.81 * c, rel=1e-4
    )  # observed 8e-5 at 5 L, 2e-7 at 1 L


def test_shape_is_the_catenary(span, exact_cable, height):
    scene, found = solved(span, height, {"horizontal_tension": 20000.0})
    _, _, exact = exact_cable(scene).solve(at=tuple(np.linspace(0.0, 1.0, len(found.x))))
    assert np.abs(found.x - exact).max() < 2e-7  # observed 4e-8 m


def test_support_forces_carry_the_weight(span, height):
    _, found = solved(span, height, {"horizontal_tension": 20000.0})
    left, right = found.support_force
    weight = 1.6 * 9.81 * found.length
    assert (left + right)[1] == pytest.approx(-weight, rel=5e-14)  # observed 7e-15
    assert left[0] == pytest.approx(20000.0, rel=1e-9)
    assert right[0] == pytest.approx(-20000.0, rel=1e-9)
    assert (left[2], right[2]) == (0.0, 0.0)
    if height == 0.0:
        assert left[1] == pytest.approx(-0.5 * weight, rel=1e-11)


def test_elastic_catenary_that_hangs_from_its_unstretched_length(span, exact_cable):
    """The textbook's cable, with uniform weight per unstretched length, differs by the stretch."""
    scene, found = solved(span, 0.0, {"horizontal_tension": 20000.0})
    ea, weight = 3e7, 1.6 * 9.81
    cable = exact_cable(scene)
    tension = np.hypot(20000.0, weight * (np.linspace(0.0, cable.arc, 2001) - cable.arc / 2))
    unstretched = np.trapezoid(1.0 / (1.0 + tension / ea), dx=cable.arc / 2000)
    w0 = weight * found.length / unstretched  # same total weight
    half = 0.5 * unstretched

    # Irvine (1981), elastic catenary of unstretched length: span and sag from the horizontal
    # tension
    def span_of(h):
        return 2 * (h * half / ea + h / w0 * np.arcsinh(w0 * half / h))

    h = brentq(lambda h: span_of(h) - 300.0, 1e4, 4e4, xtol=1e-9)
    sag = w0 * half**2 / (2 * ea) + h / w0 * (np.hypot(1.0, w0 * half / h) - 1.0)
    assert found.horizontal_tension == pytest.approx(h, rel=2e-6)  # observed 5e-7
    assert found.sag == pytest.approx(sag, rel=1e-6)  # observed 2e-7


def test_held_state_is_the_parabola_of_its_sag(span):
    scene = Scene.from_dict(
        span | {"span": {"length": 300.0, "sag": 9.0, "horizontal_tension": 19500.0}}
    )
    model = Model(scene)
    found = model.equilibrium()
    f = np.linspace(0.0, 1.0, model.nodes)
    np.testing.assert_allclose(
        found.x, np.column_stack([300.0 * f, -36.0 * f * (1.0 - f), 0.0 * f]), atol=1e-12
    )
    assert (found.sag, found.horizontal_tension) == (pytest.approx(9.0, rel=1e-14), 19500.0)
    assert np.abs(model.residual()).max() < 1e-10  # observed 4e-12 N
    # w L^2 / 8 = 176580 N m is 0.6 % more than sag times tension, 175500: the difference is
    # balanced at every node
    assert 0.0 < found.imbalance < 0.02 * 1.6 * 9.81 * 300.0 / (2 * model.elements)
