"""Branch of limit cycles of vertical galloping without swing, over the wind speed.

The branch starts at the galloping onset, where the static equilibrium in the wind loses its
stability, and is followed by harmonic balance and pseudo-arclength continuation
(`modal.screening.harmonic_balance`). Each orbit has its Floquet multipliers
(`modal.screening.floquet`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from modal.motions.reduced_model import MeanState, ReducedModel, mean_state
from modal.screening.floquet import Multipliers, multipliers
from modal.screening.harmonic_balance import (
    FINE,
    GALLOP,
    Balance,
    NotConvergedError,
    Orbit,
    amplitudes,
)
from modal.screening.orbit_family import Track

Array = NDArray[np.float64]

WIND_POINTS = 12
"""Wind speeds at which the mean state is examined before its stability limit is bracketed."""

MIN_WIND_RATIO = 0.01
"""Lowest wind speed of the search, relative to the highest."""

ONSET_TOLERANCE = 1e-4
"""Relative accuracy of the wind speed at which galloping begins."""

SPEED_RATIO = 0.3
"""Vertical speed over wind speed that scales amplitudes; galloping saturates at about 0.5."""

FIRST_SIZE = 0.05
"""Size of the first orbit next to the mean state, in that scale."""

LAST_SIZE = 0.01
"""Size at which decreasing galloping is considered to have ended, in that scale."""

MAX_GROWTH = 10.0
"""Growth of a swing per vertical cycle above which an orbit is rejected; near 2:1 it is below 3."""

MAX_OTHER_GROWTH = 1.05
"""Growth per vertical cycle of any other disturbance above which no motion stays near an orbit."""

GROWTH_MARGIN = 1e-3
"""Relative difference of two growths that counts as a difference."""

CURVE_INSTANTS = 64
"""Instants of a period at which attack angles are compared with the range of the curve."""


@dataclass(frozen=True)
class Cycle:
    """A periodic motion of the span; amplitudes are half peak-to-peak at mid-span.

    Attributes
    ----------
    wind_speed : float
        Wind speed [m/s].
    vertical, horizontal, twist : float
        Amplitudes [m], [m], [rad].
    frequency_hz : float
        Frequency of the vertical motion [Hz].
    multiplier : float
        Factor by which a small swing grows (above 1) or decays in one vertical cycle. For a motion
        with swing: the factor of the disturbance that decays slowest.
    """

    wind_speed: float
    vertical: float
    horizontal: float
    twist: float
    frequency_hz: float
    multiplier: float


def cycle_of(model: ReducedModel, orbit: Orbit, multiplier: float, cycles: int = 1) -> Cycle:
    """Convert an orbit over some vertical cycles to amplitudes and frequency."""
    _, vertical, horizontal, twist = (float(size) for size in amplitudes(model, orbit))
    frequency = cycles * orbit.omega / (2.0 * np.pi)
    return Cycle(orbit.wind_speed, vertical, horizontal, twist, frequency, multiplier)


class GallopingOnset(NamedTuple):
    """Result of `galloping_onset`.

    Attributes
    ----------
    wind_speed : float or None
        Lowest wind speed [m/s] at which the mean state is unstable; None if there is none.
    state : MeanState or None
        Mean state there.
    end_reason : str or None
        Reason why the search ended below the highest wind.
    """

    wind_speed: float | None
    state: MeanState | None
    end_reason: str | None


def galloping_onset(model: ReducedModel, wind: float, highest: float) -> GallopingOnset:
    """Find the lowest wind at which the first vertical mode grows about the mean state.

    Parameters
    ----------
    model
        The reduced span.
    wind, highest
        The scene's wind speed and the end of the search [m/s].

    Raises
    ------
    SceneError
        If no galloping begins below a wind without a stable equilibrium, and the scene's wind is
        that wind or a higher one.
    """
    from scipy.optimize import brentq  # slow to import

    states: dict[float, MeanState] = {}

    def growth(speed: float) -> float:
        if speed not in states:
            states[speed] = mean_state(model, speed)
        return states[speed].vertical.real

    stable, unstable = MIN_WIND_RATIO * highest, None
    equal = highest * np.arange(1, WIND_POINTS + 1) / WIND_POINTS
    for speed in np.union1d(equal, [wind]).tolist():
        try:
            rate = growth(speed)
        except SceneError as error:
            if speed <= wind:
                raise
            return GallopingOnset(None, None, str(error))
        if rate > 0.0:
            unstable = speed
            break
        stable = speed
    if unstable is None:
        return GallopingOnset(None, None, None)
    onset = stable
    if growth(stable) < 0.0:
        onset = float(brentq(growth, stable, unstable, rtol=ONSET_TOLERANCE))
    growth(onset)
    return GallopingOnset(onset, states[onset], None)


def amplitude_scale(model: ReducedModel, mode: int, axis: int, wind: float) -> float:
    """Modal amplitude at which the speed at mid-span is `SPEED_RATIO` times the wind speed.

    Parameters
    ----------
    model
        The reduced span; its first vertical frequency converts speed to amplitude.
    mode, axis
        The mode and the component (1: u2, 2: u3) of its motion.
    wind
        Wind speed [m/s].
    """
    return float(SPEED_RATIO * wind / model.frequencies[0] / abs(model.middle[mode, axis]))


class LimitCycles:
    """Branch of limit cycles of vertical galloping without swing.

    Parameters
    ----------
    model
        The reduced span.
    wind, highest
        The scene's wind speed and the end of the branch [m/s].

    Attributes
    ----------
    galloping_from, galloping_until : float or None
        Wind speeds [m/s] at which galloping begins and ends.
    orbits, growth : list
        Orbits in the order of continuation, and their multipliers.
    end_reason : str or None
        Reason why the branch ends below the highest wind.
    is_unresolved : bool
        True if it ends because no motion stays near the orbits that follow.
    has_ended : bool
        True if it was followed to the end of galloping.

    Raises
    ------
    SceneError
        As `galloping_onset`, or if no limit cycle starts at the onset.
    """

    def __init__(self, model: ReducedModel, wind: float, highest: float) -> None:
        self.model, self.wind, self.highest = model, wind, highest
        self.size_scale = amplitude_scale(model, model.vertical, 1, wind)
        self.is_unresolved = self.has_ended = False
        self.galloping_until: float | None = None
        self.track = self._track(GALLOP)
        self.orbits: list[Orbit] = []
        self.growth: list[Multipliers] = []
        self.galloping_from, state, self.end_reason = galloping_onset(model, wind, highest)
        if self.galloping_from is not None and state is not None:
            self._follow(self._first_guess(self.galloping_from, state))
            self._trim()

    def _track(self, balance: Balance) -> Track:
        """Family of vertical motions with a number of harmonics."""
        return Track(self.model, balance, self.model.vertical, self.wind, self.size_scale)

    def _first_guess(self, wind_speed: float, state: MeanState) -> Orbit:
        """Mean state plus the growing mode, q = q0 + s Re(x exp(i t)), as an orbit."""
        shape = state.shape / state.shape[self.model.vertical]
        size = FIRST_SIZE * self.size_scale
        coefficients = np.zeros((3, self.model.size))
        coefficients[0] = state.displacement
        coefficients[1], coefficients[2] = size * shape.real, -size * shape.imag
        return Orbit(wind_speed, float(state.vertical.imag), coefficients)

    def _follow(self, guess: Orbit) -> None:
        """Follow the branch to the highest wind, to its end or to the end of the curve.

        With four harmonics first; where they do not resolve the motion, or fail, with six.
        """
        start = guess.widened(self.track.balance.harmonics).packed()
        try:
            first, matrix, _ = self.track.of_size(start, FIRST_SIZE * self.size_scale)
        except NotConvergedError:
            raise SceneError(
                f"no limit cycle was found near the galloping onset at {guess.wind_speed:.4g} m/s;"
                " run a simulation (simulate) to see the motion"
            ) from None
        if self._follow_from(first, matrix, self.track.growing):
            return
        self.track = self._track(FINE)
        self.orbits = [orbit.widened(self.track.balance.harmonics) for orbit in self.orbits]
        last = self.orbits.pop().packed()
        self.growth.pop()
        direction = last - self.orbits[-1].packed() if self.orbits else self.track.growing
        try:
            first, matrix, _ = self.track.near(last, direction)
        except NotConvergedError:
            self.end_reason = _lost(last[-1])
            return
        self._follow_from(first, matrix, direction)

    def _follow_from(self, first: Orbit, matrix: Array, direction: Array) -> bool:
        """Append the orbits from `first` on; False if more harmonics may get further."""
        is_fine, least = self.track.balance is FINE, LAST_SIZE * self.size_scale

        def stop(orbit: Orbit) -> bool:
            done = orbit.wind_speed > self.highest or self.track.size(orbit) < least
            return done or not (is_fine or orbit.is_resolved)

        self.end_reason = None
        for orbit in self.track.follow(first, matrix, direction, stop):
            if self._append(orbit, least):
                return True
        last = self.orbits[-1]
        if last.wind_speed > self.highest:
            return True
        self.end_reason = _lost(last.wind_speed)
        return False

    def _append(self, orbit: Orbit, least: float) -> bool:
        """Append an orbit; True if the branch ends with it."""
        if self._leaves_curve(orbit):
            low, high = self.model.scene.aerodynamics.range_deg  # type: ignore[union-attr]
            self.end_reason = (
                f"at {orbit.wind_speed:.4g} m/s the attack angles leave the coefficient curve,"
                f" which is valid from {low:g} to {high:g} deg"
            )
            return True
        if self.track.size(orbit) < least:
            self._append_last(orbit, least)
            return True
        growth = multipliers(self.model, orbit)
        self.orbits.append(orbit)
        self.growth.append(growth)
        # orbits beyond are rejected anyway, and expensive
        return max(abs(growth.swing), float(np.abs(growth.others[0]))) > MAX_GROWTH

    def _leaves_curve(self, orbit: Orbit) -> bool:
        """True if an attack angle is outside the coefficient curve, and the curve forbids that."""
        q, v, _ = orbit.at(CURVE_INSTANTS)
        return self.model.angle_excess(q, v, orbit.wind_speed) > 0.0

    def _append_last(self, beyond: Orbit, least: float) -> None:
        """Classify the end of the branch: fold to equilibrium, or period-halving.

        The first harmonic vanishes between the last orbit and `beyond`. If all others vanish with
        it, galloping ends; otherwise the motion continues with half the period.
        """
        low, high = self.orbits[-1], beyond
        part = (self.track.size(low) - least) / (self.track.size(low) - self.track.size(high))
        guess = (1.0 - part) * low.packed() + part * high.packed()
        try:
            last = self.track.of_size(guess, least)[0]
        except NotConvergedError:
            self.end_reason = _lost(low.wind_speed)
            return
        self.orbits.append(last)
        self.growth.append(multipliers(self.model, last))
        self.has_ended = True
        if np.linalg.norm(last.coefficients[1:]) < FIRST_SIZE * self.size_scale:
            self.galloping_until = last.wind_speed
        else:
            self.end_reason = (
                f"at {last.wind_speed:.4g} m/s the motion changes to a higher mode at twice the"
                " frequency"
            )

    def _trim(self) -> None:
        """Remove the orbits behind the last one that a motion can stay near.

        Unstable orbits between two folds stay, as stable ones follow.
        """
        reasons = [rejection_reason(growth) for growth in self.growth]
        last = max((k for k, reason in enumerate(reasons) if not reason), default=0)
        if self.has_ended or last == len(self.orbits) - 1:
            return
        self.is_unresolved = True
        self.end_reason = (
            f"the limit cycle is unresolved above {self.orbits[last].wind_speed:.4g} m/s:"
            f" {reasons[last + 1]}"
        )
        self.orbits, self.growth = self.orbits[: last + 1], self.growth[: last + 1]

    def galloping(self) -> tuple[Orbit, Multipliers] | None:
        """First accepted orbit at the scene's wind, with its multipliers; None if there is none."""
        accepted = [not rejection_reason(growth) for growth in self.growth]
        for k, (low, high) in enumerate(pairwise(self.orbits)):
            if accepted[k] and accepted[k + 1]:
                orbit = self.track.first_at([low, high], self.wind)
                if orbit is not None:
                    return orbit, multipliers(self.model, orbit)
        return None

    def table(self) -> tuple[Cycle, ...]:
        """The limit cycles with the growth of a small swing."""
        found = zip(self.orbits, self.growth, strict=True)
        return tuple(cycle_of(self.model, orbit, abs(one.swing)) for orbit, one in found)


def rejection_reason(growth: Multipliers) -> str:
    """Reason why no motion stays near an orbit, or why it is rejected; '' if there is none."""
    swing, other = abs(growth.swing), float(np.abs(growth.others[0]))
    if swing > MAX_GROWTH:
        return f"a swing would grow {swing:.3g} times per cycle"
    if other > MAX_OTHER_GROWTH and other > (1.0 + GROWTH_MARGIN) * swing:
        return f"a disturbance other than the swing grows by {other - 1.0:.0%} per cycle"
    return ""


def _lost(wind_speed: float) -> str:
    """Reason for a branch that ends because Newton's method fails."""
    return f"the limit cycle could not be computed above {wind_speed:.4g} m/s"
