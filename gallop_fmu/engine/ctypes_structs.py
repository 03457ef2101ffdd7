"""The kernel's C structures as ctypes mirrors, field by field as in gallop.h.

`gallop_fmu.engine.library` compares every field with what the compiled library says of it.
"""

from __future__ import annotations

import ctypes as c

Pointer = c.POINTER(c.c_double)
Three = c.c_double * 3
Two = c.c_double * 2
DEVICE_PARAMETERS = 16
"""Parameters of a device; those beyond the ones of its kind are 0."""

DEVICE_JUNCTIONS = 8
"""Junctions that a device can have; indices beyond its own are -1."""

FREQUENCY_PAIR = ("low_ratio", "low_frequency", "high_ratio", "high_frequency")


def _doubles(*names: str) -> tuple[tuple[str, type[c.c_double]], ...]:
    return tuple((name, c.c_double) for name in names)


def _integers(*names: str) -> tuple[tuple[str, type[c.c_int32]], ...]:
    return tuple((name, c.c_int32) for name in names)


class CLaw(c.Structure):
    """gallop_law."""

    _fields_ = (
        *_integers("kind", "count", "first", "repeat"),
        *_doubles("initial", "peak", "amplitude", "start", "rise", "fall_start", "fall"),
        *_doubles("frequency", "phase"),
    )


class CCurve(c.Structure):
    """gallop_curve."""

    _fields_ = _integers("pieces", "outside", "first", "reserved")


class CDamping(c.Structure):
    """gallop_damping."""

    _fields_ = _doubles(*FREQUENCY_PAIR)


class CCrossSection(c.Structure):
    """gallop_cross_section."""

    _fields_ = (
        *_doubles("diameter", "mass", "axial_stiffness", "torsional_stiffness"),
        *_doubles("torsional_inertia", "ice_mass", "ice_torsional_inertia"),
        *_doubles("first_moment_x2", "first_moment_x3", "first_moment_angle"),
        *_doubles("attack_angle", "reference_radius", "thermal_expansion"),
        ("translation_damping", CDamping),
        ("twist_damping", CDamping),
        *_integers("curve", "slack"),
    )


class CField(c.Structure):
    """gallop_field."""

    _fields_ = (
        *_integers("kind", "law", "direction", "profile"),
        *_doubles("profile_parameter", "reference_height"),
        *_integers("ground_points", "first_ground", "stations", "times", "components"),
        *_integers("first_gust", "repeat", "reserved"),
    )


class CJunction(c.Structure):
    """gallop_junction."""

    _fields_ = (
        ("position", Three),
        ("fixed", c.c_int32 * 4),
        ("motion", c.c_int32 * 3),
        ("reserved", c.c_int32),
    )


class CChain(c.Structure):
    """gallop_chain."""

    _fields_ = (
        *_integers("cross_section", "field"),
        ("junction", c.c_int32 * 2),
        *_integers("elements", "reserved"),
        *_doubles("sag", "horizontal_tension"),
    )


class CStation(c.Structure):
    """gallop_station."""

    _fields_ = (
        *_integers("chain", "corner", "junction", "cross_section"),
        ("position", c.c_double),
    )


class CDevice(c.Structure):
    """gallop_device."""

    _fields_ = (
        *_integers("kind", "junctions"),
        ("junction", c.c_int32 * DEVICE_JUNCTIONS),
        ("parameter", c.c_double * DEVICE_PARAMETERS),
    )


class CLoad(c.Structure):
    """gallop_load."""

    _fields_ = (
        *_integers("chain", "law", "evenly_spaced", "reserved"),
        ("position", c.c_double),
        ("force", Three),
        ("torque", c.c_double),
    )


class CShedding(c.Structure):
    """gallop_shedding."""

    _fields_ = (
        *_integers("chain", "corner", "cross_section", "reserved"),
        *_doubles("time", "acceleration"),
    )


