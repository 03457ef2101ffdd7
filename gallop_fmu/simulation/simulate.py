"""simulate(scene): from a validated scene of a span or line to histories."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Literal, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import LineMap
from gallop_fmu.engine.model import Model, Part, State
from gallop_fmu.engine.pack import Packed
from gallop_fmu.foundation.channels import LINE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Outcome, Report, SimulationError
from gallop_fmu.input.scene_like import SceneLike, as_scene
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.line_result import LineResult, line_histories
from gallop_fmu.simulation.provenance import Histories, Provenance, histories
from gallop_fmu.simulation.recording import (
    Recording,
    Values,
    line_recording,
    rest_values,
    span_recording,
)
from gallop_fmu.simulation.result import Result
from gallop_fmu.simulation.run_options import (
    RecordingPlan,
    check_channels,
    check_on_failure,
    chosen_nodes,
    chosen_threads,
)
from gallop_fmu.simulation.shedding import with_sheddings

Array = NDArray[np.float64]

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

FIRST_PORTION = 30_000
"""Time steps times elements before the first call, when their cost is not yet known."""


@overload
def simulate(
    scene: Scene,
    stop_time: float | None = ...,
    *,
    record_every: int | None = ...,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = ...,
    channels: Sequence[str] = ...,
    span_channels: Sequence[str] | None = ...,
    progress: Progress | None = ...,
    on_failure: Literal["raise", "return"] = ...,
    threads: int | None = ...,
) -> Result: ...


@overload
def simulate(
    scene: LineScene,
    stop_time: float | None = ...,
    *,
    record_every: int | None = ...,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = ...,
    channels: Sequence[str] = ...,
    span_channels: Sequence[str] | None = ...,
    progress: Progress | None = ...,
    on_failure: Literal["raise", "return"] = ...,
    threads: int | None = ...,
) -> LineResult: ...


@overload
def simulate(
    scene: SceneLike,
    stop_time: float | None = ...,
    *,
    record_every: int | None = ...,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = ...,
    channels: Sequence[str] = ...,
    span_channels: Sequence[str] | None = ...,
    progress: Progress | None = ...,
    on_failure: Literal["raise", "return"] = ...,
    threads: int | None = ...,
) -> Result | LineResult: ...


def simulate(  # noqa: PLR0913 - all but two are keyword arguments
    scene: SceneLike,
    stop_time: float | None = None,
    *,
    record_every: int | None = None,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = "midspan",
    channels: Sequence[str] = USUAL_CHANNELS,
    span_channels: Sequence[str] | None = None,
    progress: Progress | None = None,
    on_failure: Literal["raise", "return"] = "raise",
    threads: int | None = None,
) -> Result | LineResult:
    """Simulate the motion of a span or line.

    Parameters
    ----------
    scene
        A scene, the name of a packaged one (`gallop_fmu.packaged_scenes`), or the path of a scene
        file.
    stop_time
        Simulated time [s] (default: from the scene). The run ends at the first record at or after
        it.
    record_every
        Number of time steps from one record to the next (default: from the scene).
    record_nodes
        ``"midspan"`` (of a line: of each conductor in each span, and all clamps), ``"all"``, or
        node numbers from 0, the left support.
    channels
        Node channels to record, by name (see `gallop_fmu.foundation.channels.NODE_CHANNELS`).
    span_channels
        Channels of the span or line to record, by name (see `SPAN_CHANNELS` and `LINE_CHANNELS` of
        `gallop_fmu.foundation.channels`; default: all); ``()`` for none, which is faster.
    progress
        Called about ten times a second with the time reached and the stop time [s]; returning False
        stops the run.
    on_failure
        For a run that ends early or cannot start: ``"raise"`` raises an error whose ``result`` has
        the histories until then, ``"return"`` returns them; ``result.outcome`` is the reason. If
        the run could not start, ``result.started`` is False and the only record is NaN.
    threads
        1 or 2 threads, with the same results to the last bit (default: 2 for a line of 400
        elements or more, if two cores are available and this is not a worker process). A second
        thread needs a line of 60 elements or more, and more than one conductor or span.

    Returns
    -------
    Result or LineResult
        Histories with units, outcome and provenance.

    Raises
    ------
    SceneError
        An argument is not allowed.
    SimulationError
        The run cannot start or ends early, and `on_failure` is ``"raise"``.
    """
    scene = as_scene(scene)
    plan = RecordingPlan.from_scene(scene, stop_time, record_every)
    is_line = isinstance(scene, LineScene)
    check_channels(channels, span_channels or (), LINE_INDEX if is_line else SPAN_INDEX)
    check_on_failure(on_failure)
    started = clock.perf_counter()
    packed = Packed(scene)
    mapped = packed.map
    threads = chosen_threads(threads, mapped.elements)
    usual = mapped.usual_nodes if is_line else np.array([mapped.chains[0].middle], dtype=np.int32)
    nodes = chosen_nodes(record_nodes, usual, mapped.nodes)
    recording = (
        line_recording(mapped, nodes, channels, span_channels)
        if is_line
        else span_recording(
            mapped, nodes, channels, tuple(SPAN_INDEX) if span_channels is None else span_channels
        )
    )
    run = _Run(scene, mapped, nodes, recording, plan)
    model = None
    try:
        model = Model(scene, inputs=False, packed=packed)
        state = model.start()
    except SimulationError as problem:
        seconds = clock.perf_counter() - started
        result = run.result(model, recording.unknown(), problem.report, seconds)
        if on_failure == "raise":
            raise SimulationError(problem.report, result) from None
        return result

    def record(records: int, first: int) -> tuple[Array, Report]:
        return state.record(records, plan.stride, recording.probes, first, threads)

    first = state.observe(recording.probes)[np.newaxis]
    portion = max(1, FIRST_PORTION // (mapped.elements * plan.stride))
    records, report = _march(record, first, plan, portion, progress)
    seconds = clock.perf_counter() - started
    result = run.result(model, recording.values(records), report, seconds, state)
    if report.outcome is not Outcome.COMPLETED and on_failure == "raise":
        raise SimulationError(report, result)
    return result


class _Run(NamedTuple):
    """What is recorded of which scene."""

    scene: Scene | LineScene
    mapped: LineMap
    nodes: NDArray[np.int32]
    recording: Recording
    plan: RecordingPlan

    def result(
        self,
        model: Model | None,
        values: Values,
        report: Report,
        seconds: float,
        state: State | None = None,
    ) -> Result | LineResult:
        """Return the result of a run with its provenance; without a model there is one record."""
        scene, nodes = self.scene, self.nodes
        equilibrium = None if model is None else model.equilibrium()
        provenance = Provenance(scene, equilibrium, report, seconds, _details(scene, model))
        count = len(next(iter(values.values()))[1])
        time = self.plan.interval * np.arange(count, dtype=np.float64)
        x = equilibrium.x[nodes] if equilibrium else np.full((len(nodes), 3), np.nan)
        if isinstance(scene, LineScene):
            static = {} if model is None else rest_values(self.recording, model)
            dataset = line_histories({**values, **static}, time, nodes, x, self.mapped, provenance)
            dataset = with_sheddings(dataset, self.mapped, self.recording, state)
            return LineResult(dataset, scene, report)
        make = partial(histories, values, time, nodes, x[:, 0], provenance)
        if scene.shedding:
            return Result(with_sheddings(make(), self.mapped, self.recording, state), scene, report)
        found = Histories(
            time=time,
            nodes=nodes,
            values={name: content for name, (_, content) in values.items()},
            facts=provenance.facts(),
            dataset=make,
        )
        return Result.of_histories(found, scene, report)


def _details(scene: Scene | LineScene, model: Model | None) -> dict[str, str]:
    """Return integrator and coefficient curve; of a model the unknowns and inactive terms."""
    return {
        "integrator": INTEGRATORS[scene.numerics.method].description,
        "coefficient_curve": scene.aerodynamics.label if scene.aerodynamics else "",
        "unknowns": "" if model is None else " ".join(model.unknowns),
        "inactive_terms": "" if model is None else _inactive_terms(int(model.parts)),
    }


@cache
def _inactive_terms(parts: int) -> str:
    """Return the names of the parts that a model does not have."""
    inactive = [part for part in Part if part not in Part(parts)]
    return ", ".join(str(part.name).lower().replace("_", " ") for part in inactive)


def _march(
    record: Callable[[int, int], tuple[Array, Report]],
    first: Array,
    plan: RecordingPlan,
    portion: int,
    progress: Progress | None,
) -> tuple[Array, Report]:
    """Run in portions of about `PROGRESS_INTERVAL`, to show progress and to stop on Ctrl-C."""
    done = 0
    parts, report = [first], Report(Outcome.COMPLETED, 0.0)
    while done < plan.count:
        began = clock.perf_counter()
        try:
            part, report = record(min(portion, plan.count - done), done)
            parts.append(part)
            if report.outcome is not Outcome.COMPLETED:
                break
            done += len(part)
            stopped = (
                progress is not None and progress(done * plan.interval, plan.stop_time) is False
            )
        except KeyboardInterrupt:
            stopped = True
        if stopped and done < plan.count:
            report = replace(report, outcome=Outcome.STOPPED_BY_USER, time=done * plan.interval)
            break
        pace = (clock.perf_counter() - began) / PROGRESS_INTERVAL
        portion = max(1, min(int(portion / max(pace, 1e-3)), 10 * portion))
    return np.concatenate(parts), report
