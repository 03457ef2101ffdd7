"""What a host must not do is refused by the Python run-time with a message, kept out, and fails the next step."""

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
        ("wind_speed", math.nan, "not a finite number"),
        ("wind_speed", math.inf, "not a finite number"),
        ("wind_speed", -1.0, "at least 0 and at most 150"),
        ("wind_speed", 151.0, "at least 0 and at most 150"),
        ("attack_angle", 7.0, "at most 6.28319 [rad]"),
        ("support.left.x2", math.nan, "not a finite number"),
        ("midspan.x2", 1.0, "it is an output"),
        ("status", 0, "it is an output"),
        ("span.length", 100.0, "stays 125.88 after initialisation"),
        ("numerics.elements", 9, "stays 6 after initialisation"),
    ],
)
def test_refused_while_stepping(gallop_fmu, host, name, value, message):
    fmu = host(gallop_fmu).start().step(0.01)
    before = fmu.read() | {name: fmu[name]}
    fmu[name] = value
    assert f"{name} = {value!r} is refused" in fmu.log[-1]
    assert message in fmu.log[-1]
    assert fmu.read() | {name: fmu[name]} == before | {"status": Outcome.BAD_CALL.code}
    assert message in failing_step(fmu)
    assert fmu["status"] == Outcome.BAD_CALL.code
    assert fmu["midspan.x2"] == before["midspan.x2"]


def test_a_good_value_cures_a_refused_one(gallop_fmu, host):
    fmu, plain = host(gallop_fmu).start(), host(gallop_fmu).start()
    fmu["wind_speed"] = math.nan
    failing_step(fmu)
    fmu["wind_speed"] = 5.0
    plain["wind_speed"] = 5.0
    assert fmu.step(0.01).read() == plain.step(0.01).read()


