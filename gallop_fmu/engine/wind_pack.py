"""The wind of a scene, packed into the kernel's fields: one for each span."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gallop_fmu.engine.ctypes_structs import CField
from gallop_fmu.engine.tables import NONE, Tables
from gallop_fmu.scene.time_functions import Law
from gallop_fmu.scene.wind_consistency import gusts_of, towers_of
from gallop_fmu.scene.wind_profile import PowerProfile, Profile

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene

VARIED = 1
"""gallop_field_kind of wind with a direction, a profile or gusts."""

POWER, LOGARITHMIC = 1, 2
"""gallop_profile."""

VALUES = ("value", "initial", "final", "peak", "mean", "amplitude")
"""Fields of laws that have the unit of the quantity."""


def pack_wind(tables: Tables, scene: Scene | LineScene, speeds: Sequence[int]) -> None:
    """Add a field for each wind speed; they share direction, profile and gusts.

    Parameters
    ----------
    tables
        Tables with the laws of the speeds.
    scene
        The scene.
    speeds
        Indices of the laws.
    """
    wind, given = scene.wind, {}
    if wind.direction_law is not None:
        law = in_radians(wind.direction_law)
        given["direction"] = tables.add_law(law, "wind.direction_history")
    if wind.profile is not None:
        given |= _profile(tables, scene, wind.profile)
    gusts = gusts_of(wind, scene.length, scene.run.stop_time)
    if gusts is not None:
        times, stations, components = gusts.values.shape
        first = tables.add_numbers(gusts.stations)
        tables.add_numbers(gusts.times)
        tables.add_numbers(gusts.values)
        given |= {
            "stations": stations,
            "times": times,
            "components": components,
            "first_gust": first,
            "repeat": gusts.repeat,
        }
    if given:
        given = {"kind": VARIED, "direction": NONE, **given}
    for speed in speeds:
        field = tables.add("field", CField(law=speed, **given))
        if wind.profile is not None:
            _note_profile(tables, field, wind.profile)


def in_radians(law: Law) -> Law:
    """Return a law in rad from one in deg."""
    factor = math.pi / 180.0
    scaled: dict[str, Any] = {}
    for name in VALUES:
        if name not in type(law).model_fields:
            continue
        value: Any = getattr(law, name)
        scaled[name] = (
            tuple((np.asarray(value) * factor).tolist())
            if isinstance(value, tuple)
            else value * factor
        )
    return law.model_copy(update=scaled)


def _profile(tables: Tables, scene: Scene | LineScene, profile: Profile) -> dict[str, Any]:
    """Return the fields of a profile, whose ground is added to the numbers."""
    x1, x2 = profile.ground([place for place, _ in towers_of(scene)])
    first = tables.add_numbers(x1)
    tables.add_numbers(x2)
    kind, parameter = (
        (POWER, profile.exponent)
        if isinstance(profile, PowerProfile)
        else (LOGARITHMIC, profile.roughness_length)
    )
    return {
        "profile": kind,
        "profile_parameter": parameter,
        "reference_height": profile.reference_height,
        "ground_points": len(x1),
        "first_ground": first,
    }


def _note_profile(tables: Tables, field: int, profile: Profile) -> None:
    """Note the places of the numbers of a profile."""
    parameter = "exponent" if isinstance(profile, PowerProfile) else "roughness_length"
    places = {
        parameter: CField.profile_parameter.offset,
        "reference_height": CField.reference_height.offset,
    }
    for name, offset in places.items():
        tables.note(f"wind.profile.{name}", "field", field, offset)
