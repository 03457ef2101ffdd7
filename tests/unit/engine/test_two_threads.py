"""Two threads for one line: the same bits as one, both at work, and the same end of a run."""

import ctypes as c
import multiprocessing
import threading
from functools import partial

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CReport, CTeam
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import node_probes
from gallop_fmu.engine.state import State
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.simulation import run_options
from gallop_fmu.sweeps import sweep as sweep_module
from support.galloping_lines import section_of_example2

BAD_CALL = Outcome.BAD_CALL.value[0]
QUAD = {"subconductors": 4, "spacing": 0.45, "spacers": 3}
LOAD = {
    "span": 7,
    "position": 0.5,
    "force": [0.0, 8e4, 0.0],
    "law": {
        "kind": "pulse",
        "peak": 1.0,
        "start": 1.0,
        "rise": 0.5,
        "fall_start": 9.0,
        "fall": 0.5,
    },
}
SHED = {"span": 6, "from_station": 0.2, "to_station": 0.7, "time": 0.5}


def section(**parts):
    return section_of_example2(8, **parts)


def bundles():
    return section_of_example2(3, bundle=QUAD)


def phases():
    """Conductors that nothing joins: each is solved by itself."""
    apart = [{"name": name, "offset": [0.0, height]} for name, height in (("a", 0.0), ("b", 9.0))]
    return section_of_example2(1, elements=40, phases=apart)


LINES = {"section": section, "bundles": bundles, "phases": phases}


def bits(model, threads, records=20):
    """Bits of a recorded run and of the state after it."""
    state = model.start()
    nodes = node_probes(np.arange(model.nodes, dtype=np.int32), np.arange(12, dtype=np.int32))
    values, report = state.record(records, 3, nodes, threads=threads)
    assert report.outcome is Outcome.COMPLETED
    return values.tobytes(), state.save(), report


@pytest.mark.parametrize("integrator", [*INTEGRATORS, "tolerance"])
@pytest.mark.parametrize("line", LINES)
def test_two_threads_give_the_bits_of_one(line, integrator):
    key = "tolerance" if integrator == "tolerance" else "integrator"
    value = 1e-3 if key == "tolerance" else integrator
    model = Model(LINES[line]().with_values({f"numerics.{key}": value}), inputs=False)
    assert model.threads == 2
    assert bits(model, 2) == bits(model, 1)


def test_short_lines_and_single_spans_have_one_thread():
    assert Model(section_of_example2(2, elements=10)).threads == 1
    assert Model(section_of_example2(1, elements=200)).threads == 1


def shared_run(model, steps):
    """Number of pieces of work of which a second thread computes a half."""
    team, raw, done, taken = CTeam(), CReport(), c.c_int64(), []
    state = model.start()
    second = threading.Thread(target=lambda: taken.append(kernel.gallop_assist(c.byref(team))))
    second.start()
    try:
        code = kernel.gallop_run_in_team(
            model.handle, state._pointer, 0, 1, steps, None, 0, np.empty(1).ctypes.data_as(
                c.POINTER(c.c_double)
            ), c.byref(done), c.byref(team), c.byref(raw),
        )  # fmt: skip
    finally:
        assert kernel.gallop_dismiss(c.byref(team)) == 0
        second.join()
    assert (code, done.value) == (0, 1)
    return taken[0]


def test_the_second_thread_computes_halves():
    model = Model(section(), inputs=False)
    assert any(shared_run(model, 2000) > 0 for _ in range(20))  # it may wait for a processor
    assert shared_run(Model(section_of_example2(2), inputs=False), 50) == 0


@pytest.mark.parametrize(
    ("outside", "outcome"), [("error", Outcome.ANGLE_OUT_OF_RANGE), ("hold", Outcome.SLACK)]
)
def test_a_run_that_fails_in_the_second_half(outside, outcome):
    scene = section(loads=[LOAD]).with_values({"aerodynamics.outside": outside})
    before = threading.active_count()
    results = [gf.simulate(scene, 10.0, on_failure="return", threads=threads) for threads in (1, 2)]
    assert results[0].outcome is outcome
    assert results[0].report == results[1].report
    assert results[0].dataset.drop_attrs().identical(results[1].dataset.drop_attrs())
    assert threading.active_count() == before


def test_ice_that_falls_in_the_second_half():
    model = Model(section(ice={"mass_per_length": 1.0}, shedding=[SHED]), inputs=False)
    assert bits(model, 2) == bits(model, 1)


def end_of_run(_=None):
    result = gf.simulate(section(), 1.0, threads=2)
    return result.dataset.u2.values.tobytes()


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="no fork")
def test_a_program_can_fork_between_runs():
    expected = end_of_run()
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(end_of_run).get(timeout=60) == expected


@pytest.mark.parametrize("threads", [0, 3, True, 1.5, "2"])
def test_other_numbers_of_threads_are_refused(threads):
    with pytest.raises(SceneError, match="must be 1 or 2"):
        gf.simulate(section(), 1.0, threads=threads)


def test_the_default_is_two_threads_for_a_long_line_on_two_cores(monkeypatch):
    def chosen(cores, elements):
        monkeypatch.setattr(run_options, "cores", lambda: cores)
        return run_options.chosen_threads(None, elements)

    assert [chosen(8, 400), chosen(8, 399), chosen(1, 400)] == [2, 1, 1]
    monkeypatch.setattr(multiprocessing.process, "parent_process", lambda: "a process")
    assert chosen(8, 400) == 1


def test_a_long_line_uses_two_threads_unasked(monkeypatch):
    given = []
    record = State.record

    def noted(*arguments, **options):
        given.append(arguments[-1])
        return record(*arguments, **options)

    monkeypatch.setattr(run_options, "cores", lambda: 2)
    monkeypatch.setattr(State, "record", noted)
    for line, threads in ((section(elements=50), 2), (section(), 1)):
        given.clear()
        gf.simulate(line, 0.2)
        assert set(given) == {threads}


def test_runs_of_a_sweep_have_one_thread(monkeypatch):
    given = []
    simulate = sweep_module.simulate

    def noted(*arguments, **options):
        given.append(options["threads"])
        return simulate(*arguments, **options)

    monkeypatch.setattr(sweep_module, "simulate", noted)
    gf.sweep(section_of_example2(2), {"wind.speed": [3.0, 4.0]}, stop_time=1.0)
    assert given == [1, 1]


def test_pointers_to_teams_are_checked():
    assert kernel.gallop_assist(None) == -1
    assert kernel.gallop_dismiss(None) == BAD_CALL
    odd = c.cast(c.byref(CTeam(), 4), c.POINTER(CTeam))
    assert kernel.gallop_assist(odd) == -1
    model, raw, done = Model(section(), inputs=False), CReport(), c.c_int64()
    run = partial(kernel.gallop_run_in_team, model.handle, model.start()._pointer, 0, 0, 1, None, 0)
    assert run(None, c.byref(done), odd, c.byref(raw)) == BAD_CALL
    assert raw.field.startswith(b"team")
