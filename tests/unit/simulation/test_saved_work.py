"""Work that a row of a sweep and a summary do once."""

from __future__ import annotations

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine import histories, pack
from gallop_fmu.engine.histories import history_numbers
from gallop_fmu.engine.state import State
from gallop_fmu.scene import aerodynamic_curve
from gallop_fmu.simulation import provenance, recording
from gallop_fmu.simulation import simulate as simulation
from gallop_fmu.simulation.steadiness import dominant_frequency
from gallop_fmu.sweeps.sweep import SUMMARISED, steady_motion

DRAWS = np.random.default_rng(18)


@pytest.fixture
def counted(monkeypatch):
    """Return a function that counts the calls of a function or class in a module."""

    def count(owner, name):
        calls, original = [], getattr(owner, name)

        def call(*arguments, **named):
            calls.append(name)
            return original(*arguments, **named)

        monkeypatch.setattr(owner, name, call)
        return calls

    return count


def test_a_run_packs_its_scene_once(counted):
    calls = counted(pack.Packed, "_pack_span")
    gf.simulate("example3", 0.2)
    assert len(calls) == 1


@pytest.fixture
def passes(monkeypatch):
    """Numbers of histories that each call of the kernel describes."""
    found, kernel = [], histories.kernel

    class Counting:
        def __getattr__(self, name):
            return getattr(kernel, name)

        def gallop_history_numbers(self, samples, count, *others):
            found.append(count)
            return kernel.gallop_history_numbers(samples, count, *others)

    monkeypatch.setattr(histories, "kernel", Counting())
    return found


def test_a_second_run_makes_no_table_of_probes(counted):
    gf.simulate("example3", 0.2)
    calls = counted(recording, "node_probes")
    gf.simulate("example3", 0.3)
    assert not calls


def test_a_long_run_of_a_span_needs_few_calls_of_the_kernel(counted):
    """A fifth of it first, then ten times as much, which takes less than 0.1 s."""
    calls = counted(State, "record")
    gf.simulate("example3", 100.0)
    assert len(calls) == 2


def test_steady_describes_all_channels_in_one_call(passes, counted):
    result = simulation.simulate("example3", 20.0)
    transforms = counted(np.fft, "rfft")
    assert len(result.steady(5.0)) == 21
    assert passes == [21]
    assert not transforms


def test_a_row_describes_each_history_once(passes, counted):
    """Its motion from three histories, the columns of four, and the warnings about its steps."""
    scene = gf.load_scene("example3").with_values({"wind.speed": 5.123})
    result = simulation.simulate(scene, 40.0, **SUMMARISED)
    transforms, datasets = counted(np.fft, "rfft"), counted(provenance, "dataset_of")
    steady_motion(result)
    assert passes == [3, 4]
    assert len(transforms) == 1
    assert not datasets


def test_runs_with_equal_curves_evaluate_their_warnings_once(counted):
    scene = gf.load_scene("example3").with_values({"aerodynamics.centre_deg": 180.1})
    calls = counted(aerodynamic_curve.AerodynamicCurve, "_evaluate")
    found = [scene.with_values({"wind.speed": speed}).warnings for speed in (4.0, 5.0, 6.0)]
    assert len(calls) == 5  # each coefficient, its drag, and the lift of the section
    assert found[0] == found[1] == found[2]


def test_means_and_deviations_are_those_of_numpy():
    for count in (1, 3, 10, 25, 128, 129, 1001, 20000):
        values = DRAWS.normal(size=(5, count))
        for numbers, own in zip(history_numbers(values), values, strict=True):
            assert numbers.mean == np.mean(own)
            assert numbers.deviation == np.std(own)
            assert (numbers.lowest, numbers.highest) == (own.min(), own.max())


def test_frequency_follows_the_samples_not_the_array():
    time = 0.05 * np.arange(401)
    values = np.sin(2.0 * np.pi * 0.5 * time)
    assert dominant_frequency(values, 0.05) == pytest.approx(0.5, rel=2e-4)
    values[:] = np.sin(2.0 * np.pi * 0.7 * time)
    assert dominant_frequency(values, 0.05) == pytest.approx(0.7, rel=2e-4)
    assert dominant_frequency(values[::2], 0.1) == pytest.approx(0.7, rel=2e-4)
