"""Dotted paths such as ``wind.speed`` or ``loads.0.torque``: walking a scene by them."""

from __future__ import annotations

import difflib
import re
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_rules import plain
from gallop_fmu.scene.fields import DRIVEN, Section, unit_of_field

SET_BY_USER = "set by the user"


@dataclass(frozen=True)
class Leaf:
    """A field that holds no further section: a number, an array, a text, or an optional value that is not set."""

    path: str
    value: Any
    unit: str
    meaning: str


def leaves(section: Section, start: str = "", driven: str = "") -> Iterator[Leaf]:
    """All leaves below a section in order of declaration; `driven` is the unit that a law's values take."""
    for name, field in type(section).model_fields.items():
        value, path = getattr(section, name), start + name
        unit = driven if unit_of_field(field) == DRIVEN else unit_of_field(field)
        if isinstance(value, Section):
            yield from leaves(value, path + ".", unit)
        elif isinstance(value, tuple) and value and isinstance(value[0], Section):
            for i, item in enumerate(value):
                yield from leaves(item, f"{path}.{i}.")
        else:
            yield Leaf(path, value, unit, field.description or "")


def section_classes(annotation: Any) -> list[type[Section]]:
    """Sections that an annotation allows: one, several for a union, none for plain values."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    if get_origin(annotation) is Annotated:
        return section_classes(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType, tuple):
        return [found for argument in get_args(annotation) for found in section_classes(argument)]
    return []


def all_keys(section: type[Section], start: str = "") -> list[str]:
    """Every dotted path that some scene can have; items of a list appear once, as item 0."""
    keys: dict[str, None] = {}
    for name, field in section.model_fields.items():
        below = section_classes(field.annotation)
        item = ".0" if below and get_origin(field.annotation) is tuple else ""
        keys[start + name] = None
        for found in below:
            keys |= dict.fromkeys(all_keys(found, f"{start}{name}{item}."))
    return list(keys)


@cache
def takes_text(root: type[Section], path: str) -> bool:
    """Whether the field at a dotted path is a text or a choice, never a number, an array or a table."""
    classes, fields = [root], list[FieldInfo]()
    for part in path.split("."):
        fields = [found.model_fields[part] for found in classes if part in found.model_fields]
        classes = [found for field in fields for found in section_classes(field.annotation)]
    return bool(fields) and all(_is_text(field.annotation) for field in fields)


def _is_text(annotation: Any) -> bool:
    if get_origin(annotation) is Annotated:
        return _is_text(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return all(
            _is_text(argument)
            for argument in get_args(annotation)
            if argument is not types.NoneType
        )
    return annotation is str or get_origin(annotation) is Literal


def unknown_key(root: type[Section], path: str, key: str | None = None) -> str:
    """One line for a key that does not exist, with the closest that does.

    Parameters
    ----------
    path
        What the message calls the key.
    key
        What to compare with the valid keys; `path` if not given.
    """
    key = key or path
    valid = [other for other in all_keys(root) if other != key or "." in key]
    if re.sub(r"\.\d+(?=\.|$)", ".0", key) in valid:
        return f"{path}: {_where(root, key)}"
    same_name = [other for other in valid if other.rpartition(".")[2] == key.rpartition(".")[2]]
    closest = same_name[:1] or difflib.get_close_matches(key, valid, n=1, cutoff=0.0)
    return f"{path}: unknown key; the closest valid one is {closest[0]}"


def _owners(root: type[Section], parents: list[str]) -> list[type[Section]]:
    """Sections that may be at the end of a path, one for each kind."""
    owners = [root]
    for parent in parents:
        if not parent.isdecimal():
            fields = [
                owner.model_fields[parent] for owner in owners if parent in owner.model_fields
            ]
            owners = [found for field in fields for found in section_classes(field.annotation)]
    return list(dict.fromkeys(owners))


def _where(root: type[Section], key: str) -> str:
    """Condition under which a scene has a key that exists."""
    *parents, last = key.split(".")
    owners, place = _owners(root, parents), ".".join(parents)
    with_it = [found for found in owners if last in found.model_fields]
    kinds = [
        repr(found.model_fields["kind"].default)
        for found in with_it
        if "kind" in found.model_fields
    ]
    if kinds and len(with_it) < len(owners):
        return (
            f"only {place}.kind = {' or '.join(kinds)} has this value; set the kind too, or remove"
            " this value"
        )
    return f"{place} is not given in this scene; give the whole section"


def _of_kind(
    root: type[Section], data: Mapping[str, Any], parents: list[str], kind: Any
) -> dict[str, Any]:
    """Values that a section keeps when it becomes another kind: those that this kind has, too."""
    of_kind = [
        owner
        for owner in _owners(root, parents)
        if "kind" in owner.model_fields and owner.model_fields["kind"].default == kind
    ]
    if not of_kind:
        return dict(data)  # validation names the kinds that exist
    return {
        name: value
        for name, value in data.items()
        if any(name in owner.model_fields for owner in of_kind)
    }


def replace_values(
    root: type[Section], data: dict[str, Any], values: Mapping[str, Any]
) -> dict[str, Any]:
    """Put values into nested plain data (which is changed), and mark the sources of what they change.

    Raises
    ------
    SceneError
        A path leads through something that has no such key.
    """
    for path, value in values.items():
        *parents, last = path.split(".")
        node: Any = data
        for parent in parents:
            if isinstance(node, dict):
                node = node.setdefault(parent, {})
            elif isinstance(node, list) and parent.isdecimal() and int(parent) < len(node):
                node = node[int(parent)]
            else:
                raise SceneError(unknown_key(root, path))
        try:
            new = plain(value)
        except SceneError as problem:
            raise SceneError(f"{path[:80]}: {problem}") from None
        changed = path
        if isinstance(node, list) and last.isdecimal() and int(last) < len(node):
            old, node[int(last)] = node[int(last)], new
            changed = (
                path if isinstance(new, dict) else ".".join(parents)
            )  # sources speak of arrays as a whole
        elif isinstance(node, dict):
            old = node.pop(last, None)
            if last == "kind" and new is not None and new != old:
                kept = _of_kind(root, node, parents, new)
                node.clear()
                node.update(kept)
                changed = ".".join(parents) or path
            if new is not None:
                node[last] = new
        else:
            raise SceneError(unknown_key(root, path))
        if old != new and not path.startswith("sources"):
            data["sources"] = _sources_after_change(data.get("sources", {}), changed)
    return data


def _sources_after_change(sources: dict[str, str], path: str) -> dict[str, str]:
    covered = any(path == source or path.startswith(source + ".") for source in sources)
    kept = {
        source: text
        for source, text in sources.items()
        if source != path and not source.startswith(path + ".")
    }
    return {**kept, path: SET_BY_USER} if covered or len(kept) < len(sources) else kept
