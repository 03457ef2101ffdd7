"""Sweeps: the numbers of single runs, wherever they are computed; no failure is lost."""

import json
import math
import multiprocessing
import re

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.cli import sweep_options
from gallop_fmu.simulation.clearance import cigre_322_single_loop, davison_single_loop
from gallop_fmu.sweeps.sweep import SUMMARY_COLUMNS
from modal.screening.many_spans import ESTIMATE_COLUMNS, SCREENING_COLUMNS, EstimateTask
from support.sweeps import same

WINDS = {"wind.speed": [4.0, 5.5], "ice.attack_angle_deg": [180.0, 300.0, 178.0]}
"""300 deg is outside the coefficient curve."""


@pytest.fixture(scope="module")
def scene():
    return gf.load_scene("example3").with_values(
        {"numerics.elements": 4, "numerics.time_step": 0.02, "initial.seed_vertical": 0.3}
    )


@pytest.fixture(scope="module")
def runs(scene):
    return gf.sweep(scene, WINDS, stop_time=20.0, window=10.0)


def test_rows_equal_single_runs(scene, runs):
    for row in (0, 5):
        values = {key: runs.dataset[key].values[row] for key in WINDS}
        result = gf.simulate(scene.with_values(values), 20.0)
        steady, middle = result.steady(10.0), result.midspan()
        found = {name: runs.dataset[name].values[row] for name in SUMMARY_COLUMNS}
        for name in ("u2", "u3", "theta", "tension"):
            amplitude, mean, frequency, *_ = steady[name]
            assert found[f"{name}_amplitude"] == amplitude
            assert found[f"{name}_mean"] == mean
            assert found[f"{name}_frequency_hz"] == frequency
            assert found[f"{name}_lowest"] == middle[name].min()
            assert found[f"{name}_highest"] == middle[name].max()
        right = result.dataset[["right_f1", "right_f2", "right_f3"]].to_array()
        assert found["support_force_highest"] >= float(np.sqrt((right**2).sum("variable")).max())
        assert found["lowest_tension"] == result.report.lowest_tension
        assert found["horizontal_tension"] == result.dataset.attrs["horizontal_tension"]
        assert found["time"] == 20.0
        last = middle.sel(time=slice(10.0 - 1e-9, None))
        for ellipse, name in (
            (cigre_322_single_loop(2.12, 0.0235), "cigre_322"),
            (davison_single_loop(2.12), "davison"),
        ):
            assert found[f"{name}_excess"] == ellipse.distance(last.u3.values, last.u2.values).max()
    assert runs.dataset.u2_amplitude.attrs["units"] == "m"
    assert runs.dataset["wind.speed"].attrs["units"] == "m/s"


def test_runs_that_fail_are_rows(scene, runs):
    assert (runs.done, runs.total) == (6, 6)
    assert runs.failed["run"].values.tolist() == [1, 4]
    for outcome, message in zip(
        runs.failed.outcome.values, runs.failed.message.values, strict=True
    ):
        assert outcome == "invalid_scene"
        assert "ice.attack_angle_deg = 300.0 is outside" in message
    assert np.all(np.isnan(runs.failed.u2_amplitude))


def test_a_run_that_ends_early_keeps_its_records(scene):
    runs = gf.sweep(scene, {"aerodynamics.valid_to_deg": [181.0, 260.0]}, stop_time=20.0)
    assert runs.dataset.outcome.values.tolist() == ["angle_out_of_range", "completed"]
    assert "the attack angle left the validity range" in runs.dataset.message.values[0]
    assert 0.0 < runs.dataset.time.values[0] < 20.0
    assert runs.dataset.u2_highest.values[0] >= 0.3
    assert math.isnan(runs.dataset.u2_amplitude.values[0])


def test_energies_are_recorded_only_for_a_summary_that_can_read_them(scene, monkeypatch):
    recorded = []

    def recording(*arguments, **options):
        result = gf.simulate(*arguments, **options)
        recorded.append("potential_energy" in result.recorded.values)
        return result

    monkeypatch.setattr("gallop_fmu.sweeps.sweep.simulate", recording)
    for summary in (None, lambda result: {"steps": result.report.steps}):
        gf.sweep(scene, {"wind.speed": [5.0]}, stop_time=1.0, summary=summary, workers=1)
    assert recorded == [False, True]


