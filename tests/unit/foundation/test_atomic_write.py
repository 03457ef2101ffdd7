"""The one rule for writing files: whole, with its mode, over regular files, checked early."""

import ast
import os
import re
import stat
import sys
from pathlib import Path

import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.cli.demo import run_demo
from gallop_fmu.foundation.atomic_write import check_target, open_exclusive, write_whole
from gallop_fmu.sweeps.journal import journal_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="modes, links and devices of POSIX")


def refused(path):
    """The message of both the early check and the writing; nothing is left behind."""
    before = sorted(path.parent.iterdir())
    with pytest.raises(gf.SceneError) as early:
        check_target(path)
    with pytest.raises(OSError, match=re.escape(str(path))) as late:
        write_whole(path, b"new")
    assert late.value.filename == str(path)
    assert str(early.value) == f"{path}: cannot be written ({late.value.strerror})"
    assert sorted(path.parent.iterdir()) == before
    return late.value.strerror


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o660, 0o222])
def test_an_older_file_keeps_its_mode(tmp_path, mode):
    path = tmp_path / "o.csv"
    path.write_bytes(b"old")
    path.chmod(mode)
    check_target(path)
    write_whole(path, b"new")
    assert stat.S_IMODE(path.stat().st_mode) == mode
    path.chmod(0o600)
    assert path.read_bytes() == b"new"


def test_a_new_file_has_the_mode_that_the_user_asked_for(tmp_path):
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "o.csv", b"new")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "o.csv").stat().st_mode) == 0o640


@pytest.mark.skipif(getattr(os, "geteuid", int)() != 0, reason="only root may give files away")
def test_an_older_file_keeps_its_owner(tmp_path):
    path = tmp_path / "o.csv"
    path.write_bytes(b"old")
    os.chown(path, 12345, 12346)
    write_whole(path, b"new")
    assert (path.stat().st_uid, path.stat().st_gid) == (12345, 12346)


def test_a_read_only_file_is_refused(tmp_path):
    """Also for root, whose access the system allows."""
    path = tmp_path / "o.csv"
    path.write_bytes(b"old")
    path.chmod(0o444)
    assert "the file is read-only" in refused(path)
    assert path.read_bytes() == b"old"


@pytest.mark.parametrize("through_link", [False, True])
def test_pipes_and_devices_are_not_replaced(tmp_path, through_link):
    pipe = path = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    if through_link:
        path = tmp_path / "link.csv"
        path.symlink_to(pipe)
    assert "a device or a pipe, not a regular file" in refused(path)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_the_null_device_through_a_link(tmp_path):
    path = tmp_path / "link.csv"
    path.symlink_to("/dev/null")
    assert "not a regular file" in refused(path)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


def test_links_are_followed_and_stay(tmp_path):
    (tmp_path / "other").mkdir()
    path, target = tmp_path / "o.csv", tmp_path / "other" / "real.csv"
    path.symlink_to(target)  # the target is not there yet
    for content in (b"first", b"second"):
        write_whole(path, content)
        assert path.is_symlink()
        assert target.read_bytes() == content
    loop = tmp_path / "loop.csv"
    loop.symlink_to(loop)
    assert "Too many levels of symbolic links" in refused(loop)


def test_a_planted_link_is_not_followed(tmp_path, monkeypatch):
    """The temporary name is unpredictable; an existing file would not be opened."""
    monkeypatch.setattr(
        "gallop_fmu.foundation.atomic_write.secrets.token_hex", lambda count: "0" * 16
    )
    victim = tmp_path / "victim"
    victim.write_bytes(b"precious")
    planted = tmp_path / f".gallop-{'0' * 16}.new"
    planted.symlink_to(victim)
    with pytest.raises(FileExistsError):
        write_whole(tmp_path / "o.csv", b"new")
    assert victim.read_bytes() == b"precious"
    assert sorted(tmp_path.iterdir()) == [planted, victim]


@pytest.mark.parametrize("length", [244, 251, 255])
def test_a_long_name_is_no_reason_to_fail(tmp_path, length):
    path = tmp_path / f"{'n' * (length - 4)}.csv"
    check_target(path)
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"


