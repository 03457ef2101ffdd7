"""What the scene of one span and the scene of a line share: text, files, changed values, warnings.

Lengths in m, forces in N, times in s; angles in degrees where the name ends in ``_deg``. Axes: x1
along the span, x2 up, x3 across the span in the direction of the wind.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

import tomli_w
from pydantic import Field, ValidationError, field_validator, model_validator

from gallop_fmu.foundation.atomic_write import write_whole
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.dotted_paths import (
    Leaf,
    has_path,
    leaves,
    replace_values,
    unknown_key,
    with_number,
)
from gallop_fmu.scene.fields import Section, Text, setting
from gallop_fmu.scene.file_format import FORMAT, without_format
from gallop_fmu.scene.html_table import scene_table
from gallop_fmu.scene.plausibility import unusual
from gallop_fmu.scene.validation_messages import explain

_ICE_MOMENT = re.compile(r"((?:.*\.)?ice)\.first_moment_x[23]")


class SceneBase(Section):
    """A scene: its title, its values with their sources, and how it is read, changed and saved.

    A subclass declares its tables and ``sources``, in the order in which files have them.
    """

    title: Text = setting(..., "title, one line")
    description: Text = setting("", "purpose, assumptions and gaps")
    notes: Annotated[tuple[Text, ...], Field(strict=False)] = setting(
        (), "warnings about the line data of the scene"
    )
    if TYPE_CHECKING:
        sources: dict[Text, Text] = {}

    @classmethod
    def _tables(cls, data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
        """Return the data of the tables to validate; refuse those of another kind of scene."""
        return data

    def _check(self) -> None:
        """Refuse values that contradict each other."""

    def _unusual_combinations(self) -> list[str]:
        """Warnings about values that are unusual together, each a fact and a remedy."""
        return []

    def _key_figures(self) -> str:
        """What tells a scene from others, in a few words and numbers."""
        return ""

    def __repr__(self) -> str:
        return f"{type(self).__name__} {self.title!r}: {self._key_figures()}"

    def _repr_html_(self) -> str:
        """Table of all values for notebooks."""
        return scene_table(self)

    @field_validator("sources", mode="before", check_fields=False)
    @classmethod
    def _join_keys(cls, sources: Any) -> Any:
        return _flat(sources) if isinstance(sources, dict) else sources

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        self._check()
        for source in self.sources:
            if not has_path(self, source):
                raise SceneError(unknown_key(type(self), f"sources.{source}", source))
        return self

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], folder: Path | str = ".") -> Self:
        """Validate nested plain data.

        Parameters
        ----------
        data
            Content of a scene file, with or without a table ``line`` (see
            `gallop_fmu.line.line_table.Line`) and ``format`` (default: 1).
        folder
            Where relative names of CSV files start.

        Raises
        ------
        SceneError
            One line per problem.
        """
        try:
            scene_data = cls._tables(without_format(data), Path(folder))
            return cls.model_validate(scene_data, context={"folder": Path(folder)})
        except ValidationError as error:
            raise SceneError(explain(error, cls)) from None
        except RecursionError:
            raise SceneError(
                "the data are nested too deeply for a scene; give flatter ones"
            ) from None

    def to_toml(self) -> str:
        """Return the whole scene as TOML, with all defaults; loading it gives an equal scene."""
        data = self.model_dump(mode="json", exclude_none=True)
        return tomli_w.dumps({"format": FORMAT, **data})

    def save(self, path: Path | str) -> None:
        """Write `to_toml` to a file."""
        write_whole(Path(path), self.to_toml().encode())

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return a copy with replaced values, validated as a whole.

        Parameters
        ----------
        values
            Dotted path to new value, such as ``{"wind.speed": 6.0}``. A path may also name a whole
            section; its new value is then a dictionary or an object. None removes an optional
            value. The scene notes "set by the user" as the source of a changed value.

        Raises
        ------
        SceneError
            A key is unknown (the message names the closest), or a value is not allowed.
        """
        resolved = [key for key in values if key.startswith("line.")]
        if resolved:
            raise SceneError(
                f"{resolved[0]}: a loaded scene no longer has its [line]; change the scene file, or"
                " vary this value with sweep, or with --set on the command line"
            )
        # New first moments refer to the attack angle of the copy.
        ices = [found[1] for key in values if (found := _ICE_MOMENT.fullmatch(key))]
        values = {**{f"{ice}.first_moment_angle_deg": None for ice in ices}, **values}
        data = self.model_dump(mode="json", exclude_none=True)
        try:
            return type(self).from_dict(replace_values(type(self), data, values))
        except RecursionError:
            raise SceneError("the values are nested too deeply for a scene") from None

    def numbers(self) -> dict[str, tuple[float | int, str, str]]:
        """All single numbers of the scene: dotted path to (value, unit, meaning)."""
        return {
            leaf.path: (leaf.value, leaf.unit, leaf.meaning)
            for leaf in leaves(self)
            if isinstance(leaf.value, (int, float)) and not isinstance(leaf.value, bool)
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about unusual values, each a fact and a remedy."""
        unusual_values = unusual(
            {path: number[:2] for path, number in self.numbers().items()},
            partial(with_number, type(self)),
        )
        return (*self.notes, *unusual_values, *self._unusual_combinations())

    def unit_of(self, path: str) -> str:
        """Return the unit of the value at a dotted path; empty for texts and choices.

        Raises
        ------
        SceneError
            The path does not exist; the message names the closest.
        """
        found: dict[str, Leaf] = {leaf.path: leaf for leaf in leaves(self)}
        if path not in found:
            raise SceneError(unknown_key(type(self), path))
        return found[path].unit


def _flat(nested: Mapping[str, Any], start: str = "") -> dict[str, Any]:
    """Join nested tables; an unquoted ``span.length`` in TOML is a table in a table."""
    flat: dict[str, Any] = {}
    for key, value in nested.items():
        flat |= _flat(value, f"{start}{key}.") if isinstance(value, dict) else {start + key: value}
    return flat
