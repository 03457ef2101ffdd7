"""The kernel's C structures as ctypes mirrors, and the packing of a scene into them."""

from __future__ import annotations

import ctypes as c
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.laws import Constant, Harmonic, Law, Pulse, Ramp, TimeTable
from gallop_fmu.loads import Load
from gallop_fmu.scene import Scene
from gallop_fmu.supports import AdjacentSpanSupport, SpringSupport

Pointer = c.POINTER(c.c_double)
Three = c.c_double * 3
Two = c.c_double * 2

LAW_KINDS = {"constant": 0, "ramp": 1, "pulse": 1, "harmonic": 2, "table": 3}
SUPPORT_KINDS = {"rigid": 0, "springs": 1, "adjacent_span": 2}
OUTSIDE_KINDS = {"error": 0, "hold": 1, "periodic": 2}


class CLaw(c.Structure):
    """gallop_law."""

    _fields_ = (
        ("kind", c.c_int32),
        ("count", c.c_int32),
        *((name, c.c_double) for name in ("offset", "scale", "start", "rise", "fall_start", "fall")),
        *((name, c.c_double) for name in ("frequency", "phase")),
        ("time", Pointer),
        ("value", Pointer),
    )


class CSupport(c.Structure):
    """gallop_support."""

    _fields_ = (
        ("kind", c.c_int32),
        ("reserved", c.c_int32),
        *((name, c.c_double) for name in ("stiffness_x1", "stiffness_x3", "adjacent_span", "adjacent_tension")),
        *((name, c.c_double) for name in ("insulator_length", "insulator_weight")),
        ("motion", CLaw * 3),
    )


class CLoad(c.Structure):
    """gallop_load."""

    _fields_ = (("position", c.c_double), ("force", Three), ("torque", c.c_double), ("law", CLaw))


class CDamping(c.Structure):
    """gallop_damping."""

    _fields_ = tuple((name, c.c_double) for name in ("low_ratio", "low_frequency", "high_ratio", "high_frequency"))


class CScene(c.Structure):
    """gallop_scene."""

    _fields_ = (
        *((name, c.c_double) for name in ("length", "height_difference", "sag", "horizontal_tension", "gravity")),
        *((name, c.c_double) for name in ("diameter", "mass", "axial_stiffness", "torsional_stiffness")),
        *((name, c.c_double) for name in ("torsional_inertia", "first_moment_x2", "first_moment_x3")),
        *((name, c.c_double) for name in ("air_density", "attack_angle", "reference_radius")),
        ("pieces", c.c_int32),
        ("outside", c.c_int32),
        ("breakpoint", Pointer),
        ("coefficient", Pointer),
        ("wind", CLaw),
        ("support", CSupport * 2),
        ("translation_damping", CDamping),
        ("twist_damping", CDamping),
        ("load", c.POINTER(CLoad)),
        ("load_count", c.c_int32),
        ("elements", c.c_int32),
        *((name, c.c_double) for name in ("seed_vertical", "seed_horizontal", "seed_twist")),
        ("start_in_mean_wind", c.c_int32),
        ("max_newton_iterations", c.c_int32),
        ("max_halvings", c.c_int32),
        ("reserved", c.c_int32),
        ("time_step", c.c_double),
        ("newton_tolerance", c.c_double),
    )


class CReport(c.Structure):
    """gallop_report."""

    _fields_ = (
        ("outcome", c.c_int32),
        ("element", c.c_int32),
        *((name, c.c_double) for name in ("time", "value", "limit", "lowest_tension")),
        *((name, c.c_int64) for name in ("steps", "substeps", "iterations", "refactorisations", "halvings")),
    )


class CInputs(c.Structure):
    """gallop_inputs."""

    _fields_ = (
        *((name, c.c_double) for name in ("time", "wind_speed", "attack_angle")),
        ("support", Three * 2),
        *((name, c.c_double) for name in ("wind_speed_rate", "attack_angle_rate")),
        ("support_rate", Three * 2),
    )


class CDerived(c.Structure):
    """gallop_derived."""

    _fields_ = (
        *((name, c.c_double) for name in ("sag", "horizontal_tension", "length")),
        ("support_force", Three * 2),
        ("support_stiffness", Two * 2),
        ("translation_damping", Two),
        ("twist_damping", Two),
        ("imbalance", c.c_double),
    )


CHECKED = (CScene, CLaw, CSupport, CLoad, CReport, CInputs, CDerived)


def double_pointer(values: NDArray[np.float64]) -> Any:
    """Pointer to the first value of a contiguous array."""
    return values.ctypes.data_as(Pointer)


