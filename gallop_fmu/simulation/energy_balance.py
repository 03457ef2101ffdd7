"""Energy balance of a span or line: work of wind, loads and towers, damping, and stored energy.

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
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import DOFS, Model
from gallop_fmu.engine.probes import junction_probes
from gallop_fmu.foundation.channels import NODE_CHANNELS, SPAN_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.result import Result

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MOTION_CHANNELS = tuple(channel.name for channel in NODE_CHANNELS[: 3 * DOFS])
"""Node channels required for an energy balance: displacements, velocities, accelerations."""

_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(16)
POINTS, WEIGHTS = 0.5 * (1.0 + _ABSCISSAE), 0.5 * _WEIGHTS
"""Quadrature from 0 to 1, the path to a motion; accurate for two rotations of the ice."""

HALF = 1e-4
"""Half the time [s] of the difference for the velocity of a tower."""

ENERGIES = ("kinetic_energy", "potential_energy")
FORCES = [SPAN_INDEX[f"{end}_f{axis}"] for end in ("left", "right") for axis in (1, 2, 3)]


@dataclass(frozen=True)
class EnergyBalance:
    """Energy of a span or line over time, each array of shape (time,).

    Attributes
    ----------
    time
        Times [s] of the records.
    kinetic, potential
        Stored energy [J], as the channels of the same names. With moving towers of one span, the
        work R0 . u of the static reactions R0 is excluded, here and in `supports`.
    wind, loads, supports
        Work [J] on the span since the first record of the wind, of the concentrated loads, and of
        moving towers, of one span without the static reactions. Support springs belong to the span;
        their static preload does no work.
    turning
        Work [J] of an attack angle changed by inputs, which rotates the weight and inertia of the
        ice.
    dissipated
        Energy [J] dissipated by structural damping and by devices since the first record.
    shed
        Energy [J] of the ice that fell since the first record, when it fell.
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
    shed: Array
    round_off: float

    @property
    def imbalance(self) -> Array:
        """Energy gain since the first record that is not the work of a force [J]."""
        stored = self.kinetic + self.potential
        return np.asarray(
            stored
            - stored[0]
            - (self.wind + self.loads + self.supports + self.turning - self.dissipated)
            + self.shed
        )

    @property
    def turnover(self) -> float:
        """Reference of the imbalance [J]: sum of the maxima of kinetic energy and of each work."""
        works = [self.kinetic, self.wind, self.loads, self.supports, self.turning, self.dissipated]
        works.append(self.shed)
        return float(sum(np.abs(work).max() for work in works))

    @property
    def worst(self) -> float:
        """Maximum imbalance over the `turnover`."""
        return float(np.abs(self.imbalance).max()) / (self.turnover + self.round_off)


def energy_balance(result: Result | LineResult) -> EnergyBalance:
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
    model = Model(result.scene, shedding_times=_times(data))
    missing = [name for name in MOTION_CHANNELS if name not in data]
    if missing or data.sizes["node"] != model.nodes:
        raise SceneError(
            f"the motion of all nodes was not recorded ({', '.join(missing) or 'nodes'} missing);"
            ' simulate with record_nodes="all" and channels='
            "gallop_fmu.simulation.energy_balance.MOTION_CHANNELS"
        )
    motion = np.stack([data[name].values for name in MOTION_CHANNELS], axis=-1)
    time = data.time.values
    if isinstance(result, LineResult):
        energies = np.stack([data[name].values for name in ENERGIES], axis=-1)
        force = [data[f"tower_force_x{axis}"].sum("line_phase").values for axis in (1, 2, 3)]
        balance = _account(model, time, motion, energies, np.stack(force, axis=-1), None)
    else:
        span = np.stack([data[name].values for name in SPAN_INDEX], axis=-1)
        balance = account(model, time, motion, span)
    return replace(balance, shed=_shed(data))


def _times(data: xr.Dataset) -> Array | None:
    """Return the times at which ice fell in a run; infinite: it has not."""
    if "shed_time" not in data:
        return None
    times = data["shed_time"].values
    return np.where(np.isnan(times), np.inf, times)


def _shed(data: xr.Dataset) -> Array:
    """Return the energy of the ice that fell since the first record."""
    time = data.time.values
    times = _times(data)
    if times is None:
        return np.zeros(len(time))
    energies = data["shed_kinetic_energy"].values + data["shed_potential_energy"].values
    later = (times > time[0]) & np.isfinite(times)
    return np.asarray((time[:, None] >= times[later] - 1e-9) @ energies[later])


