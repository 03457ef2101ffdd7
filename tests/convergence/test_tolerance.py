"""Under numerics.tolerance whole runs are as exact as requested, across the span and in twist."""

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX
from gallop_fmu.input.scene_files import load_scene, packaged_scenes
from gallop_fmu.simulation.simulate import simulate

CHANNELS = np.array([NODE_INDEX[name] for name in ("u2", "u3", "theta")], np.int32)
CLOCK = 0.005
FINE = 0.0025
RUNS = {
    "example1": (10.0, {}),
    "example2": (40.0, {"initial.seed_vertical": 0.3, "initial.seed_horizontal": 0.05}),
    "example3": (40.0, {"initial.seed_vertical": 0.25, "initial.seed_horizontal": 0.15}),
    "zebra": (60.0, {}),
}
"""Duration [s], and changes that let something happen in it."""

SHORT_PULSE = {
    "kind": "pulse",
    "peak": 1.0,
    "start": 3.3,
    "rise": 0.05,
    "fall_start": 3.4,
    "fall": 0.05,
}


def motion(name, numerics, until, values):
    """Motion of all nodes every 0.05 s, (time, channel, node)."""
    scene = load_scene(name).with_values(
        values | {f"numerics.{key}": value for key, value in numerics.items()}
    )
    model, every = Model(scene), round(0.05 / scene.numerics.time_step)
    run = model.start().run(
        round(until / 0.05), every, CHANNELS, np.arange(model.nodes, dtype=np.int32)
    )
    return run.node_values, run.report


def relative(found, exact):
    """Root mean square of the difference, relative to the motion, of each moving channel."""
    error, size = (np.sqrt((values**2).mean(axis=(0, 2))) for values in (found - exact, exact))
    assert np.all(error[size == 0.0] == 0.0)
    return error[size > 0.0] / size[size > 0.0]


@pytest.fixture(scope="module", params=packaged_scenes())
def converged(request):
    until, values = RUNS[request.param]
    fine = {"integrator": "gauss6", "time_step": FINE, "newton_tolerance": 1e-13}
    return request.param, until, values, motion(request.param, fine, until, values)[0]


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
def test_error_of_a_run_is_within_three_tolerances(converged, tolerance):
    name, until, values, exact = converged
    found, report = motion(name, {"tolerance": tolerance, "time_step": CLOCK}, until, values)
    errors = relative(found, exact) / tolerance
    assert len(errors) == (2 if name == "zebra" else 3)  # a bare conductor does not twist
    assert errors.max() < 3.0  # observed up to 2.01 in the twist of example 1, 0.42 elsewhere
    assert errors.max() > 0.001  # not ten times more work than requested
    assert report.steps < until / FINE


def test_steps_end_where_a_table_of_the_wind_has_a_corner():
    """A gust of 0.2 s is resolved, and the motion after it is within the tolerance."""
    wind = {"kind": "table", "time": [0.0, 3.0, 3.1, 3.2, 5.0], "value": [1.0, 1.0, 40.0, 1.0, 3.0]}
    values = {"wind.speed": None, "wind.history": wind}
    fine = {"integrator": "gauss6", "time_step": FINE, "newton_tolerance": 1e-13}
    exact, _ = motion("example3", fine, 8.0, values)
    found, _ = motion("example3", {"tolerance": 1e-4, "time_step": CLOCK}, 8.0, values)
    assert relative(found, exact).max() < 1e-5  # observed 3.8e-6


@pytest.mark.parametrize(
    "law", [SHORT_PULSE, SHORT_PULSE | {"rise": 0.0, "fall": 0.0}], ids=["smooth", "jumps"]
)
def test_a_short_pulse_is_not_stepped_over(law):
    """A span at rest alone would allow steps of a second."""
    load = {"evenly_spaced": 39, "force": [0.0, 1.0, 2.0], "torque": 0.0, "law": law}
    fine = {"integrator": "gauss6", "time_step": FINE, "newton_tolerance": 1e-13}
    exact, _ = motion("example1", fine, 8.0, {"loads": [load]})
    found, _ = motion("example1", {"tolerance": 1e-4, "time_step": CLOCK}, 8.0, {"loads": [load]})
    errors = relative(found, exact) / 1e-4
    assert errors.max() < 3.0


def test_the_time_before_the_pulse_takes_few_steps():
    load = {"evenly_spaced": 39, "force": [0.0, 1.0, 2.0], "torque": 0.0, "law": SHORT_PULSE}
    _, report = motion("example1", {"tolerance": 1e-4, "time_step": CLOCK}, 3.0, {"loads": [load]})
    assert report.steps <= 12


def test_communication_steps_end_where_asked_and_jumps_of_the_wind_are_followed():
    """Against equal steps of 5 ms; the wind jumps every 0.8 s, the host steps by 0.1 s."""
    tolerance, times = 1e-4, 0.1 * np.arange(1, 201)
    values = {"initial.seed_vertical": 0.2}
    loose = Model(
        load_scene("example2").with_values(values | {"numerics.tolerance": tolerance})
    ).start()
    fine = {
        "numerics.integrator": "gauss6",
        "numerics.time_step": 0.005,
        "numerics.newton_tolerance": 1e-12,
    }
    exact = Model(load_scene("example2").with_values(values | fine)).start()
    seen = []
    for i, until in enumerate(times):
        wind = Inputs(until - 0.1, 4.0 + 2.0 * (i // 8 % 3), np.radians(10.0), np.zeros((2, 3)))
        report = loose.advance(until, wind)
        exact.advance(until, wind)
        assert loose.time == until
        seen.append([state.observe_node(state.model.middle)[CHANNELS] for state in (loose, exact)])
    seen = np.array(seen)[..., np.newaxis]
    errors = relative(seen[:, 0], seen[:, 1]) / tolerance
    assert errors.max() < 3.0
    assert report.refactorisations < report.steps / 3


def test_provenance_counts_rejected_steps():
    scene = load_scene("example3").with_values(
        {"numerics.tolerance": 1e-4, "initial.seed_vertical": 0.25}
    )
    result = simulate(scene, 30.0)
    attributes = result.dataset.attrs
    assert attributes["rejections"] == result.report.rejections > 0
    assert "Gauss" in attributes["integrator"]
    assert (
        attributes["substeps"]
        == attributes["steps"] + attributes["rejections"] + attributes["halvings"]
    )
