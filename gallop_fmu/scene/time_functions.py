"""Laws of time for wind speed, support motion and load amplitude.

The kernel evaluates the same laws; `at` here is for plots, tests and checks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, ValidationInfo, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import Table, check_table, take_in_file
from gallop_fmu.scene.fields import UNIT_OF_OWNER, Number, Section, Text, quantity, setting

Values = NDArray[np.float64]


def smooth_step(time: ArrayLike, start: float, duration: float) -> Values:
    """Rise from 0 to 1 over `duration` as s(x) = x^3 (10 - 15 x + 6 x^2); a jump if it is 0.

    x is (time - start) / duration. First and second derivatives vanish at both ends, so the
    acceleration of a motion is continuous.
    """
    since = np.asarray(time, dtype=np.float64) - start
    if duration == 0.0:
        return np.where(since >= 0.0, 1.0, 0.0)
    x = np.clip(since / duration, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


class Constant(Section):
    """The same value at all times."""

    kind: Literal["constant"] = setting("constant", "kind of law")
    value: Number = quantity(..., UNIT_OF_OWNER, "value at all times")

    def at(self, time: ArrayLike) -> Values:
        """Value at each time [s]."""
        return np.full(np.shape(time), self.value)

    @property
    def mean_value(self) -> float:
        """The value itself."""
        return self.value

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value at any time."""
        return self.value, self.value


class Ramp(Section):
    """From `initial` to `final` along a `smooth_step`, then constant."""

    kind: Literal["ramp"] = setting("ramp", "kind of law")
    initial: Number = quantity(..., UNIT_OF_OWNER, "value before the ramp")
    final: Number = quantity(..., UNIT_OF_OWNER, "value after the ramp")
    start: Number = quantity(0.0, "s", "time at which the ramp begins")
    duration: Number = quantity(..., "s", "duration of the ramp; 0 is a jump", ge=0)

    def at(self, time: ArrayLike) -> Values:
        """Value at each time [s]."""
        return self.initial + (self.final - self.initial) * smooth_step(
            time, self.start, self.duration
        )

    @property
    def mean_value(self) -> float:
        """The value after the ramp."""
        return self.final

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value at any time."""
        return min(self.initial, self.final), max(self.initial, self.final)


class Pulse(Section):
    """From `initial` to `peak` and back, both along a `smooth_step`."""

    kind: Literal["pulse"] = setting("pulse", "kind of law")
    initial: Number = quantity(0.0, UNIT_OF_OWNER, "value before and after the pulse")
    peak: Number = quantity(..., UNIT_OF_OWNER, "value between rise and fall")
    start: Number = quantity(0.0, "s", "time at which the rise begins")
    rise: Number = quantity(..., "s", "duration of the rise; 0 is a jump", ge=0)
    fall_start: Number = quantity(
        ..., "s", "time at which the fall begins, at or after the end of the rise"
    )
    fall: Number = quantity(..., "s", "duration of the fall; 0 is a jump", ge=0)

    @model_validator(mode="after")
    def _rise_ends_before_fall(self) -> Pulse:
        if self.fall_start < self.start + self.rise:
            raise SceneError(
                f"fall_start = {self.fall_start} s is before the end of the rise at"
                f" {self.start + self.rise} s; it must be at least start + rise"
            )
        return self

    def at(self, time: ArrayLike) -> Values:
        """Value at each time [s]."""
        up, down = (
            smooth_step(time, self.start, self.rise),
            smooth_step(time, self.fall_start, self.fall),
        )
        return self.initial + (self.peak - self.initial) * (up - down)

    @property
    def mean_value(self) -> float:
        """The value before and after the pulse, not the average over time."""
        return self.initial

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value at any time."""
        return min(self.initial, self.peak), max(self.initial, self.peak)


