"""States: repeatable, saved and restored bit for bit, independent of recording, thread-safe."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model, State
from gallop_fmu.engine.state import VECTOR
from gallop_fmu.foundation.channels import (
    END_FORCES,
    NODE_CHANNELS,
    NODE_INDEX,
    SPAN_CHANNELS,
    SPAN_INDEX,
)
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.input.scene_files import load_scene

ALL = np.arange(len(NODE_CHANNELS), dtype=np.int32)
NO_NODES = np.zeros(0, np.int32)


def windy_model(values):
    """Wind, eccentric ice, damping and springs: everything that a state depends on."""
    return Model(
        load_scene("example2").with_values({"numerics.elements": 6, "wind.speed": 7.0} | values)
    )


@pytest.fixture(scope="module", params=INTEGRATORS)
def stepped_model(request):
    return windy_model({"numerics.integrator": request.param})


@pytest.fixture(scope="module", params=[*INTEGRATORS, "tolerance"])
def model(request):
    key = "tolerance" if request.param == "tolerance" else "integrator"
    return windy_model({f"numerics.{key}": 1e-4 if key == "tolerance" else request.param})


def everything(state, count=80, every=1):
    run = state.run(count, every, ALL, np.arange(state.model.nodes, dtype=np.int32))
    return run.node_values, run.span_values


def everything_from(state, first, count):
    run = state.run(count, 1, ALL, np.arange(state.model.nodes, dtype=np.int32), first=first)
    return run.node_values, run.span_values


def assert_same(found, expected):
    for one, other in zip(found, expected, strict=True):
        assert np.array_equal(one, other)


def test_a_repeated_run_has_the_same_bits(model):
    assert_same(everything(model.start()), everything(model.start()))


def test_another_model_of_the_same_scene_has_the_same_bits(model):
    assert_same(everything(Model(model.scene).start()), everything(model.start()))


def test_restoring_returns_bit_for_bit(model):
    state = model.start()
    everything(state)
    saved = state.save()
    after = everything(state)
    state.restore(saved)
    assert state.save() == saved
    assert_same(everything(state), after)


def test_a_saved_state_continues_in_another_state_of_the_model(model):
    state, other = model.start(), State(model)
    everything(state)
    other.restore(state.save())
    assert other.time == state.time
    assert_same(everything(other), everything(state))


def test_looking_at_a_state_does_not_change_it(model):
    state = model.start()
    state.advance(0.5)
    saved = state.save()
    state.motion()
    state.observe_span()
    assert state.save() == saved


def test_recording_does_not_change_the_motion(model):
    full, _ = everything(model.start())
    coarse = model.start().run(8, 10, ALL, np.arange(model.nodes, dtype=np.int32)).node_values
    assert np.array_equal(coarse, full[9::10])
    few = np.array([NODE_INDEX["theta"], NODE_INDEX["u2"]], np.int32)
    part = model.start().run(80, 1, few, np.array([model.middle, 0], np.int32)).node_values
    assert np.array_equal(part, full[:, few][:, :, [model.middle, 0]])


def test_a_run_leaves_the_state_of_its_last_record(stepped_model):
    model = stepped_model
    full, _ = everything(model.start())
    state = model.start()
    assert not state.run(80, 1, NO_NODES, NO_NODES).node_values.size
    assert np.array_equal([state.observe_node(node) for node in range(model.nodes)], full[-1].T)


def test_a_run_in_pieces_has_the_same_bits(model):
    whole = everything(model.start())
    state = model.start()
    nodes = np.arange(model.nodes, dtype=np.int32)
    pieces = [state.run(20, 1, ALL, nodes, first=20 * i) for i in range(4)]
    assert np.array_equal(np.concatenate([piece.node_values for piece in pieces]), whole[0])
    assert np.array_equal(np.concatenate([piece.span_values for piece in pieces]), whole[1])


def test_recording_does_not_move_the_instants_at_which_laws_are_read(model):
    """Times are the same products however a run is interrupted; else the wind differs."""
    gusts = {"kind": "harmonic", "mean": 7.0, "amplitude": 2.0, "frequency_hz": 0.71}
    gusty = Model(
        model.scene.with_values(
            {"wind.speed": None, "wind.history": gusts, "numerics.time_step": 0.0123}
        )
    )
    whole, portions = gusty.start(), gusty.start()
    expected = everything(whole, count=1, every=120)
    for i in range(12):
        found = everything_from(portions, first=10 * i, count=10)
    assert_same([values[-1:] for values in found], expected)
    assert portions.time == whole.time


def test_advance_and_run_take_the_same_steps(stepped_model):
    model = stepped_model
    stepped, ran = model.start(), model.start()
    for i in range(1, 81):
        stepped.advance(i * model.scene.numerics.time_step)
    everything(ran)
    for one, other in zip(stepped.motion(), ran.motion(), strict=True):
        np.testing.assert_allclose(
            one, other, rtol=0, atol=1e-13 * np.abs(other).max()
        )  # observed 0


def test_threads_on_one_model_do_not_disturb_each_other(model):
    def run(seed):
        state = model.start(inputs=Inputs(0.0, 4.0 + seed, 0.17, np.zeros((2, 3))))
        return everything(state, count=400)

    one_after_another = [run(seed) for seed in range(4)]
    with ThreadPoolExecutor(2) as pool:
        at_once = list(pool.map(run, range(4)))
    for one, other in zip(at_once, one_after_another, strict=True):
        assert_same(one, other)


def test_inputs_that_repeat_the_scene_change_nothing(model):
    inputs = Inputs(0.0, 7.0, np.radians(model.scene.ice.attack_angle_deg), np.zeros((2, 3)))
    plain, driven = model.start(), model.start(inputs=inputs)
    plain.advance(0.5)
    driven.advance(0.5, inputs)
    assert driven.save() == plain.save()


def test_inputs_change_linearly_in_time(model):
    inputs = Inputs(
        1.0,
        5.0,
        0.1,
        np.zeros((2, 3)),
        wind_speed_rate=-2.0,
        attack_angle_rate=0.3,
        support_rate=None,
    )
    inputs.support_rate = np.array([[0.0, 0.01, 0.0], [0.0, 0.0, 0.0]])
    state = model.start(1.0, inputs)
    state.advance(1.25, inputs)
    left = state.observe_node(0)
    assert state.observe_span()[SPAN_INDEX["wind_speed"]] == pytest.approx(4.5, rel=1e-14)
    assert left[NODE_INDEX["u2"]] == pytest.approx(0.0025, rel=1e-14)
    assert left[NODE_INDEX["v2"]] == 0.01
    # An end without twist: alpha0 + atan2(-vn, U - v3), vn normal to the parabola, which falls by 4
    # sag / length there.
    slope = 4.0 * 1.38 / 125.88
    normal = (left[NODE_INDEX["v2"]] + slope * left[NODE_INDEX["v1"]]) / np.hypot(1.0, slope)
    angle = 0.1 + 0.3 * 0.25 + np.arctan2(-normal, 4.5 - left[NODE_INDEX["v3"]])
    assert left[NODE_INDEX["angle_of_attack"]] == pytest.approx(angle, rel=1e-13)


def test_observed_channels_are_named_once(model):
    state = model.start()
    assert len(state.observe_span()) == len(SPAN_CHANNELS) == len(SPAN_INDEX)
    assert len(state.observe_node(0)) == len(NODE_CHANNELS) == len(NODE_INDEX)


def test_work_is_counted(stepped_model):
    state = stepped_model.start()
    report = state.advance(0.2)
    span = state.observe_span()
    assert (report.steps, report.substeps, report.halvings) == (20, 20, 0)
    assert report.iterations >= 20
    assert 1 <= report.refactorisations <= report.iterations
    assert span[SPAN_INDEX["substeps"]] == 1.0
    assert 1.0 <= span[SPAN_INDEX["newton_iterations"]] <= report.iterations
    assert report.lowest_tension < stepped_model.equilibrium().horizontal_tension * 1.1
    assert report.time == state.time == 0.2


def test_a_run_records_the_span_channels_that_are_asked_for():
    model, nodes = windy_model({}), np.array([6], np.int32)
    whole = model.start().run(20, 2, ALL, nodes)
    for names in (["right_f2", "substeps", "potential_energy"], ["left_f1"], []):
        asked = np.array([SPAN_INDEX[name] for name in names], np.int32)
        part = model.start().run(20, 2, ALL, nodes, asked)
        assert np.array_equal(part.span_values, whole.span_values[:, asked])
        assert np.array_equal(part.node_values, whole.node_values)


def test_the_kernel_refuses_inputs_to_a_model_of_the_laws_only():
    """As in C: the binding's own check is bypassed."""
    model = Model(load_scene("example2").with_values({"wind.speed": 0.0}), inputs=False)
    state, inputs = model.start(), Inputs(0.0, 10.0, 0.17, np.zeros((2, 3)))
    model._takes_inputs = True
    calls = (
        lambda: state.advance(0.1, inputs),
        lambda: model.start(inputs=inputs),
        lambda: model.rest(inputs=inputs),
    )
    for call in calls:
        with pytest.raises(SimulationError) as refused:
            call()
        assert refused.value.report.outcome is Outcome.BAD_CALL
    state.advance(0.1)


