"""Tables of the kernel's structures, filled item by item, and the places of a scene's values.

One method for each kind of item writes everything that a scene of one span and a line share.
"""

from __future__ import annotations

import ctypes as c
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import (
    DEVICE_JUNCTIONS,
    FREQUENCY_PAIR,
    CCrossSection,
    CCurve,
    CDevice,
    CJunction,
    CLaw,
    CLoad,
    CScene,
    CSettings,
    Pointer,
    Three,
)
from gallop_fmu.foundation.integrators import INTEGRATORS, SPECTRAL_RADIUS
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.damping import Damping
from gallop_fmu.scene.loads import Load
from gallop_fmu.scene.time_functions import Law, TimeTable

NUMERICS = (
    "time_step",
    "tolerance",
    "spectral_radius",
    "newton_tolerance",
    "max_newton_iterations",
    "max_halvings",
)
SEEDS = ("seed_vertical", "seed_horizontal", "seed_twist")
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


Array = NDArray[np.float64]


class Place(NamedTuple):
    """Where a value of the scene is stored.

    Attributes
    ----------
    table : str
        Name of the table in `Tables.tables`.
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


class Tables:
    """Tables of structures that refer to one another by index.

    Attributes
    ----------
    tables : dict
        Name of each table of `CScene` and "settings": its items.
    places : dict
        Dotted path of a scene value: the places where it is stored, one or more.
    """

    def __init__(self) -> None:
        self.tables: dict[str, list[Any]] = {
            name: []
            for name in (
                *("settings", "cross_section", "curve", "field", "junction", "chain"),
                *("station", "device", "load", "law", "shedding"),
            )
        }
        self._numbers: list[Array] = []
        self._number_count = 0
        self._notes: list[tuple[str, str, Place]] = []
        self._arrays: list[Any] = []

    def c_scene(self) -> CScene:
        """The structure with pointers to the tables, which this object keeps alive."""
        scene = CScene(settings=self.tables["settings"][0])
        for name, items in self.tables.items():
            if name == "settings" or not items:
                continue
            array = (type(items[0]) * len(items))(*items)
            self._arrays.append(array)
            setattr(scene, f"{name}_count", len(items))
            setattr(scene, name, array)
        numbers = self.numbers
        self._arrays.append(numbers)
        scene.number_count, scene.number = len(numbers), double_pointer(numbers)
        return scene

    def add(self, table: str, item: c.Structure) -> int:
        """Add an item to a table; return its index."""
        self.tables[table].append(item)
        return len(self.tables[table]) - 1

    def add_numbers(self, values: ArrayLike) -> int:
        """Add numbers; return the index of the first one."""
        first, added = self._number_count, np.ravel(np.asarray(values, dtype=np.float64))
        self._numbers.append(added)
        self._number_count += len(added)
        return first

    @property
    def numbers(self) -> Array:
        """The table "number": points of time tables, coefficient curves, ground and gusts."""
        return np.concatenate([np.empty(0), *self._numbers])

    def note(self, path: str, table: str, item: int, offset: int, factor: float = 1.0) -> None:
        """Note a place where the value at a dotted path is stored."""
        self._notes.append((path, "", Place(table, item, offset, factor)))

    @cached_property
    def places(self) -> dict[str, list[Place]]:
        """Dotted path of each value of the packed scene: the places where it is stored."""
        found: dict[str, list[Place]] = defaultdict(list)
        for path, name, place in self._notes:
            found[f"{path}.{name}" if name else path].append(place)
        return found

    def copy(self, section: Any, table: str, path: str, fields: Mapping[str, str | None]) -> None:
        """Copy the named values of a section to the last item of a table.

        A field maps to its name in the structure where that differs.
        """
        item = len(self.tables[table]) - 1
        target: c.Structure = self.tables[table][item]
        for name, field, offset, factor in _copies(type(target), tuple(fields.items())):
            value = getattr(section, name)
            if value is None:
                continue
            setattr(target, field, value if factor == 1.0 else value * factor)
            self._notes.append((path, name, Place(table, item, offset, factor)))

    def add_settings(self, scene: Any, gravity: str) -> CSettings:
        """Add the settings; `gravity` is the section of the scene that has it."""
        numerics = scene.numerics
        self.add("settings", CSettings(spectral_radius=SPECTRAL_RADIUS))
        settings: CSettings = self.tables["settings"][0]
        self.copy(getattr(scene, gravity), "settings", gravity, {"gravity": None})
        self.copy(scene.wind, "settings", "wind", {"air_density": None})
        self.copy(scene.initial, "settings", "initial", dict.fromkeys(SEEDS))
        self.copy(numerics, "settings", "numerics", dict.fromkeys(NUMERICS))
        settings.integrator = INTEGRATORS[numerics.method].code
        self.note("numerics.integrator", "settings", 0, CSettings.integrator.offset)
        settings.portable = numerics.portable
        settings.start_in_mean_wind = scene.initial.wind == "mean_wind_equilibrium"
        return settings

    def add_cross_section(
        self, conductor: Any, ice: Any | None, ice_path: str, damping: Damping
    ) -> CCrossSection:
        """Add a conductor with its ice (None: bare) and damping, without a coefficient curve."""
        index = self.add("cross_section", CCrossSection(curve=NONE))
        section: CCrossSection = self.tables["cross_section"][index]
        section.slack = SLACK_KINDS[conductor.slack]
        fields = dict(CONDUCTOR_FIELDS)
        if "thermal_expansion" in type(conductor).model_fields:
            fields["thermal_expansion"] = None
        self.copy(conductor, "cross_section", "conductor", fields)
        if ice is not None:
            self.copy(ice, "cross_section", ice_path, ICE_FIELDS)
        for name in ("translation", "twist"):
            pair = getattr(damping, name)
            if pair is None:
                continue
            start = getattr(CCrossSection, f"{name}_damping").offset
            target = getattr(section, f"{name}_damping")
            for field in FREQUENCY_PAIR:
                setattr(target, field, getattr(pair, field))
                offset = start + getattr(type(target), field).offset
                self.note(f"damping.{name}.{field}", "cross_section", index, offset)
        return section

    def add_curve(self, coefficients: Aerodynamics, path: str) -> int:
        """Add a coefficient curve; return its index."""
        curve = coefficients.curve()
        parts = (curve.breakpoint, curve.origin, curve.coefficient)
        first = [self.add_numbers(part) for part in parts]
        if coefficients.kind == "polynomial":
            places = {"centre_deg": first[1], "valid_from_deg": first[0]}
            places["valid_to_deg"] = first[0] + 1
            for name, index in places.items():
                self.note(f"{path}.{name}", "number", index, 0, math.pi / 180.0)
        outside = OUTSIDE_KINDS[curve.outside]
        return self.add("curve", CCurve(len(curve.origin), outside, first[0]))

    def set_curve(self, coefficients: Aerodynamics, curve: int, path: str) -> None:
        """Give the last cross-section a curve by its index."""
        self.tables["cross_section"][-1].curve = curve
        self.copy(coefficients, "cross_section", path, {"reference_radius": None})

    def add_law(self, law: Law, path: str) -> int:
        """Add a law; return its index."""
        item = CLaw(kind=LAW_KINDS[law.kind], fall_start=math.inf)
        index = self.add("law", item)
        self.copy(law, "law", path, LAW_FIELDS[law.kind])
        if isinstance(law, TimeTable):
            item.repeat = law.beyond == "repeat"
            item.count, item.first = len(law.time), self.add_numbers(law.run_times)
            self.add_numbers(law.value)
        return index

    def add_motion(self, motion: Any, path: str) -> tuple[int, int, int]:
        """Add the laws of a tower point's motion; return their indices (`NONE`: at rest)."""
        laws = [getattr(motion, axis, None) for axis in ("x1", "x2", "x3")]
        first, second, third = (
            NONE if law is None else self.add_law(law, f"{path}.motion.{axis}")
            for axis, law in zip(("x1", "x2", "x3"), laws, strict=True)
        )
        return first, second, third

    def add_junction(
        self,
        position: Sequence[float],
        fixed: Sequence[bool],
        motion: Sequence[int] = (NONE, NONE, NONE),
    ) -> int:
        """Add a junction; return its index."""
        junction = CJunction(position=Three(*position))
        junction.fixed[:] = tuple(fixed)
        junction.motion[:] = tuple(motion)
        return self.add("junction", junction)

    def add_device(
        self,
        kind: int,
        junctions: Sequence[int],
        parameters: Mapping[int, float],
    ) -> int:
        """Add a device with its parameters by index; return its index."""
        device = CDevice(kind=kind, junctions=len(junctions))
        device.junction[:] = (*junctions, *(NONE,) * (DEVICE_JUNCTIONS - len(junctions)))
        for place, value in parameters.items():
            device.parameter[place] = value
        return self.add("device", device)

    def set_parameters(
        self, device: int, section: Any, path: str, fields: Mapping[str, int]
    ) -> None:
        """Copy values of a section to parameters of a device; a None is left out."""
        for name, place in fields.items():
            value = getattr(section, name)
            if value is None:
                continue
            factor = _factor(name)
            self.tables["device"][device].parameter[place] = value * factor
            offset = CDevice.parameter.offset + 8 * place
            self.note(f"{path}.{name}", "device", device, offset, factor)

    def add_load(self, load: Load, path: str, chain: int, law: int) -> None:
        """Add a load on a chain, with its law by index."""
        self.add("load", CLoad(force=Three(*load.force), chain=chain, law=law))
        self.copy(load, "load", path, dict.fromkeys(("torque", "position", "evenly_spaced")))


@cache
def _copies(
    structure: type[c.Structure], fields: tuple[tuple[str, str | None], ...]
) -> tuple[tuple[str, str, int, float], ...]:
    """Return name, field of the structure, its offset [bytes] and factor of each value to copy."""
    return tuple(
        (name, other or name, getattr(structure, other or name).offset, _factor(name))
        for name, other in fields
    )


def _factor(name: str) -> float:
    """Factor from the unit of a field to that of the kernel."""
    return math.pi / 180.0 if name.endswith("_deg") else 1.0
