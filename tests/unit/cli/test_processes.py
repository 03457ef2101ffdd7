"""The commands as processes: streams, completion, terminals, threads, Ctrl-C."""

import os
import signal
import subprocess
import sys

import h5netcdf
import pytest
import xarray as xr

import gallop_fmu as gf


def _command(*words):
    return [sys.executable, "-P", "-c", "from gallop_fmu.cli.main import main; main()", *words]


def test_as_a_process(tmp_path):
    done = subprocess.run(
        _command("run", "exmple1"), cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(
        "gallop-fmu: exmple1: no packaged scene and no file has this name"
    )
    assert len(done.stderr.splitlines()) == 1


def test_foreign_settings_do_not_matter(tmp_path):
    """A missing backend of Jupyter, LaTeX in matplotlibrc, a stream with a code page of Windows."""
    scene = gf.load_scene("example3").with_values({"title": "\u03a9 \N{GRINNING FACE}"})
    scene.save(tmp_path / "a.toml")
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nfont.family: no such font\n")
    foreign = {
        "MPLBACKEND": "module://matplotlib_inline.backend_inline",
        "PYTHONIOENCODING": "cp1252",
    }
    command = _command("run", "a.toml", "--stop-time", "0.1", "--plot", "a.png")
    done = subprocess.run(
        command, cwd=tmp_path, env={**os.environ, **foreign}, capture_output=True, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.startswith(rb"\u03a9 \U0001f600")
    assert (tmp_path / "a.png").stat().st_size > 1000


@pytest.mark.skipif(os.name == "nt", reason="closed streams of POSIX")
@pytest.mark.parametrize(
    "words", [("run",), ("sweep", "--over", "wind.speed=4,5", "--window", "0.05")]
)
def test_streams_may_be_closed(tmp_path, words):
    """As in a service or pythonw; files opened later must not replace the streams."""
    command = _command(*words, "example3", "--stop-time", "0.1", "--out", "a.nc")
    closed = ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *command]
    assert subprocess.run(closed, cwd=tmp_path, timeout=60).returncode == 0
    with xr.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as written:
        assert written.sizes


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("gallop-fmu ru", "run"),
        ("gallop-fmu run ex", "example1 example2 example3"),
        ("gallop-fmu run min", "mine.toml"),
        ("gallop-fmu run lines/", "lines/north.toml"),
        ("gallop-fmu sweep z", "zebra"),
        ("gallop-fmu run nothing", ""),  # the shell then offers any path
        ("gallop-fmu check any", ""),
        ("gallop-fmu run example3 --in", "--inputs"),
        ("gallop-fmu new mine.toml --conductor Dr", "Drake Drone"),
        ("gallop-modal s", "slope sensitivity screen study"),
        ("gallop-modal modes zeb", "zebra"),
    ],
)
def test_tab_completes(tmp_path, typed, offered):
    """As bash requests it."""
    (tmp_path / "lines").mkdir()
    for name in ("mine.toml", "lines/north.toml", "lines/notes.txt", "anything.fmu"):
        (tmp_path / name).write_text("")
    module, variable = (
        typed.split()[0].replace("-", "_"),
        typed.split()[0].replace("-", "_").upper(),
    )
    code = (
        f"from {'gallop_fmu' if module == 'gallop_fmu' else 'modal'}.cli.main import main; main()"
    )
    asked = {
        "COMP_WORDS": typed,
        "COMP_CWORD": str(len(typed.split()) - 1),
        f"_{variable}_COMPLETE": "complete_bash",
    }
    done = subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path,
        env=os.environ | asked,
        capture_output=True,
        text=True,
    )
    assert done.stdout.split() == offered.split()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no pseudo-terminals of this kind")
@pytest.mark.parametrize(("settings", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colours_are_for_terminals_that_want_them(tmp_path, begin, settings, coloured):
    import pty

    (tmp_path / "a.fmu").write_text("not an archive")
    plain = {
        name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR")
    }
    environment = {**plain, "TERM": "xterm", **settings}
    ours, theirs = pty.openpty()
    assert (
        begin(
            _command("check", "a.fmu"), cwd=tmp_path, env=environment, stdout=theirs, stderr=theirs
        ).wait(60)
        == 1
    )
    shown = os.read(ours, 10_000).decode()
    os.close(ours)
    os.close(theirs)
    assert "FAILED" in shown
    assert ("\x1b[31m" in shown) is coloured
    piped = subprocess.run(
        _command("check", "a.fmu"), cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert "\x1b" not in piped.stdout + piped.stderr


TELLS_WHEN_IT_STEPS = """
from gallop_fmu.engine.model import State
record, portions = State.record, []
def telling(*arguments, **named):
    portions.append(1)
    if len(portions) == 2:  # the first is kept by now
        print("stepping", flush=True)
    return record(*arguments, **named)
State.record = telling
"""


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is sent otherwise on Windows")
def test_ctrl_c_keeps_computed_rows(tmp_path, begin):
    words = (
        "run",
        "example1",
        "--stop-time",
        "2e5",
        "--record-every",
        "400",
        "--out",
        "a.nc",
    )  # would take hours
    command = _command(*words)
    command[3] = TELLS_WHEN_IT_STEPS + command[3]
    process = begin(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "stepping\n"
    process.send_signal(signal.SIGINT)
    _, messages = process.communicate(timeout=60)
    assert process.returncode == 1, messages
    assert (
        "stopped on request. The run ended early; the results until then are in a.nc." in messages
    )
    with h5netcdf.File(tmp_path / "a.nc", "r") as file:
        assert file.attrs["outcome"] == "stopped_by_user"
        assert file["time"][-1] > 0.0
