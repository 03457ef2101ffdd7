"""A span or line in modal coordinates: natural modes, their damping, and the nonlinear wind load.

The wind load is evaluated by the kernel at the sections of all conductors, each with its own curve,
attack angle, twist and wind; by the principle of virtual work it becomes a load on the modes. What
strings, spacers and devices do is in the matrices of the line, linear about its equilibrium.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import (
    LineScene,
    Model,
    Outcome,
    Report,
    Scene,
    SceneError,
    SimulationError,
)
from gallop_fmu.engine.mesh import SECTIONS, AeroLoad, Mesh
from gallop_fmu.scene.devices import Interval
from gallop_fmu.scene.time_functions import Constant
from modal.foundation.normal_wind import check_wind_is_normal
from modal.linear.line_modes import LineMode, line_modes
from modal.linear.linearise import SmallMotion
from modal.linear.modes import Mode, natural_modes
from modal.linear.projection import Projection

Array = NDArray[np.float64]

EQUILIBRIUM_TOLERANCE = 1e-12
"""Largest last correction of a displacement [m, rad], relative to the largest of them or to 1."""

EQUILIBRIUM_ITERATIONS = 30
"""Most Newton iterations for an equilibrium in the wind."""

FULL_TURN = 2.0 * np.pi
"""A turn [rad]."""

BUNDLE = "bundle"
"""Name of the group of modes in which subconductors of a bundle move against each other."""


@dataclass(frozen=True)
class WindLoad:
    """Wind load on the modes at one instant.

    Attributes
    ----------
    force : ndarray, shape (mode,)
        Modal force.
    angle, excess : float
        Attack angle [rad] of the section at which it leaves the coefficient curve farthest, and by
        how much, as in `gallop_fmu.engine.mesh.AeroLoad`; an excess of 0: at none.
    element : int
        Element of that section, from 0.
    """

    force: Array
    angle: float
    excess: float
    element: int


@dataclass(frozen=True)
class ModalModel:
    """A span or line in modal coordinates q: q'' + damping q' + diag(squares) q = all loads.

    Attributes
    ----------
    scene : Scene or LineScene
        The span or line.
    modes : tuple of Mode or LineMode
        The natural modes taken: vertical, horizontal, torsional, of bundles; each from the lowest.
    squares : ndarray, shape (mode,)
        Squared angular frequencies [1/s2].
    damping : ndarray, shape (mode, mode)
        Damping of structure, strings and devices [1/s], nearly diagonal.
    seed : ndarray, shape (mode,)
        The scene's initial disturbance.
    projection : Projection
        The mass-normalised shapes, and what is projected on them.
    """

    scene: Scene | LineScene
    modes: tuple[Mode | LineMode, ...]
    squares: Array
    damping: Array
    seed: Array
    projection: Projection

    @classmethod
    def of(
        cls, scene: Scene | LineScene, *, vertical: int, horizontal: int, torsional: int
    ) -> ModalModel:
        """Project a scene on the lowest modes of each family.

        Of a line the numbers are for each conductor of each span, as `mode_superposition` says.

        Raises
        ------
        SceneError
            If a number of modes is not allowed, the mesh has too few, or the scene has what mode
            superposition does not: moving towers, wind that is not uniform or not towards +x3, ice
            that falls.
        SimulationError
            If no initial equilibrium exists.
        """
        _check_scene(scene)
        wanted = {"vertical": vertical, "horizontal": horizontal, "torsional": torsional}
        _check_counts(wanted)
        mesh = Mesh(Model(scene))
        modes = _lowest(scene, wanted)
        projection = Projection(mesh, np.stack([mode.shape for mode in modes]))
        mass = mesh.tangent(mass=1.0, inputs=mesh.still)
        momentum = (mass @ mesh.seed().ravel()).reshape(-1, 4)
        return cls(
            scene=scene,
            modes=modes,
            squares=np.array([(2.0 * np.pi * mode.frequency_hz) ** 2 for mode in modes]),
            damping=projection.matrix(mesh.tangent(damping=1.0, inputs=mesh.still)),
            seed=projection.force(momentum),  # modal mass is 1
            projection=projection,
        )

    @property
    def mesh(self) -> Mesh:
        """The finite elements of the simulation of the same scene."""
        return self.projection.mesh

    @property
    def shapes(self) -> Array:
        """Shapes of the modes, (node, 4, mode)."""
        return np.moveaxis(self.projection.shapes, 0, -1)

    @cached_property
    def _span_of_element(self) -> NDArray[np.intp]:
        """Span of each element, from 0."""
        chains = self.mesh.model.map.chains
        return np.repeat([chain.span - 1 for chain in chains], [chain.elements for chain in chains])

    @cached_property
    def _groups(self) -> list[tuple[int, NDArray[np.intp]]]:
        """Elements with the same cross-section: one of them, and the sections of all."""
        of_element = self.mesh.model.section_of_element
        found = []
        for number in np.unique(of_element):
            elements = np.flatnonzero(of_element == number)
            sections = (SECTIONS * elements[:, None] + np.arange(SECTIONS)).ravel()
            found.append((int(elements[0]), sections))
        return found

    def wind_load(self, state: Array, wind_speed: float | Array) -> WindLoad:
        """Wind load at the state (q, q'), integrated as in the simulation.

        Parameters
        ----------
        state : ndarray, shape (2 mode,)
            Modal coordinates and their rates.
        wind_speed
            Wind speed [m/s], of all spans or of each.
        """
        motion = self.projection.at_sections(state.reshape(2, -1))
        u, v = motion[:, :1], motion[:, 1:]
        air = self._air(u[2], v, wind_speed)
        worst = int(np.abs(air.excess).argmax())
        return WindLoad(
            self.projection.collect(air.force)[0],
            float(air.angle[0, worst]),
            float(air.excess[0, worst]),
            worst // SECTIONS,
        )

    def _air(self, theta: Array, v: Array, wind_speed: float | Array) -> AeroLoad:
        """Load per unit length at all sections; (instant, section) and (3, instant, section)."""
        wind, attack = wind_speed, self.mesh.model.attack_of_element
        if np.size(wind) > 1:
            wind = np.repeat(np.asarray(wind)[self._span_of_element], SECTIONS)
        if len(self._groups) == 1:
            return self.mesh.aero_load(theta, v[0], v[1], v[2], wind, attack_angle=attack[0])
        force, (angle, excess) = np.empty_like(v), np.empty((2, *theta.shape))
        wind = np.broadcast_to(wind, theta.shape[-1:])
        for element, at in self._groups:
            of_group = self.mesh.aero_load(
                theta[:, at],
                v[0][:, at],
                v[1][:, at],
                v[2][:, at],
                wind[at],
                attack_angle=attack[element],
                element=element,
            )
            force[:, :, at] = of_group.force
            angle[:, at], excess[:, at] = of_group.angle, of_group.excess
        return AeroLoad(force, None, angle, excess)

    def attack_angle(self, node: int, motion: tuple[Array, Array], wind_speed: Array) -> Array:
        """Attack angle [rad] at a node, (time,).

        Parameters
        ----------
        node
            A node of a conductor.
        motion : tuple of ndarray, shape (time, 4)
            Its displacements and velocities: u1, u2, u3 and theta.
        wind_speed : ndarray, shape (time, span)
            Wind speed [m/s].
        """
        (u, v), mesh = motion, self.mesh
        ends_there = (mesh.nodes == node).any(axis=1)
        element = int(np.flatnonzero(ends_there)[-1])  # the one to the right of the node
        wind = wind_speed[:, self._span_of_element[element] % wind_speed.shape[1]]
        v2 = v[:, :2] @ mesh.node_normal[node]
        attack = mesh.model.attack_of_element[element]
        air = mesh.aero_load(
            u[:, 3], v2, v[:, 2], v[:, 3], wind, attack_angle=attack, element=element
        )
        return air.angle

    def curve_limit(self, air: WindLoad) -> float:
        """End [rad] of the coefficient curve that an attack angle has passed."""
        curves = [self.scene.aerodynamics]
        if isinstance(self.scene, LineScene):
            curves += [d.aerodynamics for d in self.scene.devices if isinstance(d, Interval)]
        ends = [
            float(curve.curve().breakpoint[-1 if air.excess > 0.0 else 0])
            for curve in curves
            if curve is not None
        ]
        turns = [(air.angle - air.excess - end) / FULL_TURN for end in ends]
        return ends[int(np.argmin([abs(turn - round(turn)) for turn in turns]))]

    def applied(self, time: Array) -> Array:
        """Modal load of the scene's concentrated loads at each time [s], shape (time, mode)."""
        total = np.zeros((len(time), len(self.modes)))
        for load in self.scene.loads:
            unit = load.model_copy(update={"law": Constant(value=1.0)})
            with_unit, without = (
                Model(self.scene.model_copy(update={"loads": loads})) for loads in ((unit,), ())
            )
            still = self.mesh.still
            force = without.residual(inputs=still) - with_unit.residual(inputs=still)
            total += np.outer(load.law.at(time), self.projection.force(force))
        return total

    def equilibrium(self, wind_speed: float | Array) -> Array:
        """Equilibrium (mode,) in a constant wind [m/s] and under the applied loads at t = 0.

        Raises
        ------
        SimulationError
            If there is no such state near the initial equilibrium: the wind turns the conductor
            over.
        """
        applied, q = self.applied(np.zeros(1))[0], np.zeros(len(self.modes))
        for _ in range(EQUILIBRIUM_ITERATIONS):
            force = self.wind_load(np.concatenate([q, np.zeros_like(q)]), wind_speed).force
            stiffness, _ = self.wind_slopes(q, wind_speed)
            step = np.linalg.solve(
                np.diag(self.squares) - stiffness, force + applied - self.squares * q
            )
            q = q + step
            if not np.all(np.isfinite(q)):
                break
            if np.max(np.abs(self.shapes @ step)) < EQUILIBRIUM_TOLERANCE * max(
                1.0, np.max(np.abs(self.shapes @ q))
            ):
                return q
        raise SimulationError(Report(Outcome.EQUILIBRIUM_NOT_FOUND, 0.0))

    def wind_slopes(self, q: Array, wind_speed: float | Array) -> tuple[Array, Array]:
        """Derivatives of the modal wind load by q and by q', at q and q' = 0, in a wind [m/s].

        The load is in the residual of the simulation with a minus sign: its derivatives are the
        tangents in still air less those in the wind.
        """
        u, mesh = self.shapes @ q, self.mesh
        wind = np.asarray(wind_speed)
        blowing = replace(mesh.still, wind_speed=wind.item() if wind.size == 1 else wind)
        by_displacement, by_velocity = (
            self.projection.matrix(
                mesh.tangent(u, **{part: 1.0}, inputs=mesh.still)
                - mesh.tangent(u, **{part: 1.0}, inputs=blowing)
            )
            for part in ("stiffness", "damping")
        )
        return by_displacement, by_velocity

    def structure(self) -> Array:
        """State matrix of (q, q') without wind."""
        count = len(self.modes)
        return np.block(
            [[np.zeros((count, count)), np.eye(count)], [-np.diag(self.squares), -self.damping]]
        )

    def linear_system(self, wind_speed: float | Array) -> tuple[Array, Array]:
        """Linearise the wind load about the equilibrium in a wind [m/s].

        Returns
        -------
        ndarray, ndarray
            State matrix of (q, q'), and the state of the equilibrium.
        """
        count, matrix = len(self.modes), self.structure()
        q = self.equilibrium(wind_speed)
        matrix[count:] += np.hstack(self.wind_slopes(q, wind_speed))
        return matrix, np.concatenate([q, np.zeros(count)])

    def start(self) -> Array:
        """State (q, q') at t = 0: the seed plus the equilibrium in which the scene starts."""
        q = self.seed
        if self.scene.initial.wind == "mean_wind_equilibrium":
            q = q + self.equilibrium(wind_at(self.scene, np.zeros(1))[0])
        return np.concatenate([q, np.zeros_like(q)])


def wind_at(scene: Scene | LineScene, time: Array) -> Array:
    """Wind speed [m/s] of each span at each time [s], shape (time, span)."""
    if isinstance(scene, LineScene):
        laws = [scene.wind_of_span(span + 1) for span in range(len(scene.section.spans))]
        return np.stack([np.asarray(law.at(time)) for law in laws], axis=1)
    history = scene.wind.history
    speed = scene.wind.mean_speed if history is None else np.asarray(history.at(time))
    return np.broadcast_to(speed, time.shape)[:, None]


def mean_wind(scene: Scene | LineScene) -> Array:
    """Mean wind speed [m/s] of each span."""
    if isinstance(scene, LineScene):
        spans = range(1, len(scene.section.spans) + 1)
        return np.array([scene.wind_of_span(span).mean_value for span in spans])
    return np.array([scene.wind.mean_speed])


def _check_scene(scene: Scene | LineScene) -> None:
    """Refuse a scene that mode superposition cannot compute."""
    _check_towers(scene)
    for speed in mean_wind(scene):
        check_wind_is_normal(scene, "mode superposition", float(speed))
    if scene.wind.table is not None or scene.wind.has_turbulence:
        raise SceneError(
            "wind.turbulence or wind.table is given, and mode superposition takes uniform wind;"
            " remove it, or simulate the scene"
        )
    if scene.shedding:
        raise SceneError(
            "shedding is given, and natural modes keep their ice; remove it, or use"
            " gallop_fmu.simulate"
        )


def _check_towers(scene: Scene | LineScene) -> None:
    held: dict[str, Any] = {}
    if isinstance(scene, LineScene):
        section = scene.section
        held |= {"section.left_end": section.left_end, "section.right_end": section.right_end}
        held |= {f"section.suspensions.{k}": one for k, one in enumerate(section.suspensions)}
    else:
        held |= {"supports.left": scene.supports.left, "supports.right": scene.supports.right}
    for name, one in held.items():
        if one.motion is not None:
            raise SceneError(
                f"{name}.motion is given, but natural modes have their supports at rest;"
                " take it out, or use gallop_fmu.simulate"
            )


def _check_counts(wanted: dict[str, int]) -> None:
    for family, count in wanted.items():
        if isinstance(count, bool) or not isinstance(count, int) or count < 0:
            raise SceneError(f"{family} = {count}: must be a whole number of modes, 0 or more")
    if not any(wanted.values()):
        raise SceneError("vertical, horizontal and torsional are all 0; take at least one mode")


@dataclass(frozen=True)
class _Group:
    """A number of modes of some families; `each` is the number that the user gives."""

    families: tuple[str, ...]
    count: int
    each: int


def _groups_of(scene: Scene | LineScene, wanted: dict[str, int]) -> dict[str, _Group]:
    """Families and numbers of modes to take, by name."""
    if isinstance(scene, Scene):
        return {name: _Group((name,), count, count) for name, count in wanted.items()}
    bundles = len(scene.section.spans) * len(scene.phases)
    conductors = scene.bundle.subconductors
    vertical, horizontal, torsional = wanted["vertical"], wanted["horizontal"], wanted["torsional"]
    across = (conductors - 1) * (vertical + horizontal)
    return {
        "vertical": _Group(("vertical", "tension-neutral"), bundles * vertical, vertical),
        "horizontal": _Group(("horizontal",), bundles * horizontal, horizontal),
        "torsional": _Group(("torsional",), bundles * conductors * torsional, torsional),
        BUNDLE: _Group(("bundle torsion", "sub-span"), bundles * across, vertical + horizontal),
    }


def _modes_of(
    scene: Scene | LineScene,
) -> tuple[int, Callable[[int], Sequence[Mode | LineMode]]]:
    """Number of modes of a mesh, and a function that returns a number of the lowest."""
    if isinstance(scene, LineScene):
        small = SmallMotion(scene)
        equations = small.in_still_air()
        return int(equations.free.sum()), partial(line_modes, equations, small.mesh)
    most = 4 * (2 * scene.elements - 1)  # unknowns between rigid ends
    return most, partial(natural_modes, scene)


def _lowest(scene: Scene | LineScene, wanted: dict[str, int]) -> tuple[Mode | LineMode, ...]:
    """Find the lowest modes of each family, among more and more modes of the mesh.

    Raises
    ------
    SceneError
        If the mesh has too few.
    """
    groups = _groups_of(scene, wanted)
    most, modes_among = _modes_of(scene)
    among = min(most, 4 * sum(group.count for group in groups.values()) + 8)
    while True:
        found = modes_among(among)
        chosen = {
            name: [mode for mode in found if mode.family in group.families][: group.count]
            for name, group in groups.items()
        }
        short = [name for name, group in groups.items() if len(chosen[name]) < group.count]
        if not short:
            return tuple(mode for modes in chosen.values() for mode in modes)
        if among == most:
            group, has = groups[short[0]], len(chosen[short[0]])
            name = "vertical + horizontal" if short[0] == BUNDLE else short[0]
            each = "" if group.count == group.each else f", {group.count} in the whole line"
            raise SceneError(
                f"{name} = {group.each}{each}: this mesh has only {has}"
                f" {' or '.join(group.families)} modes; ask for fewer or raise numerics.elements"
            )
        among = min(most, 2 * among)
