"""Forces on the towers: momentum balance in motion, quasi-static tower motion, springs."""

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.scene import Scene

FORCES = [SPAN_INDEX[f"{end}_f{axis}"] for end in ("left", "right") for axis in (1, 2, 3)]


def momentum_rate(model, a):
    """Rate of the linear momentum [N] from the consistent mass matrix, summed over all nodes."""
    blocks = model.tangent(None, None, None, mass=1.0)
    total = np.zeros((model.nodes, 4))
    for e, block in enumerate(blocks):
        total[2 * e : 2 * e + 3] += (block @ a[2 * e : 2 * e + 3].ravel()).reshape(3, 4)
    return total[:, :3].sum(axis=0)


@pytest.mark.parametrize("supports", ["rigid", "springs"])
def test_forces_on_the_towers_balance_momentum(supports):
    """Sum of support forces = weight + loads - rate of momentum, without wind and mass damping."""
    scene = load_scene("example2" if supports == "springs" else "example1")
    values = {"wind.speed": 0.0, "damping.translation": None, "damping.twist": None,
        "ice.first_moment_x2": 0.0,
              "ice.first_moment_x3": 0.0, "span.sag": None, "span.horizontal_tension": 21730.0,
              "numerics.newton_tolerance": 1e-14}  # fmt: skip
    law = {"kind": "pulse", "peak": 1.0, "rise": 0.5, "fall_start": 0.5, "fall": 0.5}
    load = {"position": 0.31, "force": [30.0, 100.0, 150.0], "torque": 1.0, "law": law}
    model = Model(scene.with_values(values | {"loads": [load]}))
    weight = model.equilibrium().support_force.sum(axis=0)
    state = model.start()
    for time in (0.0, 0.21, 0.5, 0.77, 1.5, 3.2):
        if time:
            state.advance(time)
        found = state.observe_span()[FORCES].reshape(2, 3).sum(axis=0)
        force = np.array([30.0, 100.0, 150.0]) * float(model.scene.loads[0].law.at(time))
        expected = weight + force - momentum_rate(model, state.motion()[2])
        assert np.abs(found - expected).max() < 1e-11 * abs(weight[1])  # observed 1e-12


@pytest.mark.parametrize(
    ("axis", "bound"), [(0, 4e-4), (1, 8e-3), (2, 1e-3)]
)  # observed 9e-5, 2e-3, 3e-4
def test_slow_motion_of_the_right_tower_changes_tension_as_in_statics(
    span, exact_cable, axis, bound
):
    """An undamped cosine of 400 s, seventy times slower than the first mode, from rest."""
    amplitude = (0.15, 1.0, 1.0)[axis]
    law = {
        "kind": "harmonic",
        "mean": amplitude,
        "amplitude": amplitude,
        "frequency_hz": 1.0 / 400.0,
        "phase_deg": -90.0,
    }
    motion = {"kind": "rigid", "motion": {f"x{axis + 1}": law}}
    values = {"supports": {"right": motion}, "numerics": {"time_step": 0.05}}
    scene = Scene.from_dict(span | values)
    model, cable = Model(scene), exact_cable(scene)
    state, at_rest = model.start(), cable.solve()[0]
    errors, changes = [], []
    for time in np.arange(50.0, 401.0, 50.0):
        state.advance(float(time))
        shift = np.zeros(3)
        shift[axis] = amplitude * (1.0 - np.cos(2.0 * np.pi * time / 400.0))
        exact = cable.solve(right=shift)[0]
        errors.append(np.linalg.norm(state.observe_span()[FORCES[:3]] - exact))
        changes.append(np.linalg.norm(exact - at_rest))
    assert max(errors) < bound * max(changes)


def test_displaced_towers_at_rest(span, exact_cable):
    """Static equilibrium under support displacement is that of the exact cable."""
    scene = Scene.from_dict(span)
    left, right = np.array([0.1, -1.0, 0.5]), np.array([-0.4, 2.0, 3.0])
    inputs = Inputs(0.0, 0.0, 0.0, np.array([left, right]))
    first, last, place = exact_cable(scene).solve(left=left, right=right, at=(0.5,))
    for state in (Model(scene).rest(inputs=inputs), Model(scene).start(inputs=inputs)):
        found, model = state.observe_span()[FORCES], state.model
        middle = model.equilibrium().x[model.middle] + state.observe_node(model.middle)[:3]
        assert np.abs(found - [*first, *-last]).max() < 5e-8 * 20000.0  # observed 1.4e-8
        assert np.abs(middle - place[0]).max() < 4e-8  # observed 9e-9 m


