"""Second and third derivatives of the static forces of devices, by differences of their tangents.

A device, such as a yoke, a spacer or a pendulum, has a force f(x) that depends on the
displacements x of its junctions alone. The kernel has its exact tangent T(x) = df/dx. With unit
vectors e_j of x and a step h,

    d2f/dx dx_j      = (T(h e_j) - T(-h e_j)) / 2h,                                              (1)
    d3f/dx dx_j dx_k = (T(h e_j + h e_k) - T(h e_j - h e_k) - T(-h e_j + h e_k)
                        + T(-h e_j - h e_k)) / 4h^2,   for j = k: (T(h e_j) - 2 T(0)
                        + T(-h e_j)) / h^2.                                                      (2)

Their errors are of the order h^2. Each is extrapolated from the steps 2h and h (Richardson), which
leaves errors of the order h^4. A tangent has an error of about 1e-16 of its largest entry; divided
by h^2, it is 1e-8 of the same entry per square metre. A bar of length l and stiffness k has a
third derivative of k/l^2; its effect on a motion is k/T times smaller, T being the pull, because
its end moves on a circle. With k/T = 1e4, an error of 1e-4 remains.
(Muravyov and Rizzi 2003, Comput. Struct. 81, 1513-1523, find the derivatives of a whole structure
by enforced displacements.)
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.engine.model import DOFS

Array = NDArray[np.float64]

STEP = 1e-3
"""The larger step h [m, rad]."""

SAME_DEVICE = 1e-9
"""Relative difference of tangents below which two devices have the same derivatives."""


@dataclass(frozen=True)
class DeviceForms:
    """Derivatives of the static force of a device at the initial equilibrium.

    Attributes
    ----------
    unknowns : ndarray of int, shape (m,)
        Its unknowns, in the order of the flat displacements of all nodes.
    second : ndarray, shape (m, m, m)
        Second derivatives of its force; symmetric.
    third : ndarray, shape (m, m, m, m)
        Third derivatives.
    """

    unknowns: NDArray[np.intp]
    second: Array
    third: Array


def device_forms(mesh: Mesh, exact: Set[int]) -> list[DeviceForms]:
    """Derivatives of all devices whose force is not linear; equal devices are computed once.

    Without the devices `exact`.
    """
    nodes, leader = mesh.model.junction_nodes()
    found: list[DeviceForms] = []
    known: list[tuple[Array, tuple[Array, Array]]] = []
    for device, junctions in enumerate(mesh.model.devices):
        if device in exact:
            continue
        at = leader[nodes[list(junctions)]]
        unknowns = (DOFS * at[:, None] + np.arange(DOFS)).ravel()
        tangent = _Tangent(mesh, device, nodes[list(junctions)])
        probe = tangent(_probe(len(unknowns)))
        scale = float(np.max(np.abs(probe)))
        if scale == 0.0:
            continue
        forms = next((one[1] for one in known if _is_same(one[0], probe, scale)), None)
        if forms is None:
            forms = _derivatives(tangent, len(unknowns))
            known.append((probe, forms))
        if np.any(forms[0]) or np.any(forms[1]):
            found.append(DeviceForms(unknowns, *forms))
    return found


def _is_same(one: Array, other: Array, scale: float) -> bool:
    """True if two tangents in the same displacement agree."""
    if one.shape != other.shape:
        return False
    return bool(np.max(np.abs(one - other)) < SAME_DEVICE * scale)


def _probe(size: int) -> Array:
    """A displacement in which devices are compared."""
    return np.asarray(0.01 * np.sin(1.0 + np.arange(size) ** 2))


class _Tangent:
    """Tangent (m, m) of a device at displacements (m,) of its junctions."""

    def __init__(self, mesh: Mesh, device: int, nodes: NDArray[np.int32]) -> None:
        self.mesh, self.device, self.nodes = mesh, device, nodes

    def __call__(self, x: Array) -> Array:
        u = np.zeros((self.mesh.model.nodes, DOFS))
        u[self.nodes] = x.reshape(-1, DOFS)
        blocks = self.mesh.model.device_tangent(
            self.device, u, inputs=self.mesh.still, stiffness=1.0
        )
        return np.asarray(blocks.swapaxes(1, 2).reshape(len(x), len(x)))


def _derivatives(tangent: _Tangent, size: int) -> tuple[Array, Array]:
    """Extrapolate (1) and (2) from two steps."""
    coarse, fine = (_differences(tangent, size, step) for step in (STEP, 0.5 * STEP))
    second, third = ((4.0 * b - a) / 3.0 for a, b in zip(coarse, fine, strict=True))
    return second, third


def _differences(tangent: _Tangent, size: int, step: float) -> tuple[Array, Array]:
    """(1) and (2) with one step; the derivatives are symmetric in all indices."""
    second, third = np.zeros((size,) * 3), np.zeros((size,) * 4)
    unit, middle = step * np.eye(size), tangent(np.zeros(size))
    for j in range(size):
        ahead, back = tangent(unit[j]), tangent(-unit[j])
        second[:, :, j] = (ahead - back) / (2.0 * step)
        third[:, :, j, j] = (ahead - 2.0 * middle + back) / step**2
        for k in range(j):
            mixed = (
                tangent(unit[j] + unit[k])
                - tangent(unit[j] - unit[k])
                - tangent(unit[k] - unit[j])
                + tangent(-unit[j] - unit[k])
            ) / (4.0 * step**2)
            third[:, :, j, k] = third[:, :, k, j] = mixed
    return second, third
