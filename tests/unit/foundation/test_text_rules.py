"""One rule for every text and number that a user gives: files, tables, options, Python."""

import json
import re
import time
import tomllib
import typing
import xml.etree.ElementTree as ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import gallop_fmu as gf
import modal.cli.main
from gallop_fmu.cli.terminal import new_console
from gallop_fmu.fmu.description import Identity, describe
from gallop_fmu.fmu.fmi2_xml import model_description
from gallop_fmu.foundation.text_files import parse_toml, read_table
from gallop_fmu.foundation.text_rules import clean_text, plain, printable, read_number
from gallop_fmu.input.scene_spec import SceneWithLine
from gallop_fmu.scene.dotted_paths import section_classes
from gallop_fmu.scene.fields import Text
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.sweeps.cases import cases, read_spans

ACCEPTED = {".5": 0.5, "2.": 2.0, "05": 5.0, "1e-3": 0.001, "+3": 3.0, "7": 7.0, "2.50E+0": 2.5}
REFUSED = [
    "1_00",
    "１２",
    "2024-01-01",
    "07:30",
    "0x1F",
    "1d2",
    "2,1",
    "1e400",
    "five",
    "inf",
    "--1",
    "1 2",
    "1e",
]
BAD_CHARACTERS = [
    "\0",
    "\x1b",
    "\x85",
    "\x0b",
    "\x1c",
    "\x7f",
    "\ud800",
    "\ufdd0",
    "\ufffe",
    "\U0010ffff",
]


def in_coefficient_file(word, folder):
    (folder / "c.csv").write_text(f"angle_deg,lift,drag,moment\n-9,{word},1,0\n9,0,1,0\n", "utf-8")
    table = {"kind": "table", "file": str(folder / "c.csv")}
    scene = gf.load_scene("example3").with_values({"wind.speed": 0.0, "ice.attack_angle_deg": 0.0})
    return scene.with_values({"aerodynamics": table}).aerodynamics.lift[0]


def in_input_file(word, folder):
    (folder / "i.csv").write_text(f'time,wind_speed\n0,"{word}"\n1,5\n', "utf-8")
    return gf.with_inputs(gf.load_scene("example3"), folder / "i.csv").wind.history.value[0]


def in_span_csv(word, folder):
    (folder / "s.csv").write_text(f'name,wind.speed\nA,"{word}"\n', "utf-8")
    return cases("example3", table=folder / "s.csv").every[0].scene().wind.speed


def in_geojson(word, folder):
    feature = {"properties": {"wind.speed": word}}
    (folder / "s.geojson").write_text(
        json.dumps({"type": "FeatureCollection", "features": [feature]}), "utf-8"
    )
    return cases("example3", table=folder / "s.geojson").every[0].scene().wind.speed


def in_data_frame(word, folder):
    return cases("example3", table=pd.DataFrame({"wind.speed": [word]})).every[0].scene().wind.speed


def in_scene_file(word, folder):
    text = gf.load_scene("example3").to_toml()
    (folder / "s.toml").write_text(
        re.sub(r"(?m)^speed = .*$", f"speed = {word}  # m/s", text), "utf-8"
    )
    return gf.load_scene(folder / "s.toml").wind.speed


def in_over(word, folder):
    from gallop_fmu.cli.sweep_options import grid_of

    return cases("example3", grid_of([f"wind.speed={word}"])).every[0].scene().wind.speed


def in_set(word, folder):
    from gallop_fmu.cli.terminal import chosen_scene

    return chosen_scene("example3", [f"wind.speed={word}"]).wind.speed


PLACES = [
    in_coefficient_file,
    in_input_file,
    in_span_csv,
    in_geojson,
    in_data_frame,
    in_scene_file,
    in_over,
    in_set,
]


@pytest.mark.parametrize("place", PLACES)
def test_the_same_words_are_numbers_everywhere(place, tmp_path):
    assert {word: place(word, tmp_path) for word in ACCEPTED} == ACCEPTED


# In a coefficient file and after --over a comma separates two numbers.
REFUSALS = [
    (p, w)
    for p in PLACES
    for w in REFUSED
    if "," not in w or p not in (in_coefficient_file, in_over)
]


@pytest.mark.parametrize(("place", "word"), REFUSALS)
def test_the_same_words_are_refused_everywhere(place, word, tmp_path):
    with pytest.raises(
        gf.SceneError, match=r"finite number|a range is|not a TOML file|is not a number"
    ):
        place(word, tmp_path)


