"""One run of a random scene, and what is checked of it."""

from __future__ import annotations

import math
import time as clock
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model, Outcome, Scene, SceneError, SimulationError
from gallop_fmu.engine.model import Run, State
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX
from gallop_fmu.simulation.energy_balance import EnergyBalance, account
from gallop_fmu.simulation.run_warnings import fastest_motion, step_warnings
from support.random_spans import Stress, stress_scene

Array = NDArray[np.float64]

ALL = np.arange(len(NODE_CHANNELS), dtype=np.int32)
MOTION = slice(0, 12)
GAUSS = 1.0 / math.sqrt(3.0)

CLOSED = 0.05
"""Maximum energy imbalance over the turnover of a completed run without a warning."""

SHORTER = (8, 64)
"""Factors of the number of steps with which a suspect is repeated, until its balance closes."""

PATIENCE, PORTION = 100_000, 5
"""Limit of elements times Newton iterations; steps between two checks of it."""

AGREEMENT = 1e-6
"""Relative difference of tensions and elongations: limited by a mesh's horizontal tension."""


@dataclass
class Verdict:
    """Outcome of a run and of its checks.

    Attributes
    ----------
    name
        Seed and number of the scene.
    integrator
        By which it was run.
    outcome
        Name of the outcome; "scene refused" if the scene was not valid.
    steps, halvings, iterations
        Work done.
    step_too_long
        Whether the report warns of too long steps.
    axial
        Time step over the period of the first axial mode.
    imbalance
        Worst energy imbalance over the turnover.
    tension_error
        Largest difference of a mid-side node's tension from Hooke's law, over the largest tension.
    amplitude
        Largest displacement over the span's length.
    seconds
        Processor time [s].
    faults
        What must not be: one text each.
    """

    name: str
    integrator: str
    outcome: str
    message: str = ""
    steps: int = 0
    halvings: int = 0
    step_too_long: bool = False
    iterations: int = 0
    axial: float = 0.0
    imbalance: float = 0.0
    tension_error: float = 0.0
    amplitude: float = 0.0
    seconds: float = 0.0
    faults: list[str] = field(default_factory=list)


def judge_scene(task: tuple[int, int, dict[str, Any]]) -> Verdict:
    """Judge the scene of a seed and a number, with some values of its numerics replaced."""
    return judge(stress_scene(*task))


def judge(stress: Stress) -> Verdict:
    """Run a random scene and check it."""
    began = clock.process_time()
    verdict = Verdict(
        stress.name, stress.data["numerics"].get("integrator", "newmark"), "completed"
    )
    try:
        _run(stress, verdict)
    except SceneError as refused:
        verdict.outcome, verdict.message = "scene refused", str(refused)
    except SimulationError as failed:
        verdict.outcome, verdict.message = failed.report.outcome.name.lower(), str(failed)
    verdict.seconds = clock.process_time() - began
    return verdict


def _run(stress: Stress, verdict: Verdict) -> None:
    scene = Scene.from_dict(stress.data)
    model = Model(scene)
    run, first = _records(stress, model)
    report = run.report
    verdict.outcome, verdict.message = (
        report.outcome.name.lower(),
        " ".join([str(report), *report.warnings]),
    )
    verdict.steps, verdict.halvings, verdict.iterations = (
        len(run.span_values),
        report.halvings,
        report.iterations,
    )
    verdict.step_too_long = report.step_too_long
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    wave = math.sqrt(scene.conductor.axial_stiffness / mass)
    verdict.axial = stress.step * wave / (2.0 * model.equilibrium().length)
    nodes = np.concatenate([first.node_values, run.node_values]).transpose(0, 2, 1)
    span = np.concatenate([first.span_values, run.span_values])
    if not (np.isfinite(nodes).all() and np.isfinite(span).all()):
        verdict.faults.append("a recorded value is not finite")
        return
    verdict.amplitude = float(np.abs(nodes[..., :3]).max()) / scene.span.length
    if verdict.amplitude > 1.0:
        verdict.faults.append(f"amplitude of {verdict.amplitude:.3g} spans")
    if not np.all(nodes[..., NODE_INDEX["tension"]][:, 1::2] >= 0.0):
        verdict.faults.append("recorded tension is below zero")
    verdict.tension_error = tension_error(model, nodes)
    warned = report.step_too_long or bool(_step_warnings(scene, nodes[:, scene.numerics.elements]))
    if verdict.tension_error > AGREEMENT:
        verdict.faults.append(f"tension and elongation differ by {verdict.tension_error:.3g}")
    time = stress.step * np.arange(len(span))
    if report.halvings:
        time, nodes, span = _parts_of_steps(stress, model, len(run.span_values))
    inputs = stress.inputs if stress.reversal else None
    balance = account(model, time, nodes[..., MOTION], span, inputs)
    verdict.imbalance = balance.worst
    if report.outcome is Outcome.COMPLETED and verdict.imbalance > CLOSED and not warned:
        if not _stored_as_with_short_steps(balance, stress):
            verdict.faults.append(
                f"energy is out of balance by {verdict.imbalance:.3g}, and no warning"
            )


def _step_warnings(scene: Scene, motion: Array) -> tuple[str, ...]:
    """Warnings of `simulate`, from the channels at mid-span, (time, channel), after each step."""
    step = scene.numerics.time_step
    moves, rates = (
        [motion[:, NODE_INDEX[name]] for name in names] for names in (("u2", "u3"), ("v2", "v3"))
    )
    return step_warnings(scene, fastest_motion(step, moves, rates), step)


