"""Critical wind speed of each mode, from the aeroelastic eigenvalues of the whole span."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.foundation.deprecation import warn_renamed
from gallop_fmu.input.scene_like import SceneLike, as_scene
from gallop_fmu.scene.conductor import Ice
from modal.foundation.one_thread import one_thread
from modal.linear.line_modes import LineMode
from modal.linear.linearise import SmallMotion
from modal.linear.mode_tracking import EXTRA_MODES, Snapshot, follow
from modal.linear.modes import Mode

DEFAULT_HIGHEST_WIND = 30.0
"""Default end of the search [m/s]; iced lines gallop at lower wind speeds."""

WIND_STEP = 1.0
"""Step of the search [m/s]."""

MIN_INTERVAL = 1.0 / 64.0
"""Narrowest interval [m/s] that is halved in search of a mode that grows only inside it."""

LOW_DAMPING = 0.5
"""Damping, relative to still air, below which an interval is halved in this search."""

DIP_FACTOR = 1.0
"""Criterion for halving further: damping at an end of a half below this multiple of the deviation.

The deviation is that of the damping in the middle of the interval from a straight line. In a half,
a parabola falls below its lower end by at most a quarter of it.
"""

TRACKING_HALVINGS = 3
"""Halvings of a step in which a mode is tracked past another; in wind, most modes veer a little."""

WIND_TOLERANCE = 1e-6
"""Accuracy of a critical wind speed [m/s]."""


@dataclass(frozen=True)
class CriticalWind:
    """Wind speed at which one mode loses its damping.

    Attributes
    ----------
    mode : Mode or LineMode
        The mode in still air.
    wind_speed : float or None
        Lowest wind speed [m/s] at which the mode's damping becomes negative; None if it does not up
        to `searched_to`.
    frequency_hz : float or None
        Its frequency [Hz] there.
    den_hartog : float or None
        For a vertical mode, 4 m w xi / (rho d |CD + dCL/dalpha|) [m/s], from its frequency and
        damping ratio in still air and the curve at the initial attack angle; None for other modes,
        and where the criterion is not met.
    searched_to : float
        End of the search [m/s].
    remark : str
        Reason why it ended below the highest wind; empty if it did not.
    """

    mode: Mode | LineMode
    wind_speed: float | None
    frequency_hz: float | None
    den_hartog: float | None
    searched_to: float
    remark: str


@one_thread
def critical_wind_speed(
    scene: SceneLike,
    count: int = 6,
    highest_wind: float = DEFAULT_HIGHEST_WIND,
    *,
    highest: float | None = None,
) -> list[CriticalWind]:
    """Find the lowest wind speed at which each mode begins to grow.

    The modes are tracked from still air in steps of 1 m/s, each about the static equilibrium in its
    own wind with twist and horizontal displacement. Where a damping ratio changes sign, the wind
    speed is found to 1e-6 m/s. Where a damping ratio is low, or curved enough to pass zero inside a
    step, the step is halved, down to 1/64 m/s. The speed by Den Hartog's criterion is given for
    comparison.

    Parameters
    ----------
    scene
        The span or line; its own wind speed does not matter.
    count
        Number of modes, the lowest in still air.
    highest_wind
        Wind speed [m/s] at which the search ends.
    highest
        Deprecated name of `highest_wind`.

    Returns
    -------
    list of CriticalWind
        In order of the modes' frequency in still air.

    Raises
    ------
    SceneError
        If there is no coefficient curve, or a mode has no damping in still air: it then grows in
        any wind that excites it, and has no critical wind speed.
    """
    if highest is not None:
        warn_renamed("critical_wind_speed(highest=...)", "highest_wind")
        highest_wind = highest
    scene = as_scene(scene)
    if scene.aerodynamics is None:
        raise SceneError(
            "the scene has no aerodynamics: a critical wind speed needs a coefficient curve; add"
            " a section [aerodynamics]"
        )
    if not (np.isfinite(highest_wind) and highest_wind > 0.0):
        raise SceneError(
            f"highest_wind = {highest_wind} m/s: must be a finite, positive wind speed"
        )
    motion = SmallMotion(scene)
    known: dict[float, Snapshot] = {}

    def modes_at(speed: float) -> Snapshot:
        if speed not in known:
            known[speed] = Snapshot.of(motion, count + EXTRA_MODES, speed)
        return known[speed]

    still: Sequence[Mode | LineMode] = modes_at(0.0).modes[:count]
    _check_damped(scene, still)
    onsets, reached, remark = _search(modes_at, still, highest_wind)
    return [
        CriticalWind(
            mode=mode,
            wind_speed=None if onset is None else onset[0],
            frequency_hz=None if onset is None else onset[1],
            den_hartog=den_hartog_speed(scene, mode),
            searched_to=reached,
            remark=remark,
        )
        for mode, onset in zip(still, onsets, strict=True)
    ]


def lowest_critical_wind(scene: Scene | LineScene, count: int, highest: float) -> float | None:
    """Lowest wind speed [m/s] at which any of some modes grows, to 1e-6 m/s; None: none grows.

    Modes are not tracked, so that this is much faster than `critical_wind_speed`.

    Parameters
    ----------
    scene
        The span or line.
    count
        Number of modes, the lowest ones.
    highest
        Wind speed [m/s] at which the search ends.

    Raises
    ------
    SceneError
        There is no static equilibrium in a wind of the search.
    """
    from scipy.optimize import brentq  # slow to import

    motion = SmallMotion(scene)
    known: dict[float, Mode | LineMode] = {}

    def least_damped(speed: float) -> Mode | LineMode:
        if speed not in known:
            modes: Sequence[Mode | LineMode] = Snapshot.of(motion, count, speed).modes
            known[speed] = min(modes, key=lambda mode: mode.damping_ratio)
        return known[speed]

    low_damping = LOW_DAMPING * least_damped(0.0).damping_ratio
    for low, high in pairwise(np.linspace(0.0, highest, max(2, round(highest / WIND_STEP) + 1))):
        growing = _growing(least_damped, float(low), float(high), low_damping)
        if growing is not None:
            ratio = lambda speed: least_damped(float(speed)).damping_ratio  # noqa: E731
            return float(brentq(ratio, *growing, xtol=WIND_TOLERANCE))
    return None


ModesAt = Callable[[float], Snapshot]
"""Function from wind speed [m/s] to the modes there."""


def _search(
    modes_at: ModesAt, still: Sequence[Mode | LineMode], highest: float
) -> tuple[list[tuple[float, float] | None], float, str]:
    """Track the modes from still air step by step.

    Returns wind speed and frequency at the onset of each mode, the wind speed reached, and the
    reason if that is below the highest.
    """
    onsets: list[tuple[float, float] | None] = [None] * len(still)
    numbers = np.arange(len(still))
    reached = 0.0
    for low, high in pairwise(np.linspace(0.0, highest, max(2, round(highest / WIND_STEP) + 1))):
        try:
            following = _tracked(modes_at, numbers, float(low), float(high))
        except SceneError as problem:
            return onsets, reached, f"the search ended at {reached:g} m/s: {problem}"
        for k, mode in enumerate(still):
            if onsets[k] is None:
                branch = _Branch(modes_at, float(low), numbers, k)
                onsets[k] = _onset(branch, float(high), LOW_DAMPING * mode.damping_ratio)
        numbers, reached = following, float(high)
    return onsets, reached, ""


def _tracked(
    modes_at: ModesAt, numbers: NDArray[np.intp], low: float, high: float
) -> NDArray[np.intp]:
    """Numbers, at the wind speed `high`, of the modes that have given numbers at `low`."""
    start, end = modes_at(low), modes_at(high)
    return follow(start, numbers, end, modes_at, low, high, TRACKING_HALVINGS)[0]


def _onset(branch: _Branch, high: float, low_damping: float) -> tuple[float, float] | None:
    """Wind speed and frequency at which a mode begins to grow in a step; None if it does not."""
    from scipy.optimize import brentq  # slow to import

    growing = _growing(branch, branch.low, high, low_damping)
    if growing is None:
        return None
    speed = float(brentq(lambda u: branch(u).damping_ratio, *growing, xtol=WIND_TOLERANCE))
    return speed, branch(speed).frequency_hz


def den_hartog_speed(scene: Scene | LineScene, mode: Mode | LineMode) -> float | None:
    """Critical wind speed [m/s] of a vertical mode by Den Hartog's criterion.

    In pure vertical motion the aerodynamic damping ratio rho U d (CD + dCL/dalpha) / (4 m w) equals
    minus the structural one, xi, at

        U = 4 m w xi / (rho d |CD + dCL/dalpha|).

    On a line, (CD + dCL/dalpha)/m is that of each span with its ice, weighted by the span's share
    in the kinetic energy of the mode. None for another mode, and where CD + dCL/dalpha is not
    negative.
    """
    if scene.aerodynamics is None or mode.family not in ("vertical", "tension-neutral"):
        return None
    curve = scene.aerodynamics.curve()
    weighted = 0.0
    for ice, share in _ice_of_spans(scene, mode):
        slope = float(curve.den_hartog(np.radians(ice.attack_angle_deg)))
        weighted += share * slope / (scene.conductor.mass_per_length + ice.mass_per_length)
    if weighted >= 0.0:
        return None
    damping = 4.0 * 2.0 * np.pi * mode.frequency_hz * mode.damping_ratio
    return damping / (scene.wind.air_density * scene.conductor.diameter * -weighted)


def _ice_of_spans(scene: Scene | LineScene, mode: Mode | LineMode) -> list[tuple[Ice, float]]:
    """Ice of each span, and the span's share in the kinetic energy of a mode."""
    if isinstance(scene, Scene) or isinstance(mode, Mode):
        return [(scene.ice, 1.0)]
    return [
        (scene.ice_of_span(span), float(share)) for span, share in enumerate(mode.span_shares, 1)
    ]


