"""Towers that move in communication steps of any size: against the monolithic solution."""

import ctypes as c

import numpy as np
import pytest

from gallop_fmu.engine.library import kernel
from gallop_fmu.fmu.cosim import Cosim
from gallop_fmu.fmu.model_bin import model_bin
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.input.scene_files import load_scene
from support.scripts import load_script

steps = load_script("benchmarks/accuracy/tower_steps.py")
TIME_STEP = 0.01


@pytest.fixture(scope="module")
def reference():
    return steps.monolithic(0.0025)


MASTERS = {
    # scheme, velocities, longest step [s]: observed with seeds 0 to 4 (tower_steps.py)
    ("iterated", True, 0.05): 0.0071,
    ("iterated", False, 0.05): 0.0085,
    ("gauss_seidel", False, 0.02): 0.0098,
    ("jacobi", True, 0.02): 0.0096,
}


@pytest.mark.parametrize(("scheme", "gives_velocity", "longest"), MASTERS)
def test_the_force_of_random_and_rejected_steps_is_the_monolithic_one(
    reference, scheme, gives_velocity, longest
):
    for seed in range(3):
        largest, rms = steps.random_steps(
            scheme, steps.Coupled(gives_velocity), seed, reference, longest
        )
        assert largest < 0.01
        assert rms < 0.006  # 0.00585 at most


@pytest.mark.parametrize("scheme", ["gauss_seidel", "jacobi"])
def test_the_error_is_that_of_the_coupling_and_not_of_the_cable(reference, scheme):
    """A linear spring in place of the cable gives errors of the same size."""
    cable, spring = (
        steps.random_steps(scheme, pair, 0, reference)[1]
        for pair in (steps.Coupled(True), steps.Linear(True, reference))
    )
    assert 0.002 < spring < cable < 4.0 * spring  # ratios 1.6 to 3.0 in seeds 0 to 4


@pytest.mark.parametrize("scheme", ["gauss_seidel", "jacobi"])
def test_masters_that_control_their_steps_get_no_refusal(reference, scheme):
    error, taken, rejected, _ = steps.controlled_steps(scheme, steps.Coupled(False), reference)
    assert taken > 100
    assert rejected > 20
    assert error < 0.03  # 0.0107 and 0.0277


@pytest.mark.parametrize(("gives_velocity", "bound"), [(True, 0.01), (False, 0.02)])
def test_a_short_step_after_longer_ones_changes_the_force_little(gives_velocity, bound):
    """A velocity that grows as 1/h made 16.3 kN of 1 ms, 62.9 kN of 0.1 ms, 6.5 MN of 1 us."""
    for time_step in (0.01, 0.00125):
        before = steps.after_a_shorter_step(gives_velocity, 0.005, time_step)
        for h in (1e-3, 1e-4, 1e-6):
            found = steps.after_a_shorter_step(gives_velocity, h, time_step)
            assert abs(found / before - 1.0) < bound  # at most 0.0044 and 0.0176


