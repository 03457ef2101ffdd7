"""Lift, drag and moment coefficients over the attack angle, as one piecewise-cubic curve.

Coefficients refer to the bare conductor's diameter: forces per unit length are q d CL and q d CD,
the moment q d^2 CM, with q the dynamic pressure of the relative wind. Lift acts normal to the
relative wind (up when the wind blows along +x3), drag along it, the moment in the sense of the
twist.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, ValidationInfo, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import check_table, take_in_file
from gallop_fmu.scene.fields import Number, Section, Text, quantity, setting

Values = NDArray[np.float64]
Outside = Literal["error", "hold", "periodic"]
COEFFICIENTS = ("lift", "drag", "moment")
CURVE_COLUMNS = {"angle_deg": "deg", **dict.fromkeys(COEFFICIENTS, "1")}
"""Columns of a coefficient file, and their units."""
POLYNOMIAL_POINTS = 361
"""Number of angles at which a polynomial is checked."""

MAX_COEFFICIENT = 10.0
"""Maximum coefficient; measured ones of iced conductors are below 3."""
TURN = 2.0 * np.pi
WRAPPED_POINTS = 3
"""Points beyond each end of a turn: two for a PCHIP slope, one more for the end formula."""

MAX_STEP_OF_TURN = 45.0
"""Maximum step [deg] of a table that covers a whole turn."""

END_NOISE_SHARE, END_NOISE = 0.05, 0.01
"""Maximum noise between the two ends of a turn: share of the coefficient's range, or value."""

OUTSIDE_MEANING = (
    "outside the validity range: an error, the end value (hold), or the repeated curve (periodic)"
)
RADIUS_MEANING = "radius r of the relative wind's twist part r omega (default: half the diameter)"


@dataclass(frozen=True)
class AerodynamicCurve:
    """Coefficients as cubics between breakpoints; attack angles in rad, arrays of any shape.

    An attack angle is first reduced modulo 2 pi to the turn centred on the validity range.

    Attributes
    ----------
    breakpoint : (pieces + 1,) array
        Ends of the pieces [rad], increasing; the first and last bound the validity range.
    origin : (pieces,) array
        Origin [rad] of the polynomial of each piece.
    coefficient : (pieces, 3, 4) array
        For each piece lift, drag, moment: coefficients of powers 0..3 of (alpha - origin[piece]).
    outside : {"error", "hold", "periodic"}
        Rule outside the validity range.
    """

    breakpoint: Values
    origin: Values
    coefficient: Values
    outside: Outside

    def lift(self, alpha: ArrayLike) -> Values:
        """Lift coefficient CL.

        Raises
        ------
        SceneError
            An angle is outside the validity range and `outside` is "error"; also in the other
            methods.
        """
        return self._evaluate(alpha, 0)

    def drag(self, alpha: ArrayLike) -> Values:
        """Drag coefficient CD."""
        return self._evaluate(alpha, 1)

    def moment(self, alpha: ArrayLike) -> Values:
        """Moment coefficient CM."""
        return self._evaluate(alpha, 2)

    def lift_slope(self, alpha: ArrayLike) -> Values:
        """Slope dCL/dalpha per radian; zero outside the validity range with ``"hold"``."""
        return self._slope(alpha, 0)

    def moment_slope(self, alpha: ArrayLike) -> Values:
        """Slope dCM/dalpha per radian; zero outside the validity range with ``"hold"``."""
        return self._slope(alpha, 2)

    def den_hartog(self, alpha: ArrayLike) -> Values:
        """Den Hartog's dCL/dalpha + CD per radian; vertical galloping requires a negative value."""
        return self.lift_slope(alpha) + self.drag(alpha)

    def _evaluate(self, alpha: ArrayLike, which: int) -> Values:
        _, piece, x = self._locate(alpha)
        c = self.coefficient[piece, which]
        return np.asarray(c[..., 0] + x * (c[..., 1] + x * (c[..., 2] + x * c[..., 3])))

    def _slope(self, alpha: ArrayLike, which: int) -> Values:
        angle, piece, x = self._locate(alpha)
        c = self.coefficient[piece, which]
        slope = c[..., 1] + x * (2.0 * c[..., 2] + 3.0 * x * c[..., 3])
        is_outside = (angle < self.breakpoint[0]) | (angle > self.breakpoint[-1])
        return np.where(is_outside, 0.0, slope)

    def _locate(self, alpha: ArrayLike) -> tuple[Values, NDArray[np.intp], Values]:
        """Return the reduced angle, its piece, and the distance from the origin of the piece."""
        first, last = self.breakpoint[0], self.breakpoint[-1]
        angle = np.asarray(alpha, dtype=np.float64)
        angle = angle - TURN * np.round((angle - 0.5 * (first + last)) / TURN)
        if self.outside == "error" and not np.all((angle >= first) & (angle <= last)):
            worst = angle[~((angle >= first) & (angle <= last))].flat[0]
            raise SceneError(
                f"attack angle {np.degrees(worst):g} deg is outside the coefficient curve, which"
                f" is valid from {np.degrees(first):g} to {np.degrees(last):g} deg; choose an angle"
                ' inside, or set outside = "hold"'
            )
        inside = np.clip(angle, first, last)
        piece = np.clip(
            np.searchsorted(self.breakpoint, inside, side="right") - 1, 0, len(self.coefficient) - 1
        )
        return angle, piece, inside - self.origin[piece]


