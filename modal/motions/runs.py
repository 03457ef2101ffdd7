"""Simulations with the full model from the motions of all branches."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene
from modal.continuation.branch import Branch
from modal.continuation.diagram import Diagram
from modal.motions.full_model import FullRun, full_scene, run_from
from modal.motions.span_problem import SpanProblem

Array = NDArray[np.float64]

PERIODS = 500
"""Duration of a run in periods of the first vertical mode."""

DISTURBANCE = 0.03
"""Disturbance of the first symmetric and antisymmetric vertical and horizontal modes at the start,
relative to their typical amplitude."""


class BranchRun(NamedTuple):
    """A simulation that starts on a motion of a branch.

    Attributes
    ----------
    branch : int
        Number of the branch.
    value : float
        The number that is varied.
    is_stable : bool
        Stability of the motion from which it starts.
    end : FullRun
        Motion at the end.
    """

    branch: int
    value: float
    is_stable: bool
    end: FullRun


def runs_from_orbits(
    scene: Scene | LineScene,
    over: str,
    problem: SpanProblem,
    found: Diagram,
    count: int,
    progress: Callable[[int, float], object] | None = None,
) -> list[BranchRun]:
    """Run the full model from so many points of both parts, stable and unstable, of each branch.

    ``progress`` is called with the number of the branch and the value before each run.
    """
    runs = []
    for number, branch in enumerate(found.branches):
        for k in _chosen(branch, count):
            point = branch.points[k]
            if progress is not None:
                progress(number, point.parameter)
            model, _ = problem.family.at(point.parameter)
            state = point.states[0] + _disturbance(problem)
            end, _, _ = run_from(
                full_scene(scene, over, point.parameter, model), model, state, PERIODS
            )
            runs.append(BranchRun(number, point.parameter, point.is_stable, end))
    return runs


def _chosen(branch: Branch, count: int) -> list[int]:
    """Indices of so many points with values at equal distances, in each part."""
    chosen: set[int] = set()
    for is_stable in (True, False):
        part = [k for k, point in enumerate(branch.points) if point.is_stable == is_stable]
        if part:
            values = np.array([branch.points[k].parameter for k in part])
            wanted = np.linspace(values.min(), values.max(), count + 2)[1:-1]
            chosen |= {part[int(np.argmin(np.abs(values - value)))] for value in wanted}
    return sorted(chosen)


def _disturbance(problem: SpanProblem) -> Array:
    """Small displacement of the lowest mode of each part of the motion but twist."""
    model, change = problem.model, np.zeros(problem.size)
    for family, alike in model.groups():
        if family != "torsional":
            change[alike[0]] = DISTURBANCE * problem.scale[alike[0]]
    return change
