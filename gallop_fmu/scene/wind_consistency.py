"""Checks of the wind and of time tables against the rest of a scene, and warnings about them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.dotted_paths import section_classes
from gallop_fmu.scene.fields import Section
from gallop_fmu.scene.gusts import Gusts, check_size, gusts, unresolved
from gallop_fmu.scene.time_functions import TimedTable
from gallop_fmu.scene.wind import Wind, from_the_other_side
from gallop_fmu.scene.wind_profile import too_low

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene

Towers = Sequence[tuple[float, float]]
"""x1 and x2 [m] of the attachment points, from the left."""

SAME_PLACE = 1e-6
"""Distance [m] by which a station may be beyond the ends of the line."""


def check_wind(wind: Wind, towers: Towers, duration: float) -> None:
    """Refuse wind that does not fit the line and the run.

    Parameters
    ----------
    towers
        Attachment points of the line.
    duration
        Duration of the run [s].

    Raises
    ------
    SceneError
        The message names field, value and remedy.
    """
    length = towers[-1][0]
    if wind.table is not None:
        for number, place in enumerate(wind.table.stations, start=1):
            if not -SAME_PLACE <= place <= length + SAME_PLACE:
                raise SceneError(
                    f"wind.table.stations: station {number} is at x1 = {place:g} m, outside of the"
                    f" line, which is from 0 to {length:g} m; x1 counts from the left end: correct"
                    " or remove it"
                )
    if wind.profile is not None and (problem := too_low(wind.profile, [x2 for _, x2 in towers])):
        raise SceneError(problem)
    if wind.turbulence is not None and wind.has_turbulence:
        check_size(wind.turbulence, wind.mean_speed, length, duration)


def towers_of(scene: Scene | LineScene) -> Towers:
    """Attachment points of a span or line."""
    spans = scene.section.spans if hasattr(scene, "section") else (scene.span,)
    length = height = 0.0
    towers = [(length, height)]
    for span in spans:
        length, height = length + span.length, height + span.height_difference
        towers.append((length, height))
    return towers


def unusual_wind(wind: Wind, duration: float) -> list[str]:
    """Warnings about the wind, each a fact and a remedy."""
    found = wind.warnings()
    if wind.turbulence is not None and wind.has_turbulence:
        found += unresolved(wind.turbulence, wind.mean_speed, duration)
    return found


def check_wind_of_line(scene: LineScene) -> None:
    """Refuse wind that does not fit the line and the run; see `check_wind`."""
    check_wind(scene.wind, towers_of(scene), scene.run.stop_time)
    for number, span in enumerate(scene.section.spans, start=1):
        if scene.wind.table is not None and span.wind is not None:
            raise SceneError(
                f"section.spans.{number - 1}.wind (span {number}) and wind.table are both given;"
                " the table has the speed of each place: remove the wind of the span, or the table"
            )


def unusual_wind_of_line(scene: LineScene) -> list[str]:
    """Warnings about the wind of a line and of its spans."""
    found = unusual_wind(scene.wind, scene.run.stop_time)
    for number, span in enumerate(scene.section.spans, start=1):
        lowest = scene.wind_of_span(number).extremes[0]
        if span.wind is not None and lowest < 0.0:
            field = "speed" if span.wind.history is None else "history"
            path = f"section.spans.{number - 1}.wind.{field} (span {number})"
            found.append(from_the_other_side(path, lowest, "m/s"))
    return found


def gusts_of(wind: Wind, length: float, duration: float) -> Gusts | None:
    """Return the gusts of a wind over the line and time; None if it has none.

    Parameters
    ----------
    length
        Length of the line along x1 [m].
    duration
        Duration of the run [s].
    """
    if wind.table is not None:
        table = wind.table
        stations, times = np.asarray(table.stations), table.run_times
        return Gusts(stations, times, table.relative_gusts(), table.beyond == "repeat")
    if wind.turbulence is None or not wind.has_turbulence:
        return None
    yaw = np.radians(wind.mean_direction)
    return gusts(wind.turbulence, wind.mean_speed, float(yaw), length, duration)


def time_tables(section: Section, start: str = "") -> Iterator[tuple[str, TimedTable]]:
    """Yield the tables over time in a scene, each with its dotted path."""
    for name in _names_of_sections(type(section)):
        value, path = getattr(section, name), start + name
        if isinstance(value, TimedTable):
            yield path, value
        elif isinstance(value, Section):
            yield from time_tables(value, f"{path}.")
        elif isinstance(value, tuple) and value and isinstance(value[0], Section):
            for i, item in enumerate(value):
                yield from time_tables(item, f"{path}.{i}.")


@cache
def _names_of_sections(section: type[Section]) -> tuple[str, ...]:
    """Return the fields of a section that can have sections."""
    fields = section.model_fields.items()
    return tuple(name for name, field in fields if section_classes(field.annotation))


def check_time_tables(scene: Section, duration: float) -> None:
    """Refuse tables over time that do not overlap the run.

    Raises
    ------
    SceneError
        A table that does not repeat ends before the run, or begins after it.
    """
    for path, table in time_tables(scene):
        if table.beyond == "repeat" or (table.last > 0.0 and table.first < duration):
            continue
        where = "ends before the run" if table.last <= 0.0 else "begins after the run"
        raise SceneError(
            f"{path}: the table {where}: it is from {table.first:.10g} to {table.last:.10g} s, the"
            f" run from 0 to {duration:.6g} s; give {path}.origin, the time in the table at which"
            f" the run begins, such as {table.time[0]:.10g}"
        )


def times_of_tables(scene: Scene | LineScene) -> Iterator[tuple[str, float, float, bool]]:
    """Yield path, first and last time [s] of the run, and True if it repeats, of each table.

    The gusts of turbulence are a table, too.
    """
    for path, table in time_tables(scene):
        yield path, table.first, table.last, table.beyond == "repeat"
    turbulence = scene.wind.turbulence
    if turbulence is not None and scene.wind.has_turbulence:
        yield "wind.turbulence", 0.0, turbulence.duration or scene.run.stop_time, True
