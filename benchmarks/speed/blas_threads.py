"""Processor time and time of long functions with one thread of OpenBLAS, and with all.

Prints a table for example 3 and for the section of example 15, the smaller of two runs each, which
alternate.

Usage: python benchmarks/speed/blas_threads.py (about a minute)
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from unittest import mock

import numpy as np

import gallop_fmu as gf
import modal
from modal.foundation import one_thread

TOWERS = Path(__file__).parents[2] / "examples" / "15_towers.csv"
OPTIONS = "--conductor Drake --stringing-percent 20 --ice-thickness 0.006 --attack-angle-deg 10"


def main() -> None:
    """Measure and print."""
    span, line = gf.load_scene("example3").with_values({"wind.speed": 5.5}), section()
    print("| | processor time, one thread | all | time, one thread | all |")
    print("| --- | --- | --- | --- | --- |")
    for name, function in {
        "critical winds of a span": lambda: modal.critical_wind_speed(span),
        "screening of a span": lambda: modal.screen(span),
        "branches of a span": lambda: modal.branches(span, "wind.speed", 4.5, 5.2),
        "modes of a line": lambda: modal.natural_modes(line),
        "screening of a line": lambda: modal.screen(line),
    }.items():
        runs = [(*seconds(function), *seconds(function, limited=False)) for _ in range(2)]
        one_cpu, one, all_cpu, all_ = np.min(runs, axis=0)
        print(f"| {name} | {one_cpu:.2f} s | {all_cpu:.2f} s | {one:.2f} s | {all_:.2f} s |")


def section() -> gf.LineScene:
    """Section of example 15 in 4 m/s."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "section.toml"
        command = [Path(sys.executable).with_name("gallop-fmu"), "new", file, "--section", TOWERS]
        options = [*OPTIONS.split(), "--wind-speed", "4", "--coefficients", "example2"]
        subprocess.run([*command, *options], check=True, stdout=subprocess.DEVNULL)
        scene = gf.load_scene(file)
    assert isinstance(scene, gf.LineScene)
    return scene


def seconds(function: Callable[[], object], limited: bool = True) -> tuple[float, float]:
    """Processor time and time [s] of a call."""
    limit = one_thread.limit_to_one_thread if limited else nullcontext
    with mock.patch.object(one_thread, "limit_to_one_thread", limit):
        cpu, wall = time.process_time(), time.perf_counter()
        function()
        return time.process_time() - cpu, time.perf_counter() - wall


if __name__ == "__main__":
    main()
