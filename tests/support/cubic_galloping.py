"""A taut span with a cubic lift curve, whose galloping follows from an integral over one cycle.

The lift coefficient is CL = -a x + b x^3, x = alpha - 180 deg, and the drag coefficient constant.
The mode is a half sine of the angular frequency w and the amplitude A at mid-span. With the
quasi-steady force of the relative wind its mean power in a cycle is

    P = <int F2 v dx> - c m w^2 A^2 L / 4,    v = -w A sin(pi x/L) sin(wt),
    F2 = 1/2 rho d (v^2 + U^2) (CL cos b + CD sin b),    b = atan2(-v, U).

A lasting motion has P = 0; it begins at U = 2 m c / (rho d (a - CD)), where P = 0 for a small A.
Nothing here comes from the program but the frequency.
"""

import numpy as np
from scipy.optimize import brentq

import gallop_fmu as gf
import modal

MASS, DIAMETER, LENGTH, DENSITY = 1.66, 0.0235, 125.88, 1.2929
SLOPE, DRAG = 2.0, 1.0
RATIO, FREQUENCIES = 0.004, (0.5, 1.0)


def scene(cubic=6.0, speed=6.0):
    return gf.load_scene("example3").with_values(
        {
            "span.sag": None,
            "span.horizontal_tension": 60e3,
            "conductor.axial_stiffness": 2.5e6,
            "conductor.torsional_stiffness": 1e5,
            "ice": {"attack_angle_deg": 180.0},
            "wind.speed": speed,
            "aerodynamics.lift": [0.0, -SLOPE, 0.0, cubic],
            "aerodynamics.drag": [DRAG],
            "aerodynamics.moment": [0.0],
            "damping.translation": {
                "low_ratio": RATIO,
                "low_frequency": FREQUENCIES[0],
                "high_ratio": RATIO,
                "high_frequency": FREQUENCIES[1],
            },
        }
    )


class Cubic:
    """The integral of a cubic curve."""

    def __init__(self, cubic=6.0):
        self.cubic = cubic
        self.w = 2.0 * np.pi * modal.frequency_ratio(scene(cubic)).vertical_hz
        low, high = (2.0 * np.pi * f for f in FREQUENCIES)
        equations = [[1.0, low**2], [1.0, high**2]]
        mass, stiffness = np.linalg.solve(equations, [2.0 * RATIO * low, 2.0 * RATIO * high])
        self.c = mass + stiffness * self.w**2
        nodes, weights = np.polynomial.legendre.leggauss(20)
        self.shape, self.weight = np.sin(0.5 * np.pi * (1.0 + nodes)), 0.5 * weights
        self.sine = np.sin(2.0 * np.pi * np.arange(64) / 64)

    @property
    def begins_at(self):
        """Lowest wind speed of galloping [m/s]."""
        return 2.0 * MASS * self.c / (DENSITY * DIAMETER * (SLOPE - DRAG))

    def power(self, amplitude, speed):
        v = -self.w * amplitude * np.outer(self.shape, self.sine)
        angle = np.arctan2(-v, speed)
        lift = -SLOPE * angle + self.cubic * angle**3
        force = lift * np.cos(angle) + DRAG * np.sin(angle)
        force *= 0.5 * DENSITY * DIAMETER * (v**2 + speed**2)
        lost = 0.5 * self.c * MASS * (self.w * amplitude) ** 2 * self.weight @ self.shape**2
        return self.weight @ np.mean(force * v, axis=1) - lost

    def amplitude(self, speed):
        """Amplitude of lasting galloping [m]; 0 without."""
        if speed <= self.begins_at:
            return 0.0
        return brentq(self.power, 1e-5, 0.9 * speed / self.w, args=(speed,))
