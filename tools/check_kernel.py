"""Check the rules of the kernel: no compiler warnings, names with prefixes, layers, no circles.

    python tools/check_kernel.py

Compiles every C file with each of gcc and clang that is installed. Then, of the files and of the
symbols that `nm` lists:

- names: a function that the library exports starts with `gallop_`, `fmi2` or `fmi3`; any other
  function or constant that several files share starts with the subject of its file, which is the
  part of the file's name before the first underscore;
- layers: a file includes only headers of its own layer or of a lower one (`LAYERS`);
- paths: a function that is compiled for two paths (TWO_PATHS) is static;
- circles: neither the headers' includes nor the calls between C files form a circle.
"""

from __future__ import annotations

import argparse
import graphlib
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

KERNEL = Path(__file__).resolve().parents[1] / "gallop_fmu" / "kernel"

LAYERS = (
    ("gallop", "base"),
    ("report", "law", "history", "team"),
    ("model", "conditions", "state", "check"),
    ("device", "element", "junction", "system"),
    ("solver", "observe"),
    ("statics", "time"),
    ("analysis", "model_create", "model_create_parts", "model_create_wind"),
    ("resource",),
    ("cosim",),
    ("fmi",),
    ("fmi2", "fmi3"),
)
"""Subjects, or single files, from the lowest layer to the highest."""

EXPORTED = ("gallop_", "fmi2", "fmi3")
"""Prefixes of the functions that the library exports."""

COMPILERS = ("gcc", "clang")
FLAGS = (
    "-std=c11", "-O1", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno",
    "-fno-trapping-math", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror",
)  # fmt: skip


def fmi_headers() -> Path:
    """Folder of the headers of FMI, which the package fmpy brings along."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or spec.origin is None:
        raise SystemExit("check_kernel: fmpy is not installed; pip install fmpy")
    return Path(spec.origin).parent / "c-code"


def warnings_of(kernel: Path, compiler: str, objects: Path) -> list[str]:
    """Compile all C files into a folder; return what the compiler complains about."""
    found = []
    for source in sorted(kernel.glob("*.c")):
        command = [compiler, *FLAGS, f"-I{kernel}", "-isystem", str(fmi_headers())]
        done = subprocess.run(
            [*command, "-c", str(source), "-o", str(objects / f"{source.stem}.o")],
            capture_output=True,
            text=True,
        )
        if done.returncode:
            found.append(f"{compiler} refuses {source.name}:\n{done.stderr}")
    return found


def symbols(objects: Path) -> dict[str, tuple[set[str], set[str]]]:
    """Global symbols that each object file defines, and those that it needs."""
    found = {}
    for path in sorted(objects.glob("*.o")):
        lines = subprocess.run(
            ["nm", "-g", "-P", str(path)], capture_output=True, text=True, check=True
        ).stdout.splitlines()
        kinds = [line.split()[:2] for line in lines]
        needed = {name for name, kind in kinds if kind in "Uw"}
        found[path.stem] = ({name for name, _ in kinds} - needed, needed)
    return found


def exports(objects: Path) -> set[str]:
    """Symbols that a shared library of the object files exports."""
    library = objects / "library.so"
    sources = map(str, sorted(objects.glob("*.o")))
    subprocess.run(["cc", "-shared", "-o", str(library), *sources, "-lm"], check=True)
    lines = subprocess.run(
        ["nm", "-D", "-P", "--defined-only", str(library)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    return {line.split()[0] for line in lines}


def subject(stem: str) -> str:
    """Subject of a file: `time` of time_gauss."""
    return stem.split("_")[0]


def wrong_names(defined: dict[str, tuple[set[str], set[str]]], exported: set[str]) -> list[str]:
    """Exported names without their prefix, and internal names without their file's subject."""
    found = []
    for stem, (names, _) in defined.items():
        for name in sorted(names):
            if name in exported:
                if not name.startswith(EXPORTED):
                    found.append(f"{stem}.c exports {name}; a prefix of {EXPORTED} is missing")
            elif not name.startswith(f"{subject(stem)}_"):
                found.append(
                    f"{stem}.c shares {name}; call it {subject(stem)}_{name}, or make it static"
                )
    return found


def layer(stem: str) -> int | None:
    """Number of the layer of a file, from 0 at the bottom; None if it has no layer."""
    for name in (stem, subject(stem)):
        for number, subjects in enumerate(LAYERS):
            if name in subjects:
                return number
    return None


def included(path: Path) -> set[str]:
    """Headers of the kernel that a file includes."""
    return set(re.findall(r'^#include "([^"]+)"', path.read_text("utf-8"), re.MULTILINE))


def wrong_includes(kernel: Path) -> list[str]:
    """Files without a layer, and includes of headers of a higher layer."""
    found = []
    for path in sorted(kernel.glob("*.[ch]")):
        own = layer(path.stem)
        if own is None:
            found.append(f"{path.name}: add its subject, {subject(path.stem)}, to LAYERS")
            continue
        for header in sorted(included(path)):
            other = layer(Path(header).stem)
            if other is not None and other > own:
                found.append(f"{path.name} includes {header} of a higher layer")
    return found


def circle(graph: dict[str, set[str]], what: str) -> list[str]:
    """One circle of a graph, if it has any."""
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return [f"a circle of {what}: {' -> '.join(reversed(error.args[1]))}"]
    return []


def circles(kernel: Path, defined: dict[str, tuple[set[str], set[str]]]) -> list[str]:
    """Circles of the headers' includes and of the calls between the C files."""
    headers = {path.name: included(path) for path in kernel.glob("*.h")}
    home = {name: stem for stem, (names, _) in defined.items() for name in names}
    calls = {
        stem: {home[name] for name in needed if name in home} - {stem}
        for stem, (_, needed) in defined.items()
    }
    return circle(headers, "includes") + circle(calls, "calls")


def exported_paths(kernel: Path) -> list[str]:
    """Functions with TWO_PATHS that are not static: gcc exports those in spite of -fvisibility."""
    return [
        f"{path.name}: {line.split('(')[0]} is compiled for two paths and not static"
        for path in sorted(kernel.glob("*.[ch]"))
        for line in path.read_text().splitlines()
        if line.startswith("TWO_PATHS ") and not line.startswith("TWO_PATHS static ")
    ]


def problems(kernel: Path) -> list[str]:
    """All violations of the rules in a folder of C files."""
    available = [compiler for compiler in COMPILERS if shutil.which(compiler)]
    if not available:
        raise SystemExit("check_kernel: neither gcc nor clang is installed")
    found = wrong_includes(kernel) + exported_paths(kernel)
    with tempfile.TemporaryDirectory() as folder:
        objects = Path(folder)
        for compiler in available:
            found += warnings_of(kernel, compiler, objects)
        defined = symbols(objects)
        found += circles(kernel, defined)
        if len(defined) == len(list(kernel.glob("*.c"))):  # all of it can be linked
            found += wrong_names(defined, exports(objects))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kernel", type=Path, nargs="?", default=KERNEL, help="folder of C files")
    kernel = parser.parse_args().kernel
    found = problems(kernel)
    if found:
        sys.exit("\n".join(found))
    print(f"{len(list(kernel.glob('*.[ch]')))} files keep the rules")


if __name__ == "__main__":
    main()
