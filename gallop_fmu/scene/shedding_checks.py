"""Checks of ice that falls against the rest of a line."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

from gallop_fmu.scene.shedding import Shedding
from gallop_fmu.scene.stations import SAME_PLACE, conductors_of, icy_pieces

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene


def wrong_sheddings(scene: LineScene) -> Iterator[str]:
    """Problems of ice that falls twice, and of parts without ice."""
    for number, own in enumerate(scene.shedding, start=1):
        on = list(conductors_of(scene, own))
        if not any(icy_pieces(scene, own, conductor) for conductor in on):
            yield (
                f"{_path(number)}: there is no ice on span {own.span} from {own.from_station:g} to"
                f" {own.to_station:g}; give ice there ([ice], section.spans.ice or the ice of an"
                " interval), or remove this shedding"
            )
        yield from _angle_outside(scene, number, own)
    numbered = [
        (number, own, set(conductors_of(scene, own)))
        for number, own in enumerate(scene.shedding, start=1)
    ]
    for (a, first, on_first), (b, second, on_second) in combinations(numbered, 2):
        start = max(first.from_station, second.from_station)
        stop = min(first.to_station, second.to_station)
        if stop - start > SAME_PLACE and on_first & on_second:
            yield (
                f"{_path(b)}: the ice on span {second.span} from {start:g} to {stop:g} falls"
                f" already by shedding {a}, and ice falls once; make the two adjoin, or remove one"
            )


def _angle_outside(scene: LineScene, number: int, shedding: Shedding) -> Iterator[str]:
    """Problem of a curve that the attack angle of a bare conductor, 0, is not in."""
    curve = shedding.aerodynamics
    if curve is None or curve.beyond != "error" or not scene.wind.can_blow:
        return
    angle, (first, last) = scene.wind.turn_deg, curve.range_deg
    reduced = angle - 360.0 * round((angle - 0.5 * (first + last)) / 360.0)
    if not first <= reduced <= last:
        yield (
            f"{_path(number)}: the attack angle of the bare conductor, {angle:g} deg, is outside"
            f" its coefficient curve, which is valid from {first:g} to {last:g} deg; widen the"
            ' curve, or set outside = "hold"'
        )


def _path(number: int) -> str:
    return f"shedding.{number - 1} (shedding {number})"
