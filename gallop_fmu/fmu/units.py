"""Units of the FMU's variables: exponents of SI base units and radian, a factor, an offset."""

from __future__ import annotations

import math

BASE_UNITS: dict[str, dict[str, float]] = {
    "1": {},
    "s": {"s": 1},
    "Hz": {"s": -1},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "deg": {"rad": 1, "factor": math.pi / 180.0},
    "kg": {"kg": 1},
    "kg m": {"kg": 1, "m": 1},
    "kg/m": {"kg": 1, "m": -1},
    "kg/m3": {"kg": 1, "m": -3},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "N s/m": {"kg": 1, "s": -1},
    "N m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N m s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
    "1/K": {"K": -1},
    "degC": {"K": 1, "offset": 273.15},
    "N m2/rad": {"kg": 1, "m": 3, "s": -2, "rad": -1},
}
"""Exponents by unit; a value in SI is `factor` times the value in the unit, plus `offset`."""

DISPLAY_UNITS = {"rad": ("deg", 180.0 / math.pi), "rad/s": ("deg/s", 180.0 / math.pi)}
"""Display unit by unit: its name, and the factor from the unit to it."""
