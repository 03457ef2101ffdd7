"""Modes of a span about its equilibrium, in still air or mean wind, from the kernel's own tangents."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.linear.linearise import Linearised, WindState, linearised, uniform

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Family = Literal["longitudinal", "vertical", "horizontal", "torsional"]

FAMILIES: tuple[Family, ...] = ("longitudinal", "vertical", "horizontal", "torsional")
"""The family of the modes that move mostly along the chord, across it in the vertical plane, along x3, or that twist.
On a level span these are u1, u2, u3 and theta, the unknowns of a node; see `by_family`."""

NODAL_LINE = 1e-3
"""Displacements below this part of the largest one have no sign when the half-waves of a mode are counted."""

AT_REST = 1e-9
"""An eigenvalue whose imaginary part is below this part of its modulus does not oscillate."""


@dataclass(frozen=True)
class Mode:
    """One mode of small motion about an equilibrium, q(t) = Re[(shape + i quadrature) exp(eigenvalue t)].

    Attributes
    ----------
    frequency_hz : float
        Natural frequency [Hz], the eigenvalue's modulus over 2 pi.
    damping_ratio : float
        Part of critical damping; negative: the motion grows. Structural in still air, with the
        wind's in mean wind.
    family : str
        ``"vertical"``, ``"horizontal"``, ``"torsional"`` or ``"longitudinal"``: the largest of
        `shares`.
    shares : dict of str to float
        Kinetic energy of each family as a part of their sum. ``"longitudinal"`` and ``"vertical"``
        are the motion in the vertical plane along the chord and across it. The coupling through
        eccentric ice belongs to no family and is left out.
    symmetric : bool
        Whether the motion is rather its own mirror image about mid-span than the opposite of it.
    loops : int
        Half-waves of the family's displacement along the span.
    participation : dict of str to float
        Generalised force of a uniform load of 1 N/m along x2 ("vertical") or x3 ("horizontal"): the
        integral of the shape over the conductor [m/sqrt(kg)]. A static load p moves the modal
        coordinate by participation p / w^2; mass per unit length times its square is the mode's
        effective mass [kg], and these add up to the whole.
    eigenvalue : complex
        Of the motion [1/s], with positive imaginary part.
    shape : ndarray, shape (node, 4)
        u1, u2, u3 and theta per unit of the modal coordinate [1/sqrt(kg), rad/(m sqrt(kg))]; its
        modal mass is 1, and its first half-wave from the left is positive.
    quadrature : ndarray, shape (node, 4)
        What moves a quarter of a period ahead of `shape`; zero in still air.
    wave : ndarray, shape (node,)
        Displacement of the family in `shape`: along the chord, across it, along x3, or twist.
    """

    frequency_hz: float
    damping_ratio: float
    family: Family
    shares: dict[Family, float]
    symmetric: bool
    loops: int
    participation: dict[Literal["vertical", "horizontal"], float]
    eigenvalue: complex
    shape: Array = field(repr=False)
    quadrature: Array = field(repr=False)
    wave: Array = field(repr=False)

    @property
    def own_image(self) -> float:
        """Part of the squared `wave` that is symmetric about mid-span."""
        return 0.5 + 0.5 * float(self.wave @ self.wave[::-1]) / float(self.wave @ self.wave)


def by_family(scene: Scene, shape: NDArray[Any]) -> NDArray[Any]:
    """Displacements along the chord, across it in the vertical plane, along x3, and twist, in the order of `FAMILIES`.

    Parameters
    ----------
    scene
        The span, whose chord counts.
    shape : ndarray, shape (..., 4)
        u1, u2, u3 and theta.
    """
    chord = math.hypot(scene.span.length, scene.span.height_difference)
    cosine, sine = scene.span.length / chord, scene.span.height_difference / chord
    turned = np.array(shape)
    turned[..., 0] = cosine * shape[..., 0] + sine * shape[..., 1]
    turned[..., 1] = cosine * shape[..., 1] - sine * shape[..., 0]
    return turned


def natural_modes(scene: Scene, count: int = 12, wind: WindState = "still") -> list[Mode]:
    """Lowest modes about the initial equilibrium in still air, or about the static equilibrium in mean wind.

    Mass, damping and stiffness are those of the simulation: with the sag, the elasticity of the
    conductor and its supports, and the eccentric ice, whose weight and inertia couple the twist to
    the displacements.

    In still air the modes are those of the undamped span, and the damping ratio is phi' C phi / (2
    w). In mean wind the quasi-steady load (Liu, Yan, Zhang, Zhou 2009, eq. 20-21) adds to damping
    and stiffness, and the modes are the complex ones of M s^2 + C s + K.

    Parameters
    ----------
    scene
        The span; its mesh is ``numerics.elements``.
    count
        Number of modes.
    wind
        ``"still"``, or ``"mean"`` for the scene's mean wind.

    Returns
    -------
    list of Mode
        In order of frequency. In mean wind, what does not oscillate (damped above critical) is no
        mode and left out.

    Raises
    ------
    SceneError
        If `count` is not possible on this mesh, or the equilibrium does not exist or is statically
        unstable.
    SimulationError
        If no initial equilibrium exists.
    """
    return modes_of(linearised(scene, wind), scene, count)


def modes_of(equations: Linearised, scene: Scene, count: int) -> list[Mode]:
    """Lowest modes of equations of motion: complex where wind blows, else real."""
    mass, damping, stiffness = equations.of_free()
    unknowns = mass.shape[0]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= unknowns:
        raise SceneError(
            f"count = {count}: must be a whole number from 1 to {unknowns}, the unknowns of a mesh"
            f" of {scene.numerics.elements} elements; ask for fewer modes or raise"
            " numerics.elements"
        )
    unstable = not _is_stable(stiffness)
    if equations.wind_speed > 0.0:
        values, vectors = _complex_modes(equations, scene, count, every=unstable)
    elif unstable:
        moment = scene.ice.first_moments()[0]
        raise SceneError(
            f"the initial equilibrium is unstable: with ice.first_moment_x2 = {moment:.6g} kg at"
            " the attack angle the weight of the ice turns the conductor over, whose"
            f" conductor.torsional_stiffness is {scene.conductor.torsional_stiffness} N m2/rad;"
            " lower the first or raise the second, and check the units"
        )
    else:
        squares, real = _lowest(mass, stiffness, count)
        omega = np.sqrt(squares)
        ratio = np.einsum("im,im->m", real, damping @ real) / (2.0 * omega)
        values = omega * (-ratio + 1j * np.sqrt(np.maximum(1.0 - ratio**2, 0.0)))
        vectors = real.astype(np.complex128)
    return [
        _describe(equations, scene, complex(s), vector)
        for s, vector in zip(values, vectors.T, strict=True)
    ]


def _is_stable(stiffness: csc_array) -> bool:
    """Whether no pivot of a factorisation is negative.

    In still air as many eigenvalues are negative as pivots (Sylvester). In wind the matrix is not
    symmetric; there the sign of the determinant tells: negative, and one eigenvalue of the motion
    is real and positive.
    """
    from scipy.sparse.linalg import splu

    factors = splu(
        stiffness,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return bool(np.all(factors.U.diagonal() > 0.0))


def _lowest(mass: csc_array, stiffness: csc_array, count: int) -> tuple[Array, Array]:
    """Squared angular frequencies [1/s2] in ascending order, and mass-normalised vectors in the columns."""
    unknowns = mass.shape[0]
    if count < unknowns - 1:
        from scipy.sparse.linalg import eigsh

        squares, vectors = eigsh(stiffness, count, mass, sigma=0.0, v0=_start(unknowns))
    else:  # Lanczos' method needs more unknowns than modes
        from scipy.linalg import eigh

        squares, vectors = eigh(stiffness.toarray(), mass.toarray(), subset_by_index=(0, count - 1))
    order = np.argsort(squares)
    return squares[order], vectors[:, order]


def _complex_modes(
    equations: Linearised, scene: Scene, count: int, every: bool
) -> tuple[ComplexArray, ComplexArray]:
    """Eigenvalues [1/s] with positive imaginary part, lowest modulus first, and mass-normalised vectors."""
    matrices = equations.of_free()
    unknowns = matrices[0].shape[0]
    wanted = 2 * unknowns if every else 2 * count + 4
    while True:
        dense = wanted >= unknowns
        values, vectors = eigenpairs(*matrices) if dense else _nearest_to_zero(*matrices, wanted)
        oscillates = np.abs(values.imag) > AT_REST * np.abs(values)
        if np.any(values.real[~oscillates] > 0.0):
            raise SceneError(
                f"the equilibrium in wind of {equations.wind_speed:g} m/s is statically unstable:"
                " the conductor twists away (torsional divergence) or is blown off, because the"
                " aerodynamic moment grows faster with the twist than"
                f" conductor.torsional_stiffness = {scene.conductor.torsional_stiffness} N m2/rad"
                " resists; lower the wind, or check the slope of the moment coefficient and the"
                " attack angle"
            )
        chosen = np.flatnonzero(oscillates & (values.imag > 0.0))
        if len(chosen) >= count or dense:
            break
        wanted *= 2
    if len(chosen) < count:
        raise SceneError(
            f"count = {count}: only {len(chosen)} modes of this mesh oscillate; ask for fewer"
        )
    chosen = chosen[np.argsort(np.abs(values[chosen]))][:count]
    return values[chosen], _normalised(vectors[:unknowns, chosen], matrices[0])


def _nearest_to_zero(
    mass: csc_array, damping: csc_array, stiffness: csc_array, count: int
) -> tuple[ComplexArray, ComplexArray]:
    """Eigenpairs of M s^2 + C s + K with the smallest |s|: the largest of the inverse of the first-order form."""
    from scipy.sparse.linalg import LinearOperator, eigs, splu

    unknowns = mass.shape[0]
    factors = splu(stiffness)

    def inverse(y: Array) -> Array:
        y = y.ravel()
        return np.concatenate(
            [-factors.solve(damping @ y[:unknowns] + mass @ y[unknowns:]), y[:unknowns]]
        )

    operator = LinearOperator((2 * unknowns, 2 * unknowns), matvec=inverse, dtype=np.float64)
    inverses, vectors = eigs(operator, count, which="LM", v0=_start(2 * unknowns))
    return 1.0 / inverses, vectors


def eigenpairs(
    mass: csc_array, damping: csc_array, stiffness: csc_array
) -> tuple[ComplexArray, ComplexArray]:
    """All eigenvalues [1/s] of M s^2 + C s + K, and in the columns displacements above velocities."""
    return cast(
        tuple[ComplexArray, ComplexArray],
        tuple(np.linalg.eig(state_matrix(mass, damping, stiffness))),
    )


def state_matrix(mass: csc_array, damping: csc_array, stiffness: csc_array) -> Array:
    """First-order form of M q'' + C q' + K q = 0 for displacements above velocities, dense."""
    unknowns = mass.shape[0]
    matrix = np.zeros((2 * unknowns, 2 * unknowns))
    matrix[:unknowns, unknowns:] = np.eye(unknowns)
    matrix[unknowns:] = -np.linalg.solve(
        mass.toarray(), np.hstack([stiffness.toarray(), damping.toarray()])
    )
    return matrix


