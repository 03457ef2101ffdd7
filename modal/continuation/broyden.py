"""Corrections of a solution with the matrix of a linearisation nearby, by Broyden's method.

They need only the residual, and cost a fraction of a linearisation. The updates of the matrix are
those of Kelley (1995), Iterative methods for linear and nonlinear equations, SIAM, algorithm brsol.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modal.continuation.equations import Equations, Linear, length

Array = NDArray[np.float64]

MAX_CORRECTIONS, MAX_RATE, USUAL_RATE = 7, 0.5, 0.05
"""Largest number of corrections; largest ratio of successive ones, and the ratio that is expected
at least."""


def improved(
    equations: Equations,
    x: Array,
    phase: Array,
    condition: tuple[Array, float],
    near: tuple[Linear, float],
    tolerance: float,
) -> tuple[Array, int]:
    """Improve a solution until the next correction is expected to be small.

    Parameters
    ----------
    equations
        Equations on their mesh.
    x, phase : ndarray
        The solution, and the orbit y_0 of the phase condition.
    condition
        Row and right-hand side of condition (1) of `modal.continuation.equations`.
    near
        A linearisation nearby, and the length of the correction before; the first correction is
        made if it is shorter.
    tolerance
        Length of a small correction, relative to 1 + the length of x.

    Returns
    -------
    ndarray, int
        The solution, and the number of corrections.
    """
    (row, place), (linear, first) = condition, near
    moves, duals, sizes = list[Array](), list[Array](), [first]
    allowed = tolerance * (1.0 + length(equations, x))
    while len(moves) < MAX_CORRECTIONS:
        change = equations.correction(x, phase, row, float(row @ x) - place, linear)
        if change is None:
            break
        for k, move in enumerate(moves):
            part = float(duals[k] @ change) / float(duals[k] @ move)
            if k < len(moves) - 1:
                change = change + part * moves[k + 1]
            else:
                change = change / (1.0 - min(part, MAX_RATE))
        size = length(equations, change)
        if not size < MAX_RATE * sizes[-1]:
            break
        x = x + change
        moves.append(change)
        duals.append(equations.dual(change))
        sizes.append(size)
        if size * max(size / sizes[-2], USUAL_RATE) < allowed:
            break
    return x, len(moves)
