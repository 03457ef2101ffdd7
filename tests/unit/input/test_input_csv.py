"""CSV inputs as FMPy reads them, and results as Parquet."""

import tomllib

import numpy as np
import pandas as pd
import pytest

import gallop_fmu as gf
from gallop_fmu.foundation.text_files import parse_toml
from support.lines import LINE

CSV = (
    '"time","wind_speed","attack_angle","support.left.x1"\n'
    "0,5.0,3.0,0.0\n1,6.0,3.0,0.002\n4,5.5,3.0,0.0\n"
)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "in.csv"
    path.write_text(CSV)
    return path


def test_columns_become_laws(file):
    scene = gf.with_inputs(gf.load_scene("example3"), file)
    assert scene.wind.speed is None
    assert scene.wind.history.at([0.5, 2.5, 9.0]) == pytest.approx([5.5, 5.75, 5.5])
    assert scene.ice.attack_angle_deg == pytest.approx(np.degrees(3.0))
    assert scene.supports.left.motion.x1.at(1.0) == 0.002
    assert scene.supports.left.motion.x2 is None
    assert scene.supports.right.motion is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "time,windspeed\n0,5\n1,5\n",
            r"in.csv: the first line must name time, .*any of wind_speed.*; it has 'windspeed'",
        ),
        (
            "wind_speed\n5\n5\n",
            r"in.csv: the first line must name time, the first column, .*; it is 'wind_speed'",
        ),
        ("time\n0\n1\n", r"in.csv: the first line must name time, .*; it is 'time'"),
        (
            "time,wind_speed\n0,5\n1,6\n0,6\n",
            r"in.csv: time must increase; row 4 has 0.0 after 1.0",
        ),
        (
            "time,wind_speed\n0,5\n0,6\n0,7\n",
            r"in.csv: time must increase; row 4 has .* at most two rows may have the same",
        ),
        (
            "time,attack_angle\n0,3.0\n1,3.1\n",
            r"attack_angle changes from 3.0, but is constant in a scene",
        ),
        ("time,wind_speed\n0,5\n1,five\n", r"wind_speed in row 3 is 'five'"),
        ("", r"in.csv: .*; the file is empty"),
        ("time,wind_speed\n", "in.csv: has no rows"),
    ],
)
def test_a_bad_file_is_reported(file, text, message):
    file.write_text(text)
    with pytest.raises(gf.SceneError, match=message):
        gf.with_inputs(gf.load_scene("example3"), file)


def test_mid_span_histories_as_parquet_have_units_and_provenance(tmp_path):
    result = gf.simulate(gf.load_scene("example3"), stop_time=0.5)
    frame = pd.read_parquet(result.save(tmp_path / "run.parquet"))
    assert frame.u2.to_numpy() == pytest.approx(result.midspan().u2.values, abs=0.0)
    assert frame.index.to_numpy() == pytest.approx(result.dataset.time.values, abs=0.0)
    assert frame.attrs["units"]["tension"] == "N"
    assert frame.attrs["scene"] == result.dataset.attrs["scene"]


def test_without_pyarrow_the_extra_is_named(tmp_path, monkeypatch):
    result = gf.simulate(gf.load_scene("example3"), stop_time=0.1)
    monkeypatch.setattr("gallop_fmu.simulation.result_base.find_spec", lambda name: None)
    with pytest.raises(gf.SceneError, match=r'pip install "gallop-fmu\[parquet\]"'):
        result.save(tmp_path / "run.parquet")


def driven(file, text):
    file.write_text(text)
    return gf.with_inputs(gf.load_scene("example3"), file)


def not_covered(scene, stop_time):
    return [
        sentence for sentence in gf.simulate(scene, stop_time).warnings if " covers " in sentence
    ]


def test_two_rows_of_one_time_are_a_jump(file):
    """As in FMPy, whose inputs keep the value before the jump at its instant."""
    scene = driven(file, "time,wind_speed\n0,5\n5,5\n5,6\n20,6\n")
    assert scene.wind.history.at([0.0, 4.999999, 5.0, 5.000001, 19.0]) == pytest.approx(
        [5.0, 5.0, 5.0, 6.0, 6.0]
    )
    assert type(scene).from_dict(tomllib.loads(scene.to_toml())) == scene
    recorded = gf.simulate(scene, 6.0).dataset.wind_speed
    assert set(np.unique(recorded.values)) == {5.0, 6.0}
    assert recorded.sel(time=slice(5.005, None)).min() == 6.0


