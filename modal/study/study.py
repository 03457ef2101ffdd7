"""Study of a line: cases over wind, attack angle, ice and curve, the worst case, and measures."""

from __future__ import annotations

import itertools
import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, SceneError, SimulationError
from gallop_fmu.foundation.notebook_table import notebook_table
from gallop_fmu.foundation.text_rules import counted
from gallop_fmu.input.scene_like import LineLike, as_line
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.run_options import check_stop_time
from modal.foundation.alike_phases import one_phase
from modal.foundation.one_thread import one_thread
from modal.linear.line_modes import LineMode
from modal.linear.modes import natural_modes
from modal.motions.branches import Branches
from modal.report.findings import Missing, Parts, Progress
from modal.report.line_findings import LineFindings, examine_line
from modal.stability.critical_wind import den_hartog_speed
from modal.study.cases import Case, CasesStoppedError, Variant, run_cases
from modal.study.conditions import (
    Climate,
    StudyConditions,
    StudyLimits,
    steady_wind,
)
from modal.study.gaps import ellipse_gaps
from modal.study.governing_span import branches_of_span
from modal.study.measures import Measure, applicable, measures
from modal.study.push import pushed

Array = NDArray[np.float64]

Point = tuple[float, float]
"""Wind speed [m/s] and attack angle [deg]."""

LINEAR_MODES = 24
"""Modes among which the lowest critical wind is looked for."""


@dataclass(frozen=True)
class Tried:
    """A measure and the cases in which it was simulated; without cases it was not possible."""

    measure: Measure
    cases: list[Case]

    @property
    def largest(self) -> float:
        """Largest motion, peak to peak [m]; NaN without a result."""
        return largest_of(self.cases)

    @property
    def galloping(self) -> int:
        """Number of cases in which a span gallops."""
        return sum(case.gallops for case in self.cases)


@dataclass(frozen=True)
class DenHartog:
    """Critical wind [m/s] by Den Hartog's formula at one condition; None: no galloping by it."""

    ice: str
    curve: str
    angle_deg: float
    wind: float | None


@dataclass(frozen=True, repr=False)
class LineStudy:
    """Content of the report of a study.

    Attributes
    ----------
    scene : LineScene
        The line as given.
    conditions : StudyConditions
        What was varied.
    angles_deg : tuple of float
        Attack angles [deg] that were simulated.
    cases : list of Case
        All cases.
    worst : Case or None
        The case with the largest motion; None if no case has a result.
    unequal : Case or None
        The worst case once more, started by a push that is unlike on all spans and phases; None if
        it was not simulated. All other runs start alike on all spans.
    findings : LineFindings or Missing
        Examination of the worst case: modes, resonant pairs, critical winds, simulation.
    branches : Branches or Missing
        All motions over the wind of the span that moves most in the worst case, taken alone.
    criteria : list of DenHartog or Missing
        Critical wind by Den Hartog's formula at each ice, curve and angle.
    ellipse_gaps : dict
        Gap of the ellipses of two phases by rule and span, for the ice of the worst case.
    before : list of Case
        The cases with which measures are compared: with the worst ice and curve, in all winds at
        the worst attack angle, and at all attack angles in the worst wind.
    tried : list of Tried
        Measures, the most effective first.
    limits : StudyLimits
        Design values with which forces and gaps are compared.
    warnings : tuple of str
        Warnings about the line with each ice and curve, each once.
    curve_sources : tuple of str
        Sources of the coefficient curves.
    is_single : bool
        True if one phase was simulated for all.
    seconds : float
        Computing time [s].
    stopped : str
        What is missing, in a sentence, if the study was stopped; else empty.
    """

    scene: LineScene
    conditions: StudyConditions
    angles_deg: tuple[float, ...]
    cases: list[Case]
    worst: Case | None
    unequal: Case | None
    findings: LineFindings | Missing
    branches: Branches | Missing
    criteria: list[DenHartog] | Missing
    ellipse_gaps: dict[str, dict[int, float]]
    before: list[Case]
    tried: list[Tried]
    limits: StudyLimits
    warnings: tuple[str, ...]
    curve_sources: tuple[str, ...]
    is_single: bool
    seconds: float
    stopped: str = ""

    def __repr__(self) -> str:
        cases, measures = counted(len(self.cases), "case"), counted(len(self.tried), "measure")
        text = (
            f"LineStudy of {self.scene.title!r}: {cases}, {len(self.galloping)} gallop; {measures}"
        )
        if self.worst is None:
            return f"{text}; no case has a result"
        return (
            f"{text}; largest motion {self.worst.largest:.2f} m peak to peak in span"
            f" {self.worst.largest_span}, wind {self.worst.wind:g} m/s, {self.worst.ice}"
        )

    def _repr_html_(self) -> str:
        """Table of the cases for notebooks."""
        return notebook_table(
            repr(self),
            ("ice", "curve", "angle [deg]", "wind [m/s]", "motion", "peak to peak [m]"),
            [
                (
                    case.ice,
                    case.curve or "-",
                    f"{case.angle_deg:g}",
                    f"{case.wind:g}",
                    case.kind,
                    f"{case.largest:.2f}" if case.has_result else "-",
                )
                for case in self.cases
            ],
            self.warnings,
        )

    @property
    def known(self) -> list[Case]:
        """Cases with a motion."""
        return [case for case in self.cases if case.has_result]

    @property
    def galloping(self) -> list[Case]:
        """Cases in which a span gallops."""
        return [case for case in self.known if case.gallops]


