"""Tables of towers and spans: a CSV file with a row for each tower, in line order.

A row describes a tower and the span after it; the last row has no span. Columns may be in any
order and have one of several names (`SPELLINGS`), with a unit in brackets. Section tables of
mechaphlowers (columns of its ``SectionArray``) are such tables.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal, NamedTuple

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import cell_number, name_and_unit, read_cells

TowerKind = Literal["end", "string", "v_string", "post"]

SPELLINGS: dict[str, tuple[str, ...]] = {
    "tower": ("tower", "name", "tower_name", "tower_number", "support", "structure", "pylon"),
    "span_length": ("span_length", "span", "ahead_span", "span_ahead", "forward_span"),
    "attachment_height": (
        "attachment_height",
        "attachment_altitude",
        "attachment_elevation",
        "conductor_attachment_altitude",
        "conductor_height",
        "altitude",
        "elevation",
        "height",
    ),
    "string_length": ("string_length", "insulator_length", "insulator_string_length"),
    "string_weight": ("string_weight", "insulator_weight", "insulator_string_weight"),
    "string_mass": ("string_mass", "insulator_mass", "insulator_string_mass"),
    "half_spread": ("half_spread", "v_string_half_spread"),
    "type": ("type", "tower_type", "support_type", "kind", "suspension"),
    "line_angle": ("line_angle", "angle", "deviation_angle"),
    "crossarm_length": ("crossarm_length", "cross_arm_length", "crossarm"),
    "counterweight_mass": ("counterweight_mass", "counterweight"),
    "sagging_parameter": ("sagging_parameter", "stringing_parameter", "parameter"),
    "sagging_temperature": ("sagging_temperature", "stringing_temperature"),
    "ground_altitude": ("ground_altitude",),
    "support_height": ("support_height", "tower_height"),
    "x_offset": ("x_offset",),
}
"""Columns, each with its accepted names; spaces and hyphens are as underscores."""

NOT_USED = ("ground_altitude", "support_height", "x_offset")
"""Columns of mechaphlowers that do not matter for a section that is straight in plan."""

_LENGTHS = {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}
_MASSES = {"kg": 1.0, "t": 1e3, "lb": 0.45359237}
_FORCES = {"n": 1.0, "kn": 1e3, "dan": 10.0, "lbf": 4.4482216152605}
_ANGLES = {"deg": 1.0, "°": 1.0, "degrees": 1.0, "grad": 0.9, "gon": 0.9, "rad": 57.29577951308232}
_TEMPERATURES = {"degc": 1.0, "°c": 1.0, "c": 1.0}
UNITS: dict[str, Mapping[str, float]] = {
    **dict.fromkeys(
        (
            "span_length",
            "attachment_height",
            "string_length",
            "half_spread",
            "crossarm_length",
            "sagging_parameter",
        ),
        _LENGTHS,
    ),
    "string_weight": _FORCES,
    "string_mass": _MASSES,
    "counterweight_mass": _MASSES,
    "line_angle": _ANGLES,
    "sagging_temperature": _TEMPERATURES,
}
"""Columns of numbers, each with its units and their factors; the first one is the default."""

KINDS: dict[str, TowerKind] = {
    **dict.fromkeys(
        ("suspension", "string", "i", "i_string", "tangent", "intermediate", "true"), "string"
    ),
    **dict.fromkeys(("v", "v_string", "v_suspension"), "v_string"),
    **dict.fromkeys(("post", "line_post", "post_insulator"), "post"),
    **dict.fromkeys(
        ("tension", "dead_end", "deadend", "strain", "anchor", "terminal", "end", "false"), "end"
    ),
}
"""Types of towers as tables write them; spaces and hyphens are as underscores."""

MAX_SPAN = 10000.0
"""Maximum length of a span [m]."""

MAX_CROSSARM_ANGLE = 0.02
"""Maximum difference of crossarm lengths over the span [rad]; about 1 degree."""


@dataclass(frozen=True)
class Tower:
    """One row of the table, in SI units; None: not given.

    Attributes
    ----------
    row : int
        Row of the file.
    name : str
        Name of the tower.
    kind : {"end", "string", "v_string", "post"}
        Tension tower (``"end"``), or kind of its suspension.
    span_length : float or None
        Span after the tower [m].
    attachment_height : float or None
        Height of the conductor at a suspension in the strung state; of the tower point at an end
        [m].
    string_length, string_weight : float or None
        Length [m] and weight [N] of the string.
    half_spread : float or None
        Half the distance of the tower points of a V-string [m].
    """

    row: int
    name: str
    kind: TowerKind
    span_length: float | None
    attachment_height: float | None
    string_length: float | None
    string_weight: float | None
    half_spread: float | None


class TowerTable(NamedTuple):
    """The towers of a section, and how it was strung as far as the table has it.

    Attributes
    ----------
    file : str
        Name of the file.
    towers : list of Tower
        At least two, in line order.
    parameter : float or None
        Horizontal tension over weight per unit length [m].
    temperature : float or None
        Temperature of the strung state [degC].
    notes : tuple of str
        What of the table is not used.
    """

    file: str
    towers: list[Tower]
    parameter: float | None
    temperature: float | None
    notes: tuple[str, ...]


def read_towers(path: Path, gravity: float) -> TowerTable:
    """Read a table of towers and spans.

    Parameters
    ----------
    path
        CSV file.
    gravity
        Acceleration of gravity [m/s2], for strings with a mass.

    Raises
    ------
    SceneError
        The file is unreadable, a column unknown, a cell no number, a tower missing, a tension tower
        inside the section, or a line angle not 0; the message names the row.
    """
    lines = read_cells(path)
    columns = _columns(path, lines[0][1] if lines else [])
    rows = [_Row(path, row, cells, columns) for row, cells in lines[1:]]
    if len(rows) < 2:
        raise SceneError(
            f"{path.name}: has {len(rows)} tower{'s' * (len(rows) != 1)}; a section needs at least"
            " two, one in a row"
        )
    towers = [_tower(row, gravity, is_end=k in (0, len(rows) - 1)) for k, row in enumerate(rows)]
    _check_names(path, towers)
    _check_spans(path, towers)
    _check_heights(path, towers)
    _check_straight(path, rows, towers)
    unused = [name for name in NOT_USED if name in columns]
    notes = [f"{path.name}: column {name} is not used" for name in unused]
    return TowerTable(
        path.name,
        towers,
        _common(path, rows, "sagging_parameter", "m"),
        _common(path, rows, "sagging_temperature", "degC"),
        tuple(notes),
    )


class _Column(NamedTuple):
    """Place, heading and factor of a column."""

    place: int
    heading: str
    factor: float


class _Row:
    """The cells of one row by the names of `SPELLINGS`."""

    def __init__(
        self, path: Path, row: int, cells: Sequence[str], columns: Mapping[str, _Column]
    ) -> None:
        self.path, self.row, self._cells, self._columns = path, row, cells, columns

    def text(self, name: str) -> str:
        """Text of a cell; empty if the table has no such column."""
        column = self._columns.get(name)
        if column is None or column.place >= len(self._cells):
            return ""
        cell = self._cells[column.place].strip()
        return "" if cell.lower() in ("nan", "na", "none", "null", "-") else cell

    def number(self, name: str) -> float | None:
        """Number of a cell in SI units, or None if it is empty."""
        cell = self.text(name)
        if not cell:
            return None
        column = self._columns[name]
        return column.factor * cell_number(self.path, self.row, column.heading, cell)

    def problem(self, text: str) -> SceneError:
        """Error that names file and row."""
        return SceneError(f"{self.path.name}: row {self.row}: {text}")


def _plain(text: str) -> str:
    """Text in lower case with underscores for spaces and hyphens."""
    return re.sub(r"[\s\-_.]+", "_", text.strip().lower()).strip("_")


def _columns(path: Path, header: Sequence[str]) -> dict[str, _Column]:
    """Return the columns of the table by the names of `SPELLINGS`."""
    found: dict[str, _Column] = {}
    for place, cell in enumerate(header):
        heading, unit = name_and_unit(cell)
        if place == 0 and not heading:
            continue  # the index of a data frame
        name = _column_name(path, cell, heading, unit)
        if name in found:
            raise SceneError(
                f"{path.name}: columns {found[name].heading!r} and {cell.strip()!r} are both the"
                f" {name}; remove one of them"
            )
        found[name] = _Column(place, cell.strip(), _factor(path, cell, name, unit))
    for name in ("tower", "span_length"):
        if name not in found:
            raise SceneError(
                f"{path.name}: has no column {name}; a table of towers has a row for each tower,"
                " with its name and the length of the span after it"
            )
    if "string_weight" in found and "string_mass" in found:
        raise SceneError(f"{path.name}: has both string_weight and string_mass; remove one of them")
    return found


def _column_name(path: Path, cell: str, heading: str, unit: str | None) -> str:
    """Return the name of a column in `SPELLINGS`."""
    plain = _plain(heading)
    name = next((column for column, names in SPELLINGS.items() if plain in names), None)
    if name is None:
        raise SceneError(
            f"{path.name}: column {cell.strip()!r} is unknown; a table of towers has"
            f" {', '.join(list(SPELLINGS)[:8])}: rename it, or remove it"
        )
    has_mass = name == "string_weight" and (unit or "").lower() in _MASSES
    return "string_mass" if has_mass else name


def _factor(path: Path, cell: str, name: str, unit: str | None) -> float:
    """Return the factor of a column's unit."""
    if not unit or name not in UNITS:
        return 1.0
    factor = UNITS[name].get(unit.lower())
    if factor is None:
        raise SceneError(
            f"{path.name}: column {cell.strip()!r} has the unit {unit}; allowed are"
            f" {', '.join(UNITS[name])}: convert it"
        )
    return factor


