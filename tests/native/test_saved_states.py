"""Saved states that are refused: of another FMU or version, corrupt, forged, or none."""

import ctypes as c
import math
import struct

import numpy as np
import pytest

from support.checksum import fnv1a
from support.refused_calls import ERROR, H, refused


@pytest.fixture
def fmu(small, instance):
    return instance(small)


@pytest.fixture
def stepping(fmu):
    return fmu.start().step(H, 3)


def test_the_state_of_another_fmu(fmu, unpack, instance, small_scene):
    other = instance(unpack(small_scene.with_values({"span.gravity": 9.8}))).start()
    content = other.to_bytes(other.save())
    fmu.start()
    refused(fmu, lambda: fmu.from_bytes(content)[0], "of another FMU")
    assert fmu.restore(other.save()) == ERROR


def test_the_state_of_another_version_is_refused_by_its_format(stepping):
    """The last letter of the magic is the format: a state of release 0.2.0 has another."""
    good = stepping.to_bytes(stepping.save())
    assert good.startswith(b"GALLOPF")
    other = good[:7] + bytes([good[7] - 1]) + good[8:]
    remedy = (
        "in the format of another version of gallop-fmu; use states of this version, or the FMU"
    )
    refused(stepping, lambda: stepping.from_bytes(other)[0], remedy)


def test_corrupt_bytes_of_a_state(stepping):
    good = stepping.to_bytes(stepping.save())
    for at in np.unique(np.geomspace(1, len(good), 200).astype(int) - 1):
        bad = bytearray(good)
        bad[at] ^= 1 << (at % 8)
        refused(stepping, lambda bad=bad: stepping.from_bytes(bytes(bad))[0], "the bytes are")
    for content in (b"", good[:-1], good[:300], good + b"\0", b"from another tool" * 99):
        refused(stepping, lambda content=content: stepping.from_bytes(content)[0], "the bytes are")


RUN = 8 + 8 + 8 + 64
"""Bytes of a state before its phase: magic, size, checksum, identity."""
COUNTS = RUN + 8 + 3 * 8
"""Bytes before its counts: phase and outcome, three times."""
ARRAYS = 5
"""Numbers of an input: value, rate, reached place, trend, given; now and of the last step."""

PARTS = ["mode", "time", "wind", "number of inputs", "parameter", "kernel's magic", "kernel's size"]


@pytest.mark.parametrize("part", [*PARTS, "motion", "motion before the step"])
def test_forged_bytes_of_a_state(stepping, part):
    """The checksum is right, but no such state is possible."""
    good = stepping.to_bytes(stepping.save())
    inputs, parameters, kernel, before = struct.unpack_from("<QQQQ", good, COUNTS)
    first_input = COUNTS + 8 * 8
    values = first_input + 2 * ARRAYS * 8 * inputs
    first = values + 8 * parameters
    assert first + kernel + before == len(good)
    assert kernel == before
    bad = bytearray(good)
    match part:
        case "mode":
            struct.pack_into("<i", bad, RUN, 3)
        case "time" | "wind":
            struct.pack_into("<d", bad, first_input if part == "wind" else RUN + 8, math.nan)
        case "number of inputs":
            struct.pack_into("<Q", bad, COUNTS, 2**61)
        case "parameter":
            struct.pack_into("<d", bad, values, -1.0)
        case "kernel's magic" | "kernel's size":
            bad[first + 8 * (part == "kernel's size")] ^= 1
        case "motion" | "motion before the step":
            at = first + kernel * (part != "motion")
            struct.pack_into("<d", bad, at + kernel // 64 * 8, math.nan)
    struct.pack_into("<Q", bad, 16, fnv1a(bad[24:]))

    def take():
        status, state = stepping.from_bytes(bytes(bad))
        return status or stepping.restore(state)

    refused(stepping, take, "")
    assert stepping.from_bytes(good)[0] == 0


def test_a_state_that_cannot_be_built_leaves_the_instance_as_it_is(stepping):
    """Other parameters, which make no span, with a state: the present span is kept."""
    good = stepping.to_bytes(stepping.save())
    inputs, parameters = struct.unpack_from("<QQ", good, COUNTS)
    values = COUNTS + 8 * 8 + 2 * ARRAYS * 8 * inputs
    numbers = struct.unpack_from(f"<{parameters}d", good, values)
    bad = bytearray(good)
    struct.pack_into("<d", bad, values + 8 * numbers.index(15000.0), 30000.0)  # against the sag
    struct.pack_into("<Q", bad, 16, fnv1a(bad[24:]))
    status, state = stepping.from_bytes(bytes(bad))
    assert status == 0
    refused(stepping, lambda: stepping.restore(state), "do not make a span")
    stepping.step(H)


@pytest.mark.parametrize("call", ["SetFMUstate", "SerializedFMUstateSize", "SerializeFMUstate"])
def test_pointers_that_are_no_saved_state_are_refused(stepping, call):
    """Null, foreign and misaligned pointers; their size was once trusted."""
    junk, room, size = c.create_string_buffer(4096), c.create_string_buffer(64), c.c_size_t()
    more = {
        "SetFMUstate": (),
        "SerializedFMUstateSize": (c.byref(size),),
        "SerializeFMUstate": (room, c.c_size_t(64)),
    }
    good = stepping.save()
    for pointer in (None, c.c_void_p(c.addressof(junk)), c.c_void_p(good.value + 4)):
        refused(stepping, lambda state=pointer: stepping.call(call, state, *more[call]), "state")
