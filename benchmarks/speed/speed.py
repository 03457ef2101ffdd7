"""Measure the run time of the galloping span of example 3; see ../README.md.

Usage: python benchmarks/speed/speed.py
"""

from __future__ import annotations

import ctypes as c
import importlib.util
import os
import platform
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CScene
from gallop_fmu.engine.library import build
from gallop_fmu.engine.pack import Packed

REPEATS = 7
KERNEL = Path(__file__).resolve().parents[2] / "gallop_fmu" / "kernel"
FLAGS = (
    "-std=c11",
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fPIC",
    "-shared",
)
"""Those of CMakeLists.txt."""

SETTLED = 900.0
"""Time [s] at which example 3 has reached its steady swing."""

ELEMENTS = (10, 20, 50, 100, 200, 500, 1000)
TIME_STEPS = (0.08, 0.04, 0.02, 0.01, 0.005, 0.0025)


class Parts(c.Structure):
    """The struct `parts` of kernel_parts.c."""

    _fields_ = [
        (name, c.c_double)
        for name in (
            "forces", "ice", "aerodynamics", "tangent", "solution", "step", "iterations",
            "refactorisations"
        )
    ]  # fmt: skip


def example3(**numerics: float) -> gf.Scene:
    return gf.load_scene("example3").with_values(
        {f"numerics.{name}": value for name, value in numerics.items()}
    )


def strict(**numerics: float) -> gf.Scene:
    """Example 3, with the default Newton tolerance."""
    return example3(newton_tolerance=1e-9, **numerics)


def spread(values: list[float]) -> str:
    """Minimum, median and maximum."""
    return " | ".join(
        f"{value:.4g}" for value in (min(values), statistics.median(values), max(values))
    )


def heading() -> None:
    name = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next((line.split(": ")[1] for line in lines if line.startswith("model name")), name)
    load = f", load average {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(
        f"{datetime.now(UTC):%Y-%m-%d}, {name}, {os.cpu_count()} cores{load}; kernel: {build()}\n"
    )


def compile_kernel_with(source: str, folder: str, *flags: str) -> c.CDLL:
    """The kernel and a file of this folder in one library, built with the system's compiler."""
    fmpy = importlib.util.find_spec("fmpy")
    assert fmpy is not None
    assert fmpy.origin is not None
    headers = Path(fmpy.origin).parent / "c-code"
    sources = [Path(__file__).with_name(source), *sorted(KERNEL.glob("*.c"))]
    library = Path(folder) / f"benchmark{''.join(flags)}.so"
    compiler = os.environ.get("CC", "cc")
    command = [
        compiler,
        *FLAGS,
        *flags,
        f"-I{KERNEL}",
        f"-I{headers}",
        *map(str, sources),
        "-o",
        str(library),
        "-lm",
    ]
    subprocess.run(command, check=True)
    return c.CDLL(str(library))


def compile_parts(folder: str, *flags: str) -> Callable[..., int]:
    """The function `kernel_parts`."""
    function = compile_kernel_with("kernel_parts.c", folder, *flags).kernel_parts
    function.argtypes = (c.POINTER(CScene), c.c_double, c.c_int, c.c_int, c.POINTER(Parts))
    return function


def real_time() -> None:
    """Measure speed over real time of a whole simulation, and the cost of recording."""
    ways: dict[str, dict[str, Any]] = {
        "as packaged": {},
        "every step recorded": {"record_every": 1},
        "every step recorded, no span channels": {"record_every": 1, "span_channels": ()},
    }
    gf.simulate(example3(), stop_time=1.0)  # imports xarray
    factors: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(REPEATS):
        for name, arguments in ways.items():
            began = time.process_time()
            gf.simulate(example3(), 1000.0, **arguments)
            factors[name].append(1000.0 / (time.process_time() - began))
    print(
        "| simulate(example3), 1000 s | least | median | greatest |\n| --- | ---: | ---: | ---: |"
    )
    for name, values in factors.items():
        print(f"| real-time factor, {name} | {spread(values)} |")
    print()