def test_an_unexpected_exception_is_a_row_too(scene):
    def failing(result):
        if result.scene.wind.speed == 5.0:
            raise MemoryError("for a test")
        return {"wind": result.scene.wind.speed, "word": "fine"}

    runs = gf.sweep(scene, {"wind.speed": [4.0, 5.0, 6.0]}, stop_time=1.0, summary=failing)
    assert runs.dataset.outcome.values.tolist() == ["completed", "error", "completed"]
    assert runs.dataset.message.values[1] == "MemoryError: for a test"
    assert runs.dataset.word.values.tolist() == ["fine", "", "fine"]


def test_grid_has_a_dimension_for_each_parameter(runs):
    grid = runs.grid()
    assert dict(grid.sizes) == {"wind.speed": 2, "ice.attack_angle_deg": 3}
    assert grid["wind.speed"].attrs["units"] == "m/s"
    for row in range(6):
        place = {key: runs.dataset[key].values[row] for key in WINDS}
        assert np.array_equal(
            grid.u2_amplitude.sel(place), runs.dataset.u2_amplitude.values[row], equal_nan=True
        )
        assert grid.outcome.sel(place) == runs.dataset.outcome.values[row]


def test_grid_of_a_table_is_named(scene):
    table = [
        {"name": "A", "span.sag": 2.12, "label.owner": "x"},
        {"name": "B", "span.sag": 2.1, "label.owner": "y"},
    ]
    runs = gf.sweep(scene, {"wind.speed": [4.0, 5.0, 6.0]}, table=table, stop_time=0.2)
    assert runs.grid().u2_highest.dims == ("name", "wind.speed")
    assert runs.grid().sag.sel(name="B", **{"wind.speed": 6.0}) == pytest.approx(2.1)
    assert runs.dataset["label.owner"].values.tolist() == ["x"] * 3 + ["y"] * 3


def test_model_is_the_element_alone(scene, tmp_path):
    runs = gf.sweep(scene, {"wind.speed": [4.0]}, stop_time=1.0, model="element")
    assert runs.dataset.outcome.values.tolist() == ["completed"]
    out = tmp_path / "runs.parquet"
    with pytest.raises(gf.SceneError, match=r"condensed model was removed in 0\.2\.0"):
        gf.sweep(scene, {"wind.speed": [4.0]}, stop_time=1.0, out=out, model="condensed")
    assert not out.exists()


@pytest.mark.parametrize("workers", [1, 3])
def test_number_of_threads_changes_nothing(scene, runs, workers):
    assert same(gf.sweep(scene, WINDS, stop_time=20.0, window=10.0, workers=workers), runs)


def test_a_second_call_computes_nothing(scene, runs, tmp_path):
    out, calls = tmp_path / "runs.parquet", []
    arguments = {"stop_time": 20.0, "window": 10.0, "out": out}
    first = gf.sweep(scene, WINDS, **arguments, progress=lambda *numbers: calls.append(numbers))
    assert calls[0] == (0, 0, 6)
    assert calls[-1] == (6, 2, 6)
    assert len(calls) == 7
    second = gf.sweep(scene, WINDS, **arguments, progress=lambda *numbers: calls.append(numbers))
    assert calls[7:] == [(6, 2, 6)]
    assert second.dataset.identical(first.dataset)
    assert gf.read_runs(out).dataset.identical(first.dataset)
    assert same(first, runs)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"stop_time": 21.0}, "task was"),
        ({"window": 9.0}, "task was"),
        ({"summary": lambda result: {}}, "task was"),
    ],
)
def test_another_task_is_not_mixed_in(scene, tmp_path, change, what):
    arguments = {"stop_time": 1.0, "window": 0.5, "out": tmp_path / "runs.parquet"}
    gf.sweep(scene, {"wind.speed": [4.0]}, **arguments)
    with pytest.raises(gf.SceneError, match=what):
        gf.sweep(scene, {"wind.speed": [4.0]}, **{**arguments, **change})
    with pytest.raises(gf.SceneError, match="scenes was"):
        gf.sweep(scene, {"wind.speed": [4.1]}, **arguments)


def test_another_version_is_not_mixed_in(scene, tmp_path, monkeypatch):
    arguments = {"stop_time": 1.0, "out": tmp_path / "runs.parquet"}
    gf.sweep(scene, {"wind.speed": [4.0]}, **arguments)
    monkeypatch.setattr("gallop_fmu.sweeps.runner._kernel_hash", lambda: "0123456789ab")
    with pytest.raises(
        gf.SceneError, match=r"package was gallop-fmu .* is gallop-fmu .* \(kernel 0123456789ab\)"
    ):
        gf.sweep(scene, {"wind.speed": [4.0]}, **arguments)


