"""Harmonic balance and continuation against the van der Pol oscillator, whose limit cycle is known."""

import numpy as np
import pytest

from modal.limit_cycle import Balance, Orbit, Track, doubled
from modal.reduced import Forces


class VanDerPol:
    """x'' - (U - x^2) x' + x = 0: amplitude 2 sqrt(U), frequency 1 - U^2/16, with U in the place of the wind."""

    size = 1

    def forces(self, q, v, a, wind):
        return Forces(
            a - (wind - q**2) * v + q,
            (1.0 + 2.0 * q * v)[:, :, None],
            (q**2 - wind)[:, :, None],
            np.ones((len(q), 1, 1)),
            -v,
        )


@pytest.fixture
def track():
    return Track(VanDerPol(), Balance(7, 32), mode=0, wind_scale=1.0, size_scale=2.0)


def start(size, wind):
    coefficients = np.zeros((15, 1))
    coefficients[1] = size
    return Orbit(wind, 1.0, coefficients).packed()


def amplitude(orbit):
    return np.max(np.abs(orbit.at(512)[0]))


def test_amplitude_and_frequency_of_van_der_pol(track):
    orbit, _, _ = track.at_wind(start(0.6, 0.1), 0.1)
    # the first terms of the series in mu = U (Andersen and Geer 1982)
    assert orbit.omega == pytest.approx(1.0 - 0.1**2 / 16.0 + 17.0 * 0.1**4 / 3072.0, rel=1e-9)  # observed 4e-11
    assert amplitude(orbit) == pytest.approx(2.0 * np.sqrt(0.1), rel=1e-4)  # observed 5e-5


def test_a_family_starts_at_rest_and_is_followed_over_the_parameter(track):
    first, matrix, _ = track.of_size(start(0.1, 0.01), 0.1)
    assert first.wind_speed == pytest.approx(0.0025, rel=1e-6)  # observed 1e-7
    family = list(track.follow(first, matrix, lambda orbit: orbit.wind_speed > 0.5))
    assert len(family) > 5
    assert family[-1].wind_speed > 0.5 > family[-2].wind_speed
    for orbit in family:
        assert amplitude(orbit) == pytest.approx(
            2.0 * np.sqrt(orbit.wind_speed), rel=2e-3
        )  # observed 1.4e-3 at the end


def test_the_orbit_half_way_lies_between(track):
    low, high = (track.at_wind(start(2.0 * np.sqrt(wind), wind), wind)[0] for wind in (0.2, 0.3))
    middle = track.between(low.packed(), high.packed())
    assert 0.24 < middle.wind_speed < 0.26
    assert middle.coefficients[2, 0] == pytest.approx(0.0, abs=1e-12)


def test_turning_and_doubling_keep_the_motion(track):
    orbit, _, _ = track.at_wind(start(1.0, 0.3), 0.3)
    turned = orbit.turned(2.0 * np.pi * 3 / 64)
    assert turned.at(64)[0][:-3] == pytest.approx(orbit.at(64)[0][3:], abs=1e-12)
    twice = doubled(orbit, 14)
    assert twice.omega == 0.5 * orbit.omega
    for once, again in zip(orbit.at(64), twice.at(128), strict=True):
        assert again == pytest.approx(np.concatenate([once, once]), abs=1e-12)
