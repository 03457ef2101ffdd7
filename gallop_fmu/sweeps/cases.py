"""Many scenes from one: values over a grid, and tables of spans in CSV or GeoJSON."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import parse_value, read_cells, read_text
from gallop_fmu.foundation.text_rules import clean_text, plain
from gallop_fmu.input.scene_spec import LINE, SceneSpec, SceneWithLine
from gallop_fmu.scene.dotted_paths import all_keys, takes_text, unknown_key
from gallop_fmu.scene.scene import Scene
from gallop_fmu.sweeps.row_store import as_cell

NAME, SCENE, LABEL = "name", "scene", "label."
"""Columns of a table that are no values of a scene: what the span is called, its scene, and what is carried along."""
GEOMETRY = f"{LABEL}geometry"
"""Column of the geometry of a GeoJSON feature."""
CURVE = f"{LINE}coefficients"
"""Column that may name a file."""
REMOVED = "none"
"""Cell that removes a value of the scene."""
MOST_RUNS = 1_000_000

SpanTable = Path | str | Sequence[Mapping[str, Any]] | Any
"""File, rows in memory, or a data frame of pandas or polars."""


@dataclass(frozen=True)
class Case:
    """One run to come: a scene, what is changed in it, and what its row of results begins with.

    Attributes
    ----------
    run : int
        Number of the run, from 0.
    base : SceneSpec
        The scene before its changes.
    changes : dict
        Dotted path to value.
    labels : dict
        Column to value: name and labels of a span.
    """

    run: int
    base: SceneSpec
    changes: dict[str, Any]
    labels: dict[str, Any]

    def scene(self) -> Scene:
        """The scene to compute.

        Raises
        ------
        SceneError
            If a value is not allowed.
        """
        return self.base.scene(self.changes)

    def columns(self) -> dict[str, Any]:
        """Columns that its row of results begins with; lists and tables as JSON."""
        return {
            "run": self.run,
            **self.labels,
            **{key: as_cell(value) for key, value in self.changes.items()},
        }


@dataclass(frozen=True)
class Cases:
    """All runs of a sweep.

    Attributes
    ----------
    every : tuple of Case
        The runs, the last parameter of the grid changing fastest.
    grid : dict
        Dimension to values: the names of the spans, where there is a table, and each parameter of
        the grid.
    """

    every: tuple[Case, ...]
    grid: dict[str, list[Any]]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns with which the rows of results begin."""
        return tuple(
            dict.fromkeys(
                key for case in self.every for key in ("run", *case.labels, *case.changes)
            )
        )

    def fingerprint(self) -> str:
        """A number that changes with anything in any of the scenes."""
        digest = hashlib.sha256()
        bases: dict[int, str] = {}
        for case in self.every:
            base = bases.get(id(case.base)) or bases.setdefault(
                id(case.base), case.base.fingerprint()
            )
            curve = case.base.file_fingerprint(case.changes.get(CURVE))
            digest.update(
                json.dumps([base, case.changes, case.labels, curve], sort_keys=True).encode()
            )
        return digest.hexdigest()[:16]


def cases(
    scene: Scene | SceneSpec | str | Path | None,
    over: Mapping[str, Sequence[Any]] | None = None,
    table: SpanTable | None = None,
) -> Cases:
    """Every span of a table at every point of a grid.

    Parameters
    ----------
    scene
        The scene, packaged name or path, that the table and the grid change; may be None if each
        row names its own, or all of its line.
    over
        Dotted path to the values it takes; all combinations are computed. ``line.ice_thickness``
        and its like need a scene given by the path of a file with a ``[line]`` table (see
        `gallop_fmu.line.line_table.Line`).
    table
        A CSV file, a GeoJSON file, a data frame of pandas or polars, or rows in memory; see
        `read_spans`.

    Raises
    ------
    SceneError
        Neither grid nor table, an unknown column, a row without a scene, a scene that is not
        allowed, or more than `MOST_RUNS` runs. A value that is not allowed is no error here: it
        concerns one run.
    """
    if over is None and table is None:
        raise SceneError("nothing to vary: give values (over) or a table of spans (table)")
    grid: dict[str, list[Any]] = {}
    for key, points in (over or {}).items():
        _check_key(key)
        grid[key] = [_value(key, point, "over") for point in points]
        if not grid[key]:
            raise SceneError(f"over: {key} has no values")
    rows: Sequence[Mapping[str, Any]] = [{}] if table is None else _rows(table)
    count = len(rows) * math.prod(map(len, grid.values()))
    if count > MOST_RUNS:
        raise SceneError(
            f"{count} runs are asked for; at most {MOST_RUNS} are computed at a time: give fewer"
            " values, or several sweeps"
        )
    folder = Path(table).parent if isinstance(table, (str, Path)) else Path()
    base = None if scene is None else SceneSpec.of(scene)
    loaded: dict[str, SceneSpec] = {}
    varied: dict[int, tuple[SceneSpec, set[str]]] = {}
    found: list[Case] = []
    for number, row in enumerate(rows):
        own = _scene_of(row, number, base, folder, loaded)
        values = {
            key: value
            for key, value in row.items()
            if key not in (NAME, SCENE) and not key.startswith(LABEL)
        }
        both = sorted(values.keys() & grid.keys())
        if both:
            raise SceneError(
                f"{both[0]} is both in the table and in over; it can be in one of them"
            )
        varied.setdefault(id(own), (own, set(grid)))[1].update(values)
        labels = (
            {} if table is None else {key: value for key, value in row.items() if key not in values}
        )
        for point in itertools.product(*grid.values()):
            found.append(
                Case(len(found), own, {**values, **dict(zip(grid, point, strict=True))}, labels)
            )
    for own, keys in varied.values():
        own.check(keys)
    names = {} if table is None else {NAME: [row[NAME] for row in rows]}
    return Cases(tuple(found), {**names, **grid})


