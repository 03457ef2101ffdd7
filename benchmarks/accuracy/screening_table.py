"""Compare the onset of `modal.screen` with simulations of random scenes; print a Markdown table.

Usage: python benchmarks/accuracy/screening_table.py [SEED]

A few minutes on two cores. The output for the default seed is screening_table.md. With one thread
for linear algebra the CPU times are those of one core.

A seeded generator varies length, sag, mass, ends, damping, coefficient curve, attack angle and wind
of examples 2 and 3 of Liu, Yan, Zhang, Zhou (2009). The first rows are these examples, example 3
below its onset and example 3 on springs. The nonlinear model uses nothing of the prediction except
the start of its bisection.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

import gallop_fmu as gf
import modal
from support.simulated_swing import (
    BISECTION,
    FULL_RUN,
    PUSH,
    SEED,
    drawn_scene,
    simulated,
    sprung,
)

Found = TypeVar("Found")

DRAWN = 22
"""Number of random scenes."""

ONSET_WIDTH = 0.001
"""Relative width at which the bisection for the onset ends."""


def fixed_scenes() -> list[tuple[str, gf.Scene]]:
    third = gf.load_scene("example3")
    spring = sprung(75.97e3, 1e9)
    return [
        ("example 3", third),
        ("example 3, 5.0 m/s", third.with_values({"wind.speed": 5.0})),
        (
            "example 3, springs",
            third.with_values({"supports.left": spring, "supports.right": spring}),
        ),
        ("example 2", gf.load_scene("example2")),
    ]


def bisected(scene: gf.Scene, guess: float, highest: float) -> tuple[float, float] | None:
    """Onset wind speed [m/s] of the swing in the nonlinear model, and vertical amplitude [m] there.

    Without the swing the square of the amplitude is close to linear in the wind speed, as above any
    onset of galloping.
    """
    calm: dict[float, float] = {}
    low, high = 0.96 * guess, 1.04 * guess
    below, above = simulated(scene, low, BISECTION), simulated(scene, high, BISECTION)
    while below.swings:
        high, low = low, 0.92 * low
        below = simulated(scene, low, BISECTION)
    calm[low] = below.vertical
    while not above.swings:
        calm[high] = above.vertical
        low, high = high, 1.08 * high
        if high > highest:
            return None
        above = simulated(scene, high, BISECTION)
    while high - low > ONSET_WIDTH * high:
        middle = 0.5 * (low + high)
        motion = simulated(scene, middle, BISECTION)
        if motion.swings:
            high = middle
        else:
            low = middle
            calm[low] = motion.vertical
    onset = 0.5 * (low + high)
    winds = sorted(calm)[-2:]
    if len(winds) == 1:
        return onset, calm[low]
    slope = (calm[winds[1]] ** 2 - calm[winds[0]] ** 2) / (winds[1] - winds[0])
    return onset, math.sqrt(calm[winds[1]] ** 2 + slope * (onset - winds[1]))


@dataclass(frozen=True)
class Row:
    """One scene: prediction and nonlinear model."""

    name: str
    cells: tuple[str, ...]
    verdict: str  # right, miss, false alarm, refused, or no reference
    seconds: tuple[float, float]  # CPU time of the screening and of the two-mode estimate
    errors: tuple[float | None, float | None] = (None, None)
    """Onset and threshold."""


def timed(function: Callable[[gf.Scene], Found], scene: gf.Scene) -> tuple[Found, float]:
    """Result of a function, and its CPU time [s]."""
    began = time.thread_time()
    found = function(scene)
    return found, time.thread_time() - began


def compared(name: str, scene: gf.Scene) -> Row:
    wind = scene.wind.mean_speed
    try:
        found, whole = timed(modal.screen, scene)
        seconds = whole, timed(modal.two_mode_estimate, scene)[1]
    except gf.SceneError as error:
        return Row(name, (f"{wind:.2f}", *[""] * 6, f"refused: {error}"), "refused", (0.0, 0.0))
    took = f"{seconds[0]:.2f}"
    start = (f"{wind:.2f}", f"{found.frequencies.ratio:.3f}", found.risk)
    if found.risk == "undetermined":
        return Row(name, (*start, *[""] * 4, took, found.reason), "refused", seconds)
    try:
        motion = simulated(scene, wind, FULL_RUN)
        onset = None
        if found.onset_wind_speed is not None:
            onset = bisected(scene, found.onset_wind_speed, 1.5 * wind)
    except gf.SimulationError as error:
        return Row(
            name, (*start, *[""] * 4, took, f"no reference: {error}"), "no reference", seconds
        )
    verdict = {
        (True, True): "right",
        (False, False): "right",
        (False, True): "miss",
        (True, False): "false alarm",
    }[found.swings, motion.swings]

    def deviation(predicted: float | None, reference: float | None, least: float) -> float | None:
        if predicted is None or reference is None or reference < least:
            return None
        return predicted / reference - 1.0

    errors = (
        deviation(found.onset_wind_speed, onset and onset[0], 0.0),
        deviation(found.threshold_amplitude, onset and onset[1], 0.0),
    )
    notes = [
        "beats" * motion.beats,
        "dies out" * motion.dying,
        ""
        if motion.antisymmetric_from is None
        else f"antisymmetric from {motion.antisymmetric_from:.0f} s",
    ]
    note = ", ".join(word for word in notes if word)
    cells = (
        *start,
        "yes" if motion.swings else "no",
        pair(found.onset_wind_speed, onset and onset[0], errors[0]),
        pair(found.threshold_amplitude, onset and onset[1], errors[1]),
        estimated(found.estimate),
        took,
        verdict + (f" ({note})" if note else ""),
    )
    return Row(name, cells, verdict, seconds, errors)


def estimated(estimate: modal.TwoMode) -> str:
    onset, threshold = estimate.onset_wind_speed, estimate.threshold_amplitude
    return "" if onset is None or threshold is None else f"{threshold:.3f} m, {onset:.2f} m/s"


def pair(predicted: float | None, reference: float | None, error: float | None) -> str:
    if predicted is None:
        return ""
    if reference is None or error is None:
        return f"{predicted:.3f} : none"
    return f"{predicted:.3f} : {reference:.3f} ({error:+.1%})"


def reported(row: Row) -> Row:
    """Print progress on the terminal."""
    print(row.name, *row.cells, sep=" | ", file=sys.stderr)
    return row


EXPLANATION = f"""\
Pairs read `modal.screen` : nonlinear model. The two-mode estimate has its own column.