def largest_of(cases: Sequence[Case]) -> float:
    """Largest motion of some cases, peak to peak [m]; NaN without a result."""
    known = [case.largest for case in cases if case.largest == case.largest]
    return max(known, default=math.nan)


INSTEAD = "write it as a section of one span, or use gallop-modal report for this span"
"""What to do with a scene of one span, as an imperative."""


class StudyStoppedError(RuntimeError):
    """A study that was stopped; ``result`` is the study of what was computed until then."""

    def __init__(self, message: str, result: LineStudy) -> None:
        super().__init__(message)
        self.result = result


@one_thread
def study_line(
    scene: LineLike,
    conditions: StudyConditions | None = None,
    *,
    stop_time: float | None = None,
    limits: StudyLimits | None = None,
    out: Path | str | None = None,
    workers: int | None = None,
    folder: Path | str = ".",
    progress: Progress | None = None,
) -> LineStudy:
    """Simulate a line over wind, attack angle, ice and curve, and try measures at the worst.

    Parameters
    ----------
    scene
        The line. Its wind is replaced by constant winds.
    conditions
        What to vary (default: winds from 4 to 12 m/s, the rest as in the scene).
    stop_time
        Simulated time [s] of each case (default: from the scene).
    limits
        Design values with which forces and gaps are compared.
    out
        Folder that keeps the runs, made if it does not exist. The same call computes only what is
        missing.
    workers
        Number of threads (default: one for each core).
    folder
        Folder of relative names of curves.
    progress
        Called with the name of the current part and the share of it that is done.

    Raises
    ------
    SceneError
        An argument is not allowed, or the line has no coefficient curve.
    StudyStoppedError
        Stopped with Ctrl-C, or `out` cannot be written; ``result`` has what was computed.
    """
    scene = as_line(scene, "a study", INSTEAD)
    limits = limits or StudyLimits()
    stop_time = check_stop_time(scene.run.stop_time if stop_time is None else stop_time)
    shown = progress or (lambda name, share: None)
    offsets = [phase.offset for phase in scene.phases]

    def run(variants: Sequence[Variant], points: Sequence[Point], name: str) -> list[Case]:
        return run_cases(
            variants,
            points,
            offsets=offsets,
            folder=None if out is None else Path(out),
            stop_time=stop_time,
            workers=workers,
            progress=lambda done, failed, count: shown(name, done / count),
        )

    work = _Work(scene, conditions or StudyConditions(), Path(folder), run)
    try:
        work.simulate()
        work.start_unequally()
        work.examine(stop_time, shown)
        work.improve()
    except CasesStoppedError as problem:
        work.stopped = f"{work.stopped} {problem}".strip()
    except KeyboardInterrupt:
        work.stopped = "stopped on request."
    found = work.study(limits)
    if work.stopped:
        raise StudyStoppedError(work.stopped, found)
    return found


