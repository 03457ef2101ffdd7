"""Sensitivity of the motions of a span or line: derivatives by numbers of its scene.

The derivatives are those of the reduced model (`modal.motions.motion_models`), from
`modal.continuation.sensitivity`. Only the right-hand side of its equations is differentiated by
differences, at constant states. The step is `STEP` of the number, and the difference with twice the
step gives an estimate of its error.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.input.scene_like import SceneLike
from modal.continuation import sensitivity as gradients
from modal.continuation.equations import EquilibriumEquations, OrbitEquations
from modal.continuation.events import Event
from modal.continuation.path import Point, Settings, Stepper
from modal.continuation.problem import ContinuationError
from modal.continuation.sensitivity import Gradient
from modal.foundation.one_thread import one_thread
from modal.foundation.scene_variation import (
    ICE_MASS,
    TEMPERATURE,
    number_of,
    varied,
)
from modal.motions.branches import Branches, branches
from modal.motions.motion_models import similar_model
from modal.motions.saved_table import SavedTable
from modal.motions.sensitivity_table import sensitivity_table
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import (
    WIND_SPEED,
    Family,
    NumberFamily,
    SpanProblem,
    WindFamily,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

DEFAULT_NUMBERS = (
    "span.horizontal_tension",
    "span.length",
    ICE_MASS,
    "ice.first_moment",
    "ice.attack_angle_deg",
    "conductor.torsional_stiffness",
    "damping.translation",
    "damping.twist",
    "aerodynamics.lift",
    "aerodynamics.drag",
    "aerodynamics.moment",
    "supports.stiffness_x1",
    "supports.stiffness_x3",
)
NUMBERS_OF_LINES = (
    "section.horizontal_tension",
    *DEFAULT_NUMBERS[2:-2],
    "section.suspensions.0.length",
    "bundle.spacing",
)
"""Numbers that an engineer can change or does not know, of a span and of a line; those that a scene
lacks are left out."""

STEP = 1e-3
"""Step of a difference, relative to the number."""

STEPS = {"ice.attack_angle_deg": 0.02, ICE_MASS: 1e-3, TEMPERATURE: 0.01}
"""Steps of numbers that may be 0, in their units."""

Progress = Callable[[str], object]
"""Called with the name of the part that is computed."""


@dataclass(frozen=True, repr=False)
class Sensitivity(SavedTable):
    """Derivatives of events and motions of a span or line by numbers of its scene.

    Attributes
    ----------
    dataset : xarray.Dataset
        Over ``quantity`` and ``number``: ``derivative`` (unit of the quantity per unit of the
        number), ``relative`` (percent of the quantity per percent of the number; NaN for angles and
        for a value of 0), ``error`` (estimated relative error of the derivative). Over
        ``quantity``: its ``value``, ``unit``, ``branch``, ``motion``, ``at`` (the wind speed, or
        the number that is varied) and ``is_stable``; over ``number``: ``present`` value and
        ``number_unit``.
    remarks : tuple of str
        What could not be computed, and why.
    branches : Branches
        The motions.
    seconds : float
        CPU time [s] without that of the branches.
    """

    dataset: xr.Dataset
    remarks: tuple[str, ...]
    branches: Branches
    seconds: float

    def __repr__(self) -> str:
        data = self.dataset
        lines = [f"{data.attrs['title']}: percent per percent of each number"]
        for k in range(data.sizes["quantity"]):
            one = data.isel(quantity=k)
            parts = [
                f"{name} {value:+.3g}"
                for name, value in zip(
                    data["number"].values, one["relative"].values.tolist(), strict=True
                )
                if value == value
            ]
            lines.append(
                f"{one['quantity'].item()} = {one['value'].item():.4g} {one['unit'].item()}"
            )
            lines.append("    " + ", ".join(parts))
        return "\n".join([*lines, *self.remarks])


class Quantity(NamedTuple):
    """An event or a property of a motion, with its gradient.

    Attributes
    ----------
    name, unit : str
        Name in words, and unit.
    branch : int
        Number of the branch.
    at : float
        Value of the number that is varied.
    is_stable : bool
        Stability of the motion.
    gradient : Gradient
        Its gradient.
    explicit : callable or None
        Derivative of the quantity itself by another model, given the models and factors of a
        difference; None: it depends on the states only.
    """

    name: str
    unit: str
    branch: int
    at: float
    is_stable: bool
    gradient: Gradient
    explicit: Callable[[Sequence[tuple[SpanModel, float]]], float] | None = None


@one_thread
def sensitivity(
    scene: SceneLike | Branches,
    numbers: Sequence[str] | None = None,
    start: float | None = None,
    stop: float | None = None,
    *,
    progress: Progress | None = None,
) -> Sensitivity:
    """Differentiate onsets, amplitudes and growth of all motions by numbers of the scene.

    Parameters
    ----------
    scene
        The span or line, whose motions are sought over the wind speed by `modal.branches`; or the
        result of `modal.branches`, over any number.
    numbers
        Paths of numbers, as in `modal.ratio_map`; also factors, of which the present value is 1:
        ``damping.translation`` and ``damping.twist`` (on both ratios), ``aerodynamics.lift``,
        ``aerodynamics.drag`` and ``aerodynamics.moment`` (on the coefficient at all angles),
        ``ice.first_moment``. By default, those of `DEFAULT_NUMBERS`, of a line of
        `NUMBERS_OF_LINES`, that the scene has.
    start, stop
        Range of the wind speed, as in `modal.branches`.
    progress
        Called with the name of the part that is computed.

    Returns
    -------
    Sensitivity
        Derivatives of the wind speed of each event (Hopf, fold, period doubling, torus), and of the
        motions at the scene's wind: amplitudes at mid-span (of a line, of the span that moves most
        in this way), frequency, and the growth rate of the disturbance that grows most or decays
        least.

    Raises
    ------
    SceneError
        If the scene, the range or a number is not fit.

    Notes
    -----
    Of a span, tension and ice are varied as in `modal.ratio_map`: more ice on the strung conductor
    raises its tension. Of a line, the numbers are those of its strung state. Derivatives hold for
    small changes; `modal.measures` computes large ones again.

    Examples
    --------
    >>> import gallop_fmu as gf, modal
    >>> found = modal.sensitivity("example3", ["damping.translation"], 4.5, 4.8)
    >>> onset = found.dataset.isel(quantity=0, number=0)
    >>> f"{onset.value:.2f} m/s, {onset.relative:.2f} % per percent of damping"
    '4.59 m/s, 1.07 % per percent of damping'
    """
    shown = progress or (lambda name: None)
    if isinstance(scene, Branches):
        found = scene
        if start is not None or stop is not None:
            raise SceneError("start and stop belong to the branches, which are given: leave them")
    else:
        found = branches(
            scene,
            start=start,
            stop=stop,
            progress=lambda number, value: shown(f"branch {number}, {value:.3g} m/s"),
        )
    began = clock.process_time()
    paths = _chosen(found.scene, numbers, found.over)
    remarks: list[str] = []
    quantities = [*_events(found, remarks), *_motions(found, remarks)]
    values = np.full((2, len(quantities), len(paths)), np.nan)
    present = [number_of(found.scene, path) for path in paths]
    for k, (path, value) in enumerate(zip(paths, present, strict=True)):
        shown(path)
        step = STEPS.get(path, STEP * abs(value))
        for j, width in enumerate((step, 2.0 * step)):
            try:
                difference = _Difference(found, path, value, width)
            except (SceneError, SimulationError) as problem:
                remarks.append(f"{path}: no derivative, because {problem}")
                break
            values[j, :, k] = [difference.of(one) for one in quantities]
    dataset = sensitivity_table(found, quantities, paths, present, values)
    return Sensitivity(dataset, tuple(remarks), found, clock.process_time() - began)


def _chosen(scene: Scene | LineScene, numbers: Sequence[str] | None, over: str) -> list[str]:
    """Check the numbers, or choose those that the scene has."""
    chosen = []
    usual = NUMBERS_OF_LINES if isinstance(scene, LineScene) else DEFAULT_NUMBERS
    for path in usual if numbers is None else numbers:
        try:
            value = number_of(scene, path)
        except SceneError:
            if numbers is None:
                continue
            raise
        if path == over:
            if numbers is None:
                continue
            raise SceneError(f"{path}: the branches are over this number; choose others")
        if numbers is None and value == 0.0 and path not in STEPS:
            continue
        chosen.append(path)
    if not chosen:
        raise SceneError("numbers is empty: give at least one")
    return chosen


class _Difference:
    """The span with several values of a number, and the factors of a difference.

    The difference is central; at a number that cannot be less, such as no ice, it is that of the
    parabola through the number and two greater values.
    """

    def __init__(self, found: Branches, path: str, value: float, step: float) -> None:
        self.found, self.path = found, path
        parts: tuple[tuple[float, float], ...] = ((-1.0, -0.5), (1.0, 0.5))
        if path == ICE_MASS and value < 2.0 * step:
            parts = ((0.0, -1.5), (1.0, 2.0), (2.0, -0.5))
        self.problems = [
            (self._problem(self._model(value + part * step)), factor / step)
            for part, factor in parts
        ]

    def _model(self, value: float) -> SpanModel:
        base = _base(self.found).model
        scene = varied(self.found.scene, self.path, value)
        return similar_model(scene, base)

    def _problem(self, model: SpanModel) -> SpanProblem:
        base, over = _base(self.found), self.found.over
        family: Family
        if over == WIND_SPEED:
            family = WindFamily(model)
        else:
            old = base.family
            assert isinstance(old, NumberFamily)
            family = NumberFamily(model.scene, over, base.model, old.step)
        return SpanProblem(family, base.model, self.found.scene.wind.mean_speed or 1.0)

    def of(self, quantity: Quantity) -> float:
        """Derivative of a quantity."""
        whole = quantity.gradient.by_number(self.problems)
        if quantity.explicit is not None:
            models = [
                (problem.family.at(quantity.at)[0], factor) for problem, factor in self.problems
            ]
            whole += quantity.explicit(models)
        return whole


def _base(found: Branches) -> SpanProblem:
    problem = found.diagram.branches[0].points[0].equations.problem
    assert isinstance(problem, SpanProblem)
    return problem


def _events(found: Branches, remarks: list[str]) -> list[Quantity]:
    """Parameters of all events whose derivatives are known."""
    quantities = []
    names = found.dataset["name"].values.tolist()
    for number, branch in enumerate(found.diagram.branches):
        for event in branch.events:
            if event.kind not in gradients.KINDS:
                continue
            name = f"{event.kind} of branch {number} ({names[number]})" + _begins(found, event)
            try:
                gradient = gradients.onset(event)
            except ContinuationError as problem:
                remarks.append(f"{name}: no derivative, because {problem}")
                continue
            at = event.parameter
            quantities.append(
                Quantity(name, found.unit, number, at, event.point.is_stable, gradient)
            )
    return quantities


def _begins(found: Branches, event: Event) -> str:
    """Name of the motion that begins at an event; empty if none was followed."""
    for branch, name in zip(found.diagram.branches, found.dataset["name"].values, strict=True):
        if branch.origin is event:
            return f", begin of {name}"
    return ""


def _motions(found: Branches, remarks: list[str]) -> list[Quantity]:
    """Properties of all motions at the scene's value of the number that is varied."""
    quantities: list[Quantity] = []
    at = number_of(found.scene, found.over)
    names = found.dataset["name"].values.tolist()
    values = found.dataset["value"]
    if not values.min() <= at <= values.max():
        remarks.append(
            f"{found.over} = {at:g} {found.unit} is outside of the range of the branches, so that"
            " only events are differentiated"
        )
    for number, branch in enumerate(found.diagram.branches):
        for pair in pairwise(branch.points):
            if (pair[0].parameter - at) * (pair[1].parameter - at) > 0.0:
                continue
            name = f"branch {number} ({names[number]})"
            try:
                point = _point_at(*pair, at)
                quantities += _of_motion(name, number, point)
            except ContinuationError as problem:
                remarks.append(f"{name} at {at:g} {found.unit}: no derivative, because {problem}")
    return quantities


