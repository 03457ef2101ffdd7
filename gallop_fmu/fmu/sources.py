"""The kernel's C files, which are part of the package and of every native FMU."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "kernel"


def kernel_sources() -> dict[str, bytes]:
    """Return the content of the kernel's C files and headers by name, in alphabetical order.

    The headers of FMI 2.0 are not among them: tools that compile FMUs have their own.
    """
    return {file.name: file.read_bytes() for file in sorted(FOLDER.glob("*.[ch]"))}


def units_to_compile() -> list[str]:
    """Return the names of the C files, without headers."""
    return [name for name in kernel_sources() if name.endswith(".c")]
