"""Stable states of a span in the scene's wind: from its branches and, where they end, simulated.

Stable orbits and equilibria of the branches are states. Where a motion has lost its stability and
no stable one that follows is known (it beats with a second frequency, or its branch was given up),
a simulation with the full model begins near it; its end is a state.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from gallop_fmu.foundation.outcome import SimulationError
from modal.continuation.branch import Branch
from modal.continuation.path import Point
from modal.motions.full_model import RECORDS_PER_PERIOD, full_scene, reduction_error, runs_from
from modal.motions.motion_words import TURNED_OVER, name_of_motion, parts_of
from modal.motions.rotated import equilibria_at
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import WIND_SPEED
from modal.motions.trend import MIN_STEP, has_trend
from modal.screening.cycles import StableState, StateKind
from modal.screening.span_diagram import SpanDiagram

Array = NDArray[np.float64]

PHASES = np.arange(128) / 128.0
"""Phases of a period at which amplitudes are measured."""

ELEMENTS, STEPS = 8, 100
"""Elements, and time steps in a period of the first vertical mode, of a simulation."""

NEWTON_TOLERANCE = 1e-8
"""Tolerance [m] of Newton's method in a time step of a simulation. With 1e-7 and 1e-6 one of 26
drawn spans (13 of set 20261203 of states_table.py) ends on another of its irregular motions."""

CHECK_STEPS = 150
"""Such time steps when an orbit is compared with the full model over one period."""

MAX_ERROR = 0.1
"""Distance of the full model from an orbit after a period, relative to its amplitude, above which
the orbit is not reported, but simulated."""

PERIODS = (500, 1000, 2000, 6000)
"""Durations of a simulation in periods of the first vertical mode, until it has settled."""

LATE = (0.6, 0.3)
"""Parts of a simulation at its end in which amplitudes are read; the second, if it has not settled
in the first."""

MIN_LATE = 300
"""Least duration of such a part in periods."""

MAX_CHANGE = 0.05
"""Change of the largest amplitude between both halves of that part, up to which it has settled."""

IRREGULAR = 2000
"""Periods from which an irregular motion is a state: its largest amplitude is a rare one."""

SLOWING = 0.8
"""A part of the motion has not settled if its mean amplitude rises steadily, and from the second to
the last third by more than this times the rise before."""

MAX_GROWTH, MIN_GROWING = 1.15, 0.03
"""Growth of a part of the motion (such as that in two loops) between both halves, above which it
has not settled if the part is this large, relative to the largest amplitude."""

MAX_BEAT = 0.05
"""Variation of amplitudes, relative to the largest, up to which a motion is periodic."""

DISTURBANCE = 0.03
"""Disturbance of the lowest vertical and horizontal modes at the start of a simulation, relative to
their typical amplitude."""

MAX_RUNS = 3
"""Largest number of simulations."""

CALM = 2e-3
"""Amplitude [m] below which a simulated span is at rest."""

ALIKE, SAME_ORBIT = 0.1, 0.02
"""Differences of amplitudes, relative to the largest, below which a simulation ends in a state, and
below which two orbits are one state."""

MIN_SWING = 5e-3
"""Amplitude [m] at half the vertical frequency above which a simulated span swings."""

MIN_ROTATION = 0.01
"""Difference of the mean twist [rad] at mid-span above which two equilibria are different."""


@dataclass(frozen=True)
class Settled:
    """States of a span in the scene's wind.

    Attributes
    ----------
    states : tuple of StableState
        Stable states.
    doubts : tuple of str
        What could not be resolved, as sentences.
    """

    states: tuple[StableState, ...]
    doubts: tuple[str, ...]


def settled_states(diagram: SpanDiagram) -> Settled:
    """Find the stable states in the scene's wind.

    Parameters
    ----------
    diagram
        Branches of the span.
    """
    known = [(branch, point) for branch in diagram.orbits for point in diagram.at_wind(branch)]
    periodic, unsure = _periodic_states(diagram, [point for _, point in known if point.is_stable])
    states = [*[state for state, is_stable in _equilibria(diagram) if is_stable], *periodic]
    starts = [*unsure, *_without_successor(diagram, known, bool(states))][:MAX_RUNS]
    doubts = _add_simulated(diagram, states, [point.states[0] for point in starts])
    if not states and not doubts:
        doubts = _add_simulated(diagram, states, [one for one, _ in _static_states(diagram)][:1])
    unstable = [amplitudes(point, diagram.model) for _, point in known if point.unstable == 1]
    return Settled(tuple(_separated(state, unstable) for state in states), tuple(doubts))


def _periodic_states(
    diagram: SpanDiagram, stable: Sequence[Point]
) -> tuple[list[StableState], list[Point]]:
    """States of stable orbits, each once, and the orbits from which the full model moves away."""
    states, unsure = list[StableState](), list[Point]()
    for point in stable:
        if _error(diagram, point) > MAX_ERROR:
            unsure.append(point)
        elif not any(is_same(state_of(point, diagram), one, SAME_ORBIT) for one in states):
            states.append(state_of(point, diagram))
    return states, unsure


def _add_simulated(
    diagram: SpanDiagram, states: list[StableState], starts: Sequence[Array]
) -> list[str]:
    """Simulate from all starts and add new states; return what is not resolved."""
    doubts = []
    for start in starts:
        found, doubt = simulated_state(diagram, start)
        doubts += [doubt] if doubt else []
        if found is not None and not any(is_same(found, one) for one in states):
            states.append(found)
    return doubts


def _error(diagram: SpanDiagram, point: Point) -> float:
    """Distance of the full model from an orbit after one period; infinite if it cannot move so."""
    try:
        scene = full_scene(diagram.scene, WIND_SPEED, point.parameter, diagram.model, CHECK_STEPS)
        error = reduction_error(scene, diagram.model, point)
    except (SceneError, SimulationError):
        return float("inf")
    return error if np.isfinite(error) else float("inf")


def _without_successor(
    diagram: SpanDiagram, known: Sequence[tuple[Branch, Point]], has_state: bool
) -> list[Point]:
    """Orbits from which a simulation must begin, as what follows them is not known.

    They have been stable in a lower wind and lost that, but not to a motion that is known now, be
    it stable or not; or their branch could not be followed to this wind; or nothing else is known,
    and they are the least unstable ones.
    """
    unstable = [(branch, point) for branch, point in known if not point.is_stable]
    followed = {id(branch.origin.point.x) for branch, _ in known if branch.origin is not None}
    chosen = _last_stable(diagram)
    for branch, point in sorted(unstable, key=lambda one: one[1].unstable):
        lost_to = {id(event.point.x) for event in branch.events}
        was_stable = any(one.is_stable for one in branch.points)
        if was_stable and point.unstable <= 2 and not lost_to & followed:
            chosen.append(point)
    if not chosen and not has_state:
        chosen = [point for _, point in sorted(unstable, key=lambda one: one[1].unstable)][:1]
    return chosen


def _last_stable(diagram: SpanDiagram) -> list[Point]:
    """Last stable orbits of branches that could not be followed up to the scene's wind."""
    found = []
    for branch in diagram.orbits:
        end = branch.ends[1]
        is_lost = end.kind in ("given up", "lost", "points") and end.parameter < diagram.wind
        if is_lost and not diagram.at_wind(branch):
            found += [point for point in branch.points if point.is_stable][-1:]
    return found


