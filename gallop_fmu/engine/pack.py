"""A scene packed into the kernel's tables, and a report unpacked from a C structure."""

from __future__ import annotations

import ctypes as c
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import (
    DEVICE_JUNCTIONS,
    FREQUENCY_PAIR,
    CChain,
    CCrossSection,
    CCurve,
    CDevice,
    CField,
    CJunction,
    CLaw,
    CLoad,
    CReport,
    CScene,
    CSettings,
    Pointer,
    Three,
)
from gallop_fmu.foundation.integrators import INTEGRATORS, SPECTRAL_RADIUS
from gallop_fmu.foundation.outcome import Outcome, Report
from gallop_fmu.scene.loads import Load
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.supports import RigidSupport, Support
from gallop_fmu.scene.time_functions import Constant, Law, TimeTable

CONDUCTOR_FIELDS: dict[str, str | None] = {
    "mass_per_length": "mass",
    **dict.fromkeys(("diameter", "axial_stiffness", "torsional_stiffness", "torsional_inertia")),
}
ICE_FIELDS: dict[str, str | None] = {
    "mass_per_length": "ice_mass",
    "torsional_inertia": "ice_torsional_inertia",
    "first_moment_x2": None,
    "first_moment_x3": None,
    "first_moment_angle_deg": "first_moment_angle",
    "attack_angle_deg": "attack_angle",
}
NUMERICS = (
    "time_step",
    "tolerance",
    "spectral_radius",
    "newton_tolerance",
    "max_newton_iterations",
    "max_halvings",
)
SEEDS = ("seed_vertical", "seed_horizontal", "seed_twist")
LAW_FIELDS: dict[str, dict[str, str | None]] = {
    "constant": {"value": "initial"},
    "ramp": {"initial": None, "final": "peak", "start": None, "duration": "rise"},
    "pulse": dict.fromkeys(("initial", "peak", "start", "rise", "fall_start", "fall")),
    "harmonic": {
        "mean": "initial",
        "amplitude": None,
        "frequency_hz": "frequency",
        "phase_deg": "phase",
        "start": None,
    },
    "table": {},
}
LAW_KINDS = {"constant": 0, "ramp": 1, "pulse": 1, "harmonic": 2, "table": 3}
OUTSIDE_KINDS = {"error": 0, "hold": 1, "periodic": 2}
SLACK_KINDS = {"error": 0, "tension_only": 1}
NONE = -1
"""Index where there is no item."""


class Place(NamedTuple):
    """Where a value of the scene is stored.

    Attributes
    ----------
    table : str
        Name of the table in `Packed.tables`.
    item : int
        Index of the item.
    offset : int
        Place in the item [bytes].
    factor : float
        Stored = factor * value.
    """

    table: str
    item: int
    offset: int
    factor: float


def double_pointer(values: NDArray[np.float64]) -> Any:
    """Pointer to the first value of a contiguous array."""
    return values.ctypes.data_as(Pointer)


def unpacked(raw: CReport) -> Report:
    """The report of a call, as Python has it."""
    return Report(
        outcome=Outcome.from_code(raw.outcome),
        time=raw.time,
        element=None if raw.element < 0 else raw.element,
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
    )


