"""The command ``gallop-modal measures``: what to change of a span or line, and what it does."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import (
    TABLE_SUFFIXES,
    AsJson,
    Changes,
    SceneName,
    check_output,
    chosen_spec,
    complain_of,
    echo_json,
    new_console,
    new_table,
    progress_bar,
    real,
)

if TYPE_CHECKING:
    from modal.study.ranked import Effect, RankedMeasures

MEASURES_EXAMPLE = "gallop-modal measures example3 --highest-wind 7 -o measures.csv"


def measures(
    scene: SceneName,
    changes: Changes = None,
    highest_wind: Annotated[
        float | None,
        typer.Option(
            metavar="SPEED",
            parser=real,
            help="Highest wind speed in m/s of the search (default: 1.5 times the scene's).",
        ),
    ] = None,
    stop_time: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            parser=real,
            help="Simulated time where a simulation is necessary (default: from the scene).",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Write the table (.nc or .csv)."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Rank measures against galloping of a span or line, each computed again.

    Of a line: tension, spacers, interphase spacers, pendulums, tuned dampers, a split span. First
    are measures with which nothing begins to gallop up to the highest wind.
    """
    from modal.study.ranking import rank_measures

    if out is not None:
        check_output(out, TABLE_SUFFIXES)
    chosen = chosen_spec(scene, changes).scene()
    complain_of(chosen, "gallop-modal")
    with progress_bar("measures", silent=as_json) as bar:
        show = None
        if bar is not None:
            task = bar.add_task("screening", total=None)

            def show(name: str) -> None:
                bar.update(task, description=name)

        found = rank_measures(chosen, highest_wind, stop_time=stop_time, progress=show)
    if out is not None:
        found.save(out)
    if as_json:
        echo_json(_numbers(found))
        return
    console = new_console()
    for line in [*_lines(found), *([] if out is None else [f"wrote {out}"])]:
        console.print(line, soft_wrap=isinstance(line, str))


def _numbers(found: RankedMeasures) -> dict[str, Any]:
    """Content of the JSON output."""
    rows = [
        {
            "measure": row.measure.name,
            "detail": row.measure.detail,
            "verified_by": row.verified_by,
            "reason": row.reason,
            "tension": row.tension,
            "sag": row.sag,
            **{when: asdict(getattr(row, when)) for when in ("before", "predicted", "after")},
        }
        for row in found.rows
    ]
    return {"title": found.title, "wind_speed": found.wind_speed, "measures": rows}


def _lines(found: RankedMeasures) -> list[Any]:
    """Title, table, and details of the measures."""
    table = new_table(
        "measure",
        "galloping from [m/s]",
        "predicted",
        "swing from [m/s]",
        f"largest amplitude [m] at {found.wind_speed:g} m/s",
        "sag [m]",
        "by",
    )
    for row in found.rows:
        table.add_row(
            row.measure.name,
            _change(_text(row.before.onset), _text(row.after.onset)),
            _text(row.predicted.onset),
            _change(_text(row.before.swing), _text(row.after.swing)),
            _change(_size(row.before), _size(row.after)),
            _text(row.sag),
            row.verified_by or "not computed",
        )
    details = [
        f"{row.measure.name}: {row.measure.detail or 'not possible'}"
        + (f"; by span {_sizes(row.after.by_span)} m" if row.after.by_span else "")
        + (f"; {row.reason}" if row.reason else "")
        for row in found.rows
    ]
    return [found.title, table, *details]


def _change(before: str, after: str) -> str:
    """Both values, or a dash if both are unknown."""
    return before if before == after == "-" else f"{before} -> {after}"


def _size(effect: Effect) -> str:
    """Largest amplitude; "at least" where it may be larger, and whether a span turns over."""
    turned = " (turned over)" if effect.turns_over else ""
    return ("at least " if effect.is_at_least else "") + _text(effect.largest, 3) + turned


def _sizes(by_span: tuple[float, ...]) -> str:
    return ", ".join(f"{size:.3f}" for size in by_span)


def _text(value: float, digits: int = 2) -> str:
    """Number; "none" if it is not reached up to the highest wind, "-" if unknown."""
    if value != value:
        return "-"
    return "none" if value == float("inf") else f"{value:.{digits}f}"
