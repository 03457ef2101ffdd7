"""Figures of a study of a line: motion over wind, map of conditions, orbits, forces over time.

Every function returns a `matplotlib.figure.Figure` and leaves pyplot's global state alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gallop_fmu.plots import COLOURS, NEUTRAL, STYLE, drawing, thinned
from gallop_fmu.simulation.clearance import Ellipse
from modal.plots.span_figures import WIDTH

Array = NDArray[np.float64]

SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
"""Colours of Okabe and Ito."""

MARKERS = "osD^v"
DARK, LIGHT = "#010101", "#fefefe"
"""Colours of letters in coloured cells; they stay the same on a dark page."""

LEVELS = (("--", "dashed"), (":", "dotted"), ("-.", "dash-dotted"))
"""Style of a line at a level, and its name."""

FAR_LEVEL = 1.5
"""Level over the largest force above which it is named in the title and not drawn."""

MIN_FORCE_RANGE = 0.1
"""Least range [kN] of an axis of forces."""

LABEL_SHARE = 0.16
"""Width of the text at a bar over that of the axis."""

MAP_COLOURS = "cividis"
"""Colour map made for all kinds of colour vision."""

MIN_MOTION = 0.1
"""Least range [m] of an axis and of the colours of motions."""

MIN_MAP_HEIGHT = 1.9
"""Least height of a map [inch], so that the text beside the bar of colours fits."""


@dataclass(frozen=True)
class WindSeries:
    """Motion over wind of one ice: the range over attack angles and curves.

    Attributes
    ----------
    name : str
        Ice in words.
    wind : ndarray, shape (wind,)
        Wind speeds [m/s].
    low, high : ndarray, shape (wind,)
        Smallest and largest motion [m]; NaN where no case has a result.
    """

    name: str
    wind: Array
    low: Array
    high: Array


def wind_figure(series: Sequence[WindSeries], points: Mapping[str, tuple[Array, Array]]) -> Figure:
    """Draw the motion over the wind speed: largest values as lines, ranges shaded.

    Parameters
    ----------
    series
        One for each ice.
    points
        Name of a kind of case to the wind speeds [m/s] and motions [m] of these cases; drawn as
        marks.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
        axes = figure.subplots()
        for k, each in enumerate(series):
            colour = SERIES[k % len(SERIES)]
            axes.fill_between(
                each.wind, each.low, each.high, color=colour, alpha=0.15, linewidth=0.0
            )
            axes.plot(
                each.wind,
                each.high,
                MARKERS[k % len(MARKERS)] + "-",
                color=colour,
                markersize=4.0,
                label=f"{each.name}, largest",
            )
        for (name, (wind, size)), mark in zip(points.items(), ("x", "+", "*", "1"), strict=False):
            axes.plot(wind, size, mark, color=NEUTRAL, markersize=4.5, label=name)
        axes.set_xlabel("wind speed [m/s]")
        axes.set_ylabel("vertical motion, peak to peak [m]")
        axes.set_ylim(0.0, max(MIN_MOTION, axes.get_ylim()[1]))
        axes.legend(frameon=False, loc="best")
    return figure


