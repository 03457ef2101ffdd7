"""The equations of docs/concepts/equations.md for one element, as plain as they are written there.

The kernel computes the same for several elements at once, with tables and vector code; this is what
it must agree with. Numbers in parentheses are equations of Liu, Yan, Zhang, Zhou (2009). Numbers
are of numpy's longdouble or clongdouble: 64 bits of mantissa on x86. With complex numbers the
tangent follows by the complex step, without cancellation.
"""

from dataclasses import dataclass

import numpy as np

from gallop_fmu import Scene

LONG = np.longdouble
ROOT = np.sqrt(LONG(3) / 5)
TWO_POINTS = [(-1 / np.sqrt(LONG(3)), LONG(1)), (1 / np.sqrt(LONG(3)), LONG(1))]
THREE_POINTS = [(-ROOT, LONG(5) / 9), (LONG(0), LONG(8) / 9), (ROOT, LONG(5) / 9)]
"""Abscissae and weights of Gauss: two for the cable forces, three for inertia, ice and wind."""


def shape(xi):
    """Shape functions N of the three nodes (5)."""
    return np.array([xi * (xi - 1) / 2, 1 - xi * xi, xi * (xi + 1) / 2])


def shape_slope(xi):
    """dN/dxi of the three nodes."""
    return np.array([xi - LONG(1) / 2, -2 * xi, xi + LONG(1) / 2])


def rayleigh(pair):
    """b1 [1/s] and b2 [s] of two damping ratios; the paper's (28) holds only for equal ones."""
    if pair is None:
        return LONG(0), LONG(0)
    x1, x2 = LONG(pair.low_ratio), LONG(pair.high_ratio)
    w1, w2 = (2 * LONG(np.pi) * LONG(f) for f in (pair.low_frequency, pair.high_frequency))
    b1 = 2 * w1 * w2 * (x1 * w2 - x2 * w1) / (w2**2 - w1**2)
    b2 = 2 * (x2 * w2 - x1 * w1) / (w2**2 - w1**2)
    return b1, b2


def angle_of(w2, w3):
    """atan2(w2, w3), also of complex numbers with small imaginary parts."""
    about = np.arctan2(w2.real, w3.real)
    c, s = np.cos(about), np.sin(about)
    return about + np.arctan((w2 * c - w3 * s) / (w3 * c + w2 * s))


