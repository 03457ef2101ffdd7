"""Checks of ice that falls against the rest of a span or line."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import TYPE_CHECKING

from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.shedding import Shedding, SpanShedding
from gallop_fmu.scene.stations import (
    MIDDLE,
    MIN_PART,
    SAME_PLACE,
    conductors_of,
    icy_pieces,
    shed_stations,
)
from gallop_fmu.scene.wind import Wind

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene


def wrong_sheddings(scene: LineScene) -> Iterator[str]:
    """Problems of ice that falls twice from a line, and of parts without ice."""
    for number, own in enumerate(scene.shedding, start=1):
        on = list(conductors_of(scene, own))
        if not any(icy_pieces(scene, own, conductor) for conductor in on):
            yield (
                f"{_path(number)}: there is no ice on span {own.span} from {own.from_station:g} to"
                f" {own.to_station:g}; give ice there ([ice], section.spans.ice or the ice of an"
                " interval), or remove this shedding"
            )
        yield from _angle_outside(scene.wind, number, own)
    numbered = [
        (number, own, set(conductors_of(scene, own)))
        for number, own in enumerate(scene.shedding, start=1)
    ]
    for (a, first, on_first), (b, second, on_second) in combinations(numbered, 2):
        if on_first & on_second:
            yield from _falls_twice(a, first, b, second, f"span {second.span}")


def wrong_sheddings_of_span(scene: Scene) -> Iterator[str]:
    """Problems of ice that falls from one span: no ice, twice, parts without elements."""
    for number, own in enumerate(scene.shedding, start=1):
        if not scene.ice.mass_per_length > 0.0:
            yield (
                f"{_path(number)}: there is no ice on the span, as ice.mass_per_length ="
                f" {scene.ice.mass_per_length:g}; give ice, or remove this shedding"
            )
        yield from _angle_outside(scene.wind, number, own)
    for (a, first), (b, second) in combinations(enumerate(scene.shedding, start=1), 2):
        yield from _falls_twice(a, first, b, second, "the span")
    yield from _unfit_mesh(scene)


def _falls_twice(
    a: int, first: SpanShedding, b: int, second: SpanShedding, place: str
) -> Iterator[str]:
    """Problem of two parts of one conductor that overlap."""
    start = max(first.from_station, second.from_station)
    stop = min(first.to_station, second.to_station)
    if stop - start > SAME_PLACE:
        yield (
            f"{_path(b)}: the ice on {place} from {start:g} to {stop:g} falls already by shedding"
            f" {a}, and ice falls once; make the two adjoin, or remove one"
        )


def _unfit_mesh(scene: Scene) -> Iterator[str]:
    """Problems of the elements of a span, of which parts lose their ice."""
    elements, places = scene.elements, shed_stations(scene)
    if not places:
        return
    for left, right in pairwise([0.0, *places, 1.0]):
        if (right - left) * scene.span.length < MIN_PART:
            yield (
                f"shedding: {left:g} and {right:g} of the span are"
                f" {(right - left) * scene.span.length:.3g} m apart; give ends of parts that are"
                f" equal, or at least {MIN_PART:g} m from each other, from mid-span and from the"
                " ends of the span"
            )
    most = max(sum(p <= MIDDLE for p in places), sum(p >= MIDDLE for p in places))
    if elements // 2 < most:
        yield (
            f"numerics.elements = {scene.numerics.elements}: shedding divides half of the span into"
            f" {most} parts with at least one element each; give at least {2 * most}"
        )


def _angle_outside(wind: Wind, number: int, shedding: SpanShedding) -> Iterator[str]:
    """Problem of a curve that the attack angle of a bare conductor, 0, is not in."""
    curve = shedding.aerodynamics
    if curve is None or curve.beyond != "error" or not wind.can_blow:
        return
    angle, (first, last) = wind.turn_deg, curve.range_deg
    reduced = angle - 360.0 * round((angle - 0.5 * (first + last)) / 360.0)
    if not first <= reduced <= last:
        yield (
            f"{_path(number)}: the attack angle of the bare conductor, {angle:g} deg, is outside"
            f" its coefficient curve, which is valid from {first:g} to {last:g} deg; widen the"
            ' curve, or set outside = "hold"'
        )


def curves_of(sheddings: tuple[Shedding, ...] | tuple[SpanShedding, ...]) -> list[Aerodynamics]:
    """Coefficient curves that sheddings give for the bare conductor."""
    return [own.aerodynamics for own in sheddings if own.aerodynamics is not None]


def _path(number: int) -> str:
    return f"shedding.{number - 1} (shedding {number})"
