"""Natural modes of a line: spans, strings, bundles and phases that move together.

The motion of a bundle in a span has parts, at each place along the span: that of its centre along
the chord, normal to it and across the line; the rotation of the bundle about its centre; and the
rest. Spacers hold the bundle together, so that *bundle torsion* is the rotation at the spacers and
at the ends of the span, linear between them, and *sub-span motion* is all other motion of
subconductors against each other. The twist of each subconductor is a part of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, SceneError
from gallop_fmu.engine.line_map import LineMap, MappedChain
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.foundation.figures import drawn
from modal.linear.eigensolution import Array, ComplexArray, is_stable, lowest, oscillating
from modal.linear.linearise import Linearised
from modal.linear.wave import half_waves

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Part = Literal["longitudinal", "vertical", "horizontal", "torsional", "bundle torsion", "sub-span"]
LineFamily = Part | Literal["tension-neutral"]

PARTS: tuple[Part, ...] = (
    "longitudinal",
    "vertical",
    "horizontal",
    "torsional",
    "bundle torsion",
    "sub-span",
)
"""Parts of the motion: the centre of the bundle along the chord of the span, normal to it in the
vertical plane, and along x3; twist of the subconductors; rotation of the bundle; the rest."""

MIN_SPAN_SHARE = 0.01
"""Share of the kinetic energy of a span from which loops in it are counted."""

MIN_SAG_CHANGE = 0.5
"""Mean displacement of a span over its mean modulus from which a vertical mode changes the sag."""

MAX_ELONGATION = 0.5
"""Elongation of the conductors, relative to the motion of clamps along the line, below which a
vertical mode that changes the sag is tension-neutral."""


@dataclass(frozen=True, repr=False)
class LineMode:
    """A mode of small motion of a line, q(t) = Re[(shape + i quadrature) exp(eigenvalue t)].

    Attributes
    ----------
    frequency_hz : float
        Natural frequency [Hz]: modulus of the eigenvalue over 2 pi.
    damping_ratio : float
        Ratio to critical damping; negative if the motion grows.
    family : str
        The part with the largest of `shares`; ``"tension-neutral"`` for a vertical mode in which
        clamps move along the line, so that the sags of spans change almost without a change of
        tension.
    shares : dict of str to float
        Kinetic energy of each of `PARTS`, relative to their sum. The coupling energy of eccentric
        ice belongs to no part and is not included.
    loops : tuple of int
        Half-waves of the family's displacement in each span; 0 where the span has less than 1 % of
        the energy.
    span_shares, phase_shares, subconductor_shares : ndarray
        Share of each span, phase and subconductor (number) in the kinetic energy of the conductors.
    device_share : float
        Share of strings, spacers and other devices in the whole kinetic energy.
    tension_share : float
        Share of the changes of tension in the potential energy (w^2 / 2 of a mode with mass 1).
    eigenvalue : complex
        Eigenvalue [1/s], with positive imaginary part.
    shape : ndarray, shape (node, 4)
        u1, u2, u3 and theta per unit of the modal coordinate [1/sqrt(kg), rad/(m sqrt(kg))]; its
        modal mass is 1, and its largest displacement is positive.
    quadrature : ndarray, shape (node, 4)
        Part of the motion that is a quarter of a period ahead of `shape`; zero in still air.
    scene : LineScene
        The line.
    """

    frequency_hz: float
    damping_ratio: float
    family: LineFamily
    shares: dict[Part, float]
    loops: tuple[int, ...]
    span_shares: Array
    phase_shares: Array
    subconductor_shares: Array
    device_share: float
    tension_share: float
    eigenvalue: complex
    shape: Array = field(repr=False)
    quadrature: Array = field(repr=False)
    scene: LineScene = field(repr=False)

    def plot(self) -> Any:
        """Draw the shape by `modal.plots.line_mode_shapes`, which draws several modes, too.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("LineMode.plot", self.scene, [self], self.scene.title)

    def __repr__(self) -> str:
        return (
            f"LineMode({self.frequency_hz:.4f} Hz, {self.family}, loops by span"
            f" {', '.join(map(str, self.loops))}, damping {100.0 * self.damping_ratio:.2f} %)"
        )

    @property
    def largest(self) -> float:
        """Largest displacement of a node per unit of the modal coordinate [1/sqrt(kg)].

        Of a torsional mode the largest twist [rad/(m sqrt(kg))].
        """
        if self.family == "torsional":
            return float(np.max(np.abs(self.shape[:, 3])))
        return float(np.max(np.linalg.norm(self.shape[:, :3], axis=1)))


