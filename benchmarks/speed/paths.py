"""Compare fused with portable arithmetic, and with an earlier release; see ../README.md.

Usage: python benchmarks/speed/paths.py [PYTHON]

PYTHON is the interpreter of an environment with another release; it runs example 3, alternating
with this one. Processor times; medians of the ratios of pairs, with their range.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from typing import Any

from lines import line

import gallop_fmu as gf
from gallop_fmu.engine.library import arithmetic
from gallop_fmu.engine.model import Model

PAIRS = 11

OTHER = """
import sys, time
import gallop_fmu as gf
from gallop_fmu.engine.model import Model
step = float(sys.argv[1])
scene = gf.load_scene("example3").with_values({"numerics.time_step": step})
state = Model(scene).start()
state.advance(20.0)
began = time.process_time()
state.advance(1220.0)
print(1200.0 / (time.process_time() - began))
"""
"""Prints how many times faster than real time example 3 is computed."""


def cases() -> dict[str, tuple[Any, float]]:
    """Scenes, and the time [s] that they are run for."""
    moved = {"initial.seed_vertical": 0.1, "initial.seed_horizontal": 0.01}
    third = gf.load_scene("example3").with_values(moved)
    gauss = {"numerics.integrator": "gauss6", "numerics.time_step": 0.05}
    return {
        "example 1": (gf.load_scene("example1"), 20.0),
        "example 2": (gf.load_scene("example2").with_values(moved), 50.0),
        "example 3": (third, 100.0),
        "example 3, step 0.02 s": (third.with_values({"numerics.time_step": 0.02}), 100.0),
        "example 3, Gauss, 0.05 s": (third.with_values(gauss), 20.0),
        "3 spans on strings, 0.02 s": (line(3), 20.0),
        "twin bundle, 3 spacers, 0.02 s": (
            line(1, {"subconductors": 2, "spacing": 0.45, "spacers": 3}),
            20.0,
        ),
    }


def run_time(model: Model, seconds: float) -> float:
    """Processor time [s] of a run, without its start."""
    state = model.start()
    began = time.process_time()
    state.advance(seconds)
    return time.process_time() - began


def spread(ratios: list[float]) -> str:
    """Median and range."""
    return f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"


def compare_paths() -> None:
    """Print the speed of both kinds of arithmetic for all scenes."""
    print("| Scene | Times faster than real time | Fused / portable |\n| --- | ---: | ---: |")
    for name, (scene, seconds) in cases().items():
        fused = Model(scene)
        portable = Model(scene.with_values({"numerics.portable": True}))
        pairs = [(run_time(fused, seconds), run_time(portable, seconds)) for _ in range(PAIRS)]
        ratios = [other / own for own, other in pairs]
        speed = seconds / statistics.median(own for own, _ in pairs)
        print(f"| {name} | {speed:.0f} | {spread(ratios)} |")


def compare_with(python: str) -> None:
    """Print the speed of example 3 relative to another release."""

    def speed(interpreter: str, step: str) -> float:
        command = [interpreter, "-P", "-c", OTHER, step]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        return float(done.stdout)

    for step in ("0.01", "0.02"):
        pairs = [(speed(sys.executable, step), speed(python, step)) for _ in range(PAIRS)]
        ratios = [own / other for own, other in pairs]
        print(f"example 3, step {step} s: {spread(ratios)} times the speed of the other release")


def main() -> None:
    print(f"{arithmetic(portable=False)} arithmetic on this processor")
    compare_paths()
    for python in sys.argv[1:2]:
        compare_with(python)


if __name__ == "__main__":
    main()
