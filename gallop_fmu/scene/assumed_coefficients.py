"""An assumed coefficient curve over the full circle, with the ice thickness as its parameter.

No source has these numbers. With s = t/d, the maximum ice thickness over the diameter of the bare
conductor, and the attack angle a (0: the wind meets the thickest ice):

    CL = -L (1 - exp(-s/s0)) sin 2a                                                              (1)
    CD = D (1 + s sin^2 a)                                                                       (2)
    CM = e s (CD sin a + CL cos a)                                                               (3)

- (1) The lift is zero where the iced section is symmetric about the wind, at 0 and 180 deg, and
  falls there, so that the span can gallop; it is zero for a round section, s = 0. Without damping,
  galloping begins at 2 L (1 - exp(-s/s0)) = D.
- (2) The drag is that of a round section times the width across the wind, d + t at 90 deg.
- (3) Lift and drag act at a point on the axis of symmetry, at e t from the conductor's centre
  towards the thickest ice.

L is calibrated: simulated amplitudes follow CIGRE 322's envelope of observed ones
(``benchmarks/accuracy/assumed_curve.py``). D, s0 and e are chosen.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from gallop_fmu.scene.aerodynamic_curve import TURN, AerodynamicCurve, Outside, Values
from gallop_fmu.scene.curve_fields import RADIUS_MEANING
from gallop_fmu.scene.fields import Number, Section, quantity, setting
from gallop_fmu.scene.table_coefficients import TableCoefficients

LIFT = 1.25
"""L, the largest lift coefficient of thick ice; calibrated."""

LIFT_THICKNESS = 0.05
"""s0, the relative ice thickness at which the lift is 63 % of its largest; chosen.

A wind-tunnel study of iced poles found the most negative Den Hartog coefficient at 3 to 6 % ("The
galloping instability of ice coated poles", abstract).
"""

DRAG = 1.0
"""D, the drag coefficient of a round section; chosen."""

MOMENT_ARM = 0.25
"""e, distance of the force from the conductor's centre over the ice thickness; chosen."""

PIECES = 72
"""Number of cubic pieces of the turn; their values differ from (1) to (3) by at most 1e-5."""


class AssumedCoefficients(Section):
    """An ASSUMED curve over the full circle for ice of a given thickness; it was not measured.

    The equations are those of `gallop_fmu.scene.assumed_coefficients`.
    """

    kind: Literal["assumed"] = setting("assumed", "kind of coefficient curve")
    ice_thickness_ratio: Number = quantity(
        ..., "1", "maximum ice thickness over the diameter of the bare conductor", ge=0, le=2
    )
    reference_radius: Number | None = quantity(None, "m", RADIUS_MEANING, gt=0)

    @property
    def beyond(self) -> Outside:
        """Rule outside the validity range: the curve is periodic."""
        return "periodic"

    @property
    def range_deg(self) -> tuple[float, float]:
        """Validity range [deg]."""
        return -180.0, 180.0

    @property
    def label(self) -> str:
        """Name and parameter of the curve."""
        return f"ASSUMED, not measured: ice of {self.ice_thickness_ratio:.3g} diameters"

    def warnings(self) -> list[str]:
        """Warning that the curve is assumed."""
        return [
            "the coefficient curve is ASSUMED, not measured (ice of"
            f" {self.ice_thickness_ratio:.3g} diameters); amplitudes show an order of magnitude:"
            " use measured coefficients of the ice for design"
        ]

    def coefficients(self, alpha: Values) -> tuple[Values, Values]:
        """Equations (1) to (3) and their derivatives.

        Parameters
        ----------
        alpha
            Attack angles [rad].

        Returns
        -------
        value, slope : (3, len(alpha)) array
            Lift, drag and moment coefficient, and their slopes per radian.
        """
        s = self.ice_thickness_ratio
        size = -LIFT * (1.0 - np.exp(-s / LIFT_THICKNESS))
        sine, cosine = np.sin(alpha), np.cos(alpha)
        lift, lift_slope = size * np.sin(2.0 * alpha), 2.0 * size * np.cos(2.0 * alpha)
        drag, drag_slope = DRAG * (1.0 + s * sine**2), DRAG * s * np.sin(2.0 * alpha)
        moment = MOMENT_ARM * s * (drag * sine + lift * cosine)
        moment_slope = (
            MOMENT_ARM * s * (drag_slope * sine + drag * cosine + lift_slope * cosine - lift * sine)
        )
        return (
            np.array([lift, drag, moment]),
            np.array([lift_slope, drag_slope, moment_slope]),
        )

    def explicit(self) -> TableCoefficients:
        """Return the curve as a table with a step of 1 deg, up to its interpolation."""
        angle: Values = np.arange(-180.0, 180.0, dtype=np.float64)
        lift, drag, moment = self.coefficients(np.radians(angle))[0].tolist()
        return TableCoefficients(
            angle_deg=angle.tolist(),
            lift=lift,
            drag=drag,
            moment=moment,
            reference_radius=self.reference_radius,
        )

    def curve(self) -> AerodynamicCurve:
        """Return the curve: cubics with the values and slopes of the equations at their ends."""
        step = TURN / PIECES
        start: Values = step * np.arange(-(PIECES // 2), PIECES // 2, dtype=np.float64)
        value, slope = self.coefficients(start)
        next_value, next_slope = np.roll(value, -1, axis=1), np.roll(slope, -1, axis=1)
        chord = (next_value - value) / step
        powers = (
            value,
            slope,
            (3.0 * chord - 2.0 * slope - next_slope) / step,
            (slope + next_slope - 2.0 * chord) / step**2,
        )
        coefficient = np.ascontiguousarray(np.stack(powers).transpose(2, 1, 0))
        return AerodynamicCurve(np.append(start, -start[0]), start, coefficient, self.beyond)