def test_a_file_that_cannot_be_written_at_the_end_loses_nothing(scene, tmp_path, monkeypatch):
    out = tmp_path / "runs.nc"

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(
        gf.RunsStoppedError,
        match=r"runs.nc cannot be written .* 2 of 2 runs are done and kept in .*nc.journal",
    ) as end:
        gf.sweep(scene, {"wind.speed": [4.0, 5.0]}, stop_time=1.0, out=out)
    assert end.value.result.done == 2
    monkeypatch.undo()
    calls = []
    again = gf.sweep(
        scene,
        {"wind.speed": [4.0, 5.0]},
        stop_time=1.0,
        out=out,
        progress=lambda *n: calls.append(n),
    )
    assert calls == [(2, 0, 2)]
    assert again.dataset.identical(end.value.result.dataset)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["runs.nc", "runs.nc.journal"]


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        ({"workers": 0}, "workers = 0"),
        ({"window": 0.0}, "window = 0.0 s"),
        ({"model": "linear"}, "model = 'linear'"),
        ({"stop_time": math.inf}, "stop_time = inf"),
        ({"workers": 1, "cluster": "tcp://127.0.0.1:1"}, "a cluster has its own workers"),
        ({"out": "runs.csv"}, "must end in .parquet or .nc"),
    ],
)
def test_refusals(scene, arguments, fragment):
    with pytest.raises(gf.SceneError, match=fragment):
        gf.sweep(scene, {"wind.speed": [4.0]}, **{"stop_time": 1.0, **arguments})


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("wind.speed=4,5.5", [4, 5.5]),
        ("wind.speed=4:5:0.5", [4.0, 4.5, 5.0]),
        ("wind.speed=4.2:4.4:0.1", [4.2, 4.3, 4.4]),
        ("wind.speed=5:4:-0.5", [5.0, 4.5, 4.0]),
        ("aerodynamics.outside=hold, periodic", ["hold", "periodic"]),
        ("span.sag=none,2.1", [None, 2.1]),
    ],
)
def test_over_on_the_command_line(text, values):
    assert sweep_options.grid_of([text]) == {text.partition("=")[0]: values}


@pytest.mark.parametrize(
    "text",
    ["wind.speed", "=4", "wind.speed=", "a=1:2", "a=1:2:0", "a=1:2:0.3", "a=2:1:0.5", "a=b:c:d"],
)
def test_over_that_is_refused(text):
    with pytest.raises(gf.SceneError, match=f"--over {text}"):
        sweep_options.grid_of([text])


QUICK = ("--set", "numerics.elements=4", "--stop-time", 1)


def test_command_prints_a_table_and_lists_failures(invoke):
    result = invoke(
        "sweep",
        "example3",
        *QUICK,
        "--over",
        "wind.speed=4,5",
        "--over",
        "ice.attack_angle_deg=180,300",
    )
    assert result.exit_code == 1
    assert "u2 amplitude" in result.stdout
    assert result.stdout.count("invalid_scene") == 2
    assert "2 of 4 runs did not complete:" in result.stderr
    assert (
        "  wind.speed 4, ice.attack_angle_deg 300: ice.attack_angle_deg = 300.0 is outside"
        in result.stderr
    )