def test_the_force_at_a_junction_is_that_at_the_end_of_the_span():
    state = windy_model({}).start()
    state.advance(0.5)
    ends = [state.observe_junction(junction) for junction in range(state.model.junctions)]
    channels = [SPAN_INDEX[name] for name in END_FORCES]
    assert np.array_equal(np.concatenate(ends), state.observe_span()[channels])
    with pytest.raises(ValueError, match="junction"):
        state.observe_junction(state.model.junctions)


def test_a_state_placed_in_a_motion_continues_it():
    scene = load_scene("example3").with_values(
        {"numerics.elements": 6, "numerics.newton_tolerance": 1e-9}
    )
    model = Model(scene)
    state = model.start()
    state.advance(2.0)
    u, v, a = state.motion()
    placed = model.place(u, v, time=2.0)
    # observed 3e-6: both solve to the Newton tolerance
    assert placed.motion()[2] == pytest.approx(a, abs=1e-5 * np.max(np.abs(a)))
    for one in (state, placed):
        one.advance(3.0)
    theirs, ours = state.motion()[0], placed.motion()[0]
    assert ours == pytest.approx(theirs, abs=1e-5 * np.max(np.abs(theirs)))


def test_a_placed_state_has_the_prescribed_motion_of_its_ends():
    model = Model(load_scene("example3").with_values({"numerics.elements": 4}))
    ones = np.full((model.nodes, 4), 1e-3)
    u, v, _ = model.place(ones, ones).motion()
    assert np.all(u[[0, -1]] == 0.0)
    assert np.all(v[[0, -1]] == 0.0)
    with pytest.raises(ValueError, match="v"):
        model.place(ones, ones * np.nan)


def test_a_state_begins_at_a_whole_vector(stepped_model):
    states = [State(stepped_model) for _ in range(20)]
    assert {state._pointer.value % VECTOR for state in states} == {0}
