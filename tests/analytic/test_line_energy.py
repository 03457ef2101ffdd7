"""Energy of lines: work of wind, loads, towers and devices adds up to what is stored."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.simulation.energy_balance import MOTION_CHANNELS
from support.sections import STRING, section

SWAY = {"kind": "harmonic", "mean": 0.0, "amplitude": 0.05, "frequency_hz": 0.2}
PUSH = {"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 1.0, "fall_start": 1.0, "fall": 1.0}
MOVE = {**PUSH, "peak": 0.05}
LOADS = [{"span": 2, "position": 0.4, "force": [0.0, 200.0, 300.0], "torque": 5.0, "law": PUSH}]
BLOWING = {
    "wind": {"speed": 8.0},
    "ice": {"mass_per_length": 0.3, "torsional_inertia": 5e-5, "first_moment_x3": 2e-4},
    "aerodynamics": {
        "kind": "polynomial",
        **{"lift": [0.0, -1.2, 0.0, 0.8], "drag": [1.0, 0.0, 0.0, 0.0]},
        **{"moment": [0.0, -0.3, 0.0, 0.0], "valid_from_deg": -80.0, "valid_to_deg": 80.0},
    },
    "damping": {
        name: {"low_ratio": 0.01, "low_frequency": 0.2, "high_ratio": 0.01, "high_frequency": 5.0}
        for name in ("translation", "twist")
    },
}
DEVICES = [
    {"kind": "pendulum", "span": 1, "station": 0.4, "mass": 8.0, "arm": 0.4, "angle_deg": 30.0},
    {"kind": "mass", "span": 2, "station": 0.25, "mass": 10.0},
    {"kind": "damper", "span": 2, "station": 0.7, "damping": 40.0, "axis": "x2"},
    {
        **{"kind": "damper", "span": 3, "station": 0.3, "damping": 15.0, "axis": "x2"},
        **{"hanging_mass": 6.0, "hanging_stiffness": 300.0},
    },
]
SPACERS = [
    {
        **{"kind": "interphase_spacer", "span": 2, "station": 0.5, "phases": [1, 2]},
        **{"mass": 20.0, "stiffness": 1e5, "damping": 50.0},
    }
]
PHASES = [{"name": "a"}, {"name": "b", "offset": [4.0, 0.0]}]
SWAYING = {**STRING, "motion": {"x1": SWAY, "x3": SWAY}}

CASES = {
    "strings": {},
    "posts that move": {"suspension": {"kind": "post", "motion": {"x2": SWAY, "x3": SWAY}}},
    "towers that move": {"suspension": {**SWAYING, "damping": 2e4}},
    "end string": {"section": {"left_end": {**STRING, "motion": {"x1": MOVE}}}},
    "springs": {
        "section": {
            "left_end": {
                **{"kind": "springs", "stiffness_x1": 2e5, "stiffness_x3": 1e4},
                "motion": {"x1": SWAY},
            }
        }
    },
    "V-strings": {
        "suspension": {"kind": "v_string", "length": 3.0, "weight": 300.0, "half_spread": 1.5}
    },
    "turning clamps": {"suspension": {**SWAYING, "clamp_torsional_stiffness": 80.0}},
    "devices": {"devices": DEVICES},
    "wind": BLOWING,
    "quad": {
        **BLOWING,
        "suspension": SWAYING,
        "bundle": {
            **{"subconductors": 4, "spacing": 0.45, "spacers": 2, "spacer_mass": 5.0},
            **{"clamp_damping": 20.0, "yoke_mass": 8.0, "yoke_height": 0.2},
        },
    },
    "phases": {"phases": PHASES, "devices": SPACERS},
    "interphase spacers between bundles": {
        "phases": PHASES,
        "bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 1},
        "devices": [{**SPACERS[0], "subconductor": 2}],
    },
    "pendulums on damped arms": {
        "bundle": {
            **{"subconductors": 2, "spacing": 0.4, "spacers": 2, "spacer_mass": 5.0},
            **{"arm_stiffness": 2e4, "arm_damping": 2000.0, "clamp_damping": 5.0},
        },
        "devices": [
            {
                **{"kind": "pendulum", "span": 2, "station": 1.0 / 3.0, "subconductor": 1},
                **{"mass": 10.0, "arm": 0.4, "angle_deg": 20.0},
            }
        ],
    },
}

BOUND = 2e-5
"""Imbalance over turnover in steps of 0.01 s; 8.7e-6 seen, of springs."""


def balance(case, step):
    numerics = {"elements": 8, "time_step": step, "newton_tolerance": 1e-11}
    suspension = case.get("suspension", STRING)
    tables = {name: value for name, value in case.items() if name != "suspension"}
    scene = section((120.0, 150.0, 130.0), suspension, 20e3, loads=LOADS, **tables)
    scene = scene.with_values({f"numerics.{name}": value for name, value in numerics.items()})
    result = gf.simulate(scene, 3.0, record_nodes="all", channels=MOTION_CHANNELS)
    return gf.energy_balance(result)


@pytest.mark.parametrize("name", CASES)
def test_works_and_stored_energy_balance(name):
    found = balance(CASES[name], 0.01)
    assert found.turnover > 10.0
    assert found.worst < BOUND


def test_damping_of_devices_is_part_of_the_balance():
    found = balance(CASES["devices"], 0.01)
    assert found.dissipated[-1] > 0.02 * found.turnover
    assert np.all(np.diff(found.dissipated) > -1e-9)


def test_damping_of_spacer_arms_is_part_of_the_balance():
    """A pendulum at a spacer shakes its arms; without their damping much less is dissipated."""
    case = CASES["pendulums on damped arms"]
    found = balance(case, 0.01)
    without = balance({**case, "bundle": {**case["bundle"], "arm_damping": 0.0}}, 0.01)
    assert found.dissipated[-1] > 1.2 * without.dissipated[-1]
    assert np.all(np.diff(found.dissipated) > -1e-9)
