"""MoorDyn: one line of 40 segments without water. Example 1 only, as MoorDyn has no lift.

It takes no loads that change in time.  All nodes weigh the same and carry the same load, so
accelerating both supports against the load is exactly the same problem, seen from the supports.
MoorDyn's own stationary solver finds the shape once, to 0.04 mm of sag; every run starts from that
state, and temporal errors are against MoorDyn's finest run from it. Scheme: MoorDyn's Runge-Kutta
4.  Its others diverge without internal damping, or need a smaller step.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import moordyn
import numpy as np
from cases import Case
from chain import chain
from scenes import INTERVAL, LOADED_POINTS, Array, Problem

SETTINGS = ((5e-4, 0.01), (5e-4, 0.005), (5e-4, 0.0025), (5e-4, 0.001), (5e-4, 0.0005))
"""Internal step and coupling step [s]; the supports' speed is constant over the latter."""

FINEST = (2.5e-4, 0.00025)
DEPTH = -50.0

DECK = """MoorDyn deck
---------------------- LINE TYPES ---------------------------------------
Name Diam MassDenInAir EA BA EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s) (N-m2) (-) (-) (-) (-)
cable 0.03 {mass!r} {stiffness!r} 0 0 0 0 0 0
---------------------- POINTS -------------------------------------------
ID Type X Y Z Mass Volume CdA CA
(-) (-) (m) (m) (m) (kg) (m3) (m2) (-)
1 Coupled 0 0 {depth} 0 0 0 0
2 Coupled {length} 0 {depth} 0 0 0 0
---------------------- LINES --------------------------------------------
ID LineType NodeA NodeB UnstrLen NumSegs Outputs
(-) (-) (-) (-) (m) (-) (-)
1 cable 1 2 {rest!r} {segments} -
---------------------- OPTIONS ------------------------------------------
0 writeLog
{step} dtM
RK4 tScheme
{gravity} g
0.0 rho
100 WtrDpth
0 ICgenDynamic
1e-12 threshIC
200 TmaxIC
0.1 dtIC
---------------------- need this line -----------------------------------
"""


def cases(problem: Problem) -> list[Case]:
    if problem.wind is not None:
        return []
    return [
        Case(
            "MoorDyn",
            "MoorDyn, Runge-Kutta 4",
            f"step {1e3 * step:g} ms, coupling {1e3 * coupling:g} ms",
            "MoorDyn",
            lambda step=step, coupling=coupling: prepare(problem, step, coupling),
        )
        for step, coupling in SETTINGS
    ]


def converged(problem: Problem) -> Array:
    return prepare(problem, *FINEST)()


@contextmanager
def silence() -> Iterator[None]:
    """MoorDyn prints the time at every step; a terminal would cost more than the run."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def _create(problem: Problem, step: float, segments: int) -> object:
    span = chain(problem, segments)
    deck = Path(_folder.name) / "lines.txt"
    deck.write_text(
        DECK.format(
            mass=span.node_mass / span.rest,
            stiffness=span.stiffness,
            depth=DEPTH,
            length=problem.length,
            rest=span.rest * segments,
            segments=segments,
            step=step,
            gravity=problem.gravity,
        )
    )
    return moordyn.Create(str(deck))


def _supports(problem: Problem) -> Array:
    return np.array([0.0, 0.0, DEPTH, problem.length, 0.0, DEPTH])


_folder = (
    tempfile.TemporaryDirectory()
)  # MoorDyn writes its outputs next to the input file until it is closed
_rest_states: dict[tuple[str, int], bytes] = {}


def _rest_state(problem: Problem, segments: int) -> bytes:
    """MoorDyn's equilibrium, found once: it takes several seconds."""
    key = problem.name, segments
    if key not in _rest_states:
        system = _create(problem, FINEST[0] * 40 / segments, segments)
        moordyn.Init(system, _supports(problem), np.zeros(6))
        _rest_states[key] = moordyn.Serialize(system)
        moordyn.Close(system)
    return _rest_states[key]


def prepare(
    problem: Problem, step: float, coupling: float, segments: int = LOADED_POINTS + 1
) -> Callable[[], Array]:
    span = chain(problem, segments)
    with silence():
        start = _rest_state(problem, segments)
        system = _create(problem, step, segments)
        moordyn.Init_NoIC(system, _supports(problem), np.zeros(6))
        moordyn.Deserialize(system, start)
    line, middle, every = (
        moordyn.GetLine(system, 1),
        span.position.shape[1] // 2,
        round(INTERVAL / coupling),
    )
    origin = np.array(moordyn.GetLineNodePos(line, middle))
    travel = _twice_integrated(coupling, len(problem.times) * every)
    along, up = -problem.load[2] / span.node_mass, -problem.load[1] / span.node_mass
    direction = np.array([0.0, along, up] * 2)

    def advance() -> Array:
        out, k = np.empty((len(problem.times), 2)), 0
        with silence():
            for record in range(len(out)):
                for _ in range(every):
                    position = _supports(problem) + direction * travel[k]
                    speed = direction * ((travel[k + 1] - travel[k]) / coupling)
                    moordyn.Step(system, position, speed, k * coupling, coupling)
                    k += 1
                moved = np.array(moordyn.GetLineNodePos(line, middle)) - origin
                out[record] = moved[2] - up * travel[k], moved[1] - along * travel[k]
            moordyn.Close(system)
        return out

    return advance


def _twice_integrated(interval: float, count: int) -> Array:
    """Double integral of the smooth step of 1 s, at every coupling time."""
    time = interval * np.arange(count + 1)
    x, after = np.minimum(time, 1.0), np.maximum(time - 1.0, 0.0)
    return 0.5 * x**5 - 0.5 * x**6 + x**7 / 7.0 + 0.5 * after + 0.5 * after**2