class Packed:
    """A scene as the kernel reads it, together with the arrays its pointers lead to."""

    def __init__(self, scene: Scene) -> None:
        self._kept: list[Any] = []
        self.scene = CScene()
        self._pack(scene)

    def _pointer(self, values: Any) -> Any:
        array = np.ascontiguousarray(values, dtype=np.float64)
        self._kept.append(array)
        return double_pointer(array)

    def _law(self, law: Law | None) -> CLaw:
        packed = CLaw(fall_start=math.inf)
        if law is None:
            return packed
        packed.kind = LAW_KINDS[law.kind]
        match law:
            case Constant():
                packed.offset = law.value
            case Ramp():
                packed.offset, packed.scale = law.initial, law.final - law.initial
                packed.start, packed.rise = law.start, law.duration
            case Pulse():
                packed.offset, packed.scale = law.initial, law.peak - law.initial
                packed.start, packed.rise = law.start, law.rise
                packed.fall_start, packed.fall = law.fall_start, law.fall
            case Harmonic():
                packed.offset, packed.scale, packed.start = law.mean, law.amplitude, law.start
                packed.frequency, packed.phase = law.frequency_hz, math.radians(law.phase_deg)
            case TimeTable():
                packed.scale, packed.count = 1.0, len(law.time)
                packed.time, packed.value = self._pointer(law.time), self._pointer(law.value)
        return packed

    def _support(self, support: Any) -> CSupport:
        packed = CSupport(kind=SUPPORT_KINDS[support.kind])
        match support:
            case SpringSupport():
                packed.stiffness_x1, packed.stiffness_x3 = support.stiffness_x1, support.stiffness_x3
            case AdjacentSpanSupport():
                packed.adjacent_span, packed.adjacent_tension = support.adjacent_span, support.adjacent_tension
                packed.insulator_length = support.insulator_length
                packed.insulator_weight = support.insulator_weight
        motion = support.motion
        for axis, name in enumerate(("x1", "x2", "x3")):
            packed.motion[axis] = self._law(getattr(motion, name) if motion is not None else None)
        return packed

    def _loads(self, loads: tuple[Load, ...]) -> list[CLoad]:
        packed = []
        for load in loads:
            law = self._law(load.law)
            count = load.evenly_spaced
            points = [load.position] if count is None else [k / (count + 1) for k in range(1, count + 1)]
            for position in points:
                packed.append(CLoad(position=position, force=Three(*load.force), torque=load.torque, law=law))
        return packed

    def _pack(self, scene: Scene) -> None:
        s = self.scene
        s.length, s.height_difference, s.gravity = scene.span.length, scene.span.height_difference, scene.span.gravity
        s.sag, s.horizontal_tension = scene.span.sag or 0.0, scene.span.horizontal_tension or 0.0

        conductor, ice = scene.conductor, scene.ice
        s.diameter, s.axial_stiffness = conductor.diameter, conductor.axial_stiffness
        s.torsional_stiffness = conductor.torsional_stiffness
        s.mass = conductor.mass_per_length + ice.mass_per_length
        s.torsional_inertia = conductor.torsional_inertia + ice.torsional_inertia
        s.first_moment_x2, s.first_moment_x3 = ice.first_moment_x2, ice.first_moment_x3

        s.air_density, s.attack_angle = scene.wind.air_density, math.radians(ice.attack_angle_deg)
        s.reference_radius = 0.5 * conductor.diameter
        if scene.aerodynamics is not None:
            curve = scene.aerodynamics.curve()
            s.pieces, s.outside = len(curve.breakpoint) - 1, OUTSIDE_KINDS[curve.outside]
            s.breakpoint, s.coefficient = self._pointer(curve.breakpoint), self._pointer(curve.coefficient)
            if scene.aerodynamics.reference_radius is not None:
                s.reference_radius = scene.aerodynamics.reference_radius
        s.wind = self._law(scene.wind.history or Constant(value=scene.wind.speed or 0.0))

        s.support[0], s.support[1] = self._support(scene.supports.left), self._support(scene.supports.right)
        for target, pair in (("translation_damping", scene.damping.translation), ("twist_damping", scene.damping.twist)):
            if pair is not None:
                values = (pair.low_ratio, pair.low_frequency, pair.high_ratio, pair.high_frequency)
                setattr(s, target, CDamping(*values))
        loads = self._loads(scene.loads)
        array = (CLoad * len(loads))(*loads)
        self._kept.append(array)
        s.load, s.load_count = c.cast(array, c.POINTER(CLoad)), len(loads)

        initial, numerics = scene.initial, scene.numerics
        s.seed_vertical, s.seed_horizontal = initial.seed_vertical, initial.seed_horizontal
        s.seed_twist, s.start_in_mean_wind = initial.seed_twist, initial.wind == "mean_wind_equilibrium"
        s.elements, s.time_step = numerics.elements, numerics.time_step
        s.newton_tolerance = numerics.newton_tolerance
        s.max_newton_iterations, s.max_halvings = numerics.max_newton_iterations, numerics.max_halvings
