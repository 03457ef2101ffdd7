"""FMI 3.0: the same variables, library and results as FMI 2.0, and what only 3.0 has."""

import ctypes as c
import importlib.util
import os
import re
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from lxml import etree

import gallop_fmu as gf
from gallop_fmu.engine.library import library_path
from gallop_fmu.fmu import ExportError, export_fmu
from gallop_fmu.fmu.export import platform_3
from gallop_fmu.fmu.fmi3_xml import TIME
from support.line_scenes import section

FMPY = Path(importlib.util.find_spec("fmpy").origin).parent
TYPES = {"Real": "Float64", "Integer": "Int32", "Enumeration": "Enumeration"}
LINE = section(20000.0, [200.0, 250.0], 15.7, 3e7, elements=4)


@pytest.fixture(scope="module")
def scene():
    return gf.load_scene("example3").with_values({"numerics.elements": 6})


@pytest.fixture(scope="module")
def both(scene, tmp_path_factory):
    """Portable: which products are fused depends on the options of the compiler."""
    folder = tmp_path_factory.mktemp("fmi3")
    scene = scene.with_values({"numerics.portable": True})
    return {
        version: export_fmu(scene, folder / f"{version}.fmu", stations=[0.25], fmi=version)
        for version in (2, 3)
    }


@pytest.fixture
def hosts(both, tmp_path):
    """An instance of each version by its number; and what the one of FMI 3.0 logged."""
    log, instances = [], {}
    for version, kind in ((2, FMU2Slave), (3, FMU3Slave)):
        description = read_model_description(str(both[version]))
        folder = extract(
            str(both[version]), unzipdir=str(tmp_path / f"with space, \u00fc {version}")
        )
        instances[version] = kind(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="span",
        )
    instances[2].instantiate()
    instances[3].instantiate(logMessage=lambda *message: log.append(message[-1].decode()))
    yield instances, log
    for instance in instances.values():
        instance.freeInstance()


def start(instances):
    instances[2].setupExperiment(startTime=1.0)
    instances[2].enterInitializationMode()
    instances[3].enterInitializationMode(startTime=1.0)
    for instance in instances.values():
        instance.exitInitializationMode()


def test_fmpy_finds_no_fault(both):
    assert validate_fmu(str(both[3])) == []


def test_variables_are_those_of_fmi_2(both):
    tables = {
        version: {v.name: v for v in read_model_description(str(path)).modelVariables}
        for version, path in both.items()
    }
    time = tables[3].pop("time")
    assert (time.causality, time.valueReference, time.unit) == ("independent", TIME, "s")
    assert list(tables[2]) == list(tables[3])
    for old, new in zip(tables[2].values(), tables[3].values(), strict=True):
        assert new.type == TYPES[old.type]
        for name in (
            "valueReference",
            "description",
            "causality",
            "variability",
            "initial",
            "unit",
            "displayUnit",
            "min",
            "max",
            "nominal",
            "start",
        ):
            assert getattr(old, name) == getattr(new, name), (old.name, name)


def test_structure_and_capabilities(both):
    description = read_model_description(str(both[3]))
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    assert [unknown.variable.name for unknown in description.outputs] == outputs
    assert [unknown.variable.name for unknown in description.initialUnknowns] == outputs
    assert all(unknown.dependencies == [] for unknown in description.outputs)
    simulation = description.coSimulation
    assert simulation.canGetAndSetFMUstate
    assert simulation.canSerializeFMUstate
    assert simulation.maxOutputDerivativeOrder == 1
    assert not simulation.hasEventMode
    assert not simulation.providesIntermediateUpdate
    with zipfile.ZipFile(both[3]) as archive:  # FMPy 0.3.32 does not read this one
        assert b'providesDirectionalDerivatives="true"' in archive.read("modelDescription.xml")


def test_results_are_those_of_fmi_2_bit_for_bit(both):
    time = np.arange(0.0, 3.0, 0.1)
    signal = np.zeros(
        len(time), dtype=[("time", "f8"), ("wind_speed", "f8"), ("support.left.x1", "f8")]
    )
    signal["time"], signal["wind_speed"] = time, 6.0 + np.sin(time)
    signal["support.left.x1"] = 0.01 * np.sin(5.0 * time)
    start = {"attack_angle": 3.0, "numerics.newton_tolerance": 1e-10}
    runs = [
        simulate_fmu(
            str(path), stop_time=2.0, output_interval=0.02, input=signal, start_values=start
        )
        for path in both.values()
    ]
    names = runs[0].dtype.names
    assert set(names) == set(runs[1].dtype.names)
    assert np.ptp(runs[0]["midspan.x2"]) > 1e-3
    assert all(list(runs[0][name]) == list(runs[1][name]) for name in names)