def _growing(
    branch: Callable[[float], Mode | LineMode], low: float, high: float, suspicious: float
) -> tuple[float, float] | None:
    """Find the first interval in which a mode that is damped at `low` begins to grow.

    Parameters
    ----------
    branch
        The mode at a wind speed.
    low, high
        Interval of wind speeds [m/s] to search.
    suspicious
        Damping ratio at one of the ends below which the interval is halved.
    """
    ends = branch(low).damping_ratio, branch(high).damping_ratio
    if ends[1] < 0.0:
        return low, high
    if high - low <= MIN_INTERVAL or min(ends) >= suspicious:
        return None
    middle = 0.5 * (low + high)
    deviation = DIP_FACTOR * abs(0.5 * sum(ends) - branch(middle).damping_ratio)
    return _growing(branch, low, middle, deviation) or _growing(branch, middle, high, deviation)


class _Branch:
    """One of several modes above a wind speed at which their numbers are known.

    Parameters
    ----------
    modes_at
        The modes at a wind speed.
    low
        Wind speed [m/s] at which `numbers` holds.
    numbers
        Numbers of the tracked modes among all modes there.
    which
        Index of this mode in `numbers`.
    """

    def __init__(
        self, modes_at: ModesAt, low: float, numbers: NDArray[np.intp], which: int
    ) -> None:
        self.modes_at, self.low, self.numbers, self.which = modes_at, low, numbers, which

    def __call__(self, speed: float) -> Mode | LineMode:
        numbers = self.numbers
        if speed > self.low:
            numbers = _tracked(self.modes_at, numbers, self.low, speed)
        return self.modes_at(speed).modes[int(numbers[self.which])]


def _check_damped(scene: Scene | LineScene, modes: Sequence[Mode | LineMode]) -> None:
    """Raise SceneError if a mode has no positive damping in still air."""
    for mode in modes:
        part = "twist" if mode.family == "torsional" else "translation"
        is_given = getattr(scene.damping, part) is not None
        if is_given and mode.damping_ratio > 0.0:
            continue
        raise SceneError(
            f"damping.{part} is {'not positive at this frequency' if is_given else 'not given'}:"
            f" the {mode.family} mode at {mode.frequency_hz:.4g} Hz has a damping ratio of"
            f" {mode.damping_ratio:.3g} in still air and therefore no critical wind speed; give"
            " damping (ratios at two frequencies), about 0.001 to 0.02 for conductors"
        )