@pytest.mark.parametrize("integrator", ["newmark", "gauss6", "generalised_alpha"])
def test_a_jump_is_that_of_a_ramp_without_duration(file, integrator):
    numerics = {"numerics.integrator": integrator, "numerics.elements": 6}
    jump = driven(
        file, "time,wind_speed,support.left.x1\n0,4,0\n0.5,4,0\n0.5,6,1e-4\n2,6,1e-4\n"
    ).with_values(numerics)
    steep = {"kind": "ramp", "start": 0.5 + 1e-12, "duration": 0.0}
    laws = {
        "wind.history": {**steep, "initial": 4.0, "final": 6.0},
        "supports.left.motion.x1": {**steep, "initial": 0.0, "final": 1e-4},
    }
    runs = [gf.simulate(scene, 1.0).midspan() for scene in (jump, jump.with_values(laws))]
    for name in ("u2", "u3", "tension"):
        assert runs[0][name].values == pytest.approx(runs[1][name].values, rel=1e-9, abs=1e-12)


def test_a_single_row_is_constant(file):
    scene = driven(file, "time,wind_speed,support.left.x1\n0,5,0.1\n")
    assert scene.wind.history.at([0.0, 9.0]).tolist() == [5.0, 5.0]
    assert scene.supports.left.motion.x1.at([9.0]).tolist() == [0.1]
    assert not_covered(scene, 0.1) == []


@pytest.mark.parametrize("name", ["Time", "time [s]", "t", "TIMESTAMP (s)"])
def test_the_first_column_is_the_time_under_any_name(file, name):
    assert driven(file, f"{name},Wind_speed [m/s]\n0,5\n10,7\n").wind.history.at(5.0) == 6.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,wind_speed,wind_speed\n0,4,9\n10,4,9\n", "column 'wind_speed' is given twice"),
        ("t,time,wind_speed\n0,0,9\n", "column 'time' is given twice"),
        ("wind_speed,time\n5,0\n", "must name time, the first column"),
        ("time [ms],wind_speed\n0,5\n", "must be in s"),
        ("time,wind_speed [km/h]\n0,5\n", "must be in m/s"),
    ],
)
def test_columns_that_fmpy_would_not_take_so(file, text, message):
    with pytest.raises(gf.SceneError, match=message):
        driven(file, text)


@pytest.mark.parametrize(
    ("times", "covered"),
    [((2, 3), "0"), ((0, 0.5), "0.5"), ((0.2, 9.0), "0.8")],
)
def test_a_history_shorter_than_the_run_is_reported(file, times, covered):
    scene = driven(file, f"time,wind_speed,support.right.x2\n{times[0]},5,0\n{times[1]},5,0\n")
    warnings = not_covered(scene, 1.0)
    assert warnings[0].startswith(f"wind.history covers {covered} s of the 1 s, from ")
    assert warnings[1].startswith(f"supports.right.motion.x2 covers {covered} s of the 1 s")
    assert not_covered(driven(file, "time,wind_speed\n0,5\n1,5\n"), 1.0) == []


@pytest.mark.parametrize(
    ("stop_time", "every", "message"),
    [
        (
            1.0,
            1000,
            "first record would be at 10 s, after the end of the run at 1 s; at most 100 steps",
        ),
        (
            1e12,
            None,
            r"stop_time = 1e\+12 s is 1e\+14 time steps of 0.01 s; a run has at most 1e\+08",
        ),
        (1e8, None, "a run has at most"),
        (
            1.0,
            2**63,
            (
                "record_every = 9223372036854775808: must be a whole number of time steps, from 1"
                " to 1000000"
            ),
        ),
        (1.0, True, "record_every = True"),
    ],
)
def test_runs_and_records_have_a_limit(stop_time, every, message):
    with pytest.raises(gf.SceneError, match=message):
        gf.simulate(gf.load_scene("example3"), stop_time, record_every=every)


def test_columns_of_a_line_become_laws_of_its_towers(tmp_path):
    line = gf.LineScene.from_dict(parse_toml(LINE))
    path = tmp_path / "in.csv"
    path.write_text("time,tower[0].x1,tower[2].x3,tower[3].x2\n0,0,0,0.5\n2,0.1,0.2,0.5\n")
    section = gf.with_inputs(line, path).section
    assert section.left_end.motion.x1.at(1.0) == 0.05
    assert section.suspensions[1].motion.x3.at(1.0) == 0.1
    assert section.right_end.motion.x2.at(1.0) == 0.5
    assert section.suspensions[0].motion is None


@pytest.mark.parametrize("name", ["tower[4].x1", "support.left.x1", "attack_angle"])
def test_columns_that_a_line_does_not_have(tmp_path, name):
    path = tmp_path / "in.csv"
    path.write_text(f"time,{name}\n0,0\n2,0.1\n")
    with pytest.raises(gf.SceneError, match=r"any of wind_speed, tower\[0\].x1, .* \(13 in all\)"):
        gf.with_inputs(gf.LineScene.from_dict(parse_toml(LINE)), path)
