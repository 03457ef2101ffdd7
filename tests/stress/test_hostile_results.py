"""Files and journals of a sweep that are damaged, or mean harm: one clear message, and nothing is executed."""

import json
import os
import pickle
import random
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyarrow import parquet

import gallop_fmu as gf
from gallop_fmu import reading
from gallop_fmu.store import Store, journal_of, read

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / "tools")]

from fuzz_results import changed, sweep_rows  # noqa: E402

COUNT = 12
HEADER, ROWS = sweep_rows(COUNT)
DAMAGED = "does not hold the results of a sweep, or is damaged|no such file"
NO_JOURNAL = "is not the journal of a sweep, or damaged"
both_formats = pytest.mark.parametrize("suffix", [".nc", ".parquet"])


def written(path, rows=ROWS):
    """A finished file of results."""
    store = Store(path, HEADER)
    store.add(rows)
    store.close()
    return path


def left_behind(path):
    """The journal of a sweep under way."""
    store = Store(path, HEADER)
    store.add(ROWS)
    store.release()
    return journal_of(path)


@both_formats
def test_a_changed_file_is_refused_or_holds_the_same(tmp_path, suffix):
    path, refusals = written(tmp_path / f"runs{suffix}"), []
    good, whole = path.read_bytes(), read(path)
    for seed in range(5):
        path.write_bytes(changed(good, random.Random(seed)))
        try:
            assert read(path).identical(whole)
        except gf.SceneError as problem:
            refusals.append(str(problem))
    assert len(refusals) >= 2
    assert all("or is damaged; give another name" in refusal for refusal in refusals)


@both_formats
def test_a_wrong_bit_in_a_number_is_seen(tmp_path, suffix):
    """Neither format has checksums of its own here."""
    path = written(tmp_path / f"runs{suffix}", [{**row, "sag": 0.7} for row in ROWS])
    good = path.read_bytes()
    at = good.index(np.float64(0.7).tobytes())
    path.write_bytes(good[:at] + bytes([good[at] ^ 1]) + good[at + 1 :])
    with pytest.raises(gf.SceneError, match=DAMAGED):
        read(path)


@pytest.fixture(scope="module")
def journal(tmp_path_factory):
    """A journal to be changed, and what it held."""
    journal = left_behind(tmp_path_factory.mktemp("journal") / "runs.nc")
    return journal, journal.read_bytes()


@settings(max_examples=300)
@given(seed=st.integers(0, 2**32))
def test_a_changed_journal_is_refused_or_loses_rows(journal, seed):
    path, good = journal
    path.write_bytes(changed(good, random.Random(seed)))
    try:
        found = Store(path.with_suffix(""), HEADER).rows
    except gf.SceneError as problem:
        refusal = str(problem)
    else:
        refusal = ""
        assert found == {run: ROWS[run] for run in found}
    assert not refusal or "is not the journal of a sweep, or damaged" in refusal


@pytest.mark.parametrize(
    "header",
    [
        [],
        {"format": 1},
        {**HEADER, "runs": True},
        {**HEADER, "runs": 10**20},
        {**HEADER, "grid": {"a": list(range(1000)), "b": list(range(1000))}},
        {**HEADER, "grid": {"wind.speed": COUNT}},
        {**HEADER, "columns": {"sag": ["m"]}},
        {**HEADER, "columns": {"sag": [{}, []]}},
        {key: value for key, value in HEADER.items() if key != "scenes"},
    ],
)
def test_headers_that_no_sweep_writes(tmp_path, header):
    text = json.dumps(header).encode()
    journal_of(tmp_path / "runs.nc").write_bytes(b"%b\t%08x\n" % (text, reading.crc32(text)))
    with pytest.raises(gf.SceneError, match=NO_JOURNAL):
        gf.read_runs(tmp_path / "runs.nc")


@pytest.mark.parametrize(
    "row",
    [
        {"run": COUNT},
        {"run": -1},
        {"run": True},
        {"run": 1.0},
        {"outcome": None},
        {"message": 5},
        {"steps": 2**63},
        {"sag": [1.0]},
        {"sag": {"a": 1}},
        {"wind.speed": ...},
        5,
    ],
)
def test_rows_that_no_sweep_writes(tmp_path, row):
    row = {k: v for k, v in {**ROWS[3], **row}.items() if v is not ...} if isinstance(row, dict) else row
    lines = [reading.as_line(HEADER), reading.as_line(ROWS[0])]
    text = json.dumps(row).encode()
    journal_of(tmp_path / "runs.nc").write_bytes(b"".join([*lines, b"%b\t%08x\n" % (text, reading.crc32(text))]))
    with pytest.raises(gf.SceneError, match=NO_JOURNAL):
        gf.read_runs(tmp_path / "runs.nc")