def test_setting_a_parameter_to_what_it_is_does_no_harm(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    fmu["span.length"] = 125.88
    assert fmu.step(0.01).log == []


@pytest.mark.parametrize("size", [0.0, -0.01, math.nan, math.inf])
def test_a_step_must_be_positive(gallop_fmu, host, size):
    fmu = host(gallop_fmu).start().step(0.01)
    before = fmu.read()
    assert "must be a positive number" in failing_step(fmu, size)
    assert fmu.read() | {"status": 0} == before
    assert fmu.step(0.01)["status"] == 0


@pytest.mark.parametrize("time", [0.0, 0.5, 0.0101, math.nan])
def test_a_step_must_start_where_the_last_one_ended(gallop_fmu, host, time):
    fmu = host(gallop_fmu).start().step(0.01)
    assert "the FMU stands at 0.01 s" in failing_step(fmu, time=time)
    assert fmu.step(0.01)["status"] == 0


def test_round_off_of_the_host_is_forgiven(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    for k in range(50):
        fmu.fmu.doStep(k * 0.01 * (1.0 + 1e-11), 0.01)
    assert fmu["status"] == 0


def test_no_step_before_initialisation_or_after_the_end(gallop_fmu, host):
    fmu = host(gallop_fmu)
    assert "while instantiated" in failing_step(fmu)
    fmu.start().step(0.01)
    fmu.fmu.terminate()
    assert "while terminated" in failing_step(fmu, time=0.01)


def test_an_angle_out_of_range_fails_the_step_and_changes_nothing(gallop_fmu, host):
    fmu, plain = host(gallop_fmu).start().step(0.01, 5), host(gallop_fmu).start().step(0.01, 5)
    before = fmu.read()
    fmu["attack_angle"] = math.radians(100.0)  # the curve ends at 80 deg
    message = failing_step(fmu)
    assert message.startswith("At 0.06 s in element ")
    assert "100." in message
    assert "20 deg above the curve's upper limit of 80 deg" in message
    assert "What to do: give a curve" in message
    assert fmu["status"] == Outcome.ANGLE_OUT_OF_RANGE.code
    assert fmu.read() | {"status": 0} == before
    fmu["attack_angle"] = plain["attack_angle"]
    assert fmu.step(0.01).read() == plain.step(0.01).read()


def test_wind_that_twists_the_span_out_of_range_fails_inside_the_step(gallop_fmu, host):
    fmu = host(gallop_fmu).start().step(0.01, 5)
    before = fmu.read()
    fmu["wind_speed"] = 140.0
    message = failing_step(fmu, 5.0)
    assert "What to do" in message
    assert 0.05 < float(message.split()[1]) < 5.05
    assert fmu["status"] != 0
    assert fmu.read() | {"status": 0} == before


def test_parameters_that_contradict_each_other_leave_nothing_to_step(gallop_fmu, host):
    fmu = host(gallop_fmu)
    fmu["span.sag"] = 5.0
    fmu.start()
    assert "contradict each other" in fmu.log[-1]
    assert fmu["status"] == Outcome.INVALID_SCENE.code
    assert math.isnan(fmu["midspan.tension"])
    assert len(fmu.log) == 1  # told once, not at every look
    assert "contradict each other" in failing_step(fmu)
    fmu.fmu.reset()
    assert fmu.start().step(0.01)["status"] == 0


def test_parameters_may_contradict_each_other_on_the_way(gallop_fmu, host):
    fmu = host(gallop_fmu)
    fmu["damping.translation.low_frequency"] = 0.6  # above the high one, until that follows
    fmu["damping.translation.high_frequency"] = 0.9
    assert fmu.start().step(0.01).log == []


def test_an_excluded_bound_is_refused_and_named(gallop_fmu, host):
    fmu = host(gallop_fmu)
    fmu["span.length"] = 0.0
    assert (
        "span.length = 0.0 is refused: it must be greater than 0 and at most 10000 [m]"
        in fmu.log[-1]
    )
    fmu["span.length"] = 5e-324
    fmu.start()
    assert "is refused" not in fmu.log[-1]


def test_an_initial_angle_out_of_range_is_told(gallop_fmu, host):
    fmu = host(gallop_fmu).start(attack_angle=3.0)
    assert "left the validity range" in fmu.log[-1]
    assert fmu["status"] == Outcome.ANGLE_OUT_OF_RANGE.code
    assert "left the validity range" in failing_step(fmu)


def test_a_failed_start_stays_one_until_the_reset(gallop_fmu, host):
    fmu = host(gallop_fmu).start(attack_angle=3.0)
    fmu["attack_angle"] = 0.2
    assert "left the validity range" in failing_step(fmu)
    fmu.fmu.reset()
    assert fmu.start(attack_angle=0.2).step(0.01)["status"] == 0


def test_a_fault_of_the_package_fails_the_step_and_not_the_host(gallop_fmu, host, monkeypatch):
    def fault(self, time, size):
        raise KeyError("50% wrong")

    fmu = host(gallop_fmu).start()
    with monkeypatch.context() as patch:
        patch.setattr("gallop_fmu.fmu.session.Session.step", fault)
        assert failing_step(fmu) == "unexpected KeyError: '50 percent wrong'"
    assert fmu.step(0.01)["status"] == 0


def test_no_wind_without_a_curve(host, tmp_path):
    from gallop_fmu.fmu import export_fmu
    from gallop_fmu.input.scene_files import load_scene

    scene = load_scene("example1").with_values({"numerics.elements": 4})
    fmu = host(export_fmu(scene, tmp_path / "x.fmu", runtime="python")).start()
    fmu["wind_speed"] = 5.0
    assert "the scene has no aerodynamic curve" in fmu.log[-1]


def test_unknown_references_and_types(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    assert math.isnan(fmu.fmu.getReal([9999])[0])
    assert "no Real variable with value reference 9999" in fmu.log[-1]
    fmu.fmu.setReal([4_000_000_000], [1.0])
    fmu.fmu.setBoolean([0], [True])
    fmu.fmu.setString([0], ["5"])
    assert fmu.fmu.getBoolean([0]) == [False]
    assert "no Integer variable with value reference 0" in (fmu.fmu.getInteger([0]), fmu.log[-1])[1]
    assert fmu["wind_speed"] == 4.1
    assert "refused values" in failing_step(fmu)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"wind_speed": -1.0}, "wind_speed = -1.0 is refused: it must be at least 0 and at most"),
        ({"span.sag": 1e4}, "gallop-fmu: "),
    ],
)
def test_what_is_refused_is_said_although_the_host_does_not_log(gallop_fmu, capfd, start, message):
    """FMPy ended with two rows and not a word before: setters of pythonfmu cannot fail, its log is off by default."""
    result = simulate_fmu(
        str(gallop_fmu), stop_time=1.0, output_interval=0.05, start_values=start, output=["status"]
    )
    said = capfd.readouterr().err
    assert message in said
    assert len(result) < 3
    assert (result["status"] > 0).all()
