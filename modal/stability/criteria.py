"""Stability criteria of galloping over the attack angle.

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

from gallop_fmu import LineScene, Model, Scene, SceneError
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.input.scene_like import SceneLike, SpanLike, as_scene, as_span
from gallop_fmu.scene.aerodynamic_curve import AerodynamicCurve
from gallop_fmu.scene.conductor import Ice
from modal.foundation import one_span as instead
from modal.foundation.normal_wind import unfit_wind
from modal.linear.shallow_cable import shallow_cable
from modal.stability.frequency_ratio import frequency_ratio

Array = NDArray[np.float64]

TURN_POINTS = 1441
"""Attack angles over a whole turn at which a criterion is evaluated: every quarter of a degree."""

END_MARGIN = 1e-12
"""Distance [rad] from the ends of the curve within which slopes are those at this distance."""

ANGLE_TOLERANCE = 1e-10
"""Accuracy of the ends of an unstable range [rad]."""

MIN_OSCILLATION = 1e-6
"""Imaginary part of an eigenvalue, relative to its modulus, below which nothing oscillates."""


@dataclass(frozen=True)
class Criterion:
    """A stability criterion over the attack angle.

    Attributes
    ----------
    name, formula, unit : str
        Name and formula of the criterion, and the unit of its values.
    attack_angle : ndarray
        Mean attack angle [rad] over the validity range of the curve.
    value : ndarray
        Value of the criterion; negative is unstable.
    unstable : list of tuple of float
        Ranges of the attack angle [rad] in which it is negative.
    causes : list of str
        Kind of instability at the fastest growth in each of these ranges; empty for criteria that
        know only one kind.
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
        """One sentence for each unstable range with a cause."""
        ranges = zip(self.unstable_deg, self.causes, strict=False)
        return [f"{first:.1f} to {last:.1f} deg: {cause}" for (first, last), cause in ranges]


def den_hartog(scene: SceneLike) -> Criterion:
    """Evaluate Den Hartog's criterion: vertical motion grows where dCL/dalpha + CD < 0.

    This is dF2/dv2 > 0, without structural damping (J. P. Den Hartog 1932, Trans. AIEE 51,
    1074-1076). The slope is per radian. Twist and horizontal motion are neglected: the criterion is
    necessary for pure vertical galloping, not for coupled motion.

    Raises
    ------
    SceneError
        If the scene has no coefficient curve, as for all criteria.
    """
    curve = _curve(as_scene(scene))
    return _criterion("Den Hartog", "dCL/dalpha + CD", "1/rad", curve, curve.den_hartog)


def nigol(scene: SceneLike) -> Criterion:
    """Evaluate Nigol's torsional criterion, quasi-steady: twist grows where dCM/dalpha < 0.

    For pure twist, dM/domega and dM/dtheta of the module give the equation of motion of a section,

        I theta'' + (2 I xi w + (rho U d^2 r/2) CM') theta' + (I w^2 - (rho U^2 d^2/2) CM') theta
            = 0.

    A negative slope of the moment makes the damping negative if (rho U d^2 r/2) |CM'| > 2 I xi w. A
    positive slope reduces the stiffness, to static divergence at (rho U^2 d^2/2) CM' = I w^2. The
    signs hold for the convention of the module (moment and twist in the same sense, r windward).
    The mechanism is that of O. Nigol and P. G. Buchan (1981), IEEE Trans. PAS-100, 699-720, who
    measured the damping of the twist instead of deriving it from the static moment. `coupled` shows
    the effect of the twist on vertical motion.
    """
    curve = _curve(as_scene(scene))
    return _criterion("Nigol, torsional", "dCM/dalpha", "1/rad", curve, curve.moment_slope)


def coupled(scene: SpanLike, wind_speed: float | None = None) -> Criterion:
    """Evaluate the coupled linear criterion: largest growth rate of a section free to twist.

    The value is minus the largest real part of the eigenvalues of the three equations of a section
    in vertical, horizontal and torsional motion, with eccentric ice, structural damping, the
    linearised load of the module, and the span's frequencies: first symmetric vertical and
    horizontal, first torsional. It assumes that the three motions have the same shape along the
    span; `critical_wind_speed` does not. Unlike Den Hartog's and Nigol's criteria it includes
    static divergence (the wind's moment grows faster with the twist than the restoring moment) and
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
        If there is no wind, or the pair of modes cannot be identified.
    """
    scene = as_span(scene, "the coupled criterion of one span", instead.CRITERIA)
    speed = speed_of(scene, wind_speed)
    return coupled_of(SectionMotion.of(scene), speed)


def speed_of(scene: Scene | LineScene, wind_speed: float | None) -> float:
    """Wind speed [m/s] of the coupled criterion: the given one, or the scene's mean."""
    speed = scene.wind.mean_speed if wind_speed is None else wind_speed
    check_wind_is_constant(scene, wind_speed)
    if not (np.isfinite(speed) and speed > 0.0):
        raise SceneError(
            f"wind speed = {speed} m/s: the coupled criterion needs wind; set wind.speed"
        )
    return speed


