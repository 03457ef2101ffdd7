"""Stable states of a line in its wind: what is known of each, and how histories become a state."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal.motions.line_model import MIN_PART, MIN_SWING, LineModel
from modal.motions.motion_words import TURNED_OVER
from modal.motions.trend import have_trend
from modal.screening.cycles import StateKind

Array = NDArray[np.float64]

WINDOWS = 40
"""Number of equal windows in which amplitudes are compared."""

MAX_CHANGE, MAX_BEAT = 0.05, 0.05
"""Change of an amplitude between both halves, and variation within them, relative to the largest
amplitude, up to which a motion has settled, and up to which it is periodic."""

MAX_WANDER = 0.12
"""The first of them for a motion that beats: its largest amplitudes never repeat exactly."""

MAX_DRIFT = 0.02
"""Change of an amplitude from each third to the next, in the same sense, relative to the largest
amplitude, up to which a motion has settled."""

MAX_GROWTH, MIN_GROWING = 1.15, 0.01
"""Growth of a part of the motion between both halves, above which it has not settled if the part is
this large, relative to the largest amplitude."""

CALM = 2e-3
"""Amplitude [m] below which a simulated line is at rest."""

MIN_HALF = 5e-3
"""Amplitude [m] at half the vertical frequency from which a swing is named."""

MIN_HALF_PART = 0.02
"""The same, relative to the largest amplitude."""

TORSION = "bundle torsion"

MIN_TORSION = 0.3
"""Amplitude [rad] of the rotation from which it is named beside a larger motion."""

MIN_ALIKE = 0.7
"""Correlation of two spans above which they move in phase, or against each other if negative."""


@dataclass(frozen=True)
class LineState:
    """A stable state of a line in its wind: equilibrium or motion, by a simulation.

    Sequences are over spans, of each the phases in turn. Amplitudes are half peak-to-peak, of a
    bundle those of its centre.

    Attributes
    ----------
    name : str
        The state in words, such as "one loop with string swing at half frequency".
    kind : {"rest", "periodic", "beating", "not settled"}
        ``"beating"``: amplitudes vary; those given are the largest. ``"not settled"``: they still
        changed at the end of the simulation.
    vertical, horizontal : tuple of float
        Amplitudes [m] at mid-span.
    quarter : tuple of float
        Amplitudes [m] of the antisymmetric vertical motion at the quarter points.
    peak_to_peak : tuple of float
        Largest vertical displacement, peak to peak [m], of mid-span and the quarter points.
    rotation, mean_rotation : tuple of float
        Amplitude and mean [rad] of the rotation at mid-span: of the bundle, or of a single
        conductor.
    clamp : tuple of float
        Amplitude [m] of each clamp that hangs from strings, across the line.
    radius : float
        Mean distance [m] of subconductors from the centre of their bundle; 0 without bundles.
    frequency_hz : float or None
        Frequency [Hz] of the vertical motion; None at rest.
    has_swing : bool
        True if spans or strings swing at half the vertical frequency.
    """

    name: str
    kind: StateKind
    vertical: tuple[float, ...]
    horizontal: tuple[float, ...]
    quarter: tuple[float, ...]
    peak_to_peak: tuple[float, ...]
    rotation: tuple[float, ...]
    mean_rotation: tuple[float, ...]
    clamp: tuple[float, ...]
    radius: float
    frequency_hz: float | None
    has_swing: bool

    @property
    def largest(self) -> float:
        """Largest of the displacement amplitudes [m]."""
        return float(np.max(self.displacements))

    @property
    def is_turned_over(self) -> bool:
        """True if the ice, or a bundle, has turned by more than 90 degrees."""
        return self.name.endswith("turned over")

    @property
    def displacements(self) -> Array:
        """All amplitudes [m] in one array; that of a bundle's rotation is at its subconductors."""
        turned = [self.radius * one for one in self.rotation]
        parts = (self.vertical, self.horizontal, self.quarter, self.clamp, turned)
        return np.array([value for part in parts for value in part])

    def __str__(self) -> str:
        if self.kind == "rest":
            return f"{self.name} (mean rotation {math.degrees(self._turned):.0f} deg)"
        sizes = f"{max(self.peak_to_peak):.3g} m vertical, peak to peak"
        if self.clamp and max(self.clamp) > MIN_SWING * self.largest:
            sizes += f"; clamps {2.0 * max(self.clamp):.3g} m across the line"
        if max(self.rotation) > MIN_TORSION:
            sizes += f"; rotation {2.0 * math.degrees(max(self.rotation)):.0f} deg"
        kind = "" if self.kind == "periodic" else f", {self.kind}"
        return f"{self.name}{kind} ({sizes})"

    @property
    def _turned(self) -> float:
        return max(self.mean_rotation, key=abs)


