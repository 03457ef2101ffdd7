r"""Compile the kernel for other platforms, with the C compiler of Zig.

Zig, from the extra ``cross``, brings headers and libraries of each system, so one machine compiles
for all. The first library for a platform takes up to some minutes, in which Zig compiles the
system's own; later ones take seconds.

Libraries are kept in the user's cache folder, under a name made from sources, flags and the version
of Zig: ``$XDG_CACHE_HOME/gallop-fmu`` (or ``~/.cache/gallop-fmu``), ``~/Library/Caches/gallop-fmu``
on macOS, ``%LOCALAPPDATA%\gallop-fmu`` on Windows. The folder may be deleted at any time. Several
processes may compile at once: each works in a folder of its own, and a finished library takes its
place in one move.
"""

from __future__ import annotations

import hashlib
import os
import struct
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from gallop_fmu.fmu.sources import kernel_sources, units_to_compile
from gallop_fmu.foundation.atomic_write import write_whole

FLAGS = (
    "-std=c11",
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fvisibility=hidden",
    "-fno-sanitize=undefined",  # which Zig switches on by itself
    "-shared",
    "-s",
)
"""As in CMakeLists.txt: results then differ only by the systems' mathematical functions."""

PAGE = 14
"""Slices of a universal library start at multiples of 2**PAGE bytes, Apple's largest page."""

UNIVERSAL_HEADER = struct.Struct(">II")
"""Magic number and count of slices."""
UNIVERSAL_SLICE = struct.Struct(">iiIII")
"""Processor, its variant, offset, size, and alignment as a power of two, each in 32 bits."""
MACH_O_HEADER = struct.Struct("<Iii")
"""Magic number, processor and its variant at the start of a slice."""


@dataclass(frozen=True, slots=True)
class Platform:
    """How to compile for a platform of FMI 2.0.

    Attributes
    ----------
    suffix
        Suffix of a library.
    targets
        Zig's names of the systems to compile for; of several, the library is a universal one.
    options
        Further options of the compiler.
    """

    suffix: str
    targets: tuple[str, ...]
    options: tuple[str, ...]


PLATFORMS = {
    # glibc 2.17 is that of 2012, so the library runs on all newer ones. Choosing between two
    # paths for vectors would need Zig's own run-time library, whose sine is not glibc's: the last
    # bits would differ from the installed kernel.
    "linux64": Platform(
        ".so", ("x86_64-linux-gnu.2.17",), ("-fPIC", "-DGALLOP_ONE_PATH", "-Wl,-Bsymbolic", "-lm")
    ),
    "win64": Platform(".dll", ("x86_64-windows-gnu",), ()),
    "darwin64": Platform(".dylib", ("x86_64-macos.11.0", "aarch64-macos.11.0"), ("-fPIC",)),
}
"""Platform by its name in FMI 2.0."""


class CompilerError(RuntimeError):
    """The kernel cannot be compiled; the message says why, then the remedy."""


def cross_library(platform: str) -> bytes:
    """Return the kernel's library for a platform, compiled by Zig or from the cache.

    Parameters
    ----------
    platform
        One of `PLATFORMS`.

    Raises
    ------
    CompilerError
        Unknown platform, Zig is missing, it fails, or the cache folder cannot be written.
    """
    if platform not in PLATFORMS:
        raise CompilerError(f"platform {platform!r} is unknown; there are {', '.join(PLATFORMS)}")
    folder = cache_folder()
    kept = folder / f"{cache_key(platform, zig_version())}{PLATFORMS[platform].suffix}"
    try:
        if kept.is_file():
            return kept.read_bytes()
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as work:
            library = _compile(PLATFORMS[platform], Path(work))
        write_whole(kept, library)
    except OSError as problem:
        raise CompilerError(f"the cache folder {folder} cannot be used ({problem})") from None
    return library


def zig_version() -> str:
    """Return the version of the installed Zig."""
    try:
        return metadata.version("ziglang")
    except metadata.PackageNotFoundError:
        raise CompilerError(
            "compiling for other platforms needs the package ziglang, which is missing; run `pip"
            ' install "gallop-fmu[cross]"`, or omit platforms: the FMU then contains the library'
            " of this platform only"
        ) from None


def cache_folder() -> Path:
    """Return the folder in which libraries are kept."""
    home = Path.home()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return base / "gallop-fmu"


def cache_key(platform: str, zig: str) -> str:
    """Return a hash of the compiler's version, its arguments and the sources."""
    words = [zig, metadata.version("fmpy")]  # it has the headers of FMI
    for target in PLATFORMS[platform].targets:
        words += arguments(PLATFORMS[platform], target, headers="", output="")
    digest = hashlib.sha256("\0".join(words).encode())
    for content in kernel_sources().values():
        digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()[:32]


def arguments(platform: Platform, target: str, headers: str, output: str) -> list[str]:
    """Return the arguments of ``python -m ziglang``, called in the folder of the sources.

    Parameters
    ----------
    platform, target
        The platform, and one of its systems.
    headers
        Folder of the headers of FMI.
    output
        Library to write.
    """
    sources = units_to_compile()
    return [
        "cc",
        "-target",
        target,
        *FLAGS,
        f"-I{headers}",
        *sources,
        "-o",
        output,
        *platform.options,
    ]


def _compile(platform: Platform, folder: Path) -> bytes:
    for name, content in kernel_sources().items():
        (folder / name).write_bytes(content)
    slices = []
    for target in platform.targets:
        output = f"gallop_kernel{platform.suffix}"
        command = [
            sys.executable,
            "-m",
            "ziglang",
            *arguments(platform, target, _fmi_headers(), output),
        ]
        done = subprocess.run(
            command, cwd=folder, capture_output=True, encoding="utf-8", errors="replace"
        )
        if done.returncode:
            said = "\n".join(done.stderr.strip().splitlines()[:20])
            raise CompilerError(f"Zig could not compile the kernel for {target}:\n{said}")
        slices.append((folder / output).read_bytes())
    return universal_library(slices) if len(slices) > 1 else slices[0]


def _fmi_headers() -> str:
    """Return the folder of the headers of FMI, which are in FMPy."""
    return str(metadata.distribution("fmpy").locate_file("fmpy/c-code"))


def universal_library(slices: Sequence[bytes]) -> bytes:
    """Combine Mach-O files, each for another processor, into one.

    Parameters
    ----------
    slices
        Mach-O files of 64 bits.

    Returns
    -------
    bytes
        A header with the place of each slice, then the slices, each at the start of a page.
        All numbers of the header are big-endian (Apple, ``mach-o/fat.h``).
    """
    table, body = UNIVERSAL_HEADER.pack(0xCAFEBABE, len(slices)), b""
    start = -(-(UNIVERSAL_HEADER.size + len(slices) * UNIVERSAL_SLICE.size) // 2**PAGE) * 2**PAGE
    for content in slices:
        magic, processor, variant = MACH_O_HEADER.unpack_from(content)
        if magic != 0xFEEDFACF:
            raise ValueError(
                f"a slice starts with {magic:#x}; a Mach-O file of 64 bits starts with 0xfeedfacf"
            )
        table += UNIVERSAL_SLICE.pack(processor, variant, start + len(body), len(content), PAGE)
        body += content + bytes(-len(content) % 2**PAGE)
    return table.ljust(start, b"\0") + body
