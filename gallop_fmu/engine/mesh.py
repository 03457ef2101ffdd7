"""The finite elements of a span or line, for analyses with the kernel's own forces and matrices.

Shape functions, Gauss points, normals, wind load and element matrices are those of the compiled
kernel; nothing here is a formula of its own, except the mean wind at the sections.
"""

from __future__ import annotations

import ctypes as c
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.line_map import LineMap
from gallop_fmu.engine.model import DOFS, Model
from gallop_fmu.engine.pack import double_pointer
from gallop_fmu.foundation.argument_checks import finite, numbers
from gallop_fmu.scene.wind_consistency import towers_of

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]

SECTIONS, STRAIN_POINTS = 3, 2
"""Gauss points of an element: for inertia, ice and wind; for tension and twisting moment."""


@dataclass(frozen=True)
class Sections:
    """Sections at which inertia, ice and wind are integrated, from left to right.

    Attributes
    ----------
    shape : ndarray, shape (3, 3)
        Shape function of each node (column) at each section of an element (row).
    length : ndarray, shape (section,)
        Length [m] of conductor that belongs to each section.
    normal : ndarray, shape (section, 2)
        Upward normal n2 of the conductor in its vertical plane, along x1 and x2. Wind and ice act
        in the plane of n2 and x3.
    nodes : ndarray, shape (element, 3)
        Numbers of the nodes of each element: left, middle, right.
    """

    shape: Array
    length: Array
    normal: Array
    nodes: NDArray[np.intp]

    def motion(self, nodal: Array) -> Array:
        """Interpolate nodal motion: along n2, along x3, and twist.

        Parameters
        ----------
        nodal : ndarray, shape (node, 4, ...)
            u1, u2, u3 and theta of the nodes, or their rates; further axes are kept.

        Returns
        -------
        ndarray, shape (3, section, ...)
        """
        at = nodal[self.nodes]
        u1, u2, u3, theta = np.einsum("pn,eni...->iep...", self.shape, at).reshape(
            DOFS, -1, *nodal.shape[2:]
        )
        n1, n2 = self.normal.T.reshape(2, -1, *(1 for _ in nodal.shape[2:]))
        return np.stack([n1 * u1 + n2 * u2, u3, theta])


@dataclass(frozen=True)
class StrainPoints:
    """Points at which tension and twisting moment are integrated, from left to right.

    Attributes
    ----------
    length : ndarray, shape (point,)
        Length [m] of conductor that belongs to each point.
    tangent : ndarray, shape (point, 3)
        Unit tangent X' of the conductor in the initial equilibrium.
    shape_slope : ndarray, shape (element, 2, 3)
        Derivative of each node's shape function by the arc length [1/m].
    nodes : ndarray, shape (element, 3)
        Numbers of the nodes of each element: left, middle, right.
    """

    length: Array
    tangent: Array
    shape_slope: Array
    nodes: NDArray[np.intp]

    def slope(self, nodal: Array) -> Array:
        """Derivative by the arc length of nodal motion (node, 4, ...), shape (point, 4, ...)."""
        at = nodal[self.nodes]
        by_element = np.einsum("epn,eni...->epi...", self.shape_slope, at)
        return np.asarray(by_element.reshape(-1, *nodal.shape[1:]))


@dataclass(frozen=True, slots=True)
class AeroLoad:
    """Quasi-steady aerodynamic load per unit length on sections.

    Attributes
    ----------
    force : ndarray, shape (3, ...)
        F2 along n2 and F3 along x3 [N/m], moment M about x1 [N m/m].
    slopes : ndarray, shape (4, 3, ...), or None
        Derivatives of `force` by theta, v2, v3 and omega. By the wind speed: minus that by v3.
    angle : ndarray, shape (...)
        Attack angle [rad].
    excess : ndarray, shape (...)
        By how much [rad] the angle, less whole turns, is beyond the last breakpoint of the curve
        (positive) or before the first one (negative), where a simulation would end; else 0.
    """

    force: Array
    slopes: Array | None
    angle: Array
    excess: Array


