"""Fields and checks that the kinds of coefficient curve share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from pydantic import Field

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.aerodynamic_curve import Outside
from gallop_fmu.scene.fields import Number

Coefficients = Annotated[tuple[Number, ...], Field(strict=False)]

MAX_COEFFICIENT = 10.0
"""Maximum coefficient; measured ones of iced conductors are below 3."""

OUTSIDE_MEANING = (
    "outside the validity range: an error, the end value (hold), or the repeated curve (periodic)"
)
RADIUS_MEANING = "radius r of the relative wind's twist part r omega (default: half the diameter)"


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
