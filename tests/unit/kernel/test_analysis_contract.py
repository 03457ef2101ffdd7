"""The contract of the kernel's functions for analyses: refusals, and what may be left out."""

import ctypes as c
import math

import numpy as np
import pytest

from support.c_span import BAD_CALL, FUNCTIONS, UNTOUCHED, kernel


@pytest.mark.parametrize("factor", ["k", "c", "m"])
def test_residual_and_tangent_want_finite_numbers(span, factor):
    tangent = FUNCTIONS["gallop_tangent"]
    assert span.call("gallop_tangent", tangent, {}) == 0
    assert span.call("gallop_tangent", tangent, {factor: c.c_double(math.nan)}) == BAD_CALL
    span.motion[1][5] = math.inf
    assert span.call("gallop_tangent", tangent, {}) == BAD_CALL
    assert span.call("gallop_residual", FUNCTIONS["gallop_residual"], {}) == BAD_CALL


def test_free_unknowns_need_an_array_of_integers(span):
    is_free = np.full(4 * span.model.nodes, -1, np.int32)
    place = is_free.ctypes.data
    for model, pointer in ((None, place), (span.handle, None), (span.handle, place + 1)):
        assert kernel.gallop_free_unknowns(model, c.c_void_p(pointer)) == BAD_CALL
    assert (is_free == -1).all()
    assert kernel.gallop_free_unknowns(span.handle, c.c_void_p(place)) == 0
    assert set(is_free) == {0, 1}


def test_junction_nodes_need_arrays_of_integers(span):
    node, leader = (np.full(n, -1, np.int32) for n in (2, span.model.nodes))
    places = [node.ctypes.data, leader.ctypes.data]
    for model, first, second in (
        (None, *places),
        (span.handle, None, places[1]),
        (span.handle, places[0] + 2, places[1]),
        (span.handle, places[0], None),
        (span.handle, places[0], places[1] + 1),
    ):
        pointers = [c.c_void_p(place) for place in (first, second)]
        assert kernel.gallop_junction_nodes(model, *pointers) == BAD_CALL
    assert (node == -1).all()
    assert (leader == -1).all()
    assert kernel.gallop_junction_nodes(span.handle, *map(c.c_void_p, places)) == 0
    assert node.tolist() == [0, span.model.nodes - 1]
    assert leader.tolist() == list(range(span.model.nodes))


@pytest.mark.parametrize("name", ["gallop_device_force", "gallop_device_tangent"])
def test_a_device_is_one_of_the_scene(span, name):
    for device in (-1, 2):
        change = {"element": c.c_int32(device)}
        assert span.call(name, FUNCTIONS[name], change) == BAD_CALL
    assert (span.out == UNTOUCHED).all()
    assert span.call(name, FUNCTIONS[name], {"element": c.c_int32(1)}) == 0


def test_the_energy_of_a_device_may_be_left_out(span):
    force = FUNCTIONS["gallop_device_force"]
    assert span.call("gallop_device_force", force, {"slopes": c.c_void_p(12)}) == BAD_CALL
    assert span.call("gallop_device_force", force, {}) == 0
    assert (span.out[24:26] != UNTOUCHED).all()
    span.out[24:26] = UNTOUCHED
    assert span.call("gallop_device_force", force, {"slopes": None}) == 0
    assert (span.out[24:26] == UNTOUCHED).all()


@pytest.mark.parametrize(
    "change",
    [
        {"element": c.c_int32(2)},
        {"count": c.c_int32(-1)},
        {"slopes": None},
        {"slopes": c.c_void_p(12)},
        "u",
        "v",
    ],
)
def test_loads_of_a_device_want_its_arrays(span, change):
    load = FUNCTIONS["gallop_device_load"]
    if isinstance(change, str):
        span.motion["uv".index(change)][7] = math.nan
        change = {}
    assert span.call("gallop_device_load", load, change) == BAD_CALL
    assert (span.out == UNTOUCHED).all()


def test_a_device_has_the_load_of_as_many_motions_as_are_given(span):
    load = FUNCTIONS["gallop_device_load"]
    assert span.call("gallop_device_load", load, {"count": c.c_int32(0)}) == 0
    assert (span.out == UNTOUCHED).all()
    assert span.call("gallop_device_load", load, {}) == 0
    written = np.flatnonzero(span.out != UNTOUCHED)
    assert written.tolist() == [*range(8), *range(24, 56), *range(72, 104)]


@pytest.mark.parametrize("factor", ["k", "c", "m"])
def test_the_tangent_of_a_device_wants_finite_numbers(span, factor):
    tangent = FUNCTIONS["gallop_device_tangent"]
    assert span.call("gallop_device_tangent", tangent, {factor: c.c_double(math.nan)}) == BAD_CALL
    span.motion[1][5] = math.inf
    for name in ("gallop_device_force", "gallop_device_tangent"):
        assert span.call(name, FUNCTIONS[name], {}) == BAD_CALL


AERO = FUNCTIONS["gallop_aero_load"]


def test_a_load_is_computed_with_and_without_slopes(span):
    span.motion[0][8:10] = 5.0  # the wind speed of two sections
    assert span.call("gallop_aero_load", AERO, {}) == 0
    assert (span.out[:6] != UNTOUCHED).all()
    assert (span.out[24:48] != UNTOUCHED).all()
    span.out[24:48] = UNTOUCHED
    assert span.call("gallop_aero_load", AERO, {"slopes": None}) == 0
    assert (span.out[24:48] == UNTOUCHED).all()
    assert span.call("gallop_aero_load", AERO, {"count": c.c_int32(0)}) == 0


@pytest.mark.parametrize(
    "change",
    [
        {"count": c.c_int32(-1)},
        {"angle": c.c_double(math.nan)},
        {"slopes": c.c_void_p(12)},
        {"element": c.c_int32(-1)},
        {"element": c.c_int32(4)},
    ],
    ids=["count", "angle", "slopes", "element", "element beyond the last"],
)
def test_a_load_is_refused_for_arguments_out_of_range(span, change):
    assert span.call("gallop_aero_load", AERO, change) == BAD_CALL
    assert (span.out == UNTOUCHED).all()
    span.motion[0][9] = math.inf
    assert span.call("gallop_aero_load", AERO, {}) == BAD_CALL
    assert (span.out == UNTOUCHED).all()
