"""Probabilities and amplitudes of an atlas against a distribution in closed form."""

import numpy as np
import pytest
from scipy import stats

import modal
from tests.support.cubic_galloping import Cubic, scene

WIND = stats.weibull_min(2.0, scale=6.0)
EVENTS = 3.0


@pytest.mark.parametrize("cubic", [6.0, 60.0])
def test_the_estimate_finds_small_and_large_cycles(cubic):
    """Observed 1e-3, and 1e-2 at 1.05 times the critical speed, where it is a few centimetres."""
    exact = Cubic(cubic)
    for speed in (0.99, 1.05, 1.5, 2.5, 4.0) * np.array(exact.begins_at):
        found = modal.two_mode_estimate(scene(cubic, speed)).vertical_amplitude
        assert found == pytest.approx(exact.amplitude(speed), rel=0.012)


@pytest.fixture(scope="module")
def atlas():
    random = {"wind.speed": {"distribution": "weibull_min", "c": 2.0, "scale": 6.0}}
    return modal.risk_atlas(
        scene(), random, draws=128, events_per_winter=EVENTS, clearance=1.0, workers=1
    )


def test_probabilities_are_those_of_the_distribution(atlas):
    exact, data = Cubic(), atlas.dataset.isel(span=0)
    clashes_from = exact_speed(exact, 0.5)
    for name, speed in (("galloping", exact.begins_at), ("clash", clashes_from)):
        true = WIND.sf(speed)
        assert data[f"{name}_lowest"] <= true <= data[f"{name}_highest"]
        assert data[name].item() == pytest.approx(true, abs=0.02)  # observed 0.002 to 0.008
        assert data[f"{name}_highest"] - data[f"{name}_lowest"] < 0.06
        of_winter = 1.0 - np.exp(-EVENTS * data[name].item())
        assert data[f"winter_{name}"].item() == pytest.approx(of_winter, rel=1e-12)
    assert data.unresolved == 0.0


def test_amplitudes_are_those_of_the_distribution(atlas):
    exact, data = Cubic(), atlas.dataset.isel(span=0)
    known = data.amplitude.dropna("return_period")
    assert known.return_period.values.tolist() == [2.0]  # 128 draws, 10 of them beyond
    for period in known.return_period.values:
        true = exact.amplitude(WIND.isf(1.0 / (EVENTS * period)))
        found = data.sel(return_period=period)
        assert found.amplitude_lowest <= true <= found.amplitude_highest
        # observed 0.042 m: 128 draws, of which the interval allows 0.1 m
        assert found.amplitude.item() == pytest.approx(true, abs=0.05)


def test_the_interval_narrows_with_more_draws(atlas):
    data = atlas.dataset.isel(span=0)
    width = data.galloping_of_draws_highest - data.galloping_of_draws_lowest
    assert data.draws.values.tolist() == [16, 32, 64, 128]
    assert width.values[-1] < 0.4 * width.values[0]
    assert data.galloping_of_draws.values[-1] == data.galloping


def exact_speed(exact, amplitude):
    speeds = np.linspace(exact.begins_at, 40.0, 400)
    return np.interp(amplitude, [exact.amplitude(speed) for speed in speeds], speeds)
