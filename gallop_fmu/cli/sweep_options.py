"""Options, progress and output that ``gallop-fmu sweep`` and ``gallop-modal screen`` share."""

from __future__ import annotations

import inspect
import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from gallop_fmu.cli.terminal import (
    AnyScene,
    AsJson,
    Changes,
    Exit,
    chosen_spec,
    complain,
    complain_more,
    echo_json,
    new_console,
    new_table,
    print_warnings,
    whole,
)
from gallop_fmu.foundation.text_rules import counted

if TYPE_CHECKING:
    import xarray as xr

    from gallop_fmu.sweeps.rows import Row
    from gallop_fmu.sweeps.runner import Progress
    from gallop_fmu.sweeps.runs import Runs

MAX_ROWS_SHOWN = 20
"""Rows of results that a terminal shows."""
MAX_FAILURES_SHOWN = 10
"""Failed runs that a terminal lists."""
MAX_POINTS = 1_000_000
"""Values that one range can have."""

SpanTable = Annotated[
    Path | None,
    typer.Option(
        "--table",
        metavar="FILE_OR_FOLDER",
        help=(
            "Spans or lines to compute: a folder of scene files, .csv, or .geojson whose properties"
            " are the columns. Columns are values of a scene (span.length) or of its \\[line]"
            " (line.span), name, scene (a packaged name or a path), and label.ANYTHING, which is"
            " copied to the results."
        ),
    ),
]


@dataclass(frozen=True)
class SweepOptions:
    """Options of every command that computes many scenes."""

    scene: AnyScene = None
    changes: Changes = None
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help=(
                "Vary a value of the scene; may be repeated, all combinations are computed. "
                "VALUES: 4,5,5.5 or FIRST:LAST:STEP, both ends included."
            ),
        ),
    ] = None
    table: SpanTable = None
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help=(
                "Write the results: .parquet or .nc. Each row is written at once to FILE.journal,"
                " which is kept; the same command again computes only the missing rows."
            ),
        ),
    ] = None
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            metavar="N",
            parser=whole(1, 1000),
            help="Runs computed at a time (default: one for each core).",
        ),
    ] = None
    cluster: Annotated[
        str | None,
        typer.Option(
            "--cluster",
            metavar="ADDRESS",
            help="Compute on the Dask cluster of this scheduler (tcp://host:8786).",
        ),
    ] = None
    as_json: AsJson = False

    def arguments(self) -> dict[str, Any]:
        """Keyword arguments of `gallop_fmu.sweep` and `modal.screen_spans`.

        Raises
        ------
        SceneError
            The options name no runs or no scene, or a value is not allowed.
        """
        from gallop_fmu.foundation.errors import SceneError

        if not self.over and self.table is None:
            raise SceneError(
                "nothing to vary: give --over, such as --over wind.speed=4:7:0.5, or --table"
            )
        if self.scene is None and self.table is None:
            raise SceneError(
                "no scene: give SCENE, or a --table whose column scene names one in each row"
            )
        return {
            "scene": chosen_spec(self.scene, self.changes) if self.scene else None,
            "over": grid_of(self.over),
            "table": self.table,
            "out": self.out,
            "workers": self.workers,
            "cluster": self.cluster,
        }

    def carry_out(self, program: str, compute: Callable[..., Runs], columns: Sequence[str]) -> None:
        """Compute the runs, show progress and results, and end with the exit code.

        Parameters
        ----------
        program
            Name of the command in messages.
        compute
            Takes `arguments` and ``progress``.
        columns
            Columns of results that a terminal shows.
        """
        from gallop_fmu.sweeps.runs import RunsStoppedError

        arguments, stopped = self.arguments(), None
        try:
            with progress_bar(silent=self.as_json) as progress:
                runs = compute(**arguments, progress=progress)
        except RunsStoppedError as problem:
            stopped, runs = problem, problem.result
        failed = _rows(runs.failed)
        if self.as_json:
            _print_json(runs, failed, self.out)
        else:
            _print_rows(runs, columns, self.out)
        _complain_of_failures(runs, failed, self.out, program)
        if stopped:
            complain(str(stopped), program)
        if stopped or failed:
            raise typer.Exit(Exit.ENDED_EARLY)


