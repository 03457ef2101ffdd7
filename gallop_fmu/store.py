"""Rows of results on disk: nothing that was computed is lost, whatever ends the program.

Beside the file of results stands a journal, ``FILE.journal``: a header, then one line of JSON a row, each with its
checksum, written as soon as the row is there. The file itself is rewritten as a whole from time to time, under another
name that then takes its place. So after an interruption at any instant there is a readable file, and a journal with
every row but those under way. The journal goes when all rows are in the file.
"""

from __future__ import annotations

import json
import math
import os
import time as clock
from collections.abc import Iterable, Mapping
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.errors import SceneError
from gallop_fmu.files import netcdf_bytes, write_whole
from gallop_fmu.reading import DIGEST, HEADER, LARGEST, UnreadableError, as_line, content_of, digest_of, lines_of

if TYPE_CHECKING:
    import xarray as xr

Row = dict[str, Any]
"""Column to number, truth, text or None (not there)."""

SUFFIXES = (".parquet", ".nc")
RENEWAL = 20.0
"""Wall-clock time [s] between two rewritings of the file, about; longer where it takes long."""
RENEWAL_SHARE = 0.05
"""Largest share of the time that goes into rewriting."""

FORMAT = "gallop-fmu runs 2"

ERROR = "error"
"""Outcome of a run that ended in something unforeseen, such as lack of memory: a resumed sweep tries it again."""


class Store:
    """The rows of one sweep, and their file, if there is one.

    Parameters
    ----------
    path
        File to write, ``.parquet`` or ``.nc``; None keeps the rows in memory only.
    header
        What the rows belong to: texts by which a resumed sweep knows its own file (``package``, ``task``, ``scenes``),
        and ``runs``, ``grid`` and ``columns``.

    Raises
    ------
    SceneError
        If the file cannot be a file of results, or belongs to something else.
    """

    def __init__(self, path: Path | str | None, header: dict[str, Any]) -> None:
        self.path = None if path is None else Path(path)
        self.header = {"format": FORMAT, **header}
        self.rows: dict[int, Row] = {}
        self._journal: Any = None
        self._length = 0  # of what an earlier sweep left in the journal
        self._renewed, self._cost = clock.monotonic(), 0.0
        if self.path is not None:
            _check_path(self.path)
            self._resume(self.path)

    def dataset(self) -> xr.Dataset:
        """All rows so far, in the order of their runs."""
        return as_dataset([self.rows[run] for run in sorted(self.rows)], self.header)

    def add(self, rows: Iterable[Row]) -> None:
        """Keep rows, first in memory and then on disk.

        Raises
        ------
        OSError
            If they cannot be written.
        """
        rows = list(rows)
        self.rows.update((row["run"], row) for row in rows)
        if self.path is None:
            return
        if self._journal is None:
            self._open(journal_of(self.path))
        self._append(b"".join(map(as_line, rows)))
        now = clock.monotonic()
        if now - self._renewed > max(RENEWAL, self._cost / RENEWAL_SHARE):
            os.fsync(self._journal.fileno())
            with suppress(OSError):  # open elsewhere, on Windows; the journal has the rows, and `close` will complain
                self.renew()
            self._renewed = clock.monotonic()
            self._cost = self._renewed - now

    def renew(self) -> None:
        """Rewrite the file with all rows so far.

        Raises
        ------
        OSError
            If it cannot be written; the file from before is kept.
        """
        if self.path is not None:
            write(self.dataset(), self.path)

    def close(self) -> None:
        """Write the file, and remove the journal if every run has its row.

        Raises
        ------
        OSError
            If the file cannot be written; the journal is kept.
        """
        if self.path is None or not journal_of(self.path).exists():
            return
        self.release()
        self.renew()
        if len(self.rows) == self.header["runs"]:
            journal_of(self.path).unlink()

    def on_disk(self) -> int:
        """How many rows would be found by whoever reads the disk."""
        found = None if self.path is None else _load(self.path)
        return 0 if found is None else len(found.rows)

    def release(self) -> None:
        """Close the journal as it is."""
        if self._journal is not None:
            self._journal.close()
            self._journal = None

    def _resume(self, path: Path) -> None:
        """Take over what an earlier sweep left."""
        found = _load(path)
        if found is not None:
            self._compare(found.header)
            self.rows = {run: row for run, row in found.rows.items() if row["outcome"] != ERROR}
            self._length = found.length

    def _open(self, journal: Path) -> None:
        self._journal = journal.open("ab", buffering=0)  # no row waits in a buffer
        self._journal.truncate(self._length)  # without what a killed program wrote of its last line
        if not self._length:
            self._append(as_line(self.header))

    def _append(self, lines: bytes) -> None:
        data = memoryview(lines)
        while data:  # a disk that fills takes a part first, and refuses the next
            data = data[self._journal.write(data) :]

    def _compare(self, found: Mapping[str, Any]) -> None:
        differences = [
            f"{key} was {found.get(key)}, is {self.header[key]}"
            for key in ("package", "task", "scenes")
            if found.get(key) != self.header[key]
        ]
        if differences:
            raise SceneError(
                f"{self.path} holds the results of something else: {'; '.join(differences)}. Give another file, or "
                f"remove this one and {journal_of(Path(str(self.path))).name} to begin anew"
            )