def _point_at(first: Point, following: Point, value: float) -> Point:
    """Solution at a value of the parameter between two neighbouring points."""
    span = following.parameter - first.parameter
    part = 0.0 if span == 0.0 else (value - first.parameter) / span
    near, other = (first, following) if part < 0.5 else (following, first)
    equations = near.equations
    assert isinstance(equations, OrbitEquations | EquilibriumEquations)
    away = other.x
    if isinstance(equations, OrbitEquations):
        assert isinstance(other.equations, OrbitEquations)
        away = other.equations.transferred(away, equations)
    share = part if near is first else 1.0 - part
    hold = np.zeros_like(near.x)
    hold[-1] = unit = equations.parameter_scale
    stepper = Stepper(Settings(0.0, unit))
    distance = (value - near.parameter) / unit
    return stepper.correct(equations, near.x + share * (away - near.x), near.x, hold, distance)


def _of_motion(name: str, branch: int, point: Point) -> list[Quantity]:
    """Amplitudes, frequency and growth of a motion."""
    problem = point.equations.problem
    assert isinstance(problem, SpanProblem)
    stable, at = point.is_stable, point.parameter

    def made(what: str, unit: str, gradient: Gradient) -> Quantity:
        return Quantity(f"{what} of {name}", unit, branch, at, stable, gradient)

    found = []
    if point.equations.kind == "orbit":
        model, _ = problem.family.at(at)
        for what, watched in _moving(point, model):
            weights = np.append(watched.weights(model), np.zeros(model.size))
            low, high = gradients.extreme_states(point, weights)
            half = 0.5 * (high - low)[: model.size]

            def explicit(
                models: Sequence[tuple[SpanModel, float]],
                half: Array = half,
                watched: _Displacement = watched,
            ) -> float:
                return float(sum(factor * watched.weights(one) @ half for one, factor in models))

            gradient = gradients.amplitude(point, weights)
            found.append(made(what, "m", gradient)._replace(explicit=explicit))
        frequency = gradients.period(point).times(-1.0 / point.period**2)
        found.append(made("frequency", "Hz", replace(frequency, value=1.0 / point.period)))
    found.append(made("growth rate", "1/s", gradients.growth(point)))
    return found


