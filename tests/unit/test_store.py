"""Rows on disk: the same back, from whatever an interrupted program left."""

import json
import math
from zlib import crc32

import numpy as np
import pytest
import xarray as xr

import gallop_fmu as gf
from gallop_fmu.store import ERROR, FORMAT, Store, as_dataset, journal_of, read, rows_of

HEADER = {
    "format": FORMAT,
    "package": "p",
    "task": "t",
    "scenes": "s",
    "runs": 3,
    "grid": {"wind.speed": [4.0, 5.0, 6.0]},
    "columns": {"sag": ["m", "sag"], "outcome": ["", "how it ended"]},
}
ROWS = [
    {"outcome": "completed", "sag": 0.1 + 0.2, "note": "ice, \u00fc\u201c\n", "steps": 10, "swings": True},
    {"outcome": "slack", "sag": math.nan, "note": None, "steps": 12, "swings": False},
    {"outcome": "completed", "sag": -1e-308, "note": "x", "steps": 2**53 + 1, "swings": True},
]
ROWS = [{"run": run, "wind.speed": 4.0 + run, "message": "", **row} for run, row in enumerate(ROWS)]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "runs.parquet"


both_formats = pytest.mark.parametrize("suffix", [".nc", ".parquet"])


def _filled(path, rows=ROWS):
    store = Store(path, HEADER)
    store.add(rows)
    return store


@both_formats
def test_file_holds_what_it_was_given_bit_for_bit(tmp_path, suffix):
    path = tmp_path / f"runs{suffix}"
    store = _filled(path)
    store.close()
    found = read(path)
    assert found.identical(store.dataset())
    assert found.sag.values[0] == 0.1 + 0.2
    assert found.sag.attrs == {"units": "m", "long_name": "sag"}
    assert found.outcome.attrs == {"long_name": "how it ended"}
    assert found.steps.values.tolist() == [10, 12, 2**53 + 1]
    assert found.note.values.tolist() == ["ice, \u00fc\u201c\n", "", "x"]
    assert not journal_of(path).exists()
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_parquet_is_readable_by_others(tmp_path):
    from pyarrow import parquet

    _filled(tmp_path / "runs.parquet").close()
    table = parquet.read_table(tmp_path / "runs.parquet")
    assert table["steps"].to_pylist() == [10, 12, 2**53 + 1]
    assert table.schema.field("sag").metadata[b"units"] == b"m"


def test_rows_there_and_back():
    dataset = as_dataset(ROWS, HEADER)
    assert as_dataset(rows_of(dataset), HEADER).identical(dataset)


def test_rows_are_readable_before_the_file_is_written(path):
    _filled(path, ROWS[:2]).release()
    assert not path.exists()
    assert read(path).identical(as_dataset(ROWS[:2], HEADER))
    for line in journal_of(path).read_text().splitlines():
        content, checksum = line.split("\t")
        assert json.loads(content, parse_constant=pytest.fail)
        assert int(checksum, 16) == crc32(content.encode())


def test_a_journal_cut_anywhere_loses_only_the_row_that_was_cut(path):
    _filled(path).release()
    whole = journal_of(path).read_bytes()
    ends = [k + 1 for k, byte in enumerate(whole) if byte == 10]
    assert len(ends) == 4
    for cut in range(len(whole)):
        journal_of(path).write_bytes(whole[:cut])
        kept = max(0, sum(end <= cut for end in ends) - 1)
        again = Store(path, HEADER)
        assert sorted(again.rows) == list(range(kept))
    for cut in (5, ends[0], ends[1] + 7, ends[2] - 1):
        journal_of(path).write_bytes(whole[:cut])
        again = Store(path, HEADER)
        again.add(row for row in ROWS if row["run"] not in again.rows)
        assert journal_of(path).read_bytes() == whole
        again.release()


def test_a_closed_file_that_is_not_complete_keeps_its_journal(path):
    _filled(path, ROWS[:2]).close()
    assert path.exists()
    assert journal_of(path).exists()
    again = Store(path, HEADER)
    again.add(ROWS[2:])
    again.close()
    assert not journal_of(path).exists()
    assert read(path).identical(as_dataset(ROWS, HEADER))


