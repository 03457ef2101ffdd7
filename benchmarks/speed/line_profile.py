"""Profile the kernel on a span, a section and a bundle; see ../README.md.

Usage: python benchmarks/speed/line_profile.py

Compiles the kernel with the names of its functions (gcc) and samples it with `perf` (Linux).
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from speed import FLAGS, KERNEL

CASES = {
    "single span": ("line(1)", 4000.0),
    "10 spans on strings": ("line(10)", 400.0),
    "quad, 6 spacers": ("line(1, {'subconductors': 4, 'spacing': 0.45, 'spacers': 6})", 1000.0),
    "10 spans of quads": ("line(10, {'subconductors': 4, 'spacing': 0.45, 'spacers': 6})", 100.0),
}

PARTS = {
    "forces of elements, wind and ice": (
        "interval_of", "loads", "ice_inertia", "look_at", "choose",
    ),
    "factorisation: chains": (
        "strip_of", "loads_with_slopes", "condense", "reduce_segments", "eliminate", "add_tangent",
        "ice_tangent", "frame",
    ),
    "factorisation: junctions": ("factor_junctions", "junctions_add", "fold"),
    "solution: chains": ("solve_corners", "solve_middles", "correct_middles", "correct_corners"),
    "solution: junctions": ("solve_junctions",),
}  # fmt: skip
"""Part of a step to the beginnings of names of functions; the first part that fits counts."""

RUN = """
import ctypes, sys
sys.path.insert(0, sys.argv[1])
load = ctypes.CDLL
def choose(path, *options, **names):
    return load(sys.argv[2] if "gallop_kernel" in str(path) else path, *options, **names)
ctypes.CDLL = choose
from lines import line
from gallop_fmu.engine.model import Model
report = Model({scene}).start().advance({seconds})
print(report.iterations / report.steps, report.refactorisations / report.steps)
"""


def profile(library: Path, folder: Path, scene: str, seconds: float) -> tuple[Counter[str], str]:
    """Share of each part in the samples of the kernel, and iterations and factorisations a step."""
    data = folder / "perf.data"
    code = RUN.format(scene=scene, seconds=seconds)
    run = [sys.executable, "-P", "-c", code, str(Path(__file__).parent), str(library)]
    record = ["perf", "record", "-q", "-e", "cpu-clock", "-F", "1000", "-o", str(data), *run]
    done = subprocess.run(record, check=True, capture_output=True, text=True)
    report = ["perf", "report", "-i", str(data), "--stdio", "--sort", "dso,symbol"]
    text = subprocess.run(report, check=True, capture_output=True, text=True).stdout
    found: Counter[str] = Counter()
    for line in text.splitlines():
        words = line.split()
        if len(words) < 4 or words[1] != library.name or not words[0].endswith("%"):
            continue
        name = words[3].removeprefix("run_")
        part = next(
            (part for part, names in PARTS.items() if any(n in name for n in names)), "the rest"
        )
        found[part] += float(words[0][:-1])
    return found, done.stdout.strip()


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        library = folder / "kernel.so"
        sources = [str(path) for path in KERNEL.glob("*.c") if not path.name.startswith("fmi")]
        subprocess.run(["gcc", *FLAGS, "-g", "-o", str(library), *sources, "-lm"], check=True)
        parts = [*PARTS, "the rest"]
        print("| Line | " + " | ".join(parts) + " | iterations, factorisations a step |")
        print("| --- |" + " ---: |" * (len(parts) + 1))
        for case, (scene, seconds) in CASES.items():
            found, counts = profile(library, folder, scene, seconds)
            shares = [f"{found[part] / found.total():.0%}" for part in parts]
            work = ", ".join(f"{float(count):.2f}" for count in counts.split())
            print(f"| {case} | " + " | ".join(shares) + f" | {work} |")


if __name__ == "__main__":
    main()
