"""Positions of the span over a few periods, small enough to stand in a page."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model, Result
from gallop_fmu.plots import DIED_OUT
from gallop_fmu.simulation.steadiness import (
    FEWEST_SAMPLES,
    TURNED_OVER,
    default_window,
    dominant_frequency,
)

Array = NDArray[np.float64]

PERIODS, OTHER_PERIODS = 10.0, 5.0
"""Periods shown of a steady motion, and of another one."""

FRAMES = 500
"""Most positions that a page holds; the script draws a cubic in time through them."""

STILL = 10.0
"""Time shown [s] where nothing oscillates."""

LONGEST = 60.0
"""Longest time shown [s]."""

PART = 0.05
"""Range of a channel, per range of the largest, from which on its period is one to be shown."""

DIGITS = 4
"""Digits after the point of a position [m]: a tenth of a millimetre."""


@dataclass(frozen=True)
class Animation:
    """Frames of a moving span.

    Attributes
    ----------
    part : str
        Which part of the run it is, in words.
    time : ndarray, shape (frame,)
        Times [s].
    along, height, across : ndarray, shape (frame, node)
        Positions x1, x2, x3 [m].
    twist : ndarray, shape (frame,)
        Twist [rad] at mid-span.
    middle : int
        Which of the nodes is at mid-span.
    """

    part: str
    time: Array
    along: Array
    height: Array
    across: Array
    twist: Array
    middle: int

    def packed(self) -> dict[str, Any]:
        """The same for JavaScript: nested lists of rounded numbers; x1 hardly moves and is that of the first frame."""
        return {
            "time": self.time.round(3).tolist(),
            "along": self.along[0].round(3).tolist(),
            "height": self.height.round(DIGITS).tolist(),
            "across": self.across.round(DIGITS).tolist(),
            "twist": self.twist.round(DIGITS).tolist(),
            "middle": self.middle,
        }


def animation(result: Result) -> Animation:
    """Show the last periods of a run, or those of its largest motion where that has died out by then."""
    data = result.dataset
    time = np.asarray(data.time.values)
    part, chosen = _window(result)
    frames = chosen[:: math.ceil(len(chosen) / FRAMES)]
    nodes = np.asarray(data.node.values)
    at_rest = Model(result.scene).equilibrium().x[nodes]
    along, height, across = (
        at_rest[:, k] + data[name].values[frames] for k, name in enumerate(("u1", "u2", "u3"))
    )
    middle = int(np.flatnonzero(nodes == result.scene.numerics.elements)[0])
    twist = np.asarray(data.theta.values[frames, middle])
    return Animation(part, time[frames], along, height, across, twist, middle)


def _window(result: Result) -> tuple[str, NDArray[np.intp]]:
    """Name of the part of the run that is shown, and its records."""
    data = result.midspan()
    time = np.asarray(data.time.values)
    swings = [np.asarray(data[name].values) for name in ("u2", "u3")]
    last = float(time[-1])
    seen = time >= last - default_window(last)
    part, centre = "the end of the run", None
    if result.motion.kind == "turned over":
        turn = np.abs(data.theta.values - data.theta.values[0])
        part, centre = "the section turns over", float(time[np.argmax(turn > TURNED_OVER)])
        seen = (time <= centre) & (time >= centre - default_window(last))
    elif all(np.ptp(y[seen]) <= DIED_OUT * np.ptp(y) for y in swings):
        largest = max(swings, key=np.ptp)
        centre = float(time[np.argmax(np.abs(largest - largest[-1]))])
        part = "the largest motion of the run, which dies out later"
        seen = np.abs(time - centre) <= 0.5 * default_window(last)
    length = min(
        _period(time[seen], [y[seen] for y in swings], result.motion.kind == "steady"), LONGEST
    )
    start = max(0.0, last - length if centre is None else centre - 0.5 * length)
    return part, np.flatnonzero((time >= start - 1e-9) & (time <= start + length + 1e-9))


def _period(time: Array, swings: list[Array], steady: bool) -> float:
    """Time [s] that shows some periods of the slowest of the channels that move much."""
    if len(time) < FEWEST_SAMPLES:
        return STILL
    interval, large = float(time[1] - time[0]), PART * max(float(np.ptp(y)) for y in swings)
    found = [dominant_frequency(y, interval) for y in swings if np.ptp(y) >= large]
    cycles = [frequency for frequency in found if frequency * (time[-1] - time[0]) >= 1.0]
    return (PERIODS if steady else OTHER_PERIODS) / min(cycles) if cycles else STILL
