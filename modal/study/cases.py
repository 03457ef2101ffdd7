"""Cases of a study: one simulation each, and what is kept of it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Outcome, SceneError
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.sweeps.cases import LABEL, NAME, Cases
from gallop_fmu.sweeps.cases import Case as Run
from gallop_fmu.sweeps.line_rows import LINE_COLUMNS, line_motion
from gallop_fmu.sweeps.places import Place
from gallop_fmu.sweeps.runner import Progress, compute, package
from gallop_fmu.sweeps.runs import RunsStoppedError
from gallop_fmu.sweeps.sweep import Simulation
from modal.report.line_verdict import MIN_GALLOPING
from modal.study.gaps import motion_window, orbit_gaps

Array = NDArray[np.float64]
PLACES = f"{LABEL}phases"
"""Column with the places of all phases, on which the gaps depend."""

Kind = Literal["steady", "not steady", "turned over", "left the curve", "ended early", "failed"]

KINDS: dict[Kind, str] = {
    "steady": "ran to the end, motion steady or at rest",
    "not steady": "ran to the end, motion not steady: its amplitude holds for the end of the run",
    "turned over": "ran to the end, the iced section turned over: the motion is the largest within"
    " 20 s after the first 20 s",
    "left the curve": "ended early: the attack angle left the measured range of the curve",
    "ended early": "ended early for another reason, such as a slack conductor",
    "failed": "no result",
}
"""Kind of a case to its meaning."""

EXTENT = 20.0
"""Length [s] of the windows in which the motion of a section that turned over is measured."""

WHOLE = ("steady", "not steady", "turned over")
"""Kinds of cases that ran to the end."""

EARLY = tuple(
    each.name.lower() for each in (Outcome.SLACK, Outcome.NEWTON_STALLED, Outcome.NON_FINITE)
)
"""Outcomes of runs that ended early for another reason than the curve."""

REASONS = {
    Outcome.EQUILIBRIUM_NOT_FOUND: "no static equilibrium; ice that is heavy on one side rotates a"
    " long, twistable conductor without limit",
    Outcome.NEWTON_STALLED: "the calculation did not converge",
    Outcome.NON_FINITE: "the motion became infinite",
    Outcome.SLACK: "the conductor went slack",
    Outcome.ANGLE_OUT_OF_RANGE: "the attack angle left the measured range of the curve at once",
    Outcome.INVALID_SCENE: "the condition is not possible",
}
"""Reasons why a case has no result, in words."""

OWN_COLUMNS = {
    "span_reached": (
        "m",
        "vertical motion of mid-span, peak to peak, in the last half of the run; if the section"
        " turned over, the largest within 20 s after the first 20 s",
    ),
    "span_largest_tension": ("N", "largest tension of a subconductor in the whole run"),
    "span_orbit_gap": ("m", "smallest gap of the orbits of two phases, at any time lag"),
    **{
        f"tower_preload_{axis}": ("N", f"force on the tower {way} at rest in still air")
        for axis, way in {"x1": "along the line", "x2": "upwards", "x3": "with the wind"}.items()
    },
    "tower_pull_at_rest": ("N", "pull of the string at rest in still air"),
}
"""Columns of a row besides those of a line in a sweep: unit and meaning."""


@dataclass(frozen=True)
class Case:
    """One simulated case.

    Attributes
    ----------
    wind, angle_deg : float
        Wind speed [m/s] and attack angle [deg].
    ice, curve : str
        Ice and curve in words; the curve is empty if it is that of the scene.
    kind : str
        One of `KINDS`.
    text : str
        Judgement of the motion, or the reason why the case ended, in full.
    reason : str
        Reason why the case has no result, in words without numbers; empty if it has.
    warnings : str
        Warnings of the run that limit the trust in it; may be empty.
    sag, peak_to_peak, horizontal, frequency_hz : ndarray, shape (span,)
        Of mid-span: sag in still air and peak-to-peak motion, vertical and horizontal [m], and
        frequency of the vertical motion [Hz]; of several phases the largest. NaN without a result.
    lasting : ndarray, shape (span,)
        Vertical peak-to-peak motion [m] at the end of the run. It is less than `peak_to_peak` if
        the section turned over and the motion then decreased; NaN if the run ended early.
    tension, gap : ndarray, shape (span,)
        Largest tension of a subconductor [N], and smallest gap of two phases [m].
    towers : dict of str to ndarray, shape (tower,)
        Extremes of forces [N] and leans [rad] by column.
    """

    wind: float
    angle_deg: float
    ice: str
    curve: str
    kind: Kind
    text: str
    reason: str
    warnings: str
    sag: Array
    peak_to_peak: Array
    lasting: Array
    horizontal: Array
    frequency_hz: Array
    tension: Array
    gap: Array
    towers: Mapping[str, Array]

    @property
    def has_result(self) -> bool:
        """True if there is a motion."""
        return self.kind != "failed"

    @property
    def is_whole(self) -> bool:
        """True if the run went to its end."""
        return self.kind in WHOLE

    @cached_property
    def largest(self) -> float:
        """Largest vertical motion of all spans, peak to peak [m]; NaN without a result."""
        known = self.peak_to_peak[np.isfinite(self.peak_to_peak)]
        return float(known.max()) if len(known) else math.nan

    @cached_property
    def largest_span(self) -> int:
        """Span with the largest motion, from 1."""
        return int(np.nanargmax(self.peak_to_peak)) + 1 if self.largest == self.largest else 1

    @property
    def gallops(self) -> bool:
        """True if a span moves by `MIN_GALLOPING` of its sag or more, peak to peak."""
        with np.errstate(invalid="ignore"):
            return bool(np.any(self.peak_to_peak >= MIN_GALLOPING * self.sag))

    @property
    def gallops_for_a_time(self) -> bool:
        """True if no span gallops any more at the end, because the section turned over."""
        with np.errstate(invalid="ignore"):
            ended = not np.any(self.lasting >= MIN_GALLOPING * self.sag)
        return self.kind == "turned over" and self.gallops and ended

    @property
    def may_grow(self) -> bool:
        """True if the motion had not settled at the end, so that a longer run may gallop more."""
        return self.text.startswith(("still growing", "undetermined")) or self.kind in (
            "left the curve",
            "ended early",
        )

    @property
    def smallest_gap(self) -> float:
        """Smallest gap of two phases [m]; NaN without phases or a result."""
        known = self.gap[np.isfinite(self.gap)]
        return float(known.min()) if len(known) else math.nan

    def most(self, name: str, *, inner: bool = False) -> float:
        """Largest magnitude of a quantity of the towers, such as ``"force_x1"``; NaN if unknown.

        Parameters
        ----------
        name
            The column without ``tower_`` and ``_lowest`` or ``_highest``.
        inner
            Only suspensions, not the ends.
        """
        ends = [self.towers.get(f"tower_{name}_{end}") for end in ("lowest", "highest")]
        values = np.abs(np.array([each for each in ends if each is not None]))
        values = values[:, 1:-1] if inner and values.size else values
        values = values[np.isfinite(values)]
        return float(values.max()) if values.size else math.nan

    def condition(self) -> str:
        """Ice, angle, curve and wind in words."""
        parts = [self.ice, f"attack angle {self.angle_deg:g} deg", self.curve]
        return ", ".join(part for part in (*parts, f"wind {self.wind:g} m/s") if part)


@dataclass(frozen=True)
class Variant:
    """A line with the names of its ice and curve, before wind and attack angle are set."""

    scene: LineScene
    ice: str
    curve: str


class CasesStoppedError(RuntimeError):
    """Cases that were stopped; ``cases`` holds the finished ones, ``total`` counts all."""

    def __init__(self, message: str, cases: list[Case], total: int) -> None:
        super().__init__(message)
        self.cases, self.total = cases, total


def run_cases(
    variants: Sequence[Variant],
    points: Sequence[tuple[float, float]],
    *,
    offsets: Sequence[Sequence[float]],
    folder: Path | None = None,
    stop_time: float | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> list[Case]:
    """Simulate every variant at every point: wind speed [m/s] and attack angle [deg]; on threads.

    Parameters
    ----------
    variants
        The lines.
    points
        Wind speed and attack angle.
    offsets
        Position x2, x3 [m] of each phase, for gaps between orbits.
    folder
        Folder that keeps the rows; the same cases are computed only once. None: they are not kept.
    stop_time
        Simulated time [s] (default: from the scene).
    workers
        Number of threads (default: one for each core).
    progress
        Called with the numbers of cases that are done, that failed, and of all.

    Raises
    ------
    CasesStoppedError
        Stopped with Ctrl-C, or the folder cannot be written.
    """
    every: list[Run] = []
    named: list[Variant] = []
    places = json.dumps(np.asarray(offsets, dtype=np.float64).tolist())
    for variant in variants:
        spec = SceneSpec.of(variant.scene)
        for wind, angle in points:
            changes = {"wind.speed": wind, "ice.attack_angle_deg": angle}
            name = f"{len(every) + 1}: {variant.ice}, {variant.curve}, {wind:g} m/s, {angle:g} deg"
            every.append(Run(len(every), spec, changes, {NAME: name, PLACES: places}))
            named.append(variant)

    def summary(result: LineResult) -> Mapping[str, Any]:
        return case_row(result, offsets)

    task = Simulation(stop_time, None, summary, {**LINE_COLUMNS, **OWN_COLUMNS})
    whole = Cases(tuple(every), {NAME: [run.labels[NAME] for run in every]})
    stopped = ""
    try:
        out = None if folder is None else _file_in(folder, whole, task)
        dataset = compute(whole, task, out=out, count=workers, progress=progress).dataset
    except RunsStoppedError as problem:
        stopped, dataset = str(problem), problem.result.dataset
    rows = {int(run): k for k, run in enumerate(dataset.run.values.tolist())}
    cases = [
        _case(dataset.isel(run=rows[run.run]), run, variant)
        for run, variant in zip(every, named, strict=True)
        if run.run in rows
    ]
    if stopped:
        raise CasesStoppedError(stopped, cases, len(every))
    return cases


def _file_in(folder: Path, cases: Cases, task: Simulation) -> Path:
    """Return the file of these cases; other cases, or another version, have another file.

    Raises
    ------
    SceneError
        The folder cannot be made.
    """
    text = f"{cases.fingerprint()} {task} {package()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise SceneError(f"{folder}: cannot be made ({problem.strerror}); give another") from None
    return folder / f"cases-{hashlib.sha256(text.encode()).hexdigest()[:12]}.nc"


def case_row(result: LineResult, offsets: Sequence[Sequence[float]]) -> dict[str, Any]:
    """Return the row of a case: that of a line in a sweep, and `OWN_COLUMNS`."""
    row = dict(line_motion(result))
    phases = result.map.phases > 1
    gaps = orbit_gaps(result, offsets)
    data = result.dataset
    numbers, phase_of, tension = data.span.values, data.phase.values, data["tension"].values
    for span in range(1, result.map.spans + 1):
        for phase in range(1, result.map.phases + 1):
            place = Place("span", span, phase if phases else None)
            own = (numbers == span) & (phase_of == phase)
            row[place.name_of("span_reached")] = reached(result, span, phase)
            row[place.name_of("span_largest_tension")] = float(np.nanmax(tension[:, own]))
            if span in gaps:
                row[place.name_of("span_orbit_gap")] = gaps[span]
    pulls = {(each["tower"], each["phase"]): each for each in result.strings.to_dict("records")}
    for found in result.towers.to_dict("records"):
        place = Place("tower", found["tower"], found["phase"] if phases else None)
        for axis in ("x1", "x2", "x3"):
            row[place.name_of(f"tower_preload_{axis}")] = found[f"preload_{axis}"]
        if pulls:
            string = pulls.get((found["tower"], found["phase"]), {})
            row[place.name_of("tower_pull_at_rest")] = string.get("pull_at_rest")
    return row


def reached(result: LineResult, span: int, phase: int) -> float:
    """Largest vertical motion of mid-span, peak to peak [m], of a run without a lasting motion.

    That in the last half of the run; if the section turned over, that within `EXTENT` after the
    sudden wind at the start.
    """
    time = result.dataset.time.values
    u2 = result.bundle(span, phase)["u2"].values
    start, stop = motion_window(result)
    if result.motion.kind != "turned over" or stop - start < EXTENT:
        return float(np.ptp(u2[time >= 0.5 * time[-1]]))
    starts = np.arange(start, stop - 0.5 * EXTENT, 0.25 * EXTENT)
    return max(float(np.ptp(u2[(time >= at) & (time <= at + EXTENT)])) for at in starts)


def _case(row: Any, run: Run, variant: Variant) -> Case:
    """Return the case of a row of the dataset."""
    outcome, motion = str(row["outcome"].item()), str(_text(row, "motion"))
    kind: Kind = "failed"
    extent = _places(row, "span_reached", "span", np.nanmax)
    moved = np.isfinite(extent).any()
    if outcome == Outcome.ANGLE_OUT_OF_RANGE.name.lower() and moved:
        kind = "left the curve"
    elif outcome in EARLY and moved:
        kind = "ended early"
    elif outcome == Outcome.COMPLETED.name.lower():
        kind = "steady" if motion.startswith(("steady", "at rest")) else "not steady"
        kind = "turned over" if motion.startswith("turned over") else kind
    peak = 2.0 * _places(row, "span_u2_amplitude", "span", np.nanmax)
    return Case(
        wind=float(run.changes["wind.speed"]),
        angle_deg=float(run.changes["ice.attack_angle_deg"]),
        ice=variant.ice,
        curve=variant.curve,
        kind=kind,
        reason=_reason(outcome) if kind == "failed" else "",
        text=motion if kind in WHOLE else _text(row, "message"),
        warnings=_text(row, "warnings"),
        sag=_places(row, "span_sag", "span", np.nanmax),
        peak_to_peak=peak if kind in ("steady", "not steady") else np.fmax(extent, peak),
        lasting=peak,
        horizontal=2.0 * _places(row, "span_u3_amplitude", "span", np.nanmax),
        frequency_hz=_places(row, "span_u2_frequency_hz", "span", np.nanmax),
        tension=_places(row, "span_largest_tension", "span", np.nanmax),
        gap=_places(row, "span_orbit_gap", "span", np.nanmin),
        towers={
            str(name): _places(
                row, str(name), "tower", np.nanmin if "lowest" in str(name) else np.nanmax
            )
            for name in row.data_vars
            if str(name).startswith("tower_")
        },
    )


def _reason(outcome: str) -> str:
    """Reason of a case without a result, from the name of its outcome."""
    found = [words for each, words in REASONS.items() if each.name.lower() == outcome]
    return found[0] if found else f"the calculation failed ({outcome})"


def _text(row: Any, name: str) -> str:
    return str(row[name].item()) if name in row else ""


def _places(row: Any, name: str, kind: str, of_phases: Any) -> Array:
    """Values of a column by span or tower; of several phases the extreme one."""
    if name not in row:
        return np.full(row.sizes.get(kind, 0), np.nan)
    values = np.asarray(row[name].values, dtype=np.float64)
    if values.ndim == 2:
        known = np.isfinite(values).any(axis=1)
        kept = np.full(len(values), np.nan)
        kept[known] = of_phases(values[known], axis=1)
        return kept
    return np.atleast_1d(values)
