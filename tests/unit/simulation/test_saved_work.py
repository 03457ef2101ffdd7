"""Work that a row of a sweep and a summary do once."""

from __future__ import annotations

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine import pack
from gallop_fmu.scene import aerodynamic_curve
from gallop_fmu.simulation import simulate as simulation
from gallop_fmu.simulation.steadiness import _mean, _parts, dominant_frequency
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


def test_a_row_transforms_each_history_once(counted):
    """Four histories of the row, and two of the warnings about its steps."""
    scene = gf.load_scene("example3").with_values({"wind.speed": 5.123})
    result = simulation.simulate(scene, 40.0, **SUMMARISED)
    calls = counted(np.fft, "rfft")
    steady_motion(result)
    assert len(calls) == 6


def test_runs_with_equal_curves_evaluate_their_warnings_once(counted):
    scene = gf.load_scene("example3").with_values({"aerodynamics.centre_deg": 180.1})
    calls = counted(aerodynamic_curve.AerodynamicCurve, "_evaluate")
    found = [scene.with_values({"wind.speed": speed}).warnings for speed in (4.0, 5.0, 6.0)]
    assert len(calls) == 5  # each coefficient, its drag, and the lift of the section
    assert found[0] == found[1] == found[2]


def test_means_and_parts_are_those_of_numpy():
    for count in (3, 10, 25, 26, 27, 1001, 20000):
        values = DRAWS.normal(size=count)
        assert _mean(values) == np.mean(values)
        for own, other in zip(_parts(values, 3), np.array_split(values, 3), strict=True):
            np.testing.assert_array_equal(own, other)


def test_frequency_follows_the_samples_not_the_array():
    time = 0.05 * np.arange(401)
    values = np.sin(2.0 * np.pi * 0.5 * time)
    assert dominant_frequency(values, 0.05) == pytest.approx(0.5, rel=2e-4)
    values[:] = np.sin(2.0 * np.pi * 0.7 * time)
    assert dominant_frequency(values, 0.05) == pytest.approx(0.7, rel=2e-4)
    assert dominant_frequency(values[::2], 0.1) == pytest.approx(0.7, rel=2e-4)