def _stored_as_with_short_steps(balance: EnergyBalance, stress: Stress) -> bool:
    """Check that shorter steps, whose balance closes, store the same energy.

    Then it is the account that does not see, from the ends of long steps, what wind and damping do
    within them.
    """
    for shorter in SHORTER:
        finer = replace(stress, data=deepcopy(stress.data), steps=shorter * stress.steps)
        finer.data["numerics"]["time_step"] = stress.step / shorter
        model = Model(Scene.from_dict(finer.data))
        run, first = _records(finer, model)
        nodes = np.concatenate([first.node_values, run.node_values]).transpose(0, 2, 1)
        span = np.concatenate([first.span_values, run.span_values])
        inputs = finer.inputs if finer.reversal else None
        other = account(model, finer.step * np.arange(len(span)), nodes[..., MOTION], span, inputs)
        if other.worst <= CLOSED:
            stored, fine = (both.kinetic + both.potential for both in (balance, other))
            common = balance.time <= other.time[-1]  # a run that is cut short for its work
            difference = (stored - stored[0] - np.interp(balance.time, other.time, fine - fine[0]))[
                common
            ]
            return bool(np.abs(difference).max() <= CLOSED * (other.turnover + other.round_off))
    return False


def _observed(state: State) -> tuple[Array, Array]:
    """All channels at all nodes, (channel, node), and all span channels."""
    return (
        np.array([state.observe_node(node) for node in range(state.model.nodes)]).T,
        state.observe_span(),
    )


def _parts_of_steps(stress: Stress, model: Model, steps: int) -> tuple[Array, Array, Array]:
    """Times, node and span channels at the start and after each step or part of a halved step.

    Records at the ends of a halved step do not show the work within it: released out of
    equilibrium, a span may lose most of its energy to damping in the first one.
    """
    state = model.start(0.0, stress.inputs(0.0) if stress.reversal else None)
    times, rows = [0.0], [_observed(state)]

    def carry_out(begin: float, end: float) -> None:
        saved = state.save()
        report = state.advance(end, stress.inputs(begin) if stress.reversal else None)
        if report.halvings:  # a state that was restored has never had one
            state.restore(saved)
            middle = 0.5 * (begin + end)
            carry_out(begin, middle)
            carry_out(middle, end)
        else:
            times.append(end)
            rows.append(_observed(state))

    with suppress(SimulationError):  # the end of the run is already known
        for i in range(steps):
            carry_out(i * stress.step, (i + 1) * stress.step)
    return (
        np.array(times),
        np.array([row[0] for row in rows]).transpose(0, 2, 1),
        np.array([row[1] for row in rows]),
    )


def _records(stress: Stress, model: Model) -> tuple[Run, Run]:
    """All channels at all nodes after each step, and at the start."""
    nodes = np.arange(model.nodes, dtype=np.int32)
    inputs = stress.inputs if stress.reversal else None
    state = model.start(0.0, inputs(0.0) if inputs else None)
    start, done = _observed(state), 0
    parts: list[Run] = []
    while done < stress.steps and (not parts or parts[-1].report.outcome is Outcome.COMPLETED):
        count = min(PORTION, stress.steps - done)
        if inputs:
            parts.append(_driven(stress, state, done, count))
        else:
            parts.append(state.run(count, 1, ALL, nodes, first=done))
        done += count
        if parts[-1].report.iterations * model.elements > PATIENCE:
            break
    run = Run(
        np.concatenate([part.node_values for part in parts]),
        np.concatenate([part.span_values for part in parts]),
        parts[-1].report,
    )
    return run, Run(start[0][np.newaxis], start[1][np.newaxis], run.report)


def _driven(stress: Stress, state: State, done: int, count: int) -> Run:
    """Steps driven by inputs, as `State.run` gives them."""
    rows: list[tuple[Array, Array]] = []
    for i in range(done, done + count):
        try:
            report = state.advance((i + 1) * stress.step, stress.inputs(i * stress.step))
        except SimulationError as failed:
            report = failed.report
            break
        rows.append(_observed(state))
    nodes, span = (
        np.array([row[k] for row in rows]).reshape(len(rows), *_observed(state)[k].shape)
        for k in range(2)
    )
    return Run(nodes, span, report)


def tension_error(model: Model, nodes: Array) -> float:
    """Maximum difference of recorded tensions and Hooke's law on elongations, over the maximum.

    At mid-side nodes, where the recorded tension is the mean of both Gauss points; nodes (time,
    node, channel).
    """
    stiffness, equilibrium = model.scene.conductor.axial_stiffness, model.equilibrium()
    reference = _slopes(equilibrium.x[np.newaxis])[0]
    stretch0 = np.linalg.norm(reference, axis=-1)
    moved = _slopes(equilibrium.x + nodes[..., :3])
    stretch = np.linalg.norm(moved, axis=-1) / stretch0
    initial = equilibrium.horizontal_tension * stretch0 / reference[..., 0]
    force = (initial + stiffness * 0.5 * (stretch**2 - 1.0)) * stretch
    recorded = nodes[:, 1::2, NODE_INDEX["tension"]]
    return float(np.abs(force.mean(axis=-1) - recorded).max() / np.abs(recorded).max())


def _slopes(x: Array) -> Array:
    """dx/dxi at both Gauss points, (time, element, point, 3), from nodes (time, node, 3)."""
    left, middle, right = x[:, :-2:2], x[:, 1::2], x[:, 2::2]
    return np.stack(
        [(xi - 0.5) * left - 2.0 * xi * middle + (xi + 0.5) * right for xi in (-GAUSS, GAUSS)],
        axis=2,
    )
