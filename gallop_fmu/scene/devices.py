"""Devices on the conductors of a line.

`DEVICE_KIND` is the number of the kind in `gallop_device_kind` (gallop_scene.h); an interval is
part of a conductor and not a device of the kernel. Devices with a phase or subconductor of None
are on each of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.conductor import OwnIce
from gallop_fmu.scene.fields import Number, Section, Text, WholeNumber, quantity, setting


class OnSpan(Section):
    """What all devices share: kind and span."""

    NUMBERED: ClassVar[str] = "device"

    kind: Text = setting("", "kind of device")
    span: WholeNumber = quantity(..., "1", "number of the span, from 1", ge=1)


class OnConductor(OnSpan):
    """What devices on one phase share: phase and subconductor."""

    phase: WholeNumber | None = quantity(
        None, "1", "number of the phase, from 1 (default: on each phase)", ge=1
    )
    subconductor: WholeNumber | None = quantity(
        None, "1", "number of the subconductor, from 1 (default: on each)", ge=1
    )


class AtStation(OnConductor):
    """What devices at one point share: the station."""

    station: Number = quantity(
        ..., "1", "place as a fraction of the conductor's length in the span", gt=0, lt=1
    )


class Pendulum(AtStation):
    """A detuning pendulum, clamped to the conductor; it may rotate fully."""

    DEVICE_KIND: ClassVar[int] = 7

    kind: Literal["pendulum"] = setting("pendulum", "kind of device")
    mass: Number = quantity(..., "kg", "mass of the bob", gt=0)
    arm: Number = quantity(..., "m", "distance of the bob from the conductor's centre", gt=0)
    angle_deg: Number = quantity(
        0.0,
        "deg",
        "angle of the arm from straight down, positive towards +x3",
        ge=-180,
        le=180,
    )


class PointMass(AtStation):
    """A mass at the conductor's centre, such as a marker ball."""

    DEVICE_KIND: ClassVar[int] = 6
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {"mass": 0}

    kind: Literal["mass"] = setting("mass", "kind of device")
    mass: Number = quantity(..., "kg", "mass", gt=0)


class Damper(AtStation):
    """A viscous damper along one axis, to the ground or to a mass that hangs on a spring.

    With `hanging_mass` and `hanging_stiffness`, the damper acts between the conductor and this
    mass; otherwise between the conductor and a fixed point.
    """

    DEVICE_KIND: ClassVar[int] = 8

    kind: Literal["damper"] = setting("damper", "kind of device")
    damping: Number = quantity(..., "N s/m", "damping along the axis", ge=0)
    axis: Literal["x1", "x2", "x3"] = setting("x2", "axis of the damper")
    hanging_mass: Number | None = quantity(None, "kg", "mass that hangs on the damper", gt=0)
    hanging_stiffness: Number | None = quantity(
        None, "N/m", "stiffness of the spring of the hanging mass", gt=0
    )

    @model_validator(mode="after")
    def _mass_with_spring(self) -> Damper:
        if (self.hanging_mass is None) != (self.hanging_stiffness is None):
            raise SceneError(
                "only one of hanging_mass [kg] and hanging_stiffness [N/m] given; give both, or"
                " neither for a damper to the ground"
            )
        return self


class InterphaseSpacer(OnSpan):
    """A bar with ball joints between two phases; its length is that of the strung state."""

    DEVICE_KIND: ClassVar[int] = 9
    DEVICE_PARAMETERS: ClassVar[Mapping[str, int]] = {"stiffness": 0, "mass": 1, "damping": 2}

    kind: Literal["interphase_spacer"] = setting("interphase_spacer", "kind of device")
    station: Number = quantity(
        ..., "1", "place as a fraction of the conductors' length in the span", gt=0, lt=1
    )
    phases: Annotated[tuple[WholeNumber, WholeNumber], Field(strict=False)] = quantity(
        ..., "1", "numbers of the two phases, from 1"
    )
    subconductor: WholeNumber = quantity(
        1, "1", "number of the subconductor of each phase that the bar is clamped to", ge=1
    )
    stiffness: Number = quantity(5e6, "N/m", "stiffness along the bar", gt=0)
    mass: Number = quantity(0.0, "kg", "mass, half of it at each end", ge=0)
    damping: Number = quantity(0.0, "N s/m", "damping along the bar", ge=0)

    @model_validator(mode="after")
    def _between_two_phases(self) -> InterphaseSpacer:
        if self.phases[0] == self.phases[1]:
            raise SceneError(
                f"phases = [{self.phases[0]}, {self.phases[1]}]: an interphase spacer connects two"
                " different phases; spacers within a phase are given in [bundle]"
            )
        return self


class Interval(OnConductor):
    """A stretch with its own ice or coefficient curve: a spoiler, or a bare part of the conductor.

    ``ice = "none"`` in a scene file is a bare stretch.
    """

    kind: Literal["interval"] = setting("interval", "kind of device")
    from_station: Number = quantity(
        ..., "1", "start as a fraction of the conductor's length in the span", ge=0, lt=1
    )
    to_station: Number = quantity(
        ..., "1", "end as a fraction of the conductor's length in the span", gt=0, le=1
    )
    ice: OwnIce = setting(None, "ice on the stretch (default: as on the span)")
    aerodynamics: Aerodynamics | None = setting(
        None, "coefficient curve of the stretch (default: that of the scene)"
    )

    @model_validator(mode="after")
    def _changes_a_stretch(self) -> Interval:
        if not self.from_station < self.to_station:
            raise SceneError(
                f"from_station = {self.from_station:g} must be less than to_station ="
                f" {self.to_station:g}; exchange them"
            )
        if self.ice is None and self.aerodynamics is None:
            raise SceneError(
                'an interval without ice and aerodynamics changes nothing; give ice (or "none" for'
                " a bare stretch), or the coefficient curve of the stretch, or remove it"
            )
        return self


Device = Annotated[
    Pendulum | PointMass | Damper | InterphaseSpacer | Interval, Field(discriminator="kind")
]
"""Any of the devices; in a scene file, ``kind`` selects it."""