class Point:
    """A cable in still air; its left end moves along the span."""

    def __init__(self):
        scene = load_scene("example3").with_values(
            {"numerics.elements": 4, "numerics.time_step": TIME_STEP, "wind.speed": 0.0}
            | {"initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0}
        )
        self.reference = {v.name: v.reference for v in fmu_variables(scene)}
        self.cosim, self.time = Cosim(model_bin(scene, "x", "1"), "x"), 0.0
        self.cosim.set_up(0.0, None)
        self.cosim.enter_initialization()
        self.cosim.exit_initialization()

    def step(self, h, **values):
        names = [self.reference[f"support.left.{name}"] for name in values]
        self.cosim.set("real", names, list(values.values()))
        self.cosim.step(self.time, h)
        self.time += h
        return self.cosim.get("real", [self.reference["support.left.f1"]])[0]


def test_equal_and_growing_steps_reach_their_place_at_once():
    """The force is bit for bit that of a run with the velocity that this needs."""
    place, velocity = Point(), Point()
    reached = 0.0
    for h in (1e-4, 1e-4, 2e-3, 0.01, 0.02, 0.01):
        x = reached + 2.0**-7 * h
        one = place.step(h, x1=x)
        other = velocity.step(h, x1=reached, v1=(x - reached) / h)
        assert one == pytest.approx(other, rel=1e-9)
        reached = x


def test_the_motion_after_a_longer_step_is_the_documented_one():
    """v + r / T, with T = 8 ms less the time since, r = given - x - v h, and v' = r / T^2."""
    place, velocity = Point(), Point()
    for point in (place, velocity):
        point.step(0.008, x1=1e-4)
    x, v, ramp, h = 1e-4, 1e-4 / 0.008, 0.008, 0.001
    for _ in range(12):
        ramp = max(h, ramp - h)
        rest = 1e-3 - x - v * h
        one = place.step(h, x1=1e-3)
        other = velocity.step(h, x1=x, v1=v + rest / ramp)
        x, v = x + (v + rest / ramp) * h, v + rest * h / ramp**2
        assert one == pytest.approx(other, rel=1e-9)
    assert x == pytest.approx(1e-3, rel=1e-12)


def test_a_steady_motion_in_steps_of_any_size_is_followed_at_its_velocity():
    """With and without velocities: equal forces, after the first step."""
    rng, place, velocity = np.random.default_rng(3), Point(), Point()
    for _ in range(40):
        h = 10.0 ** rng.uniform(-6.0, -2.0)
        x = 2.0**-6 * place.time
        one = place.step(h, x1=x + 2.0**-6 * h)
        other = velocity.step(h, x1=x, v1=2.0**-6)
        assert one == pytest.approx(other, rel=1e-8)


def set_rate(point, name, rate):
    """Set the derivative of an input of the left end."""
    cosim = point.cosim
    references = cosim._references([point.reference[f"support.left.{name}"]])
    rates = cosim._array("real", [rate])
    handle = c.c_void_p(cosim._handle)
    assert kernel.gallop_cosim_set_input_rates(handle, references, c.c_size_t(1), rates) == 0


@pytest.mark.parametrize("by_derivative", [False, True])
def test_a_velocity_of_zero_is_given(by_derivative):
    """A tower that stops: zero is as good as a velocity of 1e-12 m/s, also in a restored state."""
    forces = []
    for last in (0.0, 1e-12):
        point, values = Point(), {"x1": 0.0, "v1": 0.02}
        if by_derivative:
            set_rate(point, "x1", values.pop("v1"))
        point.step(0.01, **values)
        saved, time = point.cosim.save(), point.time
        point = Point()
        point.cosim.restore(saved)
        point.time = time
        for _ in range(4):
            values = {"x1": 2e-4, "v1": last}
            if by_derivative:
                set_rate(point, "x1", values.pop("v1"))
            forces.append(point.step(0.001, **values))
    assert forces[:4] == pytest.approx(forces[4:], rel=1e-9)


@pytest.mark.parametrize("sets_zeros", [False, True])
def test_an_unused_velocity_of_zero_is_not_given(sets_zeros):
    """Some hosts set all inputs: the point goes on at its last velocity in shorter steps."""
    plain, other = Point(), Point()
    for h, x in ((0.01, 2e-4), (0.001, 2.2e-4), (0.002, 2.6e-4)):
        zeros = {"v1": 0.0} if sets_zeros else {}
        assert plain.step(h, x1=x) == other.step(h, x1=x, **zeros)


def test_the_derivative_of_a_velocity_is_an_acceleration():
    """The point moves with the mean velocity in the step, 0.03 + 0.01 4 / 2 = 0.05 m/s."""
    found = []
    for velocity, acceleration in ((0.03, 4.0), (0.05, 0.0)):
        point = Point()
        if acceleration:
            set_rate(point, "v1", acceleration)
        found.append(point.step(0.01, v1=velocity))
    assert found[0] == pytest.approx(found[1], rel=1e-12)
    assert found[0] != pytest.approx(Point().step(0.01), rel=1e-3)


def test_states_include_the_ramp():
    point = Point()
    point.step(0.01, x1=0.0)
    point.step(0.001, x1=1e-3)
    saved, time = point.cosim.save(), point.time
    forces = []
    for _ in range(2):
        point.cosim.restore(saved)
        point.time = time
        forces.append([point.step(0.001, x1=1e-3) for _ in range(5)])
    assert forces[0] == forces[1]
    fresh = Point()
    fresh.cosim.restore(saved)
    fresh.time = time
    assert [fresh.step(0.001, x1=1e-3) for _ in range(5)] == forces[0]


def test_preloads_are_the_forces_at_rest():
    point = Point()
    names = [f"support.{end}.{{}}f{k}" for end in ("left", "right") for k in "123"]
    static, force = (
        np.array(point.cosim.get("real", [point.reference[name.format(part)] for name in names]))
        for part in ("preload.", "")
    )
    assert static[0] == pytest.approx(15000.0, rel=1e-3)
    assert force == pytest.approx(static, abs=1e-6 * 15000.0)
    point.step(0.1, x1=0.01)
    again = point.cosim.get("real", [point.reference[name.format("preload.")] for name in names])
    assert again == list(static)
