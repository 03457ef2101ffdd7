"""Derivatives by inputs and in time, of outputs and inputs, against differences by the host."""

import struct

import numpy as np
import pytest

import gallop_fmu as gf
from support.checksum import fnv1a

H = 0.04  # four steps of the scene
OUTPUTS = ["midspan.x2", "midspan.x3", "midspan.theta", "midspan.v2", "midspan.tension",
    "support.left.f1",
           "support.left.f2", "support.right.f3"]  # fmt: skip
INPUTS = {"wind_speed": 1e-3, "attack_angle": 1e-4, "support.left.x1": 1e-4,
    "support.right.x2": 1e-4,
          "support.left.x3": 1e-4}  # fmt: skip


@pytest.fixture(scope="module")
def sharp(unpack):
    """Iterated to round-off, so that the host's differences are accurate."""
    return unpack(
        gf.load_scene("example3").with_values(
            {"numerics.elements": 4, "numerics.newton_tolerance": 1e-14}
        )
    )


def by_the_host(fmu, state, name, size):
    """Central difference over a whole step from a saved state, of fourth order."""
    base, sides = None, {}
    for k in (-2, -1, 1, 2):
        assert fmu.restore(state) == 0
        base = fmu[name]
        fmu[name] = base + k * size
        assert fmu.do_step(fmu.time, H) == 0
        sides[k] = np.array([fmu[output] for output in OUTPUTS])
    return (8.0 * (sides[1] - sides[-1]) - (sides[2] - sides[-2])) / (12.0 * size)


@pytest.mark.parametrize("name", INPUTS)
def test_directional_derivative_is_that_of_the_whole_step(sharp, instance, name):
    fmu = instance(sharp).start(wind_speed=7.0).step(H, 50)
    fmu["support.left.x1"] = 0.01
    state = fmu.save()
    wanted = by_the_host(fmu, state, name, INPUTS[name])
    assert fmu.restore(state) == 0
    assert fmu.do_step(fmu.time, H) == 0
    before = fmu.outputs()
    status, found = fmu.directional(OUTPUTS, [name], [1.0])
    assert status == 0, fmu.log
    scale = np.abs(wanted) + 1e-3 * np.abs(wanted).max()
    error = np.abs(np.array([found[output] for output in OUTPUTS]) - wanted) / scale
    assert error.max() < 1e-6, dict(zip(OUTPUTS, error, strict=True))
    assert fmu.outputs() == before
    fmu.drop(state)


def test_directional_derivative_is_linear_in_the_seed(sharp, instance):
    fmu = instance(sharp).start(wind_speed=7.0).step(H, 20)
    one = np.array(
        [
            list(fmu.directional(OUTPUTS, [name], [1.0])[1].values())
            for name in ("wind_speed", "attack_angle")
        ]
    )
    both = np.array(
        list(fmu.directional(OUTPUTS, ["wind_speed", "attack_angle"], [300.0, -20.0])[1].values())
    )
    expected = 300.0 * one[0] - 20.0 * one[1]
    assert both == pytest.approx(expected, rel=1e-5, abs=1e-5 * np.abs(expected).max())
    assert set(fmu.directional(OUTPUTS, ["wind_speed"], [0.0])[1].values()) == {0.0}


def test_calm_wind_has_a_derivative_from_both_sides(sharp, instance):
    """The load of a calm span grows with the square of the speed: zero slope, without a kink."""
    fmu = (
        instance(sharp)
        .start(wind_speed=0.0, initial__seed_vertical=0.0, initial__seed_horizontal=0.0)
        .step(H)
    )
    found = fmu.directional(OUTPUTS, ["wind_speed"], [1.0])[1]
    assert abs(found["midspan.x3"]) < 1e-9


def test_initial_state_by_its_inputs(sharp, instance):
    fmu = instance(sharp)
    assert fmu.set_up() == 0
    fmu.insist("EnterInitializationMode")
    fmu["support.right.x1"] = 0.02
    status, found = fmu.directional(["midspan.x2", "support.left.f1"], ["support.right.x1"], [1.0])
    assert status == 0, fmu.log
    sides = []
    for x in (0.02 - 1e-4, 0.02 + 1e-4):
        fmu["support.right.x1"] = x
        sides.append(np.array([fmu["midspan.x2"], fmu["support.left.f1"]]))
    assert list(found.values()) == pytest.approx((sides[1] - sides[0]) / 2e-4, rel=1e-6)


def test_an_input_rate_is_a_ramp(small_scene, small, instance):
    ramp = {"kind": "table", "time": [0.0, 2.0], "value": [4.0, 8.0]}
    wanted = gf.simulate(
        small_scene.with_values({"wind.speed": None, "wind.history": ramp}),
        stop_time=2.0,
        record_every=4,
    )
    fmu = instance(small).start(wind_speed=4.0)
    found, tail = [], []
    for k in range(50):
        if k % 2:  # in either order
            fmu.input_rates(wind_speed=2.0)
            fmu["wind_speed"] = 4.0 + 2.0 * k * H
        else:
            fmu["wind_speed"] = 4.0 + 2.0 * k * H
            fmu.input_rates(wind_speed=2.0)
        fmu.step(H)
        found.append(fmu["midspan.x3"])
        tail.append(fmu["angle_of_attack"])
    midspan = wanted.midspan()
    # observed: 4e-13 of the largest value, by round-off in the wind
    for values, channel in ((found, "u3"), (tail, "angle_of_attack")):
        assert values == pytest.approx(
            midspan[channel].values[1:], rel=1e-9, abs=1e-9 * np.abs(values).max()
        )