@dataclass(frozen=True)
class Histories:
    """Motion over time at the places that are looked at: (time, bundle) and (time, clamp).

    Attributes
    ----------
    u2 : ndarray, shape (time, bundle, 3)
        Vertical displacement [m] at a quarter, at mid-span and at three quarters.
    u3, rotation : ndarray, shape (time, bundle)
        Horizontal displacement [m] and rotation [rad] at mid-span.
    clamp : ndarray, shape (time, clamp)
        Displacement [m] of clamps across the line.
    interval : float
        Time [s] between two records.
    """

    u2: Array
    u3: Array
    rotation: Array
    clamp: Array
    interval: float

    @property
    def quarter(self) -> Array:
        """Antisymmetric vertical displacement [m] at the quarter points."""
        return np.asarray(0.5 * (self.u2[:, :, 0] - self.u2[:, :, 2]))

    def last(self, part: float) -> Histories:
        """The last part of them."""
        first = round((1.0 - part) * len(self.u2))
        return Histories(
            self.u2[first:],
            self.u3[first:],
            self.rotation[first:],
            self.clamp[first:],
            self.interval,
        )


def histories(model: LineModel, values: Array, interval: float) -> Histories:
    """Order the records (record, channel, node) of `LineModel.watched_nodes`.

    Parameters
    ----------
    model
        The line.
    values
        u2, u3 and theta.
    interval
        Time [s] between two records.
    """
    line = model.mesh.model.map
    moves = model.watched(values)
    along = values[:, :, : 3 * len(line.chains)].reshape(
        *values.shape[:2], -1, line.subconductors, 3
    )
    rotation = moves.theta
    if line.subconductors > 1:
        rotation = _rotation(model, along[:, :2, :, :, 1])
    return Histories(along[:, 0].mean(axis=2), moves.u3, rotation, moves.clamp, interval)


def _rotation(model: LineModel, middle: Array) -> Array:
    """Rotation [rad] (time, bundle) of displacements (time, axis, bundle, subconductor).

    The angle that fits best is atan2(sum r x p, sum r.p), for places r before and p after.
    """
    r = _places(model)
    p = r + middle - middle.mean(axis=3, keepdims=True)
    cross = (r[0] * p[:, 1] - r[1] * p[:, 0]).sum(axis=2)
    dot = (r[0] * p[:, 0] + r[1] * p[:, 1]).sum(axis=2)
    return np.asarray(np.unwrap(np.arctan2(cross, dot), axis=0))


def bundle_radius(model: LineModel) -> float:
    """Mean distance [m] of the subconductors from the centre of their bundle."""
    r = _places(model)
    return float(np.mean(np.hypot(r[0], r[1])))


def _places(model: LineModel) -> Array:
    """Places [m] (axis, bundle, subconductor) at mid-span, from the centre of the bundle."""
    mesh = model.mesh.model
    nodes = [chain.middle for chain in mesh.map.chains]
    place = mesh.equilibrium().x[nodes][:, 1:3].T.reshape(2, -1, mesh.map.subconductors)
    return np.asarray(place - place.mean(axis=2, keepdims=True))


def state_at_end(
    moves: Histories, spans: int, radius: float = 0.0, irregular: bool = False
) -> LineState:
    """State of a line that has moved so for some time.

    Parameters
    ----------
    moves
        Its motion, without the beginning.
    spans
        Number of spans.
    radius
        From `bundle_radius`.
    irregular
        Whether an irregular motion may count as one that has settled.
    """
    middle = moves.u2[:, :, 1]
    parts = [middle, moves.quarter, moves.u3, moves.clamp, radius * moves.rotation]
    vertical, quarter, horizontal, clamp, at_radius = (_half(one) for one in parts)
    turned = moves.rotation.mean(axis=0)
    largest = max(float(np.max(_half(one), initial=0.0)) for one in parts)
    name, frequency, swings = "rest", None, False
    kind: StateKind = "rest"
    if largest >= CALM:
        name, frequency, swings = _words(moves, spans, largest, float(at_radius.max()))
        kind = _kind(parts, largest, irregular)
    if np.max(np.abs(turned)) > math.radians(TURNED_OVER):
        name += ", turned over"
    return LineState(
        name=name,
        kind=kind,
        vertical=_floats(vertical),
        horizontal=_floats(horizontal),
        quarter=_floats(quarter),
        peak_to_peak=_floats(np.ptp(moves.u2, axis=0).max(axis=1)),
        rotation=_floats(_half(moves.rotation)),
        mean_rotation=_floats(turned),
        clamp=_floats(clamp),
        radius=radius,
        frequency_hz=frequency,
        has_swing=swings,
    )


def _half(values: Array) -> Array:
    """Half peak-to-peak of histories (time, place)."""
    return np.asarray(0.5 * np.ptp(np.ascontiguousarray(values.T), axis=-1))


