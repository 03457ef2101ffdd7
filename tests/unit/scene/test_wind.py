"""Wind of a scene: direction, profile, turbulence, tables; what is refused, and what is said."""

import math
import tomllib

import numpy as np
import pytest

from gallop_fmu import LineScene, load_scene
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.time_functions import TimeTable
from gallop_fmu.scene.wind import Wind
from gallop_fmu.scene.wind_consistency import gusts_of, times_of_tables
from gallop_fmu.scene.wind_profile import LogarithmicProfile, PowerProfile

TURBULENCE = {"spectrum": "kaimal", "intensity": 0.1, "length_scale": 60.0}
TABLE = {"time": [0, 1, 2], "stations": [0, 60], "speed": [[4, 6], [5, 7], [6, 8]]}


def example3(**wind):
    """Its curve, of 100 to 260 deg, extended: the attack angle is 360 deg from the other side."""
    changes = {"wind": {"speed": 5.5, **wind}, "aerodynamics.outside": "hold"}
    return load_scene("example3").with_values(changes)


def with_table(**changes):
    return load_scene("example3").with_values({"wind": {"table": {**TABLE, **changes}}})


def line(spans=({"length": 100.0}, {"length": 150.0}), **wind):
    one = load_scene("example3")
    return LineScene.from_dict(
        {
            "title": "two spans",
            "section": {
                "horizontal_tension": 15000.0,
                "spans": list(spans),
                "suspensions": [{"kind": "post"}] * (len(spans) - 1),
            },
            "conductor": one.conductor.model_dump(exclude_none=True),
            "ice": one.ice.model_dump(exclude_none=True),
            "aerodynamics": one.aerodynamics.model_dump(exclude_none=True),
            "wind": {"speed": 5.0, **wind},
        }
    )


