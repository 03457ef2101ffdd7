"""Stable states of a line in its wind, by simulations that start near all dominant motions.

A line has many motions that differ little, because its spans gallop almost independently. Instead
of following all of them, simulations with the full model start on the motions that the wind drives
most (`modal.screening.line_rest.Trial`), at the amplitude of an energy balance, each with a small
disturbance in all other ways. They end in stable states. If none does, one more starts near rest in
still air, where simulations of the scene start, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.foundation.text_rules import counted
from modal.motions.full_model import CHANNELS, full_scene
from modal.motions.line_model import LineModel
from modal.motions.span_problem import WIND_SPEED
from modal.screening.line_rest import LineRest, Trial
from modal.screening.line_states import (
    LineState,
    bundle_radius,
    histories,
    state_at_end,
)

Array = NDArray[np.float64]

STEPS, RECORDS = 60, 20
"""Time steps and records in a period of the first vertical mode."""

CHUNK, LEAST, MAX_CHUNKS, LONG_CHUNKS = 100, 3, 12, 36
"""Periods after which a simulation is looked at; so often at least, and at most if a state is known
already, and if none is."""

LATE, SHORT_LATE, SHORT_FROM = 0.6, 0.3, 10
"""Parts of a simulation at its end in which amplitudes are read; the second, if it has not settled
in the first, from so many chunks on."""

NEAR = 0.05
"""Difference of amplitudes, relative to the largest, below which a simulation has come to a known
state."""

BEATING_LEAST, IRREGULAR = 6, 10
"""Number of chunks from which a motion that beats is one, and one that is irregular."""

DISTURBANCE = 0.03
"""Disturbance of all other motions at the start, relative to their typical amplitude."""

MAX_RUNS = 4
"""Largest number of simulations."""

ENOUGH_ALIKE = 3
"""Number of simulations after which there are no more, if all of them end in the same state."""

NEWTON_TOLERANCE, OF_BUNDLES = 1e-5, 1e-6
"""Tolerances [m] of Newton's method in a time step, of single conductors and of bundles. Amplitudes
after 600 periods differ from those with 1e-8 by at most 4e-4 and 3e-3 of the largest; with a tenth
of each, a simulation takes 15 % longer."""

ALIKE = 0.15
"""Difference of amplitudes, relative to the largest, below which two states are the same."""

MIN_TURN = 0.1
"""Difference of mean rotations [rad] above which two equilibria are different."""

BELOW = 0.7
"""Part of the estimated amplitude with which a motion starts."""

GOLDEN = 2.4
"""Difference of phase [rad] of the motions that start together: they are out of step."""


@dataclass(frozen=True)
class LineSettled:
    """States of a line in its wind.

    Attributes
    ----------
    states : tuple of LineState
        Stable states, each once.
    doubts : tuple of str
        What could not be resolved, as sentences.
    """

    states: tuple[LineState, ...]
    doubts: tuple[str, ...]


def settled_states(
    rest: LineRest, equilibria: Sequence[tuple[Array, bool]], trials: Sequence[Trial]
) -> LineSettled:
    """Find stable states in the scene's wind.

    Parameters
    ----------
    rest
        Rest over the wind.
    equilibria
        Those in the scene's wind, and True for stable ones.
    trials
        Modes of the first of them.
    """
    doubts = [] if equilibria else ["no equilibrium was found in the scene's wind"]
    found = _Found([_at_rest(rest.model, state) for state, is_stable in equilibria if is_stable])
    noise = _disturbance(rest)
    starts = _starts(*equilibria[0], trials) if equilibria else []
    for number, start in enumerate(starts):
        if number < ENOUGH_ALIKE or len(found.states) > 1 or doubts or not found.all_settled:
            found.add(*_simulated(rest, start + noise, found.settled))
    if not found.settled:
        found.add(*_simulated(rest, noise, []))
    doubts += found.doubts(rest.wind)
    return LineSettled(tuple(found.states), tuple(dict.fromkeys(doubts)))


@dataclass
class _Found:
    """States that were found so far, each once, and what simulations ended early."""

    states: list[LineState]
    early: list[str] = field(default_factory=list)
    runs: int = 0

    @property
    def settled(self) -> list[LineState]:
        """States that had settled."""
        return [one for one in self.states if one.kind != "not settled"]

    @property
    def all_settled(self) -> bool:
        """True if no simulation ended early or unsettled."""
        return not self.early and len(self.settled) == len(self.states)

    def add(self, state: LineState | None, reason: str) -> None:
        """Add the end of a simulation, or why it ended early."""
        self.runs += 1
        if state is None:
            self.early.append(reason)
        elif not any(is_same(state, one) for one in self.settled):
            unlike = [one for one in self.states if not is_same(state, one)]
            self.states = [*unlike, state]

    def doubts(self, wind: float) -> list[str]:
        """What could not be resolved, as sentences."""
        unsettled = [one for one in self.states if one.kind == "not settled"]
        found = [f"{one}: it had not settled at the end of a simulation" for one in unsettled]
        if self.early:
            first = self.early[0].split(" What to do")[0].rstrip(".")
            found.append(
                f"{len(self.early)} of {counted(self.runs, 'simulation')} at {wind:.4g} m/s ended"
                f" early; reason of the first: {first}"
            )
        return found


def _starts(state: Array, is_stable: bool, trials: Sequence[Trial]) -> list[Array]:
    """States from which simulations start, the most important first."""
    kinds: dict[tuple[str, int], list[Trial]] = {}
    for one in trials:
        if one.size is not None:
            kinds.setdefault((one.kind, one.loops), []).append(one)
    groups = sorted(kinds.values(), key=lambda group: (group[0].loops, -group[0].rate))
    starts = [_moving(state, group[:1]) for group in groups]
    if groups and len(groups[0]) > 1:
        starts.insert(1, _moving(state, groups[0]))
    if not is_stable:
        starts.insert(1, state)
    return starts[:MAX_RUNS]


def _moving(state: Array, group: Sequence[Trial]) -> Array:
    """State with the motions of a group, out of step and with less amplitude if there are many."""
    n = len(state) // 2
    found = state.copy()
    for number, one in enumerate(group):
        assert one.size is not None
        shape = BELOW * one.size / np.sqrt(len(group)) * np.exp(1j * GOLDEN * number) * one.shape
        found[:n] += shape.real
        found[n:] += (1j * one.omega * shape).real
    return found


def _disturbance(rest: LineRest) -> Array:
    """Small displacement of two modes of each part of the motion but twist."""
    model, change = rest.model, np.zeros(rest.problem.size)
    for family, alike in model.groups():
        if family != "torsional":
            for number, mode in enumerate(alike[:2]):
                change[mode] = DISTURBANCE * rest.problem.scale[mode] / (1.0 + number)
    return change


def _simulated(
    rest: LineRest, start: Array, known: Sequence[LineState]
) -> tuple[LineState | None, str]:
    """State in which a simulation with the full model ends; if it ended early, None and why."""
    model = rest.model
    is_bundle = model.scene.bundle.subconductors > 1
    tolerance = OF_BUNDLES if is_bundle else NEWTON_TOLERANCE
    scene = full_scene(model.scene, WIND_SPEED, rest.wind, model, STEPS, tolerance=tolerance)
    full = Model(scene, inputs=False)
    n = model.size
    u, v = model.nodal(start[None, :n], start[None, n:])
    every = STEPS // RECORDS
    interval = every * scene.numerics.time_step
    parts, found = list[Array](), None
    try:
        moving = full.place(u[0], v[0])
        for number in range(1, (MAX_CHUNKS if known else LONG_CHUNKS) + 1):
            run = moving.run(CHUNK * RECORDS, every, CHANNELS, model.watched_nodes)
            if run.report.outcome is not Outcome.COMPLETED:
                return None, str(run.report)
            parts.append(run.node_values)
            if number < LEAST:
                continue
            found = _end_of(model, parts, interval)
            if found.kind in ("rest", "periodic") or any(is_same(found, a, NEAR) for a in known):
                break
            if found.kind == "beating" and number >= BEATING_LEAST:
                break
    except SimulationError as problem:
        return None, str(problem.report)
    return found, ""


def _end_of(model: LineModel, parts: Sequence[Array], interval: float) -> LineState:
    """State at the end of the chunks of a simulation."""
    moves = histories(model, np.concatenate(parts), interval)
    spans, radius = model.mesh.model.map.spans, bundle_radius(model)
    found = state_at_end(moves.last(LATE), spans, radius, len(parts) >= IRREGULAR)
    if found.kind == "not settled" and len(parts) >= SHORT_FROM:
        short = state_at_end(moves.last(SHORT_LATE), spans, radius)
        return found if short.kind == "not settled" else short
    return found


def _at_rest(model: LineModel, state: Array) -> LineState:
    """Equilibrium as a state."""
    n = model.size
    u, _ = model.nodal(state[None, :n], np.zeros((1, n)))
    values = u[:, model.watched_nodes][:, :, 1:].swapaxes(1, 2)
    spans = model.mesh.model.map.spans
    return state_at_end(histories(model, values, 1.0), spans, bundle_radius(model))


def is_same(one: LineState, other: LineState, alike: float = ALIKE) -> bool:
    """True if two states have the same amplitudes everywhere, or the same rotation at rest."""
    if (one.kind == "rest") != (other.kind == "rest"):
        return False
    if one.kind == "rest":
        turns = zip(one.mean_rotation, other.mean_rotation, strict=True)
        return max(abs(a - b) for a, b in turns) < MIN_TURN
    return difference(one, other) < alike


def difference(one: LineState, other: LineState) -> float:
    """Largest difference of the amplitudes of two motions, relative to the largest of them."""
    away = np.abs(one.displacements - other.displacements)
    return float(np.max(away) / max(one.largest, other.largest))
