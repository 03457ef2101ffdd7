"""The row of a line in a sweep: what it records, and its columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from gallop_fmu.engine.pack import map_of
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.line_tables import spans
from gallop_fmu.sweeps.places import Place
from gallop_fmu.sweeps.rows import Row
from gallop_fmu.sweeps.shedding_rows import SHEDDING_COLUMNS, shedding_columns

CHANNELS = ("u1", "u2", "u3", "theta", "tension", "v2", "v3")
LINE_CHANNELS = (
    *("tower_force_x1", "tower_force_x2", "tower_force_x3"),
    *("string_pull", "string_lean_along", "string_lean_across"),
)
QUARTERS = (0.25, 0.75)
"""Stations, besides mid-span, that are recorded: for distances of phases, and for two loops."""

_SECTION = {
    "time": ("s", "simulated time"),
    "motion": (
        "",
        "motion of all spans and strings in the window at the end: steady, still growing, ...",
    ),
    "lowest_tension": ("N", "minimum tension along the line in the whole run"),
    "smallest_clearance": (
        "m",
        "minimum distance of two phases at the quarter points and mid-spans in the whole run",
    ),
    "warnings": ("", "warnings that limit the trust in the results"),
}
_AT_REST = {
    "span_sag": ("m", "sag of the initial equilibrium"),
    "span_horizontal_tension": (
        "N",
        "horizontal tension of a subconductor, in the initial equilibrium",
    ),
    "span_motion": ("", "motion in the window at the end: steady, still growing, ..."),
}
_STEADY: dict[str, tuple[str, str]] = {}
for _name, (_unit, _meaning) in {
    "u2": ("m", "vertical"),
    "u3": ("m", "horizontal"),
    "theta": ("rad", "twist of the bundle"),
}.items():
    _where = f"{_meaning} at mid-span (centre of the bundle)"
    _STEADY |= {
        f"span_{_name}_amplitude": (
            _unit,
            f"{_where}, half peak-to-peak of the motion in the window",
        ),
        f"span_{_name}_mean": (_unit, f"{_where}, mean of the motion in the window"),
        f"span_{_name}_frequency_hz": (
            "Hz",
            f"{_where}, dominant frequency of the motion in the window",
        ),
    }
_STEADY |= {
    "span_cigre_322_excess": (
        "m",
        "distance of the motion in the window beyond the ellipse of CIGRE 322; negative: inside",
    ),
    "span_davison_excess": (
        "m",
        "distance of the motion in the window beyond Davison's upright ellipse; negative: inside",
    ),
}
_EXTREMES = {"min": ("lowest", "minimum"), "max": ("highest", "maximum")}
_FORCES = {
    f"force_{axis}": ("N", f"force of the conductors of a phase on the tower {way}")
    for axis, way in {"x1": "along the line", "x2": "upwards", "x3": "with the wind"}.items()
}
_STRINGS = {
    "pull": ("N", "pull of the string, positive in tension"),
    "lean_along": ("rad", "angle of the string from straight down along the line"),
    "lean_across": ("rad", "angle of the string from straight down across the line"),
}
LINE_COLUMNS: dict[str, tuple[str, str]] = {
    **_SECTION,
    **SHEDDING_COLUMNS,
    **_AT_REST,
    **_STEADY,
    **{
        f"tower_{name}_{end}": (unit, f"{meaning}, {extreme} of the whole run")
        for name, (unit, meaning) in {**_FORCES, **_STRINGS}.items()
        for end, extreme in _EXTREMES.values()
    },
}
"""Column to unit and meaning; of columns of spans and towers see `gallop_fmu.sweeps.places`."""


def recording_of_line(scene: LineScene) -> dict[str, Any]:
    """Return what is recorded of a line, as arguments of `simulate`.

    All nodes of several phases would fill the memory in a long run, so clearances are measured at
    the quarter points and at mid-spans.
    """
    mapped = map_of(scene)
    nodes = set(mapped.usual_nodes.tolist())
    nodes |= {chain.nearest_node(place) for chain in mapped.chains for place in QUARTERS}
    return {
        "channels": CHANNELS,
        "span_channels": LINE_CHANNELS,
        "record_nodes": sorted(nodes),
    }


def line_motion(result: LineResult, window: float | None = None) -> Row:
    """Summarise the result of a line in the columns of `LINE_COLUMNS`.

    Amplitudes, means, frequencies and distances from the ellipses refer to the last `window`
    seconds (None: 100 s, at most half of the run) of a completed run, extremes to the whole run,
    complete or not. Amplitudes are lasting if ``motion`` is steady.

    Raises
    ------
    SceneError
        The window contains fewer than two records.
    """
    time = float(result.dataset.time[-1])
    length = None if window is None else min(window, time)
    completed = result.report.outcome is Outcome.COMPLETED
    if completed:
        result.in_window(length)
    row: Row = {
        "time": time,
        "motion": str(result.motion if length is None else result.judged(length)),
        "lowest_tension": result.report.lowest_tension,
    }
    if result.map.phases > 1:
        row["smallest_clearance"] = float(result.clearances["smallest"].min())
    row["warnings"] = " ".join(result.warnings)
    row |= shedding_columns(result)
    for found in spans(result, length).to_dict("records"):
        place = _place(result, "span", found)
        for name in (*_AT_REST, *_STEADY):
            known = completed or name in _AT_REST
            row[place.name_of(name)] = found.get(name.removeprefix("span_")) if known else None
    for place, name, value in _of_towers(result):
        row[place.name_of(name)] = value
    return row


def _of_towers(result: LineResult) -> Iterator[tuple[Place, str, float | None]]:
    """Yield the extremes of the forces on each tower and of its string, if the line has any."""
    pulls = {(each["tower"], each["phase"]): each for each in result.strings.to_dict("records")}
    for found in result.towers.to_dict("records"):
        place = _place(result, "tower", found)
        string = pulls.get((found["tower"], found["phase"]), {})
        for name in (*_FORCES, *(_STRINGS if pulls else ())):
            for key, (end, _) in _EXTREMES.items():
                value = {**string, **found}.get(f"{name}_{key}")
                yield place, f"tower_{name}_{end}", value


def _place(result: LineResult, kind: str, found: Mapping[Any, Any]) -> Place:
    return Place(kind, found[kind], found["phase"] if result.map.phases > 1 else None)