def _floats(values: Array) -> tuple[float, ...]:
    return tuple(values.tolist())


def _kind(parts: list[Array], largest: float, irregular: bool) -> StateKind:
    """Kind of a motion by its amplitudes in equal windows."""
    along = np.ascontiguousarray(np.concatenate(parts, axis=1).T)  # (place, time)
    length = along.shape[1] // WINDOWS
    pieces = along[:, along.shape[1] - WINDOWS * length :].reshape(len(along), WINDOWS, length)
    windows = 0.5 * np.ptp(pieces, axis=2).T  # (window, place)
    early, late = (one.max(axis=0) for one in np.array_split(windows, 2))
    beat = float(np.ptp(windows, axis=0).max())
    is_periodic = beat <= MAX_BEAT * largest
    change = float(np.max(np.abs(late - early)))
    grown = (late > MAX_GROWTH * early) & (late > MIN_GROWING * largest)
    limit = MAX_CHANGE if is_periodic else MAX_WANDER
    if is_periodic and np.any(grown):
        return "not settled"
    if change > limit * largest or _drifts(windows, largest):
        if not irregular or have_trend(windows, largest):
            return "not settled"
    return "periodic" if is_periodic else "beating"


def _drifts(windows: Array, largest: float) -> bool:
    """True if a large amplitude falls or rises from each third of the windows (window, place)."""
    thirds = np.array([one.max(axis=0) for one in np.array_split(windows, 3)])
    steps = np.diff(thirds, axis=0)
    together = np.min(np.abs(steps), axis=0) * (np.prod(np.sign(steps), axis=0) > 0.0)
    return bool(np.max(together) > MAX_DRIFT * largest)


def _words(moves: Histories, spans: int, largest: float, turned: float) -> tuple[str, float, bool]:
    """Name, frequency [Hz] of the main motion, and True if something swings at half of it.

    ``turned`` is the amplitude [m] of the rotation of bundles at their subconductors.
    """
    middle, quarter = moves.u2[:, :, 1], moves.quarter
    tall, wide = _half(middle).max(), _half(quarter).max()
    is_torsion = turned > max(tall, wide)
    part = moves.rotation if is_torsion else middle if tall >= wide else quarter
    main = part[:, int(np.argmax(_half(part)))]
    frequency = _frequency(main, moves.interval)
    words = ["one loop" if tall >= wide else "two loops"]
    if is_torsion:
        words = [TORSION]
    elif min(tall, wide) > MIN_PART * max(tall, wide):
        words.append("two loops" if tall >= wide else "one loop")
    least = max(MIN_HALF, MIN_HALF_PART * largest)
    swing, string = (_at_half(one, frequency, moves.interval) for one in (moves.u3, moves.clamp))
    if string > max(least, MIN_SWING * swing):
        words.append("string swing at half frequency")
    elif swing > least:
        words.append("swing at half frequency")
    if not is_torsion and _half(moves.rotation).max() > MIN_TORSION:
        words.append(TORSION if turned > 0.0 else "twist")
    name = words[0] + (f" with {' and '.join(words[1:])}" if len(words) > 1 else "")
    return name + _where(part, spans), frequency, max(swing, string) > least


def _where(part: Array, spans: int) -> str:
    """Spans that move, and how they move together, in words."""
    size = _half(part)
    moving = np.flatnonzero(size > MIN_PART * size.max())
    phases = part.shape[1] // spans
    numbers = sorted({int(k) // phases + 1 for k in moving})
    words = ""
    if len(numbers) < spans:
        listed = " and ".join(map(str, numbers[-2:]))
        words = ", ".join([*map(str, numbers[:-2]), listed])
        words = f" in span{'s' if len(numbers) > 1 else ''} {words}"
    if len(moving) < 2:
        return words
    alike = np.atleast_2d(np.corrcoef(part[:, moving].T))[0, 1:]
    if np.all(alike > MIN_ALIKE):
        return words
    together = np.all(np.abs(alike) > MIN_ALIKE)
    return words + (", spans against each other" if together else ", spans out of step")


def _frequency(values: Array, interval: float) -> float:
    """Frequency [Hz] of the strongest line."""
    lines = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values))))
    return float(np.fft.rfftfreq(len(values), interval)[int(np.argmax(lines))])


def _at_half(values: Array, frequency: float, interval: float) -> float:
    """Largest amplitude [m] of histories (time, place) at about half a frequency."""
    if not values.shape[1]:
        return 0.0
    window = np.hanning(len(values))
    lines = np.abs(np.fft.rfft((values - values.mean(axis=0)) * window[:, None], axis=0))
    hertz = np.fft.rfftfreq(len(values), interval)
    near = (hertz > 0.4 * frequency) & (hertz < 0.6 * frequency)
    return float(np.max(lines[near], initial=0.0) * 2.0 / window.sum())
