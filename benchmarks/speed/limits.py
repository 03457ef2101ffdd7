"""Compare a time step with the peak performance of a core; see ../README.md.

Usage: python benchmarks/speed/limits.py

The floating-point operations of an element are counted by hand from the formulas of element.c,
aero.c, elementary.h and solver.c; an addition, multiplication, division or square root counts as
one, a choice as none.
"""

from __future__ import annotations

import ctypes as c
import tempfile
import time

import numpy as np
from speed import (
    REPEATS,
    SETTLED,
    Parts,
    compile_kernel_with,
    compile_parts,
    example3,
    heading,
    spread,
    strict,
)

import gallop_fmu as gf
from gallop_fmu.engine.pack import Packed
from gallop_fmu.engine.state import VECTOR, State

UNKNOWNS = 4
INERTIA = UNKNOWNS * (3 * 3 + 15)  # a + b v in three nodes, and three rows of three products
SLOPES = UNKNOWNS * 2 * 5  # of u and v
TENSION = (
    3 * 4 + 2 + 3 * 2 + 1 + 7 + 3 * 5 + 2
)  # strain, tension, its force, and the damping of both kinds
NODAL = UNKNOWNS * 6
FORCES = INERTIA + 2 * (SLOPES + TENSION + NODAL)
SECTIONS = (
    7 * 2 * 5 + 3 * 14 + 20
)  # motion at three sections, forces to the nodes, and sums at the nodes
ICE = 3 * (50 + 20)  # sine and cosine, forces
AIR = 3 * (33 + 51)  # arctangent; relative wind, place on the curve, three cubics, loads
SOLUTION = 6 * 28 + 2 * 8 + 3 * 28 + 2 * UNKNOWNS  # condensed node, chain
UPDATE = 8 * 6 + 8 * 2  # u, v, a, and the largest correction
ITERATION = FORCES + SECTIONS + ICE + AIR + SOLUTION + UPDATE
PREDICTION = 8 * (21 + 17)  # which way would have led closest; u, v, a by it

FACTORS, GEOMETRY, MOTION = 96 * 8, 31 * 8, 8 * 8 * (3 + 1)
BYTES = FACTORS + GEOMETRY + 2 * MOTION
"""Bytes per element and iteration: factors, constants, and twice u, v, a and the residual."""

MODEL = 224 + 36 * 8 + 2 * (3 + 4) * 8
"""Bytes per element in a model: its geometry, scalar and in lanes, and two nodes."""

ELEMENTS = (15, 100, 1000)
STEPS = 20_000

LANES = {
    "one element at a time": (
        "-DGALLOP_ONE_LANE",
        "-fno-tree-vectorize",
        "-fno-tree-slp-vectorize",
    ),
    "the same, vectorised by the compiler": ("-DGALLOP_ONE_LANE",),
    "four elements in vector lanes": (),
}
"""Compiler flags of the kernel."""


def side_by_side() -> None:
    """Speed-up by the lanes within one scene, which bounds the gain of several scenes in lanes."""
    packed = Packed(strict(time_step=0.02))
    spent: dict[str, list[float]] = {name: [] for name in LANES}
    with tempfile.TemporaryDirectory() as folder:
        functions = {name: compile_parts(folder, *flags) for name, flags in LANES.items()}
        for _ in range(REPEATS):
            for name, function in functions.items():
                parts = Parts()
                if function(c.byref(packed.scene), SETTLED, 20000, 20000, c.byref(parts)):
                    raise RuntimeError("the benchmark scene failed")
                spent[name].append(parts.step)
    single = spent["one element at a time"]
    print(
        "| example3, step 0.02 s | us a step: least | median | greatest | speed-up | 4 lanes"
        " could still give |"
    )
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for name, values in spent.items():
        gain = float(np.median(np.array(single) / values))
        print(f"| {name} | {spread(values)} | {gain:.2f} | {4.0 / gain:.2f} |")
    print()


def placement() -> None:
    """Speed-up by arrays that begin at multiples of a vector, where no vector is on two lines."""
    model = gf.Model(example3(time_step=0.02), inputs=False)
    start = model.start()
    start.advance(SETTLED)
    saved, states = start.save(), []
    for offset in (8, 0):
        state = State(model)
        block = np.zeros(model.state_size + 2 * VECTOR, dtype=np.uint8)
        state._block = block[-block.ctypes.data % VECTOR + offset :]
        state._pointer = state._block.ctypes.data_as(c.c_void_p)
        states.append(state)
    spent: list[list[float]] = [[], []]
    for _ in range(3 * REPEATS):
        for state, seconds in zip(states, spent, strict=True):
            state.restore(saved)
            began = time.process_time()
            state.advance(SETTLED + 200.0)
            seconds.append(time.process_time() - began)
    gain = float(np.median(np.array(spent[0]) / spent[1]))
    print(
        "example3, step 0.02 s: a state at a multiple of 32 bytes takes"
        f" {min(spent[1]) / 0.01:.3f} us a step, {gain:.2f} times faster than 8 bytes further on\n"
    )


def main() -> None:
    heading()
    with tempfile.TemporaryDirectory() as folder:
        library = compile_kernel_with("limits.c", folder)
        library.peak_rate.restype = library.read_rate.restype = c.c_double
        library.read_rate.argtypes = (c.c_void_p, c.c_size_t, c.c_int, c.POINTER(c.c_double))
        sink = c.c_double()
        states = {
            n: gf.Model(strict(time_step=0.02, elements=n), inputs=False).start() for n in ELEMENTS
        }
        peak: list[float] = []
        reading: dict[int, list[float]] = {n: [] for n in ELEMENTS}
        spent: dict[int, list[float]] = {n: [] for n in ELEMENTS}
        iterations: dict[int, float] = {}
        for state in states.values():
            state.advance(2.0)
        for _ in range(REPEATS):
            peak.append(library.peak_rate(5_000_000, c.byref(sink)) / 1e9)
            for n, state in states.items():
                values = np.ones(BYTES * n // 8)
                rounds = max(1, 200_000_000 // values.nbytes)
                reading[n].append(
                    library.read_rate(values.ctypes.data, len(values), rounds, c.byref(sink)) / 1e9
                )
                saved = state.save()
                before = state.advance(state.time + 0.02)
                steps = max(20, STEPS // n)
                began = time.process_time()
                after = state.advance(state.time + 0.02 * steps)
                spent[n].append((time.process_time() - began) / steps)
                iterations[n] = (after.iterations - before.iterations) / steps
                state.restore(saved)
    print(
        f"Additions and multiplications of the core without memory, 10^9 a second: {spread(peak)}\n"
    )
    print(f"An iteration needs {ITERATION} operations and {BYTES} bytes an element.\n")
    columns = (
        "elements",
        "us a step: least",
        "iterations",
        "10^9 operations a second",
        "of the peak",
        "GB/s",
    )
    print(f"| {' | '.join(columns)} | of reading as much | bytes an element |")
    print(f"| {' | '.join(['---:'] * 8)} |")
    for n in ELEMENTS:
        least, count = min(spent[n]), iterations[n]
        operations = n * (count * ITERATION + PREDICTION) / least / 1e9
        rate = n * count * BYTES / least / 1e9
        memory = states[n].model.state_size / n + MODEL
        shares = (
            f"{operations:.2f} | {operations / max(peak):.0%} | {rate:.1f} |"
            f" {rate / max(reading[n]):.0%}"
        )
        print(f"| {n} | {1e6 * least:.2f} | {count:.2f} | {shares} | {memory:.0f} |")
    print()
    placement()
    side_by_side()


if __name__ == "__main__":
    main()