def _static_states(diagram: SpanDiagram) -> list[tuple[Array, bool]]:
    """Equilibria (2 mode,) in the scene's wind, and True for those that are stable."""
    found = []
    for state in equilibria_at(diagram.problem, diagram.wind):
        rates = diagram.problem.rates(state[None], diagram.wind).by_state[0]
        found.append((state, bool(np.max(np.linalg.eigvals(rates).real) < 0.0)))
    return found


def _equilibria(diagram: SpanDiagram) -> list[tuple[StableState, bool]]:
    """Equilibria in the scene's wind as states, and True for those that are stable."""
    model = diagram.model
    found: list[tuple[StableState, bool]] = []
    for state, is_stable in _static_states(diagram):
        twist = float(state[: model.size] @ model.middle[:, 3])
        found.append((_rest(twist), is_stable))
    return found


def _rest(twist: float) -> StableState:
    """Equilibrium with a twist [rad] at mid-span."""
    name = "rest, turned over" if abs(np.degrees(twist)) > TURNED_OVER else "rest"
    return StableState(name, "rest", 0.0, 0.0, 0.0, 0.0, twist, None, False, False)


def amplitudes(point: Point, model: SpanModel) -> Array:
    """Amplitudes of an orbit: u2, u3, theta at mid-span, antisymmetric u2 at the quarter points."""
    moves = model.watched_at(point.at(PHASES)[:, : model.size])
    return np.array([0.5 * float(np.max(np.ptp(one, axis=0))) for one in moves[:4]])


