"""The command ``gallop-modal atlas``: the risk of spans for random wind and ice."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.sweep_options import SpanTable, progress_bar
from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    AnyScene,
    AsJson,
    Changes,
    Exit,
    check_output,
    chosen_spec,
    complain,
    new_table,
    print_warnings,
    real,
    whole,
)
from modal.cli.output import Plot, show

if TYPE_CHECKING:
    import xarray as xr

    from modal.risk.atlas import RiskAtlas

ATLAS_EXAMPLE = "gallop-modal atlas corridor.toml --random winter.toml --table spans.csv -o runs.nc"
SUMMARY_SUFFIXES = (".csv", ".geojson", ".nc")
SHOWN_PERIODS = (10.0, 50.0)
"""Return periods [winters] of the amplitudes that a terminal shows."""


def atlas(  # noqa: PLR0913 - options of a command
    random: Annotated[
        Path,
        typer.Option(
            "--random",
            metavar="FILE",
            help=(
                "Distributions of wind and ice, such as"
                ' wind.speed = \\{distribution = "weibull_min", c = 2, scale = 6} in the table'
                " \\[random]; events_per_winter above it."
            ),
        ),
    ],
    scene: AnyScene = None,
    changes: Changes = None,
    table: SpanTable = None,
    draws: Annotated[
        int,
        typer.Option(metavar="N", parser=whole(2, 1 << 20), help="Draws a span; a power of two."),
    ] = 256,
    seed: Annotated[
        int, typer.Option(metavar="N", parser=whole(0, 1 << 62), help="Seed of the draws.")
    ] = 0,
    shares: Annotated[
        bool, typer.Option("--shares", help="Compute Sobol shares, too; needs more runs.")
    ] = False,
    method: Annotated[
        str,
        typer.Option(
            metavar="METHOD", help="estimate (spans, some milliseconds a draw) or simulate."
        ),
    ] = "estimate",
    stop_time: Annotated[
        float | None,
        typer.Option(metavar="T", parser=real, help="With simulate: simulated time in s."),
    ] = None,
    clearance: Annotated[
        float | None,
        typer.Option(
            metavar="D",
            parser=real,
            help=(
                "Distance of two phases less the flashover distance, in m. Or a column"
                " label.clearance of the table."
            ),
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="Keep all runs: .parquet or .nc. The same command computes only missing ones.",
        ),
    ] = None,
    summary: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the risk of each span: .csv, .geojson or .nc."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(metavar="N", parser=whole(1, 1000), help="Runs computed at a time."),
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Compute on this Dask cluster.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Compute the probability of galloping, swing and clash of spans for random wind and ice."""
    from gallop_fmu.sweeps.runs import RunsStoppedError
    from modal.risk.atlas import risk_atlas
    from modal.risk.winter_file import read_winter

    check_output(plot, PICTURE_SUFFIXES)
    check_output(summary, SUMMARY_SUFFIXES)
    winter = read_winter(random)
    try:
        with progress_bar(silent=as_json) as progress:
            found = risk_atlas(
                chosen_spec(scene, changes) if scene else None,
                winter.random,
                table=table,
                draws=draws,
                seed=seed,
                shares=shares,
                method=method,  # type: ignore[arg-type]  # it is checked
                stop_time=stop_time,
                events_per_winter=winter.events_per_winter,
                clearance=clearance,
                out=out,
                workers=workers,
                cluster=cluster,
                progress=progress,
            )
    except RunsStoppedError as problem:
        complain(str(problem), "gallop-modal")
        raise typer.Exit(Exit.ENDED_EARLY) from None
    if summary:
        found.write(summary)

    def figure() -> Any:
        from modal.plots.risk_figure import risk_figure

        return risk_figure(found)

    show(_numbers(found), _lines(found, summary, out), figure, plot, as_json)
    if not as_json:
        print_warnings(list(found.remarks))


def _numbers(found: RiskAtlas) -> dict[str, Any]:
    """Content of the JSON output; a number that is not known is null."""
    return {
        **found.dataset.attrs,
        "remarks": list(found.remarks),
        "spans": found.table().to_dict("records"),
    }


def _lines(found: RiskAtlas, *files: Path | None) -> list[Any]:
    """Table of the spans, and the files that were written."""
    data = found.dataset
    events = [event for event in ("galloping", "swing", "clash") if data[event].notnull().any()]
    periods = [
        period
        for period in SHOWN_PERIODS
        if period in data.return_period and data.amplitude.sel(return_period=period).notnull().any()
    ]
    table = new_table(
        "span",
        *(f"{event}\n[% of winters]" for event in events),
        *(f"{period:g} winters\n[m peak-peak]" for period in periods),
        "unresolved\n[% of draws]",
    )
    for name in data.span.values.tolist():
        at = data.sel(span=name)
        table.add_row(
            name,
            *(_with_interval(at, f"winter_{event}", 100.0) for event in events),
            *(_with_interval(at.sel(return_period=period), "amplitude", 2.0) for period in periods),
            f"{100.0 * at.unresolved.item():.1f}",
        )
    meaning = "(interval of 95 % confidence); -: too few draws, or no clearance is given"
    return [table, meaning, *(f"wrote {path}" for path in files if path)]


def _with_interval(data: xr.Dataset, name: str, factor: float) -> str:
    value, low, high = (factor * data[name + end].item() for end in ("", "_lowest", "_highest"))
    return "-" if math.isnan(value) else f"{value:.3g} ({low:.3g}-{high:.3g})"
