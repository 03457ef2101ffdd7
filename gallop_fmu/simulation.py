"""simulate(scene): from a validated scene to labelled histories."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.channels import NODE_CHANNELS, NODE_INDEX, SPAN_CHANNELS, SPAN_INDEX
from gallop_fmu.engine import Model, Part, Run, build
from gallop_fmu.errors import SceneError
from gallop_fmu.integrators import INTEGRATORS
from gallop_fmu.outcome import Outcome, Report, SimulationError
from gallop_fmu.result import Result
from gallop_fmu.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

USUAL_CHANNELS = ("u1", "u2", "u3", "theta", "v1", "v2", "v3", "omega", "tension", "angle_of_attack")
"""Node channels recorded unless others are asked for."""

Progress = Callable[[float, float], object]
"""Called with the time reached and the stop time [s]; returning False stops the run."""

BETWEEN_CALLS = 0.1
"""Wall-clock time [s] between two calls of the progress function, about."""


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
    """Compute the motion of a span.

    Parameters
    ----------
    scene
        What to compute, see `gallop_fmu.load_scene`.
    stop_time
        Simulated time [s]; None takes the scene's.  The run ends at the first record at or after it.
    record_every
        Time steps from one record to the next; None takes the scene's.
    record_nodes
        ``"midspan"``, ``"all"``, or node numbers from 0 (left support) to 2 elements (right support).
    channels
        Node channels to record, by name (see `gallop_fmu.channels.NODE_CHANNELS`).
    span_channels
        Span channels to record, by name (see `gallop_fmu.channels.SPAN_CHANNELS`); ``()`` for none, which is cheaper.
    progress
        Called about ten times a second with the time reached and the stop time [s]; returning False stops the run.
    on_failure
        ``"raise"``: a run that ends early raises, with what was computed in the error's ``result``;
        ``"return"``: it is returned, and ``result.outcome`` tells.

    Returns
    -------
    Result
        Histories with units, outcome and provenance.

    Raises
    ------
    SceneError
        If an argument is not allowed.
    SimulationError
        If no initial equilibrium exists, or the run ends early and `on_failure` is ``"raise"``.
    """
    stop_time = scene.run.stop_time if stop_time is None else stop_time
    every = scene.run.record_every if record_every is None else record_every
    check_arguments(stop_time, every, channels, on_failure)
    check_span_channels(span_channels)
    started = clock.perf_counter()
    model = Model(scene, inputs=False)
    nodes = chosen_nodes(record_nodes, model.elements)
    state = model.start()
    interval = every * scene.numerics.time_step
    records = max(1, math.ceil(stop_time / interval - 1e-9))
    channel_index = np.array([NODE_INDEX[name] for name in channels], dtype=np.int32)
    span_index = np.array([SPAN_INDEX[name] for name in span_channels], dtype=np.int32)
    first = Run(
        np.array([state.observe_node(int(node))[channel_index] for node in nodes]).T[np.newaxis],
        state.observe_span()[np.newaxis, span_index],
        Report(Outcome.COMPLETED, 0.0),
    )
    record = partial(state.run, every=every, channels=channel_index, nodes=nodes, span_channels=span_index)
    parts, report = _march(record, [first], records, every, interval, stop_time, progress)
    seconds = clock.perf_counter() - started
    result = Result(_dataset(model, parts, nodes, channels, span_channels, interval, report, seconds), scene, report)
    if report.outcome is not Outcome.COMPLETED and on_failure == "raise":
        raise SimulationError(report, result)
    return result


def _march(
    record: Callable[..., Run],
    parts: list[Run],
    records: int,
    every: int,
    interval: float,
    stop_time: float,
    progress: Progress | None,
) -> tuple[list[Run], Report]:
    """Run in portions of about `BETWEEN_CALLS`, so that progress is shown and Ctrl-C is heard."""
    done, portion = 0, max(1, 500 // every)
    report = parts[0].report
    while done < records:
        began = clock.perf_counter()
        try:
            part = record(min(portion, records - done), first=done)
            parts.append(part)
            report = part.report
            if report.outcome is not Outcome.COMPLETED:
                break
            done += len(part.node_values)
            stopped = progress is not None and progress(done * interval, stop_time) is False
        except KeyboardInterrupt:
            stopped = True
        if stopped and done < records:
            return parts, replace(report, outcome=Outcome.STOPPED_BY_USER, time=done * interval)
        pace = (clock.perf_counter() - began) / BETWEEN_CALLS
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
    import xarray as xr  # a third of a second, which `import gallop_fmu` should not cost

    node_values = np.concatenate([part.node_values for part in parts])
    span_values = np.concatenate([part.span_values for part in parts])
    time = interval * np.arange(len(node_values))
    described = {channel.name: channel for channel in (*NODE_CHANNELS, *SPAN_CHANNELS)}
    variables: dict[str, tuple[tuple[str, ...], NDArray[np.float64]]] = {}
    for index, name in enumerate(channels):
        variables[name] = (("time", "node"), np.ascontiguousarray(node_values[:, index]))
    for index, name in enumerate(span_channels):
        variables[name] = (("time",), np.ascontiguousarray(span_values[:, index]))
    equilibrium = model.equilibrium()
    dataset = xr.Dataset(variables, {"time": time, "node": nodes, "x1": ("node", equilibrium.x[nodes, 0])})
    dataset.time.attrs.update(units="s", long_name="time")
    dataset.x1.attrs.update(units="m", long_name="position of the node along the span")
    for name in variables:
        dataset[name].attrs.update(units=described[name].unit, long_name=described[name].meaning)
    dataset.attrs.update(
        title=model.scene.title,
        source=f"gallop-fmu {version('gallop-fmu')}",
        kernel=build(),
        integrator=INTEGRATORS[model.scene.numerics.method].description,
        unknowns=" ".join(model.unknowns),
        left_out=", ".join(str(part.name).lower().replace("_", " ") for part in Part if part not in model.parts),
        scene=model.scene.to_toml(),
        outcome=report.outcome.name.lower(),
        message=str(report),
        seconds=seconds,
        sag=equilibrium.sag,
        horizontal_tension=equilibrium.horizontal_tension,
        held_imbalance=equilibrium.imbalance,
        steps=report.steps,
        substeps=report.substeps,
        iterations=report.iterations,
        refactorisations=report.refactorisations,
        halvings=report.halvings,
        rejections=report.rejections,
        lowest_tension=report.lowest_tension,
        largest_turn=report.largest_turn,
    )
    return dataset


def check_arguments(stop_time: float, every: int, channels: Sequence[str], on_failure: str) -> None:
    """Raise SceneError on arguments of a run that are not allowed."""
    if not (math.isfinite(stop_time) and stop_time > 0.0):
        raise SceneError(f"stop_time = {stop_time}: must be a positive number of seconds")
    if isinstance(every, bool) or not isinstance(every, int) or every < 1:
        raise SceneError(f"record_every = {every}: must be a whole number of time steps, 1 or more")
    unknown = [name for name in channels if name not in NODE_INDEX]
    if unknown or not channels:
        raise SceneError(f"channels {unknown} do not exist; there are {', '.join(NODE_INDEX)}")
    if on_failure not in ("raise", "return"):
        raise SceneError(f'on_failure = {on_failure!r}: must be "raise" or "return"')


def check_span_channels(names: Sequence[str]) -> None:
    """Raise SceneError if one of them does not exist."""
    unknown = [name for name in names if name not in SPAN_INDEX]
    if unknown:
        raise SceneError(f"span_channels {unknown} do not exist; there are {', '.join(SPAN_INDEX)}")


def chosen_nodes(wanted: Literal["midspan", "all"] | Sequence[int], elements: int) -> NDArray[np.int32]:
    """Numbers of the nodes to record on a mesh of so many elements."""
    last = 2 * elements
    if isinstance(wanted, str):
        if wanted not in ("midspan", "all"):
            raise SceneError(f'record_nodes = {wanted!r}: must be "midspan", "all" or node numbers')
        return np.array([elements] if wanted == "midspan" else range(last + 1), dtype=np.int32)
    nodes = np.array(wanted, dtype=np.int32)
    if nodes.ndim != 1 or not len(nodes) or np.any((nodes < 0) | (nodes > last)):
        raise SceneError(f"record_nodes = {list(wanted)}: must be node numbers from 0 to {last}")
    return nodes
