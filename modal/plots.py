"""Figures of the modal toolkit: mode shapes, ratio map, criteria over the attack angle, root locus, screening.

Every function returns a `matplotlib.figure.Figure` and leaves pyplot's global state alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from modal.criteria import Criterion
from modal.modes import Mode

if TYPE_CHECKING:
    import xarray as xr

    from modal.screening import Screening

COLOURS = {"vertical": "#0072B2", "horizontal": "#D55E00", "torsional": "#009E73", "longitudinal": "#CC79A7"}
"""Okabe and Ito's palette, which readers with any colour vision tell apart."""

UNSTABLE, NEUTRAL = "#E69F00", "#404040"
WIDTH = 7.1
"""Width of a figure over both columns of a journal page [inch]."""

NEAR = 0.1
"""Detuning from 2:1 that the ratio map shades."""

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
    """Shapes of modes along the span, a panel each, in the direction of their family.

    Parameters
    ----------
    modes
        From `modal.natural_modes`.
    title
        One line above the figure.
    """
    with matplotlib.rc_context(STYLE):
        rows = -(-len(modes) // 3)
        figure = Figure(figsize=(WIDTH, 0.5 + 1.15 * rows), layout="constrained")
        panels = figure.subplots(rows, 3, sharex=True, squeeze=False)
        for axes, mode in zip(panels.flat, modes, strict=False):
            wave = mode.shape[:, list(mode.shares).index(mode.family)]
            axes.axhline(0.0, color=NEUTRAL, linewidth=0.4)
            axes.plot(np.linspace(0.0, 1.0, len(wave)), wave / np.abs(wave).max(), color=COLOURS[mode.family])
            axes.set_title(f"{mode.family} {mode.loops}: {mode.frequency_hz:.4g} Hz, {mode.damping_ratio:.2%}")
            axes.set_yticks([])
            axes.margins(x=0.0)
        for axes in panels.flat[len(modes) :]:
            axes.set_axis_off()
        figure.supxlabel("position along the span / span [1]", fontsize=8.0)
        figure.suptitle(title, fontsize=9.0)
    return figure


def ratio_figure(data: xr.Dataset) -> Figure:
    """Frequencies and their ratio over what was varied, the neighbourhood of 2:1 shaded.

    Parameters
    ----------
    data
        From `modal.ratio_map`.
    """
    (path,) = data.ratio.dims
    values, unit = data[path].values, data[path].attrs["units"]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        for family in ("vertical", "horizontal"):
            above.plot(values, data[f"{family}_hz"].values, color=COLOURS[family], label=f"first symmetric {family}")
        above.plot(
            values, 2.0 * data.horizontal_hz.values, "--", color=COLOURS["horizontal"], label="twice the horizontal"
        )
        above.set_ylabel("frequency [Hz]")
        above.legend(frameon=False)
        below.axhspan(2.0 - 2.0 * NEAR, 2.0 + 2.0 * NEAR, color=UNSTABLE, alpha=0.3, linewidth=0.0)
        below.axhline(2.0, color=NEUTRAL, linewidth=0.6)
        below.plot(values, data.ratio.values, color=NEUTRAL, marker=".", markersize=3.0)
        below.set_ylabel("frequency ratio [1]")
        below.set_title(f"shaded: within {NEAR:.0%} of 2:1", loc="left")
        below.set_xlabel(f"{path} [{unit}]")
        below.margins(x=0.0)
    return figure


def criteria_figure(criteria: Sequence[Criterion], attack_angle: float | None = None) -> Figure:
    """Criteria over the attack angle, one above the other, with the unstable ranges shaded.

    Parameters
    ----------
    criteria
        From `modal.stability_criteria`.
    attack_angle
        The span's own [rad], marked if given.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.6 + 1.5 * len(criteria)), layout="constrained")
        rows = figure.subplots(len(criteria), 1, sharex=True, squeeze=False)[:, 0]
        for axes, criterion in zip(rows, criteria, strict=True):
            for first, last in criterion.unstable_deg:
                axes.axvspan(first, last, color=UNSTABLE, alpha=0.3, linewidth=0.0)
            axes.axhline(0.0, color=NEUTRAL, linewidth=0.5)
            axes.plot(np.degrees(criterion.attack_angle), criterion.value, color=COLOURS["vertical"])
            if attack_angle is not None:
                axes.axvline(np.degrees(attack_angle), color=COLOURS["horizontal"], linestyle="--")
            axes.set_ylabel(f"[{criterion.unit}]")
            axes.set_title(f"{criterion.name}: {criterion.formula}, negative (shaded) is unstable", loc="left")
            axes.margins(x=0.0)
        rows[-1].set_xlabel("attack angle [deg]")
    return figure


def locus_figure(data: xr.Dataset) -> Figure:
    """Eigenvalues as the wind rises, and damping ratio over wind speed; the growing side is shaded.

    Parameters
    ----------
    data
        From `modal.root_locus`.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
        plane, ratio = figure.subplots(1, 2)
        shown: set[str] = set()
        for k, family in enumerate(data.family.values.tolist()):
            s = data.eigenvalue.values[k]
            label = None if family in shown else family
            shown.add(family)
            plane.plot(s.real, s.imag / (2.0 * np.pi), color=COLOURS[family], marker=".", markersize=2.5, label=label)
            plane.plot(s.real[0], s.imag[0] / (2.0 * np.pi), "o", color=COLOURS[family], markersize=4.0)
            ratio.plot(data.wind_speed.values, 100.0 * data.damping_ratio.values[k], color=COLOURS[family])
        growing = max(plane.get_xlim()[1], 0.0)
        plane.axvspan(0.0, growing + 1e-9, color=UNSTABLE, alpha=0.3, linewidth=0.0)
        ratio.axhspan(min(ratio.get_ylim()[0], 0.0), 0.0, color=UNSTABLE, alpha=0.3, linewidth=0.0)
        plane.set_xlabel("growth rate, real part [1/s]")
        plane.set_ylabel("damped frequency [Hz]")
        plane.set_title("dot: lowest wind speed; shaded: growing", loc="left")
        plane.legend(frameon=False)
        ratio.set_xlabel("wind speed [m/s]")
        ratio.set_ylabel("damping ratio [%]")
        ratio.margins(x=0.0)
    return figure


def screening_figure(found: Screening) -> Figure:
    """Vertical galloping without swing over the wind speed, where a swing grows on it, and what both settle in.

    Parameters
    ----------
    found
        From `modal.screen`.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
        amplitude, growth = figure.subplots(1, 2, sharex=True)
        cycles = found.limit_cycle
        wind = np.array([cycle.wind_speed for cycle in cycles])
        grows = np.array([cycle.multiplier for cycle in cycles])
        vertical = np.array([cycle.vertical for cycle in cycles])
        amplitude.plot(wind, vertical, color=COLOURS["vertical"], label="vertical, without swing")
        unstable = np.where(grows > 1.0, vertical, np.nan)
        amplitude.plot(wind, unstable, color=UNSTABLE, linewidth=4.0, alpha=0.5, label="a swing grows on it")
        growth.plot(wind, grows, color=NEUTRAL)
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
        growth.set_ylabel("growth of a small swing per cycle")
        for axes in (amplitude, growth):
            axes.set_xlabel("wind speed [m/s]")
        if cycles or found.saturated is not None:
            amplitude.legend(frameon=False)
        figure.suptitle(f"risk of a 2:1 swing: {found.risk}", fontsize=9.0)
        return figure