class CSettings(c.Structure):
    """gallop_settings."""

    _fields_ = (
        *_doubles("gravity", "air_density", "seed_vertical", "seed_horizontal", "seed_twist"),
        *_doubles("time_step", "newton_tolerance", "tolerance", "spectral_radius"),
        *_integers("max_newton_iterations", "max_halvings", "integrator", "start_in_mean_wind"),
        *_integers("laws_only", "strung", "strung_with_ice", "portable"),
        *_doubles("strung_temperature", "temperature"),
    )


class CScene(c.Structure):
    """gallop_scene."""

    _fields_ = (
        ("settings", CSettings),
        *_integers("cross_section_count", "curve_count", "field_count", "junction_count"),
        *_integers("chain_count", "station_count", "device_count", "load_count", "law_count"),
        ("shedding_count", c.c_int32),
        ("number_count", c.c_int64),
        ("cross_section", c.POINTER(CCrossSection)),
        ("curve", c.POINTER(CCurve)),
        ("field", c.POINTER(CField)),
        ("junction", c.POINTER(CJunction)),
        ("chain", c.POINTER(CChain)),
        ("station", c.POINTER(CStation)),
        ("device", c.POINTER(CDevice)),
        ("load", c.POINTER(CLoad)),
        ("law", c.POINTER(CLaw)),
        ("shedding", c.POINTER(CShedding)),
        ("number", Pointer),
    )


class CReport(c.Structure):
    """gallop_report."""

    _fields_ = (
        *_integers("outcome", "element", "device", "reserved"),
        *_doubles("time", "value", "limit"),
        ("field", c.c_char_p),
        *_doubles("lowest_tension", "largest_turn"),
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
        *_doubles("time", "attack_angle", "attack_angle_rate"),
        *_integers("fields", "junctions"),
        ("wind", Pointer),
        ("direction", Pointer),
        ("motion", Pointer),
    )


class CProbe(c.Structure):
    """gallop_probe."""

    _fields_ = (*_integers("object", "index", "channel", "reserved"), ("station", c.c_double))


class CDerived(c.Structure):
    """gallop_derived."""

    _fields_ = (
        *_doubles("sag", "horizontal_tension", "length"),
        ("support_force", Three * 2),
        ("support_stiffness", Two * 2),
        ("translation_damping", Two),
        ("twist_damping", Two),
        ("imbalance", c.c_double),
        *_integers("parts", "threads"),
    )


class CTeam(c.Structure):
    """gallop_team."""

    _fields_ = (("content", c.c_uint64 * 32),)


class CDerivedChain(c.Structure):
    """gallop_derived_chain."""

    _fields_ = (
        *_doubles("sag", "horizontal_tension", "length"),
        ("end_force", Three * 2),
    )


MIRRORS = {
    "gallop_law": CLaw,
    "gallop_curve": CCurve,
    "gallop_damping": CDamping,
    "gallop_cross_section": CCrossSection,
    "gallop_field": CField,
    "gallop_junction": CJunction,
    "gallop_chain": CChain,
    "gallop_station": CStation,
    "gallop_device": CDevice,
    "gallop_load": CLoad,
    "gallop_shedding": CShedding,
    "gallop_settings": CSettings,
    "gallop_scene": CScene,
    "gallop_report": CReport,
    "gallop_inputs": CInputs,
    "gallop_probe": CProbe,
    "gallop_derived": CDerived,
    "gallop_derived_chain": CDerivedChain,
    "gallop_team": CTeam,
}
"""The structures of gallop.h and their mirrors."""

Layout = dict[tuple[str, str | None], tuple[int, int]]
"""(structure, field) to (offset, size) in bytes; field None: the structure itself."""


def mirrored_layout() -> Layout:
    """Layout of all mirrors."""
    layout: Layout = {}
    for name, mirror in MIRRORS.items():
        layout[name, None] = (0, c.sizeof(mirror))
        for field, *_ in mirror._fields_:
            place = getattr(mirror, field)
            layout[name, field] = (place.offset, place.size)
    return layout
