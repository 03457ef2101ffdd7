"""The outputs of the FMU equal those of the engine with the same steps."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.fmu import export_fmu
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_INDEX
from gallop_fmu.input.scene_files import load_scene

STOP = 2.0
STILL = np.zeros((2, 3))


def outputs_of(scene, node, span):
    """Every output but the status and the stations, from the engine's channels."""
    values = {}
    for variable in fmu_variables(scene):
        if variable.key in NODE_INDEX and not variable.name.startswith("station"):
            values[variable.name] = node[NODE_INDEX[variable.key]]
        elif variable.causality == "output" and variable.key in SPAN_INDEX:
            values[variable.name] = span[SPAN_INDEX[variable.key]]
    return values


def observed(state):
    return outputs_of(
        state.model.scene, state.observe_node(state.model.middle), state.observe_span()
    )


def assert_same(found, wanted):
    """Observed: no difference; 1e-12 of the maximum value allows for another compiler."""
    for name, values in wanted.items():
        assert found[name] == pytest.approx(
            values, rel=1e-12, abs=1e-12 * np.max(np.abs(values))
        ), name


def test_constant_wind_equals_the_engine_s_own_run(gallop_scene, gallop_fmu):
    dt = gallop_scene.numerics.time_step
    found = simulate_fmu(str(gallop_fmu), stop_time=STOP, output_interval=dt)
    model = Model(gallop_scene)
    channels, nodes = (
        np.arange(len(NODE_CHANNELS), dtype=np.int32),
        np.array([model.middle], dtype=np.int32),
    )
    run = model.start().run(round(STOP / dt), 1, channels, nodes)
    wanted = outputs_of(gallop_scene, run.node_values[:, :, 0].T, run.span_values.T)
    assert len(found) == 1 + len(run.node_values)
    assert_same({name: found[name][1:] for name in wanted}, wanted)
    assert np.all(found["status"] == 0)


@pytest.mark.parametrize("steps", [1, 5, 25])
def test_wind_step_equals_the_engine_at_each_communication_step(gallop_scene, gallop_fmu, steps):
    h = steps * gallop_scene.numerics.time_step
    wind = np.array(
        [(0.0, 4.1), (1.0, 4.1), (1.0, 9.0), (STOP, 9.0)],
        dtype=[("time", np.float64), ("wind_speed", np.float64)],
    )
    found = simulate_fmu(str(gallop_fmu), stop_time=STOP, output_interval=h, input=wind)
    assert len(found) == 1 + round(STOP / h)
    angle = np.radians(gallop_scene.ice.attack_angle_deg)
    state = Model(gallop_scene).start(0.0, Inputs(0.0, 4.1, angle, STILL))
    rows = [observed(state)]
    for k in range(len(found) - 1):
        begin, size = k * h, (k + 1) * h - k * h
        speed = 4.1 if begin < 1.0 - 1e-9 else 9.0
        state.advance(begin + size, Inputs(begin, speed, angle, STILL))
        rows.append(observed(state))
    assert_same(
        {name: found[name] for name in rows[0]},
        {name: [row[name] for row in rows] for name in rows[0]},
    )
    assert np.ptp(found["midspan.x3"][: round(1.0 / h)]) < 0.5 * np.ptp(
        found["midspan.x3"]
    )  # the step was felt


def test_a_step_that_is_no_multiple_is_divided_equally(gallop_scene, gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    assert gallop_scene.numerics.time_step == 0.01
    state, quarters = (
        Model(gallop_scene).start(),
        Model(gallop_scene.with_values({"numerics.time_step": 0.00925})).start(),
    )
    for k in range(10):
        fmu.step(0.037)
        assert state.advance(fmu.time).steps == 4 * (k + 1)
        for part in range(1, 5):
            quarters.advance(0.037 * k + 0.00925 * part)
    wanted = observed(state)
    assert_same({name: fmu[name] for name in wanted}, wanted)
    assert fmu["midspan.x3"] == pytest.approx(
        observed(quarters)["midspan.x3"], abs=2e-10
    )  # observed: 2e-11 m


def test_short_and_uneven_steps(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    for size in (0.01, 1e-4, 0.02, 0.003, 0.05):
        fmu.step(size)
    assert fmu.time == pytest.approx(0.0831, abs=1e-12)
    assert fmu["status"] == 0


def test_loads_follow_their_laws_from_the_start_time_on(runtime, tmp_path, host):
    scene = load_scene("example1").with_values({"numerics.elements": 4, "loads.0.evenly_spaced": 7})
    fmu = host(export_fmu(scene, tmp_path / "x.fmu", runtime=runtime)).start(time=0.5)
    state = Model(scene).start(0.5)
    for _ in range(20):
        fmu.step(0.01)
        state.advance(fmu.time)
    wanted = observed(state)
    assert abs(wanted["midspan.x3"]) > 1e-3
    assert_same({name: fmu[name] for name in wanted}, wanted)


def test_outputs_follow_inputs_while_initialising_and_not_afterwards(gallop_fmu, host):
    fmu = host(gallop_fmu)
    fmu.fmu.setupExperiment(startTime=0.0)
    fmu.fmu.enterInitializationMode()
    before = fmu["angle_of_attack"]
    fmu["attack_angle"] = 0.3
    assert before == pytest.approx(np.radians(10.0), abs=1e-12)
    assert fmu["angle_of_attack"] == pytest.approx(0.3, abs=1e-12)
    fmu.fmu.exitInitializationMode()
    fmu["attack_angle"] = 0.2
    assert fmu["angle_of_attack"] == pytest.approx(0.3, abs=1e-12)
    fmu.step(1e-6)
    assert fmu["angle_of_attack"] == pytest.approx(0.2, abs=1e-3)


def test_parameters_set_after_a_look_at_the_outputs_count_too(gallop_scene, gallop_fmu, host):
    fmu = host(gallop_fmu)
    fmu.fmu.setupExperiment(startTime=0.0)
    fmu.fmu.enterInitializationMode()
    before = fmu["support.left.f2"]
    fmu["conductor.mass_per_length"] = 1.5
    changed = Model(gallop_scene.with_values({"conductor.mass_per_length": 1.5})).start()
    assert fmu["support.left.f2"] == observed(changed)["support.left.f2"] != before


def test_parameters_set_before_initialisation_make_another_span(gallop_scene, gallop_fmu, host):
    values = {"span.length": 124.0, "conductor.mass_per_length": 1.55, "numerics.elements": 8}
    fmu = host(gallop_fmu)
    for name, value in values.items():
        fmu[name] = value
    fmu.start()
    assert [fmu[name] for name in values] == list(values.values())
    state = Model(gallop_scene.with_values(values)).start()
    for _ in range(5):
        wanted = observed(state)
        assert_same({name: fmu[name] for name in wanted}, wanted)
        fmu.step(0.05)
        state.advance(fmu.time)
    untouched = host(gallop_fmu).start()
    assert untouched["support.left.f2"] != fmu["support.left.f2"]