class Packed:
    """A scene as the kernel reads it: tables of structures that refer to one another by index.

    Attributes
    ----------
    tables : dict
        Name of each table of `CScene` and "settings": its items.
    numbers : list of float
        The table "number": points of time tables, and coefficient curves.
    places : dict
        Dotted path of a scene value: its `Place`.
    """

    def __init__(self, scene: Scene) -> None:
        self.tables: dict[str, list[Any]] = {
            name: []
            for name in (
                *("settings", "cross_section", "curve", "field", "junction", "chain"),
                *("station", "device", "load", "law"),
            )
        }
        self.numbers: list[float] = []
        self.places: dict[str, Place] = {}
        self._pack_settings(scene)
        self._pack_cross_section(scene)
        self._pack_air(scene)
        for index, (name, support) in enumerate(
            (("left", scene.supports.left), ("right", scene.supports.right))
        ):
            self._pack_support(index, support, f"supports.{name}", scene)
        self._pack_chain(scene)
        for index, load in enumerate(scene.loads):
            self._pack_load(load, f"loads.{index}")
        self._arrays: list[Any] = []
        self.scene = self._scene()

    def _scene(self) -> CScene:
        """The structure with pointers to the tables, which this object keeps alive."""
        scene = CScene(settings=self.tables["settings"][0])
        for name, items in self.tables.items():
            if name == "settings" or not items:
                continue
            array = (type(items[0]) * len(items))(*items)
            self._arrays.append(array)
            setattr(scene, f"{name}_count", len(items))
            setattr(scene, name, array)
        numbers = np.array(self.numbers)
        self._arrays.append(numbers)
        scene.number_count, scene.number = len(numbers), double_pointer(numbers)
        return scene

    @property
    def device_junctions(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the junctions of each device."""
        return tuple(tuple(d.junction[: d.junctions]) for d in self.tables["device"])

    def _add(self, table: str, item: c.Structure) -> int:
        self.tables[table].append(item)
        return len(self.tables[table]) - 1

    def _add_numbers(self, values: ArrayLike) -> int:
        first = len(self.numbers)
        self.numbers += np.ravel(values).tolist()
        return first

    def _copy(self, section: Any, table: str, path: str, fields: Mapping[str, str | None]) -> None:
        """Copy the named values of a section to the last item of a table.

        A field maps to its name in the structure where that differs.
        """
        item = len(self.tables[table]) - 1
        target = self.tables[table][item]
        for name, other in fields.items():
            value = getattr(section, name)
            if value is None:
                continue
            factor = math.pi / 180.0 if name.endswith("_deg") else 1.0
            field = other or name
            setattr(target, field, value if factor == 1.0 else value * factor)
            offset = getattr(type(target), field).offset
            self.places[f"{path}.{name}"] = Place(table, item, offset, factor)

    def _pack_settings(self, scene: Scene) -> None:
        numerics = scene.numerics
        self._add("settings", CSettings(spectral_radius=SPECTRAL_RADIUS))
        settings = self.tables["settings"][0]
        self._copy(scene.span, "settings", "span", {"gravity": None})
        self._copy(scene.wind, "settings", "wind", {"air_density": None})
        self._copy(scene.initial, "settings", "initial", dict.fromkeys(SEEDS))
        self._copy(numerics, "settings", "numerics", dict.fromkeys(NUMERICS))
        settings.integrator = INTEGRATORS[numerics.method].code
        settings.start_in_mean_wind = scene.initial.wind == "mean_wind_equilibrium"

    def _pack_cross_section(self, scene: Scene) -> None:
        self._add("cross_section", CCrossSection(curve=NONE))
        section = self.tables["cross_section"][0]
        section.slack = SLACK_KINDS[scene.conductor.slack]
        self._copy(scene.conductor, "cross_section", "conductor", CONDUCTOR_FIELDS)
        self._copy(scene.ice, "cross_section", "ice", ICE_FIELDS)
        for name in ("translation", "twist"):
            pair = getattr(scene.damping, name)
            if pair is None:
                continue
            start = getattr(CCrossSection, f"{name}_damping").offset
            target = getattr(section, f"{name}_damping")
            for field in FREQUENCY_PAIR:
                setattr(target, field, getattr(pair, field))
                offset = start + getattr(type(target), field).offset
                self.places[f"damping.{name}.{field}"] = Place("cross_section", 0, offset, 1.0)

    def _pack_air(self, scene: Scene) -> None:
        wind, coefficients = scene.wind, scene.aerodynamics
        law = self._pack_law(wind.history or Constant(value=wind.speed or 0.0), "wind.history")
        self._add("field", CField(law=law))
        if coefficients is None:
            return
        curve = coefficients.curve()
        parts = (curve.breakpoint, curve.origin, curve.coefficient)
        first = [self._add_numbers(part) for part in parts]
        item = CCurve(len(curve.origin), OUTSIDE_KINDS[curve.outside], first[0])
        self.tables["cross_section"][0].curve = self._add("curve", item)
        if coefficients.kind == "polynomial":
            places = {"centre_deg": first[1], "valid_from_deg": first[0]}
            places["valid_to_deg"] = first[0] + 1
            for name, index in places.items():
                self.places[f"aerodynamics.{name}"] = Place("number", index, 0, math.pi / 180.0)
        self._copy(coefficients, "cross_section", "aerodynamics", {"reference_radius": None})

    def _pack_law(self, law: Law, path: str) -> int:
        """Add a law; return its index."""
        item = CLaw(kind=LAW_KINDS[law.kind], fall_start=math.inf)
        index = self._add("law", item)
        self._copy(law, "law", path, LAW_FIELDS[law.kind])
        if isinstance(law, TimeTable):
            item.count, item.first = len(law.time), self._add_numbers(law.time)
            self._add_numbers(law.value)
        return index

    def _pack_support(self, index: int, support: Support, path: str, scene: Scene) -> None:
        span, rigid = scene.span, isinstance(support, RigidSupport)
        far = (span.length, span.height_difference, 0.0) if index else (0.0, 0.0, 0.0)
        junction = CJunction(position=Three(*far))
        junction.fixed[:] = (rigid, True, rigid, True)
        self._add("junction", junction)
        if index:
            for axis, name in enumerate(("length", "height_difference")):
                self.places[f"span.{name}"] = Place("junction", index, 8 * axis, 1.0)
        for axis, name in enumerate(("x1", "x2", "x3")):
            motion = getattr(support.motion, name) if support.motion is not None else None
            junction.motion[axis] = (
                NONE if motion is None else self._pack_law(motion, f"{path}.motion.{name}")
            )
        if isinstance(support, RigidSupport):
            return
        device = CDevice(kind=support.DEVICE_KIND, junctions=1)
        device.junction[:] = (index, *(NONE,) * (DEVICE_JUNCTIONS - 1))
        item = self._add("device", device)
        for name, place in support.DEVICE_PARAMETERS.items():
            device.parameter[place] = getattr(support, name)
            offset = CDevice.parameter.offset + 8 * place
            self.places[f"{path}.{name}"] = Place("device", item, offset, 1.0)

    def _pack_chain(self, scene: Scene) -> None:
        chain = CChain()
        chain.junction[:] = (0, 1)
        self._add("chain", chain)
        self._copy(scene.span, "chain", "span", dict.fromkeys(("sag", "horizontal_tension")))
        self._copy(scene.numerics, "chain", "numerics", {"elements": None})

    def _pack_load(self, load: Load, path: str) -> None:
        self._add("load", CLoad(force=Three(*load.force)))
        self._copy(load, "load", path, dict.fromkeys(("torque", "position", "evenly_spaced")))
        self.tables["load"][-1].law = self._pack_law(load.law, f"{path}.law")
