"""The report on a line: well-formed, complete, in words; the numbers are those of the run."""

import json
import math
import re
from types import SimpleNamespace as Made

import numpy as np
import pytest
from typer.testing import CliRunner

import modal
from gallop_fmu import SceneError, simulate
from gallop_fmu.line_plots import line_histories, line_paths, line_shape, tower_points
from modal.cli.main import app
from modal.report import line_page
from modal.report.findings import Missing
from modal.report.line_animation import MAX_ERROR, line_animation
from modal.report.line_findings import LineFindings
from modal.report.line_verdict import lowest_by_family, verdict
from tests.support.line_scenes import zebra

PHASES = [{"name": "a"}, {"name": "b", "offset": [4.0, 0.5]}]


@pytest.fixture(scope="module")
def scene():
    """Three spans, two strings, two phases, without wind; the seed starts the motion."""
    return zebra(
        3,
        elements=6,
        phases=PHASES,
        initial={"seed_vertical": 0.02, "seed_horizontal": 0.02},
        run={"stop_time": 4.0},
    ).with_values({"title": "<b>line</b>", "numerics.time_step": 0.02})


@pytest.fixture(scope="module")
def written(scene, tmp_path_factory):
    """Page of this line from the command."""
    folder = tmp_path_factory.mktemp("report")
    scene.save(folder / "line.toml")
    made = CliRunner().invoke(
        app, ["report", str(folder / "line.toml"), "-o", str(folder / "line.html")]
    )
    assert made.exit_code == 0, made.output
    return (folder / "line.html").read_text()


@pytest.fixture(scope="module")
def result(scene):
    return simulate(scene, record_nodes="all")


def test_has_its_parts_in_order(written):
    names = ("verdict", "pictures", "motion", "modes", "critical", "scene")
    places = [written.index(f'<section id="{name}">') for name in names]
    assert places == sorted(places)
    assert "Not computed for lines: all motions" in written
    assert "The screening is missing: The scene has no wind" in written
    assert "Critical winds: not computed." in written  # no curve
    assert "&lt;b&gt;line" in written
    assert "<b>line" not in written


def test_tables_have_the_numbers_of_the_run(written, result):
    string = result.strings.iloc[0]
    assert f'<td role="cell" data-label="pull at rest [kN]">{string.pull_at_rest / 1e3:.2f}<' in (
        written
    )
    tower = result.towers.iloc[0]
    assert f">{tower.force_x1_min / 1e3:.2f} to {tower.force_x1_max / 1e3:.2f}<" in written
    assert f">{result.clearances.smallest[0]:.2f}<" in written


def test_amplitudes_of_strings_are_half_the_range_at_the_end(result):
    start, stop = result.window()
    lean = result.dataset.string_lean_across.sel(tower=2, line_phase=2, time=slice(start, stop))
    row = result.strings.set_index(["tower", "phase"]).loc[(2, 2)]
    assert row.lean_across_amplitude == pytest.approx(0.5 * float(np.ptp(lean.values)), rel=1e-12)


def test_tension_is_the_largest_of_all_nodes(result):
    data = result.dataset
    own = ((data.span == 2) & (data.phase == 1)).values
    row = result.spans.set_index(["span", "phase"]).loc[(2, 1)]
    assert row.largest_tension == float(data.tension.values[:, own].max())


def test_strings_are_drawn_from_tower_to_clamp(result):
    """At rest, each is as long as in the scene (0.1 mm shorter or longer by elasticity)."""
    for tower in result.map.towers:
        if not tower.has_string:
            continue
        node = result.map.node_of_junction[tower.junctions[0]]
        at = result.dataset.sel(node=node)
        clamp = np.array([at.x1, at.x2, at.x3], dtype=float)
        (point,) = tower_points(result, tower)
        assert math.dist(point, clamp) == pytest.approx(2.1, abs=1e-3)


def test_figures_have_a_panel_for_each_span(result):
    assert len(line_shape(result).axes) == 2
    assert len(line_histories(result, phase=2).axes) == 3 + 2
    assert len(line_paths(result).axes) == 3
    with pytest.raises(SceneError, match="phase"):
        line_paths(result, phase=3)


def test_verdict_names_what_is_missing(scene):
    gone = Missing("no equilibrium.")
    found = LineFindings(scene, gone, gone, gone, gone, gone, gone, {})
    sentences = list(verdict(found))
    assert sentences[0] == "The simulation is missing: no equilibrium."
    assert not found.completed
    assert "Simulation: not computed." in line_page.line_page(found)


def test_the_lowest_critical_wind_counts_in_each_family():
    onsets = [
        Made(mode=Made(family=family), wind_speed=speed)
        for family, speed in (("vertical", None), ("vertical", 3.0), ("vertical", 2.0), ("a", None))
    ]
    found = lowest_by_family(onsets)
    assert {name: onset.wind_speed for name, onset in found.items()} == {"vertical": 2.0, "a": None}


def test_python_writes_the_same_page(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(line_page, "_pictures", lambda result: [])
    monkeypatch.setattr(line_page, "_modes_figure", lambda findings, modes: None)
    path = modal.write_report(scene, tmp_path / "page.html", stop_time=0.1)
    assert "Galloping report of a line" in path.read_text()


def test_the_animation_is_the_recorded_motion(result, written):
    """Shapes times amplitudes give the recorded places of all phases; strings end at clamps."""
    found = line_animation(result, 2)
    records = np.searchsorted(result.dataset.time.values, found.time - 1e-9)
    for phase in (1, 2):
        for span in (1, 2, 3):
            first, last = found.conductors[3 * (phase - 1) + span - 1]
            chain = result.map.chain(span, phase)
            own = result.dataset.sel(node=slice(*(chain.first_node + np.array([0, 12]))))
            own = own.isel(time=records)
            for k, (rest, move) in enumerate((("x2", "u2"), ("x3", "u3"))):
                expected = own[rest].values + own[move].values
                shown = found.moved[:, first : last + 1, k]
                assert np.abs(shown - expected).max() <= MAX_ERROR
    assert len(found.shapes) < 20
    for point, clamp in found.strings:
        assert np.linalg.norm(found.rest[clamp] - point) == pytest.approx(2.1, abs=0.01)
    assert len(found.strings) == 4
    frames = json.loads(re.search(r'id="frames">(.*?)</script>', written)[1])
    assert frames["conductors"] == [list(ends) for ends in found.conductors]
    assert np.shape(frames["amplitude"]) == (len(frames["time"]), len(frames["shapes"]))
