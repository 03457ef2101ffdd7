"""First points of branches: from a guess, and from events of other branches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modal.continuation import collocation as co
from modal.continuation.branch import Branch, follow, joined
from modal.continuation.equations import (
    Equations,
    EquilibriumEquations,
    OrbitEquations,
    length,
)
from modal.continuation.events import Event, UserEvent
from modal.continuation.finer_mesh import mesh_doubt
from modal.continuation.path import Point, Settings, Stepper, reversed_point
from modal.continuation.problem import ContinuationError, Problem

Array = NDArray[np.float64]

FIRST_DISTANCE, TRIALS, TRIAL_FACTOR = 0.01, 6, 0.3
"""Distance of the first point of a branch from the event, and how often it is changed."""

FIRST_INTERVALS = 20
"""Mesh intervals of an orbit before its error is known."""


def equilibria(
    problem: Problem,
    guess: Array,
    parameter: float,
    settings: Settings,
    user: Sequence[UserEvent] = (),
) -> Branch:
    """Follow the equilibria through one near a guess, in both directions.

    Parameters
    ----------
    problem
        The system.
    guess : ndarray, shape (n,)
        State near the equilibrium.
    parameter
        Parameter at which it is sought, inside the range of the settings.
    settings
        Bounds of the continuation.
    user
        Further events.

    Raises
    ------
    ContinuationError
        If Newton's method finds no equilibrium.
    """
    equations = EquilibriumEquations(problem, settings.parameter_scale)
    x = np.append(np.asarray(guess, dtype=float), parameter)
    hold = np.zeros_like(x)
    hold[-1] = settings.parameter_scale
    point = Stepper(settings).correct(equations, x, x, hold, 0.0)
    return _both_ways(point, settings, user)


def orbits(
    problem: Problem,
    states: Array,
    period: float,
    parameter: float,
    settings: Settings,
    user: Sequence[UserEvent] = (),
) -> Branch:
    """Follow the periodic orbits through one near a guess, in both directions.

    Parameters
    ----------
    problem
        The system.
    states : ndarray, shape (instant, n)
        The guess at equally spaced instants of a period, without its end: from a simulation.
    period
        Its period.
    parameter, settings, user
        As in `equilibria`.

    Raises
    ------
    ContinuationError
        If Newton's method finds no orbit.
    """
    return _both_ways(orbit(problem, states, period, parameter, settings), settings, user)


def orbit(
    problem: Problem, states: Array, period: float, parameter: float, settings: Settings
) -> Point:
    """Find the periodic orbit near a guess; see `orbits`."""
    mesh = np.linspace(0.0, 1.0, FIRST_INTERVALS + 1)
    equations = OrbitEquations(problem, settings.parameter_scale, period, mesh)
    times, count = co.node_times(mesh), len(states)
    wrapped = np.vstack([states, states[:1]])
    phases = np.arange(count + 1) / count
    nodes = np.stack([np.interp(times, phases, column) for column in wrapped.T], axis=1)
    x = np.concatenate([nodes.ravel(), [period, parameter]])
    hold = np.zeros_like(x)
    hold[-1] = settings.parameter_scale
    stepper = Stepper(settings)
    return _resolved(stepper, stepper.correct(equations, x, x, hold, 0.0), True)


def _resolved(stepper: Stepper, point: Point, is_held: bool) -> Point:
    """Refine the mesh of a point until its error is small enough."""
    while point.error > stepper.settings.tolerance:
        point = stepper.remeshed(point, point, is_held)
    return point


def _both_ways(point: Point, settings: Settings, user: Sequence[UserEvent]) -> Branch:
    """Follow a branch from a point in both directions."""
    forward = follow(point, settings, user)
    if forward.ends[1].kind == "closed":
        return forward
    return joined(follow(reversed_point(point), settings, user), forward)


def switched(event: Event, settings: Settings, user: Sequence[UserEvent] = ()) -> list[Branch]:
    """Follow the branches that start at an event.

    At a Hopf point and a period doubling, there is one; at a branch point two, which at a symmetry
    breaking are mirror images, so that one is followed.

    Parameters
    ----------
    event
        An event of a kind in `modal.continuation.events.SWITCHING`.
    settings, user
        As in `equilibria`.

    Raises
    ------
    ContinuationError
        If no branch is found, none starts at an event of this kind, or a finer mesh does not have
        the event.
    """
    point, doubt = event.point, mesh_doubt(event, settings)
    if doubt:
        raise ContinuationError(doubt)
    if event.kind == "Hopf":
        starts = [_from_hopf(event, settings)]
    elif event.kind == "period doubling":
        starts = [_from_doubling(point)]
    elif event.kind in ("branch point", "symmetry breaking"):
        direction = point.equations.null_vector(point.linear)
        both = event.kind == "branch point"
        starts = [(point.equations, point.x, sign * direction) for sign in (1.0, -1.0)[: 1 + both]]
    else:
        raise ContinuationError(f"no branch that could be followed starts at a {event.kind}")
    return [follow(_first(start, settings), settings, user, event) for start in starts]


def _first(start: tuple[Equations, Array, Array], settings: Settings) -> Point:
    """First point of a branch in a direction from a point of another one."""
    equations, x, direction = start
    direction = direction / length(equations, direction)
    stepper, distance = Stepper(settings), FIRST_DISTANCE
    for _ in range(TRIALS):
        try:
            guess = x + distance * direction
            point = stepper.correct(equations, guess, x, direction, distance, reference=guess)
            return _resolved(stepper, point, False)
        except ContinuationError as error:
            distance, reason = TRIAL_FACTOR * distance, error
    raise ContinuationError(f"no branch found beside {x[-1]:.6g}: {reason}")


def _from_hopf(event: Event, settings: Settings) -> tuple[Equations, Array, Array]:
    """Equilibrium as an orbit without motion, and the direction of the growing oscillation."""
    point, omega = event.point, abs(event.value.imag)
    problem = point.equations.problem
    jacobian = problem.rates(point.states, point.parameter).by_state[0]
    values, vectors = np.linalg.eig(jacobian)
    shape = vectors[:, np.argmin(np.abs(values - 1j * omega))]
    mesh = np.linspace(0.0, 1.0, co.MIN_INTERVALS + 1)
    period = 2.0 * np.pi / omega
    equations = OrbitEquations(problem, settings.parameter_scale, period, mesh)
    times = co.node_times(mesh)
    motion = np.real(shape * np.exp(2j * np.pi * times)[:, None])
    x = np.concatenate([np.tile(point.states[0], len(times)), [period, point.parameter]])
    return equations, x, np.concatenate([motion.ravel(), [0.0, 0.0]])


def _from_doubling(point: Point) -> tuple[Equations, Array, Array]:
    """Orbit over two periods, and the direction of the disturbance that changes its sign."""
    old, condensed = point.equations, point.linear.matrix
    assert isinstance(old, OrbitEquations)
    # M v = -v with the pencil (A, B):  A v = B v
    vector = np.linalg.svd(condensed.first - condensed.last)[2][-1]
    half = condensed.expand(vector, -vector, np.zeros(2), 0.0)[:-2]
    mesh = np.concatenate([0.5 * old.mesh, 0.5 + 0.5 * old.mesh[1:]])
    equations = OrbitEquations(old.problem, old.parameter_scale, 2.0 * old.period_scale, mesh)
    x = np.concatenate([point.x[:-2], point.x[:-2], [2.0 * point.period, point.parameter]])
    return equations, x, np.concatenate([half, -half, [0.0, 0.0]])
