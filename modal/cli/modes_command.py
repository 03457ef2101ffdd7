"""The command ``gallop-modal modes``: natural modes, or their tracks over a number."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gallop_fmu.cli.terminal import AsJson, Changes, SceneName, new_table, whole
from modal.cli.line_output import show_modes
from modal.cli.number_options import OverNumber, Points, only_for_spans, varied_values
from modal.cli.output import Plot, line_or_span_to_draw, show

if TYPE_CHECKING:
    import xarray as xr

    from gallop_fmu.scene.scene import Scene
    from modal.linear.modes import Mode

MODES_EXAMPLE = "gallop-modal modes example3 --over span.horizontal_tension --plot veering.png"


def modes(
    scene: SceneName,
    changes: Changes = None,
    count: Annotated[
        int, typer.Option(metavar="N", parser=whole(0, 10000), help="Number of modes.")
    ] = 12,
    wind: Annotated[
        Literal["still", "mean"],
        typer.Option(help="Modes in still air, or about the equilibrium in the mean wind."),
    ] = "still",
    over: OverNumber = None,
    points: Points = 25,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """List the lowest natural modes, or track them over values of a number."""
    from gallop_fmu.scene.line_scene import LineScene
    from modal.linear.modes import natural_modes

    chosen = line_or_span_to_draw(scene, changes, plot)
    if isinstance(chosen, LineScene):
        only_for_spans({"--over": over})
        show_modes(chosen, count, wind, plot, as_json)
        return
    if over is not None:
        _track_modes(chosen, count, wind, *varied_values(chosen, over, points), plot, as_json)
        return
    found = natural_modes(chosen, count, wind)

    def figure() -> Any:
        from modal.plots.span_figures import mode_shapes

        return mode_shapes(found, chosen.title)

    content = {
        "title": chosen.title,
        "warnings": list(chosen.warnings),
        "wind": wind,
        "modes": [
            {
                "frequency_hz": mode.frequency_hz,
                "damping_ratio": mode.damping_ratio,
                "family": mode.family,
                "symmetric": mode.symmetric,
                "loops": mode.loops,
                "shares": mode.shares,
                "participation": mode.participation,
            }
            for mode in found
        ],
    }
    show(content, [chosen.title, _mode_table(found)], figure, plot, as_json)


def _mode_table(found: list[Mode]) -> Any:
    """Table of modes for people."""
    table = new_table("frequency [Hz]", "damping ratio", "family", "share", "loops", "symmetric")
    for mode in found:
        table.add_row(
            f"{mode.frequency_hz:.4f}",
            f"{mode.damping_ratio:.3%}",
            mode.family,
            f"{mode.shares[mode.family]:.1%}",
            str(mode.loops),
            "yes" if mode.symmetric else "no",
        )
    return table


def _track_modes(
    scene: Scene,
    count: int,
    wind: Literal["still", "mean"],
    over: str,
    values: list[float],
    plot: Path | None,
    as_json: bool,
) -> None:
    """Print frequencies and families over values of a number."""
    from modal.linear.mode_tracking import track_modes

    data = track_modes(scene, over, values, count, wind)

    def figure() -> Any:
        from modal.plots.span_figures import tracking_figure

        return tracking_figure(data)

    content = {
        "title": scene.title,
        "warnings": list(scene.warnings),
        "wind": wind,
        "over": over,
        "unit": data[over].attrs["units"],
        "values": values,
        "modes": _tracked_rows(data),
    }
    show(content, [scene.title, _tracked_table(data, over)], figure, plot, as_json)


def _tracked_rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Tracked modes as JSON, each with its values along the way."""
    shares, names = data.share.values, data.family.values
    families = names[shares.argmax(axis=2)]
    return [
        {
            "frequency_hz": data.frequency_hz.values[k].tolist(),
            "damping_ratio": data.damping_ratio.values[k].tolist(),
            "family": families[k].tolist(),
            "shares": {name: shares[k, :, f].tolist() for f, name in enumerate(names.tolist())},
            "likeness": data.likeness.values[k].tolist(),
        }
        for k in range(len(families))
    ]


def _tracked_table(data: xr.Dataset, over: str) -> Any:
    """Table of tracked modes for people: the first and the last value."""
    families = data.family.values[data.share.values.argmax(axis=2)]
    values, unit = data[over].values, data[over].attrs["units"]
    first, last = (f"at {value:g} {unit}" for value in (values[0], values[-1]))
    table = new_table("mode", f"{first} [Hz]", "family", f"{last} [Hz]", "family")
    for k, (wave, family) in enumerate(zip(data.frequency_hz.values, families, strict=True)):
        table.add_row(str(k + 1), f"{wave[0]:.4f}", family[0], f"{wave[-1]:.4f}", family[-1])
    return table
