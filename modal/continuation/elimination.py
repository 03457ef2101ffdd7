"""Elimination of the inner nodes of the mesh intervals, in all intervals at once.

The linearised collocation equations of an interval of length h are, with the values D and L of the
slopes and of the Lagrange polynomials at the Gauss points, J = df/dy there and t = h T,

    sum over k of (D_ik - t L_ik J_i) y_k + c_i p = 0,                                           (1)

where p are the changes of the period, of the parameter, and -1 (for the right-hand side). They give
the nodes 1 to m by node 0 and p: y_k = -(G_k y_0 + g_k p).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from modal.continuation.collocation import DEGREE, SLOPE, VALUE

Array = NDArray[np.float64]

SLOPE_INVERSE: Array = np.asarray(np.linalg.inv(SLOPE[:, 1:]), dtype=float)
INTEGRAL: Array = SLOPE_INVERSE @ VALUE
"""Nodal values 1 to m of the integral over 0..s of a function, by its nodal values 0 to m."""

INTEGRAL_AT_GAUSS: Array = VALUE[:, 1:] @ INTEGRAL
"""The same at the Gauss points."""


def eliminate(jacobian: Array, time: Array, columns: Array) -> Array:
    """Eliminate the nodes of a system of first order.

    Parameters
    ----------
    jacobian : ndarray, shape (interval, m, n, n)
        J at the Gauss points.
    time : ndarray, shape (interval,)
        Duration t of each interval.
    columns : ndarray, shape (interval, m, n, 3)
        c.

    Returns
    -------
    ndarray, shape (interval, m n, n + 3)
        G and g.
    """
    count, m, n, _ = jacobian.shape
    local = -time[:, None, None, None] * jacobian
    matrix = local[:, :, :, None, :] * VALUE[:, None, :, None]
    diagonal = np.arange(n)
    matrix[:, :, diagonal, :, diagonal] += SLOPE
    right = matrix[:, :, :, 1:].reshape(count, m * n, m * n)
    left = matrix[:, :, :, 0].reshape(count, m * n, n)
    return np.asarray(
        np.linalg.solve(right, np.concatenate([left, columns.reshape(count, m * n, 3)], axis=2))
    )


def eliminate_second_order(jacobian: Array, time: Array, columns: Array) -> Array:
    """Eliminate the nodes of a system q' = v, v' = a(q, v) with half the unknowns.

    The equations of q give q_k = q_0 + t (integral of v)_k - (SLOPE_INVERSE c p)_k. In those of v,

        sum over k of D_ik v_k - t Jq_i q(s_i) - t Jv_i v(s_i) + c_i p = 0,

    only v remains, with q(s_i) = q_0 + t sum over k of INTEGRAL_AT_GAUSS_ik v_k + ...

    Parameters and result are those of `eliminate`; only the lower half of the Jacobian is read.
    """
    count, m, n, _ = jacobian.shape
    half = n // 2
    t = time[:, None, None, None]
    by_q, by_v = t * jacobian[:, :, half:, :half], t * jacobian[:, :, half:, half:]
    twice = t * by_q
    matrix = np.multiply(by_v[:, :, :, None, :], -VALUE[:, None, :, None])
    matrix -= twice[:, :, :, None, :] * INTEGRAL_AT_GAUSS[:, None, :, None]
    diagonal = np.arange(half)
    matrix[:, :, diagonal, :, diagonal] += SLOPE
    shift = np.einsum("ik,jkac->jiac", SLOPE_INVERSE, columns[:, :, :half])
    shift_at_gauss = np.einsum("ik,jkac->jiac", VALUE[:, 1:], shift)
    left = np.concatenate(
        [-by_q, matrix[:, :, :, 0], columns[:, :, half:] + by_q @ shift_at_gauss], axis=3
    )
    solved = np.linalg.solve(
        matrix[:, :, :, 1:].reshape(count, m * half, m * half),
        left.reshape(count, m * half, n + 3),
    ).reshape(count, m, half, n + 3)
    result = np.empty((count, DEGREE, n, n + 3))
    result[:, :, half:] = solved
    result[:, :, :half] = t * np.einsum("ik,jkac->jiac", INTEGRAL[:, 1:], solved)
    result[:, :, diagonal, diagonal] -= 1.0
    result[:, :, diagonal, half + diagonal] -= time[:, None, None] * INTEGRAL[:, 0, None]
    result[:, :, :half, n:] += shift
    return result.reshape(count, m * n, n + 3)
