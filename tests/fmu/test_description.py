"""The table of variables and the model description made from it."""

import math
import re
import zipfile
from xml.etree import ElementTree

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from gallop_fmu.fmu import export_fmu, variable_table
from gallop_fmu.fmu.units import BASE_UNITS
from gallop_fmu.fmu.variables import Origin, fmu_variables
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.input.scene_files import load_scene, packaged_scenes
from gallop_fmu.scene.time_functions import Ramp
from support.line_scenes import section

LINE = section(20000.0, [200.0, 250.0], 15.7, 3e7, elements=4)

SI = {
    "N": (1, 1, -2, 0, 1.0),
    "N/m": (1, 0, -2, 0, 1.0),
    "N m2/rad": (1, 3, -2, -1, 1.0),
    "kg/m3": (1, -3, 0, 0, 1.0),
    "rad/s": (0, 0, -1, 1, 1.0),
    "deg": (0, 0, 0, 1, 0.017453292519943295),
}
"""Exponents of kg, m, s, rad, and factor, written by hand to check the package's table."""

SCENES = sorted(packaged_scenes())


@pytest.fixture(scope="module", params=SCENES)
def exported(request, runtime, tmp_path_factory):
    scene = load_scene(request.param)
    path = export_fmu(scene, tmp_path_factory.mktemp("fmu") / "x.fmu", runtime=runtime)
    return scene, path, read_model_description(str(path))


def test_fmpy_finds_no_fault(exported):
    assert validate_fmu(str(exported[1])) == []


def test_every_variable_of_the_table_is_described_as_in_the_table(exported):
    scene, _, description = exported
    described = {variable.name: variable for variable in description.modelVariables}
    table = fmu_variables(scene)
    assert list(described) == [variable.name for variable in table]
    for variable in table:
        found = described[variable.name]
        assert (found.causality, found.variability) == (variable.causality, variable.variability)
        assert (found.type, found.valueReference) == (variable.type, variable.reference)
        assert found.unit == (variable.unit or None)
        assert found.description == variable.description
        if variable.start is None:
            assert found.start is None
        else:
            assert float(found.start) == variable.start


def test_every_real_has_a_unit_made_of_base_units(exported):
    _, _, description = exported
    units = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    for variable in description.modelVariables:
        if variable.type == "Real":
            base = units[variable.unit]
            wanted = {"factor": 1.0} | BASE_UNITS[variable.unit]
            for name in ("kg", "m", "s", "rad", "factor"):
                assert getattr(base, name) == wanted.get(name, 0)
    for name, (kg, m, s, rad, factor) in SI.items():
        if name in units:
            base = units[name]
            assert (base.kg, base.m, base.s, base.rad) == (kg, m, s, rad)
            assert base.factor == pytest.approx(factor, rel=1e-15)


def test_radians_are_shown_as_degrees(exported):
    _, _, description = exported
    display = {unit.name: unit.displayUnits for unit in description.unitDefinitions}
    assert [(shown.name, shown.factor) for shown in display["rad"]] == [("deg", 180.0 / math.pi)]
    assert {v.displayUnit for v in description.modelVariables if v.unit == "rad"} == {"deg"}


def test_outputs_have_no_direct_feedthrough_and_are_all_initially_unknown(exported):
    _, _, description = exported
    names = [
        variable.name for variable in description.modelVariables if variable.causality == "output"
    ]
    assert [unknown.variable.name for unknown in description.outputs] == names
    assert all(unknown.dependencies == [] for unknown in description.outputs)
    assert [unknown.variable.name for unknown in description.initialUnknowns] == names


def test_every_continuous_variable_has_a_nominal_value(exported):
    _, _, description = exported
    found = {
        v.name: float(v.nominal)
        for v in description.modelVariables
        if v.variability == "continuous"
    }
    assert len(found) == 24 + 6 + 16
    assert all(1e-3 < value < 1e6 for value in found.values())


def test_enumerations_are_those_of_the_package(exported):
    _, _, description = exported
    kinds = {kind.name: kind.items for kind in description.typeDefinitions}
    assert {int(item.value): item.name for item in kinds["Status"]} == {
        outcome.code: outcome.name.lower() for outcome in Outcome if outcome.code < 100
    }
    assert {item.name: int(item.value) for item in kinds["Integrator"]} == {
        name: one.code for name, one in INTEGRATORS.items()
    }
    declared = {v.name: v.declaredType.name for v in description.modelVariables if v.declaredType}
    assert declared == {"status": "Status", "numerics.integrator": "Integrator"}


def test_author_copyright_and_licence(exported):
    _, path, _ = exported
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        licence = archive.read("documentation/licenses/license.txt").decode()
    assert root.get("license") == "BSD-3-Clause, see documentation/licenses"
    assert root.get("copyright") in licence
    assert root.get("author") == "The gallop-fmu developers"
    assert root.get("generationTool") == f"gallop-fmu {root.get('version')}"


def test_the_model_identifier_names_the_scene(exported):
    scene, _, description = exported
    name = description.coSimulation.modelIdentifier
    words = re.findall("[A-Za-z0-9]+", scene.title)
    assert name.startswith("_".join(["gallop", *words[:3]]))
    assert re.fullmatch(r"[a-z][A-Za-z0-9_]{16,56}", name)


