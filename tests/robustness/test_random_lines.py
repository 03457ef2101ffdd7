"""Random lines of several spans: every run ends with a typed outcome, and states return exactly."""

import ctypes as c

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CChain, CDevice, CJunction, CReport, Three
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.pack import Packed
from gallop_fmu.foundation.outcome import Outcome

LINES, STEPS = 60, 20


def random_line(draw):
    """One to five spans; the junctions between them have springs, or only couple the spans."""
    method = draw.choice(["newmark", "gauss6", "generalised_alpha"])
    values = {"numerics.integrator": str(method), "numerics.time_step": 0.02}
    if method == "gauss6" and draw.random() < 0.5:
        values["numerics.tolerance"] = 1e-3
    packed = Packed(gf.load_scene("example3").with_values(values))
    spans = int(draw.integers(1, 6))
    place = np.zeros(3)
    junctions = []
    for k in range(spans + 1):
        end = k in (0, spans)
        junction = CJunction(position=Three(*place))
        junction.fixed[:] = (end, end or draw.random() < 0.5, end, end or draw.random() < 0.5)
        junction.motion[:] = (-1, -1, -1)
        junctions.append(junction)
        if not end and draw.random() < 0.8:
            device = CDevice(kind=0, junctions=1)
            device.junction[:] = (k, *(-1,) * 7)
            device.parameter[:3] = draw.uniform(1e2, 1e5, 3)
            packed.tables["device"].append(device)
        place += [draw.uniform(60.0, 300.0), draw.uniform(-5.0, 5.0), 0.0]
    packed.tables["junction"] = junctions
    packed.tables["chain"] = []
    for k in range(spans):
        chain = CChain(elements=int(draw.integers(2, 8)), horizontal_tension=15e3)
        chain.junction[:] = (k, k + 1)
        packed.tables["chain"].append(chain)
    if draw.random() < 0.3:  # an index that may be wrong
        table = draw.choice(["chain", "device", "junction"])
        for item in packed.tables[table][:1]:
            field = {"chain": "junction", "device": "junction", "junction": "motion"}[table]
            getattr(item, field)[int(draw.integers(0, 2))] = int(draw.integers(-2, spans + 3))
    packed.scene = packed.c_scene()
    return packed


def created(packed):
    report, handle = CReport(), c.c_void_p()
    code = kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(report))
    assert code == report.outcome
    assert (handle.value is None) == (code != 0)
    return Outcome.from_code(code), handle


@pytest.mark.parametrize("seed", range(LINES))
def test_random_lines_end_with_typed_outcomes(seed):
    outcome, model = created(random_line(np.random.default_rng([2026, seed])))
    if outcome is not Outcome.COMPLETED:
        assert outcome in (Outcome.INVALID_SCENE, Outcome.EQUILIBRIUM_NOT_FOUND), outcome
        return
    try:
        run_and_return(model)
    finally:
        kernel.gallop_model_free(model)


def run_and_return(model):
    """Run, save, go on, restore, go on: the same bits."""
    size, saved = kernel.gallop_state_size(model), kernel.gallop_saved_size(model)
    state, kept = np.zeros(size // 8 + 1), np.zeros(size // 8 + 1)
    report = CReport()
    at = state.ctypes.data_as(c.c_void_p)
    if kernel.gallop_state_init(model, at, 0.0, None, c.byref(report)):
        assert Outcome.from_code(report.outcome) in (Outcome.SLACK, Outcome.EQUILIBRIUM_NOT_FOUND)
        return
    if kernel.gallop_advance(model, at, None, 0.02 * STEPS, c.byref(report)):
        outcome = Outcome.from_code(report.outcome)
        assert outcome in (Outcome.SLACK, Outcome.NEWTON_STALLED, Outcome.ANGLE_OUT_OF_RANGE)
        return
    assert kernel.gallop_state_check(model, at) == 0
    kept[:] = state
    ends = []
    for _ in range(2):
        state[: saved // 8] = kept[: saved // 8]
        assert kernel.gallop_advance(model, at, None, 0.02 * (STEPS + 10), c.byref(report)) == 0
        ends.append(state[: saved // 8].copy())
    np.testing.assert_array_equal(ends[0], ends[1])
    assert kernel.gallop_state_check(model, at) == 0  # every number of it is finite