class Harmonic(Section):
    """mean + amplitude sin(2 pi frequency_hz (t - start) + phase) after `start`; mean before."""

    kind: Literal["harmonic"] = setting("harmonic", "kind of law")
    mean: Number = quantity(0.0, UNIT_OF_OWNER, "mean value, also the value before the start")
    amplitude: Number = quantity(..., UNIT_OF_OWNER, "amplitude, half peak-to-peak")
    frequency_hz: Number = quantity(..., "Hz", "frequency", gt=0)
    phase_deg: Number = quantity(0.0, "deg", "phase at the start", ge=-360, le=360)
    start: Number = quantity(0.0, "s", "time at which the oscillation begins")

    def at(self, time: ArrayLike) -> Values:
        """Value at each time [s]."""
        since = np.asarray(time, dtype=np.float64) - self.start
        wave = np.sin(2.0 * np.pi * self.frequency_hz * since + np.radians(self.phase_deg))
        return self.mean + self.amplitude * np.where(since >= 0.0, wave, 0.0)

    @property
    def mean_value(self) -> float:
        """The mean over whole periods."""
        return self.mean

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value at any time."""
        return self.mean - abs(self.amplitude), self.mean + abs(self.amplitude)


class TimedTable(Section):
    """Times of a table, and how they lie in the run: origin, end, gaps."""

    file: Text | None = setting(None, "CSV file; its columns become the arrays on loading")
    time: Annotated[tuple[Number, ...], Field(strict=False)] = quantity(
        ..., "s", "times, increasing; the same time twice is a jump"
    )
    origin: Number = quantity(0.0, "s", "time in the table at which the run begins")
    beyond: Literal["hold", "repeat"] = setting(
        "hold",
        "outside of the table: hold its first and last row, or repeat it; the last row is then the"
        " first of the next period",
    )
    max_gap: Number | None = quantity(
        None, "s", "maximum spacing (default: ten times the median)", gt=0
    )

    @property
    def first(self) -> float:
        """Time [s] of the run at the first row."""
        return self.time[0] - self.origin

    @property
    def last(self) -> float:
        """Time [s] of the run at the last row."""
        return self.time[-1] - self.origin

    @property
    def run_times(self) -> Values:
        """Times of the rows [s] from the start of the run."""
        return np.asarray(self.time) - self.origin

    def table_time(self, time: ArrayLike) -> Values:
        """Time [s] in the table for times [s] of the run, within the table if it repeats."""
        shifted = np.asarray(time, dtype=np.float64) + self.origin
        if self.beyond == "repeat":
            shifted = self.time[0] + np.mod(shifted - self.time[0], self.time[-1] - self.time[0])
        return shifted


class _KindOfTable(Section):
    """The kind of a table; a base class, so that it comes before the long arrays in a file."""

    kind: Literal["table"] = setting("table", "kind of law")


class TimeTable(TimedTable, _KindOfTable):
    """Values at given times, linear between them.

    Given as two arrays, or as a CSV file with header ``time,value``, which is read into the arrays
    on loading. Two values at one time are a jump. A spacing above `max_gap` is refused, as it is
    probably a gap in a measurement.
    """

    file: Text | None = setting(
        None, "CSV file with header time,value; its columns become the arrays on loading"
    )
    value: Annotated[tuple[Number, ...], Field(strict=False)] = quantity(
        ..., UNIT_OF_OWNER, "value at each time"
    )

    @model_validator(mode="before")
    @classmethod
    def _read_file(cls, data: Any, info: ValidationInfo) -> Any:
        data, table = take_in_file(data, info, "time", {"time": "s", "value": ""}, jumps=True)
        if table is not None:
            gap = data.get("max_gap")
            check_gaps(table, gap if isinstance(gap, (int, float)) else None, f"{table.file}: ")
        if isinstance(data, dict) and isinstance(data.get("time"), (list, tuple)):
            data = {**data, "time": _spread_jumps(data["time"])}
        return data

    @model_validator(mode="after")
    def _points_in_order(self) -> TimeTable:
        columns = {"time": self.time, "value": self.value}
        check_table("", "time", columns)
        check_gaps(Table("", columns, range(1, len(self.time) + 1)), self.max_gap, "")
        return self

    def at(self, time: ArrayLike) -> Values:
        """Value at each time [s]."""
        return np.asarray(np.interp(self.table_time(time), self.time, self.value))

    @property
    def mean_value(self) -> float:
        """The mean over the time of the table."""
        return float(np.trapezoid(self.value, self.time) / (self.time[-1] - self.time[0]))

    @property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest value at any time."""
        return min(self.value), max(self.value)


JUMP = 1e-12
"""Duration [s] of a jump; the kernel does not differentiate jumps."""


def _spread_jumps(times: Sequence[Any]) -> tuple[Any, ...]:
    """Return strictly increasing times: the second of two equal ones is `JUMP` later."""
    if not all(isinstance(time, (int, float)) and math.isfinite(time) for time in times):
        return tuple(times)
    spread = list(times)
    for i in range(1, len(times)):
        if times[i] == times[i - 1] and (i == 1 or times[i - 2] < times[i]):
            spread[i] = math.nextafter(times[i] + JUMP, math.inf)
    return tuple(spread)


def check_gaps(table: Table, max_gap: float | None, where: str) -> None:
    """Refuse a spacing above `max_gap` [s] (default: ten times the median) in the column time."""
    spacing = np.diff(table.columns["time"])
    longest = int(np.argmax(spacing))
    allowed = 10.0 * float(np.median(spacing[spacing > 1e3 * JUMP])) if max_gap is None else max_gap
    if spacing[longest] > allowed:
        before, after = table.columns["time"][longest : longest + 2]
        raise SceneError(
            f"{where}gap of {after - before:g} s in time before row {table.rows[longest + 1]} (from"
            f" {before:g} to {after:g} s); at most {allowed:g} s are interpolated: fill it, or"
            " raise max_gap to interpolate"
        )


Law = Annotated[Constant | Ramp | Pulse | Harmonic | TimeTable, Field(discriminator="kind")]
"""Any of the laws; in a scene file, ``kind`` selects it."""
