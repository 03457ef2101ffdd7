"""Elimination of the inner nodes of the mesh intervals, in all intervals at once.

The linearised collocation equations of an interval of length h are, with the values D and L of the
slopes and of the Lagrange polynomials at the Gauss points, J = df/dy there and t = h T,

    sum over k of (D_ik - t L_ik J_i) y_k + c_i p = 0,                                           (1)

where p are the changes of the period, of the parameter, and -1 (for the right-hand side). They give
the nodes 1 to m by node 0 and p: y_k = -(G_k y_0 + g_k p).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from modal.continuation.collocation import SLOPE, VALUE

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


class Factors(NamedTuple):
    """Factors of the matrices of the inner nodes of a system of second order.

    Attributes
    ----------
    matrices : list of tuple of ndarray
        LU factors and pivots of each interval.
    by_q : ndarray, shape (interval, n/2, m, n/2)
        t Jq at the Gauss points, transposed: (interval, column, m, row).
    time : ndarray, shape (interval,)
        Duration t of each interval.
    """

    matrices: list[tuple[Array, Array]]
    by_q: Array
    time: Array

    def solve(self, column: Array) -> Array:
        """Eliminate the nodes for another right-hand side c (interval, m, n): g (interval, m n)."""
        from scipy.linalg.lapack import dgetrs  # slow to import

        count, m, n = column.shape
        half = n // 2
        shift = SLOPE_INVERSE @ column[:, :, :half]
        right = column[:, :, half:] + np.einsum(
            "jib,jbia->jia", VALUE[:, 1:] @ shift, self.by_q, optimize=False
        )
        result = np.empty((count, m, n))
        for j, (factors, pivots) in enumerate(self.matrices):
            result[j, :, half:] = dgetrs(factors, pivots, right[j].ravel())[0].reshape(m, half)
        result[:, :, :half] = INTEGRAL[:, 1:] @ result[:, :, half:]
        result[:, :, :half] *= self.time[:, None, None]
        result[:, :, :half] += shift
        return result.reshape(count, m * n)


def eliminate_second_order(jacobian: Array, time: Array, columns: Array) -> tuple[Array, Factors]:
    """Eliminate the nodes of a system q' = v, v' = a(q, v) with half the unknowns.

    The equations of q give q_k = q_0 + t (integral of v)_k - (SLOPE_INVERSE c p)_k. In those of v,

        sum over k of D_ik v_k - t Jq_i q(s_i) - t Jv_i v(s_i) + c_i p = 0,

    only v remains, with q(s_i) = q_0 + t sum over k of INTEGRAL_AT_GAUSS_ik v_k + ...

    Parameters and the first result are those of `eliminate`; only the lower half of the Jacobian is
    read. The second result solves for other right-hand sides.
    """
    from scipy.linalg.lapack import dgesv  # slow to import

    count, m, n, _ = jacobian.shape
    half = n // 2
    t = time[:, None, None, None]
    # Transposed (interval, column, m, row), so that LAPACK need not copy
    by_q, by_v = (
        np.ascontiguousarray((t * part).transpose(0, 3, 1, 2))
        for part in (jacobian[:, :, half:, :half], jacobian[:, :, half:, half:])
    )
    twice = t * by_q
    matrix = np.empty((count, m, half, m, half))
    diagonal = np.arange(half)
    for k in range(m):
        np.multiply(by_v, -VALUE[:, k + 1, None], out=matrix[:, k])
        matrix[:, k] -= twice * INTEGRAL_AT_GAUSS[:, k + 1, None]
        matrix[:, k, diagonal, :, diagonal] += SLOPE[:, k + 1]
    shift = np.einsum("ik,jkac->jcia", SLOPE_INVERSE, columns[:, :, :half])
    shift_at_gauss = np.einsum("ik,jckb->jcib", VALUE[:, 1:], shift)
    right = np.empty((count, n + 3, m, half))
    np.negative(by_q, out=right[:, :half])
    right[:, half:n] = -VALUE[:, 0, None] * by_v - INTEGRAL_AT_GAUSS[:, 0, None] * twice
    right[:, half + diagonal, :, diagonal] += SLOPE[:, 0]
    right[:, n:] = columns[:, :, half:].transpose(0, 3, 1, 2)
    right[:, n:] += np.einsum("jcib,jbia->jcia", shift_at_gauss, by_q)
    result = np.empty((count, n + 3, m, n))
    matrices = []
    for j in range(count):
        factors, pivots, solved, fault = dgesv(
            matrix[j].reshape(m * half, -1).T, right[j].reshape(n + 3, -1).T, True, True
        )
        if fault:
            raise np.linalg.LinAlgError("Singular matrix")
        matrices.append((factors, pivots))
        result[j, :, :, half:] = solved.T.reshape(n + 3, m, half)
    result[..., :half] = t * np.einsum("ik,jcka->jcia", INTEGRAL[:, 1:], result[..., half:])
    result[:, diagonal, :, diagonal] -= 1.0
    result[:, half + diagonal, :, diagonal] -= time[:, None] * INTEGRAL[:, 0]
    result[:, n:, :, :half] += shift
    solved = result.reshape(count, n + 3, m * n).swapaxes(1, 2)
    return solved, Factors(matrices, by_q, time)
