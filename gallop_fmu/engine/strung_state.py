"""Points of the strung state that the kernel needs: catenaries, and clamps of end strings.

The strung state has catenaries y = c (cosh((x - a)/c) - cosh(a/c)) with c = H/w, here from a left
end at (0, 0) to a right end at (span, rise).
"""

from __future__ import annotations

import math

_ROUNDS = 60
_SETTLED = 1e-15
"""Change of an angle [rad] in a round; each round reduces it by about length over span."""


def lowest_point(span: float, rise: float, c: float) -> float:
    """Distance a [m] of the lowest point from the left end; `c` is H/w [m]."""
    return 0.5 * span - c * math.asinh(rise / (2.0 * c * math.sinh(span / (2.0 * c))))


def point_at_fraction(span: float, rise: float, c: float, fraction: float) -> tuple[float, float]:
    """Point x, y [m] of a catenary at a fraction of its length from the left end."""
    a = lowest_point(span, rise, c)
    start, end = math.sinh(-a / c), math.sinh((span - a) / c)
    x = a + c * math.asinh(start + fraction * (end - start))
    return x, _height(x, a, c)


def clamp_of_end_string(
    span: float, rise: float, c: float, length: float, weight: float
) -> tuple[float, float]:
    """Clamp x, y [m], from the tower's point, of a dead-end string at the left end of a span.

    The string is a straight bar that is in equilibrium with the strung conductor: about the tower's
    point the moments of the tension, of the conductor's weight and of its own weight W vanish,
    ``tan(angle below the horizontal) = (V + W/2) / H``. V is the vertical pull of the conductor.

    For a string at the right end, mirror the span: its rise is the negative one, and x is counted
    to the left.

    Parameters
    ----------
    span, rise
        Horizontal distance and height of the far attachment from the tower's point [m].
    c
        Horizontal tension over weight per unit length of the conductor [m].
    length
        Length of the string [m], less than the span.
    weight
        Weight of the string over that of the conductor per unit length [m].
    """
    angle = 0.0
    for _ in range(_ROUNDS):
        x, y = length * math.cos(angle), -length * math.sin(angle)
        pull = c * math.sinh(lowest_point(span - x, rise - y, c) / c)
        before, angle = angle, math.atan((pull + 0.5 * weight) / c)
        if abs(angle - before) < _SETTLED:
            break
    return length * math.cos(angle), -length * math.sin(angle)


def _height(x: float, a: float, c: float) -> float:
    """Height at x above the left end: c (cosh((x - a)/c) - cosh(a/c)), without cancellation."""
    return 2.0 * c * math.sinh(0.5 * x / c) * math.sinh((0.5 * x - a) / c)
