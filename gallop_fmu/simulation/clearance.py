"""Clearance ellipses for galloping conductors, and the distance of a motion from them.

An ellipse is in the plane across the span at mid-span: x horizontal, positive downwind (x3), y up
(x2), both measured from the conductor in equilibrium. The ellipses are envelopes of observations on
lines, not a prediction; sag and swing are those of the ice and wind of the utility's rule.

The formulas are those of two open programs, which agree: the functions of github.com/mpewsey/civpy
(civpy/tline, BSD licence), and the ellipses of PLS-CADD in the sample report of
github.com/mpewsey/plsxml (plsxml/data/galloping.xml), which the tests compare. CIGRE's Technical
Brochure 322 (2007) itself was not available.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.histories import ellipse_distances

FOOT = 0.3048
"""Length of a foot [m]."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """An ellipse in the plane across the span.

    Attributes
    ----------
    major, minor
        Lengths of the whole axes [m].
    offset
        Length of the major axis below the conductor in equilibrium [m], B in the literature.
    rotation
        Angle of the major axis to the vertical [rad]; positive: the upper end is upwind.
    """

    major: float
    minor: float
    offset: float
    rotation: float

    @property
    def centre(self) -> tuple[float, float]:
        """Coordinates x, y of the centre [m]."""
        above = 0.5 * self.major - self.offset
        return -above * math.sin(self.rotation), above * math.cos(self.rotation)

    def inside_ellipse(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Check that points x, y [m], of equal shape, are inside the ellipse or on its edge."""
        along, across = self._own_axes(x, y)
        return np.asarray(np.hypot(along / (0.5 * self.major), across / (0.5 * self.minor)) <= 1.0)

    def distance(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Return the distance of points x, y [m], of equal shape, from the edge; negative inside.

        ``kernel/history_ellipse.c`` has the method.
        """
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        return ellipse_distances(
            np.asarray(x),
            np.asarray(y),
            (*self.centre, 0.5 * self.major, 0.5 * self.minor, cosine, sine),
        )

    def outline(self, points: int = 181) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return points x, y of the edge [m]; the last is the first."""
        angle = np.linspace(0.0, 2.0 * math.pi, points)
        along, across = 0.5 * self.major * np.cos(angle), 0.5 * self.minor * np.sin(angle)
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        x, y = self.centre
        return x - along * sine + across * cosine, y + along * cosine + across * sine

    def _own_axes(
        self, x: ArrayLike, y: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return coordinates along the major and the minor axis, from the centre."""
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        dx = np.asarray(x, dtype=np.float64) - self.centre[0]
        dy = np.asarray(y, dtype=np.float64) - self.centre[1]
        return dy * cosine - dx * sine, dx * cosine + dy * sine


def cigre_322_single_loop(sag: float, diameter: float) -> Ellipse:
    """Return the ellipse of CIGRE 322 for a single conductor galloping in one loop.

    With d the diameter: major = 80 d ln(8 sag / (50 d)), minor = 0.4 major, offset = 0.3 major, no
    rotation.

    Parameters
    ----------
    sag
        Sag at mid-span [m], more than 6.25 diameters.
    diameter
        Diameter of the conductor without ice [m].

    Raises
    ------
    ValueError
        A length is not positive, or the sag is too small.
    """
    _check_positive(sag=sag, diameter=diameter)
    if sag <= 6.25 * diameter:
        raise ValueError(
            f"sag = {sag} m: must exceed 6.25 diameters, which is {6.25 * diameter:.4g} m"
        )
    major = 80.0 * diameter * math.log(8.0 * sag / (50.0 * diameter))
    return Ellipse(major, 0.4 * major, 0.3 * major, rotation=0.0)


def davison_single_loop(sag: float, swing: float = 0.0) -> Ellipse:
    """Return the ellipse of Davison for a conductor galloping in one loop.

    major = 1.25 sag + 1 ft, minor = 0.4 major, offset = 0.25 sag, rotation by half the swing. The
    sources do not give the direction; here it is that of the plane of the span, so that the upper
    end is upwind.

    Parameters
    ----------
    sag
        Sag at mid-span [m].
    swing
        Swing angle of the span in the wind [rad], positive downwind. The ellipse then refers to
        the conductor at that angle.

    Raises
    ------
    ValueError
        The sag is not positive, or the swing is a right angle or more.
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
