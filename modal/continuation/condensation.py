"""Solution of the bordered almost-block-diagonal systems of orthogonal collocation.

On each mesh interval j the equations are linear in the values y_j at its left end, in the values
z_j at its other nodes (the last of them is y_j+1), and in two parameters p (period, parameter):

    L_j y_j + R_j z_j + C_j p = d_j,                                                             (1)
    sum over j of (w_j z_j + v_j y_j) = e    (border rows),        y_N = y_0.                    (2)

First, z_j is eliminated in all intervals at once, which leaves equations

    A_j y_j + B_j y_j+1 + E_j p = f_j                                                            (3)

between the ends of the intervals. Then every second y_j is eliminated from the two equations that
contain it, with pivots from the rows of both, until one equation A y_0 + B y_N + E p = f remains
(structured LU with row partial pivoting, Wright 1992). It has the monodromy matrix
M = -B^-1 A, which is never formed: multipliers are eigenvalues of the pencil (A, B), accurate where
products of transfer matrices are not (Fairgrieve and Jepson 1991).

References
----------
Wright, S. J. (1992). Stable parallel algorithms for two-point boundary value problems. SIAM J. Sci.
Stat. Comput. 13, 742-764.
Fairgrieve, T. F., Jepson, A. D. (1991). O.K. Floquet multipliers. SIAM J. Numer. Anal. 28,
1446-1462.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARAMETERS = 2
"""Columns of the parameters; the column behind them is the right-hand side."""


class _Level(NamedTuple):
    """Relation of the eliminated values to their neighbours: y = -(left y_l + right y_r + E p)."""

    left: Array
    right: Array
    rest: Array


class Condensed:
    """The system after elimination of all but the values at the ends of the period.

    Parameters
    ----------
    solved : ndarray, shape (interval, m n, n + 3)
        R^-1 (L, C, d) of (1): `modal.continuation.elimination`.
    borders : ndarray, shape (border, interval, m n)
        Border rows: weights of the left end and of all nodes but the last of each interval.
    corner : ndarray, shape (border, 3)
        Weights of the parameters in the border rows, and their right-hand side e.

    Attributes
    ----------
    first, last : ndarray, shape (n, n)
        A and B of the remaining equation.
    final : ndarray, shape (n + 2, n + 2)
        Matrix of the remaining equations for y_0 and p.
    """

    def __init__(self, solved: Array, borders: Array, corner: Array) -> None:
        n = solved.shape[2] - PARAMETERS - 1
        self._inner, self._inner_rest = solved[:, :, :n], solved[:, :, n:]
        weights, corner = self._condense_borders(borders, corner, n)
        a = solved[:, -n:, :n]
        b = np.broadcast_to(np.eye(n), a.shape)
        e = solved[:, -n:, n:]
        self._levels: list[_Level] = []
        while len(a) > 1:
            a, b, e, weights, corner = self._halve(a, b, e, weights, corner)
        self.first, self.last, self._rest = a[0], b[0], e[0]
        self.final = np.vstack(
            [
                np.hstack([a[0] + b[0], e[0, :, :PARAMETERS]]),
                np.hstack([weights[:, 0] + weights[:, 1], corner[:, :PARAMETERS]]),
            ]
        )
        self._final_rest = np.concatenate([e[0, :, PARAMETERS], corner[:, PARAMETERS]])

    def _condense_borders(self, borders: Array, corner: Array, n: int) -> tuple[Array, Array]:
        """Express the border rows by the values at the ends of the intervals and by p."""
        count, intervals, width = borders.shape
        inner = np.zeros((count, intervals, width))
        inner[:, :, :-n] = borders[:, :, n:]  # nodes 1 to m - 1; the last belongs to the next
        weights = np.zeros((count, intervals + 1, n))
        weights[:, :-1] = borders[:, :, :n] - np.einsum("bjw,jwn->bjn", inner, self._inner)
        change = np.einsum("bjw,jwc->bc", inner, self._inner_rest)
        return weights, corner - change

    def _halve(
        self, a: Array, b: Array, e: Array, weights: Array, corner: Array
    ) -> tuple[Array, Array, Array, Array, Array]:
        """Eliminate every second value, with the largest pivots of the two equations."""
        n, pairs = a.shape[1], len(a) // 2
        even, odd = slice(0, 2 * pairs, 2), slice(1, 2 * pairs, 2)
        eliminated = np.concatenate([b[even], a[odd]], axis=1)
        others = np.zeros((pairs, 2 * n, 2 * n + e.shape[2]))
        others[:, :n, :n], others[:, n:, n : 2 * n] = a[even], b[odd]
        others[:, :n, 2 * n :], others[:, n:, 2 * n :] = e[even], e[odd]
        solved, left_over = np.empty((2, pairs, n, others.shape[2]))
        for k in range(pairs):
            factors, order = _factorised(eliminated[k])
            pivotal, rest = order[:n], order[n:]
            solved[k] = _solved(factors, others[k, pivotal])
            left_over[k] = others[k, rest] - eliminated[k, rest] @ solved[k]
        level = _Level(solved[:, :, :n], solved[:, :, n : 2 * n], solved[:, :, 2 * n :])
        self._levels.append(level)
        middle = weights[:, 1 : 2 * pairs : 2].swapaxes(0, 1)
        kept = np.concatenate([weights[:, 0 : 2 * pairs + 1 : 2], weights[:, 2 * pairs + 1 :]], 1)
        changes = middle @ solved
        kept[:, :pairs] -= changes[:, :, :n].swapaxes(0, 1)
        kept[:, 1 : pairs + 1] -= changes[:, :, n : 2 * n].swapaxes(0, 1)
        return (
            np.concatenate([left_over[:, :, :n], a[2 * pairs :]]),
            np.concatenate([left_over[:, :, n : 2 * n], b[2 * pairs :]]),
            np.concatenate([left_over[:, :, 2 * n :], e[2 * pairs :]]),
            kept,
            corner - changes[:, :, 2 * n :].sum(axis=0),
        )

    def solve(self, cutoff: float = 0.0) -> tuple[Array, Array]:
        """Solve for the right-hand side, and for a unit in the last border row.

        Parameters
        ----------
        cutoff
            Relative singular value of the final matrix below which nothing moves in its direction.

        Returns
        -------
        ndarray, ndarray
            Both solutions: nodal values without the end of the period, then the two parameters.
        """
        unit = np.zeros(len(self.final))
        unit[-1] = 1.0
        found = solve_regularised(self.final, np.stack([self._final_rest, unit], axis=1), cutoff)
        n = len(self.first)
        first, second = found[:, 0], found[:, 1]
        return (
            self.expand(first[:n], first[:n], first[n:], 1.0),
            self.expand(second[:n], second[:n], second[n:], 0.0),
        )

    def null_vector(self) -> Array:
        """Solution of the homogeneous equations where they are singular, of any length."""
        rows = np.linalg.norm(self.final, axis=1, keepdims=True)
        vector = np.linalg.svd(self.final / rows)[2][-1]
        n = len(self.first)
        return self.expand(vector[:n], vector[:n], vector[n:], 0.0)

    def expand(self, start: Array, end: Array, parameters: Array, rest: float) -> Array:
        """Compute all nodal values from those at the ends of the period.

        Parameters
        ----------
        start, end : ndarray, shape (n,)
            Values at the start and the end of the period.
        parameters : ndarray, shape (2,)
            Changes of period and parameter.
        rest
            Factor of the right-hand side.
        """
        factors = np.append(parameters, -rest)
        y = np.stack([start, end])
        for level in reversed(self._levels):
            pairs = len(level.left)
            middle = -(
                np.einsum("jnk,jk->jn", level.left, y[:pairs])
                + np.einsum("jnk,jk->jn", level.right, y[1 : pairs + 1])
                + level.rest @ factors
            )
            wide = np.empty((len(y) + pairs, y.shape[1]))
            wide[0 : 2 * pairs + 1 : 2] = y[: pairs + 1]
            wide[1 : 2 * pairs : 2] = middle
            wide[2 * pairs + 1 :] = y[pairs + 1 :]
            y = wide
        inner = -(np.einsum("jwn,jn->jw", self._inner, y[:-1]) + self._inner_rest @ factors)
        n = y.shape[1]
        nodes = np.concatenate([y[:-1], inner[:, :-n]], axis=1)
        return np.concatenate([nodes.ravel(), parameters])


def _factorised(matrix: Array) -> tuple[Array, NDArray[np.intp]]:
    """LU factors of the pivotal rows of a tall matrix (2 n, n), and the order of its rows.

    Raises
    ------
    LinAlgError
        If its columns are linearly dependent.
    """
    from scipy.linalg.lapack import dgetrf  # slow to import

    factors, pivots, fault = dgetrf(matrix)
    if fault:
        raise np.linalg.LinAlgError("Singular matrix")
    order = list(range(len(matrix)))
    for row, pivot in enumerate(pivots.tolist()):
        order[row], order[pivot] = order[pivot], order[row]
    return factors[: matrix.shape[1]], np.array(order)


def _solved(factors: Array, right: Array) -> Array:
    """Solution for right-hand sides whose rows are in the order of the factors."""
    from scipy.linalg.lapack import dgetrs

    found: Array = dgetrs(factors, np.arange(len(factors)), right)[0]
    return found


def solve_regularised(matrix: Array, right: Array, cutoff: float) -> Array:
    """Solve equations; with a cutoff, without motion in the direction of a tiny singular value.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Its rows are scaled to length 1.
    right : ndarray, shape (n, column)
        Right-hand sides.
    cutoff
        Singular value, relative to the largest, below which the least one counts as zero.
    """
    if cutoff == 0.0:
        return np.asarray(np.linalg.solve(matrix, right))
    rows = np.linalg.norm(matrix, axis=1, keepdims=True)
    u, values, v = np.linalg.svd(matrix / rows)
    inverse = 1.0 / values
    if values[-1] < cutoff * values[0]:
        inverse[-1] = 0.0
    return np.asarray(v.T @ (inverse[:, None] * (u.T @ (right / rows))))
