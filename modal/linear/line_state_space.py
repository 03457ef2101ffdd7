r"""A line as a linear state-space model of its lowest modes.

Let q be the free unknowns, p the displacements of the towers, f the other loads, all as differences
from the equilibrium; s, x and y the eigenvalue, right and left vector of a mode:

    M q'' + C q' + K q = f - Mp p'' - Cp p' - Kp p,
    (s^2 M + s C + K) x = 0,        y^T (s^2 M + s C + K) = 0,        y^T (2 s M + C) x = 1.

With P(s) = s^2 Mp + s Cp + Kp, the part of a mode in q at the angular frequency w is
x y^T (f - P(i w) p) / (i w - s). P(i w) / (i w - s) is P(s) / (i w - s) and a polynomial in i w,
which belongs to the direct terms. The same holds for an output R(i w) q, such as the force on a
tower. So the state z of a mode obeys

    z' = s z + y^T (f - P(s) p),        output = 2 Re(R(s) x z) + D (f, p),

and D follows from the static gain, which is that of all unknowns. Direct terms with p' and p'' are
neglected: damping and inertia of what moves with a tower at once, in the force on it.

A device at a tower (string, yoke, spring) sees only the motion of its clamps relative to the tower.
Its columns for the tower are therefore minus the sums of those for its clamps. A bar of mass m has
the consistent mass m/3 at the clamp and the coupling m/6 with the tower: half of that at the clamp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, LineScene, SceneError
from gallop_fmu.engine.line_map import MappedTower
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.engine.model import DOFS
from modal.linear.eigensolution import Array, ComplexArray, is_stable, oscillating
from modal.linear.linearise import Linearised, SmallMotion

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Matrices = tuple["csc_array", "csc_array", "csc_array"]

AXES = 3
MOTION = ("x1", "x2", "x3", "theta")

SAME_EIGENVALUE = 1e-6
"""Largest relative difference of an eigenvalue of the right and of the left vectors."""


@dataclass(frozen=True)
class LineSystem:
    """x' = a x + b u, y = c x + d u, with the names of u and y."""

    a: Array
    b: Array
    c: Array
    d: Array
    inputs: list[str]
    outputs: list[str]


def line_system(scene: LineScene, modes: int | None) -> LineSystem:
    """State space of the lowest modes of a line about its equilibrium in mean wind.

    Raises
    ------
    SceneError
        If `modes` is not possible, or the equilibrium does not exist or is statically unstable.
    """
    from scipy.sparse.linalg import splu

    if isinstance(modes, bool) or not isinstance(modes, int) or modes < 1:
        raise SceneError(
            f"modes = {modes}: the linear model of a line is made of its lowest modes; give their"
            " number, 1 or more"
        )
    small = SmallMotion(scene)
    equations, mesh = small.in_mean_wind(), small.mesh
    towers = _Towers(equations, mesh)
    kept = np.flatnonzero(equations.free)
    loads = np.column_stack(
        [equations.by_wind, _wind_by_span(equations, small), equations.by_attack_angle]
    )
    observed = _midspans(equations, mesh)
    values, right, left = _modes(equations, modes)

    driven = np.hstack([loads[kept], -towers.columns(0.0)[kept]])
    static = splu(equations.of_free()[2].tocsc()).solve(driven)
    force = -towers.rows(0.0)[:, kept] @ static
    force += np.hstack([towers.held.T @ loads, -towers.between])
    moved = observed[:, kept] @ static
    gain = np.vstack([moved, np.zeros((len(_linear(moved)), static.shape[1])), force])

    a, b = np.zeros((2 * modes, 2 * modes)), np.zeros((2 * modes, static.shape[1]))
    c = np.zeros((len(gain), 2 * modes))
    for m, s in enumerate(values):
        by = 2.0 * left[m] @ np.hstack([loads[kept], -towers.columns(s)[kept]])
        moved = observed[:, kept] @ right[:, m]
        force = -towers.rows(s)[:, kept] @ right[:, m]
        seen = np.concatenate([moved, s * _linear(moved), force])
        pair = slice(2 * m, 2 * m + 2)
        a[pair, pair] = [[s.real, -s.imag], [s.imag, s.real]]
        b[pair] = [by.real, by.imag]
        c[:, pair] = np.column_stack([seen.real, -seen.imag])
    return LineSystem(a, b, c, gain + c @ np.linalg.solve(a, b), *_names(mesh))


