"""Points of the strung state that the kernel needs: catenaries, and clamps of end strings.

The strung state has catenaries y = c (cosh((x - a)/c) - cosh(a/c)) with c = H/w, here from a left
end at (0, 0) to a right end at (span, rise).
"""

from __future__ import annotations

import math


def lowest_point(span: float, rise: float, c: float) -> float:
    """Distance a [m] of the lowest point from the left end; `c` is H/w [m]."""
    return 0.5 * span - c * math.asinh(rise / (2.0 * c * math.sinh(span / (2.0 * c))))


def point_at_fraction(span: float, rise: float, c: float, fraction: float) -> tuple[float, float]:
    """Point x, y [m] of a catenary at a fraction of its length from the left end."""
    a = lowest_point(span, rise, c)
    start, end = math.sinh(-a / c), math.sinh((span - a) / c)
    x = a + c * math.asinh(start + fraction * (end - start))
    return x, _height(x, a, c)


def clamp_of_end_string(span: float, rise: float, c: float, length: float) -> tuple[float, float]:
    """Point x, y [m] of a catenary at a straight distance from its left end.

    For a string at the right end, mirror the span: its rise is the negative one, and x is counted
    to the left.

    Parameters
    ----------
    span, rise
        Horizontal distance of the ends, and height of the far end above the near one [m].
    c
        Horizontal tension over weight per unit length [m].
    length
        Length of the string [m], less than the span.
    """
    a = lowest_point(span, rise, c)
    low, high = 0.0, min(length, span)
    middle = 0.5 * (low + high)
    while low < middle < high:  # the distance increases with x
        if math.hypot(middle, _height(middle, a, c)) < length:
            low = middle
        else:
            high = middle
        middle = 0.5 * (low + high)
    return middle, _height(middle, a, c)


def _height(x: float, a: float, c: float) -> float:
    """Height at x above the left end: c (cosh((x - a)/c) - cosh(a/c)), without cancellation."""
    return 2.0 * c * math.sinh(0.5 * x / c) * math.sinh((0.5 * x - a) / c)
