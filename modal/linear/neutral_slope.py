"""Slope p at which a mode of M s^2 + (C + p C1) s + K + p K1 neither grows nor decays: s = i w.

With A the matrix above, Newton's method for A x = 0, l* x = 1 in the unknowns x, w and p gives,
with y = A^-1 (dA/ds) x and z = A^-1 (dA/dp) x,

    new x = -(y i dw + z dp),    i dw (l* y) + dp (l* z) = -1,

one complex equation for the real dw and dp. At the solution ds/dp = -(l* z)/(l* y).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MAX_ITERATIONS = 30
"""Most Newton iterations."""

TOLERANCE = 1e-10
"""Relative change of frequency and slope at which the iteration ends."""


@dataclass(frozen=True)
class NeutralMode:
    """A mode that neither grows nor decays.

    Attributes
    ----------
    omega : float
        Angular frequency [rad/s].
    slope : float
        Slope p [1/rad].
    growth_by_slope : float
        Derivative of the growth rate Re(s) by the slope [rad/s].
    vector : ndarray, shape (unknown,)
        Complex motion of the free unknowns, with modal mass 1.
    """

    omega: float
    slope: float
    growth_by_slope: float
    vector: ComplexArray


@dataclass(frozen=True)
class SlopeProblem:
    """Equations of small motion of the free unknowns, linear in a slope.

    Attributes
    ----------
    mass, damping, stiffness : sparse array, shape (unknown, unknown)
        M, C and K of the module.
    slope_damping, slope_stiffness : sparse array, shape (unknown, unknown)
        C1 and K1.
    """

    mass: csc_array
    damping: csc_array
    stiffness: csc_array
    slope_damping: csc_array
    slope_stiffness: csc_array

    def neutral(self, start: NeutralMode) -> NeutralMode | None:
        """Find the neutral mode near a start; None if the iteration does not converge."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        omega, slope = start.omega, start.slope
        x = _normalised(start.vector, self.mass)
        for _ in range(MAX_ITERATIONS):
            s = 1j * omega
            damping = self.damping + slope * self.slope_damping
            stiffness = self.stiffness + slope * self.slope_stiffness
            try:
                factors = splu(csc_array(s**2 * self.mass + s * damping + stiffness))
            except RuntimeError:  # exactly singular: the start is the solution
                omega *= 1.0 + TOLERANCE
                continue
            y = factors.solve(2.0 * s * (self.mass @ x) + damping @ x)
            z = factors.solve(s * (self.slope_damping @ x) + self.slope_stiffness @ x)
            left = (self.mass @ x).conj()
            by_value, by_slope = complex(left @ y), complex(left @ z)
            along = 1j * by_value
            determinant = along.real * by_slope.imag - along.imag * by_slope.real
            if not abs(determinant) > 0.0:  # also where it is not a number
                return None
            d_omega, d_slope = -by_slope.imag / determinant, along.imag / determinant
            omega, slope = omega + d_omega, slope + d_slope
            if not (np.isfinite(omega * slope) and omega > 0.0):
                return None
            x = _normalised(-(1j * d_omega * y + d_slope * z), self.mass)
            if abs(d_omega) <= TOLERANCE * omega and abs(d_slope) <= TOLERANCE * (1.0 + abs(slope)):
                return NeutralMode(omega, slope, (-by_slope / by_value).real, x)
        return None


def _normalised(vector: ComplexArray, mass: csc_array) -> ComplexArray:
    """Scale a vector to modal mass 1."""
    return np.asarray(vector / np.sqrt((vector.conj() @ (mass @ vector)).real))
