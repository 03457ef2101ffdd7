"""A line in its lowest modes, with condensed stretching: what `SpanModel` is for one span.

The motion is u = sum of shape_i q_i + w, in the shapes of `modal.motions.line_basis`. Conductors
have the energy (1) of `modal.motions.span_model`; the devices, such as spacers and yokes, have
the derivatives of `modal.motions.device_forms`. With G(a, b) the second derivative of the force of
all of them along two shapes, the other motions follow quasi-statically,

    w = W(q, q)/2,   W = -(1 - V (V'K V)^-1 V'K) K^-1 G,                                         (1)

which has no part in the stiffness of the shapes V: V'K w = 0. This includes the swing of strings
along the line, and the rise of clamps as strings swing. The energy up to the fourth order is

    V = q K q/2 + C(q, q, q)/6 + Q(q, q, q, q)/24 - G(q, q).K_w^-1 G(q, q)/8,                    (2)

where K_w^-1 G = -W. Its quartic part is a quadratic form of the products q_a q_b, and is written as
a sum of few squares of quadratic forms, as are the damping and inertia of w. As not all shapes are
natural modes, w has a part in their inertia: with N = V'M W the kinetic energy has the term
q'.N(q, q'), and the forces

    N(q, q'') + (q''.N)(q) + N(q', q').                                                          (3)

Strings that carry one clamp are not expanded: their force is exact (`modal.motions.string_forces`).
Devices do not damp w: a spacer that rotates is not deformed, although its clamps move inwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, SceneError
from gallop_fmu.engine.mesh import SECTIONS, STRAIN_POINTS, AeroLoad, Mesh
from gallop_fmu.engine.model import DOFS
from gallop_fmu.engine.pack import Packed
from modal.linear.projection import Projection
from modal.motions.device_forms import device_forms
from modal.motions.line_basis import HELD, LineBasis, coarse, line_basis, mirror_image
from modal.motions.span_model import SpanModel, Watched, closest, few_squares
from modal.motions.string_forces import StringForces, has_exact_string

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]
Integers = NDArray[np.intp]

STRING_SWING = "string swing"
"""Family of horizontal modes in which strings swing across the line."""

MIN_PART = 0.2
"""Amplitude of a span, relative to the largest one, from which it takes part in a motion."""

MIN_SWING = 0.1
"""Displacement of a clamp across the line, relative to the largest one, from which it swings."""


class LineModel(SpanModel):
    """The line in the coordinates of its lowest modes.

    Parameters
    ----------
    scene
        The line.
    basis
        Its modes in still air.
    like
        Model of a similar scene, as of `SpanModel`.

    Attributes
    ----------
    basis : LineBasis
        The shapes.
    family : list of str
        Family of each mode.

    Raises
    ------
    SceneError
        If the line has no coefficient curve, or its modes are not those of the similar scene.
    """

    scene: LineScene  # type: ignore[assignment]

    def __init__(
        self, scene: LineScene, basis: LineBasis | None = None, like: LineModel | None = None
    ) -> None:
        if scene.aerodynamics is None:
            raise SceneError(
                "aerodynamics is not given: without a coefficient curve no wind can drive the line"
            )
        basis = line_basis(scene) if basis is None else basis
        self.scene, self.basis = coarse(scene), basis
        self.mesh = basis.mesh
        equations = basis.equations
        shapes = basis.shapes
        if like is not None:
            shapes = closest(shapes, like.shapes, equations.mass, scene.title)
        self.shapes = shapes
        self.family = basis.family
        self._projection = Projection(self.mesh, shapes)
        self.mass, self.damping, self.stiffness = (
            self._projection.matrix(a)
            for a in (equations.mass, equations.damping, equations.stiffness)
        )
        self._strings = self._strings_of()
        for string in self._strings:  # `_add_lag` has it with its nonlinearity
            self.damping -= string.damping
        self.frequencies = (self._first("vertical"), self._first("horizontal"))
        chains = self.mesh.model.map.chains
        self.middle = shapes[:, [chain.middle for chain in chains]].mean(axis=1)
        self._mirror = mirror_image(scene, self.mesh, shapes, equations.mass)
        self._prepare_stretching()
        self._prepare_sections()

    def _strings_of(self) -> list[StringForces]:
        """Strings of all towers."""
        return [
            StringForces(self.mesh, device, self.shapes, has_exact_string(tower))
            for tower in self.mesh.model.map.towers
            if tower.has_string
            for device in tower.devices
        ]

    def stretching(self, q: Array) -> tuple[Array, Array]:
        """Add the strings that are exact to the force of `SpanModel.stretching`."""
        force, stiffness = super().stretching(q)
        for string in self._strings:
            string.add_static(q, force, stiffness)
        return force, stiffness

    def residual(self, q: Array, v: Array, a: Array, wind: float) -> Array:
        """Add the strings to the forces of `SpanModel.residual`."""
        found = super().residual(q, v, a, wind)
        for string in self._strings:
            string.add_force(q, v, found)
        return found

    def _add_lag(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Add the damping of w and of the strings to forces; return its derivatives by q and v.

        The damping of a string acts on its change of length, which is almost zero as it swings; but
        the clamp rises, and a damping matrix would damp that.
        """
        by_q, by_v = super()._add_lag(q, v, forces)
        for string in self._strings:
            string.add_damping(q, v, forces, by_q, by_v)
        return by_q, by_v

    def _first(self, family: str) -> float:
        """Angular frequency [rad/s] of the lowest mode of a family, or of all modes."""
        modes = self.basis.modes
        return 2.0 * np.pi * next((m for m in modes if m.family == family), modes[0]).frequency_hz

    @property
    def elements(self) -> int:
        """Number of elements of a span, if it has no number of its own."""
        return self.scene.numerics.elements

    @property
    def bundles(self) -> int:
        """Number of conductors or bundles in all spans."""
        line = self.mesh.model.map
        return line.spans * line.phases

    def where(self, moves: Watched) -> str:
        """Spans in which a motion is, in words; empty if it is in all, in phase."""
        line = self.mesh.model.map
        parts = [one - one.mean(axis=0) for one in (moves.u2, moves.quarter, moves.u3)]
        part = max(parts, key=lambda one: float(np.max(np.abs(one))))
        size = np.ptp(part, axis=0)
        moving = np.flatnonzero(size > MIN_PART * np.max(size))
        first = part[:, moving[0]]
        against = any(first @ part[:, k] < 0.0 for k in moving)
        spans = sorted({int(k) // line.phases + 1 for k in moving})
        words = ""
        if len(spans) < line.spans:
            listed = " and ".join(map(str, spans[-2:]))
            words = ", ".join([*map(str, spans[:-2]), listed])
            words = f" in span{'s' if len(spans) > 1 else ''} {words}"
        return words + (", spans against each other" if against and len(spans) > 1 else "")

    @property
    def symmetry(self) -> Array | None:
        """Matrix that turns coordinates into those of the mirror image; None: no symmetry."""
        return self._mirror

    @property
    def watched_nodes(self) -> NDArray[np.intp]:
        """Nodes at a quarter, at mid-span and at three quarters of all conductors, then clamps."""
        line = self.mesh.model.map
        nodes = [
            chain.nearest_node(station) for chain in line.chains for station in (0.25, 0.5, 0.75)
        ]
        return np.array(nodes + self._clamps)

    @property
    def _clamps(self) -> list[int]:
        """Nodes of the clamps that hang from strings: of each tower and phase all subconductors."""
        line = self.mesh.model.map
        nodes, leader = self.mesh.model.junction_nodes()
        held = [t.junctions for t in line.towers if t.has_string]
        return [int(leader[nodes[junction]]) for one in held for junction in one]

    def watched(self, values: Array) -> Watched:
        """Put the motion of `watched_nodes` in order; of a bundle the mean of its conductors.

        Parameters
        ----------
        values : ndarray, shape (time, 3, node)
            u2, u3 and theta.
        """
        line = self.mesh.model.map
        along = values[:, :, : 3 * len(line.chains)]
        mean = along.reshape(*values.shape[:2], -1, line.subconductors, 3).mean(axis=3)
        u2, u3, theta = mean[..., 1].swapaxes(0, 1)
        quarter = 0.5 * (mean[:, 0, :, 0] - mean[:, 0, :, 2])
        clamps = values[:, 1, 3 * len(line.chains) :]
        clamp = clamps.reshape(len(values), -1, line.subconductors).mean(axis=2)
        return Watched(u2, u3, theta, quarter, clamp)

    def groups(self) -> list[tuple[str, list[int]]]:
        """Modes that are parts of the same motion, by the word for them and their loops."""
        found: dict[tuple[str, int], list[int]] = {}
        for mode, family in enumerate(self.family):
            if family == HELD:
                continue
            found.setdefault((self._word(mode), self.loops(mode)), []).append(mode)
        return [(word, modes) for (word, _), modes in found.items()]

    def _word(self, mode: int) -> str:
        """Family of a mode, or the swing of strings in it."""
        family = self.family[mode]
        if family == "tension-neutral":
            return "vertical"
        if family == "horizontal" and self._clamps:
            across = np.abs(self.shapes[mode, :, 2])
            if np.max(across[self._clamps]) > MIN_SWING * np.max(across):
                return STRING_SWING
        return family

    def loops(self, mode: int) -> int:
        """Largest number of half-waves of a mode in a span."""
        return max(self.basis.loops[mode])

    def rotated(self, twist: float) -> Array | None:
        """Coordinates in which all conductors are twisted alike at mid-span [rad]."""
        torsional = [i for i, family in enumerate(self.family) if family == "torsional"]
        middles = [chain.middle for chain in self.mesh.model.map.chains]
        if not torsional:
            return None
        at = self.shapes[torsional][:, middles, 3]
        q = np.zeros(self.size)
        q[torsional] = np.linalg.lstsq(at.T, np.full(len(middles), twist), rcond=None)[0]
        return q

    @property
    def highest_hz(self) -> float:
        """Frequency [Hz] below which all modes but torsional ones are kept."""
        return self.basis.highest_hz

    def _prepare_stretching(self) -> None:
        """Compute the cubic form, w, and the quadratic forms of (2)."""
        n = self.size
        rows, columns = np.triu_indices(n)
        force, quartic = self._second_order(rows, columns)
        flat = self.shapes.reshape(n, -1)
        cubic = flat @ force
        following = self._relaxed(force, cubic)
        self._cubic = _tensor(cubic, rows, columns)
        self._following = _tensor(following, rows, columns).transpose(1, 2, 0).copy()
        self._tension = few_squares(quartic + force.T @ following, n)
        equations, mesh = self.basis.equations, self.mesh
        of_elements = mesh.model.tangent(damping=1.0, inputs=mesh.still)
        lag = following.T @ (mesh.gather(mesh.assemble(of_elements)) @ following)
        self._lag = few_squares(lag, n)
        self._coupling = _tensor(flat @ (equations.mass @ following), rows, columns)
        self._inertia = few_squares(following.T @ (equations.mass @ following), n)

    def _second_order(self, rows: Integers, columns: Integers) -> tuple[Array, Array]:
        """Forces G (4 node, pair) of the pairs of shapes, and the quartic form (pair, pair)."""
        points = self.mesh.strain_points
        slope = points.slope(np.moveaxis(self.shapes, 0, -1))[:, :3]  # (point, 3, mode)
        axial = self.scene.conductor.axial_stiffness * points.length
        pull = np.einsum("gi,gim->gm", points.tangent, slope)
        products = np.einsum("gip,gip->gp", slope[:, :, rows], slope[:, :, columns])
        stress = products[:, None] * points.tangent[:, :, None]
        stress += pull[:, None, rows] * slope[:, :, columns]
        stress += pull[:, None, columns] * slope[:, :, rows]
        stress *= axial[:, None, None]
        force = _slope_operator(self.mesh).T @ stress.reshape(-1, len(rows))
        quartic = (axial[:, None] * products).T @ products
        flat = self.shapes.reshape(self.size, -1)
        exact = {
            device
            for tower in self.mesh.model.map.towers
            if has_exact_string(tower)
            for device in tower.devices
        }
        for device in device_forms(self.mesh, exact):
            x = flat[:, device.unknowns]
            pairs = x[rows][:, :, None] * x[columns][:, None, :]
            pairs = pairs.reshape(len(rows), -1)
            size = len(device.unknowns)
            force[device.unknowns] += device.second.reshape(size, -1) @ pairs.T
            third = device.third.reshape(size * size, -1)
            quartic += pairs @ third @ pairs.T / 3.0
        return force, quartic

    def _relaxed(self, force: Array, cubic: Array) -> Array:
        """Displacements W of (1) for forces (4 node, pair)."""
        from scipy.sparse.linalg import splu

        equations, n = self.basis.equations, self.size
        nodal = force.reshape(self.mesh.model.nodes, DOFS, -1)
        gathered = np.zeros_like(nodal)
        np.add.at(gathered, self.mesh.leader, nodal)
        at = np.flatnonzero(equations.free)
        found = np.zeros_like(force)
        factors = splu(equations.stiffness[at][:, at])
        found[at] = -factors.solve(gathered.reshape(force.shape)[at])
        found += self.shapes.reshape(n, -1).T @ np.linalg.solve(self.stiffness, cubic)
        spread = self.mesh.spread(found.reshape(nodal.shape))
        return np.asarray(spread.reshape(force.shape))

    def _prepare_sections(self) -> None:
        """Compute gravity, first moments of the ice, and wind at the sections."""
        sections, mesh = self.mesh.sections, self.mesh
        self._gravity = self.scene.section.gravity * sections.normal[:, 1]
        of_element = mesh.model.section_of_element
        moments = np.array(
            [_first_moments(row) for row in Packed(self.scene).tables["cross_section"]]
        )
        self._first_moments = tuple(np.repeat(moments[of_element], SECTIONS, axis=0).T)
        self._wind = mesh.steady_wind if self.scene.wind.is_varied else None
        self._groups = list(_groups(mesh))
        self._prepare_products()

    def _conductors(self) -> tuple[float | Array, Integers]:
        """Attack angle [rad] at the sections, and an element with their conductor and curve."""
        sections = self._projection.section.shape[2]
        angle, element = np.empty(sections), np.empty(sections, dtype=np.intp)
        for number, at, attack in self._groups:
            angle[at], element[at] = attack, number
        return angle, element

    def _air(self, u: Array, v: Array, wind: float | Array, slopes: bool = False) -> AeroLoad:
        """Aerodynamic load on the sections, each with its own curve and attack angle."""
        along, across = (0.0, 1.0) if self._wind is None else self._wind
        v2, across = v[0] - wind * along, np.broadcast_to(wind * across, v[0].shape)
        if len(self._groups) == 1:
            element, _, attack = self._groups[0]
            return self.mesh.aero_load(
                *(u[2], v2, v[1], v[2], across),
                attack_angle=attack,
                slopes=slopes,
                element=element,
            )
        force, by = np.empty_like(v), np.empty((4, *v.shape)) if slopes else None
        angle, excess = np.empty((2, *v[0].shape))
        for element, at, attack in self._groups:
            air = self.mesh.aero_load(
                *(part[:, at] for part in (u[2], v2, v[1], v[2], across)),
                attack_angle=attack,
                slopes=slopes,
                element=element,
            )
            force[:, :, at], angle[:, at], excess[:, at] = air.force, air.angle, air.excess
            if by is not None:
                by[:, :, :, at] = air.slopes
        return AeroLoad(force, by, angle, excess)


def _slope_operator(mesh: Mesh) -> csr_array:
    """Matrix of the derivatives by the arc length: (3 point, 4 node)."""
    from scipy.sparse import csr_array

    points = mesh.strain_points
    elements = len(points.nodes)
    point = np.arange(elements * STRAIN_POINTS).reshape(elements, STRAIN_POINTS, 1, 1)
    axis = np.arange(3)
    rows = np.broadcast_to(3 * point + axis, (elements, STRAIN_POINTS, 3, 3))
    columns = np.broadcast_to(
        DOFS * points.nodes[:, None, :, None] + axis, (elements, STRAIN_POINTS, 3, 3)
    )
    values = np.broadcast_to(points.shape_slope[:, :, :, None], rows.shape)
    shape = (3 * elements * STRAIN_POINTS, DOFS * mesh.model.nodes)
    return csr_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def _tensor(of_pairs: Array, rows: Integers, columns: Integers) -> Array:
    """Symmetric tensor (any, n, n) of values (any, pair)."""
    n = int(rows[-1]) + 1
    full = np.empty((len(of_pairs), n, n))
    full[:, rows, columns] = full[:, columns, rows] = of_pairs
    return full


def _first_moments(row: Any) -> tuple[float, float]:
    """First moments [kg] of the ice of a cross-section at its initial attack angle."""
    rotation = row.attack_angle - row.first_moment_angle
    sine, cosine = np.sin(rotation), np.cos(rotation)
    m2, m3 = row.first_moment_x2, row.first_moment_x3
    return m2 * cosine - m3 * sine, m2 * sine + m3 * cosine


def _groups(mesh: Mesh) -> Iterator[tuple[int, NDArray[np.intp], float]]:
    """Elements with the same cross-section: one of them, the sections of all, attack angle."""
    of_element = mesh.model.section_of_element
    for number in np.unique(of_element):
        elements = np.flatnonzero(of_element == number)
        sections = (SECTIONS * elements[:, None] + np.arange(SECTIONS)).ravel()
        first = int(elements[0])
        yield first, sections, float(mesh.model.attack_of_element[first])
