"""The contract of the kernel's exported functions, as seen by a C caller: refusals, no effect.

Every call that cannot be carried out answers GALLOP_BAD_CALL, names the argument, fills in its
report and changes nothing.
"""

import ctypes as c
import math

import numpy as np
import pytest

from gallop_fmu.engine.ctypes_structs import (
    CDerived,
    CReport,
)
from gallop_fmu.engine.pack import Packed
from gallop_fmu.foundation.channels import NODE_CHANNELS
from gallop_fmu.foundation.outcome import Outcome
from support.c_span import (
    ADVANCE,
    BAD_CALL,
    FIELD,
    FUNCTIONS,
    JUNCTION,
    NODE,
    PROBES,
    SYSTEM,
    UNTOUCHED,
    Span,
    kernel,
)

UP, DOWN, TOWARDS_ZERO = 0x800, 0x400, 0xC00  # of fesetround on x86


@pytest.fixture(scope="module")
def other(scene):
    """A started span with a state of the same size."""
    return Span(scene.with_values({"wind.speed": 6.0})).started()


def assert_filled(report, span=None):
    """The whole report, with the work of the state or none."""
    assert report.outcome == BAD_CALL
    assert report.element == -1
    assert report.field
    assert report.steps >= 0
    if span is None:
        assert math.isnan(report.lowest_tension)
        assert report.steps == report.substeps == report.iterations == 0


NULL = {key: None for key in ("model", "state", "report")}
OUTPUTS = ("probe", "values", "out", "more", "most")
POINTERS = [
    (name, argument)
    for name, arguments in FUNCTIONS.items()
    for argument in arguments
    if argument in ("model", "state", "report", "u", "v", "a", *OUTPUTS)
]


@pytest.mark.parametrize(("name", "argument"), POINTERS)
def test_null_pointers_are_refused(span, name, argument):
    before = span.saved
    assert span.call(name, FUNCTIONS[name], {argument: None}) == BAD_CALL
    assert span.saved == before
    assert (span.values == UNTOUCHED).all()
    assert (span.out == UNTOUCHED).all()
    if "report" in FUNCTIONS[name] and argument != "report":
        assert_filled(span.report)


@pytest.mark.parametrize(("name", "argument"), POINTERS)
@pytest.mark.parametrize("shift", [1, 4])
def test_pointers_that_are_not_aligned_are_refused(span, name, argument, shift):
    place = {
        "model": span.handle.value,
        "state": span.state.value,
        "report": c.addressof(span.report),
        "probe": PROBES.ctypes.data,
        "values": span.values.ctypes.data,
        "out": span.out.ctypes.data,
        "more": span.out.ctypes.data + 48 * 8,
        "most": span.out.ctypes.data + 72 * 8,
    }.get(argument, span.motion[0].ctypes.data)
    before = span.saved
    assert span.call(name, FUNCTIONS[name], {argument: c.c_void_p(place + shift)}) == BAD_CALL
    assert span.saved == before


ONLY_SCRATCH = (
    *("gallop_state_init", "gallop_equilibrium", "gallop_state_place"),
    *("gallop_residual", "gallop_tangent"),
    *("gallop_device_force", "gallop_device_tangent"),
)


@pytest.mark.parametrize(
    "name", [name for name, arguments in FUNCTIONS.items() if "state" in arguments]
)
def test_a_state_of_another_model_is_refused(span, other, scene, name):
    """A state of another size, or of another scene; residual and tangent use scratch memory."""
    small = Span(scene.with_values({"numerics.elements": 2})).started()
    blank = np.zeros(len(span.block) + 1)
    for foreign in (small.state, other.state, c.c_void_p(blank.ctypes.data)):
        if name in ONLY_SCRATCH:
            continue
        assert span.call(name, FUNCTIONS[name], {"state": foreign}) == BAD_CALL
        if "report" in FUNCTIONS[name]:
            assert_filled(span.report)
            assert b"another model" in span.report.field


def test_models_of_the_same_scene_share_their_states(span, scene):
    twin = Span(scene)
    twin.block[:] = span.block
    assert twin.call("gallop_advance", ADVANCE, {}) == 0


@pytest.mark.parametrize("change", [
    {"wind.speed": 5.6}, {"aerodynamics.lift": [0.0, 1.0]}, {"aerodynamics.centre_deg": 181.0},
    {"aerodynamics.valid_to_deg": 261.0}, {"numerics.time_step": 0.02}, {"wind.speed": None,
     "wind.history": {"kind": "table", "time": [0.0, 1.0], "value": [5.5, 5.5]}},
    {"loads": [{"position": 0.5, "force": [0.0, 1.0, 0.0], "law": {"kind": "constant",
        "value": 1.0}}]},
])  # fmt: skip
def test_a_state_belongs_to_its_whole_scene(span, scene, change):
    changed = Span(scene.with_values(change))
    assert len(changed.block) == len(span.block)
    changed.block[:] = span.block
    assert changed.call("gallop_advance", ADVANCE, {}) == BAD_CALL


