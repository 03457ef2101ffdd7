"""Figures of a run: histories, the path of the mid-span point, and both on one page.

Functions return a `matplotlib.figure.Figure` and do not use pyplot's global state, so they work
without a display, in threads and in notebooks.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from gallop_fmu.foundation.atomic_write import write_whole
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.simulation.result import Result, slowest_frequency

if TYPE_CHECKING:
    import xarray as xr

    from gallop_fmu.scene.aerodynamic_curve import AerodynamicCurve

Array = NDArray[np.float64]
Windows = Mapping[str, tuple[float, float]]
"""Name of a part of a run to its start and end [s]."""

COLOURS = {"u2": "#0072B2", "u3": "#D55E00", "theta": "#009E73", "tension": "#CC79A7"}
"""Palette of Okabe and Ito, for all kinds of colour vision."""

WINDOW_COLOURS = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7")
NEUTRAL = "#404040"
TEXT_WIDTH = 7.1
"""Width of a figure over both columns of a journal page [inch]."""

SUFFIXES = (".png", ".svg", ".pdf")
PIXEL_COLUMNS = 1500
MAX_EQUAL_SCALE_RATIO = 6.0
"""Maximum ratio of the sides of a path that is drawn with equal scales."""

LEGEND_SHARE = 0.25
"""Share of the range of coefficients that is added below for the legend."""

DIED_OUT = 0.01
"""Share of a run's range below which the motion of its last periods has died out."""

AXIS_LABELS = {
    "u2": ("vertical displacement", "$u_2$"),
    "u3": ("horizontal displacement", "$u_3$"),
    "theta": ("twist", r"$\theta$"),
    "tension": ("tension", "$T$"),
}
STYLE: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "lines.linewidth": 0.8,
    "path.simplify": True,
}


def drawing(style: Mapping[str, Any]) -> AbstractContextManager[None]:
    """Return a context with matplotlib's defaults and `style`.

    It excludes a user's ``matplotlibrc``, which may require LaTeX or fonts that are not installed.
    """
    return matplotlib.style.context(["default", dict(style)])


def histories(source: Result | xr.Dataset, channels: Sequence[str] = ("u2", "u3")) -> Figure:
    """Draw mid-span histories, one above the other.

    Parameters
    ----------
    source
        A result, or a dataset with the channels over ``time`` [s] at mid-span.
    channels
        Channels to draw.

    Raises
    ------
    SceneError
        A channel or the mid-span node was not recorded.
    """
    data = _midspan(source, channels)
    with drawing(STYLE):
        figure = _page(1.0 + 1.25 * len(channels))
        axes = figure.subplots(len(channels), 1, sharex=True, squeeze=False)[:, 0]
        _draw_histories(list(axes), data, channels)
    return figure


def trace(source: Result | xr.Dataset, windows: Windows | None = None) -> Figure:
    """Draw the path of the mid-span point, seen along the span: a panel for each part of the run.

    Parameters
    ----------
    source
        A result, or a dataset with u2 and u3 [m] over ``time`` [s] at mid-span.
    windows
        Parts of the run (default: the last periods, or the whole run if the motion has died out).

    Raises
    ------
    SceneError
        u2 or u3 was not recorded, or a window has no record.
    """
    data = _midspan(source, ("u2", "u3"))
    windows = windows or enlarged_part(data)
    with drawing(STYLE):
        figure = _page(2.9)
        panels = figure.subplots(1, len(windows), sharex=True, sharey=True, squeeze=False)[0]
        _draw_traces(list(panels), data, windows)
    return figure


def story(source: Result | xr.Dataset, windows: Windows, title: str = "") -> Figure:
    """Draw u2 and u3 with marked windows, and the mid-span path in each window.

    Parameters
    ----------
    source
        A result, or a dataset with u2 and u3 [m] over ``time`` [s] at mid-span.
    windows
        Parts of the run, such as before, during and after a transfer of energy.
    title
        Title of the figure, one line.
    """
    data = _midspan(source, ("u2", "u3"))
    with drawing(STYLE):
        figure = _page(6.0)
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.15, 1.0))[:, 0]
        upper = list(top.subplots(2, 1, sharex=True))
        _draw_histories(upper, data, ("u2", "u3"))
        for (start, stop), colour in zip(windows.values(), _cycle(len(windows)), strict=True):
            for axes in upper:
                axes.axvspan(start, stop, color=colour, alpha=0.25, linewidth=0.0, zorder=0)
        panels = list(bottom.subplots(1, len(windows), sharex=True, sharey=True, squeeze=False)[0])
        _draw_traces(panels, data, windows, times=False)  # the bands above show them
        if title:
            add_title(top, title)
    return figure


