"""Specification of a scene with an unresolved ``[line]``, so that line data can be changed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.input.scene_files import read_scene_file, scene_of_file
from gallop_fmu.line.line_table import Line
from gallop_fmu.scene.dotted_paths import is_key, takes_text, unknown_key
from gallop_fmu.scene.fields import setting, unit_of_field
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.scene_base import SceneBase

LINE = "line."
"""Start of the dotted paths of line data."""


class SceneWithLine(Scene):
    """Schema used only to list the valid keys, including those of [line]."""

    line: Line | None = setting(None, "line data")


def is_text_key(key: str) -> bool:
    """Check that a dotted path is that of a text or a choice, in a scene of any kind."""
    return takes_text(SceneWithLine, key) or takes_text(LineScene, key)


@dataclass(frozen=True)
class SceneSpec:
    """The content of a scene file, and values to change.

    Attributes
    ----------
    data : dict
        Content of a scene file.
    folder : Path
        Folder of relative names of CSV files.
    name : str
        Name for messages; may be empty.
    values : dict
        Dotted path to new value.
    """

    data: Mapping[str, Any]
    folder: Path = Path()
    name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene | LineScene | SceneSpec | str | Path) -> SceneSpec:
        """Return the specification of a scene, a packaged name or a path.

        Raises
        ------
        SceneError
            The scene does not exist, or its file cannot be read.
        """
        if isinstance(scene, SceneSpec):
            return scene
        if isinstance(scene, SceneBase):
            return cls(scene.model_dump(mode="json", exclude_none=True))
        return cls(*read_scene_file(scene))

    @property
    def has_line(self) -> bool:
        """True if there is a ``[line]`` table."""
        return "line" in self.data

    @property
    def is_section(self) -> bool:
        """True if there is a ``[section]`` table: the scene is a line."""
        return "section" in self.data

    def with_values(self, values: Mapping[str, Any]) -> SceneSpec:
        """Return a copy with more values to change; `scene` checks them."""
        return replace(self, values={**self.values, **values})

    def scene(self, values: Mapping[str, Any] | None = None) -> Scene | LineScene:
        """Return the scene with the changed values and those given here.

        Values of the line are changed first and the line is resolved, then the other values are
        changed.

        Raises
        ------
        SceneError
            A value is not allowed, or a value of a missing line is changed.
        """
        changes = {**self.values, **(values or {})}
        on_line = {
            key.removeprefix(LINE): value for key, value in changes.items() if key.startswith(LINE)
        }
        others = {key: value for key, value in changes.items() if not key.startswith(LINE)}
        scene = self._with_line(on_line) if on_line else self._unchanged
        return scene.with_values(others) if others else scene

    def check(self, varied: Collection[str]) -> None:
        """Fail early on errors that later values of the varied keys cannot fix.

        Raises
        ------
        SceneError
            No scene of this kind has a varied key; it needs a line and there is none; the line has
            an unknown key or lacks a required one; or, if no value of a line is varied, the scene
            is invalid.
        """
        root = LineScene if self.is_section else SceneWithLine
        for key in varied:
            if not is_key(root, key):
                raise SceneError(self._named(_of_other_kind(root, key)))
        on_line = sorted(key for key in varied if key.startswith(LINE))
        if not on_line:
            self.scene()
            return
        line = self._line(on_line[0])
        for key in line:
            if key not in Line.model_fields:
                raise SceneError(self._named(unknown_key(SceneWithLine, LINE + key)))
        given = {*line, *(key.removeprefix(LINE) for key in (*self.values, *on_line))}
        for name, about in Line.model_fields.items():
            if about.is_required() and name not in given:
                raise SceneError(
                    self._named(
                        f"{LINE}{name}: missing; {about.description}; give it in the scene's"
                        f" [line], or as a column {LINE}{name} of the table"
                    )
                )

    def fingerprint(self) -> str:
        """Return a text that identifies the specification and the files that its line refers to."""
        if not self.has_line:
            return self.scene().to_toml()
        content = json.dumps([self.data, self.values], sort_keys=True, default=str)
        return content + "".join(
            self.file_fingerprint(name) for name in _file_names([self.data, self.values])
        )

    def file_fingerprint(self, name: Any) -> str:
        """Return the hash of a file; empty if it does not exist."""
        path = self.folder / str(name)
        return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""

    @cached_property
    def _unchanged(self) -> Scene | LineScene:
        return scene_of_file(self.data, self.folder, self.name)

    def _with_line(self, values: Mapping[str, Any]) -> Scene:
        line = {**self._line(LINE + next(iter(values))), **values}
        kept = {key: value for key, value in line.items() if value is not None}
        return Scene.from_dict({**self.data, "line": kept}, self.folder)

    def _line(self, wanted: str) -> Mapping[str, Any]:
        if not self.has_line:
            raise SceneError(
                self._named(
                    f"{wanted}: the scene has no [line] table; give the path of a scene file with"
                    " one (a loaded scene no longer has its [line])"
                )
            )
        line = self.data["line"]
        if not isinstance(line, Mapping):
            raise SceneError(self._named("line: must be a table"))
        return line

    def _named(self, message: str) -> str:
        return f"{self.name}: {message}" if self.name else message


def _of_other_kind(root: type[SceneBase], key: str) -> str:
    """Return a message for a key that only scenes of the other kind have."""
    start = key.partition(".")[0]
    if start in root.model_fields:
        return unknown_key(root, key)
    has, has_not = ("[section]", "[span]") if root is LineScene else ("[span]", "[section]")
    return (
        f"{key}: the scene has {has}, and {start} belongs to scenes with {has_not}; give a value"
        " of this scene"
    )


def unit_of(scene: SceneBase, key: str) -> str:
    """Return the unit of a value of a scene or its line; empty for texts and choices.

    Raises
    ------
    SceneError
        The path does not exist.
    """
    return (
        unit_of_field(Line.model_fields[key.removeprefix(LINE)])
        if key.startswith(LINE)
        else scene.unit_of(key)
    )


def _file_names(data: Any) -> Iterator[str]:
    """Yield the names of files in a specification."""
    if isinstance(data, list):
        for item in data:
            yield from _file_names(item)
    elif isinstance(data, Mapping):
        for key, value in data.items():
            if key in ("file", "coefficients", f"{LINE}coefficients"):
                yield str(value)
            else:
                yield from _file_names(value)