@dataclass
class ReferenceElement:
    """One element of a scene whose coefficient curve is a polynomial.

    `x` (3, 3) are the positions [m] of its nodes in the initial equilibrium, `tension` (2,) the
    initial tension T0 [N] at the two Gauss points.
    """

    scene: Scene
    x: np.ndarray
    tension: np.ndarray

    def residual(self, u, v, a):
        """Out-of-balance forces (3, 4) [N, N m]; of `u`, `v`, `a` (3, 4), all of one type."""
        r = np.zeros((3, 4), u.dtype)
        for (xi, weight), t0 in zip(TWO_POINTS, self.tension, strict=True):
            r += weight * self._cable(xi, t0, u, v)
        for xi, weight in THREE_POINTS:
            r += weight * self._section(xi, u, v, a)
        return r

    def _cable(self, xi, t0, u, v):
        """Tension, torque and the damping b2 K at a Gauss point (3), (11), (14), (18)."""
        conductor, damping = self.scene.conductor, self.scene.damping
        ea, gj = LONG(conductor.axial_stiffness), LONG(conductor.torsional_stiffness)
        b2, b2_twist = rayleigh(damping.translation)[1], rayleigh(damping.twist)[1]

        stretch = np.linalg.norm(shape_slope(xi) @ self.x)  # dS/dxi
        slope = shape_slope(xi) / stretch  # N' = dN/dS
        p0, du, dv = slope @ self.x, slope @ u, slope @ v
        p = p0 + du[:3]  # slope of the current position (3)
        strain = p0 @ du[:3] + du[:3] @ du[:3] / 2  # Green's, from the initial equilibrium
        tension = t0 + ea * strain
        if conductor.slack == "tension_only" and tension.real < 0:
            tension = 0 * tension

        force = np.zeros(4, u.dtype)
        force[:3] = tension * p - t0 * p0  # the initial state is in equilibrium
        force[:3] += b2 * (ea * p0 * (p0 @ dv[:3]) + t0 * dv[:3])
        force[3] = gj * (du[3] + b2_twist * dv[3])
        return stretch * np.outer(slope, force)

    def _section(self, xi, u, v, a):
        """Inertia, the damping b1 M, eccentric ice and wind at a section."""
        scene, conductor = self.scene, self.scene.conductor
        mass = LONG(conductor.mass_per_length) + LONG(scene.ice.mass_per_length)
        inertia = LONG(conductor.torsional_inertia) + LONG(scene.ice.torsional_inertia)
        b1, b1_twist = rayleigh(scene.damping.translation)[0], rayleigh(scene.damping.twist)[0]

        along = shape_slope(xi) @ self.x
        stretch = np.linalg.norm(along)  # dS/dxi
        t = along / stretch
        n2 = np.array([-t[1], t[0], LONG(0)])  # e3 x t: the plane of the section is (n2, e3)
        u, v, a = (shape(xi) @ y for y in (u, v, a))
        theta, omega = u[3], v[3]
        v2, v3, a2, a3 = n2 @ v[:3], v[2], n2 @ a[:3], a[2]

        f2, f3, moment = self._ice(n2, theta, omega, a[3], a2, a3)
        w2, w3, wind_moment = self._wind(theta, omega, v2, v3)
        f2, f3, moment = f2 - w2, f3 - w3, moment - wind_moment

        force = np.zeros(4, u.dtype)
        force[:3] = mass * (a[:3] + b1 * v[:3])
        force[3] = inertia * (a[3] + b1_twist * v[3])
        force += np.array([f2 * n2[0], f2 * n2[1], f3, moment])
        return stretch * np.outer(shape(xi), force)

    def _ice(self, n2, theta, omega, omega_rate, a2, a3):
        """Eccentric ice (8), (17), with the terms in omega^2 that the paper omits."""
        ice = self.scene.ice
        given_at = ice.first_moment_angle_deg
        turn = 0 if given_at is None else ice.attack_angle_deg - given_at
        cosine, sine = (f(LONG(turn) * LONG(np.pi) / 180) for f in (np.cos, np.sin))
        s_x3 = LONG(ice.first_moment_x2) * cosine - LONG(ice.first_moment_x3) * sine
        s_x2 = LONG(ice.first_moment_x2) * sine + LONG(ice.first_moment_x3) * cosine

        c2 = s_x3 * np.cos(theta) - s_x2 * np.sin(theta)
        c3 = s_x3 * np.sin(theta) + s_x2 * np.cos(theta)
        f2 = -c3 * omega_rate - c2 * omega**2
        f3 = c2 * omega_rate - c3 * omega**2
        g2 = LONG(self.scene.span.gravity) * n2[1]
        return f2, f3, -c3 * a2 + c2 * a3 - g2 * (c3 - s_x2)

    def _wind(self, theta, omega, v2, v3):
        """Quasi-steady wind (20), (21)."""
        wind, air, d = self.scene.wind, self.scene.aerodynamics, LONG(self.scene.conductor.diameter)
        w2 = -v2 - d / 2 * omega
        w3 = LONG(wind.speed) - v3
        ur = np.sqrt(w2**2 + w3**2)
        alpha0 = LONG(self.scene.ice.attack_angle_deg - air.centre_deg) * LONG(np.pi) / 180
        alpha = alpha0 + theta + angle_of(w2, w3)  # from the centre of the polynomials
        cl, cd, cm = (
            sum(LONG(c) * alpha**power for power, c in enumerate(coefficients))
            for coefficients in (air.lift, air.drag, air.moment)
        )
        q = LONG(wind.air_density) * d * ur / 2
        return q * (cl * w3 + cd * w2), q * (-cl * w2 + cd * w3), q * ur * d * cm