@pytest.mark.parametrize(
    ("wind", "message"),
    [
        ({"direction_deg": 90.0}, r"direction_deg = 90: the wind blows along the line.* below 90"),
        ({"direction_deg": -270.0}, r"direction_deg = -270: the wind blows along"),
        (
            {"direction_history": {"kind": "constant", "value": 90.0}},
            r"direction_history = 90: the wind blows along the line",
        ),
        (
            {"direction_deg": 361.0},
            r"direction_deg = 361\.0: must be at least -360 and",
        ),
        (
            {"direction_deg": 5.0, "direction_history": {"kind": "constant", "value": 30.0}},
            r"direction_deg = 5 deg and direction_history are both given; give one",
        ),
        (
            {"direction_history": {"kind": "constant", "value": 721.0}},
            r"direction_history reaches 721\.0 deg; it must stay within -720 to 720 deg",
        ),
        (
            {"turbulence": {**TURBULENCE, "intensity": 15}},
            r"intensity = 15: must be at least 0 and at most 1 \[1\];.*is it in % \(then 0\.15",
        ),
        (
            {"turbulence": {**TURBULENCE, "intensity": -0.1}},
            r"turbulence\.intensity = -0\.1: must be at least 0 and at most 1",
        ),
        (
            {"turbulence": {**TURBULENCE, "intensity_upwards": 0.05}},
            r"length_scale_upwards: missing, but intensity_upwards = 0\.05; give it in m \(typical",
        ),
        (
            {"speed": 0.0, "turbulence": TURBULENCE},
            r"turbulence\.intensity = 0\.1 is relative to the mean speed, which is 0 m/s; give",
        ),
        (
            {"turbulence": {**TURBULENCE, "time_step": 1.0, "duration": 3.0}},
            r"time_step = 1 s must be at most a quarter of the duration of the gusts, 3 s",
        ),
        (
            {"turbulence": {**TURBULENCE, "spacing": 0.01}},
            r"12589 stations, 25000 times and 1 component are 3\.15e\+08 gusts, more than",
        ),
        (
            {"turbulence": {**TURBULENCE, "spacing": 1e-9}},
            r"spacing = 1e-09 m gives more than 2e\+07 stations on 125\.88 m; increase it",
        ),
        (
            {"turbulence": {**TURBULENCE, "duration": 1e9}},
            r"time_step = 0\.1 s gives more than 2e\+07 times in 1e\+09 s; increase it",
        ),
        (
            {"profile": {"kind": "power", "exponent": 0.16}},
            r"wind\.profile\.attachment_height: missing",
        ),
        (
            {
                "profile": {
                    "kind": "logarithmic",
                    "roughness_length": 2.0,
                    "attachment_height": 1.5,
                }
            },
            r"attachment_height = 1\.5 m must be greater than roughness_length = 2 m",
        ),
        (
            {
                "profile": {
                    "kind": "power",
                    "exponent": 0.16,
                    "attachment_height": 15.0,
                    "ground_heights": [0, 16],
                }
            },
            r"attachment point of tower 1 is -1 m above ground, must be more than 0 m; check",
        ),
        (
            {
                "profile": {
                    "kind": "power",
                    "exponent": 0.16,
                    "attachment_height": 15.0,
                    "ground_heights": [0, 1, 2],
                }
            },
            r"ground_heights has 3 values, and the scene has 2 towers; give one for each",
        ),
        (
            {
                "profile": {
                    "kind": "power",
                    "exponent": 0.16,
                    "attachment_height": 15.0,
                    "ground_heights": [1, 2],
                }
            },
            r"ground_heights: the first is 1 m, must be 0",
        ),
        ({"table": TABLE}, r"table and speed are both given; the table has the speeds: remove it"),
    ],
)
def test_wind_that_is_refused(wind, message):
    with pytest.raises(SceneError, match=message):
        example3(**wind)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stations": [60, 0]}, r"stations must increase; station 2 is at 0 m, after 60 m: sort"),
        ({"stations": [0, 0]}, r"stations must increase; station 2 is at 0 m, after 0 m"),
        (
            {"stations": [0, 130]},
            r"station 2 is at x1 = 130 m, outside .* 0 to 125\.88 m",
        ),
        ({"stations": []}, r"stations: give x1 \[m\] of at least one station"),
        ({"time": [0, 1, 1]}, r"time must increase; row 3 has 1.* after 1"),
        ({"time": [0, 1]}, r"speed has 3 rows, time has 2; give a row for each time"),
        ({"speed": [[4, 6], [5], [6, 8]]}, r"speed: row 2 has 1 values, and there are 2 stations"),
        (
            {"speed": [[4, 6], [5, math.nan], [6, 8]]},
            r"wind\.table\.speed\.1\.1 = nan: must",
        ),
        (
            {"speed": [[4, 6], [0, 0], [-4, -6]]},
            r"mean over the table is 0 m/s, less than 1%",
        ),
        ({"speed": [[4, 6], [5, 151], [6, 8]]}, r"table\.speed reaches 151\.0 m/s; it must stay"),
        ({"across": [[0, 0]]}, r"across has 1 rows, time has 3"),
        ({"time": [0, 1, 20], "max_gap": 5.0}, r"gap of 19 s in time before row 3.* at most 5 s"),
        ({"time": [7000, 7001, 7002]}, r"begins after the run: it is from 7000 to 7002 s, the run"),
    ],
)
def test_wind_tables_that_are_refused(changes, message):
    with pytest.raises(SceneError, match=message):
        with_table(**changes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,a,60\n0,4,6\n1,4,6\n", r"mast\.csv: the first line must be like .* column 2 is not"),
        ("t,0,60\n0,4,6\n", r"rename the first column to time"),
        ("time,0,60\n0,4\n", r"mast\.csv: row 2 has 2 cells, 3 are required"),
        ("time,0,60\n0,4,x\n", r"60 in row 2 is 'x', must be a finite number"),
        ("time,0,60\n0,4,6\n0,4,6\n", r"mast\.csv: time must increase; row 3 has 0"),
        (
            "time,0,60\n0,4,6\n1,4,6\n2,4,6\n99,4,6\n",
            r"mast\.csv: gap of 97 s in time before",
        ),
    ],
)
def test_files_of_wind_that_are_refused(tmp_path, text, message):
    (tmp_path / "mast.csv").write_text(text)
    data = load_scene("example3").model_dump(exclude_none=True)
    data["wind"] = {"table": {"file": "mast.csv"}}
    with pytest.raises(SceneError, match=message):
        type(load_scene("example3")).from_dict(data, tmp_path)


