"""Stranded conductors by code word, such as Drake or Zebra.

The table ``conductors.csv`` has strands, diameter, mass and rated strength, each row with its
source; areas and stiffnesses are computed from the strands by `StrandedConductor`.
"""

from __future__ import annotations

import csv
import difflib
import math
from dataclasses import dataclass
from functools import cache
from typing import Protocol

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import packaged_text

ALUMINIUM_DENSITY = 2703.0
"""Density of hard-drawn aluminium wire [kg/m3]; alloy wire has 2700."""

STEEL_DENSITY = 7780.0
"""Density of zinc-coated steel wire [kg/m3]."""

STEEL_MODULUS = 190e9
"""Young's modulus of the stranded steel core [Pa]."""

ALUMINIUM_EXPANSION, STEEL_EXPANSION = 23.0e-6, 11.5e-6
"""Coefficients of linear expansion [1/K]."""

EFFECTIVE_SHEAR_MODULUS = 5e9
"""Torsional stiffness over pi d^4/32 [Pa].

Strands slide, so it is far below the 26 GPa of aluminium, and uncertain by a factor of two: Table 1
of Liu, Yan, Zhang, Zhou (2009) has 8.2 and 5.1 GPa, a published Zebra line 4.3 GPa
(github.com/Baiyu-Eplur/Pylon1)."""

SOURCES = {
    "A": (
        "area, weight and rated strength: REFA conductor database (Lawrence Berkeley National"
        " Laboratory); strands: the ASTM B232 design of that size whose area and mass agree with"
        " them"
    ),
    "B": (
        "strands and diameter: ASTM B232, as in Grigsby (ed.), Electric Power Generation,"
        " Transmission, and Distribution (2nd ed. 2007), Tables 13.2 and 14.5; weight and rated"
        " strength: REFA conductor database (Lawrence Berkeley National Laboratory)"
    ),
    "C": (
        "strands, diameter and mass: ASTM B232/B232M-11, Table 1; rated strength: REFA conductor"
        " database (Lawrence Berkeley National Laboratory)"
    ),
    "D": (
        "BS EN 50182:2001, Annex F, conductors used in the United Kingdom, from a public"
        " transcription whose areas, diameters and masses agree with the wires"
    ),
    "E": "conductors to BS EN 50182 in the catalogue of Zar Cable (en.zarcable.com)",
    "F": (
        "diameter as published, which is that of whole layers of equal wires; mass derived: 2700"
        " kg/m3 times the area, plus 2.03 % (37 wires) or 2.37 % (61 wires) for stranding as in the"
        " tables of EN 50182; without rated strength, which is not confirmed"
    ),
}
"""Sources of the rows, by the letter in their last column."""


ESTIMATED_TORSIONAL_STIFFNESS = "estimated, 5 GPa times pi d^4/32; uncertain by a factor of two"
"""Source of the torsional stiffness."""


def torsional_stiffness(diameter: float) -> float:
    """GJ = pi d^4/32 times `EFFECTIVE_SHEAR_MODULUS` [N m2/rad]; uncertain by a factor of 2."""
    return EFFECTIVE_SHEAR_MODULUS * math.pi * diameter**4 / 32.0


class Wire(Protocol):
    """A conductor of the table, or of a catalogue of another program.

    Attributes
    ----------
    code_word : str
        Trade name.
    diameter, mass_per_length, axial_stiffness, torsional_stiffness, torsional_inertia
        Values of a scene, in SI units.
    thermal_expansion : float
        Coefficient of linear expansion [1/K].
    rated_strength : float or None
        Rated tensile strength [N]; None if it is not known.
    value_sources : dict of str to str
        Source of each of these values.
    """

    @property
    def code_word(self) -> str: ...  # noqa: D102
    @property
    def diameter(self) -> float: ...  # noqa: D102
    @property
    def mass_per_length(self) -> float: ...  # noqa: D102
    @property
    def axial_stiffness(self) -> float: ...  # noqa: D102
    @property
    def torsional_stiffness(self) -> float: ...  # noqa: D102
    @property
    def torsional_inertia(self) -> float: ...  # noqa: D102
    @property
    def thermal_expansion(self) -> float: ...  # noqa: D102
    @property
    def rated_strength(self) -> float | None: ...  # noqa: D102
    @property
    def value_sources(self) -> dict[str, str]: ...  # noqa: D102


