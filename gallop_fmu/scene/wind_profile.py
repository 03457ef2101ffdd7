"""Mean wind speed over the height above ground.

- power law: (z/z_ref)^exponent, as in IEC 61400-1, 6.3;
- logarithmic: ln(z/z_0)/ln(z_ref/z_0), with the roughness length z_0, as in EN 1991-1-4, 4.3.2, for
  neutral stratification.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, quantity, setting

Values = NDArray[np.float64]


class _Profile(Section):
    """What both profiles have: the heights above ground."""

    reference_height: Number = quantity(
        10.0, "m", "height above ground of the given wind speed", gt=0, le=1000
    )
    attachment_height: Number = quantity(
        ..., "m", "height above ground of the left attachment point (tower 0)", gt=0, le=1000
    )
    ground_heights: Annotated[tuple[Number, ...], Field(strict=False)] | None = quantity(
        None,
        "m",
        "height of the ground at each tower above that at tower 0, linear between (default:"
        " horizontal ground)",
    )

    def factor(self, height: ArrayLike) -> Values:
        """Mean speed at heights above ground [m] over that at the reference height."""
        raise NotImplementedError

    def ground(self, towers: ArrayLike) -> tuple[Values, Values]:
        """Return x1 and x2 [m] of points of the ground, linear between and constant beyond.

        Parameters
        ----------
        towers : array_like, shape (tower,)
            x1 of the towers [m]; x2 = 0 is the height of the left attachment point.
        """
        x1 = np.asarray(towers, dtype=np.float64)
        rise = np.zeros(len(x1)) if self.ground_heights is None else np.array(self.ground_heights)
        return x1, rise - self.attachment_height


class PowerProfile(_Profile):
    """Power law: the speed grows as (z/z_ref)^exponent."""

    kind: Literal["power"] = setting("power", "kind of profile")
    exponent: Number = quantity(
        ..., "1", "exponent; typical are 0.12 over water, 0.16 over open country", ge=0, le=1
    )

    def factor(self, height: ArrayLike) -> Values:
        """Mean speed at heights above ground [m] over that at the reference height."""
        return np.asarray((np.asarray(height) / self.reference_height) ** self.exponent)


class LogarithmicProfile(_Profile):
    """Logarithmic law: the speed grows as ln(z/z_0)."""

    kind: Literal["logarithmic"] = setting("logarithmic", "kind of profile")
    roughness_length: Number = quantity(
        ..., "m", "roughness length z_0; typical are 0.01 over snow, 0.05 over farmland", gt=0, le=5
    )

    @model_validator(mode="after")
    def _above_roughness(self) -> LogarithmicProfile:
        for name in ("reference_height", "attachment_height"):
            height = getattr(self, name)
            if height <= self.roughness_length:
                raise SceneError(
                    f"{name} = {height:g} m must be greater than roughness_length ="
                    f" {self.roughness_length:g} m, where the speed is 0; check both"
                )
        return self

    def factor(self, height: ArrayLike) -> Values:
        """Mean speed at heights above ground [m] over that at the reference height."""
        z0 = self.roughness_length
        return np.asarray(np.log(np.asarray(height) / z0) / np.log(self.reference_height / z0))


Profile = Annotated[PowerProfile | LogarithmicProfile, Field(discriminator="kind")]
"""Any of the profiles; in a scene file, ``kind`` selects it."""


def too_low(profile: Any, heights: ArrayLike) -> str:
    """Describe towers whose attachment point is not above ground; empty if there are none.

    Parameters
    ----------
    heights : array_like, shape (tower,)
        Heights [m] of the attachment points above the left one.
    """
    above = np.asarray(heights, dtype=np.float64) + profile.attachment_height
    if profile.ground_heights is not None:
        if len(profile.ground_heights) != len(above):
            return (
                f"wind.profile.ground_heights has {len(profile.ground_heights)} values, and the"
                f" scene has {len(above)} towers; give one for each, from tower 0"
            )
        if profile.ground_heights[0] != 0.0:
            return (
                f"wind.profile.ground_heights: the first is {profile.ground_heights[0]:g} m, must"
                " be 0: the ground at tower 0, from which the others are measured"
            )
        above = above - np.asarray(profile.ground_heights)
    lowest = getattr(profile, "roughness_length", 0.0)
    tower = int(np.argmin(above))
    if above[tower] > lowest:
        return ""
    return (
        f"wind.profile: the attachment point of tower {tower} is {above[tower]:g} m above ground,"
        f" must be more than {lowest:g} m; check attachment_height, ground_heights and the height"
        " differences of the spans"
    )
