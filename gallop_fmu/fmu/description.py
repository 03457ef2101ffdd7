"""modelDescription.xml of FMI 2.0 for co-simulation, from the table of variables."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from gallop_fmu.fmu.sources import units_to_compile
from gallop_fmu.fmu.units import BASE_UNITS, DISPLAY_UNITS
from gallop_fmu.fmu.variable import Variable
from gallop_fmu.foundation.version import program, version
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

SCENE_FILE = "scene.toml"
"""The scene in the FMU's resources."""

LOG_CATEGORIES = {
    "logStatusError": "calls that were refused, or could not be carried out",
    "logStatusDiscard": "questions without an answer",
}

SEMANTICS = (
    "The inputs of the host replace the scene's wind, attack angle and {motion} motion;"
    " concentrated loads keep their laws of time. wind_speed and attack_angle hold their values"
    " over a communication step, or change at the rate that the host gives where it can; the"
    " {points} move linearly to their new places, which they reach at its end. A communication step"
    " is carried out in equal steps no longer than numerics.time_step, or in steps that keep"
    " numerics.tolerance where it is given. Outputs do not react to inputs before the next step,"
    " except while initialising."
)
LINE_SEMANTICS = (
    "Spans, phases and stations count from 1, towers from 0 (left end) to the number of spans"
    " (right end). tower[1].f1 to f3 are the force of conductors and strings on the tower, static"
    " force included."
)


def describe(scene: Scene | LineScene, remarks: str = "") -> str:
    """Return the description of a scene, and how its FMU behaves, as one paragraph.

    Parameters
    ----------
    scene
        The scene.
    remarks
        Further remarks for the host; may be empty.
    """
    semantics = [SEMANTICS.format(motion="support", points="tower points")]
    if isinstance(scene, LineScene):
        semantics = [SEMANTICS.format(motion="tower", points="towers"), LINE_SEMANTICS]
    return " ".join([*scene.description.split(), *semantics, remarks]).strip()


@dataclass(frozen=True, slots=True)
class Identity:
    """Identity of an FMU, derived from its content: equal scenes give equal FMUs.

    Attributes
    ----------
    content
        SHA-256 of run-time, version and scene, in hexadecimal digits.
    """

    content: str

    @property
    def model_identifier(self) -> str:
        """Return the name of the binary and of the Python module."""
        return f"gallop_{self.content[:16]}"

    @property
    def guid(self) -> str:
        """Return the GUID of the model description."""
        return f"{{{uuid.UUID(self.content[:32])}}}"


def identify(scene_text: str, version: str, runtime: str, chosen: str = "") -> Identity:
    """Return the identity of the FMU of a scene, given as its TOML text, and what is chosen."""
    parts = [runtime, version, scene_text, *([chosen] if chosen else [])]
    return Identity(hashlib.sha256("\0".join(parts).encode()).hexdigest())


def model_description(
    scene: Scene | LineScene,
    description: str,
    variables: Sequence[Variable],
    identity: Identity,
    *,
    native: bool,
) -> bytes:
    """Return the text of modelDescription.xml, the same for the same arguments.

    Parameters
    ----------
    scene
        The scene.
    description
        What `describe` gives.
    variables
        Its variables.
    identity
        GUID and model identifier.
    native
        True if the FMU has its own library, which has more capabilities than pythonfmu's.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=" ".join(scene.title.split()),
        guid=identity.guid,
        description=description,
        version=version(),
        generationTool=program(),
        variableNamingConvention="structured",
    )
    _capabilities(root, identity, native)
    _units(root, variables)
    categories = SubElement(root, "LogCategories")
    for name, meaning in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=meaning)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(scene.run.stop_time),
        stepSize=repr(scene.numerics.time_step),
    )
    table = SubElement(root, "ModelVariables")
    for variable in variables:
        _scalar_variable(table, variable)
    _structure(root, variables)
    indent(root)
    return bytes(tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


def _text(value: bool | float | int) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _capabilities(root: Element, identity: Identity, native: bool) -> None:
    flags = {
        "needsExecutionTool": not native,
        "canHandleVariableCommunicationStepSize": True,
        "canInterpolateInputs": native,
        "maxOutputDerivativeOrder": int(native),
        "canRunAsynchronuously": False,
        "canBeInstantiatedOnlyOncePerProcess": False,
        "canNotUseMemoryManagementFunctions": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": native,
    }
    attributes = {"modelIdentifier": identity.model_identifier} | {
        name: _text(value) for name, value in flags.items()
    }
    simulation = SubElement(root, "CoSimulation", attributes)
    if native:
        files = SubElement(simulation, "SourceFiles")
        for file in units_to_compile():
            SubElement(files, "File", name=file)


def _units(root: Element, variables: Iterable[Variable]) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted({variable.unit for variable in variables} - {""}):
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(
            unit, "BaseUnit", {base: _text(power) for base, power in BASE_UNITS[name].items()}
        )
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            SubElement(unit, "DisplayUnit", name=display, factor=_text(factor))


def _scalar_variable(table: Element, variable: Variable) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(variable.reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.initial:
        attributes["initial"] = variable.initial
    scalar = SubElement(table, "ScalarVariable", attributes)
    typed = SubElement(scalar, variable.type)
    if variable.unit:
        typed.set("unit", variable.unit)
    if variable.unit in DISPLAY_UNITS:
        typed.set("displayUnit", DISPLAY_UNITS[variable.unit][0])
    numbers = {
        "min": variable.minimum,
        "max": variable.maximum,
        "nominal": variable.nominal,
        "start": variable.start,
    }
    for name, number in numbers.items():
        if number is not None:
            typed.set(name, _text(number if variable.type == "Integer" else float(number)))


def _structure(root: Element, variables: Iterable[Variable]) -> None:
    """Outputs do not depend on the inputs of their own instant; initial ones on everything."""
    structure = SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for index, variable in enumerate(variables, start=1):
        if variable.causality == "output":
            SubElement(outputs, "Unknown", index=str(index), dependencies="")
            SubElement(unknowns, "Unknown", index=str(index))