def condition_map(
    winds: Sequence[float],
    rows: Sequence[str],
    values: Array,
    texts: Sequence[Sequence[str]],
    label: str = "vertical motion,\npeak to peak [m]",
    highest: float | None = None,
) -> Figure:
    """Draw a map of a quantity, such as the motion, over wind and the other conditions.

    Parameters
    ----------
    winds
        Wind speeds [m/s], the columns.
    rows
        Ice, attack angle and curve in words.
    values : ndarray, shape (row, wind)
        The quantity; NaN without a result.
    texts
        Text in each cell.
    label
        Name and unit of the quantity.
    highest
        Value of the brightest colour (default: the largest one).
    """
    with drawing(STYLE):
        height = max(MIN_MAP_HEIGHT, 1.3 + 0.23 * len(rows))
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        axes = figure.subplots()
        most = highest or max([MIN_MOTION, *values[np.isfinite(values)].tolist()])
        mesh = axes.pcolormesh(
            np.arange(len(winds) + 1),
            np.arange(len(rows) + 1),
            np.ma.masked_invalid(values),
            cmap=MAP_COLOURS,
            vmin=0.0,
            vmax=most,
            edgecolors="face",
            linewidth=0.3,
        )
        for row, column in np.ndindex(*values.shape):
            size = values[row, column]
            known = np.isfinite(size)
            axes.text(
                column + 0.5,
                row + 0.5,
                texts[row][column],
                ha="center",
                va="center",
                fontsize=7.0,
                color=(DARK if size > 0.55 * most else LIGHT) if known else NEUTRAL,
            )
        axes.set_xticks(np.arange(len(winds)) + 0.5, [f"{wind:g}" for wind in winds])
        axes.set_yticks(np.arange(len(rows)) + 0.5, list(rows))
        axes.invert_yaxis()
        axes.tick_params(length=0.0)
        for side in ("left", "bottom"):
            axes.spines[side].set_visible(False)
        axes.set_xlabel("wind speed [m/s]")
        bar = figure.colorbar(mesh, ax=axes, pad=0.01, fraction=0.04)
        bar.outline.set_visible(False)
        bar.set_label(label)
    return figure


@dataclass(frozen=True)
class Area:
    """An area across the line by its support function.

    Attributes
    ----------
    normal : ndarray, shape (direction, 2)
        Directions x2, x3, in equal steps around.
    reach : ndarray, shape (direction,)
        Farthest distance [m] in each direction.
    """

    normal: Array
    reach: Array

    def outline(self, beyond: float = 0.0) -> tuple[Array, Array]:
        """Return points x3, x2 of the edge, `beyond` metres outside of it.

        The point of the edge in direction n is h n + h' t, with h' the derivative of the support
        function h by the angle and t the unit vector at a right angle to n.
        """
        h = self.reach + beyond
        step = 2.0 * np.pi / len(h)
        slope = (np.roll(h, -1) - np.roll(h, 1)) / (2.0 * step)
        x2, x3 = self.normal.T
        up, across = h * x2 + slope * x3, h * x3 - slope * x2
        return np.append(across, across[0]), np.append(up, up[0])


def orbit_figure(
    path: tuple[Array, Array],
    area: Area,
    offsets: Mapping[str, tuple[float, float]],
    ellipses: Mapping[str, Ellipse],
    clearance: float | None,
) -> Figure:
    """Draw the path of mid-span across the line, the areas of all phases, and design ellipses.

    Parameters
    ----------
    path
        Horizontal and vertical displacement [m] of mid-span over time, downwind and upwards.
    area
        The area that the motion covers.
    offsets
        Name of each phase to its place x2, x3 [m]; the path is that of the first.
    ellipses
        Name of a design rule to its ellipse about the place at rest.
    clearance
        Distance [m] that other phases must keep, drawn around the first area; None: none.
    """
    first = next(iter(offsets.values()))
    edges = [area.outline()[0], *(ellipse.outline()[0] for ellipse in ellipses.values())]
    right = max(float(edge.max()) for edge in edges)
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 5.2), layout="constrained")
        axes = figure.subplots()
        for k, (name, offset) in enumerate(offsets.items()):
            across, up = area.outline()
            place = offset[1] - first[1], offset[0] - first[0]
            x3, x2 = across + place[0], up + place[1]
            axes.fill(x3, x2, color=COLOURS["u2"], alpha=0.2, linewidth=0.0)
            label = "area that the motion covers" if k == 0 else None
            axes.plot(x3, x2, color=COLOURS["u2"], linewidth=0.7, label=label)
            axes.plot(*place, "o", color=NEUTRAL, markersize=3.0)
            if len(offsets) > 1:
                axes.annotate(
                    f"phase {name}",
                    (place[0] + right, place[1]),
                    xytext=(12, 0),
                    textcoords="offset points",
                    va="center",
                )
            for (rule, ellipse), style in zip(ellipses.items(), ("-", "--"), strict=False):
                x, y = ellipse.outline()
                label = f"ellipse of {rule}" if k == 0 else None
                line: dict[str, Any] = {"color": COLOURS["u3"], "linewidth": 0.7, "label": label}
                axes.plot(x + place[0], y + place[1], style, **line)
        axes.plot(*path, color=NEUTRAL, linewidth=0.4, label="path of mid-span")
        axes.plot([], [], "o", color=NEUTRAL, markersize=3.0, label="conductor at rest")
        if clearance is not None:
            axes.plot(
                *area.outline(clearance),
                ":",
                color=COLOURS["tension"],
                linewidth=1.0,
                label=f"required distance, {clearance:g} m",
            )
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("downwind [m]")
        axes.set_ylabel("upwards [m]")
        figure.legend(loc="outside lower center", frameon=False, ncols=2)
    return figure


