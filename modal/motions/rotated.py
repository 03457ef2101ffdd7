"""Equilibria in which the conductor has rotated with its ice, far from the initial equilibrium."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from modal.continuation.events import UserEvent
from modal.motions.reduced_model import static_equilibrium
from modal.motions.span_problem import SpanProblem

Array = NDArray[np.float64]

ROTATIONS = np.radians(sorted(np.arange(-360.0, 361.0, 45.0), key=abs))
"""Twists [rad] at mid-span from which equilibria are sought."""

PARTS = (0.02, 0.5, 0.98)
"""Values of the parameter at which they are sought, in parts of the range."""

SAME = 1e-4
"""Distance in typical sizes below which two equilibria are the same."""


def rotated_equilibria(
    problem: SpanProblem, start: float, stop: float
) -> Iterator[tuple[Array, float]]:
    """Equilibria that Newton's method finds from various twists, with their parameters.

    On a coefficient curve that does not cover a whole turn, only those inside its range.
    """
    for part in PARTS:
        value = start + part * (stop - start)
        for state in equilibria_at(problem, value):
            yield state, value


def equilibria_at(problem: SpanProblem, value: float) -> Iterator[Array]:
    """Equilibria (2 mode,) at one value of the parameter, that without twist first."""
    limits = problem.end_of_curve()
    model, wind = problem.family.at(value)
    known = list[Array]()
    for twist in ROTATIONS:
        guess = model.rotated(twist)
        if guess is None:
            return
        if twist != 0.0 and not _is_inside(limits, np.append(guess, 0.0 * guess), value):
            continue
        try:
            q, _ = static_equilibrium(model, wind, guess)
        except (SceneError, np.linalg.LinAlgError):
            continue
        state = np.append(q[0], np.zeros(model.size))
        if any(np.max(np.abs(state - other) / problem.scale) < SAME for other in known):
            continue
        known.append(state)
        if _is_inside(limits, state, value):
            yield state


def _is_inside(limits: Sequence[UserEvent], state: Array, value: float) -> bool:
    """True if no attack angle leaves the coefficient curve."""
    return all(limit.function(state[None], value) > 0.0 for limit in limits)
