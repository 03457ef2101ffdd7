"""Natural modes of a span about its initial equilibrium, from the kernel's own mass and stiffness."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, cast

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Model, Scene, SceneError

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
Family = Literal["longitudinal", "vertical", "horizontal", "torsional"]

FAMILIES: tuple[Family, ...] = ("longitudinal", "vertical", "horizontal", "torsional")
"""The family of the modes in which u1, u2, u3 or theta has the largest part, in the order of the unknowns of a node."""

NODAL_LINE = 1e-3
"""Displacements below this part of the largest one have no sign when the half-waves of a mode are counted."""


@dataclass(frozen=True)
class Mode:
    """One natural mode of small undamped motion in still air.

    Attributes
    ----------
    frequency_hz : float
        Natural frequency [Hz].
    family : str
        ``"vertical"``, ``"horizontal"``, ``"torsional"`` or ``"longitudinal"``: the largest of `shares`.
    shares : dict of str to float
        Kinetic energy of each family as a part of their sum. The coupling through eccentric ice belongs to no family
        and is left out.
    symmetric : bool
        Whether the motion is rather its own mirror image about mid-span than the opposite of it.
    loops : int
        Half-waves of the family's displacement along the span.
    shape : ndarray, shape (node, 4)
        u1, u2, u3 and theta per unit of the modal coordinate [1/sqrt(kg), rad/(m sqrt(kg))]; its modal mass is 1, and
        its first half-wave from the left is positive.
    """

    frequency_hz: float
    family: Family
    shares: dict[Family, float]
    symmetric: bool
    loops: int
    shape: Array = field(repr=False)


@dataclass(frozen=True)
class _Matrices:
    """Mass and stiffness of the unknowns that may move, and where these stand among the four of every node."""

    mass: csc_array
    stiffness: csc_array
    free: NDArray[np.bool_]  # (node, 4)


def natural_modes(scene: Scene, count: int = 12) -> list[Mode]:
    """Lowest natural modes about the initial equilibrium, in still air and without damping.

    Mass and stiffness are those of the simulation: with the sag, the elasticity of the conductor and its supports, and
    the eccentric ice, whose weight and inertia couple the twist to the displacements.

    Parameters
    ----------
    scene
        The span; its mesh is ``numerics.elements``.
    count
        Number of modes.

    Returns
    -------
    list of Mode
        In order of frequency.

    Raises
    ------
    SceneError
        If `count` is not possible on this mesh, or the initial equilibrium is unstable.
    SimulationError
        If no initial equilibrium exists.
    """
    matrices = _assemble(scene)
    unknowns = matrices.mass.shape[0]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= unknowns:
        raise SceneError(
            f"count = {count}: must be a whole number from 1 to {unknowns}, the unknowns of a mesh of "
            f"{scene.numerics.elements} elements; ask for fewer modes or raise numerics.elements"
        )
    if not _is_stable(matrices.stiffness):
        raise SceneError(
            f"the initial equilibrium is unstable: with ice.first_moment_x2 = {scene.ice.first_moment_x2} kg the "
            "weight of the ice turns the conductor over, whose conductor.torsional_stiffness is "
            f"{scene.conductor.torsional_stiffness} N m2/rad; lower the first or raise the second, and check the units"
        )
    squares, vectors = _lowest(matrices, count)
    return [
        _describe(matrices, float(np.sqrt(square)) / (2.0 * np.pi), vector)
        for square, vector in zip(squares, vectors.T, strict=True)
    ]


def _assemble(scene: Scene) -> _Matrices:
    from scipy.sparse import coo_array, csc_array  # a tenth of a second, which `import modal` should not cost

    model = Model(scene)
    still = Inputs(time=0.0, wind_speed=0.0, attack_angle=0.0, support=np.zeros((2, 3)))
    free = np.ones((model.nodes, 4), dtype=np.bool_)
    springs = np.zeros((model.nodes, 4))
    for end, stiffness in zip((0, -1), model.equilibrium().support_stiffness, strict=True):
        springs[end, [0, 2]] = stiffness
        free[end] = springs[end] > 0.0
    unknown = 8 * np.arange(model.elements)[:, None] + np.arange(12)  # neighbours share the four of a corner node
    rows = np.repeat(unknown, 12, axis=1).ravel()
    columns = np.tile(unknown, 12).ravel()
    kept = np.flatnonzero(free)

    def assembled(elements: Array, diagonal: Array) -> csc_array:
        total = coo_array((elements.ravel(), (rows, columns)), shape=(free.size, free.size)).tocsc()
        total = total + coo_array((diagonal.ravel(), (np.arange(free.size),) * 2)).tocsc()
        return csc_array(total[kept][:, kept])

    return _Matrices(
        assembled(model.tangent(mass=1.0, inputs=still), np.zeros_like(springs)),
        assembled(model.tangent(stiffness=1.0, inputs=still), springs),
        free,
    )


def _is_stable(stiffness: csc_array) -> bool:
    """Whether all eigenvalues are positive: as many are negative as pivots of a factorisation (Sylvester)."""
    from scipy.sparse.linalg import splu

    factors = splu(stiffness, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return bool(np.all(factors.U.diagonal() > 0.0))


def _lowest(matrices: _Matrices, count: int) -> tuple[Array, Array]:
    """Squared angular frequencies [1/s2] in ascending order, and mass-normalised vectors in the columns."""
    unknowns = matrices.mass.shape[0]
    if count < unknowns - 1:
        from scipy.sparse.linalg import eigsh

        start = np.random.default_rng(0).standard_normal(unknowns)  # the same digits every time
        squares, vectors = eigsh(matrices.stiffness, count, matrices.mass, sigma=0.0, v0=start)
    else:  # Lanczos' method needs more unknowns than modes
        from scipy.linalg import eigh

        squares, vectors = eigh(matrices.stiffness.toarray(), matrices.mass.toarray(), subset_by_index=(0, count - 1))
    order = np.argsort(squares)
    return squares[order], vectors[:, order]


def _describe(matrices: _Matrices, frequency_hz: float, vector: Array) -> Mode:
    shape = np.zeros(matrices.free.shape)
    shape[matrices.free] = vector
    parts = np.zeros((4, vector.size))
    column = np.nonzero(matrices.free)[1]
    parts[column, np.arange(vector.size)] = vector
    energy = np.einsum("fi,if->f", parts, matrices.mass @ parts.T)
    share = energy / energy.sum()
    dominant = int(np.argmax(share))
    wave = shape[:, dominant]
    mirrored = -wave[::-1] if FAMILIES[dominant] == "longitudinal" else wave[::-1]
    signs = np.sign(wave[np.abs(wave) > NODAL_LINE * np.max(np.abs(wave))])
    return Mode(
        frequency_hz=frequency_hz,
        family=FAMILIES[dominant],
        shares=cast(dict[Family, float], dict(zip(FAMILIES, share.tolist(), strict=True))),
        symmetric=bool(wave @ mirrored > 0.0),
        loops=1 + int(np.count_nonzero(np.diff(signs))),
        shape=shape * signs[0],
    )
