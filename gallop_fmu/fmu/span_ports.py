"""Inputs and outputs of the FMU of one span.

The host's inputs replace the scene's wind, attack angle and support motion:

- ``wind_speed`` replaces ``wind.speed`` and ``wind.history``,
- ``attack_angle`` replaces ``ice.attack_angle_deg``,
- ``support.left.x1`` to ``support.right.x3`` replace ``supports.left.motion`` and
  ``supports.right.motion``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from gallop_fmu.engine.probes import span_probes
from gallop_fmu.fmu.variable import POINT, Origin, Target, TargetKind, Term
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_CHANNELS, SPAN_INDEX
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.wind import MAX_WIND_SPEED

AXES = ("x1", "x2", "x3")
ENDS = ("left", "right")
DIRECTIONS = ("along the span", "upwards", "across the span, downwind")


def wind_speed_at_start(scene: Scene) -> float:
    """Return the wind speed [m/s] of the scene at t = 0."""
    return (
        float(scene.wind.history.at(0.0))
        if scene.wind.history is not None
        else scene.wind.speed or 0.0
    )


def typical_tension(scene: Scene) -> float:
    """Return the horizontal tension [N], from the scene or as m g L^2 / (8 sag)."""
    span = scene.span
    if span.horizontal_tension is not None:
        return span.horizontal_tension
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    return mass * span.gravity * span.length**2 / (8.0 * (span.sag or span.length))


def span_inputs(scene: Scene) -> Iterator[dict[str, Any]]:
    """Yield the attributes of each input."""
    common = {
        "origin": Origin.INPUT,
        "causality": "input",
        "variability": "continuous",
        "initial": "",
        "type": "Real",
    }
    yield common | {
        "name": "wind_speed",
        "key": "wind_speed",
        "unit": "m/s",
        "description": "wind speed across the span, held over a communication step",
        "start": wind_speed_at_start(scene),
        "minimum": 0.0,
        "maximum": MAX_WIND_SPEED if scene.aerodynamics is not None else 0.0,
        "targets": (Target(TargetKind.WIND),),
    }
    yield common | {
        "name": "attack_angle",
        "key": "attack_angle",
        "unit": "rad",
        "description": (
            "initial attack angle of the wind on the ice; turns the ice, held over a communication"
            " step"
        ),
        "start": math.radians(scene.ice.attack_angle_deg),
        "minimum": -2.0 * math.pi,
        "maximum": 2.0 * math.pi,
        "targets": (Target(TargetKind.ATTACK_ANGLE),),
    }
    for junction, end in enumerate(ENDS):
        for index, (axis, direction) in enumerate(zip(AXES, DIRECTIONS, strict=True)):
            yield common | {
                "name": f"support.{end}.{axis}",
                "key": f"support.{end}.{axis}",
                "unit": "m",
                "description": (
                    f"displacement of the {end} tower point {direction}, reached at the end of a "
                    "communication step"
                ),
                "start": 0.0,
                "targets": (Target(TargetKind.MOTION, junction, index),),
            }


def span_outputs(scene: Scene) -> Iterator[dict[str, Any]]:
    """Yield the attributes of each output."""
    common = {
        "causality": "output",
        "variability": "continuous",
        "initial": "calculated",
        "type": "Real",
    }
    whole = common | {"variability": "discrete", "type": "Integer", "unit": ""}
    tension = typical_tension(scene)
    at_midspan = {f"midspan.x{i}": f"u{i}" for i in (1, 2, 3)} | {"midspan.theta": "theta"}
    at_midspan |= {f"midspan.v{i}": f"v{i}" for i in (1, 2, 3)} | {"midspan.omega": "omega"}
    at_midspan |= {"midspan.tension": "tension", "angle_of_attack": "angle_of_attack"}
    for name, key in at_midspan.items():
        channel = NODE_CHANNELS[NODE_INDEX[key]]
        yield common | {
            "name": name,
            "origin": Origin.SUM,
            "terms": (Term(POINT, channel=NODE_INDEX[key], station=0.5),),
            "key": key,
            "unit": channel.unit,
            "description": f"{channel.meaning}; at mid-span",
            "nominal": tension if channel.unit == "N" else None,
        }
    for end in ENDS:
        for axis in (1, 2, 3):
            channel = SPAN_CHANNELS[SPAN_INDEX[f"{end}_f{axis}"]]
            remark = scene.supports.remark_on_force(end)
            yield common | {
                "name": f"support.{end}.f{axis}",
                "origin": Origin.SUM,
                "terms": (_span_term(channel.name),),
                "key": channel.name,
                "unit": channel.unit,
                "description": f"{channel.meaning}; {remark}" if remark else channel.meaning,
                "nominal": tension,
            }
    yield whole | {
        "name": "status",
        "origin": Origin.STATUS,
        "key": "status",
        "description": "0: OK; other values: number of the failure, see the log",
    }
    for name in ("newton_iterations", "substeps"):
        meaning = SPAN_CHANNELS[SPAN_INDEX[name]].meaning
        yield whole | {
            "name": name,
            "origin": Origin.SUM,
            "terms": (_span_term(name),),
            "key": name,
            "description": meaning,
        }


def _span_term(name: str) -> Term:
    """A span channel, of a scene with two junctions."""
    [probe] = span_probes(np.array([SPAN_INDEX[name]], dtype=np.int32), 2)
    return Term(int(probe["object"]), int(probe["index"]), int(probe["channel"]))
