"""A span in modal coordinates: natural modes, their damping, and the nonlinear wind load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Model, Outcome, Report, Scene, SceneError, SimulationError
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.scene.time_functions import Constant
from modal.foundation import one_span as instead
from modal.foundation.normal_wind import check_wind_is_normal
from modal.linear.modes import Family, Mode, natural_modes
from modal.linear.projection import Projection

Array = NDArray[np.float64]

EQUILIBRIUM_TOLERANCE = 1e-12
"""Largest last correction of a displacement [m, rad], relative to the largest of them or to 1."""

EQUILIBRIUM_ITERATIONS = 30
"""Most Newton iterations for an equilibrium in the wind."""


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
    """

    force: Array
    angle: float
    excess: float


@dataclass(frozen=True)
class ModalSpan:
    """A span in modal coordinates q: q'' + damping q' + diag(squares) q = wind and other loads.

    Attributes
    ----------
    scene : Scene
        The span.
    modes : tuple of Mode
        The natural modes taken: vertical, horizontal, torsional, each from the lowest.
    squares : ndarray, shape (mode,)
        Squared angular frequencies [1/s2].
    damping : ndarray, shape (mode, mode)
        Structural damping [1/s], nearly diagonal.
    seed : ndarray, shape (mode,)
        The scene's initial disturbance.
    projection : Projection
        The mass-normalised shapes, and what is projected on them.
    """

    scene: Scene
    modes: tuple[Mode, ...]
    squares: Array
    damping: Array
    seed: Array
    projection: Projection

    @classmethod
    def of(cls, scene: Scene, *, vertical: int, horizontal: int, torsional: int) -> ModalSpan:
        """Project a scene on the lowest modes of each family.

        Raises
        ------
        SceneError
            If a number of modes is not allowed, the mesh has too few, or a tower moves.
        SimulationError
            If no initial equilibrium exists.
        """
        scene = one_span(scene, "mode superposition", instead.SUPERPOSITION)
        _check_towers(scene)
        check_wind_is_normal(scene, "mode superposition")
        if scene.wind.table is not None or scene.wind.has_turbulence:
            raise SceneError(
                "wind.turbulence or wind.table is given, and mode superposition takes uniform wind;"
                " remove it, or simulate the scene"
            )
        modes = _lowest(
            scene, {"vertical": vertical, "horizontal": horizontal, "torsional": torsional}
        )
        mesh = Mesh(Model(scene))
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
        """The finite elements of the simulation of the same span."""
        return self.projection.mesh

    @property
    def shapes(self) -> Array:
        """Shapes of the modes, (node, 4, mode)."""
        return np.moveaxis(self.projection.shapes, 0, -1)

    def wind_load(self, state: Array, wind_speed: float) -> WindLoad:
        """Wind load at the state (q, q') in a wind [m/s], integrated as in the simulation."""
        motion = self.projection.at_sections(state.reshape(2, -1))
        u, v = motion[:, :1], motion[:, 1:]
        air = self.mesh.aero_load(u[2], v[0], v[1], v[2], wind_speed)
        worst = int(np.abs(air.excess).argmax())
        return WindLoad(
            self.projection.collect(air.force)[0],
            float(air.angle[0, worst]),
            float(air.excess[0, worst]),
        )

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

    def equilibrium(self, wind_speed: float) -> Array:
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

    def wind_slopes(self, q: Array, wind_speed: float) -> tuple[Array, Array]:
        """Derivatives of the modal wind load by q and by q', at q and q' = 0, in a wind [m/s].

        The load is in the residual of the simulation with a minus sign: its derivatives are the
        tangents in still air less those in the wind.
        """
        u, mesh = self.shapes @ q, self.mesh
        blowing = Inputs.still(self.scene, wind_speed=wind_speed)
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

    def linear_system(self, wind_speed: float) -> tuple[Array, Array]:
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
            q = q + self.equilibrium(float(wind_at(self.scene, np.zeros(1))[0]))
        return np.concatenate([q, np.zeros_like(q)])


def wind_at(scene: Scene, time: Array) -> Array:
    """Wind speed [m/s] at each time [s]."""
    history = scene.wind.history
    return (
        np.full(len(time), scene.wind.mean_speed)
        if history is None
        else np.asarray(history.at(time))
    )


def _check_towers(scene: Scene) -> None:
    for side in ("left", "right"):
        if getattr(scene.supports, side).motion is not None:
            raise SceneError(
                f"supports.{side}.motion is given, but natural modes have their supports at rest;"
                " take it out, or use gallop_fmu.simulate"
            )


def _check_counts(wanted: dict[Family, int]) -> None:
    for family, count in wanted.items():
        if isinstance(count, bool) or not isinstance(count, int) or count < 0:
            raise SceneError(f"{family} = {count}: must be a whole number of modes, 0 or more")
    if not any(wanted.values()):
        raise SceneError("vertical, horizontal and torsional are all 0; take at least one mode")


def _lowest(scene: Scene, wanted: dict[Family, int]) -> tuple[Mode, ...]:
    """Find the lowest modes of each family, among more and more modes of the mesh.

    Raises
    ------
    SceneError
        If a number of modes is not allowed, or the mesh has too few.
    """
    _check_counts(wanted)
    most = 4 * (2 * scene.numerics.elements - 1)  # unknowns between rigid ends
    among = min(most, 4 * sum(wanted.values()) + 8)
    while True:
        found = natural_modes(scene, among)
        families = {family: [mode for mode in found if mode.family == family] for family in wanted}
        short = [family for family, count in wanted.items() if len(families[family]) < count]
        if not short:
            return tuple(mode for family in wanted for mode in families[family][: wanted[family]])
        if among == most:
            family = short[0]
            raise SceneError(
                f"{family} = {wanted[family]}: this mesh has only {len(families[family])} {family}"
                " modes; ask for fewer or raise numerics.elements"
            )
        among = min(most, 2 * among)
