"""Measure what several scenes in the lanes of a vector could gain; see ../README.md.

Usage: python benchmarks/speed/scene_lanes.py
"""

from __future__ import annotations

import ctypes as c
import statistics
import tempfile

from speed import SETTLED, compile_kernel_with, example3, heading

from gallop_fmu.engine.ctypes_structs import CScene
from gallop_fmu.engine.pack import Packed

ROUNDS = 25
MAX_DIFFERENCE = 1e-9
"""Largest difference between one scene and four in lanes, relative to the largest value."""


class Comparison(c.Structure):
    """The struct `comparison` of scene_lanes.c."""

    _fields_ = [
        (name, c.c_double)
        for name in (
            "forces", "solution", "four_forces", "four_solution", "step", "iterations",
            "force_difference", "solution_difference"
        )
    ]  # fmt: skip


def main() -> None:
    """Print the gain of both parts, and bounds of that of a whole step."""
    heading()
    packed = Packed(example3(time_step=0.02))
    rounds: dict[str, list[Comparison]] = {"portable (AVX2)": [], "fused (AVX-512)": []}
    with tempfile.TemporaryDirectory() as folder:
        compare = compile_kernel_with("scene_lanes.c", folder).scene_lanes
        compare.argtypes = (c.POINTER(CScene), c.c_double, c.c_int, c.POINTER(Comparison))
        for _ in range(ROUNDS):
            for fused, found in enumerate(rounds.values()):
                found.append(Comparison())
                if compare(c.byref(packed.scene), SETTLED, fused, c.byref(found[-1])):
                    raise RuntimeError("the benchmark scene failed")
    print(
        "| Example 3, 15 elements, step 0.02 s | Part | One scene [us] | Four in lanes, each [us] |"
        " Gain: median (quartiles) |\n| --- | --- | ---: | ---: | --- |"
    )
    for path, found in rounds.items():
        if (
            max(max(one.force_difference, one.solution_difference) for one in found)
            > MAX_DIFFERENCE
        ):
            raise RuntimeError(
                "four scenes in lanes have other forces or another solution than one"
            )
        row(path, "forces", [one.forces for one in found], [one.four_forces for one in found])
        row(path, "solution", [one.solution for one in found], [one.four_solution for one in found])
        steps = [one.step for one in found]
        saved = [
            one.iterations * (one.forces - one.four_forces + one.solution - one.four_solution)
            for one in found
        ]
        left = [step - less for step, less in zip(steps, saved, strict=True)]
        row(path, "whole step, if its rest gains nothing", steps, left)
        both = [
            step * (one.four_forces + one.four_solution) / (one.forces + one.solution)
            for step, one in zip(steps, found, strict=True)
        ]
        row(path, "whole step, if its rest gains as much", steps, both)


def row(path: str, part: str, one: list[float], each: list[float]) -> None:
    """Print medians of the times, and of the ratio of the same round with its quartiles."""
    gain = [a / b for a, b in zip(one, each, strict=True)]
    low, median, high = statistics.quantiles(gain, n=4)
    print(
        f"| {path} | {part} | {statistics.median(one):.3f} | {statistics.median(each):.3f} |"
        f" {median:.2f} ({low:.2f} to {high:.2f}) |"
    )


if __name__ == "__main__":
    main()
