"""Amplitude, mean and frequency of histories, and what has none."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.simulation.result import frequency_text, oscillation
from gallop_fmu.simulation.steadiness import dominant_frequency

TIME = 0.05 * np.arange(2001)


def test_frequency_of_a_wave_with_harmonics_and_drift():
    """Against the frequency put in; the lines of the spectrum are 0.01 Hz apart."""
    for frequency in (0.3775, 0.6954, 5.29):
        wave = 3.0 + 0.5 * np.sin(2.0 * np.pi * frequency * TIME + 0.3)
        bent = wave + 0.1 * np.sin(4.0 * np.pi * frequency * TIME) + 0.001 * TIME
        assert dominant_frequency(bent, 0.05) == pytest.approx(
            frequency, abs=6e-6
        )  # observed 1.9e-6 at most
    found = oscillation(wave, 0.05)
    assert found.amplitude == pytest.approx(0.5, rel=5e-6)  # observed 1.2e-6
    assert found.mean == pytest.approx(3.0, abs=2e-4)  # observed 7.4e-5: no whole number of periods


@pytest.mark.parametrize(
    "still",
    [
        np.array([1.0]),  # one record
        np.sin(np.arange(7.0)),  # too few
        np.full(100, 3.3),  # motionless
        1e4 + 1e-9 * np.sin(TIME),  # only rounding moves
        np.concatenate(
            [[1.0], np.zeros(100), [-1.0]]
        ),  # at the ends only, which the window excludes
    ],
)
def test_a_motion_without_oscillation_has_no_frequency(still):
    assert np.isnan(dominant_frequency(still, 0.05))
    assert frequency_text(dominant_frequency(still, 0.05)) == "-"


def test_a_span_at_rest_has_an_amplitude_but_no_frequency():
    result = gf.simulate(
        gf.load_scene("zebra").with_values({"wind.speed": 0.0, "initial.seed_vertical": 0.0}), 5.0
    )
    found = result.steady(2.0)["u2"]
    assert found.amplitude < 1e-14  # observed 3.8e-16
    assert np.isnan(found.frequency_hz)


def test_a_window_between_two_records_is_refused():
    result = gf.simulate(gf.load_scene("example1"), 0.5, record_every=100)
    with pytest.raises(gf.SceneError, match="fewer than two records from"):
        result.steady(0.01)
    runs = gf.sweep("example1", {"wind.speed": [0.0]}, stop_time=0.5, window=0.001)
    assert runs.dataset.outcome.values.tolist() == ["invalid_scene"]
    assert "contains fewer than two records" in runs.dataset.message.item()


def test_the_description_of_a_support_force_excludes_the_tower_load():
    adjacent = {"kind": "adjacent_span", "adjacent_span": 130.0, "adjacent_tension": 15e3}
    string = {"insulator_length": 2.0, "insulator_weight": 500.0}
    scene = gf.load_scene("example3").with_values(
        {"supports.right": {**adjacent, **string}, "numerics.elements": 4}
    )
    data = gf.simulate(scene, 0.05).dataset
    for axis in (1, 2, 3):
        assert (
            "not the load on the suspension tower" not in data[f"left_f{axis}"].attrs["long_name"]
        )
        assert (
            data[f"right_f{axis}"]
            .attrs["long_name"]
            .endswith("so it is not the load on the suspension tower")
        )
    description = {variable.name: variable.description for variable in fmu_variables(scene)}
    assert "total force of this span" in description["support.right.f1"]
    assert "total force of this span" not in description["support.left.f1"]