def overview(result: Result) -> Figure:
    """Draw one page on a run: four mid-span histories, the last periods, and the mid-span path.

    Raises
    ------
    SceneError
        u2, u3, theta, tension or the mid-span node was not recorded.
    """
    channels = ("u2", "u3", "theta", "tension")
    data = _midspan(result, channels)
    part = enlarged_part(data)
    with drawing(STYLE):
        figure = _page(5.6)
        left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=(1.45, 1.0))[0]
        column = list(left.subplots(4, 1, sharex=True))
        _draw_histories(column, data, channels)
        path, close = right.subplots(2, 1, height_ratios=(1.35, 1.0))
        _draw_traces([path], data, part)
        _draw_close(close, data, next(iter(part.values())))
        left.align_ylabels(column)
        add_title(figure, textwrap.fill(result.scene.title, 110))
        add_notes(
            figure,
            [
                f"Motion: {result.motion}.",
                *(f"Warning: {sentence}" for sentence in result.warnings),
            ],
        )
    return figure


def over_values(grid: xr.Dataset, column: str) -> Figure:
    """Draw a result of a sweep over the varied number: a curve for each span or tower.

    Parameters
    ----------
    grid
        From `gallop_fmu.Runs.grid`; of several varied values select one of all but one, such as
        ``runs.grid().sel({"ice.attack_angle_deg": 180.0})``.
    column
        Column of numbers, such as ``"u2_amplitude"``, of a line ``"span_u2_amplitude"``.

    Raises
    ------
    SceneError
        There is no such column of numbers, or not one varied number.
    """
    (key,) = varied = _varied_number(grid, column)
    data = grid[column]
    places = [name for name in data.dims if name not in varied]
    curves = data.stack(place=places) if places else data.expand_dims("place")
    with drawing(STYLE):
        figure = _page(3.2)
        axes = figure.subplots()
        for curve in curves.transpose("place", key):
            label = ", ".join(f"{name} {int(curve[name])}" for name in places)
            axes.plot(grid[key].values, curve.values, marker="o", markersize=2.5, label=label)
        axes.set_xlabel(_label(key, grid))
        axes.set_ylabel(_label(column, grid))
        if places:
            axes.legend(frameon=False)
    return figure


def _varied_number(grid: xr.Dataset, column: str) -> list[str]:
    """Return the dimensions of a sweep of a column of numbers; refuse all but one of numbers."""
    numbers = [str(name) for name in grid.variables if grid[name].dtype.kind in "iuf"]
    if column not in numbers:
        known = [name for name in numbers if name in grid.data_vars]
        raise SceneError(f"{column} is no column of numbers; choose one of {', '.join(known)}")
    places = ("span", "tower", "phase")
    varied = [str(name) for name in grid[column].dims if name not in places]
    if len(varied) != 1 or varied[0] not in numbers:
        raise SceneError(
            f"a curve needs one varied number, and this sweep has {', '.join(varied) or 'none'};"
            " select one value of each other one with grid.sel"
        )
    return varied


def add_notes(figure: Figure, notes: Sequence[str]) -> None:
    """Write sentences below a figure, each on its own lines."""
    figure.supxlabel(
        "\n".join(textwrap.fill(note, 140) for note in notes), fontsize=7.0
    ).set_parse_math(False)


def add_title(figure: FigureBase, title: str) -> None:
    """Write a title above a figure; a dollar sign does not start mathematics."""
    figure.suptitle(title, fontsize=9.0).set_parse_math(False)


