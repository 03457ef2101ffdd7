"""Findings of a report on a span. A part that cannot be computed is kept as the reason."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import (
    Inputs,
    LineScene,
    Model,
    Outcome,
    Result,
    Scene,
    SceneError,
    SimulationError,
    simulate,
)
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.simulation.clearance import Ellipse, cigre_322_single_loop, davison_single_loop
from gallop_fmu.simulation.run_options import check_stop_time
from modal.foundation import one_span as instead
from modal.linear.modes import Mode, natural_modes
from modal.linear.shallow_cable import ShallowCable, shallow_cable
from modal.screening.screen import Screening, screen
from modal.stability.criteria import Criterion, stability_criteria
from modal.stability.critical_wind import CriticalWind, critical_wind_speed
from modal.stability.frequency_ratio import (
    DesignChange,
    FrequencyRatio,
    frequency_ratio,
    suggest_design_changes,
)

Array = NDArray[np.float64]
T = TypeVar("T")

Progress = Callable[[str, float], object]
"""Called with the name of the current part and the share of it that is done."""

MODE_COUNT = 12
"""Number of modes in a report."""

MAX_NODES = 41
"""Largest number of recorded nodes, enough for an animation of the span."""

CHANNELS = ("u1", "u2", "u3", "theta", "v2", "v3", "tension", "angle_of_attack")
"""Recorded channels."""

MAX_RECORDS = 100_000
"""Number of records above which only every second, third, ... record is kept."""


@dataclass(frozen=True)
class Missing:
    """A part that could not be computed, with the reason."""

    reason: str


@dataclass(frozen=True)
class Statics:
    """A span in static equilibrium.

    Attributes
    ----------
    wind_speed : float
        Steady wind speed [m/s].
    x : ndarray, shape (node, 3)
        Positions [m] of the nodes.
    sag, drop : float
        Distance [m] of mid-span from the chord in the plane of the span, and its vertical part.
    swing, twist : float
        Angle [rad] of the plane of the span at mid-span from the vertical, and twist there.
    tension : float
        Tension [N] at mid-span.
    support_force : ndarray, shape (2, 3)
        Force [N] of the cable on the left and right support.
    """

    wind_speed: float
    x: Array
    sag: float
    drop: float
    swing: float
    twist: float
    tension: float
    support_force: Array


@dataclass(frozen=True)
class Findings:
    """Content of a report; parts that could not be computed are `Missing`.

    Attributes
    ----------
    scene : Scene
        The span.
    static_in_still_air, static_in_wind : Statics
        Static equilibrium in still air, and in the mean wind.
    modes, modes_in_wind : list of Mode
        Lowest natural modes about these two.
    frequencies : FrequencyRatio
        Frequencies of the pair of the 2:1 resonance.
    cable : ShallowCable
        The same frequencies by Irvine's closed form.
    design_changes : list of DesignChange
        Changes that move the ratio away from 2:1.
    screening : Screening
        Risk of a swing.
    onsets : list of CriticalWind
        Critical wind speed of each mode.
    criteria : list of Criterion
        Den Hartog's, Nigol's and the coupled criterion.
    result : Result
        The simulation; it may have ended early.
    ellipses : dict of str to Ellipse or Missing
        Clearance ellipses of design rules.
    seconds : dict of str to float
        Computing time [s] of each part.
    """

    scene: Scene
    static_in_still_air: Statics | Missing
    static_in_wind: Statics | Missing
    modes: list[Mode] | Missing
    modes_in_wind: list[Mode] | Missing
    frequencies: FrequencyRatio | Missing
    cable: ShallowCable | Missing
    design_changes: list[DesignChange] | Missing
    screening: Screening | Missing
    onsets: list[CriticalWind] | Missing
    criteria: list[Criterion] | Missing
    result: Result | Missing
    ellipses: dict[str, Ellipse | Missing]
    seconds: dict[str, float]

    @property
    def completed(self) -> bool:
        """True if the simulation ran to its end."""
        return isinstance(self.result, Result) and self.result.outcome is Outcome.COMPLETED


def examine(
    scene: Scene, stop_time: float | None = None, progress: Progress | None = None
) -> Findings:
    """Compute the content of a report.

    Parameters
    ----------
    scene, stop_time, progress
        As for `modal.write_report`.

    Raises
    ------
    SceneError
        If `stop_time` is not allowed. Other errors are `Missing` parts of the findings.
    """
    scene = one_span(scene, "a report", instead.REPORT)
    stop_time = scene.run.stop_time if stop_time is None else stop_time
    check_stop_time(stop_time)
    parts = Parts(scene, progress or (lambda name, share: None))
    wind = scene.wind.mean_speed
    # a small mesh between rigid ends has fewer modes
    count = min(MODE_COUNT, 4 * (2 * scene.elements - 1))
    still_air = parts.compute("static state", lambda: static_equilibrium(scene, 0.0))
    in_wind = parts.compute_in_wind("static state", lambda: static_equilibrium(scene, wind))
    return Findings(
        scene=scene,
        static_in_still_air=still_air,
        static_in_wind=in_wind,
        modes=parts.compute("modes", lambda: natural_modes(scene, count)),
        modes_in_wind=parts.compute_in_wind("modes", lambda: natural_modes(scene, count, "mean")),
        frequencies=parts.compute("frequency ratio", lambda: frequency_ratio(scene)),
        cable=parts.compute("frequency ratio", lambda: shallow_cable(scene)),
        design_changes=parts.compute("frequency ratio", lambda: suggest_design_changes(scene)),
        criteria=parts.compute("critical winds", lambda: stability_criteria(scene)),
        onsets=parts.compute("critical winds", lambda: critical_wind_speed(scene)),
        screening=parts.compute_in_wind("screening", lambda: screen(scene)),
        result=parts.compute("simulation", lambda: _simulate(scene, stop_time, parts.progress)),
        ellipses=_ellipses(scene, still_air, in_wind),
        seconds=parts.seconds,
    )


class Parts:
    """Computes parts of a report, with progress and computing time [s] of each."""

    def __init__(self, scene: Scene | LineScene, progress: Progress) -> None:
        self.scene, self.progress = scene, progress
        self.seconds: dict[str, float] = {}

    def compute(self, name: str, function: Callable[[], T]) -> T | Missing:
        """Return the value of a function, or `Missing` if it raises an error of the scene."""
        self.progress(name, 0.0)
        began = clock.perf_counter()
        try:
            return function()
        except (SceneError, SimulationError) as problem:
            return Missing(str(problem))
        finally:
            spent = clock.perf_counter() - began
            self.seconds[name] = self.seconds.get(name, 0.0) + spent

    def compute_in_wind(self, name: str, function: Callable[[], T]) -> T | Missing:
        """Do the same for a part that needs wind."""
        if self.scene.wind.mean_speed != 0.0:
            return self.compute(name, function)
        return Missing("The scene has no wind (its mean speed is 0 m/s). Set wind.speed.")


def static_equilibrium(scene: Scene, wind_speed: float) -> Statics:
    """Compute the static equilibrium in a steady wind [m/s], with the scene's initial loads.

    The supports are at their initial positions.

    Raises
    ------
    SimulationError
        If there is no equilibrium.
    """
    model = Model(scene)
    initial, middle = model.equilibrium(), model.middle
    state = model.rest(inputs=Inputs.still(scene, wind_speed=wind_speed))
    u = state.motion()[0]
    drop, across = initial.sag - float(u[middle, 1]), float(u[middle, 2])
    node, span = state.observe_node(middle), state.observe_span()
    forces = [
        [span[SPAN_INDEX[f"{end}_f{axis}"]] for axis in (1, 2, 3)] for end in ("left", "right")
    ]
    return Statics(
        wind_speed=wind_speed,
        x=initial.x + u[:, :3],
        sag=math.hypot(drop, across),
        drop=drop,
        swing=math.atan2(across, drop),
        twist=float(u[middle, 3]),
        tension=float(node[NODE_INDEX["tension"]]),
        support_force=np.array(forces),
    )


def _simulate(scene: Scene, stop_time: float, progress: Progress) -> Result:
    """Run the simulation, with as many records as memory allows.

    Raises
    ------
    SimulationError
        If it cannot start.
    """
    last, middle = 2 * scene.elements, scene.elements
    equal = np.linspace(0, last, min(MAX_NODES, last + 1)).round().astype(int)
    records = stop_time / (scene.numerics.time_step * scene.run.record_every)
    result = simulate(
        scene,
        stop_time,
        record_every=scene.run.record_every * max(1, math.ceil(records / MAX_RECORDS)),
        record_nodes=sorted({*equal.tolist(), middle}),
        channels=CHANNELS,
        progress=lambda time, stop: progress("simulation", time / stop),
        on_failure="return",
    )
    if not result.started:
        raise SimulationError(result.report, result)
    return result


def _ellipses(
    scene: Scene, still_air: Statics | Missing, in_wind: Statics | Missing
) -> dict[str, Ellipse | Missing]:
    """Clearance ellipses for the sag in still air and the swing in the mean wind."""
    if isinstance(still_air, Missing):
        absent = Missing(f"the sag is not known: {still_air.reason}")
        return {"CIGRE 322": absent, "Davison": absent}
    sag = still_air.sag
    swing = 0.0 if isinstance(in_wind, Missing) else in_wind.swing
    return {
        "CIGRE 322": _ellipse(lambda: cigre_322_single_loop(sag, scene.conductor.diameter)),
        "Davison": _ellipse(lambda: davison_single_loop(sag, swing)),
    }


def _ellipse(function: Callable[[], Ellipse]) -> Ellipse | Missing:
    """Ellipse of a rule, or `Missing` outside the range of the rule."""
    try:
        return function()
    except ValueError as problem:
        return Missing(str(problem))