def unfit_for_coupled(scene: Scene | LineScene, wind_speed: float | None) -> str:
    """Describe wind for which there is no coupled criterion; empty if there is one."""
    purpose = "the coupled criterion"
    if scene.wind.profile is not None:
        return unfit_wind(scene, purpose, wind_speed)
    return unfit_wind(scene, purpose, wind_speed, oblique=True)


def check_wind_is_constant(scene: Scene | LineScene, wind_speed: float | None) -> None:
    """Refuse a scene with `unfit_for_coupled`.

    Raises
    ------
    SceneError
        Its wind has a profile, a direction that changes, or comes from the other side.
    """
    if problem := unfit_for_coupled(scene, wind_speed):
        raise SceneError(problem)


def coupled_of(section: SectionMotion, speed: float) -> Criterion:
    """Evaluate the coupled criterion of a section of the conductor in wind [m/s]."""
    curve = section.curve
    name = f"coupled, vertical-horizontal-torsional, {speed:g} m/s"
    found = _criterion(
        name, "-max Re(s)", "1/s", curve, lambda angle: -section.fastest(angle, speed).real
    )
    return replace(found, causes=[section.cause(found, *r, speed) for r in found.unstable])


def stability_criteria(scene: SpanLike) -> list[Criterion]:
    """Evaluate Den Hartog's, Nigol's and, if the scene has wind, the coupled criterion."""
    scene = as_span(scene, "stability_criteria", instead.CRITERIA)
    found = [den_hartog(scene), nigol(scene)]
    return [*found, coupled(scene)] if scene.wind.mean_speed != 0.0 else found


@dataclass(frozen=True)
class SectionMotion:
    """A section of unit length that moves by u2, u3, theta.

    On a slope u2 is the motion normal to the chord.

    Attributes
    ----------
    hertz : dict of str to float
        Frequency [Hz] of each family without wind.
    mass, damping, stiffness : ndarray, shape (3, 3)
        Matrices without wind and eccentricity, per metre.
    ice : Ice
        Eccentricity of the ice.
    gravity : float
        Gravity [m/s2] normal to the chord.
    curve : AerodynamicCurve
        Coefficients of the wind load.
    mesh : Mesh
        The span or line, whose wind load is that of the section.
    element : int
        Element at the section.
    wind : (float, float)
        Wind along n2 and n3, normal to the chord, per speed. In oblique wind on a slope its part
        along n2 rotates the relative wind; attack angles of the criterion are those of this wind.
    """

    hertz: dict[str, float]
    mass: Array
    damping: Array
    stiffness: Array
    ice: Ice
    gravity: float
    curve: AerodynamicCurve
    mesh: Mesh
    element: int = 0
    wind: tuple[float, float] = (0.0, 1.0)

    @classmethod
    def of(cls, scene: Scene) -> SectionMotion:
        """A section of a span."""
        pair = frequency_ratio(scene)
        hertz = (pair.vertical_hz, pair.horizontal_hz, shallow_cable(scene).torsional_hz)
        slope = scene.span.height_difference / scene.span.length
        gravity = scene.span.gravity / math.hypot(1.0, slope)
        made = cls.made(scene, scene.ice, hertz, gravity, Mesh(Model(scene)), 0)
        return replace(made, wind=wind_normal_to_chord(scene, slope))

    @classmethod
    def made(
        cls,
        scene: Scene | LineScene,
        ice: Ice,
        frequencies: tuple[float, float, float],
        gravity: float,
        mesh: Mesh,
        element: int,
    ) -> SectionMotion:
        """A section with its ice, frequencies [Hz], and gravity [m/s2] normal to its chord."""
        conductor = scene.conductor
        mass = conductor.mass_per_length + ice.mass_per_length
        inertia = conductor.torsional_inertia + ice.torsional_inertia
        hertz = np.array(frequencies)
        state = mesh.model.equilibrium()
        b1, b2 = np.transpose([state.translation_damping] * 2 + [state.twist_damping])
        diagonal = np.array([mass, mass, inertia])
        stiffness = diagonal * (2.0 * np.pi * hertz) ** 2
        return cls(
            dict(zip(("vertical", "horizontal", "torsional"), hertz.tolist(), strict=True)),
            np.diag(diagonal),
            np.diag(b1 * diagonal + b2 * stiffness),  # Rayleigh damping
            np.diag(stiffness),
            ice,
            gravity,
            _curve(scene),
            mesh,
            element,
        )

    def cause(self, criterion: Criterion, first: float, last: float, speed: float) -> str:
        """Kind of motion that grows fastest in an unstable range of attack angles [rad]."""
        within = (criterion.attack_angle >= first) & (criterion.attack_angle <= last)
        worst = 0.5 * (first + last)
        if np.any(within):
            worst = criterion.attack_angle[within][np.argmin(criterion.value[within])]
        fastest = complex(self.fastest(np.array([worst]), speed)[0])
        if abs(fastest.imag) < MIN_OSCILLATION * abs(fastest):
            return "static divergence of the twist"
        frequency = abs(fastest.imag) / (2.0 * np.pi)
        name = min(self.hertz, key=lambda family: abs(np.log(frequency / self.hertz[family])))
        return (
            f"growth at {frequency:.3g} Hz, near the {name} frequency of {self.hertz[name]:.3g} Hz"
        )

    def fastest(self, angle: Array, speed: float) -> NDArray[np.complex128]:
        """Eigenvalue [1/s] with the largest real part at each angle [rad], in a wind [m/s]."""
        by_velocity, by_theta = self._load_derivatives(angle, speed)
        angle = angle - math.atan2(*self.wind)  # of the ice
        mass, damping, stiffness = (
            np.repeat(matrix[None], angle.size, axis=0)
            for matrix in (self.mass, self.damping, self.stiffness)
        )
        m2, m3 = self.ice.first_moments(angle)  # the ice rotates with the attack angle
        mass[:, 0, 2] = mass[:, 2, 0] = -m3
        mass[:, 1, 2] = mass[:, 2, 1] = m2
        stiffness[:, 2, 2] -= self.gravity * m2
        damping -= by_velocity
        stiffness[:, :, 2] -= by_theta
        inverse = np.linalg.inv(mass)
        state = np.zeros((angle.size, 6, 6))
        state[:, :3, 3:] = np.eye(3)
        state[:, 3:, :3] = -inverse @ stiffness
        state[:, 3:, 3:] = -inverse @ damping
        values = np.linalg.eigvals(state)
        largest = values.real.argmax(axis=1)[:, None]
        return np.asarray(np.take_along_axis(values, largest, axis=1)[:, 0])

    def _load_derivatives(self, angle: Array, speed: float) -> tuple[Array, Array]:
        """Derivatives of F2, F3, M of the module about rest, at attack angles [rad].

        They are one-sided at the ends of the curve.

        Returns
        -------
        ndarray, ndarray, shape (angle, 3, 3) and (angle, 3)
            By v2, v3, omega and by theta.
        """
        first, last = self.curve.breakpoint[[0, -1]]
        inside = np.clip(angle, first + END_MARGIN, last - END_MARGIN)
        along_n2, along_n3 = (speed * part for part in self.wind)
        slopes = self.mesh.aero_load(
            inside - math.atan2(*self.wind),
            -along_n2,
            0.0,
            0.0,
            along_n3,
            attack_angle=0.0,
            slopes=True,
            element=self.element,
        ).slopes
        assert slopes is not None  # asked for
        return slopes[1:].transpose(2, 1, 0), slopes[0].T


