"""Sections that rotate several turns: divergence, flutter, galloping beyond the curve."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.simulation.energy_balance import account
from support.taut_span import taut_span

TURN = 2.0 * math.pi
ALL = np.arange(len(NODE_CHANNELS), dtype=np.int32)
AROUND = {
    "kind": "table", "outside": "periodic", "angle_deg": [15.0 * k for k in range(25)],
    "lift": [math.sin(2 * math.radians(15.0 * k)) for k in range(24)] + [0.0],
    "drag": [1.2 - 0.4 * math.cos(2 * math.radians(15.0 * k)) for k in range(24)] + [0.8],
    "moment": [0.3 * math.sin(math.radians(15.0 * k)) for k in range(24)] + [0.0],
}  # fmt: skip


def iced(**values):
    """Example 3, with eccentric ice, and a coefficient table of a full turn."""
    return load_scene("example3").with_values({"aerodynamics": AROUND, **values})


@pytest.mark.parametrize("turns", [1, -3, 1000])
def test_full_turns_change_nothing(turns):
    """Full turns of the section, even along the span: ice, gravity and wind see the remainder."""
    model, random = Model(iced()), np.random.default_rng(1)
    u, v, a = (
        random.uniform(-1.0, 1.0, (model.nodes, 4)) * [0.01, 0.5, 0.5, 2.0] for _ in range(3)
    )
    turned = u + np.array([0.0, 0.0, 0.0, TURN * turns])
    forces = model.residual(u, v, a)
    bound = 5e-13 * abs(turns)  # N, N m; of forces up to 4e5 N
    assert (
        np.abs(model.residual(turned, v, a) - forces).max() < bound
    )  # observed 1.1e-13, 2.7e-13, 6.6e-11
    wind = [Inputs(0.0, 9.0, angle, np.zeros((2, 3))) for angle in (1.0, 1.0 + TURN * turns)]
    one, other = (model.residual(u, v, a, inputs=inputs) for inputs in wind)
    assert np.abs(one - other).max() < bound  # observed 0, 1.8e-15, 1.5e-11


@pytest.mark.parametrize("integrator", ["newmark", "gauss6"])
def test_a_section_that_oscillates_through_several_turns_keeps_its_energy(integrator):
    """Three turns in each direction, with eccentric ice."""
    scene = iced(**{
        "wind.speed": 0.0, "damping.translation": None, "damping.twist": None,
        "initial.seed_twist": 3.0 * TURN,
        "initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0, "numerics.time_step": 5e-4,
        "numerics.newton_tolerance": 1e-9,
        "numerics.integrator": integrator,
    })  # fmt: skip
    model = Model(scene)
    state = model.start()
    start = state.observe_span()
    run = state.run(1000, 2, ALL, np.array([model.middle], np.int32))
    assert run.report.outcome is Outcome.COMPLETED
    twist = run.node_values[:, NODE_INDEX["theta"], 0]
    assert twist.min() < -2.0 * TURN
    assert twist.max() > 2.0 * TURN
    energy = sum(
        run.span_values[:, SPAN_INDEX[f"{kind}_energy"]] for kind in ("kinetic", "potential")
    )
    before = start[SPAN_INDEX["kinetic_energy"]] + start[SPAN_INDEX["potential_energy"]]
    bound = {"newmark": 4e-5, "gauss6": 2.5e-6}[integrator]  # observed 1.2e-5, 7.4e-7
    assert np.abs(energy / before - 1.0).max() < bound


def test_an_attack_angle_that_runs_round_the_circle():
    """A torque winds up mid-span by several turns in wind: the energy balance closes."""
    law = {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": 4.0}
    scene = iced(**{
        "loads": [{"position": 0.5, "force": [0.0, 0.0, 0.0], "torque": 160.0, "law": law}],
        "wind.speed": 8.0,
    })  # fmt: skip
    model = Model(scene)
    state, nodes = model.start(), np.arange(model.nodes, dtype=np.int32)
    first = (
        np.array([state.observe_node(node) for node in nodes]).T[None],
        state.observe_span()[None],
    )
    run = state.run(1000, 1, ALL, nodes)
    assert run.report.outcome is Outcome.COMPLETED
    values = np.concatenate([first[0], run.node_values]).transpose(0, 2, 1)
    assert (
        values[:, model.middle, NODE_INDEX["angle_of_attack"]].max() > math.pi + 4.0 * TURN
    )  # observed 5.1 turns
    span, step = np.concatenate([first[1], run.span_values]), scene.numerics.time_step
    balance = account(model, step * np.arange(len(span)), values[..., :12], span)
    assert np.abs(balance.wind).max() > 20.0  # J; observed 26
    assert balance.worst < 5e-6  # observed 1.5e-6


def taut(aerodynamics, speed, **values):
    """A nearly weightless string and shaft, whose modes are sines."""
    curve = {"kind": "polynomial", "valid_from_deg": -60.0, "valid_to_deg": 60.0, "drag": [0.0]}
    sections = {
        "wind": {"speed": speed, "air_density": 1.25},
        "aerodynamics": {**curve, "reference_radius": 1e-9, **aerodynamics},
        "numerics": {"time_step": 2e-3, "newton_tolerance": 1e-13},
    }
    return taut_span(
        span={"gravity": 0.01},
        conductor={"axial_stiffness": 4e6, "torsional_stiffness": 13.2},
        **(sections | values),
    )


SLOPE = 0.2  # of the moment, per radian
OMEGA = math.pi / 100.0 * math.sqrt(13.2 / 1.5e-4)  # of the twist [rad/s]
DIVERGENCE = OMEGA * math.sqrt(
    1.5e-4 / (0.5 * 1.25 * 0.028**2 * SLOPE)
)  # [m/s], q d^2 CM' = GJ (pi / L)^2


def test_below_divergence_the_twist_oscillates():
    scene = taut(
        {"lift": [0.0], "moment": [0.0, SLOPE]}, 0.97 * DIVERGENCE, initial={"seed_twist": 1e-4}
    )
    twist = gf.simulate(scene, stop_time=10.0).midspan().theta.values
    assert np.abs(twist).max() == pytest.approx(1e-4, rel=1e-6)
    steady = np.flatnonzero(np.diff(np.sign(twist)))
    found = math.pi / (np.mean(np.diff(steady)) * scene.numerics.time_step)
    assert found == pytest.approx(OMEGA * math.sqrt(1.0 - 0.97**2), rel=5e-5)  # observed 1.6e-5


def test_divergence_ends_where_the_curve_ends():
    """Above it the twist grows as cosh; the run reports when it left the curve."""
    scene = taut(
        {"lift": [0.0], "moment": [0.0, SLOPE]}, 1.1 * DIVERGENCE, initial={"seed_twist": 1e-4}
    )
    result = gf.simulate(scene, stop_time=20.0, on_failure="return")
    assert result.outcome is Outcome.ANGLE_OUT_OF_RANGE
    growth = OMEGA * math.sqrt(1.1**2 - 1.0)
    time, twist = result.dataset.time.values, result.midspan().theta.values
    late = twist > 0.01
    assert np.polyfit(time[late], np.log(twist[late]), 1)[0] == pytest.approx(
        growth, rel=1e-5
    )  # observed 3e-6
    end = math.acosh(math.radians(60.0) / 1e-4) / growth
    assert result.report.time == pytest.approx(end, abs=scene.numerics.time_step)  # observed 0.0003
    assert time[-1] == pytest.approx(result.report.time - scene.numerics.time_step, abs=1e-9)


MOMENT, LIFT, CENTRE = -0.2, 4.0, 0.006  # slopes per radian; first moment of the ice about x1, kg


def flutter_roots(speed):
    """Eigenvalues [1/s] of the typical section: plunge and twist, coupled by ice and lift."""
    d, q = 0.028, 0.5 * 1.25 * 0.028
    mass = np.array([[1.5, -CENTRE], [-CENTRE, 1.5e-4]])
    wind = q * speed**2 * np.array([[0.0, LIFT], [0.0, d * MOMENT]])
    stiffness = (math.pi / 100.0) ** 2 * np.diag([92000.0, 13.2]) - wind
    damping = q * speed * np.array([[LIFT, 0.0], [d * MOMENT, 0.0]])
    zero, one = np.zeros((2, 2)), np.eye(2)
    return np.linalg.eigvals(np.block([
        [zero, one], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
    ]))  # fmt: skip


def flutter_onset():
    speeds = np.arange(1.0, 60.0, 0.01)
    return speeds[np.argmax([flutter_roots(speed).real.max() > 1e-9 for speed in speeds])]


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_classical_flutter(factor):
    """Plunge and twist of one frequency: growth and frequencies are those of the eigenproblem."""
    speed = factor * flutter_onset()
    scene = taut(
        {"lift": [0.0, LIFT], "moment": [0.0, MOMENT]}, speed, ice={"first_moment_x3": CENTRE},
        initial={"seed_vertical": 1e-5, "seed_twist": 1e-4},
    )  # fmt: skip
    model = Model(scene)
    state = model.start()
    channels = np.array([NODE_INDEX[name] for name in ("u2", "theta", "v2", "omega")], np.int32)
    z = state.run(1000, 1, channels, np.array([model.middle], np.int32)).node_values[:, :, 0]
    z = z / np.abs(z).max(axis=0)
    step, *_ = np.linalg.lstsq(z[:-1], z[1:], rcond=None)
    found = np.log(np.linalg.eigvals(step).astype(complex)) / scene.numerics.time_step
    expected = flutter_roots(speed)
    order = [np.argmin(np.abs(found - root)) for root in expected]
    assert np.abs(found[order] - expected).max() < 1e-4 * np.abs(expected).max()  # observed 3.3e-5
    assert (expected.real.max() > 0.01) == (factor > 1.0)
    assert (found.real.max() > 0.01) == (factor > 1.0)


def test_galloping_outgrows_its_curve():
    """Measured from -15 to 35 degrees: the run ends there, equal up to then to the whole curve."""
    whole = load_scene("example2").with_values({"initial.seed_vertical": 0.2})
    part = whole.with_values(
        {"aerodynamics.valid_from_deg": -15.0, "aerodynamics.valid_to_deg": 35.0}
    )
    ended = gf.simulate(
        part, stop_time=200.0, record_every=1, record_nodes="all", on_failure="return"
    )
    assert ended.outcome is Outcome.ANGLE_OUT_OF_RANGE
    assert 10.0 < ended.report.time < 200.0
    assert ended.report.element is not None
    time = ended.dataset.time.values
    assert time[-1] == pytest.approx(ended.report.time - part.numerics.time_step, abs=1e-9)
    angle = np.degrees(ended.dataset.angle_of_attack.values)
    amplitude = np.abs(ended.dataset.u2.values).max(axis=1)
    assert amplitude[-500:].max() > 1.5 * amplitude[:500].max()
    assert angle.min() > -15.5
    assert angle.max() < 35.5
    assert min(35.0 - angle[-500:].max(), angle[-500:].min() + 15.0) < 1.0  # observed 0.05 deg
    full = gf.simulate(whole, stop_time=float(time[-1]), record_every=1, record_nodes="all")
    for name in ("u2", "u3", "theta", "tension"):
        one, other = full.dataset[name].values[: len(time)], ended.dataset[name].values
        # observed 6e-8: the centre of the range is rounded otherwise, and Newton's tolerance is
        # 1e-9
        assert np.abs(one - other).max() < 1e-6 * np.abs(one).max()
