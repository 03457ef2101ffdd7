"""Error and speed of the condensed model against the cable element; prints Markdown tables.

Usage: python benchmarks/condensed.py [SEED] > benchmarks/condensed.md (some minutes on one core).

First the paper's examples, then galloping scenes drawn by the generator of `screening_table.py`. Both models run
from the same start to the same time, the element on the scene's mesh with a step of 0.02 s; amplitudes are half
peak-to-peak at mid-span over the last 200 s. CPU times are those of the process, the two models taking turns, and of
whole calls: from the scene to the labelled result.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from screening_table import LEAST_MOTION, LEAST_SWING, drawn_scene, fixed_scenes

import gallop_fmu as gf
from gallop_fmu import condensation

SEED, DRAWN = 2009, 12
STOP_TIME, WINDOW = 1500.0, 200.0
TIME_STEP = 0.02
REPEATS = 5
SAGS = (0.012, 0.017, 0.02, 0.025, 0.03, 0.035, 0.04, 0.06, 0.1, 0.125)
RISES = (0.0, 0.1, 0.2, 0.3, 0.5)


@dataclass(frozen=True)
class Steady:
    """Amplitudes [m, m, rad] and vertical frequency [Hz]."""

    vertical: float
    horizontal: float
    twist: float
    frequency_hz: float


def steady(result: gf.Result) -> Steady:
    found = result.steady(WINDOW)
    return Steady(*(found[name].amplitude for name in ("u2", "u3", "theta")), found["u2"].frequency_hz)


def element_scene(scene: gf.Scene) -> gf.Scene:
    return scene.with_values({"numerics.time_step": TIME_STEP, "run.record_every": 2})


def row(name: str, scene: gf.Scene) -> str:
    """A row of the table of errors."""
    try:
        condensed = steady(gf.simulate_condensed(scene, STOP_TIME))
        element = steady(gf.simulate(element_scene(scene), STOP_TIME))
    except (gf.SceneError, gf.SimulationError) as problem:
        return f"| {name} | {problem} | | | |"
    pairs = [
        (element.vertical, condensed.vertical, LEAST_MOTION),
        (element.horizontal, condensed.horizontal, LEAST_SWING),
        (element.twist, condensed.twist, 0.01),
    ]
    cells = [f"{a:.4f} / {b:.4f}" + (f" ({b / a - 1.0:+.1%})" if a > least else "") for a, b, least in pairs]
    cells.append(f"{element.frequency_hz:.4f} / {condensed.frequency_hz:.4f}")
    return f"| {name} | " + " | ".join(cells) + " |"


def cpu(compute: Callable[[], object]) -> float:
    began = time.process_time()
    compute()
    return time.process_time() - began


def speeds() -> None:
    print("| scene | element | condensed | ratio |\n| --- | ---: | ---: | ---: |")
    for name, scene in fixed_scenes():
        slow, fast = element_scene(scene), scene
        times = np.array(
            [
                (
                    cpu(lambda slow=slow: gf.simulate(slow, 0.2 * STOP_TIME)) / 0.2,
                    cpu(lambda fast=fast: gf.simulate_condensed(fast, STOP_TIME)),
                )
                for _ in range(REPEATS)
            ]
        )
        factors = STOP_TIME / times
        cells = [f"{np.median(f):.0f} ({f.min():.0f} to {f.max():.0f})" for f in factors.T]
        print(f"| {name} | {cells[0]} | {cells[1]} | {np.median(times[:, 0] / times[:, 1]):.1f} |")


def main() -> None:
    gf.simulate_condensed(gf.load_scene("example3"), 1.0)  # imports
    print("# The condensed model against the cable element\n")
    print("Simulated seconds per CPU second, median (least to greatest) of whole calls:\n")
    speeds()
    head = "| scene | vertical, m | horizontal, m | twist, rad | frequency, Hz |\n| --- | --- | --- | --- | --- |"
    print(f"\nElement / condensed (error):\n\n{head}")
    draw = np.random.default_rng(int(sys.argv[1]) if len(sys.argv) > 1 else SEED)
    for name, scene in fixed_scenes() + [(f"drawn {number}", drawn_scene(draw)) for number in range(1, DRAWN + 1)]:
        print(row(name, scene), flush=True)
    refused = condensation.DEEPEST_SAG
    print("\nExample 3 strung with other sags, or between supports of different height, in 7 m/s;")
    print(f"sags above {refused:g} are refused otherwise:\n\n{head}")
    condensation.DEEPEST_SAG = 1.0  # to show what is refused otherwise
    base = gf.load_scene("example3").with_values({"wind.speed": 7.0})
    length = base.span.length
    for sag in SAGS:
        print(row(f"sag/span {sag:g}", base.with_values({"span": {"length": length, "sag": sag * length}})), flush=True)
    for rise in RISES:
        span = {"length": length, "sag": 0.017 * length, "height_difference": rise * length}
        print(row(f"rise/span {rise:g}", base.with_values({"span": span})), flush=True)


if __name__ == "__main__":
    main()
