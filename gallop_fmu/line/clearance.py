"""Ellipses within which utilities expect a galloping conductor to move, and how far a motion is from their edge.

Such an ellipse stands at mid-span, in the plane across the span: x horizontal, positive downwind
(x3), y up (x2), both measured from the conductor at rest. They are envelopes of what was seen on
lines, not a prediction; sag and swing are those of the ice and wind that the utility's rule names.

The formulas are those of two open programs that agree: the functions of github.com/mpewsey/civpy
(civpy/tline, BSD licence), and the ellipses that PLS-CADD printed into the sample report of
github.com/mpewsey/plsxml (plsxml/data/galloping.xml), which the tests compare. CIGRE's Technical
Brochure 322 (2007) itself was not at hand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FOOT = 0.3048
"""Length of a foot [m]."""
BISECTIONS = 100
"""Enough for a distance to the last digit."""
NEAR_AXIS = 1e-12
"""Points are kept this share of the minor axis away from the major one, where the foot of the normal jumps."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """An ellipse that stands across the span.

    Attributes
    ----------
    major, minor
        Lengths of the whole axes [m].
    offset
        Length of the major axis below the conductor at rest [m], B in the literature.
    rotation
        Angle of the major axis to the vertical [rad]; positive: its upper end leans against the
        wind.
    """

    major: float
    minor: float
    offset: float
    rotation: float

    @property
    def centre(self) -> tuple[float, float]:
        """Place x, y of the centre [m]."""
        above = 0.5 * self.major - self.offset
        return -above * math.sin(self.rotation), above * math.cos(self.rotation)

    def inside_ellipse(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Whether points x, y [m], of equal shape, are within the ellipse or on its edge."""
        along, across = self._own_axes(x, y)
        return np.asarray(np.hypot(along / (0.5 * self.major), across / (0.5 * self.minor)) <= 1.0)

    def distance(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Distance of points x, y [m], of equal shape, from the edge [m]; negative within.

        The nearest point of the edge is found by bisection, after D. Eberly, "Distance from a Point
        to an Ellipse, an Ellipsoid, or a Hyperellipsoid" (2013).
        """
        along, across = (np.abs(part) for part in self._own_axes(x, y))
        a, b = 0.5 * self.major, 0.5 * self.minor
        across = np.maximum(across, NEAR_AXIS * b)
        ratio = (a / b) ** 2
        low = across / b
        high = np.hypot(ratio * along / a, low)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            outside = (
                np.hypot(ratio * along / a / (middle + ratio - 1.0), across / b / middle) > 1.0
            )
            low, high = np.where(outside, middle, low), np.where(outside, high, middle)
        shortest = np.hypot(ratio * along / (low + ratio - 1.0) - along, across / low - across)
        return np.asarray(np.where(self.inside_ellipse(x, y), -shortest, shortest))

    def outline(self, points: int = 181) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Points x, y of the edge [m], for a picture; the last is the first."""
        angle = np.linspace(0.0, 2.0 * math.pi, points)
        along, across = 0.5 * self.major * np.cos(angle), 0.5 * self.minor * np.sin(angle)
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        x, y = self.centre
        return x - along * sine + across * cosine, y + along * cosine + across * sine

    def _own_axes(
        self, x: ArrayLike, y: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Parts of points along the major and the minor axis, from the centre."""
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        dx = np.asarray(x, dtype=np.float64) - self.centre[0]
        dy = np.asarray(y, dtype=np.float64) - self.centre[1]
        return dy * cosine - dx * sine, dx * cosine + dy * sine


def cigre_322_single_loop(sag: float, diameter: float) -> Ellipse:
    """Ellipse of CIGRE's Technical Brochure 322 for a single conductor that gallops in one loop.

    With d the diameter, major = 80 d ln(8 sag / (50 d)), minor = 0.4 major, offset = 0.3 major,
    upright.

    Parameters
    ----------
    sag
        Sag at mid-span [m], more than 6.25 diameters: less leaves no ellipse.
    diameter
        Diameter of the conductor without ice [m].

    Raises
    ------
    ValueError
        A length is not positive, or the sag too small.
    """
    _check_positive(sag=sag, diameter=diameter)
    if sag <= 6.25 * diameter:
        raise ValueError(
            f"sag = {sag} m: must exceed 6.25 diameters, which is {6.25 * diameter:.4g} m"
        )
    major = 80.0 * diameter * math.log(8.0 * sag / (50.0 * diameter))
    return Ellipse(major, 0.4 * major, 0.3 * major, rotation=0.0)


def davison_single_loop(sag: float, swing: float = 0.0) -> Ellipse:
    """Ellipse of Davison for a conductor that gallops in one loop.

    major = 1.25 sag + 1 ft, minor = 0.4 major, offset = 0.25 sag, turned by half the swing. The
    sources do not say to which side; here it turns as the plane of the span does, so that its upper
    end leans back against the wind.

    Parameters
    ----------
    sag
        Sag at mid-span [m].
    swing
        Angle by which the wind swings the span out [rad], positive downwind. The ellipse then
        stands at the conductor that rests there.

    Raises
    ------
    ValueError
        The sag is not positive, or the swing a right angle or more.
    """
    _check_positive(sag=sag)
    if not abs(swing) < 0.5 * math.pi:
        raise ValueError(
            f"swing = {swing} rad: must be less than a right angle, {0.5 * math.pi:.4f} rad"
        )
    major = 1.25 * sag + FOOT
    return Ellipse(major, 0.4 * major, 0.25 * sag, rotation=0.5 * swing)


def _check_positive(**lengths: float) -> None:
    for name, value in lengths.items():
        if not 0.0 < value < math.inf:
            raise ValueError(f"{name} = {value} m: must be a positive number")