def test_an_input_rate_ends_with_its_step(small, instance):
    plain, ramped = instance(small).start(), instance(small).start()
    plain.step(H), plain.step(H)
    state = plain.save()
    ramped.input_rates(wind_speed=3.0)
    ramped.step(H)
    once = ramped.save()
    assert ramped.restore(state) == 0
    ramped.time = plain.time
    assert ramped.step(H).outputs() == plain.step(H).outputs()
    assert ramped.restore(once) == 0
    ramped.time = H
    constant = ramped.step(H).outputs()
    assert ramped.restore(once) == 0
    ramped.time = H
    ramped.input_rates(wind_speed=0.0)
    assert ramped.step(H).outputs() == constant


def test_a_falling_wind_stops_at_zero(small, instance):
    fmu, other = instance(small).start(wind_speed=1.0), instance(small).start(wind_speed=1.0)
    fmu.input_rates(wind_speed=-1e6)
    other.input_rates(wind_speed=-1.0 / H)
    assert fmu.step(H).outputs() == other.step(H).outputs()


def test_support_rate_is_where_the_tower_goes(small, instance):
    fmu, other = instance(small).start(), instance(small).start()
    fmu.input_rates(support__left__x1=0.5)
    other["support.left.x1"] = 0.5 * H
    assert fmu.step(H).outputs() == other.step(H).outputs()


def test_rates_of_outputs(small, instance):
    fmu = instance(small).start(wind_speed=7.0).step(H, 30)
    forces = ["support.left.f1", "support.right.f2", "midspan.tension", "angle_of_attack"]
    before = np.array([fmu[name] for name in forces])
    fmu.step(H)
    moving = {
        "midspan.x2": "midspan.v2",
        "midspan.x3": "midspan.v3",
        "midspan.theta": "midspan.omega",
    }
    status, found = fmu.output_rates([*moving, *forces])
    assert status == 0
    assert [found[name] for name in moving] == [fmu[name] for name in moving.values()]
    after = np.array([fmu[name] for name in forces])
    assert [found[name] for name in forces] == list(
        (after - before) / ((fmu.time) - (fmu.time - H))
    )


def test_rates_of_velocities_are_accelerations(small, instance):
    fmu = instance(small).start(wind_speed=7.0).step(0.01, 100)
    rate, before = fmu.output_rates(["midspan.v2"])[1]["midspan.v2"], fmu["midspan.v2"]
    fmu.step(0.01)
    after, last = fmu.output_rates(["midspan.v2"])[1]["midspan.v2"], fmu["midspan.v2"]
    assert last - before == pytest.approx(0.5 * 0.01 * (rate + after), rel=1e-8)  # Newmark's rule


LAST_SIZE = 24 + 64 + 32 + 4 * 8
"""Place of the size of the last step: after checksum, identity, run and counts."""
ASKED = ["midspan.x3", "midspan.tension", "support.left.f1"]


def derivatives(fmu):
    """Derivatives in time and by an input: the bits."""
    rates = fmu.output_rates(ASKED)
    along = fmu.directional(ASKED, ["wind_speed", "support.left.x1"], [1.0, 0.01])
    assert rates[0] == along[0] == 0, fmu.log
    return [value.hex() for found in (rates, along) for value in found[1].values()]


@pytest.mark.parametrize("steps", [0, 3])
def test_derivatives_of_a_restored_state(small, instance, steps):
    fmu = instance(small).start(wind_speed=7.0)
    fmu["support.left.x1"] = 0.001
    fmu.step(H, steps)
    state, wanted = fmu.save(), derivatives(fmu)
    content = fmu.to_bytes(state)
    fmu["wind_speed"] = 3.0
    assert derivatives(fmu.step(H, 2)) != wanted
    assert fmu.restore(state) == 0
    assert derivatives(fmu) == wanted
    fmu.drop(state)
    other = instance(small)
    status, state = other.from_bytes(content)
    assert status == 0
    assert other.restore(state) == 0
    assert derivatives(other) == wanted
    assert other.to_bytes(other.save()) == content


def test_a_state_with_another_last_step_is_refused(small, instance):
    """The checksum is right, but the state before the step is of another time."""
    fmu = instance(small).start().step(H, 3)
    content = bytearray(fmu.to_bytes(fmu.save()))
    assert struct.unpack_from("<d", content, LAST_SIZE)[0] == pytest.approx(H)
    struct.pack_into("<d", content, LAST_SIZE, 2.0 * H)
    struct.pack_into("<Q", content, 16, fnv1a(content[24:]))
    status, state = fmu.from_bytes(bytes(content))
    assert status == 0
    assert fmu.restore(state) == 3
    assert "not one of this span" in fmu.log[-1]


def test_nothing_to_look_back_on(small, instance):
    """After a failed step there is no step to differentiate."""
    fmu = instance(small).start()
    assert fmu.output_rates(["support.left.f1"]) == (0, {"support.left.f1": 0.0})
    fmu.step(H)
    assert fmu.directional(["midspan.x2"], ["wind_speed"], [1.0])[0] == 0
    attack = fmu["attack_angle"]
    fmu["attack_angle"] = 0.0
    assert fmu.do_step(fmu.time, H) == 3
    fmu["attack_angle"] = attack
    assert fmu.output_rates(["midspan.x2"])[0] == 0
    for status in (
        fmu.output_rates(["support.left.f1"])[0],
        fmu.directional(["midspan.x2"], ["wind_speed"], [1.0])[0],
    ):
        assert status == 3
        assert "known only after a step" in fmu.log[-1]
    fmu.step(H)
    assert fmu.output_rates(["support.left.f1"])[0] == 0
