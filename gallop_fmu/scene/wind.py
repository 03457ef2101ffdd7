"""The wind: a constant speed, or a history."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, quantity
from gallop_fmu.scene.time_functions import Law

MAX_WIND_SPEED = 150.0
"""Maximum wind speed [m/s]."""


class Wind(Section):
    """Wind towards +x3, uniform along the span: a constant speed or a history (default: 0)."""

    air_density: Number = quantity(1.225, "kg/m3", "density of air", gt=0)
    speed: Number | None = quantity(None, "m/s", "constant wind speed", ge=0, le=MAX_WIND_SPEED)
    history: Law | None = quantity(None, "m/s", "wind speed over time")

    @model_validator(mode="before")
    @classmethod
    def _calm_unless_given(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("speed") is None and data.get("history") is None:
            return {**data, "speed": 0.0}
        return data

    @model_validator(mode="after")
    def _one_wind(self) -> Wind:
        if self.history is None:
            return self
        if self.speed is not None:
            raise SceneError(
                f"speed = {self.speed} m/s and history are both given; give one of them (None"
                " removes the other)"
            )
        for extreme in self.history.extremes:
            if not 0.0 <= extreme <= MAX_WIND_SPEED:
                raise SceneError(
                    f"history reaches {extreme} m/s; the speed must stay within 0 to"
                    f" {MAX_WIND_SPEED} m/s"
                )
        return self

    @property
    def mean_speed(self) -> float:
        """The constant speed, or the `mean_value` of the history [m/s].

        The latter is the final value of a ramp, the value before and after a pulse, and the mean of
        a harmonic or a table.
        """
        return self.history.mean_value if self.history is not None else self.speed or 0.0

    @property
    def can_blow(self) -> bool:
        """True if the wind speed is not zero at all times."""
        return self.history.extremes != (0.0, 0.0) if self.history else bool(self.speed)
