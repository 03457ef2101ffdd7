"""Realisations of turbulence against their target: spectrum, coherence, phase, variance."""

import math
from functools import cache

import numpy as np
import pytest

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.gusts import (
    coherent_length,
    force_ratio,
    gusts,
    resolved_share,
    unresolved,
)
from gallop_fmu.scene.turbulence import Turbulence

SPEED, YAW, LENGTH, DURATION = 8.0, math.radians(30.0), 30.0, 256.0
REALISATIONS = 200


def turbulence(**changes):
    given = {
        "spectrum": "von_karman",
        "intensity": 0.2,
        "intensity_across": 0.15,
        "intensity_upwards": 0.1,
        "length_scale": 40.0,
        "length_scale_across": 20.0,
        "length_scale_upwards": 10.0,
        "time_step": 0.5,
        "spacing": 10.0,
    }
    return Turbulence(**{**given, **changes})


@cache
def ensemble(spectrum, speed=SPEED):
    """Fourier coefficients of realisations, shape (realisation, frequency, station, component)."""
    found = [
        gusts(turbulence(spectrum=spectrum, seed=seed), speed, YAW, LENGTH, DURATION).values[:-1]
        for seed in range(REALISATIONS)
    ]
    return np.fft.rfft(np.stack(found), axis=1)[:, 1:-1]


def frequencies():
    return np.arange(1, 256) / DURATION


@pytest.mark.parametrize("spectrum", ["von_karman", "kaimal"])
@pytest.mark.parametrize("component", range(3))
def test_spectrum_of_the_realisations_is_the_target(spectrum, component):
    """Periodograms are exponential: the mean of 200 has a relative deviation of 1/sqrt(200)."""
    z = ensemble(spectrum)[..., component]
    found = np.mean(np.abs(z) ** 2, axis=0) * 2.0 / (512**2 / DURATION)
    given = turbulence(spectrum=spectrum)
    target = given.spectral_density(given.components[component], frequencies(), SPEED)
    ratio = found / target[:, np.newaxis]
    band = 1.0 / math.sqrt(REALISATIONS)
    assert ratio.std() == pytest.approx(band, rel=0.1)  # observed: within 5 %
    # 255 frequencies at 4 stations, those of low frequency correlated.
    assert abs(ratio.mean() - 1.0) < 4.0 * band / math.sqrt(255.0)
    assert np.abs(ratio - 1.0).max() < 5.0 * band


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_cross_spectrum_has_davenport_coherence_and_the_phase_of_frozen_gusts(speed):
    z = ensemble("kaimal", speed)
    f, given = frequencies(), turbulence()
    for apart in (1, 2, 3):
        cross = np.mean(z[:, :, :-apart] * np.conj(z[:, :, apart:]), axis=0)
        power = np.mean(np.abs(z) ** 2, axis=0)
        found = cross / np.sqrt(power[:, :-apart] * power[:, apart:])
        distance = 10.0 * apart
        target = np.exp(-given.decay * f * distance * math.cos(YAW) / abs(speed))
        target = target * np.exp(2j * np.pi * f * distance * math.sin(YAW) / speed)
        error = found - target[:, np.newaxis, np.newaxis]
        # Real and imaginary part deviate by at most 1/sqrt(2 x 200) each.
        band = 1.0 / math.sqrt(2.0 * REALISATIONS)
        assert np.abs(error).max() < 5.5 * band
        assert np.abs(error.mean(axis=(1, 2)))[:5].max() < 3.0 * band
        assert np.abs(error[:5]).mean() < band  # where the coherence is high, it is found better


def test_components_are_independent():
    z = ensemble("kaimal")
    for a, b in ((0, 1), (0, 2), (1, 2)):
        cross = np.mean(z[..., a] * np.conj(z[..., b]), axis=(0, 1))
        power = np.sqrt(np.mean(np.abs(z[..., a]) ** 2, axis=(0, 1)))
        power = power * np.sqrt(np.mean(np.abs(z[..., b]) ** 2, axis=(0, 1)))
        assert np.abs(cross / power).max() < 0.1


def test_gusts_are_those_of_a_factorised_spectral_matrix():
    """The usual way (Shinozuka 1972): the Cholesky factor of the cross-spectral matrix."""
    given, f = turbulence(), frequencies()
    found = gusts(given, SPEED, YAW, LENGTH, DURATION)
    x = found.stations
    distance = x[np.newaxis, :] - x[:, np.newaxis]
    for number, component in enumerate(given.components):
        random = np.random.Generator(
            np.random.PCG64(np.random.SeedSequence(given.seed).spawn(3)[number])
        )
        noise = np.stack([random.standard_normal((2, len(f))) for _ in x])
        noise = (noise[:, 0] + 1j * noise[:, 1]) / math.sqrt(2.0)
        density = given.spectral_density(component, f, SPEED)
        series = np.zeros((512, len(x)))
        t = 0.5 * np.arange(512)
        for k, frequency in enumerate(f):
            matrix = density[k] * np.exp(
                -given.decay * frequency * np.abs(distance) * math.cos(YAW) / SPEED
                + 2j * np.pi * frequency * distance * math.sin(YAW) / SPEED
            )
            amplitude = np.linalg.cholesky(matrix) @ noise[:, k] * math.sqrt(2.0 / DURATION)
            series += np.real(np.exp(2j * np.pi * frequency * t)[:, np.newaxis] * amplitude)
        assert found.values[:-1, :, number] == pytest.approx(series, abs=1e-12)


