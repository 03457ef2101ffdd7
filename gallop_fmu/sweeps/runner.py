"""Computation of many runs: in groups on workers, with stored rows and resumption."""

from __future__ import annotations

import hashlib
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from gallop_fmu.engine.library import library_path
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.foundation.text_rules import printable
from gallop_fmu.foundation.version import program
from gallop_fmu.input.scene_spec import unit_of
from gallop_fmu.sweeps.cases import Case, Cases
from gallop_fmu.sweeps.journal import journal_of
from gallop_fmu.sweeps.pool import Kind, Workers, WorkersLostError, workers
from gallop_fmu.sweeps.results_file import check_columns
from gallop_fmu.sweeps.row_store import RowStore
from gallop_fmu.sweeps.rows import ERROR, VARIED, Header, Row, row_problem
from gallop_fmu.sweeps.runs import COMPLETED, Runs, RunsStoppedError

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene

MAX_GROUP_SIZE = 8
"""Maximum number of runs that a worker takes at a time."""
MIN_GROUPS_PER_WORKER = 8
"""Minimum number of groups for each worker, so that all end at about the same time."""

STOPPED = Outcome.STOPPED_BY_USER.name.lower()
INVALID = Outcome.INVALID_SCENE.name.lower()

COLUMNS = {
    "run": ("", "number of the run"),
    "outcome": ("", "outcome of the run"),
    "message": ("", "outcome in words, with a remedy"),
    "seconds": ("s", "wall-clock time of the run"),
}

CarryOn = Callable[[], bool]
"""Called during the work; it returns False to stop it."""
Progress = Callable[[int, int, int], object]
"""Called with the numbers of runs that are done, that failed, and of all."""


