"""Rows on disk are read back unchanged, also after an interrupted program."""

import hashlib
import json
import math
import random
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import gallop_fmu as gf
from gallop_fmu.sweeps.journal import as_line, journal_of, seal_of
from gallop_fmu.sweeps.results_file import as_dataset, rows_of
from gallop_fmu.sweeps.row_store import RowStore, read
from gallop_fmu.sweeps.rows import ERROR, FORMAT

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
    {
        "outcome": "completed",
        "sag": 0.1 + 0.2,
        "note": "ice, \u00fc\u201c\n",
        "steps": 10,
        "swings": True,
    },
    {"outcome": "slack", "sag": math.nan, "note": None, "steps": 12, "swings": False},
    {"outcome": "completed", "sag": -1e-308, "note": "x", "steps": 2**53 + 1, "swings": True},
]
ROWS = [{"run": run, "wind.speed": 4.0 + run, "message": "", **row} for run, row in enumerate(ROWS)]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "runs.parquet"


def _taken(path, *begin):
    """The rows that a sweep resumes from."""
    store = RowStore(path, HEADER, *begin)
    store.release()
    return store.rows


both_formats = pytest.mark.parametrize("suffix", [".nc", ".parquet"])


def _filled(path, rows=ROWS):
    store = RowStore(path, HEADER)
    store.add(rows)
    return store


@both_formats
def test_rows_are_read_back_bit_for_bit(tmp_path, suffix):
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
    assert sorted(file.name for file in path.parent.iterdir()) == [
        path.name,
        f"{path.name}.journal",
    ]
    journal_of(path).unlink()  # then the file itself is read
    assert read(path).identical(found)


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
        assert json.loads(line.split("\t")[0], parse_constant=pytest.fail)


def test_a_journal_cut_anywhere_loses_only_the_row_that_was_cut(path):
    _filled(path).release()
    whole = journal_of(path).read_bytes()
    ends = [k + 1 for k, byte in enumerate(whole) if byte == 10]
    assert len(ends) == 4
    for cut in sorted(
        {*range(0, len(whole), 7), *(end + more for end in ends[:-1] for more in (-1, 0, 1))}
    ):
        journal_of(path).write_bytes(whole[:cut])
        kept = max(0, sum(end <= cut for end in ends) - 1)
        assert sorted(_taken(path)) == list(range(kept))
    for cut in (5, ends[0], ends[1] + 7, ends[2] - 1):
        journal_of(path).write_bytes(whole[:cut])
        again = RowStore(path, HEADER)
        again.add(row for row in ROWS if row["run"] not in again.rows)
        assert journal_of(path).read_bytes() == whole
        again.release()


def test_the_journal_stays_so_that_a_sweep_can_go_on(path):
    _filled(path, ROWS[:2]).close()
    again = RowStore(path, HEADER)
    again.add(ROWS[2:])
    again.close()
    assert read(path).identical(as_dataset(ROWS, HEADER))
    path.unlink()
    RowStore(path, HEADER).close()
    journal_of(path).unlink()
    assert read(path).identical(as_dataset(ROWS, HEADER))


def test_a_file_without_its_journal_is_not_overwritten(path):
    _filled(path).close()
    journal_of(path).unlink()
    content = path.read_bytes()
    with pytest.raises(
        gf.SceneError,
        match=r"runs.parquet: exists already, and a sweep cannot continue it without its",
    ):
        RowStore(path, HEADER)
    assert path.read_bytes() == content
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_runs_with_an_unexpected_exception_are_repeated(path):
    store = _filled(path, [*ROWS[:2], {**ROWS[2], "outcome": ERROR}])
    store.close()
    assert read(path).run.values.tolist() == [0, 1, 2]
    again = RowStore(path, HEADER)
    assert sorted(again.rows) == [0, 1]
    again.add(ROWS[2:])
    again.close()
    assert read(path).outcome.values.tolist() == ["completed", "slack", "completed"]


def test_a_complete_file_is_not_touched(path):
    _filled(path).close()
    before = path.stat().st_mtime_ns
    RowStore(path, HEADER).close()
    assert path.stat().st_mtime_ns == before


@pytest.mark.parametrize("key", ["package", "task", "scenes"])
@pytest.mark.parametrize("complete", [True, False])
def test_another_sweep_is_refused(path, key, complete):
    store = _filled(path)
    store.close() if complete else store.release()
    with pytest.raises(
        gf.SceneError, match=f"results of another sweep: {key} was .*, is other. Give another file"
    ):
        RowStore(path, {**HEADER, key: "other"})
    assert read(path).sizes["run"] == 3


