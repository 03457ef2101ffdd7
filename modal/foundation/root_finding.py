"""Roots of functions in an interval."""

from __future__ import annotations

from collections.abc import Callable

MAX_ROUND_OFF = 1e-9
"""Value at an end, relative to the other end, that may be the round-off of a root."""

RELATIVE_TOLERANCE = 1e-14
"""Relative accuracy of a root."""

MAX_EVALUATIONS = 60
"""Most evaluations of `costly_root`: as many halvings leave no bits of an interval."""


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


def costly_root(
    function: Callable[[float], float],
    ends: tuple[float, float],
    values: tuple[float, float],
    tolerance: float,
) -> float:
    """Find the root of a function in an interval with few evaluations.

    The points are those of Chandrupatla (1997), A new hybrid quadratic/bisection algorithm for
    finding the zero of a nonlinear function without using derivatives, Advances in Engineering
    Software 28, 145-149: inverse quadratic interpolation or, where that is not monotonic,
    bisection. The search ends at a point from which the next one is less than the tolerance away.
    Brent's method would then evaluate one or two more, to enclose the root.

    Parameters
    ----------
    function
        A continuous function, expensive to evaluate.
    ends, values
        Ends of the interval, and the function there, of different signs.
    tolerance
        Absolute accuracy of the root.

    Returns
    -------
    float
        The last point at which the function was evaluated, or an end.
    """
    (a, b), (at_a, at_b) = ends, values
    if at_a == 0.0 or at_b == 0.0:
        return a if at_a == 0.0 else b
    move = (b - a) * at_a / (at_a - at_b)
    for _ in range(MAX_EVALUATIONS):
        x = a + move
        at_x = function(x)
        c, at_c = a, at_a
        if at_x * at_a < 0.0:  # the root is between x and a, and c is the other end
            c, at_c, b, at_b = b, at_b, a, at_a
        a, at_a = x, at_x
        place, value = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
        move = 0.5 * (b - a)
        if value**2 < place and (1.0 - value) ** 2 < 1.0 - place:
            to_b, to_c = at_a / (at_b - at_a), at_a / (at_c - at_a)
            move = (b - a) * to_b * at_c / (at_b - at_c) + (c - a) * to_c * at_b / (at_c - at_b)
        if at_a == 0.0 or abs(move) < tolerance:
            break
    return a
