"""Statics of a section in mechaphlowers (RTE): catenary spans, strings as rigid bars.

Its strings at the ends have at least 10 mm, which stands for a rigid end here. Its cable is
strained by the mean tension of a span; weight and wind are per metre of the hanging conductor.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.80665
"""Gravity [m/s2] of mechaphlowers, which turns masses into weights."""

DECANEWTON = 10.0
"""Unit [N] of its tensions."""

SHORTEST = 0.01
"""Length [m] of the shortest string that mechaphlowers accepts."""


@dataclass(frozen=True)
class Section:
    """A section as mechaphlowers sees it.  Heights [m] are those of the conductor, strung.

    `strings`: length [m] and weight [N] of all strings, also those of the ends.
    """

    spans: tuple[float, ...]
    heights: tuple[float, ...]
    strings: tuple[tuple[float, float], ...]
    mass: float
    area: float
    modulus: float
    diameter: float
    expansion: float
    tension: float
    strung_temperature: float = 15.0


@dataclass(frozen=True)
class State:
    """Offsets (string, 3) [m] of the conductor from the top of its string, along, up, across.

    Horizontal tensions [N] (the horizontal axis leans with the wind) and unstretched lengths [m]
    at 0 deg C of the spans.
    """

    offsets: Array
    horizontal: Array
    rest_lengths: Array


def solve(section: Section, temperature: float, wind: Array, ice: Array) -> State:
    """State at a temperature [deg C], wind pressures [Pa] and ice thicknesses [m] of the spans."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from mechaphlowers.core.models.balance.engine import BalanceEngine
        from mechaphlowers.entities.arrays import CableArray, SectionArray

        engine = BalanceEngine(
            cable_array=CableArray(_cable(section)),
            section_array=SectionArray(
                _towers(section),
                sagging_parameter=section.tension / (section.mass * GRAVITY),
                sagging_temperature=section.strung_temperature,
            ),
        )
        for solver in (engine.solver_adjustment, engine.solver_change_state):
            solver.stop_condition = 1e-10
        engine.solve_adjustment()
        count = len(section.spans)
        padded = [np.append(x, np.nan) for x in (wind, ice, np.full(count, temperature))]
        # from still air to the wind in steps: full wind can turn a string over
        for share in (0.25, 0.5, 0.75, 1.0):
            engine.solve_change_state(share * padded[0], padded[1], padded[2])
    data = engine.get_data_spans()
    return State(
        engine.get_displacement()[:, [0, 2, 1]],
        DECANEWTON * np.array(data["T_h"]),
        np.array(data["L0"]),
    )


def _towers(section: Section) -> pd.DataFrame:
    count = len(section.spans) + 1
    return pd.DataFrame(
        {
            "name": [str(k) for k in range(count)],
            "suspension": [0 < k < count - 1 for k in range(count)],
            "conductor_attachment_altitude": section.heights,
            "crossarm_length": np.zeros(count),
            "line_angle": np.zeros(count),
            "insulator_length": [length for length, _ in section.strings],
            "span_length": [*section.spans, np.nan],
            "insulator_mass": [weight / GRAVITY for _, weight in section.strings],
        }
    )


def _cable(section: Section) -> pd.DataFrame:
    """The elastic values count here; the rest (layers, thermal values) has no effect on statics."""
    numbers = {
        "section": section.area * 1e6,
        "diameter": section.diameter * 1e3,
        "linear_mass": section.mass,
        "young_modulus": section.modulus * 1e-6,
        "dilatation_coefficient": section.expansion,
        "temperature_reference": 0.0,
        "a1": section.modulus * 1e-6,
        "section_conductor": section.area * 1e6,
    }
    unused = (
        "a0 a2 a3 a4 b0 b1 b2 b3 b4 diameter_heart section_heart solar_absorption emissivity"
        " electric_resistance_20 linear_resistance_temperature_coef radial_thermal_conductivity"
    )
    row = {name: 0.0 for name in unused.split()} | numbers
    return pd.DataFrame([row | {"is_polynomial": False, "has_magnetic_heart": False}])
