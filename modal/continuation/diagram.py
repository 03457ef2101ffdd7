"""All branches that can be reached from one equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modal.continuation.branch import Branch, summary
from modal.continuation.events import SWITCHING, Event, UserEvent
from modal.continuation.path import Settings
from modal.continuation.problem import ContinuationError, Problem
from modal.continuation.starts import equilibria, switched

Array = NDArray[np.float64]

SAME_EVENT = 1e-3
"""Distance of the summaries of two solutions below which they are the same event."""

SAME_HOPF, SAME_FREQUENCY = 1e-9, 1e-2
"""Distance of two Hopf points relative to the range, and relative difference of the frequencies of
an oscillation at a Hopf point and at the end of an orbit at rest, below which they are the same."""

NEAR_SEGMENT = 0.2
"""Distance from the chord of two points, relative to its length, within which a branch passes."""

CRITICAL = 1e-6
"""Growth below which a disturbance is the critical one of an event."""

RETURNS = {
    "rest": ("Hopf",),
    "period halving": ("period doubling",),
    "symmetry recovered": ("symmetry breaking", "branch point"),
}
"""Kinds at which a branch ends, and those that the same point has on the other branch."""


@dataclass(frozen=True)
class Diagram:
    """Branches of a problem.

    Attributes
    ----------
    branches : list of Branch
        First the equilibria; each other one after the branch on which its origin lies.
    failures : list of tuple of Event and str
        Events at which no branch was found, and why.
    unexplored : list of Event
        Events at which no branch was sought, because of the limits of depth, number, points and
        stability.
    """

    branches: list[Branch]
    failures: list[tuple[Event, str]]
    unexplored: list[Event]

    @property
    def is_complete(self) -> bool:
        """True if all branches end at events, and all events were explored."""
        return (
            not self.failures and not self.unexplored and all(b.is_complete for b in self.branches)
        )


def explore(
    problem: Problem,
    guess: Array,
    parameter: float,
    settings: Settings,
    user: Sequence[UserEvent] = (),
    depth: int = 4,
    most: int = 30,
    others: Sequence[tuple[Array, float]] = (),
) -> Diagram:
    """Follow the equilibria near a guess and, from their events on, all other branches.

    Parameters
    ----------
    problem, guess, parameter, settings, user
        As in `modal.continuation.starts.equilibria`.
    depth
        Largest number of events between a branch and the equilibria.
    most
        Largest number of branches.
    others
        Further equilibria and their parameters. Those on a branch that is known are left out;
        orbits that begin at the others are not followed.

    Raises
    ------
    ContinuationError
        If Newton's method finds no equilibrium.
    """
    static = _static_branches(problem, ((guess, parameter), *others), settings.at_rest, user)
    diagram = Diagram(static, [], [])
    waiting = [(event, 1) for event in static[0].events if event.kind in SWITCHING]
    seen: list[Event] = []
    while waiting:
        event, level = waiting.pop(0)
        if not _is_new(event, seen, settings):
            continue
        if level > depth or _is_beyond(diagram, event, settings, most):
            diagram.unexplored.append(event)
            continue
        seen.append(event)
        try:
            found = switched(event, settings, user)
        except ContinuationError as error:
            diagram.failures.append((event, str(error)))
            continue
        for branch in found:
            diagram.branches.append(branch)
            seen += [end for end in branch.ends[1:] if end.kind in RETURNS]
            waiting += [(one, level + 1) for one in branch.events if one.kind in SWITCHING]
    return diagram


def _is_new(event: Event, seen: Sequence[Event], settings: Settings) -> bool:
    """True if an event is wanted and none of those seen before."""
    is_wanted = settings.is_wanted is None or settings.is_wanted(event)
    return is_wanted and not any(is_same_event(event, other) for other in seen)


def _static_branches(
    problem: Problem,
    starts: Sequence[tuple[Array, float]],
    settings: Settings,
    user: Sequence[UserEvent],
) -> list[Branch]:
    """Branches of equilibria through all starts, each once."""
    static: list[Branch] = []
    for state, value in starts:
        if not any(_is_on(branch, state, value) for branch in static):
            static.append(equilibria(problem, state, value, settings, user))
    return static


def _is_on(branch: Branch, state: Array, parameter: float) -> bool:
    """True if an equilibrium lies between two neighbouring points of a branch."""
    scale = branch.points[0].equations.problem.scale
    for one, other in pairwise(branch.points):
        low, high = one.parameter, other.parameter
        if (low - parameter) * (high - parameter) > 0.0:
            continue
        part = 0.5 if high == low else (parameter - low) / (high - low)
        between = one.states[0] + part * (other.states[0] - one.states[0])
        step = float(np.linalg.norm((other.states[0] - one.states[0]) / scale))
        away = float(np.linalg.norm((state - between) / scale))
        if away < max(SAME_EVENT, NEAR_SEGMENT * step):
            return True
    return False


def _is_beyond(diagram: Diagram, event: Event, settings: Settings, most: int) -> bool:
    """True if the branch of an event is beyond the limits of number, work, or stability."""
    if event.point.equations.kind == "equilibrium":
        settings = settings.at_rest
    growing = int(np.sum(event.point.levels > CRITICAL))  # beside the critical disturbance
    points = sum(len(branch.points) for branch in diagram.branches)
    return (
        len(diagram.branches) >= most
        or (settings.max_total_points is not None and points >= settings.max_total_points)
        or (settings.max_unstable is not None and growing > settings.max_unstable)
    )


def is_same_event(one: Event, other: Event) -> bool:
    """True if two events are the same solution, seen from the same or from two branches."""
    kinds = {one.kind, *RETURNS.get(one.kind, ())} & {other.kind, *RETURNS.get(other.kind, ())}
    if not kinds:
        return False
    unit = getattr(one.point.equations, "parameter_scale", 1.0)
    if kinds == {"Hopf"} and not _is_same_oscillation(one, other, unit):
        return False
    difference = summary(one.point, unit) - summary(other.point, unit)
    problem = one.point.equations.problem
    if problem.symmetry is None:
        return bool(np.max(np.abs(difference)) < SAME_EVENT)
    mirrored = _mirrored_summary(one, unit) - summary(other.point, unit)
    return bool(min(np.max(np.abs(difference)), np.max(np.abs(mirrored))) < SAME_EVENT)


def _is_same_oscillation(one: Event, other: Event, unit: float) -> bool:
    """True if an oscillation that begins or ends at one equilibrium may be that at another.

    Two Hopf points of the equilibria are different oscillations even if they are close together.
    """
    if one.kind == other.kind == "Hopf":
        return abs(one.parameter - other.parameter) <= SAME_HOPF * unit
    first, second = (
        2.0 * np.pi / event.point.period if event.point.period else abs(event.value.imag)
        for event in (one, other)
    )
    return abs(first - second) <= SAME_FREQUENCY * max(first, second)


def _mirrored_summary(event: Event, unit: float) -> Array:
    """Summary of the mirror image of an event's solution."""
    point = event.point
    problem = point.equations.problem
    assert problem.symmetry is not None
    n = problem.size
    values = point.states @ problem.symmetry.T / problem.scale
    found = summary(point, unit).copy()
    found[:n], found[n : 2 * n] = values.min(axis=0), values.max(axis=0)
    found[2 * n : 3 * n] = problem.symmetry @ point.mean / problem.scale
    return found
