"""Ice that falls from a span or line, packed into the kernel's table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from gallop_fmu.engine.ctypes_structs import CShedding, CStation
from gallop_fmu.engine.line_map import MappedChain, MappedShedding
from gallop_fmu.engine.tables import NONE, Tables
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.shedding import SpanShedding
from gallop_fmu.scene.stations import (
    MIDDLE,
    SAME_PLACE,
    Conductor,
    conductors_of,
    icy_pieces,
    shed_stations,
)

ASSUMED_CURVE = "bare conductor"
"""In place of the dotted path of a curve that the scene does not give."""


def pack_sheddings(
    tables: Tables, scene: LineScene, chains: Sequence[MappedChain]
) -> Iterator[MappedShedding]:
    """Add the table of falling ice; yield its items.

    Parameters
    ----------
    tables
        Tables, of which only this one is missing.
    scene
        The line.
    chains
        Its chains with their stations.
    """
    places = [Conductor(chain.span, chain.phase, chain.subconductor) for chain in chains]
    sections: dict[str, int] = {}
    for number, shedding in enumerate(scene.shedding, start=1):
        path = f"shedding.{number - 1}"
        for conductor in conductors_of(scene, shedding):
            index = places.index(conductor)
            for piece in icy_pieces(scene, shedding, conductor):
                bare = _bare_section(tables, scene, shedding, path, sections)
                corner = _corner_at(chains[index], piece.from_station)
                _add_item(tables, shedding, path, (index, corner, bare))
                yield MappedShedding(
                    number,
                    *conductor,
                    piece.from_station,
                    piece.to_station,
                    piece.ice.mass_per_length,
                )


def corners_of(scene: Scene) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Return corners and stations of the elements of one span, as of `MappedChain`.

    Without stations within the span there are only its ends. Otherwise mid-span is one, with half
    of the elements on either side, and the other stations are at the nearest corner that leaves
    each part an element.
    """
    places, half = shed_stations(scene), scene.elements // 2
    if not places:
        return (0, scene.elements), (0.0, 1.0)
    left = [0.0, *(place for place in places if place < MIDDLE - SAME_PLACE), MIDDLE]
    right = [MIDDLE, *(place for place in places if place > MIDDLE + SAME_PLACE), 1.0]
    corners = [*_shared_out(left, half), *(half + k for k in _shared_out(right, half)[1:])]
    return tuple(corners), tuple([*left, *right[1:]])


def _shared_out(fractions: Sequence[float], elements: int) -> list[int]:
    """Number of elements before each station of a stretch, at least one between two of them."""
    first, last = fractions[0], fractions[-1]
    corners = [round(elements * (place - first) / (last - first)) for place in fractions]
    for k in range(1, len(corners)):
        corners[k] = max(corners[k], corners[k - 1] + 1)
    corners[-1] = elements
    for k in range(len(corners) - 2, 0, -1):
        corners[k] = min(corners[k], corners[k + 1] - 1)
    return corners


def pack_span_sheddings(
    tables: Tables, scene: Scene, chain: MappedChain
) -> Iterator[MappedShedding]:
    """Add the stations of one span, and its table of falling ice; yield the items of the latter."""
    ends = {end for own in scene.shedding for end in (own.from_station, own.to_station)}
    for corner, place in zip(chain.corners[1:-1], chain.fractions[1:-1], strict=True):
        begins = any(abs(place - end) <= SAME_PLACE for end in ends)  # an interval, or mid-span
        section = 0 if begins else NONE
        station = CStation(chain=0, corner=corner, junction=NONE, cross_section=section)
        station.position = place
        tables.add("station", station)
    sections: dict[str, int] = {}
    for number, shedding in enumerate(scene.shedding, start=1):
        path = f"shedding.{number - 1}"
        bare = _bare_section(tables, scene, shedding, path, sections)
        _add_item(tables, shedding, path, (0, _corner_at(chain, shedding.from_station), bare))
        part = (shedding.from_station, shedding.to_station)
        yield MappedShedding(number, 1, 1, 1, *part, scene.ice.mass_per_length)


def _corner_at(chain: MappedChain, station: float) -> int:
    return chain.corners[int(np.argmin(np.abs(np.array(chain.fractions) - station)))]


def _add_item(
    tables: Tables, shedding: SpanShedding, path: str, place: tuple[int, int, int]
) -> None:
    """Add an item; its place is chain, corner and the cross-section without ice."""
    chain, corner, bare = place
    item = CShedding(
        chain=chain, corner=corner, cross_section=bare, time=math.inf, acceleration=math.inf
    )
    tables.add("shedding", item)
    tables.copy(shedding, "shedding", path, {"time": None, "acceleration": None})


def _bare_section(
    tables: Tables,
    scene: Scene | LineScene,
    shedding: SpanShedding,
    path: str,
    sections: dict[str, int],
) -> int:
    """Index of the cross-section without ice; parts with the same curve share it."""
    own = shedding.aerodynamics is not None
    curve_path = f"{path}.aerodynamics" if own else ASSUMED_CURVE
    if curve_path not in sections:
        sections[curve_path] = len(tables.tables["cross_section"])
        tables.add_cross_section(scene.conductor, None, "", scene.damping)
        if own or scene.aerodynamics is not None:
            curve = shedding.bare_curve
            tables.set_curve(curve, tables.add_curve(curve, curve_path), curve_path)
    return sections[curve_path]
