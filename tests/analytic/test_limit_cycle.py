"""Harmonic balance and continuation against the limit cycle of the van der Pol oscillator."""

import numpy as np
import pytest

from modal.motions.reduced_model import Forces
from modal.screening.harmonic_balance import Balance, Orbit, doubled
from modal.screening.orbit_family import Track


class VanDerPol:
    """x'' - (U - x^2) x' + x = 0: amplitude 2 sqrt(U), frequency 1 - U^2/16; U for the wind."""

    size = 1

    def feed(self, q, wind):
        """Force of the motion, and its derivatives by displacement and wind."""
        return wind - q**2, -2.0 * q, 1.0

    def forces(self, q, v, a, wind):
        feed, by_q, by_wind = self.feed(q, wind)
        return Forces(
            a - feed * v + q,
            (1.0 - by_q * v)[:, :, None],
            -feed[:, :, None],
            np.ones((len(q), 1, 1)),
            -by_wind * v,
        )


class DyingOut(VanDerPol):
    """Driven by 0.4 U (1 - U) for U: the amplitude 2 sqrt(0.4 U (1 - U)) is zero at U = 1."""

    def feed(self, q, wind):
        return 0.4 * wind * (1.0 - wind) - q**2, -2.0 * q, 0.4 - 0.8 * wind


class Folded(VanDerPol):
    """Driven by U - 0.2 + 0.4 (x^2 - x^4)."""

    def feed(self, q, wind):
        return wind - 0.2 + 0.4 * (q**2 - q**4), 0.4 * (2.0 * q - 4.0 * q**3), 1.0


@pytest.fixture
def track():
    return Track(VanDerPol(), Balance(7, 32), mode=0, wind_scale=1.0, size_scale=2.0)


def start(size, wind, harmonics=7):
    coefficients = np.zeros((2 * harmonics + 1, 1))
    coefficients[1] = size
    return Orbit(wind, 1.0, coefficients).packed()


def amplitude(orbit):
    return np.max(np.abs(orbit.at(512)[0]))


def test_amplitude_and_frequency_of_van_der_pol(track):
    orbit, _, _ = track.at_wind(start(0.6, 0.1), 0.1)
    # the first terms of the series in mu = U (Andersen and Geer 1982)
    assert orbit.omega == pytest.approx(
        1.0 - 0.1**2 / 16.0 + 17.0 * 0.1**4 / 3072.0, rel=1e-9
    )  # observed 4e-11
    assert amplitude(orbit) == pytest.approx(2.0 * np.sqrt(0.1), rel=1e-4)  # observed 5e-5


def test_a_family_starts_at_rest_and_is_followed_over_the_parameter(track):
    first, matrix, _ = track.of_size(start(0.1, 0.01), 0.1)
    assert first.wind_speed == pytest.approx(0.0025, rel=1e-6)  # observed 1e-7
    family = list(track.follow(first, matrix, track.growing, lambda orbit: orbit.wind_speed > 0.5))
    assert len(family) > 5
    assert family[-1].wind_speed > 0.5 > family[-2].wind_speed
    for orbit in family:
        assert amplitude(orbit) == pytest.approx(
            2.0 * np.sqrt(orbit.wind_speed), rel=2e-3
        )  # observed 1.4e-3 at the end


def test_a_family_that_dies_out_passes_through_rest():
    track = Track(DyingOut(), Balance(7, 32), mode=0, wind_scale=1.0, size_scale=0.5)
    first, matrix, _ = track.of_size(start(0.1, 0.01), 0.1)
    family = list(track.follow(first, matrix, track.growing, lambda orbit: track.size(orbit) < 0.0))
    for orbit in family:
        u = orbit.wind_speed
        assert track.size(orbit) ** 2 == pytest.approx(
            1.6 * u * (1.0 - u), abs=1e-3
        )  # observed 5e-4
    assert track.size(family[-1]) < 0.0 < track.size(family[-2])
    ending = track.of_size(start(0.01, 0.99), 0.01)[0]
    assert ending.wind_speed == pytest.approx(1.0 - 0.01**2 / 1.6, rel=1e-6)  # observed 4e-9


