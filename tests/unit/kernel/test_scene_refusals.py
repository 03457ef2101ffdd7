"""Scenes that no binding would pass: the kernel itself refuses them, and names the number."""

import ctypes as c
import math

import pytest

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CLoad, CReport
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.pack import Packed
from gallop_fmu.foundation.outcome import Outcome


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


def table(law, count, times, values):
    """Make a law a table; the arrays are returned to be kept."""
    arrays = [(c.c_double * len(numbers))(*numbers) for numbers in (times, values)]
    law.kind, law.count = 3, count
    law.time, law.value = (c.cast(array, c.POINTER(c.c_double)) for array in arrays)
    return arrays


def loaded(scene, **numbers):
    load = (CLoad * 1)()
    for name, value in numbers.items():
        setattr(load[0], name, value)
    scene.load, scene.load_count = c.cast(load, c.POINTER(CLoad)), 1
    return load


def test_the_scene_itself_is_allowed():
    assert outcome_of(lambda scene: None) == (Outcome.COMPLETED, "")
    assert outcome_of(lambda scene: table(scene.wind, 2, [0.0, 1.0], [5.0, 6.0])) == (
        Outcome.COMPLETED,
        "",
    )
    assert outcome_of(lambda scene: loaded(scene, position=0.5)) == (Outcome.COMPLETED, "")


NUMBERS = {
    "attack_angle": "attack angle",
    "air_density": "density of air",
    "reference_radius": "reference radius",
    "seed_twist": "seed of the twist",
    "first_moment_x3": "first mass moment of the ice",
    "tolerance": "tolerance",
}


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_numbers_that_are_none(name, value):
    """A NaN attack angle without a curve once gave a completed state."""
    assert outcome_of(lambda scene: setattr(scene, name, value)) == (
        Outcome.INVALID_SCENE,
        NUMBERS[name],
    )


CASES = {
    "law": (lambda s: setattr(s.wind, "kind", 7), "wind speed"),
    "motion": (
        lambda s: setattr(s.support[1].motion[2], "initial", math.nan),
        "motion of a support",
    ),
    "no points": (lambda s: table(s.wind, -1, [0.0, 1.0], [5.0, 6.0]), "wind speed"),
    "order": (lambda s: table(s.wind, 2, [0.0, 0.0], [5.0, 6.0]), "wind speed"),
    "value": (lambda s: table(s.wind, 2, [0.0, 1.0], [5.0, math.nan]), "wind speed"),
    "support": (lambda s: setattr(s.support[0], "kind", 3), "kind of a support"),
    "outside": (lambda s: setattr(s, "outside", -1), "what holds outside the aerodynamic curve"),
    "pieces": (lambda s: setattr(s, "pieces", -1), "number of pieces of the aerodynamic curve"),
    "breakpoint": (
        lambda s: s.breakpoint.__setitem__(0, 10.0),
        "breakpoint of the aerodynamic curve",
    ),
    "origin": (lambda s: s.origin.__setitem__(0, math.nan), "origin of an aerodynamic piece"),
    "coefficient": (lambda s: s.coefficient.__setitem__(11, math.inf), "aerodynamic coefficient"),
    "loads": (lambda s: setattr(s, "load_count", -1), "number of loads"),
    "evenly": (lambda s: loaded(s, evenly_spaced=-2), "number of evenly spaced loads"),
    "points": (lambda s: loaded(s, evenly_spaced=2_000_000_000), "number of loaded points"),
    "position": (lambda s: loaded(s, position=1.5), "position of a load"),
    "torque": (lambda s: loaded(s, position=0.5, torque=math.nan), "torque of a load"),
}


@pytest.mark.parametrize("name", CASES)
def test_tables_that_cannot_be_read(name):
    change, field = CASES[name]
    assert outcome_of(change) == (Outcome.INVALID_SCENE, field)
