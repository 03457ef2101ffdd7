"""Cases of a sweep: values over a grid, and tables of spans in CSV or GeoJSON."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import parse_value, read_cells, read_text
from gallop_fmu.foundation.text_rules import clean_text, plain
from gallop_fmu.input.scene_spec import LINE, SceneSpec, SceneWithLine, is_text_key
from gallop_fmu.scene.dotted_paths import is_key, unknown_key
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.sweeps.rows import as_cell

NAME, SCENE, LABEL = "name", "scene", "label."
"""Columns that are not values of a scene: name of the span, its scene, and labels."""
GEOMETRY = f"{LABEL}geometry"
"""Column of the geometry of a GeoJSON feature."""
CURVE = f"{LINE}coefficients"
"""Column of the coefficient curve, which may be a file."""
REMOVED = "none"
"""Cell that removes a value of the scene."""
MAX_RUNS = 1_000_000

AnyScene = Scene | LineScene | SceneSpec | str | Path
"""Scene of a span or line, packaged name or path."""

SpanTable = Path | str | Sequence[Mapping[str, Any]] | Any
"""File, folder of scene files, rows in memory, or a data frame of pandas or polars."""


@dataclass(frozen=True)
class Case:
    """One run: a scene, the values changed in it, and labels of its row of results.

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

    def scene(self) -> Scene | LineScene:
        """Return the scene to compute.

        Raises
        ------
        SceneError
            A value is not allowed.
        """
        return self.base.scene(self.changes)

    def columns(self) -> dict[str, Any]:
        """Return the first columns of the row of results; lists and tables as JSON."""
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
        The runs; the last parameter of the grid changes fastest.
    grid : dict
        Dimension to values: the names of the spans of a table, and each parameter of the grid.
    """

    every: tuple[Case, ...]
    grid: dict[str, list[Any]]

    @property
    def bases(self) -> list[SceneSpec]:
        """The scenes before their changes, each once."""
        return list({id(case.base): case.base for case in self.every}.values())

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the first columns of the rows of results."""
        return tuple(
            dict.fromkeys(
                key for case in self.every for key in ("run", *case.labels, *case.changes)
            )
        )

    def fingerprint(self) -> str:
        """Return a hash of all scenes and labels, and of the files they refer to."""
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
    scene: AnyScene | None,
    over: Mapping[str, Sequence[Any]] | None = None,
    table: SpanTable | None = None,
) -> Cases:
    """Return every span of a table at every point of a grid.

    Parameters
    ----------
    scene
        Scene, packaged name or path that the table and the grid change; may be None if each row
        names its own, or gives all values of its line.
    over
        Dotted path to values; all combinations are computed. Line data such as
        ``line.ice_thickness`` need the path of a scene file with a ``[line]`` table (see
        `gallop_fmu.line.line_table.Line`).
    table
        A CSV file, a GeoJSON file, a folder of scene files, a data frame of pandas or polars, or
        rows in memory; see `read_spans`.

    Raises
    ------
    SceneError
        No grid and no table, an unknown column, a row without a scene, an invalid scene, or more
        than `MAX_RUNS` runs. An invalid value is not an error here: it concerns one run.
    """
    if over is None and table is None:
        raise SceneError("nothing to vary: give values (over) or a table of spans (table)")
    grid = _grid(over or {})
    rows: Sequence[Mapping[str, Any]] = [{}] if table is None else _rows(table)
    count = len(rows) * math.prod(map(len, grid.values()))
    if count > MAX_RUNS:
        raise SceneError(
            f"{count} runs are more than {MAX_RUNS}, the most of one sweep; give fewer values, or"
            " use several sweeps"
        )
    scenes = _Scenes(scene, _folder_of(table))
    found: list[Case] = []
    for number, row in enumerate(rows):
        base, (labels, values) = scenes.of_row(row, number), _labels_and_values(row)
        if twice := sorted(values.keys() & grid.keys()):
            raise SceneError(f"{twice[0]}: given in the table and in over; give it in one of them")
        scenes.will_vary(base, {*values, *grid})
        for point in itertools.product(*grid.values()):
            changes = {**values, **dict(zip(grid, point, strict=True))}
            found.append(Case(len(found), base, changes, labels))
    scenes.check()
    names = {} if table is None else {NAME: [row[NAME] for row in rows]}
    return Cases(tuple(found), {**names, **grid})


def _grid(over: Mapping[str, Sequence[Any]]) -> dict[str, list[Any]]:
    """Validate the keys and values of a grid."""
    grid: dict[str, list[Any]] = {}
    for key, points in over.items():
        _check_key(key)
        grid[key] = [_value(key, point, "over") for point in points]
        if not grid[key]:
            raise SceneError(f"over: {key} has no values; give at least one")
    return grid


