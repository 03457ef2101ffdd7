"""An FMU whose steps follow from a tolerance: the engine's trajectory, and states to return to."""

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.fmu import export_fmu
from gallop_fmu.foundation.channels import NODE_INDEX


@pytest.fixture(scope="module")
def free_scene(gallop_scene):
    return gallop_scene.with_values({"numerics.tolerance": 1e-4, "initial.seed_vertical": 0.2})


@pytest.fixture(scope="module")
def free_fmu(free_scene, runtime, tmp_path_factory):
    return export_fmu(free_scene, tmp_path_factory.mktemp("fmu") / "free.fmu", runtime=runtime)


def test_it_equals_the_engine_at_each_communication_step(free_scene, free_fmu, host):
    fmu, state = host(free_fmu).start(), None
    for k in range(30):
        wind = 4.0 + k % 4
        inputs = Inputs(
            0.3 * k, wind, np.radians(free_scene.ice.attack_angle_deg), np.zeros((2, 3))
        )
        if state is None:
            state = Model(free_scene).start(
                0.0, Inputs(0.0, 4.1, inputs.attack_angle, np.zeros((2, 3)))
            )
            fmu.time = 0.0
        fmu.set(wind_speed=wind)
        fmu.fmu.doStep(0.3 * k, 0.3 * (k + 1) - 0.3 * k)
        state.advance(0.3 * k + (0.3 * (k + 1) - 0.3 * k), inputs)
        assert fmu["midspan.x2"] == state.observe_node(state.model.middle)[NODE_INDEX["u2"]]
    assert fmu["substeps"] >= 1


def test_rollback_repeats_every_bit(free_fmu, host):
    fmu = host(free_fmu).start().step(0.4, 5)
    saved, time = fmu.fmu.getFMUstate(), fmu.time
    first = fmu.step(0.4, 5).read()
    fmu.fmu.setFMUstate(saved)
    fmu.time = time
    assert fmu.step(0.4, 5).read() == first
    fmu.fmu.freeFMUstate(saved)


def test_the_tolerance_is_a_parameter(free_fmu, host):
    """A hundredth of it changes the motion little and needs more iterations."""
    loose, tight = host(free_fmu).start(), host(free_fmu).start(numerics__tolerance=1e-6)
    ends = [fmu.step(0.4, 20)["midspan.x2"] for fmu in (loose, tight)]
    assert ends[0] != ends[1]
    assert abs(ends[0] - ends[1]) < 1e-4 * 0.2  # observed 3e-7
