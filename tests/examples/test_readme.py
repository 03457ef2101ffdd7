"""What the README says is so: its Python, its numbers, its commands, its links."""

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer

import modal
from gallop_fmu.cli import main as simulation_cli
from gallop_fmu.cli.line_commands import NEW_EXAMPLE
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.input.scene_files import load_scene
from modal.cli import main as modal_cli

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
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == expected
    assert (tmp_path / "example3.fmu").is_file()


def test_rows_of_the_table_of_trust_are_what_is_computed_now():
    """Those that take no minutes; other tests hold the others to the same sources."""
    trust = script("benchmarks/accuracy/trust.py")
    written = trust.RECORD.read_text(encoding="utf-8")
    for row in trust.computed_at_once():
        assert trust.line(*row) in written.splitlines()


def test_irvine_agrees_over_the_sags_of_the_picture():
    pictures = script("benchmarks/accuracy/pictures.py")
    scenes = pictures.spans()
    (resonant,) = modal.crossings(scenes["rigid ends"], "span.sag", [2.0, 2.6])
    assert resonant == pytest.approx(2.31, abs=0.005)
    for scene in scenes.values():
        for sag in pictures.SAGS[::8]:
            at = scene.with_values({"span.sag": float(sag)})
            found = modal.frequency_ratio(at).ratio
            assert modal.shallow_cable(at).ratio == pytest.approx(
                found, rel=1.5e-3
            )  # observed at most 1.1e-3


def commands():
    text = README.replace("\\\n", " ")
    lines = [
        line.split("#")[0].strip() for line in text.splitlines() if line.startswith("    gallop-")
    ]
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


@pytest.mark.parametrize(
    ("text", "folder"), [(README, ""), (GALLERY, "examples")], ids=["README", "gallery"]
)
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