def test_the_library_has_all_functions_of_both_standards(hosts):
    instances, _ = hosts
    for version, count in ((2, 44), (3, 75)):
        header = (FMPY / "c-code" / f"fmi{version}FunctionTypes.h").read_text()
        names = set(re.findall(rf"\b(fmi{version}[A-Z]\w+)TYPE\b", header))
        assert len(names) == count
        assert all(hasattr(instances[3].dll, name) for name in names)


def test_states_and_derivatives_are_those_of_fmi_2(hosts, both):
    instances, _ = hosts
    start(instances)
    names = ["midspan.x3", "midspan.tension", "support.left.f1"]
    description = read_model_description(str(both[2]))
    references = {v.name: v.valueReference for v in description.modelVariables}
    asked = [references[name] for name in names]
    wind = [references["wind_speed"]]
    for k in range(3):
        for instance in instances.values():
            instance.doStep(1.0 + 0.05 * k, 0.05)
    assert instances[2].getReal(asked) == instances[3].getFloat64(asked)
    assert instances[3].getFloat64([TIME]) == [pytest.approx(1.15)]
    rates = [instances[2].getRealOutputDerivatives(asked, [1, 1, 1])]
    rates.append(instances[3].getOutputDerivatives(asked, [1, 1, 1]))
    assert list(rates[0]) == rates[1]
    along = (c.c_double * 3)()
    array = c.c_uint32 * 3
    instances[3].fmi3GetDirectionalDerivative(
        instances[3].component, array(*asked), 3, (c.c_uint32 * 1)(*wind), 1,
        (c.c_double * 1)(1.0), 1, along, 3,
    )  # fmt: skip
    assert list(along) == list(instances[2].getDirectionalDerivative(asked, wind, [1.0]))
    state = instances[2].getFMUstate()
    content = instances[2].serializeFMUstate(state)
    instances[2].freeFMUstate(state)
    other = instances[3].deserializeFMUState(content)
    before = instances[3].getFloat64(asked)
    instances[3].doStep(1.15, 0.05)
    assert instances[3].getFloat64(asked) != before
    instances[3].setFMUState(other)
    assert instances[3].getFloat64(asked) == before
    assert instances[3].serializeFMUState(other) == content
    instances[3].freeFMUState(other)


def call(host, name, *arguments):
    """Call a function of the library, past the types that FMPy declares."""
    return getattr(c.CDLL(host.dll._name), name)(c.c_void_p(host.component), *arguments)


ABSENT = {
    "fmi3GetFloat32": "Float64, Int32 and Enumeration only",
    "fmi3SetString": "Float64, Int32 and Enumeration only",
    "fmi3GetClock": "no clocks",
    "fmi3GetIntervalDecimal": "no clocks",
    "fmi3EnterEventMode": "no event mode",
    "fmi3UpdateDiscreteStates": "no event mode",
    "fmi3EnterConfigurationMode": "no structural parameters",
    "fmi3GetNumberOfVariableDependencies": "no dependencies of elements",
    "fmi3GetAdjointDerivative": "no adjoint derivatives",
    "fmi3SetContinuousStates": "for co-simulation only",
}


@pytest.mark.parametrize("name", ABSENT)
def test_what_is_absent_is_refused(hosts, name):
    instances, log = hosts
    assert call(instances[3], name, *[c.c_void_p()] * 9) == 3
    assert ABSENT[name] in log[-1]


def test_refused_calls_say_why(hosts):
    instances, log = hosts
    host = instances[3]
    one, two = (c.c_uint32 * 1)(0), (c.c_double * 2)(6.0, 6.0)
    calls = {
        "give one value for each reference": (
            "fmi3SetFloat64", one, c.c_size_t(1), two, c.c_size_t(2),
        ),
        "must be at least -150 and at most 150": (
            "fmi3SetFloat64", one, c.c_size_t(1), (c.c_double * 1)(-151.0), c.c_size_t(1),
        ),
        "needs more than 32 bits": (
            "fmi3SetInt64", one, c.c_size_t(1), (c.c_int64 * 1)(2**40), c.c_size_t(1),
        ),
        "there is no Integer variable": (
            "fmi3GetInt64", one, c.c_size_t(1), (c.c_int64 * 1)(), c.c_size_t(1),
        ),
        "null pointer": ("fmi3GetInt64", None, c.c_size_t(1), None, c.c_size_t(1)),
        "is not allowed before initialization": (
            "fmi3DoStep", c.c_double(0.0), c.c_double(0.1), 1, None, None, None, None,
        ),
        "must be after the start time": (
            "fmi3EnterInitializationMode", 0, c.c_double(0.0), c.c_double(1.0), 1, c.c_double(0.5),
        ),
        "the log category is unknown": (
            "fmi3SetDebugLogging", 1, c.c_size_t(1), (c.c_char_p * 1)(b"nonsense"),
        ),
    }  # fmt: skip
    for text, (name, *arguments) in calls.items():
        assert call(host, name, *arguments) == 3, name
        assert text in log[-1]
    assert call(host, "fmi3SetDebugLogging", 1, c.c_size_t(1), (c.c_char_p * 1)(b"logAll")) == 0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"eventModeUsed": True}, "no event mode"),
        ({"requiredIntermediateVariables": [0]}, "no intermediate update"),
    ],
)
def test_instances_that_are_refused(hosts, settings, message):
    instances, _ = hosts
    log = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        instances[3].instantiate(logMessage=lambda *text: log.append(text[-1].decode()), **settings)
    assert message in log[-1]
    instances[3].instantiate()


