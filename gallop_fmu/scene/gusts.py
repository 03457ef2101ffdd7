"""Realisations of turbulence along a straight line, as tables of gusts over place and time.

Frequency by frequency, the complex amplitudes z of neighbouring stations are correlated by the
coherence r = exp(-C f d |cos psi|/|U|) of Davenport (1961). As r of a distance is the product of
those of its parts, z is a first-order autoregressive process along the line,

    z[i+1] = r exp(-2 pi i f d sin(psi)/U) z[i] + sqrt(1 - r^2) xi[i+1],

with independent complex Gaussian numbers xi of variance 1, which needs no factorisation of a
matrix. The phase is the frozen pattern that the wind carries along the line when its yaw psi from
the normal is not 0 (Taylor's hypothesis). The series of a station is the inverse Fourier transform
of z sqrt(S df/2), so it has zero mean and repeats after its duration without a jump.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.turbulence import Component, Turbulence

Values = NDArray[np.float64]

MAX_GUSTS = 20_000_000
"""Maximum number of gusts; they take 8 bytes each."""

RESOLVED_FREQUENCY = 1.0
"""Frequency [Hz] up to which the default spacing resolves the coherence.

Lines gallop below half of it, where the gust force then has an error of at most 4 %."""

MAX_DEFAULT_STATIONS = 501
"""Maximum number of stations if the spacing is not given."""

MIN_RESOLVED_SHARE = 0.9
"""Share of the variance in the gusts below which the scene gets a warning."""


class Gusts(NamedTuple):
    """Gusts over the mean speed, linear between stations and times.

    Attributes
    ----------
    stations : ndarray, shape (station,)
        x1 of each station [m]; gusts are constant beyond the ends.
    times : ndarray, shape (time,)
        Times of the run [s].
    values : ndarray, shape (time, station, component)
        Gusts along the wind, or along it, horizontally across it and upwards.
    repeat : bool
        True: the table repeats, its last row is its first. False: it is constant outside.
    """

    stations: Values
    times: Values
    values: Values
    repeat: bool


@lru_cache(maxsize=1)  # packing a model and storing a result need the same gusts
def gusts(
    turbulence: Turbulence, mean_speed: float, yaw: float, length: float, duration: float
) -> Gusts:
    """Return a realisation of turbulence along a line.

    Parameters
    ----------
    turbulence
        Its description; the seed selects the realisation.
    mean_speed
        Mean wind speed [m/s], not 0; negative from the other side.
    yaw
        Direction of the wind from the normal of the line towards +x1 [rad].
    length
        Length of the line along x1 [m].
    duration
        Duration [s] of the run, for turbulence without its own.

    Raises
    ------
    SceneError
        As of `check_size`.
    """
    check_size(turbulence, mean_speed, length, duration)
    stations = _stations(turbulence, mean_speed, length)
    frequency, count = _frequencies(turbulence, duration)
    components = turbulence.components
    distance = stations[1] - stations[0]
    decay = turbulence.decay * abs(math.cos(yaw)) / abs(mean_speed)
    coherence = np.exp(-decay * distance * frequency)
    step = coherence * np.exp(-2j * np.pi * frequency * distance * math.sin(yaw) / mean_speed)
    noise = np.sqrt(-np.expm1(-2.0 * decay * distance * frequency))  # sqrt(1 - coherence^2)
    values = np.empty((count + 1, len(stations), len(components)))
    # Independent random numbers for each component, so that one does not depend on the others.
    streams = np.random.SeedSequence(turbulence.seed).spawn(3)
    for number, component in enumerate(components):
        random = np.random.Generator(np.random.PCG64(streams[number]))
        density = turbulence.spectral_density(component, frequency, mean_speed)
        amplitude = count * np.sqrt(0.5 * density * frequency[0])
        z = np.zeros((len(stations), count // 2 + 1), dtype=np.complex128)
        now = _complex_normal(random, len(frequency))
        z[0, 1 : len(frequency) + 1] = now
        for i in range(1, len(stations)):
            now = step * now + noise * _complex_normal(random, len(frequency))
            z[i, 1 : len(frequency) + 1] = now
        z[:, 1 : len(frequency) + 1] *= amplitude
        values[:count, :, number] = np.fft.irfft(z, count, axis=1).T
    values[count] = values[0]
    values.flags.writeable = False
    times = turbulence.time_step * np.arange(count + 1, dtype=np.float64)
    return Gusts(stations, times, values, repeat=True)


def check_size(turbulence: Turbulence, mean_speed: float, length: float, duration: float) -> None:
    """Refuse gusts that are too many, or too long for the duration; parameters as of `gusts`.

    Raises
    ------
    SceneError
        The gusts would be more than `MAX_GUSTS`, or the time step is longer than a quarter of the
        duration.
    """
    _, count = _frequencies(turbulence, duration)
    stations, components = len(_stations(turbulence, mean_speed, length)), turbulence.components
    total = count * stations * len(components)
    if total > MAX_GUSTS:
        raise SceneError(
            f"wind.turbulence: {stations} stations, {count} times and {len(components)}"
            f" component{'s' * (len(components) > 1)} are {total:.3g} gusts, more than"
            f" {MAX_GUSTS:.3g}; increase spacing or time_step, or shorten duration"
        )


def _complex_normal(random: np.random.Generator, count: int) -> NDArray[np.complex128]:
    """Complex Gaussian numbers of variance 1."""
    pairs = random.standard_normal((2, count))
    return np.asarray((pairs[0] + 1j * pairs[1]) / math.sqrt(2.0))


def station_spacing(turbulence: Turbulence, mean_speed: float, length: float) -> float:
    """Distance of the stations on a line of a length [m]."""
    return length / (len(_stations(turbulence, mean_speed, length)) - 1)


def _stations(turbulence: Turbulence, mean_speed: float, length: float) -> Values:
    """Equally spaced stations, one at each end of the line."""
    spacing = turbulence.spacing
    if spacing is None:
        spacing = max(
            coherent_length(turbulence, mean_speed, RESOLVED_FREQUENCY),
            length / (MAX_DEFAULT_STATIONS - 1),
        )
    if length / spacing > MAX_GUSTS:
        raise SceneError(
            f"wind.turbulence.spacing = {spacing:g} m gives more than {MAX_GUSTS:.3g} stations on"
            f" {length:g} m; increase it"
        )
    return np.linspace(0.0, length, max(2, math.ceil(length / spacing - 1e-9) + 1))


def force_ratio(turbulence: Turbulence, spacing: float, mean_speed: float, f_hz: float) -> float:
    """Spectrum of the gust force on a long line over that of the coherence between stations.

    Between stations the gusts are linear. With k = C f d/U the sum of the correlations of stations
    is (1 + r)/(1 - r), r = exp(-k), in place of the integral 2/k: their ratio is (k/2) coth(k/2).

    Parameters
    ----------
    spacing
        Distance of the stations [m].
    f_hz
        Frequency [Hz].
    """
    half = spacing / coherent_length(turbulence, mean_speed, f_hz)
    return half / math.tanh(half)


def coherent_length(turbulence: Turbulence, mean_speed: float, frequency_hz: float) -> float:
    """Length [m] over which gusts of a frequency act together: the integral of the coherence."""
    return 2.0 * abs(mean_speed) / (turbulence.decay * frequency_hz)


def _frequencies(turbulence: Turbulence, duration: float) -> tuple[Values, int]:
    """Frequencies [Hz] of the gusts below half the sampling frequency, and the number of times."""
    length = turbulence.duration or duration
    count = math.ceil(length / turbulence.time_step - 1e-9)
    if count < 4:
        raise SceneError(
            f"wind.turbulence.time_step = {turbulence.time_step:g} s must be at most a quarter of"
            f" the duration of the gusts, {length:g} s; decrease it"
        )
    if count > MAX_GUSTS:
        raise SceneError(
            f"wind.turbulence.time_step = {turbulence.time_step:g} s gives more than"
            f" {MAX_GUSTS:.3g} times in {length:g} s; increase it"
        )
    return np.arange(1, (count - 1) // 2 + 1) / (count * turbulence.time_step), count


def resolved_share(
    turbulence: Turbulence, component: Component, mean_speed: float, duration: float
) -> float:
    """Share of the variance of a component that its gusts have at the stations and times.

    The rest is slower than the duration or faster than half the sampling frequency.
    """
    frequency, _ = _frequencies(turbulence, duration)
    density = turbulence.spectral_density(component, frequency, mean_speed)
    return float(np.sum(density) * frequency[0]) / component.intensity**2


def unresolved(turbulence: Turbulence, mean_speed: float, duration: float) -> list[str]:
    """Warnings about components with less than `MIN_RESOLVED_SHARE` of their variance."""
    found = []
    for component in turbulence.components:
        if not component.intensity:
            continue
        share = resolved_share(turbulence, component, mean_speed, duration)
        if share < MIN_RESOLVED_SHARE:
            length = turbulence.duration or duration
            found.append(
                f"wind.turbulence: the gusts {component.direction}"
                f"{' the wind' * (component.direction != 'upwards')} have {share:.0%} of the"
                f" variance of intensity {component.intensity:g}; the rest is slower than their"
                f" duration of {length:g} s or faster than twice the time_step of"
                f" {turbulence.time_step:g} s: increase duration, or decrease time_step"
            )
    return found