def test_tables_break_no_word_at_80_columns(invoke, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    angles = ("--over", "ice.attack_angle_deg=180,300")
    shown = invoke("sweep", "example3", *QUICK, "--over", "wind.speed=4,5", *angles).stdout
    table = shown.partition("undetermined (")[0]
    assert table.count(" undetermined ") == 2
    for words in (
        "amplitude",
        "frequency",
        "attack_",
        "invalid_",
    ):  # names break after a dot or underscore
        assert re.search(rf"\s{words}\s", table)
    assert max(map(len, shown.splitlines()[:12])) <= 80
    assert "wind.speed 4, ice.attack_angle_deg 180 and 1 more run: undetermined (" in shown
    assert " undetermined " in invoke("run", "example3", *QUICK).stdout


def test_command_writes_and_resumes(invoke, tmp_path):
    (tmp_path / "spans.csv").write_text(
        "name,span.sag,span.horizontal_tension\nnorth 4,2.0,none\nnorth 5,,\n"
    )
    words = ("sweep", "example3", *QUICK, "--table", "spans.csv", "--out", "runs.parquet")
    result = invoke(*words)
    assert result.exit_code == 0, result.output
    assert "north 4" in result.stdout
    assert "wrote runs.parquet: 2 of 2 runs" in result.stdout
    assert result.stderr == ""
    printed = json.loads(invoke(*words, "--json").stdout)
    assert printed == {"runs": 2, "done": 2, "failed": [], "files": ["runs.parquet"]}


def test_command_as_json(invoke):
    rows = json.loads(
        invoke("sweep", "example3", *QUICK, "--over", "wind.speed=4,5", "--json").stdout
    )["rows"]
    assert [row["wind.speed"] for row in rows] == [4, 5]
    assert all(row["outcome"] == "completed" for row in rows)


def test_command_shows_no_more_than_fits(invoke):
    result = invoke(
        "sweep", "example3", *QUICK[:2], "--stop-time", 0.02, "--over", "wind.speed=4:7:0.1"
    )
    assert "and 11 more; give --out FILE to get them all" in result.stdout
    result = invoke(
        "sweep",
        "example3",
        *QUICK[:2],
        "--stop-time",
        0.02,
        "--over",
        "ice.attack_angle_deg=290:300:1",
    )
    assert result.stderr.count("is outside") == 10
    assert "  and 1 more\n" in result.stderr


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        ((), "nothing to vary"),
        (("--over", "wind.sped=4"), "wind.sped: unknown key"),
        (("--table", "none.csv"), "none.csv: no such file"),
        (("--over", "wind.speed=4", "--out", "a.csv"), "a.csv: must end in"),
    ],
)
def test_command_refuses(invoke, words, fragment):
    result = invoke("sweep", "example3", *words)
    assert result.exit_code == 2
    assert fragment in result.stderr
    assert "Traceback" not in result.output


def test_screening_a_table_is_screening_each(scene, invoke, tmp_path):
    """In a process of its own; the second span has no structural damping."""
    from modal.cli.main import app

    scene = scene.with_values({"numerics.elements": 8, "wind.speed": 4.8})
    scene.save(tmp_path / "mine.toml")
    (tmp_path / "spans.csv").write_text("name,span.sag,damping\nA,2.1,\nB,,{}\n")
    words = (
        "screen",
        "mine.toml",
        "--table",
        "spans.csv",
        "-o",
        "a.nc",
        "--highest-wind",
        4.9,
        "--workers",
        2,
    )
    result = invoke(*words, app=app)
    assert result.exit_code == 1
    assert "wrote a.nc: 2 of 2 runs" in result.stdout
    assert "  B: the structural damping ratio" in result.stderr
    found = gf.read_runs(tmp_path / "a.nc")
    alone = modal.screen(scene.with_values({"span.sag": 2.1}), 4.9)
    row = {name: found.dataset[name].values[0] for name in SCREENING_COLUMNS}
    assert row["risk"] == alone.risk == "detuned"
    assert row["reason"] == alone.reason
    # 0 observed; the processes' linear algebra uses one thread each, and may add in another order
    assert row["galloping_from"] == pytest.approx(alone.galloping_from, rel=1e-9)
    assert row["galloping_vertical"] == pytest.approx(alone.galloping.vertical, rel=1e-9)
    assert math.isnan(row["onset_wind_speed"])
    assert row["ratio"] == pytest.approx(alone.frequencies.ratio, rel=1e-12)
    assert found.dataset.outcome.values.tolist() == ["completed", "invalid_scene"]
    assert "structural damping ratio" in found.dataset.message.values[1]


@pytest.mark.parametrize("workers", [1, 2])
def test_screening_where_no_process_can_be_started(scene, monkeypatch, workers):
    """A worker of Celery or multiprocessing.Pool is a daemon; one worker needs no process."""
    if workers == 1:
        monkeypatch.setattr(
            "loky.ProcessPoolExecutor.submit", lambda *_: pytest.fail("a process was started")
        )
    else:
        monkeypatch.setitem(multiprocessing.current_process()._config, "daemon", True)
    found = modal.screen_spans(
        scene, {"wind.speed": [5.0, 5.1]}, estimate_only=True, workers=workers
    )
    assert found.dataset.outcome.values.tolist() == ["completed", "completed"]


def test_screening_where_the_system_refuses_processes(scene, monkeypatch):
    """As in a container at its limit of processes, or without shared memory."""

    def refused(*_, **__):
        raise OSError(11, "Resource temporarily unavailable")

    monkeypatch.setattr("loky.backend.popen_loky_posix.Popen._launch", refused)
    found = modal.screen_spans(scene, {"wind.speed": [5.0]}, estimate_only=True, workers=2)
    assert found.dataset.outcome.values.tolist() == ["completed"]