@both_formats
def test_foreign_files_are_refused(tmp_path, suffix):
    path = tmp_path / f"runs{suffix}"
    path.write_bytes(b"something else")
    with pytest.raises(gf.SceneError, match="exists already"):
        RowStore(path, HEADER)
    with pytest.raises(gf.SceneError, match="not the results of a sweep"):
        read(path)
    assert path.read_bytes() == b"something else"
    path.unlink()
    journal_of(path).write_text("my diary\n")
    with pytest.raises(gf.SceneError, match="not the journal of a sweep"):
        RowStore(path, HEADER)


def test_datasets_of_others_are_refused(tmp_path):
    xr.Dataset({"u2": ("time", [0.0])}).to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    with pytest.raises(gf.SceneError, match="not the results of a sweep"):
        read(tmp_path / "run.nc")


@pytest.mark.parametrize(
    ("name", "fragment"),
    [
        ("a.csv", "must end in .parquet or .nc"),
        ("none/a.nc", "there is no folder"),
        ("folder.nc", "is a folder"),
    ],
)
def test_names_that_are_refused(tmp_path, name, fragment):
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(gf.SceneError, match=fragment):
        RowStore(tmp_path / name, HEADER)


def test_parquet_without_pyarrow_has_a_remedy(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(
        gf.SceneError, match=r'pip install "gallop-fmu\[parquet\]", or give a name that ends in .nc'
    ):
        RowStore(tmp_path / "a.parquet", HEADER)


def test_a_file_is_replaced_as_a_whole(path, monkeypatch):
    """A failure while the new file is written leaves the old one."""
    store = _filled(path, ROWS[:2])
    store.export()
    before = path.read_bytes()
    store.add(ROWS[2:])

    def full(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space left"):
        store.close()
    assert path.read_bytes() == before
    assert sorted(file.name for file in path.parent.iterdir()) == [
        path.name,
        f"{path.name}.journal",
    ]
    assert read(path).identical(as_dataset(ROWS, HEADER))


def test_the_file_follows_the_journal_from_time_to_time(path, monkeypatch):
    monkeypatch.setattr("gallop_fmu.sweeps.row_store.EXPORT_INTERVAL", 0.0)
    store = _filled(path, ROWS[:1])
    assert path.exists()
    journal_of(path).rename(path.with_name("aside"))
    assert np.array_equal(read(path).run.values, [0])
    store.release()


@both_formats
def test_without_a_row_there_are_columns_and_no_files(tmp_path, suffix):
    """As after Ctrl-C in the first run."""
    path = tmp_path / f"runs{suffix}"
    store = RowStore(path, HEADER)
    assert store.dataset().sizes == {"run": 0}
    assert {"run", "wind.speed", "sag", "outcome"} <= set(store.dataset().variables)
    assert (store.dataset().outcome.values != "completed").tolist() == []
    store.close()
    assert list(tmp_path.iterdir()) == []


def test_one_sweep_at_a_time_has_a_file(path):
    first = _filled(path, ROWS[:1])
    link = path.with_name("link.parquet")
    link.symlink_to(path.name)
    elsewhere = (
        f"from gallop_fmu.sweeps.row_store import RowStore; RowStore({str(path)!r}, {HEADER!r})"
    )
    for other in (path, link):
        with pytest.raises(
            gf.SceneError,
            match=r"another sweep writes this file \(.*runs.parquet.journal is locked\); ",
        ):
            RowStore(other, HEADER)
    done = subprocess.run([sys.executable, "-P", "-c", elsewhere], capture_output=True, text=True)
    assert "another sweep writes this file" in done.stderr
    assert read(path).run.values.tolist() == [0]  # reading it is allowed
    first.add(ROWS[1:])
    first.close()
    assert sorted(_taken(path)) == [0, 1, 2]


def _forged(path, rows, header=HEADER, sealed_for=HEADER):
    """A journal whose checksums are right."""
    seal = seal_of(json.loads(json.dumps(sealed_for)))
    journal_of(path).write_bytes(as_line(header) + b"".join(as_line(row, seal) for row in rows))


NOT_OURS = "not the journal of a sweep, or damaged; remove it to compute all runs again"


def test_rows_of_another_task_are_never_taken(path):
    """Two sweeps once wrote into one journal: rows of one below the header of the other."""
    _forged(path, ROWS)
    assert sorted(_taken(path)) == [0, 1, 2]
    _forged(path, ROWS, sealed_for={**HEADER, "scenes": "another"})
    for reader in (read, _taken):
        with pytest.raises(gf.SceneError, match=NOT_OURS):
            reader(path)


@pytest.mark.parametrize(
    "header",
    [
        {"format": 1},
        {"runs": True},
        {"runs": 10**20},
        {"grid": {"a": list(range(1000)), "b": list(range(1000))}},
        {"grid": {"wind.speed": 3}},
        {"grid": {"": [1, 2, 3]}},
        {"columns": {"sag": ["m"]}},
        {"columns": {"sag": [{}, []]}},
        {"columns": {"a\u0000b": ["m", "sag"]}},
        {"scenes": None},
    ],
)
def test_headers_that_no_sweep_writes(path, header):
    _forged(path, [], {**HEADER, **header}, {**HEADER, **header})
    with pytest.raises(gf.SceneError, match=NOT_OURS):
        gf.read_runs(path)


@pytest.mark.parametrize("header", [{"columns": {}}, {"grid": {"wind.speed": [4.0, 5.0, 7.0]}}])
def test_a_header_with_other_values_of_the_same_sweep(path, header):
    _forged(path, [], {**HEADER, **header}, {**HEADER, **header})
    with pytest.raises(gf.SceneError, match=NOT_OURS):
        RowStore(path, HEADER)


@pytest.mark.parametrize(
    "row",
    [
        {"run": 3},
        {"run": -1},
        {"run": True},
        {"run": 1.0},
        {"outcome": None},
        {"message": 5},
        {"steps": 2**63},
        {"sag": [1.0]},
        {"sag": {"a": 1}},
        {"sag": "0.3"},
        {"wind.speed": ...},
        {"wind.speed": 99.0},
        {"wind.speed": 5},
        {"wind.speed": "5.0"},
        {"": 1.0},
        {"a\ud800": 1.0},
        {"note": "a\u0000b"},
        {"note": "\udcff"},
        5,
    ],
)
def test_rows_that_no_sweep_writes(path, row):
    row = (
        {k: v for k, v in {**ROWS[1], **row}.items() if v is not ...}
        if isinstance(row, dict)
        else row
    )
    seal = seal_of(HEADER)
    text = json.dumps(row)
    journal_of(path).write_bytes(
        as_line(HEADER) + as_line(ROWS[0], seal) + _line(text.encode(), seal)
    )
    for reader in (gf.read_runs, _taken):
        with pytest.raises(gf.SceneError, match=NOT_OURS):
            reader(path)


def _line(text, seal=b""):
    return b"%b\t%b\n" % (text, hashlib.blake2b(text, digest_size=8, key=seal).hexdigest().encode())


@pytest.mark.parametrize(
    "row", [{"label.pole": "13"}, {"label.pole": 12}, {"label.pole": ...}, {"a/b": 1.0}]
)
def test_rows_must_begin_as_their_runs_do(path, row):
    begun = [{**ROWS[0], "label.pole": "12", **row}]
    _forged(path, [{key: value for key, value in begun[0].items() if value is not ...}])
    with pytest.raises(gf.SceneError, match=NOT_OURS):
        RowStore(
            path, HEADER, lambda run: {"run": run, "wind.speed": 4.0 + run, "label.pole": "12"}
        )


@pytest.mark.parametrize("text", [b"[" * 100_000, b"1" * 5000, b"\xff\xfe", b"", b"[]"])
def test_lines_that_are_no_journal(path, text):
    journal_of(path).write_bytes(_line(text))
    with pytest.raises(gf.SceneError, match=NOT_OURS):
        gf.read_runs(path)


def test_a_changed_journal_is_refused_or_loses_rows(path):
    _filled(path).release()
    good = journal_of(path).read_bytes()
    rows = _taken(path)
    chance, refusals = random.Random(0), []
    for _ in range(200):
        changed = bytearray(good)
        for _ in range(chance.choice([1, 1, 2, 8])):
            place = chance.randrange(len(changed))
            if chance.random() < 0.5:
                changed[place] ^= 1 << chance.randrange(8)
            else:
                del changed[place : place + chance.choice([1, 8, 64, 1000])]
        journal_of(path).write_bytes(changed)
        try:
            found = _taken(path)
        except gf.SceneError as problem:
            refusals.append(str(problem))
        else:
            assert found == {run: rows[run] for run in found}
    assert len(refusals) > 50
    assert all(NOT_OURS in refusal for refusal in refusals)


def test_journals_that_are_no_files(path):
    journal_of(path).symlink_to("/dev/zero")
    for reader in (read, _taken):
        with pytest.raises(gf.SceneError, match="journal"):
            reader(path)
    journal_of(path).unlink()
    journal_of(path).mkdir()
    with pytest.raises(gf.SceneError, match="is a folder"):
        RowStore(path, HEADER)


def test_a_truth_among_numbers_is_not_one():
    header = {"grid": {}, "columns": {}}
    rows = [
        {"run": 0, "a": True, "b": True},
        {"run": 1, "a": 3, "b": False},
        {"run": 2, "a": 2.5, "b": None},
    ]
    found = as_dataset(rows, header)
    assert found.a.values.tolist() == ["True", "3", "2.5"]
    assert found.b.values.tolist()[:2] == [1.0, 0.0]
