"""Reading of small text files; every failure is a `SceneError` with the file and a remedy."""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from types import MappingProxyType
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

MAX_FILE_SIZE = 10_000_000
"""Maximum size [bytes] of a scene or table."""
TABLE_SUFFIXES = (".csv", ".txt", ".dat", ".tsv")
"""Suffixes of files whose content may be quoted in messages."""
MAX_DEPTH = 40
"""Maximum depth of nested TOML tables and arrays."""
# A dotted key of this depth is found before parsing, whose time grows with the square of the depth.
_DEEP_KEY = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){{{MAX_DEPTH}}}""")

# Texts and comments, also unterminated ones, and words that are values.
_TOML_PART = re.compile(
    r'''"""(?:[^"\\]|\\.|"(?!""))*+(?:"""|\Z)|"(?:[^"\\\n]|\\[^\n])*+"?'''
    r"""|'''(?:[^']|'(?!''))*+(?:'''|\Z)|'[^'\n]*+'?|\#[^\n]*+"""
    r"""|(?<![\w.+\-])(?P<word>[+-]?\.?[0-9][\w.+\-:]*+)(?=[ \t]*(?:[,\]}\#\n]|\Z))""",
    re.DOTALL,
)


def read_text(path: Path) -> str:
    """Read a file of at most `MAX_FILE_SIZE` in UTF-8, or in UTF-16 with a byte order mark.

    Raises
    ------
    SceneError
        The file is missing, unreadable, too large, a folder, a device or not text, or holds a
        character that `clean_text` refuses.
    """
    try:
        if not path.exists():
            raise SceneError(f"{path}: no such file")
        if not path.is_file():
            raise SceneError(f"{path}: not a file; give the name of a file")
        with path.open("rb") as file:
            content = file.read(MAX_FILE_SIZE + 1)
        if len(content) > MAX_FILE_SIZE:
            raise SceneError(
                f"{path}: has {path.stat().st_size} bytes, at most {MAX_FILE_SIZE} are allowed;"
                " shorten it"
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
            f"{path}: a binary file, not a text file; save it as UTF-8 (UTF-16 needs a byte order"
            " mark)"
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
    """Parse TOML; numbers may also have the spellings of `read_number`.

    Raises
    ------
    SceneError
        It is not TOML, a number has another spelling, or the depth exceeds `MAX_DEPTH`.
    """
    try:
        if _DEEP_KEY.search(text):
            raise RecursionError
        parsed = tomllib.loads(_TOML_PART.sub(_toml_number, text))
        level: list[Any] = [parsed]
        for _ in range(MAX_DEPTH):
            level = [
                item for one in level for item in (one.values() if isinstance(one, dict) else one)
            ]
            level = [item for item in level if isinstance(item, (dict, list))]
        if level:
            raise RecursionError
    except RecursionError:
        raise SceneError(
            f"not a TOML file that can be a scene (nested more than {MAX_DEPTH} levels)"
        ) from None
    except SceneError:
        raise
    except ValueError as problem:  # a whole number of thousands of digits is no TOMLDecodeError
        raise SceneError(f"not a TOML file ({problem})") from None
    return parsed


def _toml_number(part: re.Match[str]) -> str:
    """Return a part of TOML text, with numbers in the spelling of TOML."""
    word = part["word"]
    if word is None:
        return part[0]
    if is_number(word):
        return toml_spelling(word)
    if "_" in word or word.lstrip("+-")[:2].lower() in ("0x", "0o", "0b"):
        line = part.string.count("\n", 0, part.start()) + 1
        raise SceneError(f"line {line}: {word[:40]} is not a number; {number_remedy(word)}")
    return word


def parse_value(text: str, *, as_text: bool = False) -> Any:
    """Parse the text of a cell, or of ``--set KEY=`` or ``--over KEY=``.

    ``none`` is None; numbers are parsed by `read_number`; arrays, tables and quoted texts as TOML.
    Anything else is a text, which the scene accepts or refuses.

    Parameters
    ----------
    as_text
        The key takes a text: a number is returned as it is written.

    Raises
    ------
    SceneError
        The text holds a character that `clean_text` refuses, such as a control character.
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
    """Return the sorted names, without suffix, of packaged files with a suffix."""
    names = [file.name for file in resources.files("gallop_fmu").joinpath(folder).iterdir()]
    return sorted(name.removesuffix(suffix) for name in names if name.endswith(suffix))


def packaged_text(folder: str, name: str) -> str:
    """Read a packaged text file."""
    return resources.files("gallop_fmu").joinpath(folder, name).read_text("utf-8")


@dataclass(frozen=True)
class Table:
    """Columns of numbers from a file, and the row of each entry; the first line is row 1."""

    file: str
    columns: Mapping[str, tuple[float, ...]]
    rows: Sequence[int]


def read_table(
    path: Path,
    units: Mapping[str, str],
    *,
    first: str = "",
    synonyms: Mapping[str, str] = MappingProxyType({}),
) -> Table:
    """Read a CSV file of numbers; empty lines and lines that start with ``#`` are skipped.

    Names of columns may be in upper case, in any order, and followed by the unit in brackets.

    Parameters
    ----------
    units
        Name to unit of the required columns; the unit may be empty.
    first
        Name of the first column, which may have another name in the file. With it, the file needs
        only one of the other columns.
    synonyms
        Other name in lower case to name of a column.

    Raises
    ------
    SceneError
        The file is unreadable, a column missing, unknown or repeated, a unit different, or a cell
        not a finite number; the message names the row.
    """
    lines = read_cells(path)
    names = [_renamed(cell, synonyms) for cell in lines[0][1]] if lines else []
    header = _column_names(path, names, units, first)
    rows, numbers = number_rows(path, lines[1:], header)
    return Table(
        path.name, {name: tuple(line[k] for line in numbers) for k, name in enumerate(header)}, rows
    )


def number_rows(
    path: Path, lines: Sequence[tuple[int, list[str]]], header: Sequence[str]
) -> tuple[list[int], list[list[float]]]:
    """Return the row numbers and the numbers of the lines below a header, without comments.

    Raises
    ------
    SceneError
        A row has more or fewer cells than the header, or a cell is not a finite number.
    """
    rows, numbers = [], []
    for row, cells in lines:
        if cells[0].lstrip().startswith("#"):
            continue
        if len(cells) != len(header):
            raise SceneError(
                f"{path.name}: row {row} has {len(cells)} cells, {len(header)} are required; give"
                " one for each column"
            )
        numbers.append(
            [cell_number(path, row, name, cell) for name, cell in zip(header, cells, strict=True)]
        )
        rows.append(row)
    return rows, numbers


def _renamed(cell: str, synonyms: Mapping[str, str]) -> str:
    """Return the header of a column with a synonym replaced by the name."""
    return synonyms.get(name_and_unit(cell)[0], cell) if synonyms else cell


MAX_NAMES = 12
"""Maximum number of names of columns in a message."""

_NAME_AND_UNIT = re.compile(r"(.*?)\s*(?:[\[(]\s*(.*?)\s*[\])])?")
_SAME_UNIT = {"-": "1", "sec": "s", "seconds": "s", "°": "deg", "degree": "deg", "degrees": "deg"}


def _column_names(
    path: Path, cells: Sequence[str], units: Mapping[str, str], first: str
) -> list[str]:
    """Return the names of the columns in the spelling of `units`."""
    names = [name for name in units if name != first]
    more = f" ({len(names)} in all)" if len(names) > MAX_NAMES else ""
    others = ", ".join(names[:MAX_NAMES]) + more
    required = f"{first}, the first column, and any of {others}" if first else ",".join(units)
    rule = f"{path.name}: the first line must name {required}"
    if not cells:
        raise SceneError(f"{rule}; the file is empty")
    given = ",".join(cells)
    header: list[str] = []
    for cell in cells:
        name, unit = name_and_unit(cell)
        if first and not header and name not in units:
            name = first
        if name not in units:
            raise SceneError(f"{rule}; it has {_quoted(path, cell)}{_header_remedy(given)}")
        _check_unit(f"{path.name}: column {cell.strip()!r}", unit, units[name])
        if name in header:
            raise SceneError(f"{path.name}: column {name!r} is given twice; remove one of them")
        header.append(name)
    if problem := _missing_columns(header, units, first):
        raise SceneError(f"{rule}; {problem} {_quoted(path, given)}{_header_remedy(given)}")
    return header


def _missing_columns(header: Sequence[str], units: Mapping[str, str], first: str) -> str:
    """Describe what a header lacks; an empty text if it is complete."""
    if first:
        return "" if header[0] == first and len(header) > 1 else "it is"
    missing = next((name for name in units if name not in header), None)
    return "" if missing is None else f"it has no {missing}:"


def _check_unit(column: str, unit: str | None, required: str) -> None:
    """Refuse a unit in brackets that is not the required one, if both are known."""
    if unit and required and _SAME_UNIT.get(unit, unit) != required:
        raise SceneError(f"{column} must be in {required}; convert it")


def name_and_unit(cell: str) -> tuple[str, str | None]:
    """Split a column's name, such as ``Time [s]``, into the name in lower case and the unit."""
    found = _NAME_AND_UNIT.fullmatch(cell.strip().replace("\n", " "))
    return (found[1].lower(), found[2]) if found else (cell, None)


def _quoted(path: Path, text: str) -> str:
    """Quote the content of a file in a message if its suffix is that of a table.

    A scene of another user may name any file, such as one with a password.
    """
    return repr(text.strip()[:80]) if path.suffix.lower() in TABLE_SUFFIXES else "something else"


def _header_remedy(header: str) -> str:
    """Return a remedy for the first line of a table of another program."""
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
    """Read the rows of a CSV file, each with the number of its first line.

    The separator is a comma, a semicolon or a tab, whichever is most frequent in the first row.
    Empty lines, and lines above the first row that start with ``#``, are skipped. Columns without a
    name and without any cell are removed.

    Raises
    ------
    SceneError
        The file is unreadable, or a quotation mark is not closed.
    """
    lines = read_text(path).split("\n")
    if lines[0].lstrip().startswith("<"):
        raise SceneError(f"{path}: an XML or HTML file; export the table as CSV")
    skipped, separator = _first_row(lines)
    text = "\n".join(lines[skipped:])
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    rows: list[tuple[int, list[str]]] = []
    while True:
        row = skipped + reader.line_num + 1
        try:
            cells = next(reader)
        except StopIteration:
            return _without_empty_columns(rows)
        except csv.Error as problem:
            raise SceneError(
                f"{path}: not a CSV file in row {row} ({problem}); close each quotation mark that"
                " opens a cell, and double those inside"
            ) from None
        if any(cell.strip() for cell in cells):
            rows.append((row, cells))


def _first_row(lines: Sequence[str]) -> tuple[int, str]:
    """Return the index of the first row, and the separator of cells."""
    separator, index = "", 0
    for line in lines:
        if line.startswith("sep=") and len(line) == 5 and line[4] in SEPARATORS:  # from Excel
            separator = line[4]
        elif line.strip(SEPARATORS + " ") and not line.lstrip().startswith("#"):
            break
        index += 1
    names = _QUOTED.sub("", lines[index]) if index < len(lines) else ""
    return index, separator or max(SEPARATORS, key=names.count)


def _without_empty_columns(rows: list[tuple[int, list[str]]]) -> list[tuple[int, list[str]]]:
    """Remove columns at the end that have no name and no cell."""
    if not rows:
        return []
    width = len(rows[0][1])
    while width and not any(cells[width - 1].strip() for _, cells in rows if len(cells) >= width):
        width -= 1
    return [(row, cells[:width] + _not_blank(cells[width:])) for row, cells in rows]


def _not_blank(cells: list[str]) -> list[str]:
    return cells if any(cell.strip() for cell in cells) else []


def cell_number(path: Path, row: int, name: str, cell: str) -> float:
    """Return the finite number in a cell.

    Raises
    ------
    SceneError
        It is not a finite number; the message names file, column and row.
    """
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
    """Refuse columns of unequal length, fewer than two rows, and a `key` that does not increase.

    Parameters
    ----------
    where
        Start of the message: the file name, or empty for arrays of the scene.
    rows
        Number of each entry in messages (default: counted from 1).
    jumps
        Allow two entries with the same key, at which the columns jump.
    """
    start = f"{where}: " if where else ""
    count = len(columns[key])
    for name, column in columns.items():
        if len(column) != count:
            raise SceneError(
                f"{start}{name} has {len(column)} values, {key} has {count}; give the same number"
            )
    if count < 2:
        raise SceneError(f"{start}{key} has {count} point{'s' * (count != 1)}; give at least two")
    for i in range(1, count):
        before, here = columns[key][i - 1], columns[key][i]
        if not here > before and not (
            jumps and here == before and (i == 1 or columns[key][i - 2] < before)
        ):
            row = rows[i] if rows else i + 1
            allowed = "; at most two rows may have the same" if jumps and here == before else ""
            raise SceneError(
                f"{start}{key} must increase; row {row} has {here} after {before}{allowed}"
            )


def take_in_file(
    data: Any,
    info: ValidationInfo,
    key: str,
    units: Mapping[str, str],
    *,
    jumps: bool = False,
    read: Callable[[Path], Table] | None = None,
) -> tuple[Any, Table | None]:
    """Replace the entry ``file`` of a raw section by the columns of that CSV file.

    A relative name starts from the folder of the scene file, which the loader passes as validation
    context.

    Parameters
    ----------
    read
        Function that reads and checks the file (default: `read_table`, then `check_table`).

    Returns
    -------
    data, table
        The section with arrays in place of the file, and the table (None: the section has no file).
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
            f"file = {file!r} and {', '.join(both)} are both given; give only one of them"
        )
    path = Path((info.context or {}).get("folder", ".")) / file
    if read is not None:
        table = read(path)
    else:
        table = read_table(path, units)
        check_table(table.file, key, table.columns, table.rows, jumps=jumps)
    others = {name: value for name, value in data.items() if name != "file"}
    return {**others, **table.columns}, table
