"""The FMU of a line: its ports, and its outputs against the engine's motion."""

import math
import re
import tomllib
import zipfile
from contextlib import suppress

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import Object, probes_of
from gallop_fmu.fmu import ExportError, export_fmu, variable_table
from gallop_fmu.fmu.ports import Ports
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.scene.line_scene import LineScene

RICH = tomllib.loads("""
title = "Two phases of twin bundles on three spans"
[section]
horizontal_tension = 21730.0
spans = [
    {length = 125.0},
    {length = 140.0, height_difference = 3.0, ice = {mass_per_length = 0.4}},
    {length = 120.0},
]
suspensions = [
    {kind = "string", length = 2.1, weight = 490.0, damping = 100.0},
    {kind = "string", length = 2.5, weight = 300.0},
]
right_end = {kind = "springs", stiffness_x1 = 2e5, stiffness_x3 = 1e5}
[bundle]
subconductors = 2
spacing = 0.4
spacers = 1
spacer_mass = 3.0
[[phases]]
name = "a"
[[phases]]
name = "b"
offset = [0.0, 4.0]
[conductor]
diameter = 0.0188
mass_per_length = 1.53
axial_stiffness = 13.3e6
torsional_stiffness = 101.0
torsional_inertia = 3.3e-4
[ice]
mass_per_length = 0.1
attack_angle_deg = 3.0
[wind]
speed = 4.1
[aerodynamics]
kind = "polynomial"
lift = [0.0, -4.5]
drag = [1.0]
moment = [0.0, 0.1]
centre_deg = 0.0
valid_from_deg = -60.0
valid_to_deg = 60.0
[initial]
seed_vertical = 0.01
[[devices]]
kind = "pendulum"
span = 2
station = 0.5
mass = 5.0
arm = 0.3
[numerics]
elements = 4
time_step = 0.01
""")
V_STRING = {"kind": "v_string", "length": 2.5, "weight": 300.0, "half_spread": 1.5}
SINGLE = {name: table for name, table in RICH.items() if name not in ("bundle", "phases")}
SINGLE["section"] = RICH["section"] | {
    "suspensions": [RICH["section"]["suspensions"][0], V_STRING],
    "right_end": {"kind": "rigid"},
}
STATIONS = (0.25, 0.8)
H, STEPS = 0.05, 8
TOWERS = 4


@pytest.fixture(scope="session")
def rich_scene():
    return LineScene.from_dict(RICH)


@pytest.fixture(scope="session")
def single_scene():
    """One conductor."""
    return LineScene.from_dict(SINGLE)


@pytest.fixture(scope="session")
def rich_fmu(rich_scene, runtime, tmp_path_factory):
    path = tmp_path_factory.mktemp("line") / "rich.fmu"
    return export_fmu(rich_scene, path, runtime=runtime, wind="span", stations=STATIONS)


@pytest.fixture(scope="session")
def single_fmu(single_scene, runtime, tmp_path_factory):
    path = tmp_path_factory.mktemp("line") / "single.fmu"
    return export_fmu(single_scene, path, runtime=runtime)


def test_fmpy_finds_no_fault(rich_fmu, single_fmu):
    assert validate_fmu(str(rich_fmu)) == []
    assert validate_fmu(str(single_fmu)) == []


def test_names_of_a_line_of_one_conductor(single_fmu):
    names = {v.name for v in read_model_description(str(single_fmu)).modelVariables}
    assert {"wind_speed", "attack_angle", "tower[0].x1", "tower[3].x3"} <= names
    assert {"span[2].midspan.x2", "span[3].midspan.omega", "tower[1].f1", "tower[3].f3"} <= names
    assert {"tower[1].string.pull", "tower[2].string.lean_across", "status"} <= names
    assert not any("phase" in name for name in names)
    assert {"span[2].station[1].x2", "tower[1].v3", "tower[1].preload.f1"} <= set(names)
    assert not {"span[1].wind_speed", "tower[0].string.pull", "tower[4].x1"} & names


def test_names_of_a_line_of_two_phases(rich_fmu):
    names = {v.name for v in read_model_description(str(rich_fmu)).modelVariables}
    assert {"span[1].wind_speed", "span[3].wind_speed", "span[2].phase[2].midspan.theta"} <= names
    assert {"span[2].phase[1].station[2].x3", "tower[0].f1", "tower[0].phase[2].f1"} <= names
    assert {"tower[2].phase[1].string.pull", "section.suspensions[0].damping"} <= names
    assert not {"wind_speed", "span[2].midspan.x2", "section.spans[0].length"} & names


