"""The Python binding with wrong types, shapes and indices: a right answer, or a clear error.

`State.run` handed arrays to C unchecked before: indices of 64 bits were read as pairs of 32.
"""

import copy
import math
import pickle
import threading

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays, scalar_dtypes

import gallop_fmu as gf
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model, State
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_CHANNELS
from gallop_fmu.foundation.outcome import Outcome, Report, SimulationError

U2 = NODE_INDEX["u2"]
TOWERS = np.zeros((2, 3))
CLEAR = (TypeError, ValueError, IndexError, SimulationError)
"""Exceptions that a wrong argument may raise."""


@pytest.fixture(scope="module")
def model():
    return Model(gf.load_scene("example3").with_values({"numerics.elements": 4}))


@pytest.fixture(scope="module")
def laws_only():
    scene = gf.load_scene("example3").with_values({"numerics.elements": 4})
    return Model(scene, inputs=False)


@pytest.mark.parametrize("kind", [list, tuple, np.int64, np.int32, np.int8, np.uint16, np.uint64])
def test_indices_of_any_whole_type_mean_the_same(model, kind):
    """u2 of nodes 3 and 4 after one step, read node by node."""
    state = model.start()
    given = kind([3, 4]) if kind in (list, tuple) else np.array([3, 4], kind)
    run = state.run(1, 1, [U2], given)
    expected = [state.observe_node(node)[U2] for node in (3, 4)]
    assert run.node_values.tolist() == [[expected]]
    assert run.report.outcome is Outcome.COMPLETED


def test_indices_need_not_lie_side_by_side(model):
    spread = np.arange(8, dtype=np.int32)[::2]
    found, expected = (
        model.start().run(2, 1, [U2], nodes).node_values for nodes in (spread, [0, 2, 4, 6])
    )
    assert np.array_equal(found, expected)


WRONG_RUNS = [
    ({"channels": [99]}, IndexError, r"channels\[0\] = 99 does not exist; there are 0 to 13"),
    ({"channels": [0, -1]}, IndexError, r"channels\[1\] = -1 does not exist"),
    ({"nodes": [-40]}, IndexError, r"nodes\[0\] = -40 does not exist; there are 0 to 8"),
    ({"nodes": [2**40]}, IndexError, r"nodes\[0\] = 1099511627776 does not exist"),
    ({"nodes": [[1, 2]]}, ValueError, r"nodes has the shape \(1, 2\); it must have one dimension"),
    ({"nodes": 4}, ValueError, r"nodes has the shape \(\)"),
    ({"nodes": [1.0]}, TypeError, r"nodes must be whole numbers, not float64"),
    ({"nodes": [True]}, TypeError, r"nodes must be whole numbers, not bool"),
    ({"nodes": ["1"]}, TypeError, r"nodes must be whole numbers"),
    (
        {"nodes": [[1], [1, 2]]},
        ValueError,
        r"nodes is not an array: its rows have different lengths",
    ),
    (
        {"span_channels": [11]},
        IndexError,
        r"span_channels\[0\] = 11 does not exist; there are 0 to 10",
    ),
    ({"records": -1}, ValueError, r"records = -1 must be at least 0"),
    ({"records": 1.5}, TypeError, r"records must be a whole number, not 1.5"),
    ({"every": 0}, ValueError, r"every = 0 must be at least 1"),
    ({"first": -1}, ValueError, r"first = -1 must be at least 0"),
    (
        {"first": 3, "every": 2**62},
        ValueError,
        r"every = 4611686018427387904 must be at least 1 and at most",
    ),
]


@pytest.mark.parametrize(("change", "kind", "match"), WRONG_RUNS)
def test_wrong_arguments_of_a_run_are_named(model, change, kind, match):
    state = model.start()
    saved = state.save()
    with pytest.raises(kind, match=match):
        state.run(**{"records": 1, "every": 1, "channels": [U2], "nodes": [4]} | change)
    assert state.save() == saved


