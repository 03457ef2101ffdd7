"""Points of the strung catenaries, against the catenary itself."""

import math

import pytest

from gallop_fmu.engine.strung_state import clamp_of_end_string, lowest_point, point_at_fraction
from gallop_fmu.scene.sag_tension import unstretched_length

SPANS = [(300.0, 0.0, 2000.0), (300.0, 60.0, 900.0), (120.0, -70.0, 400.0)]


def height(x, span, rise, c):
    """The catenary through (0, 0) and (span, rise), its lowest point by bisection of the rise."""
    low, high = -10.0 * c, 10.0 * c
    for _ in range(200):
        a = 0.5 * (low + high)
        end = c * (math.cosh((span - a) / c) - math.cosh(a / c))
        low, high = (a, high) if end > rise else (low, a)
    return c * (math.cosh((x - a) / c) - math.cosh(a / c))


@pytest.mark.parametrize(("span", "rise", "c"), SPANS)
def test_points_lie_on_the_catenary(span, rise, c):
    for fraction in (0.0, 0.2, 0.5, 0.9, 1.0):
        x, y = point_at_fraction(span, rise, c, fraction)
        assert y == pytest.approx(height(x, span, rise, c), abs=1e-9)  # 3e-10 seen
    assert point_at_fraction(span, rise, c, 1.0) == pytest.approx((span, rise), abs=1e-10)


@pytest.mark.parametrize(("span", "rise", "c"), SPANS)
def test_fractions_are_those_of_the_length(span, rise, c):
    whole = unstretched_length(span, 1.0, c, 1e300, rise)
    for fraction in (0.2, 0.5, 0.9):
        x, y = point_at_fraction(span, rise, c, fraction)
        part = unstretched_length(x, 1.0, c, 1e300, y)
        assert part == pytest.approx(fraction * whole, rel=1e-12)


@pytest.mark.parametrize("weight", [0.0, 60.0])
@pytest.mark.parametrize(("span", "rise", "c"), SPANS)
def test_an_end_string_points_along_its_pull(span, rise, c, weight):
    """The slope of the conductor at the clamp, by differences, and half of the string's weight."""
    x, y = clamp_of_end_string(span, rise, c, 3.0, weight)
    assert math.hypot(x, y) == pytest.approx(3.0, rel=1e-14)
    step = 1e-4
    slope = height(step, span - x, rise - y, c) / step
    assert -y / x == pytest.approx(0.5 * weight / c - slope, abs=1e-6)  # 2e-7 seen


def test_a_steep_end_string_leads_up_to_its_clamp():
    x, y = clamp_of_end_string(120.0, 60.0, 2000.0, 3.0, 10.0)
    assert x > 0.0
    assert y > 1.0


def test_the_lowest_point_of_a_level_span_is_its_middle():
    assert lowest_point(300.0, 0.0, 2000.0) == 150.0
    assert lowest_point(300.0, 60.0, 900.0) < 0.0  # the span rises throughout
