"""The kernel's C files, which come with the package and travel in every native FMU."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "kernel"


def kernel_sources() -> dict[str, bytes]:
    """Name to content of the kernel's C files and headers, in the order of their names.

    The headers of FMI 2.0 are not among them: who compiles a source FMU brings these.
    """
    return {file.name: file.read_bytes() for file in sorted(FOLDER.glob("*.[ch]"))}


def units_to_compile() -> list[str]:
    """Names of the C files, without headers."""
    return [name for name in kernel_sources() if name.endswith(".c")]
