"""Every example runs alone, asserts its result, and leaves the repository unchanged."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))
KIT = [FOLDER / "cosimulation" / "run.py"]
PAPER = sorted((FOLDER / "paper").glob("*.py"))


def _files(folder):
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*")}


def test_there_are_examples():
    assert [path.name[:2] for path in EXAMPLES] == [f"{k:02}" for k in range(1, len(EXAMPLES) + 1)]
    assert len(EXAMPLES) >= 7


@pytest.mark.parametrize("script", [*EXAMPLES, *PAPER, *KIT], ids=lambda path: path.stem)
def test_example_runs(script, tmp_path):
    text = script.read_text(encoding="utf-8")
    assert "\nassert " in text.split("# %%")[-1], "an example ends in an asserted number"
    before = _files(FOLDER)
    environment = {
        **os.environ,
        "MPLBACKEND": "Agg",
        "TMPDIR": str(tmp_path),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert _files(FOLDER) == before
