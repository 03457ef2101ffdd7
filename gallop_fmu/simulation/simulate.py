"""simulate(scene): from a validated scene to histories."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.model import Model, Part, Run
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Outcome, Report, SimulationError
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.result import Provenance, Result, histories
from gallop_fmu.simulation.run_options import (
    RecordingPlan,
    check_channels,
    check_on_failure,
    chosen_nodes,
)

if TYPE_CHECKING:
    import xarray as xr

USUAL_CHANNELS = (
    "u1",
    "u2",
    "u3",
    "theta",
    "v1",
    "v2",
    "v3",
    "omega",
    "tension",
    "angle_of_attack",
)
"""Default node channels to record."""

Progress = Callable[[float, float], object]
"""Called with the time reached and the stop time [s]; returning False stops the run."""

PROGRESS_INTERVAL = 0.1
"""Approximate wall-clock time [s] between two calls of the progress function."""

FIRST_PORTION = 500
"""Time steps before the first call, when their cost is not yet known."""


def simulate(
    scene: Scene,
    stop_time: float | None = None,
    *,
    record_every: int | None = None,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = "midspan",
    channels: Sequence[str] = USUAL_CHANNELS,
    span_channels: Sequence[str] = tuple(SPAN_INDEX),
    progress: Progress | None = None,
    on_failure: Literal["raise", "return"] = "raise",
) -> Result:
    """Simulate the motion of a span.

    Parameters
    ----------
    scene
        The scene, see `gallop_fmu.load_scene`.
    stop_time
        Simulated time [s] (default: from the scene). The run ends at the first record at or after
        it.
    record_every
        Number of time steps from one record to the next (default: from the scene).
    record_nodes
        ``"midspan"``, ``"all"``, or node numbers from 0 (left support) to twice the number of
        elements (right support).
    channels
        Node channels to record, by name (see `gallop_fmu.foundation.channels.NODE_CHANNELS`).
    span_channels
        Span channels to record, by name (see `gallop_fmu.foundation.channels.SPAN_CHANNELS`);
        ``()`` for none, which is faster.
    progress
        Called about ten times a second with the time reached and the stop time [s]; returning False
        stops the run.
    on_failure
        For a run that ends early or cannot start: ``"raise"`` raises an error whose ``result`` has
        the histories until then, ``"return"`` returns them; ``result.outcome`` is the reason. If
        the run could not start, ``result.started`` is False and the only record is NaN.

    Returns
    -------
    Result
        Histories with units, outcome and provenance.

    Raises
    ------
    SceneError
        An argument is not allowed.
    SimulationError
        The run cannot start or ends early, and `on_failure` is ``"raise"``.
    """
    plan = RecordingPlan.from_scene(scene, stop_time, record_every)
    check_channels(channels, span_channels)
    check_on_failure(on_failure)
    started = clock.perf_counter()
    nodes = chosen_nodes(record_nodes, scene.numerics.elements)
    model = None
    try:
        model = Model(scene, inputs=False)
        state = model.start()
    except SimulationError as problem:
        seconds = clock.perf_counter() - started
        result = _not_started(
            scene, model, nodes, (channels, span_channels), problem.report, seconds
        )
        if on_failure == "raise":
            raise SimulationError(problem.report, result) from None
        return result
    channel_index = np.array([NODE_INDEX[name] for name in channels], dtype=np.int32)
    span_index = np.array([SPAN_INDEX[name] for name in span_channels], dtype=np.int32)
    first = Run(
        np.array([state.observe_node(int(node))[channel_index] for node in nodes]).T[np.newaxis],
        state.observe_span()[np.newaxis, span_index],
        Report(Outcome.COMPLETED, 0.0),
    )
    record = partial(
        state.run,
        every=plan.stride,
        channels=channel_index,
        nodes=nodes,
        span_channels=span_index,
    )
    parts, report = _march(record, [first], plan, progress)
    seconds = clock.perf_counter() - started
    dataset = _dataset(model, parts, nodes, channels, span_channels, plan.interval, report, seconds)
    result = Result(dataset, scene, report)
    if report.outcome is not Outcome.COMPLETED and on_failure == "raise":
        raise SimulationError(report, result)
    return result


def _not_started(
    scene: Scene,
    model: Model | None,
    nodes: NDArray[np.int32],
    channels: tuple[Sequence[str], Sequence[str]],
    report: Report,
    seconds: float,
) -> Result:
    """Return a result without an initial state: one record at 0 s, all NaN."""
    variables: dict[str, tuple[tuple[str, ...], NDArray[np.float64]]] = {
        name: (("time", "node"), np.full((1, len(nodes)), math.nan)) for name in channels[0]
    }
    variables |= {name: (("time",), np.full(1, math.nan)) for name in channels[1]}
    equilibrium = None if model is None else model.equilibrium()
    x1 = np.full(len(nodes), math.nan) if equilibrium is None else equilibrium.x[nodes, 0]
    provenance = Provenance(scene, equilibrium, report, seconds, _details(scene, model))
    return Result(histories(variables, np.zeros(1), nodes, x1, provenance), scene, report)


def _details(scene: Scene, model: Model | None) -> dict[str, str]:
    """Return the integrator, and the unknowns and inactive terms of a model, if there is one."""
    inactive = [] if model is None else [part for part in Part if part not in model.parts]
    return {
        "integrator": INTEGRATORS[scene.numerics.method].description,
        "unknowns": "" if model is None else " ".join(model.unknowns),
        "inactive_terms": ", ".join(str(part.name).lower().replace("_", " ") for part in inactive),
    }


def _march(
    record: Callable[..., Run],
    parts: list[Run],
    plan: RecordingPlan,
    progress: Progress | None,
) -> tuple[list[Run], Report]:
    """Run in portions of about `PROGRESS_INTERVAL`, to show progress and to stop on Ctrl-C."""
    done, portion = 0, max(1, FIRST_PORTION // plan.stride)
    report = parts[0].report
    while done < plan.count:
        began = clock.perf_counter()
        try:
            part = record(min(portion, plan.count - done), first=done)
            parts.append(part)
            report = part.report
            if report.outcome is not Outcome.COMPLETED:
                break
            done += len(part.node_values)
            stopped = (
                progress is not None and progress(done * plan.interval, plan.stop_time) is False
            )
        except KeyboardInterrupt:
            stopped = True
        if stopped and done < plan.count:
            return parts, replace(
                report, outcome=Outcome.STOPPED_BY_USER, time=done * plan.interval
            )
        pace = (clock.perf_counter() - began) / PROGRESS_INTERVAL
        portion = max(1, min(int(portion / max(pace, 1e-3)), 10 * portion))
    return parts, report


def _dataset(
    model: Model,
    parts: list[Run],
    nodes: NDArray[np.int32],
    channels: Sequence[str],
    span_channels: Sequence[str],
    interval: float,
    report: Report,
    seconds: float,
) -> xr.Dataset:
    node_values = np.concatenate([part.node_values for part in parts])
    span_values = np.concatenate([part.span_values for part in parts])
    variables: dict[str, tuple[tuple[str, ...], NDArray[np.float64]]] = {}
    for index, name in enumerate(channels):
        variables[name] = (("time", "node"), np.ascontiguousarray(node_values[:, index]))
    for index, name in enumerate(span_channels):
        variables[name] = (("time",), np.ascontiguousarray(span_values[:, index]))
    equilibrium = model.equilibrium()
    scene = one_span(model.scene, "simulate")
    details = _details(scene, model)
    provenance = Provenance(scene, equilibrium, report, seconds, details)
    time = interval * np.arange(len(node_values))
    return histories(variables, time, nodes, equilibrium.x[nodes, 0], provenance)
