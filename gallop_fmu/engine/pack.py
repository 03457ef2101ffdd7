"""A scene packed into the kernel's C structures, and a report unpacked from one."""

from __future__ import annotations

import ctypes as c
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.ctypes_structs import (
    FREQUENCY_PAIR,
    SPAN_FIELDS,
    CLaw,
    CLoad,
    CReport,
    CScene,
    CSupport,
    Pointer,
    Three,
)
from gallop_fmu.foundation.integrators import INTEGRATORS, SPECTRAL_RADIUS
from gallop_fmu.foundation.outcome import Outcome, Report
from gallop_fmu.scene.loads import Load
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.supports import Support
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
    "elements",
    "time_step",
    "tolerance",
    "spectral_radius",
    "newton_tolerance",
    "max_newton_iterations",
    "max_halvings",
)
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
SUPPORT_FIELDS: dict[str, tuple[str, ...]] = {
    "rigid": (),
    "springs": ("stiffness_x1", "stiffness_x3"),
    "adjacent_span": ("adjacent_span", "adjacent_tension", "insulator_length", "insulator_weight"),
}
LAW_KINDS = {"constant": 0, "ramp": 1, "pulse": 1, "harmonic": 2, "table": 3}
SUPPORT_KINDS = {"rigid": 0, "springs": 1, "adjacent_span": 2}
OUTSIDE_KINDS = {"error": 0, "hold": 1, "periodic": 2}
SLACK_KINDS = {"error": 0, "tension_only": 1}


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
    """A scene as the kernel reads it: one `CScene`, and the arrays and loads that its pointers lead to.

    Attributes
    ----------
    scene : CScene
        The packed scene.
    places : dict
        Dotted path of a scene value to (structure or array, field or index, factor): where the
        value lies, and by what it is multiplied on the way.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = CScene()
        self.places: dict[str, tuple[Any, str | int, float]] = {}
        self.arrays: list[NDArray[np.float64]] = []
        self.loads = (CLoad * len(scene.loads))()
        self._pack_span(scene)
        self._pack_air(scene)
        for end, (name, support) in enumerate(
            (("left", scene.supports.left), ("right", scene.supports.right))
        ):
            self._pack_support(self.scene.support[end], support, f"supports.{name}")
        for name in ("translation", "twist"):
            pair = getattr(scene.damping, name)
            if pair is not None:
                target = getattr(self.scene, f"{name}_damping")
                self._copy(pair, target, f"damping.{name}", dict.fromkeys(FREQUENCY_PAIR))
        for index, load in enumerate(scene.loads):
            self._pack_load(self.loads[index], load, f"loads.{index}")
        if scene.loads:
            self.scene.load, self.scene.load_count = (
                c.cast(self.loads, c.POINTER(CLoad)),
                len(scene.loads),
            )
        self._copy(
            scene.initial,
            self.scene,
            "initial",
            dict.fromkeys(("seed_vertical", "seed_horizontal", "seed_twist")),
        )
        self.scene.start_in_mean_wind = scene.initial.wind == "mean_wind_equilibrium"
        self.scene.spectral_radius = SPECTRAL_RADIUS
        self._copy(scene.numerics, self.scene, "numerics", dict.fromkeys(NUMERICS))
        self.scene.integrator = INTEGRATORS[scene.numerics.method].code

    def _copy(
        self, section: Any, target: c.Structure, path: str, fields: Mapping[str, str | None]
    ) -> None:
        """Copy the named values of a section; a field maps to its name in the structure where that differs."""
        for name, other in fields.items():
            value = getattr(section, name)
            if value is None:
                continue
            factor = math.pi / 180.0 if name.endswith("_deg") else 1.0
            field = other or name
            setattr(target, field, value if factor == 1.0 else value * factor)
            self.places[f"{path}.{name}"] = (target, field, factor)

    def _pointer(self, values: Any) -> Any:
        self.arrays.append(np.ascontiguousarray(values, dtype=np.float64))
        return double_pointer(self.arrays[-1])

    def _pack_span(self, scene: Scene) -> None:
        self._copy(scene.span, self.scene, "span", dict.fromkeys(SPAN_FIELDS))
        self._copy(scene.conductor, self.scene, "conductor", CONDUCTOR_FIELDS)
        self.scene.slack = SLACK_KINDS[scene.conductor.slack]
        self._copy(scene.ice, self.scene, "ice", ICE_FIELDS)

    def _pack_air(self, scene: Scene) -> None:
        s, wind, coefficients = self.scene, scene.wind, scene.aerodynamics
        self._copy(wind, s, "wind", {"air_density": None})
        self._pack_law(s.wind, wind.history or Constant(value=wind.speed or 0.0), "wind.history")
        if coefficients is None:
            return
        curve = coefficients.curve()
        s.pieces, s.outside = len(curve.origin), OUTSIDE_KINDS[curve.outside]
        s.breakpoint, s.origin = self._pointer(curve.breakpoint), self._pointer(curve.origin)
        if coefficients.kind == "polynomial":
            breakpoint, origin, factor = self.arrays[-2], self.arrays[-1], math.pi / 180.0
            self.places["aerodynamics.centre_deg"] = (origin, 0, factor)
            self.places["aerodynamics.valid_from_deg"] = (breakpoint, 0, factor)
            self.places["aerodynamics.valid_to_deg"] = (breakpoint, 1, factor)
        s.coefficient = self._pointer(curve.coefficient)
        self._copy(coefficients, s, "aerodynamics", {"reference_radius": None})

    def _pack_law(self, target: CLaw, law: Law, path: str) -> None:
        target.kind, target.fall_start = LAW_KINDS[law.kind], math.inf
        self._copy(law, target, path, LAW_FIELDS[law.kind])
        if isinstance(law, TimeTable):
            target.count = len(law.time)
            target.time, target.value = self._pointer(law.time), self._pointer(law.value)

    def _pack_support(self, target: CSupport, support: Support, path: str) -> None:
        target.kind = SUPPORT_KINDS[support.kind]
        self._copy(support, target, path, dict.fromkeys(SUPPORT_FIELDS[support.kind]))
        for axis, name in enumerate(("x1", "x2", "x3")):
            motion = getattr(support.motion, name) if support.motion is not None else None
            self._pack_law(
                target.motion[axis], motion or Constant(value=0.0), f"{path}.motion.{name}"
            )

    def _pack_load(self, target: CLoad, load: Load, path: str) -> None:
        target.force = Three(*load.force)
        self._copy(load, target, path, dict.fromkeys(("torque", "position", "evenly_spaced")))
        self._pack_law(target.law, load.law, f"{path}.law")
