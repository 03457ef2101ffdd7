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
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

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

MAX_BLOCKS = 18
"""Maximum number of blocks of one to four cycles for a trend."""

MAX_WINDOW = 100.0
"""Default length [s] of the window at the end of a run, at most half of the run."""

SAMPLES_PER_CYCLE = 64
"""Minimum number of samples in a cycle for extremes by a parabola."""
MIDPOINT_WEIGHTS = np.array([3.0, -25.0, 150.0, 150.0, -25.0, 3.0]) / 256.0
"""Weights of six samples for the value midway between the third and the fourth."""

_NEIGHBOURS = np.array([[-1], [0], [1]])

DEPENDENT = 1e-13
"""Singular value, relative to the largest, of waves that depend linearly on others."""

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
    lines.
    """
    line = _largest_line(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return math.nan if math.isnan(line) else line / (4 * len(values) * interval)


@lru_cache(maxsize=8)  # a summary measures the channels that it has judged
def _largest_line(samples: bytes) -> float:
    """Return the place of the largest line in the spectrum; NaN without one."""
    values = np.frombuffer(samples)
    if len(values) < MIN_SAMPLES:
        return math.nan
    low, high = float(values.min()), float(values.max())
    if not high - low > 1e-12 * max(1.0, -low, high):
        return math.nan
    spectrum = np.abs(np.fft.rfft((values - _mean(values)) * hann(len(values)), 4 * len(values)))
    peak = int(spectrum[1:-1].argmax()) + 1
    below, top, above = np.log(spectrum[peak - 1 : peak + 2] + 1e-300).tolist()
    curvature = below - 2.0 * top + above
    if not curvature < 0.0:  # no peak: motion at the ends only, where the window is zero
        return math.nan
    return float(peak + 0.5 * (below - above) / curvature)


@lru_cache(maxsize=8)
def hann(count: int) -> Array:
    """Return Hann's window of `count` samples, which cannot be written."""
    window = np.hanning(count)
    window.flags.writeable = False
    return window


def _mean(values: Array) -> float:
    """Return the mean of samples as ``np.mean``, which takes longer to call."""
    return float(np.add.reduce(values) / len(values))


def _parts(values: Array, count: int) -> list[Array]:
    """Return a number of parts of nearly equal length, the longer first."""
    size, longer = divmod(len(values), count)
    ends = [(k + 1) * size + min(k + 1, longer) for k in range(count)]
    return [values[start:stop] for start, stop in zip([0, *ends], ends, strict=False)]


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
    if not all(np.isfinite(values).all() for values in histories.values()):
        return Motion("undetermined", "not finite")
    interval = float(time[1] - time[0])
    window = default_window(float(time[-1] - time[0])) if window is None else window
    last = slice(max(0, len(time) - 1 - round(window / interval)), None)
    motions, sizes = dict[str, Motion](), dict[str, float]()
    for name, values in histories.items():
        lever = TWIST_LEVER if name.endswith("twist") else 1.0
        motions[name] = judge(values[last], interval, REST_AMPLITUDE / lever, is_gusty=is_gusty)
        sizes[name] = lever * float(values[last].max() - values[last].min())
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
    return _first_turned_over(time, histories, last, found)


