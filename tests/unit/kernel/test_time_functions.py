"""The kernel's laws, seen through wind speed and support motion, against `Law.at`."""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.time_functions import Harmonic, Pulse, Ramp

LAWS = {
    "constant": {"kind": "constant", "value": 3.7},
    "ramp": {"kind": "ramp", "initial": 2.0, "final": 7.0, "start": 0.11, "duration": 0.5},
    "falling ramp": {"kind": "ramp", "initial": 7.0, "final": 2.0, "start": 0.2, "duration": 0.3},
    "jump": {"kind": "ramp", "initial": 1.0, "final": 2.0, "start": 0.35, "duration": 0.0},
    "pulse": {"kind": "pulse", "initial": 1.0, "peak": 4.0, "start": 0.1, "rise": 0.2,
    "fall_start": 0.4, "fall": 0.3},
    "harmonic": {
        "kind": "harmonic", "mean": 5.0, "amplitude": 2.0, "frequency_hz": 1.7, "phase_deg": 40.0,
        "start": 0.23,
    },
    "table": {"kind": "table", "time": [0.1, 0.3, 0.45, 0.7], "value": [2.0, 5.0, 1.0, 4.0]},
}  # fmt: skip
NO_CHANNELS = np.zeros(0, np.int32)
STEP = 0.01


@pytest.fixture
def drag_only(minimal):
    """A span with wind."""
    flat = {
        "kind": "polynomial",
        "valid_from_deg": -180.0,
        "valid_to_deg": 180.0,
        "outside": "periodic",
    }
    return minimal | {
        "aerodynamics": flat | {"lift": [0.0], "drag": [1.0], "moment": [0.0]},
        "numerics": {"elements": 4, "time_step": STEP},
    }


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_wind_follows_its_law(drag_only, law):
    scene = Scene.from_dict(drag_only | {"wind": {"history": law}})
    state = Model(scene).start()
    first = state.observe_span()[SPAN_INDEX["wind_speed"]]
    found = state.run(100, 1, NO_CHANNELS, NO_CHANNELS).span_values[:, SPAN_INDEX["wind_speed"]]
    time = STEP * np.arange(1, 101)
    assert first == pytest.approx(float(scene.wind.history.at(0.0)), rel=1e-15)
    np.testing.assert_allclose(
        found, scene.wind.history.at(time), rtol=3e-15
    )  # observed at most 1e-15


def test_table_is_held_before_and_after(drag_only):
    state = Model(Scene.from_dict(drag_only | {"wind": {"history": LAWS["table"]}})).start()
    assert state.observe_span()[SPAN_INDEX["wind_speed"]] == 2.0
    state.advance(1.0)
    assert state.observe_span()[SPAN_INDEX["wind_speed"]] == 4.0


def differences(law, time, h):
    """Fourth-order central first and second difference of a law."""
    before2, before, now, after, after2 = (law.at(time + k * h) for k in (-2, -1, 0, 1, 2))
    first = (before2 - 8.0 * before + 8.0 * after - after2) / (12.0 * h)
    second = (-before2 + 16.0 * before - 30.0 * now + 16.0 * after - after2) / (12.0 * h * h)
    return first, second


@pytest.mark.parametrize(
    "law",
    [
        Ramp(initial=0.0, final=0.02, start=0.0, duration=1.0),
        Pulse(peak=0.02, start=0.0, rise=0.5, fall_start=0.5, fall=0.5),
        Harmonic(amplitude=0.01, frequency_hz=1.3, phase_deg=0.0),
    ],
    ids=lambda law: law.kind,
)
def test_support_moves_with_the_law_and_its_derivatives(minimal, law):
    motion = {"x3": law.model_dump()}
    supports = {"right": {"kind": "rigid", "motion": motion}}
    model = Model(
        Scene.from_dict(
            minimal | {"supports": supports, "numerics": {"elements": 4, "time_step": STEP}}
        )
    )
    state = model.start()
    for time in (0.13, 0.37, 0.71):
        state.advance(time)
        end = state.observe_node(model.nodes - 1)
        velocity, acceleration = differences(law, time, 1e-3)
        assert end[NODE_INDEX["u3"]] == pytest.approx(float(law.at(time)), rel=1e-14)
        assert end[NODE_INDEX["v3"]] == pytest.approx(velocity, rel=2e-9)  # observed 4e-10
        assert end[NODE_INDEX["a3"]] == pytest.approx(acceleration, rel=1e-9)  # observed 2e-10


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_load_follows_its_law(minimal, law):
    """Static twist at mid-span under a torque there, M L / (4 GJ), at several times."""
    load = {"position": 0.5, "force": [0.0, 0.0, 0.0], "torque": 0.5, "law": law}
    scene = Scene.from_dict(minimal | {"loads": [load], "numerics": {"elements": 16}})
    model = Model(scene)
    for time in (0.0, 0.17, 0.4, 0.53, 2.0):
        theta = model.rest(time).observe_node(model.middle)[NODE_INDEX["theta"]]
        torque = 0.5 * float(scene.loads[0].law.at(time))
        twist = torque * model.equilibrium().length / (4.0 * scene.conductor.torsional_stiffness)
        assert theta == pytest.approx(twist, rel=5e-10)  # observed 1.1e-10