Coefficients = Annotated[tuple[Number, ...], Field(strict=False)]


class PolynomialCoefficients(Section):
    """Polynomials up to the third degree in (alpha - centre) in radians, lowest power first."""

    kind: Literal["polynomial"] = setting("polynomial", "kind of coefficient curve")
    centre_deg: Number = quantity(0.0, "deg", "origin of the polynomials", ge=-720, le=720)
    valid_from_deg: Number = quantity(..., "deg", "start of the validity range", ge=-720, le=720)
    valid_to_deg: Number = quantity(
        ..., "deg", "end of the validity range, at most 360 deg after its start", ge=-720, le=720
    )
    lift: Coefficients = quantity(
        ..., "1", "lift polynomial, ascending powers of radians", min_length=1, max_length=4
    )
    drag: Coefficients = quantity(
        ..., "1", "drag polynomial, ascending powers of radians", min_length=1, max_length=4
    )
    moment: Coefficients = quantity(
        ..., "1", "moment polynomial, ascending powers of radians", min_length=1, max_length=4
    )
    outside: Outside = setting("error", OUTSIDE_MEANING)
    reference_radius: Number | None = quantity(None, "m", RADIUS_MEANING, gt=0)

    @property
    def beyond(self) -> Outside:
        """Rule outside the validity range."""
        return self.outside

    def warnings(self) -> list[str]:
        """Warnings about negative drag and coefficients above `MAX_COEFFICIENT`."""
        curve, found = self.curve(), []
        angle = np.linspace(curve.breakpoint[0], curve.breakpoint[-1], POLYNOMIAL_POINTS)
        for name in COEFFICIENTS:
            values = np.asarray(getattr(curve, name)(angle))
            worst = int(np.argmax(np.abs(values)))
            if abs(values[worst]) > MAX_COEFFICIENT:
                found.append(
                    f"aerodynamics.{name} reaches {values[worst]:.3g} at"
                    f" {np.degrees(angle[worst]):.0f} deg; coefficients are at most"
                    f" {MAX_COEFFICIENT:g} in magnitude: check it, or narrow the range"
                )
        drag = np.asarray(curve.drag(angle))
        least = int(np.argmin(drag))
        if drag[least] < 0.0:
            found.append(
                f"aerodynamics.drag is {drag[least]:.3g} at {np.degrees(angle[least]):.0f} deg;"
                " drag acts along the wind and is never negative: check the sign, or narrow the"
                " validity range"
            )
        return found

    @model_validator(mode="after")
    def _range_is_usable(self) -> PolynomialCoefficients:
        check_range(
            "valid_from_deg", self.valid_from_deg, "valid_to_deg", self.valid_to_deg, self.outside
        )
        if self.outside == "periodic":
            curve = self.curve()
            ends = curve.breakpoint - curve.origin[0]
            for name, c in zip(COEFFICIENTS, curve.coefficient[0], strict=True):
                check_closed(name, *(float(value) for value in np.polyval(c[::-1], ends)))
        return self

    @property
    def range_deg(self) -> tuple[float, float]:
        """Validity range [deg]."""
        return self.valid_from_deg, self.valid_to_deg

    def curve(self) -> AerodynamicCurve:
        """Return the curve, which has one piece."""
        coefficient = np.zeros((1, 3, 4))
        for c, name in enumerate(COEFFICIENTS):
            powers = getattr(self, name)
            coefficient[0, c, : len(powers)] = powers
        return AerodynamicCurve(
            np.radians(self.range_deg), np.radians([self.centre_deg]), coefficient, self.outside
        )