def _tower(row: _Row, gravity: float, *, is_end: bool) -> Tower:
    """Return the tower of a row; `is_end` for the first and the last."""
    name = row.text("tower")
    if not name:
        raise row.problem("the tower has no name; give it, or remove the row")
    mass, weight = row.number("string_mass"), row.number("string_weight")
    if counterweight := row.number("counterweight_mass"):
        raise row.problem(
            f"tower {name} has a counterweight of {counterweight:g} kg, which a scene cannot"
            " have; set 0 if it does not matter"
        )
    tower = Tower(
        row=row.row,
        name=name,
        kind=_kind(row, name, is_end=is_end),
        span_length=row.number("span_length"),
        attachment_height=row.number("attachment_height"),
        string_length=row.number("string_length") or None,
        string_weight=gravity * mass if mass is not None else weight,
        half_spread=row.number("half_spread"),
    )
    for what in ("string_length", "string_weight", "half_spread"):
        value = getattr(tower, what)
        if value is not None and value < 0.0:
            raise row.problem(f"{what} of tower {name} is {value:g}; must not be negative")
    return tower


def _kind(row: _Row, name: str, *, is_end: bool) -> TowerKind:
    """Return the kind of a tower; only the first and the last are tension towers."""
    text = row.text("type")
    if text and _plain(text) not in KINDS:
        raise row.problem(
            f"tower {name} has the type {text!r}; allowed are suspension, v-string, post and"
            " tension"
        )
    kind = KINDS[_plain(text or ("end" if is_end else "string"))]
    if is_end and kind != "end":
        raise row.problem(
            f"tower {name} is at an end of the section and of type {text}; a section begins and"
            " ends at tension towers: add the missing towers, or correct the type"
        )
    if not is_end and kind == "end":
        raise row.problem(
            f"tower {name} is a tension tower ({text}) within the table; a section ends there:"
            " make a table of each section"
        )
    return kind


