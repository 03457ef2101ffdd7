"""simulate_condensed(scene): the motion of a span in a few modes, for screening and sweeps."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.condensation import CondensedSpan, condense, interpolated
from gallop_fmu.condensed_engine import CONDENSED_MODES, CondensedModel
from gallop_fmu.errors import SceneError
from gallop_fmu.outcome import Outcome, Report, SimulationError
from gallop_fmu.recording import Records, check_on_failure, chosen_nodes
from gallop_fmu.result import Result, histories
from gallop_fmu.scene import Scene
from gallop_fmu.simulation import Progress

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

STEPS_PER_PERIOD = 14
"""Time steps in a period of the first symmetric vertical mode."""

CHANNELS = ("u2", "u3", "theta", "v2", "v3", "omega", "tension", "angle_of_attack")
"""What a condensed run records at a node."""

STATIC_ITERATIONS = 50
"""Newton iterations within which an equilibrium in the wind must be found."""

PORTION = 1000
"""Records of one call of the kernel. Products with so many rows are still too small for NumPy to start threads on."""


def simulate_condensed(
    scene: Scene,
    stop_time: float | None = None,
    *,
    time_step: float | None = None,
    record_every: int | None = None,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = "midspan",
    progress: Progress | None = None,
    on_failure: Literal["raise", "return"] = "raise",
) -> Result:
    """Compute the motion of a span with its condensed model, about ten times as fast as `simulate`.

    Sixteen coupled modes (seven vertical, four horizontal, five torsional shapes, antisymmetric ones among them), the
    tension constant along the span, all of the aerodynamic curve, turning ice and the element's damping; the derivation
    stands in `gallop_fmu.condensation`. Steady amplitudes of the packaged Examples 2 and 3 are within 1 % of the
    element's, swing included; of ten drawn galloping scenes eight are within 2 % vertically and all within 4 %
    (`benchmarks/condensed.md`). Of a swing that comes and goes for ever it has the size, not the course. For a sweep or
    a first look; confirm what matters with `simulate`.

    Parameters
    ----------
    scene
        What to compute.
    stop_time
        Simulated time [s]; None takes the scene's.
    time_step
        Longest time step [s]; None takes a fourteenth of the first symmetric vertical period. The scene's time step has
        no part in it but to say when to record.
    record_every
        Time steps of the scene from one record to the next, as for `simulate`; None takes the scene's.
    record_nodes
        As for `simulate`, in the numbering of the scene's mesh.
    progress, on_failure
        As for `simulate`.

    Returns
    -------
    Result
        Laid out as that of `simulate`, with the node channels `CHANNELS`, ``wind_speed`` and ``horizontal_tension``.
        ``dataset.attrs["model"]`` says that the model was condensed.

    Raises
    ------
    SceneError
        If an argument is not allowed, or the scene is outside the model's range: a sag above 0.024 of the span, a
        height difference above half of it, moving towers, loads along the span, harmonic excitation above half of the
        lowest frequency that it leaves out.
    SimulationError
        If the run ends early (slack, attack angle out of range, motion not finite) and `on_failure` is ``"raise"``.
    """
    records = Records.of(scene, stop_time, record_every)
    check_on_failure(on_failure)
    if time_step is not None and not (math.isfinite(time_step) and time_step > 0.0):
        raise SceneError(f"time_step = {time_step}: must be a positive number of seconds")
    nodes = chosen_nodes(record_nodes, scene.numerics.elements)
    started = clock.perf_counter()
    span = condense(scene)
    pace = _Pace.of(records.interval, time_step or 1.0 / (STEPS_PER_PERIOD * span.vertical_hz))
    run = _Run(scene, span, pace, nodes)
    report = run.march(records, progress)
    seconds = clock.perf_counter() - started
    result = Result(_dataset(run, records, report, seconds), scene, report)
    if report.outcome is not Outcome.COMPLETED and on_failure == "raise":
        raise SimulationError(report, result)
    return result


@dataclass(frozen=True)
class _Pace:
    """Time step [s], steps to a record, records within a step; one of the latter is 1."""

    time_step: float
    every: int
    within: int

    @classmethod
    def of(cls, interval: float, longest: float) -> _Pace:
        within = math.floor(longest / interval * (1.0 + 1e-9))
        if within >= 1:
            return cls(within * interval, 1, within)
        every = math.ceil(interval / longest * (1.0 - 1e-9))
        return cls(interval / every, every, 1)


def _start(scene: Scene, span: CondensedSpan, kernel: CondensedModel) -> Array:
    """Coordinates at time 0: the seed, upon the static equilibrium in the wind if the scene asks for it."""
    if scene.initial.wind == "at_once":
        return span.start.copy()
    q, still, step = np.zeros(CONDENSED_MODES), np.zeros(CONDENSED_MODES), 1e-6
    squares = np.asarray(span.values["frequency"]) ** 2
    for _ in range(STATIC_ITERATIONS):
        force = kernel.forces(q, still)[0]
        slope = np.array(
            [(kernel.forces(q + row, still)[0] - force) / step for row in step * np.eye(CONDENSED_MODES)]
        ).T
        change = np.linalg.solve(np.diag(squares) - slope, force - squares * q)
        q = q + change
        if np.max(np.abs(change)) < 1e-9 * max(1.0, float(np.max(np.abs(q)))):
            return np.asarray(q + span.start)
    raise SimulationError(Report(Outcome.EQUILIBRIUM_NOT_FOUND, 0.0))


class _Run:
    """A condensed span on its way, and what has been recorded of it at some nodes."""

    def __init__(self, scene: Scene, span: CondensedSpan, pace: _Pace, nodes: NDArray[np.int32]) -> None:
        self.scene, self.span, self.pace, self.nodes = scene, span, pace, nodes
        self.kernel = CondensedModel(span.model, {**span.values, "time_step": pace.time_step})
        fraction = nodes / (2.0 * scene.numerics.elements)
        left, right = (interpolated(span.model, span.shapes, fraction, side) for side in (-1e-6, 1e-6))
        self._shape = np.concatenate([left.shape[:, :, component].T for component in (1, 2, 3)], axis=1)
        self._slope = np.concatenate(
            [at.slope[:, :, component].T for at in (left, right) for component in (1, 2)], axis=1
        )
        self._tangents = left.tangent, right.tangent
        self._moves: list[Array] = []  # (record, 3, node): u2, u3, theta
        self._rates: list[Array] = []
        self._tension: list[Array] = []  # (record, node)
        self.horizontal_tension: list[Array] = []

    def march(self, records: Records, progress: Progress | None) -> Report:
        """Run in portions, so that progress is shown and Ctrl-C is heard."""
        pace, report = self.pace, Report(Outcome.COMPLETED, 0.0, lowest_tension=math.inf)
        q, v = _start(self.scene, self.span, self.kernel), np.zeros(CONDENSED_MODES)
        self._record(np.stack([q, v])[None], np.array([self.span.horizontal_tension(q)]))
        steps = math.ceil(records.count / pace.within) * pace.every
        portion = max(1, PORTION // pace.within) * pace.every
        for first in range(0, steps, portion):
            stopped = False
            try:
                history, tension, report = self.kernel.run(
                    q, v, first, min(portion, steps - first), pace.every, pace.within, report
                )
                self._record(history, tension)
                if report.outcome is not Outcome.COMPLETED:
                    break
                reached = min(report.time, records.stop_time)
                stopped = progress is not None and progress(reached, records.stop_time) is False
            except KeyboardInterrupt:
                stopped = True
            if stopped and first + portion < steps:
                return replace(report, outcome=Outcome.STOPPED_BY_USER)
        return report

    def _record(self, history: Array, horizontal: Array) -> None:
        q, v = np.ascontiguousarray(history[:, 0]), np.ascontiguousarray(history[:, 1])
        self._moves.append((q @ self._shape).reshape(len(q), 3, -1))
        self._rates.append((v @ self._shape).reshape(len(q), 3, -1))
        slopes, stretch = (q @ self._slope).reshape(len(q), 2, 2, -1), 0.0
        for side, tangent in enumerate(self._tangents):  # averaged between neighbouring elements
            rise, drift = slopes[:, side, 0] + tangent[:, 1], slopes[:, side, 1]
            stretch = stretch + 0.5 * np.sqrt(1.0 + (rise**2 + drift**2) / tangent[:, 0] ** 2)
        self._tension.append(horizontal[:, None] * stretch)
        self.horizontal_tension.append(horizontal)

    def node_values(self, time: NDArray[np.floating], wind: NDArray[np.floating]) -> dict[str, Array]:
        """Histories (time, node) by channel."""
        moves, rates = (np.concatenate(parts)[: len(time)] for parts in (self._moves, self._rates))
        (u2, u3, theta), (v2, v3, omega) = np.moveaxis(moves, 1, 0), np.moveaxis(rates, 1, 0)
        aerodynamics = self.scene.aerodynamics
        radius = (aerodynamics and aerodynamics.reference_radius) or 0.5 * self.scene.conductor.diameter
        relative = np.arctan2(-v2 - radius * omega, wind[:, None] - v3)
        angle = math.radians(self.scene.ice.attack_angle_deg) + theta + relative
        tension = np.concatenate(self._tension)[: len(time)]
        return dict(zip(CHANNELS, (u2, u3, theta, v2, v3, omega, tension, angle), strict=True))


def _dataset(run: _Run, records: Records, report: Report, seconds: float) -> xr.Dataset:
    scene, span = run.scene, run.span
    tension = np.concatenate(run.horizontal_tension)[: records.count + 1]
    time = records.interval * np.arange(len(tension))
    history = scene.wind.history
    wind = np.asarray(history.at(time)) if history else np.full(len(time), scene.wind.speed or 0.0)
    values = run.node_values(time, wind)
    variables: dict[str, tuple[tuple[str, ...], Array]] = {name: (("time", "node"), values[name]) for name in CHANNELS}
    variables |= {"wind_speed": (("time",), wind), "horizontal_tension": (("time",), tension)}
    rest = span.model.equilibrium()
    return histories(
        variables,
        time,
        run.nodes,
        interpolated(span.model, rest.x[None], run.nodes / (2.0 * scene.numerics.elements)).shape[:, 0, 0],
        scene,
        rest,
        report,
        seconds,
        model=f"condensed: {len(span.frequency_hz)} modes, tension constant along the span",
        integrator="exponential Runge-Kutta of order four (Cox, Matthews 2002)",
        time_step=run.pace.time_step,
    )