def nodes_of_elements(line: LineMap) -> NDArray[np.intp]:
    """Numbers of the nodes of each element: left, middle, right; shape (element, 3)."""
    of_chains = [
        chain.first_node + 2 * np.arange(chain.elements)[:, None] + np.arange(3)
        for chain in line.chains
    ]
    return np.concatenate(of_chains)


class Mesh:
    """The finite elements of a model.

    Where conductors meet in a junction, each has an end node there; all but one of them, its
    *followers*, move as the other one, the *leader*. Matrices of the whole model have the forces on
    followers in the rows of their leaders; rows and columns of followers are zero.

    Parameters
    ----------
    model
        The span or line; it must accept inputs.

    Attributes
    ----------
    spring : ndarray, shape (2, 3)
        Stiffness [N/m] of the support springs, left and right, along x1, x2, x3; 0 where the end is
        prescribed.
    free : ndarray of bool, shape (node, 4)
        Unknowns that are not prescribed, without those of followers.
    leader : ndarray of int, shape (node,)
        Node whose motion each node has: itself, or its leader.
    nodes : ndarray, shape (element, 3)
        Numbers of the nodes of each element: left, middle, right.
    still : Inputs
        No wind and towers at rest.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.still = Inputs.still(model.scene)
        self.spring = np.zeros((2, 3))
        self.spring[:, [0, 2]] = model.equilibrium().support_stiffness
        is_free = np.empty((model.nodes, DOFS), dtype=np.int32)
        pointer = is_free.ctypes.data_as(c.POINTER(c.c_int32))
        _insist(kernel.gallop_free_unknowns(model.handle, pointer))
        self.free = is_free.astype(np.bool_)
        self.nodes = nodes_of_elements(model.map)
        self._junction_nodes, self.leader = model.junction_nodes()

    @cached_property
    def sections(self) -> Sections:
        """Sections at which inertia, ice and wind are integrated."""
        count = SECTIONS * self.model.elements
        shape, length, normal = np.empty((3, 3)), np.empty(count), np.empty((count, 2))
        _insist(
            kernel.gallop_sections(
                self.model.handle, *(double_pointer(y) for y in (shape, length, normal))
            )
        )
        return Sections(shape, length, normal, self.nodes)

    @cached_property
    def steady_wind(self) -> Array:
        """Wind along n2 and x3 at the sections per m/s of speed, shape (2, section).

        With the mean direction and the profile of the scene, without gusts: see `gallop_field` in
        ``kernel/gallop_scene.h``.
        """
        scene, sections = self.model.scene, self.sections
        x = self.model.equilibrium().x[sections.nodes]
        place = np.einsum("pn,eni->epi", sections.shape, x).reshape(-1, 3)
        factor = np.ones(len(place))
        if (profile := scene.wind.profile) is not None:
            ground = np.interp(place[:, 0], *profile.ground([x1 for x1, _ in towers_of(scene)]))
            factor = profile.factor(place[:, 1] - ground)
        yaw = np.radians(scene.wind.mean_direction)
        along, across = np.sin(yaw) * sections.normal[:, 0], np.full(len(place), np.cos(yaw))
        return np.asarray(factor * np.stack([along, across]))

    @cached_property
    def strain_points(self) -> StrainPoints:
        """Points at which tension and twisting moment are integrated."""
        elements = self.model.elements
        count = STRAIN_POINTS * elements
        length, tangent = np.empty(count), np.empty((count, 3))
        shape_slope = np.empty((elements, STRAIN_POINTS, 3))
        _insist(
            kernel.gallop_strain_points(
                self.model.handle, *(double_pointer(y) for y in (length, tangent, shape_slope))
            )
        )
        return StrainPoints(length, tangent, shape_slope, self.nodes)

    @cached_property
    def node_normal(self) -> Array:
        """Upward normal n2 at the nodes along x1 and x2, shape (node, 2)."""
        normal = np.empty((self.model.nodes, 2))
        _insist(kernel.gallop_node_normals(self.model.handle, double_pointer(normal)))
        return normal

    def seed(self) -> Array:
        """Initial disturbance of the scene: u1, u2, u3 [m] and theta [rad], shape (node, 4)."""
        u = np.empty((self.model.nodes, DOFS))
        _insist(kernel.gallop_seed(self.model.handle, double_pointer(u)))
        return u

    def assemble(self, elements: Array) -> csc_array:
        """Add up element matrices to that of the whole span.

        Parameters
        ----------
        elements : ndarray, shape (element, 12, 12)
            Rows and columns: left, middle, right node, each u1 u2 u3 theta.

        Returns
        -------
        sparse array, shape (4 node, 4 node)
        """
        from scipy.sparse import csc_array  # slow to import

        size = DOFS * self.model.nodes
        place, rows, first = _pattern(self.nodes.tobytes(), self.model.nodes)
        values = np.bincount(place, elements.ravel(), len(rows))
        total = csc_array((values, rows.copy(), first.copy()), shape=(size, size))
        total.has_canonical_format = True
        return total

    def assemble_dense(self, elements: Array) -> Array:
        """Add up element matrices as `assemble` does, to an array: faster on small meshes."""
        size = DOFS * self.model.nodes
        place = _dense_places(self.nodes.tobytes(), self.model.nodes)
        total = np.bincount(place, elements.ravel(), size * size)
        return np.asarray(total.reshape(size, size), dtype=np.float64)

    def gather(self, matrix: csc_array) -> csc_array:
        """Move rows and columns of followers to their leaders in a matrix (4 node, 4 node)."""
        if self._gathering is None:
            return matrix
        gathered: csc_array = (self._gathering @ matrix @ self._gathering.T).tocsc()
        return gathered

    def spread(self, nodal: NDArray[Any]) -> NDArray[Any]:
        """Give followers the values of their leaders, in values (node, ...)."""
        return np.asarray(nodal[self.leader])

    @cached_property
    def _gathering(self) -> csc_array | None:
        """Matrix that adds forces on followers to those on leaders; None: there are none."""
        from scipy.sparse import csc_array  # slow to import

        own = np.arange(len(self.leader))
        if np.array_equal(self.leader, own):
            return None
        place = np.arange(DOFS)
        rows = (DOFS * self.leader[:, None] + place).ravel()
        columns = (DOFS * own[:, None] + place).ravel()
        return csc_array((np.ones(rows.size), (rows, columns)), shape=(rows.size, rows.size))

    def device_tangents(self, *motion: ArrayLike | None, **options: Any) -> csc_array:
        """The tangents of all devices, by the arguments of `tangent`, as a matrix of all nodes."""
        from scipy.sparse import coo_array, csc_array  # slow to import

        size = DOFS * self.model.nodes
        rows, columns, values = [], [], []
        for device, junctions in enumerate(self.model.devices):
            unknowns = DOFS * self._junction_nodes[list(junctions)][:, None] + np.arange(DOFS)
            blocks = self.model.device_tangent(device, *motion, **options)
            rows.append(np.broadcast_to(unknowns[:, None, :, None], blocks.shape).ravel())
            columns.append(np.broadcast_to(unknowns[None, :, None, :], blocks.shape).ravel())
            values.append(blocks.ravel())
        if not values:
            return csc_array((size, size))
        places = np.concatenate(rows), np.concatenate(columns)
        total = csc_array(coo_array((np.concatenate(values), places), shape=(size, size)).tocsc())
        total.eliminate_zeros()
        return total

    def tangent(
        self,
        u: ArrayLike | None = None,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        **options: Any,
    ) -> csc_array:
        """Matrix ``stiffness dR/du + damping dR/dv + mass dR/da`` of the whole model.

        Parameters
        ----------
        u, v, a, **options
            As in `Model.tangent`; the matrix includes the devices, such as support springs.

        Returns
        -------
        sparse array, shape (4 node, 4 node)
        """
        total = self.assemble(self.model.tangent(u, v, a, **options))
        devices = self.device_tangents(u, v, a, **options)
        # A sum has no stored zeros, which change the order of a factorisation and so the last bits.
        if devices.nnz or options.get("stiffness"):
            total = total + devices
        return self.gather(total)

    def dense_tangent(self, u: ArrayLike | None = None, **options: float) -> Array:
        """Return the matrix of `tangent` in still air as an array: faster on small meshes.

        Parameters
        ----------
        u, **options
            As in `tangent`.
        """
        if self._gathering is not None:
            return np.asarray(self.tangent(u, inputs=self.still, **options).toarray())
        total = self.assemble_dense(self.model.tangent(u, inputs=self.still, **options))
        for device, junctions in enumerate(self.model.devices):
            unknowns = (
                DOFS * self._junction_nodes[list(junctions)][:, None] + np.arange(DOFS)
            ).ravel()
            blocks = self.model.device_tangent(device, u, inputs=self.still, **options)
            square = blocks.swapaxes(1, 2).reshape(len(unknowns), -1)
            np.add.at(total, np.ix_(unknowns, unknowns), square)
        return total

    def aero_load(
        self,
        theta: ArrayLike,
        v2: ArrayLike,
        v3: ArrayLike,
        omega: ArrayLike,
        wind_speed: ArrayLike,
        *,
        attack_angle: float | None = None,
        slopes: bool = False,
        element: int = 0,
    ) -> AeroLoad:
        """Aerodynamic load on sections in any motion (Liu et al. 2009, equations 20 and 21).

        Parameters
        ----------
        theta, v2, v3, omega, wind_speed : array_like
            Twist [rad], velocities along n2 and x3 [m/s], twist rate [rad/s], wind speed [m/s], of
            shapes that can be broadcast together.
        attack_angle
            Initial angle [rad] of the ice; None: the scene's.
        slopes
            True: compute the derivatives, too.
        element
            Element with the conductor and the curve.

        Raises
        ------
        ValueError
            If a number is not finite.
        """
        given = (theta, v2, v3, omega, wind_speed)
        shape = np.broadcast(*given).shape
        motion = np.empty((5, *shape))
        for i, values in enumerate(given):
            motion[i] = values
        count, initial = motion[0].size, self.still.attack_angle
        if attack_angle is not None:
            initial = finite("attack_angle", attack_angle)
        # One block for all results: making a pointer takes longer than computing 45 sections.
        block = np.empty((5 + (12 if slopes else 0), *shape))
        start, row = block.__array_interface__["data"][0], 8 * count
        refused = kernel.gallop_aero_load(
            self.model.handle,
            element,
            initial,
            count,
            motion.__array_interface__["data"][0],
            start,
            start + 5 * row if slopes else None,
            start + 3 * row,
            start + 4 * row,
        )
        if refused:
            numbers("motion", motion, motion.shape)
        _insist(refused)
        by = block[5:].reshape(4, 3, *shape) if slopes else None
        return AeroLoad(block[:3], by, block[3], block[4])


@lru_cache(maxsize=16)
def _dense_places(nodes: bytes, count: int) -> NDArray[np.intp]:
    """Place of each entry of the element matrices in the array of all nodes; see `_pattern`."""
    rows, columns = _entries(nodes)
    return DOFS * count * rows + columns


def _entries(nodes: bytes) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row and column of each entry of the element matrices."""
    of_elements = np.frombuffer(nodes, dtype=np.intp).reshape(-1, 3)
    unknowns = (DOFS * of_elements[:, :, None] + np.arange(DOFS)).reshape(-1, 3 * DOFS)
    return np.repeat(unknowns, 3 * DOFS, axis=1).ravel(), np.tile(unknowns, 3 * DOFS).ravel()


@lru_cache(maxsize=16)  # meshes of equal topology have the same
def _pattern(
    nodes: bytes, count: int
) -> tuple[NDArray[np.intp], NDArray[np.int32], NDArray[np.int32]]:
    """Where each entry of the element matrices is in the matrix of all nodes.

    Parameters
    ----------
    nodes
        Numbers of the nodes of each element.
    count
        Number of nodes.

    Returns
    -------
    ndarray, ndarray, ndarray
        Place of each entry among the stored numbers; their rows; and the first of each column.
    """
    size = DOFS * count
    rows, columns = _entries(nodes)
    stored, place = np.unique(size * columns + rows, return_inverse=True)
    first = np.searchsorted(stored, size * np.arange(size + 1))
    return place, (stored % size).astype(np.int32), first.astype(np.int32)


def _insist(outcome: int) -> None:
    """Raise where the kernel refused; every argument was checked before."""
    if outcome:
        raise RuntimeError(f"the kernel refused a call with outcome {outcome}")