def _names(mesh: Mesh) -> tuple[list[str], list[str]]:
    """Names of inputs and outputs: those of the FMU, with _ for dots, which control refuses."""
    line = mesh.model.map
    spans, towers = range(1, line.spans + 1), range(line.spans + 1)
    inputs = ["wind_speed", *(f"span[{k}]_wind_speed" for k in spans), "attack_angle"]
    inputs += [f"tower[{k}]_x{axis}" for k in towers for axis in (1, 2, 3)]
    places = [
        f"span[{span}]" + (f"_phase[{phase}]" if line.phases > 1 else "") + "_midspan_"
        for span in spans
        for phase in range(1, line.phases + 1)
    ]
    outputs = [place + name for place in places for name in MOTION]
    outputs += [place + name for place in places for name in ("v1", "v2", "v3")]
    outputs += [f"tower[{k}]_f{axis}" for k in towers for axis in (1, 2, 3)]
    return inputs, outputs


def _linear(motion: NDArray[Any]) -> NDArray[Any]:
    """Rows of u1, u2 and u3 among those of `_midspans`."""
    return motion[np.arange(len(motion)) % DOFS < AXES]


def _wind_by_span(equations: Linearised, small: SmallMotion) -> Array:
    """Force on each unknown per m/s of wind in each span, shape (4 node, span)."""
    mesh = small.mesh
    line, u = mesh.model.map, equations.displacement
    if equations.wind_speed == 0.0:
        return np.zeros((u.size, line.spans))
    windy = Inputs.still(mesh.model.scene, wind_speed=equations.wind_speed)
    change = mesh.model.tangent(u, damping=1.0, inputs=windy)
    change = change - mesh.model.tangent(u, damping=1.0, inputs=mesh.still)
    columns = []
    for span in range(1, line.spans + 1):
        of_span = np.zeros_like(change)
        for chain in line.chains:
            if chain.span == span:
                own = slice(chain.first_element, chain.first_element + chain.elements)
                of_span[own] = change[own]
        force = (mesh.assemble(of_span) @ small.wind_of_nodes()).reshape(u.shape)
        gathered = np.zeros_like(force)
        np.add.at(gathered, mesh.leader, force)
        columns.append(gathered.ravel())
    return np.column_stack(columns)


def _midspans(equations: Linearised, mesh: Mesh) -> Array:
    """Motion of each bundle's centre and its rotation at mid-span, from the unknowns.

    Rotation is the best fit of `atan2(sum r x x, sum r . x)`, linear about the equilibrium; r is
    the strung place of a subconductor in the bundle. Of a single conductor it is the twist.
    """
    line, scene = mesh.model.map, mesh.model.scene
    rows = np.zeros((line.spans * line.phases, DOFS, *equations.free.shape))
    bundles = [
        line.bundle(span, phase)
        for span in range(1, line.spans + 1)
        for phase in range(1, line.phases + 1)
    ]
    for row, chains in zip(rows, bundles, strict=True):
        nodes = mesh.leader[[chain.middle for chain in chains]]
        for axis in range(AXES):
            row[axis, nodes, axis] = 1.0 / len(nodes)
        if len(nodes) == 1:
            row[3, nodes, 3] = 1.0
            continue
        assert isinstance(scene, LineScene)
        arms = np.array(scene.bundle.positions)
        arms -= arms.mean(axis=0)
        x = arms + equations.displacement[nodes, 1:3]
        across = float((arms[:, 0] * x[:, 1] - arms[:, 1] * x[:, 0]).sum())
        along = float((arms * x).sum())
        turned = along * np.column_stack([-arms[:, 1], arms[:, 0]]) - across * arms
        row[3, nodes, 1:3] = turned / (along**2 + across**2)
    return rows.reshape(len(bundles) * DOFS, -1)