def shares() -> None:
    """Measure the parts of a step."""
    packed = Packed(strict(time_step=0.02))
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        function = compile_parts(folder)
        for _ in range(REPEATS):
            parts = Parts()
            if function(c.byref(packed.scene), SETTLED, 20000, 20000, c.byref(parts)):
                raise RuntimeError("the benchmark scene failed")
            runs.append(parts)
    middle = {
        field[0]: statistics.median(getattr(run, field[0]) for run in runs)
        for field in Parts._fields_
    }
    steps = [run.step for run in runs]
    each, refactorisations, whole = middle["iterations"], middle["refactorisations"], middle["step"]
    rows = [
        ("assembly of inertia, damping and tension", middle["forces"], each),
        ("eccentric ice", middle["ice"], each),
        ("aerodynamics", middle["aerodynamics"], each),
        ("tangent and factorisation", middle["tangent"], refactorisations),
        ("solution", middle["solution"], each),
    ]
    print(
        "| part of a step, 15 elements, step 0.02 s | us a call | calls a step | us a step |"
        " share |"
    )
    print("| --- | ---: | ---: | ---: | ---: |")
    for name, cost, calls in rows:
        print(
            f"| {name} | {cost:.3f} | {calls:.4g} | {cost * calls:.3f} |"
            f" {cost * calls / whole:.0%} |"
        )
    rest = whole - sum(cost * calls for _, cost, calls in rows)
    print(f"| the rest: prediction, update, convergence | | | {rest:.3f} | {rest / whole:.0%} |")
    print(f"| whole step | | | {whole:.3f} ({min(steps):.3f} to {max(steps):.3f}) | 100% |\n")


def growth_with_elements() -> None:
    """CPU time of a step over the number of elements, for 200 steps of the growing oscillation."""
    models = {
        elements: gf.Model(strict(time_step=0.02, elements=elements)) for elements in ELEMENTS
    }
    spent: dict[int, list[float]] = {elements: [] for elements in ELEMENTS}
    work: dict[int, tuple[float, float, float]] = {}
    for _ in range(REPEATS):
        for elements, model in models.items():
            state = model.start()
            before = state.advance(2.0)
            began = time.process_time()
            after = state.advance(6.0)
            steps = after.steps - before.steps
            spent[elements].append(1e6 * (time.process_time() - began) / steps)
            work[elements] = (
                (after.iterations - before.iterations) / steps,
                (after.refactorisations - before.refactorisations) / steps,
                (after.halvings - before.halvings) / steps,
            )
    print(
        "| elements | us a step: least | median | greatest | iterations | refactorisations |"
        " halvings | exponent |"
    )
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    least = [min(spent[elements]) for elements in ELEMENTS]
    exponents = ["", *(f"{e:.2f}" for e in np.diff(np.log(least)) / np.diff(np.log(ELEMENTS)))]
    for elements, exponent in zip(ELEMENTS, exponents, strict=True):
        counts = " | ".join(f"{value:.2f}" for value in work[elements])
        print(f"| {elements} | {spread(spent[elements])} | {counts} | {exponent} |")
    whole = [index for index, elements in enumerate(ELEMENTS) if work[elements][2] == 0.0]
    fitted = np.polyfit(np.log(np.array(ELEMENTS)[whole]), np.log(np.array(least)[whole]), 1)[0]
    print(f"\nExponent fitted to the rows without halvings: {fitted:.2f}\n")


def error_against_step() -> None:
    """Price of accuracy: time step, error of the steady amplitudes, real-time factor."""
    amplitudes, factors = {}, {}
    for step in TIME_STEPS:
        scene = strict(time_step=step)
        began = time.process_time()
        result = gf.simulate(scene, 2000.0, record_every=max(1, round(0.01 / step)))
        factors[step] = 2000.0 / (time.process_time() - began)
        steady = result.steady(100.0)
        amplitudes[step] = np.array([steady[name].amplitude for name in ("u2", "u3", "theta")])
    reference = amplitudes[TIME_STEPS[-1]]
    print("| step [s] | u2 [m] | error | u3 [m] | error | twist [rad] | error | real-time factor |")
    print("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    for step in TIME_STEPS:
        errors = amplitudes[step] / reference - 1.0
        cells = " | ".join(
            f"{a:.5f} | {e:+.2%}" for a, e in zip(amplitudes[step], errors, strict=True)
        )
        print(f"| {step} | {cells} | {factors[step]:.0f} |")


if __name__ == "__main__":
    heading()
    real_time()
    shares()
    growth_with_elements()
    error_against_step()