@dataclass(frozen=True)
class ForceHistory:
    """A force over time, with the values to compare it with.

    Attributes
    ----------
    name : str
        What it is, with the place.
    values : ndarray, shape (time,)
        The force [kN].
    levels : dict of str to float
        Name of a value to compare with, such as that at rest, to it [kN].
    """

    name: str
    values: Array
    levels: Mapping[str, float]


def force_figure(time: Array, forces: Sequence[ForceHistory]) -> Figure:
    """Draw forces over time [s], one above the other, with values at rest and design values."""
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + 1.35 * len(forces)), layout="constrained")
        panels = figure.subplots(len(forces), 1, sharex=True, squeeze=False)[:, 0]
        for axes, force in zip(panels, forces, strict=True):
            axes.plot(*thinned(time, force.values), color=COLOURS["u2"], linewidth=0.5)
            lowest, highest = float(force.values.min()), float(force.values.max())
            named = []
            for (name, level), (style, word) in zip(force.levels.items(), LEVELS, strict=False):
                if level > FAR_LEVEL * highest:  # the axis would hide the motion
                    named.append(f"{name} {level:z.1f} kN")
                    continue
                named.append(f"{name} {level:z.1f} kN ({word})")
                axes.axhline(level, color=COLOURS["u3"], linestyle=style, linewidth=0.8)
                lowest, highest = min(lowest, level), max(highest, level)
            half = max(0.5 * (highest - lowest), 0.5 * MIN_FORCE_RANGE)
            middle = 0.5 * (highest + lowest)
            axes.set_ylim(middle - 1.15 * half, middle + 1.15 * half)
            axes.set_title("; ".join([force.name, *named]), loc="left", pad=2.0)
            axes.set_ylabel("force [kN]")
            axes.margins(x=0.0)
        figure.align_ylabels(panels)
        panels[-1].set_xlabel("time [s]")
    return figure


def measure_figure(names: Sequence[str], before: float, after: Array, letters: int = 80) -> Figure:
    """Draw the largest motion with each measure as bars, and that without as a line.

    Parameters
    ----------
    names
        The measures.
    before
        Largest motion without them [m].
    after : ndarray, shape (measure,)
        Largest motion with each [m]; NaN without a result.
    letters
        Longest line of a name; longer names are wrapped.
    """
    wrapped = [fill(name, letters) for name in names]
    lines = sum(max(2, name.count("\n") + 1) for name in wrapped)
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 0.8 + 0.15 * lines), layout="constrained")
        axes: Any = figure.subplots()
        places = np.arange(len(names))
        shown = np.nan_to_num(after)
        limit = 1.5 * max(before, float(shown.max(initial=0.0)))
        axes.barh(places, shown, color=COLOURS["u2"], height=0.6)
        for place, size in zip(places, after, strict=True):
            text = (
                f"{size:.1f} m ({size / before - 1.0:+.0%})" if np.isfinite(size) else "no result"
            )
            crosses = size < before < size + LABEL_SHARE * limit
            axes.annotate(
                text,
                (before if crosses else np.nan_to_num(size), place),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.0,
            )
        axes.axvline(before, color=COLOURS["u3"], linestyle="--", linewidth=0.9)
        axes.annotate(
            f"as it is, {before:.1f} m",
            (before, -0.75),
            xytext=(-3, 0),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize=7.0,
        )
        axes.set_ylim(len(names) - 0.4, -1.1)
        axes.set_xlim(0.0, limit)
        axes.set_yticks(places, wrapped)
        axes.set_xlabel("largest vertical motion,\npeak to peak [m]")
    return figure
