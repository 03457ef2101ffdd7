"""All motions of a span from the lowest wind in which one begins, up to a highest wind.

The branches (`modal.continuation`) and the winds at which motions begin depend on the span alone,
not on the wind of its scene: first step, typical sizes and unit of the wind are those of a fixed
grid of wind speeds. The motions at the scene's wind are located on the branches.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.continuation.branch import Branch
from modal.continuation.diagram import CRITICAL, Diagram, explore
from modal.continuation.equations import OrbitEquations
from modal.continuation.events import Event, UserEvent
from modal.continuation.path import Point, Settings
from modal.continuation.problem import ContinuationError
from modal.linear.mode_basis import still_air_modes
from modal.linear.modes import Family
from modal.motions.reduced_model import static_equilibrium
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import SpanProblem, WindFamily
from modal.screening.multipliers import swing_multiplier

Array = NDArray[np.float64]

COUNTS: dict[Family, int] = {"vertical": 3, "horizontal": 3, "torsional": 2}
"""Modes of each family and symmetry; a third torsional one changes amplitudes by 0.1 %."""

LEAST_WIND, WIND_RATIO = 0.1, 1.15
"""Lowest wind speed [m/s] and ratio of the grid on which the lowest onset is sought."""

MAX_HALVINGS = 6
"""Largest number of times that the lowest wind speed is halved until the span is at rest."""

BEGIN, TYPICAL = 0.5, 1.5
"""Wind speeds of the first equilibrium and of typical sizes, relative to the lowest onset."""

TOLERANCE = 1e-3
"""Largest error of the discretisation, relative to the amplitude."""

NEWTON_TOLERANCE, LOCATION_TOLERANCE = 1e-4, 1e-6
"""Last correction of Newton's method, in typical sizes (the error left is its square), and accuracy
of the place of an event, relative to the step."""

FIRST_STEP, MAX_STEP = 0.05, 1.5
"""Lengths of continuation steps, in typical displacements and lowest onsets."""

MAX_POINTS, MAX_TOTAL_POINTS, MAX_BRANCHES, MAX_DEPTH = 80, 160, 12, 3
"""Limits of points of a branch and of all, of branches, and of events between one and the rest."""

MAX_INTERVALS, MAX_WORK = 60, 1000
"""Mesh intervals of an orbit above which its branch is given up as it twists too fast, and mesh
intervals of all orbits after which no more are computed."""

MAX_PERIOD = 8.0
"""Period at which a branch ends, relative to its first period."""

MAX_LOCATED = 6
"""Number of growing disturbances above which events are not located."""

MAX_GROWING, MAX_GROWTH = 3, 10.0
"""Number of growing disturbances, and growth in one period, above which no motion stays near an
orbit, so that its branch is given up."""

MAX_GROWING_AT_HOPF = 2
"""Number of growing disturbances of rest above which an oscillation that begins is not followed."""

SCENE_WIND = "scene's wind"
"""Kind of the event at which a branch passes the scene's wind."""

BEYOND = 1e-6
"""Part of the highest wind by which the branches go beyond it, so that it is inside."""


@dataclass(frozen=True)
class SpanDiagram:
    """Branches of a span over the wind speed.

    Attributes
    ----------
    scene : Scene
        The span.
    model : SpanModel
        Its reduced model.
    problem : SpanProblem
        The same as a system of equations.
    wind, highest : float
        The scene's wind and the end of the branches [m/s].
    found : Diagram or None
        The branches; None if rest is stable, and known, up to the highest wind.
    swing : dict
        Unknowns and swing multiplier of each point of an orbit, by the identity of the unknowns.
    end_reason : str
        Reason why rest is not known up to the highest wind; empty if it is.
    """

    scene: Scene
    model: SpanModel
    problem: SpanProblem
    wind: float
    highest: float
    found: Diagram | None
    swing: dict[int, tuple[Array, complex]] = field(repr=False)
    end_reason: str = ""

    @property
    def branches(self) -> list[Branch]:
        """Branches of equilibria and of orbits."""
        return [] if self.found is None else self.found.branches

    @property
    def orbits(self) -> list[Branch]:
        """Branches of orbits."""
        return [one for one in self.branches if one.kind == "orbit"]

    def at_wind(self, branch: Branch) -> list[Point]:
        """Solutions of a branch at the scene's wind, with their linearised equations."""
        return [event.point for event in branch.events if event.kind == SCENE_WIND]

    def swing_of(self, point: Point) -> complex:
        """Swing multiplier of an orbit in one period."""
        key = id(point.x)
        if key not in self.swing:
            self.swing[key] = point.x, swing_multiplier(point, self.model)
        return self.swing[key][1]


def span_model(scene: Scene) -> SpanModel:
    """Reduced model of a span for a screening."""
    return SpanModel(scene, still_air_modes(scene), counts=COUNTS)


