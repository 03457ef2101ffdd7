"""Version of the installed package."""

from __future__ import annotations

import functools
from importlib import metadata


@functools.cache
def version() -> str:
    """Version of the installed distribution gallop-fmu; cached, as it is read from a file."""
    return metadata.version("gallop-fmu")


def program() -> str:
    """Name and version, as written in results."""
    return f"gallop-fmu {version()}"