@dataclass(frozen=True)
class BundleMotion:
    """Motion of one phase in one span, by parts.

    Attributes
    ----------
    chains : tuple of MappedChain
        The subconductors.
    centre : ndarray, shape (3, node)
        Displacement of the bundle's centre along the chord, normal to it, and along x3.
    rotation : ndarray, shape (node,)
        Rotation of the bundle about x1, linear between spacers [rad].
    turned : ndarray, shape (subconductor, node, 3)
        Displacement of the subconductors due to it.
    rest : ndarray, shape (subconductor, node, 3)
        What remains of their displacement.
    twist : ndarray, shape (subconductor, node)
        Their twist [rad].
    """

    chains: tuple[MappedChain, ...]
    centre: NDArray[Any]
    rotation: NDArray[Any]
    turned: NDArray[Any]
    rest: NDArray[Any]
    twist: NDArray[Any]

    def wave(self, part: Part) -> NDArray[Any]:
        """Displacement of a part along the span; of sub-span motion the largest component."""
        if part == "bundle torsion":
            return self.rotation
        if part == "torsional":
            return cast(NDArray[Any], self.twist[np.argmax(np.abs(self.twist).max(axis=1))])
        if part == "sub-span":
            components = np.moveaxis(self.rest, 1, -1).reshape(-1, self.rest.shape[1])
            return cast(NDArray[Any], components[np.argmax(np.abs(components).max(axis=1))])
        return cast(NDArray[Any], self.centre[PARTS.index(part)])


