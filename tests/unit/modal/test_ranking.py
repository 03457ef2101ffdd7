"""Ranked measures of one span: predictions, screenings and simulations stand side by side."""

import math

import pytest
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from modal.cli.main import app
from modal.cli.measures_command import _change
from modal.study import ranking
from modal.study.span_measures import line_of_span, measures_of_span


@pytest.fixture(scope="module")
def scene():
    values = {"numerics.elements": 6, "wind.speed": 4.75, "span.sag": None}
    return gf.load_scene("example3").with_values(values)


def test_a_line_of_one_span_has_the_modes_of_the_span(scene):
    springs = {"kind": "springs", "stiffness_x1": 2e5, "stiffness_x3": 1e5}
    for supports in ({}, {"left": springs, "right": springs}):
        span = scene.with_values({"supports": supports})
        frequencies = [
            [mode.frequency_hz for mode in modal.natural_modes(one, 6)]
            for one in (span, line_of_span(span))
        ]
        assert frequencies[1] == pytest.approx(frequencies[0], rel=1e-6)  # observed 1e-9
    with pytest.raises(gf.SceneError, match="loads or shedding"):
        line_of_span(scene.with_values({"loads": [{"evenly_spaced": 2, "force": [0.0, 1.0, 0.0]}]}))


def test_measures_of_a_span(scene):
    found = measures_of_span(scene, 0.67)
    assert [one.reason for one in found] == [""] * 9
    tension = {one.name: modal_tension(one.scene) for one in found[:6]}
    assert tension["Raise the tension by 10%"] == pytest.approx(16500.0)
    assert tension["Lower the tension by 20%"] == pytest.approx(12000.0)
    assert found[4].scene.damping.translation.low_ratio == pytest.approx(0.024)
    assert found[5].scene.ice.mass_per_length == pytest.approx(0.166)
    assert 15500.0 < modal_tension(found[5].scene) < 16500.0
    assert found[6].scene.span.length == pytest.approx(62.94)
    assert [device.kind for device in found[8].scene.devices] == ["damper"]
    assert "no span gallops" in measures_of_span(scene, math.nan)[8].reason
    ends = {"kind": "adjacent_span", "adjacent_span": 125.0, "adjacent_tension": 15000.0}
    ends |= {"insulator_length": 2.0, "insulator_weight": 490.0}
    (last,) = measures_of_span(scene.with_values({"supports.left": ends}), 0.67)[7:]
    assert "adjacent_span" in last.reason


def modal_tension(scene):
    return gf.Model(scene).equilibrium().horizontal_tension


def test_predicted_and_verified_values_stand_side_by_side(scene, monkeypatch, tmp_path):
    every = measures_of_span

    def few(span, frequency):
        found = every(span, frequency)
        return [found[2], found[5], found[8]]  # lower tension, weights, a damper

    monkeypatch.setattr(ranking, "measures_of_span", few)
    found = modal.rank_measures(scene, 5.05, stop_time=10.0)
    by_name = {row.measure.name.split()[0]: row for row in found.rows}
    weights, lower, damper = by_name["Spread"], by_name["Lower"], by_name["Hang"]
    # 10 % of mass and 10 % of tension: linear predictions; observed 1e-3 and 3e-3
    for row in (weights, lower):
        assert row.verified_by == "screening"
        assert row.predicted.onset == pytest.approx(row.after.onset, rel=0.01)
        assert row.after.onset != pytest.approx(row.before.onset, rel=0.01)
    assert weights.after.largest < 1e-9  # galloping begins above the scene's wind
    assert weights.sag > gf.Model(scene).equilibrium().sag
    assert damper.verified_by == "simulation"
    assert damper.after.onset > 1.03 * damper.before.onset
    assert damper.before.onset == pytest.approx(weights.before.onset, rel=1e-3)
    data = found.dataset
    assert data.onset_after.attrs["units"] == "m/s"
    assert found.rows == (weights, lower, damper)  # no galloping, motion, motion that grows
    assert damper.after.is_at_least
    for name in ("a.nc", "a.csv"):
        assert found.save(tmp_path / name).stat().st_size
    assert "galloping from" in repr(found)
    monkeypatch.setattr(ranking, "rank_measures", lambda *_, **__: found)
    done = CliRunner().invoke(app, ["measures", "example3", "-o", str(tmp_path / "b.csv")])
    assert done.exit_code == 0, done.output
    assert "Spread" in done.stdout
    assert _change("-", "-") == "-"
    assert _change("-", "4.1") == "- -> 4.1"
    done = CliRunner().invoke(app, ["measures", "example3", "--json"])
    assert '"predicted"' in done.stdout
