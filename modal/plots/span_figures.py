"""Figures of modes, mode tracking, ratio map, stability criteria, root locus, screening.

Every function returns a `matplotlib.figure.Figure` and leaves pyplot's global state alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from gallop_fmu.plots import add_title, drawing
from modal.linear.modes import Mode
from modal.screening.verdict import RISK_OF
from modal.stability.criteria import Criterion

if TYPE_CHECKING:
    import xarray as xr

    from modal.screening.screen import Screening

Array = NDArray[np.float64]

COLOURS = {
    "vertical": "#0072B2",
    "horizontal": "#D55E00",
    "torsional": "#009E73",
    "longitudinal": "#CC79A7",
    "tension-neutral": "#56B4E9",
    "bundle torsion": "#E69F00",
    "sub-span": "#000000",
}
"""Colours of Okabe and Ito, distinguishable with any colour vision."""

UNSTABLE, NEUTRAL = "#E69F00", "#404040"
MARKED = "#D00000"
"""Colour of lines on a colour map."""

MIN_LEGEND_SHARE = 0.15
"""Share of the kinetic energy above which a family is in the legend."""

WIDTH = 7.1
"""Width of a figure over both columns of a journal page [inch]."""

SHADED_DETUNING = 0.1
"""Largest detuning from 2:1 that is shaded."""

MIN_LABEL_DISTANCE = 0.03
"""Smallest distance between labels of modes, relative to the range of frequencies."""

GEOMETRIC_TOLERANCE = 1e-3
"""Relative deviation of factors that count as equal."""

Style = Literal["-", "--", ":", "-."]

STYLE: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "lines.linewidth": 1.0,
}


def mode_shapes(modes: Sequence[Mode], title: str = "") -> Figure:
    """Draw mode shapes along the span, one panel for each, in the direction of the family.

    Parameters
    ----------
    modes
        From `modal.natural_modes`.
    title
        One line above the figure.
    """
    with drawing(STYLE):
        rows = -(-len(modes) // 3)
        figure = Figure(figsize=(WIDTH, 0.5 + 1.15 * rows), layout="constrained")
        panels = figure.subplots(rows, 3, sharex=True, squeeze=False)
        for axes, mode in zip(panels.flat, modes, strict=False):
            wave = mode.wave
            axes.axhline(0.0, color=NEUTRAL, linewidth=0.4)
            axes.plot(
                np.linspace(0.0, 1.0, len(wave)),
                wave / np.abs(wave).max(),
                color=COLOURS[mode.family],
            )
            axes.set_title(
                f"{mode.family} {mode.loops}: {mode.frequency_hz:.4g} Hz, {mode.damping_ratio:.2%}"
            )
            axes.set_yticks([])
            axes.margins(x=0.0)
        for axes in panels.flat[len(modes) :]:
            axes.set_axis_off()
        figure.supxlabel("position along the span / span [1]", fontsize=8.0)
        add_title(figure, title)
    return figure


def tracking_figure(data: xr.Dataset) -> Figure:
    """Draw the frequencies of tracked modes over the varied number.

    The colour of a line mixes the colours of the families by their share of the kinetic energy. The
    numbers at both ends identify the modes: two modes that cross change places and keep their
    colours; two that veer keep their places and exchange their colours.

    Parameters
    ----------
    data
        From `modal.track_modes`.
    """
    path = data.frequency_hz.dims[1]
    values, frequency = data[path].values, data.frequency_hz.values
    palette = np.array([to_rgb(COLOURS[family]) for family in data.family.values.tolist()])
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 5.0), layout="constrained")
        axes = figure.subplots()
        for mode, (wave, share) in enumerate(zip(frequency, data.share.values, strict=True)):
            points = np.stack([values, wave], axis=1)
            mixed = 0.5 * (share[1:] + share[:-1]) @ palette
            pieces = np.stack([points[:-1], points[1:]], axis=1)
            under = mode % 2 == 0  # of two coincident neighbours one is broad below, one thin above
            lines = LineCollection(
                list(pieces),
                colors=np.clip(mixed, 0.0, 1.0),
                linewidths=3.4 if under else 1.2,
                zorder=2 if under else 3,
            )
            axes.add_collection(lines)
        axes.autoscale()
        span = values[-1] - values[0]
        axes.set_xlim(values[0] - 0.04 * span, values[-1] + 0.04 * span)
        low, high = frequency.min(), frequency.max()
        axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
        for column, side in ((0, -1), (-1, 1)):
            order = np.argsort(frequency[:, column], kind="stable")
            heights = _spread(frequency[order, column], MIN_LABEL_DISTANCE * (high - low))
            for mode, height in zip(order, heights, strict=True):
                place = values[column] + side * 0.012 * span, height
                axes.text(
                    *place,
                    str(mode + 1),
                    ha="left" if side > 0 else "right",
                    va="center",
                    fontsize=7.0,
                )
        seen = [
            k for k in range(len(palette)) if data.share.values[:, :, k].max() > MIN_LEGEND_SHARE
        ]
        families = data.family.values.tolist()
        handles = [
            Line2D([], [], color=COLOURS[families[k]], linewidth=1.6, label=families[k])
            for k in seen
        ]
        figure.legend(
            handles=handles, frameon=False, loc="outside upper center", ncols=len(handles)
        )
        axes.set_ylabel("frequency [Hz]")
        axes.set_xlabel(f"{path} [{data[path].attrs['units']}]")
    return figure


def _spread(wanted: Array, least: float) -> Array:
    """Shift ascending positions as little as possible to have at least a given distance."""
    lifted = wanted - least * np.arange(len(wanted))
    upper = np.maximum.accumulate(lifted)
    lower = np.minimum.accumulate(lifted[::-1])[::-1]
    return np.asarray(0.5 * (upper + lower) + least * np.arange(len(wanted)))


def ratio_figure(data: xr.Dataset) -> Figure:
    """Draw frequencies and ratio over one number with the range near 2:1 shaded, or a map over two.

    Parameters
    ----------
    data
        From `modal.ratio_map`.
    """
    if data.ratio.ndim == 2:
        return _ratio_contours(data)
    (path,) = data.ratio.dims
    values, unit = data[path].values, data[path].attrs["units"]
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        for family in ("vertical", "horizontal"):
            above.plot(
                values,
                data[f"{family}_hz"].values,
                color=COLOURS[family],
                label=f"first symmetric {family}",
            )
        above.plot(
            values,
            2.0 * data.horizontal_hz.values,
            "--",
            color=COLOURS["horizontal"],
            label="twice the horizontal",
        )
        above.set_ylabel("frequency [Hz]")
        above.legend(frameon=False)
        below.axhspan(
            2.0 - 2.0 * SHADED_DETUNING,
            2.0 + 2.0 * SHADED_DETUNING,
            color=UNSTABLE,
            alpha=0.3,
            linewidth=0.0,
        )
        below.axhline(2.0, color=NEUTRAL, linewidth=0.6)
        below.plot(values, data.ratio.values, color=NEUTRAL, marker=".", markersize=3.0)
        below.set_ylabel("frequency ratio [1]")
        below.set_title(f"shaded: within {SHADED_DETUNING:.0%} of 2:1", loc="left")
        below.set_xlabel(f"{path} [{unit}]")
        below.set_xlim(values.min(), values.max())
    return figure


def _ratio_contours(data: xr.Dataset) -> Figure:
    """Draw the frequency ratio over two numbers, with 2:1 and 1:1 marked; white without a ratio.

    With vertically rigid ends the ratio hardly falls below 1, so that 1:1 itself is rarely crossed;
    a second line marks its neighbourhood.
    """
    down, across = data.ratio.dims
    x, y, ratio = data[across].values, data[down].values, data.ratio.values
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
        axes = figure.subplots()
        filled = axes.contourf(
            x, y, ratio, levels=np.linspace(np.nanmin(ratio), np.nanmax(ratio), 25), cmap="cividis"
        )
        bar = figure.colorbar(filled, ax=axes, ticks=MaxNLocator(8))
        bar.set_label("frequency ratio [1]")
        handles = []
        marks: tuple[tuple[float, Style, str], ...] = ((2.0, "-", "2:1"), (1.0, "--", "1:1"))
        for value, style, name in marks:
            if np.nanmin(ratio) < value < np.nanmax(ratio):
                axes.contour(
                    x, y, ratio, levels=[value], colors=MARKED, linewidths=1.8, linestyles=style
                )
                bar.ax.axhline(value, color=MARKED, linewidth=1.8, linestyle=style)
                handles.append(
                    Line2D([], [], color=MARKED, linewidth=1.8, linestyle=style, label=name)
                )
        edges: tuple[tuple[list[float], Style, str], ...]
        edges = (
            ([2.0 - 2.0 * SHADED_DETUNING, 2.0 + 2.0 * SHADED_DETUNING], ":", "2:1"),
            ([1.0 + SHADED_DETUNING], "-.", "1:1"),
        )
        for levels, style, name in edges:
            if np.nanmin(ratio) < levels[-1] and np.nanmax(ratio) > levels[0]:
                axes.contour(
                    x, y, ratio, levels=levels, colors=MARKED, linewidths=0.8, linestyles=style
                )
                label = f"{SHADED_DETUNING:.0%} from {name}"
                handles.append(
                    Line2D([], [], color=MARKED, linewidth=0.8, linestyle=style, label=label)
                )
        for values, scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
            if _geometric(values):
                scale("log")
        if handles:
            figure.legend(
                handles=handles, frameon=False, loc="outside upper center", ncols=len(handles)
            )
        axes.set_xlabel(f"{across} [{data[across].attrs['units']}]")
        axes.set_ylabel(f"{down} [{data[down].attrs['units']}]")
    return figure


def _geometric(values: Array) -> bool:
    """True if numbers grow by equal factors, as suits a logarithmic axis."""
    if len(values) < 3 or values[0] <= 0.0 or np.any(np.diff(values) <= 0.0):
        return False
    factors = np.diff(np.log(values))
    return bool(np.ptp(factors) < GEOMETRIC_TOLERANCE * np.log(values[-1] / values[0]))


def criteria_figure(criteria: Sequence[Criterion], attack_angle: float | None = None) -> Figure:
    """Draw criteria over the attack angle, one panel for each, with unstable ranges shaded.

    Parameters
    ----------
    criteria
        From `modal.stability_criteria`.
    attack_angle
        Attack angle [rad] of the scene, marked if given.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 0.6 + 1.5 * len(criteria)), layout="constrained")
        rows = figure.subplots(len(criteria), 1, sharex=True, squeeze=False)[:, 0]
        for axes, criterion in zip(rows, criteria, strict=True):
            for first, last in criterion.unstable_deg:
                axes.axvspan(first, last, color=UNSTABLE, alpha=0.3, linewidth=0.0)
            axes.axhline(0.0, color=NEUTRAL, linewidth=0.5)
            axes.plot(
                np.degrees(criterion.attack_angle), criterion.value, color=COLOURS["vertical"]
            )
            if attack_angle is not None:
                axes.axvline(np.degrees(attack_angle), color=COLOURS["horizontal"], linestyle="--")
            axes.set_ylabel(f"[{criterion.unit}]")
            axes.set_title(
                f"{criterion.name}: {criterion.formula}, negative (shaded) is unstable", loc="left"
            )
            axes.margins(x=0.0)
        rows[-1].set_xlabel("attack angle [deg]")
    return figure


