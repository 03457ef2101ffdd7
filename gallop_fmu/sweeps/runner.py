"""Many runs, wherever they are computed: handed out in groups, kept as they come, resumed where they stopped."""

from __future__ import annotations

import hashlib
import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from gallop_fmu.sweeps.pool import Kind, Workers, WorkersLostError, workers
from gallop_fmu.sweeps.row_store import (
    ERROR,
    VARIED,
    Row,
    Store,
    check_columns,
    journal_of,
    row_problem,
)
from gallop_fmu.sweeps.runs import COMPLETED, Runs, RunsStoppedError

if TYPE_CHECKING:
    from gallop_fmu.scene.scene import Scene

LARGEST_GROUP = 8
"""Runs that a worker takes at a time, at most."""
GROUPS_EACH = 8
"""Groups that each worker should get at least, so that all end at about the same time."""

STOPPED = Outcome.STOPPED_BY_USER.name.lower()
INVALID = Outcome.INVALID_SCENE.name.lower()

COLUMNS = {
    "run": ("", "number of the run"),
    "outcome": ("", "how the run ended"),
    "message": ("", "the same in words, with what to do"),
    "seconds": ("s", "wall-clock time that the run took"),
}

CarryOn = Callable[[], bool]
"""Whether the work shall go on; asked during it."""
Progress = Callable[[int, int, int], object]
"""Called with the numbers of runs that are done, that did not complete, and that there are."""


class Task(Protocol):
    """What is computed of each scene.

    Attributes
    ----------
    columns
        Column to unit and meaning, of the rows it returns.
    kind
        Whether it wants threads or processes.
    """

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Column to unit and meaning."""

    @property
    def kind(self) -> Kind:
        """Threads, if the work releases the interpreter lock."""

    def __call__(self, scenes: Sequence[Scene], carry_on: CarryOn) -> list[Row]:
        """One row a scene, each with outcome, message and seconds."""

    def __str__(self) -> str:
        """What it computes, in words by which a resumed sweep knows its own."""


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
        What to compute, see `gallop_fmu.sweeps.cases.cases`.
    task
        What is computed of each.
    out
        File of results, ``.parquet`` or ``.nc``; the rows of its journal are taken over.
    count, cluster
        Number of workers here, or address of a Dask scheduler.
    progress
        Called at the start and after each group of runs.

    Raises
    ------
    SceneError
        If `out` belongs to something else, or the cluster cannot be used.
    RunsStoppedError
        On Ctrl-C, a disk that is full, or lost workers; what is done is kept.
    """
    header = {
        "package": f"{program()} (kernel {_kernel_fingerprint()})",
        "task": str(task),
        "scenes": cases.fingerprint(),
        "runs": len(cases.every),
        "grid": cases.grid,
        "columns": {
            **COLUMNS,
            **{key: (_unit(cases, key), VARIED) for key in _varied(cases)},
            **task.columns,
        },
    }
    check_columns(out, cases.columns)
    store = Store(out, header, lambda run: cases.every[run].columns())
    left = [case for case in cases.every if case.run not in store.rows]
    failed = sum(row["outcome"] != COMPLETED for row in store.rows.values())
    stop = Event()
    try:
        if progress:
            progress(len(store.rows), failed, len(cases.every))
        if left:
            with workers(task.kind, count, cluster) as team:
                try:
                    for rows in _rows(team, task, left, stop):
                        store.add(rows)
                        failed += sum(row["outcome"] != COMPLETED for row in rows)
                        if progress:
                            progress(len(store.rows), failed, len(cases.every))
                finally:
                    stop.set()
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