INPUT_NUMBERS = ["time", "attack_angle", "attack_angle_rate", "wind", "motion"]
ARRAYS = {"wind": "wind", "motion": "moves"}


@pytest.mark.parametrize("last", [0, -1])
@pytest.mark.parametrize("field", INPUT_NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_inputs_that_are_not_finite_are_refused_by_their_name(span, field, value, last):
    """Wind of NaN was once INVALID_SCENE: "a number of the scene is impossible"."""
    if field in ARRAYS:
        getattr(span, ARRAYS[field]).flat[last] = value  # a value, and a rate
    else:
        setattr(span.inputs, field, value)
    before = span.saved
    for name in ("gallop_advance", "gallop_state_init", "gallop_equilibrium"):
        assert span.call(name, FUNCTIONS[name], {}) == BAD_CALL
        assert_filled(span.report, span)
        assert span.report.field.decode() == f"inputs.{field}, which must be finite"
    assert span.call("gallop_residual", FUNCTIONS["gallop_residual"], {}) == BAD_CALL
    assert span.saved == before


def test_inputs_that_overflow_on_the_way_are_refused(span):
    span.wind[1] = 1e308
    assert span.call("gallop_advance", ADVANCE, {"until": c.c_double(100.0)}) == BAD_CALL
    assert span.report.field == b"inputs, whose rates lead to infinity"


WRONG_TABLES = {
    "fields": (0, "inputs.fields, which must be as many as the scene has"),
    "junctions": (3, "inputs.junctions, which must be 0 or as many as the scene has"),
    "wind": (None, "inputs.wind, a pointer that is null or not aligned to its type"),
    "motion": (None, "inputs.motion, a pointer that is null or not aligned to its type"),
}


@pytest.mark.parametrize("field", WRONG_TABLES)
def test_tables_of_inputs_must_fit_the_scene(span, field):
    value, message = WRONG_TABLES[field]
    setattr(span.inputs, field, value)
    assert span.call("gallop_advance", ADVANCE, {}) == BAD_CALL
    assert span.report.field.decode() == message


def test_towers_without_motion_are_at_rest(span, scene):
    twin = Span(scene).started()
    twin.inputs.junctions, twin.inputs.motion = 0, None
    for one in (span, twin):
        assert one.call("gallop_advance", ADVANCE, {}) == 0
    assert span.saved == twin.saved


@pytest.mark.parametrize("until", [0.0, -1.0, math.nan, math.inf, 1e300])
def test_times_that_cannot_be_reached_are_refused(span, until):
    before = span.saved
    assert span.call("gallop_advance", ADVANCE, {"until": c.c_double(until)}) == BAD_CALL
    assert_filled(span.report, span)
    assert span.saved == before


@pytest.mark.parametrize("time", [math.nan, math.inf])
def test_starts_that_are_not_finite_are_refused(span, time):
    for name in ("gallop_state_init", "gallop_equilibrium"):
        assert span.call(name, FUNCTIONS[name], {"time": c.c_double(time)}) == BAD_CALL
        assert span.report.field == b"time, which must be finite"


WRONG_PROBES = {
    "object": ((5, 0, 0, 0, 0.0), "object of a probe", 5),
    "negative object": ((-1, 0, 0, 0, 0.0), "object of a probe", -1),
    "node": ((NODE, -40, 0, 0, 0.0), "index of a probe", -40),
    "node beyond the last": ((NODE, 9, 0, 0, 0.0), "index of a probe", 9),
    "junction": ((JUNCTION, 2, 0, 0, 0.0), "index of a probe", 2),
    "field": ((FIELD, 2**31 - 1, 0, 0, 0.0), "index of a probe", 2**31 - 1),
    "system": ((SYSTEM, 1, 0, 0, 0.0), "index of a probe", 1),
    "channel of a node": ((NODE, 0, len(NODE_CHANNELS), 0, 0.0), "channel of a probe", 14),
    "channel of a junction": ((JUNCTION, 0, 3, 0, 0.0), "channel of a probe", 3),
    "channel of a field": ((FIELD, 0, 1, 0, 0.0), "channel of a probe", 1),
    "channel of the system": ((SYSTEM, 0, -1, 0, 0.0), "channel of a probe", -1),
    "station of a node": ((NODE, 0, 0, 0, 1.0), "station of a probe", 1.0),
    "station": ((FIELD, 0, 0, 0, math.inf), "station of a probe", math.inf),
}


@pytest.mark.parametrize("name", WRONG_PROBES)
def test_a_probe_that_does_not_exist_is_refused(span, name):
    row, field, value = WRONG_PROBES[name]
    probes = PROBES.copy()
    probes[-1] = row
    wrong = {"probe": c.c_void_p(probes.ctypes.data)}
    assert span.call("gallop_observe", FUNCTIONS["gallop_observe"], wrong) == BAD_CALL
    assert (span.values == UNTOUCHED).all()
    assert span.run(**wrong) == BAD_CALL
    assert (span.report.field.decode(), span.report.value) == (field, value)
    assert (span.records == UNTOUCHED).all()


@pytest.mark.parametrize("chain", [-1, 1, 2**31 - 1])
def test_a_chain_that_does_not_exist_is_refused(span, chain):
    function = FUNCTIONS["gallop_chain_derived"]
    assert span.call("gallop_chain_derived", function, {"element": c.c_int32(chain)}) == BAD_CALL
    assert (span.values == UNTOUCHED).all()


def test_a_number_of_probes_below_zero_is_refused(span):
    count = {"probes": c.c_int32(-1)}
    assert span.call("gallop_observe", FUNCTIONS["gallop_observe"], count) == BAD_CALL
    assert span.call("gallop_observe", FUNCTIONS["gallop_observe"], {"probes": c.c_int32(0)}) == 0
    assert (span.values == UNTOUCHED).all()


LAST = [(NODE, 8, 13), (JUNCTION, 1, 2), (FIELD, 0, 0), (SYSTEM, 0, 3)]


def test_probes_are_right_up_to_their_ends(span):
    probes = np.array([(*row, 0, 0.0) for row in LAST], dtype=PROBES.dtype)
    probes["station"][2] = 50.0  # of a uniform field
    given = {"probe": c.c_void_p(probes.ctypes.data), "probes": c.c_int32(len(probes))}
    assert span.run(**given) == 0
    assert span.done.value == 2


def test_probes_are_independent_of_their_order_and_of_scratch_memory(span):
    """Scratch memory of NaN is not read."""
    observe = FUNCTIONS["gallop_observe"]
    assert span.call("gallop_advance", ADVANCE, {}) == 0
    rows = [(SYSTEM, 0, k) for k in range(4)]
    rows += [(JUNCTION, j, k) for k in range(3) for j in range(2)]
    rows += [(NODE, n, k) for k in range(11, 14) for n in (4, 0)] + [(FIELD, 0, 0)]
    probes = np.array([(*row, 0, 0.0) for row in rows], dtype=PROBES.dtype)
    found = []
    for order in (slice(None), slice(None, None, -1)):
        span.block[span.model.saved_size // 8 : span.model.state_size // 8] = math.nan
        asked = probes[order].copy()
        given = {"probe": c.c_void_p(asked.ctypes.data), "probes": c.c_int32(len(asked))}
        assert span.call("gallop_observe", observe, given) == 0
        found.append(span.values[: len(asked)][order].copy())
    assert np.isfinite(found[0]).all()
    assert np.array_equal(*found)


RUNS = {
    "number of probes": ({"probes": -1}, "number of probes", -1),
    "records": ({"records": -1}, "number of records", -1),
    "first": ({"first": -1}, "first, which must not be negative", -1),
    "every": ({"every": 0}, "every, which must be positive", 0),
    "overflow": ({"first": 3, "every": 2**62}, "number of steps", 5.0 * 2.0**62),
    "steps": ({"records": 10**13}, "number of steps", 1e13),
}
POINTERS_OF_RUN = ("probe", "values", "done", "report")


@pytest.mark.parametrize("name", RUNS)
def test_a_run_refuses_counts_and_indices_that_are_out_of_range(span, name):
    change, field, value = RUNS[name]
    given = {
        key: (c.c_int32 if key == "probes" else c.c_int64)(value) for key, value in change.items()
    }
    before = span.saved
    assert span.run(**given) == BAD_CALL
    assert_filled(span.report, span)
    assert (span.report.field.decode(), span.report.value) == (field, value)
    assert span.done.value == 0
    assert (span.records == UNTOUCHED).all()
    assert span.saved == before


@pytest.mark.parametrize("pointer", POINTERS_OF_RUN)
def test_a_run_refuses_pointers_that_are_null(span, pointer):
    before = span.saved
    assert span.run(**{pointer: None}) == BAD_CALL
    assert span.saved == before
    if pointer != "report":
        assert_filled(span.report, span)
        assert span.report.field.decode().startswith(f"{pointer}, a pointer")


def test_a_run_of_no_records_fills_in_its_report(span):
    assert span.run(records=c.c_int64(0)) == 0
    assert (span.report.outcome, span.report.element, span.done.value, span.report.steps) == (
        0,
        -1,
        0,
        0,
    )
    assert span.report.lowest_tension > 1e4  # the tension of the equilibrium


def test_a_run_whose_steps_are_lost_in_round_off_is_refused(scene):
    span = Span(scene)
    assert span.init(time=c.c_double(1e15)) == 0
    assert span.run() == BAD_CALL
    assert b"round-off" in span.report.field


def test_a_state_is_started_only_by_an_initial_state(scene):
    """After a start that failed the block is no state."""
    span = Span(scene)
    assert math.isnan(kernel.gallop_state_time(span.state))
    span.inputs.attack_angle = 0.0
    assert span.init() == Outcome.ANGLE_OUT_OF_RANGE.code
    assert math.isnan(kernel.gallop_state_time(span.state))
    assert span.call("gallop_advance", ADVANCE, {}) == BAD_CALL
    span.inputs.attack_angle = math.pi
    assert span.started().call("gallop_advance", ADVANCE, {}) == 0


REWIND = FUNCTIONS["gallop_rewind"]


def test_a_rewind_needs_a_completed_advance(span):
    """It once restored zeros."""
    before = span.saved
    assert span.call("gallop_rewind", REWIND, {}) == BAD_CALL
    assert span.saved == before
    saved = span.model.saved_size
    assert span.call("gallop_advance", ADVANCE, {}) == 0
    assert span.call("gallop_rewind", REWIND, {}) == 0
    assert span.saved[:saved] == before[:saved]
    assert span.call("gallop_advance", ADVANCE, {}) == 0
    assert span.run() == 0
    assert span.call("gallop_rewind", REWIND, {}) == BAD_CALL
    for until, sharpness in ((0.2, 0.0), (0.3, -1.0), (0.4, 2.0), (0.5, math.nan)):
        assert span.call("gallop_advance", ADVANCE, {"until": c.c_double(until)}) == 0
        assert span.call("gallop_rewind", REWIND, {"sharpness": c.c_double(sharpness)}) == BAD_CALL


def test_a_model_that_is_none_has_no_size():
    junk = np.zeros(4096)
    for pointer in (None, c.c_void_p(junk.ctypes.data)):
        assert kernel.gallop_state_size(pointer) == kernel.gallop_saved_size(pointer) == 0
        assert kernel.gallop_middle(pointer) == -1
        assert kernel.gallop_model_derived(pointer, c.byref(CDerived())) == BAD_CALL
    kernel.gallop_model_free(None)


TABLES = ("cross_section", "curve", "field", "junction", "chain", "number")


@pytest.mark.parametrize("table", TABLES)
def test_a_scene_with_null_pointers_is_refused(scene, table):
    packed, report, handle = Packed(scene), CReport(), c.c_void_p(1)
    setattr(packed.scene, table, None)
    assert (
        kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(report))
        == BAD_CALL
    )
    assert_filled(report)
    assert report.field.decode().startswith(f"scene.{table}, a pointer")
    assert handle.value is None


@pytest.mark.parametrize("argument", ["scene", "model", "report"])
def test_creation_with_null_pointers_is_refused(scene, argument):
    packed, report, handle = Packed(scene), CReport(), c.c_void_p()
    given = {
        "scene": c.byref(packed.scene),
        "model": c.byref(handle),
        "report": c.byref(report),
    } | {argument: None}
    assert kernel.gallop_model_create(*given.values()) == BAD_CALL
    assert handle.value is None


@pytest.mark.parametrize("mode", [UP, DOWN, TOWARDS_ZERO])
def test_other_rounding_modes_are_refused_by_their_name(span, mode):
    """Once: "the attack angle left the validity range (value 3.14175, limit 4.53786)"."""
    libm = c.CDLL(None)
    before = span.saved
    assert kernel.gallop_arithmetic_fault() is None
    try:
        assert libm.fesetround(mode) == 0
        outcomes = [
            span.call(name, FUNCTIONS[name], {})
            for name in FUNCTIONS
            if "state" in FUNCTIONS[name][1:2]
        ]
        fault = kernel.gallop_arithmetic_fault()
        advanced = span.call("gallop_advance", ADVANCE, {})
        field = span.report.field
    finally:
        libm.fesetround(0)
    assert b"rounding mode" in fault
    assert (advanced, field) == (BAD_CALL, fault)
    assert set(outcomes) <= {BAD_CALL, 0}  # 0: gallop_state_check, which computes nothing
    assert span.saved == before
