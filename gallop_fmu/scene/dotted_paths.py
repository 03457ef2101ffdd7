"""Dotted paths of the values of a scene, such as ``wind.speed`` or ``loads.0.torque``."""

from __future__ import annotations

import difflib
import re
import types
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_rules import plain
from gallop_fmu.scene.fields import UNIT_OF_OWNER, Section, unit_of_field

SET_BY_USER = "set by the user"


class Leaf(NamedTuple):
    """A field that is not a section: a number, an array, a text, or an optional value."""

    path: str
    value: Any
    unit: str
    meaning: str


def leaves(section: Section) -> list[Leaf]:
    """Return all leaves of a section in order of declaration."""
    found: list[Leaf] = []
    _add_leaves(found, section, "", "")
    return found


def _add_leaves(found: list[Leaf], section: Section, start: str, law_unit: str) -> None:
    """Add the leaves of a section at a path; `law_unit` is the unit of a law."""
    values = vars(section)
    for name, path, unit, meaning in _fields(type(section), start, law_unit):
        value = values[name]
        if isinstance(value, Section):
            _add_leaves(found, value, path + ".", unit)
        elif isinstance(value, tuple) and value and isinstance(value[0], Section):
            for i, item in enumerate(value):
                _add_leaves(found, item, f"{path}.{i}.", "")
        else:
            found.append(Leaf(path, value, unit, meaning))


@lru_cache(maxsize=10_000)  # a scene of a hundred spans has a thousand sections
def _fields(
    section: type[Section], start: str, law_unit: str
) -> tuple[tuple[str, str, str, str], ...]:
    """Return name, path, unit and meaning of each field of a section that begins at a path."""
    units = {name: unit_of_field(field) for name, field in section.model_fields.items()}
    return tuple(
        (
            name,
            start + name,
            law_unit if units[name] == UNIT_OF_OWNER else units[name],
            field.description or "",
        )
        for name, field in section.model_fields.items()
    )


def has_path(section: Section, path: str) -> bool:
    """Check that a section has a dotted path: that of a leaf, or the start of one."""
    value: Any = section
    for part in path.split("."):
        if isinstance(value, Section) and part in type(value).model_fields:
            value = getattr(value, part)
        elif isinstance(value, tuple) and part in map(str, range(len(value))):
            value = value[int(part)]
            if not isinstance(value, Section):
                return False
        else:
            return False
    return True