@dataclass(frozen=True)
class StrandedConductor:
    """Round wires in concentric layers: aluminium or its alloy, with or without a steel core.

    Attributes
    ----------
    code_word : str
        Trade name.
    construction : {"ACSR", "AAC", "AAAC"}
        Steel-reinforced aluminium, aluminium, or aluminium alloy.
    aluminium_wires, steel_wires : int
        Numbers of wires.
    aluminium_wire_diameter, steel_wire_diameter : float
        Diameters of the wires [m]; 0 without steel.
    diameter : float
        Overall diameter [m].
    mass_per_length : float
        Mass per unit length [kg/m], without grease.
    rated_strength : float or None
        Rated tensile strength [N]; None if no source confirms it.
    source : str
        Source of these numbers.
    """

    code_word: str
    construction: str
    aluminium_wires: int
    aluminium_wire_diameter: float
    steel_wires: int
    steel_wire_diameter: float
    diameter: float
    mass_per_length: float
    rated_strength: float | None
    source: str

    @property
    def aluminium_area(self) -> float:
        """Cross-section of the aluminium wires [m2]."""
        return self.aluminium_wires * 0.25 * math.pi * self.aluminium_wire_diameter**2

    @property
    def steel_area(self) -> float:
        """Cross-section of the steel wires [m2]."""
        return self.steel_wires * 0.25 * math.pi * self.steel_wire_diameter**2

    @property
    def aluminium_modulus(self) -> float:
        """Final modulus of the stranded aluminium [Pa].

        60 GPa up to 7 wires, 57 GPa up to 37, 55 GPa above: values of the Austrian tables of EN
        50182 for all-aluminium conductors. The stiffness decreases with the number of layers.
        """
        return 60e9 if self.aluminium_wires <= 7 else 57e9 if self.aluminium_wires <= 37 else 55e9

    @property
    def axial_stiffness(self) -> float:
        """EA = E_al A_al + E_st A_st [N]."""
        return self.aluminium_modulus * self.aluminium_area + STEEL_MODULUS * self.steel_area

    @property
    def thermal_expansion(self) -> float:
        """Coefficient of linear expansion [1/K]: of aluminium and steel, weighted by E A."""
        aluminium, steel = (
            self.aluminium_modulus * self.aluminium_area,
            STEEL_MODULUS * self.steel_area,
        )
        return (ALUMINIUM_EXPANSION * aluminium + STEEL_EXPANSION * steel) / (aluminium + steel)

    @property
    def torsional_stiffness(self) -> float:
        """GJ = pi d^4/32 times `EFFECTIVE_SHEAR_MODULUS` [N m2/rad]; uncertain by a factor of 2."""
        return torsional_stiffness(self.diameter)

    @property
    def value_sources(self) -> dict[str, str]:
        """Source of each value."""
        return {
            "diameter": self.source,
            "mass_per_length": self.source,
            "axial_stiffness": (
                f"derived, E A of {self.aluminium_wires} aluminium wires"
                f" ({self.aluminium_modulus / 1e9:g} GPa) and {self.steel_wires} steel wires (190"
                " GPa)"
            ),
            "torsional_stiffness": ESTIMATED_TORSIONAL_STIFFNESS,
            "torsional_inertia": "derived, wires in concentric layers",
            "thermal_expansion": "derived, of aluminium and steel, weighted by E A",
            "rated_strength": self.source,
        }

    @property
    def torsional_inertia(self) -> float:
        """Mass moment of inertia per unit length about the axis [kg m], from the wires."""
        layers = [
            (count * density * wire**2, radius**2 + wire**2 / 8.0)
            for count, density, wire, radius in (*self._steel_layers(), *self._aluminium_layers())
        ]
        return (
            self.mass_per_length
            * sum(mass * square for mass, square in layers)
            / sum(mass for mass, _ in layers)
        )

    def _steel_layers(self) -> list[tuple[int, float, float, float]]:
        counts = {0: (), 1: (1,), 7: (1, 6), 19: (1, 6, 12)}[self.steel_wires]
        wire = self.steel_wire_diameter
        return [(count, STEEL_DENSITY, wire, ring * wire) for ring, count in enumerate(counts)]

    def _aluminium_layers(self) -> list[tuple[int, float, float, float]]:
        """Count, density, wire diameter and radius of each layer, from the outermost inwards."""
        wire = self.aluminium_wire_diameter
        core = sum(1 for _ in self._steel_layers())
        core_diameter = (2 * core - 1) * self.steel_wire_diameter if core else wire
        layers = round(0.5 * (self.diameter - core_diameter) / wire)
        around = self.aluminium_wires - (0 if core else 1)
        outermost = around // layers + 3 * (layers - 1)
        rings = [
            (outermost - 6 * k, ALUMINIUM_DENSITY, wire, 0.5 * (self.diameter - wire) - k * wire)
            for k in range(layers)
        ]
        return rings if core else [*rings, (1, ALUMINIUM_DENSITY, wire, 0.0)]


@cache
def conductors() -> dict[str, StrandedConductor]:
    """Return all conductors of the table by code word."""
    rows = csv.DictReader(packaged_text("line", "conductors.csv").splitlines())
    return {row["code_word"]: _read(row) for row in rows}


def find_conductor(code_word: str) -> StrandedConductor:
    """Return the conductor with a code word, in upper or lower case.

    Raises
    ------
    SceneError
        The table does not have the code word; the message names the closest.
    """
    known = {name.lower(): found for name, found in conductors().items()}
    if code_word.lower() not in known:
        closest = difflib.get_close_matches(code_word.lower(), known, n=3, cutoff=0.0)
        names = ", ".join(known[name].code_word for name in closest)
        raise SceneError(
            f"{code_word!r} is not a code word of the table; closest: {names} (gallop-fmu"
            " conductors lists all). For another conductor, give its values in the section"
            " [conductor] of the scene"
        )
    return known[code_word.lower()]


def _read(row: dict[str, str]) -> StrandedConductor:
    strength = row["rated_strength_kn"]
    return StrandedConductor(
        code_word=row["code_word"],
        construction=row["construction"],
        aluminium_wires=int(row["aluminium_wires"]),
        aluminium_wire_diameter=1e-3 * float(row["aluminium_wire_mm"]),
        steel_wires=int(row["steel_wires"]),
        steel_wire_diameter=1e-3 * float(row["steel_wire_mm"]),
        diameter=1e-3 * float(row["diameter_mm"]),
        mass_per_length=1e-3 * float(row["mass_kg_per_km"]),
        rated_strength=1e3 * float(strength) if strength else None,
        source=SOURCES[row["source"]],
    )
