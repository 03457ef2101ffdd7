"""The commands that start from a line: `conductors`, `new`, and `run --inputs`."""

import json

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.cli.line_commands import NEW_EXAMPLE
from gallop_fmu.line.conductors import conductors
from gallop_fmu.line.line_table import Line


def test_conductors_are_listed(invoke):
    shown = invoke("conductors").stdout
    assert all(name in shown for name in conductors())
    (drake,) = (
        row
        for row in json.loads(invoke("conductors", "--json").stdout)
        if row["code_word"] == "Drake"
    )
    assert drake["rated_strength"] == 140120.0
    assert "ASTM B232" in drake["source"]


def test_the_example_of_the_help_writes_a_scene_that_runs(invoke, tmp_path):
    done = invoke(*NEW_EXAMPLE.split()[1:])
    assert (done.exit_code, done.stderr) == (0, "")
    line = {"conductor": "Drake", "span": 300.0, "stringing_percent": 20.0, "ice_thickness": 0.012}
    line |= {"attack_angle_deg": 10.0, "wind_speed": 4.0}
    assert gf.load_scene(tmp_path / "mine.toml") == gf.Scene.from_dict({"line": line})
    assert invoke("run", "mine.toml", "--stop-time", "1").exit_code == 0


def test_a_scene_that_contradicts_itself_is_warned_of_by_new_and_run(invoke):
    curve = ("--coefficients", "example3", "--attack-angle-deg", "180")
    done = invoke(*NEW_EXAMPLE.split()[1:], "--ice-shape", "radial", *curve)
    assert "warning: the first moments of the ice are 0" in done.stdout
    ran = invoke("run", "mine.toml", "--stop-time", "1")
    assert (ran.exit_code, ran.stdout.count("warning: the first moments of the ice are 0")) == (
        0,
        1,
    )
    numbers = json.loads(invoke("run", "mine.toml", "--stop-time", "1", "--json").stdout)
    assert numbers["warnings"][0].startswith("the first moments of the ice are 0")
    exported = invoke("export", "mine.toml", "-o", "mine.fmu", "--runtime", "python")
    assert exported.stderr.count("warning: the first moments of the ice are 0") == 1


def test_every_field_of_a_line_is_an_option(invoke):
    shown = invoke("new", "--help").stdout
    assert all(f"--{name.replace('_', '-')}" in shown for name in Line.model_fields)
    assert f"Example: {NEW_EXAMPLE}" in " ".join(shown.split())


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (
            ("a.toml", "--conductor", "Drak", "--stringing-tension", 2e4),
            "line.conductor: 'Drak' is not a code word",
        ),
        (
            ("a.toml", "--conductor", "Drake"),
            "line: neither of stringing_tension [N] and stringing_percent",
        ),
        (("a.json", "--conductor", "Drake"), "a.json: must end in .toml"),
        (("here.toml", "--conductor", "Drake"), "here.toml: exists already"),
    ],
)
def test_new_refuses(invoke, tmp_path, words, fragment):
    (tmp_path / "here.toml").write_text("mine")
    done = invoke("new", *words, "--span", 300)
    assert (done.exit_code, done.stdout) == (2, "")
    assert fragment in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["here.toml"]


def test_run_is_driven_by_inputs(invoke, tmp_path):
    (tmp_path / "in.csv").write_text("time,wind_speed\n0,1\n1,3\n")
    done = invoke("run", "example3", "--stop-time", 1, "--inputs", "in.csv", "--out", "run.csv")
    assert done.exit_code == 0
    rows = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True, deletechars="")
    assert rows["wind_speed_[m/s]"][-1] == pytest.approx(3.0)
    assert np.ptp(rows["wind_speed_[m/s]"]) == pytest.approx(2.0)
    refused = invoke("run", "example3", "--inputs", "no.csv")
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert "no.csv: no such file" in refused.stderr


def test_new_writes_a_section_from_a_table_of_towers(invoke, tmp_path):
    (tmp_path / "towers.csv").write_text("tower,span\nA,300\nB,350\nC,\n")
    words = ("new", "line.toml", "--section", "towers.csv", "--conductor", "Drake")
    strings = ("--insulator-length", 2.4, "--insulator-weight", 600, "--stringing-percent", 20)
    bundle = ("--subconductors", 2, "--spacing", 0.4, "--spacers", 5, "--orientation", "vertical")
    done = invoke(*words, *strings, *bundle)
    assert (done.exit_code, done.stderr) == (0, "")
    line = gf.load_scene(tmp_path / "line.toml")
    assert isinstance(line, gf.LineScene)
    assert (len(line.section.spans), line.bundle.spacers) == (2, 5)
    text = (tmp_path / "line.toml").read_text()
    assert "# span 2" in text
    assert "distance of neighbouring subconductors in a regular polygon [m]" in text


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        ((), "neither --span nor --section is given"),
        (("--span", 300, "--spacers", 3), "--spacers: only a section has it; give --section"),
        (("--section", "no.csv"), "no.csv: no such file"),
    ],
)
def test_new_without_spans_is_refused(invoke, tmp_path, words, fragment):
    done = invoke("new", "a.toml", "--conductor", "Drake", "--stringing-percent", 20, *words)
    assert (done.exit_code, done.stdout) == (2, "")
    assert fragment in " ".join(done.stderr.replace("│", " ").split())
    assert list(tmp_path.iterdir()) == []
