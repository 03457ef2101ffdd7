"""Run what is too long for the tests; write docs/reference/stability.md and a JSON file of numbers.

Usage: python benchmarks/stress/run.py --runs 4000 --seed 1 (about ten minutes on two idle cores)

`--parts` chooses among random scenes (scenes), the map of step, wind and mesh (map), limit cycles
(cycles) and conservation (conservation); what is not run again is kept from the JSON file.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

import report
import stability

from gallop_fmu import Model, Scene, SceneError, SimulationError
from gallop_fmu.engine.library import build
from support import conservation
from support.checks import judge_scene
from support.isolated_workers import Answer, answers
from support.random_spans import stress_scene

PARTS = ("scenes", "map", "cycles", "conservation")
REFERENCE = Path(__file__).resolve().parents[2] / "docs" / "reference"
RUN_LIMIT, LONG_LIMIT = 120.0, 1800.0
"""Time [s] after which a random scene, or one of the long runs, counts as hanging."""

CONSERVED_STEPS, RETURNED_STEPS = 1_000_000, 20_000
SAME_BITS = 40
"""Random scenes that are run again, recorded rarely, and in threads."""


def random_scene(task: tuple[int, int, dict[str, Any]]) -> dict[str, Any]:
    return asdict(judge_scene(task))


def map_cell(task: tuple[str, float, float, int]) -> dict[str, Any]:
    return asdict(stability.cell(task))


def limit_cycle(task: tuple[str, str, float]) -> dict[str, Any]:
    return asdict(stability.cycle(task))


def conserved(task: tuple[str, str]) -> dict[str, Any]:
    integrator, start = task
    chosen = conservation.conserving()[integrator]
    if start == "smooth":
        state = conservation.released(chosen)
    else:
        state = Model(conservation.undamped({**conservation.ROUGH, **chosen})).start()
    found = conservation.energy_error(state, CONSERVED_STEPS, 100)
    back = conservation.released({"numerics.newton_tolerance": 1e-13, **chosen})
    found["way_back"] = conservation.way_back(back, RETURNED_STEPS)
    return {"integrator": integrator, "start": start, **found}


def bits(seed: int) -> dict[str, Any]:
    scenes = []
    for number in range(10 * SAME_BITS):
        stress = stress_scene(seed, number)
        try:
            scene = Scene.from_dict(stress.data)
            Model(scene).start()
        except (SceneError, SimulationError):
            continue
        scenes.append(scene)
    return conservation.same_bits(scenes[:SAME_BITS], 40)


def carried_out(
    work: Callable[[Any], Any], tasks: Iterable[Any], arguments: argparse.Namespace, limit: float
) -> Any:
    """Values and losses of all tasks, and what they took."""
    found: list[Answer] = []
    began, shown = time.monotonic(), time.monotonic()
    for answer in answers(work, tasks, arguments.processes, limit):
        found.append(answer)
        if time.monotonic() - shown > 20.0:
            shown = time.monotonic()
            print(f"  {len(found)} done in {shown - began:.0f} s", file=sys.stderr)
    return {
        "values": [answer.value for answer in found if not answer.lost],
        "lost": [f"{answer.task}: {answer.lost}" for answer in found if answer.lost],
        "memory": [answer.memory for answer in found if answer.memory],
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--runs", type=int, default=4_000, help="random spans, each run by every integrator"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument(
        "--out", type=Path, default=REFERENCE, help="folder of stability.md and its pictures"
    )
    parser.add_argument(
        "--json", type=Path, default=Path("stress.json"), help="file of all numbers"
    )
    arguments = parser.parse_args()
    data = json.loads(arguments.json.read_text(encoding="utf-8")) if arguments.json.exists() else {}
    data["machine"] = (
        f"{platform.system()} {platform.machine()}, Python {platform.python_version()}, {build()}"
    )
    names = list(conservation.integrators())

    def keep() -> None:
        arguments.json.write_text(json.dumps(data), encoding="utf-8")

    if "scenes" in arguments.parts:
        tasks = [
            (arguments.seed, number, {key.split(".")[1]: value for key, value in chosen.items()})
            for number in range(arguments.runs)
            for chosen in conservation.integrators().values()
        ]
        data["scenes"] = {
            "seed": arguments.seed,
            **carried_out(random_scene, tasks, arguments, RUN_LIMIT),
        }
        keep()
    if "map" in arguments.parts:
        places = [
            (n, h, w, e)
            for n in names
            for e in stability.MESHES
            for w in stability.WINDS
            for h in stability.STEPS
        ]
        data["map"] = carried_out(map_cell, places, arguments, LONG_LIMIT)
        keep()
    if "cycles" in arguments.parts:
        runs = [(n, c, h) for n in names for h in stability.CYCLE_STEPS for c in stability.CYCLES]
        data["cycles"] = carried_out(limit_cycle, runs, arguments, LONG_LIMIT)
        keep()
    if "conservation" in arguments.parts:
        starts = [
            (name, start) for name in conservation.conserving() for start in ("smooth", "rough")
        ]
        data["conservation"] = carried_out(conserved, starts, arguments, LONG_LIMIT)
        data["bits"] = bits(arguments.seed)
        keep()
    report.write(data, arguments.out)


if __name__ == "__main__":
    main()
