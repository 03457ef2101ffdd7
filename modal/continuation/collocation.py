"""Piecewise polynomials on a mesh of the period, and the choice of the mesh.

An orbit is a polynomial of degree m on each of N intervals of the scaled time 0..1, given by its
values at m + 1 equally spaced nodes; neighbours share the node between them. The differential
equations hold at the m Gauss points of each interval. With h the length of an interval, the error
between the nodes is

    e = psi h^(m+1) y^(m+1),    psi = max over s of |1/m! integral 0..s of (x - z_1)...(x - z_m)|,

with z_i the Gauss points of 0..1 (de Boor and Swartz 1973); at the ends of the intervals, it is of
order h^(2 m). The derivative of order m + 1 is estimated from those of order m in neighbouring
intervals, and the mesh is chosen so that all intervals have the same error (Russell and
Christiansen 1978; the same rule is used by COLSYS and AUTO).

References
----------
de Boor, C., Swartz, B. (1973). Collocation at Gaussian points. SIAM J. Numer. Anal. 10, 582-606.
Russell, R. D., Christiansen, J. (1978). Adaptive mesh selection strategies for solving boundary
value problems. SIAM J. Numer. Anal. 15, 59-80.
"""

from __future__ import annotations

from functools import lru_cache
from math import factorial

import numpy as np
from numpy.polynomial import Polynomial, legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREE = 4
"""Degree m of the polynomials."""

MIN_INTERVALS, MAX_INTERVALS = 8, 160
"""Least and largest number of mesh intervals."""

TARGET = 0.2
"""Error that a new mesh is made for, relative to the largest allowed."""

MAX_GROWTH = 2.0
"""Largest factor by which the number of intervals grows at once."""

SMOOTHING = 0.1
"""Share of the mean error density that is added everywhere, so that no interval is very long."""

_gauss, _weights = legendre.leggauss(DEGREE)
GAUSS: Array = 0.5 * (_gauss + 1.0)
"""Gauss points of an interval 0..1."""

WEIGHTS: Array = 0.5 * _weights
"""Weights of the Gauss points."""

NODES: Array = np.linspace(0.0, 1.0, DEGREE + 1)
"""Nodes of an interval 0..1."""


def lagrange(points: Array) -> tuple[Array, Array]:
    """Values and derivatives of the Lagrange polynomials of the nodes at points of 0..1.

    Returns
    -------
    ndarray, ndarray, shape (point, node)
        Values and derivatives.
    """
    powers = np.vander(NODES, increasing=True)
    coefficients = np.linalg.inv(powers)
    order = np.arange(DEGREE + 1)
    value = points[:, None] ** order
    slope = order * points[:, None] ** np.maximum(order - 1, 0)
    return value @ coefficients, slope @ coefficients


VALUE, SLOPE = lagrange(GAUSS)
EXTREME_POINTS = 16
_DENSE = lagrange(np.arange(EXTREME_POINTS) / EXTREME_POINTS)[0]
_highest = np.linalg.inv(np.vander(NODES, increasing=True))[DEGREE] * factorial(DEGREE)


def _error_constant() -> float:
    """The constant psi."""
    product = Polynomial.fromroots(GAUSS) / factorial(DEGREE)
    return float(np.max(np.abs(product.integ()(np.linspace(0.0, 1.0, 201)))))


ERROR_CONSTANT = _error_constant()


@lru_cache(maxsize=64)
def block_index(intervals: int) -> NDArray[np.intp]:
    """Number of each node of each interval, shape (interval, m + 1); the last node is the first."""
    index = np.arange(intervals)[:, None] * DEGREE + np.arange(DEGREE + 1)
    return np.asarray(index % (intervals * DEGREE))


