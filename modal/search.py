"""From the critical wind over the vertical limit cycle to the swing: what screening finds out about a span."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gallop_fmu import Outcome, SceneError, simulate
from modal.floquet import flip_determinant, flip_shape, lopsided_multiplier, multipliers
from modal.limit_cycle import FINE, GALLOP, SWING, NotConvergedError, Orbit, Track, amplitudes, doubled
from modal.reduced import ReducedModel, mean_state
from modal.rest import mirrored

WINDS = 12
"""Wind speeds at which the mean state is examined before its stability limit is bisected."""

SPEED_RATIO = 0.3
"""Vertical speed over wind speed by which amplitudes are scaled: galloping settles at about 0.5."""

FIRST_SIZE = 0.05
"""Size of the first orbit beside the mean state, in that scale."""

BEAT_ELEMENTS, BEAT_STEP, BEAT_CYCLES = 6, 0.02, 400
"""Elements, time step and duration (both in vertical cycles) of the simulation of a swing that comes and goes."""

HALVINGS = 9
"""Halvings of the interval that holds a stability limit: to a thousandth of the distance of two orbits."""


@dataclass(frozen=True)
class Cycle:
    """A periodic motion of the span, amplitudes as half peak-to-peak at mid-span.

    Attributes
    ----------
    wind_speed : float
        Wind speed [m/s].
    vertical, horizontal, twist : float
        Amplitudes [m], [m], [rad].
    frequency_hz : float
        Frequency of the vertical motion [Hz].
    multiplier : float
        By how much a small swing grows (above 1) or shrinks in one vertical cycle; for a motion that already swings,
        the same for the disturbance that decays slowest.
    """

    wind_speed: float
    vertical: float
    horizontal: float
    twist: float
    frequency_hz: float
    multiplier: float


class Search:
    """Everything that is found out about one span: onset of galloping, limit cycle, onset of the swing, its branch."""

    def __init__(self, model: ReducedModel, wind: float, highest: float) -> None:
        self.model, self.wind, self.highest = model, wind, highest
        self.size_scale = SPEED_RATIO * wind / model.frequencies[0] / abs(model.middle[model.vertical, 1])
        self.limit: str | None = None  # why the limit cycle could not be followed up to the highest wind
        self.galloping_from, start = self._stability_limit()
        self.orbits: list[Orbit] = []
        for balance in (GALLOP, FINE):
            self.track = Track(model, balance, model.vertical, wind, self.size_scale)
            if start is None:
                break
            self.limit = None
            if not self._follow(start):
                break
        self.growth = [multipliers(model, orbit) for orbit in self.orbits]

    def _stability_limit(self) -> tuple[float | None, Orbit | None]:
        """Lowest wind at which the mean state gallops, and the first orbit there."""
        calm = 0.0
        winds = np.union1d(self.highest * np.arange(1, WINDS + 1) / WINDS, [self.wind])
        found = None
        for wind in winds:
            try:
                found = mean_state(self.model, float(wind))
            except SceneError as error:
                if wind <= self.wind:
                    raise
                self.limit = str(error)
                return None, None
            if found.vertical.real > 0.0:
                break
            calm = float(wind)
        if found is None or found.vertical.real <= 0.0:
            return None, None
        galloping = float(wind)
        for _ in range(HALVINGS):
            middle = 0.5 * (calm + galloping)
            state = mean_state(self.model, middle)
            if state.vertical.real > 0.0:
                galloping, found = middle, state
            else:
                calm = middle
        size = FIRST_SIZE * self.size_scale
        shape = found.shape / found.shape[self.model.vertical]
        coefficients = np.zeros((3, self.model.size))
        coefficients[0] = found.displacement
        coefficients[1], coefficients[2] = size * shape.real, -size * shape.imag
        return galloping, Orbit(galloping, float(found.vertical.imag), coefficients)

    def _follow(self, start: Orbit) -> bool:
        """Follow the limit cycle up to the highest wind or the end of the curve; true if it was lost before."""
        spectrum = np.zeros((2 * self.track.balance.harmonics + 1, self.model.size))
        spectrum[:3] = start.coefficients
        guess = Orbit(start.wind_speed, start.omega, spectrum)
        try:
            first, matrix, _ = self.track.of_size(guess.packed(), FIRST_SIZE * self.size_scale)
        except NotConvergedError:
            raise SceneError(
                f"no limit cycle was found beside the mean state at {start.wind_speed:.4g} m/s, where galloping "
                "begins; look at simulate(scene)"
            ) from None
        self.orbits = []
        for orbit in self.track.follow(first, matrix, lambda orbit: orbit.wind_speed > self.highest):
            if self._leaves_curve(orbit):
                self.limit = (
                    f"at {orbit.wind_speed:.4g} m/s its attack angles leave the coefficient curve, which is valid from "
                    "{:g} to {:g} deg".format(*self.model.scene.aerodynamics.range_deg)  # type: ignore[union-attr]
                )
                return False
            self.orbits.append(orbit)
        lost = self.orbits[-1].wind_speed < self.highest
        if lost:
            self.limit = f"it could not be followed beyond {self.orbits[-1].wind_speed:.4g} m/s"
        return lost

    def _leaves_curve(self, orbit: Orbit) -> bool:
        curve = self.model.scene.aerodynamics
        if curve is None or curve.outside != "error":
            return False
        q, v, _ = orbit.at(64)
        return self.model.angle_excess(q, v, orbit.wind_speed) > 0.0

    def at_wind(self, orbits: list[Orbit], track: Track) -> Orbit | None:
        """The first orbit of a branch that reaches the scene's wind from below; None if none does."""
        for low, high in pairwise(orbits):
            if low.wind_speed <= self.wind < high.wind_speed:
                return self._orbit_between(low, high, track)
        return None

    def _orbit_between(self, low: Orbit, high: Orbit, track: Track) -> Orbit | None:
        """Orbit at the scene's wind; where a branch turns back, neighbours are halved until Newton converges."""
        for _ in range(HALVINGS):
            part = (self.wind - low.wind_speed) / (high.wind_speed - low.wind_speed)
            try:
                return track.at_wind((1.0 - part) * low.packed() + part * high.packed(), self.wind)[0]
            except NotConvergedError:
                middle = track.between(low.packed(), high.packed())
                low, high = (middle, high) if middle.wind_speed <= self.wind else (low, middle)
        return None

    def table(self) -> tuple[Cycle, ...]:
        """The limit cycles without swing."""
        found = zip(self.orbits, self.growth, strict=True)
        return tuple(self.cycle(orbit, abs(one.swing)) for orbit, one in found)

    def limits(self) -> list[tuple[Orbit, bool]]:
        """Orbits at which the swing starts (True) or ceases to start (False), in the order of the branch."""
        found = []
        unstable = [abs(one.swing) > 1.0 for one in self.growth]
        for k in range(len(self.orbits) - 1):
            if unstable[k] != unstable[k + 1]:
                found.append((self._limit_between(self.orbits[k], self.orbits[k + 1]), unstable[k + 1]))
        return found

    def _limit_between(self, low: Orbit, high: Orbit) -> Orbit:
        """Orbit at which the swing is neither damped nor driven."""
        ends = [flip_determinant(self.model, one) for one in (low, high)]
        by_flip = ends[0] * ends[1] < 0.0

        def level(orbit: Orbit) -> float:
            return flip_determinant(self.model, orbit) if by_flip else abs(multipliers(self.model, orbit).swing) - 1.0

        first = level(low)
        a, b = low.packed(), high.packed()
        for _ in range(HALVINGS):
            orbit = self.track.between(a, b)
            if level(orbit) * first > 0.0:
                a = orbit.packed()
            else:
                b = orbit.packed()
        return self.track.between(a, b)

    def swing_branch(self, onset: Orbit) -> tuple[list[Orbit], Track]:
        """Motions with swing, from its onset to the scene's wind."""
        model = self.model
        scale = SPEED_RATIO * self.wind / model.frequencies[0] / abs(model.middle[model.horizontal, 2])
        track = Track(model, SWING, model.horizontal, self.wind, scale)
        shape, phase = flip_shape(model, onset)
        base = doubled(onset, SWING.harmonics).turned(phase)
        size = FIRST_SIZE * scale
        try:
            start = Orbit(base.wind_speed, base.omega, base.coefficients + size * shape)
            first, matrix, _ = track.of_size(start.packed(), size)
        except NotConvergedError:
            return [], track
        low, high = 0.7 * min(self.wind, onset.wind_speed), max(self.wind, 1.1 * onset.wind_speed)
        return list(track.follow(first, matrix, lambda orbit: not low < orbit.wind_speed < high)), track

    def lopsided(self, orbit: Orbit, cycles: int) -> float | None:
        """Growth in one vertical cycle of what breaks the mirror symmetry; None without such symmetry."""
        if not mirrored(self.model.scene):
            return None
        return float(lopsided_multiplier(self.model, orbit, cycles) ** (1.0 / cycles))

    def beating(self, unsteady: Cycle) -> Cycle:
        """Amplitudes of a swing that comes and goes, from a short simulation that starts near its unstable cycle."""
        coarse = {
            "numerics.elements": min(BEAT_ELEMENTS, self.model.scene.numerics.elements),
            "numerics.time_step": BEAT_STEP / unsteady.frequency_hz,
            "initial": {"seed_vertical": -unsteady.vertical, "seed_horizontal": unsteady.horizontal},
        }
        cycles = BEAT_CYCLES / unsteady.frequency_hz
        result = simulate(
            self.model.scene.with_values(coarse), stop_time=cycles, record_every=4, channels=("u2", "u3", "theta"),
            on_failure="return",
        )  # fmt: skip
        if result.outcome is not Outcome.COMPLETED:
            return unsteady
        steady = result.steady(0.6 * cycles)
        vertical, horizontal, twist = (steady[name].amplitude for name in ("u2", "u3", "theta"))
        return replace(unsteady, vertical=vertical, horizontal=horizontal, twist=twist)

    def cycle(self, orbit: Orbit, multiplier: float, cycles: int = 1) -> Cycle:
        """The figures of an orbit that takes so many vertical cycles."""
        _, vertical, horizontal, twist = (float(size) for size in amplitudes(self.model, orbit))
        frequency = cycles * orbit.omega / (2.0 * np.pi)
        return Cycle(orbit.wind_speed, vertical, horizontal, twist, frequency, multiplier)
