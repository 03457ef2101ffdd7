"""Mass, eccentricity and inertia of ice from its thickness, density and a stated shape.

All shapes are symmetric about the line from the conductor's centre to the thickest ice. With r the
conductor's radius and t the maximum thickness:

- ``radial``: a ring of thickness t; no eccentricity.
- ``crescent``: the windward half of an ellipse with semi-axes r + t (to the nose) and r, minus the
  half conductor; the thickness is zero at the top and bottom.
- ``eccentric_circle``: a circle of radius r + t/2 that touches the conductor on the leeward side.
- ``d_shape``: a flat face as wide as the conductor, at r + t from its centre, with sides tangent to
  the conductor.

The integrals are those of rectangles, circles and half ellipses about the conductor's centre.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

IceShape = Literal["radial", "crescent", "eccentric_circle", "d_shape"]


class IceSection(NamedTuple):
    """Mass and moments of the ice.

    Attributes
    ----------
    mass_per_length : float
        Mass per unit length [kg/m].
    first_moment : float
        First moment about the conductor's centre towards the thickest ice [kg].
    torsional_inertia : float
        Moment of inertia per unit length about the conductor's centre [kg m].
    """

    mass_per_length: float
    first_moment: float
    torsional_inertia: float

    def first_moments(self, attack_angle: float) -> tuple[float, float]:
        """Return the first moments along x2 and x3 [kg] at an attack angle [rad].

        At angle zero the wind, towards +x3, meets the thickest ice; a positive angle raises the
        windward edge, like a positive twist.
        """
        return self.first_moment * math.sin(attack_angle), -self.first_moment * math.cos(
            attack_angle
        )


def ice_section(shape: IceShape, diameter: float, thickness: float, density: float) -> IceSection:
    """Return the integrals of the density over the ice.

    Parameters
    ----------
    shape
        One of the shapes above.
    diameter
        Diameter of the bare conductor [m].
    thickness
        Maximum ice thickness [m].
    density
        Density of the ice [kg/m3]: glaze 900, hard rime 600 to 900, wet snow 300 to 600 (ISO
        12494).
    """
    r, t = 0.5 * diameter, thickness
    nose = r + t
    if shape == "radial":
        area, first, polar = math.pi * (nose**2 - r**2), 0.0, 0.5 * math.pi * (nose**4 - r**4)
    elif shape == "crescent":
        area = 0.5 * math.pi * r * t
        first = 2.0 / 3.0 * r * (nose**2 - r**2)
        polar = 0.125 * math.pi * nose * r * (nose**2 + r**2) - 0.25 * math.pi * r**4
    elif shape == "eccentric_circle":
        R, shift = r + 0.5 * t, 0.5 * t
        area, first = math.pi * (R**2 - r**2), math.pi * R**2 * shift
        polar = math.pi * R**2 * (0.5 * R**2 + shift**2) - 0.5 * math.pi * r**4
    else:
        area = 2.0 * r * nose - 0.5 * math.pi * r**2
        first = r * nose**2 - 2.0 / 3.0 * r**3
        polar = 2.0 / 3.0 * r * nose * (nose**2 + r**2) - 0.25 * math.pi * r**4
    return IceSection(density * area, density * first, density * polar)