@pytest.mark.parametrize("word", ["1_0", "１", "0x1", "2024-01-01"])
def test_options_take_the_same_words(invoke, word):
    commands = (
        ("run", "example3", "--stop-time", word),
        ("run", "example3", "--record-every", word),
        ("sweep", "example3", "--over", "wind.speed=5", "--workers", word),
        ("new", "m.toml", "--conductor", "Drake", "--span", word, "--stringing-percent", "20"),
    )
    for command in commands:
        result = invoke(*command)
        assert result.exit_code == 2
        assert "is not a number" in result.stderr
    assert (
        "is not a number"
        in invoke("linear", "example3", "--highest-wind", word, app=modal.cli.main.app).stderr
    )


def test_options_accept_numbers_as_other_programs_write_them(invoke):
    assert invoke("run", "example1", "--stop-time", "0.5", "--record-every", "+05").exit_code == 0
    assert invoke("run", "example1", "--stop-time", ".5").exit_code == 0
    assert (
        "not a whole number"
        in invoke("run", "example1", "--stop-time", "1", "--record-every", "1.5").stderr
    )


def test_texts_that_are_numbers():
    assert read_number("9223372036854775807") == 2**63 - 1
    assert read_number("9223372036854775808") == 2.0**63  # too large for an array of integers
    assert isinstance(read_number("05"), int)
    assert read_number("nan") is read_number("") is read_number("1e400") is None


@pytest.mark.parametrize(
    ("word", "remedy"),
    [
        ("2024-01-01T00:00:00", "convert times to seconds"),
        ("07:30:00", "convert times to seconds"),
        ("2,1", "write 2.1, with a decimal point"),
        ("1_00", "the digits 0 to 9 only"),
        ("１２", "the digits 0 to 9 only"),
        ("0x1F", "the digits 0 to 9 only"),
        ("1e400", "too large"),
        ("NaN", "allowed only in a table of spans"),
    ],
)
def test_a_word_that_is_no_number_gets_a_remedy(word, remedy, tmp_path):
    for place in (in_input_file, in_span_csv, in_set):
        with pytest.raises(gf.SceneError, match=remedy):
            place(word, tmp_path)


@pytest.mark.parametrize("character", BAD_CHARACTERS)
def test_characters_that_no_file_can_contain_are_refused_everywhere(character, tmp_path):
    """NUL and lone surrogates crash NetCDF; controls and FFFE make invalid XML."""
    text, scene = f"a{character}b", gf.load_scene("example3")
    message = f"U\\+{ord(character):04X}"
    for key in ("title", "description", "sources"):
        with pytest.raises(gf.SceneError, match=rf"^{key}.*{message}"):
            scene.with_values({key: {"span.sag": text} if key == "sources" else text})
    with pytest.raises(gf.SceneError, match=rf"^title: .*{message}"):
        gf.Scene.from_dict({**scene.model_dump(mode="json", exclude_none=True), "title": text})
    for row in (
        {"name": text},
        {"label.note": text},
        {f"label.{text}": "x"},
        {"aerodynamics.outside": text},
    ):
        with pytest.raises(gf.SceneError, match=message):
            cases("example3", table=[row])
        feature = json.dumps({"type": "FeatureCollection", "features": [{"properties": row}]})
        (tmp_path / "s.geojson").write_text(feature, "utf-8")
        with pytest.raises(gf.SceneError, match=message):
            read_spans(tmp_path / "s.geojson")
    with pytest.raises(gf.SceneError, match=message):
        cases("example3", {"aerodynamics.outside": [text]})
    if character == "\0" or "\ud800" <= character <= "\udfff":
        return  # these make no text file
    for suffix, content in (
        (".csv", f"name,span.sag\nA,2.1\n{text},2.1\n"),
        (".toml", f"[span]\n\n# {text}\n"),
    ):
        path = tmp_path / f"s{suffix}"
        path.write_text(content, "utf-8")
        with pytest.raises(gf.SceneError, match=rf"line 3: .*{message}"):
            (read_spans if suffix == ".csv" else gf.load_scene)(path)


def test_text_comes_back_in_normal_form():
    assert (
        clean_text("e\u0301\r\nline\ttwo\u2028\U0001f600 '$x_{$'")
        == "é\nline\ttwo\u2028\U0001f600 '$x_{$'"
    )


def parts(annotation):
    """Types within an annotation, except those of the checked text."""
    if annotation != Text:
        yield annotation
        for argument in typing.get_args(annotation):
            yield from parts(argument)


def test_every_text_of_a_scene_follows_the_rule():
    """Each field of type str in any section has the checked type."""
    seen, left = set(), [SceneWithLine, LineScene]
    while left:
        section = left.pop()
        if section in seen:
            continue
        seen.add(section)
        for name, field in section.model_fields.items():
            annotation = typing.get_type_hints(section, include_extras=True)[name]
            assert str not in list(parts(annotation)), (section, name)
            left += section_classes(field.annotation)
    assert len(seen) > 20


