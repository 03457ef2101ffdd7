"""Elements that the model descriptions of FMI 2.0 and 3.0 share."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import metadata
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from gallop_fmu.fmu.description import LOG_CATEGORIES
from gallop_fmu.fmu.enumerations import ENUMERATIONS, Item
from gallop_fmu.fmu.units import BASE_UNITS, DISPLAY_UNITS
from gallop_fmu.fmu.variable import Variable
from gallop_fmu.foundation.version import program, version
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

COPYRIGHT = "Copyright (c) 2026, The gallop-fmu developers"
LICENSE = "BSD-3-Clause, see documentation/licenses"
"""Of the program that the FMU contains; the scene is its author's."""

EXPERIMENT = 60.0
"""Longest duration [s] of the default experiment."""


def text_of(value: bool | float | int) -> str:
    """Return a value as an attribute has it."""
    return str(value).lower() if isinstance(value, bool) else repr(value)


def model(scene: Scene | LineScene, description: str, **identity: str) -> Element:
    """Return the root of a model description."""
    attributes = {
        "modelName": " ".join(scene.title.split()),
        "description": description,
        "author": metadata.metadata("gallop-fmu")["Author"],
        "version": version(),
        "copyright": COPYRIGHT,
        "license": LICENSE,
        "generationTool": program(),
        "variableNamingConvention": "structured",
    }
    return Element("fmiModelDescription", identity | attributes)


def add_units(root: Element, variables: Iterable[Variable]) -> None:
    """Append the definitions of all units."""
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted({variable.unit for variable in variables} - {""}):
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(
            unit, "BaseUnit", {base: text_of(power) for base, power in BASE_UNITS[name].items()}
        )
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            SubElement(unit, "DisplayUnit", name=display, factor=text_of(factor))


def used_enumerations(variables: Iterable[Variable]) -> dict[str, tuple[Item, ...]]:
    """Return the enumerations of the variables by their names."""
    names = sorted({variable.enumeration for variable in variables} - {""})
    return {name: ENUMERATIONS[name] for name in names}


def add_items(parent: Element, items: Iterable[Item]) -> None:
    """Append the items of an enumeration."""
    for item in items:
        SubElement(
            parent, "Item", name=item.name, value=str(item.value), description=item.description
        )


def add_log_categories(root: Element) -> None:
    """Append the categories of messages."""
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=meaning)


def add_default_experiment(root: Element, scene: Scene | LineScene) -> None:
    """Append the experiment that a host runs if its user asks for nothing else."""
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(min(scene.run.stop_time, EXPERIMENT)),
        stepSize=repr(scene.numerics.time_step),
    )


def common_attributes(variable: Variable) -> dict[str, str]:
    """Return name, reference and kind of a variable."""
    attributes = {
        "name": variable.name,
        "valueReference": str(variable.reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    return attributes | ({"initial": variable.initial} if variable.initial else {})


def typed_attributes(variable: Variable) -> dict[str, str]:
    """Return unit, bounds, nominal value and start of a variable."""
    attributes = {"unit": variable.unit} if variable.unit else {}
    if variable.enumeration:
        attributes["declaredType"] = variable.enumeration
    if variable.unit in DISPLAY_UNITS:
        attributes["displayUnit"] = DISPLAY_UNITS[variable.unit][0]
    numbers: dict[str, Any] = {
        "min": variable.minimum,
        "max": variable.maximum,
        "nominal": variable.nominal,
        "start": variable.start,
    }
    for name, number in numbers.items():
        if number is not None:
            attributes[name] = text_of(float(number) if variable.type == "Real" else number)
    return attributes


def xml(root: Element) -> bytes:
    """Return the text of a document, the same for equal elements."""
    indent(root)
    return bytes(tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"
