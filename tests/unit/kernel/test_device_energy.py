"""Energy of short lines with devices.

The conductors are undamped and there is no wind, so that the energy changes by the work of the
forces on moving towers, and by the dissipation of dampers alone.
"""

import math

import numpy as np
import pytest
from scipy.integrate import simpson

from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import Object, probes_of
from support.sections import section

STEP, STEPS = 0.0025, 600
AMPLITUDE = 0.01
MOVES = {
    f"x{i}": {
        "kind": "harmonic",
        "mean": -AMPLITUDE * i,
        "amplitude": AMPLITUDE * i,
        "phase_deg": 90.0,
        "frequency_hz": 0.2 + 0.1 * i,
    }
    for i in (1, 2, 3)
}
"""A tower's point starts from rest and moves along all axes."""

STRING = {"kind": "string", "length": 1.5, "weight": 300.0, "stiffness": 1e5, "damping": 0.0}
V_STRING = {**STRING, "kind": "v_string", "half_spread": 0.8}
TWIN = {
    "subconductors": 2,
    "spacing": 0.4,
    "spacers": 1,
    "spacer_mass": 4.0,
    "yoke_mass": 10.0,
    "yoke_height": 0.3,
    "arm_stiffness": 1e5,
    "arm_damping": 0.0,
    "clamp_torsional_stiffness": 20.0,
}
TWO_PHASES = [{"name": "a"}, {"name": "b", "offset": [2.0, 1.0]}]


def line(suspension=None, **tables):
    """Two short spans, or one, that start displaced, or are moved by their tower."""
    spans = (60.0, 45.0) if suspension else (60.0,)
    moved = suspension is not None and "motion" in suspension
    seeds = {"seed_vertical": -0.03, "seed_horizontal": 0.15, "seed_twist": 0.3}
    return section(
        spans,
        suspension,
        8e3,
        initial={} if moved else seeds,
        conductor={"torsional_inertia": 0.01},
        numerics={
            "elements": 6,
            "time_step": STEP,
            "integrator": "gauss6",
            "newton_tolerance": 1e-10,
        },
        **tables,
    )


def with_devices(*devices, **tables):
    return line(devices=[{"span": 1, "station": 0.5, **device} for device in devices], **tables)


UNEVEN = {"kind": "mass", "mass": 3.0, "station": 0.3, "phase": 1}
SPACER = {"kind": "interphase_spacer", "phases": [1, 2], "stiffness": 1e5, "mass": 5.0}
HANGING = {"kind": "damper", "hanging_mass": 8.0, "hanging_stiffness": 900.0}
UNDAMPED = {
    "string": lambda: line(STRING),
    "string with a clamp that turns": lambda: line(STRING | {"clamp_torsional_stiffness": 80.0}),
    "moving tower": lambda: line(STRING | {"motion": MOVES}),
    "moving V-string": lambda: line(V_STRING | {"motion": MOVES}),
    "moving yoke": lambda: line(STRING | {"weight": 100.0, "motion": MOVES}, bundle=TWIN),
    "spacer": lambda: line(bundle=TWIN),
    "mass": lambda: with_devices({"kind": "mass", "mass": 10.0}),
    "pendulum": lambda: with_devices({"kind": "pendulum", "mass": 20.0, "arm": 0.5}),
    "hanging mass": lambda: with_devices(HANGING | {"damping": 0.0}),
    "interphase spacer": lambda: with_devices(UNEVEN, SPACER, phases=TWO_PHASES),
}

DAMPED = {
    "string": (lambda d: line(STRING | {"damping": d, "motion": MOVES}), 200.0),
    "V-string": (lambda d: line(V_STRING | {"damping": d}), 200.0),
    "clamps of spacers": (lambda d: line(bundle=TWIN | {"clamp_damping": d}), 5.0),
    "damper to the ground": (lambda d: with_devices({"kind": "damper", "damping": d}), 30.0),
    "damper of a mass": (lambda d: with_devices(HANGING | {"damping": d}), 30.0),
    "interphase spacer": (
        lambda d: with_devices(UNEVEN, SPACER | {"damping": d}, phases=TWO_PHASES),
        200.0,
    ),
}


class Motion:
    """A motion with its energy, the power that towers take, and the power of the dampers."""

    def __init__(self, scene, undamped=None):
        model = Model(scene)
        rigid = Model(undamped) if undamped else None
        self.node = model.junction_nodes()[0]
        self.moving = [
            device
            for tower in model.map.towers[1:-1]
            for device in tower.devices
            if scene.section.suspensions[0].motion
        ]
        energies = probes_of([(Object.SYSTEM, 0, 0), (Object.SYSTEM, 0, 1)])
        forces = probes_of([(Object.DEVICE, d, axis) for d in self.moving for axis in range(3)])
        self.energy, self.to_towers, self.dissipation = (np.zeros(STEPS + 1) for _ in range(3))
        state = model.start()
        for n in range(STEPS + 1):
            if n:
                state.advance(n * STEP)
            self.energy[n] = state.observe(energies).sum()
            force = state.observe(forces).reshape(-1, 3).sum(axis=0)
            self.to_towers[n] = force @ tower_velocity(state.time)
            if rigid:
                self.dissipation[n] = self._dissipation(model, rigid, state)

    def _dissipation(self, model, rigid, state):
        motion, total = state.motion(), 0.0
        for d, junctions in enumerate(model.devices):
            with_it, without = (
                m.device_force(d, *motion, time=state.time)[0] for m in (model, rigid)
            )
            velocity = motion[1][self.node[list(junctions)]]
            if d in self.moving:
                velocity[:, :3] -= tower_velocity(state.time)
            total += ((with_it - without) * velocity).sum()
        return total

    def balance(self):
        """Change of energy with the work on towers and dampers; the largest of these."""
        change = self.energy[-1] - self.energy[0]
        work, heat = (simpson(p, dx=STEP) for p in (self.to_towers, self.dissipation))
        return change + work + heat, max(np.ptp(self.energy), abs(work), self.energy.max())


def tower_velocity(t):
    """Rate of the motion of the towers that move [m/s]."""
    omega = [math.tau * MOVES[axis]["frequency_hz"] for axis in MOVES]
    return np.array([-AMPLITUDE * i * w * math.sin(w * t) for i, w in enumerate(omega, start=1)])


@pytest.mark.parametrize("name", UNDAMPED)
def test_energy_is_kept(name):
    """The change of energy is the work of moving towers.  Seen: 6e-7 of the energy."""
    missing, scale = Motion(UNDAMPED[name]()).balance()
    assert abs(missing) < 1e-6 * scale


@pytest.mark.parametrize("name", DAMPED)
def test_dampers_take_the_energy_that_is_missing(name):
    """Seen: to 8e-5 of the heat, by the quadrature."""
    make, damping = DAMPED[name]
    motion = Motion(make(damping), make(0.0))
    missing, scale = motion.balance()
    heat = simpson(motion.dissipation, dx=STEP)
    assert motion.dissipation.min() > -1e-12
    assert heat > 1e-7 * scale
    assert abs(missing) < 2e-4 * heat