def _start(size: int) -> Array:
    return np.random.default_rng(0).standard_normal(size)  # the same digits every time


def _normalised(vectors: ComplexArray, mass: csc_array) -> ComplexArray:
    """Modal mass 1, and the phase at which the motion is as far in phase as can be."""
    weighted = mass @ vectors
    size = np.sqrt(np.einsum("im,im->m", vectors.conj(), weighted).real)
    turn = np.exp(-0.5j * np.angle(np.einsum("im,im->m", vectors, weighted)))
    return cast(ComplexArray, vectors * turn / size)


def _describe(equations: Linearised, scene: Scene, value: complex, vector: ComplexArray) -> Mode:
    free = equations.free
    full = np.zeros(free.size, dtype=np.complex128)
    full[free.ravel()] = vector
    turned = by_family(scene, full.reshape(free.shape))
    energy = family_energies(turned, equations.mass)
    share = energy / energy.sum()
    dominant = int(np.argmax(share))
    wave = turned[:, dominant].real
    mirrored = -wave[::-1] if FAMILIES[dominant] == "longitudinal" else wave[::-1]
    sign = signs_along(wave)[0]
    full = full * sign
    per_length = scene.conductor.mass_per_length + scene.ice.mass_per_length
    return Mode(
        frequency_hz=abs(value) / (2.0 * np.pi),
        damping_ratio=-value.real / abs(value),
        family=FAMILIES[dominant],
        shares=cast(dict[Family, float], dict(zip(FAMILIES, share.tolist(), strict=True))),
        symmetric=bool(wave @ mirrored > 0.0),
        loops=half_waves(wave),
        participation={
            "vertical": _participation(equations, full.real, 1) / per_length,
            "horizontal": _participation(equations, full.real, 2) / per_length,
        },
        eigenvalue=value,
        shape=full.real.reshape(free.shape),
        quadrature=full.imag.reshape(free.shape),
        wave=wave * sign,
    )


def signs_along(wave: Array) -> Array:
    """Signs of a displacement along the span where it has one."""
    return np.asarray(np.sign(wave[np.abs(wave) > NODAL_LINE * np.max(np.abs(wave))]))


def half_waves(wave: Array) -> int:
    """Number of half-waves of a displacement along the span."""
    return 1 + int(np.count_nonzero(np.diff(signs_along(wave))))


def family_energies(turned: NDArray[Any], mass: Any) -> Array:
    """Twice the kinetic energy of each family at unit frequency, of a motion `by_family`.

    The mass of a section is the same in every direction, so that the mass matrix of u1 and u2 is
    that of the motion along the chord and across it.
    """
    parts = np.zeros((4, turned.size), dtype=turned.dtype)
    parts[np.arange(turned.size) % 4, np.arange(turned.size)] = turned.ravel()
    return np.asarray(np.einsum("fi,if->f", parts.conj(), mass @ parts.T).real)


def _participation(equations: Linearised, shape: Array, column: int) -> float:
    """Momentum of the shape along one axis; the twist has no part in it."""
    along = uniform(equations.free.shape, column)
    return float((shape * along) @ (equations.mass @ along))