def test_capabilities_and_experiment(exported, runtime):
    scene, _, description = exported
    simulation = description.coSimulation
    assert simulation.needsExecutionTool is (runtime == "python")
    assert simulation.providesDirectionalDerivative is (runtime == "native")
    assert simulation.canInterpolateInputs is (runtime == "native")
    assert simulation.maxOutputDerivativeOrder == (1 if runtime == "native" else 0)
    assert simulation.canHandleVariableCommunicationStepSize
    assert simulation.canGetAndSetFMUstate
    assert simulation.canSerializeFMUstate
    assert not simulation.canBeInstantiatedOnlyOncePerProcess
    experiment = description.defaultExperiment
    assert float(experiment.startTime) == 0.0
    assert float(experiment.stopTime) == min(scene.run.stop_time, 60.0)
    assert float(experiment.stepSize) == scene.numerics.time_step
    assert experiment.tolerance is None
    assert description.generationDateAndTime is None


def test_every_number_of_the_scene_is_a_parameter_unless_the_host_has_its_say(exported):
    scene, _, _ = exported
    parameters = {
        variable.key: variable
        for variable in fmu_variables(scene)
        if variable.origin is Origin.PARAMETER
    }
    left_out = set(scene.numbers()) - set(parameters)
    by_the_host = {"wind.speed", "wind.direction_deg", "ice.attack_angle_deg"}
    assert left_out == {*by_the_host, "run.stop_time", "run.record_every"}
    integrator = parameters.pop("numerics.integrator")
    assert integrator.start == INTEGRATORS[scene.numerics.method].code
    for path, variable in parameters.items():
        assert variable.start == scene.numbers()[path][0]
        assert (variable.type == "Integer") == isinstance(variable.start, int)


def test_inputs_and_outputs_keep_their_references_in_every_scene():
    tables = [fmu_variables(load_scene(name)) for name in SCENES]
    interfaces = [
        [(v.name, v.reference) for v in table if v.causality != "parameter"] for table in tables
    ]
    assert all(interface == interfaces[0] for interface in interfaces)
    assert len(interfaces[0]) == 8 + 19 + 6 + 6 + 2 * 8
    assert [name for name, _ in interfaces[0][:27]] == [
        *("wind_speed", "attack_angle"),
        *(f"support.{end}.x{k}" for end in ("left", "right") for k in (1, 2, 3)),
        *(f"midspan.{name}" for name in ("x1", "x2", "x3", "theta", "v1", "v2", "v3", "omega")),
        *("midspan.tension", "angle_of_attack"),
        *(f"support.{end}.f{k}" for end in ("left", "right") for k in (1, 2, 3)),
        *("status", "newton_iterations", "substeps"),
    ]  # of release 0.2.0


def test_inputs_start_from_the_scene():
    history = Ramp(initial=2.0, final=9.0, start=0.0, duration=5.0)
    scene = load_scene("example3").with_values({"wind.speed": None, "wind.history": history})
    table = {variable.name: variable for variable in fmu_variables(scene)}
    assert table["wind_speed"].start == 2.0
    assert table["attack_angle"].start == pytest.approx(math.pi, rel=1e-15)
    assert not any(name.startswith("wind.history") for name in table)


def test_support_motion_is_left_to_the_host():
    motion = {"x1": {"kind": "harmonic", "amplitude": 0.01, "frequency_hz": 1.0}}
    scene = load_scene("example3").with_values({"supports.left.motion": motion})
    assert not any("motion" in variable.name for variable in fmu_variables(scene))


def test_still_air_stays_still_without_a_curve():
    wind = fmu_variables(load_scene("example1"))[0]
    assert (wind.name, wind.minimum, wind.maximum) == ("wind_speed", 0.0, 0.0)


def test_bounds_are_those_of_the_scene():
    table = {variable.name: variable for variable in fmu_variables(load_scene("example1"))}
    assert (table["numerics.elements"].minimum, table["numerics.elements"].maximum) == (2, 5000)
    assert (table["span.length"].minimum, table["span.length"].maximum) == (0, 10000)
    assert table["span.height_difference"].minimum is None


def test_loads_are_indexed_in_brackets():
    names = [variable.name for variable in fmu_variables(load_scene("example1"))]
    assert "loads[0].torque" in names
    assert all(
        re.fullmatch(r"[A-Za-z_]\w*(\[\d+\])?(\.[A-Za-z_]\w*(\[\d+\])?)*", name) for name in names
    )


def test_rows_for_the_documentation():
    row = variable_table(load_scene("example3"))[0]
    assert row == {
        "name": "wind_speed",
        "causality": "input",
        "type": "Real",
        "unit": "m/s",
        "start": "5.5",
        "description": "wind speed across the span, constant in a step",
    }


@pytest.mark.parametrize("scene", [load_scene("example3"), LINE], ids=["span", "line"])
def test_descriptions_fit_a_tooltip(scene):
    longest = max((variable.description for variable in fmu_variables(scene)), key=len)
    assert len(longest) <= 85, longest
