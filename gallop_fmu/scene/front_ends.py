"""Tables of a scene file that upper layers resolve before a scene is validated, such as [line].

`gallop_fmu` registers the function for ``[line]``, so that this layer does not import the line.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

FrontEnd = Callable[[Mapping[str, Any], Path], Mapping[str, Any]]
"""Function from the data of a scene file and its folder to data without the table."""

FRONT_ENDS: dict[str, FrontEnd] = {}
"""Name of a table to the function that resolves it."""


def resolved(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return scene data without tables of front ends.

    Raises
    ------
    SceneError
        A table is not allowed.
    """
    for name, resolve in FRONT_ENDS.items():
        if name in data:
            data = resolve(data, folder)
    return data
