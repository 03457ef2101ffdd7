"""Positions of the span over a few periods, small enough to stand in a page."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model, Result
from gallop_fmu.plots import DIED_OUT
from gallop_fmu.result import slowest_frequency

Array = NDArray[np.float64]

PERIODS = 10.0
FRAMES = 500
STEADY = 10.0
"""Time shown [s] where nothing oscillates."""

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
    """The last periods of a run, or the first ones where the motion has died out by then."""
    data = result.dataset
    time = np.asarray(data.time.values)
    part, chosen = _window(result)
    frames = chosen[np.linspace(0, len(chosen) - 1, min(FRAMES, len(chosen))).round().astype(int)]
    nodes = np.asarray(data.node.values)
    at_rest = Model(result.scene).equilibrium().x[nodes]
    along, height, across = (at_rest[:, k] + data[name].values[frames] for k, name in enumerate(("u1", "u2", "u3")))
    middle = int(np.flatnonzero(nodes == result.scene.numerics.elements)[0])
    twist = np.asarray(data.theta.values[frames, middle])
    return Animation(part, time[frames], along, height, across, twist, middle)


def _window(result: Result) -> tuple[str, NDArray[np.intp]]:
    """Name of the part of the run that is shown, and its records."""
    data = result.midspan()
    time = np.asarray(data.time.values)
    swings = [np.asarray(data[name].values) for name in ("u2", "u3")]
    slowest = slowest_frequency(data)
    length = PERIODS / slowest if math.isfinite(slowest) else STEADY
    late = time >= time[-1] - length
    if all(np.ptp(y[late]) <= DIED_OUT * np.ptp(y) for y in swings):
        return "the beginning; the motion dies out later", np.flatnonzero(time <= length)
    return "the end of the run", np.flatnonzero(late)
