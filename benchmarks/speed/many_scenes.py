"""What many scenes at once could gain in an atlas, a screening and a diagram; see ../README.md.

The first table has the parts of the reduced models, computed for one scene and for several at once
in arrays that are as many times longer. The second has the shares of whole jobs, and the bound
that follows for each job if all its starts, cycles and orbits were computed at once. With the
interpreter of an environment of another release, a third table compares the jobs with that one.

Usage: python benchmarks/speed/many_scenes.py [PYTHON]
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for parts below the public functions

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from speed import heading

sys.path.append(str(Path(__file__).parents[2]))

import gallop_fmu as gf
import modal
from gallop_fmu.engine.state import State
from modal.continuation import condensation, elimination, equations
from modal.motions import span_problem
from modal.screening import (
    line_settled,
    many_spans,
    settled,
    span_diagram,
    two_mode_estimate,
)
from tests.support.cubic_galloping import scene as cubic_span

ROUNDS, CALLS = 15, 20
AT_ONCE = 8
"""Scenes in one array, as many as numbers in a vector of AVX-512."""

LANES_GAIN = 1.35
"""Largest gain of several scenes in lanes of the full model (`scene_lanes.py`)."""

COMPARISONS, TIMES = 3, "--times"
"""Repeats of a comparison, and the argument for a run of it."""

DRAWS = 256
WIND = {"distribution": "weibull_min", "c": 2.0, "scale": 6.0}
ANGLE = {"distribution": "uniform", "loc": 170.0, "scale": 20.0}


class Part(NamedTuple):
    """A part of a job: functions that are timed, as (owner, name)."""

    name: str
    functions: tuple[tuple[Any, str], ...]


PARTS = (
    Part("full model in time", ((State, "record"),)),
    Part("cycles of the estimate", ((two_mode_estimate, "_cycle"),)),
    Part("modes", ((many_spans, "frequency_ratio"), (many_spans, "pair_of"))),
    Part(
        "reduced forces",
        ((span_problem.SpanProblem, "rates"), (span_problem.SpanProblem, "defect")),
    ),
    Part(
        "linear equations",
        (
            (equations, "eliminate_second_order"),
            (elimination.Factors, "solve"),
            (condensation.Condensed, "__init__"),
            (condensation.Condensed, "_bordered"),
            (condensation.Condensed, "solve"),
            (equations.OrbitEquations, "spectrum"),
        ),
    ),
)

SIMULATIONS = ((settled, "simulated_state"), (line_settled, "_simulated"))
"""Functions that simulate to a steady motion."""

HEAP = 31 * 2**17
"""Numbers in an array that is made and dropped, after which the C library of Linux keeps smaller
ones on its heap: new pages of memory take longer than most parts."""


def main() -> None:
    """Print both tables."""
    heading()
    np.empty(HEAP)
    gains = parts_at_once()
    print(
        "\n| Job | CPU time [ms] | Simulations | "
        + " | ".join(part.name for part in PARTS)
        + " | rest | Bound |\n| --- | ---: | ---: |"
        + " ---: |" * (len(PARTS) + 2)
    )
    for name, (work, count) in jobs().items():
        job(name, work, gains, count)
    if sys.argv[1:]:
        compare(sys.argv[1])


def jobs() -> dict[str, tuple[Callable[[], Any], int]]:
    """Return what is measured: name to function, and the number of draws in it."""
    angle = {"wind.speed": WIND, "ice.attack_angle_deg": ANGLE}
    atlas = partial(modal.risk_atlas, draws=DRAWS, clearance=1.0, workers=1)
    example = gf.load_scene("example3")
    random_wind = partial(atlas, cubic_span(), {"wind.speed": WIND})
    return {
        "atlas, random wind, one draw": (random_wind, DRAWS),
        "atlas, random wind and angle, one draw": (partial(atlas, example, angle), DRAWS),
        "screening, example2": (partial(modal.screen, gf.load_scene("example2")), 1),
        "screening, example3": (partial(modal.screen, example), 1),
        "screening, three spans on strings": (partial(modal.screen, three_spans()), 1),
        "diagram, example3": (partial(modal.branches, example, "wind.speed", 4.5, 6.5), 1),
    }


def three_spans() -> gf.LineScene:
    """Three spans of example 2 on strings of 2.1 m."""
    like = gf.load_scene("example2").model_dump(mode="json", exclude_none=True)
    string = {"kind": "string", "length": 2.1, "weight": 490.0}
    rayleigh = ("low_ratio", "low_frequency", "high_ratio", "high_frequency")
    ratios = (1.27e-3, 0.275, 6.4e-4, 0.55), (3.8e-2, 5.29, 1.9e-2, 10.58)
    return gf.LineScene.from_dict(
        {name: like[name] for name in ("conductor", "ice", "wind", "aerodynamics")}
        | {
            "title": "three spans",
            "section": {
                "horizontal_tension": 21730.0,
                "strung_with_ice": True,
                "spans": [{"length": 125.88}] * 3,
                "suspensions": [string] * 2,
            },
            "damping": {
                name: dict(zip(rayleigh, values, strict=True))
                for name, values in zip(("translation", "twist"), ratios, strict=True)
            },
            "numerics": {"elements": 10, "time_step": 0.01},
        }
    )


def compare(python: str) -> None:
    """Print the CPU time of each job here and with another interpreter, in alternation."""
    found: dict[str, list[dict[str, float]]] = {sys.executable: [], python: []}
    for _ in range(COMPARISONS):
        for interpreter, times in found.items():
            given = [interpreter, __file__, TIMES]
            done = subprocess.run(given, check=True, capture_output=True, text=True)
            times.append(json.loads(done.stdout))
    print("\n| Job | CPU time [ms] | of the other release | Ratio |\n| --- | ---: | ---: | ---: |")
    for name in found[python][0]:
        own, other = (1e3 * min(one[name] for one in times) for times in found.values())
        print(f"| {name} | {own:.3g} | {other:.3g} | {other / own:.2f} |")


def times_of_jobs() -> dict[str, float]:
    """CPU time [s] of each job, of an atlas that of a draw; the least of two after a first one."""
    found = {}
    for name, (work, count) in jobs().items():
        work()
        found[name] = min(timed(work, 1) for _ in range(2)) / count
    return found


def parts_at_once() -> dict[str, float]:
    """Print the cost of each part for one scene and for several at once; return the gains."""
    print(
        f"| Part of the reduced model | Numbers in an array | One scene [us] | {AT_ONCE} at once,"
        " each [us] | Gain: median (quartiles) |\n| --- | ---: | ---: | ---: | --- |"
    )
    scene = gf.load_scene("example3")
    pairs = {
        portable: two_mode_estimate.pair_of(scene.with_values({"numerics.portable": portable}))
        for portable in (False, True)
    }
    amplitudes, winds = np.linspace(0.05, 0.6, 16), np.full(16, 5.5)

    def cycles(times: int, portable: bool = False) -> Callable[[], Any]:
        pair, many = pairs[portable], (np.tile(amplitudes, times), np.tile(winds, times))
        return lambda: two_mode_estimate._cycle(pair.model, pair.coupling, *many)

    model = span_diagram.span_model(scene)
    problem = span_problem.SpanProblem(span_problem.WindFamily(model), model, 5.5)
    phase = 2.0 * np.pi * np.arange(60) / 60  # 15 intervals of 4 Gauss points
    states = 0.3 * problem.scale * np.sin(phase[:, None] + np.arange(problem.size))

    def rates(times: int) -> Callable[[], Any]:
        return partial(problem.rates, np.tile(states, (times, 1)), 5.5)

    found = problem.rates(states, 5.5)
    n = problem.size
    jacobian, columns = found.by_state.reshape(15, 4, n, n), np.ones((15, 4, n, 3))

    def solutions(times: int) -> Callable[[], Any]:
        given = np.tile(jacobian, (times, 1, 1, 1)), np.full(15 * times, 0.1)
        return partial(
            elimination.eliminate_second_order, *given, np.tile(columns, (times, 1, 1, 1))
        )

    sections = pairs[False].model._projection.section.shape[2]
    of_orbit = len(phase) * model._projection.section.shape[2]
    of_cycles = 16 * two_mode_estimate.CYCLE_INSTANTS * sections
    rows = {
        "cycles of the estimate": (of_cycles, cycles),
        "the same, portable arithmetic": (of_cycles, partial(cycles, portable=True)),
        "reduced forces": (of_orbit, rates),
        "linear equations": (15 * (2 * n) ** 2, solutions),
    }
    gains = {}
    for name, (count, of) in rows.items():
        one, many = of(1), of(AT_ONCE)
        each: list[tuple[float, float]] = []
        for _ in range(ROUNDS):
            each.append((timed(one, CALLS), timed(many, CALLS // 4) / AT_ONCE))
        ratios = [a / b for a, b in each]
        low, median, high = statistics.quantiles(ratios, n=4)
        gains[name] = max(median, 1.0)
        single, together = (1e6 * statistics.median(column) for column in zip(*each, strict=True))
        print(
            f"| {name} | {count} | {single:.0f} | {together:.0f} |"
            f" {median:.2f} ({low:.2f} to {high:.2f}) |"
        )
    return gains


def timed(work: Callable[[], Any], calls: int) -> float:
    """CPU time [s] of a call."""
    began = time.process_time()
    for _ in range(calls):
        work()
    return (time.process_time() - began) / calls


class Clock:
    """Exclusive CPU times of the parts: time in a part within another counts for the inner one."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys((part.name for part in PARTS), 0.0)
        self.simulations = 0
        self._inner = [0.0]

    def wrapped(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function with a clock."""

        def clocked(*given: Any, **options: Any) -> Any:
            self._inner.append(0.0)
            began = time.process_time()
            try:
                return function(*given, **options)
            finally:
                whole = time.process_time() - began
                self.seconds[part] += whole - self._inner.pop()
                self._inner[-1] += whole

        return clocked

    def counted(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function with a counter of simulations."""

        def started(*given: Any, **options: Any) -> Any:
            self.simulations += 1
            return function(*given, **options)

        return started


def job(name: str, work: Callable[[], Any], gains: dict[str, float], count: int = 1) -> None:
    """Print a row: CPU time, shares of the parts, and the bound with all gains.

    Simulations can share lanes only if there are several.
    """
    work()
    plain = min(timed(work, 1) for _ in range(2))
    clock, before = Clock(), []
    for part in PARTS:
        for owner, attribute in part.functions:
            before.append((owner, attribute, getattr(owner, attribute)))
            setattr(owner, attribute, clock.wrapped(part.name, before[-1][2]))
    for owner, attribute in SIMULATIONS:
        before.append((owner, attribute, getattr(owner, attribute)))
        setattr(owner, attribute, clock.counted(before[-1][2]))
    try:
        whole = timed(work, 1)
    finally:
        for owner, attribute, function in before:
            setattr(owner, attribute, function)
    shares = {part: seconds / whole for part, seconds in clock.seconds.items()}
    lanes = LANES_GAIN if clock.simulations > 1 else 1.0
    gain = {"full model in time": lanes, **gains}
    left = 1.0 - sum(share * (1.0 - 1.0 / gain.get(part, 1.0)) for part, share in shares.items())
    cells = " | ".join(f"{share:.0%}" if share > 0.0 else "" for share in shares.values())
    print(
        f"| {name} | {1e3 * plain / count:.3g} | {clock.simulations or ''} | {cells} |"
        f" {1.0 - sum(shares.values()):.0%} | {1.0 / left:.2f} |",
        flush=True,
    )


if __name__ == "__main__":
    if sys.argv[1:] == [TIMES]:
        print(json.dumps(times_of_jobs()))
    else:
        main()
