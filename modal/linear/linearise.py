"""Small motion about an equilibrium: M q'' + C q' + K q = forces, from the kernel's own tangents.

The unknowns are the displacements of all nodes about the equilibrium, four a node. Those that may
move are "free"; the others follow the tower points ("held") or do not exist (the twist of an end).
The aerodynamic load depends on the wind and on the attack angle only through w3 = U - v3 and alpha
= alpha0 + theta + ..., hence its slopes follow from the tangents exactly:

- by the wind speed, minus the aerodynamic damping matrix times a uniform unit velocity v3;
- by the attack angle, the aerodynamic stiffness matrix times a uniform unit twist, plus the change
  of the torque of the ice's weight, since the ice turns with the attack angle.

Every matrix is taken at the equilibrium itself: eccentric ice that has turned there changes the
mass matrix too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Model, Scene, SceneError, SimulationError

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
WindState = Literal["still", "mean"]


@dataclass(frozen=True)
class Linearised:
    """The equations of small motion about one equilibrium.

    Attributes
    ----------
    mass, damping, stiffness : sparse array, shape (4 node, 4 node)
        Of all unknowns, springs of the supports included [kg, N s/m, N/m and their like for the
        twist]. In wind, damping and stiffness carry the aerodynamic load and are not symmetric.
    free : ndarray of bool, shape (node, 4)
        The unknowns that may move.
    spring : ndarray, shape (2, 3)
        Stiffness [N/m] of the support springs, left and right, along x1, x2, x3; 0 where the end is
        held.
    displacement : ndarray, shape (node, 4)
        The equilibrium, from the initial one [m, rad].
    wind_speed : float
        Wind speed [m/s] of the equilibrium.
    by_wind, by_attack_angle : ndarray, shape (4 node,)
        Force [N, N m] on each unknown per m/s of wind and per rad of attack angle.
    middle : int
        The mid-span node.
    """

    mass: csc_array
    damping: csc_array
    stiffness: csc_array
    free: NDArray[np.bool_]
    spring: Array
    displacement: Array
    wind_speed: float
    by_wind: Array
    by_attack_angle: Array
    middle: int

    def of_free(self) -> tuple[csc_array, csc_array, csc_array]:
        """Mass, damping and stiffness of the free unknowns."""
        kept = np.flatnonzero(self.free)
        return self.mass[kept][:, kept], self.damping[kept][:, kept], self.stiffness[kept][:, kept]


class SmallMotion:
    """Linearises one span about its equilibrium at any wind speed; the model is made once.

    Parameters
    ----------
    scene
        The span.

    Raises
    ------
    SimulationError
        If no initial equilibrium exists.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.model = Model(scene)
        self._unknown = 8 * np.arange(self.model.elements)[:, None] + np.arange(
            12
        )  # neighbours share a corner node
        self._spring = np.zeros((2, 3))
        self._spring[:, [0, 2]] = self.model.equilibrium().support_stiffness
        self._free = np.ones((self.model.nodes, 4), dtype=np.bool_)
        self._free[[0, -1], :3] = self._spring > 0.0
        self._free[[0, -1], 3] = False

    def in_still_air(self) -> Linearised:
        """About the initial equilibrium, without wind."""
        return self._about(np.zeros((self.model.nodes, 4)), 0.0)

    def in_mean_wind(self) -> Linearised:
        """About the static equilibrium under the scene's mean wind."""
        return self.in_wind(self.scene.wind.mean_speed)

    def in_wind(self, speed: float) -> Linearised:
        """About the static equilibrium in wind of any speed [m/s], with the loads and support motions at t = 0.

        Raises
        ------
        SceneError
            If the scene has no coefficient curve, the attack angle leaves it, or there is no
            equilibrium.
        """
        if not (np.isfinite(speed) and speed >= 0.0):
            raise SceneError(f"wind speed = {speed} m/s: must be a finite number, 0 or more")
        if speed > 0.0 and self.scene.aerodynamics is None:
            raise SceneError(
                "the scene has no aerodynamics: wind needs a coefficient curve to become a force"
            )
        try:
            displacement, _, _ = self.model.rest(0.0, self._inputs(speed)).motion()
        except SimulationError as problem:
            raise SceneError(f"no equilibrium in wind of {speed:g} m/s: {problem}") from problem
        return self._about(displacement, speed)

    def _inputs(self, speed: float) -> Inputs:
        support = np.zeros((2, 3))
        for end, held in enumerate((self.scene.supports.left, self.scene.supports.right)):
            for axis in range(3):
                law = getattr(held.motion, f"x{axis + 1}") if held.motion else None
                support[end, axis] = float(law.at(0.0)) if law else 0.0
        return Inputs(0.0, speed, np.radians(self.scene.ice.attack_angle_deg), support)

    def _about(self, u: Array, speed: float) -> Linearised:
        calm, windy = self._inputs(0.0), self._inputs(speed)
        stiffness = self._assembled(self.model.tangent(u, stiffness=1.0, inputs=calm), springs=True)
        damping = self._assembled(self.model.tangent(u, damping=1.0, inputs=calm))
        still = Linearised(
            mass=self._assembled(self.model.tangent(u, mass=1.0, inputs=calm)),
            damping=damping,
            stiffness=stiffness,
            free=self._free,
            spring=self._spring,
            displacement=u,
            wind_speed=speed,
            by_wind=np.zeros(u.size),
            by_attack_angle=np.zeros(u.size),
            middle=self.model.middle,
        )
        if speed == 0.0:
            return still
        in_wind = self._assembled(self.model.tangent(u, stiffness=1.0, inputs=windy), springs=True)
        damped = self._assembled(self.model.tangent(u, damping=1.0, inputs=windy))
        untwisted = u * [1.0, 1.0, 1.0, 0.0]
        without_turn = self._assembled(
            self.model.tangent(untwisted, stiffness=1.0, inputs=calm), springs=True
        )
        return replace(
            still,
            damping=damped,
            stiffness=in_wind,
            by_wind=(damped - damping) @ uniform(u.shape, 2),
            by_attack_angle=-((in_wind - without_turn) @ uniform(u.shape, 3)),
        )

    def _assembled(self, elements: Array, springs: bool = False) -> csc_array:
        from scipy.sparse import (
            coo_array,
            csc_array,
        )  # a tenth of a second, which `import modal` should not cost

        size = 4 * self.model.nodes
        rows, columns = (
            np.repeat(self._unknown, 12, axis=1).ravel(),
            np.tile(self._unknown, 12).ravel(),
        )
        total = coo_array((elements.ravel(), (rows, columns)), shape=(size, size)).tocsc()
        if springs:
            at_ends = np.zeros((self.model.nodes, 4))
            at_ends[[0, -1], :3] = self._spring
            every = np.arange(size)
            total = total + coo_array((at_ends.ravel(), (every, every)), shape=(size, size)).tocsc()
        return csc_array(total)


def linearised(scene: Scene, wind: WindState) -> Linearised:
    """About the initial equilibrium in still air, or the static equilibrium in the scene's mean wind.

    Raises
    ------
    SceneError
        If `wind` is neither ``"still"`` nor ``"mean"``, or there is no equilibrium in the wind.
    """
    if wind not in ("still", "mean"):
        raise SceneError(f'wind = {wind!r}: must be "still" or "mean"')
    motion = SmallMotion(scene)
    return motion.in_still_air() if wind == "still" else motion.in_mean_wind()


def uniform(shape: tuple[int, ...], column: int) -> Array:
    """A unit displacement of every node in one of the four directions, flat."""
    moved = np.zeros(shape)
    moved[:, column] = 1.0
    return moved.ravel()
