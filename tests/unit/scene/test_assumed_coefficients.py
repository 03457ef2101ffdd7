"""The assumed curve over the full circle, and scenes that use it."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.scene.assumed_coefficients import (
    DRAG,
    LIFT,
    LIFT_THICKNESS,
    MOMENT_ARM,
    AssumedCoefficients,
)

COEFFICIENTS = ("lift", "drag", "moment")
RATIOS = (0.0, 0.05, 0.1, 0.5, 2.0)


@pytest.mark.parametrize("ratio", RATIOS)
def test_cubic_pieces_follow_the_equations(ratio):
    assumed = AssumedCoefficients(ice_thickness_ratio=ratio)
    curve, alpha = assumed.curve(), np.linspace(-7.0, 7.0, 4001)
    size = LIFT * (1.0 - np.exp(-ratio / LIFT_THICKNESS))
    lift = -size * np.sin(2.0 * alpha)
    drag = DRAG * (1.0 + ratio * np.sin(alpha) ** 2)
    # The moment of a force at a point towards the ice, at (x2, x3) = (sin a, -cos a) e t.
    x2, x3 = MOMENT_ARM * ratio * np.sin(alpha), -MOMENT_ARM * ratio * np.cos(alpha)
    moment = x2 * drag - x3 * lift
    for name, expected in zip(COEFFICIENTS, (lift, drag, moment), strict=True):
        # Observed: 7e-6, the moment at a ratio of 2; 2.6e-6 at 0.1.
        np.testing.assert_allclose(getattr(curve, name)(alpha), expected, rtol=0, atol=1e-5)
    # Observed: 1.1e-4.
    np.testing.assert_allclose(
        curve.lift_slope(alpha), -2.0 * size * np.cos(2.0 * alpha), rtol=0, atol=1.5e-4
    )


@pytest.mark.parametrize("ratio", RATIOS)
def test_symmetry_of_the_iced_section(ratio):
    curve = AssumedCoefficients(ice_thickness_ratio=ratio).curve()
    alpha = np.linspace(0.0, np.pi, 91)
    for name, sign in (("lift", -1.0), ("drag", 1.0), ("moment", -1.0)):
        values = getattr(curve, name)
        # Observed: 5e-16 each.
        np.testing.assert_allclose(values(-alpha), sign * values(alpha), rtol=0, atol=5e-15)
        assert abs(values(np.pi) - values(-np.pi)) < 1e-14
        if sign < 0.0:
            np.testing.assert_allclose(values(np.array([0.0, np.pi])), 0.0, atol=1e-14)
    assert np.min(curve.drag(alpha)) >= DRAG - 1e-5


def test_value_and_slope_have_no_jump_at_the_seam_and_between_pieces():
    curve = AssumedCoefficients(ice_thickness_ratio=0.3).curve()
    step = 1e-9
    for alpha in (*curve.breakpoint, 3.0 * np.pi):
        for values in (curve.lift, curve.drag, curve.moment, curve.lift_slope):
            # Observed: 9e-9, the step times the slope; a jump of 1e-3 would show.
            assert abs(values(alpha + step) - values(alpha - step)) < 1e-7


def test_without_ice_the_section_is_round():
    curve = AssumedCoefficients(ice_thickness_ratio=0.0).curve()
    alpha = np.linspace(-4.0, 4.0, 101)
    for name, expected in zip(COEFFICIENTS, (0.0, DRAG, 0.0), strict=True):
        np.testing.assert_array_equal(getattr(curve, name)(alpha), expected)


def test_galloping_needs_ice_of_a_fortieth_of_the_diameter():
    # 2 L (1 - exp(-s/s0)) = D.
    onset = -LIFT_THICKNESS * np.log(1.0 - 0.5 * DRAG / LIFT)
    assert onset == pytest.approx(0.0255, abs=1e-4)
    for ratio, is_unstable in ((0.98 * onset, False), (1.02 * onset, True)):
        curve = AssumedCoefficients(ice_thickness_ratio=ratio).curve()
        assert bool(curve.den_hartog(0.0) < 0.0) is is_unstable


def test_table_of_the_assumed_curve_is_the_same_curve():
    assumed = AssumedCoefficients(ice_thickness_ratio=0.2, reference_radius=0.02)
    table, alpha = assumed.explicit(), np.linspace(-4.0, 4.0, 1001)
    assert (table.beyond, table.reference_radius) == ("periodic", 0.02)
    for name in COEFFICIENTS:
        # Observed: 5.4e-5 at the extrema of the lift.
        np.testing.assert_allclose(
            getattr(table.curve(), name)(alpha),
            getattr(assumed.curve(), name)(alpha),
            rtol=0,
            atol=7e-5,
        )


def test_scene_and_result_say_that_the_curve_is_assumed():
    scene = gf.load_scene("example3").with_values(
        {"aerodynamics": {"kind": "assumed", "ice_thickness_ratio": 0.1}}
    )
    assert "ASSUMED" in scene.aerodynamics.label
    assert any("ASSUMED, not measured" in warning for warning in scene.warnings)
    result = gf.simulate(scene, stop_time=1.0)
    assert any("ASSUMED, not measured" in warning for warning in result.warnings)
    assert gf.Scene.from_dict(scene.model_dump(exclude_none=True)) == scene


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"ice_thickness_ratio": -0.1}, "ice_thickness_ratio = -0.1: must be at least 0"),
        ({"ice_thickness_ratio": 12.0}, "ice_thickness_ratio = 12.0: must be .* at most 2"),
        ({}, "ice_thickness_ratio: missing"),
        (
            {"ice_thickness_ratio": 0.1, "outside": "hold"},
            "outside: only aerodynamics.kind = 'polynomial' or",
        ),
    ],
)
def test_wrong_values_of_the_assumed_curve(changes, words):
    with pytest.raises(gf.SceneError, match=words):
        gf.load_scene("example3").with_values({"aerodynamics": {"kind": "assumed", **changes}})
