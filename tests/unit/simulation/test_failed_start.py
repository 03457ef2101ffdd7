"""Runs that cannot start: with ``on_failure="return"`` they are results as those that end early."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
import modal

SLACK = {"span.length": 95.0, "span.sag": None, "initial.seed_vertical": 0.6}
"""A seed that flattens the span shortens the cable by more than its elastic elongation."""

NO_EQUILIBRIUM = {"span.sag": None, "ice.first_moment_x2": 0.012}
"""More than pi^2 GJ / (g L^2) above the conductor rolls it over."""

OUT_OF_RANGE = {"aerodynamics.valid_to_deg": 180.0}

CASES = {"slack": SLACK, "no equilibrium": NO_EQUILIBRIUM, "out of range": OUT_OF_RANGE}
OUTCOMES = {
    "slack": gf.Outcome.SLACK,
    "no equilibrium": gf.Outcome.EQUILIBRIUM_NOT_FOUND,
    "out of range": gf.Outcome.ANGLE_OUT_OF_RANGE,
}


@pytest.mark.parametrize("case", CASES)
def test_a_failed_start_returns_a_result(case, tmp_path):
    scene = gf.load_scene("example3").with_values(CASES[case])
    result = gf.simulate(scene, 5.0, on_failure="return")
    assert result.outcome is OUTCOMES[case]
    assert not result.started
    assert result.dataset.time.values.tolist() == [0.0]
    assert np.isnan(result.midspan().u2.values).all()
    assert math.isfinite(result.dataset.attrs["sag"]) == (case != "no equilibrium")
    assert result.motion.kind == "undetermined"
    assert "undetermined" in repr(result)
    assert result.save(tmp_path / "a.nc").exists()
    assert result.save(tmp_path / "a.csv").exists()
    for window in (None, 5.0):
        with pytest.raises(gf.SceneError, match=r"the run has one record, at 0 s\. ") as refused:
            result.steady(window)
        assert str(refused.value).endswith(str(result.report))
    with pytest.raises(gf.SimulationError) as raised:
        gf.simulate(scene, 5.0)
    assert not raised.value.result.started


def test_a_loop_and_a_sweep_over_seeds_survive():
    scene = gf.load_scene("example3").with_values({**SLACK, "numerics.elements": 6})
    seeds = [0.01, 0.6, 0.02]
    results = [
        gf.simulate(scene.with_values({"initial.seed_vertical": seed}), 1.0, on_failure="return")
        for seed in seeds
    ]
    assert [result.started for result in results] == [True, False, True]
    runs = gf.sweep(scene, {"initial.seed_vertical": seeds}, stop_time=1.0)
    assert runs.dataset.outcome.values.tolist() == ["completed", "slack", "completed"]
    with pytest.raises(gf.SimulationError, match="slack"):
        modal.compare(scene, 1.0)
