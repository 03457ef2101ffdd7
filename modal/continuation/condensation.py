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

from modal.continuation.elimination import Factors

Array = NDArray[np.float64]

PARAMETERS = 2
"""Columns of the parameters; the column behind them is the right-hand side."""


class _Level(NamedTuple):
    """Elimination of every second value: y = -(left y_l + right y_r + E p).

    With the pivotal rows P of the two equations of each value and the other rows O of its matrices,
    left, right and E are P^-1 of the pivotal rows, and the rest is that of the other rows less O
    times these.
    """

    left: Array
    right: Array
    factors: list[Array]
    order: NDArray[np.intp]
    others: Array

    def reduce(self, columns: Array) -> tuple[Array, Array]:
        """Solution of the pivotal rows, and what is left of the others: (pair, n, column).

        The right-hand sides have shape (pair, 2 n, column).
        """
        return _reduced(self.factors, self.order, self.others, columns)


class _Borders(NamedTuple):
    """Border rows and parameters after elimination.

    Attributes
    ----------
    final : ndarray, shape (n + 2, n + 2)
        Matrix of the remaining equations for y_0 and p.
    right : ndarray, shape (n + 2,)
        Their right-hand side.
    inner : ndarray, shape (interval, m n, 3)
        R^-1 (C, d) of (1).
    of_levels : list of ndarray, shape (pair, n, 3)
        E of each level.
    """

    final: Array
    right: Array
    inner: Array
    of_levels: list[Array]


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
    nodes
        Factors of R, for `correction`.

    Attributes
    ----------
    first, last : ndarray, shape (n, n)
        A and B of the remaining equation.
    """

    def __init__(
        self, solved: Array, borders: Array, corner: Array, nodes: Factors | None = None
    ) -> None:
        self._nodes = nodes
        n = solved.shape[2] - PARAMETERS - 1
        self._inner = solved[:, :, :n]
        a = solved[:, -n:, :n]
        b = np.broadcast_to(np.eye(n), a.shape)
        self._levels: list[_Level] = []
        while len(a) > 1:
            a, b = self._halve(a, b)
        self.first, self.last = a[0], b[0]
        self._borders = self._bordered(solved[:, :, n:], borders, corner)

    @property
    def final(self) -> Array:
        """Matrix of the remaining equations for y_0 and p, shape (n + 2, n + 2)."""
        return self._borders.final

    def _halve(self, a: Array, b: Array) -> tuple[Array, Array]:
        """Eliminate every second value, with the largest pivots of the two equations."""
        n, pairs = a.shape[1], len(a) // 2
        even, odd = slice(0, 2 * pairs, 2), slice(1, 2 * pairs, 2)
        matrices = np.concatenate([b[even], a[odd]], axis=1)
        neighbours = np.zeros((pairs, 2 * n, 2 * n))
        neighbours[:, :n, :n], neighbours[:, n:, n:] = a[even], b[odd]
        found = [_factorised(one) for one in matrices]
        factors, order = [one for one, _ in found], np.array([one for _, one in found])
        others = np.take_along_axis(matrices, order[:, n:, None], axis=1)
        solved, rest = _reduced(factors, order, others, neighbours)
        self._levels.append(_Level(solved[:, :, :n], solved[:, :, n:], factors, order, others))
        return (
            np.concatenate([rest[:, :, :n], a[2 * pairs :]]),
            np.concatenate([rest[:, :, n:], b[2 * pairs :]]),
        )

    def _bordered(self, inner: Array, borders: Array, corner: Array) -> _Borders:
        """Eliminate the same values from the border rows and the columns of the parameters."""
        count, intervals, width = borders.shape
        n = len(self.first)
        at_inner = np.zeros((intervals, count, width))
        at_inner[:, :, :-n] = borders[:, :, n:].swapaxes(0, 1)  # the last node is of the next
        weights = np.zeros((intervals + 1, count, n))
        weights[:-1] = borders[:, :, :n].swapaxes(0, 1) - at_inner @ self._inner
        corner = corner - (at_inner @ inner).sum(axis=0)
        e, of_levels = inner[:, -n:], list[Array]()
        for level in self._levels:
            pairs = len(level.left)
            found, rest = level.reduce(e[: 2 * pairs].reshape(pairs, 2 * n, -1))
            middle = weights[1 : 2 * pairs : 2]
            kept = np.concatenate([weights[0 : 2 * pairs + 1 : 2], weights[2 * pairs + 1 :]])
            kept[:pairs] -= middle @ level.left
            kept[1 : pairs + 1] -= middle @ level.right
            corner = corner - (middle @ found).sum(axis=0)
            weights, e = kept, np.concatenate([rest, e[2 * pairs :]])
            of_levels.append(found)
        final = np.vstack(
            [
                np.hstack([self.first + self.last, e[0, :, :PARAMETERS]]),
                np.hstack([weights[0] + weights[1], corner[:, :PARAMETERS]]),
            ]
        )
        right = np.concatenate([e[0, :, PARAMETERS], corner[:, PARAMETERS]])
        return _Borders(final, right, inner, of_levels)

    def correction(self, column: Array, borders: Array, corner: Array) -> Array:
        """Solution for another right-hand side and other border rows; see `solve`.

        Parameters
        ----------
        column : ndarray, shape (interval, m, n)
            d of (1).
        borders, corner
            As of `Condensed`.
        """
        assert self._nodes is not None
        inner = self._borders.inner.copy()
        inner[:, :, PARAMETERS] = self._nodes.solve(column)
        found = self._bordered(inner, borders, corner)
        solved: Array = np.asarray(np.linalg.solve(found.final, found.right), dtype=float)
        n = len(self.first)
        return self._expanded(found, np.stack([solved[:n], solved[:n]]), solved[n:], 1.0)

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
        right = np.stack([self._borders.right, unit], axis=1)
        found = solve_regularised(self.final, right, cutoff)
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
        return self._expanded(self._borders, np.stack([start, end]), parameters, rest)

    def _expanded(self, borders: _Borders, y: Array, parameters: Array, rest: float) -> Array:
        """Compute all nodal values from those at the ends of the period, y (2, n)."""
        factors = np.append(parameters, -rest)
        for level, column in zip(reversed(self._levels), reversed(borders.of_levels), strict=True):
            pairs = len(level.left)
            middle = -(
                np.einsum("jnk,jk->jn", level.left, y[:pairs])
                + np.einsum("jnk,jk->jn", level.right, y[1 : pairs + 1])
                + column @ factors
            )
            wide = np.empty((len(y) + pairs, y.shape[1]))
            wide[0 : 2 * pairs + 1 : 2] = y[: pairs + 1]
            wide[1 : 2 * pairs : 2] = middle
            wide[2 * pairs + 1 :] = y[pairs + 1 :]
            y = wide
        inner = -(np.einsum("jwn,jn->jw", self._inner, y[:-1]) + borders.inner @ factors)
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


def _reduced(
    factors: list[Array], order: NDArray[np.intp], others: Array, columns: Array
) -> tuple[Array, Array]:
    """Reduce right-hand sides as `_Level.reduce` does."""
    from scipy.linalg.lapack import dgetrs  # slow to import

    n = order.shape[1] // 2
    in_order = np.take_along_axis(columns, order[:, :, None], axis=1)
    solved, unmoved = np.empty((len(order), n, columns.shape[2])), np.arange(n)
    for k, one in enumerate(factors):
        solved[k] = dgetrs(one, unmoved, in_order[k, :n])[0]
    return solved, in_order[:, n:] - others @ solved


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
