"""Wind speeds over the line and time, from measurements or another program."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import (
    Table,
    check_table,
    name_and_unit,
    number_rows,
    read_cells,
)
from gallop_fmu.foundation.text_rules import read_number
from gallop_fmu.scene.fields import Number, Text, quantity, setting
from gallop_fmu.scene.time_functions import TimedTable, check_gaps

Values = NDArray[np.float64]
Row = Annotated[tuple[Number, ...], Field(strict=False)]
Rows = Annotated[tuple[Row, ...], Field(strict=False)]

MIN_MEAN = 0.01
"""Minimum mean speed over the largest speed; gusts are relative to the mean."""

HEADER = "time,0,50,100 (time [s], then x1 [m] of each station)"


class WindTable(TimedTable):
    """Wind speeds at stations and times, linear between both, constant beyond the stations.

    Given as arrays, or as a CSV file with header ``time,0,50,100``: the time, then x1 [m] of each
    station. The mean over the table becomes the mean speed of the scene.
    """

    file: Text | None = setting(
        None, f"CSV file with header {HEADER}; its columns become the arrays on loading"
    )
    stations: Annotated[tuple[Number, ...], Field(strict=False)] = quantity(
        ..., "m", "x1 of each station, increasing"
    )
    speed: Rows = quantity(..., "m/s", "speed along the wind: a row for each time")
    across: Rows | None = quantity(
        None, "m/s", "speed horizontally across the wind (towards +x1, if it blows along +x3)"
    )
    upwards: Rows | None = quantity(None, "m/s", "upward speed")

    @model_validator(mode="before")
    @classmethod
    def _read_file(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict) or data.get("file") is None:
            return data
        arrays = [name for name in ("time", "stations", "speed") if data.get(name)]
        if not isinstance(data["file"], str) or arrays:
            given = f" and {', '.join(arrays)} are both given" if arrays else ""
            raise SceneError(
                f"file = {data['file']!r}{given}; give the name of a CSV file with header"
                f" {HEADER}, or the arrays"
            )
        table = read_wind_table(Path((info.context or {}).get("folder", ".")) / data["file"])
        gap = data.get("max_gap")
        _check_times(table, gap if isinstance(gap, (int, float)) else None)
        others = {name: value for name, value in data.items() if name != "file"}
        return {
            **others,
            "stations": table.stations,
            "time": table.columns["time"],
            "speed": table.speed,
        }

    @model_validator(mode="after")
    def _consistent(self) -> WindTable:
        rows = range(1, len(self.time) + 1)
        _check_times(_WindRows("", {"time": self.time}, rows, self.stations, ()), self.max_gap)
        if not self.stations:
            raise SceneError("stations: give x1 [m] of at least one station")
        for number, (before, here) in enumerate(pairwise(self.stations), start=2):
            if not here > before:
                raise SceneError(
                    f"stations must increase; station {number} is at {here:g} m, after"
                    f" {before:g} m: sort the columns, and remove those that are there twice"
                )
        for name in ("speed", "across", "upwards"):
            self._check_shape(name)
        largest = float(np.abs(self.speed).max())
        if abs(self.mean_value) < MIN_MEAN * largest:
            raise SceneError(
                f"speed: the mean over the table is {self.mean_value:.3g} m/s, less than"
                f" {MIN_MEAN:.0%} of the largest speed of {largest:.3g} m/s; gusts are relative to"
                " the mean: give wind.history with the speed, or a table with a mean wind"
            )
        return self

    def _check_shape(self, name: str) -> None:
        rows = getattr(self, name)
        if rows is None:
            return
        if len(rows) != len(self.time):
            raise SceneError(
                f"{name} has {len(rows)} rows, time has {len(self.time)}; give a row for each time"
            )
        for number, row in enumerate(rows, start=1):
            if len(row) != len(self.stations):
                raise SceneError(
                    f"{name}: row {number} has {len(row)} values, and there are"
                    f" {len(self.stations)} stations; give one for each"
                )

    @property
    def mean_value(self) -> float:
        """Mean of the speed along the wind over stations and time [m/s]."""
        over_time = np.trapezoid(np.asarray(self.speed), self.time, axis=0)
        return float(np.mean(over_time) / (self.time[-1] - self.time[0]))

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest speed along the wind [m/s]."""
        return float(np.min(self.speed)), float(np.max(self.speed))

    @property
    def varies_in_time(self) -> bool:
        """True if not all rows are equal."""
        tables = (self.speed, self.across, self.upwards)
        return any(len(set(rows)) > 1 for rows in tables if rows is not None)

    def relative_gusts(self) -> Values:
        """Gusts over the mean speed, shape (time, station, component): 1 component or 3."""
        mean = self.mean_value
        along = np.asarray(self.speed) / mean - 1.0
        if self.across is None and self.upwards is None:
            return along[:, :, np.newaxis]
        calm = np.zeros_like(along)
        others = (calm if v is None else np.asarray(v) / mean for v in (self.across, self.upwards))
        return np.stack([along, *others], axis=2)


class _WindRows(NamedTuple):
    """A `Table` of times, with stations and speeds."""

    file: str
    columns: dict[str, tuple[float, ...]]
    rows: Any
    stations: tuple[float, ...]
    speed: tuple[tuple[float, ...], ...]


def _check_times(table: _WindRows, max_gap: float | None) -> None:
    """Refuse times that do not increase, and gaps."""
    check_table(table.file, "time", table.columns, table.rows)
    start = f"{table.file}: " if table.file else ""
    check_gaps(Table(table.file, table.columns, table.rows), max_gap, start)


def read_wind_table(path: Path) -> _WindRows:
    """Read a CSV file of speeds: the time, then a column for each station.

    Raises
    ------
    SceneError
        The file is unreadable, the name of a column is not a place, or a cell not a finite number.
    """
    lines = read_cells(path)
    header = lines[0][1] if lines else []
    rule = f"{path.name}: the first line must be like {HEADER}"
    if len(header) < 2 or name_and_unit(header[0])[0] != "time":
        raise SceneError(f"{rule}; rename the first column to time, and add one for each station")
    stations = []
    for column, cell in enumerate(header[1:], start=2):
        place = read_number(name_and_unit(cell)[0])
        if place is None or not np.isfinite(place):
            raise SceneError(f"{rule}; the name of column {column} is not a number: give x1 in m")
        stations.append(float(place))
    rows, numbers = number_rows(path, lines[1:], header)
    time = tuple(line[0] for line in numbers)
    speed = tuple(tuple(line[1:]) for line in numbers)
    return _WindRows(path.name, {"time": time}, rows, tuple(stations), speed)
