"""Coefficient curves: polynomials and tables as one piecewise cubic."""

import numpy as np
import pytest

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.polynomial_coefficients import PolynomialCoefficients
from gallop_fmu.scene.table_coefficients import TableCoefficients

COEFFICIENTS = ("lift", "drag", "moment")


def table(count=13, **changes):
    angle = np.linspace(-180.0, 180.0, count)
    alpha = np.radians(angle)
    columns = {
        "angle_deg": angle.tolist(),
        "lift": (np.sin(2 * alpha) + 0.3 * np.cos(alpha)).tolist(),
        "drag": (1.5 - 0.5 * np.cos(2 * alpha)).tolist(),
        "moment": (0.2 * np.sin(alpha)).tolist(),
    }
    for name in COEFFICIENTS:  # closed to the last bit
        columns[name][-1] = columns[name][0]
    return TableCoefficients(**{**columns, **changes})


@pytest.mark.parametrize("name", ["example2", "example3"])
def test_cubic_polynomial_is_reproduced(name):
    polynomial = load_scene(name).aerodynamics
    curve = polynomial.curve()
    alpha = np.linspace(
        np.radians(polynomial.valid_from_deg), np.radians(polynomial.valid_to_deg), 1001
    )
    x = alpha - np.radians(polynomial.centre_deg)
    for coefficient in COEFFICIENTS:
        expected = np.polynomial.polynomial.polyval(x, getattr(polynomial, coefficient))
        # Observed: 1.2e-14 for the lift of example 3, whose terms about the start of the range
        # reach 65; else 5.5e-15.
        np.testing.assert_allclose(getattr(curve, coefficient)(alpha), expected, rtol=0, atol=2e-14)
    slope = np.polynomial.polynomial.polyval(x, np.polynomial.polynomial.polyder(polynomial.lift))
    # Observed: 1.1e-14.
    np.testing.assert_allclose(curve.lift_slope(alpha), slope, rtol=0, atol=2e-14)


def test_den_hartog_of_example3_at_180_degrees():
    # dCL/dalpha + CD = -4.5 + 1. Observed: 3.6e-15 off.
    assert load_scene("example3").aerodynamics.curve().den_hartog(np.pi) == pytest.approx(
        -3.5, abs=1e-14
    )


@pytest.mark.parametrize("outside", ["error", "hold", "periodic"])
def test_table_curve_passes_through_every_point(outside):
    measured = table(outside=outside)
    curve = measured.curve()
    assert curve.coefficient.shape == (12, 3, 4)
    assert curve.breakpoint.shape == (13,)
    for coefficient in COEFFICIENTS:
        # Observed: 1.7e-16.
        points = getattr(curve, coefficient)(np.radians(measured.angle_deg))
        np.testing.assert_allclose(points, getattr(measured, coefficient), rtol=0, atol=1e-15)


def test_table_curve_does_not_overshoot():
    step = TableCoefficients(
        angle_deg=[0, 10, 20, 30], lift=[0, 0, 1, 1], drag=[1] * 4, moment=[0] * 4
    )
    lift = step.curve().lift(np.radians(np.linspace(0, 30, 301)))
    # Observed: 0 and 1 exactly.
    assert lift.min() >= 0.0
    assert lift.max() <= 1.0 + 1e-15


def test_two_points_make_a_straight_line():
    curve = TableCoefficients(angle_deg=[0, 90], lift=[0, 1], drag=[1, 3], moment=[0, 0]).curve()
    assert curve.drag(np.radians(45.0)) == pytest.approx(2.0, abs=1e-15)


def test_periodic_curve_has_neither_jump_nor_kink_at_the_seam():
    curve = table(outside="periodic").curve()
    before, after = np.radians(180.0) - 1e-9, np.radians(-180.0) + 1e-9
    # Observed: 3.3e-9, which is 2e-9 rad times the slope, and 3e-10; without wrapping the slopes
    # differ by 0.02.
    assert curve.lift(before) == pytest.approx(curve.lift(after), abs=1e-8)
    assert curve.lift_slope(before) == pytest.approx(curve.lift_slope(after), abs=1e-7)
    assert abs(curve.lift_slope(after)) > 0.5


def test_periodic_curve_does_not_depend_on_where_the_turn_starts():
    turned = np.roll(np.arange(12), -5)
    here = table(outside="periodic")
    there = TableCoefficients(
        angle_deg=[here.angle_deg[0] + 150.0 + 30.0 * k for k in range(13)],
        outside="periodic",
        **{name: [getattr(here, name)[k] for k in (*turned, turned[0])] for name in COEFFICIENTS},
    )
    alpha = np.radians(np.linspace(-720.0, 720.0, 997))
    for coefficient in COEFFICIENTS:
        # Observed: 9e-16.
        a, b = getattr(here.curve(), coefficient)(alpha), getattr(there.curve(), coefficient)(alpha)
        np.testing.assert_allclose(a, b, rtol=0, atol=5e-15)


def test_full_turns_do_not_matter_and_shapes_are_kept():
    curve = load_scene("example3").aerodynamics.curve()
    alpha = np.radians([[170.0, 180.0, 200.0], [-170.0, 540.0, -520.0]])
    # Observed: 2e-16 against the angle inside the range.
    inside = np.radians([[170.0, 180.0, 200.0], [190.0, 180.0, 200.0]])
    np.testing.assert_allclose(curve.drag(alpha), curve.drag(inside), rtol=0, atol=1e-15)
    assert curve.den_hartog(alpha).shape == (2, 3)
    assert curve.lift(3.0).shape == ()