def test_the_xml_of_an_fmu_is_valid_for_any_title():
    every = [chr(code) for code in range(0x20, 0x11000)] + [
        "\t",
        "\n",
        "\U0001f600",
        "\U000e0041",
        "\U0010fffd",
    ]
    title = ""
    for character in every:
        try:
            title += clean_text(character)
        except gf.SceneError:
            continue
    assert len(title) > 60_000
    scene = gf.load_scene("example3").with_values({"title": title, "description": title})
    description = describe(scene, "")
    xml = model_description(scene, description, [], Identity("0" * 64), native=True)
    assert ElementTree.fromstring(xml).get("modelName") == " ".join(scene.title.split())


def test_terminals_get_no_control_sequences(capsys):
    console = new_console()
    console.print("\x1b]0;OWNED\x07\x1b[2J :warning: [bold]x")
    from gallop_fmu.cli.terminal import complain, new_table

    table = new_table("\x1b[2J")
    table.add_row("\x9b31m")
    console.print(table)
    complain("no file \x1b[2J")
    shown = "".join(capsys.readouterr())
    assert not {"\x1b", "\x07", "\x9b"} & set(shown)
    assert r"\x1b]0;OWNED\x07\x1b[2J :warning: [bold]x" in shown
    assert printable("Ω é \U0001f600\n") == "Ω é \U0001f600\n"


@pytest.mark.parametrize("title", [r"tower $x_{$", r"$\frac{$", "cost: 3 $ to 5 $"])
def test_a_dollar_sign_in_a_title_is_no_mathematics(title, tmp_path):
    from gallop_fmu.plots import overview, save_figure
    from modal import natural_modes
    from modal.plots.span_figures import mode_shapes

    scene = gf.load_scene("example1").with_values({"title": title})
    figures = [overview(gf.simulate(scene, 0.5)), mode_shapes(natural_modes(scene, 2), title)]
    for figure in figures:
        assert isinstance(figure, Figure)
        assert title.split("$")[-1] in save_figure(figure, tmp_path / "a.SVG").read_text("utf-8")


def test_values_in_memory_become_plain_data():
    import datetime
    import decimal

    assert plain({"a": (np.float64(1.5), np.int32(2), np.array([1, 2]))}) == {"a": [1.5, 2, [1, 2]]}
    assert plain(decimal.Decimal("1.5")) == 1.5
    assert plain(10**400) == np.inf
    assert plain(2**63) == 2.0**63
    assert plain(datetime.date(2024, 1, 1)) == "2024-01-01"


def test_tables_of_numbers_may_be_written_in_many_ways(tmp_path):
    path, units = tmp_path / "t.CSV", {"time": "s", "wind_speed": "m/s"}
    texts = [
        "time,wind_speed\n0,5\n1,6\n",
        "Time [s],Wind_Speed (m/s)\n0,5\n1,6\n",
        "time;wind_speed\n0;5\n1;6\n",
        "sep=;\ntime;wind_speed\n0;5\n1;6\n",
        "time\twind_speed\n0\t5\n1\t6\n",
        "# of 2024, by hand\n\nwind_speed,time\n5,0\n# a gust\n6,1\n",
        '"time","wind_speed",,\r\n0,5,,\r\n\r\n1,6,,\r\n,,,\r\n',
        "time,wind_speed\r0,5\r1,6\r",
    ]
    for text in texts:
        for encoding in ("utf-8", "utf-8-sig", "utf-16"):
            path.write_bytes(text.encode(encoding))
            assert dict(read_table(path, units).columns) == {
                "time": (0.0, 1.0),
                "wind_speed": (5.0, 6.0),
            }


