"""Thousands of spans: table, estimates, sweep, resumption; see ../README.md.

Usage: python benchmarks/speed/corridor.py
"""

from __future__ import annotations

import csv
import os
import resource
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import gallop_fmu as gf
import modal

SPANS = 2000
SIMULATED = 1000
COMPARED = 100
HIGHEST_WIND = 8.0
LINE = """\
[line]
stringing_percent = 20.0
attack_angle_deg = 178.0
coefficients = "example3"
ice_thickness = 0.01

[numerics]
time_step = 0.02
"""
COLUMNS = ("name", "label.structure", "line.conductor", "line.span", "line.height_difference")
COLUMNS += ("line.ice_thickness", "line.wind_speed")


def write_table(path: Path) -> None:
    """A corridor as a line's records might give it, drawn once and for all."""
    random = np.random.default_rng(7)
    words = random.choice(["Drake", "Hawk", "Rail", "Cardinal"], SPANS)
    spans, heights = random.uniform(80.0, 400.0, SPANS), random.normal(0.0, 4.0, SPANS)
    ice, winds = random.uniform(0.002, 0.02, SPANS), random.uniform(3.0, 8.0, SPANS)
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for k in range(SPANS):
            numbers = (f"{value[k]:.4g}" for value in (spans, heights, ice, winds))
            writer.writerow([f"S{k:04d}", "suspension", words[k], *numbers])


def measured(name: str, count: int, work: Callable[[], Any]) -> Any:
    """Measure CPU time (with child processes), wall-clock time and growth of memory of a call."""
    memory, before, began = resident(), os.times(), time.perf_counter()
    result = work()
    after, wall = os.times(), time.perf_counter() - began
    cpu = sum(after[:4]) - sum(before[:4])
    grown = (resident() - memory) / 1e6
    print(
        f"| {name} | {count} | {cpu:.1f} | {1e3 * cpu / count:.2f} | {wall:.1f} | {grown:+.0f} |",
        flush=True,
    )
    return result


def resident() -> float:
    """Memory of this program [bytes]; the peak where the system does not report the present one."""
    try:
        return float(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
    except OSError:
        return 1e3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="gallop-"))
    scene, table = folder / "corridor.toml", folder / "spans.csv"
    scene.write_text(LINE)
    write_table(table)
    print(
        f"{table.name}: {table.stat().st_size / 1e3:.0f} kB, {table.stat().st_size / SPANS:.0f}"
        " bytes a span\n"
    )
    print("| work | spans or runs | CPU s | CPU ms each | wall-clock s | memory MB |")
    print("| --- " + "| ---: " * 5 + "|")
    gf.sweep(
        scene,
        {"line.span": [100.0], "line.conductor": ["Drake"]},
        stop_time=1.0,
        out=folder / "imports.parquet",
    )
    rows = measured("read the table", SPANS, lambda: gf.read_spans(table))
    risk = folder / "first.parquet"

    def look() -> gf.Runs:
        return modal.screen_spans(
            scene, table=table, highest_wind=HIGHEST_WIND, estimate_only=True, out=risk
        )

    found = measured("estimate only", SPANS, look).dataset
    measured("the same again, complete", SPANS, look)
    print(f"\n{risk.name}: {risk.stat().st_size / 1e3:.0f} kB")
    suspect = found.suspect.values == 1.0
    print(
        f"{found.sizes['run']} rows, {int(suspect.sum())} suspect,"
        f" {int((found.outcome.values != 'completed').sum())} not"
    )

    for suffix in (".parquet", ".nc"):
        out = folder / f"runs{suffix}"

        def simulated(out: Path = out) -> gf.Runs:
            return gf.sweep(scene, table=rows[:SIMULATED], stop_time=5.0, window=4.0, out=out)

        runs = measured(f"sweep of 5 s, {suffix}", SIMULATED, simulated)
        measured("the same again, complete", SIMULATED, simulated)
        computed = float(np.nansum(runs.dataset.seconds)) / SIMULATED
        print(
            f"{out.name}: {out.stat().st_size / 1e3:.0f} kB; {1e3 * computed:.2f} ms wall-clock a"
            " run in its thread"
        )
    compare(scene, rows, found)
    threads()


def compare(scene: Path, rows: list[dict[str, Any]], found: Any) -> None:
    """Compare the spans that the estimate suspects with the full screening."""
    part = rows[:COMPARED]
    full = measured(
        "full screening",
        COMPARED,
        lambda: modal.screen_spans(scene, table=part, highest_wind=HIGHEST_WIND),
    ).dataset
    swings = np.isfinite(full.onset_wind_speed.values)
    suspect = found.suspect.values[:COMPARED] == 1.0
    print(f"\nof {COMPARED}: {int(swings.sum())} swing, {int(suspect.sum())} suspect,")
    print(
        f"{int((swings & ~suspect).sum())} swing unsuspected, {int((suspect & ~swings).sum())}"
        " suspected in vain"
    )
    for risk in sorted(set(full.risk.values)):
        print(risk or "not screened", int((full.risk.values == risk).sum()))


def threads() -> None:
    """Check that the kernel releases the interpreter lock: calls that end during another call.

    Holds on a busy machine too: while the lock is held, the count would be zero.
    """
    scene = gf.load_scene("example3")
    channels, nodes = np.array([0], dtype=np.int32), np.array([15], dtype=np.int32)
    long, short = (gf.Model(scene, inputs=False).start() for _ in range(2))
    ended, over = [], threading.Event()

    def small_calls() -> None:
        while not over.is_set():
            short.run(1, 20, channels, nodes)
            ended.append((time.perf_counter(), time.thread_time()))

    other = threading.Thread(target=small_calls)
    other.start()
    began, spent = time.perf_counter(), time.thread_time()
    long.run(10, 20_000, channels, nodes)
    finished, spent = time.perf_counter(), time.thread_time() - spent
    over.set()
    other.join()
    within = [cpu for at, cpu in ended if began < at < finished]
    print(
        f"\none call of the kernel: {finished - began:.2f} s, {spent:.2f} s of CPU; meanwhile"
        f" another thread ended {len(within)} calls in {within[-1] - within[0]:.2f} s of CPU"
    )


if __name__ == "__main__":
    main()
