"""All motions of a span or line that are connected with its equilibrium, over one number."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.foundation.notebook_table import notebook_table
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.input.scene_like import SceneLike, as_scene
from modal.continuation.branch import Branch
from modal.continuation.diagram import Diagram, explore
from modal.continuation.finer_mesh import mesh_doubt
from modal.continuation.path import GrowingLimit, Point, Settings
from modal.continuation.problem import ContinuationError
from modal.foundation.one_thread import one_thread
from modal.foundation.scene_variation import unit_of, varied
from modal.motions.full_model import full_scene, reduction_error
from modal.motions.motion_models import check_scene, motion_model
from modal.motions.motion_words import name_of_branch, name_of_disturbance
from modal.motions.reduced_model import static_equilibrium
from modal.motions.rotated import rotated_equilibria
from modal.motions.runs import runs_from_orbits
from modal.motions.saved_table import SavedTable
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import (
    WIND_SPEED,
    Family,
    NumberFamily,
    SpanProblem,
    WindFamily,
)
from modal.motions.table import begins_to_beat, branch_table, event_sentence, point_rows

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

TOLERANCE = 1e-4
"""Largest error of the discretisation, relative to the amplitude."""

FIRST_STEP, MAX_STEP = 0.05, 0.3
"""Lengths of continuation steps, in typical displacements and parts of the range."""

MAX_POINTS, MAX_TOTAL_POINTS, MAX_BRANCHES, MAX_DEPTH = 150, 300, 20, 4
"""Limits of points of a branch and of all, of branches, and of events between one and the rest."""

MAX_PERIOD = 8.0
"""Period at which a branch ends, relative to its first period."""

MAX_UNSTABLE = 2
"""Number of growing disturbances above which events are not located and branches not sought; at
rest so many for each span of a line, because its spans gallop almost independently."""

MAX_GROWING = GrowingLimit(4, 8, 0.15)
"""Limit after which a branch is given up: such a motion cannot be observed. In a section of five
spans, a motion that becomes stable has up to nine growing disturbances at first, while the wind
speed changes by 8 %."""

EXTENSION, MAX_EXTENSIONS = 0.75, 12
"""Factor by which the lowest wind is reduced until the span is at rest, and how often."""

MAX_ERROR = 0.05
"""Error of the reduction above which a remark warns."""

START_SHIFT = 1e-5
"""Distance of the first equilibrium from the start of the range, relative to the range."""

DIFFERENCE = 1e-4
"""Step of the difference by a number other than the wind speed, relative to the range."""

Progress = Callable[[int, float], object]
"""Called with the number of the branch that is followed and the value that it has reached."""


@dataclass(frozen=True, repr=False)
class Branches(SavedTable):
    """Equilibria and periodic motions of a span or line over one number.

    Attributes
    ----------
    dataset : xarray.Dataset
        Over ``branch``: its name in words, kind, first and last event, error of the reduction
        (see Notes); over ``point``: branch, value, period, amplitudes, stability; over
        ``located``: the events; over ``run``: the simulations, if there are any.
    over, unit : str
        Name and unit of the number.
    remarks : tuple of str
        What could not be found out, and why; motions that begin to beat.
    diagram : modal.continuation.diagram.Diagram
        The branches with all their states.
    scene : Scene or LineScene
        The span.
    seconds : float
        CPU time [s].

    Notes
    -----
    ``reduction_error`` is the distance, relative to the amplitude, between an orbit of the branch
    and the motion of the full model that starts on it, within one period.
    """

    dataset: xr.Dataset
    over: str
    unit: str
    remarks: tuple[str, ...]
    diagram: Diagram = field(repr=False)
    scene: Scene | LineScene = field(repr=False)
    seconds: float

    def __repr__(self) -> str:
        data = self.dataset
        lines = [f"{data.attrs['title']}: {data.sizes['branch']} branches over {self.over}"]
        for number in data.branch.values.tolist():
            one = data.sel(branch=number)
            lines.append(f"{number}: {one['name'].item()}, {one['summary'].item()}")
        return "\n".join([*lines, *self.remarks])

    def _repr_html_(self) -> str:
        """Table for notebooks."""
        data = self.dataset
        cells = (data[key].values.tolist() for key in ("branch", "name", "summary"))
        return notebook_table(
            f"{data.attrs['title']}: motions over {self.over}",
            ("branch", "motion", ""),
            [(str(number), *texts) for number, *texts in zip(*cells, strict=True)],
            self.remarks,
        )

    def plot(self) -> Any:
        """Draw the amplitudes of all branches by `modal.plots.branch_figure`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("Branches.plot", self.dataset)

    def _rows(self) -> Any:
        """Points of all branches."""
        return point_rows(self.dataset)


