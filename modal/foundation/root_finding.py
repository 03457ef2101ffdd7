"""Roots of functions in an interval."""

from __future__ import annotations

from collections.abc import Callable

MAX_ROUND_OFF = 1e-9
"""Value at an end, relative to the other end, that may be the round-off of a root."""

RELATIVE_TOLERANCE = 1e-14
"""Relative accuracy of a root."""


def bracketed_root(
    function: Callable[[float], float], low: float, high: float, xtol: float = 1e-14
) -> float:
    """Find the root of a function in an interval, one end of which may be the root itself.

    If an end is the exact root, round-off decides the sign of the function there: pi/l l - pi is
    4e-16 or -4e-16. Such an end is returned.

    Parameters
    ----------
    function
        The function.
    low, high
        Ends of the interval.
    xtol
        Absolute accuracy of the root.

    Raises
    ------
    ValueError
        If the signs are the same and neither value is round-off.
    """
    from scipy.optimize import brentq  # slow to import

    at_low, at_high = function(low), function(high)
    if at_low * at_high > 0.0:
        smaller, larger = sorted((abs(at_low), abs(at_high)))
        if not smaller <= MAX_ROUND_OFF * larger:
            raise ValueError(f"no change of sign between {low} ({at_low}) and {high} ({at_high})")
        return low if abs(at_low) == smaller else high
    return float(brentq(function, low, high, xtol=xtol, rtol=RELATIVE_TOLERANCE))