WRONG_INPUTS = [
    ({"wind_speed": math.nan}, ValueError, r"inputs.wind_speed = nan must be finite"),
    ({"attack_angle": "3"}, TypeError, r"inputs.attack_angle must be real numbers, not '3'"),
    ({"time": None}, TypeError, r"inputs.time must be real numbers, not None"),
    (
        {"wind_speed_rate": [1.0, 2.0]},
        TypeError,
        r"inputs.wind_speed_rate must be one number, not an array of shape",
    ),
    (
        {"support": np.zeros((3, 2))},
        ValueError,
        r"inputs.support has the shape \(3, 2\); it must have \(2, 3\)",
    ),
    ({"support": [[0, 0, 0], [0, math.inf, 0]]}, ValueError, r"inputs.support\[1, 1\] is inf"),
    ({"support_rate": 1.0}, ValueError, r"inputs.support_rate has the shape \(\)"),
    ({"support_rate": 1j * TOWERS}, TypeError, r"inputs.support_rate must be real numbers"),
]


@pytest.mark.parametrize(("change", "kind", "match"), WRONG_INPUTS)
def test_wrong_inputs_are_named(model, change, kind, match):
    inputs = Inputs(
        **{"time": 0.0, "wind_speed": 5.0, "attack_angle": math.pi, "support": TOWERS} | change
    )
    state = model.start()
    for call in (
        lambda: state.advance(0.1, inputs),
        lambda: model.start(inputs=inputs),
        lambda: model.rest(0.0, inputs),
    ):
        with pytest.raises(kind, match=match):
            call()


def test_whole_numbers_and_lists_are_inputs_too(model):
    one = Inputs(0, 5, np.float32(3.0), TOWERS.tolist(), support_rate=[[0, 0, 1], [0, 0, 1]])
    other = Inputs(0.0, 5.0, 3.0, TOWERS, support_rate=np.array([[0.0, 0.0, 1.0]] * 2))
    states = [model.start(inputs=inputs) for inputs in (one, other)]
    for state, inputs in zip(states, (one, other), strict=True):
        state.advance(0.05, inputs)
    assert states[0].save() == states[1].save()


WRONG_CALLS = [
    (
        lambda m: Model(3),
        TypeError,
        r"scene must be a Scene, a LineScene, the name of .*, not 3",
    ),
    (lambda m: State(m.scene), TypeError, r"model must be a Model"),
    (lambda m: m.start("0"), TypeError, r"time must be real numbers, not '0'"),
    (lambda m: m.start(inputs=5.5), TypeError, r"inputs must be Inputs or None, not 5.5"),
    (lambda m: m.start().advance(None), TypeError, r"until must be real numbers"),
    (lambda m: m.start().observe_node(1.5), TypeError, r"node must be a whole number, not 1.5"),
    (
        lambda m: m.residual(np.zeros((3, 4))),
        ValueError,
        r"u has the shape \(3, 4\); it must have \(9, 4\)",
    ),
    (
        lambda m: m.residual(v=np.full((9, 4), math.nan)),
        ValueError,
        r"v must be finite; v\[0, 0\] is nan",
    ),
    (lambda m: m.residual(time=math.inf), ValueError, r"time = inf must be finite"),
    (lambda m: m.tangent(stiffness=math.nan), ValueError, r"stiffness = nan must be finite"),
    (lambda m: m.tangent(a=["x"] * 36), TypeError, r"a must be real numbers"),
    (lambda m: m.start().restore("saved"), TypeError, r"bytes"),
    (
        lambda m: State(m).advance(1.0),
        SimulationError,
        r"state, which was not started or belongs to another model",
    ),
    (lambda m: State(m).run(1, 1, [0], [0]), SimulationError, r"state, which was not started"),
    (
        lambda m: State(m).observe_span(),
        SimulationError,
        r"state, which was not started; Model.start",
    ),
    (lambda m: State(m).motion(), SimulationError, r"state, which was not started; Model.start"),
]


@pytest.mark.parametrize(("call", "kind", "match"), WRONG_CALLS)
def test_wrong_calls_are_refused_with_the_reason(model, call, kind, match):
    with pytest.raises(kind, match=match):
        call(model)


