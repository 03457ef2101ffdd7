"""Write tower-cable.ssp: the coupled system of example 08 for an independent master.

    python make_ssp.py [folder]

SSP 1.0: three components of two FMUs, their connections, and the towers' preload as parameters.
There are no connectors of the system itself, which some masters refuse; the annotation gives
OMSimulator its master and step.
"""

import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

sys.path.append(str(Path(__file__).resolve().parents[1]))

import fmpy
from towers.coupling import build_tower, galloping_span, preload

import gallop_fmu as gf

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
STOP, STEP, CABLE_STEP = 10.0, 0.005, 0.00125
"""Stop time, communication step, and the cable's own step [s]."""
PARAMETER_SET = "preload"
"""Name of the parameter set of each tower; Ecos applies sets by name only."""


def connections() -> list[tuple[str, str, str, str]]:
    """Component and output, component and input."""
    rows = []
    for end in ("left", "right"):
        for axis in (1, 3):
            rows.append(("cable", f"support.{end}.f{axis}", f"{end}_tower", f"f{axis}"))
            rows.append((f"{end}_tower", f"x{axis}", "cable", f"support.{end}.x{axis}"))
    return rows


def _component(elements: Element, name: str, fmu: Path) -> Element:
    """A component with all inputs and outputs of its FMU as connectors."""
    component = SubElement(
        elements,
        f"{{{SSD}}}Component",
        name=name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{fmu.name}",
    )
    connectors = SubElement(component, f"{{{SSD}}}Connectors")
    for variable in fmpy.read_model_description(str(fmu)).modelVariables:
        if variable.causality in ("input", "output") and variable.type == "Real":
            connector = SubElement(
                connectors, f"{{{SSD}}}Connector", name=variable.name, kind=variable.causality
            )
            SubElement(connector, f"{{{SSC}}}Real", unit=variable.unit)
    return component


def _parameters(component: Element, values: dict[str, float]) -> None:
    binding = SubElement(
        SubElement(component, f"{{{SSD}}}ParameterBindings"), f"{{{SSD}}}ParameterBinding"
    )
    inside = SubElement(binding, f"{{{SSD}}}ParameterValues")
    parameters = SubElement(
        SubElement(inside, f"{{{SSV}}}ParameterSet", version="1.0", name=PARAMETER_SET),
        f"{{{SSV}}}Parameters",
    )
    for parameter, value in values.items():
        SubElement(
            SubElement(parameters, f"{{{SSV}}}Parameter", name=parameter),
            f"{{{SSV}}}Real",
            value=repr(value),
        )


def structure(cable: Path, tower: Path, scene: gf.Scene) -> bytes:
    """Text of SystemStructure.ssd."""
    for prefix, uri in (("ssd", SSD), ("ssv", SSV), ("ssc", SSC), ("oms", OMS)):
        ElementTree.register_namespace(prefix, uri)
    root = Element(f"{{{SSD}}}SystemStructureDescription", version="1.0", name="tower_cable_model")
    whole = SubElement(root, f"{{{SSD}}}System", name="tower_cable")
    elements = SubElement(whole, f"{{{SSD}}}Elements")
    _component(elements, "cable", cable)
    for end, (f1, f3) in zip(("left", "right"), preload(scene).reshape(2, 2).tolist(), strict=True):
        _parameters(
            _component(elements, f"{end}_tower", tower), {"preload.f1": f1, "preload.f3": f3}
        )
    links = SubElement(whole, f"{{{SSD}}}Connections")
    for source, output, target, into in connections():
        SubElement(
            links,
            f"{{{SSD}}}Connection",
            startElement=source,
            startConnector=output,
            endElement=target,
            endConnector=into,
        )
    annotation = SubElement(
        SubElement(whole, f"{{{SSD}}}Annotations"), f"{{{SSC}}}Annotation", type="org.openmodelica"
    )
    information = SubElement(
        SubElement(annotation, f"{{{OMS}}}Annotations"), f"{{{OMS}}}SimulationInformation"
    )
    tolerances = {
        "absoluteTolerance": "1e-4",
        "relativeTolerance": "1e-4",
    }  # asked for, though the step is fixed
    SubElement(
        information,
        f"{{{OMS}}}FixedStepMaster",
        description="oms-ma",
        stepSize=repr(STEP),
        **tolerances,
    )
    SubElement(root, f"{{{SSD}}}DefaultExperiment", startTime="0.0", stopTime=repr(STOP))
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


def make_ssp(folder: Path) -> Path:
    """Write tower-cable.ssp and the two FMUs into a folder."""
    scene = galloping_span(CABLE_STEP)
    cable, tower = gf.export_fmu(scene, folder / "cable.fmu"), build_tower(folder)
    target = folder / "tower-cable.ssp"
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr("SystemStructure.ssd", structure(cable, tower, scene))
        for fmu in (cable, tower):
            archive.write(fmu, f"resources/{fmu.name}")
    return target


if __name__ == "__main__":
    print("wrote", make_ssp(Path(sys.argv[1] if len(sys.argv) > 1 else ".")))
