"""A conductor that is described as several chains moves as it does as one."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CChain, CJunction, Three
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.pack import Packed
from gallop_fmu.foundation.channels import NODE_INDEX
from support.line_models import LineModel

ELEMENTS, STEP = 12, 0.02
GUSTS = {"kind": "harmonic", "mean": 8.0, "amplitude": 5.0, "frequency_hz": 0.4}
CHANNELS = [NODE_INDEX[name] for name in ("u1", "u2", "u3", "theta", "tension")]

TENSION = len(CHANNELS) - 1
BOUNDS = {"newmark": 5e-9, "generalised alpha": 3e-9, "gauss": 1e-9, "tolerance": 2e-7}
"""Seen: 1.3e-9, 6.8e-10, 2.6e-10, 4.4e-8 of the largest value; Newton's tolerance is 1e-11 m."""

INTEGRATORS = {
    "newmark": {},
    "generalised alpha": {"numerics.integrator": "generalised_alpha"},
    "gauss": {"numerics.integrator": "gauss6"},
    "tolerance": {"numerics.integrator": "gauss6", "numerics.tolerance": 1e-6},
}


def level_span(**values):
    """Example 3's conductor on a level span in gusts, with its tension given."""
    common = {
        "span.sag": None,
        "span.horizontal_tension": 15e3,
        "numerics.elements": ELEMENTS,
        "numerics.time_step": STEP,
        "numerics.newton_tolerance": 1e-11,
        "initial.seed_vertical": 0.0,
        "initial.seed_horizontal": 0.0,
        "wind.speed": None,
        "wind.history": GUSTS,
    }
    return gf.load_scene("example3").with_values(common | values)


def split(scene, parts):
    """The same span as `parts` chains, which free junctions join."""
    whole = Model(scene)
    x = whole.equilibrium().x
    packed = Packed(scene)
    left, right = packed.tables["junction"]
    per = ELEMENTS // parts
    joints = []
    for k in range(1, parts):
        joint = CJunction(position=Three(*x[2 * per * k]))
        joint.motion[:] = (-1, -1, -1)
        joints.append(joint)
    packed.tables["junction"] = [left, *joints, right]
    for device in packed.tables["device"]:
        device.junction[0] = parts if device.junction[0] == 1 else 0
    packed.tables["chain"] = []
    for k in range(parts):
        chain = CChain(elements=per, horizontal_tension=scene.span.horizontal_tension)
        chain.junction[:] = (k, k + 1)
        packed.tables["chain"].append(chain)
    packed.scene = packed.c_scene()
    nodes = np.concatenate(
        [k * (2 * per + 1) + np.arange(2 * per + (k == parts - 1)) for k in range(parts)]
    )
    return whole, LineModel(scene, packed), nodes


def records(model, nodes, steps=150, every=5):
    run = model.start().run(steps // every, every, CHANNELS, nodes)
    assert run.report.outcome.name == "COMPLETED"
    return run.node_values


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("parts", [2, 3, 4])
def test_a_span_of_several_chains_moves_as_one(integrator, parts):
    """The junctions between are free: they couple the chains by the banded solver alone."""
    scene = level_span(**INTEGRATORS[integrator])
    whole, line, nodes = split(scene, parts)
    wanted, found = records(whole, np.arange(whole.nodes)), records(line, nodes)
    assert np.abs(wanted).max(axis=(0, 2))[1:4].min() > 0.01
    joints = np.isin(np.arange(whole.nodes), [2 * ELEMENTS * k // parts for k in range(parts)])
    for k in range(len(CHANNELS)):
        scale = np.abs(wanted[:, k]).max()
        apart = np.abs(found[:, k] - wanted[:, k])
        if k == TENSION:  # at an end of a chain, it is that of one element instead of the mean
            apart = apart[:, ~joints]
        assert apart.max() < BOUNDS[integrator] * scale


def test_the_force_is_known_at_every_junction():
    """A free junction loads no tower; the forces at the ends are those of the undivided span."""
    whole, line, _ = split(level_span(), 3)
    states = [model.start() for model in (whole, line)]
    for state in states:
        state.advance(3.0)
    wanted, found = (
        np.array([state.observe_junction(j) for j in range(state.model.junctions)])
        for state in states
    )
    assert np.abs(found[1:3]).max() < 1e-6 * np.abs(wanted).max()
    assert found[[0, 3]] == pytest.approx(wanted, abs=1e-6 * np.abs(wanted).max())


def test_the_nodes_of_junctions_are_known():
    """The left end of a chain follows the right end of the one before."""
    _, line, _ = split(level_span(), 3)
    per_chain = 2 * ELEMENTS // 3 + 1
    node, leader = line.junction_nodes()
    assert node.tolist() == [0, per_chain - 1, 2 * per_chain - 1, 3 * per_chain - 1]
    wanted = np.arange(line.nodes)
    wanted[[per_chain, 2 * per_chain]] -= 1
    assert (leader == wanted).all()
