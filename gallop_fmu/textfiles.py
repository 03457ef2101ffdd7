"""Reading small text files that a user names: every way to fail ends in a `SceneError` with the file and the cure."""

from __future__ import annotations

import csv
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationInfo

from gallop_fmu.errors import SceneError

LARGEST_FILE = 10_000_000
"""Bytes; a scene or table beyond this is taken for a mistake."""
DEEPEST = 40
"""Levels of nested TOML tables and arrays that are read; a scene has few."""
# Found before parsing, which takes a time that grows with the square of the levels.
_DEEP_KEY = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}""")


def read_text(path: Path) -> str:
    """Text of a UTF-8 file of at most `LARGEST_FILE` bytes.

    Raises
    ------
    SceneError
        The file does not exist, is a folder or a device, is too large, is not readable or is not UTF-8 text.
    """
    try:
        if not path.exists():
            raise SceneError(f"{path}: no such file")
        if not path.is_file():
            raise SceneError(f"{path}: not a file")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        if len(content) > LARGEST_FILE:
            raise SceneError(f"{path}: has {path.stat().st_size} bytes; at most {LARGEST_FILE} are read")
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(f"{path}: not a text file in UTF-8") from None
    except (OSError, ValueError) as problem:
        if isinstance(problem, SceneError):
            raise
        raise SceneError(f"{path}: cannot be read ({problem})") from None
    if "\0" in text:
        raise SceneError(f"{path}: a binary file, not a text file")
    return text


def parse_toml(text: str) -> dict[str, Any]:
    """Tables and values of TOML text.

    Raises
    ------
    SceneError
        It is none, or nested more than `DEEPEST` levels.
    """
    try:
        if _DEEP_KEY.search(text):
            raise RecursionError
        parsed = tomllib.loads(text)
        level: list[Any] = [parsed]
        for _ in range(DEEPEST):
            level = [item for one in level for item in (one.values() if isinstance(one, dict) else one)]
            level = [item for item in level if isinstance(item, (dict, list))]
        if level:
            raise RecursionError
    except RecursionError:
        raise SceneError(f"not a TOML file that can be a scene (nested more than {DEEPEST} levels)") from None
    except ValueError as problem:  # a whole number of thousands of digits is no TOMLDecodeError
        raise SceneError(f"not a TOML file ({problem})") from None
    return parsed


def read_value(text: str) -> Any:
    """A value as users write it in a cell or behind ``--set``: as in TOML, ``none`` for None, else the text."""
    if text == "none":
        return None
    try:
        parsed = parse_toml(f"value = {text}")
    except SceneError:
        return text
    return parsed["value"] if len(parsed) == 1 else text


def packaged_names(folder: str, suffix: str) -> list[str]:
    """Sorted names, without suffix, of the files of a kind that come with the package."""
    names = [file.name for file in resources.files("gallop_fmu").joinpath(folder).iterdir()]
    return sorted(name.removesuffix(suffix) for name in names if name.endswith(suffix))


def packaged_text(folder: str, name: str) -> str:
    """Text of a file that comes with the package."""
    return resources.files("gallop_fmu").joinpath(folder, name).read_text("utf-8")


@dataclass(frozen=True)
class Table:
    """Columns of numbers from a file, and the row that each entry came from (the header is row 1)."""

    file: str
    columns: Mapping[str, tuple[float, ...]]
    rows: Sequence[int]


def read_header(path: Path) -> list[str]:
    """Names in the first line of a CSV file, as `read_table` counts lines; empty for an empty file.

    Raises
    ------
    SceneError
        Unreadable file.
    """
    lines = read_cells(path)
    return lines[0][1] if lines else []


def read_table(path: Path, header: Sequence[str]) -> Table:
    """Read a CSV file with exactly this header; empty lines and lines that start with ``#`` are skipped.

    Raises
    ------
    SceneError
        Unreadable file, other header, or a cell that is not a finite number; the message names the row.
    """
    filled = read_cells(path)
    if not filled or filled[0][1] != list(header):
        found = ",".join(filled[0][1])[:80] if filled else "an empty file"
        raise SceneError(f"{path.name}: the first line must be {','.join(header)}, found {found}")
    rows, numbers = [], []
    for row, cells in filled[1:]:
        if len(cells) != len(header):
            raise SceneError(f"{path.name}: row {row} has {len(cells)} cells, {len(header)} are needed")
        numbers.append([_number(path, row, name, cell) for name, cell in zip(header, cells, strict=True)])
        rows.append(row)
    return Table(path.name, {name: tuple(line[k] for line in numbers) for k, name in enumerate(header)}, rows)


def read_cells(path: Path) -> list[tuple[int, list[str]]]:
    """Rows of a CSV file with their numbers; empty lines and lines that start with ``#`` are skipped.

    Raises
    ------
    SceneError
        Unreadable file, or a cell without end.
    """
    try:
        lines = list(enumerate(csv.reader(read_text(path).splitlines()), start=1))
    except csv.Error as problem:
        raise SceneError(f"{path}: not a CSV file ({problem})") from None
    filled = [(row, [cell.strip() for cell in cells]) for row, cells in lines if any(cell.strip() for cell in cells)]
    return [(row, cells) for row, cells in filled if not cells[0].startswith("#")]


def _number(path: Path, row: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(f"{path.name}: {name} in row {row} is {cell[:40]!r}, must be a finite number")
    return value


def check_table(
    where: str, key: str, columns: Mapping[str, Sequence[float]], rows: Sequence[int] | None = None
) -> None:
    """Refuse columns of unequal length, fewer than two points, and a `key` column that does not strictly increase.

    Parameters
    ----------
    where
        Start of the message: the file name, or empty for arrays of the scene itself.
    rows
        What to call each entry in the message; counted from 1 without it.
    """
    start = f"{where}: " if where else ""
    count = len(columns[key])
    for name, column in columns.items():
        if len(column) != count:
            raise SceneError(f"{start}{name} has {len(column)} values but {key} has {count}; give one for each")
    if count < 2:
        raise SceneError(f"{start}{key} has {count} point{'s' * (count != 1)}; a table needs at least two")
    for i in range(1, count):
        before, here = columns[key][i - 1], columns[key][i]
        if not here > before:
            row = rows[i] if rows else i + 1
            raise SceneError(f"{start}{key} must increase; row {row} has {here} after {before}")


def take_in_file(data: Any, info: ValidationInfo, key: str, header: Sequence[str]) -> tuple[Any, Table | None]:
    """Replace the entry ``file`` of a raw section by the columns of the CSV file it names.

    A relative name starts from the folder of the scene file, which the loader passes as validation context.

    Returns
    -------
    data, table
        The section with arrays in place of the file, and the table that was read; None where no file was named.
    """
    if not isinstance(data, dict) or data.get("file") is None:
        return data, None
    file = data["file"]
    if not isinstance(file, str):
        raise SceneError(f"file = {file!r}: must be the name of a CSV file with header {','.join(header)}")
    both = [name for name in header if data.get(name)]
    if both:
        raise SceneError(f"file = {file!r} and {', '.join(both)} are both given; give the file or the arrays")
    table = read_table(Path((info.context or {}).get("folder", ".")) / file, header)
    check_table(table.file, key, table.columns, table.rows)
    others = {name: value for name, value in data.items() if name != "file"}
    return {**others, **table.columns}, table