def _first_turned_over(
    time: Array, histories: Mapping[str, Array], last: slice, then: Motion
) -> Motion:
    """Return the given motion, or "turned over" by the first twist that rotated by half a turn."""
    for name, values in histories.items():
        turned = _turned_over(time, values, last, then) if name.endswith("twist") else then
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
    values: Array,
    interval: float,
    floor: float = REST_AMPLITUDE,
    frequency_hz: float | None = None,
    *,
    is_gusty: bool = False,
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
    frequency_hz
        `dominant_frequency` of the values, if known.
    is_gusty
        The wind is gusty: a motion with enough cycles is random.
    """
    values = np.asarray(values, dtype=np.float64)
    low, high, length = float(values.min()), float(values.max()), (len(values) - 1) * interval
    size = 0.5 * (high - low)
    if not math.isfinite(size):
        return Motion("undetermined", "not finite")
    if size <= ROUND_OFF:
        return Motion("at rest")
    frequency = dominant_frequency(values, interval) if frequency_hz is None else frequency_hz
    sparse = frequency * interval * MIN_RECORDS_PER_CYCLE > 1.0
    if is_gusty and size >= floor and frequency * length >= MIN_CYCLES:
        return _judge_random(values)
    if frequency * length >= MIN_CYCLES and not sparse:
        finer, period = _finer((values - 0.5 * (low + high)) / size, 1.0 / (frequency * interval))
        motion = _judge_cycles(finer, period, length)
        if size >= floor or motion.kind == "still growing":
            return motion
    if size < floor:
        return Motion("at rest")
    if sparse:
        return Motion("undetermined", f"{1.0 / (frequency * interval):.1f} records in a cycle")
    counted = f"{frequency * length:.1f} cycles" if math.isfinite(frequency) else "no cycle"
    return Motion("undetermined", f"{counted} in {length:.3g} s; {MIN_CYCLES} are needed")


def _judge_random(values: Array) -> Motion:
    """Judge a motion in gusty wind: its statistics, and how much they differ within the window."""
    first, last = (float(np.std(half)) for half in _parts(values, 2))
    differ = 1.0 - min(first, last) / max(first, last)
    return Motion("random", f"standard deviations in halves of the window differ by {differ:.0%}")


def _judge_cycles(values: Array, period: float, length: float) -> Motion:
    """Judge an oscillation between -1 and 1; `period` in samples, `length` of the window in s."""
    cycles = min(max(int(len(values) / (MAX_BLOCKS * period)), 1), 4)
    envelope_of = cache(partial(_envelope, values, period))
    logs = np.log(np.maximum(envelope_of(cycles), 1e-300))
    first, second, third = _means_of_thirds(logs)
    before, after = second - first, third - second
    if max(abs(before), abs(after)) > FLAT_CHANGE and _share_of_parabola(logs) >= TREND_SHARE:
        if _settles(before, after) and abs(third) <= STEADY_RANGE:
            return Motion("steady")
        start, then, now = _means_of_thirds(
            np.arange(len(logs)) * cycles * period * length / (len(values) - 1)
        )
        rate = (
            after / (now - then)
            if after * (third - first) > 0.0
            else (third - first) / (now - start)
        )
        return Motion("still growing" if rate > 0.0 else "decaying", _rate_text(rate), rate)
    if _is_even(len(values), period, envelope_of):
        return _hidden_growth(values, period, length) or Motion("steady")
    envelope = envelope_of(1)
    fall = 1.0 - float(envelope.min() / envelope.max())
    if _share_of_beats(envelope) >= BEAT_SHARE:
        return Motion("beating", f"cycles differ by {fall:.0%}")
    first, last = (0.5 * float(half.max() - half.min()) for half in _parts(values, 2))
    halves = 1.0 - min(first, last) / max(first, last)
    return Motion(
        "irregular", f"cycles differ by {fall:.0%}, the halves of the window by {halves:.0%}"
    )


def _finer(values: Array, period: float) -> tuple[Array, float]:
    """Interpolate a motion to at least `SAMPLES_PER_CYCLE`; return it and its period in samples."""
    while period < SAMPLES_PER_CYCLE and len(values) > MIN_SAMPLES:
        middle = np.convolve(values, MIDPOINT_WEIGHTS, "valid")
        values = np.stack([values[2:-3], middle], axis=1).ravel()
        period *= 2.0
    return values, period


def _envelope(values: Array, period: float, cycles: int) -> Array:
    """Return half peak-to-peak of blocks of `cycles` cycles, which overlap by a quarter cycle."""
    size = math.ceil((cycles + 0.25) * period) + 1
    starts = np.arange(0.0, len(values) - size + 0.5, cycles * period).astype(int)
    blocks = values[starts[:, None] + np.arange(size)]
    peaks = _peaks(np.concatenate([blocks, -blocks]))
    return 0.5 * (peaks[: len(blocks)] + peaks[len(blocks) :])


def _peaks(blocks: Array) -> Array:
    """Return the maximum of each row, refined by a parabola through its neighbours."""
    rows, highest = np.arange(len(blocks)), blocks.argmax(axis=1)
    at = np.minimum(np.maximum(highest, 1), blocks.shape[1] - 2)
    below, top, above = blocks[rows, at + _NEIGHBOURS]
    curvature, slope = below - 2.0 * top + above, 0.5 * (above - below)
    inside = (curvature < 0.0) & (np.abs(slope) <= -curvature)
    rise = np.where(inside, -0.5 * slope**2 / np.where(inside, curvature, 1.0), 0.0)
    return np.asarray(np.maximum(blocks[rows, highest], top + rise))


def _means_of_thirds(values: Array) -> list[float]:
    return [_mean(part) for part in _parts(values, 3)]


def _share_of_parabola(values: Array) -> float:
    """Return the share of the variance that a parabola explains."""
    x = np.linspace(-1.0, 1.0, len(values))
    bend = x**2 - _mean(x**2)  # orthogonal to 1 and x, as the samples are symmetric
    centred = values - _mean(values)
    explained = sum(float(form @ centred) ** 2 / float(form @ form) for form in (x, bend))
    return explained / float(centred @ centred)


def _settles(before: float, after: float) -> bool:
    """Check that the mean amplitude changes by at most `REMAINING_CHANGE` after the window.

    `before` and `after` are the differences of the logarithms of the thirds.
    """
    if before * after <= 0.0:
        return abs(after) <= min(REMAINING_CHANGE, abs(before))
    factor = after / before
    return factor < MAX_FACTOR and abs(after) * factor / (1.0 - factor) <= REMAINING_CHANGE


def _is_even(count: int, period: float, envelope_of: Callable[[int], Array]) -> bool:
    """Check that the maximum of one, two, three or four cycles is constant over the window."""
    for cycles in range(1, 5):
        if count < (3.0 * cycles + 0.25) * period + 2.0:
            break  # fewer than three
        envelope = envelope_of(cycles)
        if envelope.max() - envelope.min() <= STEADY_RANGE * _mean(envelope):
            return True
    return False


def _hidden_growth(values: Array, period: float, length: float) -> Motion | None:
    """Return a motion with a growing part that does not repeat from cycle to cycle, or None."""
    whole = int(period)
    share, count = period - whole, len(values) - whole - 3
    before, here, after, beyond = (values[whole + k : whole + k + count] for k in range(4))
    # Cubic interpolation in four samples, at `share` between the second and the third.
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
    parts = _parts(later - values[1 : count + 1], 3)
    hidden = [math.sqrt(0.5 * _mean(part**2)) for part in parts]
    if (
        hidden[2] < HIDDEN_SHARE
        or not hidden[0] * HIDDEN_GROWTH < hidden[1] < hidden[2] / HIDDEN_GROWTH
    ):
        return None
    rate = math.log(hidden[2] / hidden[1]) / (length / 3.0)
    return Motion(
        "still growing",
        f"a part, now {hidden[2]:.2g} of the amplitude, by {_rate_text(rate)}",
        rate,
    )


def _share_of_beats(envelope: Array) -> float:
    """Return the share of the variance of an envelope that a spectral line and its double explain.

    The line is between one and a half beats in the window and a third of the number of cycles. The
    share is corrected for the number of unknowns.
    """
    count, unknowns = len(envelope), 5
    if count <= unknowns + 1:
        return 0.0
    centred, x = envelope - _mean(envelope), np.arange(count) / count
    beats = np.arange(1.5, max(count / 3.0, 1.6), 0.25)
    phasors = np.exp(2j * np.pi * beats[:, None] * x)
    strongest = beats[np.argsort(np.abs(phasors @ (centred * hann(count))))[-3:]]
    lines = (strongest[:, None] * [0.5, 0.97, 1.0, 1.03]).ravel()
    angle = 2.0 * np.pi * lines[lines >= 1.5, None] * x
    waves = [f(k * angle) for k in (1, 2) for f in (np.cos, np.sin)]
    basis, size, _ = np.linalg.svd(
        np.stack([np.ones_like(angle), *waves], axis=-1), full_matrices=False
    )
    basis *= (size > DEPENDENT * size[:, :1])[:, None]  # a line and the alias of its double
    residual = centred - (basis @ (basis.mT @ centred)[..., None])[..., 0]
    best = 1.0 - float(np.min(np.var(residual, axis=1)) / np.var(centred))
    return 1.0 - (1.0 - best) * (count - 1) / (count - unknowns - 1)


def _rate_text(rate: float) -> str:
    """Return a growth rate [1/s] in words."""
    if 60.0 * rate >= math.log(2.0):
        return f"doubling in {math.log(2.0) / rate:.2g} s"
    if 60.0 * rate <= -math.log(2.0):
        return f"halving in {-math.log(2.0) / rate:.2g} s"
    percent = 100.0 * math.expm1(60.0 * rate)
    return f"{percent:+.0f} %/min" if abs(percent) >= 9.5 else f"{percent:+.2g} %/min"