def schema(name):
    return etree.XMLSchema(etree.parse(str(FMPY / "schema" / "fmi3" / name)))


def test_each_tower_is_a_terminal(both, scene, tmp_path):
    for path, towers in (
        (both[3], ["support.left", "support.right"]),
        (line_fmu(tmp_path), ["tower[0]", "tower[1]", "tower[2]"]),
    ):
        with zipfile.ZipFile(path) as archive:
            root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
            names = set(archive.namelist())
        schema("fmi3TerminalsAndIcons.xsd").assertValid(root)
        assert {"terminalsAndIcons/icon.png", "terminalsAndIcons/tower.png"} <= names
        variables = {v.name: v for v in read_model_description(str(path)).modelVariables}
        found = root.findall("Terminals/Terminal")
        assert [terminal.get("name") for terminal in found] == towers
        for terminal in found:
            members = terminal.findall("TerminalMemberVariable")
            kinds = {m.get("memberName"): variables[m.get("variableName")] for m in members}
            assert list(kinds) == [f"{letter}{axis}" for letter in "xvf" for axis in (1, 2, 3)]
            assert [v.causality for v in kinds.values()] == 6 * ["input"] + 3 * ["output"]
            assert [v.unit for v in kinds.values()] == 3 * ["m"] + 3 * ["m/s"] + 3 * ["N"]
            assert all(v.name.startswith(terminal.get("name")) for v in kinds.values())


def line_fmu(folder):
    return export_fmu(LINE, folder / "line.fmu", fmi=3)


def test_compiled_from_the_build_description_it_gives_the_same_bits(both, tmp_path):
    with zipfile.ZipFile(both[3]) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
        archive.extractall(tmp_path)
    build = etree.fromstring(files["sources/buildDescription.xml"])[0]
    name = build.get("modelIdentifier")
    sources = [f"sources/{file.get('name')}" for file in build.iter("SourceFile")]
    flags = ["-std=c11", "-O0", "-ffp-contract=off", "-shared", "-fPIC", f"-I{FMPY / 'c-code'}"]
    command = [os.environ.get("CC", "cc"), *flags, *sources, "-lm", "-o", "compiled.so"]
    subprocess.run(command, cwd=tmp_path, check=True)
    own = tmp_path / "compiled.fmu"
    with zipfile.ZipFile(own, "w") as archive:
        for member, content in files.items():
            if not member.startswith("binaries/"):
                archive.writestr(member, content)
        library = f"binaries/{platform_3()}/{name}{library_path().suffix}"
        archive.writestr(library, (tmp_path / "compiled.so").read_bytes())
    runs = [simulate_fmu(str(fmu), stop_time=1.0, output_interval=0.02) for fmu in (both[3], own)]
    assert runs[0].tobytes() == runs[1].tobytes()


def test_sources_are_described(both):
    with zipfile.ZipFile(both[3]) as archive:
        names = archive.namelist()
        root = etree.fromstring(archive.read("sources/buildDescription.xml"))
    schema("fmi3BuildDescription.xsd").assertValid(root)
    named = [f"sources/{file.get('name')}" for file in root.iter("SourceFile")]
    assert named == [name for name in names if name.endswith(".c")]
    assert {"sources/fmi3.c", "sources/fmi3_absent.c"} <= set(named)
    assert "sources/fmi2.c" not in names
    description = read_model_description(str(both[3]))
    assert root[0].get("modelIdentifier") == description.coSimulation.modelIdentifier
    assert any(name.startswith(f"binaries/{platform_3()}/") for name in names)


def test_exports_that_are_refused(scene, tmp_path):
    with pytest.raises(ExportError, match="fmi = 1: must be 2 or 3"):
        export_fmu(scene, tmp_path / "x.fmu", fmi=1)
    with pytest.raises(ExportError, match="the Python runtime has FMI 2\\.0 only"):
        export_fmu(scene, tmp_path / "x.fmu", runtime="python", fmi=3)
    assert list(tmp_path.iterdir()) == []