def _labels_and_values(row: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Split a row into columns that are copied to the results, and values of the scene."""
    labels = {key: row[key] for key in row if key in (NAME, SCENE) or key.startswith(LABEL)}
    return labels, {key: value for key, value in row.items() if key not in labels}


class _Scenes:
    """Scenes of the rows of a table, each file read once.

    Parameters
    ----------
    scene
        Scene of rows that name none.
    folder
        Where relative paths start.
    """

    def __init__(self, scene: AnyScene | None, folder: Path) -> None:
        self._base = None if scene is None else SceneSpec.of(scene)
        self._folder = folder
        self._loaded: dict[str, SceneSpec] = {}
        self._varied: dict[int, tuple[SceneSpec, set[str]]] = {}

    def of_row(self, row: Mapping[str, Any], number: int) -> SceneSpec:
        """Return the scene that a row names, or the scene of the table."""
        name = row.get(SCENE)
        if isinstance(name, str):
            return self._load(name)
        if name is not None:
            raise SceneError(
                f"span {row[NAME]!r}: scene = {name!r}: must be a packaged name, or the path of a"
                " scene file"
            )
        if self._base is not None:
            return self._base
        if any(key.startswith(LINE) for key in row):
            return self._loaded.setdefault("", SceneSpec({"line": {}}, self._folder))
        raise SceneError(
            f"span {row.get(NAME, number)!r} has no scene: give one for all, or a column"
            f" {SCENE} with a packaged name or a path"
        )

    def will_vary(self, base: SceneSpec, keys: set[str]) -> None:
        """Note the keys that are changed in a scene."""
        self._varied.setdefault(id(base), (base, set()))[1].update(keys)

    def check(self) -> None:
        """Refuse scenes that are invalid for all values of the changed keys."""
        for base, keys in self._varied.values():
            base.check(keys)

    def _load(self, name: str) -> SceneSpec:
        if name not in self._loaded:
            path = self._folder / name
            self._loaded[name] = SceneSpec.of(path if path.is_file() else name)
        return self._loaded[name]


def read_spans(path: Path | str) -> list[dict[str, Any]]:
    """Read a table of spans.

    A CSV file has names in its first row. A GeoJSON file is a FeatureCollection; the properties of
    its features are the columns. Columns are dotted paths of a scene (``span.length``) or of its
    line (``line.ice_thickness``, see `gallop_fmu.line.line_table.Line`), ``scene`` (a packaged
    name, or a path relative to the table's folder), ``name``, and ``label.ANYTHING``, which is
    copied to the results. So is the geometry of a feature, as GeoJSON text in ``label.geometry``.
    An empty cell or null keeps the scene's value, in memory also None or NaN; ``none`` removes it.

    A folder has a row for each scene file (``.toml``) in it, with the name of the file.

    Names and labels are texts in Unicode's normal form C, see `gallop_fmu.foundation.text_rules`;
    labels of another type are converted to JSON text.

    Returns
    -------
    list of dict
        Column to value, ``"none"`` for one to remove, as `gallop_fmu.sweep` takes them. Every row
        has a ``name``: its own, the feature's id, or ``row N`` of the file.

    Raises
    ------
    SceneError
        The file is unreadable, a column unknown, a row too short or long, or a name used twice.
    """
    return [
        {key: REMOVED if value is None else value for key, value in row.items()}
        for row in _file_rows(Path(path))
    ]


def spans_of(table: SpanTable) -> list[dict[str, Any]]:
    """Return the checked rows of a table of spans, as `gallop_fmu.sweep` takes them.

    Relative paths of scenes are those from the table's folder.

    Raises
    ------
    SceneError
        As for `read_spans`.
    """
    folder = _folder_of(table)
    rows = [
        {key: REMOVED if value is None else value for key, value in row.items()}
        for row in _rows(table)
    ]
    for row in rows:
        name = row.get(SCENE)
        if isinstance(name, str) and (folder / name).is_file():
            row[SCENE] = str(folder / name)
    return rows


def _folder_of(table: SpanTable | None) -> Path:
    """Folder where the relative paths of a table start."""
    if not isinstance(table, (str, Path)):
        return Path()
    path = Path(table)
    return path if path.is_dir() else path.parent


def _file_rows(path: Path) -> list[dict[str, Any]]:
    if path.is_dir():
        return _checked(_scene_files(path), str(path))
    suffix = path.suffix.lower()
    if suffix == ".csv":
        rows = _csv_rows(path)
    elif suffix in (".geojson", ".json"):
        rows = _geojson_rows(path)
    else:
        raise SceneError(
            f"{path}: a table of spans is a .csv or a .geojson file, or a folder of scene files;"
            " give one of them"
        )
    return _checked(rows, str(path))


def _rows(table: SpanTable) -> list[dict[str, Any]]:
    if isinstance(table, (str, Path)):
        return _file_rows(Path(table))
    frame: Any = table
    rows: list[Any] = []
    if hasattr(table, "columns"):  # a data frame of pandas or polars
        if any(name is not None for name in getattr(getattr(frame, "index", None), "names", ())):
            frame = frame.reset_index(allow_duplicates=True)  # a named index is a column
        twice = [name for name in frame.columns if list(frame.columns).count(name) > 1]
        if twice:
            raise SceneError(f"table: column {twice[0]!r} is given twice; remove one of them")
        rows = frame.to_dicts() if hasattr(frame, "to_dicts") else frame.to_dict("records")
    elif isinstance(frame, Iterable):
        rows = list(frame)
    if not all(isinstance(row, Mapping) for row in rows) or not isinstance(frame, Iterable):
        raise SceneError(
            "table: must be the path of a file, a data frame, or a list of rows that are"
            " dictionaries"
        )
    return _checked(((f"row {number}", row) for number, row in enumerate(rows, start=1)), "table")


def _scene_files(folder: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the name and the row of each scene file of a folder, in alphabetical order."""
    files = sorted(folder.glob("*.toml"))
    if not files:
        raise SceneError(f"{folder}: contains no scene file (.toml); give a folder that does")
    for file in files:
        yield file.stem, {SCENE: file.name}


def _csv_rows(path: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the default name and the cells of each row."""
    header: list[str] | None = None
    for number, cells in read_cells(path):
        if header is None:
            header = [cell.strip() for cell in cells]
            twice = {name for name in header if header.count(name) > 1}
            if twice:
                raise SceneError(
                    f"{path}: column {min(twice)!r} is given twice; remove one of them"
                )
            continue
        if len(cells) != len(header):
            raise SceneError(
                f"{path}: row {number} has {len(cells)} cells, the first row has {len(header)};"
                " give one cell for each column"
            )
        yield f"row {number}", {key: cell for key, cell in zip(header, cells, strict=True) if cell}


def _geojson_rows(path: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the default name and the properties of each feature."""
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
        raise SceneError(f"{path}: not a GeoJSON file ({problem}); export it again") from None
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
        raise ValueError(f"{max(keys, key=keys.count)!r} is given twice in one object")
    return found


def _checked(rows: Iterable[tuple[str, Mapping[str, Any]]], where: str) -> list[dict[str, Any]]:
    """Return rows with known columns, typed values and unique names."""
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
                raise SceneError(f"{where}: column {key!r} is given twice; remove one of them")
            taken.add(key)
            if not _is_missing(key, value):
                row[key] = _value(key, value, f"{where}: span {number}")
        if row[NAME] in seen:
            raise SceneError(
                f"{where}: spans {seen[row[NAME]]} and {number} have the same name {row[NAME]!r};"
                " rename one of them"
            )
        seen[row[NAME]] = number
        found.append(row)
    if not found:
        raise SceneError(f"{where}: has no spans; add a row")
    return found


def _column(column: Any, where: str) -> str:
    """Return the name of a column; keys of scenes in lower case, labels unchanged."""
    if not isinstance(column, str):
        raise SceneError(f"{where}: the name of column {column!r} is not a text")
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
                f"{where}: {problem}; a column that is only copied to the results must be called"
                f" {LABEL}{key}"
            ) from None
    return key


def _value(key: str, value: Any, where: str) -> Any:
    """Return the value of a cell: a label, a name, or a value of the scene."""
    try:
        if key == NAME or key.startswith(LABEL):
            return as_label(value)
        if isinstance(value, str):
            return parse_value(value, as_text=key == SCENE or is_text_key(key))
        return plain(value)
    except SceneError as problem:
        raise SceneError(f"{where}: {key}: {problem}") from None


def as_label(value: Any) -> str:
    """Return a value as a label: texts and dates unchanged, others as JSON."""
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
    """Check that a cell is empty: blank, None, NaN, or a missing value of pandas."""
    if isinstance(value, str):
        return not (value if key.startswith(LABEL) else value.strip())
    if value is None or type(value).__name__ in ("NAType", "NaTType"):
        return True
    return isinstance(value, float) and math.isnan(value)


def _check_key(key: str) -> None:
    """Refuse a key that no scene has."""
    # Only single values of a line can be changed, not the line as a whole.
    if key == LINE.rstrip(".") or not any(is_key(root, key) for root in (SceneWithLine, LineScene)):
        start = key.partition(".")[0]
        is_of_line = start in LineScene.model_fields and start not in SceneWithLine.model_fields
        raise SceneError(unknown_key(LineScene if is_of_line else SceneWithLine, key))
