"""Roots between two known ends."""

from __future__ import annotations

from collections.abc import Callable

ROUND_OFF = 1e-9
"""Value at one end of a bracket, in parts of the value at the other, that may be the round-off of a root there."""


def bracketed_root(
    function: Callable[[float], float], low: float, high: float, xtol: float = 1e-14
) -> float:
    """Root of a function that changes sign between two ends, one of which may be the root itself.

    Where an end is an analytic value of the root, round-off decides the sign of the function there:
    pi/l l - pi is 4e-16 or -4e-16. Such an end is the root.

    Raises
    ------
    ValueError
        If the signs are the same and neither value is round-off.
    """
    from scipy.optimize import brentq  # slow to import

    at_low, at_high = function(low), function(high)
    if at_low * at_high > 0.0:
        smaller, larger = sorted((abs(at_low), abs(at_high)))
        if not smaller <= ROUND_OFF * larger:
            raise ValueError(f"no change of sign between {low} ({at_low}) and {high} ({at_high})")
        return low if abs(at_low) == smaller else high
    return float(brentq(function, low, high, xtol=xtol, rtol=1e-14))
