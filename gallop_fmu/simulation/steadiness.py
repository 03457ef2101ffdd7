"""The one judgement of a motion: steady, still growing, decaying, beating, irregular, at rest, or turned over.

A channel is cut into cycles of its dominant frequency. Half of the range of each cycle, with its
extremes refined by a parabola, is the envelope; the judgement follows from how the envelope changes
over the window. The bounds:

`STEADY` (2 %)
    Range of the envelope, per mean, within which a motion is steady: an amplitude is then sure to
    two digits. Cycles may differ if the greatest of every two, three or four does not: such a
    motion repeats itself less often.
`FLAT` (0.2 %)
    Change of the mean envelope from one third of the window to the next that counts as none: some
    ten times the error of the envelope. Growth below 0.4 % a minute, in a window of 100 s, is
    therefore taken as steady.
`LEFT` (1 %)
    Change still to come by which a motion that approaches a limit cycle is steady. It is
    extrapolated from the thirds: on such an approach their differences fall by a constant factor. A
    factor above `UNBOUNDED` (0.9) does not bound the limit: growth from a small disturbance goes on
    to many times the amplitude, however slow it is.
`HIDDEN` (0.1 %) and `FASTER` (1.1)
    A part that does not repeat itself from cycle to cycle makes a motion "still growing" if it has
    this share of the amplitude and grows by this factor from third to third. So a swing grows below
    steady vertical galloping before the transfer of energy. The interpolation between samples
    leaves less than 0.03 %.
`TREND` (0.7) and `REGULAR` (0.9)
    Share of the envelope's variance that a parabola in time must explain for a trend, and a
    spectral line with its double for beats. Narrow-band noise and chaos rarely reach them.
`CYCLES` (9) and `FEWEST_RECORDS` (5.5)
    Fewest cycles in the window, three in each third, and fewest records in a cycle: with five, the
    peaks of a motion with harmonics are missed by 10 %. With fewer than twenty a hidden part must
    be some 1 % to be seen.
`TURNED_OVER` (180 deg)
    Change of the twist since the start from which on the section has turned over: the ice is on the
    other side.
`SMALL` (0.1 mm)
    Amplitude below which a motion that does not grow is at rest; of a twist, which counts with a
    lever of 0.1 m, 0.06 deg. `NOTHING` (1e-9 m) is rounding.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Kind = Literal[
    "turned over",
    "still growing",
    "irregular",
    "undetermined",
    "beating",
    "decaying",
    "steady",
    "at rest",
]

STEADY = 0.02
FLAT = 0.002
LEFT = 0.01
UNBOUNDED = 0.9
HIDDEN = 0.001
FASTER = 1.1
TREND = 0.7
REGULAR = 0.9
CYCLES = 9
FEWEST_RECORDS = 5.5
TURNED_OVER = math.pi
SMALL = 1e-4
NOTHING = 1e-9
LEVER = 0.1

KINDS: tuple[Kind, ...] = get_args(Kind)
"""The kind of a span is the first of those of its channels."""

BLOCKS = 18
"""Blocks of the window from which a trend is found, each of one to four cycles."""

LONGEST_WINDOW = 100.0
"""Length [s] of the window at the end of a run, at most half of the run, where no other is asked for."""

SAMPLES = 64
"""Samples in a cycle with which a parabola finds its extremes."""
SIXTH_ORDER = np.array([3.0, -25.0, 150.0, 150.0, -25.0, 3.0]) / 256.0
"""Weights of six samples for the value half-way between the third and the fourth."""

FEWEST_SAMPLES = 8
"""Below it no spectral line is told from another."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What a motion does over a window.

    Attributes
    ----------
    kind : str
        ``"steady"``, ``"still growing"``, ``"decaying"``, ``"beating"``, ``"irregular"``, ``"at
        rest"``, ``"turned over"`` (the section, at some time of the run), or ``"undetermined"``
        (too few cycles).
    detail : str
        The numbers behind it, such as ``"vertical +12 %/min"``; empty where there are none.
    rate : float
        Rate [1/s] at which the amplitude, or the part of it that grows, does so; NaN where it does
        not.
    """

    kind: Kind
    detail: str = ""
    rate: float = math.nan

    @property
    def is_steady(self) -> bool:
        """Whether an amplitude stands for this motion without a further word: steady, or at rest."""
        return self.kind in ("steady", "at rest")

    def __str__(self) -> str:
        if self.kind == "turned over":
            return f"turned over {self.detail}"
        return f"{self.kind} ({self.detail})" if self.detail else self.kind


def dominant_frequency(values: Array, interval: float) -> float:
    """Frequency [Hz] of the largest spectral line; NaN where there is none.

    That is so for a channel that does not move, and for fewer than `FEWEST_SAMPLES` samples.

    Parameters
    ----------
    values : ndarray, shape (time,)
        Samples.
    interval
        Time [s] between them.

    Notes
    -----
    Hann window, fourfold zero padding, and a parabola through the logarithms of the three largest
    lines.
    """
    if len(values) < FEWEST_SAMPLES or not np.ptp(values) > 1e-12 * max(
        1.0, float(np.max(np.abs(values)))
    ):
        return math.nan
    samples = (values - np.mean(values)) * np.hanning(len(values))
    count = 4 * len(samples)
    spectrum = np.abs(np.fft.rfft(samples, count))
    peak = int(np.argmax(spectrum[1:-1])) + 1
    below, top, above = np.log(spectrum[peak - 1 : peak + 2] + 1e-300)
    curvature = below - 2.0 * top + above
    if (
        not curvature < 0.0
    ):  # no line stands out: what moved did so at the ends only, where the window is zero
        return math.nan
    return float((peak + 0.5 * (below - above) / curvature) / (count * interval))


def default_window(length: float) -> float:
    """Length [s] of the window at the end of a run of so many seconds."""
    return min(LONGEST_WINDOW, 0.5 * length)


def judge_span(time: Array, histories: Mapping[str, Array], window: float | None = None) -> Motion:
    """Judge the motion of a span.

    Parameters
    ----------
    time : ndarray, shape (time,)
        Equally spaced times [s] of the whole run.
    histories
        Displacements [m] by name over the whole run, of which ``"twist"`` [rad] shows whether the
        section turned over.
    window
        Length [s] of the window at the end of the run; None takes `default_window`.
    """
    if len(time) < 2:
        return Motion("undetermined", "one record")
    if not all(np.isfinite(values).all() for values in histories.values()):
        return Motion("undetermined", "not finite")
    interval = float(time[1] - time[0])
    window = default_window(float(time[-1] - time[0])) if window is None else window
    last = slice(max(0, len(time) - 1 - round(window / interval)), None)
    motions, sizes = dict[str, Motion](), dict[str, float]()
    for name, values in histories.items():
        lever = LEVER if name == "twist" else 1.0
        motions[name] = judge(values[last], interval, SMALL / lever)
        sizes[name] = lever * float(np.ptp(values[last]))
    counted = [
        name
        for name, motion in motions.items()
        if motion.kind == "still growing" or sizes[name] >= STEADY * max(sizes.values())
    ]
    found = Motion("at rest")
    if counted:
        name = min(counted, key=lambda name: (KINDS.index(motions[name].kind), -sizes[name]))
        found = motions[name]
        if found.detail:
            found = replace(found, detail=f"{name} {found.detail}")
    return _turned_over(time, histories["twist"], last, found) if "twist" in histories else found


def _turned_over(time: Array, twist: Array, last: slice, then: Motion) -> Motion:
    """The same motion, or that the section has turned over before it."""
    turn = np.abs(twist - twist[0])
    if not np.max(turn) > TURNED_OVER:
        return then
    after, mean = (
        float(time[int(np.argmax(turn > TURNED_OVER))]),
        float(abs(np.mean(twist[last]) - twist[0])),
    )
    angle = f"by {math.degrees(mean):.0f} deg"
    if mean < TURNED_OVER:
        angle = f"by up to {math.degrees(float(np.max(turn))):.0f} deg"
    return Motion("turned over", f"{angle} after {after:.3g} s, then {then}", then.rate)


def judge(
    values: Array, interval: float, floor: float = SMALL, frequency_hz: float | None = None
) -> Motion:
    """Judge one channel over a window.

    Parameters
    ----------
    values : ndarray, shape (time,)
        Equally spaced samples over the window.
    interval
        Time [s] between them.
    floor
        Amplitude below which a motion that does not grow is at rest, in the unit of the values.
    frequency_hz
        `dominant_frequency` of the values, where it is known already.
    """
    values = np.asarray(values, dtype=np.float64)
    low, high, length = float(np.min(values)), float(np.max(values)), (len(values) - 1) * interval
    size = 0.5 * (high - low)
    if not math.isfinite(size):
        return Motion("undetermined", "not finite")
    if size <= NOTHING:
        return Motion("at rest")
    frequency = dominant_frequency(values, interval) if frequency_hz is None else frequency_hz
    sparse = frequency * interval * FEWEST_RECORDS > 1.0
    if frequency * length >= CYCLES and not sparse:
        finer, period = _finer((values - 0.5 * (low + high)) / size, 1.0 / (frequency * interval))
        motion = _judge_cycles(finer, period, length)
        if size >= floor or motion.kind == "still growing":
            return motion
    if size < floor:
        return Motion("at rest")
    if sparse:
        return Motion("undetermined", f"{1.0 / (frequency * interval):.1f} records in a cycle")
    counted = f"{frequency * length:.1f} cycles" if math.isfinite(frequency) else "no cycle"
    return Motion("undetermined", f"{counted} in {length:.3g} s; {CYCLES} are needed")


def _judge_cycles(values: Array, period: float, length: float) -> Motion:
    """Judge an oscillation between -1 and 1, with its period in samples and the length of its window [s]."""
    cycles = min(max(int(len(values) / (BLOCKS * period)), 1), 4)
    logs = np.log(np.maximum(_envelope(values, period, cycles), 1e-300))
    first, second, third = _means_of_thirds(logs)
    mean_time = _means_of_thirds(
        np.arange(len(logs)) * cycles * period * length / (len(values) - 1)
    )
    before, after = second - first, third - second
    if max(abs(before), abs(after)) > FLAT and _share_of_parabola(logs) >= TREND:
        if _settles(before, after) and abs(third) <= STEADY:
            return Motion("steady")
        start, then, now = mean_time
        rate = (
            after / (now - then)
            if after * (third - first) > 0.0
            else (third - first) / (now - start)
        )
        return Motion("still growing" if rate > 0.0 else "decaying", _rate_text(rate), rate)
    if _is_even(values, period):
        return _hidden_growth(values, period, length) or Motion("steady")
    envelope = _envelope(values, period)
    fall = 1.0 - float(np.min(envelope) / np.max(envelope))
    if _share_of_beats(envelope) >= REGULAR:
        return Motion("beating", f"cycles differ by {fall:.0%}")
    first, last = (0.5 * float(np.ptp(half)) for half in np.array_split(values, 2))
    halves = 1.0 - min(first, last) / max(first, last)
    return Motion(
        "irregular", f"cycles differ by {fall:.0%}, the halves of the window by {halves:.0%}"
    )


def _finer(values: Array, period: float) -> tuple[Array, float]:
    """The same motion and its period in samples, at `SAMPLES` a cycle or more: halves of intervals by six samples."""
    while period < SAMPLES and len(values) > FEWEST_SAMPLES:
        middle = np.convolve(values, SIXTH_ORDER, "valid")
        values = np.stack([values[2:-3], middle], axis=1).ravel()
        period *= 2.0
    return values, period


def _envelope(values: Array, period: float, cycles: int = 1) -> Array:
    """Half peak-to-peak of each `cycles` cycles, overlapping by a quarter of one so that none misses its peak."""
    size = math.ceil((cycles + 0.25) * period) + 1
    starts = np.arange(0.0, len(values) - size + 0.5, cycles * period).astype(int)
    blocks = values[starts[:, None] + np.arange(size)]
    return 0.5 * (_peaks(blocks) + _peaks(-blocks))


def _peaks(blocks: Array) -> Array:
    """Greatest value of each row, by a parabola through its neighbours."""
    at = np.clip(blocks.argmax(axis=1), 1, blocks.shape[1] - 2)
    below, top, above = (blocks[np.arange(len(blocks)), at + k] for k in (-1, 0, 1))
    bend, slope = below - 2.0 * top + above, 0.5 * (above - below)
    inside = (bend < 0.0) & (np.abs(slope) <= -bend)
    lift = np.where(inside, -0.5 * slope**2 / np.where(inside, bend, 1.0), 0.0)
    return np.asarray(np.maximum(blocks.max(axis=1), top + lift))


def _means_of_thirds(values: Array) -> list[float]:
    return [float(np.mean(part)) for part in np.array_split(values, 3)]


def _share_of_parabola(values: Array) -> float:
    """Share of the variance that a parabola explains."""
    place = np.linspace(-1.0, 1.0, len(values))
    left = values - np.polynomial.Polynomial.fit(place, values, 2)(place)
    return 1.0 - float(np.var(left) / np.var(values))


def _settles(before: float, after: float) -> bool:
    """Whether the mean amplitude ends within `LEFT` of where it is, by the differences of the thirds' logarithms."""
    if before * after <= 0.0:
        return abs(after) <= min(LEFT, abs(before))
    factor = after / before
    return factor < UNBOUNDED and abs(after) * factor / (1.0 - factor) <= LEFT