def test_a_family_is_followed_round_a_fold():
    """Driven by U - 0.2 + 0.4 (x^2 - x^4): U = 0.2 - 0.1 r^2 + 0.05 r^4, minimum at r = 1."""
    track = Track(Folded(), Balance(7, 48), mode=0, wind_scale=1.0, size_scale=1.0)
    first, matrix, _ = track.of_size(start(0.1, 0.2), 0.1)
    family = list(track.follow(first, matrix, track.growing, lambda orbit: orbit.wind_speed > 0.3))
    winds = [orbit.wind_speed for orbit in family]
    assert np.diff(np.sign(np.diff(winds))).tolist().count(2) == 1
    for orbit in family:
        r = track.size(orbit)
        assert orbit.wind_speed == pytest.approx(
            0.2 - 0.1 * r**2 + 0.05 * r**4, abs=6e-3
        )  # observed 4.9e-3 at the end


def test_more_harmonics_do_not_change_the_motion(track):
    orbit, _, _ = track.at_wind(start(1.0, 0.3), 0.3)
    assert orbit.widened(9).at(64)[0] == pytest.approx(orbit.at(64)[0], abs=1e-15)
    assert orbit.is_resolved
    steep, _, _ = Track(VanDerPol(), Balance(3, 16), 0, 1.0, 2.0).at_wind(
        start(1.8, 0.8, harmonics=3), 0.8
    )
    assert not steep.is_resolved  # the third harmonic of van der Pol's is U/8 of the first


@pytest.mark.parametrize(("highest", "resolved"), [(0.0029, True), (0.0031, False)])
def test_the_highest_harmonic_may_be_three_thousandths(highest, resolved):
    coefficients = np.zeros((9, 1))
    coefficients[0], coefficients[1], coefficients[8] = (
        5.0,
        1.0,
        highest,
    )  # the mean state does not count
    assert Orbit(1.0, 1.0, coefficients).is_resolved == resolved


def test_the_orbit_half_way_lies_between(track):
    low, high = (track.at_wind(start(2.0 * np.sqrt(wind), wind), wind)[0] for wind in (0.2, 0.3))
    middle = track.between(low.packed(), high.packed())
    assert 0.24 < middle.wind_speed < 0.26
    assert middle.coefficients[2, 0] == pytest.approx(0.0, abs=1e-12)


def test_phase_shift_and_doubling_keep_the_motion(track):
    orbit, _, _ = track.at_wind(start(1.0, 0.3), 0.3)
    turned = orbit.shifted(2.0 * np.pi * 3 / 64)
    assert turned.at(64)[0][:-3] == pytest.approx(orbit.at(64)[0][3:], abs=1e-12)
    twice = doubled(orbit, 14)
    assert twice.omega == 0.5 * orbit.omega
    for once, again in zip(orbit.at(64), twice.at(128), strict=True):
        assert again == pytest.approx(np.concatenate([once, once]), abs=1e-12)


def test_every_oscillating_coefficient_counts_in_the_length_of_a_family(track):
    """Where a higher mode takes over, the first harmonic alone is constant."""
    count = 2 * track.balance.harmonics + 1
    assert track.measure[1:count] == pytest.approx(1.0 / track.size_scale**2)
    assert track.measure[[0, count]].tolist() == [
        0.0,
        0.0,
    ]  # the mean state and the frequency only follow
    assert track.measure[-1] == 1.0 / track.wind_scale**2


def test_guesses_ahead_are_of_second_order(track):
    """Their error is of third order in the step; that of the first step is of second order."""

    class Watched(Track):
        def near(self, guess, direction, iterations=12):
            found = super().near(guess, direction, iterations)
            errors.append(np.max(np.abs(found[0].packed() - guess)))
            return found

    watched = Watched(track.model, track.balance, track.mode, track.wind_scale, track.size_scale)
    first, matrix, _ = track.of_size(start(0.6, 0.1), 0.6)
    both = []
    for step in (0.02, 0.01):
        errors = []
        list(
            watched.follow(
                first, matrix, track.growing, lambda _: False, step=step, longest=step, most=3
            )
        )
        both.append(errors)
    assert both[0][0] / both[1][0] == pytest.approx(4.0, abs=0.3)
    assert both[0][2] / both[1][2] == pytest.approx(8.0, abs=0.8)
