"""Lift, drag and moment coefficients over the attack angle, as one piecewise-cubic curve.

Coefficients refer to the bare conductor's diameter: forces per unit length are q d CL and q d CD,
the moment q d^2 CM, with q the dynamic pressure of the relative wind. Lift acts normal to the
relative wind (up when the wind blows along +x3), drag along it, the moment in the sense of the
twist.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.foundation.errors import SceneError

Values = NDArray[np.float64]
Outside = Literal["error", "hold", "periodic"]
COEFFICIENTS = ("lift", "drag", "moment")
TURN = 2.0 * np.pi


@dataclass(frozen=True)
class AerodynamicCurve:
    """Coefficients as cubics between breakpoints; attack angles in rad, arrays of any shape.

    An attack angle is first reduced modulo 2 pi to the turn centred on the validity range.

    Attributes
    ----------
    breakpoint : (pieces + 1,) array
        Ends of the pieces [rad], increasing; the first and last bound the validity range.
    origin : (pieces,) array
        Origin [rad] of the polynomial of each piece.
    coefficient : (pieces, 3, 4) array
        For each piece lift, drag, moment: coefficients of powers 0..3 of (alpha - origin[piece]).
    outside : {"error", "hold", "periodic"}
        Rule outside the validity range.
    """

    breakpoint: Values
    origin: Values
    coefficient: Values
    outside: Outside

    def lift(self, alpha: ArrayLike) -> Values:
        """Lift coefficient CL.

        Raises
        ------
        SceneError
            An angle is outside the validity range and `outside` is "error"; also in the other
            methods.
        """
        return self._evaluate(alpha, 0)

    def drag(self, alpha: ArrayLike) -> Values:
        """Drag coefficient CD."""
        return self._evaluate(alpha, 1)

    def moment(self, alpha: ArrayLike) -> Values:
        """Moment coefficient CM."""
        return self._evaluate(alpha, 2)

    def lift_slope(self, alpha: ArrayLike) -> Values:
        """Slope dCL/dalpha per radian; zero outside the validity range with ``"hold"``."""
        return self._slope(alpha, 0)

    def moment_slope(self, alpha: ArrayLike) -> Values:
        """Slope dCM/dalpha per radian; zero outside the validity range with ``"hold"``."""
        return self._slope(alpha, 2)

    def den_hartog(self, alpha: ArrayLike) -> Values:
        """Den Hartog's dCL/dalpha + CD per radian; vertical galloping requires a negative value."""
        return self.lift_slope(alpha) + self.drag(alpha)

    def _evaluate(self, alpha: ArrayLike, which: int) -> Values:
        _, piece, x = self._locate(alpha)
        c = self.coefficient[piece, which]
        return np.asarray(c[..., 0] + x * (c[..., 1] + x * (c[..., 2] + x * c[..., 3])))

    def _slope(self, alpha: ArrayLike, which: int) -> Values:
        angle, piece, x = self._locate(alpha)
        c = self.coefficient[piece, which]
        slope = c[..., 1] + x * (2.0 * c[..., 2] + 3.0 * x * c[..., 3])
        is_outside = (angle < self.breakpoint[0]) | (angle > self.breakpoint[-1])
        return np.where(is_outside, 0.0, slope)

    def _locate(self, alpha: ArrayLike) -> tuple[Values, NDArray[np.intp], Values]:
        """Return the reduced angle, its piece, and the distance from the origin of the piece."""
        first, last = self.breakpoint[0], self.breakpoint[-1]
        angle = np.asarray(alpha, dtype=np.float64)
        angle = angle - TURN * np.round((angle - 0.5 * (first + last)) / TURN)
        if self.outside == "error" and not np.all((angle >= first) & (angle <= last)):
            worst = angle[~((angle >= first) & (angle <= last))].flat[0]
            raise SceneError(
                f"attack angle {np.degrees(worst):g} deg is outside the coefficient curve, which"
                f" is valid from {np.degrees(first):g} to {np.degrees(last):g} deg; choose an angle"
                ' inside, or set outside = "hold"'
            )
        inside = np.clip(angle, first, last)
        piece = np.clip(
            np.searchsorted(self.breakpoint, inside, side="right") - 1, 0, len(self.coefficient) - 1
        )
        return angle, piece, inside - self.origin[piece]