def test_a_wind_table_is_its_mean_and_relative_gusts(tmp_path):
    (tmp_path / "mast.csv").write_text("Time [s],0 [m/s],60\n# masts\n10,4,6\n11,5,7\n12,6,8\n")
    data = load_scene("example3").model_dump(exclude_none=True)
    data["wind"] = {"table": {"file": "mast.csv", "origin": 10.0}}
    scene = type(load_scene("example3")).from_dict(data, tmp_path)
    assert scene.wind.mean_speed == pytest.approx(6.0)
    gusts = gusts_of(scene.wind, 125.88, 60.0)
    assert gusts.times.tolist() == [0.0, 1.0, 2.0]
    assert gusts.stations.tolist() == [0.0, 60.0]
    assert 6.0 * (1.0 + gusts.values[:, :, 0]) == pytest.approx(np.array([[4, 6], [5, 7], [6, 8]]))
    assert type(scene).from_dict(tomllib.loads(scene.to_toml())) == scene
    three = with_table(upwards=[[0, 3], [0, 0], [0, 0]])
    assert gusts_of(three.wind, 125.88, 60.0).values[0, 1] == pytest.approx([0.0, 0.0, 0.5])


@pytest.mark.parametrize(
    ("wind", "sentence"),
    [
        ({"speed": -5.0}, "wind.speed reaches -5 m/s: the wind comes from the other side"),
        (
            {"speed": None, "history": {"kind": "ramp", "initial": 3, "final": -4, "duration": 1}},
            "wind.history reaches -4 m/s: the wind comes from the other side (towards -x3)",
        ),
        ({"direction_deg": 170.0}, "wind.direction_deg reaches 170 deg: the wind comes from the"),
        (
            {"direction_history": {"kind": "ramp", "initial": 0, "final": 180, "duration": 9}},
            "wind.direction_history reaches 180 deg: the wind comes from the other side",
        ),
        ({"direction_deg": -75.0}, "wind.direction_deg reaches -75 deg: more than 60 deg from"),
        (
            {"turbulence": {**TURBULENCE, "time_step": 2.0, "duration": 30.0}},
            "wind.turbulence: the gusts along the wind have 44% of the variance of intensity 0.1;",
        ),
    ],
)
def test_unusual_wind_is_said(wind, sentence):
    assert any(text.startswith(sentence) for text in example3(**wind).warnings)


def test_a_curve_that_does_not_hold_from_the_other_side_is_refused():
    words = (
        r"ice\.attack_angle_deg = 180\.0, 180 deg more in wind from the other side \(wind\.speed or"
        r" wind\.direction_deg\), is outside"
    )
    for wind in ({"speed": -5.0}, {"speed": 5.0, "direction_deg": 135.0}):
        with pytest.raises(SceneError, match=words):
            load_scene("example3").with_values({"wind": wind})
    both = {"wind": {"speed": -5.0, "direction_deg": 135.0}}
    assert load_scene("example3").with_values(both).wind.turn_deg == 0.0


def test_usual_oblique_and_turbulent_wind_has_no_warning():
    scene = example3(direction_deg=60.0, turbulence=TURBULENCE)
    assert scene.warnings == load_scene("example3").warnings


def test_wind_of_spans():
    spans = [{"length": 100.0, "wind": {"speed": -9.0}}, {"length": 150.0}]
    scene = line(spans)
    assert [scene.wind_of_span(k).mean_value for k in (1, 2)] == [-9.0, 5.0]
    assert "section.spans.0.wind.speed (span 1) reaches -9 m/s: the wind comes" in str(
        scene.warnings
    )
    calm = line([{"length": 100.0}, {"length": 150.0, "wind": {"speed": 2.0}}], speed=0.0)
    assert calm.can_blow
    assert not calm.wind.can_blow


