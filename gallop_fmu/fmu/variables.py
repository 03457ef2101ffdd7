"""The table of the FMU's variables, for model description, run-time, documentation and tests.

`gallop_fmu.fmu.span_ports` and `gallop_fmu.fmu.line_ports` have the inputs and outputs. Every
number of the scene that the host's inputs do not replace is a fixed parameter under its dotted
path, except those of ``run``, which the host decides, the ice thickness of the assumed coefficient
curve, and numbers of a line on which its mesh or the place of a junction depends, such as
``section.spans[0].length``. In names, indices of the scene's lists are in brackets, as FMI demands,
and count from 0: ``loads[0].torque``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, get_args

from gallop_fmu.engine.ctypes_structs import CCrossSection
from gallop_fmu.engine.pack import Packed
from gallop_fmu.fmu.enumerations import ENUMERATIONS, INTEGRATOR
from gallop_fmu.fmu.line_ports import line_inputs, line_outputs
from gallop_fmu.fmu.ports import Ports, wind_direction_input
from gallop_fmu.fmu.span_ports import span_inputs, span_outputs
from gallop_fmu.fmu.variable import Origin, Variable
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.scene.devices import Damper
from gallop_fmu.scene.fields import WholeNumber
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.stations import shed_stations
from gallop_fmu.scene.suspensions import EndString

REPLACED_BY_INPUTS = re.compile(
    r"wind\.(?!air_density$|profile\.(exponent|roughness_length|reference_height)$)"
    r"|ice\.attack_angle_deg$|supports\.\w+\.motion\.|run\."
    r"|(.*\.)?aerodynamics\.ice_thickness_ratio$"
)
"""Paths of a span that are not parameters, because the host sets them or does not use them.

The numbers of the assumed coefficient curve are computed from the ice thickness at export.
"""

REPLACED_IN_A_LINE = re.compile(
    r"(.*\.)?wind\.(?!air_density$|profile\.(exponent|roughness_length|reference_height)$)"
    r"|section\..*\.motion\.|run\."
)
"""The same of a line, but for the attack angle of the ice on the first span."""

SHED_STATION = re.compile(r"shedding\.\d+\.(from|to)_station")
"""Paths of a span that place its stations."""

HELD = {
    "span.sag": "; must fit the tension",
    "span.horizontal_tension": "; must fit the sag within 5 %",
}
"""Remarks on the parameters of a span whose sag and tension are both given."""

WEIGHT = re.compile(r"conductor\.mass_per_length|section\.(gravity|horizontal_tension)")
ICE_WEIGHT = re.compile(r"(.*\.)?ice\.mass_per_length")
"""Paths on which the strung shape depends; the second if the line is strung with ice."""


def fmu_variables(
    scene: Scene | LineScene, ports: Ports | None = None, packed: Packed | None = None
) -> tuple[Variable, ...]:
    """Return all variables of a scene's FMU.

    Inputs and outputs come first; of a single span they have the same references in every FMU,
    but for stations and the direction of the wind, which follow.

    Parameters
    ----------
    scene
        The scene.
    ports
        What is chosen; None: the usual.
    packed
        The scene's tables, if the caller has them.
    """
    ports = ports or Ports()
    found: list[dict[str, Any]]
    if isinstance(scene, LineScene):
        packed = packed or Packed(scene)
        found = [*line_inputs(scene, ports, packed), *line_outputs(scene, ports, packed)]
        paths = _paths_of_line(scene, packed)
    else:
        found = [*span_inputs(scene), *span_outputs(scene, ports)]
        paths = {path for path in scene.numbers() if not REPLACED_BY_INPUTS.match(path)}
        if scene.shedding:
            paths -= _paths_of_the_mesh(scene)
    if scene.wind.is_varied:
        fields = len(scene.section.spans) if isinstance(scene, LineScene) else 1
        found.append(wind_direction_input(scene.wind, fields))
    found += _parameters(scene, paths)
    if scene.numerics.tolerance is None:
        found.append(_integrator(scene))
    return tuple(Variable(reference=number, **one) for number, one in enumerate(found))


def _paths_of_the_mesh(scene: Scene) -> set[str]:
    """Paths of the numbers on which the mesh of a span depends that loses ice from parts."""
    stations = {path for path in scene.numbers() if SHED_STATION.fullmatch(path)}
    return stations | ({"numerics.elements"} if shed_stations(scene) else set())


def _paths_of_line(scene: LineScene, packed: Packed) -> set[str]:
    """Paths of the numbers on which neither the mesh nor the place of a junction depends."""
    ends = (scene.section.left_end, scene.section.right_end)
    has_shape = any(isinstance(end, EndString) for end in ends) or any(
        isinstance(device, Damper) and device.hanging_mass is not None for device in scene.devices
    )
    replaced = (
        "cross_section",
        0,
        CCrossSection.attack_angle.offset,
    )
    paths = set()
    for path in scene.numbers():
        places = packed.places.get(path, [])
        fixed = has_shape and (
            WEIGHT.fullmatch(path) or (scene.section.strung_with_ice and ICE_WEIGHT.fullmatch(path))
        )
        if not places or fixed or REPLACED_IN_A_LINE.match(path):
            continue
        if not any(place[:3] == replaced for place in places):
            paths.add(path)
    return paths


def variable_table(scene: Scene | LineScene, ports: Ports | None = None) -> list[dict[str, str]]:
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
        for variable in fmu_variables(scene, ports)
    ]


def _parameters(scene: Scene | LineScene, paths: set[str]) -> Iterator[dict[str, Any]]:
    held = HELD if isinstance(scene, Scene) and scene.span.initial_state == "held" else {}
    for path, (value, unit, meaning) in scene.numbers().items():
        if path not in paths:
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
            "description": meaning + _exclusive(bounds) + held.get(path, ""),
            "start": value,
            "minimum": bounds.get("ge", bounds.get("gt")),
            "maximum": bounds.get("le", bounds.get("lt")),
            "minimum_excluded": "gt" in bounds,
            "maximum_excluded": "lt" in bounds,
        }


def _integrator(scene: Scene | LineScene) -> dict[str, Any]:
    """Return the attributes of the parameter that chooses the time integrator."""
    codes = [item.value for item in ENUMERATIONS[INTEGRATOR]]
    return {
        "name": "numerics.integrator",
        "origin": Origin.PARAMETER,
        "key": "numerics.integrator",
        "causality": "parameter",
        "variability": "fixed",
        "initial": "exact",
        "type": "Enumeration",
        "enumeration": INTEGRATOR,
        "unit": "",
        "description": "time integrator",
        "start": INTEGRATORS[scene.numerics.method].code,
        "minimum": min(codes),
        "maximum": max(codes),
    }


def _exclusive(bounds: dict[str, float]) -> str:
    """Remark on bounds that are refused themselves; FMI's own bounds are inclusive."""
    words = {"gt": ">", "lt": "<"}
    remarks = " and ".join(
        f"{word} {bounds[kind]:.6g}" for kind, word in words.items() if kind in bounds
    )
    return f"; {remarks}" if remarks else ""


def _declared(scene: Scene | LineScene, path: str) -> tuple[bool, dict[str, float]]:
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
