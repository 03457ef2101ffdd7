"""Galloping of a square prism: the whole simulation against Parkinson and Smith's quasi-steady
theory, with the hysteresis of its amplitude over the wind speed."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from support.square_prism import (
    FORCE,
    fold_winds,
    irvine_shape,
    limit_cycles,
    onset_wind_speed,
    prism,
)

WINDOW = 20
"""Periods at the end of a run whose amplitude is measured."""


def settled(relative_wind, start):
    """Amplitude [m] at the end of a run that starts with an amplitude [m]."""
    result = gf.simulate(prism(relative_wind * onset_wind_speed(), start))
    u2 = np.ravel(result.dataset.u2.values)[-40 * WINDOW :]
    return 0.5 * float(u2.max() - u2.min())


def test_the_span_is_that_of_the_closed_form():
    (vertical,) = (
        mode
        for mode in modal.natural_modes(prism(1.0, 0.0), 3)
        if (mode.family, mode.loops) == ("vertical", 1)
    )
    omega, _ = irvine_shape()
    assert 2.0 * np.pi * vertical.frequency_hz == pytest.approx(omega, rel=3e-4)
    needed = modal.required_slope(prism(1.0, 0.0), [onset_wind_speed()]).dataset
    assert needed.slope.sel(mode=2).item() == pytest.approx(-FORCE[0], rel=3e-4)


def test_three_limit_cycles_lie_between_the_folds():
    """Of the uniform prism between 1.24 and 1.83 U0; of a half-wave in a narrower range."""
    low, high = fold_winds()
    assert (low, high) == pytest.approx((1.36, 1.71), abs=0.01)
    winds = (low - 0.01, low + 0.01, high - 0.01, high + 0.01)
    assert [len(limit_cycles(wind)) for wind in winds] == [1, 3, 3, 1]


@pytest.mark.parametrize("wind", [1.2, 2.5])
def test_outside_the_folds_there_is_one_amplitude(wind):
    (amplitude,) = limit_cycles(wind)
    assert settled(wind, amplitude) == pytest.approx(amplitude, rel=1e-3)  # observed 2e-4


@pytest.mark.parametrize("wind", [1.4, 1.65])
def test_between_the_folds_the_start_decides(wind):
    """The branch of a sweep upwards, that of a sweep downwards, and the unstable one between."""
    low, unstable, high = limit_cycles(wind)
    assert settled(wind, low) == pytest.approx(low, rel=1e-3)  # observed 1e-4
    assert settled(wind, high) == pytest.approx(high, rel=1e-3)
    assert settled(wind, 0.97 * unstable) < 0.95 * unstable
    assert settled(wind, 1.03 * unstable) > 1.05 * unstable
