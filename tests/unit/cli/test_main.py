"""The command line: what it prints, writes and returns; one readable message for a mistake."""

import json
from pathlib import Path

import h5netcdf
import numpy as np
import pytest

from gallop_fmu.cli import terminal
from gallop_fmu.input.scene_files import packaged_scenes

COMMANDS = ("scenes", "conductors", "curves", "new", "run", "export", "check", "demo")
LEAVES_THE_CURVE = (
    "--set",
    "aerodynamics.valid_to_deg=181",
)  # example 3 gallops out of this range at 119 s


def _refused(result, *fragments, code=2):
    assert result.exit_code == code
    assert result.stdout == ""
    for fragment in fragments:
        assert fragment in result.stderr
    assert "Traceback" not in result.output


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(invoke, command):
    result = invoke(command, "--help")
    assert result.exit_code == 0
    assert f"Example: gallop-fmu {command}" in result.stdout


def test_help_lists_the_exit_codes(invoke):
    text = " ".join(invoke("--help").stdout.split())
    for meaning in ("0: success", "1: the calculation ended early", "2: invalid input"):
        assert meaning in text


def test_version(invoke):
    from importlib.metadata import version

    assert invoke("--version").stdout == f"gallop-fmu {version('gallop-fmu')}\n"


def test_scenes(invoke):
    assert json.loads(invoke("scenes", "--json").stdout) == packaged_scenes()
    listed = invoke("scenes").stdout
    assert all(name in listed for name in packaged_scenes())


@pytest.mark.parametrize(
    "command", [["run", "example3"], ["sweep", "example3", "--over", "wind.speed=4:5:1"]]
)
def test_the_model_that_was_removed_is_refused(invoke, command):
    _refused(
        invoke(*command, "--model", "condensed", "--stop-time", 1),
        "removed in 0.2.0",
        "remove the option",
    )
    _refused(
        invoke(*command, "--model", "other", "--stop-time", 1),
        "model = 'other': must be \"element\"",
    )
    assert invoke(*command, "--model", "element", "--stop-time", 1).exit_code == 0


def test_run_prints_the_motion(invoke):
    result = invoke("run", "example1", "--stop-time", 2)
    assert result.exit_code == 0
    for expected in (
        "sag 4.050 m",
        "horizontal tension 4.583 kN",
        "vertical u2 [m]",
        "800 steps",
        "lowest tension",
    ):
        assert expected in result.stdout
    assert result.stderr == ""


def test_every_printer_shows_the_warnings_of_a_run(invoke):
    """A rough start with steps of several axial periods, which are halved often."""
    rough = {"initial.seed_vertical": 0.3, "initial.seed_twist": 0.2, "numerics.time_step": 0.2}
    words = ["example3", "--set", "aerodynamics.outside=hold"]
    for key, value in rough.items():
        words += ["--set", f"{key}={value}"]
    shown = invoke("run", *words, "--stop-time", 20)
    assert shown.exit_code == 0
    assert "warning: The time step is too long for this motion" in shown.stdout
    printed = json.loads(invoke("run", *words, "--stop-time", 20, "--json").stdout)
    assert any("halved" in sentence for sentence in printed["warnings"])
    assert printed["message"] == "completed at 20 s"
    swept = invoke("sweep", *words, "--over", "wind.speed=5", "--stop-time", 20, "--json")
    assert "halved" in json.loads(swept.stdout)["rows"][0]["warnings"]


def test_run_as_json(invoke):
    result = invoke("run", "example1", "--stop-time", 2, "--json")
    numbers = json.loads(result.stdout)
    assert numbers["outcome"] == "completed"
    assert numbers["midspan"]["u3"]["amplitude"] > 0.1
    assert numbers["files"] == []
    assert result.stderr == ""


def test_run_writes_the_requested_files(invoke):
    result = invoke(
        "run",
        "example1",
        "--stop-time",
        1,
        "--record-every",
        20,
        "--record-nodes",
        "all",
        "--out",
        "a.nc",
        "--plot",
        "a.svg",
    )
    assert result.exit_code == 0
    assert "wrote a.nc" in result.stdout
    with h5netcdf.File("a.nc", "r") as file:
        assert file.dimensions["time"].size == 21
        assert file.dimensions["node"].size == 41
        assert file["u2"].attrs["units"] == "m"
    assert Path("a.svg").read_text().startswith("<?xml")


