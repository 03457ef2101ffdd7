"""The kernel's C structures as ctypes mirrors, field by field as in gallop.h."""

from __future__ import annotations

import ctypes as c

Pointer = c.POINTER(c.c_double)
Three = c.c_double * 3
Two = c.c_double * 2

SPAN_FIELDS = ("length", "height_difference", "sag", "horizontal_tension", "gravity")
SEEDS = ("seed_vertical", "seed_horizontal", "seed_twist")
FREQUENCY_PAIR = ("low_ratio", "low_frequency", "high_ratio", "high_frequency")


class CLaw(c.Structure):
    """gallop_law."""

    _fields_ = (
        ("kind", c.c_int32),
        ("count", c.c_int32),
        *(
            (name, c.c_double)
            for name in ("initial", "peak", "amplitude", "start", "rise", "fall_start", "fall")
        ),
        *((name, c.c_double) for name in ("frequency", "phase")),
        ("time", Pointer),
        ("value", Pointer),
    )


class CSupport(c.Structure):
    """gallop_support."""

    _fields_ = (
        ("kind", c.c_int32),
        ("reserved", c.c_int32),
        *(
            (name, c.c_double)
            for name in ("stiffness_x1", "stiffness_x3", "adjacent_span", "adjacent_tension")
        ),
        *((name, c.c_double) for name in ("insulator_length", "insulator_weight")),
        ("motion", CLaw * 3),
    )


class CLoad(c.Structure):
    """gallop_load."""

    _fields_ = (
        ("evenly_spaced", c.c_int32),
        ("reserved", c.c_int32),
        ("position", c.c_double),
        ("force", Three),
        ("torque", c.c_double),
        ("law", CLaw),
    )


class CDamping(c.Structure):
    """gallop_damping."""

    _fields_ = tuple((name, c.c_double) for name in FREQUENCY_PAIR)


class CScene(c.Structure):
    """gallop_scene."""

    _fields_ = (
        *((name, c.c_double) for name in SPAN_FIELDS),
        *(
            (name, c.c_double)
            for name in ("diameter", "mass", "axial_stiffness", "torsional_stiffness")
        ),
        *(
            (name, c.c_double)
            for name in ("torsional_inertia", "ice_mass", "ice_torsional_inertia")
        ),
        *(
            (name, c.c_double)
            for name in ("first_moment_x2", "first_moment_x3", "first_moment_angle")
        ),
        *((name, c.c_double) for name in ("air_density", "attack_angle", "reference_radius")),
        ("pieces", c.c_int32),
        ("outside", c.c_int32),
        ("breakpoint", Pointer),
        ("origin", Pointer),
        ("coefficient", Pointer),
        ("wind", CLaw),
        ("support", CSupport * 2),
        ("translation_damping", CDamping),
        ("twist_damping", CDamping),
        ("load", c.POINTER(CLoad)),
        ("load_count", c.c_int32),
        ("elements", c.c_int32),
        *((name, c.c_double) for name in SEEDS),
        ("start_in_mean_wind", c.c_int32),
        ("max_newton_iterations", c.c_int32),
        ("max_halvings", c.c_int32),
        ("integrator", c.c_int32),
        ("time_step", c.c_double),
        ("newton_tolerance", c.c_double),
        ("tolerance", c.c_double),
        ("spectral_radius", c.c_double),
        ("laws_only", c.c_int32),
        ("slack", c.c_int32),
    )


class CReport(c.Structure):
    """gallop_report."""

    _fields_ = (
        ("outcome", c.c_int32),
        ("element", c.c_int32),
        *((name, c.c_double) for name in ("time", "value", "limit")),
        ("field", c.c_char_p),
        ("lowest_tension", c.c_double),
        ("largest_turn", c.c_double),
        *(
            (name, c.c_int64)
            for name in (
                "steps",
                "substeps",
                "iterations",
                "refactorisations",
                "halvings",
                "rejections",
            )
        ),
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
        ("parts", c.c_int32),
        ("reserved", c.c_int32),
    )


CHECKED = (CScene, CLaw, CSupport, CLoad, CReport, CInputs, CDerived)