def _rows(team: Workers, task: Task, left: list[Case], stop: Event) -> Iterator[list[Row]]:
    """The rows of each group, as they come."""
    size = max(1, min(LARGEST_GROUP, len(left) // (GROUPS_EACH * team.count)))
    groups = ([_ready(case) for case in left[k : k + size]] for k in range(0, len(left), size))
    call = _Group(task, stop if team.here else None)
    for group, answer in team.answers(call, groups):
        if isinstance(answer, Exception):
            answer = [
                {**case.row, **_failure(answer, 0.0)} if case.scene else case.row for case in group
            ]
        yield [row for row in answer if row["outcome"] != STOPPED]


class _Ready(NamedTuple):
    """A case on its way to a worker: its scene, and what its row begins with; the whole row where there is no scene.

    Scenes are made before they travel, since the files that they name may be here only.
    """

    row: Row
    scene: Scene | None


def _ready(case: Case) -> _Ready:
    try:
        return _Ready(case.columns(), case.scene())
    except Exception as problem:
        return _Ready({**case.columns(), **_failure(problem, 0.0)}, None)


@dataclass(frozen=True)
class _Group:
    """Computes a group of cases; travels to other processes and machines, where nothing tells it to stop."""

    task: Task
    stop: Event | None

    def __call__(self, group: list[_Ready]) -> list[Row]:
        """One row a case."""
        computed = iter(self.task([case.scene for case in group if case.scene], self._carry_on))
        return [_joined(case.row, next(computed)) if case.scene else case.row for case in group]

    def _carry_on(self) -> bool:
        return self.stop is None or not self.stop.is_set()


def one_by_one(
    function: Callable[[Scene], Row], scenes: Sequence[Scene], carry_on: CarryOn
) -> list[Row]:
    """Rows of a function of one scene: with outcome, message and seconds, whatever it raises."""
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
    """A row of plain numbers and texts.

    Raises
    ------
    ValueError
        If no file of results can hold it.
    """
    row = {
        key: value.item() if hasattr(value, "item") and np.ndim(value) == 0 else value
        for key, value in row.items()
    }
    slashed = next((key for key in row if "/" in str(key)), None)
    if problem := row_problem(row) or (
        slashed and f"{slashed}: the name of a column must have no slash"
    ):
        raise ValueError(problem)
    return row


def _joined(begin: Row, computed: Row) -> Row:
    """A whole row; what it begins with says which run it is, and is not to be replaced."""
    twice = sorted(begin.keys() & computed.keys())
    if twice:
        computed = _failure(
            ValueError(f"{twice[0]}: is a column of the inputs; give the result another name"), 0.0
        )
    return {**begin, **computed}


def _failure(problem: Exception, seconds: float) -> Row:
    """The row of a run that has no result."""
    if isinstance(problem, SimulationError):
        outcome, message = problem.report.outcome.name.lower(), str(problem)
    elif isinstance(problem, SceneError):
        outcome, message = INVALID, str(problem)
    else:
        outcome, message = ERROR, f"{type(problem).__name__}: {problem}"
    return {"outcome": outcome, "message": printable(message), "seconds": seconds}


def _stopped(why: str, store: Store) -> RunsStoppedError:
    """The error that ends an interrupted sweep, once its file is up to date, if that can be."""
    result = Runs(store.dataset())
    if not result.done:
        return RunsStoppedError(
            f"{why}. None of {result.total} runs is done, and nothing was written", result
        )
    if store.path is None:
        kept, where, again = (
            result.done,
            "in the result of this error, since no file was named (out)",
            "",
        )
    else:
        again = " The same call again computes the rest."
        try:
            store.close()
            kept, where = result.done, f"in {store.path}"
        except OSError:
            kept, where = store.on_disk(), f"in {journal_of(store.path)}"
    return RunsStoppedError(
        f"{why}. {kept} of {result.total} runs are done and kept {where}.{again}", result
    )


def _varied(cases: Cases) -> list[str]:
    return list(dict.fromkeys(key for case in cases.every for key in case.changes))


def _unit(cases: Cases, key: str) -> str:
    first = cases.every[0]
    for scene in (
        first.base.scene,
        first.scene,
    ):  # a specification may be complete with its row only
        with suppress(SceneError):
            return unit_of(scene(), key)
    return ""  # a section as a whole, or an item of a list that this scene does not have


def _kernel_fingerprint() -> str:
    return hashlib.sha256(library_path().read_bytes()).hexdigest()[:12]
