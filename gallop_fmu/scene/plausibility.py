"""Usual and possible values of an overhead line.

Impossible values are refused, unusual ones get a warning. If the value would be usual in another
unit, the message asks for that unit.
"""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

from gallop_fmu.foundation.errors import SceneError


class Plausible(NamedTuple):
    """Limits of one quantity.

    Attributes
    ----------
    usual, possible : tuple of float
        Lowest and highest value in the unit of the field. Zero is always usual.
    units : dict of str to tuple of float
        Other unit to factor and offset: value in the field's unit = factor * value + offset.
    """

    usual: tuple[float, float]
    possible: tuple[float, float] = (-math.inf, math.inf)
    units: Mapping[str, tuple[float, float]] = {}


LENGTH = {"km": (1e3, 0.0)}
SMALL_LENGTH = {"mm": (1e-3, 0.0), "cm": (1e-2, 0.0)}
FORCE = {"kN": (1e3, 0.0), "MN": (1e6, 0.0)}
SPEED = {"km/h": (1.0 / 3.6, 0.0)}
TEMPERATURE = {"K": (1.0, -273.15)}
ICE_MASS = Plausible((1e-4, 50.0), units={"kg/km": (1e-3, 0.0)})
WIND_SPEED = Plausible((-40.0, 40.0), units=SPEED)
SPAN = Plausible((10.0, 3000.0), (5.0, 1e4), LENGTH)

PLAUSIBLE: dict[str, Plausible] = {
    "line.span": SPAN,
    "line.ruling_span": SPAN,
    "line.adjacent_span": SPAN,
    "line.stringing_percent": Plausible((2.0, 50.0), (1.0, 100.0), {"a fraction": (100.0, 0.0)}),
    "line.stringing_temperature": Plausible((-50.0, 60.0), units=TEMPERATURE),
    "line.temperature": Plausible((-50.0, 60.0), units=TEMPERATURE),
    "line.ice_thickness": Plausible((1e-3, 0.08), (1e-4, 0.5), SMALL_LENGTH),
    "line.ice_density": Plausible((150.0, 930.0), (50.0, 1000.0), {"g/cm3": (1e3, 0.0)}),
    "line.wind_speed": WIND_SPEED,
    "line.insulator_length": Plausible((0.2, 10.0), (0.05, 50.0), SMALL_LENGTH),
    "line.insulator_weight": Plausible((10.0, 3e4), (1.0, 3e5), {"kN": (1e3, 0.0)}),
    "line.damping_percent": Plausible((0.01, 10.0), units={"a fraction": (100.0, 0.0)}),
    "line.twist_damping_percent": Plausible((0.1, 30.0), units={"a fraction": (100.0, 0.0)}),
    "span.length": SPAN._replace(possible=(-math.inf, math.inf)),
    "span.gravity": Plausible((1.0, 30.0), units={"cm/s2": (1e-2, 0.0)}),
    "conductor.diameter": Plausible((2e-3, 0.1), units=SMALL_LENGTH),
    "conductor.mass_per_length": Plausible((0.02, 20.0), units={"kg/km": (1e-3, 0.0)}),
    "conductor.axial_stiffness": Plausible((5e4, 1e9), units=FORCE),
    "ice.mass_per_length": ICE_MASS,
    "wind.air_density": Plausible((0.6, 1.7), units={"g/m3": (1e-3, 0.0)}),
    "wind.speed": WIND_SPEED,
    "section.spans.*.wind.speed": WIND_SPEED,
    "wind.turbulence.intensity*": Plausible((0.02, 0.4), units={"%": (1e-2, 0.0)}),
    "wind.turbulence.length_scale*": Plausible((2.0, 500.0), units=LENGTH),
    "section.spans.*.length": SPAN._replace(possible=(-math.inf, math.inf)),
    "section.gravity": Plausible((1.0, 30.0), units={"cm/s2": (1e-2, 0.0)}),
    "section.*.length": Plausible((0.2, 10.0), units=SMALL_LENGTH),
    "section.*.weight": Plausible((10.0, 3e4), units={"kN": (1e3, 0.0)}),
    "section.*temperature_deg_c": Plausible((-50.0, 150.0), units=TEMPERATURE),
    "section.spans.*.ice.mass_per_length": ICE_MASS,
    "conductor.thermal_expansion": Plausible((5e-6, 3e-5), units={"1e-6/K": (1e-6, 0.0)}),
    "bundle.spacing": Plausible((0.1, 1.5), units=SMALL_LENGTH),
    "bundle.spacer_mass": Plausible((0.1, 50.0), units={"g": (1e-3, 0.0)}),
    "devices.*.ice.mass_per_length": ICE_MASS,
    "devices.*.mass": Plausible((0.05, 500.0), units={"g": (1e-3, 0.0)}),
    "devices.*.arm": Plausible((0.02, 2.0), units=SMALL_LENGTH),
    "supports.*.adjacent_span": SPAN._replace(possible=(-math.inf, math.inf)),
    "supports.*.insulator_length": Plausible((0.2, 10.0), units=SMALL_LENGTH),
    "supports.*.stiffness_x?": Plausible(
        (1.0, 1e12), units={"kN/m": (1e3, 0.0), "MN/m": (1e6, 0.0)}
    ),
    "damping.translation.*_ratio": Plausible((1e-6, 0.2), units={"%": (1e-2, 0.0)}),
    "damping.twist.*_ratio": Plausible((1e-6, 0.5), units={"%": (1e-2, 0.0)}),
}
"""Dotted path, with wildcards, to the limits of its values."""


