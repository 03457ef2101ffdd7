"""A scene as a TOML file with unit and meaning of each value, for editing."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping

from gallop_fmu.scene.dotted_paths import leaves, number_of_item
from gallop_fmu.scene.scene_base import SceneBase

HEADER = """\
# A scene of gallop-fmu: SI units, angles in degrees where the name ends in _deg.
# Axes: x1 along the span, x2 up, x3 horizontal; wind blows towards +x3.
# Change values as needed, and give their sources under [sources].

"""


def annotated_toml(scene: SceneBase) -> str:
    """Return `SceneBase.to_toml` with comments; loading it gives an equal scene."""
    notes = {
        leaf.path: f"{leaf.meaning} [{leaf.unit}]" if leaf.unit else leaf.meaning
        for leaf in leaves(scene)
        if leaf.value is not None
    }
    return HEADER + "\n".join(_annotated(scene, notes)) + "\n"


def _annotated(scene: SceneBase, notes: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of the file; items of a line, such as spans, have their number."""
    table, array, items = "", "", Counter[str]()

    def numbered(line: str, path: str) -> str:
        number = number_of_item(type(scene), f"{path}.{items[path]}")
        items[path] += bool(number)
        return f"{line}  # {number}" if number else line

    for line in scene.to_toml().splitlines():
        if heading := re.fullmatch(r"(\[+)([^\]\"]+)\]+", line):
            yield numbered(line, heading[2]) if heading[1] == "[[" else line
            table = _with_index(f"{heading[2]}.", items)
        elif array and line.startswith("    {"):
            yield numbered(line, array)
        else:
            key = re.match(r"(\w+) = ", line)
            path = table + key[1] if key else ""
            array = path if line.endswith("[") and _is_numbered(scene, path) else ""
            if array:
                yield from _notes_of_items(array, notes)
            yield from _with_note(line, None if array else notes.get(path), in_table=bool(table))


def _is_numbered(scene: SceneBase, path: str) -> bool:
    return number_of_item(type(scene), f"{path}.0") != ""


def _with_note(line: str, note: str | None, *, in_table: bool) -> Iterator[str]:
    """Yield a line with the meaning of its value, which is above an array of several lines."""
    if note is None or line.endswith('"""'):
        yield line
    elif line.endswith("["):
        yield from (f"# {note}", line)
    else:
        yield f"{line}  # {note}" if in_table else line


def _with_index(table: str, items: Mapping[str, int]) -> str:
    """Return the path of a table; a table within an item has the index of this item."""
    for array, count in items.items():
        if table.startswith(f"{array}."):
            return f"{array}.{count - 1}{table.removeprefix(array)}"
    return table


def _notes_of_items(array: str, notes: Mapping[str, str]) -> Iterator[str]:
    """Yield the meanings of the values of items that are written in one line each."""
    item = re.compile(re.escape(array) + r"\.\d+\.(.+)")
    meanings: dict[str, str] = {}
    for path, note in notes.items():
        if match := item.fullmatch(path):
            meanings.setdefault(match[1], note)
    yield from (f"# {name}: {note}" for name, note in meanings.items())
