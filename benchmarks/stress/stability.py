"""Limits of step, wind and mesh: outcome of a hard start, error of limit cycles over the step."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Any

import numpy as np

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.simulation.energy_balance import account
from support.conservation import integrators

STEPS = (0.0025, 0.005, 0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2)
WINDS = (0.0, 5.5, 10.0, 20.0, 40.0, 60.0)
MESHES = (5, 15, 40, 100)
LONGEST, MOST = 20.0, 1000
"""Simulated time [s] of a cell of the map, and its most steps."""

START = {"initial.seed_vertical": 0.3, "initial.seed_horizontal": 0.1, "initial.seed_twist": 0.2}
"""Start of the map [m, rad]: released at an amplitude of galloping, with the full wind at once."""

NEWTON = 1e-9
"""Newton tolerance of all runs, the default of scenes: only the step varies."""

CYCLE_STEPS = (0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.12, 0.15, 0.2)
"""Steps at which limit cycles are measured [s]; the first is the reference."""

CYCLE_ELEMENTS = 10
"""Elements of the limit cycles; 15 change no amplitude by more than 1 %."""

WINDOW = 200.0
"""Time [s] at the end of a run over which an amplitude is half of peak to peak."""

SPRING = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": 1e9}
RIGID = {"kind": "rigid"}
CYCLES: dict[str, tuple[str, float, dict[str, Any]]] = {
    "example 2, 4.1 m/s": ("example2", 1500.0, {}),
    "example 3, 5.0 m/s": ("example3", 1600.0, {"wind.speed": 5.0}),
    "example 3, 5.5 m/s": ("example3", 1400.0, {}),
    "example 3, soft: ends on springs of 76 kN/m": (
        "example3", 1400.0, {"supports.left": SPRING, "supports.right": SPRING},
    ),
    "example 2, stiff: rigid ends": ("example2", 1500.0, {"supports.left": RIGID,
    "supports.right": RIGID}),
}  # fmt: skip
"""Name of a limit cycle: scene, simulated time [s], changed values."""

PARTNER = 0.05
"""Horizontal amplitude over the vertical one from which its error counts too."""


@dataclass(frozen=True)
class Cell:
    """One place of the map, with how its run ended.

    `halved` is the share of steps that were divided, `imbalance` the worst energy imbalance over
    the turnover.
    """

    integrator: str
    step: float
    wind: float
    elements: int
    outcome: str
    reached: float
    halved: float
    iterations: float
    imbalance: float
    seconds: float


def cell(place: tuple[str, float, float, int]) -> Cell:
    """Run one place of the map: integrator, step [s], wind speed [m/s], elements."""
    integrator, step, wind, elements = place
    began = clock.process_time()
    scene = gf.load_scene("example3").with_values({
        "numerics.time_step": step, "numerics.elements": elements, "wind.speed": wind,
        "aerodynamics.outside": "hold",
        "numerics.newton_tolerance": NEWTON, **START, **integrators()[integrator],
    })  # fmt: skip
    model = Model(scene)
    state = model.start()
    nodes, channels = np.arange(model.nodes, dtype=np.int32), np.arange(12, dtype=np.int32)
    start = np.array([state.observe_node(int(node))[:12] for node in nodes])
    span = state.observe_span()
    run = state.run(min(MOST, round(LONGEST / step)), 1, channels, nodes)
    motion = np.concatenate([start[np.newaxis], run.node_values.transpose(0, 2, 1)])
    balance = account(
        model, step * np.arange(len(motion)), motion, np.concatenate([[span], run.span_values])
    )
    taken = max(1, len(run.span_values))
    divided = float(np.mean(run.span_values[:, -1] > 1.0)) if len(run.span_values) else 1.0
    return Cell(
        integrator, step, wind, elements, run.report.outcome.name.lower(), run.report.time, divided,
        run.report.iterations / taken, balance.worst, clock.process_time() - began,
    )  # fmt: skip


@dataclass(frozen=True)
class Cycle:
    """Limit cycle at one step: amplitudes at mid-span [m], vertical frequency [Hz], work."""

    integrator: str
    name: str
    step: float
    outcome: str
    vertical: float
    horizontal: float
    frequency: float
    halvings: int
    iterations: float
    seconds: float


def cycle(place: tuple[str, str, float]) -> Cycle:
    """Run one limit cycle: integrator, name, step [s]."""
    integrator, name, step = place
    packaged, duration, values = CYCLES[name]
    began = clock.process_time()
    numerics = {"time_step": step, "elements": CYCLE_ELEMENTS, "newton_tolerance": NEWTON}
    changed = {
        **{f"numerics.{key}": value for key, value in numerics.items()},
        **values,
        **integrators()[integrator],
    }
    scene = gf.load_scene(packaged).with_values(changed)
    every = max(1, round(0.02 / step))
    result = gf.simulate(
        scene, stop_time=duration, record_every=every, on_failure="return", channels=("u2", "u3")
    )
    report = result.report
    steady = result.steady(WINDOW) if report.outcome is gf.Outcome.COMPLETED else None
    return Cycle(
        integrator, name, step, report.outcome.name.lower(),
        steady["u2"].amplitude if steady else np.nan, steady["u3"].amplitude if steady else np.nan,
        steady["u2"].frequency_hz if steady else np.nan, report.halvings,
        report.iterations / max(1, report.steps),
        clock.process_time() - began,
    )  # fmt: skip


def error(found: Cycle, reference: Cycle) -> float:
    """Larger relative error of the vertical and, where not negligible, the horizontal amplitude."""
    errors = [abs(found.vertical / reference.vertical - 1.0)]
    if reference.horizontal > PARTNER * reference.vertical:
        errors.append(abs(found.horizontal / reference.horizontal - 1.0))
    return float(max(errors))


def largest_step(cycles: list[Cycle], bound: float) -> float:
    """Largest step [s] up to which all steps keep the amplitudes close to the smallest step's."""
    ordered = sorted(cycles, key=lambda found: found.step)
    kept = ordered[0].step
    for found in ordered[1:]:
        if not error(found, ordered[0]) <= bound:
            break
        kept = found.step
    return kept