def read_spans(path: Path | str) -> list[dict[str, Any]]:
    """The rows of a table of spans.

    A CSV file has names in its first row; a GeoJSON file is a FeatureCollection, and the properties
    of its features are the columns. Columns are dotted paths of a scene (``span.length``) or of its
    line (``line.ice_thickness``, see `gallop_fmu.line.line_table.Line`), ``scene`` (a packaged
    name, or a path that starts from the table's folder), ``name``, and ``label.`` with anything
    behind it, which is carried along to the results. So is the geometry of a feature, as GeoJSON
    text in ``label.geometry``. An empty cell leaves the scene's value, and so does null, and in
    memory None or NaN; ``none`` removes it.

    Names and labels are texts, which come back as they were (in Unicode's normal form C, see
    `gallop_fmu.foundation.text_rules`); labels of another type come back as JSON text.

    Returns
    -------
    list of dict
        Column to value, ``"none"`` for one to remove, as `gallop_fmu.sweep` takes them. Every row
        has a ``name``: its own, the feature's id, or ``row N`` as counted in the file.

    Raises
    ------
    SceneError
        Unreadable file, unknown column, a row of another length, two spans of one name.
    """
    return [
        {key: REMOVED if value is None else value for key, value in row.items()}
        for row in _file_rows(Path(path))
    ]


def _file_rows(path: Path) -> list[dict[str, Any]]:
    suffix = path.suffix.lower()
    if suffix == ".csv":
        rows = _csv_rows(path)
    elif suffix in (".geojson", ".json"):
        rows = _geojson_rows(path)
    else:
        raise SceneError(
            f"{path}: a table of spans is a .csv or a .geojson file; save it as one of them"
        )
    return _checked(rows, str(path))


def _rows(table: SpanTable) -> list[dict[str, Any]]:
    if isinstance(table, (str, Path)):
        return _file_rows(Path(table))
    frame: Any = table
    rows: list[Any] = []
    if hasattr(table, "columns"):  # a data frame of pandas or polars
        if any(name is not None for name in getattr(getattr(frame, "index", None), "names", ())):
            frame = frame.reset_index(
                allow_duplicates=True
            )  # a named index, such as the spans' names, is a column
        twice = [name for name in frame.columns if list(frame.columns).count(name) > 1]
        if twice:
            raise SceneError(f"table: column {twice[0]!r} is there twice")
        rows = frame.to_dicts() if hasattr(frame, "to_dicts") else frame.to_dict("records")
    elif isinstance(frame, Iterable):
        rows = list(frame)
    if not all(isinstance(row, Mapping) for row in rows) or not isinstance(frame, Iterable):
        raise SceneError(
            "table: must be the path of a file, a data frame, or a list of rows that are"
            " dictionaries"
        )
    return _checked(((f"row {number}", row) for number, row in enumerate(rows, start=1)), "table")


def _csv_rows(path: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Default name and cells of each row."""
    header: list[str] | None = None
    for number, cells in read_cells(path):
        if header is None:
            header = [cell.strip() for cell in cells]
            twice = {name for name in header if header.count(name) > 1}
            if twice:
                raise SceneError(f"{path}: column {min(twice)!r} is there twice")
            continue
        if len(cells) != len(header):
            raise SceneError(
                f"{path}: row {number} has {len(cells)} cells, the first row has {len(header)}"
            )
        yield f"row {number}", {key: cell for key, cell in zip(header, cells, strict=True) if cell}


def _geojson_rows(path: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Default name and properties of each feature."""
    try:
        data = json.loads(read_text(path), object_pairs_hook=_without_repetition)
        if data["type"] != "FeatureCollection":
            raise KeyError(data["type"])
        every = [
            (feature.get("id"), feature.get("geometry"), dict(feature["properties"]))
            for feature in data["features"]
        ]
    except (ValueError, RecursionError) as problem:
        if isinstance(problem, SceneError):
            raise
        raise SceneError(f"{path}: not a GeoJSON file ({problem})") from None
    except (TypeError, KeyError, AttributeError):
        raise SceneError(
            f"{path}: not a GeoJSON FeatureCollection whose features have properties"
        ) from None
    for number, (identity, geometry, properties) in enumerate(every, start=1):
        name = f"feature {number}" if identity is None else as_label(identity)
        yield name, {GEOMETRY: geometry, **properties}


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"{max(keys, key=keys.count)!r} is there twice in one object")
    return found


