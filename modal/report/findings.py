"""Everything that a report tells of a span. What cannot be found out is kept as the reason why."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Model, Outcome, Result, Scene, SceneError, SimulationError, simulate
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.line.clearance import Ellipse, cigre_322_single_loop, davison_single_loop
from gallop_fmu.simulation.run_options import check_stop_time
from modal.linear.modes import Mode, natural_modes
from modal.linear.shallow_cable import ShallowCable, shallow_cable
from modal.screening.screen import Screening, screen
from modal.stability.criteria import Criterion, stability_criteria
from modal.stability.critical_wind import CriticalWind, critical_wind_speed
from modal.stability.frequency_ratio import DesignChange, FrequencyRatio, frequency_ratio, way_out

Array = NDArray[np.float64]
T = TypeVar("T")

Progress = Callable[[str, float], object]
"""Called with the name of what is being computed and the share of it that is done."""

MODES = 12
NODES = 41
"""Most nodes recorded: as many as an animation of the span needs."""

CHANNELS = ("u1", "u2", "u3", "theta", "v2", "v3", "tension", "angle_of_attack")
MOST_RECORDS = 100_000
"""Records of a run above which only every second, third, ... is kept, so that a long run fits into memory."""


@dataclass(frozen=True)
class Missing:
    """What could not be found out, and why."""

    reason: str


@dataclass(frozen=True)
class Statics:
    """A span at rest.

    Attributes
    ----------
    wind_speed : float
        Wind [m/s] under which it rests.
    x : ndarray, shape (node, 3)
        Positions [m] of the nodes.
    sag, lowered : float
        Drop [m] below the chord at mid-span: along the plane of the span, and its vertical part.
    swing, twist : float
        Angle [rad] by which mid-span has swung out of the vertical plane, and its twist.
    tension : float
        Tension [N] at mid-span.
    support_force : ndarray, shape (2, 3)
        Force [N] of the cable on the left and right tower.
    """

    wind_speed: float
    x: Array
    sag: float
    lowered: float
    swing: float
    twist: float
    tension: float
    support_force: Array


@dataclass(frozen=True)
class Findings:
    """What a report tells, each part found out or `Missing`.

    Attributes
    ----------
    scene : Scene
        What was examined.
    still, blown : Statics
        At rest in still air, and in the mean wind.
    modes, modes_in_wind : list of Mode
        Lowest natural modes in still air, and about rest in the mean wind.
    frequencies : FrequencyRatio
        The pair of the 2:1 resonance.
    cable : ShallowCable
        The same by Irvine's closed form.
    ways_out : list of DesignChange
        What changes the ratio.
    screening : Screening
        Whether galloping starts the swing.
    onsets : list of CriticalWind
        Wind at which each mode begins to grow.
    criteria : list of Criterion
        Den Hartog's, Nigol's and the coupled criterion.
    result : Result
        The simulation, also when it ended early.
    ellipses : dict of str to Ellipse or Missing
        Envelopes that design rules give.
    seconds : dict of str to float
        Time [s] that each part took.
    """

    scene: Scene
    still: Statics | Missing
    blown: Statics | Missing
    modes: list[Mode] | Missing
    modes_in_wind: list[Mode] | Missing
    frequencies: FrequencyRatio | Missing
    cable: ShallowCable | Missing
    ways_out: list[DesignChange] | Missing
    screening: Screening | Missing
    onsets: list[CriticalWind] | Missing
    criteria: list[Criterion] | Missing
    result: Result | Missing
    ellipses: dict[str, Ellipse | Missing]
    seconds: dict[str, float]

    @property
    def completed(self) -> bool:
        """Whether the simulation ran to its end."""
        return isinstance(self.result, Result) and self.result.outcome is Outcome.COMPLETED


def examine(
    scene: Scene, stop_time: float | None = None, progress: Progress | None = None
) -> Findings:
    """Find out everything that a report tells.

    Parameters
    ----------
    scene, stop_time, progress
        As for `modal.write_report`.

    Raises
    ------
    SceneError
        If `stop_time` is not allowed. What else cannot be found out is `Missing` in the findings.
    """
    stop_time = scene.run.stop_time if stop_time is None else stop_time
    check_stop_time(stop_time)
    tell = progress or (lambda name, share: None)
    seconds: dict[str, float] = {}

    def part(name: str, function: Callable[[], T]) -> T | Missing:
        tell(name, 0.0)
        began = clock.perf_counter()
        try:
            return function()
        except (SceneError, SimulationError) as problem:
            return Missing(str(problem))
        finally:
            seconds[name] = seconds.get(name, 0.0) + clock.perf_counter() - began

    count = min(
        MODES, 4 * (2 * scene.numerics.elements - 1)
    )  # a small mesh between rigid ends has no more
    calm = Missing(
        "The scene has no wind: its mean speed is 0 m/s. Set wind.speed to look at a span in wind."
    )
    blows = scene.wind.mean_speed > 0.0
    still = part("static state", lambda: at_rest_in(scene, 0.0))
    blown = (
        part("static state", lambda: at_rest_in(scene, scene.wind.mean_speed)) if blows else calm
    )
    return Findings(
        scene=scene,
        still=still,
        blown=blown,
        modes=part("modes", lambda: natural_modes(scene, count)),
        modes_in_wind=part("modes", lambda: natural_modes(scene, count, "mean")) if blows else calm,
        frequencies=part("frequency ratio", lambda: frequency_ratio(scene)),
        cable=part("frequency ratio", lambda: shallow_cable(scene)),
        ways_out=part("frequency ratio", lambda: way_out(scene)),
        criteria=part("critical winds", lambda: stability_criteria(scene)),
        onsets=part("critical winds", lambda: critical_wind_speed(scene)),
        screening=part("screening", lambda: screen(scene)) if blows else calm,
        result=part("simulation", lambda: _simulated(scene, stop_time, tell)),
        ellipses={
            "CIGRE 322": _ellipse(
                lambda: cigre_322_single_loop(_found(still).sag, scene.conductor.diameter)
            ),
            "Davison": _ellipse(lambda: davison_single_loop(_found(still).sag, _swing(blown))),
        },
        seconds=seconds,
    )


def at_rest_in(scene: Scene, wind_speed: float) -> Statics:
    """The span at rest in a steady wind [m/s], with the scene's loads at the start, the towers where they stand.

    Raises
    ------
    SimulationError
        If there is no equilibrium.
    """
    model = Model(scene)
    angle = math.radians(scene.ice.attack_angle_deg)
    initial, middle = model.equilibrium(), model.middle
    state = model.rest(inputs=Inputs(0.0, wind_speed, angle, np.zeros((2, 3))))
    u = state.motion()[0]
    lowered, across = initial.sag - float(u[middle, 1]), float(u[middle, 2])
    node, span = state.observe_node(middle), state.observe_span()
    forces = [
        [span[SPAN_INDEX[f"{end}_f{axis}"]] for axis in (1, 2, 3)] for end in ("left", "right")
    ]
    return Statics(
        wind_speed=wind_speed,
        x=initial.x + u[:, :3],
        sag=math.hypot(lowered, across),
        lowered=lowered,
        swing=math.atan2(across, lowered),
        twist=float(u[middle, 3]),
        tension=float(node[NODE_INDEX["tension"]]),
        support_force=np.array(forces),
    )


def _simulated(scene: Scene, stop_time: float, tell: Progress) -> Result:
    last, middle = 2 * scene.numerics.elements, scene.numerics.elements
    nodes = np.unique(np.linspace(0, last, min(NODES, last + 1)).round().astype(int)).tolist()
    records = stop_time / (scene.numerics.time_step * scene.run.record_every)
    result = simulate(
        scene,
        stop_time,
        record_every=scene.run.record_every * max(1, math.ceil(records / MOST_RECORDS)),
        record_nodes=sorted({*nodes, middle}),
        channels=CHANNELS,
        progress=lambda time, stop: tell("simulation", time / stop),
        on_failure="return",
    )
    if not result.started:
        raise SimulationError(result.report, result)
    return result


def _ellipse(function: Callable[[], Ellipse]) -> Ellipse | Missing:
    try:
        return function()
    except (ValueError, SceneError) as problem:
        return Missing(str(problem))


def _found(still: Statics | Missing) -> Statics:
    if isinstance(still, Missing):
        raise SceneError(f"the sag is not known: {still.reason}")
    return still


def _swing(blown: Statics | Missing) -> float:
    return 0.0 if isinstance(blown, Missing) else blown.swing
