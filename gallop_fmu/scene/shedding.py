"""Ice that falls from a part of a span or line: where, and when."""

from __future__ import annotations

from typing import ClassVar

from pydantic import model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.fields import Number, Section, WholeNumber, quantity, setting
from gallop_fmu.scene.polynomial_coefficients import PolynomialCoefficients

BARE_DRAG = 1.0
"""Assumed drag coefficient of a conductor without ice, that of a round section (IEC 60826)."""


class SpanShedding(Section):
    """All ice falls from a part of the span, at a time or where the conductor accelerates.

    Position and velocity are continuous. From then on the part has no ice, and the coefficient
    curve of a bare conductor.
    """

    NUMBERED: ClassVar[str] = "shedding"

    from_station: Number = quantity(
        0.0, "1", "start as a fraction of the conductor's length in the span", ge=0, lt=1
    )
    to_station: Number = quantity(
        1.0, "1", "end as a fraction of the conductor's length in the span", gt=0, le=1
    )
    time: Number | None = quantity(None, "s", "time at which the ice falls", ge=0)
    acceleration: Number | None = quantity(
        None,
        "m/s2",
        "acceleration of the conductor across its axis at which the ice falls, in place of time;"
        " it is compared at the end of each time step",
        gt=0,
    )
    aerodynamics: Aerodynamics | None = setting(
        None,
        "coefficient curve of the bare conductor (default: drag of 1.0 alone, as of a round"
        " section)",
    )

    @model_validator(mode="after")
    def _falls_once(self) -> SpanShedding:
        if not self.from_station < self.to_station:
            raise SceneError(
                f"from_station = {self.from_station:g} must be less than to_station ="
                f" {self.to_station:g}; exchange them"
            )
        if (self.time is None) == (self.acceleration is None):
            given = "neither" if self.time is None else "both"
            raise SceneError(
                f"{given} of time [s] and acceleration [m/s2] given; give exactly one, by which"
                " the ice falls"
            )
        return self

    @property
    def bare_curve(self) -> Aerodynamics:
        """Coefficient curve once the ice has fallen."""
        return self.aerodynamics or PolynomialCoefficients(
            valid_from_deg=-180.0,
            valid_to_deg=180.0,
            lift=(0.0,),
            drag=(BARE_DRAG,),
            moment=(0.0,),
            outside="periodic",
        )


class Shedding(SpanShedding):
    """All ice falls from a part of one span of a line, as of a scene of one span."""

    span: WholeNumber = quantity(..., "1", "number of the span, from 1", ge=1)
    phase: WholeNumber | None = quantity(
        None, "1", "number of the phase, from 1 (default: each phase)", ge=1
    )
    subconductor: WholeNumber | None = quantity(
        None, "1", "number of the subconductor, from 1 (default: each)", ge=1
    )
