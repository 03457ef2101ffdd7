"""Many scenes from one: values over a grid, and tables of spans in CSV or GeoJSON."""

from __future__ import annotations

import hashlib
import itertools
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from gallop_fmu.descriptions import LINE, Describable, Description
from gallop_fmu.errors import SceneError
from gallop_fmu.paths import all_keys, unknown_key
from gallop_fmu.scene import Scene
from gallop_fmu.store import as_cell
from gallop_fmu.textfiles import read_cells, read_text, read_value

NAME, SCENE, LABEL = "name", "scene", "label."
"""Columns of a table that are no values of a scene: what the span is called, its scene, and what is carried along."""
GEOMETRY = f"{LABEL}geometry"
"""Column of the geometry of a GeoJSON feature."""
CURVE = f"{LINE}coefficients"
"""Column that may name a file."""


@dataclass(frozen=True)
class Case:
    """One run to come: a scene, what is changed in it, and what its row of results begins with.

    Attributes
    ----------
    run : int
        Number of the run, from 0.
    base : Description
        The scene before its changes.
    changes : dict
        Dotted path to value.
    labels : dict
        Column to value: name and labels of a span.
    """

    run: int
    base: Description
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
        return {"run": self.run, **self.labels, **{key: as_cell(value) for key, value in self.changes.items()}}


@dataclass(frozen=True)
class Cases:
    """All runs of a sweep.

    Attributes
    ----------
    every : tuple of Case
        The runs, the last parameter of the grid changing fastest.
    grid : dict
        Dimension to values: the names of the spans, where there is a table, and each parameter of the grid.
    """

    every: tuple[Case, ...]
    grid: dict[str, list[Any]]

    def fingerprint(self) -> str:
        """A number that changes with anything in any of the scenes."""
        digest = hashlib.sha256()
        bases: dict[int, str] = {}
        for case in self.every:
            base = bases.get(id(case.base)) or bases.setdefault(id(case.base), case.base.fingerprint())
            curve = case.base.file_fingerprint(case.changes.get(CURVE))
            digest.update(json.dumps([base, case.changes, case.labels, curve], sort_keys=True).encode())
        return digest.hexdigest()[:16]


def cases(
    scene: Scene | Description | str | Path | None,
    over: Mapping[str, Sequence[Any]] | None = None,
    table: Path | str | Sequence[Mapping[str, Any]] | None = None,
) -> Cases:
    """Every span of a table at every point of a grid.

    Parameters
    ----------
    scene
        The scene, packaged name or path, that the table and the grid change; may be None if each row names its own, or
        all of its line.
    over
        Dotted path to the values it takes; all combinations are computed. ``line.ice_thickness`` and its like need a
        scene given by the path of a file with a ``[line]`` table (see `gallop_fmu.lines.Line`).
    table
        A CSV file, a GeoJSON file, or rows in memory; see `read_spans`.

    Raises
    ------
    SceneError
        Neither grid nor table, an unknown column, a row without a scene, or a scene that is not allowed. A value that
        is not allowed is no error here: it concerns one run.
    """
    if over is None and table is None:
        raise SceneError("nothing to vary: give values (over) or a table of spans (table)")
    grid = {key: [_plain(value) for value in values] for key, values in (over or {}).items()}
    for key, points in grid.items():
        _check_key(key)
        if not points:
            raise SceneError(f"over: {key} has no values")
    rows: Sequence[Mapping[str, Any]] = [{}] if table is None else _rows(table)
    folder = Path(table).parent if isinstance(table, (str, Path)) else Path()
    base = None if scene is None else Description.of(scene)
    loaded: dict[str, Description] = {}
    varied: dict[int, tuple[Description, set[str]]] = {}
    found: list[Case] = []
    for number, row in enumerate(rows):
        own = _scene_of(row, number, base, folder, loaded)
        values = {key: value for key, value in row.items() if key not in (NAME, SCENE) and not key.startswith(LABEL)}
        both = sorted(values.keys() & grid.keys())
        if both:
            raise SceneError(f"{both[0]} is both in the table and in over; it can be in one of them")
        varied.setdefault(id(own), (own, set(grid)))[1].update(values)
        labels = {} if table is None else {key: value for key, value in row.items() if key not in values}
        for point in itertools.product(*grid.values()):
            found.append(Case(len(found), own, {**values, **dict(zip(grid, point, strict=True))}, labels))
    for own, keys in varied.values():
        own.check(keys)
    names = {} if table is None else {NAME: [row[NAME] for row in rows]}
    return Cases(tuple(found), {**names, **grid})


