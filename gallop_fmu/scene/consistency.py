"""Checks of the values of a scene against each other, and warnings about unusual combinations."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.sag_tension import MAX_STRAIN, check_tension
from gallop_fmu.scene.shedding_checks import curves_of, wrong_sheddings_of_span
from gallop_fmu.scene.supports import AdjacentSpanSupport
from gallop_fmu.scene.validation_messages import joined
from gallop_fmu.scene.wind_consistency import (
    check_time_tables,
    check_wind,
    towers_of,
    unusual_wind,
)

if TYPE_CHECKING:
    from gallop_fmu.scene.aerodynamics import Aerodynamics
    from gallop_fmu.scene.conductor import Conductor, Ice
    from gallop_fmu.scene.scene import Scene

SAG_TENSION_AGREEMENT = 0.05
"""Maximum relative difference of a given sag from m g L^2/(8 H); published: 1 to 2 %."""

MAX_SAG_RATIO = 5.0
"""Maximum sag over span; lines have 0.1 or less."""

MIN_USUAL_SAG_RATIO, MAX_USUAL_SAG_RATIO = 5e-4, 0.25
"""Limits of usual sags over the span."""

MAX_LIFT_OF_ROUND_SECTION = 0.01
"""Lift coefficient above which a section is not round."""
NO_CURVE = (
    "wind is given but aerodynamics is not; give a coefficient curve, which is required for the"
    " wind force ([line] coefficients, or a section [aerodynamics]; gallop-fmu curves lists"
    " packaged and assumed ones)"
)
"""Message for wind without a coefficient curve."""

LIFT_POINTS = 73
"""Number of attack angles at which the lift is evaluated."""


def check_consistency(scene: Scene) -> None:
    """Refuse values that contradict each other.

    Raises
    ------
    SceneError
        The message names the values and a remedy.
    """
    _check_sag_and_tension(scene)
    _check_sag_against_tension(scene)
    check_mass_matrix(scene.conductor, scene.ice, "ice")
    _check_aerodynamics(scene)
    if problems := list(wrong_sheddings_of_span(scene)):
        raise SceneError(joined(problems))
    check_time_tables(scene, scene.run.stop_time)
    check_wind(scene.wind, towers_of(scene), scene.run.stop_time)


def unusual_combinations(scene: Scene) -> list[str]:
    """Warnings about values that are unusual together, each a fact and a remedy."""
    curves = [scene.aerodynamics, *curves_of(scene.shedding)]
    return [
        *_unusual_sag(scene),
        *(text for curve in curves if curve is not None for text in curve.warnings()),
        *ice_against_curve(scene.aerodynamics, scene.ice),
        *unusual_wind(scene.wind, scene.run.stop_time),
    ]


def _check_sag_and_tension(scene: Scene) -> None:
    """Refuse a sag or a tension that no span has."""
    span = scene.span
    weight = (scene.conductor.mass_per_length + scene.ice.mass_per_length) * span.gravity
    for end, support in (("left", scene.supports.left), ("right", scene.supports.right)):
        if isinstance(support, AdjacentSpanSupport):
            given = f"supports.{end}.adjacent_tension = {support.adjacent_tension:g} N"
            check_tension(given, support.adjacent_tension, weight, support.adjacent_span)
    if span.horizontal_tension is not None:
        given = f"span.horizontal_tension = {span.horizontal_tension:g} N"
        check_tension(given, span.horizontal_tension, weight, span.length)
    if span.sag is not None and span.sag > MAX_SAG_RATIO * span.length:
        raise SceneError(
            f"span.sag = {span.sag:g} m is more than {MAX_SAG_RATIO:g} times span.length ="
            f" {span.length:g} m; is it in cm or mm?"
        )


def _unusual_sag(scene: Scene) -> list[str]:
    """Warnings about an unusual sag or tension."""
    span, found = scene.span, []
    weight = (
        (scene.conductor.mass_per_length + scene.ice.mass_per_length) * span.gravity * span.length
    )
    sag_ratio = None if span.sag is None else span.sag / span.length
    if sag_ratio is not None and not MIN_USUAL_SAG_RATIO < sag_ratio < MAX_USUAL_SAG_RATIO:
        found.append(
            f"span.sag = {span.sag:g} m is {sag_ratio:.3g} of span.length; usual are"
            f" {MIN_USUAL_SAG_RATIO:g} to {MAX_USUAL_SAG_RATIO:g}; check the units"
        )
    elif (
        span.horizontal_tension is not None
        and 8.0 * MAX_USUAL_SAG_RATIO * span.horizontal_tension < weight
    ):
        found.append(
            f"span.horizontal_tension = {span.horizontal_tension:g} N is small for a weight of the"
            f" span of {weight:.4g} N: the sag is more than {MAX_USUAL_SAG_RATIO:g} of span.length;"
            " check the units"
        )
    if (span.horizontal_tension or 0.0) > MAX_STRAIN * scene.conductor.axial_stiffness:
        found.append(
            f"span.horizontal_tension = {span.horizontal_tension:g} N is more than"
            f" {MAX_STRAIN:.0%} of conductor.axial_stiffness ="
            f" {scene.conductor.axial_stiffness:g} N, which no conductor withstands; check the"
            " units (both in N)"
        )
    return found


def ice_against_curve(aerodynamics: Aerodynamics | None, ice: Ice) -> list[str]:
    """Warnings about round ice and a curve with lift, or eccentric ice and a curve without."""
    if aerodynamics is None:
        return []
    is_round = ice.first_moment_x2 == ice.first_moment_x3 == 0.0
    lift = _largest_lift(aerodynamics)
    if is_round == (lift < MAX_LIFT_OF_ROUND_SECTION):
        return []
    if not is_round:
        return [
            f"the first moments of the ice are {ice.first_moment_x2:g} and"
            f" {ice.first_moment_x3:g} kg, as for ice on one side, but the coefficient curve has no"
            " lift, as that of a round section; give the curve of the shape of the ice, or first"
            " moments of 0"
        ]
    return [
        "the first moments of the ice are 0, as for round or no ice, but the coefficient curve has"
        f" lift up to {lift:.3g}, which a round section does not have; give the ice the shape of"
        " the curve ([line] ice_shape and ice_thickness, or [ice] first moments), or the curve of a"
        " round section"
    ]


@lru_cache(maxsize=64)  # the runs of a sweep share few curves
def _largest_lift(aerodynamics: Aerodynamics) -> float:
    """Return the largest magnitude of the lift coefficient."""
    curve = aerodynamics.curve()
    angles = np.linspace(curve.breakpoint[0], curve.breakpoint[-1], LIFT_POINTS)
    return float(abs(curve.lift(angles)).max())


def _check_sag_against_tension(scene: Scene) -> None:
    span = scene.span
    if span.sag is None or span.horizontal_tension is None:
        return
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    slope = math.hypot(1.0, span.height_difference / span.length)
    parabola = mass * span.gravity * span.length**2 / (8.0 * span.horizontal_tension) * slope
    if abs(span.sag - parabola) > SAG_TENSION_AGREEMENT * parabola:
        raise SceneError(
            f"span.sag = {span.sag} m and span.horizontal_tension = {span.horizontal_tension} N"
            f" contradict each other: m g L^2/(8 H) gives a sag of {parabola:.4g} m, and at most"
            f" {SAG_TENSION_AGREEMENT:.0%} difference is accepted; correct one of them, or give"
            " only one"
        )


def check_mass_matrix(conductor: Conductor, ice: Ice, path: str) -> None:
    """Refuse ice with first moments that no body of its mass and inertia has.

    Parameters
    ----------
    path
        Dotted path of the ice, for the message.

    Raises
    ------
    SceneError
        The mass matrix would not be positive definite.
    """
    mass = conductor.mass_per_length + ice.mass_per_length
    inertia = conductor.torsional_inertia + ice.torsional_inertia
    moments = ice.first_moment_x2**2 + ice.first_moment_x3**2
    if not inertia * mass > moments:
        raise SceneError(
            f"{path}.first_moment_x2 = {ice.first_moment_x2} kg and {path}.first_moment_x3 ="
            f" {ice.first_moment_x3} kg are too large: the sum of their squares, {moments:.4g} kg2,"
            " must be less than torsional inertia times mass of conductor and ice,"
            f" {inertia * mass:.4g} kg2, for a positive definite mass matrix; check the units of"
            " these values"
        )


def _check_aerodynamics(scene: Scene) -> None:
    if not scene.wind.can_blow:
        return
    if scene.aerodynamics is None:
        raise SceneError(NO_CURVE)
    check_attack_angle(scene.aerodynamics, scene.ice, "ice", scene.wind.turn_deg)


def check_attack_angle(curve: Aerodynamics, ice: Ice, path: str, turn_deg: float) -> None:
    """Refuse ice with an attack angle outside its coefficient curve.

    Parameters
    ----------
    path
        Dotted path of the ice, for the message.
    turn_deg
        Rotation [deg] of the attack angle by wind from the other side, see `Wind.turn_deg`.

    Raises
    ------
    SceneError
        The angle is outside, and the curve refuses such angles.
    """
    angle, (first, last) = ice.attack_angle_deg + turn_deg, curve.range_deg
    reduced = angle - 360.0 * round((angle - 0.5 * (first + last)) / 360.0)
    if curve.beyond == "error" and not first <= reduced <= last:
        turned = (
            f", {turn_deg:g} deg more in wind from the other side (wind.speed or"
            " wind.direction_deg),"
            if turn_deg
            else ""
        )
        raise SceneError(
            f"{path}.attack_angle_deg = {ice.attack_angle_deg}{turned} is outside the coefficient"
            f" curve, which is valid from {first} to {last} deg; choose an angle inside, or set"
            ' aerodynamics.outside = "hold"'
        )