@one_thread
def branches(
    scene: SceneLike,
    over: str = WIND_SPEED,
    start: float | None = None,
    stop: float | None = None,
    *,
    simulate: int = 0,
    progress: Progress | None = None,
) -> Branches:
    """Find all motions over a number: equilibria, periodic motions, and their stability.

    The span or line is reduced to its lowest modes of all families
    (`modal.motions.span_model`, `modal.motions.line_model`). Starting from the equilibrium,
    branches are followed by continuation (`modal.continuation`): galloping begins at a Hopf point,
    a swing at a period doubling or a torus, motion in two loops at a Hopf point or where the
    symmetry breaks. Motions with two frequencies begin at a torus; they are not followed, but
    simulated on request.

    Parameters
    ----------
    scene
        A span or line with wind and a coefficient curve. A wind history counts with its mean; loads
        and seeds are ignored.
    over
        Name of the number, as in `Scene.with_values`; derivatives by other numbers than the wind
        speed are differences, which takes about four times as long.
    start, stop
        Range of the number. Default for the wind speed: half and 1.5 times the scene's. If
        galloping begins in a lower wind, the range is extended to it.
    simulate
        Number of values at which the full model is started on the stable part of each branch, and
        on its unstable part, with a small disturbance; 0: none.
    progress
        Called with the number of the branch that is followed and the value that it has reached.

    Returns
    -------
    Branches
        The motions, events and remarks.

    Raises
    ------
    SceneError
        If the scene or the range is not fit, or if there is no equilibrium at the start.

    Examples
    --------
    >>> import gallop_fmu as gf, modal
    >>> found = modal.branches(gf.load_scene("example3"), start=4.5, stop=4.8)
    >>> found.dataset["name"].values.tolist()
    ['rest', 'one loop']
    """
    began = clock.process_time()
    scene = as_scene(scene)
    start, stop = _range(scene, over, start, stop)
    at_start = _scene_at(scene, over, start)
    wind = start if over == WIND_SPEED else scene.wind.mean_speed
    model = motion_model(at_start)
    problem = _problem(scene, over, model, start, stop)
    guess, grows = _rest(problem, model, start, wind)
    remarks = []
    if grows and over == WIND_SPEED:
        asked = start
        start, guess, grows = _lower_start(problem, model, start, guess)
        remarks.append(
            f"galloping begins below {asked:g} m/s: the range was extended to {start:.4g} m/s"
        )
    if grows:
        remarks.append(
            f"at {over} = {start:g} the equilibrium is unstable: motions that begin outside of the"
            " range could not be found; extend it to where the span is at rest"
        )
    at_rest = MAX_UNSTABLE * model.bundles
    settings = Settings(
        start,
        stop,
        tolerance=TOLERANCE,
        first_step=FIRST_STEP,
        max_step=MAX_STEP,
        max_points=MAX_POINTS,
        max_period=MAX_PERIOD,
        max_unstable=MAX_UNSTABLE,
        max_unstable_at_rest=at_rest,
        max_total_points=MAX_TOTAL_POINTS,
        max_growing=MAX_GROWING,
        on_point=_Watch(progress) if progress else None,
    )
    first = start + START_SHIFT * (stop - start)
    try:
        found = explore(
            problem,
            guess,
            first,
            settings,
            problem.end_of_curve(),
            MAX_DEPTH,
            MAX_BRANCHES,
            list(rotated_equilibria(problem, start, stop)),
        )
    except ContinuationError as problem_:
        raise SceneError(f"branches could not be found, because {problem_}") from None
    names = [name_of_branch(one, model) for one in found.branches]
    errors = [_error(scene, over, problem, one) for one in found.branches]
    runs = runs_from_orbits(scene, over, problem, found, simulate, progress) if simulate else []
    unit = unit_of(scene, over)
    doubts = _mesh_doubts(found, settings)
    unconfirmed = {*doubts, *(id(event.point.x) for event, _ in found.failures)}
    dataset = branch_table(problem, found, names, errors, runs, over, unit, unconfirmed)
    dataset.attrs |= {"title": scene.title, "scene": scene.to_toml()}
    remarks += [*_remarks(found, names, model, unit, doubts), *_doubts(errors, names)]
    seconds = clock.process_time() - began
    return Branches(dataset, over, unit, tuple(remarks), found, scene, seconds)


def _range(
    scene: Scene | LineScene, over: str, start: float | None, stop: float | None
) -> tuple[float, float]:
    """Check the scene and the range of the number."""
    wind = scene.wind.mean_speed
    check_scene(scene, wind if over != WIND_SPEED or start is None else start)
    if start is None or stop is None:
        if over != WIND_SPEED or not wind > 0.0:
            raise SceneError(f"the range of {over} is not given: give start and stop")
        start = 0.5 * wind if start is None else start
        stop = 1.5 * wind if stop is None else stop
    if not (np.isfinite(start) and np.isfinite(stop) and start < stop):
        raise SceneError(f"range of {over}: start = {start:g} must be below stop = {stop:g}")
    if over != WIND_SPEED and not wind > 0.0:
        raise SceneError("wind.speed = 0 m/s: branches need wind; set wind.speed")
    return float(start), float(stop)


