"""Tables of a line's result: spans, strings, towers, clearances.

Columns have SI units, listed in ``table.attrs["units"]``. Means are over the window at the end of
the run, extremes over the whole run.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.simulation.clearance import cigre_322_single_loop, davison_single_loop
from gallop_fmu.simulation.oscillation import measure
from gallop_fmu.simulation.shedding import SETTLED

if TYPE_CHECKING:
    import xarray as xr

    from gallop_fmu.simulation.line_result import LineResult

Array = NDArray[np.float64]

STRING_COLUMNS = {
    "string_pull": ("pull", "N"),
    "string_lean_along": ("lean_along", "rad"),
    "string_lean_across": ("lean_across", "rad"),
}
"""Channel of a string to the start of its columns and their unit."""

AXES = ("x1", "x2", "x3")
WAYS = ("along", "across")


def strings(result: LineResult) -> pd.DataFrame:
    """Return pull and lean of each string: at rest in still air, mean, smallest and largest.

    Amplitudes (half peak-to-peak) and frequencies of the leans are over the window at the end of
    the run, as the means.
    """
    rows = []
    for tower in result.map.towers:
        if not tower.has_string:
            continue
        row: dict[str, Any] = {"tower": tower.tower, "phase": tower.phase, "kind": tower.kind}
        place = {"tower": tower.tower, "line_phase": tower.phase}
        for channel, (start, _) in STRING_COLUMNS.items():
            row |= _statistics(result, channel, place, start)
        row |= _swing(result, place)
        rows.append(row)
    units = {
        f"{start}_{what}": unit
        for start, unit in STRING_COLUMNS.values()
        for what in (*_STATISTICS, AFTER_SHEDDING)
    }
    for way in WAYS:
        units |= {f"lean_{way}_amplitude": "rad", f"lean_{way}_frequency_hz": "Hz"}
    return _frame(rows, units)


def towers(result: LineResult) -> pd.DataFrame:
    """Return the force of the conductors on each tower, along x1, x2, x3, of each phase.

    The preload is that of the initial equilibrium in still air; the other columns include it.
    """
    rows = []
    for tower in result.map.towers:
        row: dict[str, Any] = {"tower": tower.tower, "phase": tower.phase, "kind": tower.kind}
        place = {"tower": tower.tower, "line_phase": tower.phase}
        for axis in AXES:
            row |= _statistics(result, f"tower_force_{axis}", place, f"force_{axis}")
        rows.append(row)
    frame = _frame(
        rows,
        {f"force_{axis}_{what}": "N" for axis in AXES for what in (*_STATISTICS, AFTER_SHEDDING)},
    )
    renamed = {f"force_{axis}_at_rest": f"preload_{axis}" for axis in AXES}
    units = {renamed.get(name, name): unit for name, unit in frame.attrs["units"].items()}
    frame = frame.rename(columns=renamed)
    frame.attrs = {"units": units}
    return frame


_STATISTICS = ("at_rest", "mean", "min", "max")
AFTER_SHEDDING = SETTLED.removeprefix("_")
"""Name of the value at rest with the ice that is left, if ice fell."""


def _statistics(
    result: LineResult, channel: str, place: dict[str, int], start: str
) -> dict[str, float]:
    """Return the statistics of a history; NaN if it was not recorded."""
    if channel not in result.dataset:
        return dict.fromkeys([f"{start}_{what}" for what in _STATISTICS], np.nan)
    history = result.dataset[channel].sel(place)
    at_rest = result.dataset[f"{channel}_at_rest"].sel(place)
    late = _late(result, history)
    numbers = [at_rest, late.mean(), history.min(), history.max()]
    names = list(_STATISTICS)
    if f"{channel}{SETTLED}" in result.dataset:
        numbers.append(result.dataset[f"{channel}{SETTLED}"].sel(place))
        names.append(AFTER_SHEDDING)
    return {f"{start}_{w}": float(number) for w, number in zip(names, numbers, strict=True)}


def _swing(result: LineResult, place: dict[str, int]) -> dict[str, float]:
    """Return amplitude and frequency of a string's leans at the end of the run."""
    found: dict[str, float] = {}
    for way in WAYS:
        if f"string_lean_{way}" not in result.dataset:
            continue
        late = _late(result, result.dataset[f"string_lean_{way}"].sel(place))
        if len(late.time) > 1:
            amplitude, _, frequency = measure(late.values, float(late.time[1] - late.time[0]))
            found[f"lean_{way}_amplitude"] = amplitude
            found[f"lean_{way}_frequency_hz"] = frequency
    return found


def _late(result: LineResult, history: xr.DataArray, window: float | None = None) -> xr.DataArray:
    """The part of a history in the window at the end of the run; of one record, itself."""
    if len(history.time) < 2:
        return history
    begin, end = result.window(window)
    return history.sel(time=slice(begin - 1e-9, end + 1e-9))


def spans(result: LineResult, window: float | None = None) -> pd.DataFrame:
    """Return the motion of the bundle's centre at mid-span, of each span and phase.

    Amplitudes (half peak-to-peak), means and frequencies are over the last `window` s of the run
    (default: 100 s, at most half of it). The excess is the distance of the orbit from the ellipse
    of a single loop; negative inside. The largest tension is that of all recorded nodes in
    the whole run.
    """
    rows = [
        {"span": span, "phase": phase, **_span_row(result, span, phase, window)}
        for span in range(1, result.map.spans + 1)
        for phase in range(1, result.map.phases + 1)
    ]
    units = {"sag": "m", "horizontal_tension": "N", "largest_tension": "N"}
    units |= {"cigre_322_excess": "m", "davison_excess": "m"}
    for name, unit in {"u2": "m", "u3": "m", "theta": "rad"}.items():
        units |= {f"{name}_amplitude": unit, f"{name}_mean": unit, f"{name}_frequency_hz": "Hz"}
    return _frame(rows, units)