def state_of(point: Point, diagram: SpanDiagram) -> StableState:
    """Return a stable orbit as a state."""
    model = diagram.model
    u2, u3, theta, quarter = amplitudes(point, model).tolist()
    growth = float(np.log(np.max(np.abs(point.spectrum)))) / point.period
    parts = parts_of(point, model)
    vertical = next((part for part in parts if part.family == "vertical"), parts[0])
    swings = any(
        part.family == "horizontal" and 2 * part.harmonic == vertical.harmonic for part in parts
    )
    return StableState(
        name_of_motion(point, model),
        "periodic",
        u2,
        u3,
        theta,
        quarter,
        float(point.mean[: model.size] @ model.middle[:, 3]),
        vertical_frequency(point, model),
        swings,
        False,
        growth_rate=growth,
    )


def vertical_frequency(point: Point, model: SpanModel) -> float:
    """Frequency [Hz] of the strongest vertical part of an orbit."""
    parts = parts_of(point, model)
    vertical = next((part for part in parts if part.family == "vertical"), parts[0])
    return vertical.harmonic / point.period


def simulated_state(diagram: SpanDiagram, state: Array) -> tuple[StableState | None, str]:
    """State in which a simulation with the full model ends.

    Parameters
    ----------
    diagram
        Branches of the span.
    state : ndarray, shape (2 mode,)
        Start; a small disturbance is added.

    Returns
    -------
    StableState or None, str
        The state, None if the simulation ended early, and what is not resolved (else empty).
    """
    model = diagram.model
    count = model.elements
    elements = count // 2 if count >= 2 * ELEMENTS and count % 2 == 0 else count
    scene = full_scene(
        diagram.scene, WIND_SPEED, diagram.wind, model, STEPS, elements, NEWTON_TOLERANCE
    )
    start = state + _disturbance(diagram)
    for end, values, interval in runs_from(scene, model, start, PERIODS):
        if end.ended_early:
            return None, f"a simulation at {diagram.wind:.4g} m/s ended early: {end.outcome}"
        for part in LATE:
            late = values[round((1.0 - part) * len(values)) :]
            if part < LATE[0] and len(late) < MIN_LATE * RECORDS_PER_PERIOD:
                continue
            found = _end_of(late, interval, len(values) >= IRREGULAR * RECORDS_PER_PERIOD)
            if found.kind != "not settled":
                return found, ""
    return found, ""


def _disturbance(diagram: SpanDiagram) -> Array:
    """Small displacement of the lowest vertical and horizontal modes of both symmetries."""
    model, change = diagram.model, np.zeros(diagram.problem.size)
    for family in ("vertical", "horizontal"):
        for symmetric in (True, False):
            for i, known in enumerate(model.family):
                if known == family and model.is_symmetric[i] == symmetric:
                    change[i] = DISTURBANCE * diagram.problem.scale[i]
                    break
    return change


