"""Coefficients measured at a number of attack angles."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import ValidationInfo, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import check_table, take_in_file
from gallop_fmu.scene.aerodynamic_curve import COEFFICIENTS, TURN, AerodynamicCurve, Outside
from gallop_fmu.scene.curve_fields import (
    OUTSIDE_MEANING,
    RADIUS_MEANING,
    Coefficients,
    check_coefficients,
    check_range,
)
from gallop_fmu.scene.curve_file import read_curve
from gallop_fmu.scene.fields import Number, Section, Text, quantity, setting

CURVE_COLUMNS = {"angle_deg": "deg", **dict.fromkeys(COEFFICIENTS, "1")}
"""Columns of a coefficient file, and their units."""

WRAPPED_POINTS = 3
"""Points beyond each end of a turn: two for a PCHIP slope, one more for the end formula."""

MAX_STEP_OF_TURN = 45.0
"""Maximum step [deg] of a table that ends one step before a whole turn."""

GAP_STEPS, MIN_GAP, MAX_GAP = 3.0, 10.0, 45.0
"""A gap is a step above this number of the median step, and above these [deg]: warning, error."""

END_NOISE_SHARE, END_NOISE = 0.05, 0.01
"""Maximum noise between the two ends of a turn: share of the coefficient's range, or value."""