def _span_row(result: LineResult, span: int, phase: int, window: float | None) -> dict[str, Any]:
    place = {"line_span": span, "line_phase": phase}
    row: dict[str, Any] = {
        name: float(result.dataset[name].sel(place)) for name in ("sag", "horizontal_tension")
    }
    data = result.dataset
    if "tension" in data:
        own = ((data.span == span) & (data.phase == phase)).values
        row["largest_tension"] = float(np.nanmax(data["tension"].values[:, own]))
    bundle = result.bundle(span, phase)
    moves = [name for name in ("u2", "u3", "theta") if name in bundle]
    late = {name: _late(result, bundle[name], window) for name in moves}
    for name, history in late.items():
        if len(history.time) < 2:
            continue
        interval = float(history.time[1] - history.time[0])
        keys = (f"{name}_amplitude", f"{name}_mean", f"{name}_frequency_hz")
        row |= dict(zip(keys, measure(history.values, interval), strict=True))
    row["motion"] = str(result.motion_of(span, phase, window))
    if {"u2", "u3"} <= set(late):
        ellipses = {"davison_excess": davison_single_loop(row["sag"])}
        with suppress(ValueError):  # the rule has no ellipse for such a small sag
            ellipses["cigre_322_excess"] = cigre_322_single_loop(
                row["sag"], result.scene.conductor.diameter
            )
        for name, ellipse in ellipses.items():
            distance = ellipse.distance(late["u3"].values, late["u2"].values)
            row[name] = float(np.max(distance))
    return row


def clearances(result: LineResult, since: float = 0.0) -> pd.DataFrame:
    """Return the smallest distance of each two phases in each span from `since` [s] on.

    Distances are between the centres of conductors at the recorded nodes, each with the nearest
    one of the other phase along the line; record all nodes to cover the whole span. Where the two
    are not at the same place along the line, because the meshes differ, the other one is moved
    there along the chord of the span.

    Raises
    ------
    SceneError
        Displacements were not recorded.
    """
    if not {"u1", "u2", "u3"} <= set(result.dataset.data_vars):
        raise SceneError(
            "the displacements u1, u2, u3 were not recorded, so there are no clearances; simulate"
            " with these channels"
        )
    rows = [
        row
        for span in range(1, result.map.spans + 1)
        for first, second in combinations(range(1, result.map.phases + 1), 2)
        if (row := _clearance(result, span, (first, second), since))
    ]
    return _frame(rows, {"at_rest": "m", "smallest": "m", "time": "s", "x1": "m"})


def _clearance(
    result: LineResult, span: int, phases: tuple[int, int], since: float
) -> dict[str, Any] | None:
    """Return the row of two phases in a span; None if no node of one of them was recorded."""
    data = result.dataset.sel(time=slice(since - 1e-9, None))
    columns = [np.flatnonzero((data.span == span) & (data.phase == p)) for p in phases]
    if not all(len(own) for own in columns):
        return None
    own = result.scene.section.spans[span - 1]
    chord = np.array([1.0, own.height_difference / own.length, 0.0])
    best: dict[str, Any] = {}
    at_rest = np.inf
    for one, other in _pairs(data, *columns):
        apart = (data.x1.values[one] - data.x1.values[other]) * chord
        steps = [_place(data, one, axis) - _place(data, other, axis) for axis in (1, 2, 3)]
        distance = np.sqrt(sum((step - d) ** 2 for step, d in zip(steps, apart, strict=True)))
        resting = np.array([data[axis].values[one] - data[axis].values[other] for axis in AXES])
        resting = resting - apart
        at_rest = min(at_rest, float(np.linalg.norm(resting)))
        record = int(np.argmin(distance))
        if not best or distance[record] < best["smallest"]:
            time, x1 = float(data.time[record]), float(data.x1[one])
            best = {"smallest": float(distance[record]), "time": time, "x1": x1}
    first, second = phases
    return {"span": span, "phase": first, "other_phase": second, "at_rest": at_rest, **best}


def _pairs(
    data: xr.Dataset, first: NDArray[np.intp], second: NDArray[np.intp]
) -> Iterator[tuple[int, int]]:
    """Yield each node of the first phase with the nearest ones of the subconductors of the other.

    Nodes at the ends of the span have the distance of the towers and are left out.
    """
    x1, station = data.x1.values, data.station.values
    parts = data.subconductor.values
    for one in first:
        if not 0.0 < station[one] < 1.0:
            continue
        for part in np.unique(parts[second]):
            others = second[parts[second] == part]
            yield int(one), int(others[np.argmin(np.abs(x1[others] - x1[one]))])


def _place(data: xr.Dataset, node: int, axis: int) -> Array:
    """Coordinate of a node over time [m]."""
    place = float(data[f"x{axis}"].values[node])
    return np.asarray(place + data[f"u{axis}"].values[:, node])


def _frame(rows: list[dict[str, Any]], units: dict[str, str]) -> pd.DataFrame:
    frame = pd.DataFrame(rows)
    frame.attrs = {"units": {name: unit for name, unit in units.items() if name in frame}}
    return frame


def line_summary(result: LineResult) -> dict[str, object]:
    """Summarise a run of a line in plain numbers and words, for a terminal or as JSON."""
    start, stop = result.window() if len(result.dataset.time) > 1 else (0.0, 0.0)
    tables = {"spans": result.spans, "strings": result.strings, "towers": result.towers}
    if result.map.phases > 1:
        tables["clearances"] = result.clearances
    rows = {name: table.to_dict("records") for name, table in tables.items()}
    return {**result.numbers(), "window": stop - start, **rows}
