"""Inputs and outputs that the FMU of a span and the FMU of a line share, and what can be chosen."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gallop_fmu.engine.probes import span_probes
from gallop_fmu.fmu.enumerations import ENUMERATIONS, STATUS
from gallop_fmu.fmu.variable import Origin, Target, TargetKind, Term
from gallop_fmu.foundation.channels import SPAN_INDEX
from gallop_fmu.scene.wind import MAX_DIRECTION, Wind

AXES = ("x1", "x2", "x3")

INPUT: dict[str, Any] = {
    "origin": Origin.INPUT,
    "causality": "input",
    "variability": "continuous",
    "initial": "",
    "type": "Real",
}
"""Attributes of every input."""

OUTPUT: dict[str, Any] = {
    "causality": "output",
    "variability": "continuous",
    "initial": "calculated",
    "type": "Real",
}
"""Attributes of every Real output."""

WIND_SPEED = "wind speed across"

NOMINAL = {
    **{"u1": 0.01, "u2": 1.0, "u3": 1.0, "theta": 0.1},
    **{"v1": 0.1, "v2": 1.0, "v3": 1.0, "omega": 1.0},
    **{"angle_of_attack": 1.0, "wind_speed": 10.0, "attack_angle": 1.0, "wind_direction": 1.0},
    **{"tower": 0.01, "tower_velocity": 0.1, "lean": 0.1},
}
"""Orders of magnitude [m, rad, m/s, rad/s] of galloping spans; a force has that of the tension."""

MEANINGS = {
    "u1": "displacement along the span at {where}, from the initial equilibrium",
    "u2": "upward displacement at {where}, from the initial equilibrium",
    "u3": "downwind displacement at {where}, from the initial equilibrium",
    "theta": "twist at {where}, right-handed about the span",
    "v1": "velocity along the span at {where}",
    "v2": "upward velocity at {where}",
    "v3": "downwind velocity at {where}",
    "omega": "rate of twist at {where}",
    "tension": "tension at {where}",
    "angle_of_attack": "attack angle of the relative wind on the ice at {where}",
}
"""Meanings of the channels of a node, for a host's tooltips."""

MAX_TURN = math.radians(MAX_DIRECTION)
"""Maximum direction of the wind [rad], in either sense."""

MAX_STATIONS = 100
"""Most stations of a span."""


QUARTERS = (0.25, 0.75)
"""Usual stations: galloping in two loops has a node at mid-span."""


@dataclass(frozen=True, slots=True)
class Ports:
    """What is chosen when a scene is exported.

    Attributes
    ----------
    wind
        Of a line: "line" for one wind speed, "span" for one of each span.
    stations
        Places in each span, besides its middle, of which the FMU has outputs: fractions of the
        conductor's length.

    Raises
    ------
    ValueError
        A value is not allowed.
    """

    wind: Literal["line", "span"] = "line"
    stations: tuple[float, ...] = QUARTERS

    def __post_init__(self) -> None:
        if self.wind not in ("line", "span"):
            raise ValueError(f"wind = {self.wind!r}: must be 'line' or 'span'")
        if len(self.stations) > MAX_STATIONS:
            raise ValueError(
                f"stations: {len(self.stations)} given; at most {MAX_STATIONS} are allowed"
            )
        for number, station in enumerate(self.stations, start=1):
            if not 0.0 < station < 1.0:
                raise ValueError(
                    f"station {number} is {station:g}; it must be between 0 and 1, a fraction of"
                    " the span"
                )

    @property
    def identity(self) -> str:
        """Text that differs where the choice does; empty for the usual one."""
        return "" if self == Ports() else repr(self)


def motion_input(name: str, key: str, place: str, targets: tuple[Target, ...]) -> dict[str, Any]:
    """Return the attributes of the input of a tower's displacement along an axis."""
    return INPUT | {
        "name": name,
        "key": key,
        "unit": "m",
        "nominal": NOMINAL["tower"],
        "description": f"displacement of {place}, reached at the end of a step",
        "start": 0.0,
        "targets": targets,
    }