def locus_figure(data: xr.Dataset) -> Figure:
    """Draw eigenvalues and damping ratios over the wind speed; the unstable side is shaded.

    Parameters
    ----------
    data
        From `modal.root_locus`.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
        plane, ratio = figure.subplots(1, 2)
        shown: set[str] = set()
        for k, family in enumerate(data.family.values.tolist()):
            s = data.eigenvalue.values[k]
            label = None if family in shown else family
            shown.add(family)
            plane.plot(
                s.real,
                s.imag / (2.0 * np.pi),
                color=COLOURS[family],
                marker=".",
                markersize=2.5,
                label=label,
            )
            plane.plot(
                s.real[0], s.imag[0] / (2.0 * np.pi), "o", color=COLOURS[family], markersize=4.0
            )
            ratio.plot(
                data.wind_speed.values, 100.0 * data.damping_ratio.values[k], color=COLOURS[family]
            )
        left, right = plane.get_xlim()
        low, high = ratio.get_ylim()
        plane.axvspan(0.0, max(right, 0.0) + 1e-9, color=UNSTABLE, alpha=0.3, linewidth=0.0)
        ratio.axhspan(min(low, 0.0) - 1e-9, 0.0, color=UNSTABLE, alpha=0.3, linewidth=0.0)
        plane.set_xlim(left, max(right, 0.0))
        ratio.set_ylim(min(low, 0.0), high)
        plane.set_xlabel("growth rate, real part [1/s]")
        plane.set_ylabel("damped frequency [Hz]")
        plane.set_title("dot: lowest wind speed; shaded: growing", loc="left")
        plane.legend(frameon=False)
        ratio.set_xlabel("wind speed [m/s]")
        ratio.set_ylabel("damping ratio [%]")
        ratio.margins(x=0.0)
    return figure


def screening_figure(found: Screening) -> Figure:
    """Draw galloping without swing over the wind speed, growth of a swing, saturated motion.

    Parameters
    ----------
    found
        From `modal.screen`.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
        amplitude, growth = figure.subplots(1, 2, sharex=True)
        cycles = found.limit_cycle
        wind = np.array([cycle.wind_speed for cycle in cycles])
        grows = np.array([cycle.multiplier for cycle in cycles])
        vertical = np.array([cycle.vertical for cycle in cycles])
        points: dict[str, Any] = {"marker": ".", "markersize": 3.0}  # the computed orbits
        amplitude.plot(
            wind, vertical, color=COLOURS["vertical"], label="vertical, without swing", **points
        )
        unstable = np.where(grows > 1.0, vertical, np.nan)
        amplitude.plot(
            wind, unstable, color=UNSTABLE, linewidth=4.0, alpha=0.5, label="a small swing grows"
        )
        growth.plot(wind, grows, color=NEUTRAL, **points)
        growth.axhline(1.0, color=NEUTRAL, linewidth=0.4)
        if found.saturated is not None:
            for name in ("vertical", "horizontal"):
                label = f"{name}, with swing"
                place = found.saturated.wind_speed, getattr(found.saturated, name)
                amplitude.plot(*place, "o", color=COLOURS[name], label=label)
        if found.onset_wind_speed is not None:
            for axes in (amplitude, growth):
                axes.axvline(found.onset_wind_speed, color=NEUTRAL, linewidth=0.6, linestyle=":")
        amplitude.set_ylabel("half peak-to-peak at mid-span [m]")
        growth.set_ylabel("growth of a small swing per cycle [1]")
        for axes in (amplitude, growth):
            axes.set_xlabel("wind speed [m/s]")
        if cycles or found.saturated is not None:
            amplitude.legend(frameon=False)
        figure.suptitle(f"{RISK_OF}: {found.risk}", fontsize=9.0)
        return figure
