"""Positions of the span over a few periods, for the animation in a report."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model, Result
from gallop_fmu.plots import DIED_OUT
from gallop_fmu.simulation.steadiness import (
    MIN_SAMPLES,
    TURNED_OVER,
    default_window,
    dominant_frequency,
)

Array = NDArray[np.float64]

STEADY_PERIODS, OTHER_PERIODS = 10.0, 5.0
"""Periods shown of a steady motion, and of any other motion."""

MAX_FRAMES = 500
"""Largest number of frames in a page; the script interpolates them by cubics in time."""

DEFAULT_LENGTH, MAX_LENGTH = 10.0, 60.0
"""Time shown [s] if nothing oscillates, and longest time shown."""

MIN_RANGE_RATIO = 0.05
"""Range of a channel, relative to the largest, above which its period counts."""

DECIMALS = 4
"""Decimal places of a position [m]: a tenth of a millimetre."""

TIME_TOLERANCE = 1e-9
"""Difference of times [s] due to rounding."""


@dataclass(frozen=True)
class Animation:
    """Frames of a moving span.

    Attributes
    ----------
    part : str
        Name of the part of the run that is shown.
    time : ndarray, shape (frame,)
        Times [s].
    along, height, across : ndarray, shape (frame, node)
        Positions x1, x2, x3 [m].
    twist : ndarray, shape (frame,)
        Twist [rad] at mid-span.
    middle : int
        Index of the node at mid-span.
    """

    part: str
    time: Array
    along: Array
    height: Array
    across: Array
    twist: Array
    middle: int

    def packed(self) -> dict[str, Any]:
        """Convert to nested lists of rounded numbers, for JavaScript.

        x1 hardly changes; that of the first frame is used.
        """
        return {
            "time": self.time.round(3).tolist(),
            "along": self.along[0].round(3).tolist(),
            "height": self.height.round(DECIMALS).tolist(),
            "across": self.across.round(DECIMALS).tolist(),
            "twist": self.twist.round(DECIMALS).tolist(),
            "middle": self.middle,
        }


def animation(result: Result) -> Animation:
    """Select the last periods of a run, or those of its largest motion if that decays later."""
    data = result.dataset
    time = np.asarray(data.time.values)
    part, chosen = _window(result)
    frames = chosen[:: math.ceil(len(chosen) / MAX_FRAMES)]
    nodes = np.asarray(data.node.values)
    initial = Model(result.scene).equilibrium().x[nodes]
    along, height, across = (
        initial[:, k] + data[name].values[frames] for k, name in enumerate(("u1", "u2", "u3"))
    )
    middle = int(np.flatnonzero(nodes == result.scene.elements)[0])
    twist = np.asarray(data.theta.values[frames, middle])
    return Animation(part, time[frames], along, height, across, twist, middle)


def _window(result: Result) -> tuple[str, NDArray[np.intp]]:
    """Name of the part of the run that is shown, and its records."""
    data = result.midspan()
    time = np.asarray(data.time.values)
    motions = [np.asarray(data[name].values) for name in ("u2", "u3")]
    periods = STEADY_PERIODS if result.motion.kind == "steady" else OTHER_PERIODS
    if result.motion.kind != "turned over":
        return shown_part(time, motions, periods)
    turn = np.abs(data.theta.values - data.theta.values[0])
    centre = float(time[np.argmax(turn > TURNED_OVER)])
    near = (time <= centre) & (time >= centre - default_window(float(time[-1])))
    return "the section turns over", _records(time, motions, near, centre, periods)


def shown_part(time: Array, motions: list[Array], periods: float) -> tuple[str, NDArray[np.intp]]:
    """Select the last periods of a run, or those of its largest motion if that decays later.

    Parameters
    ----------
    time
        Times [s] of the records.
    motions
        Histories [m].
    periods
        Number of periods of the slowest motion that is not small.

    Returns
    -------
    str, ndarray
        Name of the part, and its records.
    """
    length = default_window(float(time[-1]))
    near = time >= time[-1] - length
    if any(np.ptp(y[near]) > DIED_OUT * np.ptp(y) for y in motions):
        return "the end of the run", _records(time, motions, near, None, periods)
    largest = max(motions, key=np.ptp)
    centre = float(time[np.argmax(np.abs(largest - largest[-1]))])
    near = np.abs(time - centre) <= 0.5 * length
    part = "the largest motion of the run, which decays later"
    return part, _records(time, motions, near, centre, periods)


def _records(
    time: Array,
    motions: list[Array],
    near: NDArray[np.bool_],
    centre: float | None,
    periods: float,
) -> NDArray[np.intp]:
    """Records of some periods about a time [s]; None: at the end. `near` decides the period."""
    length = min(_length(time[near], [y[near] for y in motions], periods), MAX_LENGTH)
    start = max(0.0, time[-1] - length if centre is None else centre - 0.5 * length)
    shown = (time >= start - TIME_TOLERANCE) & (time <= start + length + TIME_TOLERANCE)
    return np.flatnonzero(shown)


def _length(time: Array, motions: list[Array], periods: float) -> float:
    """Length [s] of some periods of the slowest motion that is not small."""
    if len(time) < MIN_SAMPLES:
        return DEFAULT_LENGTH
    interval = float(time[1] - time[0])
    least = MIN_RANGE_RATIO * max(float(np.ptp(y)) for y in motions)
    found = [dominant_frequency(y, interval) for y in motions if np.ptp(y) >= least]
    cycles = [frequency for frequency in found if frequency * (time[-1] - time[0]) >= 1.0]
    return periods / min(cycles) if cycles else DEFAULT_LENGTH


def played(
    part: str, time: Array, moved: tuple[Array, Array], packed: dict[str, Any]
) -> dict[str, Any]:
    """Return what a template needs of an animation.

    Parameters
    ----------
    part
        Name of the part of the run that is shown.
    time
        Times [s].
    moved
        Heights and downwind places [m].
    packed
        Numbers for the script.
    """
    height, across = moved
    return {
        "part": part,
        "start": float(time[0]),
        "stop": float(time[-1]),
        "low": float(height.min()),
        "high": float(height.max()),
        "left": float(across.min()),
        "right": float(across.max()),
        "data": json.dumps(packed, separators=(",", ":")),
    }