def test_brackets_are_printed_as_they_are(invoke):
    result = invoke(
        "run", "example1", "--stop-time", 0.1, "--set", "title=A [bold] span", "--out", "[red]a.nc"
    )
    assert "A [bold] span" in result.stdout
    assert "wrote [red]a.nc" in result.stdout


def test_json_has_no_nan(capsys):
    terminal.echo_json({"value": [float("nan"), float("inf"), 1.0]})
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == {
        "value": [None, None, 1.0]
    }


def test_run_writes_csv(invoke):
    assert invoke("run", "example1", "--stop-time", 0.1, "--out", "a.csv").exit_code == 0
    assert Path("a.csv").read_text().startswith("time [s],u1 [m]")
    assert np.loadtxt("a.csv", delimiter=",", skiprows=1).shape[0] == 41


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("wind.speed=6", ("wind.speed", 6)),
        ("wind.speed = 6.5", ("wind.speed", 6.5)),
        ("aerodynamics.outside=hold", ("aerodynamics.outside", "hold")),
        ('aerodynamics.outside="hold"', ("aerodynamics.outside", "hold")),
        ("aerodynamics.lift=[0.0, -1]", ("aerodynamics.lift", [0.0, -1])),
        ('supports.left={kind="rigid"}', ("supports.left", {"kind": "rigid"})),
        ("span.sag=none", ("span.sag", None)),
        ("wind.speed=6\nx=1", ("wind.speed", "6\nx=1")),
    ],
)
def test_values_are_read_as_toml(text, expected):
    assert terminal._change(text) == expected


def test_a_whole_number_does_for_a_wind_speed(invoke):
    scene = terminal.chosen_scene(
        "example3", ["wind.speed=6", "aerodynamics.lift=[0, -4, 0, 3]", "span.sag=none"]
    )
    assert scene.wind.speed == 6.0
    assert isinstance(scene.wind.speed, float)
    assert scene.aerodynamics.lift == (0.0, -4.0, 0.0, 3.0)
    assert scene.span.sag is None


@pytest.mark.parametrize(
    ("words", "fragments"),
    [
        (["exmple1"], ["exmple1: no packaged scene", "closest: example1"]),
        (["nowhere.toml"], ["nowhere.toml: no such file"]),
        (["."], ["not a"]),
        (
            ["example3", "--set", "wind.sped=6"],
            ["wind.sped: unknown key; the closest valid one is wind.speed"],
        ),
        (
            ["example3", "--set", "wind.speed=fast"],
            ["wind.speed = 'fast': must be a finite number"],
        ),
        (["example3", "--set", "wind.speed=nan"], ["wind.speed = 'nan': must be a finite number"]),
        (["example3", "--set", "wind.speed"], ["--set wind.speed: must be KEY=VALUE"]),
        (["example3", "--set", "=6"], ["must be KEY=VALUE"]),
        (
            ["example3", "--set", "wind.speed=6", "--set", "wind.speed=7"],
            ["--set wind.speed: given twice"],
        ),
        (
            ["example3", "--set", "wind.speed=2024-01-01"],
            ["wind.speed = '2024-01-01'", "convert times to seconds"],
        ),
        (
            ["example3", "--stop-time", "1e12"],
            ["stop_time = 1e+12 s is 1e+14 time steps of 0.01 s; a run has at most"],
        ),
        (
            ["example3", "--set", "numerics.elements=15.5"],
            ["numerics.elements = 15.5: must be a whole number"],
        ),
        (
            ["example3", "--set", "ice.attack_angle_deg=20"],
            ["ice.attack_angle_deg = 20.0 is outside", "100.0 to 260.0"],
        ),
        (["example3", "--set", "span.sag=3.0"], ["span.sag = 3.0 m", "contradict"]),
        (["example1", "--stop-time", -1], ["stop_time = -1.0: must be a positive number"]),
        (["example1", "--stop-time", "soon"], ["--stop-time"]),
        (["example1", "--record-every", 0], ["record_every = 0: must be a whole number"]),
        (
            ["example1", "--stop-time", 10, "--record-every", 5000],
            [
                "first record would be at 12.5 s, after the end of the run at 10 s; at most 4000"
                " steps"
            ],
        ),
        (["example1", "--record-nodes", "some"], ["--record-nodes", "some"]),
        (["example1", "--out", "a.txt"], ["a.txt: must end in .nc or .csv"]),
        (["example1", "--out", "none/a.nc"], ["none/a.nc: there is no folder none"]),
        (["example1", "--plot", "a.gif"], ["a.gif: must end in .png or .svg or .pdf"]),
        ([], ["SCENE"]),
    ],
)
def test_run_refuses(invoke, words, fragments):
    _refused(invoke("run", *words), *fragments)
    assert list(Path().iterdir()) == []


