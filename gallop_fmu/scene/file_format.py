"""Version of the format of scene files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.version import program

FORMAT = 1
"""Value of the key ``format`` of a scene file. It increases when older releases misread a file."""


def without_format(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Check the key ``format`` of scene data and return the data without it.

    Raises
    ------
    SceneError
        The format is newer than this release, or not a whole number.
    """
    if "format" not in data:
        return data
    found = data["format"]
    if isinstance(found, bool) or not isinstance(found, int) or found < 1:
        raise SceneError(
            f"format = {found!r}: must be a whole number from 1; write format = {FORMAT}"
        )
    if found > FORMAT:
        raise SceneError(
            f"format = {found}: a newer format of scene files; {program()} reads formats up to"
            f" {FORMAT}: install the newest gallop-fmu (pip install --upgrade gallop-fmu)"
        )
    return {key: value for key, value in data.items() if key != "format"}
