"""Places on the conductors of a line: spacers, devices, ends of intervals and of falling ice.

A *place* is a fraction of the conductor's length in a span. Spans, phases and subconductors count
from 1.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from gallop_fmu.scene.conductor import Ice
from gallop_fmu.scene.devices import Device, InterphaseSpacer, Interval
from gallop_fmu.scene.shedding import Shedding, SpanShedding

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene

SAME_PLACE = 1e-9
"""Difference of two fractions up to which they are one station."""

MIN_PART = 0.1
"""Minimum length [m] of conductor between two stations, or a station and an end of the span."""

MIDDLE = 0.5
"""Station at mid-span."""

BOUNDARIES = {"interval", "shedding"}
"""Kinds of places that are no devices."""


class Conductor(NamedTuple):
    """One subconductor of a phase in a span."""

    span: int
    phase: int
    subconductor: int


class Place(NamedTuple):
    """A station of a conductor, and what is there.

    Attributes
    ----------
    station : float
        Fraction of the conductor's length.
    name : str
        Name for messages, such as ``"spacer 2"`` or ``"device 3"``.
    kind : str
        Kind of the device, or ``"spacer"``, or ``"shedding"``.
    """

    station: float
    name: str
    kind: str


class IcyPiece(NamedTuple):
    """A stretch of a conductor with ice.

    Attributes
    ----------
    from_station, to_station : float
        Its ends as fractions of the conductor's length.
    ice : Ice
        Its ice.
    """

    from_station: float
    to_station: float
    ice: Ice


def icy_pieces(scene: LineScene, shedding: Shedding, conductor: Conductor) -> list[IcyPiece]:
    """Return the stretches of a conductor from which ice falls; none if there is no ice."""
    own = [
        device
        for device in scene.devices
        if isinstance(device, Interval) and conductor in conductors_of(scene, device)
    ]
    first, last = shedding.from_station, shedding.to_station
    inner = {
        end
        for device in own
        for end in (device.from_station, device.to_station)
        if first + SAME_PLACE < end < last - SAME_PLACE
    }
    found = []
    for left, right in pairwise(sorted({first, last, *inner})):
        ice, middle = scene.ice_of_span(conductor.span), 0.5 * (left + right)
        for device in own:
            if device.from_station < middle < device.to_station and device.ice is not None:
                ice = device.ice
        if right - left > SAME_PLACE and ice.mass_per_length > 0.0:
            found.append(IcyPiece(left, right, ice))
    return found


def conductors_of(scene: LineScene, device: Device | Shedding) -> Iterator[Conductor]:
    """Yield the conductors that a device or falling ice is on; of an interphase spacer both."""
    phases: Iterable[int] = _one_or_all(getattr(device, "phase", None), len(scene.phases))
    if isinstance(device, InterphaseSpacer):
        phases = device.phases
    subconductors = _one_or_all(device.subconductor, scene.bundle.subconductors)
    for phase in phases:
        for subconductor in subconductors:
            yield Conductor(device.span, phase, subconductor)


def places(scene: LineScene) -> dict[Conductor, list[Place]]:
    """Return the places on each conductor, sorted by station; empty if a conductor has none."""
    spacers = [
        Place(station, f"spacer {number}", "spacer")
        for number, station in enumerate(scene.bundle.spacer_stations, start=1)
    ]
    found = {
        Conductor(span, phase, subconductor): list(spacers)
        for span in range(1, len(scene.section.spans) + 1)
        for phase in range(1, len(scene.phases) + 1)
        for subconductor in range(1, scene.bundle.subconductors + 1)
    }
    for number, device in enumerate(scene.devices, start=1):
        stations = [device.station] if not isinstance(device, Interval) else _ends(device)
        kind: str = device.kind
        if isinstance(device, InterphaseSpacer):
            kind += " between phases {} and {}".format(*sorted(device.phases))
        for conductor in conductors_of(scene, device):
            found[conductor] += [Place(station, f"device {number}", kind) for station in stations]
    for number, shedding in enumerate(scene.shedding, start=1):
        for conductor in conductors_of(scene, shedding):
            found[conductor] += [
                Place(station, f"shedding {number}", "shedding") for station in _ends(shedding)
            ]
    for found_places in found.values():
        found_places.sort(key=lambda place: place.station)
    return found


def stations(found: list[Place]) -> list[float]:
    """Return the different stations of sorted places."""
    kept: list[float] = []
    for place in found:
        if not kept or place.station - kept[-1] > SAME_PLACE:
            kept.append(place.station)
    return kept


def shed_stations(scene: Scene) -> list[float]:
    """Return the stations of one span, of which parts lose their ice; mid-span is one of them.

    There is none if no part ends within the span.
    """
    inner = sorted(end for shedding in scene.shedding for end in _ends(shedding))
    kept: list[float] = []
    for end in sorted([*inner, MIDDLE]) if inner else []:
        if not kept or end - kept[-1] > SAME_PLACE:
            kept.append(end)
    return kept


def _ends(device: Interval | SpanShedding) -> list[float]:
    """Ends of a stretch that are not ends of the conductor."""
    return [end for end in (device.from_station, device.to_station) if 0.0 < end < 1.0]


def _one_or_all(number: int | None, count: int) -> range:
    return range(1, count + 1) if number is None else range(number, number + 1)


def elements_of_parts(fractions: tuple[float, ...], elements: int) -> tuple[int, ...]:
    """Share the elements of a conductor out to the parts between its stations, by length.

    Each part has at least one element. Numbers are rounded, so that equal parts have equal numbers;
    the total then differs from `elements` by at most half of the number of parts.

    Parameters
    ----------
    fractions
        Stations with both ends: from 0 to 1, increasing.
    elements
        Number of elements asked for.

    Returns
    -------
    tuple of int
        Number of elements before each station, from 0 to the total.
    """
    corners = [0]
    for left, right in pairwise(fractions):
        share = math.floor(elements * (right - left) + 0.5 + SAME_PLACE * elements)
        corners.append(corners[-1] + max(1, share))
    return tuple(corners)