def test_run_refuses_a_folder_as_output(invoke):
    Path("a.nc").mkdir()
    _refused(invoke("run", "example1", "--out", "a.nc"), "a.nc: is a folder")


def test_run_that_ends_early_keeps_its_records(invoke):
    result = invoke("run", "example3", *LEAVES_THE_CURVE, "--out", "a.nc", "--plot", "a.png")
    assert result.exit_code == 1
    assert "the attack angle left the validity range" in result.stderr
    assert 'set aerodynamics.outside to "hold"' in result.stderr
    assert "The run ended early; the results until then are in a.nc, a.png." in result.stderr
    with h5netcdf.File("a.nc", "r") as file:
        assert file.attrs["outcome"] == "angle_out_of_range"
        assert 100.0 < file["time"][-1] < 2500.0


def test_run_that_ends_early_as_json(invoke):
    result = invoke("run", "example3", *LEAVES_THE_CURVE, "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["outcome"] == "angle_out_of_range"
    assert "nothing was written" in result.stderr


def test_run_that_fails_at_once_is_drawn_too(invoke):
    result = invoke(
        "run", "example3", "--set", "aerodynamics.valid_to_deg=180.0001", "--plot", "a.png"
    )
    assert result.exit_code == 1
    assert Path("a.png").stat().st_size > 0


def test_scene_without_equilibrium(invoke):
    result = invoke("run", "example3", "--set", "aerodynamics.valid_to_deg=180")
    _refused(result, "At 0 s", "What to do", code=1)


def test_export_and_check(invoke):
    result = invoke("export", "example1", "-o", "a.fmu", "--set", "numerics.elements=4", "--json")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout) == {
        "file": "a.fmu",
        "bytes": Path("a.fmu").stat().st_size,
        "runtime": "native",
    }
    checked = invoke("check", "a.fmu", "--json")
    assert checked.exit_code == 0, checked.output
    assert all(row["ok"] for row in json.loads(checked.stdout))


def test_check_shows_failures(invoke):
    Path("a.fmu").write_text("not an archive")
    result = invoke("check", "a.fmu")
    assert result.exit_code == 1
    assert "FAILED" in result.stdout
    assert "a.fmu: 1 of 1 checks failed: archive" in result.stderr
    assert not json.loads(invoke("check", "a.fmu", "--json").stdout)[0]["ok"]


@pytest.mark.parametrize(
    ("words", "fragments"),
    [
        (["check", "a.fmu"], ["a.fmu: no such file"]),
        (["check", "."], [".: not a file"]),
        (["export", "example1", "-o", "a.zip"], ["a.zip", ".fmu"]),
        (["export", "example1", "-o", "none/a.fmu"], ["none/a.fmu", "folder none"]),
        (["export", "example1", "-o", "a.fmu", "--runtime", "rust"], ["--runtime", "rust"]),
        (["export", "exmple1", "-o", "a.fmu"], ["closest: example1"]),
        (["check", "example1"], ["no such file; gallop-fmu export SCENE -o FILE.fmu writes"]),
        (
            ["sweep", "example1"],
            ["nothing to vary: give --over, such as --over wind.speed=4:7:0.5, or --table"],
        ),
        (["sweep", "--over", "wind.speed=4,5"], ["no scene: give SCENE, or a --table"]),
        (
            ["sweep", "example1", "--over", "wind.speed=4", "--cluster", "here"],
            ["cluster = 'here'", "port"],
        ),
        (["gallop"], ["gallop"]),
    ],
)
def test_other_commands_refuse(invoke, words, fragments):
    _refused(invoke(*words), *fragments)
    assert list(Path().iterdir()) == []


def test_demo_into_a_file(invoke):
    Path("taken").write_text("")
    _refused(invoke("demo", "--out-dir", "taken"), "taken: is a file; --out-dir takes a folder")
