"""Sag and tension of a strung conductor at another temperature or with another load: the change of state.

The conductor keeps its unstretched length but for thermal expansion, here on the elastic catenary;
its textbook form on the parabola is the cubic H^2 (H - H0 + EA w0^2 L^2/(24 H0^2) + EA a dT) = EA
w^2 L^2/24. In a section of several spans with upright insulators the horizontal tension is the same
in all and follows that of the `ruling_span`. Creep, and the slackening of the aluminium of a hot
ACSR, are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from gallop_fmu.foundation.errors import SceneError

LEAST_TENSION = 0.1
"""Least horizontal tension of a line, in parts of the weight of the span: there the sag is seven times the span."""

LARGEST_STRAIN = 0.02
"""Strain that no conductor bears."""


def ruling_span(spans: Sequence[float]) -> float:
    """Span [m] whose tension changes like that of a section of several spans [m]: sqrt(sum L^3 / sum L)."""
    return math.sqrt(sum(span**3 for span in spans) / sum(spans))


def unstretched_length(
    span: float,
    weight: float,
    tension: float,
    axial_stiffness: float,
    height_difference: float = 0.0,
) -> float:
    """Length [m] that a hanging conductor would have without tension.

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
    The catenary's length less its elastic stretch, the integral of T/EA.
    """
    c = tension / weight
    half = 0.5 * span / c
    middle = math.asinh(0.5 * height_difference / (c * math.sinh(half)))
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
    """Refuse a tension under which no line hangs, before a catenary is computed from it.

    Parameters
    ----------
    name
        Name and value of the tension in the message, such as "stringing_tension = 5 N".
    tension
        Horizontal tension [N].
    weight
        Weight per unit length [N/m].
    span
        Horizontal distance between the supports [m].
    question
        Probable mistake, as a question.

    Raises
    ------
    SceneError
        If the tension is less than `LEAST_TENSION` times the weight of the span.
    """
    total = weight * span
    if tension >= LEAST_TENSION * total:
        return
    parts = {1e-3: "a thousandth", 1e-2: "a hundredth", LEAST_TENSION: "a tenth"}
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
    """Horizontal tension [N] after a change of temperature or load.

    The weight counts per length of the hanging, stretched cable in both states. A cable whose mass
    stays with its rest length has a tension that differs by up to 0.13 % (200 drawn level spans of
    60 to 600 m).

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
        If the tension is far too small for the span, or no tension fits, which a strong cooling or
        wrong units can cause.
    """
    from scipy.optimize import brentq  # slow to import

    if not (math.isfinite(temperature_change) and math.isfinite(expansion)):
        raise SceneError(
            f"temperature_change = {temperature_change} K, expansion = {expansion} 1/K: must be"
            " finite"
        )
    check_tension(f"tension = {tension:g} N", tension, weight, span)
    if not tension < LARGEST_STRAIN * axial_stiffness:
        raise SceneError(
            f"tension = {tension:g} N is more than {LARGEST_STRAIN:.0%} of axial_stiffness ="
            f" {axial_stiffness:g} N, which no conductor bears; check the units (both in N)"
        )
    before = unstretched_length(span, weight, tension, axial_stiffness, height_difference)
    wanted = before * math.exp(expansion * temperature_change)

    def excess(guess: float) -> float:
        return (
            unstretched_length(span, new_weight, guess, axial_stiffness, height_difference) - wanted
        )

    # slacker than any line, where the sag is a thousand times the span; tighter than the conductor
    # bears
    low, high = 0.5 * LEAST_TENSION * new_weight * span, LARGEST_STRAIN * axial_stiffness
    if not excess(low) > 0.0 > excess(high):
        raise SceneError(
            f"no tension fits a temperature change of {temperature_change} K and a weight of"
            f" {new_weight:.6g} N/m: the unstretched length would be {wanted:.6g} m in a span of"
            f" {span} m; check the units"
        )
    return float(brentq(excess, low, high, rtol=1e-14))
