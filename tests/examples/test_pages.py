"""The README and the pages in docs: Python runs, figures and commands are right, links exist."""

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import typer

import modal
from gallop_fmu.cli import main as simulation_cli
from gallop_fmu.cli.line_commands import NEW_EXAMPLE
from modal.cli import main as modal_cli
from support.scripts import load_script

ROOT = Path(__file__).parents[2]
PAGES = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in (
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "examples" / "README.md",
        *sorted((ROOT / "docs").rglob("*.md")),
    )
}
README = PAGES["README.md"]
GALLERY = PAGES["examples/README.md"]
APPS = {"gallop-fmu": simulation_cli.app, "gallop-modal": modal_cli.app}

PYTHON = re.compile(r"^```python\n(.*?)^```(?:\n\n```text\n(.*?)^```)?", re.MULTILINE | re.DOTALL)
"""A block of code and, if one follows, the block with what it prints."""


@pytest.mark.parametrize("page", [name for name, text in PAGES.items() if PYTHON.search(text)])
def test_python_of_a_page_prints_the_shown_text(page, tmp_path):
    """Some pages take seconds: they simulate until a motion is steady, as a reader does."""
    code, shown = zip(*PYTHON.findall(PAGES[page]), strict=True)
    done = subprocess.run(
        [sys.executable, "-P", "-c", "".join(code)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "".join(shown)


def test_the_readme_is_short():
    lines = README.splitlines()
    assert len(lines) <= 130
    assert all(len(line) <= 100 for line in lines if not line.startswith("|"))


def test_rows_of_the_table_of_comparisons_are_reproduced():
    """Rows that are computed in seconds; other tests check the other rows."""
    trust = load_script("benchmarks/accuracy/trust.py")
    written = trust.RECORD.read_text(encoding="utf-8").splitlines()
    for row in trust.computed_at_once():
        assert trust.line(*row) in written
    quoted = re.search(r"^\| Compared with .*?(?=\n\n)", README, re.MULTILINE | re.DOTALL)[0]
    assert set(quoted.splitlines()) <= set(written)


def test_irvine_agrees_over_the_sags_of_the_picture():
    pictures = load_script("benchmarks/accuracy/pictures.py")
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
    """Every command of this project on the pages, with its page."""
    for page, text in PAGES.items():
        for line in text.replace("\\\n", " ").splitlines():
            if line.startswith("    gallop-"):
                yield page, " ".join(line.split("#")[0].split())


@pytest.mark.parametrize(("page", "command"), list(commands()))
def test_commands_are_understood(page, command):
    program, name, *words = shlex.split(command)
    known = typer.main.get_command(APPS[program]).commands[name]
    known.make_context(name, words)  # refuses what it does not know


def test_the_readme_shows_the_example_of_the_help():
    assert ("README.md", NEW_EXAMPLE) in commands()


@pytest.mark.parametrize("page", PAGES)
def test_links_and_files_exist(page):
    text = re.sub(r"^```.*?^```", "", PAGES[page], flags=re.MULTILINE | re.DOTALL)
    linked = [target for target in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in target]
    named = re.findall(
        r"`((?:examples|benchmarks|tests|tools|docs|gallop_fmu|modal)/[\w./-]+)`", text
    )
    for target in linked:
        assert (ROOT / page).parent.joinpath(target).exists(), target
    for target in named:
        assert (ROOT / target).exists(), target


def test_the_gallery_shows_every_example():
    scripts = sorted(path.name for path in (ROOT / "examples").glob("*.py"))
    assert re.findall(r"^\| \[(\S+\.py)\]", GALLERY, re.MULTILINE) == scripts


def test_the_citation_has_the_version_of_the_package():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"version: {project['version']}\n" in citation


@pytest.mark.parametrize("package", ["gallop_fmu", "modal"])
def test_the_map_names_every_module(package):
    map_of_folders = re.findall(r"^\| `(\w+)/` \| (.*) \|$", PAGES["CONTRIBUTING.md"], re.MULTILINE)
    for path in sorted((ROOT / package).glob("*/*.py")):
        named = " ".join(text for folder, text in map_of_folders if folder == path.parent.name)
        assert path.name == "__init__.py" or f"`{path.name}`" in named, path
    for folder, text in map_of_folders:
        for name in re.findall(r"`(\w+\.py)`", text):
            assert any(
                (ROOT / top / folder / name).exists() for top in ("gallop_fmu", "modal", "")
            ), name
