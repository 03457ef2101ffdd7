"""The command line of modal: what it prints and writes; one readable message for a mistake."""

import json
import subprocess
import sys
from functools import partial

import pytest

import gallop_fmu as gf
import modal
from modal.cli.main import app

COMMANDS = {
    "modes": (),
    "ratio": ("--points", "3"),
    "linear": ("--count", "2", "--highest-wind", "6"),
    "screen": ("--highest-wind", "6"),
    "slope": ("--highest-wind", "6", "--count", "2"),
    "compare": ("--stop-time", "10"),
}
QUICK = ("--set", "numerics.elements=8")


@pytest.fixture
def invoke(invoke):
    """Run a command of gallop-modal in an empty folder."""
    return partial(invoke, app=app)


@pytest.fixture
def scene():
    return gf.load_scene("example3").with_values({"numerics.elements": 8})


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(invoke, command):
    result = invoke(command, "--help")
    assert result.exit_code == 0
    assert f"Example: gallop-modal {command}" in result.stdout


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("as_json", [False, True])
def test_every_command_prints_and_draws(invoke, tmp_path, command, as_json):
    words = [command, "example3", *QUICK, *COMMANDS[command], "--plot", "picture.png"]
    result = invoke(*words, *(["--json"] if as_json else []))
    assert result.exit_code == 0, result.output
    assert (tmp_path / "picture.png").read_bytes()[:4] == b"\x89PNG"
    if as_json:
        assert json.loads(result.stdout)["files"] == ["picture.png"]
    else:
        assert "wrote picture.png" in result.stdout


def test_modes_are_those_of_the_function(invoke, scene):
    for wind in ("still", "mean"):
        printed = json.loads(
            invoke("modes", "example3", *QUICK, "--count", "3", "--wind", wind, "--json").stdout
        )
        expected = modal.natural_modes(scene, 3, wind)
        assert [row["frequency_hz"] for row in printed["modes"]] == [
            mode.frequency_hz for mode in expected
        ]
        assert [row["damping_ratio"] for row in printed["modes"]] == [
            mode.damping_ratio for mode in expected
        ]


def test_the_warnings_of_a_scene_are_printed(invoke):
    round_ice = ("--set", "ice.first_moment_x2=0.0", "--set", "ice.first_moment_x3=0.0")
    done = invoke("modes", "example3", *round_ice, "--json")
    assert done.stderr.startswith(
        "gallop-modal: warning: the first moments of the ice are 0, as for round or no ice"
    )
    assert invoke("modes", "example3").stderr == ""


@pytest.mark.parametrize("command", ["modes", "ratio", "linear"])
def test_the_warnings_of_a_scene_are_in_the_json_too(invoke, command):
    """A program that reads the JSON does not see standard error."""
    round_ice = ("--set", "ice.first_moment_x2=0", "--set", "ice.first_moment_x3=0")
    printed = json.loads(
        invoke(command, "example3", "--json", *QUICK, *round_ice, *COMMANDS[command]).stdout
    )
    (sentence,) = printed["warnings"]
    assert sentence.startswith("the first moments of the ice are 0")


def test_ratio_prints_where_it_is_two(invoke, scene):
    words = ("--over", "span.sag=2.0:2.5", "--points", "3", "--json")
    printed = json.loads(invoke("ratio", "example3", *QUICK, *words).stdout)
    assert printed["ratio"] == modal.frequency_ratio(scene).ratio
    assert printed["crossings"] == modal.crossings(scene, "span.sag", [2.0, 2.25, 2.5])
    assert "raising span.horizontal_tension" in printed["design_changes"][0]


