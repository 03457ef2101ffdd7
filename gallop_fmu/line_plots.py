"""Figures of a run of a line: its shape in elevation and plan, histories, paths of mid-spans.

Functions return a `matplotlib.figure.Figure` and do not use pyplot's global state.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import MappedTower
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.plots import (
    COLOURS,
    NEUTRAL,
    STYLE,
    TEXT_WIDTH,
    add_notes,
    add_title,
    drawing,
    thinned,
)
from gallop_fmu.simulation.line_result import LineResult

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

ROW_HEIGHT = 1.05
"""Height [inch] of a panel of histories."""

PATHS_IN_ROW = 5
"""Panels of paths in a row."""

CLOSE_TIME = 20.0
"""Length [s] of the end of the run of which paths are drawn."""

MIN_PATH_WIDTH = 0.4
"""Least width of a panel of paths, relative to the height of the highest path."""

STRING_WIDTH = 2.2
"""Width of the line [point] of a string."""

STRING_COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
STRING_STYLES = ("-", "--", ":")
"""Colours of Okabe and Ito, and styles of lines, of the strings of a line."""

MIN_HALF_RANGE = 0.5
"""Half range [m] of an axis along which nothing moves."""


def line_shape(result: LineResult) -> Figure:
    """Draw a line in elevation and in plan: at rest, and where it is farthest downwind.

    The shaded area is the range of heights in the run. Strings are thick lines, from tower point to
    clamp; the tower points are at their places in the scene, without prescribed motion. Scales of
    the axes differ.

    Parameters
    ----------
    result
        A run with the displacements of all nodes (``record_nodes="all"``); with others, the
        conductors are straight between the recorded nodes.

    Raises
    ------
    SceneError
        The displacements u1, u2 and u3 were not recorded.
    """
    data = result.dataset
    missing = [name for name in ("u1", "u2", "u3") if name not in data]
    if missing:
        raise SceneError(f"{', '.join(missing)} was not recorded; add it to the channels")
    rest = np.stack([data[axis].values for axis in ("x1", "x2", "x3")], axis=-1)
    moves = [data[name].values for name in ("u1", "u2", "u3")]
    record = farthest_record(result)
    now = rest + np.stack([values[record] for values in moves], axis=-1)
    heights = rest[:, 1] + moves[1].min(axis=0), rest[:, 1] + moves[1].max(axis=0)
    time = float(data.time[record])
    with drawing(STYLE):
        figure = Figure(figsize=(TEXT_WIDTH, 4.4), layout="constrained")
        side, above = figure.subplots(2, 1, sharex=True, height_ratios=(1.3, 1.0))
        first = True
        for own in _conductors(result):
            label = {"rest": "at rest in still air", "now": f"at {time:.4g} s, farthest downwind"}
            names = label if first else dict.fromkeys(label)
            side.fill_between(
                rest[own, 0],
                heights[0][own],
                heights[1][own],
                color=COLOURS["u2"],
                alpha=0.2,
                linewidth=0.0,
                label="heights in the run" if first else None,
            )
            for axes, axis in ((side, 1), (above, 2)):
                axes.plot(rest[own, 0], rest[own, axis], color=NEUTRAL, label=names["rest"])
                axes.plot(now[own, 0], now[own, axis], color=COLOURS["u3"], label=names["now"])
            first = False
        _draw_strings(result, (side, above), rest, now)
        side.set_title("elevation, wind away from the viewer (scales differ)", loc="left")
        above.set_title("plan, wind upwards in the picture (scales differ)", loc="left")
        side.set_ylabel("height $x_2$ [m]")
        above.set_ylabel("downwind $x_3$ [m]")
        above.set_xlabel("along the line $x_1$ [m]")
        _widen(above)
        handles = side.get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


def line_histories(result: LineResult, phase: int = 1) -> Figure:
    """Draw histories: vertical and horizontal at mid-span of each span, and leans of the strings.

    Leans are drawn if they were recorded.

    Parameters
    ----------
    result
        The run.
    phase
        Number of the phase, from 1.

    Raises
    ------
    SceneError
        There is no such phase, or u2, u3 or mid-spans were not recorded.
    """
    time = np.asarray(result.dataset.time.values)
    strings = [tower for tower in _strings(result) if tower.phase == phase]
    ways = [w for w in ("across", "along") if strings and f"string_lean_{w}" in result.dataset]
    rows = result.map.spans + len(ways)
    with drawing(STYLE):
        figure = Figure(figsize=(TEXT_WIDTH, 0.6 + ROW_HEIGHT * rows), layout="constrained")
        panels = list(figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0])
        for span, axes in enumerate(panels[: result.map.spans], start=1):
            bundle = _moves(result, span, phase)
            for name, label in (("u2", "vertical"), ("u3", "horizontal, downwind")):
                values = np.asarray(bundle[name].values)
                axes.plot(*thinned(time, values), color=COLOURS[name], linewidth=0.5, label=label)
            axes.set_ylabel("displacement\n[m]")
            axes.set_title(f"{result.label(span, phase)}, mid-span", loc="left", pad=2.0)
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
        for way, axes in zip(ways, panels[result.map.spans :], strict=True):
            for number, tower in enumerate(strings):
                lean = result.dataset[f"string_lean_{way}"].values[:, tower.tower, phase - 1]
                axes.plot(
                    *thinned(time, np.degrees(lean)),
                    STRING_STYLES[number // len(STRING_COLOURS) % len(STRING_STYLES)],
                    color=STRING_COLOURS[number % len(STRING_COLOURS)],
                    linewidth=0.6,
                    label=f"tower {tower.tower}",
                )
            axes.set_ylabel("lean [deg]")
            axes.set_title(f"strings, lean {way} the line", loc="left", pad=2.0)
        if ways:
            handles = panels[-1].get_legend_handles_labels()
            figure.legend(*handles, loc="outside lower center", ncols=4, frameon=False)
        for axes in panels:
            axes.margins(x=0.0)
        figure.align_ylabels(panels)
        panels[-1].set_xlabel("time [s]")
    return figure


def line_overview(result: LineResult) -> Figure:
    """Draw one page on a run: the histories of phase 1, with title, motion and warnings.

    Raises
    ------
    SceneError
        u2, u3 or mid-spans were not recorded.
    """
    figure = line_histories(result)
    phases = result.map.phases
    which = f" (phase 1 of {phases})" if phases > 1 else ""
    with drawing(STYLE):
        add_title(figure, textwrap.fill(result.scene.title + which, 110))
        notes = [f"Motion: {result.motion}."]
        add_notes(figure, [*notes, *(f"Warning: {sentence}" for sentence in result.warnings)])
    return figure


def line_paths(
    result: LineResult, phase: int = 1, window: tuple[float, float] | None = None
) -> Figure:
    """Draw the path of mid-span across the line, a panel for each span.

    Parameters
    ----------
    result
        The run.
    phase
        Number of the phase, from 1.
    window
        Start and end [s] of the path; by default the last 20 s of the run.

    Raises
    ------
    SceneError
        There is no such phase, or u2, u3 or mid-spans were not recorded.
    """
    end = float(result.dataset.time[-1])
    start, stop = window or (max(0.0, end - CLOSE_TIME), end)
    columns = min(result.map.spans, PATHS_IN_ROW)
    rows = math.ceil(result.map.spans / columns)
    with drawing(STYLE):
        figure = Figure(figsize=(TEXT_WIDTH, 0.4 + 2.4 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for axes in panels.ravel()[result.map.spans :]:
            axes.set_axis_off()
        drawn: list[xr.Dataset] = []
        for span, axes in enumerate(panels.ravel()[: result.map.spans], start=1):
            part = _moves(result, span, phase).sel(time=slice(start - 1e-9, stop + 1e-9))
            axes.plot(part.u3.values, part.u2.values, color=COLOURS["u2"], linewidth=0.6)
            axes.set_title(result.label(span, phase))
            drawn.append(part)
            axes.set_aspect("equal", adjustable="box")
            axes.locator_params(axis="x", nbins=2)
            axes.locator_params(axis="y", nbins=5)
        panels[0, 0].set_xlim(*_path_range(drawn))
        figure.supxlabel("horizontal displacement, downwind $u_3$ [m]", fontsize=8.0)
        figure.supylabel("vertical displacement $u_2$ [m]", fontsize=8.0)
    return figure


def farthest_record(result: LineResult) -> int:
    """Record at the end of the run at which the mean horizontal displacement is largest."""
    data = result.dataset
    sizes = np.nanmean(np.abs(data["u3"].values), axis=1)
    late = data.time.values >= result.window()[0] - 1e-9 if len(data.time) > 1 else np.array([True])
    return int(np.argmax(np.where(late, sizes, -1.0)))


def _path_range(drawn: list[xr.Dataset]) -> tuple[float, float]:
    """Range [m] of the horizontal axis of paths, wide enough for the numbers at it."""
    sides = [float(getattr(part.u3, end)()) for part in drawn for end in ("min", "max")]
    high = max(float(np.ptp(part.u2.values)) for part in drawn)
    middle = 0.5 * (min(sides) + max(sides))
    half = max(0.55 * (max(sides) - min(sides)), MIN_PATH_WIDTH * 0.5 * high)
    return middle - half, middle + half


def _moves(result: LineResult, span: int, phase: int) -> xr.Dataset:
    """Histories of a bundle's centre at mid-span."""
    bundle = result.bundle(span, phase)
    missing = [name for name in ("u2", "u3") if name not in bundle]
    if missing:
        raise SceneError(f"{', '.join(missing)} was not recorded; add it to the channels")
    return bundle


