"""List the lines of the kernel that the tests execute: build with gcc --coverage, run, print.

    python tools/coverage.py                    # the quick folders of the tests
    python tools/coverage.py tests/unit -k laws # any arguments of pytest

A copy of the packages, with that kernel, precedes the installed ones. So the
tests load it the usual way, in their own process, in those they start, and inside the FMUs they
export. Programs that tests compile themselves (sanitizers, fuzzing targets) are not counted.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("unit", "property", "native", "fmu", "convergence", "analytic")
FLAGS = (
    "-std=c11",
    "-O1",
    "-g",
    "--coverage",
    "-fprofile-update=atomic",
    "-ffp-contract=off",
    "-DGALLOP_ONE_PATH",
)
WANTED = 95.0
"""Percent of lines that a kernel is expected to have covered."""

Lines = dict[str, dict[int, int]]
"""File name to line number to how often it was executed."""


def build(kernel: Path, objects: Path) -> None:
    """Compile the kernel of a copy; counts are kept in `objects`."""
    found = importlib.util.find_spec("fmpy")
    assert found is not None
    assert found.origin is not None
    headers = Path(found.origin).parent / "c-code"
    compile_one: list[str | Path] = [
        "gcc",
        *FLAGS,
        "-fPIC",
        "-fvisibility=hidden",
        f"-I{headers}",
        "-c",
    ]
    for source in sorted(kernel.glob("*.c")):
        subprocess.run(
            [*compile_one, source, "-o", objects / f"{source.stem}.o"], cwd=objects, check=True
        )
    library = kernel.parent / "gallop_kernel.so"
    link: list[str | Path] = [
        "gcc",
        "--coverage",
        "-shared",
        "-Wl,-Bsymbolic",
        *sorted(objects.glob("*.o")),
        "-o",
        library,
        "-lm",
    ]
    subprocess.run(link, check=True)


def executed(objects: Path) -> Lines:
    """Counts of gcov."""
    lines: Lines = defaultdict(lambda: defaultdict(int))
    for data in sorted(objects.glob("*.gcda")):
        done = subprocess.run(
            ["gcov", "--json-format", "--stdout", data],
            cwd=objects,
            capture_output=True,
            check=True,
        )
        for report in done.stdout.splitlines():
            for file in json.loads(report)["files"]:
                for line in file["lines"]:
                    lines[Path(file["file"]).name][line["line_number"]] += line["count"]
    return lines


def ranges(numbers: list[int]) -> str:
    """Numbers as ``3-5 9``."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return " ".join(str(part[0]) if len(part) == 1 else f"{part[0]}-{part[-1]}" for part in parts)


def show(lines: Lines) -> float:
    """Print the table; the covered percentage of all lines."""
    print(f"{'file':16s} {'lines':>6s} {'run':>6s} {'%':>6s}  not executed")
    total = covered = 0
    for name, counts in sorted(lines.items()):
        missed = sorted(number for number, count in counts.items() if not count)
        total, covered = total + len(counts), covered + len(counts) - len(missed)
        share = 100.0 * (1.0 - len(missed) / len(counts))
        print(
            f"{name:16s} {len(counts):6d} {len(counts) - len(missed):6d} {share:6.1f} "
            f" {ranges(missed)}"
        )
    share = 100.0 * covered / total
    print(f"{'all':16s} {total:6d} {covered:6d} {share:6.1f}")
    return share


def main(arguments: list[str]) -> int:
    """Build, test, count."""
    with tempfile.TemporaryDirectory(prefix="coverage_") as name:
        copy, objects = Path(name) / "packages", Path(name) / "objects"
        objects.mkdir()
        for package in ("gallop_fmu", "modal"):
            shutil.copytree(
                ROOT / package, copy / package, ignore=shutil.ignore_patterns("__pycache__", "*.so")
            )
        build(copy / "gallop_fmu" / "kernel", objects)
        environment = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
        tests = arguments or [f"tests/{folder}" for folder in FOLDERS]
        done = subprocess.run(
            [sys.executable, "-P", "-m", "pytest", "-q", *tests], cwd=ROOT, env=environment
        )
        share = show(executed(objects))
    if done.returncode:
        print("some tests failed", file=sys.stderr)
    return int(done.returncode != 0 or share < WANTED)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
