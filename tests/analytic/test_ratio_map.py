"""The frequency ratio over parameters, the change of state, design changes that avoid 2:1."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
import modal

SPRINGS = {"kind": "springs", "stiffness_x1": 5e6, "stiffness_x3": 1e6}


@pytest.fixture(scope="module")
def scene():
    return gf.load_scene("example3").with_values({"numerics.elements": 10})


def length_of(scene):
    """Unstretched, from the mesh: the stretch of each chord piece under its tension."""
    equilibrium = gf.Model(scene).equilibrium()
    x = equilibrium.x
    slope = np.gradient(x[:, 1], x[:, 0])
    stretch = (
        np.trapezoid(equilibrium.horizontal_tension * (1.0 + slope**2), x[:, 0])
        / scene.conductor.axial_stiffness
    )
    return equilibrium.length - stretch


@pytest.mark.parametrize("height", [0.0, 30.0])
@pytest.mark.parametrize(("warmer", "ice"), [(-30.0, None), (40.0, None), (0.0, 1.5)])
def test_the_unstretched_length_stays_but_for_expansion(scene, height, warmer, ice):
    level = scene.with_values({"span.sag": None, "span.height_difference": height})
    changed = modal.change_of_state(level, warmer, ice)
    expected = math.exp(18.9e-6 * warmer)
    assert length_of(changed) / length_of(level) == pytest.approx(
        expected, abs=3e-8
    )  # observed 1.1e-8
    assert changed.ice.mass_per_length == (level.ice.mass_per_length if ice is None else ice)


def test_the_tension_is_that_of_the_parabolas_change_of_state(scene):
    # L^2 w^2 / 24 (1/H1^2 - 1/H0^2) = alpha dT + (H1 - H0)/EA, the engineer's equation
    taut = scene.with_values({"span.sag": None, "span.horizontal_tension": 20e3})
    h = modal.change_of_state(taut, 25.0).span.horizontal_tension
    w, ea = 1.66 * 9.81, 25.53e6
    left = (125.88 * w) ** 2 / 24.0 * (1.0 / h**2 - 1.0 / 20e3**2)
    assert left == pytest.approx(18.9e-6 * 25.0 + (h - 20e3) / ea, rel=3e-4)  # observed 1.6e-4


def test_a_change_of_state_can_be_undone(scene):
    there = modal.change_of_state(scene, 30.0)
    assert modal.change_of_state(there, -30.0).span.horizontal_tension == pytest.approx(
        15000.0, rel=1e-9
    )
    assert there.span.sag is None


def test_a_scene_given_by_its_sag(scene):
    by_sag = scene.with_values({"span.horizontal_tension": None})
    assert modal.change_of_state(by_sag).span.horizontal_tension == pytest.approx(15223.0, rel=1e-3)
    assert length_of(modal.change_of_state(by_sag)) == pytest.approx(length_of(by_sag), rel=1e-6)


def test_adjacent_spans_change_in_the_same_way(scene):
    adjacent = {"kind": "adjacent_span", "adjacent_span": 120.0, "adjacent_tension": 10e3}
    adjacent |= {"insulator_length": 2.0, "insulator_weight": 500.0}
    changed = modal.change_of_state(scene.with_values({"supports.left": adjacent}), 20.0)
    assert changed.supports.left.adjacent_tension == pytest.approx(
        changed.span.horizontal_tension * 10e3 / 15e3
    )


@pytest.mark.parametrize("change", [{"temperature_change": -5000.0}, {"temperature_change": 1e6}])
def test_an_impossible_state_is_named(scene, change):
    with pytest.raises(gf.SceneError, match="no tension is possible for a temperature change"):
        modal.change_of_state(scene, **change)


@pytest.mark.parametrize(
    ("path", "values", "rising"),
    [
        ("span.horizontal_tension", [13e3, 15e3, 17e3], False),
        ("span.sag", [1.9, 2.1, 2.3], True),
        ("temperature_change", [-20.0, 0.0, 20.0], True),
        ("conductor.axial_stiffness", [2e7, 2.5e7, 3e7], True),
    ],
)
def test_the_map_goes_the_way_of_the_theory(scene, path, values, rising):
    data = modal.ratio_map(scene, path, values)
    assert np.all(np.diff(data.ratio.values) > 0.0) == rising
    assert data.detuning.values == pytest.approx(data.ratio.values / 2.0 - 1.0)
    assert data[path].attrs["units"] == (
        "K" if path == "temperature_change" else scene.unit_of(path)
    )
    for value, ratio in zip(values, data.ratio.values, strict=True):
        theory = modal.shallow_cable(_changed(scene, path, value)).ratio
        assert ratio == pytest.approx(theory, rel=8e-4)  # observed 5.2e-4
    assert list(data.problem.values) == ["", "", ""]


def _changed(scene, path, value):
    if path == "temperature_change":
        return modal.change_of_state(scene, value)
    other = {"span.sag": "span.horizontal_tension"}.get(path, "span.sag")
    return scene.with_values({path: value, other: None})


def test_springs_at_both_ends_change_at_once(scene):
    hung = scene.with_values(
        {"supports.left": SPRINGS, "supports.right": SPRINGS, "span.sag": None}
    )
    data = modal.ratio_map(hung, "supports.stiffness_x1", [1e5, 1e7])
    one = hung.with_values({"supports.left.stiffness_x1": 1e5, "supports.right.stiffness_x1": 1e5})
    assert data.ratio.values[0] == modal.frequency_ratio(one).ratio
    assert data.ratio.values[0] < data.ratio.values[1]


@pytest.mark.parametrize("path", ["span.horizontal_tension", "span.sag", "temperature_change"])
def test_the_ratio_is_two_at_a_crossing(scene, path):
    values = {
        "span.horizontal_tension": [10e3, 20e3],
        "span.sag": [1.5, 3.0],
        "temperature_change": [0.0, 40.0],
    }[path]
    (at,) = modal.crossings(scene, path, values)
    assert modal.ratio_map(scene, path, [at]).ratio.item() == pytest.approx(
        2.0, abs=2e-6
    )  # observed 2.2e-8


def test_no_crossing_is_an_empty_list(scene):
    assert modal.crossings(scene, "span.horizontal_tension", [16e3, 20e3]) == []


def test_a_point_without_a_ratio_has_a_reason(scene):
    data = modal.ratio_map(scene, "ice.first_moment_x2", [0.0, 0.012])
    assert np.isfinite(data.ratio.values[0])
    assert np.isnan(data.ratio.values[1])
    assert "equilibrium" in str(data.problem.values[1])


def test_no_ratio_and_no_crossing_where_modes_veer(scene):
    # an inclined span has no mirror image that would keep its first two vertical modes apart
    inclined = scene.with_values({"span.sag": None, "span.height_difference": 40.0})
    veering = inclined.with_values({"span.horizontal_tension": 13250.0})
    with pytest.raises(gf.SceneError, match="two modes cross or veer"):
        modal.frequency_ratio(veering)
    assert (
        modal.frequency_ratio(inclined.with_values({"span.horizontal_tension": 17e3})).ratio < 1.8
    )
    with pytest.raises(
        gf.SceneError, match=r"at span\.horizontal_tension = 13250 there is no frequency ratio"
    ):
        modal.crossings(inclined, "span.horizontal_tension", [12e3, 13.25e3, 15e3])


def test_design_changes_have_the_predicted_effect(scene):
    changes = modal.suggest_design_changes(scene)
    assert changes[0].path == "span.horizontal_tension"
    here = modal.frequency_ratio(scene.with_values({"span.sag": None})).detuning
    for change in changes:
        again = modal.ratio_map(scene, change.path, [change.after]).detuning.item()
        assert (change.detuning_before, change.detuning_after) == pytest.approx((here, again))
        assert abs(again) > abs(here)
        assert "away from 2:1" in change.sentence
        assert change.sensitivity * (change.after - change.before) < 0.0  # below 2:1, away is down


@pytest.mark.parametrize("path", ["span.width", "supports.left.stiffness_x1"])
def test_a_number_that_is_not_there_is_named(scene, path):
    with pytest.raises(gf.SceneError, match=path.replace(".", r"\.")):
        modal.ratio_map(scene, path, [1.0])


def test_no_values_are_refused(scene):
    with pytest.raises(gf.SceneError, match="at least one"):
        modal.ratio_map(scene, "span.sag", [])


def test_a_map_over_two_numbers_is_made_of_maps_over_one(scene):
    tensions, warmer = [12e3, 15e3, 18e3], [-20.0, 0.0, 30.0]
    data = modal.ratio_map(
        scene, "span.horizontal_tension", tensions, against=("temperature_change", warmer)
    )
    assert data.ratio.dims == ("span.horizontal_tension", "temperature_change")
    assert data.temperature_change.attrs["units"] == "K"
    alone = modal.ratio_map(scene, "span.horizontal_tension", tensions).ratio.values
    assert data.ratio.values[:, 1] == pytest.approx(alone, rel=1e-9)
    for row, tension in zip(data.ratio.values, tensions, strict=True):
        strung = scene.with_values({"span.sag": None, "span.horizontal_tension": tension})
        assert row == pytest.approx(
            modal.ratio_map(strung, "temperature_change", warmer).ratio.values, rel=1e-9
        )
    turned = modal.ratio_map(
        scene, "temperature_change", warmer, against=("span.horizontal_tension", tensions)
    )
    assert turned.ratio.values.T == pytest.approx(data.ratio.values, rel=1e-12)


@pytest.mark.parametrize("second", ["span.sag", "span.horizontal_tension"])
def test_no_map_over_numbers_that_determine_each_other(scene, second):
    with pytest.raises(gf.SceneError, match="each determines the other"):
        modal.ratio_map(scene, "span.horizontal_tension", [15e3], against=(second, [2.0]))
    with pytest.raises(gf.SceneError, match=r"values of ice\.mass_per_length: at least one"):
        modal.ratio_map(
            scene, "span.horizontal_tension", [15e3], against=("ice.mass_per_length", [])
        )