def journal_of(path: Path) -> Path:
    """Where the rows of a sweep under way stand."""
    return path.with_name(path.name + ".journal")


def read(path: Path | str) -> xr.Dataset:
    """The rows of a file of results, complete or not; the journal is taken where there is one.

    Raises
    ------
    SceneError
        If it is none.
    """
    path = Path(path)
    _check_path(path)
    found = _load(path)
    if found is None:
        raise SceneError(f"{path}: no such file")
    return as_dataset([found.rows[run] for run in sorted(found.rows)], found.header)


def as_dataset(rows: list[Row], header: dict[str, Any]) -> xr.Dataset:
    """One array a column over the dimension ``run``; what is missing is NaN, or an empty text."""
    import xarray as xr

    columns = dict.fromkeys(("run", *(key for row in rows for key in row)))
    variables = {name: ("run", _array([row.get(name) for row in rows])) for name in columns}
    dataset = xr.Dataset(variables, attrs={HEADER: json.dumps(header)})
    for name, (unit, meaning) in header["columns"].items():
        if name in dataset:
            dataset[name].attrs = {"long_name": meaning, **({"units": unit} if unit else {})}
    return dataset


def rows_of(dataset: xr.Dataset) -> list[Row]:
    """The rows that `as_dataset` was given."""
    columns = {str(name): values.values.tolist() for name, values in dataset.variables.items()}
    count = dataset.sizes["run"]
    return [{name: _missing_as_none(values[k]) for name, values in columns.items()} for k in range(count)]


def write(dataset: xr.Dataset, path: Path) -> None:
    """Write a file as a whole: whoever reads it finds the old one or the new one."""
    columns = {str(name): values.values for name, values in dataset.variables.items()}
    sealed = dataset.assign_attrs({DIGEST: digest_of(dataset.attrs[HEADER], columns)})
    write_whole(path, _as_parquet(sealed) if path.suffix == ".parquet" else netcdf_bytes(sealed))


