"""Devices at junctions: forces, tangents and energies agree with each other."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.model import Model


def test_a_spring_holds_its_junction():
    springs = {"kind": "springs", "stiffness_x1": 3e4, "stiffness_x3": 2e3}
    scene = gf.load_scene("example3").with_values(
        {"numerics.elements": 4, "supports.left": springs, "supports.right": springs}
    )
    model = Model(scene)
    assert model.devices == ((0,), (1,))
    u = np.zeros((model.nodes, 4))
    u[-1] = [0.01, 0.02, -0.03, 0.1]
    force, kinetic, potential = model.device_force(1, u)
    assert force[0] == pytest.approx([300.0, 0.0, -60.0, 0.0])
    assert (kinetic, potential) == (0.0, pytest.approx(0.5 * (3e4 * 0.01**2 + 2e3 * 0.03**2)))
    tangent = model.device_tangent(1, u, stiffness=2.0, damping=5.0, mass=7.0)
    assert tangent[0, 0] == pytest.approx(np.diag([6e4, 0.0, 4e3, 0.0]))
    assert not model.device_force(0, u)[0].any()


def test_a_device_that_does_not_exist_is_refused():
    model = Model(gf.load_scene("example2"))
    for call in (model.device_force, model.device_tangent):
        with pytest.raises(ValueError, match=r"device = 2 must be at least 0 and at most 1"):
            call(2)
