"""The command ``gallop-modal slope``: slope of the coefficient curve that galloping needs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import AsJson, Changes, SceneName, new_table, real, whole
from modal.cli.output import Plot, line_or_span_to_draw, show

if TYPE_CHECKING:
    from modal.stability.required_slope import RequiredSlope

SLOPE_EXAMPLE = "gallop-modal slope example3 --highest-wind 12 --plot slope.png"

POINTS = 20
"""Number of wind speeds."""


def slope(
    scene: SceneName,
    changes: Changes = None,
    count: Annotated[
        int, typer.Option(metavar="N", parser=whole(1, 10000), help="Number of modes.")
    ] = 6,
    highest_wind: Annotated[
        float, typer.Option(metavar="U", parser=real, help="Highest wind speed in m/s.")
    ] = 20.0,
    drag: Annotated[
        float | None,
        typer.Option(
            metavar="CD",
            parser=real,
            help="Drag coefficient (default: from the scene's curve; 1.0 without a curve).",
        ),
    ] = None,
    saturation_deg: Annotated[
        float,
        typer.Option(
            metavar="DEG",
            parser=real,
            help="Assumed rotation of the relative wind at which the lift force changes its sign.",
        ),
    ] = 45.0,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Print how negative CD + dCL/dalpha must be for galloping, and an estimate of its amplitude.

    The coefficient curve need not be known; of a curve only the drag is used.
    """
    import numpy as np

    from gallop_fmu.foundation.errors import SceneError
    from modal.stability.required_slope import required_slope

    if not (np.isfinite(highest_wind) and highest_wind > 0.0):
        raise SceneError(f"--highest-wind {highest_wind:g}: must be a finite, positive wind speed")
    chosen = line_or_span_to_draw(scene, changes, plot)
    found = required_slope(
        chosen,
        np.linspace(highest_wind / POINTS, highest_wind, POINTS).tolist(),
        count=count,
        drag=drag,
        saturation_deg=saturation_deg,
    )

    def figure() -> Any:
        from modal.plots.slope_figure import slope_figure

        return slope_figure(found)

    content = {"title": chosen.title, "warnings": list(chosen.warnings), **_numbers(found)}
    show(content, [chosen.title, *_lines(found)], figure, plot, as_json)


def _numbers(found: RequiredSlope) -> dict[str, Any]:
    """Content of the JSON output; a number that does not exist is null."""
    data = found.dataset
    return {
        "drag": found.drag,
        "given_lift_slope": found.given_lift_slope,
        "given_moment_slope": found.given_moment_slope,
        "saturation_deg": found.saturation_deg,
        "remarks": found.remarks,
        "units": {name: data[name].attrs["units"] for name in data if "units" in data[name].attrs},
        "mode": data.mode.values.tolist(),
        "wind_speed": data.wind_speed.values.tolist(),
        **{str(name): _without_nan(values.values.tolist()) for name, values in data.items()},
    }


def _without_nan(values: Any) -> Any:
    if isinstance(values, list):
        return [_without_nan(value) for value in values]
    return None if isinstance(values, float) and math.isnan(values) else values


def _lines(found: RequiredSlope) -> list[Any]:
    """Table over the wind speed, of the mode that needs the least steep slope, and remarks."""
    data = found.dataset
    table = new_table(
        "wind [m/s]", "CD + dCL/dalpha", "mode", "amplitude [m]", "dCM/dalpha", "diverges"
    )
    for speed in data.wind_speed.values:
        at = data.sel(wind_speed=speed)
        if at.slope.isnull().all():
            mode, needed, reach = "-", "-", "-"
        else:
            best = at.isel(mode=int(at.slope.fillna(-math.inf).argmax("mode")))
            mode = f"{best.mode.item()} {best.family.item()} {best.loops.item()}"
            needed, reach = f"{best.slope.item():.3g}", f"{best.amplitude_limit.item():.3g}"
        torsional = at.moment_slope.max().item()
        diverges = at.divergence_moment_slope.item()
        table.add_row(f"{speed:g}", needed, mode, reach, *map(_printed, (torsional, diverges)))
    meaning = (
        "slopes per rad: vertical modes grow below CD + dCL/dalpha, torsional modes below"
        " dCM/dalpha; the twist diverges above the last column. The amplitude is the limit for very"
        " negative slopes."
    )
    return [table, meaning, *found.remarks]


def _printed(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3g}"
