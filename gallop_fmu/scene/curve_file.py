"""Coefficient curves from CSV files."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import (
    Table,
    check_table,
    name_and_unit,
    read_cells,
    read_table,
)
from gallop_fmu.scene.aerodynamic_curve import COEFFICIENTS

UNIT_NAMES = {"deg": "deg", "°": "deg", "degree": "deg", "degrees": "deg"} | {
    "rad": "rad",
    "radian": "rad",
    "radians": "rad",
}
"""Units of the angles in a header."""

MAX_ROUNDING = 0.25
"""Maximum difference [deg] from a whole turn by rounding of the last angle, such as 6.28 rad."""


def read_curve(path: Path) -> Table:
    """Read a coefficient curve; the header says degrees or radians.

    Columns: ``angle_deg`` or ``angle_rad`` (or ``angle`` with the unit in brackets), ``lift``,
    ``drag``, ``moment``, in any order.

    Returns
    -------
    Table
        Columns ``angle_deg``, ``lift``, ``drag`` and ``moment``. A last angle that differs from a
        whole turn by rounding only is that of the whole turn.

    Raises
    ------
    SceneError
        The file is not such a table; the message names the row.
    """
    unit = _unit_of_angles(path)
    key = f"angle_{unit}"
    columns = {key: unit, **dict.fromkeys(COEFFICIENTS, "1")}
    table = read_table(path, columns, synonyms={"angle": key})
    _refuse_two_values(table, key)
    check_table(table.file, key, table.columns, table.rows)
    angle = list(table.columns[key])
    if unit == "rad":
        angle = [math.degrees(value) for value in angle]
    _refuse_radians(path, unit, angle)
    past_turn = angle[-1] - angle[0] - 360.0
    if 0.0 < abs(past_turn) <= min(MAX_ROUNDING, 0.5 * (angle[-1] - angle[-2])):
        angle[-1] = angle[0] + 360.0
    others = {name: table.columns[name] for name in COEFFICIENTS}
    return replace(table, columns={"angle_deg": tuple(angle), **others})


def _unit_of_angles(path: Path) -> str:
    """Return the unit that the header says."""
    lines = read_cells(path)
    for cell in lines[0][1] if lines else []:
        name, unit = name_and_unit(cell)
        if name in ("angle_deg", "angle_rad"):
            return name.removeprefix("angle_")
        if name == "angle":
            if UNIT_NAMES.get(unit or "") is None:
                raise SceneError(
                    f"{path.name}: column {cell.strip()!r} must say the unit; call it angle_deg or"
                    " angle_rad"
                )
            return UNIT_NAMES[unit or ""]
    return "deg"


def _refuse_two_values(table: Table, key: str) -> None:
    """Refuse two rows with the same angle."""
    angle = table.columns[key]
    for i in range(1, len(angle)):
        if angle[i] == angle[i - 1]:
            raise SceneError(
                f"{table.file}: rows {table.rows[i - 1]} and {table.rows[i]} both give {key} ="
                f" {angle[i]:g}; remove one of them, or give their mean"
            )


def _refuse_radians(path: Path, unit: str, angle: list[float]) -> None:
    """Refuse angles that the header calls degrees and that are a turn in radians."""
    size = angle[-1] - angle[0]
    if unit == "deg" and len(angle) > 12 and abs(size - 2.0 * math.pi) < 0.3:
        raise SceneError(
            f"{path.name}: the angles cover {size:.4g} deg in {len(angle)} rows, as a turn in"
            " radians does; call the column angle_rad"
        )
