"""simulate_condensed: what it returns, how runs end, what it refuses."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gallop_fmu as gf

HARMONIC = {"kind": "harmonic", "mean": 5.0, "amplitude": 1.0, "frequency_hz": 2.0}


@pytest.fixture
def scene():
    return gf.load_scene("example3").with_values({"numerics.time_step": 0.01, "run.record_every": 5})


def test_it_is_laid_out_like_a_simulation(scene):
    condensed = gf.simulate_condensed(scene, 2.0, record_nodes="all").dataset
    element = gf.simulate(scene, 2.0, record_nodes="all").dataset
    assert condensed.sizes == element.sizes
    assert np.array_equal(condensed.time, element.time)
    assert condensed.x1.values == pytest.approx(element.x1.values, abs=1e-9)
    for name in set(condensed.data_vars) - {"horizontal_tension"}:
        assert condensed[name].attrs == element[name].attrs
    assert condensed.attrs["model"].startswith("condensed: 16 modes")
    assert condensed.tension.values[0] == pytest.approx(element.tension.values[0], rel=2.5e-3)  # observed 1.7e-3
    assert condensed.angle_of_attack.values[-1] == pytest.approx(element.angle_of_attack.values[-1], abs=0.01)


@pytest.mark.parametrize(("longest", "taken"), [(0.1, 0.1), (0.12, 0.1), (0.05, 0.05), (0.03, 0.025), (0.001, 0.001)])
def test_steps_fit_the_records(scene, longest, taken):
    result = gf.simulate_condensed(scene, 1.05, time_step=longest)
    assert result.dataset.attrs["time_step"] == pytest.approx(taken)
    assert result.dataset.time.values[-1] == pytest.approx(1.05)


def test_a_fine_mesh_is_condensed_from_a_coarser_one(scene):
    fine = gf.simulate_condensed(scene.with_values({"numerics.elements": 100}), 5.0, record_nodes=[50, 100])
    coarse = gf.simulate_condensed(scene.with_values({"numerics.elements": 12}), 5.0, record_nodes=[6, 12])
    assert np.array_equal(fine.dataset.u2, coarse.dataset.u2)


def test_threads_give_the_same_as_one(scene):
    scenes = [scene.with_values({"wind.speed": speed}) for speed in (4.0, 5.0, 6.0, 7.0)]

    def run(one):
        return gf.simulate_condensed(one, 50.0).dataset.u2.values

    with ThreadPoolExecutor(4) as pool:
        assert all(np.array_equal(a, b) for a, b in zip(pool.map(run, scenes), map(run, scenes), strict=True))


def test_a_slack_span_ends_the_run_and_keeps_what_was_computed(scene):
    law = {"kind": "pulse", "peak": 1.0, "start": 1.0, "rise": 1.0, "fall_start": 20.0, "fall": 1.0}
    lifted = scene.with_values({"loads": [{"force": [0.0, 60.0, 0.0], "evenly_spaced": 39, "law": law}]})
    with pytest.raises(gf.SimulationError, match="slack") as caught:
        gf.simulate_condensed(lifted, 10.0)
    result = caught.value.result
    assert result.outcome is gf.Outcome.SLACK
    assert 1.0 < result.dataset.time.values[-1] < 2.5
    assert result.report.lowest_tension < 0.0


def test_leaving_the_curve_ends_the_run(scene):
    narrow = scene.with_values({"aerodynamics.valid_to_deg": 181.0})
    result = gf.simulate_condensed(narrow, 300.0, on_failure="return")
    assert result.outcome is gf.Outcome.ANGLE_OUT_OF_RANGE
    element = gf.simulate(narrow, 300.0, on_failure="return")
    assert result.report.time == pytest.approx(element.report.time, abs=15.0)  # observed 9 s of 141; slow growth


def test_progress_can_stop_the_run(scene):
    result = gf.simulate_condensed(scene, 1000.0, progress=lambda time, stop: False, on_failure="return")
    assert result.outcome is gf.Outcome.STOPPED_BY_USER
    assert result.dataset.time.values[-1] == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"span": {"length": 125.88, "sag": 4.0}}, "sag is 0.032"),
        ({"span": {"length": 100.0, "sag": 2.0, "height_difference": -60.0}}, "height_difference is 0.600"),
        ({"supports.left": {"kind": "rigid", "motion": {"x2": {"kind": "constant", "value": 0.1}}}}, "left.motion"),
        ({"loads": [{"force": [1.0, 0.0, 0.0], "position": 0.5}]}, "loads.0.force"),
        ({"wind": {"history": HARMONIC}}, "wind.history.frequency_hz = 2.0"),
    ],
)
def test_scenes_outside_the_range_are_refused(scene, changes, reason):
    with pytest.raises(gf.SceneError, match="condensed model does not take this span") as caught:
        gf.simulate_condensed(scene.with_values(changes), 1.0)
    assert reason in str(caught.value)


@pytest.mark.parametrize("step", [0.0, -0.1, float("nan")])
def test_a_time_step_must_be_positive(scene, step):
    with pytest.raises(gf.SceneError, match="time_step"):
        gf.simulate_condensed(scene, 1.0, time_step=step)
