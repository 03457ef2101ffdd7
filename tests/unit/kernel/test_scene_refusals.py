"""The kernel refuses scenes that no binding would pass, and names the number."""

import ctypes as c
import math

import pytest

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CLoad, CReport
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.pack import Packed
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.scene.consistency import SAG_TENSION_AGREEMENT


def outcome_of(change):
    """Outcome and field of a model of example 3 that was changed after it was validated."""
    packed, report, handle = Packed(gf.load_scene("example3")), CReport(), c.c_void_p()
    kept = change(packed.scene)
    code = kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(report))
    assert code == report.outcome
    assert (handle.value is None) == (code != 0), kept
    if handle.value is not None:
        kernel.gallop_model_free(handle)
    return Outcome.from_code(code), (report.field or b"").decode()


def assign(table, field, value, index=None):
    """Change that sets a field of the first item of a table, or one number of an array."""

    def change(scene):
        item = scene.settings if table == "settings" else getattr(scene, table)[0]
        if index is None:
            setattr(item, field, value)
        else:
            getattr(item, field)[index] = value

    return change


def wind_table(count, times, values):
    """Change that makes the wind a table of times and values."""

    def change(scene):
        law, curve = scene.law[scene.field[0].law], scene.curve[0]
        numbers = [scene.number[i] for i in range(scene.number_count)]
        array = (c.c_double * (len(numbers) + 4))(*numbers, *times, *values)
        law.kind, law.count, law.first = 3, count, len(numbers)
        scene.number, scene.number_count = array, len(array)
        return array, curve

    return change


def varied(*numbers, **fields):
    """Change that makes the wind a varied field; `numbers` are those of its ground or gusts."""

    def change(scene):
        field = scene.field[0]
        all_numbers = [scene.number[i] for i in range(scene.number_count)]
        field.kind, field.direction = 1, -1
        field.first_ground = field.first_gust = len(all_numbers)
        for name, value in fields.items():
            setattr(field, name, value)
        array = (c.c_double * (len(all_numbers) + len(numbers)))(*all_numbers, *numbers)
        scene.number, scene.number_count = array, len(array)
        return array

    return change


def number(offset, value):
    """Change of one number of the curve, counted from its first breakpoint."""

    def change(scene):
        scene.number[scene.curve[0].first + offset] = value

    return change


def loaded(**numbers):
    """Change that adds a load."""

    def change(scene):
        load = (CLoad * 1)()
        for name, value in numbers.items():
            setattr(load[0], name, value)
        scene.load, scene.load_count = load, 1
        return load

    return change


def test_the_scene_itself_is_allowed():
    assert outcome_of(lambda scene: None) == (Outcome.COMPLETED, "")
    assert outcome_of(wind_table(2, [0.0, 1.0], [5.0, 6.0])) == (Outcome.COMPLETED, "")
    assert outcome_of(loaded(position=0.5)) == (Outcome.COMPLETED, "")
    assert outcome_of(varied(direction=0)) == (Outcome.COMPLETED, "")
    gusts = varied(5.0, 0.0, 1.0, 0.1, -0.1, stations=1, times=2, components=1, repeat=1)
    assert outcome_of(gusts) == (Outcome.COMPLETED, "")
    sheared = varied(0.0, -9.0, profile=1, reference_height=10.0, ground_points=1)
    assert outcome_of(sheared) == (Outcome.COMPLETED, "")


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_sag_and_tension_may_differ_as_much_as_in_a_scene(side):
    def with_difference(part):
        def change(scene):
            section, chain = scene.cross_section[0], scene.chain[0]
            length = scene.junction[chain.junction[1]].position[0]
            weight = (section.mass + section.ice_mass) * scene.settings.gravity
            parabola = weight * length**2 / (8.0 * chain.horizontal_tension)
            chain.sag = parabola * (1.0 + side * part * SAG_TENSION_AGREEMENT)

        return outcome_of(change)

    assert with_difference(0.999) == (Outcome.COMPLETED, "")
    contradicts = "sag, which contradicts the horizontal tension"
    assert with_difference(1.001) == (Outcome.INVALID_SCENE, contradicts)


NUMBERS = {
    ("cross_section", "attack_angle"): "attack angle",
    ("settings", "air_density"): "density of air",
    ("cross_section", "reference_radius"): "reference radius",
    ("settings", "seed_twist"): "seed of the twist",
    ("cross_section", "first_moment_x3"): "first mass moment of the ice",
    ("settings", "tolerance"): "tolerance",
    ("chain", "sag"): "sag",
}