def _conductors(result: LineResult) -> Iterator[NDArray[np.intp]]:
    """Columns of the recorded nodes of each subconductor in each span."""
    data = result.dataset
    for chain in result.map.chains:
        own = (data.node >= chain.nodes.start) & (data.node < chain.nodes.stop)
        columns = np.flatnonzero(own.values)
        if len(columns):
            yield columns


def _strings(result: LineResult) -> list[MappedTower]:
    """Suspensions with a string or V-string."""
    return [tower for tower in result.map.towers if tower.has_string and 0 < tower.tower]


def tower_points(result: LineResult, tower: MappedTower) -> list[Array]:
    """Points [m] of a tower from which a string or the bars of a V-string hang."""
    scene, section = result.scene, result.scene.section
    if not 0 < tower.tower < result.map.spans:
        return []
    held = section.suspensions[tower.tower - 1]
    across = getattr(held, "half_spread", 0.0)
    drop = math.sqrt(getattr(held, "length", 0.0) ** 2 - across**2)
    if tower.has_yoke:
        drop += scene.bundle.yoke_height
    before = section.spans[: tower.tower]
    x1 = sum(span.length for span in before)
    up, side = scene.phases[tower.phase - 1].offset
    x2 = sum(span.height_difference for span in before) + up + drop
    return [np.array([x1, x2, side + way]) for way in ((-across, across) if across else (0.0,))]