def middle_of(model, state, span, phase, station=0.5):
    """Mean displacement of a bundle, and its rotation, from the nodes alone."""
    u = state.motion()[0]
    nodes = [chain.nearest_node(station) for chain in model.map.bundle(span, phase)]
    arms = np.array(model.scene.bundle.positions)
    arms -= arms.mean(axis=0)
    moved = u[nodes]
    across = moved[:, 1:3] - moved[:, 1:3].mean(axis=0) + arms
    # The complex number that turns the arms into their new places best.
    turn = np.sum((across[:, 0] + 1j * across[:, 1]) * (arms[:, 0] - 1j * arms[:, 1]))
    return moved.mean(axis=0)[:3], np.angle(turn) if len(nodes) > 1 else moved[0, 3]


def force_on(state, tower):
    """Sum of the forces at the junctions of a tower."""
    return sum(
        state.observe_junction(junction)
        for held in state.model.map.towers
        if held.tower == tower
        for junction in held.junctions
    )


def strings_of(state, held):
    rows = [(Object.DEVICE, device, channel) for device in held.devices for channel in (3, 4, 5)]
    values = state.observe(probes_of(rows)).reshape(len(held.devices), 3)
    return values[:, 0].sum(), values[:, 1].mean(), values[:, 2].mean()


def driven(scene, host, wind):
    """The engine and the FMU under the same wind and tower motion, step by step."""
    model = Model(scene)
    angle = math.radians(3.0)
    moves = np.zeros((TOWERS, 3))
    state = model.start(0.0, Inputs(0.0, wind(0), angle, moves))
    host.start()
    for k in range(STEPS):
        begin, before = host.time, moves
        moves = 0.01 * np.sin(0.7 * k + np.arange(12.0)).reshape(TOWERS, 3)
        for tower, axis in np.ndindex(TOWERS, 3):
            host[f"tower[{tower}].x{axis + 1}"] = moves[tower, axis]
        speeds = np.atleast_1d(wind(k))
        for span, speed in enumerate(speeds, start=1):
            host["wind_speed" if len(speeds) == 1 else f"span[{span}].wind_speed"] = speed
        host.step(H)
        size = host.time - begin
        inputs = Inputs(begin, wind(k), angle, before, support_rate=(moves - before) / size)
        state.advance(host.time, inputs)
        yield model, state


def close(wanted):
    """Sums in another order: 1e-12 of the largest component."""
    return pytest.approx(wanted, rel=1e-12, abs=1e-12 * np.max(np.abs(wanted)) + 1e-18)


def test_outputs_of_bundles_and_phases_are_those_of_the_engine(rich_scene, rich_fmu, host):
    def wind(k):
        return np.array([4.1, 0.0, 3.0]) if k else np.full(3, 4.1)

    fmu = host(rich_fmu)
    for model, state in driven(rich_scene, fmu, wind):
        for span, phase in ((1, 1), (2, 2), (3, 1)):
            for name, station in (("midspan", 0.5), ("station[1]", 0.25), ("station[2]", 0.8)):
                place = f"span[{span}].phase[{phase}].{name}"
                centre, turn = middle_of(model, state, span, phase, station)
                assert [fmu[f"{place}.x{i}"] for i in (1, 2, 3)] == close(centre)
                assert fmu[f"{place}.theta"] == pytest.approx(turn, rel=1e-9, abs=1e-15)
        for tower in range(TOWERS):
            wanted = force_on(state, tower)
            assert [fmu[f"tower[{tower}].f{i}"] for i in (1, 2, 3)] == close(wanted)
            parts = [[fmu[f"tower[{tower}].phase[{p}].f{i}"] for i in (1, 2, 3)] for p in (1, 2)]
            assert np.sum(parts, axis=0) == close(wanted)
        for held in model.map.towers:
            if held.has_string:
                name = f"tower[{held.tower}].phase[{held.phase}].string"
                wanted = strings_of(state, held)
                found = [fmu[f"{name}.{key}"] for key in ("pull", "lean_along", "lean_across")]
                assert found == pytest.approx(wanted, rel=1e-9, abs=1e-12)
    assert abs(fmu["span[2].phase[2].midspan.theta"]) > 1e-6


def test_outputs_of_a_line_of_one_conductor_are_those_of_the_engine(single_scene, single_fmu, host):
    """Digit by digit: each of these outputs is one probe."""
    fmu = host(single_fmu)
    for model, state in driven(single_scene, fmu, lambda k: 4.1 + 0.2 * k):
        for span in (1, 2, 3):
            node = state.observe_node(model.map.chain(span).middle)
            place = f"span[{span}].midspan"
            names = ["x1", "x2", "x3", "theta", "v1", "v2", "v3", "omega"]
            assert [fmu[f"{place}.{name}"] for name in names] == node[:8].tolist()
            assert fmu[f"{place}.tension"] == node[12]
            assert fmu[f"{place}.angle_of_attack"] == node[13]
        for tower in range(TOWERS):
            wanted = force_on(state, tower)
            assert [fmu[f"tower[{tower}].f{i}"] for i in (1, 2, 3)] == wanted.tolist()
        for tower in (1, 2):
            found = [fmu[f"tower[{tower}].string.{key}"] for key in ("pull", "lean_along")]
            assert found == [*strings_of(state, model.map.tower(tower))[:2]]


