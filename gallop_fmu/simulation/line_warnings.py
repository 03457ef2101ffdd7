"""The warnings of a run of a line, in one list for all outputs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import LineMap
from gallop_fmu.foundation.outcome import Report
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.simulation.run_warnings import (
    fastest_motion,
    gust_warnings,
    not_covered,
    step_warnings,
)
from gallop_fmu.simulation.shedding import shedding_warnings

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

CURE_OF_UPLIFT = (
    "A string carries no compression: make it heavier or longer, lower the tension, or change the"
    " heights of the attachment points (section.spans)"
)


def line_warnings(
    dataset: xr.Dataset, scene: LineScene, report: Report, mapped: LineMap
) -> tuple[str, ...]:
    """Return the warnings of a run of a line, each a fact and a remedy.

    Parameters
    ----------
    dataset
        Recorded histories.
    scene
        The scene of the run.
    report
        Report of the kernel.
    mapped
        Map of the model.
    """
    return (
        *scene.warnings,
        *report.warnings,
        *_uplift(dataset, mapped),
        *_strength(dataset, scene),
        *_steps(dataset, scene, mapped),
        *shedding_warnings(dataset, scene),
        *not_covered(scene, float(dataset.time[-1])),
    )


def _uplift(dataset: xr.Dataset, mapped: LineMap) -> Iterator[str]:
    """Warnings about strings in compression."""
    if "string_pull" not in dataset:
        return
    pulls, time = dataset["string_pull"].values, dataset.time.values
    for tower in mapped.towers:
        pull = pulls[:, tower.tower, tower.phase - 1]
        if not (tower.has_string and np.nanmin(pull) < 0.0):
            continue
        phase = f", phase {tower.phase}" if mapped.phases > 1 else ""
        lowest = int(np.nanargmin(pull))
        when = f"at {time[lowest]:.4g} s"
        if pull[0] < 0.0:
            when = "at the start" if lowest == 0 else f"{when}, and already at the start"
        yield (
            f"tower {tower.tower}{phase}: uplift, the string's pull is {pull[lowest]:.4g} N {when},"
            f" which is compression. {CURE_OF_UPLIFT}."
        )


def _strength(dataset: xr.Dataset, scene: LineScene) -> Iterator[str]:
    """Warning about a tension above the rated strength."""
    strength = scene.section.rated_strength
    if strength is None or "tension" not in dataset:
        return
    tension = dataset["tension"].values
    if not np.isfinite(tension).any() or not np.nanmax(tension) > strength:
        return
    record, column = np.unravel_index(int(np.nanargmax(tension)), tension.shape)
    span, station = int(dataset.span[column]), float(dataset.station[column])
    yield (
        f"span {span}: the tension reaches {tension[record, column]:.4g} N at"
        f" {float(dataset.time[record]):.4g} s and station {station:.3g}, more than"
        f" section.rated_strength = {strength:g} N. Reduce the tension of the strung state, or"
        " check ice and wind."
    )


def _steps(dataset: xr.Dataset, scene: LineScene, mapped: LineMap) -> tuple[str, ...]:
    """Warnings about long steps and record intervals, from the fastest motion of all mid-spans."""
    time, recorded = dataset.time.values, dataset.node.values.tolist()
    columns = [recorded.index(chain.middle) for chain in mapped.chains if chain.middle in recorded]
    if not columns or len(time) < 2:
        return ()
    interval = float(time[1] - time[0])
    fastest = [
        fastest_motion(interval, _at(dataset, ("u2", "u3"), k), _at(dataset, ("v2", "v3"), k))
        for k in columns
    ]
    if not np.isfinite(fastest).any():
        return ()
    frequency_hz = float(np.nanmax(fastest))
    return (*step_warnings(scene, frequency_hz, interval), *gust_warnings(scene, frequency_hz))


def _at(dataset: xr.Dataset, names: tuple[str, ...], column: int) -> list[Array]:
    return [dataset[name].values[:, column] for name in names if name in dataset]