def _modes(equations: Linearised, count: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Eigenvalues, right vectors (columns) and normalised left vectors (rows) of lowest modes.

    Parts of the line that are not coupled, such as phases, are taken one after another, so that
    equal eigenvalues of two parts are not missed.
    """
    from scipy.sparse.csgraph import connected_components

    mass, damping, stiffness = equations.of_free()
    pattern = (abs(stiffness) + abs(mass) + abs(damping)).tocsr()
    pattern.eliminate_zeros()
    number, label = connected_components(pattern, directed=False)
    values: list[ComplexArray] = []
    right: list[ComplexArray] = []
    left: list[ComplexArray] = []
    for part in range(number):
        rows = np.flatnonzero(label == part)
        own = (mass[rows][:, rows], damping[rows][:, rows], stiffness[rows][:, rows])
        found, of_right, of_left = _both_sides(own, min(count, len(rows)))
        for vectors, whole in ((of_right, right), (of_left.T, left)):
            full = np.zeros((mass.shape[0], len(found)), dtype=np.complex128)
            full[rows] = vectors
            whole.append(full)
        values.append(found)
    together = np.concatenate(values)
    order = np.argsort(np.abs(together), kind="stable")[:count]
    if len(order) < count:
        raise SceneError(f"modes = {count}: only {len(order)} modes of this mesh; lower modes")
    return together[order], np.hstack(right)[:, order], np.hstack(left)[:, order].T


def _both_sides(own: Matrices, count: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """`_modes` of one part of the line."""
    mass, damping, stiffness = own
    divergence = (
        "the equilibrium of the line is unstable: a motion grows without oscillation. Check"
        " conductor.torsional_stiffness, ice.first_moment_x2 and strings under compression (uplift)"
    )
    every = not is_stable(stiffness)
    values, right = oscillating(own, count, every=every, divergence=divergence)
    turned = (mass.T.tocsc(), damping.T.tocsc(), stiffness.T.tocsc())
    again, left = oscillating(turned, count, every=every, divergence=divergence)
    distance = np.abs(values[:, None] - again).min(axis=1) / np.abs(values)
    if distance.max() > SAME_EIGENVALUE:
        raise SceneError(
            f"modes = {count}: the highest modes have equal frequencies, so that one of them cannot"
            f" be left out; set {count + 1}"
        )
    # Vectors of different eigenvalues a, b are orthogonal: y^T [(a + b) M + C] x = 0.
    product = (again[:, None] + values) * (left.T @ (mass @ right)) + left.T @ (damping @ right)
    normalised: ComplexArray = np.linalg.solve(product, left.T).astype(np.complex128)
    return values, right, normalised


class _Towers:
    """How motion of the towers drives the line, and how the line pulls at the towers.

    Columns are towers from the left, each x1, x2, x3.
    """

    def __init__(self, equations: Linearised, mesh: Mesh) -> None:
        line, u = mesh.model.map, equations.displacement
        free = equations.free
        count = AXES * (line.spans + 1)
        self.held = np.zeros((u.size, count))
        """1 where an unknown is the displacement of a tower."""
        for tower, junctions in enumerate(line.junctions_of_towers):
            for node in mesh.leader[line.node_of_junction[list(junctions)]]:
                for axis in range(AXES):
                    if not free[node, axis]:
                        self.held[DOFS * node + axis, AXES * tower + axis] = 1.0
        matrices = (equations.stiffness, equations.damping, equations.mass)
        self._columns = [np.asarray(matrix @ self.held) for matrix in matrices]
        self._rows = [np.asarray((matrix.T @ self.held).T) for matrix in matrices]
        self.between = self.held.T @ self._columns[0]
        """Minus the force on towers by their displacement, all else at rest."""
        for held in line.towers:
            for device in held.devices:
                self._add_device(mesh, u, held, device)

    def _add_device(self, mesh: Mesh, u: Array, held: MappedTower, device: int) -> None:
        line = mesh.model.map
        nodes = mesh.leader[line.node_of_junction[list(mesh.model.devices[device])]]
        unknowns = (DOFS * nodes[:, None] + np.arange(DOFS)).ravel()
        size, tower = unknowns.size, slice(AXES * held.tower, AXES * (held.tower + 1))
        clamps = np.tile(np.eye(DOFS, AXES), (len(nodes), 1))
        for power, part in enumerate(("stiffness", "damping", "mass")):
            blocks = mesh.model.device_tangent(device, u, **{part: 1.0}, inputs=mesh.still)
            matrix = blocks.transpose(0, 2, 1, 3).reshape(size, size)
            weight = -1.0
            if part == "mass":
                matrix = matrix - self._frame_mass(mesh, held) / len(nodes) * np.diag(
                    np.tile([1.0, 1.0, 1.0, 0.0], len(nodes))
                )
                weight = 0.5
            self._columns[power][unknowns, tower] += weight * (matrix @ clamps)
            self._rows[power][tower, unknowns] += weight * (clamps.T @ matrix)
            if part == "stiffness":
                self.between[tower, tower] += clamps.T @ matrix @ clamps

    @staticmethod
    def _frame_mass(mesh: Mesh, held: MappedTower) -> float:
        """Mass [kg] of the frame of a yoke, which the tower does not move by itself."""
        scene = mesh.model.scene
        return scene.bundle.yoke_mass if isinstance(scene, LineScene) and held.has_yoke else 0.0

    def columns(self, s: complex) -> NDArray[Any]:
        """Force on all unknowns, with the minus sign, per displacement exp(s t) of the towers."""
        stiffness, damping, mass = self._columns
        return stiffness + s * (damping + s * mass)

    def rows(self, s: complex) -> NDArray[Any]:
        """Minus the force on the towers per motion exp(s t) of all unknowns."""
        stiffness, damping, mass = self._rows
        return stiffness + s * (damping + s * mass)