class LineParts:
    """Divides motions of a line into parts, and adds up their energies.

    Parameters
    ----------
    mesh
        The line.
    """

    def __init__(self, mesh: Mesh) -> None:
        self.line: LineMap = mesh.model.map
        self.scene = cast(LineScene, mesh.model.scene)
        self.x = mesh.model.equilibrium().x
        elements = mesh.model.tangent(mass=1.0, inputs=mesh.still)
        self.mass: csc_array = mesh.assemble(elements)
        """Of the conductors alone, before followers join their leaders."""
        self._linear, self._twisting = (
            self.mass[k::4, k::4].tocsr() for k in (1, 3)
        )  # the same for u1, u2 and u3
        self.points = mesh.strain_points
        self.axial = _axial_stiffness(mesh)

    def bundles(self, shape: NDArray[Any]) -> list[BundleMotion]:
        """Parts of a motion (node, 4), by span, then phase."""
        return [
            self._of_bundle(shape, span, phase)
            for span in range(1, self.line.spans + 1)
            for phase in range(1, self.line.phases + 1)
        ]

    def _of_bundle(self, shape: NDArray[Any], span: int, phase: int) -> BundleMotion:
        chains = self.line.bundle(span, phase)
        moved = np.array([shape[chain.nodes] for chain in chains])
        x = np.array([self.x[chain.nodes] for chain in chains])
        chord = (x[:, -1] - x[:, 0]).mean(axis=0)
        cosine, sine = chord[:2] / np.hypot(*chord[:2])
        u = np.stack(
            [
                cosine * moved[..., 0] + sine * moved[..., 1],
                cosine * moved[..., 1] - sine * moved[..., 0],
                moved[..., 2],
            ],
            axis=-1,
        )
        centre = u.mean(axis=0)
        apart = u - centre
        arm = (x - x.mean(axis=0))[..., 1:]
        squares = (arm**2).sum(axis=(0, 2))
        if len(chains) == 1:
            squares = np.ones_like(squares)
        fitted = (arm[..., 0] * apart[..., 2] - arm[..., 1] * apart[..., 1]).sum(axis=0) / squares
        held = self._held_corners(chains[0], span, phase)
        station = chains[0].stations
        rotation = np.interp(station, station[held], fitted[held].real).astype(shape.dtype)
        if np.iscomplexobj(shape):
            rotation = rotation + 1j * np.interp(station, station[held], fitted[held].imag)
        turned = np.zeros_like(u)
        turned[..., 1] = -rotation * arm[..., 1]
        turned[..., 2] = rotation * arm[..., 0]
        return BundleMotion(chains, centre.T, rotation, turned, apart - turned, moved[..., 3])

    def _held_corners(self, chain: MappedChain, span: int, phase: int) -> list[int]:
        """Nodes, from the start of a chain, at its ends and spacers."""
        held = {0, 2 * chain.elements}
        for spacer in self.line.spacers:
            if (spacer.span, spacer.phase) == (span, phase):
                place = chain.junctions.index(spacer.junctions[chain.subconductor - 1])
                held.add(2 * chain.corners[place])
        return sorted(held)

    def energies(self, bundles: list[BundleMotion]) -> dict[Part, float]:
        """Twice the kinetic energy of each part at unit frequency."""
        parts = {
            part: np.zeros((3, self.line.nodes), dtype=np.complex128)
            for part in PARTS[:3] + PARTS[4:]
        }
        twist = np.zeros(self.line.nodes, dtype=np.complex128)
        for bundle in bundles:
            for k, chain in enumerate(bundle.chains):
                for axis in range(3):
                    parts[PARTS[axis]][axis, chain.nodes] = bundle.centre[axis]
                parts["bundle torsion"][:, chain.nodes] = bundle.turned[k].T
                parts["sub-span"][:, chain.nodes] = bundle.rest[k].T
                twist[chain.nodes] = bundle.twist[k]
        found = {part: _energy(self._linear, motion) for part, motion in parts.items()}
        found["torsional"] = _energy(self._twisting, twist[None])
        return {part: found[part] for part in PARTS}

    def of_chains(self, shape: NDArray[Any]) -> Array:
        """Twice the kinetic energy of each chain at unit frequency, shape (span, phase, sub)."""
        flat = shape.ravel()
        of_nodes = (flat.conj() * (self.mass @ flat)).real.reshape(-1, 4).sum(axis=1)
        line = self.line
        found = np.array([of_nodes[chain.nodes].sum() for chain in line.chains])
        return found.reshape(line.spans, line.phases, line.subconductors)

    def elongations(self, shape: Array) -> tuple[Array, Array]:
        """Elongation of each chain, and the part of it by its ends [m]."""
        slope = self.points.slope(shape)[:, :3]
        strain = (self.points.tangent * slope).sum(axis=1) * self.points.length
        whole, ends = [], []
        for chain in self.line.chains:
            first = 2 * chain.first_element
            at = slice(first, first + 2 * chain.elements)
            tangent = self.points.tangent[at]
            whole.append(strain[at].sum())
            left, right = chain.ends
            ends.append(shape[right, :3] @ tangent[-1] - shape[left, :3] @ tangent[0])
        return np.array(whole), np.array(ends)

    def tension_energy(self, shape: Array) -> float:
        """Twice the potential energy of the changes of tension [J]."""
        slope = self.points.slope(shape)[:, :3]
        strain = (self.points.tangent * slope).sum(axis=1)
        return float((self.axial * strain**2) @ self.points.length)


def _energy(mass: csc_array, motion: NDArray[Any]) -> float:
    return float(sum((part.conj() @ (mass @ part)).real for part in motion))


def _axial_stiffness(mesh: Mesh) -> Array:
    """Axial stiffness [N] at each strain point."""
    scene = mesh.model.scene
    return np.full(len(mesh.strain_points.length), scene.conductor.axial_stiffness)


def line_modes(equations: Linearised, mesh: Mesh, count: int) -> list[LineMode]:
    """Compute the lowest modes of the equations of motion of a line.

    Raises
    ------
    SceneError
        If `count` is not possible on this mesh, or the equilibrium is statically unstable.
    """
    mass, damping, stiffness = equations.of_free()
    unknowns = mass.shape[0]
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= unknowns:
        raise SceneError(
            f"count = {count}: must be a whole number from 1 to {unknowns}, the unknowns of this"
            " mesh; lower count or raise numerics.elements"
        )
    divergence = (
        f"the equilibrium of the line in wind of {equations.wind_speed:g} m/s is unstable: a motion"
        " grows without oscillation. Check conductor.torsional_stiffness, ice.first_moment_x2 and"
        " the slope of the moment coefficient, and strings under compression (uplift)"
    )
    unstable = not is_stable(stiffness)
    if equations.wind_speed != 0.0:
        values, vectors = oscillating(
            (mass, damping, stiffness), count, every=unstable, divergence=divergence
        )
    elif unstable:
        raise SceneError(divergence)
    else:
        squares, real = lowest_by_component(mass, stiffness, count)
        omega = np.sqrt(squares)
        ratio = np.einsum("im,im->m", real, damping @ real) / (2.0 * omega)
        values = omega * (-ratio + 1j * np.sqrt(np.maximum(1.0 - ratio**2, 0.0)))
        vectors = real.astype(np.complex128)
    parts = LineParts(mesh)
    found = []
    for value, vector in zip(values, vectors.T, strict=True):
        full = np.zeros(equations.free.size, dtype=np.complex128)
        full[equations.free.ravel()] = vector
        found.append(_describe(parts, mesh.spread(full.reshape(-1, 4)), complex(value)))
    return found


