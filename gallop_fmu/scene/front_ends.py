"""Tables of a scene file that are not sections of a scene: the layers above resolve them before a scene is validated.

`gallop_fmu` names the function for ``[line]`` when it is imported, so that a scene needs no import
of the line.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

FrontEnd = Callable[[Mapping[str, Any], Path], Mapping[str, Any]]
"""Turns the data of a scene file and the folder of its CSV files into data without the table."""

FRONT_ENDS: dict[str, FrontEnd] = {}
"""Name of a table to the function that resolves it."""


def resolved(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return data of a scene in which only sections of a scene are left.

    Raises
    ------
    SceneError
        A table is not allowed.
    """
    for name, resolve in FRONT_ENDS.items():
        if name in data:
            data = resolve(data, folder)
    return data
