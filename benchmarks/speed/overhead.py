"""Measure the share of Python in a run, a row of a sweep and a command; see ../README.md.

Usage: python benchmarks/speed/overhead.py [PYTHON]

PYTHON is the interpreter of an environment with another release, which then alternates with this
one. Processor times, least of the repeats.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from typing import Any

REPEATS = 5

RUNS = """
import json, sys, time
import gallop_fmu as gf
from gallop_fmu.engine import library
from gallop_fmu.sweeps import sweep as sweeps

kernel = [0.0]

def timed(function):
    def call(*arguments):
        began = time.process_time()
        found = function(*arguments)
        kernel[0] += time.process_time() - began
        return found

    return call

for name, function in list(vars(library.kernel).items()):
    if name.startswith("gallop_"):
        setattr(library.kernel, name, timed(function))
base = gf.load_scene("example3")
row = sweeps.Simulation(100.0, None, None, sweeps.SUMMARY_COLUMNS)
cases = {
    "simulate": lambda scene: gf.simulate(scene, 100.0),
    "simulate, dataset used": lambda scene: gf.simulate(scene, 100.0).dataset,
    "simulate, steady()": lambda scene: gf.simulate(scene, 100.0).steady(),
    "row of a sweep": lambda scene: row([scene], lambda: True),
    "row of a sweep, with its scene": lambda scene: row(
        [base.with_values({"wind.speed": scene.wind.speed})], lambda: True
    ),
}
least = {}
for repeat in range(15):
    scene = base.with_values({"wind.speed": 5.0 + 1e-4 * repeat})  # no two runs are equal
    for name, case in cases.items():
        kernel[0], began = 0.0, time.process_time()
        case(scene)
        whole = time.process_time() - began
        own, total = least.get(name, (1e9, 1e9))
        least[name] = min(own, kernel[0]), min(total, whole - kernel[0])
print(json.dumps(least))
"""
"""Prints times [s] of the kernel and of the rest, for 100 s of example 3."""

HIDDEN = """
import sys
from importlib.machinery import PathFinder
found = PathFinder.find_spec.__func__
def without_dask(cls, name, path=None, target=None):
    return None if name.split(".")[0] in ("dask", "distributed") else found(cls, name, path, target)
PathFinder.find_spec = classmethod(without_dask)
"""

COMMANDS = {
    "import gallop_fmu": "import gallop_fmu",
    "gallop-fmu --help": "run('--help')",
    "gallop-fmu run example3, 600 s": "run('run', 'example3', '--until', '600')",
    "the same, with a file .nc": "run('run', 'example3', '--until', '600', '--out', sys.argv[1])",
}
"""Programs whose whole processor time counts."""

COMMAND = """
import sys
def run(*arguments):
    from gallop_fmu.cli.main import app
    app(arguments, standalone_mode=False)
"""


def process_time(python: str, code: str) -> float:
    """Processor time [s] of a Python process."""
    before = os.times()
    with tempfile.TemporaryDirectory() as folder:
        command = [python, "-P", "-c", code, f"{folder}/run.nc"]
        subprocess.run(command, check=True, capture_output=True)
    after = os.times()
    return (after.children_user - before.children_user) + (
        after.children_system - before.children_system
    )


def compare_runs(pythons: list[str]) -> None:
    """Print the time of the kernel and of the rest for runs of 100 s."""
    print("| 100 s of example 3 | kernel, ms | rest, ms | rest / kernel |")
    print("| --- | ---: | ---: | ---: |")
    found: list[dict[str, Any]] = [{} for _ in pythons]
    for _ in range(REPEATS):
        for python, least in zip(pythons, found, strict=True):
            done = subprocess.run(
                [python, "-P", "-c", RUNS], check=True, capture_output=True, text=True
            )
            for name, times in json.loads(done.stdout).items():
                least[name] = [
                    min(pair) for pair in zip(times, least.get(name, times), strict=True)
                ]
    for number, least in enumerate(found):
        for name, (kernel, rest) in least.items():
            label = f"{name}, other release" if number else name
            print(f"| {label} | {1e3 * kernel:.1f} | {1e3 * rest:.2f} | {rest / kernel:.0%} |")


def compare_commands(pythons: list[str]) -> None:
    """Print the processor time of whole programs, with and without Dask."""
    other = ["other release, s"] * (len(pythons) - 1)
    print("| program | " + " | ".join(["s", "without Dask, s", *other]) + " |")
    print("| --- |" + " ---: |" * (2 + len(other)))
    for name, code in COMMANDS.items():
        variants = [(pythons[0], COMMAND + code), (pythons[0], HIDDEN + COMMAND + code)]
        variants += [(python, COMMAND + code) for python in pythons[1:]]
        times = [[process_time(*variant) for variant in variants] for _ in range(REPEATS)]
        least = [f"{min(column):.2f}" for column in zip(*times, strict=True)]
        print(f"| {name} | " + " | ".join(least) + " |")


def main() -> None:
    pythons = [sys.executable, *sys.argv[1:2]]
    compare_runs(pythons)
    print()
    compare_commands(pythons)


if __name__ == "__main__":
    main()