def test_modes_are_followed_over_a_number(invoke, scene, tmp_path):
    words = ("--over", "span.sag=2.0:2.6", "--points", "7", "--count", "4", "--plot", "veer.svg")
    printed = json.loads(invoke("modes", "example3", *QUICK, *words, "--json").stdout)
    expected = modal.track_modes(scene, "span.sag", printed["values"], 4)
    assert printed["values"] == pytest.approx([2.0, 2.1, 2.2, 2.3, 2.4, 2.5, 2.6])
    assert [
        row["frequency_hz"] for row in printed["modes"]
    ] == expected.frequency_hz.values.tolist()
    assert [row["family"][0] for row in printed["modes"]] == [
        "horizontal",
        "vertical",
        "vertical",
        "horizontal",
    ]
    assert "span.sag [m]" in (tmp_path / "veer.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize("given", ["span.sag=2:x", "span.sag=2:3:4:5", "span.sag=3:2:0.5"])
def test_a_range_that_is_none_is_quoted(invoke, given):
    said = invoke("ratio", "example3", "--over", given)
    assert said.exit_code == 2
    assert f"{given}: " in said.stderr


def test_a_ratio_over_two_numbers(invoke, scene, tmp_path):
    words = (
        "--over",
        "span.sag=2,2.25,2.5",
        "--against",
        "temperature_change=-20:20",
        "--points",
        "3",
    )
    words += ("--plot", "map.svg", "--json")
    printed = json.loads(invoke("ratio", "example3", *QUICK, *words).stdout)
    expected = modal.ratio_map(
        scene, "span.sag", [2.0, 2.25, 2.5], against=("temperature_change", [-20.0, 0.0, 20.0])
    )
    assert printed["ratios"] == expected.ratio.values.tolist()
    picture = (tmp_path / "map.svg").read_text(encoding="utf-8")
    assert "temperature_change [K]" in picture
    assert "2:1" in picture


def test_slope_prints_the_slope_that_is_needed(invoke, scene):
    words = ("--highest-wind", "6", "--count", "2", "--json")
    printed = json.loads(invoke("slope", "example3", *QUICK, *words).stdout)
    winds = [0.3 * k for k in range(1, 21)]
    assert printed["wind_speed"] == pytest.approx(winds)
    expected = modal.required_slope(scene, printed["wind_speed"], count=2).dataset
    assert printed["slope"][0] == [None] * 20  # the horizontal mode
    assert printed["slope"][1] == expected.slope.values[1].tolist()
    assert printed["units"]["amplitude_limit"] == "m"


def test_linear_prints_the_critical_wind(invoke, scene):
    printed = json.loads(
        invoke("linear", "example3", *QUICK, "--count", "2", "--highest-wind", "6", "--json").stdout
    )
    expected = modal.critical_wind_speed(scene, 2, 6.0)
    assert [row["wind_speed"] for row in printed["critical_winds"]] == [
        onset.wind_speed for onset in expected
    ]
    assert printed["unstable_attack_angles_deg"]["Den Hartog"][0] == pytest.approx(
        [145.222781, 214.777219]
    )


def test_the_criteria_can_be_drawn(invoke, tmp_path):
    words = ("--count", "1", "--highest-wind", "2", "--show", "criteria", "--plot", "criteria.svg")
    assert invoke("linear", "example3", *QUICK, *words).exit_code == 0
    assert "Den Hartog" in (tmp_path / "criteria.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("modes", "example9"), "no packaged scene and no file has this name"),
        (("modes", "example3", "--count", "0"), "count = 0"),
        (("modes", "example3", "--plot", "modes.gif"), "must end in .png"),
        (("ratio", "example3", "--over", "span.width"), "span.width"),
        (("ratio", "example3", "--over", "supports.stiffness_x1"), "supports.left.stiffness_x1"),
        (("linear", "example1"), "no aerodynamics"),
        (("linear", "example3", "--highest-wind", "-1"), "highest_wind = -1"),
    ],
)
def test_mistakes_end_in_one_message(invoke, words, message):
    result = invoke(*words)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert message in result.stderr
    assert "Traceback" not in result.output


def test_heavy_packages_wait_until_they_are_needed():
    heavy = "control", "matplotlib", "scipy", "xarray"
    code = f"import sys, modal.cli.main; print([name for name in {heavy} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_screen_prints_the_risk_and_its_onset(invoke, scene):
    printed = json.loads(
        invoke("screen", "example3", *QUICK, "--highest-wind", "6", "--json").stdout
    )
    expected = modal.screen(scene, 6.0)
    assert (printed["risk"], printed["onset_wind_speed"]) == ("certain", expected.onset_wind_speed)
    assert printed["ratio"] == expected.frequencies.ratio
    assert printed["saturated"]["horizontal"] == expected.saturated.horizontal


def test_compare_sets_three_models_side_by_side(invoke):
    printed = json.loads(
        invoke("compare", "example3", *QUICK, "--stop-time", "10", "--json").stdout
    )
    assert list(printed["models"]) == ["nonlinear", "superposition", "linear"]


def test_compare_sets_models_of_a_line_side_by_side(invoke, line, tmp_path):
    picture = tmp_path / "compare.png"
    options = ("compare", "line.toml", "--stop-time", "4")
    printed = json.loads(invoke(*options, "--plot", str(picture), "--json").stdout)
    assert list(printed["models"]) == ["nonlinear", "superposition", "linear"]
    assert [row["span"] for row in printed["models"]["linear"]["spans"]] == [1, 2]
    assert picture.stat().st_size > 20_000
    shown = invoke(*options).stdout
    assert "span 1:" in shown
    assert "span 2:" in shown


