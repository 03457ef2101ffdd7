"""The packaged coefficient curves."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.scene.curve_catalogue import across_wind_table, find_curve, packaged_curves
from gallop_fmu.scene.packaged_coefficients import PackagedCoefficients


def with_curve(attack_angle_deg=180.0, **curve):
    return gf.load_scene("example3").with_values(
        {
            "aerodynamics": {"kind": "packaged", **curve},
            "ice.attack_angle_deg": attack_angle_deg,
        }
    )


@pytest.mark.parametrize("name", packaged_curves())
def test_every_packaged_curve_is_complete_and_used_in_scenes(name):
    entry = find_curve(name)
    assert entry.status in ("published", "reconstructed")
    for text in (entry.title, entry.source, entry.reynolds, entry.attack_angle, entry.validity):
        assert len(text) > 5
    curve = PackagedCoefficients(name=name)
    first, last = curve.range_deg
    scene = with_curve(0.5 * (first + last), name=name)
    assert scene.aerodynamics.curve().breakpoint[0] == pytest.approx(np.radians(first))
    warned = any("not measured" in warning for warning in scene.warnings)
    assert warned is (entry.status != "published")


@pytest.mark.parametrize("name", ["example2", "example3"])
def test_curves_of_packaged_scenes_are_those_of_the_scenes(name):
    scene = gf.load_scene(name)
    own, packaged = scene.aerodynamics.curve(), PackagedCoefficients(name=name).curve()
    np.testing.assert_array_equal(packaged.coefficient, own.coefficient)
    np.testing.assert_array_equal(packaged.breakpoint, own.breakpoint)
    assert "RECONSTRUCTION" in find_curve(name).source


def test_force_across_the_wind_is_the_published_polynomial():
    curve = PackagedCoefficients(name="square_prism_parkinson_smith").curve()
    x = np.linspace(-0.32, 0.32, 257)
    alpha, relative = np.arctan(-x), np.hypot(1.0, x)
    force = relative * (curve.lift(alpha) - curve.drag(alpha) * x)
    expected = 2.69 * x - 168.0 * x**3 + 6270.0 * x**5 - 59900.0 * x**7
    # Observed: 7.3e-4 at the extrema, where PCHIP is flat at a point of the table.
    np.testing.assert_allclose(force, expected, rtol=0, atol=8e-4)
    # Den Hartog at 0: -A1.
    assert curve.den_hartog(0.0) == pytest.approx(-2.69, abs=0.01)


def test_a_prism_of_another_force_has_that_force():
    table = across_wind_table((1.0,), 2.0, 10.0, 5.0)
    assert table["angle_deg"] == [-10.0, -5.0, 0.0, 5.0, 10.0]
    tangent = np.tan(np.radians(5.0))
    assert table["lift"][3] == pytest.approx(-np.cos(np.radians(5.0)) * tangent - 2.0 * tangent)


def test_rule_outside_the_range_and_reference_radius_can_be_given():
    name = "square_prism_parkinson_smith"
    assert PackagedCoefficients(name=name).beyond == "error"
    curve = PackagedCoefficients(name=name, outside="hold", reference_radius=0.03)
    assert (curve.beyond, curve.explicit().reference_radius) == ("hold", 0.03)
    assert curve.curve().lift(1.0) == curve.curve().lift(np.radians(18.0))


def test_an_unknown_name_is_refused_with_the_closest():
    with pytest.raises(gf.SceneError, match=r"aerodynamics.name: 'squar' is not .*closest: square"):
        with_curve(name="squar")


def test_the_same_motion_as_with_the_numbers():
    given = gf.load_scene("example3")
    named = with_curve(name="example3")
    a, b = (gf.simulate(scene, stop_time=5.0).dataset.u2 for scene in (given, named))
    np.testing.assert_array_equal(a, b)
