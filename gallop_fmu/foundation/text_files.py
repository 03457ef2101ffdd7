"""Reading small text files that a user names: every way to fail ends in a `SceneError` with the file and the cure."""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationInfo

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_rules import (
    clean_text,
    is_number,
    number_remedy,
    plain,
    read_number,
    toml_spelling,
)

LARGEST_FILE = 10_000_000
"""Bytes; a scene or table beyond this is taken for a mistake."""
TABLE_SUFFIXES = (".csv", ".txt", ".dat", ".tsv")
"""Names of files whose content messages may quote."""
DEEPEST = 40
"""Levels of nested TOML tables and arrays that are read; a scene has few."""
# Found before parsing, which takes a time that grows with the square of the levels.
_DEEP_KEY = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}""")


# Texts and comments, which are passed over also where they do not end, and words that stand as
# values.
_TOML_PART = re.compile(
    r'''"""(?:[^"\\]|\\.|"(?!""))*+(?:"""|\Z)|"(?:[^"\\\n]|\\[^\n])*+"?'''
    r"""|'''(?:[^']|'(?!''))*+(?:'''|\Z)|'[^'\n]*+'?|\#[^\n]*+"""
    r"""|(?<![\w.+\-])(?P<word>[+-]?\.?[0-9][\w.+\-:]*+)(?=[ \t]*(?:[,\]}\#\n]|\Z))""",
    re.DOTALL,
)