def test_damaged_bytes_are_not_restored(model):
    """A motion that is not finite; a state of another scene of equal size."""
    state, saved = model.start(), bytearray(model.start().save())
    saved[-16:-8] = np.array([1.0]).tobytes()
    before = state.save()
    not_finite = before.replace(
        state.motion()[2].tobytes(), np.full((model.nodes, 4), math.nan).tobytes()
    )
    assert not_finite != before
    other = Model(model.scene.with_values({"wind.speed": 6.0})).start().save()
    for damaged in (not_finite, other, bytes(len(before))):
        with pytest.raises(ValueError, match="belong to another model or are damaged"):
            state.restore(damaged)
    assert state.save() == before
    state.restore(memoryview(before))


def test_copies_of_a_model_are_the_model(model):
    """A copy once freed the kernel's model a second time."""
    for again in (copy.copy(model), copy.deepcopy(model), copy.deepcopy([model])[0]):
        assert again is model


def test_an_unpickled_model_computes_the_same(model, laws_only):
    for one in (model, laws_only):
        other = pickle.loads(pickle.dumps(one))
        assert (other.parts, other.nodes, other.scene) == (one.parts, one.nodes, one.scene)
        assert other.start().save() == one.start().save()


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda state: pickle.loads(pickle.dumps(state))]
)
def test_copies_of_a_state_go_their_own_way(model, again):
    state, expected = model.start(), model.start()
    state.advance(0.1)
    other = again(state)
    assert other.save() == state.save()
    other.advance(0.3)
    assert state.time == 0.1
    state.advance(0.3)
    expected.advance(0.1)
    expected.advance(0.3)
    assert state.save() == other.save() == expected.save()
    assert math.isnan(again(State(model)).time)


def test_an_unpickled_failure_has_the_same_message():
    failure = SimulationError(
        Report(Outcome.SLACK, 1.0, 3, -5.0, 0.0, lowest_tension=-5.0), "result"
    )
    again = pickle.loads(pickle.dumps(failure))
    assert (str(again), again.report, again.result) == (str(failure), failure.report, "result")


def test_a_state_in_use_refuses_other_threads(model):
    """Threads on one state once raced: displacements of 8e6 m, errors with wrong reasons."""
    state, expected, reasons = model.start(), model.start(), []
    thread = threading.Thread(target=state.run, args=(1, 20_000, [], []))
    thread.start()
    while not state._alone._lock.locked():  # else this thread could be the first to use the state
        assert thread.is_alive()
    while thread.is_alive():
        try:
            state.observe_span()
        except RuntimeError as reason:
            reasons.append(str(reason))
    thread.join()
    assert reasons
    assert set(reasons) == {
        "this State is in use by another thread; give each thread a State of its own"
    }
    expected.run(1, 20_000, [], [])
    assert state.save() == expected.save()


scalars = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3),
    st.binary(max_size=3),
    st.complex_numbers(),
    st.lists(st.integers(-2, 20), max_size=4), st.lists(st.lists(st.floats(), max_size=3),
    max_size=3), st.just(TOWERS),
    st.just(Inputs(0.0, 5.0, 3.0, TOWERS)), st.just(object()),
    arrays(scalar_dtypes(), array_shapes(max_dims=3, max_side=4)),
)  # fmt: skip
small = st.one_of(st.integers(-3, 12), scalars)


def allowed(call, *arguments, **named):
    """The call's value, or None where the arguments were refused by a clear error."""
    try:
        return call(*arguments, **named)
    except CLEAR as problem:
        reason = str(problem)
    assert len(reason) > 10
    return None


FACE = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))


@FACE
@given(
    records=small, every=small, first=small, channels=scalars, nodes=scalars, span_channels=scalars
)
def test_any_arguments_of_a_run(model, records, every, first, channels, nodes, span_channels):
    if isinstance(records, int) and isinstance(every, int) and records * every > 20:
        return
    state = model.start()
    run = allowed(state.run, records, every, channels, nodes, span_channels, first)
    if run is not None:
        assert run.report.outcome is Outcome.COMPLETED
        assert np.isfinite(run.node_values).all()
        assert run.node_values.shape == (int(records), len(channels), len(nodes))


