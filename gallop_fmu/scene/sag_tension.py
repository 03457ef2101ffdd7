"""Change of state: tension of a conductor at another temperature or with another load.

The unstretched length changes by thermal expansion only, here on the elastic catenary. The textbook
form on the parabola is the cubic H^2 (H - H0 + EA w0^2 L^2/(24 H0^2) + EA a dT) = EA w^2 L^2/24. In
a section of several spans with vertical insulators the horizontal tension is that of the
`ruling_span`. Creep, and the unloading of the aluminium of a hot ACSR, are neglected.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from gallop_fmu.foundation.errors import SceneError

MIN_TENSION_RATIO = 0.1
"""Minimum horizontal tension over the weight of the span; the sag is then seven times the span."""

MAX_STRAIN = 0.02
"""Maximum strain; no conductor withstands more."""


def ruling_span(spans: Sequence[float]) -> float:
    """Ruling span [m] of a section of several spans [m]: sqrt(sum L^3 / sum L)."""
    return math.sqrt(sum(span**3 for span in spans) / sum(spans))


def unstretched_length(
    span: float,
    weight: float,
    tension: float,
    axial_stiffness: float,
    height_difference: float = 0.0,
) -> float:
    """Return the length [m] of a hanging conductor without tension.

    Parameters
    ----------
    span
        Horizontal distance between the supports [m].
    weight
        Weight per unit length [N/m].
    tension
        Horizontal tension [N].
    axial_stiffness
        Axial stiffness EA [N].
    height_difference
        Height of one support above the other [m].

    Notes
    -----
    The length of the catenary minus its elongation, the integral of T/EA.
    """
    c = tension / weight
    half, middle = _half_and_middle(span, c, height_difference)
    ends = middle - half, middle + half
    length = c * (math.sinh(ends[1]) - math.sinh(ends[0]))
    # T = H cosh(x/c) and ds = cosh(x/c) dx
    integral = (
        0.5 * tension * (span + 0.5 * c * (math.sinh(2.0 * ends[1]) - math.sinh(2.0 * ends[0])))
    )
    return length - integral / axial_stiffness


def check_tension(
    name: str, tension: float, weight: float, span: float, question: str = "is it in kN?"
) -> None:
    """Refuse a tension that is too small for a line.

    Parameters
    ----------
    name
        Name and value of the tension for the message, such as "stringing_tension = 5 N".
    tension
        Horizontal tension [N].
    weight
        Weight per unit length [N/m].
    span
        Horizontal distance between the supports [m].
    question
        Question about the probable mistake.

    Raises
    ------
    SceneError
        The tension is less than `MIN_TENSION_RATIO` times the weight of the span.
    """
    total = weight * span
    if tension >= MIN_TENSION_RATIO * total:
        return
    parts = {1e-3: "a thousandth", 1e-2: "a hundredth", MIN_TENSION_RATIO: "a tenth"}
    part = next(text for part, text in parts.items() if tension < part * total)
    raise SceneError(
        f"{name} is less than {part} of the weight of the span ({total:.4g} N); {question}"
    )


def changed_tension(
    tension: float,
    *,
    span: float,
    weight: float,
    new_weight: float,
    axial_stiffness: float,
    temperature_change: float = 0.0,
    expansion: float = 0.0,
    height_difference: float = 0.0,
) -> float:
    """Return the horizontal tension [N] after a change of temperature or load.

    The weight refers to the length of the stretched cable in both states. With a constant mass of
    the unstretched cable the tension differs by up to 0.13 % (200 random level spans of 60 to 600
    m).

    Parameters
    ----------
    tension, weight
        Horizontal tension [N] and weight per unit length [N/m] of the known state.
    new_weight
        Weight per unit length of the new state [N/m], with ice.
    temperature_change
        Rise of temperature [K].
    expansion
        Coefficient of linear expansion [1/K].
    span, axial_stiffness, height_difference
        See `unstretched_length`.

    Raises
    ------
    SceneError
        The tension is too small for the span, or no tension is possible, as for extreme cooling or
        wrong units.
    """
    from scipy.optimize import brentq  # slow import

    if not (math.isfinite(temperature_change) and math.isfinite(expansion)):
        raise SceneError(
            f"temperature_change = {temperature_change} K, expansion = {expansion} 1/K: must be"
            " finite"
        )
    check_tension(f"tension = {tension:g} N", tension, weight, span)
    if not tension < MAX_STRAIN * axial_stiffness:
        raise SceneError(
            f"tension = {tension:g} N is more than {MAX_STRAIN:.0%} of axial_stiffness ="
            f" {axial_stiffness:g} N, which no conductor withstands; check the units (both in N)"
        )
    before = unstretched_length(span, weight, tension, axial_stiffness, height_difference)
    wanted = before * math.exp(expansion * temperature_change)

    def excess(guess: float) -> float:
        return (
            unstretched_length(span, new_weight, guess, axial_stiffness, height_difference) - wanted
        )

    # Search between a tension with a sag of a thousand spans, and the maximum strain.
    low, high = 0.5 * MIN_TENSION_RATIO * new_weight * span, MAX_STRAIN * axial_stiffness
    if not excess(low) > 0.0 > excess(high):
        raise SceneError(
            f"no tension is possible for a temperature change of {temperature_change} K and a"
            f" weight of {new_weight:.6g} N/m: the unstretched length would be {wanted:.6g} m in a"
            f" span of {span} m; check the units"
        )
    return float(brentq(excess, low, high, rtol=1e-14))


def _half_and_middle(span: float, c: float, height_difference: float) -> tuple[float, float]:
    """Half the span, and the distance of mid-span from the lowest point, both over c = H/w."""
    half = 0.5 * span / c
    return half, math.asinh(0.5 * height_difference / (c * math.sinh(half)))


def catenary_sag(
    span: float, weight: float, tension: float, height_difference: float = 0.0
) -> float:
    """Sag [m] of a catenary at mid-span, measured vertically from the chord.

    Arguments as in `unstretched_length`. It is the mean height of the ends above mid-span,
    c (cosh a - 1) cosh m, with a and m of `_half_and_middle`.
    """
    c = tension / weight
    half, middle = _half_and_middle(span, c, height_difference)
    return 2.0 * c * math.sinh(0.5 * half) ** 2 * math.cosh(middle)


def highest_tension(
    span: float, weight: float, tension: float, height_difference: float = 0.0
) -> float:
    """Tension [N] of a catenary at its higher end; arguments as in `unstretched_length`."""
    half, middle = _half_and_middle(span, tension / weight, height_difference)
    return tension * math.cosh(half + abs(middle))


def tension_of_sag(sag: float, span: float, weight: float, height_difference: float = 0.0) -> float:
    """Return the horizontal tension [N] of a catenary with a given sag.

    Parameters
    ----------
    sag
        Sag at mid-span, measured vertically from the chord [m].
    span, weight, height_difference
        See `unstretched_length`.
    """
    # The sag decreases with the tension, and a catenary hangs deeper than its parabola.
    low = 0.125 * weight * span**2 / sag
    high = 2.0 * low * math.hypot(1.0, height_difference / span)
    while catenary_sag(span, weight, high, height_difference) > sag:
        high *= 2.0
    middle = 0.5 * (low + high)
    while low < middle < high:
        if catenary_sag(span, weight, middle, height_difference) > sag:
            low = middle
        else:
            high = middle
        middle = 0.5 * (low + high)
    return middle