RunCases = Callable[[Sequence[Variant], Sequence[Point], str], list[Case]]
"""Function from lines, winds with angles, and the name of the part to the cases."""

NO_WORST = "no case has a result, so there is no worst case."

NOT_REACHED = Missing("The study was stopped before this part.")


class _Work:
    """The parts of a study in the order in which they are computed.

    Parameters
    ----------
    scene, conditions
        As given.
    folder
        Folder of relative names of curves.
    run
        Simulates cases.
    """

    def __init__(
        self, scene: LineScene, conditions: StudyConditions, folder: Path, run: RunCases
    ) -> None:
        self.started = clock.perf_counter()
        self.scene, self.conditions, self.run = scene, conditions, run
        self.whole = steady_wind(scene)
        self.reduced = one_phase(self.whole)
        self.climates = list(conditions.climates(self.reduced, folder))
        self.angles = conditions.angles(scene)
        self.cases: list[Case] = []
        self.tried: list[Tried] = []
        self.unequal: Case | None = None
        self.findings: LineFindings | Missing = NOT_REACHED
        self.branches: Branches | Missing = NOT_REACHED
        self.criteria: list[DenHartog] | Missing = NOT_REACHED
        self.stopped = ""

    @property
    def worst(self) -> Case | None:
        """The case with the largest motion so far; None without a result."""
        known = [case for case in self.cases if math.isfinite(case.largest)]
        return max(known, key=lambda case: case.largest, default=None)

    def simulate(self) -> None:
        """Simulate all cases.

        Raises
        ------
        CasesStoppedError
            Stopped; the finished cases are kept.
        """
        variants = [Variant(each.scene, each.ice_text, each.curve_text) for each in self.climates]
        points = list(itertools.product(self.conditions.winds, self.angles))
        try:
            self.cases = self.run(variants, points, "cases")
        except CasesStoppedError as problem:
            self.cases = problem.cases
            self.stopped = (
                f"Only {len(problem.cases)} of {problem.total} cases were simulated, and no measure"
                " was tried: the worst case may be missing."
            )
            raise

    def start_unequally(self) -> None:
        """Simulate the worst case from a push that is unlike on all spans and phases.

        Raises
        ------
        CasesStoppedError
            Stopped.
        """
        worst = self.worst
        if worst is None:
            return
        line = pushed(self._climate_of(worst).scene)
        point = (worst.wind, worst.angle_deg)
        self.stopped = "The worst case was not started unequally, and no measure was tried."
        (self.unequal,) = self.run([Variant(line, worst.ice, worst.curve)], [point], "other start")
        self.stopped = ""

    def examine(self, stop_time: float, shown: Progress) -> None:
        """Compute critical winds at all conditions, and examine the worst case."""
        parts = Parts(self.scene, shown)
        self.criteria = parts.compute(
            "critical winds", lambda: _criteria(self.climates, self.angles)
        )
        worst = self.worst
        if worst is None:
            self.findings = self.branches = Missing(NO_WORST)
            return
        scene = self._climate_of(worst).at(worst.wind, worst.angle_deg)
        highest = max(map(abs, self.conditions.winds))
        self.findings = examine_line(scene, stop_time, shown, highest)
        result = self.findings.result if isinstance(self.findings, LineFindings) else None
        if not isinstance(result, LineResult):
            self.branches = Missing("The worst case was not simulated again.")
            return
        self.branches = parts.compute(
            "motions of one span",
            lambda: branches_of_span(result, worst.largest_span, self.conditions.winds),
        )

    def improve(self) -> None:
        """Try measures with the ice and curve of the worst case.

        Raises
        ------
        CasesStoppedError
            Stopped; measures of which all cases were simulated are kept.
        """
        worst = self.worst
        if worst is None or not worst.gallops:
            return
        points = [(case.wind, case.angle_deg) for case in _around(worst, self.cases)]
        found = _measures(self._climate_of(worst), self.whole, worst)
        variants = [Variant(one_phase(scene), each.name, "") for each, scene in applicable(found)]
        cases: list[Case] = []
        try:
            for alike in _of_equal_phases(variants):
                cases += self.run(alike, points, "measures")
        except CasesStoppedError as problem:
            cases += problem.cases
            self.stopped = "Not all measures were tried."
            raise
        finally:
            self.tried = _tried(found, cases, len(points))

    def study(self, limits: StudyLimits) -> LineStudy:
        """Return what was computed."""
        worst = self.worst
        sags = () if worst is None else worst.sag
        return LineStudy(
            scene=self.scene,
            conditions=self.conditions,
            angles_deg=self.angles,
            cases=self.cases,
            worst=worst,
            unequal=self.unequal,
            findings=self.findings,
            branches=self.branches,
            criteria=self.criteria,
            ellipse_gaps=ellipse_gaps(
                {k: float(sag) for k, sag in enumerate(sags, start=1)},
                self.scene.conductor.diameter,
                [phase.offset for phase in self.scene.phases],
            ),
            before=[] if worst is None else _around(worst, self.cases),
            tried=self.tried,
            limits=limits,
            warnings=_warnings_of(self.climates),
            curve_sources=tuple(dict.fromkeys(each.source for each in self.climates)),
            is_single=len(self.reduced.phases) < len(self.scene.phases),
            seconds=clock.perf_counter() - self.started,
            stopped=self.stopped,
        )

    def _climate_of(self, case: Case) -> Climate:
        """The line with the ice and curve of a case."""
        named = case.ice, case.curve
        return next(each for each in self.climates if (each.ice_text, each.curve_text) == named)


