"""Ice that falls within the FMU, of a span and of a line, by time and by acceleration."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.fmu import export_fmu
from gallop_fmu.fmu.variables import fmu_variables
from support.sections import DRAKE, section

FALL = 0.5037
"""Time [s] off the communication points."""

H = 0.05
PARTS = [
    {"from_station": 0.25, "to_station": 0.75, "time": FALL},
    {"from_station": 0.75, "to_station": 1.0, "acceleration": 3.0},
]
COMMON = {
    "ice": {"mass_per_length": 1.5, "torsional_inertia": 4e-4, "first_moment_x3": -2e-3},
    "numerics": {"elements": 8, "time_step": 0.01},
}
SCENES = {
    "span": gf.Scene.from_dict(
        {
            "title": "ice that falls",
            "span": {"length": 300.0, "horizontal_tension": 35e3},
            "conductor": DRAKE,
            "shedding": PARTS,
            **COMMON,
        }
    ),
    "line": section((300.0, 280.0), shedding=[{"span": 1, **part} for part in PARTS], **COMMON),
}
MIDDLE = {"span": "midspan.x2", "line": "span[1].midspan.x2"}


@pytest.fixture(scope="session", params=SCENES)
def kind(request):
    return request.param


@pytest.fixture(scope="session")
def shed_fmu(kind, runtime, tmp_path_factory):
    path = tmp_path_factory.mktemp("shed") / f"{kind}.fmu"
    return export_fmu(SCENES[kind], path, runtime=runtime)


def engine(scene, times):
    """The motion of mid-span at each time, with the inputs at rest; and the times of the falls."""
    model = Model(scene)
    state = model.start(inputs=Inputs.still(scene))
    rows = []
    for time in times:
        state.advance(time, Inputs.still(scene))
        rows.append(state.motion()[0][model.middle, 1])
    return np.array(rows), state.shedding_times()


def heights(fmu, name, count):
    """Mid-span after each step, from the start of the run."""
    rows = []
    for _ in range(count):
        fmu.step(H)
        rows.append(fmu[name])
    return np.array(rows)


def test_motion_is_that_of_the_engine(shed_fmu, kind, host):
    """Both parts fall, the second one by acceleration, and no step goes across a fall."""
    fmu = host(shed_fmu).start()
    at_start = fmu[MIDDLE[kind]]
    found = heights(fmu, MIDDLE[kind], 40)
    times = H * np.arange(1, 41)
    wanted, falls = engine(SCENES[kind], times)
    assert falls[0] == FALL
    assert FALL < falls[1] < 2.0
    start = Model(SCENES[kind]).start().motion()[0][Model(SCENES[kind]).middle, 1]
    assert found - at_start == pytest.approx(wanted - start, abs=1e-9)
    assert found[-1] - at_start > 0.5


@pytest.mark.parametrize("before", [9, 10, 11])
def test_a_state_saved_around_the_fall_repeats_every_bit(shed_fmu, kind, host, before):
    fmu = host(shed_fmu).start()
    heights(fmu, MIDDLE[kind], before)
    state, time = fmu.fmu.getFMUstate(), fmu.time
    content = fmu.fmu.serializeFMUstate(state)
    first = heights(fmu, MIDDLE[kind], 8)
    fmu.fmu.setFMUstate(state)
    fmu.time = time
    assert np.array_equal(heights(fmu, MIDDLE[kind], 8), first)
    other = host(shed_fmu)
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(content))
    other.time = time
    assert np.array_equal(heights(other, MIDDLE[kind], 8), first)


def test_time_and_limit_are_parameters(shed_fmu, kind, host):
    """A host moves the fall; places belong to the mesh and are fixed."""
    values = {"shedding[0].time": 0.2, "shedding[1].acceleration": 1e6}
    fmu = host(shed_fmu)
    for name, value in values.items():
        fmu[name] = value
    fmu.start()
    at_start = fmu[MIDDLE[kind]]
    found = heights(fmu, MIDDLE[kind], 10)
    scene = SCENES[kind].with_values({"shedding.0.time": 0.2, "shedding.1.acceleration": 1e6})
    wanted, falls = engine(scene, H * np.arange(1, 11))
    assert falls.tolist() == [0.2, np.inf]
    start = Model(scene).start().motion()[0][Model(scene).middle, 1]
    assert found - at_start == pytest.approx(wanted - start, abs=1e-9)


def test_places_are_no_parameters(kind):
    names = {variable.name for variable in fmu_variables(SCENES[kind])}
    assert "shedding[0].time" in names
    assert not any("_station" in name for name in names)
    assert "numerics.elements" not in names
    whole = SCENES["span"].with_values({"shedding": [{"time": 1.0}]})
    assert "numerics.elements" in {variable.name for variable in fmu_variables(whole)}