def span_diagram(model: SpanModel, highest: float) -> SpanDiagram:
    """Follow all motions of a span that its rest leads to, up to a wind speed.

    Parameters
    ----------
    model
        The span, from `span_model`.
    highest
        Highest wind speed [m/s].

    Raises
    ------
    SceneError
        If there is no equilibrium in a weak wind, or no branch of equilibria is found; or if the
        span is turned out of its curve in a wind below the scene's and any onset.
    """
    scene, wind = model.scene, model.scene.wind.mean_speed
    unit, end_reason = first_growth(model, highest, wind)
    problem = SpanProblem(WindFamily(model), model, TYPICAL * (unit or highest))
    known = SpanDiagram(scene, model, problem, wind, highest, None, {}, end_reason)
    if unit is None:
        return known
    start = BEGIN * unit
    swing: dict[int, tuple[Array, complex]] = {}
    work = [0]

    def remember(point: Point) -> None:
        if isinstance(point.equations, OrbitEquations):
            swing[id(point.x)] = point.x, swing_multiplier(point, model)
            work[0] += point.equations.intervals

    def is_left(point: Point) -> bool:
        return _is_left(point) or work[0] > MAX_WORK

    settings = Settings(
        start,
        (1.0 + BEYOND) * highest,
        tolerance=TOLERANCE,
        first_step=FIRST_STEP,
        max_step=MAX_STEP,
        max_points=MAX_POINTS,
        max_period=MAX_PERIOD,
        max_unstable=MAX_LOCATED,
        max_total_points=MAX_TOTAL_POINTS,
        on_point=remember,
        newton_tolerance=NEWTON_TOLERANCE,
        location_tolerance=LOCATION_TOLERANCE,
        unit=unit,
        give_up=is_left,
        is_wanted=_is_wanted,
    )
    q, _ = static_equilibrium(model, start)
    passes = UserEvent(SCENE_WIND, lambda _, value: value - wind, False)
    try:
        found = explore(
            problem,
            np.append(q[0], np.zeros(model.size)),
            start * (1.0 + BEYOND),
            settings,
            [*problem.end_of_curve(), passes],
            MAX_DEPTH,
            MAX_BRANCHES,
        )
    except ContinuationError as error:
        raise SceneError(f"the span could not be screened, because {error}") from None
    return SpanDiagram(scene, model, problem, wind, highest, found, swing, end_reason)


def first_growth(model: SpanModel, highest: float, reach: float) -> tuple[float | None, str]:
    """Lowest wind speed [m/s] of a fixed grid in which a disturbance of rest grows.

    Parameters
    ----------
    model
        The span or line.
    highest
        Highest wind speed [m/s].
    reach
        Wind speed [m/s] up to which rest must be known; below it an error is raised.

    Returns
    -------
    float or None, str
        The wind speed, None if there is none, and why the search ended earlier (else empty).
    """
    wind = LEAST_WIND
    for _ in range(MAX_HALVINGS):
        q, grows = _growth(model, wind, None)
        if not grows:
            break
        wind *= 0.5
    else:
        raise SceneError(f"the span is not at rest in a wind of {wind:.2g} m/s: check its damping")
    while wind < highest:
        wind = min(WIND_RATIO * wind, highest)
        try:
            q, grows = _growth(model, wind, q)
        except SceneError as error:
            if wind <= reach:
                raise
            return None, str(error)
        if grows:
            return wind, ""
    return None, ""


def _growth(model: SpanModel, wind: float, guess: Array | None) -> tuple[Array, bool]:
    """Equilibrium in a wind, and True if a disturbance grows.

    Raises
    ------
    SceneError
        If there is none, or it lies outside the coefficient curve.
    """
    q, forces = static_equilibrium(model, wind, guess)
    if model.angle_excess(q, np.zeros_like(q), wind) > 0.0:
        assert model.scene.aerodynamics is not None  # a reduced model has a curve
        first, last = model.scene.aerodynamics.range_deg
        raise SceneError(
            f"in a wind of {wind:.4g} m/s the span is turned out of the coefficient curve, which is"
            f" valid from {first:g} to {last:g} deg; lower wind.speed or give a longer curve"
        )
    n = model.size
    lower = -np.linalg.solve(forces.mass[0], np.hstack([forces.stiffness[0], forces.damping[0]]))
    rates = np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), lower]))
    return q[0], bool(np.max(rates.real) > 0.0)


def _is_left(point: Point) -> bool:
    """True if no motion stays near an orbit, or it is too fast for the modes that are kept."""
    equations = point.equations
    return isinstance(equations, OrbitEquations) and (
        point.unstable > MAX_GROWING
        or float(np.max(np.abs(point.spectrum))) > MAX_GROWTH
        or equations.intervals > MAX_INTERVALS
    )


def _is_wanted(event: Event) -> bool:
    """True if a branch that begins at an event may have stable motions."""
    growing = int(np.sum(event.point.levels > CRITICAL_LEVEL))
    return growing <= (MAX_GROWING_AT_HOPF if event.kind == "Hopf" else 0)


CRITICAL_LEVEL = 100.0 * CRITICAL
"""Growth below which a disturbance is the critical one of an event that is roughly located."""
