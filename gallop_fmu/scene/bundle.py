"""Bundle of subconductors of a phase, with its spacers."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, WholeNumber, quantity, setting

MAX_SUBCONDUCTORS = 8
"""Maximum number of subconductors of a bundle."""

Offset = Annotated[tuple[Number, Number], Field(strict=False)]
"""Position across the line: x2 (up), x3 (downwind) [m]."""


class Bundle(Section):
    """Subconductors of each phase, and the spacers that hold them apart (default: one conductor).

    The subconductors are at the corners of a regular polygon with a horizontal side at the top.
    They count from 1, from the corner that is upwind (towards -x3) on top, clockwise for a viewer
    who looks along x1: of a quad, 1 is upwind on top, 2 downwind on top, 3 downwind below, 4 upwind
    below; of a horizontal twin, 1 is upwind; of a vertical one, 1 is on top.

    A spacer is a rigid frame in its plane across the line, with an elastic clamp at each
    subconductor.
    """

    subconductors: WholeNumber = quantity(
        1, "1", "number of subconductors of each phase", ge=1, le=MAX_SUBCONDUCTORS
    )
    spacing: Number | None = quantity(
        None, "m", "distance of neighbouring subconductors in a regular polygon", gt=0
    )
    orientation: Literal["horizontal", "vertical"] | None = setting(
        None, "arrangement of a twin bundle (default: horizontal)"
    )
    offsets: Annotated[tuple[Offset, ...], Field(strict=False)] | None = quantity(
        None, "m", "position x2, x3 of each subconductor, in place of spacing and orientation"
    )
    spacers: WholeNumber | None = quantity(
        None,
        "1",
        "number n of spacers in each span, at k/(n+1) of its length, k = 1..n",
        ge=0,
        le=1000,
    )
    stations: Annotated[tuple[Number, ...], Field(strict=False)] | None = quantity(
        None, "1", "places of the spacers as fractions of each span, in place of spacers"
    )
    spacer_mass: Number = quantity(0.0, "kg", "mass of a spacer, equally at its clamps", ge=0)
    arm_stiffness: Number = quantity(
        1e7, "N/m", "stiffness of each arm of a spacer in its plane", gt=0
    )
    arm_damping: Number = quantity(
        1e4,
        "N s/m",
        "damping of each arm in its plane (chosen, so that vibration of the arms that no time step"
        " resolves decays)",
        ge=0,
    )
    clamp_torsional_stiffness: Number = quantity(
        500.0, "N m/rad", "stiffness of a clamp against rotation about x1 in the spacer", gt=0
    )
    clamp_damping: Number = quantity(
        0.0, "N m s/rad", "damping of a clamp's rotation in the spacer", ge=0
    )
    yoke_mass: Number = quantity(
        0.0, "kg", "mass of the yoke at each suspension string, equally at its clamps", ge=0
    )
    yoke_height: Number = quantity(
        0.0, "m", "height of the string's joint at the yoke above the bundle's centre"
    )

    @model_validator(mode="after")
    def _fits_the_number(self) -> Bundle:
        count = self.subconductors
        if count == 1:
            self._check_single()
        elif (self.spacing is None) == (self.offsets is None):
            given = "neither" if self.spacing is None else "both"
            raise SceneError(
                f"{given} of spacing [m] and offsets [m] given for {count} subconductors; give"
                " exactly one"
            )
        if self.offsets is not None and len(self.offsets) != count:
            raise SceneError(
                f"offsets has {len(self.offsets)} positions for {count} subconductors; give [x2,"
                " x3] of each"
            )
        if self.orientation is not None and (count != 2 or self.offsets is not None):
            reason = "with offsets" if self.offsets is not None else f"of {count} subconductors"
            raise SceneError(
                f'orientation = "{self.orientation}": only a twin bundle with spacing has one, not'
                f" a bundle {reason}; remove it"
            )
        return self

    @model_validator(mode="after")
    def _stations_in_order(self) -> Bundle:
        if self.stations is None:
            return self
        if self.spacers is not None:
            raise SceneError(
                f"spacers = {self.spacers} and stations are both given; give one of them"
            )
        previous = 0.0
        for number, station in enumerate(self.stations, start=1):
            if not 0.0 < station < 1.0:
                raise SceneError(
                    f"stations: spacer {number} is at {station:g}; must be greater than 0 and less"
                    " than 1 (fraction of the span)"
                )
            if number > 1 and not station > previous:
                raise SceneError(
                    f"stations must increase: spacer {number} is at {station:g} after"
                    f" {previous:g}; sort them, and remove double ones"
                )
            previous = station
        return self

    def _check_single(self) -> None:
        """Refuse what a single conductor does not have."""
        given = [
            name
            for name in ("spacing", "offsets", "spacers", "stations")
            if getattr(self, name) not in (None, 0, ())
        ]
        if given:
            raise SceneError(
                f"{given[0]} is given, but subconductors = 1: a single conductor has no"
                f" {'spacers' if given[0] in ('spacers', 'stations') else 'bundle spacing'}; set"
                " subconductors, or remove it"
            )

    @property
    def positions(self) -> tuple[tuple[float, float], ...]:
        """Position x2, x3 [m] of each subconductor; with `spacing` from the bundle's centre."""
        if self.offsets is not None:
            return self.offsets
        count, spacing = self.subconductors, self.spacing
        if count == 1 or spacing is None:
            return ((0.0, 0.0),)
        if self.orientation == "vertical":
            return ((0.5 * spacing, 0.0), (-0.5 * spacing, 0.0))
        # Angles from straight up; rounded so that mirrored corners have the same numbers.
        radius, step = 0.5 * spacing / math.sin(math.pi / count), 2.0 * math.pi / count
        angles = [(k - 0.5 - count * (k > count // 2)) * step for k in range(count)]
        return tuple(
            (round(radius * math.cos(a), 15) + 0.0, round(radius * math.sin(a), 15) + 0.0)
            for a in angles
        )

    @property
    def spacer_stations(self) -> tuple[float, ...]:
        """Places of the spacers as fractions of each span."""
        if self.stations is not None:
            return self.stations
        count = self.spacers or 0
        return tuple(k / (count + 1) for k in range(1, count + 1))