class TableCoefficients(Section):
    """Measured coefficients with monotone cubic interpolation (PCHIP), without overshoot.

    A table over a whole turn is periodic by default: one of 360 deg, whose ends are the same angle,
    or one that ends a step before, such as 0, 10, ... 350 deg. If the ends of 360 deg differ by
    noise, their mean is used.

    Given as four arrays, or as a CSV file with header ``angle_deg,lift,drag,moment`` (or
    ``angle_rad`` for radians), which is read into the arrays on loading.
    """

    kind: Literal["table"] = setting("table", "kind of coefficient curve")
    file: Text | None = setting(
        None,
        "CSV file with header angle_deg,lift,drag,moment (angle_rad: radians); its columns become"
        " the arrays on loading",
    )
    angle_deg: Coefficients = quantity(
        ..., "deg", "attack angles, strictly increasing, over at most 360 deg"
    )
    lift: Coefficients = quantity(..., "1", "lift coefficient at each angle")
    drag: Coefficients = quantity(..., "1", "drag coefficient at each angle")
    moment: Coefficients = quantity(..., "1", "moment coefficient at each angle")
    outside: Outside | None = setting(
        None,
        f"{OUTSIDE_MEANING} (default: periodic for angles over a whole turn, otherwise an error)",
    )
    reference_radius: Number | None = quantity(None, "m", RADIUS_MEANING, gt=0)

    @model_validator(mode="before")
    @classmethod
    def _read_file(cls, data: Any, info: ValidationInfo) -> Any:
        return take_in_file(data, info, "angle_deg", CURVE_COLUMNS, read=read_curve)[0]

    @model_validator(mode="after")
    def _points_in_order(self) -> TableCoefficients:
        check_table("", "angle_deg", {name: getattr(self, name) for name in CURVE_COLUMNS})
        check_coefficients(self.angle_deg, {name: getattr(self, name) for name in COEFFICIENTS})
        if (gap := self._gap()) is not None and gap[1] - gap[0] > MAX_GAP:
            raise SceneError(
                f"no coefficients between {gap[0]:g} and {gap[1]:g} deg: a gap of"
                f" {gap[1] - gap[0]:g} deg in a table whose median step is {self._median_step:g}"
                " deg; give the missing rows, or only the part of the table on one side"
            )
        first, last = self.range_deg
        check_range("first angle_deg", first, "last angle_deg", last, self.beyond)
        if self.beyond == "periodic":
            for name, (start, end) in self._unequal_ends().items():
                values = getattr(self, name)
                noise = max(END_NOISE_SHARE * (max(values) - min(values)), END_NOISE)
                if abs(end - start) > noise:
                    raise SceneError(
                        f"{name} is {start:g} at {first:g} deg and {end:g} at {last:g} deg, the"
                        ' same angle; make them equal, or set outside = "error" or "hold" to use'
                        " the table as it is"
                    )
        return self

    @property
    def beyond(self) -> Outside:
        """Rule outside the validity range: `outside`, or the default."""
        return self.outside or (
            "periodic" if self._is_whole_turn or self._is_one_step_short else "error"
        )

    @property
    def _is_whole_turn(self) -> bool:
        return self.angle_deg[-1] - self.angle_deg[0] == 360.0

    @property
    def _is_one_step_short(self) -> bool:
        """Check that the gap to the whole turn is at most one step."""
        widest = float(np.max(np.diff(self.angle_deg)))
        gap = 360.0 - (self.angle_deg[-1] - self.angle_deg[0])
        return (
            len(self.angle_deg) > 2
            and 0.0 < gap <= (1.0 + 1e-6) * widest
            and widest <= MAX_STEP_OF_TURN
        )

    @property
    def _median_step(self) -> float:
        return float(np.median(np.diff(self.angle_deg)))

    def _gap(self) -> tuple[float, float] | None:
        """Angles [deg] on both sides of the widest step, if that is a gap."""
        steps = np.diff(self.angle_deg)
        widest = int(np.argmax(steps))
        if steps[widest] <= max(GAP_STEPS * self._median_step, MIN_GAP):
            return None
        return self.angle_deg[widest], self.angle_deg[widest + 1]

    def _open_turn(self) -> list[str]:
        """Warning about a table that ends a little before a whole turn and is not closed."""
        missing = 360.0 - (self.angle_deg[-1] - self.angle_deg[0])
        if self.outside is not None or self.beyond == "periodic" or not 0.0 < missing <= MAX_GAP:
            return []
        return [
            f"aerodynamics.angle_deg covers all but {missing:g} deg of a turn, more than one step,"
            " and is not closed: a motion there ends the run; give the missing rows, or set"
            ' outside = "hold"'
        ]

    def _unequal_ends(self) -> dict[str, tuple[float, float]]:
        """First and last value of each coefficient whose values at both ends of a turn differ."""
        if self.beyond != "periodic" or not self._is_whole_turn:
            return {}
        ends = {name: (getattr(self, name)[0], getattr(self, name)[-1]) for name in COEFFICIENTS}
        return {name: (start, end) for name, (start, end) in ends.items() if start != end}

    def warnings(self) -> list[str]:
        """Warnings about gaps, and about values that differ at both ends of a turn."""
        found = self._open_turn()
        if (gap := self._gap()) is not None:
            found.append(
                f"aerodynamics has no values between {gap[0]:g} and {gap[1]:g} deg (median step:"
                f" {self._median_step:g} deg): they are interpolated; give the missing rows"
            )
        elif (widest := float(np.max(np.diff(self.angle_deg)))) > MAX_GAP:
            found.append(
                f"aerodynamics.angle_deg has steps of up to {widest:g} deg, between which lift and"
                " its slope are hardly known; give steps of at most 10 deg"
            )
        return found + [
            f"aerodynamics.{name} is {start:g} at {self.angle_deg[0]:g} deg and {end:g} at"
            f" {self.angle_deg[-1]:g} deg, the same angle: the mean of both is used"
            for name, (start, end) in self._unequal_ends().items()
            if abs(end - start) > 1e-9
        ]

    @property
    def range_deg(self) -> tuple[float, float]:
        """Validity range [deg], including the step that closes a turn."""
        first, last = self.angle_deg[0], self.angle_deg[-1]
        return (
            (first, first + 360.0)
            if self.beyond == "periodic" and self._is_one_step_short
            else (first, last)
        )

    @property
    def label(self) -> str:
        """Kind and range of the curve."""
        first, last = self.angle_deg[0], self.angle_deg[-1]
        return f"table of {len(self.angle_deg)} angles from {first:g} to {last:g} deg"

    def explicit(self) -> TableCoefficients:
        """Return the curve with its numbers, which is this one."""
        return self

    def curve(self) -> AerodynamicCurve:
        """Return the curve: a piece between neighbouring points, smooth where a turn closes."""
        # A slow import, which polynomials do not need.
        from scipy.interpolate import PchipInterpolator

        angle_deg = self.angle_deg
        short = self.range_deg[1] > angle_deg[-1]
        angle = np.radians([*angle_deg, self.range_deg[1]] if short else angle_deg)
        unequal = self._unequal_ends()
        pieces = len(angle) - 1
        wrap = min(WRAPPED_POINTS, pieces) if self.beyond == "periodic" else 0
        wrapped = np.concatenate(
            [angle[pieces - wrap : pieces] - TURN, angle, angle[1 : 1 + wrap] + TURN]
        )
        coefficient = np.empty((pieces, 3, 4))
        for c, name in enumerate(COEFFICIENTS):
            y = np.array(getattr(self, name))
            if short:
                y = np.append(y, y[0])
            if name in unequal:
                y[0] = y[-1] = 0.5 * (y[0] + y[-1])
            y = np.concatenate([y[pieces - wrap : pieces], y, y[1 : 1 + wrap]])
            highest_first = PchipInterpolator(wrapped, y).c[:, wrap : wrap + pieces]
            coefficient[:, c, :] = highest_first[::-1].T
        return AerodynamicCurve(angle, angle[:-1], coefficient, self.beyond)
