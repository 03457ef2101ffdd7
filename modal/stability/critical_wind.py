"""The wind speed at which each mode begins to grow, from the aeroelastic eigenvalues of the whole span."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.linear.linearise import SmallMotion
from modal.linear.mode_tracking import SPARE, Snapshot, follow
from modal.linear.modes import Mode

HIGHEST_WIND = 30.0
"""Wind speed [m/s] up to which an onset is looked for unless told otherwise: iced lines gallop below."""

WIND_STEP = 1.0
"""Wind speeds between which a change of stability is looked for [m/s]."""

FINEST = 1.0 / 64.0
"""Narrowest interval [m/s] that is still halved to look for a mode that grows only inside it."""

NEAR = 0.5
"""Part of a mode's damping in still air below which every interval is looked into."""

BEND = 1.0
"""Either half is looked into as well while the damping at one of its ends is below so many times the deviation of the
damping in the middle from a straight line. In a half, a parabola dips below its lower end by a quarter of that."""

HALVINGS = 3
"""Times that a step is halved to follow a mode past another; in wind, modes of all families veer a little."""

TOLERANCE = 1e-6
"""Accuracy of a critical wind speed [m/s]."""


@dataclass(frozen=True)
class CriticalWind:
    """Where one mode loses its damping.

    Attributes
    ----------
    mode : Mode
        The mode in still air.
    wind_speed : float or None
        Lowest wind speed [m/s] at which the mode's damping becomes negative; None: not up to
        `searched_to`.
    frequency_hz : float or None
        Its frequency [Hz] there.
    den_hartog : float or None
        For a vertical mode, 4 m w xi / (rho d |CD + dCL/dalpha|) [m/s], from its frequency and
        damping ratio in still air and the curve at the initial attack angle; None for other modes,
        and where the criterion is not met.
    searched_to : float
        Wind speed [m/s] up to which was searched.
    remark : str
        Why the search ended before the highest wind, or empty.
    """

    mode: Mode
    wind_speed: float | None
    frequency_hz: float | None
    den_hartog: float | None
    searched_to: float
    remark: str


def critical_wind_speed(
    scene: Scene, count: int = 6, highest: float = HIGHEST_WIND
) -> list[CriticalWind]:
    """Lowest wind speed at which each mode begins to grow.

    The modes are followed from still air in steps of 1 m/s, each about the static equilibrium under
    its own wind, twist and sideways swing included; where a damping ratio changes sign, bisection
    finds the speed to 1e-6 m/s. A mode whose damping is low, or bends within a step far enough to
    pass zero, is looked for inside the step too, down to 1/64 m/s. Beside it stands the speed that
    Den Hartog's criterion gives.

    Parameters
    ----------
    scene
        The span; its own wind speed does not matter.
    count
        Number of modes, the lowest in still air.
    highest
        Wind speed [m/s] at which the search ends.

    Returns
    -------
    list of CriticalWind
        In order of the modes' frequency in still air.

    Raises
    ------
    SceneError
        If there is no coefficient curve, or a mode has no damping in still air: then any wind that
        feeds it makes it grow, and a critical speed would be no property of the span.
    """
    from scipy.optimize import brentq  # slow to import

    if scene.aerodynamics is None:
        raise SceneError(
            "the scene has no aerodynamics: a critical wind speed needs a coefficient curve"
        )
    if not (np.isfinite(highest) and highest > 0.0):
        raise SceneError(f"highest = {highest} m/s: must be a finite, positive wind speed")
    motion = SmallMotion(scene)
    seen: dict[float, Snapshot] = {}

    def at(speed: float) -> Snapshot:
        if speed not in seen:
            seen[speed] = Snapshot.of(motion, count + SPARE, speed)
        return seen[speed]

    still = at(0.0).modes[:count]
    _check_damped(scene, still)
    found: list[tuple[float, float] | None] = [None] * len(still)
    chosen = np.arange(len(still))
    speeds = np.linspace(0.0, highest, max(2, round(highest / WIND_STEP) + 1))
    reached, remark = 0.0, ""
    for low, high in pairwise(speeds):
        try:
            there, _ = follow(at(low), chosen, at(high), at, float(low), float(high), HALVINGS)
        except SceneError as problem:
            remark = f"not beyond {reached:g} m/s: {problem}"
            break
        for k in range(len(there)):
            if found[k] is not None:
                continue
            branch = _Branch(at, float(low), chosen, k)
            growing = _growing(branch, float(low), float(high), NEAR * still[k].damping_ratio)
            if growing is not None:
                speed = float(
                    brentq(
                        lambda u, b=branch: b(u).damping_ratio,
                        growing[0],
                        growing[1],
                        xtol=TOLERANCE,
                    )
                )
                found[k] = speed, branch(speed).frequency_hz
        chosen, reached = there, float(high)
    return [
        CriticalWind(
            mode=mode,
            wind_speed=None if onset is None else onset[0],
            frequency_hz=None if onset is None else onset[1],
            den_hartog=den_hartog_speed(scene, mode),
            searched_to=reached,
            remark=remark,
        )
        for mode, onset in zip(still, found, strict=True)
    ]


