"""The wind: its speed, direction, profile over the height, and gusts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, quantity, setting
from gallop_fmu.scene.time_functions import Constant, Law
from gallop_fmu.scene.turbulence import Turbulence
from gallop_fmu.scene.wind_profile import Profile
from gallop_fmu.scene.wind_table import WindTable

MAX_WIND_SPEED = 150.0
"""Maximum wind speed [m/s], in either sense."""

MAX_DIRECTION = 720.0
"""Maximum direction [deg] of a history, in either sense."""

MAX_USUAL_YAW = 60.0
"""Yaw [deg] from the normal up to which measurements agree with the cosine law."""


OTHER_SIDE = "the wind comes from the other side (towards -x3)"
"""Words for wind with a part across the line that is negative."""


class SpanWind(Section):
    """Wind speed of one span of a line, in place of that of the line."""

    speed: Number | None = quantity(
        None,
        "m/s",
        "constant wind speed; negative: from the other side",
        ge=-MAX_WIND_SPEED,
        le=MAX_WIND_SPEED,
    )
    history: Law | None = quantity(None, "m/s", "wind speed over time")

    @model_validator(mode="after")
    def _one_speed(self) -> SpanWind:
        if self.speed is None and self.history is None:
            raise SceneError(
                "neither speed [m/s] nor history is given; give one of them, or remove the wind of"
                " this span: it then has that of the line"
            )
        _check_speed(self.speed, self.history)
        return self

    @property
    def speed_law(self) -> Law:
        """The speed [m/s] over time."""
        return self.history or Constant(value=self.speed or 0.0)


class Wind(Section):
    """Wind: speed, direction, profile over the height, and gusts (default: calm).

    It blows towards +x3 unless a direction is given: W = U (sin psi, 0, cos psi).
    """

    air_density: Number = quantity(1.225, "kg/m3", "density of air", gt=0)
    speed: Number | None = quantity(
        None,
        "m/s",
        "constant wind speed; negative: from the other side",
        ge=-MAX_WIND_SPEED,
        le=MAX_WIND_SPEED,
    )
    history: Law | None = quantity(None, "m/s", "wind speed over time")
    direction_deg: Number = quantity(
        0.0,
        "deg",
        "direction psi: yaw from the normal of the line (+x3) towards +x1",
        ge=-360,
        le=360,
    )
    direction_history: Law | None = quantity(
        None, "deg", "direction over time, in place of direction_deg"
    )
    profile: Profile | None = setting(
        None, "mean speed over the height (default: the same at all heights)"
    )
    turbulence: Turbulence | None = setting(None, "gusts by spectrum and coherence")
    table: WindTable | None = setting(
        None, "speeds over the line and time, in place of speed, history, profile and turbulence"
    )

    @model_validator(mode="before")
    @classmethod
    def _calm_unless_given(cls, data: Any) -> Any:
        sources = ("speed", "history", "table")
        if isinstance(data, dict) and all(data.get(name) is None for name in sources):
            return {**data, "speed": 0.0}
        return data

    @model_validator(mode="after")
    def _one_wind(self) -> Wind:
        _check_speed(self.speed, self.history)
        self._check_direction()
        if self.table is not None:
            others = ("speed", "history", "profile", "turbulence")
            both = [name for name in others if getattr(self, name) is not None]
            if both:
                raise SceneError(
                    f"table and {', '.join(both)} are both given; the table has the speeds: remove"
                    f" {'it' if len(both) == 1 else 'them'}, or the table"
                )
            _check_extremes("table.speed", self.table.extremes, "m/s", MAX_WIND_SPEED)
        if self.turbulence is not None and not self.turbulence.is_calm and not self.mean_speed:
            raise SceneError(
                f"turbulence.intensity = {self.turbulence.intensity:g} is relative to the mean"
                " speed, which is 0 m/s; give a mean speed, or remove turbulence"
            )
        return self

    def _check_direction(self) -> None:
        if self.direction_history is not None:
            if self.direction_deg != 0.0:
                raise SceneError(
                    f"direction_deg = {self.direction_deg:g} deg and direction_history are both"
                    " given; give one of them"
                )
            extremes = self.direction_history.extremes
            _check_extremes("direction_history", extremes, "deg", MAX_DIRECTION)
        low, high = self.directions
        if low == high and abs(abs(math.remainder(low, 180.0)) - 90.0) < 1e-9:
            name = "direction_deg" if self.direction_history is None else "direction_history"
            raise SceneError(
                f"{name} = {low:g}: the wind blows along the line, with no part across it; give an"
                " angle from the normal below 90 deg (above 90 deg it comes from the other side)"
            )

    @property
    def directions(self) -> tuple[float, float]:
        """Lowest and highest direction at any time [deg]."""
        if self.direction_history is not None:
            return self.direction_history.extremes
        return self.direction_deg, self.direction_deg

    @property
    def mean_direction(self) -> float:
        """The constant direction, or the `mean_value` of its history [deg]."""
        history = self.direction_history
        return self.direction_deg if history is None else history.mean_value

    @property
    def direction_law(self) -> Law | None:
        """The direction [deg] over time; None: always 0."""
        if self.direction_history is not None:
            return self.direction_history
        return Constant(value=self.direction_deg) if self.direction_deg else None

    @property
    def speed_law(self) -> Law:
        """The speed [m/s] over time, without gusts; of a table its mean."""
        if self.table is not None:
            return Constant(value=self.table.mean_value)
        return self.history or Constant(value=self.speed or 0.0)

    @property
    def mean_speed(self) -> float:
        """The constant speed, the `mean_value` of the history, or the mean of the table [m/s].

        That of a history is the final value of a ramp, the value before and after a pulse, and the
        mean of a harmonic or a table. It is negative if the wind comes from the other side.
        """
        return self.speed_law.mean_value

    @property
    def can_blow(self) -> bool:
        """True if the wind speed is not zero at all times."""
        return self.speed_law.extremes != (0.0, 0.0)

    @property
    def turn_deg(self) -> float:
        """Rotation of the attack angle [deg] by the mean wind: 180 from the other side, else 0."""
        across = self.mean_speed * math.cos(math.radians(self.mean_direction))
        return 180.0 if across < 0.0 else 0.0

    def without_gusts(self) -> Wind:
        """The mean wind: without turbulence, and with the mean of a table."""
        if self.turbulence is None and self.table is None:
            return self
        speed = self.speed if self.table is None else self.table.mean_value
        return self.model_copy(update={"turbulence": None, "table": None, "speed": speed})

    @property
    def has_turbulence(self) -> bool:
        """True if turbulence is given and not all of its intensities are 0."""
        return self.turbulence is not None and not self.turbulence.is_calm

    @property
    def is_varied(self) -> bool:
        """True if the wind is described by more than its speed: direction, profile or gusts."""
        oblique = self.direction_law is not None or self.profile is not None
        return oblique or self.has_turbulence or self.table is not None

    @property
    def is_gusty(self) -> bool:
        """True if the speed varies irregularly in time, by turbulence or by a table."""
        return self.has_turbulence or (self.table is not None and self.table.varies_in_time)

    def warnings(self) -> list[str]:
        """Warnings about the direction, each a fact and a remedy."""
        found, name = [], "speed" if self.history is None else "history"
        name = name if self.table is None else "table.speed"
        lowest = (self.speed_law if self.table is None else self.table).extremes[0]
        if lowest < 0.0:
            found.append(from_the_other_side(f"wind.{name}", lowest, "m/s"))
        if self.directions == (0.0, 0.0):
            return found
        field = "wind.direction_deg" if self.direction_history is None else "wind.direction_history"
        angles = np.linspace(*self.directions, 721)
        largest = float(angles[np.argmax(-np.cos(np.radians(angles)))])
        if math.cos(math.radians(largest)) < -1e-12:
            found.append(from_the_other_side(field, largest, "deg"))
        largest = float(angles[np.argmin(abs(np.cos(np.radians(angles))))])
        if abs(math.cos(math.radians(largest))) < math.cos(math.radians(MAX_USUAL_YAW)) - 1e-12:
            found.append(
                f"{field} reaches {largest:g} deg: more than {MAX_USUAL_YAW:g} deg from the normal"
                " of the line, only the part of the wind normal to the conductor acts on it, and"
                " measurements of oblique wind differ from this; take the result as an estimate"
            )
        return found


def from_the_other_side(field: str, value: float, unit: str) -> str:
    """Return the warning about wind from the other side, wherever it is given."""
    return (
        f"{field} reaches {value:g} {unit}: {OTHER_SIDE}, so its attack angle is 180 deg more;"
        " check that the coefficient curve is valid there"
    )


def _check_speed(speed: float | None, history: Law | None) -> None:
    """Refuse two winds, and a history out of range."""
    if history is None:
        return
    if speed is not None:
        raise SceneError(
            f"speed = {speed} m/s and history are both given; give one of them (None"
            " removes the other)"
        )
    _check_extremes("history", history.extremes, "m/s", MAX_WIND_SPEED)


def _check_extremes(name: str, extremes: tuple[float, float], unit: str, limit: float) -> None:
    for extreme in extremes:
        if not abs(extreme) <= limit:
            raise SceneError(
                f"{name} reaches {extreme} {unit}; it must stay within {-limit:g} to {limit:g}"
                f" {unit}"
            )