def test_compare_prints_each_warning_once(invoke):
    scene = (
        "compare",
        "example3",
        *QUICK,
        "--set",
        "span.sag=none",
        "--set",
        "span.horizontal_tension=400",
    )
    done = invoke(*scene, "--stop-time", "10")
    assert done.exit_code == 0, done.output
    lines = (done.stdout + done.stderr).splitlines()
    warned = [line.partition(": ")[2] for line in lines if "warning" in line.partition(": ")[0]]
    assert any("span.horizontal_tension = 400 N is small" in sentence for sentence in warned)
    assert len(set(warned)) == len(warned)


def test_the_ratio_of_a_steep_span_is_printed_though_it_is_not_known_at_every_tension(invoke):
    steep = (
        "ratio",
        "zebra",
        "--set",
        "span.height_difference=300",
        "--set",
        "numerics.elements=12",
    )
    done = invoke(*steep)
    assert done.exit_code == 0, done.output
    assert "14.8% above 2:1" in done.stdout
    assert (
        "values at which the ratio is 2 cannot be listed: at span.horizontal_tension = "
        in done.stdout
    )
    numbers = json.loads(invoke(*steep, "--json").stdout)
    assert numbers["ratio"] == pytest.approx(2.296, abs=1e-3)  # see tests/analytic/test_modes.py
    assert numbers["crossings"] is None


LINE = """
title = "Two spans"
[section]
horizontal_tension = 21730.0
spans = [{length = 125.0}, {length = 110.0}]
suspensions = [{kind = "string", length = 2.1, weight = 490.0}]
[conductor]
diameter = 0.0286
mass_per_length = 1.53
axial_stiffness = 13.3e6
torsional_stiffness = 101.0
torsional_inertia = 3.3e-4
[wind]
speed = 4.0
[aerodynamics]
kind = "polynomial"
valid_from_deg = -60.0
valid_to_deg = 60.0
lift = [0.0, -2.0]
drag = [1.0]
moment = [0.0]
[damping]
translation = {low_ratio = 0.005, low_frequency = 0.3, high_ratio = 0.005, high_frequency = 2.0}
twist = {low_ratio = 0.02, low_frequency = 1.0, high_ratio = 0.02, high_frequency = 5.0}
[numerics]
elements = 4
"""
LINE_COMMANDS = {
    "modes": ("--count", "6"),
    "ratio": (),
    "linear": ("--count", "2", "--highest-wind", "2"),
    "slope": ("--count", "2", "--highest-wind", "2"),
}


@pytest.fixture
def line(tmp_path):
    (tmp_path / "line.toml").write_text(LINE, encoding="utf-8")
    return gf.load_scene(tmp_path / "line.toml")


@pytest.mark.parametrize("command", LINE_COMMANDS)
def test_commands_print_and_draw_a_line(invoke, tmp_path, line, command):
    words = [command, "line.toml", *LINE_COMMANDS[command]]
    printed = invoke(*words, "--plot", "picture.png")
    assert printed.exit_code == 0, printed.output
    assert "wrote picture.png" in printed.stdout
    assert (tmp_path / "picture.png").read_bytes()[:4] == b"\x89PNG"
    data = json.loads(invoke(*words, "--json").stdout)
    assert data["title"] == "Two spans"
    if command == "modes":
        wanted = modal.natural_modes(line, 6)
        assert [m["frequency_hz"] for m in data["modes"]] == [m.frequency_hz for m in wanted]
        assert [m["loops"] for m in data["modes"]] == [list(m.loops) for m in wanted]
        assert "tension-neutral" in printed.stdout
    if command == "ratio":
        wanted = modal.frequency_ratio(line)
        assert [pair["sentence"] for pair in data["pairs"]] == [p.sentence for p in wanted]
        matter = [pair for pair in wanted if pair.matters]
        assert (wanted[0].sentence in printed.stdout) == bool(matter)
        assert ("no pair matters; the nearest are:" in printed.stdout) == (not matter)
        rows = [row for row in printed.stdout.splitlines() if row.startswith((" 2:1 ", " 1:1 "))]
        assert len(rows) == min(len(matter), 20) if matter else min(len(wanted), 5)
    if command == "slope":
        assert sum(data["span_share"][0]) == pytest.approx(1.0)
        assert len(data["slope"]) == len(data["mode"])
    if command == "linear":
        assert [span["span"] for span in data["spans"]] == [1, 2]
        assert "span 2, 0.0 deg: unstable by Den Hartog" in printed.stdout


def test_a_line_has_no_options_and_commands_of_one_span(invoke, line):
    refused = {
        ("modes", "--over", "wind.speed"): "--over is for scenes of one span",
        ("ratio", "--against", "wind.speed"): "--against is for scenes of one span",
        ("linear", "--show", "criteria"): "--show criteria is for scenes of one span",
        ("screen", "--plot", "a.svg"): "--plot draws one span",
    }
    for (command, *options), message in refused.items():
        result = invoke(command, "line.toml", *options)
        assert result.exit_code == 2
        assert message in result.stderr