@pytest.mark.parametrize("place", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_numbers_that_are_not_finite(place, value):
    """Before, a NaN attack angle without a curve gave a state that was reported as complete."""
    assert outcome_of(assign(*place, value)) == (Outcome.INVALID_SCENE, NUMBERS[place])


CASES = {
    "law": (lambda s: setattr(s.law[s.field[0].law], "kind", 7), "wind speed"),
    "motion": (
        lambda s: (
            s.junction[1].motion.__setitem__(2, 0),
            setattr(s.law[0], "initial", math.nan),
            setattr(s.field[0], "law", 0),
        ),
        "wind speed",
    ),
    "motion index": (assign("junction", "motion", 9, 2), "motion of a support"),
    "no points": (wind_table(-1, [0.0, 1.0], [5.0, 6.0]), "wind speed"),
    "too many points": (wind_table(3, [0.0, 1.0], [5.0, 6.0]), "wind speed"),
    "order": (wind_table(2, [0.0, 0.0], [5.0, 6.0]), "wind speed"),
    "value": (wind_table(2, [0.0, 1.0], [5.0, math.nan]), "wind speed"),
    "field": (assign("field", "kind", 2), "kind of a field of wind"),
    "direction": (varied(direction=9), "direction of the wind"),
    "profile": (varied(profile=3), "profile of the wind"),
    "exponent": (varied(profile=1, profile_parameter=-0.1), "exponent of the wind profile"),
    "roughness": (
        varied(profile=2, reference_height=10.0),
        "roughness length of the wind profile",
    ),
    "reference height": (
        varied(profile=2, profile_parameter=0.1, reference_height=0.1),
        "reference height of the wind profile",
    ),
    "no ground": (varied(profile=1, reference_height=10.0), "number of points of the ground"),
    "ground": (
        varied(0.0, 0.0, -9.0, -9.0, profile=1, reference_height=10.0, ground_points=2),
        "x1 of a point of the ground",
    ),
    "height of the ground": (
        varied(0.0, 1.0, -9.0, math.inf, profile=1, reference_height=10.0, ground_points=2),
        "height of a point of the ground",
    ),
    "below the ground": (
        varied(0.0, -1.0, profile=1, reference_height=10.0, ground_points=1),
        "height of a conductor above ground, for the wind profile",
    ),
    "stations": (varied(stations=-1), "number of stations of gusts"),
    "no times": (varied(stations=1, components=1), "number of times of gusts"),
    "components": (varied(stations=1, times=1, components=2), "number of components of a gust"),
    "repeat": (varied(stations=1, times=1, components=1, repeat=1), "whether gusts repeat"),
    "too many gusts": (
        varied(stations=100, times=1000000, components=3),
        "number of gusts",
    ),
    "station order": (
        varied(5.0, 5.0, 0.0, 0.1, 0.1, stations=2, times=1, components=1),
        "station of gusts",
    ),
    "time order": (
        varied(5.0, 1.0, 0.0, 0.1, 0.1, stations=1, times=2, components=1),
        "time of gusts",
    ),
    "gust": (
        varied(5.0, 0.0, 1.0, 0.1, math.nan, stations=1, times=2, components=1),
        "gust",
    ),
    "no support": (assign("junction", "fixed", 0, 0), "stiffness of a support"),
    "not a flag": (assign("junction", "fixed", 2, 0), "what is fixed at a junction"),
    "free to twist": (assign("junction", "fixed", 0, 3), "stiffness of a support"),
    "curve index": (assign("cross_section", "curve", 1), "aerodynamic curve of a conductor"),
    "conductor": (assign("chain", "cross_section", 1), "conductor of a span"),
    "end": (assign("chain", "junction", -1, 0), "end of a span"),
    "one end": (assign("chain", "junction", 0, 1), "length of the span"),
    "across": (
        lambda s: s.junction[1].position.__setitem__(2, 1.0),
        "place of the end of a span across the line",
    ),
    "no curve": (lambda s: setattr(s, "curve_count", -1), "number of items of scene.curve"),
    "outside": (assign("curve", "outside", -1), "what holds outside the aerodynamic curve"),
    "pieces": (assign("curve", "pieces", 0), "number of pieces of the aerodynamic curve"),
    "first": (assign("curve", "first", -1), "breakpoint of the aerodynamic curve"),
    "breakpoint": (number(0, 10.0), "breakpoint of the aerodynamic curve"),
    "origin": (number(2, math.nan), "origin of an aerodynamic piece"),
    "coefficient": (number(3 + 11, math.inf), "aerodynamic coefficient"),
    "slack": (assign("cross_section", "slack", 2), "what follows where a conductor is slack"),
    "loads": (lambda s: setattr(s, "load_count", -1), "number of items of scene.load"),
    "load's span": (loaded(chain=1), "span of a load"),
    "load's law": (loaded(law=-1), "history of a load"),
    "evenly": (loaded(evenly_spaced=-2), "number of evenly spaced loads"),
    "points": (loaded(evenly_spaced=2_000_000_000), "number of loaded points"),
    "position": (loaded(position=1.5), "position of a load"),
    "torque": (loaded(position=0.5, torque=math.nan), "torque of a load"),
}


@pytest.mark.parametrize("name", CASES)
def test_tables_that_cannot_be_read(name):
    change, field = CASES[name]
    assert outcome_of(change) == (Outcome.INVALID_SCENE, field)


DEVICES = {
    "kind": (lambda d: setattr(d, "kind", 10), "kind of a device"),
    "junction": (lambda d: d.junction.__setitem__(0, 2), "junction of a device"),
    "second junction": (lambda d: d.junction.__setitem__(1, 1), "junction of a device"),
    "junctions": (lambda d: setattr(d, "junctions", 2), "number of junctions of a device"),
    "stiffness": (lambda d: d.parameter.__setitem__(0, -1.0), "stiffness of a support"),
    "no stiffness": (lambda d: d.parameter.__setitem__(2, 0.0), "stiffness of a support"),
    "parameter": (lambda d: d.parameter.__setitem__(11, math.nan), "parameter of a device"),
}


@pytest.mark.parametrize("name", DEVICES)
def test_devices_that_cannot_be(name):
    springs = {"kind": "springs", "stiffness_x1": 1e4, "stiffness_x3": 1e3}
    scene = gf.load_scene("example3").with_values({"supports.left": springs})
    packed, report, handle = Packed(scene), CReport(), c.c_void_p()
    change, field = DEVICES[name]
    change(packed.scene.device[0])
    code = kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(report))
    assert (Outcome.from_code(code), report.field.decode()) == (Outcome.INVALID_SCENE, field)
    assert handle.value is None
