"""sweep(scene, over): simulate many scenes, and keep of each what a table can hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.line.clearance import cigre_322_single_loop, davison_single_loop
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.result import Result, measure
from gallop_fmu.simulation.run_options import check_model, check_stop_time
from gallop_fmu.simulation.simulate import simulate
from gallop_fmu.sweeps.cases import SpanTable, cases
from gallop_fmu.sweeps.pool import Kind
from gallop_fmu.sweeps.row_store import Row
from gallop_fmu.sweeps.runner import CarryOn, Progress, compute, one_by_one
from gallop_fmu.sweeps.runs import Runs

Summary = Callable[[Result], Mapping[str, Any]]
"""From a result to the numbers that are kept of it."""

CHANNELS = ("u2", "u3", "theta", "tension")
RECORDED = (*CHANNELS, "v2", "v3")

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
        "what the span does over the window at the end: steady, still growing, turned over, ...",
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
        f"{_name}_lowest": (_unit, f"{_meaning} at mid-span, least of the whole run"),
        f"{_name}_highest": (_unit, f"{_meaning} at mid-span, greatest of the whole run"),
    }
SUMMARY_COLUMNS |= {
    "lowest_tension": ("N", "lowest tension anywhere along the span in the whole run"),
    "support_force_highest": (
        "N",
        "greatest pull on an end in the whole run (adjacent_span: not the load on the tower)",
    ),
    "beyond_cigre_322": (
        "m",
        "how far the motion in the window leaves the ellipse of CIGRE 322; negative within",
    ),
    "beyond_davison": (
        "m",
        "how far the motion in the window leaves the upright ellipse of Davison; negative within",
    ),
    "warnings": ("", "what limits the trust in the numbers"),
}


def steady_motion(result: Result, window: float | None = None) -> Row:
    """What `sweep` keeps of a result: the columns of `SUMMARY_COLUMNS`.

    Amplitude, mean and frequency over the last `window` seconds (or the whole of a shorter run;
    None: 100 s, at most half of the run) and the distances from the ellipses only of a run that
    completed; extremes over all that was computed. Whether amplitudes hold for longer than the
    window is what ``motion`` says.
    """
    dataset, report = result.dataset, result.report
    attrs = dataset.attrs
    row: Row = {
        "sag": float(attrs["sag"]),
        "horizontal_tension": float(attrs["horizontal_tension"]),
        "time": float(dataset.time[-1]),
    }
    length = None if window is None else min(window, row["time"])
    row["motion"] = str(result.motion if length is None else result.judged(length))
    for name, values in _midspan_histories(result).items():
        row |= {f"{name}_lowest": float(np.min(values)), f"{name}_highest": float(np.max(values))}
    row |= {"lowest_tension": report.lowest_tension, "warnings": " ".join(result.warnings)}
    if "left_f1" in dataset:
        forces = [
            np.sqrt(sum(dataset[f"{end}_f{axis}"].values ** 2 for axis in (1, 2, 3)))
            for end in ("left", "right")
        ]
        row["support_force_highest"] = float(np.max(forces))
    if report.outcome is Outcome.COMPLETED:
        row |= _steady_columns(result, length, float(attrs["sag"]))
    return {name: row.get(name) for name in SUMMARY_COLUMNS}


def _steady_columns(result: Result, window: float | None, sag: float) -> Row:
    row: Row = {}
    time = result.dataset.time.values
    start, stop = result.window(window)
    last = time >= start - 1e-9
    if np.count_nonzero(last) < 2:
        raise SceneError(
            f"window = {stop - start} s: holds fewer than two records, which are"
            f" {time[1] - time[0]:g} s apart"
        )
    interval = float(np.diff(time[last][:2])[0])
    histories = {name: values[last] for name, values in _midspan_histories(result).items()}
    for name, values in histories.items():
        keys = (f"{name}_amplitude", f"{name}_mean", f"{name}_frequency_hz")
        row |= dict(zip(keys, measure(values, interval), strict=True))
    ellipses = {"beyond_davison": davison_single_loop(sag)}
    with suppress(ValueError):  # so little sag that the rule has no ellipse
        ellipses["beyond_cigre_322"] = cigre_322_single_loop(sag, result.scene.conductor.diameter)
    beyond = {
        key: float(np.max(ellipse.distance(histories["u3"], histories["u2"])))
        for key, ellipse in ellipses.items()
    }
    return {**row, **beyond}


def _midspan_histories(result: Result) -> dict[str, NDArray[np.float64]]:
    """Plain arrays, since selecting in a dataset costs more than computing some seconds."""
    middle = result.dataset.node.values.tolist().index(result.scene.numerics.elements)
    return {name: result.dataset[name].values[:, middle] for name in CHANNELS}


@dataclass(frozen=True)
class Simulation:
    """The task of a sweep."""

    stop_time: float | None
    window: float | None
    summary: Summary | None
    kind: Kind = "threads"

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Column to unit and meaning."""
        return SUMMARY_COLUMNS if self.summary is None else {}

    def __str__(self) -> str:
        name = (
            "steady_motion"
            if self.summary is None
            else f"{self.summary.__module__}.{self.summary.__qualname__}"
        )
        window = "its end" if self.window is None else f"{self.window:g} s"
        return f"simulate to {self.stop_time or 'its own'} s, {name} over {window}"

    def __call__(self, scenes: Sequence[Scene], carry_on: CarryOn) -> list[Row]:
        """Compute a group of scenes, each by itself."""

        def run(scene: Scene) -> Row:
            def going_on(time: float, stop_time: float) -> bool:
                return carry_on()

            result = simulate(
                scene, self.stop_time, channels=RECORDED, progress=going_on, on_failure="return"
            )
            if not result.started:
                raise SimulationError(result.report, result)
            row = (
                steady_motion(result, self.window)
                if self.summary is None
                else dict(self.summary(result))
            )
            if result.outcome is not Outcome.COMPLETED:
                row |= {"outcome": result.outcome.name.lower(), "message": str(result.report)}
            return row

        return one_by_one(run, scenes, carry_on)