def save_figure(figure: Figure, path: Path | str) -> Path:
    """Write a figure in the format of the suffix.

    Raises
    ------
    SceneError
        The suffix is not .png, .svg or .pdf.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise SceneError(
            f"{path}: pictures are not written as {path.suffix or 'files without suffix'}; choose"
            f" {', '.join(SUFFIXES)}"
        )
    write_whole(path, _content(figure, path.suffix[1:].lower(), 200))
    return path


def shown_in_notebooks(figure: Figure) -> Figure:
    """Give a figure a picture for notebooks, which pyplot gives to its own figures only."""
    figure._repr_png_ = partial(_content, figure, "png", 100)  # type: ignore[attr-defined]
    return figure


def _content(figure: Figure, suffix: str, dpi: int) -> bytes:
    """Return the file of a figure in a format."""
    with drawing({"svg.fonttype": "none", "pdf.fonttype": 42}):
        content = BytesIO()
        figure.savefig(content, format=suffix, dpi=dpi)
    return content.getvalue()


def enlarged_part(data: xr.Dataset, periods: float = 6.0) -> Windows:
    """Return the window of the last periods, or the whole run if the motion has died out.

    Parameters
    ----------
    data
        Dataset with u2 and u3 over ``time`` [s] at mid-span.
    periods
        Number of periods of the slower of u2 and u3, limited to half of the run.
    """
    time = np.asarray(data.time.values)
    half = len(time) // 2
    values = [np.asarray(data[name].values) for name in ("u2", "u3")]
    slowest = slowest_frequency(data)
    length = periods / slowest if math.isfinite(slowest) else float(time[-1])
    start = max(float(time[half]), float(time[-1]) - length)
    if all(np.ptp(y[time >= start]) < DIED_OUT * np.ptp(y) or np.ptp(y) == 0.0 for y in values):
        return {"whole run": (float(time[0]), float(time[-1]))}
    return {"last periods": (start, float(time[-1]))}


def _midspan(source: Result | xr.Dataset, channels: Sequence[str]) -> xr.Dataset:
    data = source.midspan() if isinstance(source, Result) else source
    missing = [name for name in channels if name not in data]
    if missing:
        raise SceneError(
            f"{', '.join(missing)} was not recorded; add it to the channels of simulate"
        )
    return data


def _page(height: float) -> Figure:
    return Figure(figsize=(TEXT_WIDTH, height), layout="constrained")


def _cycle(count: int) -> list[str]:
    return [WINDOW_COLOURS[k % len(WINDOW_COLOURS)] for k in range(count)]


def _label(name: str, data: xr.Dataset) -> str:
    """Return the symbol, or the name of an unusual channel, and the unit."""
    unit = {"theta": "deg", "tension": "kN"}.get(name, str(data[name].attrs.get("units", "")))
    title = AXIS_LABELS[name][1] if name in AXIS_LABELS else name
    return f"{title} [{unit}]" if unit else title


def _shown(name: str, data: xr.Dataset) -> Array:
    """Return the values in the unit of `_label`."""
    values = np.asarray(data[name].values, dtype=np.float64)
    return (
        np.degrees(values) if name == "theta" else values / 1000.0 if name == "tension" else values
    )


def _draw_histories(rows: list[Axes], data: xr.Dataset, channels: Sequence[str]) -> None:
    time = np.asarray(data.time.values)
    for axes, name in zip(rows, channels, strict=True):
        axes.plot(
            *thinned(time, _shown(name, data)), color=COLOURS.get(name, NEUTRAL), linewidth=0.5
        )
        axes.set_ylabel(_label(name, data))
        axes.set_title(
            f"mid-span {AXIS_LABELS[name][0] if name in AXIS_LABELS else name}", loc="left", pad=2.0
        )
        axes.margins(x=0.0)
    rows[-1].set_xlabel("time [s]")


def _draw_traces(
    panels: list[Axes], data: xr.Dataset, windows: Windows, *, times: bool = True
) -> None:
    """Draw paths across the span, with equal scales unless a path is too thin."""
    ranges = []
    for axes, (name, (start, stop)), colour in zip(
        panels, windows.items(), _cycle(len(windows)), strict=True
    ):
        part = data.sel(time=slice(start - 1e-9, stop + 1e-9))
        if not part.sizes["time"]:
            raise SceneError(
                f"the window {name} from {start:g} s to {stop:g} s has no record; give a longer one"
            )
        ranges.append((float(np.ptp(part.u3.values)), float(np.ptp(part.u2.values))))
        axes.plot(
            part.u3.values,
            part.u2.values,
            color=NEUTRAL if len(windows) == 1 else colour,
            linewidth=0.5,
        )
        digits = 0 if stop - start > 5.0 else 2
        title = f"{name}, {start:.{digits}f} to {stop:.{digits}f} s" if times else name
        axes.set_title(title).set_parse_math(False)
        axes.set_xlabel(_label("u3", data))
        axes.locator_params(nbins=4)
    panels[0].set_ylabel(_label("u2", data))
    wide, high = np.max(ranges, axis=0)
    if max(wide, high) <= MAX_EQUAL_SCALE_RATIO * min(wide, high):
        for axes in panels:
            axes.set_aspect("equal", adjustable="datalim" if len(panels) == 1 else "box")
    else:
        panels[0].set_title(f"{panels[0].get_title()}\n(scales differ)")  # one line is too long


def curve_figure(
    curve: AerodynamicCurve, title: str = "", attack_angle: float | None = None
) -> Figure:
    """Draw a coefficient curve, and where Den Hartog's criterion is negative.

    Parameters
    ----------
    curve
        The curve.
    title
        Title of the figure.
    attack_angle
        Attack angle [rad] that is marked by a vertical line.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(TEXT_WIDTH, 2.6), layout="constrained")
        axes = figure.subplots()
        draw_curve(axes, curve)
        if attack_angle is not None:
            first, last = np.degrees(curve.breakpoint[[0, -1]])
            initial = np.degrees(attack_angle)
            turns = round((initial - 0.5 * (first + last)) / 360.0)
            axes.axvline(initial - 360.0 * turns, color=NEUTRAL, linewidth=0.6)
        axes.set_title(title, loc="left")
    return figure


