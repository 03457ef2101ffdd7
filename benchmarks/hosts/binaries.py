"""Exports of a shared library, read from its bytes: ELF, PE and Mach-O of 64 bits.

    python benchmarks/hosts/binaries.py [LIBRARY ...]

prints size, functions of FMI and newest glibc of ELF libraries, by default the installed kernel.
"""

import re
import struct
import sys
from collections.abc import Iterator
from pathlib import Path

MACH_O_NAMES = {0x01000007: "x86_64", 0x0100000C: "arm64"}


def exports(library: bytes) -> set[str]:
    """Names that other programs see."""
    if library.startswith(b"\x7fELF"):
        return set(_elf_exports(library))
    if library.startswith(b"MZ"):
        return set(_pe_exports(library))
    return set(_mach_o_exports(library))


def slices(library: bytes) -> dict[str, bytes]:
    """Processor to Mach-O file, of a universal library."""
    magic, count = struct.unpack_from(">II", library)
    assert magic == 0xCAFEBABE, (
        f"starts with {magic:#x}; a universal library starts with 0xcafebabe"
    )
    found = {}
    for index in range(count):
        processor, _, offset, size, alignment = struct.unpack_from(
            ">iiIII", library, 8 + 20 * index
        )
        assert offset % 2**alignment == 0, f"slice {index} is not aligned"
        found[MACH_O_NAMES[processor]] = library[offset : offset + size]
        assert struct.unpack_from("<Ii", library, offset) == (0xFEEDFACF, processor), (
            f"slice {index} is another file"
        )
    return found


def newest_glibc(library: bytes) -> tuple[int, int]:
    """Largest version of glibc that an ELF library asks for."""
    return max(
        (int(major), int(minor)) for major, minor in re.findall(rb"GLIBC_(\d+)\.(\d+)", library)
    )


def _text(library: bytes, at: int) -> str:
    return library[at : library.index(b"\0", at)].decode()


def _elf_exports(library: bytes) -> Iterator[str]:
    (first,) = struct.unpack_from("<Q", library, 0x28)
    size, count = struct.unpack_from("<HH", library, 0x3A)
    headers = [
        struct.unpack_from("<IIQQQQIIQQ", library, first + size * index) for index in range(count)
    ]
    for _, kind, _, _, offset, length, link, _, _, entry in headers:
        if kind == 11:  # dynamic symbols
            for at in range(offset, offset + length, entry):
                name, _, _, section = struct.unpack_from("<IBBH", library, at)
                if section:  # defined here
                    yield _text(library, headers[link][4] + name)


def _pe_exports(library: bytes) -> Iterator[str]:
    (header,) = struct.unpack_from("<I", library, 0x3C)
    sections, optional = struct.unpack_from("<H12xH", library, header + 6)
    table = [
        struct.unpack_from("<8xIIII", library, header + 24 + optional + 40 * index)
        for index in range(sections)
    ]

    def place(address: int) -> int:
        return next(
            offset + address - start
            for size, start, _, offset in table
            if 0 <= address - start < size
        )

    (directory,) = struct.unpack_from("<I", library, header + 24 + 112)
    (count,) = struct.unpack_from("<I", library, place(directory) + 24)
    (names,) = struct.unpack_from("<I", library, place(directory) + 32)
    for (name,) in struct.iter_unpack("<I", library[place(names) : place(names) + 4 * count]):
        yield _text(library, place(name))


def _mach_o_exports(library: bytes) -> Iterator[str]:
    (commands,) = struct.unpack_from("<I", library, 16)
    at = 32
    for _ in range(commands):
        command, size = struct.unpack_from("<II", library, at)
        if command == 0x80000022:  # information for the dynamic loader
            offset, length = struct.unpack_from("<II", library, at + 40)
            yield from _leaves(library[offset : offset + length], 0, "")
        at += size


def _leaves(tree: bytes, node: int, name: str) -> Iterator[str]:
    """Names in a tree whose edges are parts of names."""
    terminal, at = _uleb128(tree, node)
    if terminal:
        yield name.removeprefix("_")
    at += terminal
    children, at = tree[at], at + 1
    for _ in range(children):
        part = _text(tree, at)
        child, at = _uleb128(tree, at + len(part) + 1)
        yield from _leaves(tree, child, name + part)


def _uleb128(data: bytes, at: int) -> tuple[int, int]:
    """A number of variable length, and where it ends."""
    value = shift = 0
    while True:
        value |= (data[at] & 0x7F) << shift
        shift, at = shift + 7, at + 1
        if data[at - 1] < 0x80:
            return value, at


def main(paths: list[str]) -> None:
    if not paths:
        from gallop_fmu.engine.library import library_path

        paths = [str(library_path())]
    for path in paths:
        library = Path(path).read_bytes()
        found = exports(library)
        counts = (sum(name.startswith(f"fmi{n}") for name in found) for n in (2, 3))
        major, minor = newest_glibc(library)
        print(
            f"{Path(path).name}: {len(library)} bytes, {next(counts)} functions of FMI 2.0 and"
            f" {next(counts)} of FMI 3.0, glibc {major}.{minor} at most"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