def lowest_by_component(mass: csc_array, stiffness: csc_array, count: int) -> tuple[Array, Array]:
    """Lowest modes of parts of the line that are not coupled, such as phases, one after another.

    Equal frequencies of two parts then do not mix their modes.

    Returns
    -------
    ndarray, ndarray
        Squared angular frequencies [1/s2], ascending, and mass-normalised vectors (columns).
    """
    from scipy.sparse.csgraph import connected_components

    pattern = (abs(stiffness) + abs(mass)).tocsr()
    pattern.eliminate_zeros()
    number, label = connected_components(pattern, directed=False)
    squares, vectors = [], []
    for part in range(number):
        rows = np.flatnonzero(label == part)
        found, shapes = lowest(mass[rows][:, rows], stiffness[rows][:, rows], min(count, len(rows)))
        whole = np.zeros((mass.shape[0], len(found)))
        whole[rows] = shapes
        squares.append(found)
        vectors.append(whole)
    together = np.concatenate(squares)
    order = np.argsort(together, kind="stable")[:count]
    return together[order], np.hstack(vectors)[:, order]


def _describe(parts: LineParts, full: ComplexArray, value: complex) -> LineMode:
    """Mode of an eigenvalue [1/s] and its motion (node, 4), which has modal mass 1."""
    largest = np.unravel_index(np.argmax(np.abs(full[:, :3].real)), (len(full), 3))
    sign = np.sign(full[largest].real) or 1.0
    full = full * sign
    bundles = parts.bundles(full)
    energy = parts.energies(bundles)
    total = sum(energy.values())
    shares = {part: energy[part] / total for part in PARTS}
    dominant = max(PARTS, key=lambda part: shares[part])
    of_chains = parts.of_chains(full)
    conductors = of_chains.sum()
    by_span = of_chains.sum(axis=(1, 2)) / conductors
    by_phase = of_chains.sum(axis=2)
    loops = []
    for span, share in enumerate(by_span):
        phase = int(np.argmax(by_phase[span]))
        wave = bundles[span * parts.line.phases + phase].wave(dominant).real
        loops.append(half_waves(wave) if share >= MIN_SPAN_SHARE else 0)
    family: LineFamily = dominant
    if dominant == "vertical" and _is_tension_neutral(parts, full.real, bundles):
        family = "tension-neutral"
    return LineMode(
        frequency_hz=abs(value) / (2.0 * np.pi),
        damping_ratio=-value.real / abs(value),
        family=family,
        shares=shares,
        loops=tuple(loops),
        span_shares=by_span,
        phase_shares=of_chains.sum(axis=(0, 2)) / conductors,
        subconductor_shares=of_chains.sum(axis=(0, 1)) / conductors,
        device_share=max(0.0, 1.0 - float(conductors)),
        tension_share=parts.tension_energy(full.real) / abs(value) ** 2,
        eigenvalue=value,
        shape=full.real,
        quadrature=full.imag,
        scene=parts.scene,
    )


def _is_tension_neutral(parts: LineParts, shape: Array, bundles: list[BundleMotion]) -> bool:
    """True if clamps move along the line, so that sags change almost without elongation."""
    waves = [bundle.centre[1].real for bundle in bundles]
    change = sum(abs(wave.sum()) for wave in waves)
    if change < MIN_SAG_CHANGE * sum(np.abs(wave).sum() for wave in waves):
        return False
    elongation, by_ends = parts.elongations(shape)
    return bool(np.sum(elongation**2) < MAX_ELONGATION**2 * np.sum(by_ends**2))