def test_outside_the_range():
    polynomial = load_scene("example2").aerodynamics
    with pytest.raises(
        SceneError, match=r"attack angle 85 deg is outside .* valid from -60 to 80 deg"
    ):
        polynomial.curve().lift(np.radians([10.0, 85.0]))
    with pytest.raises(SceneError, match="attack angle nan deg"):
        polynomial.curve().lift(np.nan)
    constant = polynomial.model_copy(update={"outside": "hold"}).curve()
    assert constant.drag(np.radians(85.0)) == constant.drag(np.radians(80.0))
    assert constant.lift_slope(np.radians(85.0)) == 0.0
    assert constant.lift_slope(np.radians(79.0)) != 0.0


def test_periodic_polynomial_must_close():
    ends = {
        "valid_from_deg": -180,
        "valid_to_deg": 180,
        "outside": "periodic",
        "drag": [1.0],
        "moment": [0.0],
    }
    PolynomialCoefficients(**ends, lift=[0.5])
    with pytest.raises(ValueError, match="equal end values; lift"):
        PolynomialCoefficients(**ends, lift=[0.5, 0.1])


def every_ten_degrees(**changes):
    """A table over 0, 10, ... 360 deg, whose row of 360 deg repeats that of 0 deg."""
    return table(count=37, angle_deg=[10.0 * k for k in range(37)], **changes)


def test_a_turn_that_ends_one_step_before_it_closes_is_the_closed_one():
    closed = every_ten_degrees()
    short = TableCoefficients(
        **{name: getattr(closed, name)[:-1] for name in ("angle_deg", *COEFFICIENTS)}
    )
    assert (short.beyond, short.range_deg, len(short.angle_deg)) == ("periodic", (0.0, 360.0), 36)
    np.testing.assert_array_equal(short.curve().coefficient, closed.curve().coefficient)
    np.testing.assert_array_equal(short.curve().breakpoint, closed.curve().breakpoint)
    assert short.curve().lift(np.radians(355.0)) == closed.curve().lift(np.radians(-5.0))
    for outside in ("error", "hold"):
        assert TableCoefficients(**{**short.model_dump(), "outside": outside}).range_deg == (
            0.0,
            350.0,
        )


@pytest.mark.parametrize(
    ("angles", "beyond"),
    [
        (range(-170, 171, 20), "periodic"),
        (range(-180, 181, 10), "periodic"),
        ([0, 5, *range(10, 351, 10)], "periodic"),  # finer where it was measured more closely
        (range(0, 341, 10), "error"),  # two steps are missing
        (range(-90, 91, 10), "error"),
        ([0, 120, 240], "error"),  # too few to be a turn
    ],
)
def test_definition_of_a_full_turn(angles, beyond):
    count = len(angles)
    flat = TableCoefficients(
        angle_deg=list(angles), lift=[0] * count, drag=[1] * count, moment=[0] * count
    )
    assert flat.beyond == beyond


def test_ends_of_a_turn_that_differ_by_noise_are_averaged_with_a_warning():
    closed = every_ten_degrees()
    ends = (closed.lift[0] + 0.01, *closed.lift[1:-1], closed.lift[0] - 0.01)
    noisy = every_ten_degrees(lift=ends)
    assert noisy.curve().lift(0.0) == pytest.approx(closed.lift[0], abs=1e-15)
    np.testing.assert_allclose(noisy.curve().coefficient, closed.curve().coefficient, atol=1e-12)
    assert noisy.warnings() == [
        "aerodynamics.lift is -0.29 at 0 deg and -0.31 at 360 deg, the same angle: the mean of both"
        " is used"
    ]
    assert closed.warnings() == []
    assert (
        every_ten_degrees(lift=(0.0, *closed.lift[1:-1], -2.4e-16)).warnings() == []
    )  # sin(pi) in doubles
    assert every_ten_degrees(lift=ends, outside="hold").curve().lift(0.0) == ends[0]


def test_the_seam_of_a_plain_table_from_minus_180_has_no_one_sided_slope():
    curve = table(count=37).curve()
    step = 1e-6
    assert curve.lift_slope(-np.pi) == pytest.approx(curve.lift_slope(np.pi), abs=1e-9)
    central = (curve.lift(np.pi + step) - curve.lift(np.pi - step)) / (2.0 * step)
    assert curve.lift_slope(np.pi) == pytest.approx(central, abs=1e-5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"aerodynamics.drag": [1.0, 0.0, -1.0]},
            "aerodynamics.drag is -0.95 at 260 deg; drag acts along",
        ),
        (
            {"aerodynamics.lift": [0.0, -4.5, 0.0, 10.0]},
            "aerodynamics.lift reaches 20.9 at 260 deg; coefficients are",
        ),
        ({}, None),
    ],
)
def test_polynomials_that_no_conductor_has_are_warned_of(changes, words):
    found = load_scene("example3").with_values(changes).warnings
    assert (found == ()) if words is None else any(words in warning for warning in found)