def _check_names(path: Path, towers: Sequence[Tower]) -> None:
    """Refuse a name that appears twice, and a gap in numbers of towers."""
    first: dict[str, int] = {}
    for tower in towers:
        if tower.name in first:
            raise SceneError(
                f"{path.name}: row {tower.row}: tower {tower.name} is in row {first[tower.name]},"
                " too; remove one, or correct its name"
            )
        first[tower.name] = tower.row
    numbers = [re.fullmatch(r"(\D*)([0-9]{1,9})", tower.name) for tower in towers]
    if not all(numbers) or len({found[1] for found in numbers if found}) > 1:
        return
    values = [int(found[2]) for found in numbers if found]
    step = 1 if values[-1] > values[0] else -1
    for tower, (before, here) in zip(towers[1:], pairwise(values), strict=True):
        if here == before + step:
            continue
        prefix = numbers[0][1] if numbers[0] else ""
        raise SceneError(
            f"{path.name}: row {tower.row}: tower {tower.name} follows tower {prefix}{before};"
            f" tower {prefix}{before + step} is missing: insert it, or give the towers names that"
            " are not numbers"
        )


def _check_spans(path: Path, towers: Sequence[Tower]) -> None:
    """Refuse missing and impossible span lengths."""
    for tower, after in pairwise(towers):
        if not tower.span_length:
            raise SceneError(
                f"{path.name}: row {tower.row}: tower {tower.name} has no span_length, but tower"
                f" {after.name} follows; give the span between them"
            )
        if not 0.0 < tower.span_length <= MAX_SPAN:
            raise SceneError(
                f"{path.name}: row {tower.row}: span_length after tower {tower.name} is"
                f" {tower.span_length:g} m; must be greater than 0 and at most {MAX_SPAN:g} m;"
                " check the unit"
            )
    if towers[-1].span_length:
        raise SceneError(
            f"{path.name}: row {towers[-1].row}: the last tower {towers[-1].name} has a span of"
            f" {towers[-1].span_length:g} m, but no tower follows; add the tower at its end, or"
            " leave the cell empty"
        )


