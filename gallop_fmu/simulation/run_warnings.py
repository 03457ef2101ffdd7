"""The warnings of a run, in one list for all outputs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.histories import energy_line, history_sizes
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Report
from gallop_fmu.scene.gusts import coherent_length, force_ratio, station_spacing
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.wind_consistency import times_of_tables
from gallop_fmu.simulation.provenance import Histories
from gallop_fmu.simulation.shedding import shedding_warnings
from gallop_fmu.simulation.steadiness import (
    MIN_RECORDS_PER_CYCLE,
    MIN_SAMPLES,
    REST_AMPLITUDE,
    default_window,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

MIN_STEPS_PER_PERIOD = 40
"""Steps in a period below which Newmark's method gets a warning; the amplitude error is then 1.4 %.

Other methods get it at the same error."""

MAX_FORCE_RATIO = 1.5
"""Spectrum of the gust force on the line over that of the coherence; the force is 22 % larger."""

MIN_GUST_SHARE = 0.8
"""Share of a gust that is left at the frequency of the motion by interpolation in time."""

MAX_MOTION = 1e100
"""Displacement [m] or velocity [m/s] above which a motion is not analysed."""

FAST_ENERGY_SHARE = 0.1
"""Share of the kinetic energy above the frequency of the fastest motion."""


def run_warnings(
    recorded: Histories, scene: Scene, report: Report, dataset: xr.Dataset | None
) -> tuple[str, ...]:
    """Return the warnings of a run, each a fact and a remedy.

    To add a kind of warning, write a function that returns a tuple of sentences and call it here.

    Parameters
    ----------
    recorded
        Recorded histories.
    scene
        The scene of the run.
    report
        Report of the kernel.
    dataset
        Dataset of the histories, if ice falls.
    """
    return (
        *scene.warnings,
        *report.warnings,
        *_step_warnings(recorded, scene),
        *(() if dataset is None else shedding_warnings(dataset, scene)),
        *not_covered(scene, float(recorded.time[-1])),
    )


def not_covered(scene: Scene | LineScene, stop_time: float) -> tuple[str, ...]:
    """Return warnings about time tables and gusts that do not cover the whole run.

    Parameters
    ----------
    scene
        The scene of the run.
    stop_time
        End of the run [s].
    """
    found = []
    for name, first, last, repeats in times_of_tables(scene):
        covered = max(0.0, min(last, stop_time) - max(first, 0.0))
        if covered >= stop_time * (1.0 - 1e-9):
            continue
        outside = f"repeats every {last - first:.6g} s" if repeats else "is constant outside"
        remedy = "a longer duration" if name == "wind.turbulence" else "a history of the whole run"
        found.append(
            f"{name} covers {covered:.6g} s of the {stop_time:.6g} s, from {first:.10g} to"
            f" {last:.10g} s of the run; it {outside}. Give {remedy}, unless this is meant."
        )
    return tuple(found)


def _step_warnings(recorded: Histories, scene: Scene) -> tuple[str, ...]:
    """Warnings about long steps and record intervals."""
    middle, time = scene.elements, recorded.time
    nodes = recorded.nodes.tolist()
    if middle not in nodes or len(time) < 2:
        return ()
    column = nodes.index(middle)
    displacements, velocities = (
        [recorded.values[name][:, column] for name in names if name in recorded.values]
        for names in (("u2", "u3"), ("v2", "v3"))
    )
    interval = float(time[1] - time[0])
    frequency_hz = fastest_motion(interval, displacements, velocities)
    return (*step_warnings(scene, frequency_hz, interval), *gust_warnings(scene, frequency_hz))


def fastest_motion(
    interval: float, displacements: Sequence[Array], velocities: Sequence[Array] = ()
) -> float:
    """Return the frequency [Hz] of the fastest mode with motion; NaN without motion.

    A tenth of the kinetic energy is above this frequency, by the spectra of the displacements at
    the end of the run (or at their maximum, if the motion has decayed by then). Velocities, if
    given, detect motion above half of the sampling frequency, which aliases in the spectra: the
    result is at least the frequency of the ratio of velocity to displacement.

    Parameters
    ----------
    interval
        Time [s] between records.
    displacements, velocities
        Histories [m, m/s] of the same points, in the same order, over the whole run.
    """
    if not displacements:
        return math.nan
    motions = np.array([*displacements, *velocities])
    moving, count = len(displacements), int(motions.shape[1])
    whole = history_sizes(motions).tolist()
    if not all(-MAX_MOTION < low and high < MAX_MOTION for low, high, *_ in whole):
        return math.nan
    length = max(2, round(default_window(interval * (count - 1)) / interval) + 1)
    if length < MIN_SAMPLES:
        return math.nan
    ranges = [high - low for low, high, *_ in whole[:moving]]
    place = ranges.index(max(ranges))
    largest, end = motions[place], count
    if np.ptp(largest[-length:]) < 0.5 * ranges[place]:
        end = min(count, int(np.argmax(np.abs(largest - whole[place][2]))) + length // 2)
    late = np.ascontiguousarray(motions[:, max(0, end - length) : end])
    sizes = history_sizes(late)
    variances = [deviation**2 for deviation in sizes[:, 3].tolist()]
    variance = sum(variances[:moving])
    if not variance > 0.5 * REST_AMPLITUDE**2:
        return math.nan
    samples = len(late[0])
    lines = np.fft.rfft((late[:moving] - sizes[:moving, 2:3]) * _hann(samples))
    found = energy_line(lines, FAST_ENERGY_SHARE) / (samples * interval)
    if len(velocities) != moving:
        return found
    ratio = sum(variances[moving:]) / variance
    return max(found, math.sqrt(ratio) / (2.0 * math.pi))


@lru_cache(maxsize=2)
def _hann(samples: int) -> Array:
    """Return Hann's window, which cannot be written."""
    window = np.hanning(samples)
    window.flags.writeable = False
    return window