def test_rows_of_the_file_count_where_the_journal_is_shorter(path):
    """The disk was full when the journal was begun anew over a file of results."""
    _filled(path, ROWS[:2]).close()
    header = journal_of(path).read_bytes().splitlines(keepends=True)[0]
    journal_of(path).write_bytes(header)
    assert read(path).run.values.tolist() == [0, 1]
    assert sorted(Store(path, HEADER).rows) == [0, 1]


def test_what_ended_in_something_unforeseen_is_tried_again(path):
    store = _filled(path, [*ROWS[:2], {**ROWS[2], "outcome": ERROR}])
    store.close()
    assert read(path).run.values.tolist() == [0, 1, 2]
    again = Store(path, HEADER)
    assert sorted(again.rows) == [0, 1]
    again.add(ROWS[2:])
    again.close()
    assert read(path).outcome.values.tolist() == ["completed", "slack", "completed"]


def test_a_complete_file_is_not_touched(path):
    _filled(path).close()
    before = path.stat().st_mtime_ns
    Store(path, HEADER).close()
    assert path.stat().st_mtime_ns == before


@pytest.mark.parametrize("key", ["package", "task", "scenes"])
@pytest.mark.parametrize("complete", [True, False])
def test_another_sweep_is_refused(path, key, complete):
    store = _filled(path)
    store.close() if complete else store.release()
    with pytest.raises(gf.SceneError, match=f"results of something else: {key} was .*, is other. Give another file"):
        Store(path, {**HEADER, key: "other"})
    assert read(path).sizes["run"] == 3


@both_formats
def test_foreign_files_are_refused(tmp_path, suffix):
    path = tmp_path / f"runs{suffix}"
    path.write_bytes(b"something else")
    with pytest.raises(gf.SceneError, match="does not hold the results of a sweep"):
        Store(path, HEADER)
    assert path.read_bytes() == b"something else"
    path.unlink()
    journal_of(path).write_text("my diary\n")
    with pytest.raises(gf.SceneError, match="is not the journal of a sweep"):
        Store(path, HEADER)


def test_datasets_of_others_are_refused(tmp_path):
    xr.Dataset({"u2": ("time", [0.0])}).to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with pytest.raises(gf.SceneError, match="does not hold the results of a sweep"):
        read(tmp_path / "run.nc")


@pytest.mark.parametrize(
    ("name", "fragment"),
    [("a.csv", "must end in .parquet or .nc"), ("none/a.nc", "there is no folder"), ("folder.nc", "is a folder")],
)
def test_names_that_are_refused(tmp_path, name, fragment):
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(gf.SceneError, match=fragment):
        Store(tmp_path / name, HEADER)


def test_parquet_without_pyarrow_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(gf.SceneError, match=r'pip install "gallop-fmu\[parquet\]", or give a name that ends in .nc'):
        Store(tmp_path / "a.parquet", HEADER)


def test_a_file_is_replaced_as_a_whole(path, monkeypatch):
    """Whatever happens while the new file is written, the old one stays."""
    store = _filled(path, ROWS[:2])
    store.renew()
    before = path.read_bytes()
    store.add(ROWS[2:])

    def full(new, content):
        with new.open("wb") as file:
            file.write(content[:100])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(OSError, match="No space left"):
        store.close()
    assert path.read_bytes() == before
    assert sorted(file.name for file in path.parent.iterdir()) == [path.name, f"{path.name}.journal"]
    assert read(path).identical(as_dataset(ROWS, HEADER))


def test_the_file_follows_the_journal_from_time_to_time(path, monkeypatch):
    monkeypatch.setattr("gallop_fmu.store.RENEWAL", 0.0)
    store = _filled(path, ROWS[:1])
    assert path.exists()
    journal_of(path).rename(path.with_name("aside"))
    assert np.array_equal(read(path).run.values, [0])
    store.release()
