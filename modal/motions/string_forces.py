"""Forces of strings in the coordinates of a reduced line.

The displacements of a clamp are x = X q: where one string carries one clamp, the quasi-static
displacements w of `modal.motions.line_model` are zero, because the shapes have the static
displacements under a force on the clamp along each axis. There, the force of a string is that of
the kernel at x, without a truncation. This is necessary: with the stiffness k of a string of length
l, the clamp rises by x3^2/2l as the string swings, and the truncation of this to the second order
changes the stiffness against the swing by a part of k (x3/l)^4, which is not small beside P/l, P
being the pull.

At a yoke or a bundle on several strings, w is not zero at each clamp. The static force is expanded
there to the third order (`modal.motions.device_forms`), and only the damping is that of the kernel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import MappedTower
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.engine.model import DOFS

Array = NDArray[np.float64]


def has_exact_string(tower: MappedTower) -> bool:
    """True if one string or V-string carries one clamp of a tower."""
    return tower.has_string and len(tower.junctions) == 1


class StringForces:
    """Forces of one string, V-string or yoke beyond its linear stiffness in still air.

    Parameters
    ----------
    mesh
        The line.
    device
        The string.
    shapes : ndarray, shape (mode, node, 4)
        Shapes of the coordinates.
    is_exact
        True: its static force is that of the kernel; False: it has none here, only damping.

    Attributes
    ----------
    damping : ndarray, shape (mode, mode)
        Its damping matrix at rest.
    """

    def __init__(self, mesh: Mesh, device: int, shapes: Array, is_exact: bool) -> None:
        self._model, self._device, self._is_exact = mesh.model, device, is_exact
        nodes, leader = mesh.model.junction_nodes()
        at = leader[nodes[list(mesh.model.devices[device])]]
        self._junctions = len(at)
        self._x = np.ascontiguousarray(shapes[:, at].reshape(len(shapes), -1))
        still = np.zeros((1, len(shapes)))
        self._at_rest, self._stiffness, damping = (one[0] for one in self._load(still, still))
        self.damping: Array = self._x @ damping @ self._x.T
        self._is_damped = bool(np.any(damping))

    def _load(self, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Force (instant, m) and its derivatives (instant, m, m) by displacement and velocity."""
        shape = (len(q), self._junctions, DOFS)
        force, *slopes = self._model.device_load(
            self._device, (q @ self._x).reshape(shape), (v @ self._x).reshape(shape)
        )
        size = self._x.shape[1]
        by_u, by_v = (one.swapaxes(2, 3).reshape(len(q), size, size) for one in slopes)
        return force.reshape(len(q), size), by_u, by_v

    def add_static(self, q: Array, force: Array, stiffness: Array) -> None:
        """Add the static force less its linear part to a force and to its derivative.

        Parameters
        ----------
        q : ndarray, shape (instant, mode)
            Coordinates.
        force, stiffness : ndarray, shape (instant, mode) and (instant, mode, mode)
            What is added to.
        """
        if not self._is_exact:
            return
        load, by_u, _ = self._load(q, np.zeros_like(q))
        force += (load - self._at_rest - q @ self._x @ self._stiffness.T) @ self._x.T
        stiffness += self._x @ (by_u - self._stiffness) @ self._x.T

    def add_damping(self, q: Array, v: Array, force: Array, by_q: Array, by_v: Array) -> None:
        """Add the damping force D(x) x' to a force and to its derivatives by q and v."""
        if not self._is_damped:
            return
        moving, slope, damping = self._load(q, v)
        load, stiffness, _ = self._load(q, np.zeros_like(q))
        force += (moving - load) @ self._x.T
        by_q += self._x @ (slope - stiffness) @ self._x.T
        by_v += self._x @ damping @ self._x.T

    def add_force(self, q: Array, v: Array, force: Array) -> None:
        """Add the forces of `add_static` and `add_damping` to a force, without derivatives."""
        load = self._load(q, v if self._is_damped else np.zeros_like(q))[0]
        if self._is_exact:
            load -= self._at_rest + q @ self._x @ self._stiffness.T
        elif self._is_damped:
            load -= self._load(q, np.zeros_like(q))[0]
        else:
            return
        force += load @ self._x.T