@pytest.mark.parametrize("text", [b"[" * 100_000, b"1" * 5000, b"\xff\xfe", b""])
def test_lines_that_are_no_json(tmp_path, text):
    journal_of(tmp_path / "runs.nc").write_bytes(b"%b\t%08x\n" % (text, reading.crc32(text)))
    with pytest.raises(gf.SceneError, match=NO_JOURNAL):
        gf.read_runs(tmp_path / "runs.nc")


def test_what_is_no_file(tmp_path):
    """A pipe that nobody writes to, a device without end, a folder."""
    path = tmp_path / "runs.nc"
    os.mkfifo(path)
    with pytest.raises(gf.SceneError, match=DAMAGED):
        read(path)
    path.unlink()
    journal_of(path).symlink_to("/dev/zero")
    with pytest.raises(gf.SceneError, match=NO_JOURNAL):
        read(path)
    journal_of(path).unlink()
    journal_of(path).mkdir()
    with pytest.raises(gf.SceneError, match=NO_JOURNAL):
        read(path)


def _netcdf_without_end(path):
    with h5py.File(path, "w") as file:
        file.create_dataset("run", shape=(10**13,), chunks=(10**6,), dtype="f8")
        file.attrs[reading.HEADER] = file.attrs[reading.DIGEST] = "x"


def _netcdf_of_elsewhere(path):
    with h5py.File(path, "w") as file:
        file["run"] = h5py.ExternalLink("other.nc", "/run")
        file.attrs[reading.HEADER] = file.attrs[reading.DIGEST] = "x"


def _parquet_without_end(path):
    """One text of 50 MB, a thousand times: some kB of file."""
    texts = pa.DictionaryArray.from_arrays(pa.array(np.zeros(1000, dtype=np.int32)), pa.array(["x" * 50_000_000]))
    schema = pa.schema([pa.field("run", texts.type)], metadata={reading.HEADER: "x", reading.DIGEST: "x"})
    parquet.write_table(pa.table([texts], schema=schema), path, compression="zstd", store_schema=False)
    assert parquet.read_schema(path).field("run").type == pa.string()


@pytest.mark.parametrize(
    ("name", "make"),
    [("a.nc", _netcdf_without_end), ("b.nc", _netcdf_of_elsewhere), ("c.parquet", _parquet_without_end)],
)
def test_files_that_ask_for_the_whole_machine_or_for_other_files(tmp_path, name, make):
    make(tmp_path / name)
    assert (tmp_path / name).stat().st_size < 100_000
    began = time.process_time()
    with pytest.raises(gf.SceneError, match=DAMAGED):
        read(tmp_path / name)
    assert time.process_time() - began < 5.0


def test_reading_that_does_not_end(tmp_path, monkeypatch):
    path = written(tmp_path / "runs.nc")
    monkeypatch.setattr(reading, "SECONDS", 0.01)
    with pytest.raises(gf.SceneError, match=DAMAGED):
        read(path)


class Harm:
    """Pickled, it makes a file when it is loaded."""

    def __init__(self, file):
        self.file = str(file)

    def __reduce__(self):
        return open, (self.file, "w")


def test_pickles_are_not_loaded(tmp_path):
    """Where Arrow, and others that keep objects in HDF5, have looked for them."""
    harm = pickle.dumps(Harm(tmp_path / "harm"))
    names = [b"arrow.py_extension_type", b"pandas.period"]
    for name in names:
        metadata = {b"ARROW:extension:name": name, b"ARROW:extension:metadata": harm}
        field = pa.field("run", pa.int64(), metadata=metadata)
        schema = pa.schema([field], metadata={reading.HEADER: "x", reading.DIGEST: "x"})
        parquet.write_table(pa.table([pa.array([0])], schema=schema), tmp_path / "runs.parquet")
        with pytest.raises(gf.SceneError, match=DAMAGED):
            read(tmp_path / "runs.parquet")
    with h5py.File(tmp_path / "runs.nc", "w") as file:
        file["run"] = np.array([np.void(harm)])
        file.attrs[reading.HEADER] = file.attrs[reading.DIGEST] = np.void(harm)
    with pytest.raises(gf.SceneError, match=DAMAGED):
        read(tmp_path / "runs.nc")
    assert not (tmp_path / "harm").exists()
    pickle.loads(harm).close()
    assert (tmp_path / "harm").exists()  # it would have been seen


def test_the_command_line_says_it_in_one_message(tmp_path):
    path = written(tmp_path / "runs.nc")
    path.write_bytes(path.read_bytes()[:3000])
    words = ["sweep", "example3", "--over", "wind.speed=4,5", "--until", "1", "--out", str(path)]
    command = [sys.executable, "-P", "-c", "from gallop_fmu.cli import main; main()", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert "or is damaged; give another name, or remove it to begin anew" in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr
    assert "Error" not in done.stderr
