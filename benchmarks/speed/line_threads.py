"""Measure what a second thread could gain in sections and bundles; see ../README.md.

Usage: python benchmarks/speed/line_threads.py
"""

from __future__ import annotations

import ctypes as c
import tempfile
from typing import Any

from lines import line
from speed import compile_kernel_with, heading

from gallop_fmu.engine.ctypes_structs import CScene
from gallop_fmu.engine.pack import Packed

SETTLED, SAMPLES, ROUNDS = 20.0, 40, 4
LINES: dict[str, tuple[int, int]] = {
    "5 spans": (5, 1),
    "10 spans": (10, 1),
    "twin, 1 span": (1, 2),
    "quad, 1 span": (1, 4),
    "10 spans of twins": (10, 2),
    "10 spans of quads": (10, 4),
}
"""Name to the numbers of spans and subconductors; bundles have 6 spacers a span."""

LANES_GAIN = (1.22, 1.66)
"""Gain of forces and solution from four equal chains in lanes, measured by scene_lanes.py."""


class Comparison(c.Structure):
    """The struct `comparison` of line_threads.c."""

    _fields_ = [
        (name, c.c_double)
        for name in (
            "iteration", "factorisation", "iteration_by_two", "factorisation_by_two", "elements",
            "devices", "to_ends", "from_ends", "reduction", "between", "factorisation_between",
            "step", "iterations", "refactorisations", "hand_over", "two_lines", "different"
        )
    ]  # fmt: skip


def least(rounds: list[Comparison]) -> Comparison:
    """The least of each time; the counts are those of the fastest steps."""
    fastest = min(rounds, key=lambda one: one.step)
    times = {name: min(getattr(one, name) for one in rounds) for name, *_ in Comparison._fields_}
    return Comparison(
        **times | {"iterations": fastest.iterations, "refactorisations": fastest.refactorisations}
    )


def row(name: str, found: Comparison) -> str:
    """Shares of a step, what bounds the gain, and the gain with the times of two threads."""
    iterations, factorisations = found.iterations, found.refactorisations
    solution = found.to_ends + found.from_ends
    shared = iterations * (found.elements + found.devices + solution)
    shared += factorisations * found.reduction
    serial = iterations * found.between + factorisations * found.factorisation_between
    one = iterations * found.iteration + factorisations * found.factorisation
    two = iterations * found.iteration_by_two + factorisations * found.factorisation_by_two
    step, rest = found.step, found.step - one
    shared, serial = shared / (shared + serial) * one, serial / (shared + serial) * one
    saved = found.elements * (1.0 - 1.0 / LANES_GAIN[0]) + solution * (1.0 - 1.0 / LANES_GAIN[1])
    lanes = f"{step / (step - iterations * saved):.2f}" if LINES[name][1] == 4 else ""
    cells = (
        name,
        f"{step:.1f}",
        *(f"{part / step:.0%}" for part in (shared, serial, rest)),
        f"{step / (serial + rest + shared / 2):.2f}",
        f"{step / (serial + (rest + shared) / 2):.2f}",
        f"{one / two:.2f}",
        f"{step / (two + rest):.2f}",
        f"{step / (two + rest / 2):.2f}",
        f"{2 * found.iteration / found.two_lines:.2f}",
        f"{found.hand_over:.2f}",
        lanes,
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print a row for each line."""
    heading()
    rounds: dict[str, list[Comparison]] = {name: [] for name in LINES}
    with tempfile.TemporaryDirectory() as folder:
        compare = compile_kernel_with("line_threads.c", folder, "-pthread").line_threads
        compare.argtypes = (c.POINTER(CScene), c.c_double, c.c_int, c.POINTER(Comparison))
        for _ in range(ROUNDS):
            for name, (spans, subconductors) in LINES.items():
                bundle: dict[str, Any] | None = None
                if subconductors > 1:
                    bundle = {"subconductors": subconductors, "spacing": 0.45, "spacers": 6}
                packed, found = Packed(line(spans, bundle)), Comparison()
                if compare(c.byref(packed.scene), SETTLED, SAMPLES, c.byref(found)):
                    raise RuntimeError(f"{name}: the benchmark failed")
                if found.different:
                    raise RuntimeError(f"{name}: two threads have other bits than one")
                rounds[name].append(found)
    print(
        "| Line | µs a step | shared | between | rest | bound | bound, rest shared |"
        " two threads: forces and solution | whole step | whole step, half the rest |"
        " two lines at once | µs a hand-over | subconductors in lanes |\n|"
        + " --- |"
        + " ---: |" * 12
    )
    for name, found_rounds in rounds.items():
        print(row(name, least(found_rounds)))


if __name__ == "__main__":
    main()
