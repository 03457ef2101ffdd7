"""The files of FMI 3.0 for co-simulation, from the table of variables.

- ``modelDescription.xml``,
- ``terminalsAndIcons/terminalsAndIcons.xml``: a terminal for every tower, whose members are the
  displacements that the FMU takes and the forces that it gives,
- ``sources/buildDescription.xml``: how to compile the sources.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

from gallop_fmu.fmu import xml_parts
from gallop_fmu.fmu.description import Identity
from gallop_fmu.fmu.sources import units_to_compile
from gallop_fmu.fmu.variable import TargetKind, Variable
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

TIME = 0x7FFFFFFF
"""Value reference of the time: GALLOP_COSIM_TIME in kernel/gallop_cosim.h."""

TYPES = {"Real": "Float64", "Integer": "Int32", "Enumeration": "Enumeration"}
"""Types of FMI 3.0 by those of FMI 2.0."""

AXES = ("x1", "x2", "x3")
VELOCITIES = ("v1", "v2", "v3")
FORCES = ("f1", "f2", "f3")


def model_description(
    scene: Scene | LineScene, description: str, variables: Sequence[Variable], identity: Identity
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
        Instantiation token and model identifier.
    """
    root = xml_parts.model(scene, description, fmiVersion="3.0", instantiationToken=identity.guid)
    _capabilities(root, identity)
    xml_parts.add_units(root, variables)
    types = SubElement(root, "TypeDefinitions")
    for name, items in xml_parts.used_enumerations(variables).items():
        xml_parts.add_items(SubElement(types, "EnumerationType", name=name), items)
    xml_parts.add_log_categories(root)
    xml_parts.add_default_experiment(root, scene)
    table = SubElement(root, "ModelVariables")
    SubElement(
        table,
        "Float64",
        name="time",
        valueReference=str(TIME),
        description="time that has been reached",
        causality="independent",
        variability="continuous",
        unit="s",
    )
    for variable in variables:
        attributes = xml_parts.common_attributes(variable) | xml_parts.typed_attributes(variable)
        SubElement(table, TYPES[variable.type], attributes)
    _structure(root, variables)
    return xml_parts.xml(root)


def _capabilities(root: Element, identity: Identity) -> None:
    flags = {
        "needsExecutionTool": False,
        "canBeInstantiatedOnlyOncePerProcess": False,
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": True,
        "providesAdjointDerivatives": False,
        "canHandleVariableCommunicationStepSize": True,
        "maxOutputDerivativeOrder": 1,
        "providesIntermediateUpdate": False,
        "mightReturnEarlyFromDoStep": False,
        "hasEventMode": False,
    }
    attributes = {name: xml_parts.text_of(value) for name, value in flags.items()}
    SubElement(root, "CoSimulation", attributes, modelIdentifier=identity.model_identifier)


def _structure(root: Element, variables: Iterable[Variable]) -> None:
    """Outputs do not depend on the inputs of their own instant; initial ones on everything."""
    structure = SubElement(root, "ModelStructure")
    references = [str(v.reference) for v in variables if v.causality == "output"]
    for reference in references:
        SubElement(structure, "Output", valueReference=reference, dependencies="")
    for reference in references:
        SubElement(structure, "InitialUnknown", valueReference=reference)


def terminals(variables: Sequence[Variable]) -> dict[str, list[str]]:
    """Return the names of the members of each terminal by the name of the tower."""
    names = {variable.name for variable in variables}
    towers = dict.fromkeys(
        variable.name.rpartition(".")[0]
        for variable in variables
        if variable.targets and variable.targets[0].kind is TargetKind.MOTION
    )
    members = (*AXES, *VELOCITIES, *FORCES)
    return {
        tower: [f"{tower}.{member}" for member in members if f"{tower}.{member}" in names]
        for tower in towers
    }


def terminals_and_icons(variables: Sequence[Variable]) -> bytes:
    """Return the text of terminalsAndIcons.xml; the towers are in a row above the icon's middle."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = SubElement(root, "GraphicalRepresentation")
    square = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    SubElement(picture, "CoordinateSystem", square, suggestedScalingFactorTo_mm="0.1")
    SubElement(picture, "Icon", square)
    found = terminals(variables)
    table = SubElement(root, "Terminals")
    for number, (tower, names) in enumerate(found.items()):
        terminal = SubElement(
            table,
            "Terminal",
            name=tower,
            matchingRule="bus",  # a tower need not give its velocity
            description="motion of the tower, and force of the conductors on it",
        )
        for name in names:
            member = name.rpartition(".")[2]
            SubElement(
                terminal,
                "TerminalMemberVariable",
                variableName=name,
                memberName=member,
                variableKind="outflow" if member in FORCES else "signal",
            )
        middle = -100.0 + 200.0 * number / max(len(found) - 1, 1)
        SubElement(
            terminal,
            "TerminalGraphicalRepresentation",
            x1=repr(middle - 10.0),
            y1="40.0",
            x2=repr(middle + 10.0),
            y2="60.0",
            iconBaseName="tower",
        )
    return xml_parts.xml(root)


def build_description(identity: Identity) -> bytes:
    """Return the text of buildDescription.xml."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    build = SubElement(root, "BuildConfiguration", modelIdentifier=identity.model_identifier)
    files = SubElement(build, "SourceFileSet", language="C11")
    for file in units_to_compile(3):
        SubElement(files, "SourceFile", name=file)
    SubElement(build, "Library", name="m", external="true", description="of the C compiler, if any")
    return xml_parts.xml(root)
