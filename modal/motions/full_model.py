"""Simulations with the full model that start on a motion of the reduced model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Model, Scene
from gallop_fmu.foundation.channels import NODE_INDEX
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from modal.continuation.path import Point
from modal.foundation.scene_variation import varied
from modal.motions.line_basis import coarse
from modal.motions.span_model import SpanModel, Watched
from modal.motions.trend import MIN_WINDOWS, have_trend

Array = NDArray[np.float64]

STEPS_PER_PERIOD = 300
"""Time steps in a period of the first vertical mode: its frequency is 4e-5 too low by Newmark's
method."""

NEWTON_TOLERANCE = 1e-8
CHANNELS = np.array([NODE_INDEX[name] for name in ("u2", "u3", "theta")], dtype=np.int32)
NO_SPAN_CHANNELS = np.empty(0, dtype=np.int32)
RECORDS_PER_PERIOD = 50
BAND_PERIODS = 60
"""Periods of the first vertical mode at the end of a run, in which amplitudes are measured."""

CYCLES_PER_WINDOW = 2
"""Such periods in the window of one amplitude: two, for a swing at half the frequency."""

WINDOW = CYCLES_PER_WINDOW * RECORDS_PER_PERIOD
"""Records in such a window."""

MAX_BAND = 0.02
"""Spread of amplitudes, relative to the largest one, up to which a motion is called periodic."""

CALM = 1e-3
"""Amplitude [m] below which a span is at rest."""


class Band(NamedTuple):
    """Amplitudes (half peak-to-peak) at the end of a run.

    Attributes
    ----------
    low, high : float
        Lowest and highest amplitude in windows of `CYCLES_PER_WINDOW` periods.
    whole : float
        Amplitude over all windows.
    drift : float
        Largest difference between the highest amplitudes in each third of the windows.
    """

    low: float
    high: float
    whole: float
    drift: float


OUTCOMES = ("periodic", "beating", "irregular", "rest", "not settled", "too short")
"""Outcomes of runs that last as long as wanted."""


@dataclass(frozen=True)
class FullRun:
    """End of a run with the full model.

    Attributes
    ----------
    u2, u3, theta : Band
        Amplitudes at mid-span [m, m, rad].
    quarter : Band
        Amplitudes of the antisymmetric vertical motion at the quarter points [m].
    clamp : Band
        Amplitudes of clamps of strings across the line [m]; 0 for a span. All of them are those of
        the span or tower at which they are largest.
    outcome : str
        "rest", "periodic", "beating" (the largest amplitude is the same in each third of the
        windows), "irregular" (it differs, but amplitudes have no trend), "not settled" (they have
        one), "too short", or the reason for which the run ended early. Amplitudes are those of the
        last `BAND_PERIODS` or, if these do not repeat, of the second half of the run.
    """

    u2: Band
    u3: Band
    theta: Band
    quarter: Band
    clamp: Band
    outcome: str

    @property
    def ended_early(self) -> bool:
        """True if the run ended before its time; `outcome` is the reason."""
        return self.outcome not in OUTCOMES


def full_scene(
    scene: Scene | LineScene,
    over: str,
    value: float,
    model: SpanModel,
    steps: int = STEPS_PER_PERIOD,
    elements: int | None = None,
    tolerance: float = NEWTON_TOLERANCE,
) -> Scene | LineScene:
    """Scene of the full model in steady wind, without loads.

    Parameters
    ----------
    scene, over, value
        The span or line, and a number of it with its value.
    model
        Reduced model.
    steps
        Time steps in a period of the first vertical mode.
    elements
        Elements of a span, of which the number of the reduced model is a multiple; None: the same.
    tolerance
        Tolerance [m] of Newton's method in a time step.
    """
    wind = scene.wind.mean_speed
    if isinstance(scene, LineScene):
        scene = coarse(scene)
    steady = scene.with_values(
        {
            "wind.history": None,
            "wind.turbulence": None,
            "wind.speed": wind,
            "loads": [],
            "numerics.newton_tolerance": tolerance,
            "numerics.time_step": 2.0 * np.pi / model.frequencies[0] / steps,
        }
    )
    if isinstance(steady, Scene):
        steady = steady.with_values({"numerics.elements": elements or model.elements})
    return varied(steady, over, value)


def run_from(
    scene: Scene | LineScene, model: SpanModel, state: Array, periods: float
) -> tuple[FullRun, Array, float]:
    """Run the full model from a state of the reduced model.

    Parameters
    ----------
    scene
        From `full_scene`.
    model
        Reduced model.
    state : ndarray, shape (2 mode,)
        Coordinates and velocities.
    periods
        Duration in periods of the first vertical mode, at least `BAND_PERIODS`.

    Returns
    -------
    FullRun, ndarray, float
        The end of the run; the records (record, channel, node) at the watched nodes;
        and the time [s] between two of them.
    """
    return next(runs_from(scene, model, state, [periods]))


def runs_from(
    scene: Scene | LineScene, model: SpanModel, state: Array, durations: Sequence[float]
) -> Iterator[tuple[FullRun, Array, float]]:
    """Yield what `run_from` returns for ascending durations; a longer run continues the last one.

    A run that ended early is the last one.
    """
    full = Model(scene, inputs=False)
    nodes = (model.watched_nodes * (full.nodes - 1)) // (model.shapes.shape[1] - 1)
    steps = round(2.0 * np.pi / model.frequencies[0] / scene.numerics.time_step)
    every = steps // RECORDS_PER_PERIOD
    interval = every * scene.numerics.time_step
    n = model.size
    u, v = model.nodal(state[None, :n], state[None, n:])
    coarse = slice(None, None, (u.shape[1] - 1) // (full.nodes - 1))
    values = np.empty((0, len(CHANNELS), len(nodes)))
    try:
        started = full.place(u[0, coarse], v[0, coarse])
    except SimulationError as problem:
        yield _end(model.watched(values), str(problem.report)), values, interval
        return
    for periods in durations:
        more = round(periods * RECORDS_PER_PERIOD) - len(values)
        run = started.run(more, every, CHANNELS, nodes, NO_SPAN_CHANNELS, first=len(values))
        values = np.concatenate([values, run.node_values])
        reason = "" if run.report.outcome is Outcome.COMPLETED else str(run.report)
        yield _end(model.watched(values), reason), values, interval
        if reason:
            return


def _end(moves: Watched, reason: str) -> FullRun:
    """Amplitudes in the last windows or, if they do not repeat, in the second half."""
    records = len(moves.u2) // WINDOW
    count = min(BAND_PERIODS // CYCLES_PER_WINDOW, records)
    if reason or count == 0:
        unknown = Band(np.nan, np.nan, np.nan, np.nan)
        return FullRun(unknown, unknown, unknown, unknown, unknown, reason or "too short")
    last, late = _end_of(moves, count), max(count, records // 2)
    if last.outcome in ("rest", "periodic"):
        return last
    if last.outcome == "beating" and not _have_trend(moves, count):
        return last
    if _have_trend(moves, late):
        return replace(last, outcome="not settled")
    return _end_of(moves, late)


def _end_of(moves: Watched, count: int) -> FullRun:
    """Amplitudes in so many windows at the end."""
    sizes = [_windows(one, count) for one in moves]
    u2, u3, theta, quarter, clamp = (
        _largest_band(one, of_each) for one, of_each in zip(moves, sizes, strict=True)
    )
    bands = (u2, u3, quarter, clamp)
    largest = max(band.high for band in bands)
    is_periodic = max(band.high - band.low for band in bands) <= MAX_BAND * largest
    is_settled = max(band.drift for band in bands) <= MAX_BAND * largest
    outcome = "periodic" if is_periodic else "beating" if is_settled else "irregular"
    return FullRun(u2, u3, theta, quarter, clamp, "rest" if largest < CALM else outcome)


def _have_trend(moves: Watched, count: int) -> bool:
    """True if an amplitude changes over so many windows, or if they are too few to exclude it."""
    moving = [moves.u2, moves.u3, moves.quarter, moves.clamp]
    sizes = np.concatenate([_windows(one, count) for one in moving], axis=1)
    return count < MIN_WINDOWS or have_trend(sizes, float(sizes.max()))


def _windows(values: Array, count: int) -> Array:
    """Amplitudes (window, place) of histories (time, place) in so many windows at the end."""
    pieces = values[len(values) - count * WINDOW :].reshape(count, WINDOW, -1)
    return np.asarray(0.5 * np.ptp(pieces, axis=1))


def _largest_band(values: Array, sizes: Array) -> Band:
    """Amplitudes where they are largest, of histories (time, place); 0 if there is no place."""
    if not sizes.shape[1]:
        return Band(0.0, 0.0, 0.0, 0.0)
    place = int(np.argmax(sizes.max(axis=0)))
    history, of_each = values[len(values) - len(sizes) * WINDOW :, place], sizes[:, place]
    highest = [third.max() for third in np.array_split(of_each, 3) if len(third)]
    drift = float(np.ptp(highest))
    return Band(float(of_each.min()), float(of_each.max()), float(0.5 * np.ptp(history)), drift)


def reduction_error(scene: Scene | LineScene, model: SpanModel, point: Point) -> float:
    """Error of the reduction: how far the full model is from the orbit after one period.

    Relative to the largest displacement of the watched nodes. NaN if
    the full model cannot move so.
    """
    first = 2.0 * np.pi / model.frequencies[0]
    _, values, step = run_from(scene, model, point.states[0], np.ceil(point.period / first) + 1.0)
    if len(values) == 0:
        return float("nan")
    n = model.size
    times = step * np.arange(1, len(values) + 1)
    within = times <= point.period
    q = point.at(np.asarray(times[within] / point.period))[:, :n]
    u, _ = model.nodal(q, np.zeros_like(q))
    expected = u[:, model.watched_nodes][:, :, [1, 2]].swapaxes(1, 2)
    difference = values[within][:, :2] - expected
    return float(np.max(np.abs(difference)) / np.max(np.abs(expected - expected.mean(axis=0))))
