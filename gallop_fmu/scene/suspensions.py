"""Towers of a section: suspensions between spans, and the ends of the section.

What is not rigid is a device of the kernel: `DEVICE_KIND` is its number in `gallop_device_kind`
(gallop_scene.h), and `DEVICE_PARAMETERS` has the index of each field among its parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, quantity, setting
from gallop_fmu.scene.supports import RigidSupport, SpringSupport, SupportMotion

STRING_STIFFNESS = 1e7
"""Default axial stiffness over length [N/m]; a composite string has about half of it."""

STRING_DAMPING = 3e4
"""Default damping along a string [N s/m].

Chosen: about critical for the vibration of a clamp with its part of the conductor along the
string. A time step does not resolve this vibration, and undamped it would not decay: it would
alternate in the pull of the string from step to step. A conductor's motion stretches a string by
less than a millimetre, so the work of this damping is negligible.
"""


class String(Section):
    """A suspension string: a uniform straight bar with ball joints at tower and clamp.

    The twist of the clamp is fixed, unless `clamp_torsional_stiffness` is given; the clamp then
    rotates about x1 against this stiffness from the sideways lean of the string.
    """

    NUMBERED: ClassVar[str] = "suspension"
    DEVICE_KIND: ClassVar[int] = 2
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {
        "length": 0,
        "weight": 1,
        "stiffness": 2,
        "damping": 3,
        "clamp_torsional_stiffness": 4,
    }

    kind: Literal["string"] = setting("string", "kind of suspension")
    length: Number = quantity(..., "m", "length of the string, from tower to clamp", gt=0)
    weight: Number = quantity(..., "N", "weight of the string", ge=0)
    stiffness: Number = quantity(STRING_STIFFNESS, "N/m", "stiffness along the string", gt=0)
    damping: Number = quantity(STRING_DAMPING, "N s/m", "damping along the string", ge=0)
    clamp_torsional_stiffness: Number | None = quantity(
        None,
        "N m/rad",
        "stiffness of the clamp's rotation against the lean of the string (default: twist fixed)",
        gt=0,
    )
    motion: SupportMotion | None = setting(None, "motion of the tower point (default: fixed)")


class VString(Section):
    """Two bars from tower points on either side of the conductor to one clamp; twist is fixed."""

    NUMBERED: ClassVar[str] = "suspension"
    DEVICE_KIND: ClassVar[int] = 3
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {
        "length": 0,
        "weight": 1,
        "stiffness": 2,
        "damping": 3,
        "half_spread": 4,
    }

    kind: Literal["v_string"] = setting("v_string", "kind of suspension")
    length: Number = quantity(..., "m", "length of each bar", gt=0)
    weight: Number = quantity(..., "N", "weight of each bar", ge=0)
    half_spread: Number = quantity(
        ..., "m", "horizontal distance of each tower point from the clamp, along x3", gt=0
    )
    stiffness: Number = quantity(STRING_STIFFNESS, "N/m", "stiffness along each bar", gt=0)
    damping: Number = quantity(STRING_DAMPING, "N s/m", "damping along each bar", ge=0)
    motion: SupportMotion | None = setting(None, "motion of both tower points (default: fixed)")

    @model_validator(mode="after")
    def _reaches_down(self) -> VString:
        if self.half_spread >= self.length:
            raise SceneError(
                f"half_spread = {self.half_spread:g} m must be less than length = {self.length:g}"
                " m, so that the bars reach down to the clamp"
            )
        return self


class Post(Section):
    """A post insulator: the clamp follows the tower point in all directions; twist is fixed."""

    NUMBERED: ClassVar[str] = "suspension"

    kind: Literal["post"] = setting("post", "kind of suspension")
    motion: SupportMotion | None = setting(None, "motion of the tower point (default: fixed)")


Suspension = Annotated[String | VString | Post, Field(discriminator="kind")]
"""Any of the suspensions; in a scene file, ``kind`` selects it."""


class EndString(Section):
    """A dead-end string in line with the conductor, one for each subconductor; twist is fixed.

    The end of the span is the tower point. In the strung state the string, with its weight, is in
    equilibrium with the strung conductor.
    """

    DEVICE_KIND: ClassVar[int] = 2
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {
        "length": 0,
        "weight": 1,
        "stiffness": 2,
        "damping": 3,
    }

    kind: Literal["string"] = setting("string", "kind of end")
    length: Number = quantity(..., "m", "length of the string, from tower to clamp", gt=0)
    weight: Number = quantity(..., "N", "weight of the string", ge=0)
    stiffness: Number = quantity(STRING_STIFFNESS, "N/m", "stiffness along the string", gt=0)
    damping: Number = quantity(STRING_DAMPING, "N s/m", "damping along the string", ge=0)
    motion: SupportMotion | None = setting(None, "motion of the tower point (default: fixed)")


SectionEnd = Annotated[RigidSupport | SpringSupport | EndString, Field(discriminator="kind")]
"""Any of the ends of a section; in a scene file, ``kind`` selects it."""
