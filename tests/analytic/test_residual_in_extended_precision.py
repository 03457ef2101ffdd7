"""The out-of-balance forces of a random motion against the published equations, written down a second time.

Element by element, in numpy's longdouble: 64 bits of mantissa on x86, where the difference is the
kernel's round-off.
"""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.input.scene_files import load_scene

LONG = np.longdouble
ROOT = np.sqrt(LONG(3) / 5)
TWO_POINTS = [(-1 / np.sqrt(LONG(3)), LONG(1)), (1 / np.sqrt(LONG(3)), LONG(1))]
THREE_POINTS = [(-ROOT, LONG(5) / 9), (LONG(0), LONG(8) / 9), (ROOT, LONG(5) / 9)]


def shape(xi):
    return np.array([xi * (xi - 1) / 2, 1 - xi * xi, xi * (xi + 1) / 2])


def slope(xi):
    return np.array([xi - LONG(1) / 2, -2 * xi, xi + LONG(1) / 2])


def rayleigh(pair):
    x1, x2 = LONG(pair.low_ratio), LONG(pair.high_ratio)
    w1, w2 = (2 * LONG(np.pi) * LONG(f) for f in (pair.low_frequency, pair.high_frequency))
    square = w2**2 - w1**2
    return 2 * w1 * w2 * (x1 * w2 - x2 * w1) / square, 2 * (x2 * w2 - x1 * w1) / square


def polynomial(coefficients, x):
    return sum(LONG(c) * x**power for power, c in enumerate(coefficients))


def section_forces(scene, tangent, theta, omega, rate, v, a):
    """Force along x1, x2, x3 and moment of eccentric ice less those of the wind (Liu et al. 2009, eq. 8, 17, 20, 21).

    The equations hold in the plane normal to the conductor, so with the components along its normal
    n2 = e3 x t.
    """
    ice, air = scene.ice, scene.aerodynamics
    normal = np.array([-tangent[1], tangent[0], LONG(0)])
    v, a = ([0, normal @ y[:3], y[2]] for y in (v, a))
    turn = (
        LONG(ice.attack_angle_deg - (ice.first_moment_angle_deg or ice.attack_angle_deg))
        * LONG(np.pi)
        / 180
    )
    given = LONG(ice.first_moment_x2), LONG(ice.first_moment_x3)
    s3 = given[0] * np.cos(turn) - given[1] * np.sin(turn)
    s2 = given[0] * np.sin(turn) + given[1] * np.cos(turn)
    c2 = s3 * np.cos(theta) - s2 * np.sin(theta)
    c3 = s3 * np.sin(theta) + s2 * np.cos(theta)
    inertia = np.array([
        -c3 * rate - c2 * omega**2,
        c2 * rate - c3 * omega**2,
        -c3 * a[1] + c2 * a[2] - LONG(scene.span.gravity) * normal[1] * (c3 - s2),
    ])  # fmt: skip
    d = LONG(scene.conductor.diameter)
    w2, w3 = -v[1] - d / 2 * omega, LONG(scene.wind.speed) - v[2]
    ur = np.sqrt(w2**2 + w3**2)
    x = LONG(ice.attack_angle_deg - air.centre_deg) * LONG(np.pi) / 180 + theta + np.arctan2(w2, w3)
    cl, cd, cm = (polynomial(c, x) for c in (air.lift, air.drag, air.moment))
    q = LONG(scene.wind.air_density) * d * ur / 2
    f2, f3, moment = inertia - np.array(
        [q * (cl * w3 + cd * w2), q * (cd * w3 - cl * w2), q * ur * d * cm]
    )
    return np.array([*(f2 * normal[:2]), f3, moment])


def element_forces(scene, x, tension, u, v, a):
    """Out-of-balance forces (3, 4) of one element; `tension` at the two stiffness points."""
    conductor = scene.conductor
    ea, gj = LONG(conductor.axial_stiffness), LONG(conductor.torsional_stiffness)
    mass = LONG(conductor.mass_per_length) + LONG(scene.ice.mass_per_length)
    spin = LONG(conductor.torsional_inertia) + LONG(scene.ice.torsional_inertia)
    b, bt = rayleigh(scene.damping.translation), rayleigh(scene.damping.twist)
    r = np.zeros((3, 4), LONG)
    for (xi, weight), t0 in zip(TWO_POINTS, tension, strict=True):
        jacobian = np.sqrt(np.sum((slope(xi) @ x) ** 2))
        n = slope(xi) / jacobian
        p0, du, dv = n @ x, n @ u, n @ v
        strain = p0 @ du[:3] + du[:3] @ du[:3] / 2
        force = np.zeros(4, LONG)
        for initial in (False, True):  # the initial state is in balance
            sign, t, p = (-1, t0, p0) if initial else (1, t0 + ea * strain, p0 + du[:3])
            force[:3] += sign * t * p
        force[:3] += b[1] * (ea * p0 * (p0 @ dv[:3]) + t0 * dv[:3])
        force[3] = gj * (du[3] + bt[1] * dv[3])
        r += weight * jacobian * np.outer(n, force)
    for xi, weight in THREE_POINTS:
        n, jacobian = shape(xi), np.sqrt(np.sum((slope(xi) @ x) ** 2))
        at_u, at_v, at_a = n @ u, n @ v, n @ a
        force = np.zeros(4, LONG)
        force[:3] = mass * (at_a[:3] + b[0] * at_v[:3])
        force[3] = spin * (at_a[3] + bt[0] * at_v[3])
        force += section_forces(
            scene, slope(xi) @ x / jacobian, at_u[3], at_v[3], at_a[3], at_v, at_a
        )
        r += weight * jacobian * np.outer(n, force)
    return r


SLOPING = {"span.height_difference": 80.0, "span.sag": 2.5, "ice.attack_angle_deg": 165.0}
"""Held on a parabola as example 3 is; the first moments are given at 180 deg."""
WIDE = [[0.01, 1.0, 1.0, 0.4], [0.1, 1.0, 1.0, 3.0], [1.0, 10.0, 10.0, 50.0]]  # largest u, v, a
QUICK = [
    [1e-5, 1e-4, 1e-4, 0.4],
    [1e-4, 2.0, 2.0, 50.0],
    [1.0, 10.0, 10.0, 5000.0],
]  # forces of ice and wind prevail


@pytest.mark.parametrize("scale", [WIDE, QUICK], ids=["wide", "quick"])
@pytest.mark.parametrize("changes", [{}, SLOPING], ids=["level", "sloping, ice turned"])
@pytest.mark.parametrize("seed", range(3))
def test_residual_of_a_random_motion(seed, changes, scale):
    """Example 3 has it all: eccentric ice, wind, damping, twist.  Each kind of force is compared on its own scale."""
    scene, random = load_scene("example3").with_values(changes), np.random.default_rng(seed)
    model = Model(scene)
    u, v, a = (random.uniform(-1.0, 1.0, (model.nodes, 4)) * s for s in scale)
    x, expected = model.equilibrium().x.astype(LONG), np.zeros((model.nodes, 4), LONG)
    for e in range(model.elements):
        at = slice(2 * e, 2 * e + 3)
        tension = []
        for xi, _ in TWO_POINTS:
            along = slope(xi) @ x[at]
            tension.append(LONG(scene.span.horizontal_tension) * np.sqrt(along @ along) / along[0])
        expected[at] += element_forces(
            scene, x[at], tension, *(y[at].astype(LONG) for y in (u, v, a))
        )
    error = np.abs(model.residual(u, v, a) - expected).max(axis=0)
    assert np.all(error < 3e-14 * np.abs(expected).max(axis=0))  # observed up to 9e-15
