"""The table of the FMU's variables, for model description, run-time, documentation and tests.

`gallop_fmu.fmu.span_ports` has the inputs and outputs. Every number of the scene that the host's
inputs do not replace is a fixed parameter under its dotted path, except those of ``run``, which the
host decides. In names, the index of a load is in brackets, as FMI demands: ``loads[0].torque``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, get_args

from gallop_fmu.fmu.span_ports import span_inputs, span_outputs
from gallop_fmu.fmu.variable import Origin, Variable
from gallop_fmu.scene.fields import WholeNumber
from gallop_fmu.scene.scene import Scene

REPLACED_BY_INPUTS = re.compile(
    r"wind\.(speed|history)\b|ice\.attack_angle_deg$|supports\.\w+\.motion\.|run\."
)
"""Paths of a scene that are not parameters, because the host sets them or does not use them."""


def fmu_variables(scene: Scene) -> tuple[Variable, ...]:
    """Return all variables of a scene's FMU.

    Inputs and outputs come first and have the same references in every FMU.
    """
    variables: list[Variable] = []
    for settings in (*span_inputs(scene), *span_outputs(scene), *_parameters(scene)):
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