def _checked(rows: Iterable[tuple[str, Mapping[str, Any]]], where: str) -> list[dict[str, Any]]:
    """Rows with known columns, typed values and a name of their own each."""
    found: list[dict[str, Any]] = []
    spelled: dict[Any, str] = {}
    seen: dict[str, int] = {}
    for number, (default, given) in enumerate(rows, start=1):
        row = {NAME: default}
        taken: set[str] = set()
        for column, value in given.items():
            if column not in spelled:
                spelled[column] = _column(column, where)
            key = spelled[column]
            if key in taken:
                raise SceneError(f"{where}: column {key!r} is there twice")
            taken.add(key)
            if not _is_missing(key, value):
                row[key] = _value(key, value, f"{where}: span {number}")
        if row[NAME] in seen:
            raise SceneError(
                f"{where}: spans {seen[row[NAME]]} and {number} are both called {row[NAME]!r}"
            )
        seen[row[NAME]] = number
        found.append(row)
    if not found:
        raise SceneError(f"{where}: has no spans")
    return found


def _column(column: Any, where: str) -> str:
    """A column as the program spells it: keys of scenes are in lower case, labels as they are."""
    if not isinstance(column, str):
        raise SceneError(f"{where}: column {column!r} is no text")
    try:
        key = clean_text(column)
    except SceneError as problem:
        raise SceneError(f"{where}: column {problem}") from None
    if key.lower().startswith(LABEL):
        return LABEL + key[len(LABEL) :]
    key = key.lower()
    if key not in (NAME, SCENE):
        try:
            _check_key(key)
        except SceneError as problem:
            raise SceneError(
                f"{where}: {problem}; what is only to be carried along must be called {LABEL}{key}"
            ) from None
    return key


def _value(key: str, value: Any, where: str) -> Any:
    """A cell as its column means it: a label, a name, or a value of the scene."""
    try:
        if key == NAME or key.startswith(LABEL):
            return as_label(value)
        if isinstance(value, str):
            return parse_value(value, as_text=key == SCENE or takes_text(SceneWithLine, key))
        return plain(value)
    except SceneError as problem:
        raise SceneError(f"{where}: {key}: {problem}") from None


def as_label(value: Any) -> str:
    """A label: texts and dates as they are, anything else as JSON."""
    if isinstance(value, str):
        return clean_text(value)
    value = value.item() if hasattr(value, "item") else value
    try:
        return clean_text(json.dumps(value, ensure_ascii=False))
    except TypeError:
        return clean_text(str(value))
    except (ValueError, RecursionError) as problem:
        raise SceneError(f"cannot be written as text ({problem})") from None


def _is_missing(key: str, value: Any) -> bool:
    """Whether a cell is empty: blank, None, NaN, or a missing value of pandas."""
    if isinstance(value, str):
        return not (value if key.startswith(LABEL) else value.strip())
    if value is None or type(value).__name__ in ("NAType", "NaTType"):
        return True
    return isinstance(value, float) and math.isnan(value)


def _check_key(key: str) -> None:
    """Refuse what no scene has; items of lists are known by their number."""
    pattern = re.sub(r"\.\d+(?=\.)", ".0", key)
    if re.sub(r"(\.\d+)+$", "", pattern) not in _keys():
        raise SceneError(unknown_key(SceneWithLine, key))


@cache
def _keys() -> frozenset[str]:
    return frozenset(all_keys(SceneWithLine)) - {
        LINE.rstrip(".")
    }  # a line is changed value by value


def _scene_of(
    row: Mapping[str, Any],
    number: int,
    base: SceneSpec | None,
    folder: Path,
    loaded: dict[str, SceneSpec],
) -> SceneSpec:
    name = row.get(SCENE)
    if name is not None and not isinstance(name, str):
        raise SceneError(
            f"span {row[NAME]!r}: scene = {name!r}: must be a packaged name, or the path of a scene"
            " file"
        )
    if name is None and base is None and any(key.startswith(LINE) for key in row):
        return loaded.setdefault("", SceneSpec({"line": {}}, folder))
    if name is None:
        if base is None:
            raise SceneError(
                f"span {row.get(NAME, number)!r} has no scene: give one for all, or a column"
                f" {SCENE} with a packaged name or a path"
            )
        return base
    if name not in loaded:
        beside = folder / name
        loaded[name] = SceneSpec.of(beside if beside.is_file() else name)
    return loaded[name]