@pytest.mark.parametrize("spectrum", ["von_karman", "kaimal"])
def test_integral_of_the_spectra_is_the_variance(spectrum):
    given = turbulence(spectrum=spectrum)
    f = np.geomspace(1e-7, 1e6, 20001)
    for component in given.components:
        density = given.spectral_density(component, f, SPEED)
        # 70.8 of von Karman is rounded: 2e-4.
        assert np.trapezoid(density, f) == pytest.approx(component.intensity**2, rel=4e-4)
        scale = component.intensity**2 * 4.0 * component.length_scale / SPEED
        assert density[0] == pytest.approx(scale, rel=1e-4)


def test_variance_is_the_resolved_share_of_the_intensity():
    given = turbulence()
    z = ensemble("von_karman")
    variance = 2.0 * np.sum(np.mean(np.abs(z) ** 2, axis=(0, 2)), axis=0) / 512.0**2
    for number, component in enumerate(given.components):
        share = resolved_share(given, component, SPEED, DURATION)
        assert share == pytest.approx([0.902, 0.902, 0.865][number], abs=1e-3)
        assert variance[number] / component.intensity**2 == pytest.approx(share, rel=0.02)
    words = unresolved(given, SPEED, DURATION)
    assert [text.split(" of the variance")[0].split()[-1] for text in words] == ["87%"]
    fine = turbulence(time_step=0.01, intensity_across=0.0, intensity_upwards=0.0)
    assert unresolved(fine, SPEED, 2000.0) == []


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
def test_gusts_are_carried_along_the_line_by_oblique_wind(speed):
    """Wind with a yaw of 90 deg reaches stations at larger x1 later, by distance over speed."""
    given = turbulence(length_scale=100.0, spacing=24.0)
    along = gusts(given, speed, math.radians(90.0), 96.0, DURATION).values[:-1, :, 0]
    for station in range(5):
        later = round(24.0 * station / speed / 0.5)
        assert along[:, station] == pytest.approx(np.roll(along[:, 0], later), abs=1e-6)


def test_gusts_repeat_without_a_jump_and_have_no_mean():
    found = gusts(turbulence(), SPEED, YAW, LENGTH, DURATION)
    assert found.repeat
    assert np.array_equal(found.values[0], found.values[-1])
    assert found.times[-1] == DURATION
    assert found.values[:-1].mean(axis=0) == pytest.approx(0.0, abs=1e-15)


def test_one_seed_gives_the_same_bits_and_each_component_is_its_own_stream():
    first, again = (gusts(turbulence(), SPEED, YAW, LENGTH, DURATION) for _ in range(2))
    assert first.values.tobytes() == again.values.tobytes()
    other = gusts(turbulence(seed=2), SPEED, YAW, LENGTH, DURATION)
    assert np.abs(first.values - other.values).max() > 0.1
    alone = turbulence(intensity_across=0.0, intensity_upwards=0.0)
    along = gusts(alone, SPEED, YAW, LENGTH, DURATION).values
    assert along.shape == (513, 4, 1)
    assert np.array_equal(along[..., 0], first.values[..., 0])
    longer = gusts(turbulence(), SPEED, YAW, 2.0 * LENGTH, DURATION).values
    assert np.array_equal(longer[:, :4], first.values)


def test_default_spacing_resolves_the_coherence_at_one_hertz():
    given = turbulence(spacing=None)
    assert coherent_length(given, SPEED, 1.0) == pytest.approx(1.6)
    assert len(gusts(given, SPEED, 0.0, LENGTH, DURATION).stations) == 20
    assert len(gusts(given, SPEED, 0.0, 1e4, 8.0).stations) == 501
    # Half of a coherent length between stations: 8 % in the spectrum, 4 % in the force.
    assert force_ratio(given, 1.6, SPEED, 0.5) == pytest.approx(1.082, abs=1e-3)


@pytest.mark.parametrize("spacing", [2.0, 10.0])
def test_force_on_a_long_line_is_that_of_the_stations(spacing):
    """Variance of the mean of a long line that is linear between correlated stations."""
    given, f_hz, count = turbulence(), 0.5, 1500
    x = spacing * np.arange(count)
    weights = np.full(count, spacing)
    correlation = np.exp(-given.decay * f_hz * np.abs(x[:, None] - x) / SPEED)
    found = weights @ correlation @ weights / (spacing * count)
    exact = coherent_length(given, SPEED, f_hz)
    assert found / exact == pytest.approx(force_ratio(given, spacing, SPEED, f_hz), rel=3e-3)


def test_gusts_that_are_too_many_are_refused():
    with pytest.raises(SceneError, match=r"are 3\.07e\+08 gusts, more than 2e\+07; increase"):
        gusts(turbulence(spacing=1e-3, time_step=0.1), SPEED, 0.0, 100.0, 102.4)