def _warnings_of(climates: Sequence[Climate]) -> tuple[str, ...]:
    """Warnings about the line with each ice and curve, each once."""
    return tuple(dict.fromkeys(text for each in climates for text in each.scene.warnings))


def _around(worst: Case, cases: Sequence[Case]) -> list[Case]:
    """The cases with the ice and curve of the worst one, and its wind or its attack angle."""
    return [
        case
        for case in cases
        if (case.ice, case.curve) == (worst.ice, worst.curve)
        and (case.wind == worst.wind or case.angle_deg == worst.angle_deg)
    ]


def _measures(climate: Climate, whole: LineScene, worst: Case) -> list[Measure]:
    """Measures for all phases of the line as given, with ice and curve of the worst case."""
    phased = climate.scene
    if len(whole.phases) > len(phased.phases):
        phased = phased.with_values({"phases": [phase.model_dump() for phase in whole.phases]})
    gallops = worst.peak_to_peak >= 0.5 * worst.largest
    return measures(phased, np.where(gallops, worst.frequency_hz, np.nan))


def _of_equal_phases(variants: Sequence[Variant]) -> list[list[Variant]]:
    """Lines in groups of the same number of phases."""
    counts = sorted({len(each.scene.phases) for each in variants})
    return [[each for each in variants if len(each.scene.phases) == count] for count in counts]


def _tried(found: Sequence[Measure], cases: Sequence[Case], count: int) -> list[Tried]:
    """Return impossible measures, and those of which all cases were simulated, best first."""
    tried = [Tried(each, [case for case in cases if case.ice == each.name]) for each in found]
    whole = [each for each in tried if each.measure.scene is None or len(each.cases) == count]
    return sorted(whole, key=_effect)


def _effect(tried: Tried) -> tuple[bool, float]:
    """Place in the list: the smallest remaining motion first, impossible ones last."""
    largest = tried.largest
    return math.isnan(largest), largest


def _criteria(climates: Sequence[Climate], angles_deg: Sequence[float]) -> list[DenHartog]:
    """Critical wind by Den Hartog's formula: the lowest of all modes, for each condition."""
    known: dict[str, list[LineMode]] = {}
    found = []
    for climate in climates:
        if climate.ice_text not in known:
            known[climate.ice_text] = natural_modes(climate.scene, LINEAR_MODES)
        for angle in angles_deg:
            try:
                scene = climate.scene.with_values({"ice.attack_angle_deg": angle})
                speeds = [den_hartog_speed(scene, mode) for mode in known[climate.ice_text]]
            except (SceneError, SimulationError):  # the angle is outside the curve
                speeds = []
            lowest = min((speed for speed in speeds if speed is not None), default=None)
            found.append(DenHartog(climate.ice_text, climate.curve_text, angle, lowest))
    return found