def takes_sweep_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of `SweepOptions` to a command, which gets them as its first argument."""
    hints = get_type_hints(SweepOptions, include_extras=True)
    shared = [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=field.default,
            annotation=hints[field.name],
        )
        for field in fields(SweepOptions)
    ]
    _, *own = inspect.signature(command, eval_str=True).parameters.values()
    own = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]

    @wraps(command)
    def with_options(**given: Any) -> None:
        options = SweepOptions(
            **{field.name: given.pop(field.name) for field in fields(SweepOptions)}
        )
        command(options, **given)

    signature = inspect.Signature([*shared, *own])
    with_options.__signature__ = signature  # type: ignore[attr-defined]
    with_options.__annotations__ = {
        name: parameter.annotation for name, parameter in signature.parameters.items()
    }
    return with_options


def grid_of(over: Sequence[str] | None) -> dict[str, list[Any]] | None:
    """Return the grid that ``--over`` describes.

    Raises
    ------
    SceneError
        A text is not ``KEY=VALUES``, or a key is given twice.
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


def values_of(key: str, text: str) -> list[Any]:
    """Return the values that a text such as ``4,5,5.5`` or ``4:6:0.5`` lists.

    Raises
    ------
    SceneError
        The text is neither, or a range has more than `MAX_POINTS` values.
    """
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.foundation.text_files import parse_value
    from gallop_fmu.input.scene_spec import is_text_key

    as_text = is_text_key(key)
    if as_text or ":" not in text:
        return [parse_value(value, as_text=as_text) for value in text.split(",")]
    first, last, step = range_of(key, text, ("FIRST", "LAST", "STEP"), "4:6:0.5")
    steps = (last - first) / step if step else math.nan
    if not 0.0 <= steps < MAX_POINTS or abs(steps - round(steps)) > 1e-6:
        raise SceneError(
            f"--over {key}={text}: steps of {step:g} do not lead from {first:g} to {last:g}, or"
            f" are more than {MAX_POINTS}; choose a step that divides the range"
        )
    # Rounding gives 4.3, not 4.300000000000001.
    return [float(f"{first + k * step:.12g}") for k in range(round(steps) + 1)]


