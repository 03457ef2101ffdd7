"""A line packed into the kernel's tables.

Junctions are in line order, so that those which a conductor or a device joins are close in the
table: at each tower the clamps by phase and subconductor, then the stations of the next span from
left to right. Chains are ordered by span, phase, subconductor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from gallop_fmu.engine.ctypes_structs import CChain, CSettings, CStation
from gallop_fmu.engine.line_map import LineMap, MappedChain, MappedSpacer, MappedTower
from gallop_fmu.engine.shedding_pack import pack_sheddings
from gallop_fmu.engine.strung_state import clamp_of_end_string, point_at_fraction
from gallop_fmu.engine.tables import NONE, Tables
from gallop_fmu.engine.wind_pack import pack_wind
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.conductor import Ice
from gallop_fmu.scene.devices import Damper, Device, InterphaseSpacer, Interval, Pendulum, PointMass
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.stations import (
    BOUNDARIES,
    SAME_PLACE,
    Conductor,
    conductors_of,
    elements_of_parts,
    places,
    stations,
)
from gallop_fmu.scene.supports import SpringSupport
from gallop_fmu.scene.suspensions import EndString, SectionEnd, String, Suspension, VString

FREE, TWIST_FIXED = (False,) * 4, (False, False, False, True)
FIXED = (True,) * 4
FRAME, YOKE, POINT_MASS = 4, 5, 6
"""Kinds of devices that the scene does not have as devices: gallop_device_kind."""

FRAME_PARAMETERS = {
    "arm_stiffness": 1,
    "arm_damping": 2,
    "clamp_torsional_stiffness": 3,
    "clamp_damping": 4,
}
"""Fields of a bundle, and their index among the parameters of a frame or yoke."""

YOKE_STRING = {"length": 5, "weight": 6, "stiffness": 7, "damping": 8}
"""Fields of a string, and their index among the parameters of a yoke."""

PENDULUM_PARAMETERS = {"mass": 0, "arm": 1, "angle_deg": 2}
TOWER_POINT = 5
"""Parameter of a string: place of the tower's point from the clamp along x1, then x2."""

AXES = ("x1", "x2", "x3")


class _Part(NamedTuple):
    """What one stretch of conductor has: its ice and curve with their dotted paths."""

    ice: Ice
    ice_path: str
    curve: Aerodynamics | None
    curve_path: str


class _Station(NamedTuple):
    """A station of a conductor between its ends."""

    fraction: float
    junction: int


def pack_line(tables: Tables, scene: LineScene) -> LineMap:
    """Fill the tables from a line; return the map of its parts."""
    return _LinePacker(tables, scene).pack()


