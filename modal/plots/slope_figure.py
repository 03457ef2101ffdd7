"""Figure of the slope that galloping needs, over the wind speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from gallop_fmu.plots import add_title, drawing
from modal.plots.span_figures import COLOURS, NEUTRAL, STYLE, UNSTABLE, WIDTH

if TYPE_CHECKING:
    from modal.stability.required_slope import RequiredSlope

SHOWN_SLOPES = 15.0
"""Steepest slope [1/rad] in the figure; measured curves are less steep."""

MARGIN = 1.2
"""Range of the figure over the largest value in it."""


def slope_figure(found: RequiredSlope) -> Figure:
    """Draw the needed slope of each mode over the wind speed, and the estimate of its amplitude.

    Parameters
    ----------
    found
        From `modal.required_slope`.
    """
    data = found.dataset
    wind = data.wind_speed.values
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
        add_title(figure, data.attrs["title"])
        slope, amplitude = figure.subplots(1, 2, sharex=True)
        shown: set[str] = set()
        for k, family in enumerate(data.family.values.tolist()):
            needed = data.slope.values[k]
            if np.all(np.isnan(needed)):
                continue
            label = None if family in shown else family
            shown.add(family)
            slope.plot(wind, needed, color=COLOURS[family], label=label)
            amplitude.plot(wind, data.amplitude_limit.values[k], color=COLOURS[family])
        decisive = found.decisive().values
        known = np.isfinite(decisive)
        if np.any(known):
            lowest = -min(SHOWN_SLOPES, MARGIN * float(np.max(np.abs(decisive[known]))))
            slope.fill_between(wind, lowest, decisive, color=UNSTABLE, alpha=0.3, linewidth=0.0)
            slope.set_ylim(lowest, max(0.0, MARGIN * float(np.max(decisive[known]))))
        observed = data.observed_amplitude.values
        if np.any(np.isfinite(observed)):
            amplitude.axhline(
                float(np.nanmax(observed)),
                color=NEUTRAL,
                linestyle="--",
                label="largest observed (CIGRE 322)",
            )
            amplitude.legend(frameon=False)
        slope.set_ylabel("CD + dCL/dalpha [1/rad]")
        slope.set_title("a mode grows below its line", loc="left")
        amplitude.set_ylabel("amplitude [m]")
        amplitude.set_title(
            f"limit for a saturation at {found.saturation_deg:g} deg (assumed)", loc="left"
        )
        for axes in (slope, amplitude):
            axes.set_xlabel("wind speed [m/s]")
            axes.margins(x=0.0)
        if shown:
            slope.legend(frameon=False)
        return figure
