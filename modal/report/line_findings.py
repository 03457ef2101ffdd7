"""Findings of a report on a line. A part that cannot be computed is kept as the reason."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gallop_fmu import LineScene, Outcome, SimulationError, simulate
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.run_options import check_stop_time
from modal.linear.line_modes import LineMode
from modal.linear.modes import natural_modes
from modal.report.findings import MAX_RECORDS, Missing, Parts, Progress
from modal.screening.line_screen import LineScreening
from modal.screening.screen import MAX_WIND_RATIO, screen
from modal.stability.critical_wind import (
    DEFAULT_HIGHEST_WIND,
    CriticalWind,
    critical_wind_speed,
)
from modal.stability.line_criteria import SpanCriteria, line_criteria
from modal.stability.mode_pairs import ModePair, mode_pairs

MODE_COUNT = 24
"""Number of modes in a report, as many as pairs of modes are searched in."""

MIN_CRITICAL_COUNT = 6
"""Least number of modes with a critical wind; all up to the lowest vertical mode have one."""

MAX_VALUES = 2_000_000
"""Values of a channel (records times nodes) above which only every second, ... record is kept."""

CHANNELS = ("u1", "u2", "u3", "theta", "tension")
"""Recorded channels."""


@dataclass(frozen=True)
class LineFindings:
    """Content of a report on a line; parts that could not be computed are `Missing`.

    Attributes
    ----------
    scene : LineScene
        The line.
    modes : list of LineMode
        Lowest natural modes in still air.
    pairs : list of ModePair
        Pairs of modes near 2:1 and 1:1.
    onsets : list of CriticalWind
        Critical wind speed of the lowest modes.
    criteria : list of SpanCriteria
        Den Hartog's, Nigol's and the coupled criterion of each span.
    screening : LineScreening
        Motions that begin, what galloping starts, and the stable states in the line's wind.
    result : LineResult
        The simulation; it may have ended early.
    seconds : dict of str to float
        Computing time [s] of each part.
    """

    scene: LineScene
    modes: list[LineMode] | Missing
    pairs: list[ModePair] | Missing
    onsets: list[CriticalWind] | Missing
    criteria: list[SpanCriteria] | Missing
    screening: LineScreening | Missing
    result: LineResult | Missing
    seconds: dict[str, float]

    @property
    def completed(self) -> bool:
        """True if the simulation ran to its end."""
        return isinstance(self.result, LineResult) and self.result.outcome is Outcome.COMPLETED


def examine_line(
    scene: LineScene,
    stop_time: float | None = None,
    progress: Progress | None = None,
    highest_wind: float = DEFAULT_HIGHEST_WIND,
) -> LineFindings:
    """Compute the content of a report on a line.

    Parameters
    ----------
    scene, stop_time, progress
        As for `modal.write_report`.
    highest_wind
        End of the search for critical winds [m/s]; the screening ends at 1.5 times the line's wind.

    Raises
    ------
    SceneError
        If `stop_time` is not allowed. Other errors are `Missing` parts of the findings.
    """
    stop_time = scene.run.stop_time if stop_time is None else stop_time
    check_stop_time(stop_time)
    parts = Parts(scene, progress or (lambda name, share: None))
    modes = parts.compute("modes", lambda: _modes(scene))
    count = _critical_count(modes)
    return LineFindings(
        scene=scene,
        modes=modes,
        pairs=parts.compute("pairs of modes", lambda: mode_pairs(scene)),
        criteria=parts.compute("critical winds", lambda: line_criteria(scene)),
        onsets=parts.compute(
            "critical winds", lambda: critical_wind_speed(scene, count, highest_wind)
        ),
        screening=parts.compute_in_wind("screening", lambda: _screened(scene, highest_wind)),
        result=parts.compute("simulation", lambda: _simulate(scene, stop_time, parts.progress)),
        seconds=parts.seconds,
    )


def _modes(scene: LineScene) -> list[LineMode]:
    """Lowest modes of a line."""
    return natural_modes(scene, MODE_COUNT)


def _screened(scene: LineScene, highest_wind: float) -> LineScreening:
    """Screen the line up to 1.5 times its wind, or to the highest wind if that is lower."""
    wind = scene.wind.mean_speed
    return screen(scene, max(wind, min(highest_wind, MAX_WIND_RATIO * wind)))


def _critical_count(modes: list[LineMode] | Missing) -> int:
    """Number of modes up to the lowest vertical one."""
    found = [] if isinstance(modes, Missing) else modes
    numbers = [k for k, mode in enumerate(found, start=1) if mode.family == "vertical"]
    return max(MIN_CRITICAL_COUNT, min(numbers, default=0))


def _simulate(scene: LineScene, stop_time: float, progress: Progress) -> LineResult:
    """Run the simulation, with all nodes and as many records as memory allows.

    Raises
    ------
    SimulationError
        If it cannot start.
    """
    spans = range(1, len(scene.section.spans) + 1)
    conductors = len(scene.phases) * scene.bundle.subconductors
    nodes = conductors * sum(2 * scene.elements_of_span(span) + 1 for span in spans)
    records = stop_time / (scene.numerics.time_step * scene.run.record_every)
    result = simulate(
        scene,
        stop_time,
        record_every=scene.run.record_every
        * max(1, math.ceil(records / min(MAX_RECORDS, MAX_VALUES / nodes))),
        record_nodes="all",
        channels=CHANNELS,
        progress=lambda time, stop: progress("simulation", time / stop),
        on_failure="return",
    )
    if not result.started:
        raise SimulationError(result.report, result)
    return result