XFOIL = """
       XFOIL         Version 6.99

 Calculated polar for: NACA 0012

   alpha    CL        CD       CDp       CM
  ------ -------- --------- --------- --------
  -5.000  -0.5421   0.00935   0.00363   0.0019
"""


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (XFOIL, "not separated by commas, semicolons or tabs; save it as CSV"),
        ("Xfoil polar. Reynolds number fixed.\nAlpha,Cl,Cd\n", "put # before lines of text above"),
        (
            "Alpha,Cl,Cd,Cdp,Cm\n-5,0,0,0,0\n",
            "it has 'Alpha'. Rename the columns, remove those that are not needed",
        ),
        ("! AeroDyn airfoil data\n  1  ReRef\n", "not separated by commas"),
        ('<?xml version="1.0"?>\n<gpx></gpx>\n', "an XML or HTML file; export the table as CSV"),
        (
            "time,wind_speed\n2024-01-01T00:00:00Z,5\n",
            "convert times to seconds from the start of the run",
        ),
        ("time;wind_speed\n0;5,5\n", "write 5.5, with a decimal point"),
        ("time [ms],wind_speed\n0,5\n", "column 'time \\[ms\\]' must be in s; convert it"),
        ("time,wind_speed\n0,5\n1\n", "row 3 has 1 cells, 2 are required"),
        ("time,wind_speed,Wind_Speed\n0,4,9\n", "column 'wind_speed' is given twice"),
        (b"\xff\xfe\x00", "not a text file in UTF-8"),
        ("Höhe,1\n".encode("cp1252"), "save it as UTF-8"),
        (
            "time,wind_speed\n0,5\n".encode("utf-16-le"),
            "UTF-16 needs a byte order mark",
        ),
        ('time,wind_speed\n0,"5\n1,6\n', "not a CSV file in row 2 .*close each quotation mark"),
    ],
)
def test_foreign_files_get_a_remedy(content, message, tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(gf.SceneError, match=message):
        read_table(path, {"time": "s", "wind_speed": "m/s"})


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("0,-1,-0.1,0", "drag = -0.1 at 0.0 deg: drag acts along the wind and is never negative"),
        ("0,0,1e300,0", "drag = 1e\\+300 at 0.0 deg: a coefficient is at most 10 in magnitude"),
        ("0,30,1,0", "lift = 30.0 at 0.0 deg: a coefficient is at most 10"),
    ],
)
def test_coefficients_of_no_conductor_are_refused(row, message, tmp_path):
    (tmp_path / "c.csv").write_text(f"angle_deg,lift,drag,moment\n{row}\n9,0,1,0\n")
    with pytest.raises(gf.SceneError, match=message):
        gf.load_scene("example3").with_values(
            {"aerodynamics": {"kind": "table", "file": str(tmp_path / "c.csv")}}
        )


def test_a_text_that_looks_like_a_number_stays_a_text(tmp_path):
    from gallop_fmu.cli.sweep_options import grid_of
    from gallop_fmu.cli.terminal import chosen_scene

    assert chosen_scene("example3", ["title=1.10"]).title == "1.10"
    assert chosen_scene("example3", ['title="a, b"']).title == "a, b"
    assert cases("example3", grid_of(["title=07:30,1e3"])).grid == {"title": ["07:30", "1e3"]}
    (tmp_path / "s.csv").write_text("title,aerodynamics.outside\n1_0,hold\n")
    assert cases("example3", table=tmp_path / "s.csv").every[0].scene().title == "1_0"


def test_only_values_of_a_scene_file_are_respelled():
    text = '''a."0.5" = ".5, 05" # 1_0 is .5
b = [ .5, 2., [05, -.5e3], {x = +007.}, "1_0", 'its .5', 1979-05-27 07:32:00, 07:30:00 ]
c = """one ".5"
1_0
\\""" 05"""
d = \'\'\'x = .5
\'\'\'
12 = 0 # "
1_0 = 2024-01-01
[e.05]
f = nan'''
    found = parse_toml(text)
    plain_toml = text.replace(
        "[ .5, 2., [05, -.5e3], {x = +007.}", "[ 0.5, 2.0, [5, -0.5e3], {x = 7.0}"
    )
    expected = tomllib.loads(plain_toml)
    assert {**found, "e": None} == {**expected, "e": None}
    assert type(found["b"][2][0]) is int
    for wrong in ("x = 1_0", "x = [1, 0x1F]", "x = {y = 0b1}", "x = -1_0.5"):
        with pytest.raises(
            gf.SceneError, match=r"line 2: .* is not a number; write the digits 0 to 9 only"
        ):
            parse_toml(f"a = 1\n{wrong} # why")


@pytest.mark.parametrize(
    "text", ['"\\"' * 500_000, "'" * 999_999, '"""' + '"' * 999_999, "1" * 999_999, "=.1," * 99_999]
)
def test_respelling_takes_no_long_time(text):
    began = time.perf_counter()
    with pytest.raises(gf.SceneError):
        parse_toml("a = " + text)
    assert time.perf_counter() - began < 5.0  # observed: 0.2


def test_suffixes_may_be_in_capitals(tmp_path):
    scene = gf.load_scene("example1")
    result = gf.simulate(scene, 0.5)
    for suffix in (".NC", ".Csv", ".PARQUET"):
        assert result.save(tmp_path / f"r{suffix}").stat().st_size > 1000
    assert gf.export_fmu(scene, tmp_path / "s.FMU").stat().st_size > 1000
    curve = "angle_deg,lift,drag,moment\n0,0,1,0\n10,-1,1,0\n"
    (tmp_path / "C.CSV").write_text(curve)
    line = {"conductor": "Drake", "span": 300.0, "stringing_percent": 20.0, "coefficients": "C.CSV"}
    assert gf.Scene.from_dict({"line": line}, tmp_path).aerodynamics.lift == (0.0, -1.0)
