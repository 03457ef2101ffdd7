"""The command ``gallop-modal screen``: the risk of a 2:1 swing of one span, or of many."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.sweep_options import SweepOptions, takes_sweep_options
from gallop_fmu.cli.terminal import new_table, real
from modal.cli.line_output import show_line_screening
from modal.cli.output import Plot, line_or_span_to_draw, show

if TYPE_CHECKING:
    from gallop_fmu.scene.scene import Scene
    from modal.screening.cycles import Transfer
    from modal.screening.screen import Screening

SCREEN_EXAMPLE = "gallop-modal screen example3 --table corridor.csv -o risk.parquet"


COLUMNS = (
    "outcome",
    "suspect",
    "risk",
    "ratio",
    "galloping_from",
    "other_galloping_from",
    "onset_wind_speed",
    "estimated_onset",
    "largest_vertical",
)
"""Columns of results that a terminal shows."""


@takes_sweep_options
def screen_span(
    shared: SweepOptions,
    highest_wind: Annotated[
        float | None,
        typer.Option(
            metavar="U",
            parser=real,
            help="Highest wind speed in m/s (default: 1.5 times the scene's).",
        ),
    ] = None,
    estimate_only: Annotated[
        bool,
        typer.Option(
            "--estimate-only",
            help="For many spans: closed-form estimate only (about 30 times faster).",
        ),
    ] = False,
    plot: Plot = None,
) -> None:
    """Find what a span or line does in its wind, and if galloping starts a swing (2:1 resonance).

    For one scene of a span or line, or for many: over values of its parameters, every scene of a
    table or folder, or both.
    """
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.scene.line_scene import LineScene
    from modal.screening.many_spans import screen_spans
    from modal.screening.screen import screen

    if shared.over or shared.table:
        if plot:
            raise SceneError("--plot draws one span; leave it out, or leave out --over and --table")
        compute = partial(screen_spans, highest_wind=highest_wind, estimate_only=estimate_only)
        shared.carry_out("gallop-modal", compute, COLUMNS)
        return
    if estimate_only or shared.out or shared.workers or shared.cluster:
        raise SceneError(
            "--estimate-only, --out, --workers and --cluster are for many spans; give --over or"
            " --table"
        )
    if shared.scene is None:
        raise SceneError("no scene: give SCENE, or spans to screen with --table")
    chosen = line_or_span_to_draw(shared.scene, shared.changes, plot)
    if isinstance(chosen, LineScene):
        if plot:
            raise SceneError("--plot draws one span; leave it out: the scene is a line")
        show_line_screening(chosen, highest_wind, shared.as_json)
        return
    found = screen(chosen, highest_wind)

    def figure() -> Any:
        from modal.plots.span_figures import screening_figure

        return screening_figure(found)

    show(_numbers(chosen, found), _lines(chosen, found), figure, plot, shared.as_json)


def _numbers(scene: Scene, found: Screening) -> dict[str, Any]:
    """Content of the JSON output."""
    from dataclasses import asdict

    return {
        "title": scene.title,
        **asdict(found),
        "ratio": found.frequencies.ratio,
        "detuning": found.frequencies.detuning,
        "growth_per_cycle": found.growth_per_cycle,
    }


def _growth(transfer: Transfer) -> str:
    """Describe a growing disturbance."""
    return (
        f"{transfer.disturbance} grows by {transfer.growth_rate:.3g} 1/s, from 1 mm to 0.1 m in"
        f" {transfer.time():.3g} s"
    )


def _lines(scene: Scene, found: Screening) -> list[Any]:
    """Lines and table of the output for people."""
    from modal.screening.verdict import RISK_OF

    lines = [scene.title, f"{RISK_OF}: {found.risk}", found.reason]
    lines += [f"from {one.origin}: {_growth(one)}" for one in found.transfers]
    if not found.galloping:
        return lines
    table = new_table("", "wind [m/s]", "vertical [m]", "horizontal [m]", "frequency [Hz]")
    for name, cycle in (("without swing", found.galloping), ("with swing", found.saturated)):
        if cycle is not None:
            numbers = (cycle.wind_speed, cycle.vertical, cycle.horizontal, cycle.frequency_hz)
            table.add_row(name, *(f"{number:.4g}" for number in numbers))
    return [*lines, table]
