"""The command ``gallop-modal sensitivity``: derivatives of onsets and motions by numbers."""

from __future__ import annotations

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
    import xarray as xr

SENSITIVITY_EXAMPLE = "gallop-modal sensitivity example3 --start 4.5 --stop 5.6 -o sensitivity.csv"


def sensitivity(
    scene: SceneName,
    changes: Changes = None,
    numbers: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY",
            help="Number of the scene, or a factor such as damping.translation or"
            " aerodynamics.lift; may be repeated (default: tension, length, ice, damping, curve,"
            " supports).",
        ),
    ] = None,
    start: Annotated[
        float | None,
        typer.Option(
            metavar="U",
            parser=real,
            help="Lowest wind speed in m/s of the search (default: half the scene's).",
        ),
    ] = None,
    stop: Annotated[
        float | None,
        typer.Option(
            metavar="U",
            parser=real,
            help="Highest wind speed in m/s of the search (default: 1.5 times the scene's).",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="FILE", help="Write the table (.nc or .csv)."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Differentiate onsets, amplitudes and growth of all motions by numbers of the scene."""
    from modal.motions.sensitivity import sensitivity as find_sensitivity

    if out is not None:
        check_output(out, TABLE_SUFFIXES)
    chosen = chosen_spec(scene, changes).scene()
    complain_of(chosen, "gallop-modal")
    with progress_bar("sensitivity", silent=as_json) as bar:
        show = None
        if bar is not None:
            task = bar.add_task("equilibria", total=None)

            def show(name: str) -> None:
                bar.update(task, description=name)

        found = find_sensitivity(chosen, numbers, start, stop, progress=show)
    if out is not None:
        found.save(out)
    data = found.dataset
    if as_json:
        names = [*data.coords, *data.data_vars]
        tables = {str(name): data[name].values.tolist() for name in names}
        echo_json({"title": data.attrs["title"], "remarks": list(found.remarks), **tables})
        return
    console = new_console()
    console.print(data.attrs["title"], soft_wrap=True)
    for line in [*_tables(data), *found.remarks, *([] if out is None else [f"wrote {out}"])]:
        console.print(line, soft_wrap=isinstance(line, str))


def _tables(data: xr.Dataset) -> list[Any]:
    """A table for each quantity, its strongest number first."""
    tables: list[Any] = []
    for k in range(data.sizes["quantity"]):
        one = data.isel(quantity=k)
        unit = one["unit"].item()
        tables.append(f"{one['quantity'].item()}: {one['value'].item():.4g} {unit}")
        table = new_table("number", "present value", f"{unit} per unit", "% per %")
        rows = zip(
            one["number"].values.tolist(),
            one["present"].values.tolist(),
            one["number_unit"].values.tolist(),
            one["derivative"].values.tolist(),
            one["relative"].values.tolist(),
            strict=True,
        )
        for name, present, number_unit, derivative, relative in sorted(rows, key=_strength):
            table.add_row(
                name,
                f"{present:.6g} {number_unit}".removesuffix(" 1"),
                f"{derivative:+.4g}",
                "-" if relative != relative else f"{relative:+.3g}",
            )
        tables.append(table)
    return tables


def _strength(row: tuple[str, float, str, float, float]) -> float:
    """Place in the table: the largest relative change first, unknown ones last."""
    relative = row[-1]
    return float("inf") if relative != relative else -abs(relative)
