"""The kernel's C files, which are part of the package and, but for a few, of every native FMU."""

from __future__ import annotations

from pathlib import Path

HISTORIES = ("history", "gallop_history")
"""Beginnings of the names of files for recorded histories."""

FOLDER = Path(__file__).resolve().parents[1] / "kernel"


def kernel_sources(fmi: int | None = None) -> dict[str, bytes]:
    """Return the content of the C files and headers of an FMU by name, in alphabetical order.

    The functions for recorded histories are not among them, as an FMU records nothing.
    The headers of FMI are not among them: tools that compile FMUs have their own, of the version
    that they read.

    Parameters
    ----------
    fmi
        2 or 3: without the functions of the other version; None: all.
    """
    others = {2: ("fmi3",), 3: ("fmi2",), None: ()}[fmi] + HISTORIES
    return {
        file.name: file.read_bytes()
        for file in sorted(FOLDER.glob("*.[ch]"))
        if not file.name.startswith(others)
    }


def units_to_compile(fmi: int | None = None) -> list[str]:
    """Return the names of the C files, without headers."""
    return [name for name in kernel_sources(fmi) if name.endswith(".c")]
