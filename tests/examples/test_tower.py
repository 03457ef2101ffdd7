"""The tower example: tower, monolithic solution, masters, and the same system as an SSP file."""

import json
import os
import re
import subprocess
import sys
import zipfile
from contextlib import ExitStack, closing
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.ssp.ssd import read_ssd
from scipy.integrate import solve_ivp

import gallop_fmu as gf

FOLDER = Path(__file__).resolve().parents[2] / "examples"
sys.path[:0] = [str(FOLDER), str(FOLDER / "ssp")]

from make_ssp import (  # noqa: E402
    CABLE_STEP,
    PARAMETER_SET,
    SSC,
    SSD,
    SSV,
    STEP,
    connections,
    make_ssp,
)
from towers.coupling import (  # noqa: E402
    SCHEMES,
    Component,
    Line,
    Log,
    build_tower,
    couple,
    galloping_span,
    preload,
)
from towers.modal_tower import MODES, ModalTower, Mode  # noqa: E402
from towers.monolithic import Monolith  # noqa: E402

NAMES = {"ssd": SSD, "ssv": SSV, "ssc": SSC}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("towers")


@pytest.fixture(scope="module")
def tower(folder):
    return build_tower(folder)


@pytest.fixture(scope="module")
def span():
    return galloping_span(cable_step=0.0025)


@pytest.fixture(scope="module")
def cable(folder, span):
    return gf.export_fmu(span, folder / "cable.fmu")


def test_the_tower_is_a_sound_fmu(tower):
    check = gf.check_fmu(tower)
    assert check.ok, check.rows


def test_a_mode_follows_a_linear_force_exactly():
    mass, frequency, ratio, shape = 4000.0, 2.0, 0.03, 0.7
    omega = 2.0 * np.pi * frequency
    mode = Mode(mass, frequency, ratio, shape)
    mode.q, mode.rate = 0.002, -0.03

    def slope(t, y):
        force = shape * (1000.0 - 20000.0 * t)
        return [y[1], force / mass - 2.0 * ratio * omega * y[1] - omega**2 * y[0]]

    wanted = solve_ivp(slope, (0.0, 0.2), [mode.q, mode.rate], rtol=1e-12, atol=1e-14).y[:, -1]
    mode.advance(1000.0, -1000.0, 0.1)
    mode.advance(-1000.0, -3000.0, 0.1)
    assert [mode.q, mode.rate] == pytest.approx(wanted, rel=1e-9)  # observed: 3e-12


def test_a_saved_tower_is_restored_bit_for_bit():
    tower = ModalTower(instance_name="tower", resources=".")
    tower.force["f1"] = 2000.0
    tower.do_step(0.0, 0.01)
    saved = json.loads(json.dumps(tower._get_fmu_state()))

    def go_on():
        tower.force.update(f1=3000.0, f3=-100.0)
        tower.do_step(0.01, 0.01)
        return [variable.getter() for variable in tower.vars.values()]

    first = go_on()
    assert go_on() != first
    tower._set_fmu_state(saved)
    assert go_on() == first


def test_very_heavy_towers_are_rigid_ends(span):
    scene = span.with_values({"numerics.time_step": 0.005, "numerics.newton_tolerance": 1e-9})
    heavy = {axis: [(1e12, 2.0, 0.02, 1.0)] for axis in MODES}
    u2 = Monolith(scene, heavy, 0.005).run(2.0, 1)[:, 0]
    alone = gf.simulate(scene, stop_time=2.0, record_every=1).midspan().u2.values
    assert np.max(np.abs(u2 - alone)) < 2e-9  # observed: 9e-10 m of 0.1 m


def test_the_monolithic_solution_is_of_second_order(span):
    coarse, middle, fine = (
        Monolith(span, MODES, step).run(1.0, round(0.02 / step)) for step in (0.01, 0.005, 0.0025)
    )
    order = np.log2(np.linalg.norm(middle - coarse, axis=0) / np.linalg.norm(fine - middle, axis=0))
    assert order == pytest.approx([2.0, 2.0], abs=0.03)  # observed: 2.000, 1.987