def section_classes(annotation: Any) -> list[type[Section]]:
    """Return the sections of an annotation: one, several for a union, none for plain values."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    if get_origin(annotation) is Annotated:
        return section_classes(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType, tuple):
        return [found for argument in get_args(annotation) for found in section_classes(argument)]
    return []


def all_keys(section: type[Section], start: str = "") -> list[str]:
    """Return all dotted paths that a scene can have; a list has the item 0 only."""
    keys: dict[str, None] = {}
    for name, field in section.model_fields.items():
        below = section_classes(field.annotation)
        item = ".0" if below and get_origin(field.annotation) is tuple else ""
        keys[start + name] = None
        for found in below:
            keys |= dict.fromkeys(all_keys(found, f"{start}{name}{item}."))
    return list(keys)


@cache
def is_key(root: type[Section], path: str) -> bool:
    """Check that a scene can have a dotted path; items of lists have any number."""
    pattern = re.sub(r"\.\d+(?=\.)", ".0", path)
    return re.sub(r"(\.\d+)+$", "", pattern) in _keys(root)


@cache
def _keys(root: type[Section]) -> frozenset[str]:
    return frozenset(all_keys(root))


def number_of_item(root: type[Section], path: str) -> str:
    """Return the number of the item of a path for people, such as ``"device 1"`` of ``devices.0``.

    Items of a class with ``NUMBERED`` have a number, which counts from 1; other paths have none.
    """
    parts = path.split(".")
    for i, part in enumerate(parts):
        if part.isdecimal():
            for owner in _owners(root, parts[:i]):
                if hasattr(owner, "NUMBERED"):
                    return f"{owner.NUMBERED} {int(part) + 1}"
    return ""


def with_number(root: type[Section], path: str) -> str:
    """Return a path and the number of its item, such as ``devices.0.mass (device 1)``."""
    number = number_of_item(root, path)
    return f"{path} ({number})" if number else path


@cache
def takes_text(root: type[Section], path: str) -> bool:
    """Check that the field at a dotted path is always a text or a choice."""
    classes, fields = [root], list[FieldInfo]()
    for part in path.split("."):
        if part.isdecimal():
            continue  # an item of a list; its classes are those of the list
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
    """Return a message for an unknown key, with the closest valid key.

    Parameters
    ----------
    path
        Name of the key in the message.
    key
        Key to compare with the valid ones (default: `path`).
    """
    key = key or path
    valid = [other for other in all_keys(root) if other != key or "." in key]
    if re.sub(r"\.\d+(?=\.|$)", ".0", key) in valid:
        return f"{path}: {_where(root, key)}"
    # Keys with the closest last part, if it is close; of these the closest as a whole.
    last = {other: other.rpartition(".")[2] for other in valid}
    names = difflib.get_close_matches(key.rpartition(".")[2], set(last.values()), n=1, cutoff=0.8)
    candidates = [other for other in valid if last[other] in names] or valid
    closest = difflib.get_close_matches(key, candidates, n=1, cutoff=0.0)
    return f"{path}: unknown key; the closest valid one is {_with_indices(closest[0], key)}"


def _with_indices(valid: str, key: str) -> str:
    """Return a valid path with the indices of a key, as far as both name the same items."""
    parts, given = valid.split("."), key.split(".")
    for i, (part, other) in enumerate(zip(parts, given, strict=False)):
        if part == "0" and other.isdecimal():
            parts[i] = other
        elif part != other:
            break
    return ".".join(parts)


def _owners(root: type[Section], parents: list[str]) -> list[type[Section]]:
    """Return the possible sections at the end of a path, one for each kind."""
    owners = [root]
    for parent in parents:
        if not parent.isdecimal():
            fields = [
                owner.model_fields[parent] for owner in owners if parent in owner.model_fields
            ]
            owners = [found for field in fields for found in section_classes(field.annotation)]
    return list(dict.fromkeys(owners))


def _where(root: type[Section], key: str) -> str:
    """Return the condition under which a scene has a valid key."""
    *parents, last = key.split(".")
    owners, section = _owners(root, parents), ".".join(parents)
    with_it = [found for found in owners if last in found.model_fields]
    kinds = [
        repr(found.model_fields["kind"].default)
        for found in with_it
        if "kind" in found.model_fields
    ]
    if kinds and len(with_it) < len(owners):
        return (
            f"only {section}.kind = {' or '.join(kinds)} has this value; set the kind too, or"
            " remove this value"
        )
    return f"{section} is not given in this scene; give the whole section"


def _keep_values_of_kind(
    root: type[Section], section: dict[str, Any], parents: list[str], kind: Any
) -> None:
    """Remove the values of a section that another kind of it does not have."""
    owners = [
        owner
        for owner in _owners(root, parents)
        if "kind" in owner.model_fields and owner.model_fields["kind"].default == kind
    ]
    if owners:  # otherwise validation reports the unknown kind
        for name in list(section):
            if not any(name in owner.model_fields for owner in owners):
                del section[name]


def replace_values(
    root: type[Section], data: dict[str, Any], values: Mapping[str, Any]
) -> dict[str, Any]:
    """Replace values in nested plain data, in place, and update the sources of changed values.

    Raises
    ------
    SceneError
        A path does not exist.
    """
    for path, value in values.items():
        try:
            new = plain(value)
        except SceneError as problem:
            raise SceneError(f"{path[:80]}: {problem}") from None
        *parents, last = path.split(".")
        container = _container(root, data, parents, path)
        if isinstance(container, list):
            old, container[int(last)] = container[int(last)], new
            # The source of an array is that of the whole array.
            changed = path if isinstance(new, dict) else ".".join(parents)
        else:
            old = container.pop(last, None)
            changed = path
            if last == "kind" and new not in (None, old):
                _keep_values_of_kind(root, container, parents, new)
                changed = ".".join(parents) or path
            if new is not None:
                container[last] = new
        if old != new and not path.startswith("sources"):
            data["sources"] = _sources_after_change(data.get("sources", {}), changed)
    return data


def _container(
    root: type[Section], data: dict[str, Any], parents: list[str], path: str
) -> dict[str, Any] | list[Any]:
    """Return the table, or the list with the item, that holds the value of a path."""
    node: Any = data
    for i, parent in enumerate(parents):
        if isinstance(node, dict):
            node = node.setdefault(parent, {})
        elif _has_item(node, parent):
            node = node[int(parent)]
        elif parent.isdecimal() and len(_owners(root, parents[: i + 1])) > 1:
            item = ".".join(parents[: i + 1])
            raise SceneError(f"{path}: {item} is not given in this scene; give the whole section")
        else:
            raise SceneError(unknown_key(root, path))
    if isinstance(node, dict):
        return node
    if not _has_item(node, path.rpartition(".")[2]):
        raise SceneError(unknown_key(root, path))
    items: list[Any] = node
    return items


def _has_item(node: Any, index: str) -> bool:
    return isinstance(node, list) and index.isdecimal() and int(index) < len(node)


def _sources_after_change(sources: dict[str, str], path: str) -> dict[str, str]:
    covered = any(path == source or path.startswith(source + ".") for source in sources)
    kept = {
        source: text
        for source, text in sources.items()
        if source != path and not source.startswith(path + ".")
    }
    return {**kept, path: SET_BY_USER} if covered or len(kept) < len(sources) else kept
