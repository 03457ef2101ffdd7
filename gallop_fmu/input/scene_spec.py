"""What a scene is made from, its ``[line]`` table not yet resolved, so that familiar numbers can be changed too."""

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
from gallop_fmu.scene.dotted_paths import unknown_key
from gallop_fmu.scene.fields import setting, unit_of_field
from gallop_fmu.scene.scene import Scene

LINE = "line."
"""Start of the dotted paths of a line's familiar numbers."""


class SceneWithLine(Scene):
    """Schema that only lists the valid keys of a specification, those of [line] among them."""

    line: Line | None = setting(None, "a line in familiar numbers")


@dataclass(frozen=True)
class SceneSpec:
    """A scene as it was given, and values changed upon it.

    Attributes
    ----------
    data : dict
        Content of a scene file.
    folder : Path
        Where relative names of CSV files start.
    name : str
        What error messages call it; empty for none.
    values : dict
        Dotted path to changed value.
    """

    data: Mapping[str, Any]
    folder: Path = Path()
    name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: Scene | SceneSpec | str | Path) -> SceneSpec:
        """The specification of a scene, of a packaged name or of a path.

        Raises
        ------
        SceneError
            If there is no such scene, or its file cannot be read.
        """
        if isinstance(scene, SceneSpec):
            return scene
        if isinstance(scene, Scene):
            return cls(scene.model_dump(mode="json", exclude_none=True))
        return cls(*read_scene_file(scene))

    @property
    def has_line(self) -> bool:
        """Whether there is a ``[line]`` table whose values can be changed."""
        return "line" in self.data

    def with_values(self, values: Mapping[str, Any]) -> SceneSpec:
        """The same with some more values changed; not looked at before `scene`."""
        return replace(self, values={**self.values, **values})

    def scene(self, values: Mapping[str, Any] | None = None) -> Scene:
        """The scene with its values, and with those given here.

        Values of the line are changed first, and the line resolved; then the others, on what
        follows from it.

        Raises
        ------
        SceneError
            A value is not allowed, or there is no line where one is to be changed.
        """
        every = {**self.values, **(values or {})}
        on_line = {
            key.removeprefix(LINE): value for key, value in every.items() if key.startswith(LINE)
        }
        others = {key: value for key, value in every.items() if not key.startswith(LINE)}
        scene = self._with_line(on_line) if on_line else self._unchanged
        return scene.with_values(others) if others else scene

    def check(self, to_come: Collection[str]) -> None:
        """Refuse at once what no value of the keys to come can mend.

        Raises
        ------
        SceneError
            Values of a line are to come, but there is no line; its table has an unknown key, or
            lacks one that does not come; or without a line, the scene is not allowed as it is.
        """
        on_line = sorted(key for key in to_come if key.startswith(LINE))
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
        """A number that changes with anything in it, and in the files that a line names."""
        if not self.has_line:
            return self.scene().to_toml()
        content = json.dumps([self.data, self.values], sort_keys=True, default=str)
        return content + "".join(
            self.file_fingerprint(name) for name in _file_names([self.data, self.values])
        )

    def file_fingerprint(self, name: Any) -> str:
        """A number that changes with the content of a file; empty if there is none of this name."""
        path = self.folder / str(name)
        return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""

    @cached_property
    def _unchanged(self) -> Scene:
        return scene_of_file(self.data, self.folder, self.name)

    def _with_line(self, values: Mapping[str, Any]) -> Scene:
        line = {**self._line(LINE + next(iter(values))), **values}
        kept = {key: value for key, value in line.items() if value is not None}
        return Scene.from_dict({**self.data, "line": kept}, self.folder)

    def _line(self, wanted: str) -> Mapping[str, Any]:
        if not self.has_line:
            raise SceneError(
                self._named(
                    f"{wanted}: there is no [line] table whose values could be changed; give a"
                    " scene file that has one, by its path (a scene once loaded holds plain"
                    " numbers only)"
                )
            )
        line = self.data["line"]
        if not isinstance(line, Mapping):
            raise SceneError(self._named("line: must be a table"))
        return line

    def _named(self, message: str) -> str:
        return f"{self.name}: {message}" if self.name else message


def unit_of(scene: Scene, key: str) -> str:
    """Unit of the value of a scene, or of its line, at a dotted path; empty for texts and choices.

    Raises
    ------
    SceneError
        No value has this path.
    """
    return (
        unit_of_field(Line.model_fields[key.removeprefix(LINE)])
        if key.startswith(LINE)
        else scene.unit_of(key)
    )


def _file_names(data: Any) -> Iterator[str]:
    """Values at the places where a specification can name a file."""
    if isinstance(data, list):
        for item in data:
            yield from _file_names(item)
    elif isinstance(data, Mapping):
        for key, value in data.items():
            if key in ("file", "coefficients", f"{LINE}coefficients"):
                yield str(value)
            else:
                yield from _file_names(value)