def sweep(  # noqa: PLR0913 - all but two are keyword arguments
    scene: Scene | SceneSpec | str | Path | None = None,
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
        Scene, packaged name or path; may be None if each row of the table names its own, or all of
        its line.
    over
        Dotted path to the values it takes, such as ``{"wind.speed": [4.0, 5.0]}``; all combinations
        are computed. The familiar numbers of a line vary too, ``{"line.ice_thickness": [0.01,
        0.02]}``, where `scene` is the path of a file with a ``[line]`` table.
    table
        CSV or GeoJSON file of spans, a data frame of pandas or polars, or rows in memory; see
        `gallop_fmu.sweeps.cases.read_spans`.
    stop_time
        Simulated time [s]; None takes each scene's.
    window
        Time [s] at the end over which amplitudes are taken and the motion is judged; None takes 100
        s, at most half of the run.
    model
        ``"element"``, the only one: kept for callers of 0.1.0, which had another. The next release
        drops it.
    summary
        From a `Result` to what is kept of it, in place of `steady_motion`.
    out
        File to write, ``.parquet`` (needs the extra ``parquet``) or ``.nc``. Each row is written at
        once into the journal ``FILE.journal``, which stays beside the file: the same call again
        computes only the rows that are missing there. One sweep at a time can write a file. A file
        without its journal is not overwritten.
    workers
        Number of threads; None takes one for each core.
    cluster
        Address of a Dask scheduler such as ``tcp://host:8786`` (needs the extra ``cluster``), in
        place of threads here. A cluster that has had no workers for a minute is given up; what it
        computed is kept.
    progress
        Called with the numbers of runs done, not completed, and in all, after each group of runs.

    Returns
    -------
    Runs
        One row a run, also for those that did not complete: ``outcome`` and ``message`` tell.
        ``runs.grid()`` has one dimension for each parameter.

    Raises
    ------
    SceneError
        An argument is not allowed, the table cannot be read, or `out` holds the results of
        something else.
    RunsStoppedError
        On Ctrl-C, when the file cannot be written, or the workers are lost; its ``result`` has what
        was done.

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
    task = Simulation(stop_time, window, summary)
    return compute(
        cases(scene, over, table), task, out=out, count=workers, cluster=cluster, progress=progress
    )
