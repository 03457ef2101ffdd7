"""Places on the conductors of a line: spacers, devices and the ends of intervals.

A *place* is a fraction of the conductor's length in a span. Spans, phases and subconductors count
from 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from gallop_fmu.scene.devices import Device, InterphaseSpacer, Interval

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene

SAME_PLACE = 1e-9
"""Difference of two fractions up to which they are one station."""


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
        Kind of the device, or ``"spacer"``.
    """

    station: float
    name: str
    kind: str


def conductors_of(scene: LineScene, device: Device) -> Iterator[Conductor]:
    """Yield the conductors that a device is on; of an interphase spacer both."""
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


def _ends(device: Interval) -> list[float]:
    """Ends of an interval that are not ends of the conductor."""
    return [end for end in (device.from_station, device.to_station) if 0.0 < end < 1.0]


def _one_or_all(number: int | None, count: int) -> range:
    return range(1, count + 1) if number is None else range(number, number + 1)
