"""CSV inputs as FMPy reads them, and results as Parquet."""

import numpy as np
import pandas as pd
import pytest

import gallop_fmu as gf

CSV = '"time","wind_speed","attack_angle","support.left.x1"\n0,5.0,3.0,0.0\n1,6.0,3.0,0.002\n4,5.5,3.0,0.0\n'


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
        ("time,windspeed\n0,5\n1,5\n", r"in.csv: windspeed is no input; it must name time and any of wind_speed"),
        ("wind_speed\n5\n5\n", r"in.csv: the header is wind_speed; it must name time"),
        ("time\n0\n1\n", r"in.csv: the header is time; it must name time and any of"),
        ("time,wind_speed\n0,5\n0,6\n", r"time must increase"),
        ("time,wind_speed\n0,5\n", r"at least two"),
        ("time,attack_angle\n0,3.0\n1,3.1\n", r"attack_angle changes from 3.0; in a scene it is constant"),
        ("time,wind_speed\n0,5\n1,five\n", r"wind_speed in row 3 is 'five'"),
        ("", r"the header is ; it must name time"),
    ],
)
def test_a_bad_file_is_told(file, text, message):
    file.write_text(text)
    with pytest.raises(gf.SceneError, match=message):
        gf.with_inputs(gf.load_scene("example3"), file)


def test_mid_span_histories_as_parquet_hold_units_and_provenance(tmp_path):
    result = gf.simulate(gf.load_scene("example3"), stop_time=0.5)
    frame = pd.read_parquet(result.save(tmp_path / "run.parquet"))
    assert frame.u2.to_numpy() == pytest.approx(result.midspan().u2.values, abs=0.0)
    assert frame.index.to_numpy() == pytest.approx(result.dataset.time.values, abs=0.0)
    assert frame.attrs["units"]["tension"] == "N"
    assert frame.attrs["scene"] == result.dataset.attrs["scene"]


def test_without_pyarrow_the_extra_is_named(tmp_path, monkeypatch):
    result = gf.simulate(gf.load_scene("example3"), stop_time=0.1)
    monkeypatch.setattr("gallop_fmu.result.find_spec", lambda name: None)
    with pytest.raises(gf.SceneError, match=r'pip install "gallop-fmu\[parquet\]"'):
        result.save(tmp_path / "run.parquet")
