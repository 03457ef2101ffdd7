"""Oscillations: amplitude, mean, frequency and judgement of a channel over a window."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.histories import HistoryNumbers, history_numbers
from gallop_fmu.foundation.channels import DESCRIBED
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.simulation.steadiness import (
    REST_AMPLITUDE,
    STEADY_RANGE,
    TWIST_LEVER,
    Motion,
    dominant_frequency,
    judge_numbers,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


MOVES = {"u2": "vertical", "u3": "horizontal", "theta": "twist"}
"""Channels for the judgement of a motion, and their names in words."""

SMALL_OF = {
    "m": REST_AMPLITUDE,
    "m/s": REST_AMPLITUDE,
    "m/s2": REST_AMPLITUDE,
    "rad": REST_AMPLITUDE / TWIST_LEVER,
    "rad/s": REST_AMPLITUDE / TWIST_LEVER,
    "rad/s2": REST_AMPLITUDE / TWIST_LEVER,
}
"""Unit to the amplitude below which a channel is at rest.

For other units it is `REST_AMPLITUDE` times the maximum of the channel."""


class Oscillation(NamedTuple):
    """Oscillation of one channel over a window.

    Attributes
    ----------
    amplitude, mean
        Half peak-to-peak, and mean, in the channel's unit.
    frequency_hz
        Dominant frequency [Hz]; NaN without one, see
        `gallop_fmu.simulation.steadiness.dominant_frequency`.
    motion
        Judgement of the motion. Only for a steady motion are the numbers valid beyond the window.
    deviation
        Standard deviation, in the channel's unit; of a harmonic motion the amplitude over sqrt(2).
    """

    amplitude: float
    mean: float
    frequency_hz: float
    motion: Motion
    deviation: float

    @property
    def is_steady(self) -> bool:
        """True if the motion is steady or at rest."""
        return self.motion.is_steady

    def __repr__(self) -> str:
        return (
            f"Oscillation(amplitude {self.amplitude:.5g}, mean {self.mean:.5g},"
            f" {frequency_text(self.frequency_hz)} Hz, {self.motion})"
        )

    def as_dict(self) -> dict[str, float | str]:
        """Return plain numbers and text, for JSON."""
        return {**self._asdict(), "motion": str(self.motion)}

    def text(self, unit: str, scale: float = 1.0, digits: str = ".3f") -> str:
        """Return the amplitude, with the motion unless it is steady: ``0.026 m, still growing``.

        Of a random motion it is the standard deviation.
        """
        if self.motion.kind == "random":
            return f"standard deviation {self.deviation * scale:{digits}} {unit}, {self.motion}"
        size = f"{self.amplitude * scale:{digits}} {unit}"
        return size if self.motion.kind == "steady" else f"{size}, {self.motion}"


MAIN_CHANNELS = ("u2", "u3", "theta", "tension")
"""Channels that are shown first."""


class Oscillations(dict[str, Oscillation]):
    """Oscillation of each mid-span channel by name.

    Attributes
    ----------
    start, stop : float
        Start and end [s] of the window.
    """

    def __init__(self, channels: Mapping[str, Oscillation], start: float, stop: float) -> None:
        super().__init__(channels)
        self.start, self.stop = start, stop

    def __repr__(self) -> str:
        shown = [name for name in MAIN_CHANNELS if name in self] or list(self)[: len(MAIN_CHANNELS)]
        rows = [f"  {name}: {self._line(name)}" for name in shown]
        others = [name for name in self if name not in shown]
        if others:
            rows.append(f"  and {len(others)} more channels: {others[0]}, ..., {others[-1]}")
        return "\n".join(
            [f"Oscillations from {self.start:g} to {self.stop:g} s (half peak-to-peak)", *rows]
        )

    def _line(self, name: str) -> str:
        each, unit = self[name], DESCRIBED[name].unit
        return (
            f"{each.amplitude:.5g} {unit} at {frequency_text(each.frequency_hz)} Hz, {each.motion}"
        )


def frequency_text(frequency_hz: float) -> str:
    """Return a dominant frequency as text; a dash for NaN."""
    return f"{frequency_hz:.4f}" if math.isfinite(frequency_hz) else "-"


def slowest_frequency(data: xr.Dataset) -> float:
    """Return the lower dominant frequency [Hz] of u2 and u3 in the second half of a run, or NaN.

    Parameters
    ----------
    data
        Dataset with u2 and u3 over ``time`` [s] at mid-span.
    """
    time = np.asarray(data.time.values)
    late = slice(len(time) // 2, None)
    interval = float(time[1] - time[0]) if len(time) > 1 else math.nan
    found = [
        dominant_frequency(np.asarray(data[name].values)[late], interval) for name in ("u2", "u3")
    ]
    return min((frequency for frequency in found if math.isfinite(frequency)), default=math.nan)


def oscillation(
    values: Array, interval: float, unit: str = "m", *, is_gusty: bool = False
) -> Oscillation:
    """Return the oscillation of equally spaced samples with a unit, maybe in gusty wind."""
    (numbers,) = history_numbers([values], STEADY_RANGE)
    return _oscillation(values, numbers, interval, unit, is_gusty)


def _oscillation(
    values: Array, numbers: HistoryNumbers, interval: float, unit: str, is_gusty: bool
) -> Oscillation:
    amplitude, mean, frequency = _measured(numbers, interval)
    floor = SMALL_OF.get(unit, REST_AMPLITUDE * (abs(mean) + amplitude))
    motion = judge_numbers(values, numbers, interval, floor, is_gusty=is_gusty)
    return Oscillation(amplitude, mean, frequency, motion, numbers.deviation)


def measure(values: Array, interval: float) -> tuple[float, float, float]:
    """Return half peak-to-peak, mean and dominant frequency [Hz] of equally spaced samples."""
    return measure_all([values], interval)[0]


def measure_all(
    values: Sequence[Array] | Array, interval: float
) -> list[tuple[float, float, float]]:
    """Return what `measure` returns, of several histories of equal length."""
    return [_measured(numbers, interval) for numbers in history_numbers(values)]


def _measured(numbers: HistoryNumbers, interval: float) -> tuple[float, float, float]:
    amplitude = 0.5 * (numbers.highest - numbers.lowest)
    return amplitude, numbers.mean, numbers.frequency_hz(interval)


def oscillations(
    time: Array,
    histories: Mapping[str, tuple[Array, str]],
    start: float,
    stop: float,
    *,
    is_gusty: bool = False,
) -> Oscillations:
    """Return the oscillation of each channel of one point from `start` to `stop` [s].

    Parameters
    ----------
    time : ndarray, shape (time,)
        Times [s], equally spaced.
    histories
        Channel to its values, shape (time,), and its unit.
    is_gusty
        The wind is gusty, so that no motion is steady.

    Raises
    ------
    SceneError
        There are fewer than two records.
    """
    part = np.flatnonzero((time >= start - 1e-9) & (time <= stop + 1e-9))
    if len(part) < 2:
        raise SceneError(
            f"there are fewer than two records from {start} s to {stop} s; give a longer window"
        )
    interval = float(time[part[1]] - time[part[0]])
    late = np.stack([values[part[0] : part[-1] + 1] for values, _ in histories.values()])
    found = {
        name: _oscillation(values, numbers, interval, unit, is_gusty)
        for (name, (_, unit)), values, numbers in zip(
            histories.items(), late, history_numbers(late, STEADY_RANGE), strict=True
        )
    }
    return Oscillations(found, start, stop)
