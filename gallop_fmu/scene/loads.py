"""Concentrated loads on the conductor."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, WholeNumber, quantity
from gallop_fmu.scene.time_functions import Constant, Law


class Load(Section):
    """Equal force and torque at one point or at evenly spaced points, times a law of time."""

    force: Annotated[tuple[Number, Number, Number], Field(strict=False)] = quantity(
        ..., "N", "force along x1 (span), x2 (up) and x3 (downwind) at each point"
    )
    torque: Number = quantity(
        0.0, "N m", "torque about x1 at each point, positive in the sense of the twist"
    )
    position: Number | None = quantity(
        None, "1", "loaded point as a fraction of the conductor's length", ge=0, le=1
    )
    evenly_spaced: WholeNumber | None = quantity(
        None,
        "1",
        "number n of loaded points, at k/(n+1) of the conductor's length, k = 1..n",
        ge=1,
        le=10000,
    )
    law: Law = quantity(Constant(value=1.0), "1", "amplitude factor in time")

    @model_validator(mode="after")
    def _one_way_to_place(self) -> Load:
        if (self.position is None) == (self.evenly_spaced is None):
            given = "neither" if self.position is None else "both"
            raise SceneError(f"{given} of position and evenly_spaced given; give exactly one")
        return self


class LineLoad(Load):
    """A load on one span of a line, on each phase and subconductor unless one is given."""

    NUMBERED: ClassVar[str] = "load"

    span: WholeNumber = quantity(..., "1", "number of the span, from 1", ge=1)
    phase: WholeNumber | None = quantity(
        None, "1", "number of the phase, from 1 (default: on each phase)", ge=1
    )
    subconductor: WholeNumber | None = quantity(
        None, "1", "number of the subconductor, from 1 (default: on each)", ge=1
    )