def _end_of(late: Array, interval: float, irregular: bool) -> StableState:
    """State in late records (record, channel, node) at both quarter points and mid-span.

    An irregular motion counts as settled if ``irregular``.
    """
    series = {
        "vertical": late[:, 0, 1],
        "horizontal": late[:, 1, 1],
        "quarter": 0.5 * (late[:, 0, 0] - late[:, 0, 2]),
    }
    sizes = {name: _windows(one) for name, one in series.items()}
    largest = max(float(one.max()) for one in sizes.values())
    twist = float(late[-len(late) // 4 :, 2, 1].mean())
    if largest < CALM:
        return replace(_rest(twist), is_simulated=True)
    beat = max(float(np.ptp(one)) for one in sizes.values())
    kind: StateKind = "periodic" if beat <= MAX_BEAT * largest else "beating"
    changes = any(_changes(one, largest) for one in sizes.values())
    if changes and not (irregular and not any(has_trend(one) for one in sizes.values())):
        kind = "not settled"
    if any(_rises(one, largest) for one in sizes.values()):
        kind = "not settled"
    name, frequency, swings = _words(series, sizes, interval)
    if abs(np.degrees(twist)) > TURNED_OVER:
        name += ", turned over"
    vertical, horizontal, quarter = (0.5 * float(np.ptp(one)) for one in series.values())
    return StableState(
        name,
        kind,
        vertical,
        horizontal,
        0.5 * float(np.ptp(late[:, 2, 1])),
        quarter,
        twist,
        frequency,
        swings,
        True,
    )


WINDOWS = 60
"""Number of equal windows in which amplitudes are compared."""


def _windows(values: Array) -> Array:
    """Amplitudes in equal windows."""
    return np.array([0.5 * np.ptp(one) for one in np.array_split(values, WINDOWS)])


def _changes(sizes: Array, largest: float) -> bool:
    """True if the largest amplitude in equal windows differs between both halves."""
    early, late = (float(half.max()) for half in np.array_split(sizes, 2))
    grows = late > max(MAX_GROWTH * early, MIN_GROWING * largest)
    return grows or abs(late - early) > MAX_CHANGE * largest


def _rises(sizes: Array, largest: float) -> bool:
    """True if an amplitude rises steadily, however slowly, and not ever less."""
    thirds = np.array([third.mean() for third in np.array_split(sizes, 3)])
    first, second = np.diff(thirds).tolist()
    return bool(
        sizes.max() > MIN_GROWING * largest
        and min(first, second) > MIN_STEP * thirds[0]
        and second > SLOWING * first
        and has_trend(sizes)
    )


def _words(
    series: dict[str, Array], sizes: dict[str, Array], interval: float
) -> tuple[str, float, bool]:
    """Name, vertical frequency [Hz], and True if there is a swing at half that frequency."""
    vertical, quarter = float(sizes["vertical"].max()), float(sizes["quarter"].max())
    main = series["vertical"] if vertical >= quarter else series["quarter"]
    count = len(main)
    window = np.hanning(count)
    frequencies = np.fft.rfftfreq(count, interval)
    lines = np.abs(np.fft.rfft((main - main.mean()) * window))
    frequency = float(frequencies[int(np.argmax(lines))])
    swing = series["horizontal"]
    spectrum = np.abs(np.fft.rfft((swing - swing.mean()) * window)) * 2.0 / window.sum()
    near = (frequencies > 0.4 * frequency) & (frequencies < 0.6 * frequency)
    swings = bool(np.max(spectrum[near], initial=0.0) > MIN_SWING)
    words = ["one loop"] if vertical >= quarter else ["two loops"]
    if min(vertical, quarter) > 0.1 * max(vertical, quarter):
        words.append("two loops" if vertical >= quarter else "one loop")
    if swings:
        words.append("swing at half frequency")
    name = words[0] + (f" with {' and '.join(words[1:])}" if len(words) > 1 else "")
    return name, frequency, swings


def is_same(one: StableState, other: StableState, alike: float = ALIKE) -> bool:
    """True if two states have the same amplitudes, or the same twist at rest."""
    if (one.kind == "rest") != (other.kind == "rest"):
        return False
    if one.kind == "rest":
        return abs(one.mean_twist - other.mean_twist) < 10.0 * MIN_ROTATION
    names = ("vertical", "horizontal", "quarter")
    away = max(abs(float(getattr(one, name) - getattr(other, name))) for name in names)
    return away < alike * max(one.largest, other.largest)


def _separated(state: StableState, unstable: Sequence[Array]) -> StableState:
    """Add the difference of amplitudes to the nearest orbit with one growing disturbance."""
    own = np.array([state.vertical, state.horizontal, state.quarter])
    sizes = [float(np.max(np.abs(one[[0, 1, 3]] - own))) for one in unstable]
    return replace(state, separation=min(sizes)) if sizes else state