def test_a_name_that_is_too_long_is_refused(tmp_path):
    assert "File name too long" in refused(tmp_path / f"{'n' * 252}.csv")


@pytest.mark.parametrize(
    ("name", "fragment"), [("a\0.csv", "null"), ("none/a.csv", "there is no folder")]
)
def test_names_that_cannot_be(tmp_path, name, fragment):
    with pytest.raises(gf.SceneError, match=fragment):
        check_target(tmp_path / name)


LONG = "n" * 249
WRITERS = {
    f"{LONG}.nc": lambda path: gf.sweep("example3", {"wind.speed": [4.0]}, out=path),
    "x.html": lambda path: modal.write_report(gf.load_scene("example3"), path),
    "example3.nc": lambda path: run_demo(path.parent),
    "x.fmu": lambda path: gf.export_fmu(gf.load_scene("example3"), path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_nothing_is_computed_for_a_file_that_cannot_be_written(tmp_path, monkeypatch, name):
    """A name too long for that of the journal, and read-only files."""

    def started(*_, **__):
        raise AssertionError("it was computed")

    monkeypatch.setattr("gallop_fmu.engine.model.Model.__init__", started)
    path = tmp_path / name
    if not name.startswith(LONG):
        path.write_bytes(b"old")
        path.chmod(0o444)
    with pytest.raises(ValueError, match=r"File name too long|the file is read-only"):
        WRITERS[name](path)


def test_no_module_writes_files_in_another_way():
    """Except for temporary folders of a compilation and of an FMU check."""
    found = set()
    for package in (gf, modal):
        folder = Path(package.__file__).parent
        for file in folder.rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text("utf-8"))):
                if isinstance(node, ast.Attribute) and node.attr in (
                    "write_text",
                    "write_bytes",
                    "NamedTemporaryFile",
                ):
                    found.add(file.relative_to(folder.parent).as_posix())
                if isinstance(node, ast.Call) and "open" in (
                    getattr(node.func, n, "") for n in ("id", "attr")
                ):
                    modes = [c.value for c in ast.walk(node) if isinstance(c, ast.Constant)]
                    if {"w", "wb", "a", "ab"} & {mode for mode in modes if isinstance(mode, str)}:
                        found.add(file.relative_to(folder.parent).as_posix())
    assert found == {
        "gallop_fmu/fmu/cross_compile.py",
        "gallop_fmu/fmu/smoke_test.py",
        "gallop_fmu/cli/terminal.py",
    }


def test_a_lock_is_for_one_and_ends_with_its_file(tmp_path):
    path = tmp_path / "o.nc.journal"
    with open_exclusive(path) as first:
        first.write(b"row\n")
        with pytest.raises(BlockingIOError):
            open_exclusive(path)
    with open_exclusive(path) as second:
        second.seek(0)
        assert second.read() == b"row\n"


@pytest.mark.parametrize("make", [lambda path: path.symlink_to("victim"), os.mkfifo, os.mkdir])
def test_a_journal_is_a_regular_file(tmp_path, make):
    (tmp_path / "victim").write_bytes(b"")
    make(journal_of(tmp_path / "o.nc"))
    with pytest.raises(OSError, match=r"symbolic links|not a regular file|Is a directory"):
        open_exclusive(journal_of(tmp_path / "o.nc"))
    assert (tmp_path / "victim").read_bytes() == b""


def test_a_file_that_was_removed_before_it_was_locked_is_made_again(tmp_path, monkeypatch):
    """Another sweep removes its empty journal in the instant between opening and locking."""
    path, lock = tmp_path / "o.nc.journal", []

    def late(descriptor):
        if not lock:
            path.unlink()
        lock.append(descriptor)

    monkeypatch.setattr("gallop_fmu.foundation.atomic_write._lock", late)
    with open_exclusive(path) as file:
        assert os.path.samestat(os.fstat(file.fileno()), path.stat())
    assert len(lock) == 2