def _is_even(values: Array, period: float) -> bool:
    """Whether the greatest of one, two, three or four cycles is the same over the window."""
    for cycles in range(1, 5):
        if len(values) < (3.0 * cycles + 0.25) * period + 2.0:
            break  # fewer than three
        envelope = _envelope(values, period, cycles)
        if np.ptp(envelope) <= STEADY * np.mean(envelope):
            return True
    return False


def _hidden_growth(values: Array, period: float, length: float) -> Motion | None:
    """A part that does not repeat itself from cycle to cycle, and grows."""
    whole = int(period)
    share, count = period - whole, len(values) - whole - 3
    before, here, after, beyond = (values[whole + k : whole + k + count] for k in range(4))
    # A cubic through four samples, at `share` of the way from the second to the third.
    later = here + 0.5 * share * (
        after
        - before
        + share
        * (
            2.0 * before
            - 5.0 * here
            + 4.0 * after
            - beyond
            + share * (3.0 * (here - after) + beyond - before)
        )
    )
    parts = np.array_split(later - values[1 : count + 1], 3)
    hidden = [math.sqrt(0.5 * float(np.mean(part**2))) for part in parts]
    if hidden[2] < HIDDEN or not hidden[0] * FASTER < hidden[1] < hidden[2] / FASTER:
        return None
    rate = math.log(hidden[2] / hidden[1]) / (length / 3.0)
    return Motion(
        "still growing",
        f"a part, now {hidden[2]:.2g} of the amplitude, by {_rate_text(rate)}",
        rate,
    )


