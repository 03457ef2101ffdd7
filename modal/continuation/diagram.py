"""All branches that can be reached from one equilibrium."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
        Events at which no branch was sought, because of the limits of depth, number and stability.
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

    Raises
    ------
    ContinuationError
        If Newton's method finds no equilibrium.
    """
    first = equilibria(problem, guess, parameter, settings, user)
    diagram = Diagram([first], [], [])
    waiting = [(event, 1) for event in first.events if event.kind in SWITCHING]
    seen: list[Event] = []
    while waiting:
        event, level = waiting.pop(0)
        if any(is_same_event(event, other) for other in seen):
            continue
        if level > depth or len(diagram.branches) >= most or _is_unlikely(event, settings):
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


def _is_unlikely(event: Event, settings: Settings) -> bool:
    """True if too many disturbances grow at an event, beside the critical one."""
    growing = int(np.sum(event.point.levels > CRITICAL))
    return settings.max_unstable is not None and growing > settings.max_unstable


def is_same_event(one: Event, other: Event) -> bool:
    """True if two events are the same solution, seen from the same or from two branches."""
    kinds = {one.kind, *RETURNS.get(one.kind, ())} & {other.kind, *RETURNS.get(other.kind, ())}
    if not kinds:
        return False
    unit = getattr(one.point.equations, "parameter_scale", 1.0)
    difference = summary(one.point, unit) - summary(other.point, unit)
    problem = one.point.equations.problem
    if problem.symmetry is None:
        return bool(np.max(np.abs(difference)) < SAME_EVENT)
    mirrored = _mirrored_summary(one, unit) - summary(other.point, unit)
    return bool(min(np.max(np.abs(difference)), np.max(np.abs(mirrored))) < SAME_EVENT)


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