def _check_heights(path: Path, towers: Sequence[Tower]) -> None:
    """Refuse heights of some towers only."""
    without = [tower for tower in towers if tower.attachment_height is None]
    if without and len(without) < len(towers):
        raise SceneError(
            f"{path.name}: row {without[0].row}: tower {without[0].name} has no attachment_height,"
            " but others have one; give it for all towers, or for none (level spans)"
        )


def _check_straight(path: Path, rows: Sequence[_Row], towers: Sequence[Tower]) -> None:
    """Refuse a section that is not straight in plan."""
    for row, tower in zip(rows[1:-1], towers[1:-1], strict=True):
        angle = row.number("line_angle")
        if angle:
            raise row.problem(
                f"tower {tower.name} has a line angle of {angle:g} deg; a section must be straight"
                " in plan: only 0 is computed, so split the table at this tower, or set 0 if the"
                " angle does not matter"
            )
    for (row, tower), (other, after) in pairwise(zip(rows, towers, strict=True)):
        arms = row.number("crossarm_length"), other.number("crossarm_length")
        if arms[0] is None or arms[1] is None or tower.span_length is None:
            continue
        if abs(arms[1] - arms[0]) > MAX_CROSSARM_ANGLE * tower.span_length:
            raise other.problem(
                f"crossarm_length of tower {after.name} is {arms[1]:g} m, and {arms[0]:g} m of"
                f" tower {tower.name}; a section must be straight in plan, so give equal lengths"
            )


def _common(path: Path, rows: Sequence[_Row], name: str, unit: str) -> float | None:
    """Return the number that all rows with a number have in common."""
    given = [(row, number) for row in rows if (number := row.number(name)) is not None]
    for row, number in given:
        if number != given[0][1]:
            raise row.problem(
                f"{name} is {number:g} {unit}, and {given[0][1]:g} {unit} in row"
                f" {given[0][0].row}; a section is strung with one value"
            )
    return given[0][1] if given else None