@pytest.mark.parametrize("scheme", SCHEMES)
def test_without_wind_and_seed_nothing_moves(scheme, span, tower, folder):
    calm = {"wind.speed": 0.0, "initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0}
    scene = span.with_values(calm)
    static = preload(scene)
    assert static[[0, 2]] == pytest.approx([15000.0, -15000.0], rel=1e-3)
    with closing(Line(gf.export_fmu(scene, folder / "calm.fmu"), tower)) as line:
        line.start(static)
        assert line.forces() == pytest.approx(static, rel=1e-12, abs=1e-9)
        for n in range(50):
            SCHEMES[scheme](line, 0.01 * n, 0.01)
        assert np.max(np.abs(line.displacements())) < 1e-15  # observed: 4e-18 m
        assert line.forces() == pytest.approx(static, rel=1e-12, abs=1e-9)


def test_the_schemes_agree_with_the_monolithic_solution(span, cable, tower):
    reference = Monolith(span, MODES, 0.0025).run(1.0, 8)
    histories = {
        scheme: couple(cable, tower, scheme, 0.0025, 1.0, 0.02, preload(span)) for scheme in SCHEMES
    }
    errors = {
        scheme: (
            np.linalg.norm(history.values - reference, axis=0) / np.linalg.norm(reference, axis=0)
        )
        for scheme, history in histories.items()
    }
    assert np.all(errors["Jacobi"] > errors["Gauss-Seidel"])  # 4.7e-3 and 8.5e-2, 4.4e-3 and 5.8e-2
    assert np.all(errors["Gauss-Seidel"] > 10.0 * errors["iterated"])
    assert errors["iterated"][0] < 4e-5  # observed: 3.2e-5
    assert errors["iterated"][1] < 4e-3  # observed: 3.5e-3


@pytest.fixture(scope="module")
def ssp(folder):
    unpacked = folder / "unpacked"
    path = make_ssp(folder)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(unpacked)
    return path, unpacked, ElementTree.parse(unpacked / "SystemStructure.ssd").getroot()


def test_the_ssp_follows_the_standard(ssp):
    path, _, root = ssp
    structure = read_ssd(str(path))  # FMPy validates it against the schema of SSP 1.0
    for name in (structure.name, structure.system.name):  # OMSimulator refuses other names
        assert re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name)
    assert [component.name for component in structure.system.elements] == [
        "cable",
        "left_tower",
        "right_tower",
    ]
    assert len(structure.system.connections) == len(connections()) == 8
    assert (
        root.find("ssd:System/ssd:Connectors", NAMES) is None
    )  # Ecos refuses connectors of the system


def test_the_ssp_fits_its_fmus(ssp):
    _, unpacked, root = ssp
    variables = {}
    for component in root.iterfind(".//ssd:Component", NAMES):
        name = component.get("name")
        model = fmpy.read_model_description(str(unpacked / component.get("source")))
        variables[name] = {variable.name: variable for variable in model.modelVariables}
        for connector in component.iterfind("ssd:Connectors/ssd:Connector", NAMES):
            variable = variables[name][connector.get("name")]
            assert connector.get("kind") == variable.causality
            assert connector.find("ssc:Real", NAMES).get("unit") == variable.unit
    fed = set()
    for link in root.iterfind(".//ssd:Connection", NAMES):
        source = variables[link.get("startElement")][link.get("startConnector")]
        target = variables[link.get("endElement")][link.get("endConnector")]
        assert (source.causality, target.causality) == ("output", "input")
        assert source.unit == target.unit
        fed.add((link.get("endElement"), link.get("endConnector")))
    inputs = {
        (part, v.name)
        for part, of in variables.items()
        for v in of.values()
        if v.causality == "input"
    }
    free = {"wind_speed", "attack_angle", "support.left.x2", "support.right.x2"}
    free |= {f"support.{end}.v{i}" for end in ("left", "right") for i in (1, 2, 3)}  # optional
    assert inputs - fed == {("cable", name) for name in free}


def test_the_ssp_preloads_the_towers_with_the_static_forces(ssp, span):
    _, _, root = ssp
    values = []
    for component in root.iterfind(".//ssd:Component", NAMES):
        for parameters in component.iterfind(".//ssv:ParameterSet", NAMES):
            assert parameters.get("name") == PARAMETER_SET
            values += [
                float(real.get("value")) for real in parameters.iterfind(".//ssv:Real", NAMES)
            ]
    assert values == pytest.approx(preload(span), rel=1e-12)


def test_the_ssp_agrees_with_the_jacobi_loop(ssp):
    _, unpacked, root = ssp
    fmus = [unpacked / "resources" / name for name in ("cable.fmu", "tower.fmu")]
    wanted = np.array(
        couple(*fmus, "Jacobi", STEP, 0.1, STEP, preload(galloping_span(CABLE_STEP))).values
    )
    links = [
        [
            link.get(f"{side}{what}")
            for side in ("start", "end")
            for what in ("Element", "Connector")
        ]
        for link in root.iterfind(".//ssd:Connection", NAMES)
    ]

    def exchange():
        for source, output, target, into in links:
            parts[target].set([into], parts[source].get([output]))

    log, parts = Log(), {}
    with ExitStack() as stack:
        for component in root.iterfind(".//ssd:Component", NAMES):
            part = Component(unpacked / component.get("source"), component.get("name"), log)
            parts[component.get("name")] = stack.enter_context(closing(part))
            part.fmu.enterInitializationMode()
            for parameter in component.iterfind(".//ssv:Parameter", NAMES):
                part.set(
                    [parameter.get("name")],
                    np.array([float(parameter.find("ssv:Real", NAMES).get("value"))]),
                )
        exchange()
        for part in parts.values():
            part.fmu.exitInitializationMode()
        for n in range(20):
            exchange()
            for part in parts.values():
                part.fmu.doStep(n * STEP, STEP)
        found = [parts["cable"].get(["midspan.x2"])[0], parts["left_tower"].get(["x1"])[0]]
    assert found == pytest.approx(wanted[-1], rel=1e-12)


def test_the_independent_run_names_the_missing_package(tmp_path):
    (tmp_path / "ecospy.py").write_text("raise ImportError")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, str(FOLDER / "ssp" / "run_ssp.py")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert "pip install ecospy" in done.stderr
