"""A full disk while results are written: no crash, the older file remains, a clear message."""

import resource
import signal
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr

import gallop_fmu as gf
from gallop_fmu.fmu import ExportError, export_fmu
from gallop_fmu.foundation.atomic_write import write_whole
from gallop_fmu.plots import overview, save_figure
from modal.report.page import write_page

LIMIT = 2000
"""Bytes that a file may have, in place of a full disk."""


@pytest.fixture(scope="module")
def result():
    return gf.simulate(gf.load_scene("example1"), stop_time=1.0)


@contextmanager
def little_room():
    """Limit files of this process to `LIMIT` bytes; reset before pytest writes its report."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


WRITERS = {
    "run.csv": lambda result, path: result.save(path),
    "run.parquet": lambda result, path: result.save(path),
    "run.png": lambda result, path: save_figure(overview(result), path),
    "run.toml": (
        lambda result, path: result.scene.with_values({"description": 4 * LIMIT * "x"}).save(path)
    ),
    "run.fmu": lambda result, path: export_fmu(result.scene, path),
}


@pytest.mark.parametrize("name", WRITERS)
def test_an_older_file_survives(tmp_path, result, name):
    path = tmp_path / name
    path.write_bytes(b"the older one")
    failure = pytest.raises(
        (OSError, ExportError), match=f"{name}.*(large|space)|(large|space).*{name}"
    )
    with failure, little_room():
        WRITERS[name](result, path)
    assert path.read_bytes() == b"the older one"
    assert list(tmp_path.iterdir()) == [path]


def test_a_page_that_does_not_fit_leaves_the_older_one(tmp_path, monkeypatch):
    path = tmp_path / "run.html"
    path.write_bytes(b"the older one")
    monkeypatch.setattr("modal.report.page.page", lambda findings: 4 * LIMIT * "x")
    with pytest.raises(OSError, match=r"large.*run.html"), little_room():
        write_page(None, path)
    assert path.read_bytes() == b"the older one"
    assert list(tmp_path.iterdir()) == [path]


def test_a_run_reports_a_file_it_cannot_write_and_keeps_the_rest(tmp_path):
    """NetCDF in a process of its own: HDF5 writing directly would end it with SIGSEGV."""
    (tmp_path / "run.nc").write_bytes(b"the older one")

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

    words = [
        "run",
        "example1",
        "--stop-time",
        "1",
        "--record-every",
        "20",
        "--out",
        "run.nc",
        "--plot",
        "run.png",
    ]
    command = [sys.executable, "-P", "-c", "from gallop_fmu.cli.main import main; main()", *words]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, preexec_fn=limited, timeout=120
    )
    assert done.returncode == 2, done.stderr or signal.Signals(-done.returncode)
    for name in ("run.nc", "run.png"):
        assert (
            f"{name}: cannot be written (File too large); an older file of this name is unchanged"
            in done.stderr
        )
    assert "Traceback" not in done.stderr
    assert "lowest tension" in done.stdout  # the summary is not lost
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]
    assert (tmp_path / "run.nc").read_bytes() == b"the older one"


def test_files_are_replaced_through_links(tmp_path, result):
    (tmp_path / "real.nc").write_bytes(b"the older one")
    (tmp_path / "run.nc").symlink_to("real.nc")
    result.save(tmp_path / "run.nc")
    assert (tmp_path / "run.nc").is_symlink()
    with xr.open_dataset(tmp_path / "real.nc", engine="h5netcdf") as found:
        assert np.array_equal(found.u2.values, result.dataset.u2.values)


def test_an_interrupted_write_leaves_the_older_file_alone(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    path.write_bytes(b"the older one")

    def interrupted(descriptor):
        raise KeyboardInterrupt

    monkeypatch.setattr("os.fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(path, b"new")
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == b"the older one"
