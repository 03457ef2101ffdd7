"""The table of the FMU's variables, for model description, run-time, documentation and tests.

The host's inputs replace the scene's wind, attack angle and support motion:

- ``wind_speed`` replaces ``wind.speed`` and ``wind.history``,
- ``attack_angle`` replaces ``ice.attack_angle_deg``,
- ``support.left.x1`` to ``support.right.x3`` replace ``supports.left.motion`` and
  ``supports.right.motion``.

Every other number of the scene is a fixed parameter under its dotted path, except those of ``run``,
which the host decides. In names, the index of a load is in brackets, as FMI demands:
``loads[0].torque``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any, Literal, get_args

from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_CHANNELS, SPAN_INDEX
from gallop_fmu.scene.fields import WholeNumber
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.wind import MAX_WIND_SPEED

AXES = ("x1", "x2", "x3")
ENDS = ("left", "right")
SUPPORT_INPUTS = tuple(f"support.{end}.{axis}" for end in ENDS for axis in AXES)
"""Names of the six displacements of the tower points, left before right."""

REPLACED_BY_INPUTS = re.compile(
    r"wind\.(speed|history)\b|ice\.attack_angle_deg$|supports\.\w+\.motion\.|run\."
)
"""Paths of a scene that are not parameters, because the host sets them or does not use them."""

DIRECTIONS = ("along the span", "upwards", "across the span, downwind")


class Origin(Enum):
    """Source of the value of a variable."""

    INPUT = "input"
    PARAMETER = "parameter"
    MIDSPAN = "mid-span channel"
    SPAN = "span channel"
    STATUS = "outcome of the last call"


@dataclass(frozen=True, slots=True)
class Variable:
    """One variable of the FMU.

    Attributes
    ----------
    name, reference
        Name and value reference; a reference is not used twice, whatever the type.
    origin, key
        Source of the value: the name of an input, the dotted path of a parameter, the name
        of a channel.
    causality, variability, initial, type
        As in FMI 2.0; `initial` is empty where the standard forbids it.
    unit
        Unit of a Real, one of `gallop_fmu.fmu.units.BASE_UNITS`; "1" for pure numbers, empty for an
        Integer.
    description
        One phrase.
    start
        Start value; None for calculated variables.
    minimum, maximum
        Bounds of the host's values; FMI's are inclusive.
    minimum_excluded, maximum_excluded
        True if the bound itself is refused.
    nominal
        Order of magnitude, if it is far from one.
    """

    name: str
    reference: int
    origin: Origin
    key: str
    causality: Literal["input", "output", "parameter"]
    variability: Literal["continuous", "discrete", "fixed"]
    initial: Literal["", "calculated", "exact"]
    type: Literal["Real", "Integer"]
    unit: str
    description: str
    start: float | int | None = None
    minimum: float | int | None = None
    maximum: float | int | None = None
    minimum_excluded: bool = False
    maximum_excluded: bool = False
    nominal: float | None = None

    def allows(self, value: float) -> bool:
        """Return True if the bounds include a value."""
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        above = value > low if self.minimum_excluded else value >= low
        return above and (value < high if self.maximum_excluded else value <= high)

    @property
    def allowed(self) -> str:
        """Return the bounds in words, as `bounds_of` in kernel/cosim_values.c; may be empty."""
        low = "greater than" if self.minimum_excluded else "at least"
        high = "less than" if self.maximum_excluded else "at most"
        bounds = ((low, self.minimum), (high, self.maximum))
        return " and ".join(f"{word} {bound:.6g}" for word, bound in bounds if bound is not None)


def fmu_variables(scene: Scene) -> tuple[Variable, ...]:
    """Return all variables of a scene's FMU.

    Inputs and outputs come first and have the same references in every FMU.
    """
    variables: list[Variable] = []
    for settings in (*_inputs(scene), *_outputs(scene), *_parameters(scene)):
        variables.append(Variable(reference=len(variables), **settings))
    return tuple(variables)


def variable_table(scene: Scene) -> list[dict[str, str]]:
    """Return rows for documentation, as text: name, causality, type, unit, start, description."""
    return [
        {
            "name": variable.name,
            "causality": variable.causality,
            "type": variable.type,
            "unit": variable.unit,
            "start": "" if variable.start is None else f"{variable.start:.6g}",
            "description": variable.description,
        }
        for variable in fmu_variables(scene)
    ]


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


def _inputs(scene: Scene) -> Iterator[dict[str, Any]]:
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
    }
    for end in ENDS:
        for axis, direction in zip(AXES, DIRECTIONS, strict=True):
            yield common | {
                "name": f"support.{end}.{axis}",
                "key": f"support.{end}.{axis}",
                "unit": "m",
                "description": (
                    f"displacement of the {end} tower point {direction}, reached at the end of a "
                    "communication step"
                ),
                "start": 0.0,
            }


def _outputs(scene: Scene) -> Iterator[dict[str, Any]]:
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
            "origin": Origin.MIDSPAN,
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
                "origin": Origin.SPAN,
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
        yield whole | {"name": name, "origin": Origin.SPAN, "key": name, "description": meaning}


def _parameters(scene: Scene) -> Iterator[dict[str, Any]]:
    for path, (value, unit, meaning) in scene.numbers().items():
        if REPLACED_BY_INPUTS.match(path):
            continue
        whole, bounds = _declared(scene, path)
        yield {
            "name": re.sub(r"\.(\d+)", r"[\1]", path),
            "origin": Origin.PARAMETER,
            "key": path,
            "causality": "parameter",
            "variability": "fixed",
            "initial": "exact",
            "type": "Integer" if whole else "Real",
            "unit": "" if whole else unit,
            "description": meaning + _exclusive(bounds),
            "start": value,
            "minimum": bounds.get("ge", bounds.get("gt")),
            "maximum": bounds.get("le", bounds.get("lt")),
            "minimum_excluded": "gt" in bounds,
            "maximum_excluded": "lt" in bounds,
        }


def _exclusive(bounds: dict[str, float]) -> str:
    """Remark on bounds that are refused themselves; FMI's own bounds are inclusive."""
    words = {"gt": "greater than", "lt": "less than"}
    remarks = " and ".join(
        f"{word} {bounds[kind]:.6g}" for kind, word in words.items() if kind in bounds
    )
    return f"; must be {remarks}" if remarks else ""


def _declared(scene: Scene, path: str) -> tuple[bool, dict[str, float]]:
    """Return True if the field at a path is a whole number; and its bounds by kind (gt, ...)."""
    *parents, name = path.split(".")
    section: Any = scene
    for parent in parents:
        section = section[int(parent)] if parent.isdecimal() else getattr(section, parent)
    field = type(section).model_fields[name]
    kinds = ("gt", "ge", "lt", "le")
    bounds = {
        kind: getattr(rule, kind)
        for rule in field.metadata
        for kind in kinds
        if hasattr(rule, kind)
    }
    whole = any(
        kind in (int, WholeNumber) for kind in (field.annotation, *get_args(field.annotation))
    )
    return whole, bounds
