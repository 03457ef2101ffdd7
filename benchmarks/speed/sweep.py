"""Measure the throughput of sweeps and screenings; see ../README.md.

Usage: python benchmarks/speed/sweep.py
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable

import numpy as np

import gallop_fmu as gf
import modal

REPEATS = 5
RUNS = 24
STOP_TIME = 1000.0
SPANS = 12


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Wall-clock and CPU time [s] of this process and its children."""
    before, began = os.times(), time.perf_counter()
    work()
    after = os.times()
    cpu = sum(after[:4]) - sum(before[:4])
    return time.perf_counter() - began, cpu


def spread(values: list[float]) -> str:
    """Least, median and greatest."""
    return " | ".join(
        f"{value:.3g}" for value in (min(values), statistics.median(values), max(values))
    )


def compare(ways: dict[str, Callable[[], object]], runs: int, unit: str) -> None:
    """Time the ways in turn; ratios are from the same round, so that other load affects both."""
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for _ in range(REPEATS):
        for name, work in ways.items():
            spent[name].append(timed(work))
    first = next(iter(ways))
    print(
        f"| {unit} | CPU s a {unit}: least | median | greatest | {unit}s a wall-clock second,"
        " median | wall-clock, times the first: least | median | greatest | cores kept busy,"
        " median |"
    )
    print("| --- " + "| ---: " * 8 + "|")
    for name, values in spent.items():
        gain = [one[0] / other[0] for one, other in zip(spent[first], values, strict=True)]
        rate = statistics.median(runs / wall for wall, _ in values)
        busy = statistics.median(cpu / wall for wall, cpu in values)
        print(
            f"| {name} | {spread([cpu / runs for _, cpu in values])} | {rate:.3g} | {spread(gain)}"
            f" | {busy:.2f} |"
        )
    print()


def sweeps() -> None:
    """A plain loop over `simulate`, against `sweep`."""
    winds = list(np.linspace(4.0, 6.0, RUNS))
    base = gf.load_scene("example3").with_values(
        {"numerics.time_step": 0.02, "run.record_every": 3}
    )

    def loop() -> None:
        for wind in winds:
            gf.simulate(base.with_values({"wind.speed": wind}), STOP_TIME).steady(100.0)

    def swept(workers: int) -> Callable[[], object]:
        return lambda: gf.sweep(base, {"wind.speed": winds}, stop_time=STOP_TIME, workers=workers)

    compare(
        {"plain loop": loop, "sweep, 1 thread": swept(1), "sweep, 2 threads": swept(2)}, RUNS, "run"
    )


def screenings() -> None:
    """A plain loop over `screen`, against `screen_spans`."""
    table = [
        {"span.sag": sag, "span.horizontal_tension": "none", "span.length": length}
        for sag, length in zip(
            np.linspace(1.8, 2.6, SPANS), np.linspace(115.0, 140.0, SPANS), strict=True
        )
    ]
    base = gf.load_scene("example3")

    def loop() -> None:
        for changes in table:
            modal.screen(base.with_values(changes), 6.5)

    def screened(workers: int) -> Callable[[], object]:
        return lambda: modal.screen_spans(base, table=table, highest_wind=6.5, workers=workers)

    ways = {
        "plain loop": loop,
        "screen_spans, 1 process": screened(1),
        "screen_spans, 2 processes": screened(2),
    }
    compare(ways, SPANS, "span")


def overhead() -> None:
    """Measure the overhead of a thousand runs: journal, file, table."""
    base = gf.load_scene("example3").with_values(
        {"numerics.elements": 2, "numerics.time_step": 0.02}
    )
    winds = list(np.linspace(4.0, 6.0, 1000))

    def loop() -> None:
        for wind in winds:
            gf.simulate(base.with_values({"wind.speed": wind}), 1.0)

    compare(
        {
            "plain loop": loop,
            "sweep, 1 thread": lambda: gf.sweep(
                base, {"wind.speed": winds}, stop_time=1.0, workers=1
            ),
        },
        1000,
        "run",
    )


if __name__ == "__main__":
    gf.sweep("example3", {"wind.speed": [5.0]}, stop_time=1.0)  # imports
    sweeps()
    overhead()
    screenings()