def den_hartog_speed(scene: Scene, mode: Mode) -> float | None:
    """Wind speed [m/s] at which Den Hartog's negative damping equals the structural damping of a vertical mode.

    4 m w xi / (rho d |CD + dCL/dalpha|): the aerodynamic damping ratio rho U d (CD + CL')/(4 m w)
    of pure vertical motion against xi. None for another mode, or where CD + dCL/dalpha is not
    negative.
    """
    if scene.aerodynamics is None or mode.family != "vertical":
        return None
    slope = float(scene.aerodynamics.curve().den_hartog(np.radians(scene.ice.attack_angle_deg)))
    if slope >= 0.0:
        return None
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    omega = 2.0 * np.pi * mode.frequency_hz
    return (
        4.0
        * mass
        * omega
        * mode.damping_ratio
        / (scene.wind.air_density * scene.conductor.diameter * -slope)
    )


def _growing(
    branch: _Branch, low: float, high: float, suspicious: float
) -> tuple[float, float] | None:
    """The first interval found at whose end a mode grows that is damped at its beginning; None if there is none."""
    ends = branch(low).damping_ratio, branch(high).damping_ratio
    if ends[1] < 0.0:
        return low, high
    if high - low <= FINEST or min(ends) >= suspicious:
        return None
    middle = 0.5 * (low + high)
    bend = BEND * abs(0.5 * sum(ends) - branch(middle).damping_ratio)
    return _growing(branch, low, middle, bend) or _growing(branch, middle, high, bend)


class _Branch:
    """One of several modes above a wind speed at which their numbers are known: others may overtake it on the way."""

    def __init__(
        self, at: Callable[[float], Snapshot], low: float, chosen: NDArray[np.intp], which: int
    ) -> None:
        self.at, self.low, self.chosen, self.which = at, low, chosen, which

    def __call__(self, speed: float) -> Mode:
        there = self.chosen
        if speed > self.low:
            there, _ = follow(
                self.at(self.low), there, self.at(speed), self.at, self.low, speed, HALVINGS
            )
        return self.at(speed).modes[int(there[self.which])]


def _check_damped(scene: Scene, modes: list[Mode]) -> None:
    for mode in modes:
        part = "twist" if mode.family == "torsional" else "translation"
        given = getattr(scene.damping, part) is not None
        if given and mode.damping_ratio > 0.0:
            continue
        raise SceneError(
            f"damping.{part} is {'not positive at this frequency' if given else 'not given'}: the"
            f" {mode.family} mode at {mode.frequency_hz:.4g} Hz has a damping ratio of"
            f" {mode.damping_ratio:.3g} in still air, so it has no critical wind speed; give"
            " damping (ratios at two frequencies), about 0.001 to 0.02 for conductors"
        )