def blocks(nodes: Array) -> Array:
    """Nodal values (node, n) of a periodic function by interval: (interval, m + 1, n)."""
    return np.asarray(nodes[block_index(len(nodes) // DEGREE)])


def node_times(mesh: Array) -> Array:
    """Scaled times of all nodes but the end of the period."""
    return np.asarray((mesh[:-1, None] + np.diff(mesh)[:, None] * NODES[:-1]).ravel())


def evaluate(mesh: Array, nodes: Array, times: Array) -> Array:
    """Values (time, n) of a periodic piecewise polynomial at scaled times."""
    times = np.mod(times, 1.0)
    interval = np.clip(np.searchsorted(mesh, times, side="right") - 1, 0, len(mesh) - 2)
    local = (times - mesh[interval]) / np.diff(mesh)[interval]
    return np.asarray(np.einsum("tk,tkn->tn", lagrange(local)[0], blocks(nodes)[interval]))


def mean(mesh: Array, nodes: Array) -> Array:
    """Mean over the period of each component: (n,)."""
    at_gauss = np.einsum("ik,jkn->jin", VALUE, blocks(nodes))
    return np.asarray(np.einsum("j,i,jin->n", np.diff(mesh), WEIGHTS, at_gauss))


def extremes(nodes: Array) -> tuple[Array, Array]:
    """Lowest and highest value of each component over the period: two of (n,).

    They are read at `EXTREME_POINTS` points of each interval, and refined by a parabola.
    """
    values = np.einsum("sk,jkn->jsn", _DENSE, blocks(nodes)).reshape(-1, nodes.shape[1])
    found = []
    for sign in (-1.0, 1.0):
        top = np.argmax(sign * values, axis=0)
        left, middle, right = (
            np.take_along_axis(values, (top + shift)[None] % len(values), axis=0)[0]
            for shift in (-1, 0, 1)
        )
        bend = left - 2.0 * middle + right
        flat = np.abs(bend) < np.finfo(float).tiny
        slope = 0.5 * (right - left)
        found.append(middle - np.where(flat, 0.0, 0.5 * slope**2 / np.where(flat, 1.0, bend)))
    return found[0], found[1]


def _high_derivative(mesh: Array, nodes: Array) -> Array:
    """Estimate of the absolute derivative of order m + 1 in each interval: (interval, n)."""
    h = np.diff(mesh)
    derivative = np.einsum("k,jkn->jn", _highest, blocks(nodes)) / h[:, None] ** DEGREE
    distance = 0.5 * (h + np.roll(h, -1))
    jump = np.abs(np.roll(derivative, -1, axis=0) - derivative) / distance[:, None]
    return np.asarray(0.5 * (jump + np.roll(jump, 1, axis=0)))


def interval_errors(mesh: Array, nodes: Array) -> Array:
    """Estimated error of each component in each interval: (interval, n)."""
    h = np.diff(mesh)[:, None]
    return np.asarray(ERROR_CONSTANT * h ** (DEGREE + 1) * _high_derivative(mesh, nodes))


def equidistributed(mesh: Array, errors: Array, intervals: int) -> Array:
    """Choose a mesh with the same error in all intervals.

    Parameters
    ----------
    mesh
        Present mesh.
    errors : ndarray, shape (interval,)
        Relative error in each of its intervals.
    intervals
        Number of intervals of the new mesh.
    """
    h = np.diff(mesh)
    density = errors ** (1.0 / (DEGREE + 1)) / h
    density = density + SMOOTHING * float(density @ h) + np.finfo(float).tiny
    total = np.concatenate([[0.0], np.cumsum(density * h)])
    return np.asarray(np.interp(np.linspace(0.0, total[-1], intervals + 1), total, mesh))


def wanted_intervals(intervals: int, error: float, tolerance: float) -> int:
    """Number of intervals at which the error becomes `TARGET` times the tolerance."""
    growth = (error / (TARGET * tolerance)) ** (1.0 / (DEGREE + 1))
    wanted = int(np.ceil(intervals * min(growth, MAX_GROWTH)))
    return int(np.clip(wanted, MIN_INTERVALS, MAX_INTERVALS))