def read_spans(path: Path | str) -> list[dict[str, Any]]:
    """The rows of a table of spans.

    A CSV file has names in its first row; a GeoJSON file is a FeatureCollection, and the properties of its features
    are the columns. Columns are dotted paths of a scene (``span.length``) or of its line (``line.ice_thickness``, see
    `gallop_fmu.lines.Line`), ``scene`` (a packaged name, or a path that starts from the table's folder), ``name``, and
    ``label.`` with anything behind it, which is carried along to the results. So is the geometry of a feature, as
    GeoJSON text in ``label.geometry``. An empty cell, or null, leaves the scene's value; ``none`` removes it.

    Returns
    -------
    list of dict
        Column to value. Every row has a ``name``: its own, the feature's id, or ``row N`` as counted in the file.

    Raises
    ------
    SceneError
        Unreadable file, unknown column, a row of another length, two spans of one name.
    """
    path = Path(path)
    if path.suffix == ".csv":
        rows = list(_csv_rows(path))
    elif path.suffix in (".geojson", ".json"):
        rows = list(_geojson_rows(path))
    else:
        raise SceneError(f"{path}: a table of spans is a .csv or a .geojson file")
    return _checked(rows, str(path))


def _rows(table: Path | str | Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    if isinstance(table, (str, Path)):
        return read_spans(table)
    rows = [{key: _plain(value) for key, value in row.items()} for row in table]
    return _checked([{NAME: f"row {number}", **row} for number, row in enumerate(rows, start=1)], "table")


def _csv_rows(path: Path) -> Iterator[dict[str, Any]]:
    header: list[str] | None = None
    for number, cells in read_cells(path):
        if header is None:
            header = cells
            twice = {name for name in header if header.count(name) > 1}
            if twice:
                raise SceneError(f"{path}: column {min(twice)!r} is there twice")
            continue
        if len(cells) != len(header):
            raise SceneError(f"{path}: row {number} has {len(cells)} cells, the first row has {len(header)}")
        filled = {key: cell for key, cell in zip(header, cells, strict=True) if cell}
        texts = {key: cell for key, cell in filled.items() if key in (NAME, SCENE)}
        yield {NAME: f"row {number}", **{key: read_value(cell) for key, cell in filled.items()}, **texts}


def _geojson_rows(path: Path) -> Iterator[dict[str, Any]]:
    try:
        data = json.loads(read_text(path))
        if data["type"] != "FeatureCollection":
            raise KeyError(data["type"])
        every = [
            (feature.get("id"), feature.get("geometry"), dict(feature["properties"])) for feature in data["features"]
        ]
    except (ValueError, RecursionError) as problem:
        if isinstance(problem, SceneError):
            raise
        raise SceneError(f"{path}: not a GeoJSON file ({problem})") from None
    except (TypeError, KeyError, AttributeError):
        raise SceneError(f"{path}: not a GeoJSON FeatureCollection whose features have properties") from None
    for number, (identity, geometry, properties) in enumerate(every, start=1):
        name = f"feature {number}" if identity is None else str(identity)
        place = {} if geometry is None else {GEOMETRY: json.dumps(geometry)}
        given = {key: value for key, value in properties.items() if value is not None}
        yield {NAME: name, **place, **{key: None if value == "none" else value for key, value in given.items()}}


def _checked(rows: list[dict[str, Any]], where: str) -> list[dict[str, Any]]:
    if not rows:
        raise SceneError(f"{where}: has no spans")
    for key in dict.fromkeys(key for row in rows for key in row):
        if key not in (NAME, SCENE) and not key.startswith(LABEL):
            try:
                _check_key(key)
            except SceneError as problem:
                raise SceneError(
                    f"{where}: {problem}; what is only to be carried along must be called {LABEL}{key}"
                ) from None
    seen: dict[str, int] = {}
    for number, row in enumerate(rows, start=1):
        row[NAME] = str(row[NAME])
        if row[NAME] in seen:
            raise SceneError(f"{where}: spans {seen[row[NAME]]} and {number} are both called {row[NAME]!r}")
        seen[row[NAME]] = number
    return rows


def _check_key(key: str) -> None:
    """Refuse what no scene has; items of lists are known by their number."""
    pattern = re.sub(r"\.\d+(?=\.)", ".0", key)
    if re.sub(r"(\.\d+)+$", "", pattern) not in _keys():
        raise SceneError(unknown_key(Describable, key))


@cache
def _keys() -> frozenset[str]:
    return frozenset(all_keys(Describable)) - {LINE.rstrip(".")}  # a line is changed value by value


def _scene_of(
    row: Mapping[str, Any], number: int, base: Description | None, folder: Path, loaded: dict[str, Description]
) -> Description:
    name = row.get(SCENE)
    if name is None and base is None and any(key.startswith(LINE) for key in row):
        return loaded.setdefault("", Description({"line": {}}, folder))
    if name is None:
        if base is None:
            raise SceneError(
                f"span {row.get(NAME, number)!r} has no scene: give one for all, or a column {SCENE} with a packaged "
                "name or a path"
            )
        return base
    if name not in loaded:
        beside = folder / str(name)
        loaded[name] = Description.of(beside if beside.is_file() else str(name))
    return loaded[name]


def _plain(value: Any) -> Any:
    """Numbers and arrays of NumPy as Python's own."""
    value = value.tolist() if hasattr(value, "tolist") else value
    return list(value) if isinstance(value, tuple) else value
