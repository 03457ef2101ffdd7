"""sweep(scene, over): simulate many scenes and summarise each in a row."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.histories import history_sizes
from gallop_fmu.foundation.channels import END_FORCES
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.clearance import cigre_322_single_loop, davison_single_loop
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.oscillation import measure_all
from gallop_fmu.simulation.result import Result
from gallop_fmu.simulation.run_options import check_model, check_stop_time
from gallop_fmu.simulation.simulate import simulate
from gallop_fmu.sweeps.cases import Cases, SpanTable, cases
from gallop_fmu.sweeps.line_rows import LINE_COLUMNS, line_motion, recording_of_line
from gallop_fmu.sweeps.pool import Kind
from gallop_fmu.sweeps.rows import Row
from gallop_fmu.sweeps.runner import CarryOn, Progress, compute, one_by_one
from gallop_fmu.sweeps.runs import Runs
from gallop_fmu.sweeps.shedding_rows import SHEDDING_COLUMNS, shedding_columns

Summary = Callable[[Any], Mapping[str, Any]]
"""Function from a `Result`, of a line a `LineResult`, to the columns of its row."""

CHANNELS = ("u2", "u3", "theta", "tension")
RECORDED: dict[str, Any] = {"channels": (*CHANNELS, "v2", "v3")}
"""What is recorded of a span for any summary, as arguments of `simulate`."""
SUMMARISED: dict[str, Any] = {**RECORDED, "span_channels": END_FORCES}
"""The same for `steady_motion`, which reads no energies."""

_MOTIONS = {
    "u2": ("m", "vertical"),
    "u3": ("m", "horizontal"),
    "theta": ("rad", "twist"),
    "tension": ("N", "tension"),
}
SUMMARY_COLUMNS: dict[str, tuple[str, str]] = {
    "sag": ("m", "sag of the initial equilibrium"),
    "horizontal_tension": ("N", "horizontal tension of the initial equilibrium"),
    "time": ("s", "simulated time"),
    "motion": (
        "",
        "motion of the span in the window at the end: steady, still growing, turned over, ...",
    ),
}
for _name, (_unit, _meaning) in _MOTIONS.items():
    SUMMARY_COLUMNS |= {
        f"{_name}_amplitude": (
            _unit,
            f"{_meaning} at mid-span, half peak-to-peak of the motion in the window",
        ),
        f"{_name}_mean": (_unit, f"{_meaning} at mid-span, mean of the motion in the window"),
        f"{_name}_frequency_hz": (
            "Hz",
            f"{_meaning} at mid-span, dominant frequency of the motion in the window",
        ),
        f"{_name}_lowest": (_unit, f"{_meaning} at mid-span, minimum of the whole run"),
        f"{_name}_highest": (_unit, f"{_meaning} at mid-span, maximum of the whole run"),
    }
SUMMARY_COLUMNS |= {
    "lowest_tension": ("N", "minimum tension along the span in the whole run"),
    "support_force_highest": (
        "N",
        "maximum force on an end in the whole run (adjacent_span: not the load on the tower)",
    ),
    "cigre_322_excess": (
        "m",
        "distance of the motion in the window beyond the ellipse of CIGRE 322; negative: inside",
    ),
    "davison_excess": (
        "m",
        "distance of the motion in the window beyond Davison's upright ellipse; negative: inside",
    ),
    "warnings": ("", "warnings that limit the trust in the results"),
}


def steady_motion(result: Result, window: float | None = None) -> Row:
    """Summarise a result in the columns of `SUMMARY_COLUMNS`.

    Amplitudes, means, frequencies and distances from the ellipses refer to the last `window`
    seconds (None: 100 s, at most half of the run) of a completed run, extremes to the whole run,
    complete or not. Amplitudes are lasting if ``motion`` is steady.
    """
    recorded, report = result.recorded, result.report
    row: Row = {
        "sag": recorded.facts["sag"],
        "horizontal_tension": recorded.facts["horizontal_tension"],
        "time": float(recorded.time[-1]),
    }
    length = None if window is None else min(window, row["time"])
    row["motion"] = str(result.motion if length is None else result.judged(length))
    sizes = history_sizes(_midspan_histories(result)).tolist()
    for name, (low, high, *_) in zip(CHANNELS, sizes, strict=True):
        row |= {f"{name}_lowest": low, f"{name}_highest": high}
    row |= {"lowest_tension": report.lowest_tension, "warnings": " ".join(result.warnings)}
    if "left_f1" in recorded.values:
        forces = np.array([recorded.values[name] for name in END_FORCES]).reshape(2, 3, -1)
        row["support_force_highest"] = math.sqrt(np.max(np.sum(forces * forces, axis=1)))
    if report.outcome is Outcome.COMPLETED:
        row |= _steady_columns(result, length, recorded.facts["sag"])
    return {name: row.get(name) for name in SUMMARY_COLUMNS} | shedding_columns(result)


def _steady_columns(result: Result, window: float | None, sag: float) -> Row:
    row: Row = {}
    time, last = result.recorded.time, result.in_window(window)
    start = int(np.argmax(last))
    interval = float(time[start + 1] - time[start])
    histories = np.ascontiguousarray(_midspan_histories(result)[:, start:])
    for name, found in zip(CHANNELS, measure_all(histories, interval), strict=True):
        keys = (f"{name}_amplitude", f"{name}_mean", f"{name}_frequency_hz")
        row |= dict(zip(keys, found, strict=True))
    ellipses = {"davison_excess": davison_single_loop(sag)}
    with suppress(ValueError):  # the rule has no ellipse for such a small sag
        ellipses["cigre_322_excess"] = cigre_322_single_loop(sag, result.scene.conductor.diameter)
    u2, u3 = histories[: CHANNELS.index("theta")]
    excess = {key: float(np.max(ellipse.distance(u3, u2))) for key, ellipse in ellipses.items()}
    return {**row, **excess}


def _midspan_histories(result: Result) -> NDArray[np.float64]:
    """Mid-span histories of `CHANNELS`, (channel, time); selection in a dataset is slow."""
    middle = result.recorded.nodes.tolist().index(result.scene.elements)
    return np.array([result.recorded.values[name][:, middle] for name in CHANNELS])


@dataclass(frozen=True)
class Simulation:
    """Task of a sweep: simulate and summarise."""

    stop_time: float | None
    window: float | None
    summary: Summary | None
    columns: Mapping[str, tuple[str, str]]
    kind: Kind = "threads"

    def __str__(self) -> str:
        name = (
            "steady_motion"  # of a line line_motion
            if self.summary is None
            else f"{self.summary.__module__}.{self.summary.__qualname__}"
        )
        window = "the end" if self.window is None else f"{self.window:g} s"
        return f"simulate to {self.stop_time or 'its own'} s, {name} over {window}"

    def __call__(self, scenes: Sequence[Scene | LineScene], carry_on: CarryOn) -> list[Row]:
        """Simulate a group of scenes, one by one."""

        def run(scene: Scene | LineScene) -> Row:
            def progress(time: float, stop_time: float) -> bool:
                return carry_on()

            result = simulate(
                scene,
                self.stop_time,
                progress=progress,
                on_failure="return",
                threads=1,  # the runs share the processors
                **self._recorded(scene),
            )
            if not result.started:
                raise SimulationError(result.report, result)
            row = dict(self._summarised(result))
            if result.outcome is not Outcome.COMPLETED:
                row |= {"outcome": result.outcome.name.lower(), "message": str(result.report)}
            return row

        return one_by_one(run, scenes, carry_on)

    def _recorded(self, scene: Scene | LineScene) -> dict[str, Any]:
        """Return what is recorded, as arguments of `simulate`."""
        if isinstance(scene, LineScene):
            return recording_of_line(scene)
        return RECORDED if self.summary else SUMMARISED

    def _summarised(self, result: Result | LineResult) -> Mapping[str, Any]:
        """Return the columns of a result."""
        if self.summary is not None:
            return self.summary(result)
        if isinstance(result, LineResult):
            return line_motion(result, self.window)
        return steady_motion(result, self.window)


def sweep(  # noqa: PLR0913 - all but two are keyword arguments
    scene: Scene | LineScene | SceneSpec | str | Path | None = None,
    over: Mapping[str, Sequence[Any]] | None = None,
    *,
    table: SpanTable | None = None,
    stop_time: float | None = None,
    window: float | None = None,
    model: str = "element",
    summary: Summary | None = None,
    out: Path | str | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> Runs:
    """Simulate a scene over values of its parameters, or every span of a table, or both.

    Parameters
    ----------
    scene
        Scene of a span or line, packaged name or path; may be None if each row of the table names
        its own, or gives all values of its line.
    over
        Dotted path to values, such as ``{"wind.speed": [4.0, 5.0]}``; all combinations are
        computed. Items of lists count from 0: ``section.spans.1.length`` is that of span 2. Line
        data such as ``{"line.ice_thickness": [0.01, 0.02]}`` need the path of a
        scene file with a ``[line]`` table as `scene`.
    table
        CSV or GeoJSON file of spans, folder of scene files, data frame of pandas or polars, or rows
        in memory; see
        `gallop_fmu.sweeps.cases.read_spans`.
    stop_time
        Simulated time [s]; None takes each scene's.
    window
        Length [s] of the window at the end for amplitudes and motion; None takes 100 s, at most
        half of the run.
    model
        ``"element"``, the only one. Kept for callers of 0.1.0; the next release removes it.
    summary
        Function from a `Result` to the columns of its row, in place of `steady_motion`; of a line
        from a `LineResult`, in place of `gallop_fmu.sweeps.line_rows.line_motion`.
    out
        File to write, ``.parquet`` (needs the extra ``parquet``) or ``.nc``. Each row is written at
        once to the journal ``FILE.journal``, which is kept: the same call again computes only the
        missing rows. One sweep at a time can write a file. A file without its journal is not
        overwritten.
    workers
        Number of threads; None takes one for each core.
    cluster
        Address of a Dask scheduler such as ``tcp://host:8786`` (needs the extra ``cluster``), in
        place of threads. The sweep ends when the cluster has had no workers for a minute; finished
        runs are kept.
    progress
        Called after each group of runs with the numbers of finished, failed and all runs.

    Returns
    -------
    Runs
        One row a run, also for failed runs (see ``outcome`` and ``message``). ``runs.grid()`` has
        one dimension for each parameter. Results of each span and tower of lines, such as
        ``span_u2_amplitude``, have the dimension ``span`` or ``tower``, too, and ``phase`` if there
        are several.

    Raises
    ------
    SceneError
        An argument is not allowed, the table cannot be read, or `out` holds the results of another
        sweep.
    RunsStoppedError
        Ctrl-C, a file that cannot be written, or lost workers; ``result`` has the finished runs.

    Examples
    --------
    >>> import gallop_fmu as gf
    >>> runs = gf.sweep("example3", {"wind.speed": [5.0, 5.5]}, stop_time=2.0)
    >>> runs.grid().u2_amplitude.dims
    ('wind.speed',)
    """
    if window is not None and not window > 0.0:
        raise SceneError(f"window = {window} s: must be positive")
    if stop_time is not None:
        check_stop_time(stop_time)
    check_model(model)
    found = cases(scene, over, table)
    columns = _columns_of(found) if summary is None else {}
    task = Simulation(stop_time, window, summary, columns)
    return compute(found, task, out=out, count=workers, cluster=cluster, progress=progress)


def _columns_of(found: Cases) -> dict[str, tuple[str, str]]:
    """Columns of the summaries of all cases."""
    kinds = {base.is_section for base in found.bases}
    columns = {**SUMMARY_COLUMNS, **SHEDDING_COLUMNS} if False in kinds else {}
    return {**LINE_COLUMNS, **columns} if True in kinds else columns
