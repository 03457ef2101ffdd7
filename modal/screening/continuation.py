"""From the critical wind over the vertical limit cycle to the swing: what screening finds out about a span."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Model, Outcome, SceneError, SimulationError
from modal.linear.mode_basis import mirrored
from modal.screening.floquet import (
    Multipliers,
    flip_determinant,
    flip_shape,
    lopsided_multiplier,
    multipliers,
)
from modal.screening.harmonic_balance import (
    FINE,
    GALLOP,
    SWING,
    Balance,
    NotConvergedError,
    Orbit,
    Track,
    amplitudes,
    doubled,
)
from modal.screening.reduced_model import MeanState, ReducedModel, mean_state

Array = NDArray[np.float64]

WINDS = 12
"""Wind speeds at which the mean state is examined before its stability limit is narrowed down."""

LEAST_WIND, ACCURATE = 0.01, 1e-4
"""Lowest wind looked at, in parts of the highest, and relative accuracy of the wind at which galloping begins."""

SPEED_RATIO = 0.3
"""Vertical speed over wind speed by which amplitudes are scaled: galloping settles at about 0.5."""

FIRST_SIZE = 0.05
"""Size of the first orbit beside the mean state, in that scale."""

LAST_SIZE = 0.01
"""Size at which galloping that dies out at a higher wind is taken to have ended, in that scale."""

BEAT_ELEMENTS, BEAT_STEPS, BEAT_RECORDS, BEAT_CYCLES, BEAT_SETTLING = 6, 80, 16, 500, 0.4
"""The simulation of a swing that comes and goes: elements, steps and records in a vertical cycle, cycles, and the part
of them that is left out while it settles."""

HALVINGS = 9
"""Halvings of the interval that holds an orbit at the scene's wind."""

LARGEST_GROWTH = 10.0
"""Growth of a swing in a vertical cycle above which the limit cycle is not believed; near 2:1 it is below 3."""

LEAVING = 1.05
"""Growth in a vertical cycle of another disturbance than the swing above which no motion stays near the limit cycle."""

