"""A span in the coordinates of a few shapes: u = shape_1 q_1 + shape_2 q_2 + ...

Forces and matrices of all nodes become those of the coordinates by the principle of virtual work: a
force does the same work on every shape.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.mesh import Mesh

Array = NDArray[np.float64]


class Projection:
    """Motion and forces in the coordinates of a few shapes.

    Parameters
    ----------
    mesh
        The span.
    shapes : ndarray, shape (mode, node, 4)
        Displacements [m, rad] per unit coordinate.

    Attributes
    ----------
    section : ndarray, shape (3, mode, section)
        The shapes at the sections: along n2, along x3, twist.
    weighted : ndarray, shape (3, section, mode)
        The same times the length of conductor that belongs to each section.
    """

    def __init__(self, mesh: Mesh, shapes: Array) -> None:
        self.mesh, self.shapes = mesh, shapes
        self._flat = shapes.reshape(len(shapes), -1)
        at_sections = mesh.sections.motion(np.moveaxis(shapes, 0, -1))
        self.section = at_sections.transpose(0, 2, 1).copy()
        self.weighted = at_sections * mesh.sections.length[:, None]

    def keep_left_half(self) -> None:
        """Keep the sections up to mid-span, which then count for both halves.

        The shapes must be symmetric. A section at mid-span counts once.
        """
        count = self.section.shape[2]
        kept = (count + 1) // 2
        times = np.full(kept, 2.0)
        times[count // 2 :] = 1.0
        self.section = self.section[:, :, :kept].copy()
        self.weighted = self.weighted[:, :kept] * times[:, None]

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.shapes)

    def matrix(self, nodal: Any) -> Array:
        """Project a matrix of the whole span, dense or sparse (4 node, 4 node), on (mode, mode)."""
        return np.asarray(self._flat @ (nodal @ self._flat.T))

    def force(self, nodal: Array) -> Array:
        """Project nodal forces (node, 4) [N, N m] on (mode,)."""
        return np.asarray(self._flat @ nodal.ravel())

    def at_sections(self, coordinates: Array) -> Array:
        """Motion at the sections of coordinates (instant, mode), shape (3, instant, section)."""
        return np.asarray(coordinates @ self.section)

    def collect(self, load: Array) -> Array:
        """Project loads per unit length (3, instant, section) on (instant, mode)."""
        of_each = load @ self.weighted
        return np.asarray(of_each[0] + of_each[1] + of_each[2])
