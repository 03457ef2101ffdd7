"""Branches of solutions as labelled data, and the loop that follows one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modal.continuation.events import Event, Found, Segment, UserEvent, events_between
from modal.continuation.path import Point, Settings, Stepper, angle_between
from modal.continuation.problem import ContinuationError

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

TERMINAL = ("range", "period", "rest", "period halving", "symmetry recovered")
"""Kinds of events at which a branch ends."""

MIN_CLOSED_POINTS = 8
"""Least number of points of a closed branch."""

CLOSED_TOLERANCE = 0.02
"""Distance of summaries of two solutions, relative to the step, below which a branch is closed."""


@dataclass(frozen=True)
class Branch:
    """Neighbouring solutions.

    Attributes
    ----------
    kind : str
        "equilibrium" or "orbit".
    points : list of Point
        Solutions in the order of the branch. Events are among them.
    events : list of Event
        Events in the order of the branch, without its ends.
    ends : tuple of Event
        Where and why the branch begins and ends. Kinds beside those of `modal.continuation.events`:
        "start", "closed", "points" (the largest number of points), "given up" (by
        `Settings.give_up` or `Settings.max_growing`), "lost" (no further solution found, not
        resolved, or a jump to another branch not excluded; `reason` says which).
    origin : Event or None
        Event of another branch from which it was reached.
    """

    kind: str
    points: list[Point] = field(repr=False)
    events: list[Event]
    ends: tuple[Event, Event]
    origin: Event | None = field(default=None, repr=False)

    @property
    def is_complete(self) -> bool:
        """True if the branch ends at an event or closes."""
        return not any(end.kind in ("lost", "points") for end in self.ends)

    def of_kind(self, kind: str) -> list[Event]:
        """Events of a kind, with the ends."""
        first, last = self.ends
        return [one for one in (first, *self.events, last) if one.kind == kind]

    def at(self, parameter: float) -> list[Point]:
        """Neighbouring points between which the parameter takes a value: the first of each pair."""
        values = np.array([point.parameter for point in self.points])
        return [
            self.points[k]
            for k in np.flatnonzero((values[:-1] - parameter) * (values[1:] - parameter) <= 0.0)
        ]

    def dataset(self) -> xr.Dataset:
        """Return the branch as a table.

        Returns
        -------
        xarray.Dataset
            Over ``point``: parameter, period, number of unstable disturbances, is_stable, errors,
            event ("" where there is none); over ``component``: lowest, highest, mean; over
            ``multiplier``: multiplier (complex; for equilibria the eigenvalues).
        """
        import xarray as xr

        points = self.points
        extremes = [point.extremes for point in points]
        labels = {id(event.point.x): event.kind for event in (*self.events, *self.ends)}
        over = ("point", "component")
        return xr.Dataset(
            {
                "parameter": ("point", [point.parameter for point in points]),
                "period": ("point", [point.period for point in points]),
                "unstable": ("point", [point.unstable for point in points]),
                "is_stable": ("point", [point.is_stable for point in points]),
                "error": ("point", [point.error for point in points]),
                "trivial_error": ("point", [point.trivial_error for point in points]),
                "event": ("point", [labels.get(id(point.x), "") for point in points]),
                "lowest": (over, np.array([low for low, _ in extremes])),
                "highest": (over, np.array([high for _, high in extremes])),
                "mean": (over, np.array([point.mean for point in points])),
                "multiplier": (
                    ("point", "multiplier_number"),
                    np.array([point.spectrum for point in points]),
                ),
            },
            attrs={"kind": self.kind, "begin": self.ends[0].kind, "end": self.ends[1].kind},
        )


def follow(
    start: Point,
    settings: Settings,
    user: Sequence[UserEvent] = (),
    origin: Event | None = None,
) -> Branch:
    """Follow a branch from a point in the direction of its tangent.

    Parameters
    ----------
    start
        First solution.
    settings
        Bounds of the continuation.
    user
        Further events.
    origin
        Event at which the branch was found.

    Returns
    -------
    Branch
        The branch; the last of `Branch.ends` says why it ends.
    """
    terminal = {*TERMINAL, *(event.name for event in user if event.is_terminal)}
    max_period = settings.max_period * start.period
    stepper = Stepper(settings)
    points, events = [start], list[Event]()
    point, step, bend = start, settings.first_step, None
    end: Event | None = None
    while end is None:
        if len(points) >= settings.max_points:
            reason = f"the largest number of points, {settings.max_points}, is reached"
            end = Event("points", point, reason=reason)
            break
        try:
            if len(points) % REMESH_STEPS == 0:
                point = stepper.remeshed(point)
            base, new = stepper.step(point, step, bend)
            found = events_between(Segment(stepper, base, new, step), settings, user, max_period)
        except ContinuationError as error:
            step *= 0.5
            if step < settings.min_step:
                end = Event("lost", point, reason=str(error))
            continue
        end = _append(points, events, found, terminal)
        if end is None:
            points.append(new)
            if settings.on_point is not None:
                settings.on_point(new)
            angle = angle_between(base, new)
            bend = angle / step
            if _is_closed(points, step):
                end = Event("closed", new, reason="the branch returns to its start")
            else:
                end = _given_up(points, settings)
            step = stepper.next_length(step, angle, new.iterations)
            point = new
    first = origin or Event("start", start)
    branch_points = [_light(one) for one in points]
    return Branch(start.equations.kind, branch_points, events, (first, end), origin)


REMESH_STEPS = 4
"""Points after which the mesh is adapted even if its error is small enough."""


def _append(
    points: list[Point], events: list[Event], found: Found, terminal: set[str]
) -> Event | None:
    """Append the events of a step and their points; return the one at which the branch ends."""
    for _, event in found:
        if event.kind in terminal:
            if event.kind != "rest":
                points.append(event.point)
            return event
        points.append(event.point)
        events.append(event)
    return None


def _given_up(points: list[Point], settings: Settings) -> Event | None:
    """End of a branch that is unwanted, or at whose last points too many disturbances grow."""
    last = points[-1]
    if settings.give_up is not None and settings.give_up(last):
        return Event("given up", last, reason="what follows was not wanted")
    if settings.max_growing is None or last.equations.kind != "orbit":
        return None
    limit, unstable = settings.max_growing, [point.unstable for point in points]
    fewer = [k for k, number in enumerate(unstable) if number <= limit.disturbances]
    in_a_row = [point.parameter for point in points[fewer[-1] + 1 if fewer else 0 :]]
    if len(in_a_row) < limit.points:
        return None
    if np.ptp(in_a_row) < limit.change * np.max(np.abs(in_a_row)):
        return None
    reason = f"more than {limit.disturbances} disturbances grow from {in_a_row[0]:.4g} on"
    return Event("given up", last, reason=reason)


def _light(point: Point) -> Point:
    """Drop the matrices of a point, which take much memory."""
    return replace(point, linear=point.linear._replace(matrix=None))


def summary(point: Point, parameter_scale: float) -> Array:
    """Numbers by which solutions are compared, whatever their mesh and phase."""
    scale = point.equations.problem.scale
    low, high = point.extremes
    parts = (low / scale, high / scale, point.mean / scale)
    return np.concatenate([*parts, [point.parameter / parameter_scale]])


def _is_closed(points: list[Point], step: float) -> bool:
    """True if the last step passes the start of the branch in its direction."""
    if len(points) < MIN_CLOSED_POINTS:
        return False
    unit = getattr(points[0].equations, "parameter_scale", 1.0)
    start, second, before, last = (summary(points[k], unit) for k in (0, 1, -2, -1))
    move = last - before
    square = float(move @ move)
    if square == 0.0 or float(move @ (second - start)) <= 0.0:
        return False
    part = float((start - before) @ move) / square
    if not 0.0 <= part <= 1.0:
        return False
    away = float(np.linalg.norm(before + part * move - start))
    return away < max(CLOSED_TOLERANCE * step, 0.05 * float(np.sqrt(square)))


def joined(backward: Branch, forward: Branch) -> Branch:
    """Join two branches that start at the same point in opposite directions."""
    points = backward.points[:0:-1] + forward.points
    events = backward.events[::-1] + forward.events
    return Branch(forward.kind, points, events, (backward.ends[1], forward.ends[1]))
