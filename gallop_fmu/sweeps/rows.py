"""Rows of results and their header: valid names, types and values."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Set
from functools import lru_cache
from typing import Any, NotRequired, TypedDict

from gallop_fmu.foundation.text_rules import is_printable
from gallop_fmu.sweeps.places import placed

Row = dict[str, Any]
"""Column to number, truth value, text or None (missing)."""


class Header(TypedDict):
    """Description of a sweep; a resumed sweep must have the same.

    Attributes
    ----------
    format : str
        Format of the journal.
    package, task, scenes : str
        Program, computation, and hash of the scenes.
    runs : int
        Number of runs.
    grid : dict
        Dimension to values.
    columns : dict
        Column to unit and meaning.
    """

    format: NotRequired[str]
    package: str
    task: str
    scenes: str
    runs: int
    grid: dict[str, list[Any]]
    columns: Mapping[str, tuple[str, str]]


FORMAT = "gallop-fmu runs 3"

ERROR = "error"
"""Outcome of a run with an unforeseen error, such as lack of memory; a resumed sweep repeats it."""
VARIED = "varied"
"""Meaning of a column that is an input of the runs."""
TEXT_COLUMNS = ("outcome", "message")
"""Columns that are text in every row."""


def is_header(header: Any) -> bool:
    """Check that data are a `Header` of this format."""
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        return False
    if not all(isinstance(header.get(key), str) for key in ("package", "task", "scenes")):
        return False
    grid, columns = header.get("grid"), header.get("columns")
    return (
        isinstance(grid, dict)
        and all(isinstance(values, list) for values in grid.values())
        and is_whole(header.get("runs"))
        and header["runs"] == math.prod(map(len, grid.values()))
        and isinstance(columns, dict)
        and all(map(_is_unit_and_meaning, columns.values()))
        and not _invalid_names((*grid, *columns))
    )


def _is_unit_and_meaning(texts: Any) -> bool:
    return (
        isinstance(texts, list) and len(texts) == 2 and all(isinstance(text, str) for text in texts)
    )


def is_row(row: Any, header: Header, number_columns: Set[str]) -> bool:
    """Check that data are a row of this header: names, values, and its point of the grid."""
    return (
        isinstance(row, dict)
        and is_whole(row.get("run"))
        and 0 <= row["run"] < header["runs"]
        and row.keys() >= set(TEXT_COLUMNS)
        and not row_problem(row)
        and has_values(row, _point(header["grid"], row["run"]))
        and number_columns.isdisjoint(placed(key)[0] for key in row if isinstance(row[key], str))
    )


def number_columns(header: Header) -> set[str]:
    """Return the columns of numbers that are computed."""
    columns = header["columns"].items()
    return {key for key, (unit, meaning) in columns if unit and meaning != VARIED}


def row_problem(row: Mapping[str, Any]) -> str:
    """Return the reason why a row cannot be written to a file of results, or an empty text."""
    if invalid := _invalid_names(tuple(row)):
        return f"{invalid[0]!r}: a column needs a name of printable characters"
    for name in TEXT_COLUMNS:
        if not isinstance(row.get(name, ""), str):
            return f"{name}: must be a text, not {row[name]!r:.40}"
    for name, value in row.items():
        if isinstance(value, str):
            if not is_printable(value):
                return (
                    f"{name}: a text must not hold control characters, surrogates or non-characters"
                )
        elif not (value is None or isinstance(value, (float, bool)) or is_whole(value)):
            return (
                f"{name}: must be a number of at most 64 bits, a truth value, a text or None, not"
                f" {value!r:.40}"
            )
    return ""


@lru_cache  # many rows have the same columns
def _invalid_names(names: tuple[Any, ...]) -> list[Any]:
    return [name for name in names if not (isinstance(name, str) and name and is_printable(name))]


def is_whole(value: Any) -> bool:
    """Check that a value is a whole number of at most 64 bits."""
    return isinstance(value, int) and not isinstance(value, bool) and -(2**63) <= value < 2**63


def as_cell(value: Any) -> Any:
    """Return a value of a scene as a row holds it: lists and tables as JSON."""
    return json.dumps(value) if isinstance(value, (list, dict)) else value


def _point(grid: Mapping[str, list[Any]], run: int) -> Row:
    """Values of the grid in a run; the last parameter changes fastest."""
    point: Row = {}
    for name, values in reversed(list(grid.items())):
        run, index = divmod(run, len(values))
        point[name] = as_cell(values[index])
    return point


def has_values(row: Mapping[str, Any], values: Mapping[str, Any]) -> bool:
    """Check that a row has these columns, with these values of the same types."""
    return all(
        key in row and _as_json(row[key]) == _as_json(value) for key, value in values.items()
    )


def _as_json(value: Any) -> str:
    return json.dumps(finite_or_none(value))


def finite_or_none(value: Any) -> Any:
    """Return None in place of NaN and infinity, which JSON does not have."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
