"""Figure of a risk atlas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from gallop_fmu.plots import add_title, drawing
from modal.plots.span_figures import NEUTRAL, STYLE, WIDTH

if TYPE_CHECKING:
    import xarray as xr

    from modal.risk.atlas import RiskAtlas

EVENT_COLOURS = {"galloping": "#0072B2", "swing": "#009E73", "clash": "#D55E00"}
"""Palette of Okabe and Ito."""

MAX_CURVES = 6
"""Maximum number of spans with a curve; those most likely to gallop."""
MAX_SPANS = 40
"""Maximum number of spans with probabilities; those most likely to gallop."""
SPAN_HEIGHT = 0.2
"""Height of a span in the figure [inch]."""


def risk_figure(atlas: RiskAtlas) -> Figure:
    """Draw the probabilities of each span, its amplitude over the return period, the convergence.

    With Sobol shares, those of the span most likely to gallop are drawn, too. Of many spans the
    figure has those most likely to gallop.

    Parameters
    ----------
    atlas
        From `modal.risk_atlas`.
    """
    data = atlas.dataset
    order = np.argsort(-np.nan_to_num(data.winter_galloping.values, nan=-1.0))
    shown, worst = data.isel(span=order[:MAX_SPANS]), data.isel(span=order[:MAX_CURVES])
    with drawing(STYLE):
        height = 3.4 + max(1.0, SPAN_HEIGHT * shown.sizes["span"])
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        add_title(figure, "Risk of galloping")
        halves: Any = figure.subfigures(2, 1, height_ratios=(height - 2.6, 2.6))
        upper, lower = halves
        _probabilities(upper.subplots(), shown)
        has_shares = "first_share" in data and bool(worst.first_share.isel(span=0).notnull().all())
        parts = lower.subplots(1, 3 if has_shares else 2)
        _amplitudes(parts[0], worst)
        _convergence(parts[1], worst)
        if has_shares:
            _shares(parts[2], worst.isel(span=0))
        return figure


def _probabilities(axes: Any, data: xr.Dataset) -> None:
    places = np.arange(data.sizes["span"])
    drawn = [event for event in EVENT_COLOURS if np.any(np.isfinite(data[event].values))]
    for k, event in enumerate(drawn):
        values = data[f"winter_{event}"].values
        ends = np.abs(
            [data[f"winter_{event}_{end}"].values - values for end in ("lowest", "highest")]
        )
        axes.errorbar(
            values,
            places + 0.18 * (k - 0.5 * (len(drawn) - 1)),
            xerr=ends,
            fmt="osD"[k],
            markersize=3.5,
            color=EVENT_COLOURS[event],
            linewidth=0.9,
            label=event,
        )
    axes.set_yticks(places, data.span.values.tolist())
    axes.set_ylim(data.sizes["span"] - 0.5, -0.5)
    axes.set_xlim(-0.02, 1.02)
    axes.set_xlabel("probability in a winter [1]")
    axes.grid(axis="y", linewidth=0.3, color="#d0d0d0")
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0.0, 1.0))


def _amplitudes(axes: Any, data: xr.Dataset) -> None:
    periods = data.return_period.values
    for k, span in enumerate(data.span.values.tolist()):
        one = data.isel(span=k)
        line = axes.plot(periods, 2.0 * one.amplitude, marker="o", markersize=2.5, label=span)[0]
        axes.fill_between(
            periods,
            2.0 * one.amplitude_lowest,
            2.0 * one.amplitude_highest,
            color=line.get_color(),
            alpha=0.15,
            linewidth=0.0,
        )
    axes.set_xscale("log")
    axes.set_xticks(periods, [f"{period:g}" for period in periods])
    axes.minorticks_off()
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("return period [winters]")
    axes.set_ylabel("vertical, peak to peak [m]")
    axes.legend(frameon=False)


def _convergence(axes: Any, data: xr.Dataset) -> None:
    draws = data.draws.values
    for k in range(data.sizes["span"]):
        one = data.isel(span=k)
        line = axes.plot(draws, one.galloping_of_draws, marker="o", markersize=2.5)[0]
        axes.fill_between(
            draws,
            one.galloping_of_draws_lowest,
            one.galloping_of_draws_highest,
            color=line.get_color(),
            alpha=0.15,
            linewidth=0.0,
        )
    axes.set_xscale("log", base=2)
    axes.set_xticks(draws, [f"{count:g}" for count in draws])
    axes.set_xlabel("draws")
    axes.set_ylabel("probability of galloping\nin an ice event [1]")


def _shares(axes: Any, data: xr.Dataset) -> None:
    names = data.quantity.values.tolist()
    places = np.arange(len(names))
    for k, (name, label) in enumerate({"first_share": "alone", "total_share": "in total"}.items()):
        values = data[name].values
        ends = np.abs([data[f"{name}_{end}"].values - values for end in ("lowest", "highest")])
        axes.barh(
            places + 0.36 * (k - 0.5),
            values,
            0.34,
            xerr=ends,
            color=("#56B4E9", "#E69F00")[k],
            error_kw={"linewidth": 0.8, "ecolor": NEUTRAL},
            label=label,
        )
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.05)
    axes.set_xlabel(f"share of the variance of the\namplitude [1], {data.span.item()}")
    axes.legend(frameon=False)
