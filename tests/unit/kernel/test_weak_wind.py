"""Weak wind: its angle is not checked, as the section's own motion rotates it by any angle.

The right motion is that of ``aerodynamics.outside = "hold"``, which judges no angle: the forces
have the same bits.
"""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_CHANNELS
from gallop_fmu.foundation.outcome import Outcome

RISE = {"kind": "ramp", "initial": 0.0, "final": 5.5, "duration": 10.0}
CALM = {"kind": "constant", "value": 0.0}
WINDS = {
    "ramp from calm": (RISE, 12.0),  # ended at 0.01 s
    "ramp to calm": (RISE | {"initial": 5.5, "final": 0.0}, 30.0),  # at 8.86 s
    "lulls": (
        {"kind": "harmonic", "mean": 5.0, "amplitude": 5.0, "frequency_hz": 0.1},
        30.0,
    ),  # at 17.42 s
    "nearly calm": (CALM | {"value": 1e-9}, 1.0),  # at 0.01 s
    "table that touches zero": (
        {"kind": "table", "time": [0.0, 5.0, 10.0], "value": [5.5, 0.0, 5.5]},
        12.0,
    ),
}
EVERY_CHANNEL = np.arange(len(NODE_CHANNELS))


def scene(history, **values):
    changes = {
        "wind.speed": None,
        "wind.history": history,
        "numerics.elements": 10,
        "numerics.time_step": 0.02,
    }
    return gf.load_scene("example3").with_values(changes | values)


def motion(scene, seconds):
    model = Model(scene, inputs=False)
    run = model.start().run(round(seconds / 0.2), 10, EVERY_CHANNEL, np.arange(model.nodes))
    return run.report.outcome, run.node_values


@pytest.mark.parametrize("integrator", ["newmark", "gauss6"])
@pytest.mark.parametrize("name", WINDS)
def test_runs_in_weak_wind_are_those_that_judge_no_angle(name, integrator):
    history, seconds = WINDS[name]
    (judged, found), (free, expected) = (
        motion(
            scene(history, **{"aerodynamics.outside": outside, "numerics.integrator": integrator}),
            seconds,
        )
        for outside in ("error", "hold")
    )
    assert judged is free is Outcome.COMPLETED
    assert np.array_equal(found, expected)


def test_the_bound_is_a_millionth_of_the_weight():
    """Two-sided: wind from outside the range fails only where rho d U^2 / 2 exceeds the bound."""
    still = scene(CALM)
    weight = (still.conductor.mass_per_length + still.ice.mass_per_length) * still.span.gravity
    bound = np.sqrt(1e-6 * weight / (0.5 * still.wind.air_density * still.conductor.diameter))
    assert 0.03 < bound < 0.04  # [m/s]
    model = Model(still)
    below, above = (Inputs(0.0, factor * bound, 0.0, np.zeros((2, 3))) for factor in (0.999, 1.001))
    assert model.start(inputs=below).time == 0.0
    with pytest.raises(gf.SimulationError, match=r'set aerodynamics\.outside to "hold"') as refused:
        model.start(inputs=above)
    assert refused.value.report.outcome is Outcome.ANGLE_OUT_OF_RANGE


def test_a_section_that_moves_fast_in_still_air_is_judged():
    """The relative wind counts: the seed of 0.1 m moves at about 0.4 m/s."""
    moving = scene(CALM | {"value": 1e-3}, **{"initial.seed_vertical": 0.1})
    outcome, _ = motion(moving, 10.0)
    assert outcome is Outcome.ANGLE_OUT_OF_RANGE
