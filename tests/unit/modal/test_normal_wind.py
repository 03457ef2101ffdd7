"""Analyses in wind from the other side, in oblique and in turbulent wind."""

import math

import pytest

import modal
from gallop_fmu import SceneError, load_scene
from modal.superposition.modal_model import ModalModel
from support.line_scenes import section

TURBULENCE = {"spectrum": "kaimal", "intensity": 0.1, "length_scale": 60.0}
DRAG_ONLY = {
    "kind": "polynomial",
    "valid_from_deg": -180,
    "valid_to_deg": 180,
    "outside": "hold",
    "lift": [0],
    "drag": [1],
    "moment": [0],
}


def superposition(scene):
    return ModalModel.of(scene, vertical=1, horizontal=1, torsional=1)


@pytest.mark.parametrize(
    "analysis", [modal.coupled, modal.screen, modal.two_mode_estimate, superposition]
)
def test_analyses_of_normal_wind_refuse_other_wind(analysis):
    scene = load_scene("example3")
    other_side = scene.with_values({"wind.speed": -5.5, "aerodynamics.outside": "hold"})
    with pytest.raises(SceneError, match=r"wind speed = -5\.5 m/s: the wind comes from the other"):
        analysis(other_side)
    if analysis is not superposition:
        turned = {"wind.direction_deg": 100.0, "aerodynamics.outside": "hold"}
        with pytest.raises(SceneError, match=r"wind\.direction_deg = 100 deg: the wind comes from"):
            analysis(scene.with_values(turned))
        turning = {"kind": "ramp", "initial": 0.0, "final": 30.0, "duration": 9.0}
        with pytest.raises(SceneError, match=r"wind\.direction_history is given, and .* steady"):
            analysis(scene.with_values({"wind.direction_history": turning}))
        return
    with pytest.raises(SceneError, match=r"wind\.direction_deg is given, and .* uniform wind"):
        analysis(scene.with_values({"wind.direction_deg": 20.0}))


def test_the_coupled_criterion_refuses_a_profile():
    profile = {"kind": "power", "exponent": 0.2, "attachment_height": 20.0}
    with pytest.raises(SceneError, match=r"wind\.profile is given, and the coupled"):
        modal.coupled(load_scene("example3").with_values({"wind.profile": profile}))


def test_mode_superposition_refuses_gusts():
    gusty = load_scene("example3").with_values({"wind.turbulence": TURBULENCE})
    with pytest.raises(SceneError, match=r"wind\.turbulence or wind\.table is given, and mode sup"):
        superposition(gusty)


def test_modes_in_turbulent_wind_are_those_in_the_mean_wind():
    steady = load_scene("example3")
    gusty = steady.with_values({"wind.turbulence": TURBULENCE})
    found = [modal.natural_modes(scene, 3, "mean") for scene in (steady, gusty)]
    assert [mode.frequency_hz for mode in found[0]] == [mode.frequency_hz for mode in found[1]]


def test_modes_in_wind_from_the_other_side():
    """With drag only, a span in wind from the other side is the mirror image of itself."""
    scene = load_scene("example3").with_values(
        {"aerodynamics": DRAG_ONLY, "ice.first_moment_x2": 0}
    )
    found = [
        modal.natural_modes(scene.with_values({"wind.speed": speed}), 3, "mean")
        for speed in (8.0, -8.0)
    ]
    for one, other in zip(*found, strict=True):
        assert other.frequency_hz == pytest.approx(one.frequency_hz, rel=1e-9)
        assert other.damping_ratio == pytest.approx(one.damping_ratio, rel=1e-7)


def test_criteria_of_a_line_in_wind_from_the_other_side():
    """The wind meets the ice at an angle turned by 180 deg; the missing criterion is said."""
    curve = {**DRAG_ONLY, "lift": [0, -2]}
    scene = section(
        15000.0,
        (125.0, 125.0),
        15.0,
        2.0e7,
        elements=6,
        aerodynamics=curve,
        wind={"speed": -5.0},
        ice={"attack_angle_deg": 170.0},
    )
    for found in modal.line_criteria(scene):
        assert math.degrees(found.attack_angle) == pytest.approx(-10.0)
        assert found.unstable == ["Den Hartog"]
        assert found.remark.startswith("no coupled criterion: wind speed = -5 m/s: the wind comes")