LIMIT = 1e-3
"""Accuracy of a stability limit, in parts of the distance of two orbits."""


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
        By how much a small swing grows (above 1) or shrinks in one vertical cycle; for a motion
        that already swings, the same for the disturbance that decays slowest.
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
        self.size_scale = (
            SPEED_RATIO * wind / model.frequencies[0] / abs(model.middle[model.vertical, 1])
        )
        self.limit: str | None = (
            None  # why the limit cycle could not be followed up to the highest wind
        )
        self.unresolved = (
            False  # whether the limit cycle goes on, but says nothing about the motion
        )
        self.ended = False  # whether the limit cycle was followed to its end
        self.galloping_until: float | None = None
        self.galloping_from, start = self._stability_limit()
        self.track = self._track(GALLOP)
        self.orbits: list[Orbit] = []
        self.growth: list[Multipliers] = []
        if start is not None:
            self._follow(start)
            self._trim()

    def _track(self, balance: Balance) -> Track:
        return Track(self.model, balance, self.model.vertical, self.wind, self.size_scale)

    def _stability_limit(self) -> tuple[float | None, Orbit | None]:
        """Lowest wind at which the mean state gallops, and the first orbit there."""
        from scipy.optimize import brentq  # slow to import

        states: dict[float, MeanState] = {}

        def growth(wind: float) -> float:
            if wind not in states:
                states[wind] = mean_state(self.model, wind)
            return states[wind].vertical.real

        growth(
            self.wind
        )  # refuses a span that the wind in question turns over, however early it gallops
        calm, galloping = LEAST_WIND * self.highest, None
        for wind in np.union1d(
            self.highest * np.arange(1, WINDS + 1) / WINDS, [self.wind]
        ).tolist():
            try:
                rate = growth(wind)
            except SceneError as error:
                if wind < self.wind:
                    raise
                self.limit = str(error)
                return None, None
            if rate > 0.0:
                galloping = wind
                break
            calm = wind
        if galloping is None:
            return None, None
        galloping = (
            float(brentq(growth, calm, galloping, rtol=ACCURATE)) if growth(calm) < 0.0 else calm
        )
        growth(galloping)
        found = states[galloping]
        size = FIRST_SIZE * self.size_scale
        shape = found.shape / found.shape[self.model.vertical]
        coefficients = np.zeros((3, self.model.size))
        coefficients[0] = found.displacement
        coefficients[1], coefficients[2] = size * shape.real, -size * shape.imag
        return galloping, Orbit(galloping, float(found.vertical.imag), coefficients)

    def _follow(self, start: Orbit) -> None:
        """Follow the limit cycle up to the highest wind, its own end or the end of the curve."""
        guess = start.widened(self.track.balance.harmonics).packed()
        try:
            first, matrix, _ = self.track.of_size(guess, FIRST_SIZE * self.size_scale)
        except NotConvergedError:
            raise SceneError(
                f"no limit cycle was found beside the mean state at {start.wind_speed:.4g} m/s,"
                " where galloping begins; look at simulate(scene)"
            ) from None
        if self._follow_on(first, matrix, self.track.growing):
            return
        # from where four harmonics no longer do
        self.track = self._track(FINE)
        self.orbits = [orbit.widened(self.track.balance.harmonics) for orbit in self.orbits]
        last = self.orbits.pop().packed()
        self.growth.pop()
        direction = last - self.orbits[-1].packed() if self.orbits else self.track.growing
        try:
            first, matrix, _ = self.track.near(last, direction)
        except NotConvergedError:
            self.limit = f"it could not be followed beyond {last[-1]:.4g} m/s"
            return
        self._follow_on(first, matrix, direction)

    def _follow_on(self, first: Orbit, matrix: Array, direction: Array) -> bool:
        """Follow the limit cycle from one orbit on; false if it was lost, or is not resolved, with so few harmonics."""
        fine, least = self.track.balance is FINE, LAST_SIZE * self.size_scale

        def ends(orbit: Orbit) -> bool:
            done = orbit.wind_speed > self.highest or self.track.size(orbit) < least
            return done or not (fine or orbit.is_resolved)

        self.limit = None
        for orbit in self.track.follow(first, matrix, direction, ends):
            if self._leaves_curve(orbit):
                low, high = self.model.scene.aerodynamics.range_deg  # type: ignore[union-attr]
                self.limit = (
                    f"at {orbit.wind_speed:.4g} m/s its attack angles leave the coefficient curve, "
                    f"which is valid from {low:g} to {high:g} deg"
                )
                return True
            if self.track.size(orbit) < least:
                self._end(orbit, least)
                return True
            growth = multipliers(self.model, orbit)
            self.orbits.append(orbit)
            self.growth.append(growth)
            if max(abs(growth.swing), float(np.abs(growth.others[0]))) > LARGEST_GROWTH:
                return True  # what lies beyond is no answer, whatever it costs to follow it
        last = self.orbits[-1]
        if last.wind_speed > self.highest:
            return True
        self.limit = f"it could not be followed beyond {last.wind_speed:.4g} m/s"
        return False

    def _trim(self) -> None:
        """Remove what follows the last orbit that a motion can stay near; between folds the limit cycle may lose it."""
        trusted = max(
            (k for k, growth in enumerate(self.growth) if not doubt_of(growth)), default=0
        )
        if self.ended or trusted == len(self.orbits) - 1:
            return
        self.unresolved = True
        self.limit = (
            f"the limit cycle is unresolved beyond {self.orbits[trusted].wind_speed:.4g} m/s, as "
            f"{doubt_of(self.growth[trusted + 1])}"
        )
        self.orbits, self.growth = self.orbits[: trusted + 1], self.growth[: trusted + 1]

    def _end(self, beyond: Orbit, least: float) -> None:
        """How a family ends that has lost its first harmonic: at rest, or in a motion of half its period."""
        low, high = self.orbits[-1], beyond
        part = (self.track.size(low) - least) / (self.track.size(low) - self.track.size(high))
        try:
            last = self.track.of_size((1.0 - part) * low.packed() + part * high.packed(), least)[0]
        except NotConvergedError:
            self.limit = f"it could not be followed beyond {low.wind_speed:.4g} m/s"
            return
        self.orbits.append(last)
        self.growth.append(multipliers(self.model, last))
        self.ended = True
        if np.linalg.norm(last.coefficients[1:]) < FIRST_SIZE * self.size_scale:
            self.galloping_until = last.wind_speed
        else:
            self.limit = (
                f"at {last.wind_speed:.4g} m/s a higher mode takes over, at twice its frequency"
            )

    def _leaves_curve(self, orbit: Orbit) -> bool:
        curve = self.model.scene.aerodynamics
        if curve is None or curve.beyond != "error":
            return False
        q, v, _ = orbit.at(64)
        return self.model.angle_excess(q, v, orbit.wind_speed) > 0.0

    def galloping(self) -> tuple[Orbit, Multipliers] | None:
        """The first orbit without swing at the scene's wind that a motion can stay near, and its multipliers."""
        trusted = [not doubt_of(growth) for growth in self.growth]
        for k, pair in enumerate(pairwise(self.orbits)):
            orbit = self.at_wind(list(pair), self.track) if trusted[k] and trusted[k + 1] else None
            if orbit is not None:
                return orbit, multipliers(self.model, orbit)
        return None

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
                return track.at_wind((1.0 - part) * low.packed() + part * high.packed(), self.wind)[
                    0
                ]
            except NotConvergedError:
                middle = track.between(low.packed(), high.packed())
                low, high = (middle, high) if middle.wind_speed <= self.wind else (low, middle)
        return None

    def table(self) -> tuple[Cycle, ...]:
        """The limit cycles without swing."""
        found = zip(self.orbits, self.growth, strict=True)
        return tuple(self.cycle(orbit, abs(one.swing)) for orbit, one in found)

    def limits(self) -> list[tuple[Orbit, bool]]:
        """Orbits at which the swing starts (True) or ceases to start (False), in the order of the branch.

        The last orbit may lie beyond the highest wind looked at; what happens there does not count.
        """
        found = []
        unstable = [abs(one.swing) > 1.0 for one in self.growth]
        doubted = [bool(doubt_of(one)) for one in self.growth]
        for k in range(len(self.orbits) - 1):
            if unstable[k] != unstable[k + 1] and not (doubted[k] or doubted[k + 1]):
                found.append(
                    (self._limit_between(self.orbits[k], self.orbits[k + 1]), unstable[k + 1])
                )
        return [(orbit, starts) for orbit, starts in found if orbit.wind_speed <= self.highest]

    def _limit_between(self, low: Orbit, high: Orbit) -> Orbit:
        """Orbit at which the swing is neither damped nor driven."""
        from scipy.optimize import brentq  # slow to import

        ends = [flip_determinant(self.model, one) for one in (low, high)]
        by_flip, size = ends[0][0] != ends[1][0], ends[0][1]
        a, b = low.packed(), high.packed()

        def level(part: float) -> float:
            orbit = self.track.between(a, b, part) if 0.0 < part < 1.0 else (low, high)[int(part)]
            if not by_flip:
                return abs(multipliers(self.model, orbit).swing) - 1.0
            sign, logarithm = flip_determinant(self.model, orbit)
            return sign * float(np.exp(logarithm - size))

        return self.track.between(a, b, float(brentq(level, 0.0, 1.0, xtol=LIMIT)))

    def swing_branch(self, onset: Orbit) -> tuple[list[Orbit], Track]:
        """Motions with swing, from its onset to the scene's wind."""
        model = self.model
        scale = (
            SPEED_RATIO * self.wind / model.frequencies[0] / abs(model.middle[model.horizontal, 2])
        )
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

        def ends(orbit: Orbit) -> bool:
            return not low < orbit.wind_speed < high or track.size(orbit) <= 0.0

        return list(track.follow(first, matrix, track.growing, ends)), track

    def lopsided(self, orbit: Orbit, cycles: int) -> float | None:
        """Growth in one vertical cycle of what breaks the mirror symmetry; None without such symmetry."""
        if not mirrored(self.model.scene):
            return None
        return float(lopsided_multiplier(self.model, orbit, cycles) ** (1.0 / cycles))

    def beating(self, unsteady: Cycle) -> Cycle:
        """Amplitudes of a swing that comes and goes, from a short simulation that starts near its unstable cycle."""
        scene = self.model.scene
        coarse = {
            "numerics.elements": min(BEAT_ELEMENTS, scene.numerics.elements),
            "numerics.time_step": 1.0 / (BEAT_STEPS * unsteady.frequency_hz),
            "initial": {"seed_vertical": -unsteady.vertical, "seed_horizontal": unsteady.horizontal},
            "wind": {"speed": self.wind, "air_density": scene.wind.air_density},
            "loads": [], "supports.left.motion": None, "supports.right.motion": None,
        }  # fmt: skip
        model = Model(scene.with_values(coarse))
        every = BEAT_STEPS // BEAT_RECORDS
        try:
            start = model.start()
        except SimulationError:  # the conductor would be slack in so large a motion
            return unsteady
        run = start.run(
            BEAT_CYCLES * BEAT_RECORDS,
            every,
            np.array([1, 2, 3], np.int32),
            np.array([model.middle], np.int32),
        )
        if run.report.outcome is not Outcome.COMPLETED:
            return unsteady
        late = run.node_values[int(BEAT_SETTLING * len(run.node_values)) :, :, 0]
        vertical, horizontal, twist = (0.5 * float(size) for size in np.ptp(late, axis=0))
        return replace(unsteady, vertical=vertical, horizontal=horizontal, twist=twist)

    def cycle(self, orbit: Orbit, multiplier: float, cycles: int = 1) -> Cycle:
        """The figures of an orbit that takes so many vertical cycles."""
        _, vertical, horizontal, twist = (float(size) for size in amplitudes(self.model, orbit))
        frequency = cycles * orbit.omega / (2.0 * np.pi)
        return Cycle(orbit.wind_speed, vertical, horizontal, twist, frequency, multiplier)


def doubt_of(growth: Multipliers) -> str:
    """Reason why no motion stays near an orbit, or why it is not believed; empty if there is none."""
    swing, other = abs(growth.swing), float(np.abs(growth.others[0]))
    if swing > LARGEST_GROWTH:
        return f"a swing would grow {swing:.3g} times in a cycle"
    if other > LEAVING and other > (1.0 + LIMIT) * swing:
        return (
            f"a disturbance other than the swing grows by {other - 1.0:.0%} in a cycle and leads"
            " away from it"
        )
    return ""
