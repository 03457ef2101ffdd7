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
    root, table, array = type(scene), "", ""
    items = Counter[str]()
    for line in scene.to_toml().splitlines():
        if heading := re.fullmatch(r"(\[+)([^\]\"]+)\]+", line):
            table = _with_index(heading[2], items)
            number = number_of_item(root, f"{table}.{items[table]}") if heading[1] == "[[" else ""
            if number:
                items[table] += 1
                table += f".{items[table] - 1}"
            table += "."
            yield f"{line}  # {number}" if number else line
            continue
        if array and line.startswith("    {"):
            yield f"{line}  # {number_of_item(root, f'{array}.{items[array]}')}"
            items[array] += 1
            continue
        key = re.match(r"(\w+) = ", line)
        path = table + key[1] if key else ""
        note = notes.get(path) if key and table != "sources." and not line.endswith('"""') else None
        is_array = line.endswith("[")
        array = path if is_array and number_of_item(root, f"{path}.0") else ""
        if array:
            yield from _notes_of_items(array, notes)
        elif note and is_array:
            yield f"# {note}"
        yield f"{line}  # {note}" if note and table and not is_array else line


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
