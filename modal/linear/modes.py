"""Modes of a span about its equilibrium in still air or in wind, from the kernel's tangents."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, cast, overload

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.foundation.deprecation import warn_renamed
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.foundation.text_rules import counted
from gallop_fmu.input.scene_like import SceneLike, as_scene
from modal.foundation.one_thread import one_thread
from modal.linear.eigensolution import is_stable, lowest, oscillating
from modal.linear.line_modes import LineMode, line_modes
from modal.linear.linearise import Linearised, SmallMotion, WindState, linearised, uniform
from modal.linear.mode_list import ModeList
from modal.linear.wave import half_waves, signs_along

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Family = Literal["longitudinal", "vertical", "horizontal", "torsional"]

FAMILIES: tuple[Family, ...] = ("longitudinal", "vertical", "horizontal", "torsional")
"""Families of modes: mostly along the chord, normal to it in the vertical plane, along x3, twist.

On a level span these are u1, u2, u3 and theta, the unknowns of a node; see `by_family`.
"""


@dataclass(frozen=True, repr=False)
class Mode:
    """A mode of small motion, q(t) = Re[(shape + i quadrature) exp(eigenvalue t)].

    Attributes
    ----------
    frequency_hz : float
        Natural frequency [Hz]: modulus of the eigenvalue over 2 pi.
    damping_ratio : float
        Ratio to critical damping; negative if the motion grows. Structural damping in still air,
        structural and aerodynamic damping in wind.
    family : str
        ``"vertical"``, ``"horizontal"``, ``"torsional"`` or ``"longitudinal"``: the family with
        the largest of `shares`.
    shares : dict of str to float
        Kinetic energy of each family, relative to their sum. ``"longitudinal"`` and ``"vertical"``
        are the motion in the vertical plane along the chord and normal to it. The coupling energy
        of eccentric ice belongs to no family and is not included.
    symmetric : bool
        True if the motion is more symmetric than antisymmetric about mid-span.
    loops : int
        Half-waves of the family's displacement along the span.
    participation : dict of str to float
        Generalised force of a uniform load of 1 N/m along x2 ("vertical") or x3 ("horizontal"): the
        integral of the shape over the conductor [m/sqrt(kg)]. A static load p moves the modal
        coordinate by participation p / w^2. Mass per unit length times its square is the effective
        mass [kg] of the mode; effective masses add up to the whole mass.
    eigenvalue : complex
        Eigenvalue [1/s], with positive imaginary part.
    shape : ndarray, shape (node, 4)
        u1, u2, u3 and theta per unit of the modal coordinate [1/sqrt(kg), rad/(m sqrt(kg))]; its
        modal mass is 1, and its first half-wave from the left is positive.
    quadrature : ndarray, shape (node, 4)
        Part of the motion that is a quarter of a period ahead of `shape`; zero in still air.
    wave : ndarray, shape (node,)
        Component of `shape` in the family: along the chord, normal to it, along x3, or twist.
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

    def __repr__(self) -> str:
        side = "symmetric" if self.symmetric else "antisymmetric"
        return (
            f"Mode({self.frequency_hz:.4f} Hz, {self.family}, {side},"
            f" {counted(self.loops, 'loop')}, damping {100.0 * self.damping_ratio:.2f} %)"
        )

    def plot(self) -> Any:
        """Draw the shape of the mode by `modal.plots.mode_shapes`, which draws several, too.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("Mode.plot", [self])

    @property
    def symmetric_share(self) -> float:
        """Share of the squared `wave` that is symmetric about mid-span."""
        return 0.5 + 0.5 * float(self.wave @ self.wave[::-1]) / float(self.wave @ self.wave)

    @property
    def own_image(self) -> float:
        """Deprecated name of `symmetric_share`."""
        warn_renamed("Mode.own_image", "symmetric_share")
        return self.symmetric_share


def by_family(scene: Scene, shape: NDArray[Any]) -> NDArray[Any]:
    """Rotate nodal displacements to the directions of `FAMILIES`.

    Parameters
    ----------
    scene
        The span, which gives the direction of the chord.
    shape : ndarray, shape (..., 4)
        u1, u2, u3 and theta.

    Returns
    -------
    ndarray, shape (..., 4)
        Along the chord, normal to it in the vertical plane, along x3, and twist.
    """
    chord = math.hypot(scene.span.length, scene.span.height_difference)
    cosine, sine = scene.span.length / chord, scene.span.height_difference / chord
    rotated = np.array(shape)
    rotated[..., 0] = cosine * shape[..., 0] + sine * shape[..., 1]
    rotated[..., 1] = cosine * shape[..., 1] - sine * shape[..., 0]
    return rotated


@overload
def natural_modes(scene: Scene, count: int = 12, wind: WindState = "still") -> ModeList[Mode]: ...


@overload
def natural_modes(
    scene: LineScene, count: int = 12, wind: WindState = "still"
) -> ModeList[LineMode]: ...


@overload
def natural_modes(
    scene: SceneLike, count: int = 12, wind: WindState = "still"
) -> ModeList[Mode] | ModeList[LineMode]: ...


@one_thread
def natural_modes(
    scene: SceneLike, count: int = 12, wind: WindState = "still"
) -> ModeList[Mode] | ModeList[LineMode]:
    """Compute the lowest modes about the equilibrium in still air, or in the mean wind.

    Mass, damping and stiffness are those of the simulation. They include the sag, the elasticity of
    the conductor and its supports, and the eccentric ice, whose weight and inertia couple twist and
    displacements.

    In still air the modes are those of the undamped span, and the damping ratio is phi' C phi / (2
    w). In mean wind the quasi-steady load (Liu, Yan, Zhang, Zhou 2009, eq. 20-21) adds to damping
    and stiffness, and the modes are the complex ones of M s^2 + C s + K.

    Parameters
    ----------
    scene
        The span or line; its mesh is ``numerics.elements``.
    count
        Number of modes.
    wind
        ``"still"``, or ``"mean"`` for the scene's mean wind.

    Returns
    -------
    ModeList of Mode, or of LineMode for a line
        A list in order of frequency, with ``plot()``. In mean wind, motions that do not oscillate
        (overdamped) are not included.

    Raises
    ------
    SceneError
        If `count` is not possible on this mesh, or the equilibrium does not exist or is statically
        unstable.
    SimulationError
        If no initial equilibrium exists.
    """
    scene = as_scene(scene)
    if isinstance(scene, LineScene):
        motion = SmallMotion(scene)
        return ModeList(line_modes(motion.about(wind), motion.mesh, count), scene)
    return ModeList(modes_of(linearised(scene, wind), scene, count), scene)


def modes_of(equations: Linearised, scene: Scene, count: int) -> list[Mode]:
    """Compute the lowest modes of equations of motion: complex in wind, real in still air."""
    return list(each_mode(equations, scene, count))


def each_mode(equations: Linearised, scene: Scene, count: int) -> Iterator[Mode]:
    """Yield the modes of `modes_of`, each described when it is wanted."""
    mass, damping, stiffness = equations.of_free()
    unknowns = mass.shape[0]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= unknowns:
        raise SceneError(
            f"count = {count}: must be a whole number from 1 to {unknowns}, the unknowns of a mesh"
            f" of {scene.numerics.elements} elements; lower count or raise numerics.elements"
        )
    unstable = not is_stable(stiffness)
    if equations.wind_speed != 0.0:
        divergence = (
            f"the equilibrium in wind of {equations.wind_speed:g} m/s is statically unstable:"
            " the aerodynamic moment grows faster with the twist than the restoring moment of"
            f" conductor.torsional_stiffness = {scene.conductor.torsional_stiffness} N m2/rad"
            " (torsional divergence); lower the wind, or check the slope of the moment"
            " coefficient and the attack angle"
        )
        values, vectors = oscillating(
            (mass, damping, stiffness), count, every=unstable, divergence=divergence
        )
    elif unstable:
        moment = scene.ice.first_moments()[0]
        raise SceneError(
            f"the initial equilibrium is unstable: with ice.first_moment_x2 = {moment:.6g} kg at"
            " the attack angle the weight of the ice rotates the conductor against its"
            f" conductor.torsional_stiffness = {scene.conductor.torsional_stiffness} N m2/rad;"
            " lower the first or raise the second, and check the units"
        )
    else:
        squares, real = lowest(mass, stiffness, count)
        omega = np.sqrt(squares)
        ratio = np.einsum("im,im->m", real, damping @ real) / (2.0 * omega)
        values = omega * (-ratio + 1j * np.sqrt(np.maximum(1.0 - ratio**2, 0.0)))
        vectors = real.astype(np.complex128)
    for s, vector in zip(values, vectors.T, strict=True):
        yield _describe(equations, scene, complex(s), vector)


def _describe(equations: Linearised, scene: Scene, value: complex, vector: ComplexArray) -> Mode:
    """Mode of an eigenvalue [1/s] and its vector of free unknowns."""
    free = equations.free
    full = np.zeros(free.size, dtype=np.complex128)
    full[free.ravel()] = vector
    rotated = by_family(scene, full.reshape(free.shape))
    energy = family_energies(rotated, equations.mass)
    share = energy / energy.sum()
    dominant = int(np.argmax(share))
    wave = rotated[:, dominant].real
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


def family_energies(rotated: NDArray[Any], mass: Any) -> Array:
    """Twice the kinetic energy of each family at unit frequency, for a motion from `by_family`.

    The mass of a section is the same in every direction, so that the mass matrix of u1 and u2 is
    that of the motion along the chord and normal to it.
    """
    parts = np.zeros((4, rotated.size), dtype=rotated.dtype)
    parts[np.arange(rotated.size) % 4, np.arange(rotated.size)] = rotated.ravel()
    return np.asarray(np.einsum("fi,if->f", parts.conj(), mass @ parts.T).real)


def _participation(equations: Linearised, shape: Array, column: int) -> float:
    """Momentum of the shape along one axis, without the twist."""
    along = uniform(equations.free.shape, column)
    return float((shape * along) @ (equations.mass @ along))
