"""A tension section: its spans, the towers between and beyond them, and its strung state."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.conductor import OwnIce
from gallop_fmu.scene.fields import Number, Section, WholeNumber, quantity, setting
from gallop_fmu.scene.supports import RigidSupport, displacement_of
from gallop_fmu.scene.suspensions import SectionEnd, Suspension
from gallop_fmu.scene.wind import SpanWind

MAX_SPANS = 1000
"""Maximum number of spans of a section."""


class SectionSpan(Section):
    """One span of a section, between the attachment points of the conductor."""

    NUMBERED: ClassVar[str] = "span"

    length: Number = quantity(
        ..., "m", "horizontal distance between the attachment points", gt=0, le=10000
    )
    height_difference: Number = quantity(
        0.0, "m", "height of the right attachment point above the left"
    )
    elements: WholeNumber | None = quantity(
        None,
        "1",
        "number of elements of each subconductor (default: numerics.elements)",
        ge=2,
        le=5000,
    )
    ice: OwnIce = setting(None, 'ice on this span, in place of [ice]; "none": bare')
    wind: SpanWind | None = setting(None, "wind speed on this span, in place of that of [wind]")

    @model_validator(mode="after")
    def _not_too_steep(self) -> SectionSpan:
        if abs(self.height_difference) >= self.length:
            raise SceneError(
                f"height_difference = {self.height_difference:g} m must be less than length ="
                f" {self.length:g} m either way"
            )
        return self


class TensionSection(Section):
    """Spans between two ends, straight in plan, in the state in which they were strung.

    In the strung state all strings are plumb, and all spans are catenaries with the same horizontal
    tension. It fixes the unstretched lengths. Ice, temperature and wind act on the section from
    there.
    """

    horizontal_tension: Number | None = quantity(
        None, "N", "horizontal tension of each subconductor in the strung state", gt=0
    )
    sag: Number | None = quantity(
        None,
        "m",
        "sag of span sag_span in the strung state, at its middle from its chord, in place of"
        " horizontal_tension",
        gt=0,
    )
    sag_span: WholeNumber | None = quantity(
        None, "1", "number of the span with the given sag, from 1", ge=1
    )
    strung_with_ice: bool = setting(False, "true: the ice was there in the strung state")
    strung_temperature_deg_c: Number = quantity(
        15.0, "degC", "temperature of the strung state", ge=-80, le=250
    )
    temperature_deg_c: Number = quantity(
        15.0, "degC", "temperature of the conductor now", ge=-80, le=250
    )
    gravity: Number = quantity(9.81, "m/s2", "acceleration of gravity", gt=0, le=100)
    rated_strength: Number | None = quantity(
        None, "N", "rated strength of a subconductor; larger tensions get a warning", gt=0
    )
    spans: Annotated[tuple[SectionSpan, ...], Field(strict=False)] = Field(
        ..., description="spans from left to right", min_length=1, max_length=MAX_SPANS
    )
    suspensions: Annotated[tuple[Suspension, ...], Field(strict=False)] = setting(
        (), "suspensions from left to right, one between each two spans"
    )
    left_end: SectionEnd = setting(RigidSupport(), "end at the left of span 1")
    right_end: SectionEnd = setting(RigidSupport(), "end at the right of the last span")

    @model_validator(mode="after")
    def _determined(self) -> TensionSection:
        if (self.sag is None) == (self.horizontal_tension is None):
            given = "neither" if self.sag is None else "both"
            raise SceneError(
                f"{given} of horizontal_tension [N] and sag [m] given for the strung state; give"
                " exactly one (None removes the other)"
            )
        if (self.sag is None) != (self.sag_span is None):
            missing = "sag [m]" if self.sag is None else "sag_span"
            raise SceneError(
                f"only one of sag and sag_span given; give {missing}, too: sag_span is the number"
                " of the span with the sag, from 1"
            )
        if self.sag_span is not None and self.sag_span > len(self.spans):
            raise SceneError(
                f"sag_span = {self.sag_span}: the section has {_count(len(self.spans), 'span')};"
                f" give a number from 1 to {len(self.spans)}"
            )
        return self

    @model_validator(mode="after")
    def _suspension_between_spans(self) -> TensionSection:
        required, given = len(self.spans) - 1, len(self.suspensions)
        if given != required:
            raise SceneError(
                f"suspensions: {given} given, but {_count(len(self.spans), 'span')} need"
                f"{'s' * (len(self.spans) == 1)} {required}; give one between each two spans (the"
                " ends are left_end and right_end)"
            )
        return self

    def displacement_at(self, time: float) -> NDArray[np.float64]:
        """Displacement [m] of the tower points (row) along x1, x2, x3 at a time [s]."""
        held = (self.left_end, *self.suspensions, self.right_end)
        return displacement_of([tower.motion for tower in held], time)

    @property
    def temperature_change(self) -> float:
        """Temperature now minus that of the strung state [K]."""
        return self.temperature_deg_c - self.strung_temperature_deg_c


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
