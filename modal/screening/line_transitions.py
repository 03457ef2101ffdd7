"""What the galloping of a line starts: where its first motion loses its stability, and to what.

The motion in one loop that begins in the lowest wind is followed up to the wind in which it is no
longer stable. The strongest part of the disturbance that grows there has a name: a swing of the
strings, the torsion of the bundle, or an exchange of motion between spans.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from modal.continuation.branch import Branch
from modal.continuation.equations import EquilibriumEquations, OrbitEquations
from modal.continuation.events import Event
from modal.continuation.finer_mesh import mesh_doubt
from modal.continuation.path import Point, Settings
from modal.continuation.problem import ContinuationError
from modal.continuation.starts import switched
from modal.motions.line_model import STRING_SWING
from modal.motions.motion_words import (
    disturbance_of,
    name_of_disturbance,
    name_of_motion,
    name_of_oscillation,
    parts_of,
)
from modal.motions.span_problem import LEAVES_CURVE, SpanProblem
from modal.motions.table import event_sentence
from modal.screening.line_rest import LineRest

TYPICAL, UNIT = 5.0, 4.0
"""Wind of typical sizes, and wind of length 1, relative to the lowest onset: the first motion
changes slowly with the wind, and each orbit of a line is expensive."""

FIRST_STEP, MAX_STEP = 0.05, 6.0
"""Lengths of continuation steps, in these sizes."""

TOLERANCE, NEWTON_TOLERANCE, LOCATION_TOLERANCE = 1e-3, 1e-4, 1e-4
"""As in `modal.screening.span_diagram`."""

MAX_POINTS, MAX_LOCATED = 40, 4
"""Largest number of orbits, and of growing disturbances with which changes are located."""

MAX_GROWING, MAX_GROWTH = 4, 10.0
"""Growing disturbances, and growth in a period, above which the motion is not followed."""

MAX_PERIOD = 8.0
"""Period at which the branch ends, relative to its first one."""

LASTING = 1.3
"""Ratio of wind speeds over which a motion must be unstable: close to the lowest onset, where
several motions begin, their stability changes within a few parts of a thousand."""

LOSSES = ("torus", "period doubling", "symmetry breaking", "branch point")
"""Events at which a motion loses its stability to another one."""

EXCHANGE = "exchange of motion between spans"


@dataclass(frozen=True)
class LineTransition:
    """A motion that starts another one.

    Attributes
    ----------
    origin : str
        The motion that loses its stability, in words.
    disturbance : str
        What grows on it, in words.
    wind_speed : float
        Wind speed [m/s] from which it grows.
    frequency_ratio : float
        Its frequency, relative to that of the motion: about 0.5 for a swing of the strings.
    is_swing : bool
        True if it is a swing of strings or spans at about half the frequency.
    """

    origin: str
    disturbance: str
    wind_speed: float
    frequency_ratio: float
    is_swing: bool

    def __str__(self) -> str:
        return (
            f"{self.origin} starts {self.disturbance} from {self.wind_speed:.4g} m/s, at"
            f" {self.frequency_ratio:.3g} of its frequency"
        )


MIN_HALF = 0.4
"""Least frequency of a swing at about half the frequency of the motion that starts it, relative to
that one."""


def transitions(rest: LineRest) -> tuple[tuple[LineTransition, ...], tuple[str, ...]]:
    """What the first motion of a line starts, and what could not be resolved, as sentences."""
    event = first_motion(rest)
    if event is None:
        return (), ()
    settings = _settings(rest, event)
    branch, doubt = _followed(rest, event, settings)
    if branch is None:
        return (), (doubt,)
    found, doubts = list[LineTransition](), list[str]()
    for one in branch.events:
        if one.kind in LOSSES and _lasts(one, branch):
            doubt = mesh_doubt(one, settings)
            found += [] if doubt else [_transition(one, rest)]
            doubts += [f"the first motion loses its stability, but {doubt}"] if doubt else []
    end = branch.ends[1]
    if end.kind == LEAVES_CURVE or end.kind in ("lost", "points", "period"):
        name = name_of_motion(branch.points[len(branch.points) // 2], rest.model)
        doubts.append(f"{name}: {event_sentence(end, 'm/s')}")
    elif end.kind == "given up" and not found:
        doubts.append(
            f"what the first motion starts is not known: it was not followed beyond"
            f" {end.parameter:.4g} m/s, where {end.point.unstable} disturbances of it grow"
        )
    return tuple(found), tuple(doubts)


def first_motion(rest: LineRest) -> Event | None:
    """Hopf point of the vertical motion in one loop in the lowest wind; if none, the first one."""
    begins = rest.begins
    for event in begins:
        jacobian = event.point.equations.problem.rates(event.point.states, event.parameter)
        values, vectors = np.linalg.eig(jacobian.by_state[0])
        near = int(np.argmin(np.abs(values - 1j * abs(event.value.imag))))
        kind, loops, _ = name_of_oscillation(vectors[: rest.model.size, near], rest.model)
        if (kind, loops) == ("vertical", 1):
            return event
    return begins[0] if begins else None


def _settings(rest: LineRest, event: Event) -> Settings:
    """Bounds of the branch that begins at an event."""
    assert rest.unit is not None
    return Settings(
        event.parameter,
        rest.highest,
        tolerance=TOLERANCE,
        first_step=FIRST_STEP,
        max_step=MAX_STEP,
        max_points=MAX_POINTS,
        max_period=MAX_PERIOD,
        max_unstable=MAX_LOCATED,
        newton_tolerance=NEWTON_TOLERANCE,
        location_tolerance=LOCATION_TOLERANCE,
        unit=UNIT * rest.unit,
        give_up=_has_lost(),
    )


def _followed(rest: LineRest, event: Event, settings: Settings) -> tuple[Branch | None, str]:
    """Branch of the motion that begins at an event, or the reason for which there is none."""
    assert rest.unit is not None
    problem = SpanProblem(rest.problem.family, rest.model, TYPICAL * rest.unit)
    try:
        branch = switched(_of(event, problem, settings), settings, problem.end_of_curve())[0]
    except ContinuationError as error:
        return None, f"the first motion could not be followed, because {error}"
    return branch, ""


def _of(event: Event, problem: SpanProblem, settings: Settings) -> Event:
    """The same Hopf point in other typical sizes."""
    equations = EquilibriumEquations(problem, settings.parameter_scale)
    return replace(event, point=replace(event.point, equations=equations))


def _has_lost() -> Callable[[Point], bool]:
    """Function that is True for an orbit that is unstable, as all since a much lower wind."""
    stable = list[float]()

    def give_up(point: Point) -> bool:
        if not isinstance(point.equations, OrbitEquations):
            return False
        if point.is_stable:
            stable.append(point.parameter)
        too_far = point.unstable > MAX_GROWING
        too_far |= float(np.max(np.abs(point.spectrum))) > MAX_GROWTH
        return too_far or (bool(stable) and point.parameter > LASTING * stable[-1])

    return give_up


def _lasts(event: Event, branch: Branch) -> bool:
    """True if the motion was stable below an event, and is not soon stable again above it."""
    wind, last = event.parameter, LASTING * event.parameter
    below = [one for one in branch.points if one.parameter < wind]
    nearest = max(below, key=lambda one: one.parameter, default=None)
    after = any(one.is_stable and wind < one.parameter <= last for one in branch.points)
    return nearest is not None and nearest.is_stable and not after


def _transition(event: Event, rest: LineRest) -> LineTransition:
    """What begins at an event."""
    model, point = rest.model, event.point
    origin = name_of_motion(point, model)
    first = parts_of(point, model)[0]
    if event.kind in ("symmetry breaking", "branch point"):
        return LineTransition(origin, EXCHANGE, event.parameter, 1.0, False)
    word, mode = disturbance_of(event, model)
    rotation = event.rotation if event.kind == "torus" else 0.5
    is_swing = word in (STRING_SWING, "horizontal") and rotation / first.harmonic >= MIN_HALF
    ratio = rotation / first.harmonic
    if not is_swing:
        # A multiplier has the frequency up to whole ones of the orbit: the nearest to the mode's.
        natural = float(np.sqrt(model.stiffness[mode, mode])) * point.period / (2.0 * np.pi)
        near = np.arange(20.0)[:, None] + np.array([rotation, 1.0 - rotation])
        ratio = float(near.flat[np.argmin(np.abs(near - natural))]) / first.harmonic
    is_own = (word, model.loops(mode)) == (first.family, first.loops)
    name = EXCHANGE if is_own else name_of_disturbance(event, model)
    return LineTransition(origin, name, event.parameter, ratio, is_swing)
