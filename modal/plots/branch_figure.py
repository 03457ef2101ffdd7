"""Figure of all motions of a span or line over one number."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from gallop_fmu.plots import add_title, drawing
from modal.plots.span_figures import NEUTRAL, STYLE, WIDTH

if TYPE_CHECKING:
    import xarray as xr

PALETTE = ("#404040", "#0072B2", "#E69F00", "#D55E00", "#009E73", "#CC79A7", "#56B4E9")
"""Colours of the branches: those of Okabe and Ito, distinguishable with any colour vision."""

MARKERS = {
    "Hopf": ("o", "oscillation begins"),
    "fold": ("v", "branch turns back"),
    "period doubling": ("s", "motion of twice the period begins"),
    "symmetry breaking": ("D", "symmetry breaks"),
    "torus": ("^", "beating begins"),
    "leaves the curve": ("X", "attack angle leaves the curve"),
    "lost": ("x", "not found further"),
}
"""Markers of events, and their meaning."""

ROWS = (
    ("u2", "u2_amplitude", "vertical, mid-span"),
    ("u3", "u3_amplitude", "horizontal, mid-span"),
    ("quarter", "quarter_amplitude", "antisymmetric vertical,\nquarter points"),
)
"""Name of a simulated amplitude, that of the branches, and the title of the axis."""


CLAMPS = ("clamp", "clamp_amplitude", "clamps of strings,\nacross the line")
"""The same of a line with strings."""


LEGEND_LETTERS = 44
"""Letters of a line of the legend; two columns of them fit the figure."""

LEGEND_LINE = 0.13
"""Height of a line of the legend [inch]."""


def branch_figure(data: xr.Dataset, legend_columns: int = 2) -> Figure:
    """Draw the amplitudes of all branches: stable parts solid, unstable parts dashed.

    Parameters
    ----------
    data
        Dataset of `modal.branches`.
    legend_columns
        Number of columns of the legend.
    """
    rows = (*ROWS, CLAMPS) if data.sizes.get("tower") else ROWS
    handles = _handles(data)
    lines = sum(str(handle.get_label()).count("\n") + 1 for handle in handles)
    height = 2.0 * len(rows) + LEGEND_LINE * lines / legend_columns
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        add_title(figure, data.attrs["title"])
        panels = figure.subplots(len(rows), 1, sharex=True)
        for axes, (run_name, column, label) in zip(panels, rows, strict=True):
            for number in data.branch.values.tolist():
                _draw_branch(axes, data, number, column)
            if "run" in data.sizes:
                _draw_runs(axes, data, run_name)
            axes.set_ylabel(f"{label} [m]")
            axes.set_ylim(bottom=0.0)
            axes.margins(x=0.0)
        name = str(data.attrs["over"]).replace("wind.speed", "wind speed")
        panels[-1].set_xlabel(f"{name} [{data.attrs['units']}]")
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=legend_columns,
            frameon=False,
            fontsize=7.5,
        )
        return figure


def _colour(number: int) -> str:
    return PALETTE[number % len(PALETTE)]


def _draw_branch(axes: Axes, data: xr.Dataset, number: int, column: str) -> None:
    """Draw a branch in stable and unstable parts, and mark its events."""
    at = data.isel(point=np.flatnonzero(data.branch_of_point.values == number))
    value, amplitude = at.value.values, at[column].values
    colour = _colour(number)
    for part, stable in _parts(at.is_stable.values, at.event.values != ""):
        axes.plot(
            value[part],
            amplitude[part],
            color=colour,
            linestyle="-" if stable else "--",
            linewidth=1.6 if stable else 0.9,
        )
    for kind, (marker, _) in MARKERS.items():
        chosen = at.event.values == kind
        if not np.any(chosen):
            continue
        axes.plot(
            value[chosen],
            amplitude[chosen],
            marker,
            color=colour,
            markersize=4.5,
            markerfacecolor="white",
            clip_on=False,
            zorder=3,
        )


def _parts(stable: NDArray[np.bool_], is_event: NDArray[np.bool_]) -> Iterator[tuple[slice, bool]]:
    """Runs of points with the same stability; neighbours share the event between them."""
    stable = np.asarray(stable, dtype=bool)
    changes = [
        int(k) if is_event[k] else int(k) - 1 for k in np.flatnonzero(stable[1:] != stable[:-1]) + 1
    ]
    bounds = [0, *changes, len(stable) - 1]
    for first, last in pairwise(bounds):
        if last > first:
            inside = stable[first + 1] if last > first + 1 else stable[first : last + 1].any()
            yield slice(first, last + 1), bool(inside)


def _draw_runs(axes: Axes, data: xr.Dataset, name: str) -> None:
    """Draw simulated amplitudes: a point, or a bar from the lowest to the highest of a beat."""
    low, high = data[f"run_{name}_low"].values, data[f"run_{name}_high"].values
    axes.vlines(data.run_value.values, low, high, color="black", linewidth=2.0, zorder=4)
    axes.plot(
        data.run_value.values, 0.5 * (low + high), "_", color="black", markersize=5.0, zorder=4
    )


def _handles(data: xr.Dataset) -> list[Line2D]:
    """Entries of the legend: branches, kinds of lines, events, simulations."""
    handles = [
        Line2D(
            [],
            [],
            color=_colour(number),
            linewidth=1.6,
            label=fill(f"{number}: {name}", LEGEND_LETTERS),
        )
        for number, name in zip(data.branch.values.tolist(), data["name"].values, strict=True)
    ]
    handles.append(Line2D([], [], color=NEUTRAL, linestyle="--", linewidth=0.9, label="unstable"))
    present = set(data.event.values.tolist())
    handles += [
        Line2D(
            [],
            [],
            color=NEUTRAL,
            marker=marker,
            linestyle="",
            markersize=4.5,
            markerfacecolor="white",
            label=meaning,
        )
        for kind, (marker, meaning) in MARKERS.items()
        if kind in present
    ]
    if "run" in data.sizes:
        handles.append(
            Line2D([], [], color="black", linewidth=2.0, label="simulation from a motion")
        )
    return handles
