"""Where the energy of a span comes from and where it goes: work of wind, loads and towers, damping, what is stored.

An average-acceleration step (Newmark, beta 1/4, gamma 1/2) moves each unknown by the mean of its
velocities. So the mean of two inertia forces times the displacement between them is exactly the
change of kinetic energy, and work is summed as ``(F_n + F_n+1) / 2 . (u_n+1 - u_n)``. What the
balance then leaves is the error of the step in the elastic forces and in the rotation of the
eccentric ice, and whatever lies between records.

That error is of second order in the step only for motion that the steps resolve. A start out of
equilibrium, such as a seed of 0.1 m with the wind on the span at once, releases axial waves with
periods of a few hundredths of a second. With steps of 0.01 s they leave an imbalance of some per
cent of the turnover, which shorter steps may first increase. Start in equilibrium, or damp the
waves, where the balance is to be small.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.model import DOFS, Inputs, Model
from gallop_fmu.foundation.channels import NODE_CHANNELS, SPAN_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.simulation.result import Result

Array = NDArray[np.float64]

MOTION_CHANNELS = tuple(channel.name for channel in NODE_CHANNELS[: 3 * DOFS])
"""Node channels that an energy balance needs: displacements, velocities, accelerations."""

_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(16)
PLACES, WEIGHTS = 0.5 * (1.0 + _ABSCISSAE), 0.5 * _WEIGHTS
"""Of an integral from 0 to 1, the way to a motion: exact enough for ice that turns twice."""

FORCES = [SPAN_INDEX[f"{end}_f{axis}"] for end in ("left", "right") for axis in (1, 2, 3)]


@dataclass(frozen=True)
class EnergyBalance:
    """Energy of a span over time, each array of shape (time,).

    Attributes
    ----------
    time
        Times [s] of the records.
    kinetic, potential
        Stored energy [J], as the channels of the same names. Where towers move, the energy of
        position of the span as a whole also contains the work of the static reactions R0 on them,
        R0 . u, which is left out here and in `supports` alike.
    wind, loads, supports
        Work [J] done on the span since the first record by the wind, by the concentrated loads, and
        by moving towers, of the latter without the work of the static reactions. Support springs
        belong to the span; their static preload does no work.
    turning
        Work [J] of an attack angle that inputs change: it turns the ice, whose weight and inertia
        then differ.
    dissipated
        Energy [J] lost to structural damping since the first record.
    round_off
        Energy [J] that says nothing: rounding of tension times length.
    """

    time: Array
    kinetic: Array
    potential: Array
    wind: Array
    loads: Array
    supports: Array
    turning: Array
    dissipated: Array
    round_off: float

    @property
    def imbalance(self) -> Array:
        """Energy gained since the first record that no work accounts for [J]."""
        stored = self.kinetic + self.potential
        return np.asarray(
            stored
            - stored[0]
            - (self.wind + self.loads + self.supports + self.turning - self.dissipated)
        )

    @property
    def turnover(self) -> float:
        """Energy that an imbalance is measured by [J]: the largest kinetic energy and the largest of each work."""
        works = (self.kinetic, self.wind, self.loads, self.supports, self.turning, self.dissipated)
        return float(sum(np.abs(work).max() for work in works))

    @property
    def worst(self) -> float:
        """Largest imbalance over the `turnover`."""
        return float(np.abs(self.imbalance).max()) / (self.turnover + self.round_off)


def energy_balance(result: Result) -> EnergyBalance:
    """Energy balance of a simulation that has recorded the motion of all nodes.

    Parameters
    ----------
    result
        From ``simulate(scene, record_nodes="all", record_every=1, channels=MOTION_CHANNELS)``; with
        longer intervals between the records the sums of work are coarser.  A step that was halved
        hides the work within it: what is damped there is missing.

    Raises
    ------
    SceneError
        If the motion of all nodes was not recorded.
    """
    data = result.dataset
    missing = [name for name in MOTION_CHANNELS if name not in data]
    if missing or data.sizes["node"] != 2 * result.scene.numerics.elements + 1:
        raise SceneError(
            'an energy balance needs the motion of all nodes: simulate with record_nodes="all" and'
            " channels="
            f"gallop_fmu.simulation.energy_balance.MOTION_CHANNELS ({', '.join(missing) or 'nodes'}"
            " not recorded)"
        )
    motion = np.stack([data[name].values for name in MOTION_CHANNELS], axis=-1)
    span = np.stack([data[name].values for name in SPAN_INDEX], axis=-1)
    return account(Model(result.scene), data.time.values, motion, span)


def account(
    model: Model,
    time: Array,
    motion: Array,
    span: Array,
    inputs: Callable[[float], Inputs] | None = None,
) -> EnergyBalance:
    """Energy balance of recorded motion.

    Parameters
    ----------
    model
        The span that moved.
    time : ndarray, shape (time,)
        Times [s] of the records, every step for the sharpest balance.
    motion : ndarray, shape (time, node, 12)
        The channels `MOTION_CHANNELS` at all nodes.
    span : ndarray, shape (time, channel)
        All span channels.
    inputs
        Inputs at a time [s], if the motion was driven by inputs in place of the scene's laws.
    """
    u, v, a = (motion[..., DOFS * i : DOFS * (i + 1)] for i in range(3))
    still, attack = np.zeros_like(u[0]), float(np.radians(model.scene.ice.attack_angle_deg))
    damped = model.scene.damping.translation is not None or model.scene.damping.twist is not None
    wind, loads, damping = np.zeros_like(u), np.zeros_like(u), np.zeros_like(u)
    for i, t in enumerate(time):
        at = inputs(float(t)) if inputs else None
        calm = Inputs(float(t), 0.0, at.attack_angle if at else attack, np.zeros((2, 3)))
        if damped or model.scene.wind.can_blow or inputs:
            without = model.residual(u[i], v[i], a[i], time=t, inputs=calm)
            wind[i] = without - model.residual(u[i], v[i], a[i], time=t, inputs=at)
        if damped:  # damping is odd in the velocities, the rotation of the ice even
            damping[i] = 0.5 * (without - model.residual(u[i], -v[i], a[i], time=t, inputs=calm))
        if model.scene.loads:
            loads[i] = -model.residual(still, still, still, time=t, inputs=calm)
    place = np.array([_tower_points(model, float(t), inputs) for t in time])
    rest = model.equilibrium()
    pull = rest.support_force.ravel() - span[:, FORCES]  # on the cable, without the static force
    return EnergyBalance(
        time=np.asarray(time),
        kinetic=span[:, SPAN_INDEX["kinetic_energy"]],
        potential=span[:, SPAN_INDEX["potential_energy"]],
        wind=_work(wind, u),
        loads=_work(loads, u),
        supports=_work(pull, place),
        turning=_turning(model, time, u, v, inputs),
        dissipated=_work(damping, u),
        round_off=float(np.finfo(np.float64).eps) * rest.horizontal_tension * rest.length,
    )


def _turning(
    model: Model, time: Array, u: Array, v: Array, inputs: Callable[[float], Inputs] | None
) -> Array:
    """Work since the first record: what the stored energy gains as the ice turns and the motion stays."""
    work = np.zeros(len(time))
    attack = [inputs(float(t)).attack_angle for t in time] if inputs else []
    for i in range(1, len(attack)):
        if attack[i] != attack[i - 1]:
            work[i] = sum(
                0.5 * side * _stored(model, u[k], v[k], angle)
                for k in (i - 1, i)
                for side, angle in ((1.0, attack[i]), (-1.0, attack[i - 1]))
            )
    return np.cumsum(work)


def _stored(model: Model, u: Array, v: Array, attack: float) -> float:
    """Energy [J] of a motion, by the forces that hold it and its inertia; loads of the scene count as potential."""
    still, at = np.zeros_like(u), Inputs(0.0, 0.0, attack, np.zeros((2, 3)))
    held = model.residual(u, still, still, inputs=at)
    kinetic = 0.5 * np.vdot(v, model.residual(u, still, v, inputs=at) - held)
    path = sum(
        w * model.residual(x * u, still, still, inputs=at)
        for x, w in zip(PLACES, WEIGHTS, strict=True)
    )
    return float(kinetic + np.vdot(u, path))


def _tower_points(model: Model, time: float, inputs: Callable[[float], Inputs] | None) -> Array:
    """Displacement of the tower points [m]: left x1 x2 x3, right x1 x2 x3."""
    if inputs:
        at = inputs(time)
        return np.asarray(at.support, dtype=np.float64).ravel()
    return model.scene.supports.displacement_at(time).ravel()


def _work(force: Array, place: Array) -> Array:
    """Work since the first record: mean force times displacement, summed over all but the first axis."""
    increments = 0.5 * (force[1:] + force[:-1]) * np.diff(place, axis=0)
    each = increments.sum(axis=tuple(range(1, increments.ndim)))
    return np.concatenate([[0.0], np.cumsum(each)])
