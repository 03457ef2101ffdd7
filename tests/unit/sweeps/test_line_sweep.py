"""Sweeps of lines: rows of spans and towers, the same numbers in every file, and refusals."""

import json

import numpy as np
import pandas as pd
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.sweeps.line_rows import LINE_COLUMNS
from gallop_fmu.sweeps.places import Place, flattened, placed, stacked
from gallop_fmu.sweeps.results_file import read_results, rows_of
from support.sections import POST, section
from support.sweeps import same

PUSH = {"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 0.5, "fall_start": 1.0, "fall": 0.5}
PHASES = [{"name": "a", "offset": [0.0, -4.0]}, {"name": "b", "offset": [1.0, 4.0]}]
COARSE = {"elements": 4, "time_step": 0.02}
OVER = {"section.horizontal_tension": [25e3, -1.0], "section.spans.1.length": [350.0, 330.0]}


def pushed(lengths=(300.0, 350.0), phase=1, **tables):
    """A coarse line whose second span is pushed."""
    load = {"span": 2, "position": 0.4, "force": [0.0, 300.0, 900.0], "law": PUSH, "phase": phase}
    return section(lengths, numerics=COARSE, loads=[load], **tables)


@pytest.fixture(scope="module")
def runs():
    return gf.sweep(pushed(), OVER, stop_time=2.0, window=0.8)


@pytest.fixture(scope="module")
def phases():
    """Two phases of which the first is pushed towards the second."""
    return pushed(phases=PHASES)


def test_rows_equal_single_runs(runs):
    data = runs.dataset
    assert data.span_u2_amplitude.dims == ("run", "span")
    assert data.span.values.tolist() == [1, 2]
    assert data.tower.values.tolist() == [0, 1, 2]
    changed = {"section.horizontal_tension": 25e3, "section.spans.1.length": 330.0}
    result = gf.simulate(pushed().with_values(changed), 2.0)
    row = data.isel(run=1)
    for span in (1, 2):
        found, steady = row.sel(span=span), result.steady(0.8, span)
        for name in ("u2", "u3", "theta"):
            amplitude, mean, frequency, *_ = steady[name]
            assert found[f"span_{name}_amplitude"] == amplitude
            assert found[f"span_{name}_mean"] == mean
            np.testing.assert_equal(found[f"span_{name}_frequency_hz"].item(), frequency)
        assert found.span_motion == str(result.motion_of(span, window=0.8))
    for _, held in result.towers.iterrows():
        found = row.sel(tower=held.tower)
        for axis in ("x1", "x2", "x3"):
            assert found[f"tower_force_{axis}_lowest"] == held[f"force_{axis}_min"]
            assert found[f"tower_force_{axis}_highest"] == held[f"force_{axis}_max"]
    string = result.strings.iloc[0]
    assert row.tower_lean_across_highest.sel(tower=1) == string.lean_across_max > 0.003
    assert row.tower_pull_lowest.sel(tower=1) == string.pull_min
    assert np.isnan(row.tower_pull_lowest.sel(tower=[0, 2])).all()
    assert row.motion == str(result.judged(0.8))
    assert row.lowest_tension == result.report.lowest_tension
    assert data.span_sag.values[1] == pytest.approx(result.spans.sag.values, rel=1e-12)
    assert "smallest_clearance" not in data


def test_columns_have_units(runs):
    for name, (unit, meaning) in LINE_COLUMNS.items():
        if name in runs.dataset:
            about = runs.dataset[name].attrs
            assert about == {"long_name": meaning, **({"units": unit} if unit else {})}
    assert runs.dataset["section.spans.1.length"].attrs["units"] == "m"
    assert runs.dataset.tower_force_x3_highest.attrs["units"] == "N"


def test_a_value_that_is_not_allowed_is_a_row_with_its_message(runs):
    assert runs.dataset.outcome.values.tolist() == ["completed"] * 2 + ["invalid_scene"] * 2
    assert "section.horizontal_tension = -1.0: must be" in runs.dataset.message.values[2]
    assert np.isnan(runs.failed.span_u2_amplitude).all()
    assert (runs.failed.span_motion == "").all()


def test_grid_has_the_spans_beside_the_parameters(runs):
    amplitude = runs.grid().span_u3_amplitude
    assert amplitude.dims == (*OVER, "span")
    assert amplitude.sel({"section.horizontal_tension": 25e3}).values.tolist() == (
        runs.dataset.span_u3_amplitude.values[:2].tolist()
    )
    assert np.isnan(amplitude.sel({"section.horizontal_tension": -1.0})).all()
    assert "run" not in runs.grid().dims


@pytest.mark.parametrize("suffix", [".nc", ".parquet"])
def test_files_have_the_same_numbers_and_are_resumed(runs, tmp_path, suffix):
    path = tmp_path / f"runs{suffix}"
    written = gf.sweep(pushed(), OVER, stop_time=2.0, window=0.8, out=path)
    assert same(written, runs)
    assert read_results(path).identical(written.dataset)
    assert gf.read_runs(path).dataset.identical(written.dataset)
    journal = tmp_path / f"runs{suffix}.journal"
    lines = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(b"".join(line for line in lines if b'"run": 1,' not in line))
    again = gf.sweep(pushed(), OVER, stop_time=2.0, window=0.8, out=path)
    assert same(again, runs)
    computed = again.dataset.seconds.values != written.dataset.seconds.values
    assert computed.tolist() == [False, True, False, False]


def test_parquet_has_a_column_for_each_span(runs, tmp_path):
    path = tmp_path / "runs.parquet"
    gf.sweep(pushed(), OVER, stop_time=2.0, window=0.8, out=path)
    frame = pd.read_parquet(path)
    assert frame.span_2_u2_amplitude[0] == runs.dataset.span_u2_amplitude.values[0, 1]
    assert frame.tower_1_lean_across_highest[0] > 0.003
    assert "span_u2_amplitude" not in frame


def test_phases_are_a_dimension_and_have_a_clearance(phases):
    runs = gf.sweep(phases, {"loads.0.force.2": [0.0, 900.0]}, stop_time=3.0)
    data = runs.dataset
    assert data.span_u3_amplitude.dims == ("run", "span", "phase")
    assert data.tower_force_x2_lowest.dims == ("run", "tower", "phase")
    row = rows_of(data)[1]
    amplitudes = [row[f"span_2_phase_{phase}_u3_amplitude"] for phase in (1, 2)]
    assert data.span_u3_amplitude.sel(span=2).values[1].tolist() == amplitudes
    assert amplitudes[0] > 10.0 * amplitudes[1]
    at_rest = np.hypot(8.0, 1.0)
    every = gf.simulate(
        phases.with_values({"loads.0.force.2": 900.0}), 3.0, record_nodes="all"
    ).clearances.smallest.min()
    assert every <= data.smallest_clearance[1] < data.smallest_clearance[0] < at_rest + 1e-6


def test_a_table_of_cases_may_have_lines_and_spans(tmp_path):
    """Lines of one, two and three spans; missing spans are NaN."""
    push = {"position": 0.5, "force": [0.0, 300.0, 500.0], "law": PUSH}
    for name, lengths in {"two": (300.0, 350.0), "three": (300.0, 350.0, 280.0)}.items():
        line = section(lengths, POST, numerics=COARSE, loads=[{"span": 1, **push}])
        line.save(tmp_path / f"{name}.toml")
    (tmp_path / "cases.csv").write_text(
        "name,scene,section.spans.1.length,numerics.elements\n"
        "A,two.toml,320,\nB,three.toml,,\nC,example1,,4\n"
    )
    runs = gf.sweep(table=tmp_path / "cases.csv", stop_time=0.5)
    assert runs.dataset.outcome.values.tolist() == ["completed"] * 3
    amplitude = runs.dataset.span_u2_amplitude
    assert np.isfinite(amplitude).sum("span").values.tolist() == [2, 3, 0]
    assert np.isfinite(runs.dataset.u2_amplitude).values.tolist() == [False, False, True]
    assert runs.grid().span_u2_amplitude.dims == ("name", "span")
    assert "tower_pull_lowest" not in runs.dataset  # posts


def test_the_smallest_clearance_includes_the_quarter_points():
    """Phases that come nearest at a quarter of the span, while mid-span is still at rest."""
    phases = [{"name": "a"}, {"name": "b", "offset": [4.0, 0.0]}]
    loads = [
        {"span": 1, "phase": 1 + k, "position": 0.75, "force": [0.0, force, 0.0], "law": PUSH}
        for k, force in enumerate((1500.0, -1500.0))
    ]
    scene = section((300.0,), numerics={"elements": 8}, phases=phases, loads=loads)
    row = gf.sweep(scene, {"section.horizontal_tension": [25e3]}, stop_time=1.0).dataset.isel(run=0)
    whole = gf.simulate(scene, 1.0, record_nodes="all")
    at_mid_span = gf.simulate(scene, 1.0).clearances["smallest"].item()
    assert row.smallest_clearance < at_mid_span - 0.2
    assert row.smallest_clearance == pytest.approx(whole.clearances["smallest"].item(), abs=0.05)


def test_a_run_that_ends_early_keeps_its_extremes():
    scene = pushed(
        wind={"speed": 12.0},
        aerodynamics={
            "kind": "polynomial",
            **{"lift": [0.0, 0.0, 0.0, 0.0], "drag": [1.0, 0.0, 0.0, 0.0]},
            **{"moment": [0.0, 0.0, 0.0, 0.0], "valid_from_deg": -3.0, "valid_to_deg": 3.0},
        },
    )
    data = gf.sweep(scene, {"wind.speed": [12.0]}, stop_time=10.0).dataset
    assert data.outcome.values.tolist() == ["angle_out_of_range"]
    assert 0.0 < data.time[0] < 10.0
    assert np.isnan(data.span_u2_amplitude).all()
    assert np.isfinite(data.tower_force_x3_highest).all()
    assert np.isfinite(data.span_sag).all()


def test_a_summary_of_ones_own_takes_the_result_of_a_line():
    def pulls(result):
        return {"span_1_pull": float(result.strings.pull_max[0])}

    runs = gf.sweep(pushed(), {"loads.0.span": [1, 2]}, stop_time=0.5, summary=pulls)
    assert runs.dataset.span_1_pull.dims == ("run",)
    assert (runs.dataset.span_1_pull > 4e3).all()


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"span.length": [300.0]}, "span belongs to scenes with"),
        ({"line.span": [300.0]}, "line belongs to scenes with"),
        ({"section.spans.0.lenth": [300.0]}, r"the closest valid one is section\.spans\.0\.length"),
        ({"bundle.spacer": [3]}, r"the closest valid one is bundle\.spacers"),
    ],
)
def test_keys_that_a_line_does_not_have_are_refused_early(over, message):
    with pytest.raises(gf.SceneError, match=message):
        gf.sweep(pushed(), over)


