"""Lines in the kernel's tables, and the map of their parts."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CChain, CCrossSection, CDevice
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.pack import Packed
from gallop_fmu.scene.stations import elements_of_parts
from support.sections import POST, STRING, section

QUAD = {"subconductors": 4, "spacing": 0.45, "spacers": 2}


def quad(**more):
    """Two spans of a quad bundle in two phases."""
    phases = [{"name": "a", "offset": [0.0, -4.0]}, {"name": "b", "offset": [1.0, 4.0]}]
    return section((300.0, 350.0), bundle=QUAD, phases=phases, **more)


def kinds(packed):
    return [device.kind for device in packed.tables["device"]]


def test_elements_are_shared_out_by_length():
    assert elements_of_parts((0.0, 1.0), 15) == (0, 15)
    assert elements_of_parts((0.0, 0.25, 0.5, 0.75, 1.0), 16) == (0, 4, 8, 12, 16)
    assert elements_of_parts((0.0, 0.01, 1.0), 10) == (0, 1, 11)
    equal = elements_of_parts(tuple(k / 7 for k in range(8)), 15)
    assert equal == tuple(2 * k for k in range(8))
    mirrored = elements_of_parts((0.0, 0.35, 0.65, 1.0), 10)
    assert np.diff(mirrored).tolist() == np.diff(mirrored).tolist()[::-1]


def test_every_subconductor_of_every_span_is_a_chain():
    packed = Packed(quad())
    numbers = [(c.span, c.phase, c.subconductor) for c in packed.map.chains]
    assert numbers == [(s, p, k) for s in (1, 2) for p in (1, 2) for k in (1, 2, 3, 4)]
    assert packed.map.nodes == sum(2 * c.elements + 1 for c in packed.tables["chain"])
    assert packed.map.chain(2, 2, 3).first_node == packed.map.chain(2, 2, 2).nodes.stop


def test_joined_junctions_are_close_in_the_table():
    packed = Packed(quad())
    found = 0
    for chain in packed.map.chains:
        along = [j for j in chain.junctions if j >= 0]
        assert along == sorted(along)
        found = max(found, *np.diff(along))
    for device in packed.tables["device"]:
        own = device.junction[: device.junctions]
        found = max(found, max(own) - min(own))
    assert found == 2 * 4  # phases times subconductors


def test_positions_add_up_spans_heights_phases_and_subconductors():
    scene = section(
        (300.0, 350.0), POST, bundle=QUAD, phases=[{"name": "a", "offset": [1.0, 4.0]}]
    ).with_values({"section.spans.0.height_difference": 12.0})
    packed = Packed(scene)
    first = packed.map.tower(1).junctions[0]
    assert packed.tables["junction"][first].position[:] == pytest.approx(
        [300.0, 12.0 + 1.0 + 0.225, 4.0 - 0.225]
    )


def test_a_bundle_hangs_from_yokes_and_has_spacers():
    packed = Packed(quad())
    assert kinds(packed) == [5, 5, *[4] * 8]  # two yokes, two spacers in two spans, two phases
    yoke, tower = packed.tables["device"][0], packed.map.tower(1, 1)
    assert yoke.junction[:4] == list(tower.junctions)
    assert yoke.parameter[5:9] == [2.4, 600.0, 1e7, 3e4]
    spacer = packed.map.spacers[-1]
    assert (spacer.span, spacer.phase, spacer.number) == (2, 2, 2)
    own = packed.tables["device"][spacer.device]
    assert own.junction[:4] == list(spacer.junctions)
    assert own.parameter[:5] == [0.0, 1e7, 1e4, 500.0, 0.0]


def test_strings_of_a_single_conductor_fix_its_twist_unless_the_clamp_turns():
    fixed = Packed(section()).tables["junction"][1].fixed[:]
    turning = {**STRING, "clamp_torsional_stiffness": 80.0}
    packed = Packed(section(suspension=turning))
    assert fixed == [0, 0, 0, 1]
    assert packed.tables["junction"][1].fixed[:] == [0, 0, 0, 0]
    assert packed.tables["device"][0].parameter[4] == 80.0


def test_an_end_string_points_along_its_pull_at_the_tower():
    end = {"kind": "string", "length": 3.0, "weight": 500.0}
    scene = section(section={"right_end": end})
    packed = Packed(scene)
    last, string = packed.tables["junction"][-1], packed.tables["device"][-1]
    to_tower = string.parameter[5:7]
    assert math.hypot(*to_tower) == pytest.approx(3.0)
    assert last.position[0] + to_tower[0] == pytest.approx(930.0)
    assert last.position[1] + to_tower[1] == pytest.approx(0.0, abs=1e-12)
    pull = 0.5 * 280.0 * 1.628 * 9.81 + 0.5 * 500.0  # down, with half of the string
    assert to_tower[1] / to_tower[0] == pytest.approx(pull / 25e3, rel=0.02)
    assert "section.horizontal_tension" not in packed.places


def test_an_interval_has_its_own_cross_section():
    bare = {"kind": "interval", "span": 1, "from_station": 0.25, "to_station": 0.75, "ice": "none"}
    ice = {"mass_per_length": 0.8, "torsional_inertia": 1e-4}
    packed = Packed(section(suspension=POST, ice=ice, devices=[bare]))
    tables = packed.tables
    assert [item.cross_section for item in tables["station"]] == [1, 0]
    assert [item.junction for item in tables["station"]] == [-1, -1]
    assert [item.ice_mass for item in tables["cross_section"]] == [0.8, 0.0]
    assert packed.map.devices == ((),)


def test_an_interval_that_starts_at_the_end_of_a_span_is_the_chains_cross_section():
    bare = {"kind": "interval", "span": 2, "from_station": 0.0, "to_station": 0.5, "ice": "none"}
    packed = Packed(section(suspension=POST, ice={"mass_per_length": 0.8}, devices=[bare]))
    assert [chain.cross_section for chain in packed.tables["chain"]] == [0, 1, 0]
    assert [item.cross_section for item in packed.tables["station"]] == [0]


def test_devices_are_on_each_phase_and_subconductor_unless_one_is_given():
    pendulum = {"kind": "pendulum", "span": 1, "station": 0.5, "mass": 8.0, "arm": 0.5}
    one = {"kind": "mass", "span": 2, "station": 1 / 3, "mass": 3.0, "phase": 2, "subconductor": 1}
    spacer = {"kind": "interphase_spacer", "span": 2, "station": 0.5, "phases": [1, 2]}
    packed = Packed(quad(devices=[{**pendulum, "angle_deg": 90.0}, one, spacer]))
    assert [len(items) for items in packed.map.devices] == [8, 1, 1]
    device = packed.tables["device"]
    first, mass, bar = (device[items[0]] for items in packed.map.devices)
    assert (first.kind, *first.parameter[:3]) == (7, 8.0, 0.5, pytest.approx(math.pi / 2))
    assert mass.junction[0] == packed.map.spacers[5].junctions[0]  # at the spacer's station
    ends = [packed.map.chain(2, phase, 1) for phase in (1, 2)]
    assert bar.junction[:2] == [end.junctions[end.fractions.index(0.5)] for end in ends]


def test_a_hanging_mass_has_a_node_of_its_own():
    damper = {"kind": "damper", "span": 1, "station": 0.4, "damping": 9.0, "axis": "x2"}
    hanging = {**damper, "hanging_mass": 5.0, "hanging_stiffness": 800.0}
    packed = Packed(section(suspension=POST, devices=[hanging]))
    assert kinds(packed) == [8, 6]
    (body,) = packed.map.bodies
    assert packed.tables["device"][0].junction[:2] == [body - 1, body]
    assert packed.tables["device"][0].parameter[:6] == [0.0, 9.0, 0.0, 800.0, 800.0, 800.0]
    assert packed.map.node_of_junction[body] == packed.map.nodes - 1
    assert np.isnan(packed.map.labels["station"][-1])
    ground = Packed(section(suspension=POST, devices=[damper]))
    assert (kinds(ground), ground.map.bodies) == ([8], ())


def test_loads_are_on_each_conductor_of_their_span_unless_one_is_given():
    force = {"force": [0.0, -100.0, 0.0], "position": 0.5}
    packed = Packed(quad(loads=[{**force, "span": 2}, {**force, "span": 1, "subconductor": 3}]))
    chains = [load.chain for load in packed.tables["load"]]
    assert chains == [*range(8, 16), 2, 6]
    assert len({load.law for load in packed.tables["load"]}) == 2


def test_a_value_is_noted_at_every_place_where_it_is_stored():
    own = {"mass_per_length": 1.0}
    packed = Packed(section().with_values({"section.spans.1.ice": own}))
    mass = packed.places["conductor.mass_per_length"]
    assert [(place.table, place.item) for place in mass] == [
        ("cross_section", 0),
        ("cross_section", 1),
    ]
    assert {place.offset for place in mass} == {CCrossSection.mass.offset}
    (ice,) = packed.places["section.spans.1.ice.mass_per_length"]
    assert (ice.item, ice.offset) == (1, CCrossSection.ice_mass.offset)
    tension = packed.places["section.horizontal_tension"]
    assert [place.item for place in tension] == [0, 1, 2]
    assert {place.offset for place in tension} == {CChain.horizontal_tension.offset}
    (weight,) = packed.places["section.suspensions.1.weight"]
    assert (weight.table, weight.item) == ("device", 1)
    assert weight.offset == CDevice.parameter.offset + 8


def test_the_model_has_the_nodes_of_the_map():
    model = Model(section(suspension=POST, bundle={**QUAD, "spacers": 0}))
    x, junctions = model.equilibrium().x, Packed(model.scene).tables["junction"]
    for junction, node in enumerate(model.map.node_of_junction):
        assert x[node] == pytest.approx(junctions[junction].position[:], abs=1e-9)
    middle = model.map.chain(2, 1, 4)
    assert x[middle.middle][0] == pytest.approx(300.0 + 175.0, abs=1e-6)
    assert model.map.labels["station"][middle.middle] == pytest.approx(0.5)


def test_stations_lie_where_the_map_says():
    """Nodes between two stations are equally spaced along the conductor, in the strung state."""
    load = {"kind": "interval", "span": 1, "from_station": 0.2, "to_station": 0.3, "ice": "none"}
    scene = section((300.0,), POST, devices=[load], numerics={"elements": 40})
    model = Model(scene)
    x, chain = model.equilibrium().x, model.map.chain(1)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
    assert length / length[-1] == pytest.approx(chain.stations, abs=2e-6)  # chords: 6e-7 seen


@pytest.mark.parametrize(("name", "numbers"), [("span", (3, 1, 1)), ("phase", (1, 0, 1))])
def test_a_number_that_the_line_does_not_have_is_refused(name, numbers):
    with pytest.raises(IndexError, match=rf"{name} [03] does not exist; give a number from 1 to"):
        Packed(quad()).map.chain(*numbers)


def test_the_map_of_one_span_is_that_of_a_line_of_one_span():
    mapped = Model(gf.load_scene("example2")).map
    assert (mapped.spans, mapped.phases, mapped.subconductors) == (1, 1, 1)
    assert mapped.chain(1).middle == mapped.elements
    assert [tower.kind for tower in mapped.towers] == ["springs", "springs"]
    assert [tower.devices for tower in mapped.towers] == [(0,), (1,)]


def test_a_failure_is_placed_by_the_parts_of_the_line():
    parts = Packed(
        section(
            bundle={"subconductors": 2, "spacing": 0.4},
            phases=[{"name": "a"}, {"name": "b", "offset": [0.0, 8.0]}],
        )
    ).map
    chain = parts.chain(2, 1, 2)
    assert parts.place_of(chain.first_element + 3, None) == (
        f"in span 2, phase 1, subconductor 2, element 4 of {chain.elements}"
    )
    assert parts.place_of(None, parts.tower(2, 2).devices[0]) == "at tower 2, phase 2"
    assert parts.place_of(None, None) is None
    assert Packed(gf.load_scene("example1")).map.place_of(3, None) is None


def test_a_tower_where_the_conductor_pulls_up_is_named():
    spans = [{"length": 300.0}, {"length": 300.0, "height_difference": -60.0}]
    spans.append({"length": 300.0, "height_difference": 60.0})
    with pytest.raises(gf.SimulationError, match=r"at tower 2 no static .* pull of a string \[N\]"):
        Model(section(section={"spans": spans}))


def inclined_pendulum(angle_deg):
    pendulum = {"kind": "pendulum", "span": 1, "station": 0.5, "mass": 20.0, "arm": 0.5}
    return section(lengths=(300.0, 300.0), devices=[{**pendulum, "angle_deg": angle_deg}])


@pytest.mark.parametrize("angle_deg", [30.0, 90.0, 179.0])
def test_a_pendulum_turns_the_conductor_until_it_hangs(angle_deg):
    """Moment of its weight against torsion, 4 GJ / L; the conductor does not wind itself up."""
    model = Model(inclined_pendulum(angle_deg))
    turn = model.start().motion()[0][model.map.chain(1).middle, 3]
    moment = 20.0 * 9.81 * 0.5 * math.sin(math.radians(angle_deg) - turn)
    assert 0.0 < turn < math.radians(angle_deg)
    assert moment == pytest.approx(4.0 * 159.0 / 300.0 * turn, rel=2e-3)


def test_a_pendulum_that_stands_upright_is_refused_at_its_place():
    with pytest.raises(gf.SimulationError, match=r"in span 1, element [56] .* would be unstable"):
        Model(inclined_pendulum(180.0))
