"""Residual and tangent of random motions against the equations in extended precision.

The reference is tests/support/element_reference.py. The difference is the kernel's round-off.
"""

import numpy as np
import pytest

from gallop_fmu import load_scene
from gallop_fmu.engine.model import Model
from support.element_reference import LONG, TWO_POINTS, ReferenceElement, shape_slope

SLOPING = {"span.height_difference": 80.0, "span.sag": 2.5, "ice.attack_angle_deg": 165.0}
"""Initial state prescribed as a parabola, as that of example 3; first moments given at 180 deg."""
SLACK = {"conductor.slack": "tension_only"}
SCENES = {"level": {}, "sloping, ice rotated": SLOPING, "tension only": SLACK}

LARGE_MOTION = [[0.01, 1.0, 1.0, 0.4], [0.1, 1.0, 1.0, 3.0], [1.0, 10.0, 10.0, 50.0]]
FAST_MOTION = [[1e-5, 1e-4, 1e-4, 0.4], [1e-4, 2.0, 2.0, 50.0], [1.0, 10.0, 10.0, 5000.0]]
"""Largest u, v, a of the nodes. In large motion the cable forces dominate, in fast motion those of
ice and wind."""


def reference(model):
    """Reference elements of a model of example 3, with the kernel's node positions."""
    x = model.equilibrium().x.astype(LONG)
    elements = []
    for e in range(model.elements):
        nodes = x[2 * e : 2 * e + 3]
        slopes = [shape_slope(xi) @ nodes for xi, _ in TWO_POINTS]
        horizontal = LONG(model.scene.span.horizontal_tension)
        tension = [horizontal * np.sqrt(dx @ dx) / dx[0] for dx in slopes]
        elements.append(ReferenceElement(model.scene, nodes, np.array(tension)))
    return elements


def random_motion(model, seed, scale):
    random = np.random.default_rng(seed)
    return [random.uniform(-1.0, 1.0, (model.nodes, 4)) * s for s in scale]


def of_element(motion, e):
    return [y[2 * e : 2 * e + 3].astype(LONG) for y in motion]


@pytest.mark.parametrize("scale", [LARGE_MOTION, FAST_MOTION], ids=["large", "fast"])
@pytest.mark.parametrize("changes", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("seed", range(3))
def test_residual(seed, changes, scale):
    """Example 3 has eccentric ice, wind, damping and twist; each force has its own scale."""
    model = Model(load_scene("example3").with_values(changes))
    motion = random_motion(model, seed, scale)
    expected = np.zeros((model.nodes, 4), LONG)
    for e, element in enumerate(reference(model)):
        expected[2 * e : 2 * e + 3] += element.residual(*of_element(motion, e))
    error = np.abs(model.residual(*motion) - expected).max(axis=0)
    assert np.all(error < 3e-14 * np.abs(expected).max(axis=0))  # observed up to 9e-15


@pytest.mark.parametrize("part", ["stiffness", "damping", "mass"])
@pytest.mark.parametrize("scale", [LARGE_MOTION, FAST_MOTION], ids=["large", "fast"])
@pytest.mark.parametrize("changes", SCENES.values(), ids=SCENES)
def test_tangent(changes, scale, part):
    """Complex step: dR/du = Im R(u + i h) / h, exact for so small an h.

    Each block of 4 unknowns by 4 forces has scales for each pair of them.
    """
    model = Model(load_scene("example3").with_values({"numerics.elements": 4, **changes}))
    motion = random_motion(model, 7, scale)
    found = model.tangent(*motion, **{part: 1.0})
    step, which = LONG(1e-30), ["stiffness", "damping", "mass"].index(part)
    expected = np.zeros_like(found, LONG)
    for e, element in enumerate(reference(model)):
        for column in range(12):
            moved = [y.astype(np.clongdouble) for y in of_element(motion, e)]
            moved[which].flat[column] += 1j * step
            expected[e, :, column] = (element.residual(*moved).imag / step).ravel()
    blocks = (model.elements, 3, 4, 3, 4)
    error = np.abs(found - expected).reshape(blocks).max(axis=(0, 1, 3))
    scales = np.abs(expected).reshape(blocks).max(axis=(0, 1, 3))
    assert np.all(error <= 1e-14 * scales)  # observed up to 3e-15