@FACE
@given(fields=st.lists(scalars, min_size=7, max_size=7), until=small)
def test_any_inputs(model, fields, until):
    if isinstance(until, int | float) and until > 10:
        return
    names = (
        "time",
        "wind_speed",
        "attack_angle",
        "support",
        "wind_speed_rate",
        "attack_angle_rate",
        "support_rate",
    )
    usual = dict(zip(names, (0.0, 5.0, math.pi, TOWERS, 0.0, 0.0, None), strict=True))
    state = model.start()
    for name, value in zip(names, fields, strict=True):
        inputs = Inputs(**usual | {name: value})
        allowed(state.advance, until, inputs)
        allowed(model.start, until, inputs)
    assert np.isfinite(state.motion()).all()


@FACE
@given(
    u=scalars,
    v=scalars,
    a=scalars,
    factors=st.lists(scalars, min_size=3, max_size=3),
    time=small,
    inputs=scalars,
)
def test_any_motion(model, laws_only, u, v, a, factors, time, inputs):
    stiffness, damping, mass = factors
    for one in (model, laws_only):
        residual = allowed(one.residual, u, v, a, time=time, inputs=inputs)
        assert residual is None or residual.shape == (model.nodes, 4)
        allowed(
            one.tangent,
            u,
            v,
            a,
            stiffness=stiffness,
            damping=damping,
            mass=mass,
            time=time,
            inputs=inputs,
        )


WRONG_SIMULATIONS = [
    (
        {"record_nodes": [1.7]},
        r"record_nodes = \[1.7\]: must be node numbers from 0 to 8",
    ),  # was node 1
    (
        {"record_nodes": [2**40]},
        r"record_nodes = \[1099511627776\]: must be node numbers",
    ),  # was OverflowError
    ({"record_nodes": []}, r"record_nodes = \[\]: must be node numbers"),
    ({"record_nodes": 4}, r"record_nodes = 4: must be node numbers"),
    ({"record_every": 1.5}, r"record_every = 1.5: must be a whole number of time steps"),
    ({"record_every": True}, r"record_every = True: must be a whole number"),
    ({"stop_time": "1"}, r"stop_time = '1': must be a positive number of seconds"),
    ({"stop_time": math.nan}, r"stop_time = nan: must be a positive number"),
]


@pytest.mark.parametrize(("change", "match"), WRONG_SIMULATIONS)
def test_wrong_arguments_of_a_simulation_are_named(model, change, match):
    with pytest.raises(gf.SceneError, match=match):
        gf.simulate(model.scene, **{"stop_time": 0.1} | change)


def test_whole_numbers_of_numpy_are_whole(model):
    found, expected = (
        gf.simulate(model.scene, stop, record_every=every, record_nodes=nodes).dataset
        for stop, every, nodes in (
            (np.float32(0.5), np.int64(5), np.array([3, 4])),
            (0.5, 5, [3, 4]),
        )
    )
    assert np.array_equal(found["u2"].values, expected["u2"].values)


@settings(FACE, max_examples=15)
@given(stop=scalars, every=small, nodes=scalars, channels=scalars, failure=scalars)
def test_any_arguments_of_a_simulation(model, stop, every, nodes, channels, failure):
    if isinstance(stop, int | float) and stop > 10:
        return
    usual = {
        "stop_time": 0.1,
        "record_every": 1,
        "record_nodes": "all",
        "channels": ["u2"],
        "on_failure": "raise",
    }
    for name, value in zip(usual, (stop, every, nodes, channels, failure), strict=True):
        result = allowed(gf.simulate, model.scene, **usual | {name: value})
        assert result is None or result.outcome is Outcome.COMPLETED


@FACE
@given(value=scalars)
def test_any_other_argument(model, laws_only, value):
    state = model.start()
    for call in (
        Model, State, state.observe_node, state.restore, model.start, model.rest, model.accept,
        state.advance,
        laws_only.accept, lambda x: Model(model.scene, inputs=x),
    ):  # fmt: skip
        if call == state.advance and isinstance(value, int | float) and value > 10:
            continue
        allowed(call, value)
    assert len(state.observe_span()) == len(SPAN_CHANNELS)
    assert len(state.observe_node(0)) == len(NODE_CHANNELS)
