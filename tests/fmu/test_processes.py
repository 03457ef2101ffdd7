"""FMUs that share a process, and traces left in it: each test is a program of its own."""

import json
import os
import subprocess
import sys
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.fmu import export_fmu

pytestmark = [
    pytest.mark.usefixtures("runtime"),
    pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session"),
]

SIMULATE = "from fmpy import simulate_fmu; import json, sys; paths = sys.argv[1:]\n"
HOLD = "simulate_fmu(paths[{i}], stop_time=0.5, output_interval=0.05)['midspan.tension'].tolist()"


def run(code, *arguments, cwd=None, environment=None):
    """Output of a Python program, which must end with exit code 0 and an empty error stream."""
    done = attempt(code, *arguments, cwd=cwd, environment=environment)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def attempt(code, *arguments, cwd=None, environment=None):
    command = [sys.executable, "-P", "-c", code, *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, env={**os.environ, **(environment or {})}, capture_output=True, text=True
    )


def test_two_fmus_in_one_process_do_not_mix(gallop_fmu, rigid_fmu, tmp_path):
    alone = [
        json.loads(run(SIMULATE + f"print(json.dumps({HOLD.format(i=0)}))", p))
        for p in (gallop_fmu, rigid_fmu)
    ]
    both = (
        SIMULATE
        + f"print(json.dumps([{HOLD.format(i=0)}, {HOLD.format(i=1)}, {HOLD.format(i=0)}]))"
    )
    found = json.loads(run(both, gallop_fmu, rigid_fmu, cwd=tmp_path))
    assert found == [alone[0], alone[1], alone[0]]
    assert alone[0] != alone[1]


@pytest.mark.skipif(sys.platform != "linux", reason="a fault of pythonfmu's library for Linux")
def test_pythonfmu_uses_no_freed_memory_at_exit(gallop_fmu, tmp_path):
    """Without our finaliser this ends with SIGSEGV; an ordinary allocator may abort or not."""
    source = Path(__file__).with_name("reuse_after_free.c")
    subprocess.run(
        [os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o", tmp_path / "guard.so", source],
        check=True,
    )
    code = SIMULATE + f"first = {HOLD.format(i=0)}; print(first == {HOLD.format(i=0)})"
    assert (
        run(code, gallop_fmu, environment={"LD_PRELOAD": str(tmp_path / "guard.so")}).strip()
        == "True"
    )


def test_the_command_of_fmpy_ends_cleanly(gallop_fmu):
    """Without our finaliser it aborts at exit; benchmarks/hosts/exits.py repeats it 50 times."""
    command = "import sys; from fmpy.cli import main; sys.argv[0] = 'fmpy'; main()"
    for _ in range(2):
        run(command, "simulate", "--stop-time", "0.1", gallop_fmu)


def test_two_fmus_alive_at_once_in_two_threads(gallop_scene, rigid_scene, gallop_fmu, rigid_fmu):
    code = SIMULATE + (
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from fmpy import extract, instantiate_fmu, read_model_description\n"
        # one after the other: pythonfmu looks for the class of a script through a name that all
        # threads share
        "folders = [extract(p) for p in paths]\n"
        "fmus = [instantiate_fmu(f, read_model_description(p), 'CoSimulation') for f, p in"
        " zip(folders, paths)]\n"
        "def tension(folder, fmu):\n"
        "    records = simulate_fmu(folder, stop_time=2.0, output_interval=0.01,"
        " fmu_instance=fmu)\n"
        "    return records['midspan.tension'].tolist()\n"
        "with ThreadPoolExecutor(2) as pool: print(json.dumps(list(pool.map(tension, folders,"
        " fmus))))"
    )
    found = json.loads(run(code, gallop_fmu, rigid_fmu))
    for values, scene in zip(found, (gallop_scene, rigid_scene), strict=True):
        state = Model(scene).start()
        for k in range(200):
            state.advance(0.01 * (k + 1))
        assert values[-1] == pytest.approx(state.observe_node(state.model.middle)[12], rel=1e-12)


def test_the_search_path_does_not_grow_and_unpacked_files_may_go(gallop_fmu):
    code = (
        SIMULATE
        + f"before = list(sys.path); first = {HOLD.format(i=0)}; second = {HOLD.format(i=0)}\n"
    )
    code += "assert first == second; print(sys.path == before)"
    assert run(code, gallop_fmu).strip() == "True"


def test_many_failing_instances_end_cleanly(gallop_fmu):
    code = (
        SIMULATE + "for _ in range(60):\n    result = simulate_fmu(paths[0], stop_time=5.0,"
        " output_interval=0.05, start_values={'wind_speed': 140.0})\nprint(0.0 <"
        " result['time'][-1] < 5.0, result['status'][-1])"
    )
    done = attempt(code, gallop_fmu)
    assert done.returncode == 0
    assert {line[:14] for line in done.stderr.splitlines()} == {
        "gallop-fmu: th"
    }  # why the steps failed
    stopped, status = done.stdout.split()
    assert stopped == "True"
    assert int(status) > 0


def test_a_path_with_spaces(gallop_fmu, tmp_path):
    folder = tmp_path / "with some spaces"
    folder.mkdir()
    code = SIMULATE + f"print(len({HOLD.format(i=0)}))"
    assert run(code, gallop_fmu, environment={"TMPDIR": str(folder)}).strip() == "11"


def rewritten(path, target, change):
    """Copy of an FMU with `change` made to each entry's content."""
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            new.writestr(name, change(name, old.read(name)))
    return target


def test_another_version_of_the_package_is_refused(gallop_fmu, tmp_path):
    needed = version("gallop-fmu")

    def change(name, data):
        return data.replace(needed.encode(), b"0.0.9") if name.endswith(".py") else data

    path = rewritten(gallop_fmu, tmp_path / "x.fmu", change)
    done = attempt(SIMULATE + HOLD.format(i=0), path)
    assert done.returncode == 1
    assert "this FMU needs the Python package gallop-fmu==0.0.9" in done.stderr
    assert f"there is version {needed}" in done.stderr


def test_a_resource_changed_inside_the_fmu_is_refused(gallop_fmu, tmp_path):
    def change(name, data):
        return data[:-9] + b"x" + data[-8:] if name.endswith("model.bin") else data

    done = attempt(SIMULATE + HOLD.format(i=0), rewritten(gallop_fmu, tmp_path / "x.fmu", change))
    assert done.returncode == 1
    assert "model.bin is damaged: its checksum is wrong" in done.stderr


def test_works_from_another_folder(rigid_scene, tmp_path):
    path = export_fmu(rigid_scene, tmp_path / "x.fmu", runtime="python")
    code = SIMULATE + f"print(len({HOLD.format(i=0)}))"
    assert run(code, path.name, cwd=tmp_path).strip() == "11"
