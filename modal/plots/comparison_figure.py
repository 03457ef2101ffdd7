"""Figure of a comparison: histories and mid-span paths of the three models."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gallop_fmu import LineResult, Outcome, SceneError
from gallop_fmu.plots import STYLE, TEXT_WIDTH, add_notes, drawing, enlarged_part
from modal.superposition.comparison import AnyResult, Comparison, Place, midspan_of, motion_of

NAMES = {
    "nonlinear": "nonlinear simulation",
    "superposition": "mode superposition",
    "linear": "linear theory",
}
COLOURS = {"nonlinear": "#0072B2", "superposition": "#E69F00", "linear": "#404040"}
LABELS = {"u2": "vertical $u_2$ [m]", "u3": "horizontal $u_3$ [m]"}
ENDS = {Outcome.ANGLE_OUT_OF_RANGE: "attack angle\noff the curve"}
RANGE_FACTOR = 1.08
"""Range of an axis, relative to the range of the motion."""

MIN_RANGE = 1e-6
"""Smallest range of an axis [m]."""

NOTE_HEIGHT = 0.25
"""Height [inch] of a warning below the figure."""

MARKED_LEVEL = 0.2
"""Relative difference of amplitudes that is marked; a level of `Comparison.divergences`."""

LATE_SHARE = 0.75
"""Share of the time axis beyond which the note on an early end is on the left of its line."""


def comparison_figure(
    comparison: Comparison, span: int | None = None, phase: int | None = None
) -> Figure:
    """Draw histories of u2 and u3, one row for each model, and the path of mid-span in each.

    All rows have one scale, that of the two models with bounded motion; linear theory may leave it.
    A dotted line marks the time from which the amplitude of a simpler model differs from that of
    the simulation by a fifth.

    Parameters
    ----------
    comparison
        The comparison.
    span, phase
        Numbers, from 1, of what is drawn of a line (default: the mid-span with the largest motion
        in the simulation).

    Raises
    ------
    SceneError
        There is no such span or phase.
    """
    place = _largest_motion(comparison, span, phase)
    of_place = ""
    if isinstance(comparison.nonlinear, LineResult):
        of_place = f" of {comparison.nonlinear.label(*place)}"
    motions = [
        f"{NAMES[name]}: {motion_of(result, place)}" for name, result in comparison.models.items()
    ]
    warnings = dict.fromkeys(
        f"Warning: {text}" for result in comparison.models.values() for text in result.warnings
    )
    with drawing(STYLE):
        figure = Figure(
            figsize=(TEXT_WIDTH, 6.6 + NOTE_HEIGHT * len(warnings)), layout="constrained"
        )
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.5, 1.0))[:, 0]
        _draw_histories(top.subplots(3, 2, sharex=True, sharey="col"), comparison, place)
        _draw_paths(list(bottom.subplots(1, 3, sharex=True, sharey=True)), comparison, place)
        add_notes(figure, [f"Motion{of_place} in the {'; '.join(motions)}.", *warnings])
    return figure


def _largest_motion(comparison: Comparison, span: int | None, phase: int | None) -> Place:
    """Span and phase that are given, or else those with the largest range of u2 and u3."""

    def size(place: Place) -> float:
        data = midspan_of(comparison.nonlinear, *place)
        return float(sum(np.ptp(data[channel].values) for channel in LABELS))

    wanted = [
        place
        for place in comparison.places
        if span in (None, place[0]) and phase in (None, place[1])
    ]
    if not wanted:
        spans, phases = comparison.places[-1]
        raise SceneError(
            f"span = {span}, phase = {phase}: the scene has spans 1 to {spans} and phases 1 to"
            f" {phases}"
        )
    return max(wanted, key=size)


def _limits(comparison: Comparison, channel: str, place: Place) -> tuple[float, float]:
    """Range of a channel in the models with bounded motion."""
    values = np.concatenate(
        [
            midspan_of(result, *place)[channel].values
            for result in (comparison.nonlinear, comparison.superposition)
        ]
    )
    low, high = float(values.min()), float(values.max())
    middle, half = 0.5 * (low + high), 0.5 * RANGE_FACTOR * max(high - low, MIN_RANGE)
    return middle - half, middle + half


def _draw_histories(grid: NDArray[Any], comparison: Comparison, place: Place) -> None:
    """Draw one row of histories for each model."""
    stop = comparison.nonlinear.dataset.time.values[-1]
    for row, (name, result) in zip(grid, comparison.models.items(), strict=True):
        data = midspan_of(result, *place)
        for axes, channel in zip(row, LABELS, strict=True):
            axes.plot(data.time.values, data[channel].values, color=COLOURS[name], linewidth=0.4)
            axes.set_xlim(0.0, stop)
            axes.set_ylabel(LABELS[channel])
            axes.set_ylim(*_limits(comparison, channel, place))
            if name != "nonlinear":
                _mark_divergence(axes, comparison, (name, channel), place)
            if result.outcome is not Outcome.COMPLETED:
                _mark_end(axes, result)
        row[0].set_title(NAMES[name], loc="left", pad=2.0)
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")


def _mark_divergence(
    axes: Axes, comparison: Comparison, which: tuple[str, str], place: Place
) -> None:
    """Mark the time from which the amplitude of a model and channel differs from the simulation."""
    time = comparison.divergence(*which, MARKED_LEVEL, *place).amplitude
    if time is not None:
        axes.axvline(time, color="#D55E00", linestyle=":", linewidth=1.0)
        axes.set_title(
            f"amplitude differs by {MARKED_LEVEL:.0%} from {time:.0f} s",
            loc="right",
            pad=2.0,
            fontsize=7.0,
            color="#D55E00",
        )


def _mark_end(axes: Axes, result: AnyResult) -> None:
    """Mark the time at which a run ended early, with the reason on the empty side."""
    time = result.report.time
    late = time > LATE_SHARE * axes.get_xlim()[1]
    reason = ENDS.get(result.outcome, result.outcome.name.lower().replace("_", "\n"))
    axes.axvline(time, color="#404040", linewidth=0.8)
    axes.annotate(
        f"{reason}\nat {time:.0f} s",
        (time, 0.06),
        xycoords=("data", "axes fraction"),
        xytext=(-4 if late else 4, 0),
        textcoords="offset points",
        horizontalalignment="right" if late else "left",
        fontsize=7.0,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
    )


def _draw_paths(panels: list[Axes], comparison: Comparison, place: Place) -> None:
    """Draw the last periods of each model, with the length that suits the simulation."""
    first, last = next(iter(enlarged_part(midspan_of(comparison.nonlinear, *place)).values()))
    for axes, (name, result) in zip(panels, comparison.models.items(), strict=True):
        data = midspan_of(result, *place)
        stop = float(data.time.values[-1])
        start = max(0.0, stop - (last - first))
        part = data.sel(time=slice(start - 1e-9, stop + 1e-9))
        axes.plot(part.u3.values, part.u2.values, color=COLOURS[name], linewidth=0.6)
        axes.set_title(f"{NAMES[name]}, {start:.0f} to {stop:.0f} s")
        axes.set_xlabel(LABELS["u3"])
        axes.locator_params(nbins=5)
    panels[0].set_ylabel(LABELS["u2"])
    panels[0].set_xlim(*_limits(comparison, "u3", place))
    panels[0].set_ylim(*_limits(comparison, "u2", place))
