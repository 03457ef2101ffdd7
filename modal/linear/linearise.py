"""Small motion about an equilibrium: M q'' + C q' + K q = forces, from the kernel's own tangents.

The unknowns are the displacements of all nodes about the equilibrium, four a node. Most are "free";
the others are prescribed: the ends follow the tower points and cannot twist. The aerodynamic load
depends on the wind and on the attack angle only through w3 = U - v3 and alpha = alpha0 + theta +
... (Liu et al. 2009, eq. 20-21). Hence, with e3 a uniform unit velocity v3 and et a uniform unit
twist, the force F on the unknowns has the exact slopes

    dF/dU      = -dF/dv3 = (C - C_still) e3,
    dF/dalpha0 = -(K - K_untwisted) et.

In oblique wind or a profile, e3 is replaced by the wind at each node per m/s of its speed.

C_still is the damping matrix without wind; K_untwisted is the stiffness matrix without wind and at
zero twist. It is in the second slope because the torque of the weight of the ice is g (c3 - m3),
where both first moments rotate with alpha0: c3 by theta + alpha0, m3 by alpha0.

Every matrix is taken at the equilibrium itself: eccentric ice that is rotated there changes the
mass matrix, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, LineScene, Model, Scene, SceneError, SimulationError
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.engine.model import DOFS
from gallop_fmu.scene.wind_consistency import towers_of

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
        The unknowns that are not prescribed.
    spring : ndarray, shape (2, 3)
        Stiffness [N/m] of the support springs, left and right, along x1, x2, x3; 0 where the end is
        prescribed.
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
        free = self.free.ravel()
        return tuple(restricted(one, free) for one in (self.mass, self.damping, self.stiffness))


def restricted(matrix: csc_array, kept: NDArray[np.bool_]) -> csc_array:
    """Rows and columns of a square matrix that are kept; faster than its selection by indices."""
    from scipy.sparse import csc_array  # slow to import

    number = np.cumsum(kept) - 1
    columns = np.repeat(np.arange(len(kept)), np.diff(matrix.indptr))
    stored = kept[matrix.indices] & kept[columns]
    counts = np.bincount(number[columns[stored]], minlength=int(kept.sum()))
    first = np.concatenate([[0], np.cumsum(counts)]).astype(matrix.indptr.dtype)
    rows = number[matrix.indices[stored]].astype(matrix.indices.dtype)
    return csc_array((matrix.data[stored], rows, first), shape=(len(counts),) * 2)


class SmallMotion:
    """Linearises a span or line about its equilibrium at any wind speed; the model is made once.

    Parameters
    ----------
    scene
        The span or line.

    Raises
    ------
    SimulationError
        If no initial equilibrium exists.
    """

    def __init__(self, scene: Scene | LineScene) -> None:
        scene = scene.model_copy(update={"wind": scene.wind.without_gusts()})
        self.scene = scene
        self.model = Model(scene)
        self.mesh = Mesh(self.model)

    def about(self, wind: WindState) -> Linearised:
        """About the initial equilibrium in still air, or the static one in the mean wind.

        Raises
        ------
        SceneError
            If `wind` is neither ``"still"`` nor ``"mean"``, or there is no equilibrium in the wind.
        """
        if wind not in ("still", "mean"):
            raise SceneError(f'wind = {wind!r}: must be "still" or "mean"')
        return self.in_still_air() if wind == "still" else self.in_mean_wind()

    def in_still_air(self) -> Linearised:
        """About the initial equilibrium, without wind."""
        return self._about(np.zeros((self.model.nodes, DOFS)), 0.0)

    def in_mean_wind(self) -> Linearised:
        """About the static equilibrium under the scene's mean wind."""
        return self.in_wind(self.scene.wind.mean_speed)

    def inputs(self, speed: float) -> Inputs:
        """Inputs of the kernel: wind of a speed [m/s], towers at rest."""
        return Inputs.still(self.scene, wind_speed=speed)

    def wind_of_nodes(self) -> Array:
        """Wind at the nodes per m/s of its speed, as velocities of the unknowns, flat."""
        wind = self.scene.wind
        yaw = np.radians(wind.mean_direction)
        moved = np.zeros((self.model.nodes, DOFS))
        moved[:, [0, 2]] = np.sin(yaw), np.cos(yaw)
        if wind.profile is not None:
            x = self.model.equilibrium().x
            towers = [x1 for x1, _ in towers_of(self.scene)]
            height = x[:, 1] - np.interp(x[:, 0], *wind.profile.ground(towers))
            moved *= wind.profile.factor(height)[:, None]
        return moved.ravel()

    def in_wind(self, speed: float) -> Linearised:
        """About the static equilibrium in wind of any speed [m/s], negative from the other side.

        Loads and support displacements are those at t = 0.

        Raises
        ------
        SceneError
            If the scene has no coefficient curve, the attack angle leaves it, or there is no
            equilibrium.
        """
        if not np.isfinite(speed):
            raise SceneError(f"wind speed = {speed} m/s: must be a finite number")
        if speed != 0.0 and self.scene.aerodynamics is None:
            raise SceneError(
                "the scene has no aerodynamics: wind needs a coefficient curve to become a force"
            )
        inputs = self.inputs(speed)
        scene = self.scene
        towers = scene.supports if isinstance(scene, Scene) else scene.section
        inputs.support = towers.displacement_at(0.0)
        try:
            displacement, _, _ = self.model.rest(0.0, inputs).motion()
        except SimulationError as problem:
            raise SceneError(f"no equilibrium in wind of {speed:g} m/s: {problem}") from problem
        return self._about(displacement, speed)

    def _about(self, u: Array, speed: float) -> Linearised:
        """Equations of small motion about the displacement u in a wind [m/s].

        With R(u, u', u'') the out-of-balance forces, M, C, K are dR/du'', dR/du', dR/du. The load
        enters R with a minus sign; the still-air parts cancel in the differences.
        """
        mesh = self.mesh
        windy = self.inputs(speed)
        stiffness = mesh.tangent(u, stiffness=1.0, inputs=mesh.still)
        damping = mesh.tangent(u, damping=1.0, inputs=mesh.still)
        still = Linearised(
            mass=mesh.tangent(u, mass=1.0, inputs=mesh.still),
            damping=damping,
            stiffness=stiffness,
            free=mesh.free,
            spring=mesh.spring,
            displacement=u,
            wind_speed=speed,
            by_wind=np.zeros(u.size),
            by_attack_angle=np.zeros(u.size),
            middle=self.model.middle,
        )
        if speed == 0.0:
            return still
        stiffness_in_wind = mesh.tangent(u, stiffness=1.0, inputs=windy)
        damping_in_wind = mesh.tangent(u, damping=1.0, inputs=windy)
        untwisted = u * [1.0, 1.0, 1.0, 0.0]
        # Of the elements alone: the attack angle does not turn pendulums and other devices.
        by_angle = self.model.tangent(u, stiffness=1.0, inputs=windy) - self.model.tangent(
            untwisted, stiffness=1.0, inputs=mesh.still
        )
        return replace(
            still,
            damping=damping_in_wind,
            stiffness=stiffness_in_wind,
            by_wind=(damping_in_wind - damping) @ self.wind_of_nodes(),
            by_attack_angle=-(mesh.gather(mesh.assemble(by_angle)) @ uniform(u.shape, 3)),
        )


def linearised(scene: Scene | LineScene, wind: WindState) -> Linearised:
    """Linearise about the initial equilibrium in still air, or the static one in the mean wind.

    Raises
    ------
    SceneError
        If `wind` is neither ``"still"`` nor ``"mean"``, or there is no equilibrium in the wind.
    """
    return SmallMotion(scene).about(wind)


def uniform(shape: tuple[int, ...], column: int) -> Array:
    """A unit displacement of every node in one of the four directions, flat."""
    moved = np.zeros(shape)
    moved[:, column] = 1.0
    return moved.ravel()
