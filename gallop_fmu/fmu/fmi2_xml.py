"""modelDescription.xml of FMI 2.0 for co-simulation, from the table of variables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

from gallop_fmu.fmu import xml_parts
from gallop_fmu.fmu.description import Identity
from gallop_fmu.fmu.sources import units_to_compile
from gallop_fmu.fmu.variable import Variable
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene


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
    root = xml_parts.model(scene, description, fmiVersion="2.0", guid=identity.guid)
    _capabilities(root, identity, native)
    xml_parts.add_units(root, variables)
    types = SubElement(root, "TypeDefinitions")
    for name, items in xml_parts.used_enumerations(variables).items():
        kind = SubElement(types, "SimpleType", name=name)
        xml_parts.add_items(SubElement(kind, "Enumeration"), items)
    xml_parts.add_log_categories(root)
    xml_parts.add_default_experiment(root, scene)
    table = SubElement(root, "ModelVariables")
    for variable in variables:
        scalar = SubElement(table, "ScalarVariable", xml_parts.common_attributes(variable))
        SubElement(scalar, variable.type, xml_parts.typed_attributes(variable))
    _structure(root, variables)
    return xml_parts.xml(root)


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
        name: xml_parts.text_of(value) for name, value in flags.items()
    }
    simulation = SubElement(root, "CoSimulation", attributes)
    if native:
        files = SubElement(simulation, "SourceFiles")
        for file in units_to_compile(2):
            SubElement(files, "File", name=file)


def _structure(root: Element, variables: Iterable[Variable]) -> None:
    """Outputs do not depend on the inputs of their own instant; initial ones on everything."""
    structure = SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for index, variable in enumerate(variables, start=1):
        if variable.causality == "output":
            SubElement(outputs, "Unknown", index=str(index), dependencies="")
            SubElement(unknowns, "Unknown", index=str(index))
