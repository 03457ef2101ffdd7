"""The square prism of Parkinson and Smith on a span, and the closed form of its galloping.

G. V. Parkinson and J. D. Smith (1964), Quart. J. Mech. Appl. Math. 17, 225-239, measured the force
across the wind on a square prism and fitted

    CFy = A1 x - A3 x^3 + A5 x^5 - A7 x^7,    x = v/U                                            (1)

in the velocity v across a wind U. By averaging over a period (Krylov and Bogoliubov), a prism that
moves as a f(S) sin(w t), with f = 1 where it moves most, has the limit cycles

    A1 - 3/4 s4 A3 y + 5/8 s6 A5 y^2 - 35/64 s8 A7 y^3 = A1 U0/U,    y = (w a/U)^2,              (2)

where s_n = int f^n dS / int f^2 dS, all 1 in uniform motion, and U0 = 4 m xi w / (rho d A1) is the
wind at which galloping begins. The right side is the damping of the structure.
"""

from __future__ import annotations

import math
import tomllib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene
from gallop_fmu.foundation.text_files import packaged_text
from gallop_fmu.scene.curve_catalogue import FOLDER, across_wind_table

Array = NDArray[np.float64]

_CURVE = tomllib.loads(packaged_text(FOLDER, "square_prism_parkinson_smith.toml"))["across_wind"]
FORCE, DRAG = tuple(_CURVE["force"]), _CURVE["drag"]
"""Coefficients of x, x^3, x^5 and x^7, and drag of the packaged curve."""

MEANS = (1.0, 3.0 / 4.0, 5.0 / 8.0, 35.0 / 64.0)
"""2 mean(sin^n) for n = 2, 4, 6, 8."""

DENSITY, DIAMETER, MASS, LENGTH, GRAVITY = 1.225, 0.1, 15.0, 50.0, 9.81
"""Air [kg/m3], side of the prism [m], its mass [kg/m], span [m], gravity [m/s2]."""

DAMPING = 5e-4
"""Damping ratio at the frequency of the string; proportional to the frequency above."""

IRVINE = 1.3
"""Irvine's parameter lambda^2. Overtones of a string without sag are multiples of the first
frequency, so that the odd harmonics of the force would excite them at resonance."""

STRAIN = 0.01
"""Elongation by the tension."""

SAG = LENGTH / 8.0 * math.sqrt(IRVINE * STRAIN)
TENSION = MASS * GRAVITY * LENGTH**2 / (8.0 * SAG)
STRING_HZ = math.sqrt(TENSION / MASS) / (2.0 * LENGTH)


def prism(
    wind_speed: float,
    amplitude: float,
    *,
    periods: float = 2000.0,
    steps_per_period: int = 40,
    force: tuple[float, ...] = FORCE,
) -> Scene:
    """A span with the prism's coefficients, displaced by a half sine of an amplitude [m].

    Parameters
    ----------
    wind_speed
        Wind speed [m/s].
    amplitude
        Initial amplitude [m].
    periods
        Duration in periods of the string.
    steps_per_period
        Time steps in such a period.
    force
        Odd coefficients of the force in ascending order.
    """
    return Scene.from_dict(
        {
            "title": "square prism",
            "span": {"length": LENGTH, "horizontal_tension": TENSION, "gravity": GRAVITY},
            "conductor": {
                "diameter": DIAMETER,
                "mass_per_length": MASS,
                "axial_stiffness": TENSION / STRAIN,
                "torsional_stiffness": 1e5,
                "torsional_inertia": 0.03,
            },
            "wind": {"speed": wind_speed, "air_density": DENSITY},
            "aerodynamics": coefficients(force),
            "damping": {
                "translation": proportional(DAMPING, STRING_HZ),
                "twist": proportional(0.05, STRING_HZ),
            },
            "initial": {"wind": "mean_wind_equilibrium", "seed_vertical": amplitude},
            "numerics": {"elements": 6, "time_step": 1.0 / (STRING_HZ * steps_per_period)},
            "run": {"stop_time": periods / STRING_HZ, "record_every": 1},
        }
    )


def proportional(ratio: float, frequency: float) -> dict[str, float]:
    """Damping proportional to the stiffness, with a ratio at a frequency [Hz]."""
    return {
        "low_ratio": ratio,
        "low_frequency": frequency,
        "high_ratio": 2.0 * ratio,
        "high_frequency": 2.0 * frequency,
    }


def coefficients(force: tuple[float, ...]) -> dict[str, Any]:
    """Section of the scene with a force across the wind."""
    return {**across_wind_table(**{**_CURVE, "force": force}), "outside": "hold"}


def irvine_shape() -> tuple[float, Array]:
    """First symmetric vertical mode of a shallow cable: frequency [rad/s], and s_n of the module.

    tan(b/2) = b/2 - 4/lambda^2 (b/2)^3 with b = w L sqrt(m/H), and the shape 1 - tan(b/2) sin(b x)
    - cos(b x) (H. M. Irvine, Cable Structures, 1981).
    """
    from scipy.optimize import brentq

    b = brentq(
        lambda b: math.sin(b / 2.0) - math.cos(b / 2.0) * (b / 2.0 - 4.0 / IRVINE * (b / 2.0) ** 3),
        math.pi * (1.0 + 1e-6),
        1.5 * math.pi,
        xtol=1e-14,
    )
    points, weights = np.polynomial.legendre.leggauss(40)
    x = 0.5 * (points + 1.0)
    shape = 1.0 - math.tan(b / 2.0) * np.sin(b * x) - np.cos(b * x)
    shape /= 1.0 - math.tan(b / 2.0) * math.sin(b / 2.0) - math.cos(b / 2.0)
    powers = np.array([weights @ shape**n for n in (2, 4, 6, 8)])
    return b / LENGTH * math.sqrt(TENSION / MASS), powers / powers[0]


def onset_wind_speed() -> float:
    """U0 of the module [m/s]."""
    omega, _ = irvine_shape()
    ratio = DAMPING * omega / (2.0 * math.pi * STRING_HZ)
    return 4.0 * MASS * ratio * omega / (DENSITY * DIAMETER * FORCE[0])


def limit_cycles(relative_wind: float, force: tuple[float, ...] = FORCE) -> list[float]:
    """Amplitudes [m] of equation (2) at a wind U/U0, ascending; every second one is unstable.

    U0 is that of `FORCE`.
    """
    omega, s = irvine_shape()
    polynomial = np.array(force) * np.array(MEANS)[: len(force)] * s[: len(force)]
    polynomial[0] -= FORCE[0] / relative_wind
    roots = np.roots(polynomial[::-1])
    real = np.sort(roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)])
    speed = relative_wind * onset_wind_speed()
    return [float(np.sqrt(y)) * speed / omega for y in real]


def fold_winds() -> tuple[float, float]:
    """Winds U/U0 of the two folds of equation (2): three limit cycles exist between them."""
    _, s = irvine_shape()
    polynomial = np.polynomial.Polynomial(np.array(FORCE) * np.array(MEANS) * s)
    at = polynomial(polynomial.deriv().roots().real)
    high, low = sorted(FORCE[0] / at, reverse=True)
    return float(low), float(high)