def wind_normal_to_chord(scene: Scene | LineScene, slope: float) -> tuple[float, float]:
    """Wind along n2 and n3 of a chord per speed, without its part along the chord.

    With the direction psi it is (sin psi, 0, cos psi), and n2 = (-slope, 1, 0) / sqrt(1 + slope^2).
    """
    direction = math.radians(scene.wind.direction_deg)
    if direction == 0.0:
        return 0.0, 1.0
    return -math.sin(direction) * slope / math.hypot(1.0, slope), math.cos(direction)


def _curve(scene: Scene | LineScene) -> AerodynamicCurve:
    """Coefficient curve of a scene; SceneError if it has none."""
    if scene.aerodynamics is None:
        raise SceneError(
            "the scene has no aerodynamics: stability criteria need a coefficient curve; add a"
            " section [aerodynamics]"
        )
    return scene.aerodynamics.curve()


def _criterion(
    name: str, formula: str, unit: str, curve: AerodynamicCurve, function: Callable[[Array], Array]
) -> Criterion:
    """Evaluate a function of attack angles [rad] over the curve, and find its negative ranges."""
    first, last = float(curve.breakpoint[0]), float(curve.breakpoint[-1])
    angle = np.linspace(
        first, last, max(3, round((TURN_POINTS - 1) * (last - first) / (2.0 * np.pi)) + 1)
    )
    angle = np.unique(np.concatenate([angle, np.clip(curve.breakpoint, first, last)]))
    value = function(angle)
    return Criterion(name, formula, unit, angle, value, _negative_ranges(angle, value, function))


def _negative_ranges(
    angle: Array, value: Array, function: Callable[[Array], Array]
) -> list[tuple[float, float]]:
    """Ranges in which a function is negative, given its values at some angles [rad]."""
    from scipy.optimize import brentq  # slow to import

    negative = value < 0.0
    changes = np.flatnonzero(negative[1:] != negative[:-1])
    zeros = [
        float(
            brentq(
                lambda a: float(function(np.array([a]))[0]),
                angle[k],
                angle[k + 1],
                xtol=ANGLE_TOLERANCE,
            )
        )
        for k in changes
    ]
    ends = (
        ([float(angle[0])] if negative[0] else [])
        + zeros
        + ([float(angle[-1])] if negative[-1] else [])
    )
    return list(zip(ends[::2], ends[1::2], strict=True))