@pytest.mark.parametrize(
    ("span", "wind", "message"),
    [
        (
            {"speed": 9.0, "history": {"kind": "constant", "value": 9.0}},
            {},
            r"section\.spans\.1\.wind \(span 2\): speed = 9\.0 m/s and history are both given",
        ),
        ({}, {}, r"section\.spans\.1\.wind \(span 2\): neither speed \[m/s\] nor history is given"),
        ({"speed": 151.0}, {}, r"section\.spans\.1\.wind\.speed \(span 2\) = 151\.0: must be at"),
        (
            {"speed": 4.0},
            {"speed": None, "table": TABLE},
            r"section\.spans\.1\.wind \(span 2\) and wind\.table are both given; the table has",
        ),
    ],
)
def test_wind_of_spans_that_is_refused(span, wind, message):
    with pytest.raises(SceneError, match=message):
        line([{"length": 100.0}, {"length": 150.0, "wind": span}], **wind)


def test_profiles():
    power = PowerProfile(exponent=0.2, attachment_height=20.0, reference_height=10.0)
    assert power.factor([10.0, 20.0]) == pytest.approx([1.0, 2.0**0.2])
    log = LogarithmicProfile(roughness_length=0.05, attachment_height=20.0)
    assert log.factor([10.0, 0.05]) == pytest.approx([1.0, 0.0])
    # EN 1991-1-4, 4.3.2, terrain II (z0 = 0.05 m): v(20 m)/v(10 m) = ln 400/ln 200.
    assert log.factor(20.0) == pytest.approx(1.1308, abs=1e-4)
    hill = power.model_copy(update={"ground_heights": (0.0, 5.0)})
    assert [points.tolist() for points in hill.ground([0.0, 100.0])] == [[0, 100], [-20, -15]]


def test_time_tables_with_origin_and_repetition():
    table = TimeTable(time=[100, 101, 102], value=[0, 4, 0], origin=100.5)
    assert table.at([0.0, 0.5, 1.5, 9.0]) == pytest.approx([2.0, 4.0, 0.0, 0.0])
    again = table.model_copy(update={"beyond": "repeat"})
    assert again.at([0.0, 2.0, 4.5, -2.0]) == pytest.approx([2.0, 2.0, 4.0, 2.0])
    assert again.run_times.tolist() == [-0.5, 0.5, 1.5]


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([7000, 7001], r"wind\.history: the table begins after the run: it is from 7000 to 7001 s"),
        ([-9, -1], r"ends before the run.*; give wind\.history\.origin.* such as -9"),
    ],
)
def test_time_tables_that_do_not_overlap_the_run(times, message):
    table = {"kind": "table", "time": times, "value": [4.0, 5.0]}
    with pytest.raises(SceneError, match=message):
        example3(speed=None, history=table)
    assert example3(speed=None, history={**table, "origin": times[0]}).wind.mean_speed == 4.5
    assert example3(speed=None, history={**table, "beyond": "repeat"}).wind.mean_speed == 4.5


def test_tables_and_gusts_that_may_end_before_the_run():
    history = {"kind": "table", "time": [5, 6], "value": [4.0, 5.0], "origin": 5}
    scene = example3(speed=None, history=history, turbulence={**TURBULENCE, "duration": 99.0})
    assert list(times_of_tables(scene)) == [
        ("wind.history", 0.0, 1.0, False),
        ("wind.turbulence", 0.0, 99.0, True),
    ]
    assert gusts_of(Wind(speed=5.0), 100.0, 60.0) is None
    calm = Wind(speed=5.0, turbulence={**TURBULENCE, "intensity": 0.0})
    assert gusts_of(calm, 100.0, 60.0) is None