def velocity_input(motion: dict[str, Any], place: str) -> dict[str, Any]:
    """Return the attributes of the input of the velocity that belongs to a displacement."""
    targets = tuple(target._replace(kind=TargetKind.VELOCITY) for target in motion["targets"])
    name = re.sub(r"x(\d)$", r"v\1", motion["name"])
    return INPUT | {
        "name": name,
        "key": name,
        "unit": "m/s",
        "nominal": NOMINAL["tower_velocity"],
        "description": (
            f"velocity of {place}; {motion['name'][-2:]} then is at the start of a step"
        ),
        "start": 0.0,
        "targets": targets,
    }


def preload_output(force: dict[str, Any], place: str) -> dict[str, Any]:
    """Return the attributes of the static part of a force: in still air, without loads."""
    tower, _, axis = force["name"].rpartition(".")
    name = f"{tower}.preload.{axis}"
    return force | {
        "name": name,
        "key": name,
        "origin": Origin.STATIC,
        "variability": "discrete",
        "description": f"static part of the force on {place}, in still air",
    }


def wind_speed_at_start(wind: Wind) -> float:
    """Return the wind speed [m/s] at t = 0, without gusts."""
    return float(wind.speed_law.at(0.0))


def wind_direction_input(wind: Wind, fields: int) -> dict[str, Any]:
    """Return the attributes of the input that turns the wind of all fields.

    Only scenes whose wind has a direction, a profile or gusts have it.
    """
    law = wind.direction_law
    return INPUT | {
        "name": "wind_direction",
        "key": "wind_direction",
        "unit": "rad",
        "description": (
            "direction of the wind: yaw from across the line towards x1, constant in a step"
        ),
        "nominal": NOMINAL["wind_direction"],
        "start": 0.0 if law is None else math.radians(float(law.at(0.0))),
        "minimum": -MAX_TURN,
        "maximum": MAX_TURN,
        "targets": tuple(Target(TargetKind.WIND_DIRECTION, field) for field in range(fields)),
    }


def attack_angle_input(start: float, remark: str = "") -> dict[str, Any]:
    """Return the attributes of the input that turns the ice; `start` in rad."""
    return INPUT | {
        "name": "attack_angle",
        "key": "attack_angle",
        "unit": "rad",
        "nominal": NOMINAL["attack_angle"],
        "description": (f"attack angle of the wind on the ice{remark}; constant in a step"),
        "start": start,
        "minimum": -2.0 * math.pi,
        "maximum": 2.0 * math.pi,
        "targets": (Target(TargetKind.ATTACK_ANGLE),),
    }


def span_term(name: str) -> Term:
    """Return the term of a span channel, of a scene with two junctions."""
    [probe] = span_probes(np.array([SPAN_INDEX[name]], dtype=np.int32), 2)
    return Term(int(probe["object"]), int(probe["index"]), int(probe["channel"]))


def common_outputs() -> Iterator[dict[str, Any]]:
    """Yield the attributes of the outputs about the computation."""
    whole = OUTPUT | {"variability": "discrete", "type": "Integer", "unit": ""}
    yield whole | {
        "name": "status",
        "type": "Enumeration",
        "enumeration": STATUS,
        "origin": Origin.STATUS,
        "key": "status",
        "description": "outcome of the last computation; the log has its cause and a remedy",
        "minimum": min(item.value for item in ENUMERATIONS[STATUS]),
        "maximum": max(item.value for item in ENUMERATIONS[STATUS]),
    }
    for name, meaning in (
        ("newton_iterations", "Newton iterations of the last inner time step"),
        ("substeps", "sub-steps into which the last inner time step was divided"),
    ):
        yield whole | {
            "name": name,
            "origin": Origin.SUM,
            "terms": (span_term(name),),
            "key": name,
            "description": meaning,
        }
