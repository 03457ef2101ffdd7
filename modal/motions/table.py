"""Branches as labelled tables and sentences, and the files of them."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from modal.continuation.branch import Branch
from modal.continuation.diagram import CRITICAL, Diagram
from modal.continuation.events import Event
from modal.continuation.path import Point
from modal.motions.runs import BranchRun
from modal.motions.span_problem import LEAVES_CURVE, SpanProblem

if TYPE_CHECKING:
    import xarray as xr

PHASES = np.arange(128) / 128.0
"""Phases of a period at which amplitudes are measured."""

MEANINGS = {
    "Hopf": "an oscillation begins",
    "rest": "the oscillation ends at rest",
    "fold": "the branch turns back",
    "period doubling": "a motion of twice the period begins",
    "period halving": "the motion becomes one of half the period",
    "torus": "the motion begins to beat with a second frequency",
    "symmetry breaking": "a motion without mirror symmetry begins",
    "symmetry recovered": "the motion becomes symmetric",
    "branch point": "two branches meet",
    "range": "end of the range",
    "period": "the period grows without bound",
    "closed": "the branch returns to its start",
    "start": "start",
    LEAVES_CURVE: "the attack angle leaves the coefficient curve",
    "lost": "not found further",
    "points": "not followed further",
    "given up": "not followed further",
}
"""Kinds of events in words."""


def begins_to_beat(event: Event) -> bool:
    """True at a torus of a motion that was stable before."""
    return event.kind == "torus" and not np.any(event.point.levels > CRITICAL)


def event_sentence(event: Event, unit: str) -> str:
    """Sentence about an event that limits what is known; empty if it does not."""
    at = f"{event.parameter:.4g} {unit}"
    if begins_to_beat(event):
        frequency = event.rotation / event.point.period
        return (
            f"at {at} the motion begins to beat (multiplier at {event.rotation:.3g} of a turn,"
            f" {frequency:.3g} Hz); motions with two frequencies are not followed: simulate them"
        )
    if event.kind == LEAVES_CURVE:
        return f"ends at {at}, because the attack angle reaches the end of the coefficient curve"
    if event.kind == "given up":
        return f"not followed beyond {at}, because {event.reason}"
    if event.kind in ("lost", "points"):
        return f"could not be found beyond {at}, because {event.reason}"
    if event.kind == "period":
        return f"ends at {at}, because {event.reason}"
    return ""


def branch_table(
    problem: SpanProblem,
    found: Diagram,
    names: Sequence[str],
    errors: Sequence[float],
    runs: Sequence[BranchRun],
    over: str,
    unit: str,
    unconfirmed: Collection[int],
) -> xr.Dataset:
    """Return the branches as a table; see `modal.motions.branches.Branches`.

    ``unconfirmed`` has the identities of the unknowns of events that are not confirmed.
    """
    import xarray as xr

    data: dict[str, Any] = {
        "name": ("branch", list(names)),
        "kind": ("branch", [one.kind for one in found.branches]),
        "begin": ("branch", [one.ends[0].kind for one in found.branches]),
        "end": ("branch", [one.ends[1].kind for one in found.branches]),
        "summary": ("branch", [_summary(one, unit) for one in found.branches]),
        "reduction_error": ("branch", list(errors), {"units": "1"}),
        **_point_columns(problem, found, unit),
        **_event_columns(found, unit, unconfirmed),
    }
    if runs:
        data |= _run_columns(runs, unit)
    model = problem.model
    return xr.Dataset(
        data,
        coords={"branch": np.arange(len(found.branches))},
        attrs={
            "over": over,
            "units": unit,
            "modes": model.size,
            "highest_hz": model.highest_hz,
            "amplitude": "half peak-to-peak",
        },
    )


POINT_COLUMNS = {
    "period": "s",
    "u2_amplitude": "m",
    "u3_amplitude": "m",
    "theta_amplitude": "rad",
    "quarter_amplitude": "m",
    "clamp_amplitude": "m",
    "u2_mean": "m",
    "u3_mean": "m",
    "theta_mean": "rad",
    "unstable": "1",
    "is_stable": "1",
    "growth": "1",
    "error": "1",
}
"""Columns of the points and their units. ``quarter_amplitude`` is that of the antisymmetric
vertical motion at the quarter points; ``growth`` is the largest absolute multiplier of a
disturbance in one period, for equilibria the largest growth rate [1/s]. Of a line, amplitudes are
those of the span in which they are largest, and means those of all spans; ``clamp_amplitude`` is
that of clamps of strings across the line."""

PLACES = ("u2", "u3", "theta", "quarter", "clamp")
"""Motions of which the amplitude at each place of a line is a column ``NAME_by_span``, with phases
one after another, or ``clamp_by_tower``."""


def _point_columns(problem: SpanProblem, found: Diagram, unit: str) -> dict[str, Any]:
    """Columns over the points of all branches."""
    points = [(number, point) for number, one in enumerate(found.branches) for point in one.points]
    special = {id(e.point.x): e.kind for one in found.branches for e in (*one.events, *one.ends)}
    rows = [_of_point(problem, point) for _, point in points]
    return {
        "branch_of_point": ("point", [number for number, _ in points]),
        "value": ("point", [point.parameter for _, point in points], {"units": unit}),
        "event": ("point", [special.get(id(point.x), "") for _, point in points]),
        **{
            name: ("point", np.array([row[name] for row in rows]), {"units": units})
            for name, units in POINT_COLUMNS.items()
        },
        **(_place_columns(problem, points) if problem.model.bundles > 1 else {}),
    }


def _place_columns(problem: SpanProblem, points: Sequence[tuple[int, Point]]) -> dict[str, Any]:
    """Columns of amplitudes over points and places of a line."""
    columns: dict[str, Any] = {}
    of_points = [
        problem.model.watched_at(point.at(PHASES)[:, : problem.modes]) for _, point in points
    ]
    for number, name in enumerate(PLACES):
        place = "tower" if name == "clamp" else "span"
        amplitudes = np.array([0.5 * np.ptp(moves[number], axis=0) for moves in of_points])
        units = POINT_COLUMNS[f"{name}_amplitude"]
        columns[f"{name}_by_{place}"] = (("point", place), amplitudes, {"units": units})
    return columns


def _event_columns(found: Diagram, unit: str, unconfirmed: Collection[int]) -> dict[str, Any]:
    """Columns over the events of all branches."""
    located = [(k, event) for k, one in enumerate(found.branches) for event in _events(one)]
    meanings = [
        MEANINGS.get(event.kind, event.kind)
        + (" (not confirmed)" if id(event.point.x) in unconfirmed else "")
        for _, event in located
    ]
    return {
        "event_kind": ("located", [event.kind for _, event in located]),
        "event_branch": ("located", [number for number, _ in located]),
        "event_value": ("located", [event.parameter for _, event in located], {"units": unit}),
        "event_meaning": ("located", meanings),
    }


def _of_point(problem: SpanProblem, point: Point) -> dict[str, float]:
    """Columns of a point."""
    model = problem.model
    q = point.at(PHASES)[:, : model.size]
    moves = model.watched_at(q)
    u2, u3, theta, quarter, clamp = (0.5 * np.ptp(one, axis=0).max(initial=0.0) for one in moves)
    mean = point.mean[: model.size] @ model.middle
    is_orbit = point.equations.kind == "orbit"
    growth = np.max(np.abs(point.spectrum)) if is_orbit else np.max(point.spectrum.real)
    return {
        "period": point.period if is_orbit else np.nan,
        "u2_amplitude": u2,
        "u3_amplitude": u3,
        "theta_amplitude": theta,
        "quarter_amplitude": quarter,
        "clamp_amplitude": clamp,
        "u2_mean": mean[1],
        "u3_mean": mean[2],
        "theta_mean": mean[3],
        "unstable": point.unstable,
        "is_stable": point.is_stable,
        "growth": float(growth),
        "error": point.error,
    }


def _events(branch: Branch) -> list[Event]:
    """Events of a branch and its end; the begin is an event of another branch."""
    return [*branch.events, branch.ends[1]]


def _summary(branch: Branch, unit: str) -> str:
    """Where a branch begins and ends, and where it is stable."""
    begin, end = branch.ends
    stable = _stable_ranges(branch)
    where = ", ".join(f"{low:.4g} to {high:.4g}" for low, high in stable)
    folds = ", ".join(f"{one.parameter:.4g}" for one in branch.of_kind("fold"))
    turns = f", turns back at {folds} {unit}" if folds else ""
    begins = "" if begin.kind in ("start", "range") else f" ({MEANINGS.get(begin.kind)})"
    return (
        f"from {begin.parameter:.4g} {unit}{begins} to {end.parameter:.4g} {unit}"
        f" ({MEANINGS.get(end.kind, end.kind)}){turns}; "
        + (f"stable at {where} {unit}" if stable else "nowhere stable")
    )


def _stable_ranges(branch: Branch) -> list[tuple[float, float]]:
    """Ranges of the parameter of the stable parts.

    At an event a disturbance neither grows nor decays: its point is the end of both neighbours.
    """
    ranges: list[tuple[float, float]] = []
    part: list[float] = []
    at_event: list[float] = []
    for point in branch.points:
        value, before = point.parameter, at_event
        if point.is_stable:
            part += [*at_event, value]
        at_event = [
            value for event in _events(branch) if math.isclose(value, event.parameter, rel_tol=1e-9)
        ][:1]
        if part and not point.is_stable:
            part += [] if before else at_event
            ranges.append((min(part), max(part)))
            part = []
    if part:
        ranges.append((min(part), max(part)))
    return [(low, high) for low, high in ranges if high > low]


def _run_columns(runs: Sequence[BranchRun], unit: str) -> dict[str, Any]:
    """Columns of the simulations."""
    columns: dict[str, Any] = {
        "run_branch": ("run", [run.branch for run in runs]),
        "run_value": ("run", [run.value for run in runs], {"units": unit}),
        "run_start_is_stable": ("run", [run.is_stable for run in runs]),
        "run_outcome": ("run", [run.end.outcome for run in runs]),
    }
    for name, units in (
        ("u2", "m"),
        ("u3", "m"),
        ("theta", "rad"),
        ("quarter", "m"),
        ("clamp", "m"),
    ):
        for part in ("low", "high", "whole"):
            values = [getattr(getattr(run.end, name), part) for run in runs]
            columns[f"run_{name}_{part}"] = ("run", values, {"units": units})
    return columns


def point_rows(dataset: xr.Dataset) -> Any:
    """Points of all branches as a DataFrame, with units in the names of its columns."""
    names = ["branch_of_point", "value", *POINT_COLUMNS, "event"]
    units = [dataset[name].attrs.get("units", "") for name in names]
    frame = dataset[names].to_dataframe()[names]
    frame.insert(1, "name", dataset["name"].values[frame["branch_of_point"].to_numpy()])
    units.insert(1, "")
    frame.columns = [
        f"{name} [{unit}]" if unit and unit != "1" else name
        for name, unit in zip(frame.columns, units, strict=True)
    ]
    return frame
