"""Shapes in which the motion of a line is described: lowest modes, twists, strings.

Motions of the conductors without twist are natural modes in still air, the lowest ones of all
families: of each span in and out of phase, of bundles, and on strings. The twist of conductors
follows these motions: the shapes of the twist are those that the moment of the wind on them
produces, because a line has a great many torsional modes with almost the same frequency. At each
tower with strings, the static displacements under forces on its clamps are added.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Model, SceneError
from gallop_fmu.engine.mesh import Mesh
from modal.linear.line_modes import LineMode, line_modes
from modal.linear.linearise import Linearised, SmallMotion
from modal.linear.mode_basis import MIRROR

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]

FIRST_SPAN, EACH_SPAN, MAX_MODES = 8, 6, 24
"""Number of modes kept: of the first span, of each further one, and of all."""

BUNDLE_FACTOR = 1.5
"""Factor of this number for bundles, which have torsion as well."""

MIN_GAP = 1e-2
"""Relative difference of the frequencies of two modes between which the lowest modes end."""

MAX_TWISTS = 12
"""Number of shapes of the twist."""

MIN_TWIST = 0.05
"""Singular value, relative to the largest, below which a twist follows from the others."""

HELD = "held by a string"
"""Family of the shapes that belong to forces on the clamps of strings."""

ROUND_OFF, COMPLETE = 1e-7, 1e-4
"""Bounds of entries of a mirror matrix: below the first they are 0; the second is the largest
difference of its square from 1."""

MAX_ELEMENTS = 12
"""Most elements of a span of a line that is reduced, if spacers and devices allow it."""


@dataclass(frozen=True)
class LineBasis:
    """A line in still air: its matrices, and the shapes of its motion.

    Attributes
    ----------
    mesh : Mesh
        The finite elements.
    equations : Linearised
        Small motion in still air.
    modes : list of LineMode
        The natural modes kept.
    shapes : ndarray, shape (mode, node, 4)
        Mass-normalised shapes: those of the modes, of the twist, and of forces at strings.
    family : list of str
        Family of each shape.
    loops : list of tuple of int
        Half-waves of each shape in each span.
    highest_hz : float
        Frequency [Hz] of the lowest mode without twist that is not kept.
    """

    mesh: Mesh
    equations: Linearised
    modes: list[LineMode]
    shapes: Array
    family: list[str]
    loops: list[tuple[int, ...]]
    highest_hz: float

    @property
    def model(self) -> Model:
        """The model of the line."""
        return self.mesh.model


def line_basis(scene: LineScene, like: LineBasis | None = None) -> LineBasis:
    """Find the lowest modes of a line, the twists that follow them, and the shapes at strings.

    Parameters
    ----------
    scene
        The line.
    like
        Basis with the numbers of modes to take; None: as many as the line needs.

    Raises
    ------
    SceneError
        If the equilibrium in still air is unstable.
    SimulationError
        If there is none.
    """
    small = SmallMotion(coarse(scene))
    equations, mesh = small.in_still_air(), small.mesh
    if like is None:
        modes, highest = _lowest(equations, mesh, _wanted(scene), MIN_GAP)
    else:
        modes, highest = _lowest(equations, mesh, len(like.modes), 0.0)
    most_twists = MAX_TWISTS if like is None else like.family.count("torsional")
    shapes = np.stack([mode.shape for mode in modes])
    loops = [mode.loops for mode in modes]
    twisting = [mode for mode in modes if mode.family != "horizontal"]
    basis = list(shapes.reshape(len(shapes), -1))
    for mode, twist in zip(twisting, _twists(equations, mesh, twisting), strict=True):
        if len(basis) < len(modes) + most_twists and _append(basis, twist, equations.mass):
            loops.append(mode.loops)
    family = [str(mode.family) for mode in modes] + ["torsional"] * (len(basis) - len(modes))
    for moved in _held_places(equations, mesh):
        if _append(basis, moved, equations.mass):
            loops.append((0,) * len(scene.section.spans))
            family.append(HELD)
    together = np.array(basis).reshape(-1, *shapes.shape[1:])
    return LineBasis(mesh, equations, modes, together, family, loops, highest)


def coarse(scene: LineScene, most: int = MAX_ELEMENTS) -> LineScene:
    """Return the line with at most so many elements a span, if its stations allow it."""
    numbers: dict[str, object] = {}
    if scene.numerics.elements > most:
        numbers["numerics.elements"] = most
    for index, span in enumerate(scene.section.spans):
        if span.elements is not None and span.elements > most:
            numbers[f"section.spans.{index}.elements"] = most
    if not numbers:
        return scene
    try:
        return scene.with_values(numbers)
    except SceneError:
        return scene


def _wanted(scene: LineScene) -> int:
    """Number of modes without twist that are kept."""
    bundles = len(scene.section.spans) * len(scene.phases)
    count = FIRST_SPAN + EACH_SPAN * (bundles - 1)
    if scene.bundle.subconductors > 1:
        count = round(BUNDLE_FACTOR * count)
    return min(MAX_MODES, count)


def _lowest(
    equations: Linearised, mesh: Mesh, wanted: int, gap: float
) -> tuple[list[LineMode], float]:
    """Lowest modes that are not torsional, up to a gap, and the frequency [Hz] of the next one."""
    most = int(equations.free.sum())
    among = min(most, wanted + 12)
    while True:
        found = line_modes(equations, mesh, among)
        kept = [mode for mode in found if mode.family != "torsional"]
        for count in range(wanted, len(kept)):
            if kept[count].frequency_hz > (1.0 + gap) * kept[count - 1].frequency_hz:
                return kept[:count], kept[count].frequency_hz
        if among == most:
            return kept, float("inf")
        among = min(most, 2 * among)


def _twists(equations: Linearised, mesh: Mesh, modes: list[LineMode]) -> list[Array]:
    """Static twist under a torque in proportion to the displacement along n2 of each mode.

    This is how the moment of the wind is distributed, which depends on the velocity there.
    """
    from scipy.sparse.linalg import splu

    free = equations.free.copy()
    free[:, :3] = False
    at = np.flatnonzero(free)
    if not len(at):
        return []
    factors = splu(equations.stiffness[at][:, at])
    mass = equations.mass[at][:, at]
    found = []
    for mode in modes:
        along = np.zeros((mesh.model.nodes, 4))
        along[:, 3] = np.einsum("ni,ni->n", mesh.node_normal, mode.shape[:, :2])
        twist = np.zeros(along.size)
        twist[at] = factors.solve(mass @ along.ravel()[at])
        found.append(mesh.spread(twist.reshape(-1, 4)).ravel())
    return found


def _held_places(equations: Linearised, mesh: Mesh) -> Iterator[Array]:
    """Static displacements under a force on the clamps of each tower with strings, along each axis.

    Also under a moment where a clamp may twist. With them, the motion of a clamp is that of the
    coordinates alone, so that its string may lean, and change its pull, to any extent: at the top
    of a large galloping motion, strings carry almost no weight.
    """
    from scipy.sparse.linalg import splu

    at = np.flatnonzero(equations.free)
    nodes, leader = mesh.model.junction_nodes()
    towers = [tower for tower in mesh.model.map.towers if tower.has_string]
    if not towers:
        return
    factors = splu(equations.stiffness[at][:, at])
    for tower in towers:
        clamps = leader[nodes[list(tower.junctions)]]
        for axis in np.flatnonzero(equations.free.reshape(-1, 4)[clamps].all(axis=0)):
            force, moved = np.zeros((mesh.model.nodes, 4)), np.zeros(4 * mesh.model.nodes)
            force[clamps, axis] = 1.0
            moved[at] = factors.solve(force.ravel()[at])
            yield mesh.spread(moved.reshape(-1, 4)).ravel()


def _append(basis: list[Array], vector: Array, mass: csc_array) -> bool:
    """Append the part of a vector outside of a basis, if it is enough; normalise by the mass."""
    size = np.sqrt(vector @ (mass @ vector))
    for _ in range(2):
        for known in basis:
            vector = vector - (known @ (mass @ vector)) * known
    left = np.sqrt(vector @ (mass @ vector))
    if not left > MIN_TWIST * size:
        return False
    basis.append(vector / left)
    return True


def mirror_image(scene: LineScene, mesh: Mesh, shapes: Array, mass: csc_array) -> Array | None:
    """Matrix that turns coordinates into those of the mirror image about the middle of the line.

    None if the line is not the same on both sides, or may not be: devices and wind or ice that
    differ between spans are not compared.
    """
    section = scene.section
    spans, strings = section.spans, section.suspensions
    is_same = (
        all(span.height_difference == 0.0 for span in spans)
        and spans == spans[::-1]
        and strings == strings[::-1]
        and section.left_end == section.right_end
        and not scene.devices
    )
    line, opposite = mesh.model.map, np.arange(mesh.model.nodes)
    for chain in line.chains:
        other = line.chain(line.spans + 1 - chain.span, chain.phase, chain.subconductor)
        if not np.allclose(chain.stations, 1.0 - other.stations[::-1]):
            return None
        opposite[chain.nodes] = np.arange(other.nodes.stop - 1, other.nodes.start - 1, -1)
    if not is_same or line.bodies:
        return None
    flat = shapes.reshape(len(shapes), -1)
    image = (shapes[:, opposite] * MIRROR).reshape(len(shapes), -1)
    found: Array = np.asarray(flat @ (mass @ image.T))
    found[np.abs(found) < ROUND_OFF] = 0.0
    is_complete = np.allclose(found @ found.T, np.eye(len(shapes)), atol=COMPLETE)
    return found if is_complete else None
