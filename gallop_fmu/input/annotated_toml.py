"""A scene as a TOML file with unit and meaning of each value, for editing."""

from __future__ import annotations

import re

from gallop_fmu.scene.dotted_paths import leaves
from gallop_fmu.scene.scene import Scene

HEADER = """\
# A scene of gallop-fmu: SI units, angles in degrees where the name ends in _deg.
# Axes: x1 along the span, x2 up, x3 horizontal; wind blows towards +x3.
# Change values as needed, and give their sources under [sources].

"""


def annotated_toml(scene: Scene) -> str:
    """Return `Scene.to_toml` with comments; loading it gives an equal scene."""
    notes = {
        leaf.path: f"{leaf.meaning} [{leaf.unit}]" if leaf.unit else leaf.meaning
        for leaf in leaves(scene)
    }
    lines, table = [], ""
    for line in scene.to_toml().splitlines():
        heading = re.fullmatch(r"\[+([^\]\"]+)\]+", line)
        table = f"{heading[1]}." if heading else table
        key = re.match(r"(\w+) = ", line)
        note = (
            notes.get(table + key[1])
            if key and table != "sources." and not line.endswith('"""')
            else None
        )
        if note and line.endswith("["):
            lines.append(f"# {note}")
        lines.append(f"{line}  # {note}" if note and table and not line.endswith("[") else line)
    return HEADER + "\n".join(lines) + "\n"
