"""Inputs and outputs of the FMU of one span.

The host's inputs replace the scene's wind, attack angle and support motion:

- ``wind_speed`` replaces ``wind.speed`` and ``wind.history``, ``wind_direction`` of a scene whose
  wind has a direction, a profile or gusts ``wind.direction_deg`` and ``wind.direction_history``,
- ``attack_angle`` replaces ``ice.attack_angle_deg``,
- ``support.left.x1`` to ``support.right.x3`` replace ``supports.left.motion`` and
  ``supports.right.motion``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from gallop_fmu.fmu.ports import (
    AXES,
    INPUT,
    MEANINGS,
    NOMINAL,
    OUTPUT,
    WIND_SPEED,
    Ports,
    attack_angle_input,
    common_outputs,
    motion_input,
    preload_output,
    span_term,
    velocity_input,
    wind_speed_at_start,
)
from gallop_fmu.fmu.variable import POINT, Origin, Target, TargetKind, Term
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_CHANNELS, SPAN_INDEX
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.wind import MAX_WIND_SPEED

ENDS = ("left", "right")
DIRECTIONS = ("along the span", "upwards", "across, downwind")
MOTIONS = {
    **{f"x{i}": f"u{i}" for i in (1, 2, 3)},
    "theta": "theta",
    **{f"v{i}": f"v{i}" for i in (1, 2, 3)},
    "omega": "omega",
}
"""Motions of a place by their names in the FMU."""


def typical_tension(scene: Scene) -> float:
    """Return the horizontal tension [N], from the scene or as m g L^2 / (8 sag)."""
    span = scene.span
    if span.horizontal_tension is not None:
        return span.horizontal_tension
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    return mass * span.gravity * span.length**2 / (8.0 * (span.sag or span.length))


def span_inputs(scene: Scene) -> Iterator[dict[str, Any]]:
    """Yield the attributes of each input."""
    yield INPUT | {
        "name": "wind_speed",
        "key": "wind_speed",
        "unit": "m/s",
        "nominal": NOMINAL["wind_speed"],
        "description": f"{WIND_SPEED} the span, constant in a step",
        "start": wind_speed_at_start(scene.wind),
        "minimum": -MAX_WIND_SPEED if scene.aerodynamics is not None else 0.0,
        "maximum": MAX_WIND_SPEED if scene.aerodynamics is not None else 0.0,
        "targets": (Target(TargetKind.WIND),),
    }
    yield attack_angle_input(math.radians(scene.ice.attack_angle_deg))
    for motion, _ in _motions():
        yield motion


def _motions() -> Iterator[tuple[dict[str, Any], str]]:
    """Yield the inputs of the displacements of the ends, each with its place in words."""
    for junction, end in enumerate(ENDS):
        for axis, direction in enumerate(DIRECTIONS):
            name, place = f"support.{end}.{AXES[axis]}", f"the {end} tower point {direction}"
            targets = (Target(TargetKind.MOTION, junction, axis),)
            yield motion_input(name, name, place, targets), place


def span_outputs(scene: Scene, ports: Ports) -> Iterator[dict[str, Any]]:
    """Yield the attributes of each output; then velocities of the ends, preloads and stations.

    These were added later; references are not changed.
    """
    tension = typical_tension(scene)
    at_midspan = {f"midspan.{name}": key for name, key in MOTIONS.items()}
    at_midspan |= {"midspan.tension": "tension", "angle_of_attack": "angle_of_attack"}
    for name, key in at_midspan.items():
        yield _at(0.5, name, key, "mid-span", tension)
    forces = list(_forces(scene, tension))
    yield from forces
    yield from common_outputs()
    for motion, place in _motions():
        yield velocity_input(motion, place)
    for force in forces:
        end = force["name"].split(".")[1]
        yield preload_output(force, f"the {end} end {DIRECTIONS[int(force['name'][-1]) - 1]}")
    for number, station in enumerate(ports.stations, start=1):
        for name, key in MOTIONS.items():
            where = f"{station:g} of the span"
            yield _at(station, f"station[{number}].{name}", key, where, tension)


def _forces(scene: Scene, tension: float) -> Iterator[dict[str, Any]]:
    """Yield the attributes of the force on each end."""
    for end in ENDS:
        for axis in (1, 2, 3):
            channel = SPAN_CHANNELS[SPAN_INDEX[f"{end}_f{axis}"]]
            remark = scene.supports.remark_on_force(end)
            yield OUTPUT | {
                "name": f"support.{end}.f{axis}",
                "origin": Origin.SUM,
                "terms": (span_term(channel.name),),
                "key": channel.name,
                "unit": channel.unit,
                "description": f"{channel.meaning}; {remark}" if remark else channel.meaning,
                "nominal": tension,
            }


def _at(station: float, name: str, key: str, where: str, tension: float) -> dict[str, Any]:
    channel = NODE_CHANNELS[NODE_INDEX[key]]
    return OUTPUT | {
        "name": name,
        "origin": Origin.SUM,
        "terms": (Term(POINT, channel=NODE_INDEX[key], station=station),),
        "key": key,
        "unit": channel.unit,
        "description": MEANINGS[key].format(where=where),
        "nominal": tension if channel.unit == "N" else NOMINAL[key],
    }