def _share_of_beats(envelope: Array) -> float:
    """Share of the variance of an envelope that a line of the spectrum and its double explain, less what chance does.

    The line lies between one and a half beats in the window and a third of the number of cycles.
    """
    count, unknowns = len(envelope), 5
    if count <= unknowns + 1:
        return 0.0
    centred, place = envelope - np.mean(envelope), np.arange(count) / count
    beats = np.arange(1.5, max(count / 3.0, 1.6), 0.25)
    turns = np.exp(2j * np.pi * beats[:, None] * place)
    strongest = beats[np.argsort(np.abs(turns @ (centred * np.hanning(count))))[-3:]]
    best = 0.0
    for line in (strongest[:, None] * [0.5, 0.97, 1.0, 1.03]).ravel():
        if line < 1.5:
            continue
        angle = 2.0 * np.pi * line * place[:, None]
        waves = np.hstack(
            [np.ones_like(angle), *(f(k * angle) for k in (1, 2) for f in (np.cos, np.sin))]
        )
        left = centred - waves @ np.linalg.lstsq(waves, centred, rcond=None)[0]
        best = max(best, 1.0 - float(np.var(left) / np.var(centred)))
    return 1.0 - (1.0 - best) * (count - 1) / (count - unknowns - 1)


def _rate_text(rate: float) -> str:
    """A rate of growth [1/s] in words."""
    if 60.0 * rate >= math.log(2.0):
        return f"doubling in {math.log(2.0) / rate:.2g} s"
    if 60.0 * rate <= -math.log(2.0):
        return f"halving in {-math.log(2.0) / rate:.2g} s"
    percent = 100.0 * math.expm1(60.0 * rate)
    return f"{percent:+.0f} %/min" if abs(percent) >= 9.5 else f"{percent:+.2g} %/min"