def test_both_run_times_give_the_same_digits(rich_scene, tmp_path, host):
    found = []
    for runtime in ("native", "python"):
        path = export_fmu(rich_scene, tmp_path / f"{runtime}.fmu", runtime=runtime)
        fmu = host(path).start()
        for tower in range(TOWERS):
            fmu[f"tower[{tower}].x1"] = 0.01 * tower
        found.append(fmu.step(H, 3).read())
    assert found[0] == found[1]


def test_a_state_is_saved_and_restored_bit_for_bit(rich_fmu, host):
    fmu = host(rich_fmu).start()
    fmu["tower[1].x3"], fmu["span[2].wind_speed"] = 0.02, 3.0
    fmu.step(H, 2)
    state = fmu.fmu.getFMUstate()
    kept = fmu.fmu.serializeFMUstate(state)
    time, wanted = fmu.time, fmu.step(H, 2).read()
    fmu["tower[1].x3"], fmu["span[2].wind_speed"] = 0.0, 0.0
    fmu.step(H, 2)
    again = fmu.fmu.deSerializeFMUstate(kept)
    fmu.fmu.setFMUstate(again)
    fmu.time = time
    assert fmu["span[2].wind_speed"] == 3.0
    assert fmu.step(H, 2).read() == wanted
    for one in (state, again):
        fmu.fmu.freeFMUstate(one)


def test_towers_that_move_alike_carry_the_line_along(single_scene, single_fmu, host):
    """Without wind and seed: a rigid translation, with the forces of rest."""
    calm = {"initial.seed_vertical": 0.0, "wind_speed": 0.0}
    forces = []
    for shift in ((0.0, 0.0, 0.0), (0.3, -0.2, 0.4)):
        values = calm | {
            f"tower[{tower}].x{axis + 1}": move
            for tower in range(TOWERS)
            for axis, move in enumerate(shift)
        }
        fmu = host(single_fmu)
        for name, value in values.items():
            fmu[name] = value
        fmu.start()
        for span in (1, 2, 3):
            moved = [fmu[f"span[{span}].midspan.x{i}"] for i in (1, 2, 3)]
            assert moved == pytest.approx(shift, abs=1e-8)
        forces.append([fmu[f"tower[{tower}].f{i}"] for tower in range(TOWERS) for i in (1, 2, 3)])
    assert forces[1] == pytest.approx(forces[0], abs=1e-3)  # of 21730 N


def test_the_towers_carry_the_weight_of_the_line(single_scene, single_fmu, host):
    """Still air: conductor, ice, strings and pendulum, and no force across or along in sum."""
    fmu = host(single_fmu)
    fmu["initial.seed_vertical"], fmu["wind_speed"] = 0.0, 0.0
    fmu.start()
    total = np.sum([[fmu[f"tower[{t}].f{i}"] for i in (1, 2, 3)] for t in range(TOWERS)], axis=0)
    ice = (0.1, 0.4, 0.1)
    lengths = [_strung_length(span) for span in SINGLE["section"]["spans"]]
    mass = sum((1.53 + own) * length for own, length in zip(ice, lengths, strict=True)) + 5.0
    weight = 9.81 * mass + 490.0 + 2 * 300.0
    # Mass is per metre of the conductor as it hangs; the ice has stretched it: observed 6.9e-5.
    assert total[1] == pytest.approx(-weight, rel=8e-5)
    assert total[[0, 2]] == pytest.approx(0.0, abs=1e-6)  # observed 4e-12


def _strung_length(span):
    """Length of the catenary of a span in the strung state."""
    a, half = 21730.0 / (1.53 * 9.81), 0.5 * span["length"]
    rise = span.get("height_difference", 0.0)
    return math.hypot(2.0 * a * math.sinh(half / a), rise)


PARAMETERS = {
    "conductor.mass_per_length": 1.6,
    "section.horizontal_tension": 21000.0,
    "section.suspensions[0].length": 2.0,
    "bundle.clamp_torsional_stiffness": 400.0,
    "section.spans[1].ice.mass_per_length": 0.3,
    "section.temperature_deg_c": -5.0,
    "section.strung_temperature_deg_c": 20.0,
}


