"""Measure what a second thread gains in sections and bundles; see ../README.md.

Usage: python benchmarks/speed/line_threads.py
"""

from __future__ import annotations

import ctypes as c
import statistics
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from lines import line
from speed import compile_kernel_with, heading

from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import node_probes
from gallop_fmu.engine.state import State
from gallop_fmu.foundation.outcome import Outcome, SimulationError

SETTLED, SAMPLE, PAIRS = 10.0, 0.1, 9
"""Time [s] before the first sample, wall-clock time [s] of a sample, and number of pairs."""

LINES: dict[str, tuple[int, int, int]] = {
    "5 spans": (5, 1, 15),
    "10 spans": (10, 1, 15),
    "20 spans": (20, 1, 15),
    "40 spans": (40, 1, 15),
    "4 spans, 40 elements each": (4, 1, 40),
    "10 spans, 40 elements each": (10, 1, 40),
    "20 spans, 40 elements each": (20, 1, 40),
    "quad, 1 span of 60 elements": (1, 4, 60),
    "10 spans of twins": (10, 2, 15),
    "10 spans of quads": (10, 4, 15),
    "10 spans of quads, 40 elements": (10, 4, 40),
}
"""Name to the numbers of spans, subconductors, elements a span; bundles have 6 spacers a span."""

PROBES = node_probes(np.array([3], dtype=np.int32), np.array([1], dtype=np.int32))


def model_of(spans: int, subconductors: int, elements: int) -> Model:
    """A line, galloping in its wind."""
    bundle: dict[str, Any] | None = None
    if subconductors > 1:
        bundle = {"subconductors": subconductors, "spacing": 0.45, "spacers": 6}
    values = {"numerics.elements": elements, "aerodynamics.outside": "hold"}
    scene = line(spans, bundle).with_values(values)
    return Model(scene, inputs=False)


def seconds(state: State, steps: int, threads: int) -> float:
    """Wall-clock time [s] of so many steps."""
    began = time.perf_counter()
    _, report = state.record(1, steps, PROBES, threads=threads)
    taken = time.perf_counter() - began
    if report.outcome is not Outcome.COMPLETED:
        raise SimulationError(report)
    return taken


def row(name: str, model: Model, hand_over: Callable[[], float]) -> str:
    """Time of a step in one thread and in two, and the gain."""
    states = {threads: model.start() for threads in (1, 2)}
    for state in states.values():
        state.advance(SETTLED)
    steps = max(2, int(SAMPLE / seconds(states[1], 50, 1) * 50))
    seconds(states[2], 50, 2)
    times: dict[int, list[float]] = {1: [], 2: []}
    hand_overs = [hand_over()]
    for _ in range(PAIRS):
        for threads, state in states.items():
            times[threads].append(seconds(state, steps, threads))
    hand_overs.append(hand_over())
    if states[1].save() != states[2].save():
        raise RuntimeError(f"{name}: two threads have other bits than one")
    gains = [one / two for one, two in zip(*times.values(), strict=True)]
    low, median, high = statistics.quantiles(gains, n=4)
    least = {threads: min(of) / steps * 1e6 for threads, of in times.items()}
    cells = (
        name,
        f"{model.elements}",
        f"{least[1]:.1f}",
        f"{least[2]:.1f}",
        f"{least[1] / least[2]:.2f}",
        f"{median:.2f} ({low:.2f} to {high:.2f})",
        f"{min(hand_overs):.2f} to {max(hand_overs):.2f}",
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print a row for each line that two threads can share."""
    heading()
    print(
        "| Line | Elements | One thread [µs a step] | Two | Gain: of the least times"
        " | median of pairs (quartiles) | µs to a core and back |\n| --- |"
        + " ---: |" * 4
        + " --- |" * 2
    )
    with tempfile.TemporaryDirectory() as folder:
        hand_over = compile_kernel_with("hand_over.c", folder, "-pthread").hand_over
        hand_over.restype = c.c_double
        for name, of in LINES.items():
            print(row(name, model_of(*of), hand_over), flush=True)


if __name__ == "__main__":
    main()
