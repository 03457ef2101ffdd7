"""Supports of the conductor.

The kernel computes stiffnesses from these numbers, by the formulas given here.  A support that is
not rigid is a device of the kernel: `DEVICE_KIND` is its number in `gallop_device_kind` (gallop.h),
and `DEVICE_PARAMETERS` has the index of each field among its parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from gallop_fmu.scene.fields import Number, Section, quantity, setting
from gallop_fmu.scene.time_functions import Law

ONE_SPAN_ONLY = (
    "total force of this span on its end; the adjacent span balances most of it, so it is not the"
    " load on the suspension tower"
)
"""Remark on the force on an end with an insulator and an adjacent span."""


class SupportMotion(Section):
    """Displacement of the attachment point on the tower, along each axis."""

    x1: Law | None = quantity(None, "m", "displacement along the span")
    x2: Law | None = quantity(None, "m", "displacement upwards")
    x3: Law | None = quantity(None, "m", "displacement across the span, downwind")


def displacement_of(motions: Sequence[SupportMotion | None], time: float) -> NDArray[np.float64]:
    """Displacement [m] of tower points (row) along x1, x2, x3 at a time [s]; None: at rest."""
    place = np.zeros((len(motions), 3))
    for tower, motion in enumerate(motions):
        for axis in range(3):
            law = getattr(motion, f"x{axis + 1}") if motion else None
            place[tower, axis] = float(law.at(time)) if law else 0.0
    return place


class RigidSupport(Section):
    """The end follows the tower point in all directions; twist is fixed."""

    kind: Literal["rigid"] = setting("rigid", "kind of support")
    motion: SupportMotion | None = setting(None, "motion of the tower point (default: fixed)")


class SpringSupport(Section):
    """Springs along and across the span, preloaded by the initial reaction; x2, twist fixed."""

    DEVICE_KIND: ClassVar[int] = 0
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {"stiffness_x1": 0, "stiffness_x3": 2}

    kind: Literal["springs"] = setting("springs", "kind of support")
    stiffness_x1: Number = quantity(..., "N/m", "stiffness along the span", gt=0)
    stiffness_x3: Number = quantity(..., "N/m", "stiffness across the span", gt=0)
    motion: SupportMotion | None = setting(None, "motion of the tower point (default: fixed)")


class AdjacentSpanSupport(Section):
    """A suspension insulator with an adjacent span; vertical displacement and twist are fixed.

    The stiffnesses follow equations (23) and (24) of Liu, Yan, Zhang, Zhou (2009),

    - 1/K_ST = Lx/(AE) + py^2 Lx^3 / (12 H^3), the adjacent span along x1,
    - K_l1 = (py L + W/2) / Ll, the insulator as a pendulum,
    - K_x1 = K_ST + K_l1 along the span and K_x3 = K_l1 + 2 H / Lx across it,

    with Lx `adjacent_span`, H `adjacent_tension`, Ll `insulator_length`, W `insulator_weight`, L
    the length of the analysed span, AE its axial stiffness and py its weight per unit length with
    ice.

    The reported force on this end is the total force of the analysed span. A suspension tower
    carries the insulator's force only: K_l1 times the displacement of the conductor's end along and
    across the span, and the vertical forces of both spans (twice this one for equal spans) plus the
    insulator's weight.
    """

    DEVICE_KIND: ClassVar[int] = 1
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {
        "adjacent_span": 0,
        "adjacent_tension": 1,
        "insulator_length": 2,
        "insulator_weight": 3,
    }

    kind: Literal["adjacent_span"] = setting("adjacent_span", "kind of support")
    adjacent_span: Number = quantity(..., "m", "length of the adjacent span", gt=0)
    adjacent_tension: Number = quantity(..., "N", "horizontal tension of the adjacent span", gt=0)
    insulator_length: Number = quantity(..., "m", "length of the insulator string", gt=0)
    insulator_weight: Number = quantity(..., "N", "weight of the insulator string", ge=0)
    motion: SupportMotion | None = setting(None, "motion of the tower point (default: fixed)")


Support = Annotated[RigidSupport | SpringSupport | AdjacentSpanSupport, Field(discriminator="kind")]
"""Any of the supports; in a scene file, ``kind`` selects it."""


class Supports(Section):
    """Both ends of the span."""

    left: Support = setting(RigidSupport(), "support at x1 = 0")
    right: Support = setting(RigidSupport(), "support at the far end, x1 = length")

    def displacement_at(self, time: float) -> NDArray[np.float64]:
        """Displacement [m] of both tower points (row) along x1, x2, x3 at a time [s]."""
        return displacement_of((self.left.motion, self.right.motion), time)

    def remark_on_force(self, end: str) -> str:
        """Remark on the force on the ``"left"`` or ``"right"`` end; may be empty."""
        return ONE_SPAN_ONLY if isinstance(getattr(self, end), AdjacentSpanSupport) else ""
