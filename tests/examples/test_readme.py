"""What the README says is so: its Python, its numbers, its commands, its links."""

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer

import modal
from gallop_fmu import cli as simulation_cli
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.line_commands import NEW_EXAMPLE
from gallop_fmu.scene_files import load_scene
from modal import cli as modal_cli

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
GALLERY = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
APPS = {"gallop-fmu": simulation_cli.app, "gallop-modal": modal_cli.app}


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


def script(name):
    """A script of the repository as a module."""
    path = ROOT / name
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_python_of_the_readme_prints_what_it_says(tmp_path):
    code, expected = "".join(blocks("python")), "".join(blocks("text"))
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == expected
    assert (tmp_path / "example3.fmu").is_file()


def test_the_table_of_trust_is_what_its_script_wrote():
    """Rows of minutes are those of the last run of the script, which other tests hold to the same sources."""
    trust = script("benchmarks/trust.py")
    written = trust.RECORD.read_text(encoding="utf-8")
    assert written in README
    for row in trust.computed_at_once():
        assert trust.line(*row) in written.splitlines()


def test_the_table_of_screening_is_that_of_the_benchmarks():
    for name, label in (("screening_table", "seen during development"), ("screening_blind", "blind")):
        found = (ROOT / "benchmarks" / f"{name}.md").read_text(encoding="utf-8")
        patterns = (
            r"- right: (\d+)",
            r"- miss: (\d+)",
            r"- false alarm: (\d+)",
            r"- onset wind: largest error ([\d.]+%)",
            r"- threshold: largest error ([\d.]+%)",
        )
        numbers = [re.search(pattern, found)[1] for pattern in patterns]
        assert f"| {label} | {' | '.join(numbers)} |" in README


def test_the_frequency_ratio_is_that_of_the_picture():
    pictures = script("benchmarks/pictures.py")
    scenes = pictures.spans()
    (resonant,) = modal.crossings(scenes["rigid ends"], "span.sag", [2.0, 2.6])
    assert f"the ratio is 2 at a sag of {resonant:.2f} m" in README
    for scene in scenes.values():
        for sag in pictures.SAGS[::8]:
            at = scene.with_values({"span.sag": float(sag)})
            found = modal.frequency_ratio(at).ratio
            assert modal.shallow_cable(at).ratio == pytest.approx(found, rel=1.5e-3)  # observed at most 1.1e-3
    assert "is within 0.1 % of it" in README
    picture = (ROOT / "docs" / "ratio.svg").read_text(encoding="utf-8")
    assert {"Irvine's theory", "rigid ends", "sag [m]"} <= set(re.findall(r"<text[^>]*>([^<]*)</text>", picture))


def test_the_count_of_frequencies_is_right():
    peers = script("tests/peers/test_natural_frequencies.py")
    count = sum(len(found) for table in (peers.VERTICAL, peers.HORIZONTAL) for found in table.values())
    assert count == 60
    assert "Sixty\nmore natural frequencies" in README


def test_errors_of_time_steps_are_those_that_the_example_asserts():
    told = re.findall(r"\| `time_step` [\d.]+ s \| \d+ \| (\+[\d.]+) % \|", README)
    example = (ROOT / "examples" / "14_choosing_a_time_step.py").read_text(encoding="utf-8")
    assert f"== {[f'{error}%' for error in told]}".replace("'", '"') in example
    assert "| about 6900 | less than 0.01 % |" in README
    assert "- 6900) < 100" in example
    assert 'errors["tolerance"][1]) < 1e-4' in example
    assert "Take 50 steps or more in a period" in (ROOT / "docs" / "stability.md").read_text(encoding="utf-8")


def commands():
    text = README.replace("\\\n", " ")
    lines = [line.split("#")[0].strip() for line in text.splitlines() if line.startswith("    gallop-")]
    return [" ".join(line.split()) for line in lines]


@pytest.mark.parametrize("command", commands())
def test_commands_are_understood(command):
    program, name, *words = shlex.split(command)
    known = typer.main.get_command(APPS[program]).commands[name]
    known.make_context(name, words)  # refuses what it does not know


def test_commands_of_a_comment_exist():
    assert NEW_EXAMPLE in commands()
    for name in ("modes", "ratio", "linear", "compare"):
        assert name in typer.main.get_command(modal_cli.app).commands


def test_variables_of_the_table_exist():
    table = re.search(r"\| inputs .*?\n\| parameters", README, re.DOTALL)[0]
    named = {name for name in re.findall(r"`([a-z0-9_.]+)`", table) if name not in ("x3", "v3")}
    assert named <= {variable.name for variable in fmu_variables(load_scene("example3"))}
    assert len(named) >= 12


@pytest.mark.parametrize(("text", "folder"), [(README, ""), (GALLERY, "examples")], ids=["README", "gallery"])
def test_links_and_files_exist(text, folder):
    linked = [target for target in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in target]
    named = re.findall(r"`((?:examples|benchmarks|tests|docs)/[\w./]+)`", text)
    assert len(linked) + len(named) > 5
    for target in linked:
        assert (ROOT / folder / target).exists(), target
    for target in named:
        assert (ROOT / target).exists(), target


def test_the_gallery_shows_every_example():
    scripts = sorted(path.name for path in (ROOT / "examples").glob("*.py"))
    assert re.findall(r"^\| \[(\S+\.py)\]", GALLERY, re.MULTILINE) == scripts


def test_every_number_of_the_gallery_is_asserted():
    """The last column repeats numbers that stand in the example's last cell."""
    for name, numbers in re.findall(r"^\| \[(\S+\.py)\].*\| ([^|]*) \|$", GALLERY, re.MULTILINE):
        last = (ROOT / "examples" / name).read_text(encoding="utf-8").split("# %%")[-1]
        stated = [float(text) for text in re.findall(r"(?<![\w.])\d+\.?\d*(?:e-?\d+)?", numbers)]
        assert stated, name
        known = [float(text) for text in re.findall(r"\d+\.?\d*(?:e-?\d+)?", last)]
        for number in stated:
            assert np.min(np.abs(np.array(known) - number)) <= 1e-9, (name, number)


def test_the_run_times_are_those_of_the_committed_run():
    """`benchmarks/work_precision/run.py` wrote them; only a quiet machine can measure them again."""
    told = (ROOT / "benchmarks" / "work_precision" / "results.md").read_text(encoding="utf-8")
    ratio = {
        name: float(re.search(rf"than {name}: ([\d.]+) times", told)[1]) for name in ("OpenSees", "Radau", "CVODE")
    }
    nearest = [float(text) for text in re.findall(r"next is numba: ([\d.]+) times our cost", told)]
    assert len(nearest) == 6
    text = " ".join(README.split())
    assert f"cost OpenSees {ratio['OpenSees']:.0f} times, scipy's Radau {ratio['Radau']:.0f} times" in text
    assert f"and CVODE {ratio['CVODE']:.0f} times what it costs here" in text
    assert f"took {min(nearest):.1f} to {max(nearest):.1f} times as long at errors from 1e-2 to 1e-7" in text
    speed = (ROOT / "benchmarks" / "README.md").read_text(encoding="utf-8")
    median = float(re.search(r"as packaged \| \d+ \| (\d+) \|", speed)[1])
    assert f"runs some {round(median, -2):.0f} times faster than real time" in text
    assert re.search(r"\| 0\.01 \| [\d.]+ \| \+0\.10% \|", speed)