def _check_path(path: Path) -> None:
    if path.suffix not in SUFFIXES:
        raise SceneError(f"{path}: must end in {' or '.join(SUFFIXES)}, which decides the format")
    if path.is_dir():
        raise SceneError(f"{path}: is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise SceneError(f"{path}: there is no folder {path.parent}; make it first")
    if path.suffix == ".parquet":
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise SceneError(
                f'{path}: Parquet needs pyarrow; pip install "gallop-fmu[parquet]", or give a name that ends in .nc'
            ) from None


class _Found(NamedTuple):
    """What stands on disk: the header, the rows by run, and the length of the journal in whole lines."""

    header: dict[str, Any]
    rows: dict[int, Row]
    length: int


def _load(path: Path) -> _Found | None:
    """The rows of the file and of its journal, which has the later ones; None where there is neither."""
    file, journal = _read_file(path), _read_journal(journal_of(path))
    if file is None or journal is None:
        return file or journal
    return journal if file.header != journal.header else journal._replace(rows={**file.rows, **journal.rows})


def _read_file(path: Path) -> _Found | None:
    if not path.exists():
        return None
    try:
        return _found(lines_of(path))
    except UnreadableError:
        raise SceneError(
            f"{path}: exists, but does not hold the results of a sweep, or is damaged; give another name, or remove it "
            "to begin anew"
        ) from None
    except OSError as problem:
        raise SceneError(f"{path}: cannot be read ({problem.strerror})") from None


def _read_journal(journal: Path) -> _Found | None:
    if not journal.exists():
        return None
    try:
        if not journal.is_file() or journal.stat().st_size > LARGEST:
            raise UnreadableError
        data = journal.read_bytes()
        whole = data[: data.rfind(b"\n") + 1]  # a killed program may leave half a line
        return _found(whole) if whole else None
    except UnreadableError:
        raise SceneError(f"{journal}: is not the journal of a sweep, or damaged; remove it to begin anew") from None
    except OSError as problem:
        raise SceneError(f"{journal}: cannot be read ({problem.strerror})") from None


def _found(lines: bytes) -> _Found:
    """What lines mean, each of which must be as this module writes it.

    Raises
    ------
    UnreadableError
        If one is not.
    """
    header, *rows = [content_of(line) for line in lines.split(b"\n")[:-1]] or [None]
    if not (_is_header(header) and all(_is_row(row, header) for row in rows)):
        raise UnreadableError
    return _Found(header, {row["run"]: row for row in rows}, len(lines))


def _is_header(header: Any) -> bool:
    return (
        isinstance(header, dict)
        and header.get("format") == FORMAT
        and all(isinstance(header.get(key), str) for key in ("package", "task", "scenes"))
        and _is_whole(header.get("runs"))
        and isinstance(header.get("grid"), dict)
        and all(isinstance(values, list) for values in header["grid"].values())
        and math.prod(map(len, header["grid"].values())) == header["runs"]
        and isinstance(header.get("columns"), dict)
        and all(
            isinstance(told, list) and len(told) == 2 and all(isinstance(text, str) for text in told)
            for told in header["columns"].values()
        )
    )


def _is_row(row: Any, header: Mapping[str, Any]) -> bool:
    return (
        isinstance(row, dict)
        and _is_whole(row.get("run"))
        and 0 <= row["run"] < header["runs"]
        and all(isinstance(row.get(key), str) for key in ("outcome", "message"))
        and header["grid"].keys() <= row.keys()
        and all(value is None or isinstance(value, (str, float, bool)) or _is_whole(value) for value in row.values())
    )


def _is_whole(value: Any) -> bool:
    """Whether it is a whole number that an array can hold."""
    return isinstance(value, int) and not isinstance(value, bool) and -(2**63) <= value < 2**63


def _array(values: list[Any]) -> NDArray[Any]:
    there = [value for value in values if value is not None]
    whole = len(there) == len(values)
    if whole and there and all(isinstance(value, bool) for value in there):
        return np.array(values, dtype=np.bool_)
    if whole and there and all(isinstance(value, int) for value in there):
        return np.array(values, dtype=np.int64)
    if all(isinstance(value, (bool, int, float)) for value in there):
        return np.array([math.nan if value is None else value for value in values], dtype=np.float64)
    return np.array(["" if value is None else str(value) for value in values], dtype=object)


def _missing_as_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _as_parquet(dataset: xr.Dataset) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    columns = {str(name): pa.array(values.values) for name, values in dataset.variables.items()}
    fields = [pa.field(name, column.type, metadata=dataset[name].attrs) for name, column in columns.items()]
    schema = pa.schema(fields, metadata={name: dataset.attrs[name] for name in (HEADER, DIGEST)})
    buffer = BytesIO()
    parquet.write_table(pa.table(list(columns.values()), schema=schema), buffer)
    return buffer.getvalue()
