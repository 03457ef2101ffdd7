"""Rows of a sweep on disk, kept when the program is stopped or killed.

Each row is written to the journal ``FILE.journal`` at once. A sweep resumes from its journal only,
and one sweep at a time can write it. ``FILE`` is an export for other programs, rewritten now and
then and at the end. The journal is kept, so that the sweep can be repeated or completed later.
"""

from __future__ import annotations

import json
import os
import time as clock
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from gallop_fmu.foundation.atomic_write import check_target
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.sweeps.journal import (
    Journal,
    UnreadableError,
    as_line,
    journal_of,
    load_journal,
    open_journal,
    parse_journal,
    reading,
    seal_of,
    whole_lines,
)
from gallop_fmu.sweeps.results_file import (
    as_dataset,
    check_results_file,
    check_suffix,
    read_results,
    write_results,
)
from gallop_fmu.sweeps.rows import ERROR, FORMAT, Header, Row, has_values

if TYPE_CHECKING:
    import xarray as xr

EXPORT_INTERVAL = 20.0
"""Minimum wall-clock time [s] between two exports."""
MAX_EXPORT_SHARE = 0.05
"""Maximum share of the time spent on exports."""


class RowStore:
    """Rows of one sweep and their files.

    Parameters
    ----------
    path
        File to write, ``.parquet`` or ``.nc``; None keeps the rows in memory only.
    header
        Description of the sweep; a journal with another one is refused.
    first_values
        From the number of a run to the columns and values that its row begins with; resumed rows
        must have them.

    Raises
    ------
    SceneError
        The file cannot be written, another sweep writes it, or the journal is of another sweep.
    """

    def __init__(
        self,
        path: Path | str | None,
        header: Header,
        first_values: Callable[[int], Row] = lambda run: {"run": run},
    ) -> None:
        self.path = None if path is None else Path(path)
        self.header: Header = json.loads(json.dumps({"format": FORMAT, **header}))
        self.rows: dict[int, Row] = {}
        self._first_values, self._seal = first_values, seal_of(self.header)
        self._journal: BinaryIO | None = None
        self._journal_size = 0
        self._is_exported = True
        self._export_time, self._export_cost = clock.monotonic(), 0.0
        if self.path is not None:
            check_results_file(self.path)
            check_target(journal_of(self.path))
            self._journal = open_journal(self.path)
            try:
                self._resume(self.path, self._journal)
            except BaseException:
                self.release()
                raise

    def dataset(self) -> xr.Dataset:
        """All rows so far, in the order of their runs."""
        return as_dataset([self.rows[run] for run in sorted(self.rows)], self.header)

    def add(self, rows: Iterable[Row]) -> None:
        """Add rows, first in memory, then on disk.

        Raises
        ------
        OSError
            They cannot be written.
        """
        rows = list(rows)
        self.rows.update((row["run"], row) for row in rows)
        if self._journal is None or not rows:
            return
        self._is_exported = False
        if not self._journal_size:
            self._append(as_line(self.header))
        self._append(b"".join(as_line(row, self._seal) for row in rows))
        now = clock.monotonic()
        if now - self._export_time > max(EXPORT_INTERVAL, self._export_cost / MAX_EXPORT_SHARE):
            os.fsync(self._journal.fileno())
            # On Windows, an open file cannot be replaced; `close` reports the error.
            with suppress(OSError):
                self.export()
            self._export_time = clock.monotonic()
            self._export_cost = self._export_time - now

    def export(self) -> None:
        """Rewrite the file with all rows so far.

        Raises
        ------
        OSError
            It cannot be written; the older file is kept.
        """
        if self.path is not None:
            write_results(self.dataset(), self.path)
            self._is_exported = True

    def close(self) -> None:
        """Export rows that are not in the file yet, and close the journal.

        Raises
        ------
        OSError
            The file cannot be written; the journal is kept.
        """
        try:
            if not self._is_exported:
                self.export()
        finally:
            self.release()

    def rows_on_disk(self) -> int:
        """Return the number of rows in the journal."""
        journal = None if self.path is None else load_journal(self.path)
        return 0 if journal is None else len(journal.rows)

    def release(self) -> None:
        """Close and unlock the journal; remove it if it is empty."""
        if self._journal is None or self.path is None:
            return
        with self._journal as journal:
            if not os.fstat(journal.fileno()).st_size:
                with suppress(OSError):
                    journal_of(self.path).unlink()
        self._journal = None

    def _resume(self, path: Path, journal: BinaryIO) -> None:
        """Read the rows of an earlier sweep from the journal."""
        with reading(journal_of(path)):
            journal.seek(0)
            lines = whole_lines(journal)
            if lines:
                self.rows = self._resumed_rows(parse_journal(lines))
        if not lines and path.exists():
            raise SceneError(
                f"{path}: exists already, and a sweep cannot continue it without its journal"
                f" {journal_of(path).name}; give another name, or remove the file"
            )
        self._journal_size = len(lines)
        self._is_exported = path.exists() or not self.rows
        journal.truncate(self._journal_size)  # removes the incomplete line of a killed program

    def _resumed_rows(self, journal: Journal) -> dict[int, Row]:
        """Rows of this sweep, without those that ended in an unforeseen error."""
        self._check_header(journal.header)
        for run, row in journal.rows.items():
            values = self._first_values(run)
            if not has_values(row, values) or any(
                "/" in name for name in row.keys() - values.keys()
            ):
                raise UnreadableError
        return {run: row for run, row in journal.rows.items() if row["outcome"] != ERROR}

    def _append(self, lines: bytes) -> None:
        """Write lines to the journal. On a full disk, some may be written before the error."""
        content = memoryview(lines)
        while content and self._journal:
            written = self._journal.write(content)
            self._journal_size += written
            content = content[written:]

    def _check_header(self, found: Mapping[str, Any]) -> None:
        expected: Mapping[str, Any] = self.header
        differences = [
            f"{key} was {found.get(key)}, is {expected[key]}"
            for key in ("package", "task", "scenes")
            if found.get(key) != expected[key]
        ]
        if differences:
            raise SceneError(
                f"{self.path} holds the results of another sweep: {'; '.join(differences)}. Give"
                f" another file, or remove this one and {journal_of(Path(str(self.path))).name} to"
                " compute all runs"
            )
        if seal_of(found) != self._seal:
            raise UnreadableError


def read(path: Path | str) -> xr.Dataset:
    """Read the rows of a sweep from its journal, or from the file if it has no journal.

    Raises
    ------
    SceneError
        Neither exists, or it holds something else.
    """
    path = Path(path)
    check_suffix(path)
    journal = load_journal(path)
    if journal is None:
        return read_results(path)
    return as_dataset([journal.rows[run] for run in sorted(journal.rows)], journal.header)