def step_warnings(
    scene: Scene | LineScene, frequency_hz: float, interval: float
) -> tuple[str, ...]:
    """Return warnings about steps or records that are too far apart for a motion.

    Parameters
    ----------
    scene
        The scene of the run.
    frequency_hz
        `fastest_motion` [Hz]; NaN without motion.
    interval
        Time [s] between records.
    """
    if not frequency_hz > 0.0:
        return ()
    numerics, found = scene.numerics, []
    method, steps = INTEGRATORS[numerics.method], 1.0 / (frequency_hz * numerics.time_step)
    error = method.amplitude_error / steps**method.order
    newmark = INTEGRATORS["newmark"]
    period = (
        f"a period of {1.0 / frequency_hz:.3g} s, the fastest that carries a tenth of the recorded"
        " motion's energy"
    )
    if (
        numerics.tolerance is None
        and error > newmark.amplitude_error / MIN_STEPS_PER_PERIOD**newmark.order
    ):
        shortest = (
            method.amplitude_error / newmark.amplitude_error * MIN_STEPS_PER_PERIOD**newmark.order
        ) ** (1 / method.order)
        found.append(
            f"There are {steps:.1f} time steps in {period}; amplitudes may have an error of"
            f" {_percent_text(error)}, by the error law of examples 2 and 3. Reduce"
            f" numerics.time_step to {_round_down(1.0 / (frequency_hz * shortest)):g} s or less."
        )
    records = 1.0 / (interval * frequency_hz)
    if records < MIN_RECORDS_PER_CYCLE:
        every = max(1, int(interval / numerics.time_step * records / (2.0 * MIN_RECORDS_PER_CYCLE)))
        found.append(
            f"There are {records:.1f} records in {period}; amplitudes are wrong, and frequencies"
            f" too if there are fewer than two. Reduce run.record_every to {every}."
        )
    return tuple(found)


def gust_warnings(scene: Scene | LineScene, frequency_hz: float) -> tuple[str, ...]:
    """Return warnings about gusts that are too far apart in place or time for a motion.

    Parameters
    ----------
    scene
        The scene of the run.
    frequency_hz
        `fastest_motion` [Hz]; NaN without motion.
    """
    wind, found = scene.wind, []
    turbulence = wind.turbulence
    if turbulence is None or not wind.has_turbulence or not frequency_hz > 0.0:
        return ()
    spacing = station_spacing(turbulence, wind.mean_speed, scene.length)
    ratio = force_ratio(turbulence, spacing, wind.mean_speed, frequency_hz)
    if ratio > MAX_FORCE_RATIO:
        resolved = coherent_length(turbulence, wind.mean_speed, frequency_hz)
        found.append(
            f"wind.turbulence: gusts are {spacing:.3g} m apart and linear between, which makes"
            f" their force at {frequency_hz:.3g} Hz, the frequency of the motion,"
            f" {math.sqrt(ratio):.2g} times as large as by their coherence. Reduce"
            f" wind.turbulence.spacing to {_round_down(0.5 * resolved):g} m."
        )
    share = float(np.sinc(frequency_hz * turbulence.time_step)) ** 2
    if share < MIN_GUST_SHARE:
        found.append(
            f"wind.turbulence: gusts are {turbulence.time_step:g} s apart and linear between, which"
            f" leaves {share:.0%} of them at {frequency_hz:.3g} Hz, the frequency of the motion."
            f" Reduce wind.turbulence.time_step to {_round_down(0.1 / frequency_hz):g} s."
        )
    return tuple(found)


def _percent_text(error: float) -> str:
    return f"{100.0 * error:.2g} %" if error < 0.5 else "50 % or more"


def _round_down(value: float) -> float:
    """Round down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(digit for digit in (5.0, 2.0, 1.0) if digit * power <= value * (1.0 + 1e-9)) * power
