"""A span in its initial equilibrium in still air: all modes, and bases of a few shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model, Scene, SceneError
from gallop_fmu.engine.mesh import Mesh
from modal.linear.modes import FAMILIES, Family, by_family

Array = NDArray[np.float64]

MAX_ELEMENTS = 16
"""Most elements of the mesh that is reduced; more change the amplitudes by less than 0.1 %."""

MODES_PER_FAMILY: dict[Family, int] = {"vertical": 3, "horizontal": 3, "torsional": 3}
"""Mode shapes of each family and symmetry, the lowest ones."""

TANGENT_STEP = 1e-3
"""Step along a mode for differences of the tangent [modal coordinate], which are exact at any step:
the tangent is quadratic in the displacement."""

MIRROR = np.array([-1.0, 1.0, 1.0, 1.0])
"""Signs of the family displacements in the mirror image of a motion about mid-span."""

SIGN_OFFSET = 1e-12
"""Added to a mid-span displacement whose sign is taken: the sign of 0 is positive."""


@dataclass(frozen=True)
class StillAirModes:
    """A span in its initial equilibrium in still air: its matrices and all natural modes.

    Attributes
    ----------
    mesh : Mesh
        The finite elements.
    frequencies : ndarray, shape (mode,)
        Natural angular frequencies [rad/s], ascending.
    shapes : ndarray, shape (mode, node, 4)
        Mass-normalised mode shapes.
    family : list of str
        Family of each mode, as in `modal.Mode`.
    symmetric : ndarray of bool, shape (mode,)
        True for modes that are rather symmetric about mid-span than antisymmetric.
    mass, damping, stiffness : ndarray, shape (4 node, 4 node)
        Matrices of the whole span, with the springs of the supports.
    """

    mesh: Mesh
    frequencies: Array
    shapes: Array
    family: list[Family]
    symmetric: NDArray[np.bool_]
    mass: Array
    damping: Array
    stiffness: Array

    @property
    def model(self) -> Model:
        """The model of the span."""
        return self.mesh.model

    @property
    def free(self) -> NDArray[np.bool_]:
        """Unknowns that are not prescribed, shape (4 node,)."""
        return self.mesh.free.ravel()

    def first(self, family: Family) -> int:
        """Number of the first symmetric mode of a family.

        Raises
        ------
        SceneError
            If there is none.
        """
        for number, (found, symmetric) in enumerate(zip(self.family, self.symmetric, strict=True)):
            if found == family and symmetric:
                return number
        raise SceneError(
            f"the span has no symmetric {family} mode on a mesh of {self.model.elements} elements"
        )


def still_air_modes(scene: Scene, elements: int = MAX_ELEMENTS) -> StillAirModes:
    """Matrices and all modes about the initial equilibrium in still air.

    Parameters
    ----------
    scene
        The span.
    elements
        Largest number of elements of the mesh.

    Raises
    ------
    SceneError
        If the initial equilibrium is unstable.
    """
    from scipy.linalg import eigh

    if scene.numerics.elements > elements:
        coarse = scene.numerics.model_copy(update={"elements": elements})
        scene = scene.model_copy(
            update={"numerics": coarse}
        )  # a valid number: the check of a whole scene takes 10 ms
    mesh = Mesh(Model(scene))
    mass, damping, stiffness = (
        mesh.dense_tangent(**{part: 1.0}) for part in ("mass", "damping", "stiffness")
    )
    free = np.flatnonzero(mesh.free)
    squares, vectors = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)])
    if squares[0] <= 0.0:
        raise SceneError(
            "the initial equilibrium is unstable in still air, so it has no natural modes; check"
            " the units of ice.first_moment_x2 and of conductor.torsional_stiffness"
        )
    flat = np.zeros((len(squares), mesh.free.size))
    flat[:, free] = vectors.T
    shapes = flat.reshape(-1, *mesh.free.shape)
    turned = by_family(scene, shapes)
    dominant = _dominant_family(turned, mass)
    sign = np.sign(turned[np.arange(len(shapes)), mesh.model.middle, dominant] + SIGN_OFFSET)
    return StillAirModes(
        mesh=mesh,
        frequencies=np.sqrt(squares),
        shapes=shapes * sign[:, None, None],
        family=[FAMILIES[i] for i in dominant],
        symmetric=np.sum(turned * turned[:, ::-1] * MIRROR, axis=(1, 2)) > 0.0,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
    )


def _dominant_family(turned: Array, mass: Array) -> NDArray[np.intp]:
    """Number of the family with the largest kinetic energy in each motion (mode, node, 4)."""
    nodes = turned.shape[1]
    blocks = mass.reshape(nodes, 4, nodes, 4)
    energy = [
        np.einsum("mi,ij,mj->m", turned[:, :, f], blocks[:, f, :, f], turned[:, :, f])
        for f in range(4)
    ]
    return np.asarray(np.argmax(energy, axis=0))


def stiffness_derivative(modes: StillAirModes, direction: Array) -> Array:
    """Derivative of the stiffness (4 nodes, 4 nodes) along nodal displacements (node, 4).

    The tangent is quadratic in the displacement, so its central difference is exact.
    """
    ahead, back = (
        modes.model.tangent(side * TANGENT_STEP * direction, stiffness=1.0, inputs=modes.mesh.still)
        for side in (1.0, -1.0)
    )
    return modes.mesh.assemble_dense((ahead - back) / (2.0 * TANGENT_STEP))


def mirrored(scene: Scene) -> bool:
    """True if the span has mirror symmetry about mid-span."""
    return scene.span.height_difference == 0.0 and scene.supports.left == scene.supports.right


def choose(
    modes: StillAirModes,
    symmetric: tuple[bool, ...],
    counts: Mapping[Family, int] = MODES_PER_FAMILY,
) -> list[int]:
    """Numbers of the lowest modes of each family and of the wanted symmetries."""
    chosen: list[int] = []
    for family, count in counts.items():
        for kind in symmetric:
            alike = [
                i for i, f in enumerate(modes.family) if f == family and modes.symmetric[i] == kind
            ]
            chosen += alike[:count]
    return chosen
