"""Symmetries of the motion: mirror, left-right, time reversal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.input.scene_files import load_scene

CALM = load_scene("example3").with_values({"wind.speed": 0.0, "numerics.elements": 6})
FEW = settings(max_examples=5)
ALL = np.arange(len(NODE_CHANNELS), dtype=np.int32)
FORCES = [SPAN_INDEX[f"{end}_f{axis}"] for end in ("left", "right") for axis in (1, 2, 3)]


def loaded(scene, force, torque, position):
    """The scene with one pulse of force and torque, which excites everything."""
    law = {"kind": "pulse", "peak": 1.0, "rise": 0.4, "fall_start": 0.4, "fall": 0.3}
    loads = [{"force": list(force), "torque": torque, "position": position, "law": law}]
    return Model(
        scene.with_values(
            {"loads": loads, "initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0}
        )
    )


def records(model, count=150):
    """Node channels (record, channel, node) and the six support forces (record, force)."""
    run = model.start().run(count, 1, ALL, np.arange(model.nodes, dtype=np.int32))
    return run.node_values, run.span_values[:, FORCES]


def spread(found, expected):
    """Largest difference of each channel, over that channel's largest value."""
    axes = (0, 2) if found.ndim == 3 else 0
    scale = np.abs(expected).max(axis=axes)
    return (np.abs(found - expected).max(axis=axes) / np.where(scale > 0.0, scale, 1.0)).max()


# Never so small that round-off is all that moves.
PULSES = {
    "force": st.tuples(st.floats(2.0, 20.0), st.floats(-40.0, -4.0), st.floats(4.0, 40.0)),
    "torque": st.floats(0.2, 2.0),
    "position": st.floats(0.1, 0.9),
}


@pytest.mark.parametrize("integrator", INTEGRATORS)
@FEW
@given(**PULSES)
def test_mirror_across_the_span_plane(integrator, force, torque, position):
    """x3 -> -x3 without wind: x3, twist, torque and the first moment along x3 change sign."""
    calm = CALM.with_values({"numerics.integrator": integrator})
    mirrored_ice = calm.with_values({"ice.first_moment_x3": -CALM.ice.first_moment_x3})
    nodes, supports = records(loaded(calm, force, torque, position))
    other_nodes, other_supports = records(
        loaded(mirrored_ice, (force[0], force[1], -force[2]), -torque, position)
    )
    odd = [NODE_INDEX[name] for name in ("u3", "theta", "v3", "omega", "a3", "omega_rate")]
    kept = [i for i in ALL if i != NODE_INDEX["angle_of_attack"]]
    other_nodes[:, odd] *= -1.0
    other_supports[:, [2, 5]] *= -1.0
    assert np.array_equal(other_nodes[:, kept], nodes[:, kept])
    assert np.array_equal(other_supports, supports)


@FEW
@given(**PULSES)
def test_left_and_right_of_a_level_span_can_be_exchanged(force, torque, position):
    """Half a turn about x2: x1, x3, twist, torque and the first moment along x3 change sign."""
    turned_ice = CALM.with_values({"ice.first_moment_x3": -CALM.ice.first_moment_x3})
    nodes, supports = records(loaded(CALM, force, torque, position))
    other_nodes, other_supports = records(
        loaded(turned_ice, (-force[0], force[1], -force[2]), -torque, 1.0 - position)
    )
    odd = [NODE_INDEX[name + axis] for name in "uva" for axis in "13"]
    odd += [NODE_INDEX[name] for name in ("theta", "omega", "omega_rate")]
    kept = [i for i in ALL if i != NODE_INDEX["angle_of_attack"]]
    other_nodes[:, odd] *= -1.0
    other_supports = other_supports[:, [3, 4, 5, 0, 1, 2]] * np.array([-1.0, 1.0, -1.0] * 2)
    other_nodes = other_nodes[:, :, ::-1]
    assert spread(other_nodes[:, kept], nodes[:, kept]) < 1e-9  # observed 4e-11
    assert spread(other_supports, supports) < 1e-9  # observed 4e-11


@FEW
@given(**PULSES)
def test_undamped_motion_runs_back_in_time(force, torque, position):
    """With all velocities reversed the motion retraces its path: Newmark's rule is symmetric."""
    values = {
        "damping.translation": None,
        "damping.twist": None,
        "numerics.newton_tolerance": 1e-13,
    }
    model = loaded(CALM.with_values(values), force, torque, position)
    state = model.start()
    state.advance(0.8)  # the load is over at 0.7 s
    there, velocity, _ = state.motion()
    state.advance(1.6)
    away, back, _ = state.motion()
    state.restore(state.save().replace(back.tobytes(), (-back).tobytes()))
    assert np.array_equal(state.motion()[1], -back)
    state.advance(2.4)
    returned, reversed_velocity, _ = state.motion()
    moved = np.abs(there - away).max(axis=0)
    assert (np.abs(returned - there).max(axis=0) < 5e-6 * moved).all()  # observed 8e-7
    gained = np.abs(reversed_velocity + velocity).max(axis=0)
    assert (gained < 5e-6 * np.abs(velocity).max(axis=0)).all()  # observed 8e-7
