"""A span in modal coordinates: natural modes, their damping, and the quasi-steady wind load projected on them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Model, Outcome, Report, Scene, SceneError, SimulationError
from gallop_fmu.scene.aerodynamics import PolynomialCoefficients
from gallop_fmu.scene.time_functions import Constant
from modal.foundation.shape_functions import Sections
from modal.linear.modes import Family, Mode, natural_modes

Array = NDArray[np.float64]

CALM = PolynomialCoefficients(
    valid_from_deg=-180.0,
    valid_to_deg=180.0,
    lift=(0.0,),
    drag=(0.0,),
    moment=(0.0,),
    outside="hold",
)
"""Stands for the coefficients of a scene that has none, because no wind blows."""

TURN = 2.0 * np.pi
WEAK_WIND = 1e-6
"""Wind whose force is a smaller part of the weight has no attack angle to judge, as in the kernel (aero.c)."""

EQUILIBRIUM_TOLERANCE = 1e-12
EQUILIBRIUM_ITERATIONS = 30


@dataclass(frozen=True)
class WindLoad:
    """Quasi-steady wind load on the modes of a span (Liu, Yan, Zhang, Zhou 2009, equations 20 and 21).

    It is evaluated in the relative wind (-v2 - r omega, U - v3) at the attack angle alpha0 + theta
    + its direction, in the plane of each section: v2 is the velocity along the conductor's normal
    n2 (see `modal.foundation.shape_functions.Sections`).

    Attributes
    ----------
    motion : ndarray, shape (3 point, 2 mode)
        From the state (q, q') to theta, v2 + r omega and v3 at the points along the span.
    collect : ndarray, shape (mode, 3 point)
        From the load per unit length (along n2, with the wind, twisting) at the points to the
        modes.
    attack_angle : float
        Initial angle alpha0 of the ice [rad].
    radius : float
        Radius r that the twist's part of the relative wind refers to [m].
    diameter, half_density_diameter : float
        Diameter d [m], and air density times d over 2 [kg/m2].
    centre, half_range : float
        Middle and half width of the curve's validity range [rad].
    limited : bool
        Whether an angle outside the range is an error; else the coefficient there is the one at the
        end of the range.
    weak : float
        Force per length [N/m] of a coefficient of one, up to which the wind on a section cannot
        matter.
    inner, origin, coefficient
        The curve: inner breakpoints, and origins and coefficients (power, coefficient, piece) of
        its cubics.
    """

    motion: Array
    collect: Array
    attack_angle: float
    radius: float
    diameter: float
    half_density_diameter: float
    centre: float
    half_range: float
    limited: bool
    weak: float
    inner: Array
    origin: Array
    coefficient: Array

    @classmethod
    def of(cls, scene: Scene, x: Array, shapes: Array) -> WindLoad:
        """The scene's wind load on modes with the given nodal shapes (node, 4, mode); x are the nodes' places."""
        sections = Sections.of(x)
        u2, u3, theta = sections.motion(shapes)
        length = sections.length[:, None]
        aerodynamics = CALM if scene.aerodynamics is None else scene.aerodynamics
        curve, given = aerodynamics.curve(), aerodynamics.reference_radius
        radius = 0.5 * scene.conductor.diameter if given is None else given
        first, last = curve.breakpoint[[0, -1]].tolist()
        still = np.zeros_like(theta)
        return cls(
            motion=np.block([[theta, still], [still, u2 + radius * theta], [still, u3]]),
            collect=np.concatenate([length * u2, length * u3, length * theta]).T.copy(),
            attack_angle=math.radians(scene.ice.attack_angle_deg),
            radius=radius,
            diameter=scene.conductor.diameter,
            half_density_diameter=0.5 * scene.wind.air_density * scene.conductor.diameter,
            centre=0.5 * (first + last),
            half_range=0.5 * (last - first),
            limited=curve.outside == "error",
            weak=WEAK_WIND
            * (scene.conductor.mass_per_length + scene.ice.mass_per_length)
            * scene.span.gravity,
            inner=curve.breakpoint[1:-1],
            origin=curve.origin,
            coefficient=np.ascontiguousarray(curve.coefficient.transpose(2, 1, 0)),
        )

    def __call__(self, state: Array, wind_speed: float) -> tuple[Array, float]:
        """Modal load at the state (q, q'), and the attack angle [rad] that is farthest from the middle of the curve.

        The angle is that of the sections on which the wind matters; without any it is the middle of
        the curve.
        """
        if wind_speed == 0.0:  # as in the simulation, still air exerts no force
            return np.zeros(len(self.collect)), self.centre
        theta, rise, drift = (self.motion @ state).reshape(3, -1)
        w2, w3 = -rise, wind_speed - drift
        offset = self.attack_angle - self.centre + theta + np.arctan2(w2, w3)
        offset -= TURN * np.rint(offset / TURN)
        angle = self.centre + np.minimum(np.maximum(offset, -self.half_range), self.half_range)
        piece = self.inner.searchsorted(angle, side="right")
        c, s = self.coefficient[:, :, piece], angle - self.origin[piece]
        lift, drag, moment = c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        square = w2 * w2 + w3 * w3
        q = self.half_density_diameter * np.sqrt(square)
        load = np.concatenate(
            [
                q * (lift * w3 + drag * w2),
                q * (drag * w3 - lift * w2),
                self.half_density_diameter * self.diameter * square * moment,
            ]
        )
        judged = np.where(self.half_density_diameter * square > self.weak, offset, 0.0)
        return self.collect @ load, self.centre + float(judged[np.abs(judged).argmax()])

    def leaves_curve(self, angle: float) -> bool:
        """Whether the simulation would refuse this attack angle [rad]."""
        return self.limited and abs(angle - self.centre) > self.half_range


@dataclass(frozen=True)
class ModalSpan:
    """A span in modal coordinates q: q'' + damping q' + diag(squares) q = wind load + applied loads.

    Attributes
    ----------
    scene : Scene
        The span.
    modes : tuple of Mode
        The natural modes taken: vertical, horizontal, torsional, each from the lowest.
    shapes : ndarray, shape (node, 4, mode)
        Their mass-normalised shapes.
    squares : ndarray, shape (mode,)
        Squared angular frequencies [1/s2].
    damping : ndarray, shape (mode, mode)
        Structural damping [1/s], nearly diagonal.
    seed : ndarray, shape (mode,)
        The scene's initial disturbance.
    wind_load : WindLoad
        The nonlinear load.
    model : Model
        The simulation's model of the same span.
    """

    scene: Scene
    modes: tuple[Mode, ...]
    shapes: Array
    squares: Array
    damping: Array
    seed: Array
    wind_load: WindLoad
    model: Model

    @classmethod
    def of(cls, scene: Scene, *, vertical: int, horizontal: int, torsional: int) -> ModalSpan:
        """The lowest modes of each family, and everything of the scene projected on them.

        Raises
        ------
        SceneError
            If a number of modes is not allowed, the mesh has too few, or a tower moves.
        SimulationError
            If no initial equilibrium exists.
        """
        _check_towers(scene)
        modes = _lowest(
            scene, {"vertical": vertical, "horizontal": horizontal, "torsional": torsional}
        )
        model, initial = Model(scene), scene.initial
        x, shapes = model.equilibrium().x, np.stack([mode.shape for mode in modes], axis=2)
        seed, wave = np.zeros((model.nodes, 4)), np.sin(np.pi * x[1:-1, 0] / scene.span.length)
        seed[1:-1, 1:] = wave[:, None] * [
            initial.seed_vertical,
            initial.seed_horizontal,
            initial.seed_twist,
        ]
        still, parts = Inputs.still(scene), _by_element(shapes)
        mass = model.tangent(mass=1.0, inputs=still)
        return cls(
            scene=scene,
            modes=modes,
            shapes=shapes,
            squares=np.array([(2.0 * np.pi * mode.frequency_hz) ** 2 for mode in modes]),
            damping=_projected(parts, model.tangent(damping=1.0, inputs=still)),
            seed=np.einsum("eam,eab,eb->m", parts, mass, _by_element(seed)),
            wind_load=WindLoad.of(scene, x, shapes),
            model=model,
        )

    def applied(self, time: Array) -> Array:
        """Modal load of the scene's concentrated loads at each time [s], shape (time, mode)."""
        total = np.zeros((len(time), len(self.modes)))
        for load in self.scene.loads:
            unit = load.model_copy(update={"law": Constant(value=1.0)})
            with_unit, without = (
                Model(self.scene.model_copy(update={"loads": loads})) for loads in ((unit,), ())
            )
            still = Inputs.still(self.scene)
            force = without.residual(inputs=still) - with_unit.residual(inputs=still)
            total += np.outer(load.law.at(time), np.einsum("nim,ni->m", self.shapes, force))
        return total

    def rest(self, wind_speed: float) -> Array:
        """Modal coordinates at rest in a constant wind [m/s] and under the applied loads at t = 0.

        Raises
        ------
        SimulationError
            If there is no such state near the initial equilibrium: the wind turns the conductor
            over.
        """
        applied, q = self.applied(np.zeros(1))[0], np.zeros(len(self.modes))
        for _ in range(EQUILIBRIUM_ITERATIONS):
            force, _ = self.wind_load(np.concatenate([q, np.zeros_like(q)]), wind_speed)
            stiffness, _ = self.wind_slopes(q, wind_speed)
            step = np.linalg.solve(
                np.diag(self.squares) - stiffness, force + applied - self.squares * q
            )
            q = q + step
            if np.max(np.abs(self.shapes @ step)) < EQUILIBRIUM_TOLERANCE * max(
                1.0, np.max(np.abs(self.shapes @ q))
            ):
                return q
        raise SimulationError(Report(Outcome.EQUILIBRIUM_NOT_FOUND, 0.0))

    def wind_slopes(self, q: Array, wind_speed: float) -> tuple[Array, Array]:
        """Derivatives of the modal wind load by q and by q', at rest at q, from the simulation's own tangents."""
        u, parts = self.shapes @ q, _by_element(self.shapes)
        still = Inputs.still(self.scene)
        blowing = replace(still, wind_speed=wind_speed)

        def slope(stiffness: float, damping: float) -> Array:
            without, within = (
                self.model.tangent(u, stiffness=stiffness, damping=damping, inputs=inputs)
                for inputs in (still, blowing)
            )
            return _projected(parts, without - within)

        return slope(1.0, 0.0), slope(0.0, 1.0)

    def structure(self) -> Array:
        """State matrix of (q, q') without wind."""
        count = len(self.modes)
        return np.block(
            [[np.zeros((count, count)), np.eye(count)], [-np.diag(self.squares), -self.damping]]
        )

    def linear_system(self, wind_speed: float) -> tuple[Array, Array]:
        """State matrix of (q, q') with the wind load linearised about rest in the wind [m/s], and that rest."""
        count, matrix = len(self.modes), self.structure()
        rest = self.rest(wind_speed)
        matrix[count:] += np.hstack(self.wind_slopes(rest, wind_speed))
        return matrix, np.concatenate([rest, np.zeros(count)])

    def start(self) -> Array:
        """State (q, q') at t = 0: the seed, on rest in still air or in the wind as the scene says."""
        q = self.seed
        if self.scene.initial.wind == "mean_wind_equilibrium":
            q = q + self.rest(float(wind_at(self.scene, np.zeros(1))[0]))
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


def _lowest(scene: Scene, wanted: dict[Family, int]) -> tuple[Mode, ...]:
    """The lowest modes of each family, looked for in ever more modes of the mesh."""
    for family, count in wanted.items():
        if isinstance(count, bool) or not isinstance(count, int) or count < 0:
            raise SceneError(f"{family} = {count}: must be a whole number of modes, 0 or more")
    if not any(wanted.values()):
        raise SceneError("vertical, horizontal and torsional are all 0; take at least one mode")
    most = 4 * (2 * scene.numerics.elements - 1)  # unknowns between rigid ends
    among = min(most, 4 * sum(wanted.values()) + 8)
    while True:
        found = natural_modes(scene, among)
        families = {family: [mode for mode in found if mode.family == family] for family in wanted}
        short = [family for family, count in wanted.items() if len(families[family]) < count]
        if not short:
            return tuple(
                mode for family, count in wanted.items() for mode in families[family][:count]
            )
        if among == most:
            family = short[0]
            raise SceneError(
                f"{family} = {wanted[family]}: this mesh has only {len(families[family])} {family}"
                " modes; ask for fewer or raise numerics.elements"
            )
        among = min(most, 2 * among)


def _by_element(nodal: Array) -> Array:
    """From (node, 4, ...) to (element, 12, ...)."""
    elements = len(nodal) // 2
    node = 2 * np.arange(elements)[:, None] + np.arange(3)
    return np.asarray(nodal[node].reshape(elements, 12, *nodal.shape[2:]))


def _projected(parts: Array, matrices: Array) -> Array:
    """Element matrices (element, 12, 12) projected on modes (element, 12, mode)."""
    return np.asarray(np.einsum("eam,eab,ebn->mn", parts, matrices, parts, optimize=True))