AMPLITUDES = {"vertical": "u2", "horizontal": "u3", "two-loop": "quarter", "clamp": "clamp"}
"""Amplitudes, and their names in `SpanModel.watched_at`: at mid-span, antisymmetric vertical motion
at the quarter points, and clamps of strings across the line."""

MIN_AMPLITUDE = 0.01
"""Amplitude, relative to the largest, below which one is left out."""


class _Displacement(NamedTuple):
    """A displacement of `SpanModel.watched_at`, linear in the coordinates.

    Attributes
    ----------
    name : str
        Its name there.
    place : int
        Number of the span or tower, from 0.
    """

    name: str
    place: int

    def weights(self, model: SpanModel) -> Array:
        """Weights of the coordinates."""
        watched = model.watched_at(np.eye(model.size))
        return np.asarray(getattr(watched, self.name)[:, self.place])


def _moving(point: Point, model: SpanModel) -> list[tuple[str, _Displacement]]:
    """Amplitudes that are not small beside the largest, where each is largest."""
    q = point.states[:, : model.size]
    watched = model.watched_at(q)
    largest = []
    for what, name in AMPLITUDES.items():
        sizes = np.ptp(getattr(watched, name), axis=0)
        if sizes.size:
            place = int(np.argmax(sizes))
            where = f"{what} amplitude"
            if sizes.size > 1 or name == "clamp":
                where += f" at tower {place + 1}" if name == "clamp" else f" in span {place + 1}"
            largest.append((where, _Displacement(name, place), float(sizes[place])))
    most = max(size for _, _, size in largest)
    return [(what, one) for what, one, size in largest if size >= MIN_AMPLITUDE * most]
