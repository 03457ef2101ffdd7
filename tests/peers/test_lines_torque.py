"""Static torque on a spacer of a quad bundle against OpenSees.

The torque follows the frame. The numbers of the specification belong to forces that keep their
direction, in increments of 20 N m; `repeated` in the stored case has both.
"""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from support.line_references import line_scene, stored

ELEMENTS = 40


def turn(model, state):
    """Turn [rad] of the bundle at mid-span about its centre."""
    nodes = [chain.middle for chain in model.map.bundle(1)]
    strung = model.equilibrium().x[nodes, 1:]
    arms = strung - strung.mean(axis=0)
    moved = arms + state.motion()[0][nodes, 1:3]
    moved -= moved.mean(axis=0)
    cross = arms[:, 0] * moved[:, 1] - arms[:, 1] * moved[:, 0]
    return float(np.arctan2(cross.sum(), (arms * moved).sum()))


@pytest.mark.parametrize("number", range(5))
def test_turn_under_a_torque(number):
    case = stored("bundle_torque_quad_300m")
    case["scene"]["bundle"]["clamp_torsional_stiffness"] = 1e6
    torque = case["results"]["torque_n_m"][number]
    load = {"span": 1, "position": 0.5, "force": [0.0, 0.0, 0.0], "torque": 0.25 * torque}
    model = Model(line_scene(case, ELEMENTS, loads=[load]))
    found = np.degrees(turn(model, model.rest()))
    wanted = case["repeated"]["turn_deg_follower_torque"][number]
    assert found == pytest.approx(wanted, rel=3.5e-4)  # 2.7e-4: mesh of OpenSees