def range_of(key: str, text: str, parts: tuple[str, ...], example: str) -> tuple[float, ...]:
    """Return the numbers of a range such as ``FIRST:LAST``.

    Raises
    ------
    SceneError
        The number of parts is different, or a part is not a number.
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


@contextmanager
def progress_bar(*, silent: bool) -> Iterator[Progress | None]:
    """Show runs done, failures and time left on standard error, if it is a terminal.

    Yield what a function takes as its argument ``progress``; None shows nothing.
    """
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
    # Estimate the time left from the last minutes: runs end in bursts, one from each worker.
    with Progress(
        *columns, console=new_console(stderr=True), transient=True, speed_estimate_period=300.0
    ) as bar:
        task = None

        def show(done: int, failed: int, total: int) -> None:
            nonlocal task
            description = f"{failed} failed" if failed else ""
            if task is None:
                task = bar.add_task(description, total=total, completed=done)
            else:
                bar.update(task, completed=done, description=description)

        yield show


def _print_json(runs: Runs, failed: list[Row], out: Path | None) -> None:
    content: dict[str, Any] = {
        "runs": runs.total,
        "done": runs.done,
        "failed": failed,
        "files": [str(out)] if out and out.exists() else [],
    }
    if not out:
        content["rows"] = _rows(runs.dataset)
    echo_json(content)


def _complain_of_failures(runs: Runs, failed: list[Row], out: Path | None, program: str) -> None:
    """Print the first failed runs, each with its message, on standard error."""
    if not failed:
        return
    complain(f"{len(failed)} of {runs.done} runs did not complete:", program)
    for row in failed[:MAX_FAILURES_SHOWN]:
        message = row["message"].replace("\n", "\n    ")
        complain_more(f"  {_run_label(runs, row)}: {message}")
    if len(failed) > MAX_FAILURES_SHOWN:
        where = f"; all are in {out}" if out else ""
        complain_more(f"  and {len(failed) - MAX_FAILURES_SHOWN} more{where}")


def _print_rows(runs: Runs, columns: Sequence[str], out: Path | None) -> None:
    """Print the first rows as a table, then the details of motions and the warnings."""
    console, dataset = new_console(), runs.dataset
    keys = [key for key in (*runs.varied, *columns) if key in dataset]
    if "motion" in keys and "outcome" in columns:
        keys.remove("outcome")  # the column "motion" also says how a run ended
    rows = _rows(dataset)
    if rows:
        console.print(_table(runs, rows[:MAX_ROWS_SHOWN], keys))
    if len(rows) > MAX_ROWS_SHOWN:
        where = f" in {out}" if out else "; give --out FILE to get them all"
        console.print(f"and {len(rows) - MAX_ROWS_SHOWN} more{where}")
    for sentence in _grouped(runs, rows, "motion"):
        if sentence.endswith(")"):  # it has more than the table shows
            console.print(sentence, style="dim", soft_wrap=True)
    for sentence in _grouped(runs, rows, "unresolved"):
        console.print(f"unresolved, {sentence}", soft_wrap=True)
    print_warnings(_grouped(runs, rows, "warnings"))
    if out and out.exists():
        console.print(f"wrote {out}: {runs.done} of {runs.total} runs", soft_wrap=True)


def _table(runs: Runs, rows: list[Row], keys: list[str]) -> Any:
    table = new_table(*(_heading(runs, key) for key in keys))
    for row in rows:
        table.add_row(*(_motion(row) if key == "motion" else _cell_of(row, key) for key in keys))
    return table


def _heading(runs: Runs, key: str) -> str:
    """Heading of a column; spaces let a narrow terminal break it, a varied key stays as typed."""
    title = key if key in runs.varied else key.replace("_", " ")
    unit = runs.dataset[key].attrs.get("units")
    return f"{title}\n[{unit}]" if unit else title


def _rows(dataset: xr.Dataset) -> list[Row]:
    from gallop_fmu.sweeps.results_file import rows_of

    return rows_of(dataset)


def _grouped(runs: Runs, rows: Sequence[Row], key: str) -> list[str]:
    """Texts of a column that differ in more than numbers, each with its first run."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row.get(key):
            groups.setdefault(re.sub(r"[\d.]+", "", row[key]), []).append(row)
    sentences = []
    for first, *others in groups.values():
        more = f" and {counted(len(others), 'more run')}" if others else ""
        if any(row[key] != first[key] for row in others):
            more += ", with the numbers of the first"
        sentences.append(f"{_run_label(runs, first)}{more}: {first[key]}")
    return sentences


def _motion(row: Row) -> str:
    """Motion of a completed run without details, or the outcome of another run."""
    if row["outcome"] != "completed":
        return str(row["outcome"])
    return str(row["motion"]).partition(" (")[0]


def _cell(value: Any) -> str:
    if value in (None, ""):
        return "-"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _cell_of(row: Row, key: str) -> str:
    """Cell of a column; of one of spans or towers the values of all, in their order."""
    from gallop_fmu.sweeps.places import placed

    if key in row:
        return _cell(row[key])
    return ", ".join(_cell(value) for name, value in row.items() if placed(name)[0] == key)


def _run_label(runs: Runs, row: Row) -> str:
    """Label of a run: its varied values, such as ``north 4, wind.speed 5.5``."""
    return ", ".join(
        row[key] if key == "name" else f"{key} {_cell(row.get(key))}" for key in runs.varied
    )