def test_a_span_has_no_keys_of_a_line():
    with pytest.raises(gf.SceneError, match=r"section belongs to scenes with \[section\]"):
        gf.sweep("example1", {"section.spans.0.length": [300.0]})


def test_estimate_refuses_a_line_at_once():
    with pytest.raises(gf.SceneError, match=r"estimate_only takes a scene of one span.*leave it"):
        modal.screen_spans(pushed(), {"wind.speed": [4.0, 5.0]}, estimate_only=True)


def test_command_shows_the_values_of_all_spans(invoke, tmp_path):
    pushed().save(tmp_path / "line.toml")
    words = ("sweep", "line.toml", "--stop-time", 1, "--over", "section.spans.1.length=330:350:20")
    shown = invoke(*words)
    assert shown.exit_code == 0, shown.output
    row = json.loads(invoke(*words, "--json").stdout)["rows"][0]
    both = ", ".join(f"{row[f'span_{span}_u2_amplitude']:.5g}" for span in (1, 2))
    assert both in " ".join(shown.stdout.split())
    assert "span u2" in shown.stdout
    assert "smallest" not in shown.stdout


def test_names_of_columns_of_places():
    assert Place("span", 2).name_of("span_u2_amplitude") == "span_2_u2_amplitude"
    name = "tower_0_phase_3_force_x1_lowest"
    assert placed(name) == ("tower_force_x1_lowest", Place("tower", 0, 3))
    assert Place("tower", 0, 3).name_of("tower_force_x1_lowest") == name
    assert placed("span.length") == ("span.length", None)
    assert placed("label.span_1_x") == ("label.span_1_x", None)


def test_places_missing_in_some_columns_are_nan():
    runs = gf.sweep(pushed(), {"loads.0.span": [1]}, stop_time=0.1)
    flat = flattened(runs.dataset).drop_vars(["span_1_sag", "span_2_motion"])
    whole = stacked(flat, LINE_COLUMNS)
    assert np.isnan(whole.span_sag.values[0]).tolist() == [True, False]
    assert whole.span_motion.values[0, 1] == ""