class _LinePacker:
    """Tables and what is known of them while they are filled."""

    def __init__(self, tables: Tables, scene: LineScene) -> None:
        self.tables = tables
        self.scene = scene
        self.places = places(scene)
        self.sections: dict[tuple[str, str], int] = {}
        self.curves: dict[str, int] = {}
        self.clamps: dict[tuple[int, int, int], int] = {}
        self.stations: dict[Conductor, list[_Station]] = {c: [] for c in self.places}
        self.hanging: dict[tuple[int, Conductor], int] = {}
        self.bodies: list[int] = []
        self.corners: dict[Conductor, tuple[int, ...]] = {}

    def pack(self) -> LineMap:
        """Fill the tables in the order in which they refer to each other."""
        scene = self.scene
        self._pack_settings()
        self._section_of(self._part_of_span(1))  # the first one: inputs give its attack angle
        law = self.tables.add_law(scene.wind.speed_law, "wind.history")
        speeds = [
            law
            if span.wind is None
            else self.tables.add_law(span.wind.speed_law, f"section.spans.{i}.wind.history")
            for i, span in enumerate(scene.section.spans)
        ]
        pack_wind(self.tables, scene, speeds)
        self._pack_junctions()
        chains = tuple(self._pack_chain(conductor) for conductor in self.places)
        self._pack_stations()
        towers = tuple(self._pack_towers())
        spacers = tuple(self._pack_spacers())
        devices = tuple(
            tuple(self._pack_device(number, device)) for number, device in enumerate(scene.devices)
        )
        self._pack_loads()
        sheddings = tuple(pack_sheddings(self.tables, scene, chains))
        return LineMap(
            spans=len(scene.section.spans),
            phases=len(scene.phases),
            subconductors=scene.bundle.subconductors,
            chains=self._with_numbers(chains),
            towers=towers,
            spacers=spacers,
            devices=devices,
            bodies=tuple(self.bodies),
            junctions=len(self.tables.tables["junction"]),
            sheddings=sheddings,
        )

    # ---- settings and conductors ----

    def _pack_settings(self) -> None:
        section = self.scene.section
        settings = self.tables.add_settings(self.scene, "section")
        settings.strung = True
        settings.strung_with_ice = section.strung_with_ice
        for name in ("strung_temperature", "temperature"):
            setattr(settings, name, getattr(section, f"{name}_deg_c"))
            if self.scene.conductor.thermal_expansion is not None:
                offset = getattr(CSettings, name).offset
                self.tables.note(f"section.{name}_deg_c", "settings", 0, offset)

    def _part_of_span(self, span: int) -> _Part:
        own = self.scene.section.spans[span - 1].ice
        path = "ice" if own is None else f"section.spans.{span - 1}.ice"
        return _Part(self.scene.ice_of_span(span), path, self.scene.aerodynamics, "aerodynamics")

    def _part_of_interval(self, number: int, interval: Interval) -> _Part:
        part, path = self._part_of_span(interval.span), f"devices.{number}"
        if interval.ice is not None:
            part = part._replace(ice=interval.ice, ice_path=f"{path}.ice")
        if interval.aerodynamics is not None:
            part = part._replace(curve=interval.aerodynamics, curve_path=f"{path}.aerodynamics")
        return part

    def _section_of(self, part: _Part) -> int:
        """Index of the cross-section of a part; equal parts share it."""
        key = (part.ice_path, part.curve_path)
        if key not in self.sections:
            scene = self.scene
            index = len(self.tables.tables["cross_section"])
            self.tables.add_cross_section(scene.conductor, part.ice, part.ice_path, scene.damping)
            if part.curve is not None:
                if part.curve_path not in self.curves:
                    self.curves[part.curve_path] = self.tables.add_curve(
                        part.curve, part.curve_path
                    )
                self.tables.set_curve(part.curve, self.curves[part.curve_path], part.curve_path)
            self.sections[key] = index
        return self.sections[key]

    # ---- junctions ----

    def _pack_junctions(self) -> None:
        spans = len(self.scene.section.spans)
        for tower in range(spans + 1):
            held = self._held(tower)
            motion = self.tables.add_motion(held.motion, self._path(tower))
            for phase in range(1, len(self.scene.phases) + 1):
                for subconductor in range(1, self.scene.bundle.subconductors + 1):
                    place = self._clamp(tower, phase, subconductor)
                    self.clamps[tower, phase, subconductor] = self.tables.add_junction(
                        place, self._fixed(held), motion
                    )
            if tower < spans:
                self._pack_station_junctions(tower + 1)

    def _path(self, tower: int) -> str:
        """Dotted path of what holds the conductors at a tower."""
        if tower == 0:
            return "section.left_end"
        if tower == len(self.scene.section.spans):
            return "section.right_end"
        return f"section.suspensions.{tower - 1}"

    def _held(self, tower: int) -> Suspension | SectionEnd:
        """What holds the conductors at a tower."""
        section = self.scene.section
        if tower == 0:
            return section.left_end
        return section.right_end if tower == len(section.spans) else section.suspensions[tower - 1]

    def _fixed(self, held: Suspension | SectionEnd) -> tuple[bool, ...]:
        """Unknowns of a clamp that follow the tower's point; the twist is then 0."""
        if isinstance(held, SpringSupport):
            return (False, True, False, True)
        if isinstance(held, EndString | VString):
            return TWIST_FIXED
        if isinstance(held, String):
            turns = self.scene.bundle.subconductors > 1 or held.clamp_torsional_stiffness
            return FREE if turns else TWIST_FIXED
        return FIXED

    def _attachment(self, tower: int, phase: int, subconductor: int) -> tuple[float, float, float]:
        """Attachment point of a conductor in the strung state."""
        before = self.scene.section.spans[:tower]
        phase_x2, phase_x3 = self.scene.phases[phase - 1].offset
        own_x2, own_x3 = self.scene.bundle.positions[subconductor - 1]
        height = math.fsum(span.height_difference for span in before)
        length = math.fsum(span.length for span in before)
        return length, height + phase_x2 + own_x2, phase_x3 + own_x3

    def _clamp(self, tower: int, phase: int, subconductor: int) -> tuple[float, float, float]:
        """Clamp of a conductor in the strung state; an end string is between it and the tower."""
        held, place = self._held(tower), self._attachment(tower, phase, subconductor)
        if not isinstance(held, EndString):
            return place
        x, y = self._end_string(tower, held)
        return place[0] + x, place[1] + y, place[2]

    def _end_string(self, tower: int, held: EndString) -> tuple[float, float]:
        """From the tower's point to the clamp in the strung state, along x1 and x2."""
        number = 1 if tower == 0 else tower
        span, side = self.scene.section.spans[number - 1], 1.0 if tower == 0 else -1.0
        rise = side * span.height_difference
        x, y = clamp_of_end_string(
            span.length,
            rise,
            self._parameter(number),
            held.length,
            held.weight / self.scene.strung_weight(number),
        )
        return side * x, y

    def _parameter(self, span: int) -> float:
        """Parameter H/w of the catenary of a span in the strung state [m]."""
        return self.scene.strung_tension / self.scene.strung_weight(span)

    def _pack_station_junctions(self, span: int) -> None:
        """Add the junctions of a span's stations from left to right, each with its bodies."""
        found = [
            (fraction, conductor)
            for conductor, at in self.places.items()
            if conductor.span == span
            for fraction in stations(at)
        ]
        found.sort(key=lambda item: (round(item[0] / SAME_PLACE), item[1]))
        for fraction, conductor in found:
            junction = NONE
            if not self._kinds_at(conductor, fraction) <= BOUNDARIES:
                place = self._strung_point(conductor, fraction)
                junction = self.tables.add_junction(place, FREE)
                self._pack_bodies(conductor, fraction, place)
            self.stations[conductor].append(_Station(fraction, junction))

    def _kinds_at(self, conductor: Conductor, fraction: float) -> set[str]:
        """Kinds of what is at a station."""
        return {p.kind for p in self.places[conductor] if _same(p.station, fraction)}

    def _strung_point(self, conductor: Conductor, fraction: float) -> tuple[float, float, float]:
        """Point of a conductor in the strung state."""
        span, *own = conductor
        left, right = self._clamp(span - 1, *own), self._clamp(span, *own)
        x, y = point_at_fraction(
            right[0] - left[0], right[1] - left[1], self._parameter(span), fraction
        )
        return left[0] + x, left[1] + y, left[2]

    def _pack_bodies(
        self, conductor: Conductor, fraction: float, place: tuple[float, float, float]
    ) -> None:
        """Add a junction for each mass that hangs on a damper at a station."""
        for number, device in enumerate(self.scene.devices):
            if not isinstance(device, Damper) or device.hanging_mass is None:
                continue
            if _same(device.station, fraction) and conductor in conductors_of(self.scene, device):
                body = self.tables.add_junction(place, TWIST_FIXED)
                self.hanging[number, conductor] = body
                self.bodies.append(body)

    # ---- chains and stations ----

    def _pack_chain(self, conductor: Conductor) -> MappedChain:
        span, *own = conductor
        found = self.stations[conductor]
        fractions = (0.0, *(station.fraction for station in found), 1.0)
        corners = elements_of_parts(fractions, self.scene.elements_of_span(span))
        self.corners[conductor] = corners
        phase, subconductor = own
        ends = [self.clamps[tower, phase, subconductor] for tower in (span - 1, span)]
        chain = CChain(
            cross_section=self._section_at(conductor, 0.0),
            field=span - 1,
            elements=corners[-1],
            horizontal_tension=self.scene.strung_tension,
        )
        chain.junction[:] = ends
        index = self.tables.add("chain", chain)
        if self._tension_is_a_place():
            offset = CChain.horizontal_tension.offset
            self.tables.note("section.horizontal_tension", "chain", index, offset)
        junctions = (ends[0], *(station.junction for station in found), ends[1])
        return MappedChain(
            span, phase, subconductor, 0, 0, corners[-1], corners, fractions, junctions
        )

    def _tension_is_a_place(self) -> bool:
        """True if the strung tension is given, and no clamp's place follows from it."""
        section = self.scene.section
        ends = (section.left_end, section.right_end)
        given = section.horizontal_tension is not None
        return given and not any(isinstance(end, EndString) for end in ends)

    def _section_at(self, conductor: Conductor, fraction: float) -> int:
        """Index of the cross-section to the right of a station; intervals have their own."""
        for number, device in enumerate(self.scene.devices):
            if (
                isinstance(device, Interval)
                and conductor in conductors_of(self.scene, device)
                and device.from_station - SAME_PLACE <= fraction < device.to_station - SAME_PLACE
            ):
                return self._section_of(self._part_of_interval(number, device))
        return self._section_of(self._part_of_span(conductor.span))

    def _pack_stations(self) -> None:
        for index, conductor in enumerate(self.places):
            before = self.tables.tables["chain"][index].cross_section
            inner = self.corners[conductor][1:-1]
            for corner, station in zip(inner, self.stations[conductor], strict=True):
                section = self._section_at(conductor, station.fraction)
                falls = "shedding" in self._kinds_at(conductor, station.fraction)
                changed = section if falls or section != before else NONE
                item = CStation(index, corner, station.junction, changed, station.fraction)
                self.tables.add("station", item)
                before = section

    @staticmethod
    def _with_numbers(chains: tuple[MappedChain, ...]) -> tuple[MappedChain, ...]:
        """The chains with the numbers of their first node and element."""
        node = element = 0
        numbered = []
        for chain in chains:
            values = {**chain.__dict__, "first_node": node, "first_element": element}
            numbered.append(MappedChain(**values))
            node, element = node + 2 * chain.elements + 1, element + chain.elements
        return tuple(numbered)

    # ---- towers ----

    def _pack_towers(self) -> Iterator[MappedTower]:
        count = self.scene.bundle.subconductors
        for tower in range(len(self.scene.section.spans) + 1):
            held = self._held(tower)
            for phase in range(1, len(self.scene.phases) + 1):
                clamps = tuple(self.clamps[tower, phase, k] for k in range(1, count + 1))
                devices = tuple(self._pack_held(tower, held, clamps))
                yield MappedTower(tower, phase, held.kind, clamps, devices)

    def _pack_held(
        self, tower: int, held: Suspension | SectionEnd, clamps: tuple[int, ...]
    ) -> Iterator[int]:
        """Add the devices at a tower: a yoke, or one device for each clamp."""
        path = self._path(tower)
        if isinstance(held, String) and len(clamps) > 1:
            yoke = self._pack_frame(YOKE, clamps, "yoke_mass")
            self.tables.set_parameters(yoke, held, path, YOKE_STRING)
            self.tables.set_parameters(yoke, self.scene.bundle, "bundle", {"yoke_height": 9})
            yield yoke
        elif isinstance(held, String | VString | EndString | SpringSupport):
            for clamp in clamps:
                device = self.tables.add_device(held.DEVICE_KIND, (clamp,), {})
                self.tables.set_parameters(device, held, path, held.DEVICE_PARAMETERS)
                if isinstance(held, EndString):
                    from_tower = self._end_string(tower, held)
                    for axis, distance in enumerate(from_tower):
                        item = self.tables.tables["device"][device]
                        item.parameter[TOWER_POINT + axis] = -distance
                yield device

    def _pack_frame(self, kind: int, clamps: tuple[int, ...], mass: str) -> int:
        """Add a spacer or yoke with the values of the bundle."""
        device = self.tables.add_device(kind, clamps, {})
        self.tables.set_parameters(
            device, self.scene.bundle, "bundle", {mass: 0, **FRAME_PARAMETERS}
        )
        return device

    # ---- spacers, devices and loads ----

    def _pack_spacers(self) -> Iterator[MappedSpacer]:
        bundle = self.scene.bundle
        for span in range(1, len(self.scene.section.spans) + 1):
            for number, station in enumerate(bundle.spacer_stations, start=1):
                for phase in range(1, len(self.scene.phases) + 1):
                    clamps = tuple(
                        self._junction(Conductor(span, phase, k), station)
                        for k in range(1, bundle.subconductors + 1)
                    )
                    device = self._pack_frame(FRAME, clamps, "spacer_mass")
                    yield MappedSpacer(span, phase, number, station, device, clamps)

    def _junction(self, conductor: Conductor, fraction: float) -> int:
        """Junction of a station."""
        return next(
            station.junction
            for station in self.stations[conductor]
            if _same(station.fraction, fraction)
        )

    def _pack_device(self, number: int, device: Device) -> Iterator[int]:
        """Add a device of the scene on each of its conductors."""
        path, on = f"devices.{number}", conductors_of(self.scene, device)
        if isinstance(device, InterphaseSpacer):
            ends = [self._junction(conductor, device.station) for conductor in on]
            item = self.tables.add_device(device.DEVICE_KIND, ends, {})
            self.tables.set_parameters(item, device, path, device.DEVICE_PARAMETERS)
            yield item
        elif not isinstance(device, Interval):
            for conductor in on:
                yield from self._pack_at(number, device, conductor)

    def _pack_at(
        self, number: int, device: Pendulum | PointMass | Damper, conductor: Conductor
    ) -> Iterator[int]:
        """Add a device at its station of one conductor."""
        path, junction = f"devices.{number}", self._junction(conductor, device.station)
        tables = self.tables
        if isinstance(device, Damper):
            yield self._pack_damper(number, device, conductor, junction)
            if device.hanging_mass is not None:
                mass = tables.add_device(POINT_MASS, (self.hanging[number, conductor],), {})
                tables.set_parameters(mass, device, path, {"hanging_mass": 0})
                yield mass
            return
        item = tables.add_device(device.DEVICE_KIND, (junction,), {})
        fields = PENDULUM_PARAMETERS if isinstance(device, Pendulum) else device.DEVICE_PARAMETERS
        tables.set_parameters(item, device, path, fields)
        yield item

    def _pack_damper(self, number: int, device: Damper, conductor: Conductor, junction: int) -> int:
        """Add a damper; the spring of a hanging mass is as stiff along each axis."""
        path, axis = f"devices.{number}", AXES.index(device.axis)
        hanging = self.hanging.get((number, conductor))
        ends = (junction,) if hanging is None else (junction, hanging)
        item = self.tables.add_device(device.DEVICE_KIND, ends, {})
        self.tables.set_parameters(item, device, path, {"damping": axis})
        for k in range(3 if hanging is not None else 0):
            self.tables.set_parameters(item, device, path, {"hanging_stiffness": 3 + k})
        return item

    def _pack_loads(self) -> None:
        for number, load in enumerate(self.scene.loads):
            path = f"loads.{number}"
            law = self.tables.add_law(load.law, f"{path}.law")
            for chain, conductor in enumerate(self.places):
                if (
                    load.span == conductor.span
                    and load.phase in (None, conductor.phase)
                    and load.subconductor in (None, conductor.subconductor)
                ):
                    self.tables.add_load(load, path, chain, law)


def _same(first: float, second: float) -> bool:
    return abs(first - second) <= SAME_PLACE
