"""Failures: reports, no partial results, and halving of steps at a jump."""

import math

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model, State
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.scene import Scene

ALL = np.arange(len(NODE_CHANNELS), dtype=np.int32)


def fails(state, until, inputs=None):
    """The report of a failing advance, which must leave every bit of the state unchanged."""
    before = state.save()
    with pytest.raises(SimulationError) as caught:
        state.advance(until, inputs)
    assert state.save() == before
    return caught.value.report


def test_attack_angle_leaves_the_curve():
    """Example 2 is valid to 80 degrees; a torque turns the conductor out of that range."""
    twist = {"position": 0.5, "force": [0.0, 0.0, 0.0], "torque": 20.0,
             "law": {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": 2.0}}  # fmt: skip
    model = Model(load_scene("example2").with_values({"loads": [twist]}))
    state = model.start()
    state.advance(0.1)
    report = fails(state, 3.0)
    assert report.outcome is Outcome.ANGLE_OUT_OF_RANGE
    assert 0.1 < report.time < 2.0
    assert report.element == model.elements // 2
    assert report.limit == pytest.approx(math.radians(80.0), rel=1e-14)
    assert report.limit < report.value < report.limit + math.radians(1.0)
    # one step earlier all is well, and the largest angle is just inside
    step = model.scene.numerics.time_step
    state.advance(report.time - step)
    angles = [
        state.observe_node(node)[NODE_INDEX["angle_of_attack"]] for node in range(model.nodes)
    ]
    assert (
        math.radians(77.0) < max(angles) < math.radians(80.5)
    )  # nodes lie beyond the Gauss points
    assert fails(state, report.time).time == pytest.approx(report.time, abs=1e-12)


def test_attack_angle_below_the_curve():
    inputs = Inputs(0.0, 4.1, math.radians(-61.0), np.zeros((2, 3)))
    model = Model(load_scene("example2"))
    report = fails(model.start(), 0.1, inputs)
    assert report.outcome is Outcome.ANGLE_OUT_OF_RANGE
    assert report.limit == pytest.approx(math.radians(-60.0), rel=1e-14)
    assert report.value < report.limit
    for begin in (model.start, model.rest):
        with pytest.raises(SimulationError) as caught:
            begin(0.0, inputs)
        assert caught.value.report.outcome is Outcome.ANGLE_OUT_OF_RANGE


def test_a_failed_run_keeps_what_was_recorded():
    twist = {"position": 0.5, "force": [0.0, 0.0, 0.0], "torque": 20.0,
             "law": {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": 2.0}}  # fmt: skip
    model = Model(load_scene("example2").with_values({"loads": [twist]}))
    run = model.start().run(300, 1, ALL, np.array([model.middle], np.int32))
    assert run.report.outcome is Outcome.ANGLE_OUT_OF_RANGE
    assert len(run.node_values) == len(run.span_values) == round(run.report.time / 0.01) - 1
    assert np.isfinite(run.node_values).all()


def lifted(minimal, lift, **numerics):
    """A span pushed up by a load that grows within 0.3 s."""
    law = {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": 0.3}
    load = {"evenly_spaced": 19, "force": [0.0, lift, 0.0], "law": law}
    return Model(
        Scene.from_dict(minimal | {"loads": [load], "numerics": {"elements": 10, **numerics}})
    )


def test_strong_upward_load_makes_the_cable_slack(minimal):
    model = lifted(minimal, 400.0)  # 19 x 400 N against 1472 N of weight
    report = fails(model.start(), 3.0)
    assert report.outcome is Outcome.SLACK
    assert 0.0 < report.time < 3.0
    assert 0 <= report.element < model.elements
    assert report.value < 0.0
    assert report.limit == 0.0
    assert report.lowest_tension <= report.value
    assert "slack" in str(SimulationError(report))


def test_gentle_upward_load_does_not(minimal):
    report = lifted(minimal, 20.0).start().advance(3.0)
    assert report.outcome is Outcome.COMPLETED
    assert report.lowest_tension > 0.0


def jumped(minimal, **numerics):
    """A sideways load that jumps in the middle of a step, too much for a long one."""
    law = {"kind": "ramp", "initial": 0.0, "final": 1.0, "start": 0.9, "duration": 0.0}
    load = {"evenly_spaced": 19, "force": [0.0, -300.0, 300.0], "law": law}
    return Model(
        Scene.from_dict(minimal | {"loads": [load], "numerics": {"elements": 10, **numerics}})
    )


def test_newton_stalls_where_halving_is_not_allowed(minimal):
    model = jumped(minimal, time_step=0.5, max_halvings=0, max_newton_iterations=3)
    state = model.start()
    state.advance(0.5)
    report = fails(state, 1.0)
    assert report.outcome is Outcome.NEWTON_STALLED
    assert report.time == 1.0
    assert report.halvings == 0


def test_halving_gets_through_a_jump(minimal):
    """Halved steps end in the same motion as steps a hundred times shorter."""
    coarse, fine = (
        jumped(minimal, time_step=0.05, max_newton_iterations=4),
        jumped(minimal, time_step=0.0005),
    )
    states = [model.start() for model in (coarse, fine)]
    halved, whole = (state.advance(1.2) for state in states)
    found, expected = (state.motion()[0][:, :3] for state in states)
    assert halved.steps == 24
    assert halved.halvings > 0
    assert halved.substeps > halved.steps
    assert (whole.halvings, whole.substeps) == (0, 2400)
    assert np.abs(found - expected).max() < 0.15 * np.abs(expected).max()  # observed 0.05


@pytest.mark.parametrize("integrator", ["newmark", "gauss6"])
def test_a_run_that_fails_in_half_a_step_ends_where_the_step_began(minimal, integrator):
    model = jumped(
        minimal, time_step=0.5, max_halvings=1, max_newton_iterations=4, integrator=integrator
    )
    state, whole = model.start(), model.start()
    whole.advance(0.5)
    run = state.run(3, 1, ALL, np.array([model.middle], np.int32))
    assert (run.report.outcome, run.report.halvings, len(run.node_values)) == (
        Outcome.NEWTON_STALLED,
        1,
        1,
    )
    assert run.report.time == 1.0  # in the second half, after the jump
    assert state.time == 0.5
    for kept, right in zip(state.motion(), whole.motion(), strict=True):
        assert np.array_equal(kept, right)


@pytest.mark.parametrize("values", [{}, {"integrator": "gauss6"}, {"tolerance": 1e-4}])
def test_a_run_that_fails_leaves_the_wind_of_its_state(values):
    """Once motion and time were from before the failed step, wind and tower motion from within."""
    gale = {"kind": "ramp", "initial": 5.5, "final": 140.0, "duration": 20.0}
    narrow = {"aerodynamics.valid_from_deg": 179.99, "aerodynamics.valid_to_deg": 180.01}
    changes = {"wind.speed": None, "wind.history": gale, "numerics.elements": 8, **narrow}
    scene = load_scene("example3").with_values(
        changes | {f"numerics.{name}": value for name, value in values.items()}
    )
    state = Model(scene).start()
    assert state.run(2000, 1, ALL, [8]).report.outcome is not Outcome.COMPLETED
    assert state.time > 0.0
    wind = state.observe_span()[SPAN_INDEX["wind_speed"]]
    assert wind == pytest.approx(float(scene.wind.history.at(state.time)), rel=1e-14)
    other = State(state.model)
    other.restore(state.save())


@pytest.mark.parametrize("until", [0.5, 0.4, math.nan, math.inf, -math.inf])
def test_time_must_be_finite_and_grow(minimal, until):
    state = Model(Scene.from_dict(minimal)).start()
    state.advance(0.5)
    assert fails(state, until).outcome is Outcome.BAD_CALL
    assert state.time == 0.5


@pytest.mark.parametrize("time", [math.nan, math.inf])
def test_start_must_be_finite(minimal, time):
    model = Model(Scene.from_dict(minimal))
    for begin in (model.start, model.rest):
        with pytest.raises(SimulationError) as caught:
            begin(time)
        assert caught.value.report.outcome is Outcome.BAD_CALL


def test_impossible_support_displacement_has_no_equilibrium(minimal):
    """The towers one above the other: the horizontal tension vanishes."""
    inputs = Inputs(0.0, 0.0, 0.0, np.array([[0.0, 0.0, 0.0], [1e9, 0.0, 0.0]]))
    with pytest.raises(SimulationError) as caught:
        Model(Scene.from_dict(minimal)).rest(inputs=inputs)
    assert caught.value.report.outcome is Outcome.EQUILIBRIUM_NOT_FOUND


def test_foreign_bytes_are_not_restored(minimal):
    model, other = (Model(Scene.from_dict(minimal | {"numerics": {"elements": n}})) for n in (6, 7))
    state = model.start()
    saved = state.save()
    for foreign in (b"", saved[:-1], saved + b"\0", b"X" * len(saved), other.start().save()):
        with pytest.raises(ValueError, match="not a saved state of this model"):
            state.restore(foreign)
        assert state.save() == saved


def test_nodes_outside_the_mesh_are_refused(minimal):
    model = Model(Scene.from_dict(minimal))
    for node in (-1, model.nodes):
        with pytest.raises(IndexError, match=f"node {node} does not exist"):
            model.start().observe_node(node)


def test_a_state_recovers_after_a_failure():
    """After a failed advance the state continues under other inputs, as if it had not failed."""
    model = Model(load_scene("example2"))
    state, other = model.start(), State(model)
    state.advance(0.3)
    other.restore(state.save())
    fails(state, 0.5, Inputs(0.3, 4.1, math.radians(-61.0), np.zeros((2, 3))))
    state.advance(0.5)
    other.advance(0.5)
    assert state.save() == other.save()


def test_a_step_of_the_host_far_below_that_of_the_tolerance():
    """A ten-millionth of a step: both limits of the tolerance for the host's clock."""
    scene = load_scene("example3").with_values({"numerics.tolerance": 1e-3, "numerics.elements": 4})
    state = Model(scene).start()
    state.advance(
        1e-9, Inputs(time=0.0, wind_speed=5.5, attack_angle=math.pi, support=np.zeros((2, 3)))
    )
    assert state.time == 1e-9
    assert abs(state.observe_node(4)[NODE_INDEX["u2"]] - 1e-3) < 1e-9  # the seed


def test_a_tolerance_that_newtons_iteration_cannot_keep():
    """Steps are halved as often as allowed, and then the run ends."""
    hard = {
        "numerics.tolerance": 1e-7,
        "numerics.max_newton_iterations": 2,
        "numerics.max_halvings": 3,
    }
    far = {"numerics.elements": 4, "initial.seed_vertical": 0.3, "initial.seed_twist": 0.5}
    report = fails(Model(load_scene("example3").with_values({**hard, **far})).start(), 1.0)
    assert (report.outcome, report.halvings, report.steps) == (Outcome.NEWTON_STALLED, 3, 0)
