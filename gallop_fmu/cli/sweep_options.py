"""What ``gallop-fmu sweep`` and ``gallop-modal screen --table`` share: options, progress, and telling of many runs."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import (
    Exit,
    complain,
    complain_more,
    echo_json,
    new_console,
    new_table,
    print_warnings,
    whole,
)

if TYPE_CHECKING:
    from gallop_fmu.sweeps.runner import Progress
    from gallop_fmu.sweeps.runs import Runs

SHOWN = 20
"""Rows of results that a terminal shows."""
LISTED = 10
"""Failures that a terminal lists."""
MOST_POINTS = 1_000_000
"""Values that one range can have."""

Over = Annotated[
    list[str] | None,
    typer.Option(
        "--over",
        metavar="KEY=VALUES",
        help=(
            "Vary a value of the scene, as often as needed; all combinations are computed. "
            "VALUES: 4,5,5.5 or FIRST:LAST:STEP, both ends included."
        ),
    ),
]
SpanTable = Annotated[
    Path | None,
    typer.Option(
        "--table",
        metavar="FILE",
        help=(
            "Spans to compute: .csv, or .geojson whose properties are the columns. Columns are"
            " values of a scene (span.length) or of its \\[line] (line.span), name, scene (a"
            " packaged name or a path), and label.ANYTHING to carry along."
        ),
    ),
]
RunsOut = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE",
        help=(
            "Write the results: .parquet or .nc. Each row goes at once into FILE.journal, which"
            " stays; the same command again computes only the rows that are missing there."
        ),
    ),
]
ClusterAddress = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="ADDRESS",
        help="Compute on the Dask cluster of this scheduler (tcp://host:8786).",
    ),
]
WorkerCount = Annotated[
    int | None,
    typer.Option(
        "--workers",
        metavar="N",
        parser=whole(1, 1000),
        help="Runs at a time; else one for each core.",
    ),
]


def grid_of(over: Sequence[str] | None) -> dict[str, list[Any]] | None:
    """The grid that ``--over`` asks for.

    Raises
    ------
    SceneError
        If it is not ``KEY=VALUES``, or a key is given twice.
    """
    from gallop_fmu.foundation.errors import SceneError

    grid: dict[str, list[Any]] = {}
    for text in over or ():
        key, equals, values = (part.strip() for part in text.partition("="))
        if not (key and equals and values):
            raise SceneError(
                f"--over {text}: must be KEY=VALUES, such as --over wind.speed=4,5,6 or"
                " wind.speed=4:6:0.5"
            )
        if key in grid:
            raise SceneError(f"--over {text}: {key} is given twice")
        grid[key] = values_of(key, values)
    return grid or None


def check_given(scene: str | None, over: Sequence[str] | None, table: Path | None) -> None:
    """Refuse a command that names no runs."""
    from gallop_fmu.foundation.errors import SceneError

    if not over and table is None:
        raise SceneError(
            "nothing to vary: give --over, such as --over wind.speed=4:7:0.5, or --table"
        )
    if scene is None and table is None:
        raise SceneError(
            "no scene: give SCENE, or a --table whose column scene names one in each row"
        )


def values_of(key: str, text: str) -> list[Any]:
    """Values of a key that ``4,5,5.5`` or ``4:6:0.5`` stands for.

    Raises
    ------
    SceneError
        The text is neither, or a range has more than `MOST_POINTS` values.
    """
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.foundation.text_files import parse_value
    from gallop_fmu.input.scene_spec import SceneWithLine
    from gallop_fmu.scene.dotted_paths import takes_text

    as_text = takes_text(SceneWithLine, key)
    if as_text or ":" not in text:
        return [parse_value(value, as_text=as_text) for value in text.split(",")]
    first, last, step = range_of(key, text, ("FIRST", "LAST", "STEP"), "4:6:0.5")
    steps = (last - first) / step if step else math.nan
    if not 0.0 <= steps < MOST_POINTS or abs(steps - round(steps)) > 1e-6:
        raise SceneError(
            f"--over {key}={text}: steps of {step:g} do not lead from {first:g} to {last:g} in at"
            f" most {MOST_POINTS}"
        )
    # Rounded so that 4.2, 4.3 and 4.4 are what they look like.
    return [float(f"{first + k * step:.12g}") for k in range(round(steps) + 1)]


def range_of(key: str, text: str, parts: tuple[str, ...], example: str) -> tuple[float, ...]:
    """Numbers of a range such as ``FIRST:LAST``.

    Raises
    ------
    SceneError
        The text has another number of parts, or one is no number.
    """
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.foundation.text_rules import read_number

    found = [
        number
        for part in text.split(":")
        if (number := read_number(part)) is not None and math.isfinite(number)
    ]
    if len(found) != len(parts) or text.count(":") != len(parts) - 1:
        raise SceneError(f"--over {key}={text}: a range is {':'.join(parts)}, such as {example}")
    return tuple(map(float, found))


def carry_out(
    program: str,
    compute: Callable[[Progress | None], Runs],
    columns: Sequence[str],
    out: Path | None,
    *,
    as_json: bool,
) -> None:
    """Run, show progress, tell what came out, and end with the exit code that belongs to it."""
    from gallop_fmu.sweeps.runs import RunsStoppedError

    stopped = None
    try:
        with _bar(silent=as_json) as progress:
            runs = compute(progress)
    except RunsStoppedError as problem:
        stopped, runs = problem, problem.result
    failed = _rows(runs.failed)
    if as_json:
        files = [str(out)] if out and out.exists() else []
        told = {"runs": runs.total, "done": runs.done, "failed": failed, "files": files}
        echo_json(told if out else {**told, "rows": _rows(runs.dataset)})
    else:
        _show(runs, columns, out)
    if failed:
        complain(f"{len(failed)} of {runs.done} runs did not complete:", program)
        for row in failed[:LISTED]:
            told = row["message"].replace("\n", "\n    ")
            complain_more(f"  {_place(runs, row)}: {told}")
        if len(failed) > LISTED:
            complain_more(
                f"  and {len(failed) - LISTED} more{f'; all are in {out}' if out else ''}"
            )
    if stopped:
        complain(str(stopped), program)
    if stopped or failed:
        raise typer.Exit(Exit.ENDED_EARLY)


@contextmanager
def _bar(*, silent: bool) -> Iterator[Progress | None]:
    """Runs done, failures and time left on standard error, if somebody is there to watch."""
    if silent or not sys.stderr.isatty():
        yield None
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.description}", markup=False),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    # The time left follows from the last minutes, not from the last seconds: runs come in bursts,
    # one from each worker.
    with Progress(
        *columns, console=new_console(stderr=True), transient=True, speed_estimate_period=300.0
    ) as bar:
        task = None

        def show(done: int, failed: int, total: int) -> None:
            nonlocal task
            told = f"{failed} failed" if failed else ""
            if task is None:
                task = bar.add_task(told, total=total, completed=done)
            else:
                bar.update(task, completed=done, description=told)

        yield show


def _show(runs: Runs, columns: Sequence[str], out: Path | None) -> None:
    console, dataset = new_console(), runs.dataset
    keys = [key for key in (*runs.varied, *columns) if key in dataset]
    if "motion" in keys and "outcome" in columns:
        keys.remove(
            "outcome"
        )  # one column: what a run that completed does, or how another one ended
    # Spaces, so that a narrow terminal breaks a heading instead of cutting it; what was varied
    # keeps its name as typed.
    titles = [key if key in runs.varied else key.replace("_", " ") for key in keys]
    units = [dataset[key].attrs.get("units") for key in keys]
    table = new_table(
        *(
            f"{title}\n[{unit}]" if unit else title
            for title, unit in zip(titles, units, strict=True)
        )
    )
    rows = _rows(dataset)
    for row in rows[:SHOWN]:
        table.add_row(*(_motion(row) if key == "motion" else _cell(row.get(key)) for key in keys))
    if rows:
        console.print(table)
    if len(rows) > SHOWN:
        console.print(
            f"and {len(rows) - SHOWN}"
            f" more{f' in {out}' if out else '; name a file (--out) to have them all'}"
        )
    for told in _grouped(runs, rows, "motion"):
        if told.endswith(")"):  # with more than the table says
            console.print(told, style="dim", soft_wrap=True)
    print_warnings(_grouped(runs, rows, "warnings"))
    if out and out.exists():
        console.print(f"wrote {out}: {runs.done} of {runs.total} runs", soft_wrap=True)


def _rows(dataset: Any) -> list[dict[str, Any]]:
    from gallop_fmu.sweeps.row_store import rows_of

    return rows_of(dataset)


def _grouped(runs: Runs, rows: Sequence[dict[str, Any]], key: str) -> list[str]:
    """Each text of a column once, whatever its numbers, with the first of its runs and how many more there are."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        if row.get(key):
            groups.setdefault(re.sub(r"[\d.]+", "", row[key]), []).append(row)
    told = []
    for first, *others in groups.values():
        more = f" and {len(others)} more runs" if others else ""
        if any(row[key] != first[key] for row in others):
            more += ", with the numbers of the first"
        told.append(f"{_place(runs, first)}{more}: {first[key]}")
    return told


def _motion(row: dict[str, Any]) -> str:
    """Word on a run: its motion without the details, or its outcome where it did not complete."""
    return (
        str(row["motion"]).partition(" (")[0]
        if row["outcome"] == "completed"
        else str(row["outcome"])
    )


def _cell(value: Any) -> str:
    return (
        "-" if value in (None, "") else f"{value:.5g}" if isinstance(value, float) else str(value)
    )


def _place(runs: Runs, row: dict[str, Any]) -> str:
    """Which run it was: ``north 4, wind.speed 5.5``."""
    return ", ".join(
        row[key] if key == "name" else f"{key} {_cell(row.get(key))}" for key in runs.varied
    )
