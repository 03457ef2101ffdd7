"""Tables of spans whose scene has a [line]: columns with line data, refusals, fingerprints."""

import tomllib

import pytest

import gallop_fmu as gf
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.scene.scene import Scene
from gallop_fmu.sweeps.cases import cases

LINE = """
[line]
conductor = "Drake"
stringing_percent = 20.0
wind_speed = 4.0
coefficients = "mine.csv"

[numerics]
elements = 8
"""
CURVE = "angle_deg,lift,drag,moment\n0,0,1,0\n10,{lift},1,0\n"


@pytest.fixture
def corridor(table):
    """The path of a scene file with a line that lacks its span, in the folder of its curve."""
    table(CURVE.format(lift=-1), "mine.csv")
    return table(LINE, "corridor.toml")


def test_familiar_numbers_of_a_line_are_columns(table, corridor):
    path = table(
        "name,line.conductor,line.span,line.height_difference,"
        "line.ice_thickness,line.wind_speed,span.gravity\n"
        "A,Drake,300,5,0.012,6,\n"
        "B,Hawk,250,,,,9.8\n"
    )
    first, second = (case.scene() for case in cases(corridor, table=path).every)
    line = {
        "conductor": "Drake",
        "span": 300,
        "height_difference": 5,
        "ice_thickness": 0.012,
        "wind_speed": 6,
    }
    given = {"line": {**tomllib.loads(LINE)["line"], **line}, "numerics": {"elements": 8}}
    assert first == Scene.from_dict(given, corridor.parent)
    assert (second.conductor.diameter, second.span.length) == (
        gf.find_conductor("Hawk").diameter,
        250.0,
    )
    assert (second.span.gravity, second.wind.speed, second.numerics.elements) == (9.8, 4.0, 8)
    # values given explicitly replace those computed from the line, and nothing else
    assert (
        second.span.horizontal_tension
        == cases(corridor, {"line.conductor": ["Hawk"], "line.span": [250.0]})
        .every[0]
        .scene()
        .span.horizontal_tension
    )


def test_a_table_may_contain_the_whole_line(table):
    path = table("line.conductor,line.span,line.stringing_tension\nDrake,300,28000\nHawk,250,\n")
    first, second = cases(None, table=path).every
    assert first.scene().span.horizontal_tension == pytest.approx(28000.0, rel=0.1)
    with pytest.raises(gf.SceneError, match="line: neither of stringing_tension"):
        second.scene()


def test_errors_of_a_line_concern_their_own_run_and_name_the_column(table, corridor):
    path = table(
        "line.conductor,line.span,line.ice_thickness\n"
        "Drak,300,\nDrake,,\nDrake,300,-0.01\nDrake,300,\n"
    )
    messages = [
        "line.conductor: 'Drak' is not a code word of the table; closest: Drake",
        "line.span: missing, must be a finite number greater than 0",
        "line.ice_thickness = -0.01: must be at least 0",
    ]
    every = cases(corridor, table=path).every
    for case, message in zip(every, messages, strict=False):
        with pytest.raises(gf.SceneError, match=f"^{message}"):
            case.scene()
    assert every[3].scene().span.length == 300.0


@pytest.mark.parametrize(
    ("scene", "over", "fragment"),
    [
        (
            "example3",
            {"line.span": [300.0]},
            r"^example3: line.span: the scene has no \[line\] table",
        ),
        (
            gf.load_scene("zebra"),
            {"line.span": [300.0]},
            r"^line.span: the scene has no \[line\] table",
        ),
        (
            None,
            {"line.conductor": ["Drake", "Hawk"]},
            r"corridor.toml: line.span: missing; .* as a column line.span",
        ),
        (None, {"wind.speed": [4.0]}, r"corridor.toml: line.span: missing"),
        (
            None,
            {"line.spam": [4.0]},
            r"^line.spam: unknown key; the closest valid one is line.span",
        ),
        (None, {"line": [{}]}, r"^line: unknown key"),
    ],
)
def test_lines_that_no_row_can_correct_are_refused_at_once(corridor, scene, over, fragment):
    with pytest.raises(gf.SceneError, match=fragment):
        cases(scene or corridor, over)


def test_an_unknown_key_of_the_line_is_refused_at_once(table, corridor):
    wrong = table(LINE.replace("wind_speed", "wind_sped"), "wrong.toml")
    with pytest.raises(
        gf.SceneError, match=r"wrong.toml: line.wind_sped: unknown key; .* line.wind_speed"
    ):
        cases(wrong, {"line.span": [300.0]})


def test_fingerprint_sees_the_line_and_its_curve(table, corridor):
    over = {"line.span": [300.0], "line.coefficients": ["mine.csv", "example2"]}
    prints = [cases(corridor, over).fingerprint()]
    table(LINE.replace("20.0", "21.0"), "corridor.toml")
    prints.append(cases(corridor, over).fingerprint())
    table(CURVE.format(lift=-2), "mine.csv")
    prints.append(cases(corridor, over).fingerprint())
    prints.append(cases(corridor, {"line.span": [300.0]}).fingerprint())
    table(CURVE.format(lift=-3), "mine.csv")
    prints.append(cases(corridor, {"line.span": [300.0]}).fingerprint())
    prints.append(
        cases(
            SceneSpec.of(corridor).with_values({"wind.speed": 3.0}), {"line.span": [300.0]}
        ).fingerprint()
    )
    table(
        LINE.replace("mine.csv", "example2"), "corridor.toml"
    )  # the curve is named in the grid only
    prints.append(cases(corridor, over).fingerprint())
    table(CURVE.format(lift=-4), "mine.csv")
    prints.append(cases(corridor, over).fingerprint())
    assert len(set(prints)) == 8
