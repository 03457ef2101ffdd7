"""Rows of results on disk: nothing that was computed is lost, whatever ends the program.

Beside the file of results, ``FILE``, is its journal, ``FILE.journal``: a header, then one line of
JSON a row, each with a seal, written as soon as the row is there. A sweep takes rows over from its
journal and from nothing else, and only one sweep at a time can write it. ``FILE`` is an export for
other programs: it is rewritten as a whole from time to time and at the end. The journal stays, so
that the same sweep can be repeated, or completed, later.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.atomic_write import (
    check_target,
    netcdf_bytes,
    open_exclusive,
    write_whole,
)
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_rules import is_printable

if TYPE_CHECKING:
    import xarray as xr

Row = dict[str, Any]
"""Column to number, truth, text or None (not there)."""

HEADER = "gallop_fmu"
"""Attribute of a dataset and of its file that holds the header as JSON."""
SUFFIXES = (".parquet", ".nc")
RENEWAL = 20.0
"""Wall-clock time [s] between two rewritings of the file, about; longer where it takes long."""
RENEWAL_SHARE = 0.05
"""Largest share of the time that goes into rewriting."""
LARGEST = 2**32
"""Size [bytes] beyond which a journal is taken for a mistake."""

FORMAT = "gallop-fmu runs 3"

ERROR = "error"
"""Outcome of a run that ended in something unforeseen, such as lack of memory: a resumed sweep tries it again."""
VARIED = "varied"
"""Meaning of a column that is an input of the runs."""
TEXTS = ("outcome", "message")
"""Columns that are text in every row."""


class UnreadableError(ValueError):
    """A journal that holds something else, or is damaged."""


class Store:
    """The rows of one sweep, and their files, if there are any.

    Parameters
    ----------
    path
        File to write, ``.parquet`` or ``.nc``; None keeps the rows in memory only.
    header
        What the rows belong to: texts by which a resumed sweep recognises its own rows
        (``package``, ``task``, ``scenes``), and ``runs``, ``grid`` and ``columns``.
    begin
        From the number of a run to the columns and values that its row begins with; rows that are
        taken over must begin so.

    Raises
    ------
    SceneError
        If the file cannot be written, another sweep is writing it, or the journal belongs to
        something else.
    """

    def __init__(
        self,
        path: Path | str | None,
        header: dict[str, Any],
        begin: Callable[[int], Row] = lambda run: {"run": run},
    ) -> None:
        self.path = None if path is None else Path(path)
        self.header: dict[str, Any] = json.loads(json.dumps({"format": FORMAT, **header}))
        self.rows: dict[int, Row] = {}
        self._begin, self._seal = begin, seal_of(self.header)
        self._journal: BinaryIO | None = None
        self._length = 0  # of the journal
        self._exported = True
        self._renewed, self._cost = clock.monotonic(), 0.0
        if self.path is not None:
            check_results(self.path)
            self._journal = _open_journal(self.path)
            try:
                self._resume(self.path, self._journal)
            except BaseException:
                self.release()
                raise

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
        if self._journal is None or not rows:
            return
        self._exported = False
        if not self._length:
            self._append(as_line(self.header))
        self._append(b"".join(as_line(row, self._seal) for row in rows))
        now = clock.monotonic()
        if now - self._renewed > max(RENEWAL, self._cost / RENEWAL_SHARE):
            os.fsync(self._journal.fileno())
            with suppress(
                OSError
            ):  # open elsewhere, on Windows; the journal has the rows, and `close` will complain
                self.export()
            self._renewed = clock.monotonic()
            self._cost = self._renewed - now

    def export(self) -> None:
        """Rewrite the file with all rows so far.

        Raises
        ------
        OSError
            If it cannot be written; the file from before is kept.
        """
        if self.path is not None:
            write(self.dataset(), self.path)
            self._exported = True

    def close(self) -> None:
        """Write the file if rows were added since it was written last, and close the journal.

        Raises
        ------
        OSError
            If the file cannot be written; the journal is kept.
        """
        try:
            if not self._exported:
                self.export()
        finally:
            self.release()

    def on_disk(self) -> int:
        """Number of rows that are in the journal."""
        found = None if self.path is None else _load(journal_of(self.path))
        return 0 if found is None else len(found.rows)

    def release(self) -> None:
        """Close the journal, which unlocks it; remove it if it has no row."""
        if self._journal is None or self.path is None:
            return
        with self._journal as journal:
            if not os.fstat(journal.fileno()).st_size:
                with suppress(OSError):
                    journal_of(self.path).unlink()
        self._journal = None

    def _resume(self, path: Path, journal: BinaryIO) -> None:
        """Take over the rows that an earlier sweep left."""
        with _reading(journal_of(path)):
            journal.seek(0)
            data = _whole_lines(journal)
            if data:
                self.rows = self._own_rows(_found(data))
        if not data and path.exists():
            raise SceneError(
                f"{path}: exists already, and a sweep cannot continue it without its journal"
                f" {journal_of(path).name}; give another name, or remove the file"
            )
        self._length = len(data)
        self._exported = path.exists() or not self.rows
        journal.truncate(self._length)  # without what a killed program wrote of its last line

    def _own_rows(self, found: _Found) -> dict[int, Row]:
        """The rows of this very sweep; those that ended in something unforeseen are computed again."""
        self._compare(found.header)
        for run, row in found.rows.items():
            begin = self._begin(run)
            if not _begins(row, begin) or any("/" in name for name in row.keys() - begin.keys()):
                raise UnreadableError
        return {run: row for run, row in found.rows.items() if row["outcome"] != ERROR}

    def _append(self, lines: bytes) -> None:
        data = memoryview(lines)
        while data and self._journal:  # a disk that fills takes a part first, and refuses the next
            written = self._journal.write(data)
            self._length += written
            data = data[written:]

    def _compare(self, found: Mapping[str, Any]) -> None:
        differences = [
            f"{key} was {found.get(key)}, is {self.header[key]}"
            for key in ("package", "task", "scenes")
            if found.get(key) != self.header[key]
        ]
        if differences:
            raise SceneError(
                f"{self.path} holds the results of something else: {'; '.join(differences)}. Give"
                f" another file, or remove this one and {journal_of(Path(str(self.path))).name} to"
                " compute all of it"
            )
        if seal_of(found) != self._seal:
            raise UnreadableError


def journal_of(path: Path) -> Path:
    """The journal of a file of results; that of its target, where the file is a link."""
    place = Path(os.path.realpath(path)) if path.is_symlink() else path
    return place.with_name(place.name + ".journal")


def read(path: Path | str) -> xr.Dataset:
    """The rows of a sweep, complete or not: from its journal, or from the file if it has none.

    Raises
    ------
    SceneError
        If there is neither, or it holds something else.
    """
    path = Path(path)
    _check_format(path)
    found = _load(journal_of(path))
    if found is not None:
        return as_dataset([found.rows[run] for run in sorted(found.rows)], found.header)
    if not path.exists():
        raise SceneError(f"{path}: no such file")
    try:
        if not path.is_file():
            raise UnreadableError
        return _read_parquet(path) if path.suffix.lower() == ".parquet" else _read_netcdf(path)
    except SceneError:
        raise
    except Exception as problem:  # as many kinds as there are ways to damage a file
        raise SceneError(
            f"{path}: does not hold the results of a sweep ({type(problem).__name__})"
        ) from None


def as_dataset(rows: list[Row], header: dict[str, Any]) -> xr.Dataset:
    """One array a column over the dimension ``run``; what is missing is NaN, or an empty text.

    Columns that the header declares are there also without a row.
    """
    import xarray as xr

    columns = dict.fromkeys(("run", *(key for row in rows for key in row)))
    if not rows:
        columns = dict.fromkeys(("run", *header["grid"], *header["columns"]))
    variables = {
        name: ("run", _array([row.get(name) for row in rows], name in TEXTS)) for name in columns
    }
    dataset = xr.Dataset(variables, attrs={HEADER: json.dumps(header)})
    for name, (unit, meaning) in header["columns"].items():
        if name in dataset:
            dataset[name].attrs = {"long_name": meaning, **({"units": unit} if unit else {})}
    return dataset


def rows_of(dataset: xr.Dataset) -> list[Row]:
    """The rows that `as_dataset` was given."""
    columns = {str(name): values.values.tolist() for name, values in dataset.variables.items()}
    count = dataset.sizes["run"]
    return [
        {name: _missing_as_none(values[k]) for name, values in columns.items()}
        for k in range(count)
    ]


def write(dataset: xr.Dataset, path: Path) -> None:
    """Write a file as a whole: a reader finds the old one or the new one."""
    write_whole(
        path, _as_parquet(dataset) if path.suffix.lower() == ".parquet" else netcdf_bytes(dataset)
    )


def check_results(path: Path) -> None:
    """Refuse, before anything is computed, a file of results that could not be written.

    Raises
    ------
    SceneError
        As `gallop_fmu.foundation.atomic_write.check_target`, for the file and for its journal.
    """
    _check_format(path)
    check_target(path)
    check_target(journal_of(path))


def check_columns(path: Path | str | None, columns: Iterable[str]) -> None:
    """Refuse, before anything is computed, names of columns that the type of the file cannot hold.

    Raises
    ------
    SceneError
        If there is one.
    """
    slashed = [name for name in columns if "/" in name]
    if path is not None and Path(path).suffix.lower() == ".nc" and slashed:
        raise SceneError(
            f"{path}: NetCDF allows no slash in the name of a column, as in {slashed[0]!r}; call it"
            f" {slashed[0].replace('/', '_')!r}, or give a file name that ends in .parquet"
        )


def as_line(content: Mapping[str, Any], seal: bytes = b"") -> bytes:
    """A header or row as JSON, a tab, and a checksum that `seal` changes; numbers that are not finite become null."""
    plain = {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in content.items()
    }
    text = json.dumps(plain).encode()
    return b"%b\t%b\n" % (text, _checksum(text, seal))


def seal_of(header: Mapping[str, Any]) -> bytes:
    """Digest of a header; in the checksum of each row it binds the row to its sweep."""
    return hashlib.sha256(json.dumps(header, sort_keys=True).encode()).digest()


def _checksum(text: bytes, seal: bytes) -> bytes:
    return hashlib.blake2b(text, digest_size=8, key=seal).hexdigest().encode()


def _content_of(line: bytes, seal: bytes) -> Any:
    """The content that `as_line` was given.

    Raises
    ------
    UnreadableError
        If it is something else, or has another seal.
    """
    text, _, checksum = line.rpartition(b"\t")
    if checksum != _checksum(text, seal):
        raise UnreadableError
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise UnreadableError from None


def _check_format(path: Path) -> None:
    if path.suffix.lower() not in SUFFIXES:
        raise SceneError(f"{path}: must end in {' or '.join(SUFFIXES)}, which decides the format")
    if path.suffix.lower() == ".parquet":
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise SceneError(
                f'{path}: Parquet needs pyarrow; pip install "gallop-fmu[parquet]", or give a name'
                " that ends in .nc"
            ) from None


def _open_journal(path: Path) -> BinaryIO:
    journal = journal_of(path)
    try:
        return open_exclusive(journal)
    except BlockingIOError:
        raise SceneError(
            f"{path}: another sweep writes this file ({journal} is locked); wait until it has"
            " ended, or give another name"
        ) from None
    except OSError as problem:
        raise SceneError(f"{journal}: cannot be opened ({problem.strerror or problem})") from None


class _Found(NamedTuple):
    """Content of a journal: the header, and the rows by run."""

    header: dict[str, Any]
    rows: dict[int, Row]


def _load(journal: Path) -> _Found | None:
    """Header and rows of a journal; None where there is none, or nothing in it."""
    if not journal.exists():
        return None
    with _reading(journal):
        if not journal.is_file():
            raise UnreadableError
        with journal.open("rb") as file:
            data = _whole_lines(file)
        return _found(data) if data else None


def _whole_lines(file: BinaryIO) -> bytes:
    """All lines but the last, if a killed program left half of it."""
    if os.fstat(file.fileno()).st_size > LARGEST:
        raise UnreadableError
    data = file.read()
    return data[: data.rfind(b"\n") + 1]


@contextmanager
def _reading(journal: Path) -> Iterator[None]:
    """Report a journal that cannot be read."""
    try:
        yield
    except UnreadableError:
        raise SceneError(
            f"{journal}: is not the journal of a sweep, or damaged; remove it to compute all of it"
            " again"
        ) from None
    except OSError as problem:
        raise SceneError(f"{journal}: cannot be read ({problem.strerror})") from None


def _found(lines: bytes) -> _Found:
    """Meaning of lines, each of which must be as this module writes it.

    Raises
    ------
    UnreadableError
        If one is not.
    """
    first, *others = lines.split(b"\n")[:-1]
    header = _content_of(first, b"")
    if not _is_header(header):
        raise UnreadableError
    seal = seal_of(header)
    rows = [_content_of(line, seal) for line in others]
    numbers = [
        key for key, (unit, meaning) in header["columns"].items() if unit and meaning != VARIED
    ]
    if not all(_is_row(row, header, numbers) for row in rows):
        raise UnreadableError
    return _Found(header, {row["run"]: row for row in rows})


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
            isinstance(said, list)
            and len(said) == 2
            and all(isinstance(text, str) for text in said)
            for said in header["columns"].values()
        )
        and not _not_names((*header["grid"], *header["columns"]))
    )


def _is_row(row: Any, header: Mapping[str, Any], numbers: Iterable[str]) -> bool:
    """Whether a row can be one of this header: names, values, columns of numbers, and its place in the grid."""
    return (
        isinstance(row, dict)
        and _is_whole(row.get("run"))
        and 0 <= row["run"] < header["runs"]
        and row.keys() >= set(TEXTS)
        and not row_problem(row)
        and _begins(row, _point(header["grid"], row["run"]))
        and str not in {type(row.get(key)) for key in numbers}
    )


def row_problem(row: Mapping[str, Any]) -> str:
    """Reason why a row cannot be written to a file of results, or an empty text."""
    if unnamed := _not_names(tuple(row)):
        return f"{unnamed[0]!r}: a column needs a name of printable characters"
    for name in TEXTS:
        if not isinstance(row.get(name, ""), str):
            return f"{name}: must be a text, not {row[name]!r:.40}"
    for name, value in row.items():
        if isinstance(value, str):
            if not is_printable(value):
                return (
                    f"{name}: a text must not hold control characters, surrogates or non-characters"
                )
        elif not (value is None or isinstance(value, (float, bool)) or _is_whole(value)):
            return (
                f"{name}: must be a number of at most 64 bits, a truth value, a text or None, not"
                f" {value!r:.40}"
            )
    return ""


@lru_cache
def _not_names(names: tuple[Any, ...]) -> list[Any]:
    """Those that no column can have; many rows have the same columns."""
    return [name for name in names if not (isinstance(name, str) and name and is_printable(name))]


def _is_whole(value: Any) -> bool:
    """Whether it is a whole number that an array can hold."""
    return isinstance(value, int) and not isinstance(value, bool) and -(2**63) <= value < 2**63


def as_cell(value: Any) -> Any:
    """A value of a scene as a row holds it: lists and tables as JSON."""
    return json.dumps(value) if isinstance(value, (list, dict)) else value


def _point(grid: Mapping[str, list[Any]], run: int) -> Row:
    """Values of the grid in a run; the last parameter changes fastest."""
    point: Row = {}
    for name, values in reversed(list(grid.items())):
        run, place = divmod(run, len(values))
        point[name] = as_cell(values[place])
    return point


def _begins(row: Mapping[str, Any], begin: Mapping[str, Any]) -> bool:
    """Whether a row has these columns with these values, of the same types."""
    return all(key in row and _as_json(row[key]) == _as_json(value) for key, value in begin.items())


def _as_json(value: Any) -> str:
    return json.dumps(None if isinstance(value, float) and not math.isfinite(value) else value)


def _array(values: list[Any], text: bool = False) -> NDArray[Any]:
    there = [value for value in values if value is not None]
    whole = len(there) == len(values)
    if whole and there and all(isinstance(value, bool) for value in there):
        return np.array(values, dtype=np.bool_)
    if whole and there and all(isinstance(value, int) for value in there):
        return np.array(values, dtype=np.int64)
    truths = [isinstance(value, bool) for value in there]
    numbers = all(isinstance(value, (int, float)) for value in there)
    if not text and numbers and (all(truths) or not any(truths)):  # a truth among numbers is no 1
        return np.array(
            [math.nan if value is None else value for value in values], dtype=np.float64
        )
    return np.array(["" if value is None else str(value) for value in values], dtype=object)


def _missing_as_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _as_parquet(dataset: xr.Dataset) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    columns = {str(name): pa.array(values.values) for name, values in dataset.variables.items()}
    fields = [
        pa.field(name, column.type, metadata=dataset[name].attrs)
        for name, column in columns.items()
    ]
    schema = pa.schema(fields, metadata={HEADER: dataset.attrs[HEADER]})
    buffer = BytesIO()
    parquet.write_table(pa.table(list(columns.values()), schema=schema), buffer)
    return buffer.getvalue()


def _read_parquet(path: Path) -> xr.Dataset:
    import xarray as xr
    from pyarrow import parquet

    table = parquet.read_table(path)
    header = table.schema.metadata[HEADER.encode()].decode()
    variables = {}
    for field in table.schema:
        attributes = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
        described = {
            key: value for key, value in attributes.items() if key in ("long_name", "units")
        }
        variables[field.name] = ("run", table[field.name].to_numpy(), described)
    return _checked(xr.Dataset(variables, attrs={HEADER: header}))


def _read_netcdf(path: Path) -> xr.Dataset:
    import xarray as xr

    return _checked(xr.load_dataset(path, engine="h5netcdf"))


def _checked(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset whose header is one of a sweep, of this version or an older one."""
    header = json.loads(dataset.attrs[HEADER])
    if not _is_header({**header, "format": FORMAT}) or not {"run", *TEXTS} <= set(
        map(str, dataset.variables)
    ):
        raise UnreadableError
    return dataset
