"""Forces on the towers, and towers that move."""

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.fmu import export_fmu
from gallop_fmu.foundation.channels import NODE_INDEX

FORCES = [f"support.{end}.f{axis}" for end in ("left", "right") for axis in (1, 2, 3)]


@pytest.fixture(scope="module")
def quiet_scene(rigid_scene):
    """Still air, no seed, strong damping of the slow modes."""
    damping = {"low_ratio": 0.3, "low_frequency": 0.3, "high_ratio": 0.3, "high_frequency": 3.0}
    values = {"wind.speed": 0.0, "initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0}
    return rigid_scene.with_values({**values, "damping.translation": damping})


@pytest.fixture(scope="module")
def quiet_fmu(quiet_scene, runtime, tmp_path_factory):
    return export_fmu(quiet_scene, tmp_path_factory.mktemp("fmu") / "quiet.fmu", runtime=runtime)


def test_forces_start_at_the_static_reaction(quiet_scene, quiet_fmu, host):
    fmu = host(quiet_fmu).start()
    static = Model(quiet_scene).equilibrium().support_force
    assert [fmu[name] for name in FORCES] == pytest.approx(static.ravel(), rel=1e-12, abs=1e-9)
    assert fmu["support.left.f1"] == pytest.approx(
        15000.0, rel=1e-3
    )  # the cable pulls the left tower inwards
    assert fmu["support.right.f1"] == pytest.approx(-15000.0, rel=1e-3)


def test_a_tower_that_moves_slowly_leads_to_the_new_equilibrium(quiet_scene, quiet_fmu, host):
    fmu = host(quiet_fmu).start()
    moved = np.array([[-0.02, 0.0, 0.0], [0.01, 0.0, 0.05]])
    for k in range(1, 201):
        share = min(1.0, k / 100)
        fmu.set(
            support__left__x1=-0.02 * share,
            support__right__x1=0.01 * share,
            support__right__x3=0.05 * share,
        )
        fmu.step(0.2)
    model = Model(quiet_scene)
    rest = model.rest(0.0, Inputs(0.0, 0.0, np.pi, moved)).observe_node(model.middle)
    before = model.equilibrium().horizontal_tension
    wanted = rest[NODE_INDEX["tension"]]
    assert wanted - before > 1000.0  # observed: 1935 N
    assert fmu["midspan.tension"] == pytest.approx(wanted, rel=2e-9)  # observed: 2e-10
    assert fmu["midspan.x2"] == pytest.approx(rest[NODE_INDEX["u2"]], rel=1e-8)  # observed: 1e-9
    assert fmu["midspan.x3"] == pytest.approx(
        rest[NODE_INDEX["u3"]], rel=1e-6
    )  # observed: 2e-7, what is left of the swing


def test_a_tower_moves_linearly_and_arrives_at_the_end_of_the_step(quiet_scene, quiet_fmu, host):
    fmu = host(quiet_fmu).start()
    state = Model(quiet_scene).start()
    tower = np.zeros((2, 3))
    for target in (0.004, 0.004, -0.002):
        wanted = np.zeros((2, 3))
        wanted[0, 0] = target
        fmu["support.left.x1"] = target
        begin = fmu.time
        fmu.step(0.05)
        state.advance(
            fmu.time, Inputs(begin, 0.0, np.pi, tower, support_rate=(wanted - tower) / 0.05)
        )
        tower = wanted
        assert state.observe_node(0)[NODE_INDEX["u1"]] == pytest.approx(target, abs=1e-15)
        tension = state.observe_node(state.model.middle)[NODE_INDEX["tension"]]
        assert fmu["midspan.tension"] == pytest.approx(tension, rel=1e-9)


def test_a_displacement_before_the_start_is_static(quiet_scene, quiet_fmu, host):
    fmu = host(quiet_fmu).start(support__left__x1=-0.02)
    tower = np.array([[-0.02, 0.0, 0.0], [0.0, 0.0, 0.0]])
    model = Model(quiet_scene)
    rest = model.rest(0.0, Inputs(0.0, 0.0, np.pi, tower)).observe_node(model.middle)[
        NODE_INDEX["tension"]
    ]
    assert fmu["midspan.tension"] == pytest.approx(rest, rel=1e-9)
    fmu.step(0.05, 20)
    assert fmu["midspan.tension"] == pytest.approx(rest, rel=1e-6)