class TableCoefficients(Section):
    """Measured coefficients with monotone cubic interpolation (PCHIP), without overshoot.

    A table over a whole turn is periodic by default: one of 360 deg, whose ends are the same angle,
    or one that ends a step before, such as 0, 10, ... 350 deg. If the ends of 360 deg differ by
    noise, their mean is used.

    Given as four arrays, or as a CSV file with header ``angle_deg,lift,drag,moment``, which is read
    into the arrays on loading.
    """

    kind: Literal["table"] = setting("table", "kind of coefficient curve")
    file: Text | None = setting(
        None,
        "CSV file with header angle_deg,lift,drag,moment; its columns become the arrays on loading",
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
        return take_in_file(data, info, "angle_deg", CURVE_COLUMNS)[0]

    @model_validator(mode="after")
    def _points_in_order(self) -> TableCoefficients:
        check_table("", "angle_deg", {name: getattr(self, name) for name in CURVE_COLUMNS})
        check_coefficients(self.angle_deg, {name: getattr(self, name) for name in COEFFICIENTS})
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

    def _unequal_ends(self) -> dict[str, tuple[float, float]]:
        """First and last value of each coefficient whose values at both ends of a turn differ."""
        if self.beyond != "periodic" or not self._is_whole_turn:
            return {}
        ends = {name: (getattr(self, name)[0], getattr(self, name)[-1]) for name in COEFFICIENTS}
        return {name: (start, end) for name, (start, end) in ends.items() if start != end}

    def warnings(self) -> list[str]:
        """Warnings about coefficients whose values at both ends of a turn differ."""
        return [
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


Aerodynamics = Annotated[PolynomialCoefficients | TableCoefficients, Field(discriminator="kind")]
"""Either form of coefficient curve; in a scene file, ``kind`` selects it."""


def check_range(
    first_name: str, first: float, last_name: str, last: float, outside: Outside
) -> None:
    """Refuse an empty range, a range above a turn, and a periodic range that is not a turn."""
    if not first < last:
        raise SceneError(f"{first_name} = {first} must be less than {last_name} = {last} deg")
    if last - first > 360.0:
        raise SceneError(
            f"{first_name} = {first} to {last_name} = {last} is more than a turn; give at most"
            " 360 deg"
        )
    if outside == "periodic" and last - first != 360.0:
        raise SceneError(
            "outside = 'periodic' needs a range of exactly 360 deg, or of one step less (0, 10,"
            f" ... 350); {first_name} = {first} to {last_name} = {last} covers {last - first} deg"
        )


def check_coefficients(angle_deg: Sequence[float], columns: Mapping[str, Sequence[float]]) -> None:
    """Refuse negative drag, and coefficients above `MAX_COEFFICIENT`."""
    for name, values in columns.items():
        for angle, value in zip(angle_deg, values, strict=True):
            if abs(value) > MAX_COEFFICIENT:
                raise SceneError(
                    f"{name} = {value} at {angle} deg: a coefficient is at most"
                    f" {MAX_COEFFICIENT:g} in magnitude; check the order of the columns and that"
                    " forces are divided by rho v^2 d/2"
                )
            if name == "drag" and value < 0.0:
                raise SceneError(
                    f"drag = {value} at {angle} deg: drag acts along the wind and is never"
                    " negative; check the sign and the order of the columns"
                )


def check_closed(name: str, first: float, last: float) -> None:
    """Refuse a periodic coefficient with a jump where the turn closes."""
    if abs(last - first) > 1e-9:
        raise SceneError(
            f"outside = 'periodic' needs equal end values; {name} starts at {first} and ends at"
            f" {last}"
        )