def test_estimate_only_is_the_estimate(scene):
    """A swing; a threshold that is not reached; no threshold; no wind."""
    example, free = gf.load_scene("example3"), {"span.horizontal_tension": None}
    scenes = [example, *(example.with_values({**free, "span.sag": sag}) for sag in (1.8, 1.5))]
    calm = scene.with_values({"wind.speed": 0.0})
    swings, below, detuned, calm = EstimateTask(6.0)([*scenes, calm], lambda: True)
    alone = modal.two_mode_estimate(scenes[0], 5.5, 6.0)
    assert swings["suspect"] is True
    assert swings["estimated_onset"] == alone.onset_wind_speed
    assert swings["estimated_threshold"] == alone.threshold_amplitude
    assert swings["estimated_vertical"] == alone.vertical_amplitude
    assert swings["ratio"] == modal.frequency_ratio(scenes[0]).ratio
    assert set(ESTIMATE_COLUMNS) <= set(swings)
    round_ice = example.with_values({"ice.first_moment_x2": 0.0, "ice.first_moment_x3": 0.0})
    (warned,) = EstimateTask(6.0)([round_ice], lambda: True)
    assert (swings["warnings"], warned["warnings"]) == ("", " ".join(round_ice.warnings))
    assert "round section" in warned["warnings"]
    assert (below["suspect"], below["estimated_onset"]) == (True, None)
    assert (detuned["suspect"], detuned["estimated_threshold"]) == (False, None)
    assert calm["outcome"] == "invalid_scene"
    assert "wind.speed = 0 m/s" in calm["message"]


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        ((), "no scene"),
        (("example3", "--out", "a.nc"), "are for many spans"),
        (("example3", "--estimate-only"), "are for many spans"),
        (("example3", "--over", "span.sag=2.1", "--plot", "a.png"), "--plot draws one span"),
    ],
)
def test_screen_command_refuses(invoke, words, fragment):
    from modal.cli.main import app

    result = invoke("screen", *words, app=app)
    assert result.exit_code == 2
    assert fragment in result.stderr


@pytest.mark.parametrize(
    ("kept", "message"),
    [
        ({"a/b": 1.0}, "a/b: the name of a column must not have a slash"),
        ({"": 1.0}, "'': a column needs a name of printable characters"),
        ({5: 1.0}, "5: a column needs a name"),
        (
            {"x": [1.0]},
            "x: must be a number of at most 64 bits, a truth value, a text or None, not [1.0]",
        ),
        ({"x": 10**30}, "x: must be a number of at most 64 bits"),
        ({"x": "a\0b"}, "x: a text must not hold control characters"),
        ({"outcome": 3}, "outcome: must be a text, not 3"),
        ({"run": 5}, "run: also a column of the inputs; give the result another name"),
        ({"wind.speed": 9.0}, "wind.speed: also a column of the inputs"),
        ({"x": np.int64(3), "y": np.array(2.5), "z": np.bool_(True), "t": "text"}, ""),
    ],
)
def test_a_summary_that_no_file_can_contain_is_a_failed_run(scene, tmp_path, kept, message):
    """The sweep continues, and the next one finds an intact journal."""
    arguments = {"stop_time": 0.1, "summary": lambda result: kept, "out": tmp_path / "a.nc"}
    for _ in range(2):
        dataset = gf.sweep(scene, {"wind.speed": [4.0]}, **arguments).dataset
        assert dataset.run.values.tolist() == [0]
        assert dataset["wind.speed"].values.tolist() == [4.0]
        assert message in dataset.message.values[0]
        assert dataset.outcome.values[0] == ("error" if message else "completed")
        assert (tmp_path / "a.nc").exists()


@pytest.mark.parametrize("out", [(), ("-o", "a.nc")])
@pytest.mark.parametrize("form", [(), ("--json",)])
def test_stopped_before_the_first_run_is_done(invoke, monkeypatch, tmp_path, out, form):
    """Ctrl-C within the first half second."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("gallop_fmu.sweeps.runner._rows", interrupted)
    result = invoke("sweep", "example3", "--over", "wind.speed=3:6:0.1", *out, *form)
    assert result.exit_code == 1
    assert "stopped on request. None of 31 runs is done, and nothing was written" in result.stderr
    assert "Traceback" not in result.output
    if form:
        said = json.loads(result.stdout)
        assert (said["runs"], said["done"], said["failed"], said["files"]) == (31, 0, [], [])
    assert list(tmp_path.iterdir()) == []
