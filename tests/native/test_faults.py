"""No memory, corrupt files and states, under the sanitizers and under valgrind."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
FUZZING = HERE.parents[1] / "fuzz"
CORPORA = {
    folder.name: sorted(folder.iterdir()) for folder in sorted((FUZZING / "corpus").iterdir())
}


def run(command, small, timeout=120):
    environment = {**os.environ, "RESOURCES": small.resources.as_uri(), "GUID": small.guid}
    done = subprocess.run(
        list(map(str, command)), env=environment, capture_output=True, text=True, timeout=timeout
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


def test_every_allocation_fails_once(sanitized, small):
    """A clean refusal, no leak, and the instance continues when there is memory again."""
    program = sanitized("faults", HERE / "faults.c", flags=["-Wl,--wrap=malloc,--wrap=calloc"])
    counted = dict(
        line.split()
        for line in run([program, small.resources.as_uri(), small.guid], small).splitlines()
    )
    # How many allocations there are, each of which failed: the model and its work space, and so on.
    assert counted == {
        "create": "2", "resource": "3", "instantiate": "11", "initialise": "3", "states": "2",
        "exchange": "4"
    }  # fmt: skip


@pytest.mark.parametrize("name", ["resource", "state", "scene", "face"])
def test_inputs_that_fuzzing_has_found(sanitized, small, name):
    program = sanitized(name, FUZZING / f"{name}_target.c", FUZZING / "replay.c")
    assert len(CORPORA[name]) >= 20
    assert run([program, *CORPORA[name]], small) == f"{len(CORPORA[name])} inputs\n"


def test_corpus_is_small():
    assert sum(file.stat().st_size for files in CORPORA.values() for file in files) < 200_000


def test_valgrind_finds_nothing(compiled, kernel_sources, small, tmp_path):
    """Reads of uninitialised memory, which the sanitizers do not see."""
    valgrind = shutil.which("valgrind")
    assert valgrind, "valgrind is not installed; apt-get install valgrind"
    includes = [f"-I{kernel_sources}", f"-I{FUZZING}"]
    sources = [
        FUZZING / "state_target.c",
        FUZZING / "replay.c",
        *sorted(kernel_sources.glob("*.c")),
    ]
    program = compiled(
        tmp_path / "state", *sources, flags=["-g", "-O1", "-DGALLOP_ONE_PATH", *includes]
    )
    memcheck = [
        valgrind,
        "--quiet",
        "--error-exitcode=9",
        "--leak-check=full",
        "--track-origins=no",
    ]
    files = CORPORA["state"][::4]
    assert run([*memcheck, program, *files], small) == f"{len(files)} inputs\n"
