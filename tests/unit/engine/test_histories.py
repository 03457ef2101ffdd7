"""Numbers of histories from the kernel, compared with NumPy and with formulas."""

from __future__ import annotations

import ctypes
import math

import numpy as np
import pytest

from gallop_fmu.engine.histories import beat_share, energy_line, history_numbers, history_sizes
from gallop_fmu.engine.library import kernel

EVEN = 0.02


def _padded_line(values):
    """Largest line [cycles a sample] of a padded transform by NumPy, with a parabola."""
    count = len(values)
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(count), 4 * count))
    peak = int(spectrum[1:-1].argmax()) + 1
    below, top, above = np.log(spectrum[peak - 1 : peak + 2])
    return (peak + 0.5 * (below - above) / (below - 2.0 * top + above)) / (4 * count)


def test_lines_are_those_of_a_padded_transform():
    """Waves, noise and steps of 8 to 2000 samples; observed difference 4e-12 of the line."""
    rng = np.random.default_rng(18)
    for _ in range(60):
        count = int(np.exp(rng.uniform(np.log(8), np.log(2000))))
        t = np.arange(count)
        values = np.array(
            [
                np.cos(rng.uniform(0.01, 3.0) * t + rng.uniform(0.0, 6.0)) + 1e3,
                1e-5 * rng.standard_normal(count),
                np.cumsum(rng.standard_normal(count)),
                np.cos(0.3 * t) + rng.uniform(0.9, 1.1) * np.cos(rng.uniform(0.5, 2.0) * t),
                np.exp(0.01 * t) * np.cos(rng.uniform(0.1, 1.0) * t),
            ]
        )
        for own, numbers in zip(values, history_numbers(values), strict=True):
            assert numbers.frequency == pytest.approx(_padded_line(own), rel=1e-8)
            assert numbers.blocks == 0.0


def test_cycles_of_a_growing_wave():
    """Envelope exp(a t): a third later it is exp(a T/3) times larger; nothing else changes."""
    t, rate, period = np.arange(4001.0), 2e-4, 40.3
    (numbers,) = history_numbers([np.exp(rate * t) * np.cos(2.0 * np.pi * t / period)], EVEN)
    growth = numbers.blocks / 3.0 * numbers.spacing * 4000.0 * rate
    assert numbers.log_2 - numbers.log_1 == pytest.approx(growth, rel=0.01)  # observed 0.004
    assert numbers.log_3 - numbers.log_2 == pytest.approx(growth, rel=0.01)
    assert numbers.trend == pytest.approx(1.0, abs=1e-4)
    assert numbers.half_2 / numbers.half_1 == pytest.approx(math.exp(2000.0 * rate), rel=0.01)
    assert numbers.hidden_3 / numbers.hidden_1 == pytest.approx(math.exp(2667.0 * rate), rel=0.03)


def test_beats_explain_a_modulated_wave():
    t = np.arange(6001.0)
    wave = (1.0 + 0.3 * np.cos(2.0 * np.pi * t / 900.0)) * np.cos(2.0 * np.pi * t / 60.0)
    rng = np.random.default_rng(5)
    steps = np.repeat(rng.uniform(0.5, 1.0, 101), 60)[: len(t)]
    noisy = steps * np.cos(2.0 * np.pi * t / 60.0)
    (beating,), (irregular,) = (history_numbers([values], EVEN) for values in (wave, noisy))
    assert beating.fall == pytest.approx(1.0 - 0.7 / 1.3, abs=0.01)
    assert beat_share(wave, beating) > 0.99
    assert beat_share(noisy, irregular) < 0.5


def test_energy_line_is_that_of_two_waves():
    """Energies of 1 and 0.2 at lines 10 and 40: a tenth lies above the second, a half does not."""
    t = np.arange(512) / 512.0
    values = [np.cos(2.0 * np.pi * 10.0 * t), math.sqrt(0.2) / 4.0 * np.cos(2.0 * np.pi * 40.0 * t)]
    lines = np.fft.rfft(np.array(values))
    assert energy_line(lines, 0.1) == 40
    assert energy_line(lines, 0.5) == 10


def test_values_that_are_no_numbers_give_no_sizes():
    values = np.ones((3, 20))
    values[0, 7], values[1, 3] = math.nan, math.inf
    assert np.isnan(history_sizes(values)[0]).all()
    assert history_sizes(values)[1, :2].tolist() == [1.0, math.inf]
    assert all(math.isnan(numbers.frequency) for numbers in history_numbers(values, EVEN))


def test_bad_calls_are_refused():
    values, work, out = (
        np.ones(100),
        np.empty(kernel.gallop_history_size(100), np.uint8),
        np.ones(18),
    )
    at = [array.ctypes.data for array in (values, work, out)]
    assert kernel.gallop_history_size(0) == kernel.gallop_history_size(2**40) == 0
    assert kernel.gallop_history_numbers(100, 1, at[0], EVEN, at[1], at[2]) == 0
    assert kernel.gallop_history_numbers(100, 0, at[0], EVEN, at[1], at[2]) == 8
    assert kernel.gallop_history_numbers(100, 1, None, EVEN, at[1], at[2]) == 8
    assert kernel.gallop_history_numbers(100, 1, at[0] + 4, EVEN, at[1], at[2]) == 8
    assert kernel.gallop_history_sizes(0, 1, at[0], at[2]) == 8
    share = ctypes.c_double()  # of a history without cycles
    assert kernel.gallop_history_beats(100, at[0], at[2], at[1], ctypes.byref(share)) == 8
    assert kernel.gallop_history_energy_line(0, 1, at[0], 0.1) == -1
    flat = np.array([0.0, 0.0, 1.0, 2.0, 1.0, 0.0])  # the first half axis is the shorter one
    assert kernel.gallop_history_distances(5, at[0], at[0], flat.ctypes.data, at[2]) == 8