def account(
    model: Model,
    time: Array,
    motion: Array,
    span: Array,
    inputs: Callable[[float], Inputs] | None = None,
) -> EnergyBalance:
    """Return the energy balance of a recorded motion of one span.

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
    energies = span[:, [SPAN_INDEX[name] for name in ENERGIES]]
    return _account(model, time, motion, energies, span[:, FORCES].reshape(-1, 2, 3), inputs)


def _account(
    model: Model,
    time: Array,
    motion: Array,
    energies: Array,
    force: Array,
    inputs: Callable[[float], Inputs] | None,
) -> EnergyBalance:
    """Return the balance from `energies` (time, 2) and forces on towers (time, tower, 3)."""
    u, v, a = (motion[..., DOFS * i : DOFS * (i + 1)] for i in range(3))
    still = np.zeros_like(u[0])
    damped = model.scene.damping.translation is not None or model.scene.damping.twist is not None
    wind, loads, damping = np.zeros_like(u), np.zeros_like(u), np.zeros_like(u)
    bare = _without_loads(model)
    for i, t in enumerate(time):
        at = inputs(float(t)) if inputs else None
        calm = Inputs.still(model.scene, at.attack_angle if at else None)
        if damped or model.scene.wind.can_blow or inputs:
            without = model.residual(u[i], v[i], a[i], time=t, inputs=calm)
            wind[i] = without - model.residual(u[i], v[i], a[i], time=t, inputs=at)
        if damped:  # damping forces are odd in the velocities, those of the rotating ice even
            damping[i] = 0.5 * (without - model.residual(u[i], -v[i], a[i], time=t, inputs=calm))
        if bare is not None:
            held = bare.residual(time=t, inputs=Inputs.still(model.scene))
            loads[i] = held - model.residual(still, still, still, time=t, inputs=calm)
    place = np.array([_tower_points(model.scene, float(t), inputs) for t in time])
    return EnergyBalance(
        time=np.asarray(time),
        kinetic=energies[:, 0],
        potential=energies[:, 1],
        wind=_work(wind, u),
        loads=_work(loads, u),
        supports=_work(_static_force(model) - force, place),
        turning=_turning(model, time, u, v, inputs),
        shed=np.zeros(len(time)),
        dissipated=_work(damping, u) + _of_devices(model, time, (u, v, a), place),
        round_off=float(np.finfo(np.float64).eps) * _stretch_energy(model),
    )


def _without_loads(model: Model) -> Model | None:
    """Return the model without loads, whose residual devices balance; None: it has none."""
    if not model.scene.loads:
        return None
    return Model(model.scene.with_values({"loads": []}), shedding_times=model.shedding_times)


def _static_force(model: Model) -> Array:
    """Forces [N] on the towers (tower, 3) that the energies do not include.

    Of one span these are all static forces, of a line those that springs hold.
    """
    if not isinstance(model.scene, LineScene):
        return model.equilibrium().support_force
    static = np.zeros((model.map.spans + 1, 3))
    for tower in model.map.towers:
        if tower.kind == "springs":
            probes = np.concatenate([junction_probes(junction) for junction in tower.junctions])
            static[tower.tower] += model.observe_equilibrium(probes).reshape(-1, 3).sum(axis=0)
    return static


def _stretch_energy(model: Model) -> float:
    """Tension times length of all conductors [J], the scale of the round-off of the energies."""
    chains = [model.chain_equilibrium(index) for index in range(len(model.map.chains))]
    return sum(chain.horizontal_tension * chain.length for chain in chains)


def _of_devices(
    model: Model, time: Array, motion: tuple[Array, Array, Array], place: Array
) -> Array:
    """Return the energy that dampers, strings and clamps dissipate.

    Their damping forces are odd in the velocities of nodes and towers.
    """
    node, work = model.junction_nodes()[0], np.zeros(len(time))
    for device, junctions in enumerate(model.devices):
        if not np.any(model.device_tangent(device, damping=1.0)):
            continue
        own = node[list(junctions)]
        force = np.array(
            [
                0.5
                * (
                    model.device_force(device, u, v, a, time=t, inputs=_moving(model, t, 1.0))[0]
                    - model.device_force(device, u, -v, a, time=t, inputs=_moving(model, t, -1.0))[
                        0
                    ]
                )
                for t, u, v, a in zip(time, *motion, strict=True)
            ]
        )
        work += _work(force, motion[0][:, own])
        for tower in model.map.towers:
            if device in tower.devices:
                work -= _work(force[..., :3].sum(axis=1), place[:, tower.tower])
    return work


def _moving(model: Model, time: float, sense: float) -> Inputs:
    """Towers where the laws take them at a time, with their velocities times `sense`."""
    scene = model.scene
    inputs = Inputs.still(scene)
    ahead, behind = (_tower_points(scene, time + step, None) for step in (HALF, -HALF))
    inputs.time, inputs.support = time, _tower_points(scene, time, None)
    inputs.support_rate = sense * (ahead - behind) / (2.0 * HALF)
    return inputs


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


def _tower_points(
    scene: Scene | LineScene, time: float, inputs: Callable[[float], Inputs] | None
) -> Array:
    """Return the displacement of the tower points [m], shape (tower, 3)."""
    if inputs:
        return np.asarray(inputs(time).support, dtype=np.float64)
    if not isinstance(scene, LineScene):
        return scene.supports.displacement_at(time)
    section = scene.section
    towers = (section.left_end, *section.suspensions, section.right_end)
    place = np.zeros((len(towers), 3))
    for row, tower in zip(place, towers, strict=True):
        for axis, name in enumerate(("x1", "x2", "x3")):
            law = getattr(tower.motion, name, None)
            row[axis] = 0.0 if law is None else float(law.at(time))
    return place


def _work(force: Array, place: Array) -> Array:
    """Return the work since the first record, summed over all axes but the first."""
    increments = 0.5 * (force[1:] + force[:-1]) * np.diff(place, axis=0)
    each = increments.sum(axis=tuple(range(1, increments.ndim)))
    return np.concatenate([[0.0], np.cumsum(each)])