def test_a_parameter_acts_wherever_its_value_is(rich_scene, tmp_path, host):
    """As if the scene had been changed before the export."""
    warm = rich_scene.with_values({"conductor.thermal_expansion": 1.9e-5})
    changed = warm.with_values(
        {name.replace("[", ".").replace("]", ""): value for name, value in PARAMETERS.items()}
    )
    one = host(export_fmu(warm, tmp_path / "one.fmu"))
    for name, value in PARAMETERS.items():
        one[name] = value
    other = host(export_fmu(changed, tmp_path / "other.fmu"))
    assert one.start().step(H, 3).read() == other.start().step(H, 3).read()


def test_every_number_of_a_line_is_a_parameter_or_has_a_reason(rich_scene):
    parameters = {v.key for v in fmu_variables(rich_scene) if v.causality == "parameter"}
    left_out = set(rich_scene.numbers()) - parameters
    mesh = {"numerics.elements", "bundle.subconductors", "bundle.spacing", "bundle.spacers"}
    places = {
        f"section.spans.{k}.{name}" for k in range(3) for name in ("length", "height_difference")
    }
    # Without conductor.thermal_expansion they have no effect.
    strung = {"section.strung_temperature_deg_c", "section.temperature_deg_c"}
    replaced = {"wind.speed", "wind.direction_deg", "ice.attack_angle_deg"}
    replaced |= {"run.stop_time", "run.record_every"}
    device = {"devices.0.span", "devices.0.station"}
    assert left_out == mesh | places | strung | replaced | device


def test_rows_for_the_documentation_name_the_towers(single_scene):
    rows = {row["name"]: row for row in variable_table(single_scene)}
    assert rows["tower[1].f3"]["description"] == (
        "force on tower 1 across the line, downwind, of conductors and strings"
    )
    assert rows["tower[0].x1"]["unit"] == "m"


def test_the_page_in_the_fmu_lists_the_variables(rich_fmu, rich_scene):
    with zipfile.ZipFile(rich_fmu) as archive:
        page = archive.read("documentation/index.html").decode()
    names = re.findall(r"<code>(.*?)</code>", page[page.index("<h2>Inputs") :])
    ports = Ports("span", STATIONS)
    assert sorted(names) == sorted(v.name for v in fmu_variables(rich_scene, ports))
    assert "<td>displacement of tower 1 upwards, reached at the end of a step" in page


WRONG_PORTS = {
    "a span": ({"wind": "tower"}, "wind = 'tower': must be 'line' or 'span'"),
    "end": ({"stations": (0.5, 1.0)}, "station 2 is 1; it must be between 0 and 1"),
    "not a number": ({"stations": (math.nan,)}, "station 1 is nan; it must be between 0 and 1"),
    "many": ({"stations": (0.5,) * 101}, "stations: 101 given; at most 100 are allowed"),
}


@pytest.mark.parametrize("name", WRONG_PORTS)
def test_ports_that_do_not_exist_are_refused(single_scene, tmp_path, name):
    chosen, message = WRONG_PORTS[name]
    with pytest.raises(ExportError, match=re.escape(message)):
        export_fmu(single_scene, tmp_path / "no.fmu", **chosen)


def test_one_span_has_one_wind_and_may_have_stations(rigid_scene, tmp_path, host):
    with pytest.raises(ExportError, match="the scene is one span; omit it, or export a line"):
        export_fmu(rigid_scene, tmp_path / "no.fmu", wind="span")
    fmu = host(export_fmu(rigid_scene, tmp_path / "one.fmu", stations=(0.25, 0.5)))
    fmu.start().step(H, 2)
    assert fmu["station[2].x2"] == fmu["midspan.x2"] != fmu["station[1].x2"] != 0.0
    fmu["numerics.time_step"]  # references of parameters follow those of stations


def test_a_failure_is_reported_in_the_words_of_python(rich_scene, rich_fmu, host):
    """With span, phase, subconductor and element, or the tower."""
    fmu = host(rich_fmu)
    model = Model(rich_scene)
    speeds = np.array([4.1, 4.1, 0.0])
    state = model.start(0.0, Inputs(0.0, np.full(3, 4.1), math.radians(3.0), np.zeros((4, 3))))
    fmu.start()
    fmu["span[3].wind_speed"], fmu["tower[2].x2"] = 0.0, -60.0
    moves = np.zeros((TOWERS, 3))
    moves[2, 1] = -60.0
    still = np.zeros((TOWERS, 3))
    inputs = Inputs(0.0, speeds, math.radians(3.0), still, support_rate=moves / 5.0)
    with pytest.raises(SimulationError) as python:
        state.advance(5.0, inputs)
    with suppress(Exception):
        fmu.step(5.0)
    words = str(python.value)
    assert re.search(
        r" in span [23], phase [12], subconductor [12], element [1-5] of [4-6] ", words
    )
    assert f"the step could not be carried out: a{words[1:]}".replace("%", " percent") in fmu.log
