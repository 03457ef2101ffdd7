"""Measure which libraries take the time of a row of `modal.screen_spans`; see ../README.md.

Usage: python benchmarks/speed/screen_share.py

Needs `perf` of Linux, which samples the processor. One thread for linear algebra.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROWS = 8

PROGRAM = f"""
import time
import gallop_fmu as gf
from modal.screening.many_spans import ScreeningTask, row_of
from modal.screening.screen import screen

base, task = gf.load_scene("example3"), ScreeningTask(None)
scenes = [base.with_values({{"wind.speed": 5.0 + 0.1 * k}}) for k in range({ROWS})]
while time.process_time() < 2.5:  # imports and first calls, which perf does not sample
    found = screen(base)
began = time.process_time()
row_of(found)
row = time.process_time() - began
began = time.process_time()
task(scenes, lambda: True)
print(1e3 * (time.process_time() - began) / {ROWS}, 1e3 * row)
"""
"""Prints the processor time [ms] of a row, and of its columns from the screening alone."""

DELAY = 2500
"""Time [ms] before the first sample."""

PARTS = {
    "kernel": r"gallop_kernel",
    "linear algebra (OpenBLAS, LAPACK)": r"openblas|_flapack|_fblas|_umath_linalg",
    "NumPy and SciPy: loops over arrays, and their calls": r"umath|scipy|numpy|libm[.-]",
    "memory": r"libc[.-]|kernel\.kallsyms",
    "Python": r"python",
}
"""Part to the names of its libraries, tried in this order."""


def shares(record: str) -> dict[str, float]:
    """Share [%] of each part of the samples; the rest is "other"."""
    command = ["perf", "report", "-i", record, "--stdio", "--sort", "dso"]
    report = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = dict.fromkeys([*PARTS, "other"], 0.0)
    for percent, name in re.findall(r"^\s*([0-9.]+)%\s+(\S+)", report, re.MULTILINE):
        part = next((part for part, names in PARTS.items() if re.search(names, name)), "other")
        found[part] += float(percent)
    return found


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        record = str(Path(folder) / "samples")
        program = [sys.executable, "-P", "-c", PROGRAM]
        done = subprocess.run(
            ["perf", "record", "-q", "-F", "997", "-D", str(DELAY), "-o", record, *program],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
        whole, row = map(float, done.stdout.split())
        print(f"A row takes {whole:.0f} ms; its columns from the screening {row:.2f} ms.\n")
        print("| part | share of the samples, % |")
        print("| --- | ---: |")
        for part, share in shares(record).items():
            print(f"| {part} | {share:.0f} |")


if __name__ == "__main__":
    main()
