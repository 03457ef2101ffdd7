"""Judgement of a motion: steady, still growing, beating, irregular, random, at rest, turned over.

A channel is cut into cycles of its dominant frequency. The envelope is half of the range of each
cycle, with extremes refined by a parabola; the judgement follows from its change over the window:

`STEADY_RANGE` (2 %)
    Maximum range of the envelope, relative to its mean, of a steady motion: its amplitude then has
    two reliable digits. If single cycles differ more, the maxima of two, three or four cycles are
    compared: such a motion repeats after several cycles.
`FLAT_CHANGE` (0.2 %)
    Change of the mean envelope from one third of the window to the next that counts as zero, about
    ten times the error of the envelope. Growth below 0.4 % a minute, in a window of 100 s, is
    therefore judged as steady.
`REMAINING_CHANGE` (1 %)
    Maximum remaining change of a steady motion that approaches a limit cycle. It is extrapolated
    from the thirds, whose differences decrease by a constant factor. With a factor above
    `MAX_FACTOR` (0.9) there is no bound: growth from a small disturbance continues to many times
    the amplitude, however slow it is.
`HIDDEN_SHARE` (0.1 %) and `HIDDEN_GROWTH` (1.1)
    A part that does not repeat from cycle to cycle makes a motion "still growing" if it has this
    share of the amplitude and grows by this factor from third to third. An example is the swing
    below steady vertical galloping before the transfer of energy. The error of interpolation
    between samples is below 0.03 %.
`TREND_SHARE` (0.7) and `BEAT_SHARE` (0.9)
    Share of the variance of the envelope that a parabola in time must explain for a trend, and a
    spectral line with its double for beats. Narrow-band noise and chaos rarely reach them.
`MIN_CYCLES` (9) and `MIN_RECORDS_PER_CYCLE` (5.5)
    Minimum number of cycles in the window, three in each third, and of records in a cycle: with
    five, the peaks of a motion with harmonics have an error of 10 %. With fewer than twenty, a
    hidden part must have about 1 % to be detected.
`TURNED_OVER` (180 deg)
    Change of the twist since the start at which the section has turned over: the ice is on the
    other side.
In gusty wind a motion with `MIN_CYCLES` is "random": it has a mean, a standard deviation and
extremes over the window, but no amplitude that lasts.

`REST_AMPLITUDE` (0.1 mm)
    Amplitude below which a motion that does not grow is at rest; for a twist 0.06 deg, with a lever
    of 0.1 m. `ROUND_OFF` (1e-9 m) is rounding.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.histories import HistoryNumbers, beat_share, history_numbers, history_sizes

Array = NDArray[np.float64]

Kind = Literal[
    "turned over",
    "random",
    "still growing",
    "irregular",
    "undetermined",
    "beating",
    "decaying",
    "steady",
    "at rest",
]

STEADY_RANGE = 0.02
FLAT_CHANGE = 0.002
REMAINING_CHANGE = 0.01
MAX_FACTOR = 0.9
HIDDEN_SHARE = 0.001
HIDDEN_GROWTH = 1.1
TREND_SHARE = 0.7
BEAT_SHARE = 0.9
MIN_CYCLES = 9
MIN_RECORDS_PER_CYCLE = 5.5
TURNED_OVER = math.pi
REST_AMPLITUDE = 1e-4
ROUND_OFF = 1e-9
TWIST_LEVER = 0.1

KINDS: tuple[Kind, ...] = get_args(Kind)
"""Kinds in order of precedence: a span has the first kind of its channels."""

MAX_WINDOW = 100.0
"""Default length [s] of the window at the end of a run, at most half of the run."""

MIN_SAMPLES = 8
"""Minimum number of samples for a spectral line."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Judgement of a motion over a window.

    Attributes
    ----------
    kind : str
        ``"steady"``, ``"still growing"``, ``"decaying"``, ``"beating"``, ``"irregular"``, ``"at
        rest"``, ``"random"`` (in gusty wind), ``"turned over"`` (the section, at some time of the
        run), or ``"undetermined"`` (too few cycles).
    detail : str
        Details, such as ``"vertical +12 %/min"``; may be empty.
    rate : float
        Growth rate [1/s] of the amplitude, or of its growing part; NaN without growth or decay.
    """

    kind: Kind
    detail: str = ""
    rate: float = math.nan

    @property
    def is_steady(self) -> bool:
        """True if the motion is steady or at rest, so that its amplitude is lasting."""
        return self.kind in ("steady", "at rest")

    def __str__(self) -> str:
        if self.kind == "turned over":
            return f"turned over {self.detail}"
        return f"{self.kind} ({self.detail})" if self.detail else self.kind


def dominant_frequency(values: Array, interval: float) -> float:
    """Return the frequency [Hz] of the largest spectral line; NaN without one.

    There is none for a channel at rest, and for fewer than `MIN_SAMPLES` samples.

    Parameters
    ----------
    values : ndarray, shape (time,)
        Samples.
    interval
        Time [s] between them.

    Notes
    -----
    Hann window, fourfold zero padding, and a parabola through the logarithms of the three largest
    lines (``kernel/history_spectrum.c``).
    """
    return history_numbers([values])[0].frequency_hz(interval)


def default_window(length: float) -> float:
    """Return the length [s] of the window at the end of a run of `length` seconds."""
    return min(MAX_WINDOW, 0.5 * length)


def judge_span(
    time: Array,
    histories: Mapping[str, Array],
    window: float | None = None,
    *,
    is_gusty: bool = False,
) -> Motion:
    """Judge the motion of a span or line.

    Parameters
    ----------
    time : ndarray, shape (time,)
        Equally spaced times [s] of the whole run.
    histories
        Displacements [m] by name over the whole run; those whose names end in ``twist`` are
        rotations [rad] and show if a section turned over.
    window
        Length [s] of the window at the end of the run (default: `default_window`).
    is_gusty
        The wind is gusty: the motion is random, not steady, and has statistics only.
    """
    if len(time) < 2:
        return Motion("undetermined", "one record")
    whole = np.stack(list(histories.values()))
    ends = history_sizes(whole)[:, :2]
    if not np.isfinite(ends).all():
        return Motion("undetermined", "not finite")
    interval = float(time[1] - time[0])
    window = default_window(float(time[-1] - time[0])) if window is None else window
    last = slice(max(0, len(time) - 1 - round(window / interval)), None)
    late = np.ascontiguousarray(whole[:, last])
    motions, sizes = dict[str, Motion](), dict[str, float]()
    for name, values, numbers in zip(
        histories, late, history_numbers(late, STEADY_RANGE), strict=True
    ):
        lever = TWIST_LEVER if name.endswith("twist") else 1.0
        motions[name] = judge_numbers(
            values, numbers, interval, REST_AMPLITUDE / lever, is_gusty=is_gusty
        )
        sizes[name] = lever * (numbers.highest - numbers.lowest)
    counted = [
        name
        for name, motion in motions.items()
        if motion.kind == "still growing" or sizes[name] >= STEADY_RANGE * max(sizes.values())
    ]
    found = Motion("at rest")
    if counted:
        name = min(counted, key=lambda name: (KINDS.index(motions[name].kind), -sizes[name]))
        found = motions[name]
        if found.detail:
            found = replace(found, detail=f"{name} {found.detail}")
    turned = {
        name: values
        for (name, values), (low, high) in zip(histories.items(), ends.tolist(), strict=True)
        if name.endswith("twist") and high - low > TURNED_OVER  # a turn needs this range
    }
    return _first_turned_over(time, turned, last, found)


def _first_turned_over(
    time: Array, histories: Mapping[str, Array], last: slice, then: Motion
) -> Motion:
    """Return the given motion, or "turned over" by the first twist that rotated by half a turn."""
    for name, values in histories.items():
        turned = _turned_over(time, values, last, then)
        if turned is not then:
            place = name.removesuffix("twist").strip()
            return replace(turned, detail=f"in {place}, {turned.detail}") if place else turned
    return then


def _turned_over(time: Array, twist: Array, last: slice, then: Motion) -> Motion:
    """Return the given motion, or "turned over" if the section rotated by half a turn before."""
    rotation = np.abs(twist - twist[0])
    if not np.max(rotation) > TURNED_OVER:
        return then
    after, mean = (
        float(time[int(np.argmax(rotation > TURNED_OVER))]),
        float(abs(np.mean(twist[last]) - twist[0])),
    )
    angle = f"by {math.degrees(mean):.0f} deg"
    if mean < TURNED_OVER:
        angle = f"by up to {math.degrees(float(np.max(rotation))):.0f} deg"
    return Motion("turned over", f"{angle} after {after:.3g} s, then {then}", then.rate)


def judge(
    values: Array, interval: float, floor: float = REST_AMPLITUDE, *, is_gusty: bool = False
) -> Motion:
    """Judge one channel over a window.

    Parameters
    ----------
    values : ndarray, shape (time,)
        Equally spaced samples over the window.
    interval
        Time [s] between them.
    floor
        Amplitude below which a motion without growth is at rest, in the unit of the values.
    is_gusty
        The wind is gusty: a motion with enough cycles is random.
    """
    (numbers,) = history_numbers([values], STEADY_RANGE)
    return judge_numbers(values, numbers, interval, floor, is_gusty=is_gusty)


def judge_numbers(
    values: Array, numbers: HistoryNumbers, interval: float, floor: float, *, is_gusty: bool
) -> Motion:
    """Judge one channel over a window, from its numbers.

    Parameters
    ----------
    values, interval, floor, is_gusty
        As of `judge`.
    numbers
        Its numbers, for `STEADY_RANGE`.
    """
    size, length = 0.5 * (numbers.highest - numbers.lowest), (len(values) - 1) * interval
    if not math.isfinite(size):
        return Motion("undetermined", "not finite")
    if size <= ROUND_OFF:
        return Motion("at rest")
    frequency = numbers.frequency_hz(interval)
    sparse = numbers.frequency * MIN_RECORDS_PER_CYCLE > 1.0
    if is_gusty and size >= floor and frequency * length >= MIN_CYCLES:
        return _judge_random(values)
    if frequency * length >= MIN_CYCLES and not sparse:
        motion = _judge_cycles(values, numbers, length)
        if size >= floor or motion.kind == "still growing":
            return motion
    if size < floor:
        return Motion("at rest")
    if sparse:
        return Motion("undetermined", f"{1.0 / numbers.frequency:.1f} records in a cycle")
    counted = f"{frequency * length:.1f} cycles" if math.isfinite(frequency) else "no cycle"
    return Motion("undetermined", f"{counted} in {length:.3g} s; {MIN_CYCLES} are needed")


def _judge_random(values: Array) -> Motion:
    """Judge a motion in gusty wind: its statistics, and how much they differ within the window."""
    differ = _difference(*(float(np.std(half)) for half in np.array_split(values, 2)))
    return Motion("random", f"standard deviations in halves of the window differ by {differ:.0%}")


def _difference(first: float, last: float) -> float:
    """Return the difference of two positive numbers, relative to the larger one."""
    return 1.0 - min(first, last) / max(first, last)


def _judge_cycles(values: Array, numbers: HistoryNumbers, length: float) -> Motion:
    """Judge an oscillation over a window of `length` [s]."""
    before, after = numbers.log_2 - numbers.log_1, numbers.log_3 - numbers.log_2
    if max(abs(before), abs(after)) > FLAT_CHANGE and numbers.trend >= TREND_SHARE:
        if _settles(before, after) and abs(numbers.log_3) <= STEADY_RANGE:
            return Motion("steady")
        return _trend(numbers, length)
    if numbers.range <= STEADY_RANGE:
        return _hidden_growth(numbers, length) or Motion("steady")
    if beat_share(values, numbers) >= BEAT_SHARE:
        return Motion("beating", f"cycles differ by {numbers.fall:.0%}")
    halves = _difference(numbers.half_1, numbers.half_2)
    return Motion(
        "irregular",
        f"cycles differ by {numbers.fall:.0%}, the halves of the window by {halves:.0%}",
    )


def _trend(numbers: HistoryNumbers, length: float) -> Motion:
    """Return growth or decay: the rate of the last thirds, or of all if they differ in sign."""
    sizes, longer = divmod(int(numbers.blocks), 3)
    first, second, third = (sizes + (k < longer) for k in range(3))
    spacing = numbers.spacing * length
    whole = numbers.log_3 - numbers.log_1
    last = numbers.log_3 - numbers.log_2
    if last * whole > 0.0:
        rate = last / (0.5 * (second + third) * spacing)
    else:
        rate = whole / ((0.5 * (first + third) + second) * spacing)
    return Motion("still growing" if rate > 0.0 else "decaying", _rate_text(rate), rate)


def _settles(before: float, after: float) -> bool:
    """Check that the mean amplitude changes by at most `REMAINING_CHANGE` after the window.

    `before` and `after` are the differences of the logarithms of the thirds.
    """
    if before * after <= 0.0:
        return abs(after) <= min(REMAINING_CHANGE, abs(before))
    factor = after / before
    return factor < MAX_FACTOR and abs(after) * factor / (1.0 - factor) <= REMAINING_CHANGE


def _hidden_growth(numbers: HistoryNumbers, length: float) -> Motion | None:
    """Return a motion with a growing part that does not repeat from cycle to cycle, or None."""
    first, second, third = numbers.hidden_1, numbers.hidden_2, numbers.hidden_3
    if third < HIDDEN_SHARE or not first * HIDDEN_GROWTH < second < third / HIDDEN_GROWTH:
        return None
    rate = math.log(third / second) / (length / 3.0)
    return Motion(
        "still growing",
        f"a part, now {third:.2g} of the amplitude, by {_rate_text(rate)}",
        rate,
    )


def _rate_text(rate: float) -> str:
    """Return a growth rate [1/s] in words."""
    if 60.0 * rate >= math.log(2.0):
        return f"doubling in {math.log(2.0) / rate:.2g} s"
    if 60.0 * rate <= -math.log(2.0):
        return f"halving in {-math.log(2.0) / rate:.2g} s"
    percent = 100.0 * math.expm1(60.0 * rate)
    return f"{percent:+.0f} %/min" if abs(percent) >= 9.5 else f"{percent:+.2g} %/min"
