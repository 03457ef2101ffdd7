"""The command ``gallop-modal branches``: all motions of a span or line over one number."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
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
    whole,
)

if TYPE_CHECKING:
    from modal.motions.branches import Branches

BRANCHES_EXAMPLE = "gallop-modal branches example3 --over wind.speed 4.5 9 -o branches.png"


def branches(
    scene: SceneName,
    changes: Changes = None,
    over: Annotated[
        tuple[str, str, str] | None,
        typer.Option(
            metavar="KEY START STOP",
            help="Number that is varied, and its range"
            " (default: wind.speed, from half to 1.5 times the scene's).",
        ),
    ] = None,
    simulate: Annotated[
        int,
        typer.Option(
            metavar="N",
            parser=whole(0, 100),
            help="Start the full model at N points of the stable and of the unstable part of each"
            " branch, and show where it settles.",
        ),
    ] = 0,
    out: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--out",
            metavar="FILE",
            help="Write a picture (.png, .svg, .pdf) or a table (.nc, .csv); may be repeated.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find all motions of a span or line over a number: rest, loops, swings, and stability."""
    from gallop_fmu.foundation.errors import SceneError
    from modal.motions.branches import branches as find_branches

    files = out or []
    for path in files:
        check_output(path, (*PICTURE_SUFFIXES, *TABLE_SUFFIXES))
    chosen = chosen_spec(scene, changes).scene()
    complain_of(chosen, "gallop-modal")
    name, start, stop = "wind.speed", None, None
    if over is not None:
        name, start, stop = over[0], *_range(over)
        if not start < stop:
            raise SceneError(f"--over {name} {start:g} {stop:g}: the first value must be smaller")
    with progress_bar(f"branches over {name}", silent=as_json) as bar:
        show = None
        if bar is not None:
            task = bar.add_task("equilibria", total=None)

            def show(number: int, value: float) -> None:
                bar.update(task, description=f"branch {number}, {name} = {value:.3g}")

        found = find_branches(chosen, name, start, stop, simulate=simulate, progress=show)
    for path in files:
        _write(found, path)
    if as_json:
        echo_json({**_numbers(found), "files": [str(path) for path in files]})
        return
    console = new_console()
    for line in [*_lines(found), *(f"wrote {path}" for path in files)]:
        console.print(line, soft_wrap=isinstance(line, str))


def _range(over: tuple[str, str, str]) -> tuple[float, float]:
    return real(over[1]), real(over[2])


def _write(found: Branches, path: Path) -> None:
    if path.suffix.lower() in TABLE_SUFFIXES:
        found.save(path)
        return
    from gallop_fmu.plots import save_figure
    from modal.plots.branch_figure import branch_figure

    save_figure(branch_figure(found.dataset), path)


def _numbers(found: Branches) -> dict[str, Any]:
    """Content of the JSON output: all tables, and the remarks."""
    data = found.dataset
    return {
        "title": data.attrs["title"],
        "over": found.over,
        "unit": found.unit,
        "seconds": found.seconds,
        "remarks": list(found.remarks),
        **{str(name): values.values.tolist() for name, values in data.items()},
    }


def _lines(found: Branches) -> list[Any]:
    """Tables of branches, events and simulations, and remarks."""
    data, unit = found.dataset, found.unit
    table = new_table("", "motion", "range, stable part", "error of the reduction")
    for number in data.branch.values.tolist():
        one = data.sel(branch=number)
        error = one.reduction_error.item()
        table.add_row(
            str(number),
            one["name"].item(),
            one["summary"].item(),
            "-" if error != error else f"{error:.1%}",
        )
    events = new_table(f"{found.over} [{unit}]", "branch", "event")
    for k in range(data.sizes["located"]):
        one = data.isel(located=k)
        if one.event_kind.item() != "range":
            events.add_row(
                f"{one.event_value.item():.4g}",
                str(one.event_branch.item()),
                f"{one.event_kind.item()}: {one.event_meaning.item()}",
            )
    lines = [data.attrs["title"], table, events]
    if "run" in data.sizes:
        lines.append(_runs(found))
    return [*lines, *found.remarks]


def _runs(found: Branches) -> Any:
    """Table of the simulations."""
    data = found.dataset
    table = new_table(
        f"{found.over} [{found.unit}]",
        "from branch",
        "at the end",
        "vertical [m]",
        "horizontal [m]",
        "two-loop [m]",
    )
    for k in range(data.sizes["run"]):
        one = data.isel(run=k)
        amplitudes = (
            f"{one[f'run_{name}_low'].item():.3f} to {one[f'run_{name}_high'].item():.3f}"
            for name in ("u2", "u3", "quarter")
        )
        table.add_row(
            f"{one.run_value.item():.4g}",
            f"{one.run_branch.item()}{'' if one.run_start_is_stable.item() else ' (unstable)'}",
            one.run_outcome.item(),
            *amplitudes,
        )
    return table
