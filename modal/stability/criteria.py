"""When a wind makes a span gallop: criteria over the attack angle, and the critical wind speed of each mode.

All follow from the quasi-steady load (Liu, Yan, Zhang, Zhou 2009, eq. 20-21) on a section that
moves by u2, u3, theta,

    F2 = q (CL w3 + CD w2),  F3 = q (CD w3 - CL w2),  M = q Ur d CM,  q = rho d Ur/2,
    w2 = -v2 - r omega,  w3 = U - v3,  alpha = alpha0 + theta + atan2(w2, w3),

with lift up when the wind blows along +x3, moment and twist right-handed about x1 (the windward
edge rises), slopes per radian, and r > 0 the distance of the windward point whose velocity makes
the relative wind. Linearised about rest,

    dF2/dv2 = -(rho U d/2)(CL' + CD),        dF2/dtheta = (rho U^2 d/2) CL',
    dF3/dv3 = -rho U d CD,                   dF3/dtheta = (rho U^2 d/2) CD',
    dM/domega = -(rho U d^2 r/2) CM',        dM/dtheta = (rho U^2 d^2/2) CM'.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from gallop_fmu.scene.aerodynamics import AerodynamicCurve
from gallop_fmu.scene.damping import RayleighPair
from gallop_fmu.scene.scene import Ice
from modal.linear.shallow_cable import shallow_cable
from modal.stability.frequency_ratio import frequency_ratio

Array = NDArray[np.float64]

POINTS = 1441
"""Attack angles over a whole turn at which a criterion is evaluated: every quarter of a degree."""

SLOPE_STEP = 1e-6
"""Step of the difference that gives the slopes of drag and moment [rad]; the curve is cubic between breakpoints."""


REAL = 1e-6
"""Imaginary part of an eigenvalue, in parts of its modulus, below which the motion does not oscillate."""


@dataclass(frozen=True)
class Criterion:
    """A criterion of stability over the attack angle.

    Attributes
    ----------
    name, formula, unit : str
        What it is, and the unit of its values.
    attack_angle : ndarray
        Mean attack angle [rad] over the validity range of the curve.
    value : ndarray
        Negative: unstable.
    unstable : list of tuple of float
        Ranges of the attack angle [rad] in which it is negative.
    causes : list of str
        Kind of the instability in each of these ranges where it grows fastest; empty for criteria
        of one kind.
    """

    name: str
    formula: str
    unit: str
    attack_angle: Array = field(repr=False)
    value: Array = field(repr=False)
    unstable: list[tuple[float, float]]
    causes: list[str] = field(default_factory=list)

    @property
    def unstable_deg(self) -> list[tuple[float, float]]:
        """The unstable ranges in degrees."""
        return [
            (float(np.degrees(first)), float(np.degrees(last))) for first, last in self.unstable
        ]

    @property
    def explained(self) -> list[str]:
        """Sentence on each unstable range whose cause is known."""
        ranges = zip(self.unstable_deg, self.causes, strict=False)
        return [f"{first:.1f} to {last:.1f} deg: {cause}" for (first, last), cause in ranges]


def den_hartog(scene: Scene) -> Criterion:
    """Den Hartog's criterion: vertical motion is fed by the wind where dCL/dalpha + CD < 0.

    dF2/dv2 > 0 above, without structural damping (J. P. Den Hartog 1932, Trans. AIEE 51,
    1074-1076). The slope is per radian. Twist and horizontal motion are left out: necessary for
    pure vertical galloping, not for coupled.

    Raises
    ------
    SceneError
        If the scene has no coefficient curve; so in all criteria.
    """
    curve = _curve(scene)
    return _criterion("Den Hartog", "dCL/dalpha + CD", "1/rad", curve, curve.den_hartog)


def nigol(scene: Scene) -> Criterion:
    """Nigol's torsional criterion in quasi-steady form: twist is fed by the wind where dCM/dalpha < 0.

    For pure twist the equation of motion of a section is, from dM/domega and dM/dtheta above,

        I theta'' + (2 I xi w + (rho U d^2 r/2) CM') theta' + (I w^2 - (rho U^2 d^2/2) CM') theta =
        0,

    so a negative slope of the moment feeds the twist through the damping once (rho U d^2 r/2)|CM'|
    > 2 I xi w, while a positive one softens it until it diverges statically at (rho U^2 d^2/2) CM'
    = I w^2. The sign belongs to the convention above (moment and twist in the same sense, r
    windward); with the moment counted the other way round it is reversed. The mechanism is that of
    O. Nigol and P. G. Buchan (1981), IEEE Trans. PAS-100, 699-720, who measured the damping of the
    twist instead of deriving it from the static moment; see `coupled` for the twist's effect on the
    vertical motion.
    """
    curve = _curve(scene)
    return _criterion(
        "Nigol, torsional", "dCM/dalpha", "1/rad", curve, lambda a: slopes(curve, a)[2]
    )


def coupled(scene: Scene, wind_speed: float | None = None) -> Criterion:
    """The coupled linear criterion: growth of the fastest-growing motion of a section free to move and twist.

    Eigenvalues of the three equations of a section in vertical, horizontal and torsional motion,
    with eccentric ice, structural damping, the span's first symmetric vertical and horizontal
    frequencies, the first torsional one, and the linearised load above. The value is minus the
    largest real part. That the three motions have the same shape along the span is an assumption;
    `critical_wind_speed` needs none. Unlike Den Hartog's and Nigol's criteria it knows static
    divergence, where the wind's moment grows faster with the twist than the section resists, and
    coupled flutter, so that it may be unstable where these two are stable; see `Criterion.causes`.

    Parameters
    ----------
    scene
        The span.
    wind_speed
        Wind speed [m/s]; None takes the scene's mean.

    Raises
    ------
    SceneError
        If there is no wind, or the pair of modes cannot be told.
    """
    curve = _curve(scene)
    speed = scene.wind.mean_speed if wind_speed is None else wind_speed
    if not (np.isfinite(speed) and speed > 0.0):
        raise SceneError(
            f"wind speed = {speed} m/s: the coupled criterion needs a positive one; set wind.speed"
        )
    section = _Section.of(scene)
    name = f"coupled, vertical-horizontal-torsional, {speed:g} m/s"
    found = _criterion(
        name, "-max Re(s)", "1/s", curve, lambda angle: -section.fastest(curve, angle, speed).real
    )
    causes = []
    for first, last in found.unstable:
        within = (found.attack_angle >= first) & (found.attack_angle <= last)
        worst = (
            found.attack_angle[within][np.argmin(found.value[within])]
            if np.any(within)
            else 0.5 * (first + last)
        )
        causes.append(section.cause(complex(section.fastest(curve, np.array([worst]), speed)[0])))
    return replace(found, causes=causes)


def stability_criteria(scene: Scene) -> list[Criterion]:
    """Den Hartog's, Nigol's and, where the scene has wind, the coupled criterion."""
    found = [den_hartog(scene), nigol(scene)]
    return [*found, coupled(scene)] if scene.wind.mean_speed > 0.0 else found


def slopes(curve: AerodynamicCurve, angle: Array) -> Array:
    """Slopes of lift, drag and moment per radian, shape (3, angle); one-sided at the ends of a curve that has ends."""
    first, last = curve.breakpoint[0], curve.breakpoint[-1]
    within = (angle >= first) & (angle <= last) & (curve.outside != "periodic")
    low = np.where(within, np.maximum(angle - SLOPE_STEP, first), angle - SLOPE_STEP)
    high = np.where(within, np.minimum(angle + SLOPE_STEP, last), angle + SLOPE_STEP)
    of = (curve.lift, curve.drag, curve.moment)
    return np.array([(coefficient(high) - coefficient(low)) / (high - low) for coefficient in of])


@dataclass(frozen=True)
class _Section:
    """A section of unit length: matrices of u2, u3, theta without wind and eccentricity, and what the load needs.

    On a slope u2 is the motion normal to the chord, and `gravity` the component against it.
    """

    hertz: dict[str, float]
    mass: Array
    damping: Array
    stiffness: Array
    ice: Ice
    gravity: float
    air_density: float
    diameter: float
    radius: float

    @classmethod
    def of(cls, scene: Scene) -> _Section:
        conductor, ice, pair = scene.conductor, scene.ice, frequency_ratio(scene)
        mass = conductor.mass_per_length + ice.mass_per_length
        inertia = conductor.torsional_inertia + ice.torsional_inertia
        hertz = np.array([pair.vertical_hz, pair.horizontal_hz, shallow_cable(scene).torsional_hz])
        rayleigh = [scene.damping.translation, scene.damping.translation, scene.damping.twist]
        diagonal = np.array([mass, mass, inertia])
        omega = 2.0 * np.pi * hertz
        ratio = np.array([rayleigh_ratio(pair, f) for pair, f in zip(rayleigh, hertz, strict=True)])
        assert scene.aerodynamics is not None  # asked for by every criterion
        radius = scene.aerodynamics.reference_radius or 0.5 * conductor.diameter
        return cls(
            dict(zip(("vertical", "horizontal", "torsional"), hertz.tolist(), strict=True)),
            np.diag(diagonal),
            np.diag(2.0 * diagonal * omega * ratio),
            np.diag(diagonal * omega**2),
            ice,
            scene.span.gravity / math.hypot(1.0, scene.span.height_difference / scene.span.length),
            scene.wind.air_density,
            conductor.diameter,
            radius,
        )

    def cause(self, fastest: complex) -> str:
        """Kind of motion that grows with an eigenvalue [1/s]."""
        if abs(fastest.imag) < REAL * abs(fastest):
            return "static divergence of the twist"
        frequency = abs(fastest.imag) / (2.0 * np.pi)
        name = min(self.hertz, key=lambda family: abs(np.log(frequency / self.hertz[family])))
        return (
            f"growth at {frequency:.3g} Hz, near the {name} frequency of {self.hertz[name]:.3g} Hz"
        )

    def fastest(
        self, curve: AerodynamicCurve, angle: Array, speed: float
    ) -> NDArray[np.complex128]:
        """Eigenvalue [1/s] with the largest real part at each angle."""
        cl, cd, cm = curve.lift(angle), curve.drag(angle), curve.moment(angle)
        sl, sd, sm = slopes(curve, angle)
        k, d, r = 0.5 * self.air_density * self.diameter * speed, self.diameter, self.radius
        by_v2 = -k * np.array([sl + cd, sd - cl, d * sm])
        by_v3 = -k * np.array([2.0 * cl, 2.0 * cd, 2.0 * d * cm])
        by_theta = k * speed * np.array([sl, sd, d * sm])
        damping, stiffness = np.empty((angle.size, 3, 3)), np.empty((angle.size, 3, 3))
        damping[:] = self.damping
        stiffness[:] = self.stiffness
        mass = np.empty((angle.size, 3, 3))
        mass[:] = self.mass
        m2, m3 = self.ice.first_moments(angle)  # the ice turns with the attack angle
        mass[:, 0, 2] = mass[:, 2, 0] = -m3
        mass[:, 1, 2] = mass[:, 2, 1] = m2
        stiffness[:, 2, 2] -= self.gravity * m2
        damping -= np.stack([by_v2, by_v3, r * by_v2], axis=-1).transpose(1, 0, 2)
        stiffness[:, :, 2] -= by_theta.T
        state = np.zeros((angle.size, 6, 6))
        state[:, :3, 3:] = np.eye(3)
        inverse = np.linalg.inv(mass)
        state[:, 3:, :3] = -inverse @ stiffness
        state[:, 3:, 3:] = -inverse @ damping
        values = np.linalg.eigvals(state)
        return np.asarray(
            np.take_along_axis(values, values.real.argmax(axis=1)[:, None], axis=1)[:, 0]
        )


def rayleigh_ratio(pair: RayleighPair | None, frequency_hz: float) -> float:
    """Damping ratio of a pair at any frequency [Hz], b1/(2 w) + b2 w/2; 0 without damping."""
    if pair is None:
        return 0.0
    low, high = pair.low_frequency, pair.high_frequency
    between = high**2 - low**2
    constant = low * high * (pair.low_ratio * high - pair.high_ratio * low) / between
    linear = (pair.high_ratio * high - pair.low_ratio * low) / between
    return constant / frequency_hz + linear * frequency_hz


def _curve(scene: Scene) -> AerodynamicCurve:
    if scene.aerodynamics is None:
        raise SceneError(
            "the scene has no aerodynamics: criteria of galloping need a coefficient curve"
        )
    return scene.aerodynamics.curve()


def _criterion(
    name: str, formula: str, unit: str, curve: AerodynamicCurve, function: Callable[[Array], Array]
) -> Criterion:
    first, last = float(curve.breakpoint[0]), float(curve.breakpoint[-1])
    angle = np.linspace(
        first, last, max(3, round((POINTS - 1) * (last - first) / (2.0 * np.pi)) + 1)
    )
    angle = np.unique(np.concatenate([angle, np.clip(curve.breakpoint, first, last)]))
    value = function(angle)
    return Criterion(name, formula, unit, angle, value, _negative_ranges(angle, value, function))


def _negative_ranges(
    angle: Array, value: Array, function: Callable[[Array], Array]
) -> list[tuple[float, float]]:
    """Where a function is negative, its zeros between the points found by bisection."""
    from scipy.optimize import brentq  # slow to import

    negative = value < 0.0
    changes = np.flatnonzero(negative[1:] != negative[:-1])
    zeros = [
        float(
            brentq(lambda a: float(function(np.array([a]))[0]), angle[k], angle[k + 1], xtol=1e-10)
        )
        for k in changes
    ]
    ends = (
        ([float(angle[0])] if negative[0] else [])
        + zeros
        + ([float(angle[-1])] if negative[-1] else [])
    )
    return list(zip(ends[::2], ends[1::2], strict=True))
