"""Refused calls of the FMU in Python: logged, without effect; steps fail until it is repaired.

pythonfmu's setters can report no error. The rules and messages are the kernel's: tests/native.
"""

import math

import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException

from gallop_fmu.foundation.outcome import Outcome

pytestmark = [
    pytest.mark.usefixtures("runtime"),
    pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session"),
]

DISCARD = 2


def failing_step(fmu, size=0.01, time=None):
    """The log's last message after a step that had to fail."""
    with pytest.raises(FMICallException) as caught:
        fmu.fmu.doStep(fmu.time if time is None else time, size)
    assert caught.value.status == DISCARD
    return fmu.log[-1]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("wind_speed", math.nan, "wind_speed must be a finite number"),
        (
            "wind_speed",
            -151.0,
            "wind_speed = -151 is refused: it must be at least -150 and at most",
        ),
        ("midspan.x2", 1.0, "midspan.x2 is an output"),
        ("status", 0, "status is an output"),
        ("span.length", 100.0, "span.length is a fixed parameter"),
        ("numerics.elements", 9, "numerics.elements is a fixed parameter"),
    ],
)
def test_a_refused_value_fails_the_steps_after_it(gallop_fmu, host, name, value, message):
    fmu = host(gallop_fmu).start().step(0.01)
    before = fmu.read() | {name: fmu[name]}
    fmu[name] = value
    assert message in fmu.log[-1]
    assert fmu.read() | {name: fmu[name]} == before
    for _ in range(2):
        said = failing_step(fmu)
        assert said.startswith("no step is made after a refused call: ")
        assert message in said
    assert fmu.read() | {name: fmu[name]} == before


def test_a_good_value_repairs_a_refused_one(gallop_fmu, host):
    fmu, plain = host(gallop_fmu).start(), host(gallop_fmu).start()
    fmu["wind_speed"] = math.nan
    failing_step(fmu)
    fmu["attack_angle"] = plain["attack_angle"]  # another variable does not
    failing_step(fmu)
    fmu["wind_speed"] = 5.0
    plain["wind_speed"] = 5.0
    assert fmu.step(0.01).read() == plain.step(0.01).read()


def test_all_values_of_a_call_are_set_or_none(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    wind, angle = (fmu.variables[name].valueReference for name in ("wind_speed", "attack_angle"))
    fmu.fmu.setReal([wind, angle], [5.0, math.nan])
    assert fmu["wind_speed"] == 4.1
    fmu["wind_speed"] = 5.0
    assert "attack_angle must be a finite number" in failing_step(fmu)
    fmu["attack_angle"] = 0.2
    fmu.step(0.01)


def test_a_refused_step_leaves_no_refusal_behind(gallop_fmu, host):
    fmu = host(gallop_fmu)
    assert "a step is not allowed before initialization" in failing_step(fmu)
    fmu.start().step(0.01)
    before = fmu.read()
    assert "must be positive" in failing_step(fmu, 0.0)
    assert "but the FMU is at 0.01 s" in failing_step(fmu, time=0.5)
    assert fmu.read() == before
    fmu.step(0.01)
    fmu.fmu.terminate()
    assert "a step is not allowed after termination" in failing_step(fmu)


def test_an_angle_out_of_range_fails_the_step_and_changes_nothing(gallop_fmu, host):
    fmu, plain = host(gallop_fmu).start().step(0.01, 5), host(gallop_fmu).start().step(0.01, 5)
    before = fmu.read()
    fmu["attack_angle"] = math.radians(100.0)  # the curve ends at 80 deg
    message = failing_step(fmu)
    assert message.startswith("the step could not be carried out: at 0.06 s in element ")
    assert "20 deg above the curve's upper limit of 80 deg" in message
    assert fmu["status"] == Outcome.ANGLE_OUT_OF_RANGE.code
    assert fmu.read() | {"status": 0} == before
    fmu["attack_angle"] = plain["attack_angle"]
    assert fmu.step(0.01).read() == plain.step(0.01).read()


def test_without_an_initial_state_no_step_is_made_until_the_reset(gallop_fmu, host):
    fmu = host(gallop_fmu).start(attack_angle=3.0)
    assert "there is no initial state" in fmu.log[-1]
    assert fmu["status"] == Outcome.ANGLE_OUT_OF_RANGE.code
    assert math.isnan(fmu["midspan.tension"])
    fmu["attack_angle"] = 0.2
    assert "left the validity range" in failing_step(fmu)
    fmu.fmu.reset()
    assert fmu.start(attack_angle=0.2).step(0.01)["status"] == 0


def test_unknown_references_and_types(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    assert math.isnan(fmu.fmu.getReal([9999])[0])
    assert "no Real variable with value reference 9999" in fmu.log[-1]
    assert fmu.fmu.getBoolean([0]) == [False]
    assert "no Boolean and no String variables" in fmu.log[-1]
    assert fmu.fmu.getInteger([0]) == [0]
    assert "no Integer variable with value reference 0" in fmu.log[-1]
    fmu.step(0.01)
    fmu.fmu.setBoolean([0], [True])
    assert "no Boolean and no String variables" in failing_step(fmu)
    fmu["wind_speed"] = 4.1
    fmu.fmu.setReal([4_000_000_000], [1.0])
    assert "value reference 4000000000" in failing_step(fmu, time=0.01)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"wind_speed": -151.0}, "wind_speed = -151 is refused: it must be at least -150 and"),
        ({"span.sag": 1e4}, "gallop-fmu: "),
    ],
)
def test_refusals_are_reported_without_logging(gallop_fmu, capfd, start, message):
    """pythonfmu's setters cannot fail and its log is off by default: stderr has the reason."""
    result = simulate_fmu(
        str(gallop_fmu), stop_time=1.0, output_interval=0.05, start_values=start, output=["status"]
    )
    said = capfd.readouterr().err
    assert message in said
    assert len(result) < 3
