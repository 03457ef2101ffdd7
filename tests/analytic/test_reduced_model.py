"""The reduced model against the kernel: forces, equilibrium in wind, coupling of the pair.

Its tension forces are compared in `test_motions_model.py`.
"""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu import Inputs, Model
from modal.linear.mode_basis import still_air_modes
from modal.motions.reduced_model import static_equilibrium
from modal.motions.span_model import SpanModel
from support.windy_spans import LOGARITHMIC

SPRINGS = {"kind": "springs", "stiffness_x1": 76e3, "stiffness_x3": 1400.0}
TABLE = {
    "kind": "table",
    "angle_deg": [100.0, 140.0, 180.0, 220.0, 260.0],
    "lift": [0.5, 2.0, 0.0, -2.0, -0.5],
    "drag": [1.5, 1.2, 1.0, 1.2, 1.5],
    "moment": [0.1, 0.2, 0.0, -0.2, -0.1],
}
SCENES = {
    "rigid": {},
    "sprung": {"supports.left": SPRINGS, "supports.right": SPRINGS},
    "asymmetric": {"supports.left": SPRINGS, "span.height_difference": 8.0, "span.sag": None},
    "table": {"aerodynamics": TABLE},
    "oblique": {"wind.direction_deg": 35.0, "span.height_difference": 20.0, "span.sag": None},
    "profile": {"wind.direction_deg": -20.0, "wind.profile": LOGARITHMIC},
}


@pytest.mark.parametrize("values", SCENES.values(), ids=SCENES)
def test_forces_of_wind_ice_inertia_and_damping_are_those_of_the_kernel(values):
    """Beyond the static forces of the same displacement without wind."""
    scene = gf.load_scene("example3").with_values(values)
    rest = still_air_modes(scene)
    model = SpanModel(scene, rest)
    draw = np.random.default_rng(0)
    q, v, a = (size * draw.standard_normal((3, model.size)) for size in (0.3, 0.6, 0.9))
    calm = np.zeros_like(q)
    found, static = model.forces(q, v, a, 5.5), model.forces(q, calm, calm, 0.0)
    flat = model.shapes.reshape(model.size, -1)
    inputs = Inputs(0.0, 5.5, np.radians(scene.ice.attack_angle_deg), np.zeros((2, 3)))

    def of_kernel(motion, inputs):
        residual = rest.model.residual(*motion, inputs=inputs).ravel()
        matrices = [
            rest.mesh.tangent(*motion, inputs=inputs, **{part: 1.0}).toarray()
            for part in ("stiffness", "damping", "mass")
        ]
        return flat @ residual, *(flat @ matrix @ flat.T for matrix in matrices)

    for k in range(3):
        motion = [(y[k] @ flat).reshape(-1, 4) for y in (q, v, a)]
        moving, still = of_kernel(motion, inputs), of_kernel(motion[:1], rest.mesh.still)
        for part, theirs in enumerate(moving):
            difference = found[part][k] - theirs
            if part < 2:  # residual and stiffness have tension forces
                difference -= static[part][k] - still[part]
            assert np.max(np.abs(difference)) < 2e-14 * np.max(np.abs(theirs))


@pytest.mark.parametrize("wind", [{}, SCENES["oblique"], SCENES["profile"]])
def test_the_derivative_by_the_wind_is_that_of_the_residual(wind):
    scene = gf.load_scene("example3").with_values(wind)
    model = SpanModel(scene, still_air_modes(scene))
    q, v, a = np.random.default_rng(1).standard_normal((3, 2, model.size)) * 0.3
    ahead, back = (model.forces(q, v, a, speed).residual for speed in (5.5 + 1e-4, 5.5 - 1e-4))
    slope = model.forces(q, v, a, 5.5).by_wind
    assert slope == pytest.approx((ahead - back) / 2e-4, abs=1e-7 * np.max(np.abs(slope)))


def test_shapes_are_orthonormal_in_the_mass():
    scene = gf.load_scene("example3")
    model = SpanModel(scene, still_air_modes(scene))
    mass = (
        model.shapes.reshape(model.size, -1)
        @ model.modes.mass
        @ model.shapes.reshape(model.size, -1).T
    )
    assert mass == pytest.approx(np.eye(model.size), abs=1e-12)
    assert 2.0 * np.pi * np.array([0.69541, 0.37752]) == pytest.approx(model.frequencies, rel=2e-5)


def test_the_equilibrium_in_the_wind_is_that_of_the_kernel():
    scene = gf.load_scene("example3")
    model = SpanModel(scene, still_air_modes(scene))
    q, _ = static_equilibrium(model, 5.5)
    kernel = Model(scene)
    exact = kernel.rest().motion()[0][kernel.middle]
    # observed 1.3e-4 of 0.0608 m, drag
    assert q[0] @ model.middle == pytest.approx(exact, abs=2e-4)


@pytest.mark.parametrize("sag", [1.4, 2.15, 2.8])
def test_the_coupling_is_the_dynamic_over_the_static_tension(sag):
    """h/H per metre of a shallow cable: (EA/Le) (8 sag/L^2) integral of the mode / H."""
    scene = gf.load_scene("example3").with_values({"span": {"length": 125.88, "sag": sag}})
    state = Model(scene).equilibrium()
    first = next(m for m in modal.natural_modes(scene) if m.family == "vertical" and m.symmetric)
    wave = first.shape[:, 1] / first.shape[len(first.shape) // 2, 1]
    length = scene.span.length
    effective = length * (1.0 + 8.0 * (state.sag / length) ** 2)
    area = np.trapezoid(wave, state.x[:, 0])
    per_metre = scene.conductor.axial_stiffness / effective * 8.0 * state.sag / length**2 * area
    found = modal.quadratic_coupling(scene).modulation
    assert found == pytest.approx(
        -per_metre / state.horizontal_tension, rel=0.003
    )  # observed up to 1.7e-3; upwards slackens
