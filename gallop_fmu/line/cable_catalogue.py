"""Cable catalogues of mechaphlowers, the program of RTE for the mechanics of overhead lines.

A catalogue is a CSV file with a row for each cable. Of its columns these are read: ``name``,
``section`` [mm2], ``diameter`` [mm], ``young_modulus`` [MPa], ``linear_mass`` [kg/m],
``dilatation_coefficient`` [1/K], ``rts_cable`` [N] and ``is_polynomial``.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from pathlib import Path

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import cell_number, read_cells
from gallop_fmu.line.conductors import ESTIMATED_TORSIONAL_STIFFNESS, torsional_stiffness

NEEDED = ("section", "diameter", "young_modulus", "linear_mass", "dilatation_coefficient")


@dataclass(frozen=True)
class CatalogueCable:
    """A cable of a catalogue, see `gallop_fmu.line.conductors.Wire`.

    A catalogue has no masses of the layers, so the moment of inertia is that of a uniform round
    bar; a conductor with a steel core has less.
    """

    code_word: str
    diameter: float
    mass_per_length: float
    axial_stiffness: float
    thermal_expansion: float
    rated_strength: float | None
    catalogue: str
    is_polynomial: bool

    @property
    def torsional_stiffness(self) -> float:
        """GJ estimated from the diameter [N m2/rad]."""
        return torsional_stiffness(self.diameter)

    @property
    def torsional_inertia(self) -> float:
        """Mass moment of inertia per unit length about the axis [kg m], m d^2/8."""
        return self.mass_per_length * self.diameter**2 / 8.0

    @property
    def value_sources(self) -> dict[str, str]:
        """Source of each value."""
        stiffness = f"derived: young_modulus times section of {self.catalogue}"
        if self.is_polynomial:
            stiffness += "; the stress-strain polynomials of the cable are not used"
        return {
            "diameter": self.catalogue,
            "mass_per_length": self.catalogue,
            "axial_stiffness": stiffness,
            "torsional_stiffness": ESTIMATED_TORSIONAL_STIFFNESS,
            "thermal_expansion": self.catalogue,
            "rated_strength": self.catalogue,
            "torsional_inertia": "estimated: that of a uniform round bar, m d^2/8",
        }


def find_cable(path: Path, name: str) -> CatalogueCable:
    """Return the cable of a catalogue with a name, in upper or lower case.

    Raises
    ------
    SceneError
        The file is unreadable or no catalogue, the name is not in it or twice, or a value is
        missing or not positive; the message names the row.
    """
    (_, header), *rows = read_cells(path) or [(1, [""])]
    columns = {cell.strip().lower(): k for k, cell in enumerate(header)}
    missing = [column for column in ("name", *NEEDED) if column not in columns]
    if missing:
        raise SceneError(
            f"{path.name}: not a cable catalogue of mechaphlowers, as it has no column"
            f" {missing[0]}; its first line must name {', '.join(('name', *NEEDED))}"
        )
    cables = [
        (row, {column: cells[k].strip() for column, k in columns.items() if k < len(cells)})
        for row, cells in rows
    ]
    found = [(row, cable) for row, cable in cables if cable.get("name", "").lower() == name.lower()]
    if not found:
        names = [cable["name"] for _, cable in cables if cable.get("name")]
        closest = difflib.get_close_matches(name, names, n=3, cutoff=0.0)
        raise SceneError(f"{path.name}: has no cable {name!r}; closest: {', '.join(closest)}")
    if len(found) > 1:
        raise SceneError(
            f"{path.name}: {name!r} is in rows {found[0][0]} and {found[1][0]}; remove one of them"
        )
    return _cable(path, *found[0])


def _cable(path: Path, row: int, cells: dict[str, str]) -> CatalogueCable:
    def positive(column: str) -> float:
        value = cell_number(path, row, column, cells.get(column, ""))
        if not value > 0.0:
            raise SceneError(
                f"{path.name}: {column} in row {row} is {value:g}; must be greater than 0"
            )
        return value

    numbers = {column: positive(column) for column in NEEDED}
    return CatalogueCable(
        code_word=cells["name"],
        diameter=1e-3 * numbers["diameter"],
        mass_per_length=numbers["linear_mass"],
        axial_stiffness=numbers["young_modulus"] * numbers["section"],
        thermal_expansion=numbers["dilatation_coefficient"],
        rated_strength=positive("rts_cable") if cells.get("rts_cable") else None,
        catalogue=f"{cells['name']} in the cable catalogue {path.name}",
        is_polynomial=cells.get("is_polynomial", "").lower() in ("true", "1"),
    )