def _draw_strings(result: LineResult, panels: tuple[Axes, Axes], rest: Array, now: Array) -> None:
    """Draw strings at rest and displaced, in elevation and plan, and the tower points."""
    recorded = result.dataset.node.values.tolist()
    for tower in result.map.towers:
        clamps = [int(result.map.node_of_junction[j]) for j in tower.junctions]
        if not set(clamps) <= set(recorded):
            continue
        columns = [recorded.index(clamp) for clamp in clamps]
        points = tower_points(result, tower) if tower.has_string else []
        for place, colour in ((rest, NEUTRAL), (now, COLOURS["u3"])):
            clamp = place[columns].mean(axis=0)
            for point in points:
                for axes, axis in zip(panels, (1, 2), strict=True):
                    axes.plot(
                        (point[0], clamp[0]),
                        (point[axis], clamp[axis]),
                        color=colour,
                        linewidth=STRING_WIDTH,
                    )
        for point in points or [rest[columns].mean(axis=0)]:
            for axes, axis in zip(panels, (1, 2), strict=True):
                axes.plot(point[0], point[axis], "s", color=NEUTRAL, markersize=3.0)
        x1, high = (points or [rest[columns].mean(axis=0)])[0][:2]
        if tower.phase == 1:
            panels[0].annotate(
                f"{tower.tower}",
                (x1, high),
                xytext=(0, 4),
                textcoords="offset points",
                ha="center",
                fontsize=7.0,
            )


def _widen(axes: Axes) -> None:
    """Give an axis along which nothing moves a range."""
    low, high = axes.get_ylim()
    if high - low < 2.0 * MIN_HALF_RANGE:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - MIN_HALF_RANGE, middle + MIN_HALF_RANGE)
