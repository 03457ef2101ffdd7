"""The figure of a comparison: histories and mid-span paths of the three models."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gallop_fmu import Outcome, Result
from gallop_fmu.plots import STYLE, TEXT_WIDTH, add_notes, drawing, enlarged_part
from modal.superposition.comparison import Comparison

NAMES = {
    "nonlinear": "nonlinear simulation",
    "superposition": "mode superposition",
    "linear": "linear theory",
}
COLOURS = {"nonlinear": "#0072B2", "superposition": "#E69F00", "linear": "#404040"}
LABELS = {"u2": "vertical $u_2$ [m]", "u3": "horizontal $u_3$ [m]"}
ENDS = {Outcome.ANGLE_OUT_OF_RANGE: "attack angle\noff the curve"}
MARGIN = 1.08
NOTE_HEIGHT = 0.25
"""Height [in] that a warning below the figure takes."""

LEVEL = 0.2
"""Part of the running amplitude at which a parting of amplitudes is marked."""


def comparison_figure(comparison: Comparison) -> Figure:
    """Histories of u2 and u3, a row for each model, and the path of the mid-span point in each.

    All rows share one scale, that of the two models that stay bounded; linear theory runs out of
    it.  A dotted line marks where the amplitude of a simpler model has parted from the simulation's
    by a fifth.
    """
    motions = [f"{NAMES[name]}: {result.motion}" for name, result in comparison.models.items()]
    warnings = dict.fromkeys(
        f"Warning: {text}" for result in comparison.models.values() for text in result.warnings
    )
    with drawing(STYLE):
        figure = Figure(
            figsize=(TEXT_WIDTH, 6.6 + NOTE_HEIGHT * len(warnings)), layout="constrained"
        )
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.5, 1.0))[:, 0]
        _draw_histories(top.subplots(3, 2, sharex=True, sharey="col"), comparison)
        _draw_paths(list(bottom.subplots(1, 3, sharex=True, sharey=True)), comparison)
        add_notes(figure, [f"Motion in the {'; '.join(motions)}.", *warnings])
    return figure


def _limits(comparison: Comparison, channel: str) -> tuple[float, float]:
    """Range of the models that do not grow without bound."""
    values = np.concatenate(
        [
            result.midspan()[channel].values
            for result in (comparison.nonlinear, comparison.superposition)
        ]
    )
    low, high = float(values.min()), float(values.max())
    middle, half = 0.5 * (low + high), 0.5 * MARGIN * max(high - low, 1e-6)
    return middle - half, middle + half


def _draw_histories(grid: NDArray[Any], comparison: Comparison) -> None:
    stop = comparison.nonlinear.dataset.time.values[-1]
    for row, (name, result) in zip(grid, comparison.models.items(), strict=True):
        data = result.midspan()
        for axes, channel in zip(row, LABELS, strict=True):
            axes.plot(data.time.values, data[channel].values, color=COLOURS[name], linewidth=0.4)
            axes.set_xlim(0.0, stop)
            axes.set_ylabel(LABELS[channel])
            axes.set_ylim(*_limits(comparison, channel))
            if name != "nonlinear":
                _mark_divergence(axes, comparison, name, channel)
            if result.outcome is not Outcome.COMPLETED:
                _mark_end(axes, result)
        row[0].set_title(NAMES[name], loc="left", pad=2.0)
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")


def _mark_divergence(axes: Axes, comparison: Comparison, name: str, channel: str) -> None:
    time = comparison.divergence(name, channel, LEVEL).amplitude
    if time is not None:
        axes.axvline(time, color="#D55E00", linestyle=":", linewidth=1.0)
        axes.set_title(
            f"amplitude off by 20 % from {time:.0f} s",
            loc="right",
            pad=2.0,
            fontsize=7.0,
            color="#D55E00",
        )


def _mark_end(axes: Axes, result: Result) -> None:
    """A line where a run ended early, and why, on its empty side."""
    time = result.report.time
    late = time > 0.75 * axes.get_xlim()[1]
    why = ENDS.get(result.outcome, result.outcome.name.lower().replace("_", "\n"))
    axes.axvline(time, color="#404040", linewidth=0.8)
    axes.annotate(
        f"{why}\nat {time:.0f} s",
        (time, 0.06),
        xycoords=("data", "axes fraction"),
        xytext=(-4 if late else 4, 0),
        textcoords="offset points",
        horizontalalignment="right" if late else "left",
        fontsize=7.0,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
    )


def _draw_paths(panels: list[Axes], comparison: Comparison) -> None:
    """The last periods of each model, as many seconds of them as show the slowest motion of the simulation."""
    first, last = next(iter(enlarged_part(comparison.nonlinear.midspan()).values()))
    for axes, (name, result) in zip(panels, comparison.models.items(), strict=True):
        data = result.midspan()
        stop = float(data.time.values[-1])
        start = max(0.0, stop - (last - first))
        part = data.sel(time=slice(start - 1e-9, stop + 1e-9))
        axes.plot(part.u3.values, part.u2.values, color=COLOURS[name], linewidth=0.6)
        axes.set_title(f"{NAMES[name]}, {start:.0f} to {stop:.0f} s")
        axes.set_xlabel(LABELS["u3"])
        axes.locator_params(nbins=5)
    panels[0].set_ylabel(LABELS["u2"])
    panels[0].set_xlim(*_limits(comparison, "u3"))
    panels[0].set_ylim(*_limits(comparison, "u2"))