def _scene_at(scene: Scene | LineScene, over: str, value: float) -> Scene | LineScene:
    if over == WIND_SPEED:
        return scene
    return varied(scene, over, value)


def _problem(
    scene: Scene | LineScene, over: str, model: SpanModel, start: float, stop: float
) -> SpanProblem:
    """The span as a system with the number as its parameter."""
    family: Family
    if over == WIND_SPEED:
        family, wind = WindFamily(model), stop
    else:
        family = NumberFamily(scene, over, model, DIFFERENCE * (stop - start))
        wind = scene.wind.mean_speed
    return SpanProblem(family, model, wind)


def _rest(problem: SpanProblem, model: SpanModel, value: float, wind: float) -> tuple[Array, bool]:
    """Equilibrium state at a value of the number, and True if a disturbance of it grows."""
    q, _ = static_equilibrium(model, wind)
    state = np.append(q[0], np.zeros(model.size))
    rates = np.linalg.eigvals(problem.rates(state[None], value).by_state[0])
    return state, bool(np.max(rates.real) > 0.0)


def _lower_start(
    problem: SpanProblem, model: SpanModel, start: float, state: Array
) -> tuple[float, Array, bool]:
    """Find a wind below the start in which the equilibrium is stable, if there is one."""
    for _ in range(MAX_EXTENSIONS):
        start *= EXTENSION
        state, grows = _rest(problem, model, start, start)
        if not grows:
            return start, state, False
    return start, state, True


class _Watch:
    """Count the branches of the points that continuation reports."""

    def __init__(self, progress: Progress) -> None:
        self.progress, self.number, self.last = progress, 0, ""

    def __call__(self, point: Point) -> None:
        name = f"{point.equations.kind} {getattr(point.equations, 'period_scale', 0.0):.6g}"
        self.number += name != self.last
        self.last = name
        self.progress(self.number, point.parameter)


def _error(scene: Scene | LineScene, over: str, problem: SpanProblem, branch: Branch) -> float:
    """Error of the reduction at the middle of the stable part, or of the branch."""
    if branch.kind == "equilibrium":
        return float("nan")
    stable = [point for point in branch.points if point.is_stable] or branch.points
    point = stable[len(stable) // 2]
    model, _ = problem.family.at(point.parameter)
    try:
        return reduction_error(full_scene(scene, over, point.parameter, model), model, point)
    except (SceneError, SimulationError):
        return float("nan")


def _doubts(errors: list[float], names: list[str]) -> list[str]:
    """Sentences about branches for which the reduced model is not accurate."""
    return [
        f"branch {number} ({name}): the full model moves away from the reduced one by {error:.0%}"
        " of the amplitude in one period, so that the amplitudes are not reliable: simulate"
        for number, (error, name) in enumerate(zip(errors, names, strict=True))
        if error > MAX_ERROR
    ]


def _mesh_doubts(found: Diagram, settings: Settings) -> dict[int, str]:
    """Reasons why beats are not confirmed on a finer mesh, by the identity of the unknowns."""
    beats = [one for branch in found.branches for one in branch.events if begins_to_beat(one)]
    doubts = {id(one.point.x): mesh_doubt(one, settings) for one in beats}
    return {key: doubt for key, doubt in doubts.items() if doubt}


def _remarks(
    found: Diagram, names: list[str], model: SpanModel, unit: str, doubts: dict[int, str]
) -> tuple[str, ...]:
    """Sentences about what could not be found out, and about motions that begin to beat."""
    remarks = []
    for number, (branch, name) in enumerate(zip(found.branches, names, strict=True)):
        for event in (*branch.events, *branch.ends):
            sentence = event_sentence(event, unit)
            if sentence and event.kind == "torus":
                sentence += f"; what begins is {name_of_disturbance(event, model)}"
                if doubt := doubts.get(id(event.point.x)):
                    sentence += f"; this is not confirmed, because {doubt}"
            if sentence:
                remarks.append(f"branch {number} ({name}): {sentence}")
    for event, reason in found.failures:
        remarks.append(
            f"the branch that starts at {event.parameter:.4g} {unit} ({event.kind}) could not be"
            f" found, because {reason}"
        )
    if found.unexplored:
        listed = ", ".join(dict.fromkeys(f"{one.parameter:.4g}" for one in found.unexplored))
        remarks.append(
            f"branches that start at {listed} {unit} were not followed, because more than"
            f" {MAX_UNSTABLE} disturbances grow there, or the limit of {MAX_BRANCHES} branches and"
            f" {MAX_TOTAL_POINTS} points is reached: give a smaller range"
        )
    return tuple(remarks)