def read_text(path: Path) -> str:
    """Text of a file of at most `LARGEST_FILE` bytes, in UTF-8, or in UTF-16 with a byte order mark.

    Raises
    ------
    SceneError
        The file does not exist, is a folder or a device, is too large, is not readable, is not
        text, or holds a character that `clean_text` refuses.
    """
    try:
        if not path.exists():
            raise SceneError(f"{path}: no such file")
        if not path.is_file():
            raise SceneError(f"{path}: not a file")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        if len(content) > LARGEST_FILE:
            raise SceneError(
                f"{path}: has {path.stat().st_size} bytes; at most {LARGEST_FILE} are read"
            )
        utf16 = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        text = content.decode("utf-16" if utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(
            f"{path}: not a text file in UTF-8; save it as UTF-8 (in Excel: CSV UTF-8), not as an"
            " older encoding"
        ) from None
    except (OSError, ValueError) as problem:
        if isinstance(problem, SceneError):
            raise
        raise SceneError(f"{path}: cannot be read ({problem})") from None
    if "\0" in text:
        raise SceneError(
            f"{path}: a binary file, not a text file; a text file in UTF-16 needs a byte order mark"
        )
    try:
        return clean_text(text)
    except SceneError:
        for number, line in enumerate(text.split("\n"), start=1):
            try:
                clean_text(line)
            except SceneError as problem:
                raise SceneError(f"{path}: line {number}: {problem}") from None
        raise


def parse_toml(text: str) -> dict[str, Any]:
    """Tables and values of TOML text, in which numbers are those of `gallop_fmu.foundation.text_rules.read_number`.

    Raises
    ------
    SceneError
        It is none, a number is written in another way, or it is nested more than `DEEPEST` levels.
    """
    try:
        if _DEEP_KEY.search(text):
            raise RecursionError
        parsed = tomllib.loads(_TOML_PART.sub(_toml_number, text))
        level: list[Any] = [parsed]
        for _ in range(DEEPEST):
            level = [
                item for one in level for item in (one.values() if isinstance(one, dict) else one)
            ]
            level = [item for item in level if isinstance(item, (dict, list))]
        if level:
            raise RecursionError
    except RecursionError:
        raise SceneError(
            f"not a TOML file that can be a scene (nested more than {DEEPEST} levels)"
        ) from None
    except SceneError:
        raise
    except ValueError as problem:  # a whole number of thousands of digits is no TOMLDecodeError
        raise SceneError(f"not a TOML file ({problem})") from None
    return parsed


def _toml_number(part: re.Match[str]) -> str:
    """A part of TOML text, its numbers in the spelling of TOML."""
    word = part["word"]
    if word is None:
        return part[0]
    if is_number(word):
        return toml_spelling(word)
    if "_" in word or word.lstrip("+-")[:2].lower() in ("0x", "0o", "0b"):
        line = part.string.count("\n", 0, part.start()) + 1
        raise SceneError(f"line {line}: {word[:40]} is no number; {number_remedy(word)}")
    return word


def parse_value(text: str, *, as_text: bool = False) -> Any:
    """Value of a cell, or of a value that follows ``--set KEY=`` or ``--over KEY=``.

    ``none`` is None, a number is one by `read_number`, what begins like an array, a table or a
    quoted text is read as TOML. Anything else is a text, which the scene accepts or refuses.

    Parameters
    ----------
    as_text
        The key takes a text: a text that looks like a number stays as it is.

    Raises
    ------
    SceneError
        The text is refused, see `clean_text`.
    """
    text = clean_text(text).strip()
    if text == "none":
        return None
    number = None if as_text else read_number(text)
    if number is not None:
        return number
    if text.startswith(('"', "'") if as_text else ('"', "'", "[", "{")):
        try:
            parsed = parse_toml(f"value = {text}")
        except SceneError:
            return text
        return plain(parsed["value"]) if len(parsed) == 1 else text
    return text


def packaged_names(folder: str, suffix: str) -> list[str]:
    """Sorted names, without suffix, of the files of a kind that come with the package."""
    names = [file.name for file in resources.files("gallop_fmu").joinpath(folder).iterdir()]
    return sorted(name.removesuffix(suffix) for name in names if name.endswith(suffix))


def packaged_text(folder: str, name: str) -> str:
    """Text of a file that comes with the package."""
    return resources.files("gallop_fmu").joinpath(folder, name).read_text("utf-8")


@dataclass(frozen=True)
class Table:
    """Columns of numbers from a file, and the row that each entry came from (the first line of the file is row 1)."""

    file: str
    columns: Mapping[str, tuple[float, ...]]
    rows: Sequence[int]


def read_table(path: Path, units: Mapping[str, str], *, first: str = "") -> Table:
    """Read a CSV file of numbers; empty lines and lines that start with ``#`` are skipped.

    Names of columns may be in capitals, in any order, and followed by their unit in brackets.

    Parameters
    ----------
    units
        Name to unit of the columns that the file must have; no unit, where it is not known.
    first
        Where this is one of the names, it is the first column whatever the file calls it, and the
        file must have at least one of the others.

    Raises
    ------
    SceneError
        Unreadable file, missing, unknown or repeated column, another unit, or a cell that is not a
        finite number; the message names the row.
    """
    lines = read_cells(path)
    header = _column_names(path, lines[0][1] if lines else [], units, first)
    rows, numbers = [], []
    for row, cells in lines[1:]:
        if cells[0].lstrip().startswith("#"):
            continue
        if len(cells) != len(header):
            raise SceneError(
                f"{path.name}: row {row} has {len(cells)} cells, {len(header)} are needed"
            )
        numbers.append(
            [_number(path, row, name, cell) for name, cell in zip(header, cells, strict=True)]
        )
        rows.append(row)
    return Table(
        path.name, {name: tuple(line[k] for line in numbers) for k, name in enumerate(header)}, rows
    )


_NAME_AND_UNIT = re.compile(r"(.*?)\s*(?:[\[(]\s*(.*?)\s*[\])])?")
_SAME_UNIT = {"-": "1", "sec": "s", "seconds": "s", "°": "deg", "degree": "deg", "degrees": "deg"}


def _column_names(
    path: Path, cells: Sequence[str], units: Mapping[str, str], first: str
) -> list[str]:
    """Names of the columns, as `units` spells them."""
    others = ", ".join(name for name in units if name != first)
    wanted = f"{first}, the first column, and any of {others}" if first else ",".join(units)
    wrong = f"{path.name}: the first line must name {wanted}"
    header: list[str] = []
    if not cells:
        raise SceneError(f"{wrong}; the file is empty")
    for position, cell in enumerate(cells):
        found = _NAME_AND_UNIT.fullmatch(cell.strip().replace("\n", " "))
        name, unit = (found[1].lower(), found[2]) if found else (cell, None)
        if first and position == 0 and name not in (known for known in units if known != first):
            name = first
        if name not in units:
            raise SceneError(f"{wrong}; it has {_quoted(path, cell)}{_foreign(','.join(cells))}")
        if unit and units[name] and _SAME_UNIT.get(unit, unit) != units[name]:
            raise SceneError(
                f"{path.name}: column {cell.strip()!r} must be in {units[name]}; convert it"
            )
        if name in header:
            raise SceneError(f"{path.name}: column {name!r} is there twice; remove one of them")
        header.append(name)
    missing = [name for name in units if name not in header]
    if first and (not header or header[0] != first or len(header) < 2):
        raise SceneError(f"{wrong}; it is {_quoted(path, ','.join(cells))}")
    if missing and not first:
        raise SceneError(
            f"{wrong}; it has no {missing[0]}:"
            f" {_quoted(path, ','.join(cells))}{_foreign(','.join(cells))}"
        )
    return header


def _quoted(path: Path, text: str) -> str:
    """Content of a file for a message, if the file is a table by its name: a scene of others may name any file."""
    return repr(text.strip()[:80]) if path.suffix.lower() in TABLE_SUFFIXES else "something else"


def _foreign(header: str) -> str:
    """What to do with a file of another program, as far as its first line tells."""
    if "," not in header and len(header.split()) > 1:
        return (
            ". Its columns are not separated by commas, semicolons or tabs; save it as CSV with one"
            " line of names, and put # before lines of text above it"
        )
    return (
        ". Rename the columns, remove those that are not needed, and put # before lines of text"
        " above the names"
    )


SEPARATORS = ",;\t"
_QUOTED = re.compile(r'"[^"]*"')


def read_cells(path: Path) -> list[tuple[int, list[str]]]:
    """Rows of a CSV file, each with the number of its first line.

    Cells are separated by commas, semicolons or tabs, whichever the first row has most of. Empty
    lines are skipped, and so are lines that start with ``#`` above the first row; columns without a
    name and without any cell are left out.

    Raises
    ------
    SceneError
        Unreadable file, or a quotation mark that is not closed.
    """
    lines = read_text(path).split("\n")
    if lines[0].lstrip().startswith("<"):
        raise SceneError(f"{path}: an XML or HTML file; export the table as CSV")
    skipped, separator = 0, ""
    for line in lines:
        if line.startswith("sep=") and len(line) == 5 and line[4] in SEPARATORS:  # Excel's own line
            separator = line[4]
        elif line.strip(SEPARATORS + " ") and not line.lstrip().startswith("#"):
            break
        skipped += 1
    text = "\n".join(lines[skipped:])
    names = _QUOTED.sub("", lines[skipped]) if text else ""
    separator = separator or max(SEPARATORS, key=names.count)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    rows: list[tuple[int, list[str]]] = []
    while True:
        row = skipped + reader.line_num + 1
        try:
            cells = next(reader)
        except StopIteration:
            break
        except csv.Error as problem:
            raise SceneError(
                f"{path}: not a CSV file in row {row} ({problem}); close each quotation mark that"
                " opens a cell, and double those inside"
            ) from None
        if any(cell.strip() for cell in cells):
            rows.append((row, cells))
    if not rows:
        return []
    width = len(rows[0][1])
    while width and not any(cells[width - 1].strip() for _, cells in rows if len(cells) >= width):
        width -= 1
    return [(row, cells[:width] + _not_blank(cells[width:])) for row, cells in rows]


def _not_blank(cells: list[str]) -> list[str]:
    return cells if any(cell.strip() for cell in cells) else []


def _number(path: Path, row: int, name: str, cell: str) -> float:
    value = read_number(cell)
    if value is None or not math.isfinite(value):
        remedy = number_remedy(cell)
        raise SceneError(
            f"{path.name}: {name} in row {row} is {_quoted(path, cell)}, must be a finite number"
            f"{f'; {remedy}' if remedy else ''}"
        )
    return float(value)


def check_table(
    where: str,
    key: str,
    columns: Mapping[str, Sequence[float]],
    rows: Sequence[int] | None = None,
    *,
    jumps: bool = False,
) -> None:
    """Refuse columns of unequal length, fewer than two points, and a `key` column that does not strictly increase.

    Parameters
    ----------
    where
        Start of the message: the file name, or empty for arrays of the scene itself.
    rows
        What to call each entry in the message; counted from 1 without it.
    jumps
        Two entries of one key are allowed: the columns jump there.
    """
    start = f"{where}: " if where else ""
    count = len(columns[key])
    for name, column in columns.items():
        if len(column) != count:
            raise SceneError(
                f"{start}{name} has {len(column)} values but {key} has {count}; give one for each"
            )
    if count < 2:
        raise SceneError(
            f"{start}{key} has {count} point{'s' * (count != 1)}; a table needs at least two"
        )
    for i in range(1, count):
        before, here = columns[key][i - 1], columns[key][i]
        if not here > before and not (
            jumps and here == before and (i == 1 or columns[key][i - 2] < before)
        ):
            row = rows[i] if rows else i + 1
            allowed = (
                "; two rows of one are a jump, three are not" if jumps and here == before else ""
            )
            raise SceneError(
                f"{start}{key} must increase; row {row} has {here} after {before}{allowed}"
            )


def take_in_file(
    data: Any, info: ValidationInfo, key: str, units: Mapping[str, str], *, jumps: bool = False
) -> tuple[Any, Table | None]:
    """Replace the entry ``file`` of a raw section by the columns of the CSV file it names.

    A relative name starts from the folder of the scene file, which the loader passes as validation
    context.

    Returns
    -------
    data, table
        The section with arrays in place of the file, and the table that was read; None where no
        file was named.
    """
    if not isinstance(data, dict) or data.get("file") is None:
        return data, None
    file = data["file"]
    if not isinstance(file, str):
        raise SceneError(
            f"file = {file!r}: must be the name of a CSV file with header {','.join(units)}"
        )
    both = [name for name in units if data.get(name)]
    if both:
        raise SceneError(
            f"file = {file!r} and {', '.join(both)} are both given; give the file or the arrays"
        )
    table = read_table(Path((info.context or {}).get("folder", ".")) / file, units)
    check_table(table.file, key, table.columns, table.rows, jumps=jumps)
    others = {name: value for name, value in data.items() if name != "file"}
    return {**others, **table.columns}, table
