"""Cost and convergence of a risk atlas of many draws; see docs/how-to/risk_atlas.md.

The span is that of `tests/support/cubic_galloping.py`: the probabilities of galloping and of a
clash follow from an integral. With --out the same command continues after Ctrl-C; the time of the
draws themselves is then that of all parts, the others are those of the last one.

Usage: python benchmarks/speed/atlas.py [--draws 131072] [--out runs.nc]
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

import gallop_fmu as gf
import modal

sys.path.append(str(Path(__file__).parents[2]))
from tests.support.cubic_galloping import Cubic, scene

WIND = {"distribution": "weibull_min", "c": 2.0, "scale": 6.0}
ANGLE = {"distribution": "uniform", "loc": 170.0, "scale": 20.0}
CLEARANCE = 1.0
OTHERS = 2048
"""Draws of the cases whose cost alone is measured."""


def main() -> None:
    """Print the cost of draws, then the probabilities over the number of draws."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--draws", type=int, default=1 << 17)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    print("| Random | Draws | Time of a draw [ms] | CPU time [s] | Wall time [s] |")
    print("| --- | --- | --- | --- | --- |")
    angle = {"wind.speed": WIND, "ice.attack_angle_deg": ANGLE}
    found = measured("wind, cubic curve", scene(), {"wind.speed": WIND}, given.draws, given.out)
    measured("wind and angle of the ice, example3", gf.load_scene("example3"), angle, OTHERS)
    peak = sum(resource.getrusage(who).ru_maxrss for who in (0, -1)) / 1024
    print(f"\nmemory: {peak:.0f} MB; unresolved draws: {found.dataset.unresolved.item():.3%}\n")
    compare(found)


def measured(
    name: str, span: gf.Scene, random: dict[str, Any], draws: int, out: Path | None = None
) -> modal.RiskAtlas:
    """Compute an atlas and print what it cost, with child processes."""
    before, began = os.times(), time.perf_counter()
    found = modal.risk_atlas(
        span, random, draws=draws, clearance=CLEARANCE, out=out, progress=shown
    )
    cpu, wall = sum(os.times()[:4]) - sum(before[:4]), time.perf_counter() - began
    each = 1e3 * found.runs.dataset.seconds.values
    print(
        f"| {name} | {draws} | {np.mean(each):.1f} (median {np.median(each):.1f}) | {cpu:.0f} |"
        f" {wall:.0f} |",
        flush=True,
    )
    return found


def shown(done: int, failed: int, total: int) -> None:
    """Print the progress in a terminal."""
    if sys.stderr.isatty():
        print(f"\r{done} of {total}, {failed} failed ", end="", file=sys.stderr)


def compare(found: modal.RiskAtlas) -> None:
    """Print the probabilities with their intervals, and the exact ones."""
    wind, exact, data = stats.weibull_min(2.0, scale=6.0), Cubic(), found.dataset.isel(span=0)
    speeds = np.linspace(exact.begins_at, 40.0, 400)
    clash_from = np.interp(0.5 * CLEARANCE, [exact.amplitude(u) for u in speeds], speeds)
    print("| Draws | Probability of galloping | 95 % interval |\n| --- | --- | --- |")
    for draws in data.draws.values.tolist()[1::3]:
        at = data.sel(draws=draws)
        ends = [at[f"galloping_of_draws{end}"].item() for end in ("_lowest", "_highest")]
        print(f"| {draws} | {at.galloping_of_draws.item():.5f} | {ends[0]:.5f} to {ends[1]:.5f} |")
    print(f"| exact | {wind.sf(exact.begins_at):.5f} | |\n")
    print("| Event | Atlas | 95 % interval | Exact |\n| --- | --- | --- | --- |")
    for event, speed in (("galloping", exact.begins_at), ("clash", clash_from)):
        ends = [data[event + end].item() for end in ("_lowest", "_highest")]
        print(
            f"| {event} | {data[event].item():.5f} | {ends[0]:.5f} to {ends[1]:.5f} |"
            f" {wind.sf(speed):.5f} |"
        )


if __name__ == "__main__":
    main()