@lru_cache(maxsize=4096)
def plausible(path: str) -> Plausible | None:
    """Return the limits for a dotted path, or None."""
    return next(
        (row for pattern, row in PLAUSIBLE.items() if fnmatch.fnmatchcase(path, pattern)), None
    )


def question(path: str, value: float, unit: str) -> str:
    """Ask for another unit in which a value would be usual; empty if there is none."""
    row = plausible(path)
    if row is None or not isinstance(value, (int, float)):
        return ""
    for name, (factor, offset) in row.units.items():
        there = factor * value + offset
        if row.usual[0] <= there <= row.usual[1]:
            return (
                f"is it {name if name.startswith('a ') else f'in {name}'} (then {there:.4g}"
                f" {unit})?"
            )
    return ""


def check_possible(numbers: Mapping[str, tuple[float, str]]) -> None:
    """Refuse impossible values.

    Parameters
    ----------
    numbers
        Dotted path to value and unit.

    Raises
    ------
    SceneError
        One line for each such value.
    """
    problems = [
        f"{path} = {value:g} {unit}: no line has less than {row.possible[0]:g} or more than"
        f" {row.possible[1]:g} {unit}; {question(path, value, unit) or 'check the unit'}"
        for path, value, unit, row in _rows(numbers)
        if not row.possible[0] <= value <= row.possible[1]
    ]
    if problems:
        raise SceneError("\n".join(problems))


def unusual(
    numbers: Mapping[str, tuple[float, str]], shown: Callable[[str], str] = str
) -> list[str]:
    """Return warnings about unusual values.

    Parameters
    ----------
    numbers
        As in `check_possible`.
    shown
        Function from a path to its text in a warning.
    """
    return [
        f"{shown(path)} = {value:g} {unit} is outside the usual {row.usual[0]:g} to"
        f" {row.usual[1]:g} {unit}; {question(path, value, unit) or 'check the unit'}"
        for path, value, unit, row in _rows(numbers)
        if not row.usual[0] <= value <= row.usual[1]
    ]


def _rows(numbers: Mapping[str, tuple[float, str]]) -> Iterator[tuple[str, float, str, Plausible]]:
    for path, (value, unit) in numbers.items():
        row = plausible(path)
        if row is not None and value != 0.0:
            yield path, value, "" if unit == "1" else unit, row
