"""The kernel's C files, which are part of the package and of every native FMU."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "kernel"


def kernel_sources(fmi: int | None = None) -> dict[str, bytes]:
    """Return the content of the kernel's C files and headers by name, in alphabetical order.

    The headers of FMI are not among them: tools that compile FMUs have their own, of the version
    that they read.

    Parameters
    ----------
    fmi
        2 or 3: without the functions of the other version; None: all.
    """
    other = {2: "fmi3", 3: "fmi2", None: "-"}[fmi]
    return {
        file.name: file.read_bytes()
        for file in sorted(FOLDER.glob("*.[ch]"))
        if not file.name.startswith(other)
    }


def units_to_compile(fmi: int | None = None) -> list[str]:
    """Return the names of the C files, without headers."""
    return [name for name in kernel_sources(fmi) if name.endswith(".c")]