def test_springs_yield_by_force_change_over_stiffness(span, exact_cable):
    """Preloaded by the initial reaction, a spring moves by force change over stiffness."""
    springs = {"kind": "springs", "stiffness_x1": 40000.0, "stiffness_x3": 3000.0}
    loads = [{"evenly_spaced": 29, "force": [0.0, -40.0, 30.0]}]
    scene = Scene.from_dict(
        span
        | {
            "supports": {"left": springs, "right": springs},
            "loads": loads,
            "numerics": {"elements": 30},
        }
    )
    model = Model(scene)
    assert np.array_equal(model.equilibrium().support_stiffness, [[40000.0, 3000.0]] * 2)
    state = model.rest()
    found = state.observe_span()[FORCES].reshape(2, 3)
    change = found - model.equilibrium().support_force
    ends = np.array([state.observe_node(node)[:3] for node in (0, model.nodes - 1)])
    np.testing.assert_allclose(ends[:, 0], change[:, 0] / 40000.0, rtol=1e-10)
    np.testing.assert_allclose(ends[:, 2], change[:, 2] / 3000.0, rtol=1e-10)
    points = [(k / 30, np.array([0.0, -40.0, 30.0])) for k in range(1, 30)]
    first, last, _ = exact_cable(scene, points=points).solve(left=ends[0], right=ends[1])
    assert np.abs(found - [first, -last]).max() < 1e-8 * np.abs(change).max()  # observed 2.4e-9


def test_adjacent_span_gives_the_published_stiffness(span):
    """Equations (23) and (24) of Liu, Yan, Zhang, Zhou (2009)."""
    adjacent = {
        "kind": "adjacent_span", "adjacent_span": 250.0, "adjacent_tension": 18000.0,
        "insulator_length": 2.5,
        "insulator_weight": 900.0,
    }  # fmt: skip
    found = (
        Model(Scene.from_dict(span | {"supports": {"left": adjacent}}))
        .equilibrium()
        .support_stiffness
    )
    weight = 1.6 * 9.81
    pendulum = (weight * 300.0 + 900.0 / 2.0) / 2.5
    along = 1.0 / (250.0 / 3e7 + weight**2 * 250.0**3 / (12.0 * 18000.0**3)) + pendulum
    np.testing.assert_allclose(
        found, [[along, pendulum + 2.0 * 18000.0 / 250.0], [0.0, 0.0]], rtol=1e-14
    )


def test_ends_of_a_rigid_span_stay_and_follow_their_motion(span):
    law = {"kind": "ramp", "initial": 0.0, "final": 0.2, "duration": 2.0}
    left = {"kind": "rigid", "motion": {"x1": law, "x2": law, "x3": law}}
    model = Model(Scene.from_dict(span | {"supports": {"left": left}}))
    state = model.start()
    state.advance(1.3)
    ends = state.motion()[0][[0, -1]]
    expected = float(model.scene.supports.left.motion.x1.at(1.3))
    np.testing.assert_allclose(ends, [[expected, expected, expected, 0.0], [0.0] * 4], rtol=1e-14)
    assert state.observe_node(0)[NODE_INDEX["theta"]] == 0.0


def test_a_load_acts_at_once_although_a_tower_is_displaced():
    """The start is the equilibrium without loads, with displaced towers as without.

    Before, a displaced tower put the loads into the equilibrium: 0.38 m lower here.
    """
    values = {
        "supports.left": {"kind": "rigid", "motion": {"x1": {"kind": "constant", "value": -0.02}}},
        "supports.right": {"kind": "rigid"},
        "wind.speed": 0.0,
        "initial.seed_vertical": 0.0,
    }
    bare = load_scene("example3").with_values(values)
    load = {
        "position": 0.5,
        "force": [0.0, -500.0, 0.0],
        "law": {"kind": "constant", "value": 1.0},
    }
    loaded = Scene.from_dict(bare.model_dump(mode="json") | {"loads": [load]})
    starts = [Model(scene).start().motion() for scene in (bare, loaded)]
    np.testing.assert_array_equal(starts[0][0], starts[1][0])
    middle = Model(bare).middle
    assert abs(starts[0][2][middle, 1]) < 1e-3  # [m/s^2], seen 5.5e-5
    assert starts[1][2][middle, 1] < -10.0  # seen -75
