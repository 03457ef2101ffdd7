"""Coefficients as polynomials in the attack angle."""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import model_validator

from gallop_fmu.scene.aerodynamic_curve import COEFFICIENTS, AerodynamicCurve, Outside
from gallop_fmu.scene.curve_fields import (
    MAX_COEFFICIENT,
    OUTSIDE_MEANING,
    RADIUS_MEANING,
    Coefficients,
    check_closed,
    check_range,
)
from gallop_fmu.scene.fields import Number, Section, quantity, setting

POLYNOMIAL_POINTS = 361
"""Number of angles at which a polynomial is checked."""


class PolynomialCoefficients(Section):
    """Polynomials up to the third degree in (alpha - centre) in radians, lowest power first."""

    kind: Literal["polynomial"] = setting("polynomial", "kind of coefficient curve")
    centre_deg: Number = quantity(
        0.0, "deg", "attack angle where the polynomials begin", ge=-720, le=720
    )
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
        return list(_warnings(self))

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

    @property
    def label(self) -> str:
        """Kind and range of the curve."""
        return f"polynomial from {self.valid_from_deg:g} to {self.valid_to_deg:g} deg"

    def explicit(self) -> PolynomialCoefficients:
        """Return the curve with its numbers, which is this one."""
        return self

    def curve(self) -> AerodynamicCurve:
        """Return the curve, which has one piece."""
        coefficient = np.zeros((1, 3, 4))
        for c, name in enumerate(COEFFICIENTS):
            powers = getattr(self, name)
            coefficient[0, c, : len(powers)] = powers
        return AerodynamicCurve(
            np.radians(self.range_deg), np.radians([self.centre_deg]), coefficient, self.outside
        )


@lru_cache(maxsize=64)  # the runs of a sweep share few curves
def _warnings(coefficients: PolynomialCoefficients) -> tuple[str, ...]:
    """Return the warnings of a polynomial curve."""
    curve, found = coefficients.curve(), []
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
    return tuple(found)
