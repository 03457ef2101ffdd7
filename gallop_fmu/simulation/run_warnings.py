"""The warnings of a run: everything that limits the trust in its numbers, in one list that every printer uses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Report
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.time_functions import TimeTable
from gallop_fmu.simulation.steadiness import FEWEST_RECORDS, FEWEST_SAMPLES, SMALL, default_window

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

FEWEST_STEPS = 40
"""Steps in a period below which Newmark's method, whose amplitudes are then off by up to 1.4 %, gets a warning; other
methods get it at the same error."""

HUGE = 1e100
"""Displacement [m] or velocity [m/s] that nothing is found out about."""

CARRIED = 0.1
"""Share of the kinetic energy above the frequency of the fastest motion that counts."""


def run_warnings(dataset: xr.Dataset, scene: Scene, report: Report) -> tuple[str, ...]:
    """Sentences, each with a fact and its remedy; empty if there is nothing to warn of.

    To add a kind of warning, write a function that returns a tuple of sentences and call it here.

    Parameters
    ----------
    dataset
        Recorded histories.
    scene
        What was computed.
    report
        How the run ended.
    """
    return (
        *scene.warnings,
        *report.warnings,
        *_step_warnings(dataset, scene),
        *_not_covered(scene, float(dataset.time[-1])),
    )


def _not_covered(scene: Scene, stop_time: float) -> tuple[str, ...]:
    """Histories of the scene that end before the run, or begin after its start."""
    laws = {"wind.history": scene.wind.history}
    laws |= {f"loads.{number}.law": load.law for number, load in enumerate(scene.loads)}
    for end in ("left", "right"):
        motion = getattr(scene.supports, end).motion
        if motion is not None:
            laws |= {
                f"supports.{end}.motion.{axis}": getattr(motion, axis)
                for axis in ("x1", "x2", "x3")
            }
    found = []
    for name, law in laws.items():
        if not isinstance(law, TimeTable):
            continue
        covered = max(0.0, min(law.time[-1], stop_time) - max(law.time[0], 0.0))
        if covered < stop_time * (1.0 - 1e-9):
            found.append(
                f"{name} covers {covered:.6g} s of the {stop_time:.6g} s, from {law.time[0]:.10g}"
                f" to {law.time[-1]:.10g} s; its first and last values are held outside. Give a"
                " history of the whole run, with times in seconds from its start."
            )
    return tuple(found)


def _step_warnings(dataset: xr.Dataset, scene: Scene) -> tuple[str, ...]:
    """Warnings on the distance of steps and records."""
    middle, time = scene.numerics.elements, dataset.time.values
    nodes = dataset.node.values.tolist()
    if middle not in nodes or len(time) < 2:
        return ()
    at = nodes.index(middle)
    place, rate = (
        [dataset[name].values[:, at] for name in names if name in dataset]
        for names in (("u2", "u3"), ("v2", "v3"))
    )
    interval = float(time[1] - time[0])
    return step_warnings(scene, fastest_motion(interval, place, rate), interval)


def fastest_motion(
    interval: float, displacements: Sequence[Array], velocities: Sequence[Array] = ()
) -> float:
    """Frequency [Hz] of the highest mode that carries motion; NaN where nothing moves.

    It is the frequency above which a tenth of the kinetic energy lies, from the spectra of the
    displacements at the end of the run, or where they are largest if they have died out by then.
    Velocities, if there are any, show what lies above half of the sampling frequency, where the
    spectra are another motion's: the frequency is at least the one that the ratio of velocity to
    displacement tells.

    Parameters
    ----------
    interval
        Time [s] between records.
    displacements, velocities
        Histories [m, m/s] of the same points, in the same order, over the whole run.
    """
    if not displacements or not all(
        np.abs(values).max() < HUGE for values in (*displacements, *velocities)
    ):
        return math.nan
    count = len(displacements[0])
    length = max(2, round(default_window(interval * (count - 1)) / interval) + 1)
    if length < FEWEST_SAMPLES:
        return math.nan
    ranges = [float(np.ptp(values)) for values in displacements]
    largest = displacements[int(np.argmax(ranges))]
    end = count
    if np.ptp(largest[-length:]) < 0.5 * max(ranges):
        end = min(count, int(np.argmax(np.abs(largest - np.mean(largest)))) + length // 2)
    part = slice(max(0, end - length), end)
    motions = [values[part] - np.mean(values[part]) for values in displacements]
    variance = sum(float(np.var(motion)) for motion in motions)
    if not variance > 0.5 * SMALL**2:
        return math.nan
    frequency = np.fft.rfftfreq(len(motions[0]), interval)
    energy = (
        sum(np.abs(np.fft.rfft(motion * np.hanning(len(motion)))) ** 2 for motion in motions)
        * frequency**2
    )
    above = np.cumsum(energy[::-1])[::-1]
    found = float(frequency[np.flatnonzero(above >= CARRIED * above[0])[-1]])
    if len(velocities) != len(displacements):
        return found
    ratio = sum(float(np.var(values[part])) for values in velocities) / variance
    return max(found, math.sqrt(ratio) / (2.0 * math.pi))


def step_warnings(scene: Scene, frequency_hz: float, interval: float) -> tuple[str, ...]:
    """Warnings where steps or records are too far apart for a motion.

    Parameters
    ----------
    scene
        What was computed.
    frequency_hz
        Frequency [Hz] of the fastest motion that counts; NaN where nothing moves.
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
    if numerics.tolerance is None and error > newmark.amplitude_error / FEWEST_STEPS**newmark.order:
        shortest = (
            method.amplitude_error / newmark.amplitude_error * FEWEST_STEPS**newmark.order
        ) ** (1 / method.order)
        found.append(
            f"There are {steps:.1f} time steps in {period}; by the error law of examples 2 "
            f"and 3 amplitudes may be off by {_percent_text(error)}. Reduce numerics.time_step to "
            f"{_below(1.0 / (frequency_hz * shortest)):g} s or less."
        )
    records = 1.0 / (interval * frequency_hz)
    if records < FEWEST_RECORDS:
        every = max(1, int(interval / numerics.time_step * records / (2.0 * FEWEST_RECORDS)))
        found.append(
            f"There are {records:.1f} records in {period}; amplitudes, and below two the"
            f" frequencies, are not those of the motion. Reduce run.record_every to {every}."
        )
    return tuple(found)


def _percent_text(error: float) -> str:
    return f"{100.0 * error:.2g} %" if error < 0.5 else "50 % and more"


def _below(value: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above the value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(digit for digit in (5.0, 2.0, 1.0) if digit * power <= value * (1.0 + 1e-9)) * power
