"""What a file of results holds, read in a process of its own: ``python -m gallop_fmu.reading FILE`` prints its lines.

HDF5 and Arrow are made for files that are in order. On others they may crash, never end, or ask for memory without
bound; one wrong bit is enough. So they read where that harms nobody, with a limit on time and memory. What comes back
is text as in the journal of a sweep: the header, then one line of JSON a row, each with its checksum.
"""

from __future__ import annotations

import hashlib
import json
import math
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

HEADER, DIGEST = "gallop_fmu", "gallop_fmu_digest"
"""Under which names a file has its header, and the digest of header and columns."""

LARGEST = 2**32
"""Bytes of lines; a file or journal beyond this is taken for a mistake."""
SECONDS, BYTES_PER_SECOND = 60.0, 1e6
"""Time that reading may take, and how much more is given to a large file."""
ROOM, ROOM_PER_BYTE = 2**30, 50
"""Memory [bytes] that reading may take, and how much more is given to a large file."""


class UnreadableError(ValueError):
    """A file that holds something else, or is damaged."""


def lines_of(path: Path) -> bytes:
    """The lines of a file of results.

    Raises
    ------
    UnreadableError
        If it has none, or reading takes too long or too much memory.
    """
    if not path.is_file():
        raise UnreadableError
    command = [sys.executable, "-P", "-m", "gallop_fmu.reading", str(path.absolute())]
    limit = SECONDS + path.stat().st_size / BYTES_PER_SECOND
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=limit)
    except subprocess.TimeoutExpired:
        raise UnreadableError from None
    if done.returncode:
        raise UnreadableError
    return done.stdout


def as_line(content: Mapping[str, Any]) -> bytes:
    """A header or row as JSON, a tab, and a checksum; numbers that are not finite become null."""
    plain = {
        key: None if isinstance(value, float) and not math.isfinite(value) else value for key, value in content.items()
    }
    text = json.dumps(plain).encode()
    return b"%b\t%08x\n" % (text, crc32(text))


def content_of(line: bytes) -> Any:
    """What `as_line` was given.

    Raises
    ------
    UnreadableError
        If it is something else.
    """
    text, _, checksum = line.rpartition(b"\t")
    if checksum != b"%08x" % crc32(text):
        raise UnreadableError
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise UnreadableError from None


def digest_of(header: str, columns: Mapping[str, NDArray[Any]]) -> str:
    """A number that changes with anything in a file, whatever its format."""
    digest = hashlib.sha256(header.encode())
    for name, values in sorted(columns.items()):
        digest.update(f"\n{name} {values.dtype.kind} {values.size}\n".encode())
        if values.dtype == object:
            digest.update(json.dumps(values.tolist()).encode())
        else:
            little = values.astype(values.dtype.newbyteorder("<"))
            one_nan = np.where(np.isnan(little), math.nan, little) if little.dtype.kind == "f" else little
            digest.update(one_nan.tobytes())
    return digest.hexdigest()


class _Content(NamedTuple):
    header: str
    digest: str
    columns: dict[str, NDArray[Any]]


def _read_netcdf(path: Path) -> _Content:
    import h5py

    with h5py.File(path, "r") as file:
        columns = {name: _hdf5_column(file, name, path.stat().st_size) for name in file}
        return _Content(str(file.attrs[HEADER]), str(file.attrs[DIGEST]), columns)


def _hdf5_column(file: Any, name: str, largest: int) -> NDArray[Any]:
    """A column that lies in this file itself, uncompressed."""
    import h5py

    if not isinstance(file.get(name, getlink=True), h5py.HardLink):
        raise UnreadableError
    column = file[name]
    if column.ndim != 1 or column.nbytes > largest or column.external or column.is_virtual:
        raise UnreadableError
    if h5py.check_string_dtype(column.dtype):
        return np.asarray(column.asstr()[()], dtype=object)
    values = np.asarray(column[()])
    return values.astype(np.bool_) if column.attrs.get("dtype") == "bool" else values


def _read_parquet(path: Path) -> _Content:
    from pyarrow import parquet

    table = parquet.read_table(path, use_threads=False)
    metadata = table.schema.metadata
    columns = {name: table[name].to_numpy() for name in table.column_names}
    return _Content(metadata[HEADER.encode()].decode(), metadata[DIGEST.encode()].decode(), columns)


def _lines(path: Path) -> Iterator[bytes]:
    content = (_read_parquet if path.suffix == ".parquet" else _read_netcdf)(path)
    kinds = {values.dtype.kind for values in content.columns.values()}
    if not kinds <= set("bifO") or digest_of(content.header, content.columns) != content.digest:
        raise UnreadableError
    yield as_line(json.loads(content.header))
    names = list(content.columns)
    for row in zip(*(values.tolist() for values in content.columns.values()), strict=True):
        yield as_line(dict(zip(names, row, strict=True)))


def _limit_memory(more: int) -> None:
    """To what this process has, and so many bytes; where the system can do that."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        now = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (now + more, now + more))


def main(path: Path) -> None:
    """Print the lines of a file."""
    _limit_memory(ROOM + ROOM_PER_BYTE * path.stat().st_size)
    written = 0
    for line in _lines(path):
        written += len(line)
        if written > LARGEST:
            raise UnreadableError
        sys.stdout.buffer.write(line)
    sys.stdout.buffer.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
