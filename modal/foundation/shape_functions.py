"""The simulation's three-node element seen from Python: shape functions, Gauss points and section planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GAUSS2 = np.array([-1.0, 1.0]) / np.sqrt(3.0)
"""Abscissae at which the kernel integrates stiffness."""

GAUSS3 = np.array([-1.0, 0.0, 1.0]) * np.sqrt(0.6)
"""Abscissae at which the kernel integrates inertia and wind load: the sections."""

GAUSS3_WEIGHT = np.array([5.0, 8.0, 5.0]) / 9.0


def shape(xi: Array) -> Array:
    """Quadratic shape functions (Liu et al. 2009, eq. 5), shape (point, node)."""
    return np.stack([0.5 * xi * (xi - 1.0), 1.0 - xi**2, 0.5 * xi * (xi + 1.0)], axis=1)


def slope(xi: Array) -> Array:
    """Derivatives of the shape functions by xi, shape (point, node)."""
    return np.stack([xi - 0.5, -2.0 * xi, xi + 0.5], axis=1)


def nodes_of(elements: int) -> NDArray[np.intp]:
    """Numbers of the nodes of each element, shape (element, 3)."""
    return 2 * np.arange(elements)[:, None] + np.arange(3)


def normal_to(tangent: Array) -> Array:
    """n2 = e3 x t of tangents (..., 3) in the plane of x1 and x2: components along x1 and x2, shape (..., 2)."""
    length = np.hypot(tangent[..., 0], tangent[..., 1])
    return np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1) / length[..., None]


def node_normal(x: Array, node: int) -> Array:
    """n2 at a node of a mesh with places x (node, 3); of the mean direction where two elements meet."""
    elements = len(x) // 2
    first = node // 2 if node % 2 or node == 0 else node // 2 - 1
    last = node // 2 if node // 2 < elements else first
    total = np.zeros(3)
    for e in range(first, last + 1):
        tangent = slope(np.array([float(node - 2 * e - 1)]))[0] @ x[2 * e : 2 * e + 3]
        total += tangent / np.linalg.norm(tangent)
    return normal_to(total)


@dataclass(frozen=True)
class Sections:
    """The sections at which wind load and ice inertia are integrated, in order along the span.

    Attributes
    ----------
    length : ndarray, shape (section,)
        Length [m] of conductor that belongs to each.
    normal : ndarray, shape (section, 2)
        n2, the upward normal of the conductor in its vertical plane, along x1 and x2. Wind and ice
        act in the plane of n2 and x3.
    """

    length: Array
    normal: Array

    @classmethod
    def of(cls, x: Array) -> Sections:
        """Of a mesh with nodes at x, shape (node, 3) [m]."""
        tangent = np.einsum("pn,eni->epi", slope(GAUSS3), x[nodes_of(len(x) // 2)]).reshape(-1, 3)
        stretch = np.linalg.norm(tangent, axis=1).reshape(-1, len(GAUSS3))
        return cls((GAUSS3_WEIGHT * stretch).ravel(), normal_to(tangent))

    def motion(self, nodal: Array) -> Array:
        """Nodal motion (node, 4, ...) at the sections: along n2, along x3, and twist; shape (3, section, ...)."""
        at = nodal[nodes_of(len(nodal) // 2)]
        u1, u2, u3, theta = np.einsum("pn,eni...->iep...", shape(GAUSS3), at).reshape(
            4, -1, *nodal.shape[2:]
        )
        along = self.normal.reshape(len(self.normal), 2, *(1 for _ in nodal.shape[2:]))
        return np.stack([along[:, 0] * u1 + along[:, 1] * u2, u3, theta])