def draw_curve(axes: Axes, curve: AerodynamicCurve) -> None:
    """Draw lift, drag and moment coefficient, and shade where CD + dCL/dalpha is negative."""
    angle = np.linspace(curve.breakpoint[0], curve.breakpoint[-1], 721)
    degrees = np.degrees(angle)
    lines = (("lift", "u2", "-"), ("drag", "u3", "--"), ("moment", "theta", "-."))
    for name, colour, style in lines:
        axes.plot(degrees, getattr(curve, name)(angle), style, color=COLOURS[colour], label=name)
    axes.fill_between(
        degrees,
        0.0,
        1.0,
        where=list(curve.den_hartog(angle) < 0.0),
        transform=axes.get_xaxis_transform(),
        color=NEUTRAL,
        alpha=0.12,
        linewidth=0.0,
        label="CD + dCL/dα < 0",
    )
    axes.axhline(0.0, color=NEUTRAL, linewidth=0.4)
    axes.set_xlabel("attack angle [deg]")
    axes.set_ylabel("coefficient [1]")
    axes.margins(x=0.0)
    low, high = axes.get_ylim()
    axes.set_ylim(low - LEGEND_SHARE * (high - low), high)
    axes.legend(frameon=False, ncols=2, loc="lower center")


def _draw_close(axes: Axes, data: xr.Dataset, window: tuple[float, float]) -> None:
    """Draw the last periods of u2 and u3 about their means."""
    part = data.sel(time=slice(*window))
    for name in ("u2", "u3"):
        values = part[name].values
        axes.plot(
            part.time.values,
            values - np.mean(values),
            color=COLOURS[name],
            label=AXIS_LABELS[name][1],
        )
    axes.set_xlabel("time [s]")
    axes.set_ylabel("about the mean [m]")
    axes.margins(x=0.0)
    axes.locator_params(nbins=5)
    axes.legend(
        loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, borderaxespad=0.1
    )


def thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Return the minimum and maximum in each column of pixels, for the same picture."""
    size = len(time) // PIXEL_COLUMNS
    if size < 4:
        return time, values
    whole = len(time) // size * size
    starts = np.arange(0, whole, size)
    blocks = values[:whole].reshape(-1, size)
    kept = np.sort(np.concatenate([starts + blocks.argmin(axis=1), starts + blocks.argmax(axis=1)]))
    return time[kept], values[kept]
