"""A scene packed into the kernel's tables, and a report unpacked from a C structure."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import CChain, CReport
from gallop_fmu.engine.line_map import LineMap, one_span_map
from gallop_fmu.engine.line_pack import pack_line
from gallop_fmu.engine.shedding_pack import corners_of, pack_span_sheddings
from gallop_fmu.engine.tables import NONE, Place, Tables, double_pointer
from gallop_fmu.engine.wind_pack import pack_wind
from gallop_fmu.foundation.outcome import Outcome, Report
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.supports import RigidSupport, Support

__all__ = ["NONE", "Packed", "Place", "double_pointer", "map_of", "unpacked"]


def unpacked(raw: CReport, parts: LineMap | None = None) -> Report:
    """The report of a call, as Python has it; `parts` name the place of a failure in a line."""
    element = None if raw.element < 0 else raw.element
    device = None if raw.device < 0 else raw.device
    return Report(
        outcome=Outcome.from_code(raw.outcome),
        time=raw.time,
        element=element,
        value=raw.value,
        limit=raw.limit,
        field=raw.field.decode() if raw.field else None,
        lowest_tension=raw.lowest_tension,
        largest_turn=raw.largest_turn,
        steps=raw.steps,
        substeps=raw.substeps,
        iterations=raw.iterations,
        refactorisations=raw.refactorisations,
        halvings=raw.halvings,
        rejections=raw.rejections,
        device=device,
        place=None if parts is None else parts.place_of(element, device),
    )


class Packed(Tables):
    """A scene as the kernel reads it.

    Attributes
    ----------
    map : LineMap
        Which chains, junctions and devices are which part of the scene.
    scene : CScene
        The structure with pointers to the tables, which this object keeps alive.
    """

    def __init__(self, scene: Scene | LineScene) -> None:
        super().__init__()
        if isinstance(scene, LineScene):
            self.map = pack_line(self, scene)
        else:
            self.map = self._pack_span(scene)
        self.scene = self.c_scene()

    @property
    def device_junctions(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the junctions of each device."""
        return tuple(tuple(d.junction[: d.junctions]) for d in self.tables["device"])

    def sections_of_elements(self) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Cross-section of each element, and its initial attack angle [rad]."""
        found: list[NDArray[np.intp]] = []
        for index, chain in enumerate(self.tables["chain"]):
            of_chain = np.full(chain.elements, chain.cross_section, dtype=np.intp)
            for station in self.tables["station"]:
                if station.chain == index and station.cross_section != NONE:
                    of_chain[station.corner :] = station.cross_section
            found.append(of_chain)
        section = np.concatenate(found)
        attack = np.array([row.attack_angle for row in self.tables["cross_section"]])
        return section, attack[section]

    def set_shedding_times(self, times: ArrayLike) -> None:
        """Let ice fall at given times [s] alone, one for each item of `map.sheddings`."""
        given = np.asarray(times, dtype=np.float64)
        if given.shape != (len(self.map.sheddings),) or np.isnan(given).any():
            raise ValueError(
                f"shedding_times must be {len(self.map.sheddings)} times in s, one for each part"
                " that loses its ice; give infinity where it does not"
            )
        for item, time in enumerate(given):
            self.scene.shedding[item].time = time
            self.scene.shedding[item].acceleration = math.inf

    def _pack_span(self, scene: Scene) -> LineMap:
        self.add_settings(scene, "span")
        self.add_cross_section(scene.conductor, scene.ice, "ice", scene.damping)
        pack_wind(self, scene, [self.add_law(scene.wind.speed_law, "wind.history")])
        if scene.aerodynamics is not None:
            curve = self.add_curve(scene.aerodynamics, "aerodynamics")
            self.set_curve(scene.aerodynamics, curve, "aerodynamics")
        supports = (scene.supports.left, scene.supports.right)
        for end, support in enumerate(supports):
            self._pack_support(end, support, scene)
        chain = CChain()
        chain.junction[:] = (0, 1)
        self.add("chain", chain)
        self.copy(scene.span, "chain", "span", dict.fromkeys(("sag", "horizontal_tension")))
        self.copy(scene.numerics, "chain", "numerics", {"elements": None})
        for number, load in enumerate(scene.loads):
            law = self.add_law(load.law, f"loads.{number}.law")
            self.add_load(load, f"loads.{number}", 0, law)
        ends = tuple(device.junction[0] for device in self.tables["device"])
        kinds = (supports[0].kind, supports[1].kind)
        mapped = one_span_map(*corners_of(scene), kinds, ends)
        self.tables["chain"][0].elements = scene.elements
        if not scene.shedding:
            return mapped
        return replace(mapped, sheddings=tuple(pack_span_sheddings(self, scene, mapped.chains[0])))

    def _pack_support(self, end: int, support: Support, scene: Scene) -> None:
        span, path = scene.span, f"supports.{'right' if end else 'left'}"
        rigid = isinstance(support, RigidSupport)
        place = (span.length, span.height_difference, 0.0) if end else (0.0, 0.0, 0.0)
        self.add_junction(place, (rigid, True, rigid, True), self.add_motion(support.motion, path))
        if end:
            for axis, name in enumerate(("length", "height_difference")):
                self.note(f"span.{name}", "junction", end, 8 * axis)
        if not isinstance(support, RigidSupport):
            device = self.add_device(support.DEVICE_KIND, (end,), {})
            self.set_parameters(device, support, path, support.DEVICE_PARAMETERS)


def map_of(scene: Scene | LineScene) -> LineMap:
    """The map of the model of a scene, without the model."""
    return Packed(scene).map