- In the nonlinear model a force of {PUSH:g} N starts the swing after galloping has settled. The
  onset is bisected to {ONSET_WIDTH:.1%}; the threshold is the amplitude there, extrapolated.
  Just above the critical wind the amplitude rises steeply and settles slowly: where the onset is
  close to it, the threshold of the nonlinear model itself is uncertain by a few per cent.
- "antisymmetric from": round-off has grown until the motion was no longer symmetric about mid-span.
  The reference is read before that; `Screening.states` has what follows.
- CPU is the CPU time of `modal.screen` on one core in seconds.
"""

HEAD = ("Scene", "Wind, m/s", "f_v/f_h", "Risk", "Swings", "Onset wind, m/s", "Threshold, m",
        "Two-mode estimate", "CPU, s", "Verdict")  # fmt: skip


def main() -> None:
    began = time.perf_counter()
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else SEED
    draw = np.random.default_rng(seed)
    scenes = fixed_scenes() + [
        (f"drawn {number}", drawn_scene(draw)) for number in range(1, DRAWN + 1)
    ]
    modal.screen(scenes[0][1])  # import now, so that no row measures it
    with ThreadPoolExecutor(2) as pool:
        rows = list(pool.map(lambda item: reported(compared(*item)), scenes))
    print(f"# Screening against the nonlinear model: seed {seed}\n")
    print((__doc__ or "").split("\n\n", 3)[3])
    print(EXPLANATION)
    print("| " + " | ".join(HEAD) + " |\n|" + " --- |" * len(HEAD))
    for row in rows:
        print(f"| {row.name} | " + " | ".join(row.cells) + " |")
    print()
    summarise(rows)
    print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)


def summarise(rows: list[Row]) -> None:
    """Print the counts and the largest errors."""
    for verdict in ("right", "miss", "false alarm", "refused", "no reference"):
        print(f"- {verdict}: {sum(row.verdict == verdict for row in rows)}")
    for index, (name, allowed) in enumerate((("onset wind", 0.05), ("threshold", 0.1))):
        errors = [abs(error) for row in rows if (error := row.errors[index]) is not None]
        if errors:
            print(
                f"- {name}: largest error {max(errors):.1%}, median {np.median(errors):.1%}, "
                f"{sum(error > allowed for error in errors)} of {len(errors)} above {allowed:.0%}"
            )
    for name, index in (("screening", 0), ("two-mode estimate", 1)):
        times = [1e3 * row.seconds[index] for row in rows]
        print(
            f"- CPU time of the {name}: at most {max(times):.0f} ms, median"
            f" {np.median(times):.0f} ms"
        )


if __name__ == "__main__":
    main()
