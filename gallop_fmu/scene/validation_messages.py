"""Messages for errors of pydantic in a scene: field, given value, allowed values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from gallop_fmu.foundation.text_rules import number_remedy
from gallop_fmu.scene.dotted_paths import section_classes, unknown_key, with_number
from gallop_fmu.scene.fields import Section, unit_of_field
from gallop_fmu.scene.plausibility import question

MAX_LINES = 20
"""Maximum number of problems in a message; the closest key of an unknown one takes 5 ms."""
BOUNDS = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}

OUT_OF_BOUNDS = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")


def explain(error: ValidationError, root: type[Section]) -> str:
    """Return one line per problem: path, given value, allowed values, meaning of the field."""
    problems = _without_consequences(error.errors(include_url=False))
    return joined([_line(problem, root) for problem in problems[:MAX_LINES]], len(problems))


def joined(lines: Sequence[str], count: int | None = None) -> str:
    """Join problems, one in a line, up to `MAX_LINES`; `count` is their number (default: all)."""
    shown = lines[:MAX_LINES]
    more = (len(lines) if count is None else count) - len(shown)
    return "\n".join([*shown, f"and {more} more problems"] if more else shown)


def _without_consequences(problems: list[ErrorDetails]) -> list[ErrorDetails]:
    """Drop "too short" of an array whose items have problems: pydantic counts valid items only."""
    return [
        problem
        for problem in problems
        if problem["type"] != "too_short"
        or not any(
            other["loc"][:-1] == problem["loc"] for other in problems if other is not problem
        )
    ]


def _line(problem: ErrorDetails, root: type[Section]) -> str:
    key, field = _locate(problem["loc"], root)
    path = with_number(root, key)
    kind, given = problem["type"], _short(problem["input"])
    if kind == "extra_forbidden":
        return unknown_key(root, path, key)
    if kind == "value_error":
        return f"{path}: {problem['ctx']['error']}" if path else str(problem["ctx"]["error"])
    if kind == "union_tag_invalid":
        return (
            f"{with_number(root, key + '.kind')} = {problem['ctx']['tag']!r}: must be one of"
            f" {problem['ctx']['expected_tags']}"
        )
    if kind == "union_tag_not_found":
        kinds = [
            found.model_fields["kind"].default
            for found in section_classes(field.annotation if field else None)
        ]
        kind_path = with_number(root, f"{key}.kind")
        return f"{kind_path}: missing; must be one of {', '.join(map(repr, kinds))}"
    meaning = f"; {field.description}" if field and field.description else ""
    allowed = _allowed(problem, field)
    if kind == "missing":
        return f"{path}: missing, {allowed}{meaning}"
    hint = (
        question(key, problem["input"], unit_of_field(field))
        if field and kind in OUT_OF_BOUNDS
        else ""
    )
    return f"{path} = {given}: {allowed}{meaning}{f'; {hint}' if hint else ''}"


def _locate(loc: tuple[int | str, ...], root: type[Section]) -> tuple[str, FieldInfo | None]:
    """Return the path and the field of a pydantic location, which includes kinds of unions."""
    classes, field, path = [root], None, []
    for part in loc:
        chosen = [
            found
            for found in classes
            if len(classes) > 1 and found.model_fields["kind"].default == part
        ]
        if chosen:
            classes = chosen
            continue
        path.append(str(part))
        owner = classes[0] if classes else None
        if isinstance(part, str) and owner and part in owner.model_fields:
            field = owner.model_fields[part]
            classes = section_classes(field.annotation)
    return ".".join(path), field


def _allowed(problem: ErrorDetails, field: FieldInfo | None) -> str:
    """Describe the allowed values: bounds of a number, otherwise the message of pydantic."""
    kind = problem["type"]
    if kind == "literal_error":
        return f"must be {problem['ctx']['expected']}"
    if kind in ("too_short", "too_long"):
        limit = "at least" if kind == "too_short" else "at most"
        count = problem["ctx"]["min_length" if kind == "too_short" else "max_length"]
        return f"must have {limit} {count} value{'s' if count > 1 else ''}"
    if field and unit_of_field(field) and kind not in ("model_type", "tuple_type"):
        return _allowed_number(problem, field)
    message = problem["msg"]
    return "but required" if kind == "missing" else message[0].lower() + message[1:]


def _allowed_number(problem: ErrorDetails, field: FieldInfo) -> str:
    """Describe the allowed numbers of a field by its bounds and unit."""
    bounds = [
        f"{word} {getattr(rule, name):.10g}"
        for rule in field.metadata
        for name, word in BOUNDS.items()
        if hasattr(rule, name)
    ]
    words = [" and ".join(bounds)] if bounds else []
    if not (bounds and problem["type"] in OUT_OF_BOUNDS):
        is_whole = int in (field.annotation, *get_args(field.annotation))
        words.insert(0, "a whole number" if is_whole else "a finite number")
    remedy = number_remedy(problem["input"]) if isinstance(problem["input"], str) else ""
    hint = f" ({remedy})" if remedy else ""
    return f"must be {' '.join(words)} [{unit_of_field(field)}]{hint}"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