class Task(Protocol):
    """Computation of a group of scenes.

    Attributes
    ----------
    columns
        Column to unit and meaning, of the rows that it returns.
    kind
        Type of workers.
    """

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Column to unit and meaning."""

    @property
    def kind(self) -> Kind:
        """Threads, if the work releases the interpreter lock."""

    def __call__(self, scenes: Sequence[Scene | LineScene], carry_on: CarryOn) -> list[Row]:
        """Return one row a scene, each with outcome, message and seconds."""

    def __str__(self) -> str:
        """Text identifying the task; a resumed sweep must match it."""


def compute(
    cases: Cases,
    task: Task,
    *,
    out: Path | str | None = None,
    count: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> Runs:
    """Compute every case that has no row yet.

    Parameters
    ----------
    cases
        Runs to compute, see `gallop_fmu.sweeps.cases.cases`.
    task
        Computation of each.
    out
        File of results, ``.parquet`` or ``.nc``; the sweep resumes from its journal.
    count, cluster
        Number of workers on this machine, or address of a Dask scheduler.
    progress
        Called at the start and after each group of runs.

    Raises
    ------
    SceneError
        `out` belongs to another sweep, or the cluster cannot be used.
    RunsStoppedError
        Ctrl-C, a full disk, or lost workers; finished runs are kept.
    """
    check_columns(out, cases.columns)
    store = RowStore(out, _header(cases, task), lambda run: cases.every[run].columns())
    try:
        _compute_missing(store, cases, task, (count, cluster), progress)
        store.close()
    except KeyboardInterrupt:
        raise _stopped("stopped on request", store) from None
    except WorkersLostError as problem:
        raise _stopped(str(problem), store) from None
    except OSError as problem:
        raise _stopped(f"{out} cannot be written ({problem.strerror or problem})", store) from None
    finally:
        store.release()
    return Runs(store.dataset())


def _header(cases: Cases, task: Task) -> Header:
    varied = dict.fromkeys(key for case in cases.every for key in case.changes)
    return {
        "package": package(),
        "task": str(task),
        "scenes": cases.fingerprint(),
        "runs": len(cases.every),
        "grid": cases.grid,
        "columns": {
            **COLUMNS,
            **{key: (_unit(cases, key), VARIED) for key in varied},
            **task.columns,
        },
    }


def _compute_missing(
    store: RowStore,
    cases: Cases,
    task: Task,
    team: tuple[int | None, str | None],
    progress: Progress | None,
) -> None:
    """Compute cases without a row on `team`, a number of workers or a cluster; store their rows."""
    missing = [case for case in cases.every if case.run not in store.rows]
    failed = _count_failed(store.rows.values())
    if progress:
        progress(len(store.rows), failed, len(cases.every))
    if not missing:
        return
    stop = Event()
    with workers(task.kind, *team) as found:
        try:
            for rows in _rows(found, task, missing, stop):
                store.add(rows)
                failed += _count_failed(rows)
                if progress:
                    progress(len(store.rows), failed, len(cases.every))
        finally:
            stop.set()


def _count_failed(rows: Iterable[Row]) -> int:
    return sum(row["outcome"] != COMPLETED for row in rows)


def _rows(team: Workers, task: Task, missing: list[Case], stop: Event) -> Iterator[list[Row]]:
    """Yield the rows of each group when it is finished."""
    size = max(1, min(MAX_GROUP_SIZE, len(missing) // (MIN_GROUPS_PER_WORKER * team.count)))
    starts = range(0, len(missing), size)
    groups = ([_prepared(case) for case in missing[k : k + size]] for k in starts)
    call = _GroupTask(task, stop if team.has_shared_memory else None)
    for group, answer in team.answers(call, groups):
        if isinstance(answer, Exception):
            answer = [
                {**case.row, **_failure(answer, 0.0)} if case.scene else case.row for case in group
            ]
        yield [row for row in answer if row["outcome"] != STOPPED]


class _PreparedCase(NamedTuple):
    """Input of a worker: the first columns of the row, and the scene.

    Scenes are made on this machine, as the files that they name may exist here only. A case whose
    scene is not allowed has a complete row and no scene.
    """

    row: Row
    scene: Scene | LineScene | None


def _prepared(case: Case) -> _PreparedCase:
    try:
        return _PreparedCase(case.columns(), case.scene())
    except Exception as problem:
        return _PreparedCase({**case.columns(), **_failure(problem, 0.0)}, None)


@dataclass(frozen=True)
class _GroupTask:
    """Function that computes a group of cases; without `stop`, on other processes and machines."""

    task: Task
    stop: Event | None

    def __call__(self, group: list[_PreparedCase]) -> list[Row]:
        """Return one row a case."""
        computed = iter(self.task([case.scene for case in group if case.scene], self._carry_on))
        return [_joined(case.row, next(computed)) if case.scene else case.row for case in group]

    def _carry_on(self) -> bool:
        return self.stop is None or not self.stop.is_set()


def one_by_one(
    function: Callable[[Scene | LineScene], Row],
    scenes: Sequence[Scene | LineScene],
    carry_on: CarryOn,
) -> list[Row]:
    """Call a function for each scene; return rows with outcome, message and seconds."""
    rows = []
    for scene in scenes:
        began = clock.perf_counter()
        if not carry_on():
            rows.append({"outcome": STOPPED})
            continue
        try:
            row = {"outcome": COMPLETED, "message": "", "seconds": 0.0, **_plain(function(scene))}
            row["seconds"] = clock.perf_counter() - began
        except Exception as problem:
            row = _failure(problem, clock.perf_counter() - began)
        rows.append(row)
    return rows


def _plain(row: Row) -> Row:
    """Return a row with plain numbers and texts.

    Raises
    ------
    ValueError
        No file of results can hold it.
    """
    row = {
        key: value.item() if hasattr(value, "item") and np.ndim(value) == 0 else value
        for key, value in row.items()
    }
    slashed = next((key for key in row if "/" in str(key)), None)
    if problem := row_problem(row) or (
        slashed and f"{slashed}: the name of a column must not have a slash; rename it"
    ):
        raise ValueError(problem)
    return row


def _joined(begin: Row, computed: Row) -> Row:
    """Return a whole row; computed values must not replace the first columns."""
    twice = sorted(begin.keys() & computed.keys())
    if twice:
        computed = _failure(
            ValueError(f"{twice[0]}: also a column of the inputs; give the result another name"),
            0.0,
        )
    return {**begin, **computed}


def _failure(problem: Exception, seconds: float) -> Row:
    """Return the row of a run without a result."""
    if isinstance(problem, SimulationError):
        outcome, message = problem.report.outcome.name.lower(), str(problem)
    elif isinstance(problem, SceneError):
        outcome, message = INVALID, str(problem)
    else:
        outcome, message = ERROR, f"{type(problem).__name__}: {problem}"
    return {"outcome": outcome, "message": printable(message), "seconds": seconds}


def _stopped(why: str, store: RowStore) -> RunsStoppedError:
    """Write the file of an interrupted sweep, if possible, and return the error that ends it."""
    result = Runs(store.dataset())
    if not result.done:
        return RunsStoppedError(
            f"{why}. None of {result.total} runs is done, and nothing was written", result
        )
    if store.path is None:
        kept, where, again = (
            result.done,
            "in the result of this error, as no file was given (out)",
            "",
        )
    else:
        again = " The same call again computes the rest."
        try:
            store.close()
            kept, where = result.done, f"in {store.path}"
        except OSError:
            kept, where = store.rows_on_disk(), f"in {journal_of(store.path)}"
    return RunsStoppedError(
        f"{why}. {kept} of {result.total} runs are done and kept {where}.{again}", result
    )


def _unit(cases: Cases, key: str) -> str:
    first = cases.every[0]
    for scene in (first.base.scene, first.scene):  # a row may complete its specification
        with suppress(SceneError):
            return unit_of(scene(), key)
    return ""  # a section, or an item of a list that this scene does not have


def package() -> str:
    """Program and kernel on which results depend."""
    return f"{program()} (kernel {_kernel_hash()})"


def _kernel_hash() -> str:
    return hashlib.sha256(library_path().read_bytes()).hexdigest()[:12]
