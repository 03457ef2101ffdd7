"""Energy balance of a span: work of wind, loads and towers, damping, and stored energy.

In an average-acceleration step (Newmark, beta 1/4, gamma 1/2) each displacement increment is the
mean velocity times the step. So the mean of two inertia forces times the increment is exactly the
change of kinetic energy, and work is summed as ``(F_n + F_n+1) / 2 . (u_n+1 - u_n)``. The imbalance
is then the error of the step in the elastic forces and in the rotation of the eccentric ice, and
the motion between records.

That error is of second order in the step only for motion that the steps resolve. A start out of
equilibrium, such as a perturbation of 0.1 m with sudden wind, excites axial waves with periods of a
few hundredths of a second. With steps of 0.01 s the imbalance is then a few per cent of the
turnover, and may first increase for shorter steps. For a small imbalance, start in equilibrium or
damp the waves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import DOFS, Model
from gallop_fmu.foundation.channels import NODE_CHANNELS, SPAN_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.simulation.result import Result

Array = NDArray[np.float64]

MOTION_CHANNELS = tuple(channel.name for channel in NODE_CHANNELS[: 3 * DOFS])
"""Node channels required for an energy balance: displacements, velocities, accelerations."""

_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(16)
POINTS, WEIGHTS = 0.5 * (1.0 + _ABSCISSAE), 0.5 * _WEIGHTS
"""Quadrature from 0 to 1, the path to a motion; accurate for two rotations of the ice."""

FORCES = [SPAN_INDEX[f"{end}_f{axis}"] for end in ("left", "right") for axis in (1, 2, 3)]


@dataclass(frozen=True)
class EnergyBalance:
    """Energy of a span over time, each array of shape (time,).

    Attributes
    ----------
    time
        Times [s] of the records.
    kinetic, potential
        Stored energy [J], as the channels of the same names. With moving towers, the work R0 . u of
        the static reactions R0 is excluded, here and in `supports`.
    wind, loads, supports
        Work [J] on the span since the first record of the wind, of the concentrated loads, and of
        moving towers, the latter without the static reactions. Support springs belong to the span;
        their static preload does no work.
    turning
        Work [J] of an attack angle changed by inputs, which rotates the weight and inertia of the
        ice.
    dissipated
        Energy [J] dissipated by structural damping since the first record.
    round_off
        Energy [J] of round-off: machine precision times tension times length.
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
        """Energy gain since the first record that is not the work of a force [J]."""
        stored = self.kinetic + self.potential
        return np.asarray(
            stored
            - stored[0]
            - (self.wind + self.loads + self.supports + self.turning - self.dissipated)
        )

    @property
    def turnover(self) -> float:
        """Reference of the imbalance [J]: sum of the maxima of kinetic energy and of each work."""
        works = (self.kinetic, self.wind, self.loads, self.supports, self.turning, self.dissipated)
        return float(sum(np.abs(work).max() for work in works))

    @property
    def worst(self) -> float:
        """Maximum imbalance over the `turnover`."""
        return float(np.abs(self.imbalance).max()) / (self.turnover + self.round_off)


def energy_balance(result: Result) -> EnergyBalance:
    """Return the energy balance of a simulation with the recorded motion of all nodes.

    Parameters
    ----------
    result
        From ``simulate(scene, record_nodes="all", record_every=1, channels=MOTION_CHANNELS)``; with
        longer intervals between records the work is less accurate. Damping within a halved step is
        not included.

    Raises
    ------
    SceneError
        The motion of all nodes was not recorded.
    """
    data = result.dataset
    missing = [name for name in MOTION_CHANNELS if name not in data]
    if missing or data.sizes["node"] != 2 * result.scene.numerics.elements + 1:
        raise SceneError(
            f"the motion of all nodes was not recorded ({', '.join(missing) or 'nodes'} missing);"
            ' simulate with record_nodes="all" and channels='
            "gallop_fmu.simulation.energy_balance.MOTION_CHANNELS"
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
    """Return the energy balance of a recorded motion.

    Parameters
    ----------
    model
        The span.
    time : ndarray, shape (time,)
        Times [s] of the records; every step for the best accuracy.
    motion : ndarray, shape (time, node, 12)
        The channels `MOTION_CHANNELS` at all nodes.
    span : ndarray, shape (time, channel)
        All span channels.
    inputs
        Function from time [s] to inputs, if they took the place of the scene's laws.
    """
    u, v, a = (motion[..., DOFS * i : DOFS * (i + 1)] for i in range(3))
    still = np.zeros_like(u[0])
    damped = model.scene.damping.translation is not None or model.scene.damping.twist is not None
    wind, loads, damping = np.zeros_like(u), np.zeros_like(u), np.zeros_like(u)
    for i, t in enumerate(time):
        at = inputs(float(t)) if inputs else None
        calm = Inputs.still(model.scene, at.attack_angle if at else None)
        if damped or model.scene.wind.can_blow or inputs:
            without = model.residual(u[i], v[i], a[i], time=t, inputs=calm)
            wind[i] = without - model.residual(u[i], v[i], a[i], time=t, inputs=at)
        if damped:  # damping forces are odd in the velocities, those of the rotating ice even
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
    """Return the work of the rotation of the ice by inputs at constant motion."""
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
    """Return the energy [J] of a motion by its static and inertia forces; loads are potential."""
    still, at = np.zeros_like(u), Inputs.still(model.scene, attack)
    static = model.residual(u, still, still, inputs=at)
    kinetic = 0.5 * np.vdot(v, model.residual(u, still, v, inputs=at) - static)
    path = sum(
        w * model.residual(x * u, still, still, inputs=at)
        for x, w in zip(POINTS, WEIGHTS, strict=True)
    )
    return float(kinetic + np.vdot(u, path))


def _tower_points(model: Model, time: float, inputs: Callable[[float], Inputs] | None) -> Array:
    """Return the displacement of the tower points [m]: left x1 x2 x3, right x1 x2 x3."""
    if inputs:
        at = inputs(time)
        return np.asarray(at.support, dtype=np.float64).ravel()
    return one_span(model.scene, "energy_balance").supports.displacement_at(time).ravel()


def _work(force: Array, place: Array) -> Array:
    """Return the work since the first record, summed over all axes but the first."""
    increments = 0.5 * (force[1:] + force[:-1]) * np.diff(place, axis=0)
    each = increments.sum(axis=tuple(range(1, increments.ndim)))
    return np.concatenate([[0.0], np.cumsum(each)])
