"""The journal of a sweep: a header and one line a row, each JSON, a tab and a checksum."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from gallop_fmu.foundation.atomic_write import open_exclusive
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.sweeps.rows import Header, Row, finite_or_none, is_header, is_row, number_columns

MAX_JOURNAL_SIZE = 2**32
"""Size [bytes] beyond which a file is not taken for a journal."""


class UnreadableError(ValueError):
    """A journal that holds something else, or is damaged."""


class Journal(NamedTuple):
    """Content of a journal: the header, and the rows by run."""

    header: Header
    rows: dict[int, Row]


def journal_of(path: Path) -> Path:
    """Return the path of the journal of a file of results; of its target, if the file is a link."""
    target = Path(os.path.realpath(path)) if path.is_symlink() else path
    return target.with_name(target.name + ".journal")


def open_journal(path: Path) -> BinaryIO:
    """Open and lock the journal of a file of results.

    Raises
    ------
    SceneError
        Another sweep has it open, or it cannot be opened.
    """
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


def load_journal(path: Path) -> Journal | None:
    """Return the content of the journal of a file of results; None if it is missing or empty.

    Raises
    ------
    SceneError
        It is not a journal, or damaged.
    """
    journal = journal_of(path)
    if not journal.exists():
        return None
    with reading(journal):
        if not journal.is_file():
            raise UnreadableError
        with journal.open("rb") as file:
            lines = whole_lines(file)
        return parse_journal(lines) if lines else None


@contextmanager
def reading(journal: Path) -> Iterator[None]:
    """Turn the errors of an unreadable journal into a `SceneError`."""
    try:
        yield
    except UnreadableError:
        raise SceneError(
            f"{journal}: not the journal of a sweep, or damaged; remove it to compute all runs"
            " again"
        ) from None
    except OSError as problem:
        raise SceneError(f"{journal}: cannot be read ({problem.strerror})") from None


def whole_lines(file: BinaryIO) -> bytes:
    """Return all complete lines; the last may be incomplete after a program was killed."""
    if os.fstat(file.fileno()).st_size > MAX_JOURNAL_SIZE:
        raise UnreadableError
    content = file.read()
    return content[: content.rfind(b"\n") + 1]


def parse_journal(lines: bytes) -> Journal:
    """Parse and validate the lines of a journal.

    Raises
    ------
    UnreadableError
        A line is not one that this module writes.
    """
    first, *others = lines.split(b"\n")[:-1]
    header = _content_of(first, b"")
    if not is_header(header):
        raise UnreadableError
    seal = seal_of(header)
    rows = [_content_of(line, seal) for line in others]
    numbers = number_columns(header)
    if not all(is_row(row, header, numbers) for row in rows):
        raise UnreadableError
    return Journal(header, {row["run"]: row for row in rows})


def as_line(content: Mapping[str, Any], seal: bytes = b"") -> bytes:
    """Return a header or row as a line; its checksum depends on `seal`."""
    plain = {key: finite_or_none(value) for key, value in content.items()}
    text = json.dumps(plain).encode()
    return b"%b\t%b\n" % (text, _checksum(text, seal))


def seal_of(header: Mapping[str, Any]) -> bytes:
    """Return the digest of a header; it binds the checksum of each row to its sweep."""
    return hashlib.sha256(json.dumps(header, sort_keys=True).encode()).digest()


def _checksum(text: bytes, seal: bytes) -> bytes:
    return hashlib.blake2b(text, digest_size=8, key=seal).hexdigest().encode()


def _content_of(line: bytes, seal: bytes) -> Any:
    """Return the content of a line of `as_line`.

    Raises
    ------
    UnreadableError
        The checksum is wrong.
    """
    text, _, checksum = line.rpartition(b"\t")
    if checksum != _checksum(text, seal):
        raise UnreadableError
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise UnreadableError from None
