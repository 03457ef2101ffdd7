"""Measure the speed-up from inactive terms; see ../README.md.

Usage: python benchmarks/speed/skips.py

Each scene is computed as it is, and once more with a disturbance that activates the terms and moves
nothing.
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
from speed import REPEATS, heading

import gallop_fmu as gf
from gallop_fmu.engine.model import Model

STEPS = 4000
# far below the round-off of a metre; its square does not underflow, which would cost time
NOTHING = 1e-30
CALM = {
    "ice.first_moment_x2": 0.0,
    "ice.first_moment_x3": 0.0,
    "wind.speed": 0.0,
    "initial.seed_vertical": 0.1,
}
TWIST = {"initial.seed_twist": NOTHING}


def example3(*changes: dict[str, Any]) -> gf.Scene:
    values: dict[str, Any] = {"numerics.time_step": 0.02, "initial.seed_horizontal": 0.0}
    for change in changes:
        values |= change
    return gf.load_scene("example3").with_values(values)


def cases() -> dict[str, tuple[gf.Scene, gf.Scene]]:
    """Scene with inactive terms, and the same scene with these terms active."""
    plane = example3(CALM)
    eccentric = example3({"wind.speed": 0.0, "initial.seed_vertical": 0.1})
    vertical = {"loads.0.force": [0.0, 1.0, 0.0], "loads.0.torque": 0.0}
    example1 = gf.load_scene("example1").with_values(vertical)
    tiny_ice = {"ice.first_moment_x2": NOTHING}
    return {
        "example 1, vertical load alone: u3 and theta": (example1, example1.with_values(TWIST)),
        "in the plane: u3 and theta": (plane, plane.with_values(TWIST)),
        "in the plane: u3, theta and eccentric ice": (plane, plane.with_values(tiny_ice)),
        "eccentric ice without wind: aerodynamics": (
            eccentric, eccentric.with_values({"wind.speed": 1e-9, "aerodynamics.outside": "hold"}),
        ),
    }  # fmt: skip


def microseconds(model: Model) -> float:
    """CPU time of a step."""
    state, step = model.start(), model.scene.numerics.time_step
    state.advance(1.0)
    began = time.process_time()
    state.advance(1.0 + STEPS * step)
    return 1e6 * (time.process_time() - began) / STEPS


def main() -> None:
    heading()
    print(
        "| scene: inactive terms | unknowns | us a step: least | median | greatest"
        " | gain: least | median | greatest |"
    )
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    pairs = cases()
    models = {name: [Model(scene, inputs=False) for scene in pair] for name, pair in pairs.items()}
    spent: dict[str, list[list[float]]] = {name: [] for name in models}
    for _ in range(REPEATS):
        for name, pair in models.items():
            spent[name].append([microseconds(model) for model in pair])
    for name, pair in models.items():
        assert pair[0].parts != pair[1].parts or pair[0].state_size < pair[1].state_size, name
        times = np.array(spent[name])
        ratios = list(times[:, 1] / times[:, 0])
        cells = [(min(y), statistics.median(y), max(y)) for y in (list(times[:, 0]), ratios)]
        numbers = " | ".join(f"{value:.2f}" for cell in cells for value in cell)
        print(f"| {name} | {' '.join(pair[0].unknowns)} | {numbers} |")
    print()


if __name__ == "__main__":
    main()
