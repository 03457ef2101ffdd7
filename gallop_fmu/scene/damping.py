"""Structural damping, given as damping ratios instead of Rayleigh coefficients."""

from __future__ import annotations

from pydantic import model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, quantity, setting


class RayleighPair(Section):
    """Damping ratios at two frequencies, which determine C = b1 M + b2 K.

    With ratios x1, x2 at w1 < w2 [rad/s],

    - b1 = 2 w1 w2 (x1 w2 - x2 w1) / (w2^2 - w1^2),
    - b2 = 2 (x2 w2 - x1 w1) / (w2^2 - w1^2).

    The b1 of equation (28) of Liu, Yan, Zhang, Zhou (2009) is valid for equal ratios only. A
    negative b2 would excite all high modes and is refused; a negative b1 acts only below
    `low_frequency` and is accepted.
    """

    low_ratio: Number = quantity(..., "1", "damping ratio at the low frequency", ge=0, lt=1)
    low_frequency: Number = quantity(..., "Hz", "frequency at which the ratio is low_ratio", gt=0)
    high_ratio: Number = quantity(..., "1", "damping ratio at the high frequency", ge=0, lt=1)
    high_frequency: Number = quantity(..., "Hz", "frequency at which the ratio is high_ratio", gt=0)

    @model_validator(mode="after")
    def _damps_high_modes(self) -> RayleighPair:
        if not self.low_frequency < self.high_frequency:
            raise SceneError(
                f"low_frequency = {self.low_frequency} Hz must be less than high_frequency ="
                f" {self.high_frequency} Hz"
            )
        lowest = self.low_ratio * self.low_frequency / self.high_frequency
        if self.high_ratio * self.high_frequency < self.low_ratio * self.low_frequency:
            raise SceneError(
                f"high_ratio = {self.high_ratio} would excite the modes above {self.high_frequency}"
                f" Hz (stiffness-proportional damping negative); it must be at least {lowest:.6g}"
            )
        return self


class Damping(Section):
    """Damping of translations and of twist, constant in time (default: none)."""

    translation: RayleighPair | None = setting(
        None, "damping of vertical, horizontal and longitudinal motion"
    )
    twist: RayleighPair | None = setting(None, "damping of twist")
