"""The command ``gallop-modal screen``: the risk of a 2:1 swing of one span, or of many."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.sweep_options import (
    ClusterAddress,
    Over,
    RunsOut,
    SpanTable,
    WorkerCount,
    carry_out,
    check_given,
    grid_of,
)
from gallop_fmu.cli.terminal import AnyScene, AsJson, Changes, chosen_spec, new_table, real
from modal.cli.output import Plot, scene_to_draw, tell

if TYPE_CHECKING:
    from gallop_fmu.input.scene_spec import SceneSpec
    from gallop_fmu.sweeps.runner import Progress
    from gallop_fmu.sweeps.runs import Runs

SCREEN_EXAMPLE = "gallop-modal screen example3 --table corridor.csv -o risk.parquet"


def screen_span(
    scene: AnyScene = None,
    changes: Changes = None,
    over: Over = None,
    table: SpanTable = None,
    highest: Annotated[
        float | None,
        typer.Option(
            metavar="U", parser=real, help="Highest wind speed \\[m/s]; else 1.5 times the scene's."
        ),
    ] = None,
    first_look: Annotated[
        bool,
        typer.Option(
            "--first-look",
            help="Many spans: only the estimate by hand, about thirty times as fast.",
        ),
    ] = False,
    out: RunsOut = None,
    workers: WorkerCount = None,
    cluster: ClusterAddress = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Tell whether galloping will start the horizontal swing by 2:1 internal resonance, and from which wind on.

    Of one scene, or of many: over values of its parameters, every span of a table, or both.
    """
    from dataclasses import asdict

    from gallop_fmu.foundation.errors import SceneError
    from modal.screening.screen import screen

    if over or table:
        if plot:
            raise SceneError("--plot draws one span; leave it out, or leave out --over and --table")
        check_given(scene, over, table)
        _screen_many(
            chosen_spec(scene, changes) if scene else None,
            over,
            table,
            highest,
            first_look,
            out,
            workers,
            cluster,
            as_json,
        )
        return
    if first_look or out or workers or cluster:
        raise SceneError(
            "--first-look, --out, --workers and --cluster are for many spans; give --over or"
            " --table"
        )
    if scene is None:
        raise SceneError("no scene: give SCENE, or spans to screen with --table")
    chosen = scene_to_draw(scene, changes, plot)
    found = screen(chosen, highest)

    def figure() -> Any:
        from modal.plots.span_figures import screening_figure

        return screening_figure(found)

    cycles = new_table("", "wind [m/s]", "vertical [m]", "horizontal [m]", "frequency [Hz]")
    for name, cycle in (("without swing", found.galloping), ("with swing", found.saturated)):
        if cycle is not None:
            numbers = (cycle.wind_speed, cycle.vertical, cycle.horizontal, cycle.frequency_hz)
            cycles.add_row(name, *(f"{number:.4g}" for number in numbers))
    lines = [
        chosen.title,
        f"risk of a 2:1 swing: {found.risk}",
        found.reason,
        *([cycles] if found.galloping else []),
    ]
    ratios = {"ratio": found.frequencies.ratio, "detuning": found.frequencies.detuning}
    told = {
        "title": chosen.title,
        **asdict(found),
        **ratios,
        "growth_per_cycle": found.growth_per_cycle,
    }
    tell(told, lines, figure, plot, as_json)


def _screen_many(
    base: SceneSpec | None,
    over: list[str] | None,
    table: Path | None,
    highest: float | None,
    first_look: bool,
    out: Path | None,
    workers: int | None,
    cluster: str | None,
    as_json: bool,
) -> None:
    from modal.screening.many_spans import screen_spans

    def compute(progress: Progress | None) -> Runs:
        return screen_spans(
            base,
            grid_of(over),
            table=table,
            highest_wind=highest,
            first_look=first_look,
            out=out,
            workers=workers,
            cluster=cluster,
            progress=progress,
        )

    columns = (
        "outcome", "suspect", "risk", "ratio", "galloping_from", "other_galloping_from", "onset_wind_speed",
        "estimated_onset",
    )  # fmt: skip
    carry_out("gallop-modal", compute, columns, out, as_json=as_json)
