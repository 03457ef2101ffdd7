"""Periodic motions of a galloping span by harmonic balance, followed over the wind speed.

A motion of period ``2 pi / omega`` is a Fourier series whose coefficients balance the forces of
`modal.screening.reduced_model` at equally spaced instants. A family of such motions is followed by
pseudo-arclength continuation, so that it may start from rest, turn back or jump.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from modal.screening.reduced_model import Forces, ReducedModel

Array = NDArray[np.float64]

GALLOP_HARMONICS, GALLOP_INSTANTS = 4, 18
FINE_HARMONICS, FINE_INSTANTS = 6, 26
SWING_HARMONICS, SWING_INSTANTS = 6, 26
"""Harmonics kept and instants of balance. Four harmonics are enough unless a higher mode resonates with one of them."""

RESOLVED = 0.003
"""Part of the highest harmonic kept, relative to the whole motion, from which more are needed: four are then off by
0.3 % of the amplitude."""

TOLERANCE = 1e-5
"""Newton's iteration ends at this relative change of the coefficients; what is left is of the order of its square."""


STRAIGHT, SHORT = 0.8, 0.02
"""A step along a family must go in the direction of its tangent, this cosine at least, or be as short as this: a longer
one that turns may have jumped over a fold."""

SHORTEST = 1e-3
"""Step along a family, in parts of its scales, below which no next orbit is looked for."""


class NotConvergedError(ArithmeticError):
    """Newton's iteration did not find a periodic motion."""


@dataclass(frozen=True)
class Balance:
    """Fourier matrices of a number of harmonics at a number of instants."""

    harmonics: int
    instants: int
    value: Array = field(init=False, repr=False)  # (instant, coefficient): 1, cos, sin, cos 2, ...
    rate: Array = field(init=False, repr=False)  # the same for the derivative by the phase
    curvature: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        phase = 2.0 * np.pi * np.arange(self.instants) / self.instants
        value, rate = fourier(phase, self.harmonics)
        squares = np.repeat(np.arange(self.harmonics + 1), 2)[1:] ** 2
        object.__setattr__(self, "value", value)
        object.__setattr__(self, "rate", rate)
        object.__setattr__(self, "curvature", -value * squares)


def fourier(phase: Array, harmonics: int) -> tuple[Array, Array]:
    """1, cos, sin, cos 2, sin 2, ... at phases [rad], and their derivatives: (phase, coefficient) each."""
    value, rate = [np.ones_like(phase)], [np.zeros_like(phase)]
    for k in range(1, harmonics + 1):
        cosine, sine = np.cos(k * phase), np.sin(k * phase)
        value += [cosine, sine]
        rate += [-k * sine, k * cosine]
    return np.stack(value, axis=1), np.stack(rate, axis=1)


fourier_matrices = lru_cache(maxsize=32)(Balance)
"""The same for whoever needs them again."""

GALLOP = Balance(GALLOP_HARMONICS, GALLOP_INSTANTS)
FINE = Balance(FINE_HARMONICS, FINE_INSTANTS)
SWING = Balance(SWING_HARMONICS, SWING_INSTANTS)


@dataclass(frozen=True)
class Orbit:
    """A periodic motion.

    Attributes
    ----------
    wind_speed : float
        Wind speed [m/s].
    omega : float
        Fundamental angular frequency [rad/s].
    coefficients : ndarray, shape (2 harmonics + 1, mode)
        Constant, cosine and sine parts in turn.
    """

    wind_speed: float
    omega: float
    coefficients: Array = field(repr=False)

    def at(self, instants: int) -> tuple[Array, Array, Array]:
        """Coordinates, velocities and accelerations at instants of one period, (instant, mode) each."""
        balance = fourier_matrices(len(self.coefficients) // 2, instants)
        return tuple(  # type: ignore[return-value]
            self.omega**order * basis @ self.coefficients
            for order, basis in enumerate((balance.value, balance.rate, balance.curvature))
        )

    def turned(self, phase: float) -> Orbit:
        """The same motion from another instant of it on, `phase` [rad] of the fundamental later."""
        turned = self.coefficients.copy()
        for k in range(1, len(turned) // 2 + 1):
            c, s = self.coefficients[2 * k - 1], self.coefficients[2 * k]
            turned[2 * k - 1] = c * np.cos(k * phase) + s * np.sin(k * phase)
            turned[2 * k] = s * np.cos(k * phase) - c * np.sin(k * phase)
        return Orbit(self.wind_speed, self.omega, turned)

    def widened(self, harmonics: int) -> Orbit:
        """The same motion with room for more harmonics."""
        coefficients = np.zeros((2 * harmonics + 1, self.coefficients.shape[1]))
        coefficients[: len(self.coefficients)] = self.coefficients
        return Orbit(self.wind_speed, self.omega, coefficients)

    @property
    def is_resolved(self) -> bool:
        """Whether the highest harmonic kept is small."""
        highest = np.linalg.norm(self.coefficients[-2:])
        return bool(highest <= RESOLVED * np.linalg.norm(self.coefficients[1:]))

    def packed(self) -> Array:
        """Coefficients, omega, wind speed in one array."""
        return np.concatenate([self.coefficients.ravel(), [self.omega, self.wind_speed]])


def doubled(orbit: Orbit, harmonics: int) -> Orbit:
    """The same motion as one of twice the period."""
    coefficients = np.zeros((2 * harmonics + 1, orbit.coefficients.shape[1]))
    coefficients[0] = orbit.coefficients[0]
    for k in range(1, min(harmonics // 2, len(orbit.coefficients) // 2) + 1):
        coefficients[4 * k - 1 : 4 * k + 1] = orbit.coefficients[2 * k - 1 : 2 * k + 1]
    return Orbit(orbit.wind_speed, 0.5 * orbit.omega, coefficients)


def unpacked(y: Array, size: int) -> Orbit:
    """Orbit of the unknowns in one array."""
    return Orbit(float(y[-1]), float(y[-2]), y[:-2].reshape(-1, size))


def amplitudes(model: ReducedModel, orbit: Orbit) -> Array:
    """Half peak-to-peak of u1, u2, u3 [m] and theta [rad] at mid-span."""
    q, _, _ = orbit.at(128)
    motion = q @ model.middle
    return np.asarray(0.5 * np.ptp(motion, axis=0))


def imbalance(model: ReducedModel, balance: Balance, orbit: Orbit) -> tuple[Array, Array, Forces]:
    """Fourier coefficients of the residual, their derivatives by the unknowns, and the forces at the instants."""
    q = balance.value @ orbit.coefficients
    v = orbit.omega * balance.rate @ orbit.coefficients
    a = orbit.omega**2 * balance.curvature @ orbit.coefficients
    forces = model.forces(q, v, a, orbit.wind_speed)
    test = balance.value * (2.0 / balance.instants)
    size, count = model.size, test.shape[1]
    jacobian = np.empty((count, size, count * size + 2))
    jacobian[:, :, :-2] = derivative(balance, orbit.omega, forces, test).reshape(count, size, -1)
    by_omega = np.einsum("tij,tj->ti", forces.damping, v) + 2.0 * np.einsum(
        "tij,tj->ti", forces.mass, a
    )
    jacobian[:, :, -2] = test.T @ by_omega / orbit.omega
    jacobian[:, :, -1] = test.T @ forces.by_wind
    return (test.T @ forces.residual).ravel(), jacobian.reshape(count * size, -1), forces


def derivative(
    balance: Balance,
    omega: float,
    forces: Forces,
    test: Array,
    columns: slice | NDArray[np.intp] = slice(None),
) -> Array:
    """(row coefficient, mode, column coefficient, mode) of the linearised balance."""
    size = forces.residual.shape[1]
    total = None
    for order, (basis, matrix) in enumerate(
        (
            (balance.value, forces.stiffness),
            (balance.rate, forces.damping),
            (balance.curvature, forces.mass),
        )
    ):
        basis = omega**order * basis[:, columns]
        weights = (test[:, :, None] * basis[:, None, :]).reshape(len(test), -1)
        part = weights.T @ matrix.reshape(len(test), -1)
        total = part if total is None else total + part
    assert total is not None
    return total.reshape(test.shape[1], -1, size, size).transpose(0, 2, 1, 3)


def solve(
    model: ReducedModel,
    balance: Balance,
    start: Array,
    rows: Array,
    values: Array,
    iterations: int = 12,
) -> tuple[Orbit, Array, int]:
    """Newton's iteration for an orbit on which two linear conditions hold: ``rows @ unknowns = values``.

    Returns
    -------
    Orbit, ndarray, int
        The orbit, the derivative there with the two rows below it, and the number of iterations.

    Raises
    ------
    NotConvergedError
        If it is not found.
    """
    y = start.copy()
    for iteration in range(1, iterations + 1):
        residual, jacobian, _ = imbalance(model, balance, unpacked(y, model.size))
        matrix = np.vstack([jacobian, rows])
        change = np.linalg.solve(matrix, -np.concatenate([residual, rows @ y - values]))
        scale = max(float(np.max(np.abs(y[:-2]))), 1e-12)
        if not np.all(np.isfinite(change)):
            break
        y = y + change
        if y[-2] <= 0.0 or y[-1] <= 0.0:
            break
        if (
            np.max(np.abs(change[:-2])) < TOLERANCE * scale
            and np.max(np.abs(change[-2:] / y[-2:])) < TOLERANCE
        ):
            return unpacked(y, model.size), matrix, iteration
    raise NotConvergedError


@dataclass(frozen=True)
class Track:
    """Which unknowns fix the phase and measure the size of a family of orbits."""

    model: ReducedModel
    balance: Balance
    mode: int  # the mode whose first harmonic is a pure cosine
    wind_scale: float
    size_scale: float

    @property
    def cosine(self) -> int:
        """Unknown that measures the size."""
        return self.model.size + self.mode

    @property
    def sine(self) -> int:
        """Unknown that is zero."""
        return 2 * self.model.size + self.mode

    def rows(self, condition: Array) -> Array:
        """The phase condition and another one."""
        rows = np.zeros((2, len(condition)))
        rows[0, self.sine] = 1.0
        rows[1] = condition
        return rows

    @property
    def growing(self) -> Array:
        """Direction of the unknowns towards larger size."""
        direction = np.zeros((2 * self.balance.harmonics + 1) * self.model.size + 2)
        direction[self.cosine] = 1.0
        return direction

    @property
    def measure(self) -> Array:
        """Weights of the unknowns in the length of a family of orbits: of all that oscillates, and of the wind."""
        weights = np.full(
            (2 * self.balance.harmonics + 1) * self.model.size + 2, 1.0 / self.size_scale**2
        )
        weights[: self.model.size] = weights[-2] = 0.0
        weights[-1] = 1.0 / self.wind_scale**2
        return weights

    def size(self, orbit: Orbit) -> float:
        """First harmonic of the mode followed; negative where a family has passed through rest or half its period."""
        return float(orbit.coefficients[1, self.mode])

    def near(
        self, guess: Array, direction: Array, iterations: int = 12
    ) -> tuple[Orbit, Array, int]:
        """Orbit beside a guess, in the plane across a direction."""
        row = self.measure * direction
        return solve(
            self.model,
            self.balance,
            guess,
            self.rows(row),
            np.array([0.0, row @ guess]),
            iterations,
        )

    def of_size(self, start: Array, size: float) -> tuple[Orbit, Array, int]:
        """Orbit with the cosine part `size`, whatever the wind."""
        guess = start.copy()
        guess[self.cosine] = size
        return self.near(guess, self.growing)

    def between(self, low: Array, high: Array, part: float = 0.5) -> Orbit:
        """Orbit between two neighbours of the family, at a part of the way."""
        return self.near(low + part * (high - low), high - low)[0]

    def at_wind(self, start: Array, wind_speed: float) -> tuple[Orbit, Array, int]:
        """Orbit at a wind speed."""
        guess, direction = start.copy(), np.zeros_like(start)
        guess[-1], direction[-1] = wind_speed, 1.0
        return self.near(guess, direction)

    def follow(
        self,
        first: Orbit,
        matrix: Array,
        direction: Array,
        stop: Callable[[Orbit], bool],
        step: float = 0.05,
        longest: float = 0.25,
        most: int = 32,
    ) -> Iterator[Orbit]:
        """Orbits from `first` on, at first towards `direction`, until `stop` or where Newton finds no more.

        Guesses are of second order (Adams and Bashforth's formula for the tangent), which saves
        iterations.
        """
        yield first
        y, measure = first.packed(), self.measure
        before, last = direction, np.inf
        for number in range(most):
            ahead = np.vstack([matrix[:-1], measure * direction])
            direction = np.linalg.solve(ahead, np.concatenate([np.zeros(len(y) - 1), [1.0]]))
            direction /= np.sqrt(direction @ (measure * direction))
            bend = np.zeros_like(y) if number == 0 else (direction - before) / last
            while True:
                try:
                    guess = y + step * (direction + 0.5 * step * bend)
                    orbit, found, iterations = self.near(guess, direction, iterations=6)
                    moved = orbit.packed() - y
                    if step > SHORT and direction @ (measure * moved) < STRAIGHT * np.sqrt(
                        moved @ (measure * moved)
                    ):
                        raise NotConvergedError
                    matrix = found
                    break
                except (NotConvergedError, np.linalg.LinAlgError):
                    step *= 0.5
                    if step < SHORTEST:
                        return
            yield orbit
            if stop(orbit):
                return
            y, before, last = orbit.packed(), direction, step
            if iterations <= 3:
                step = min(1.5 * step, longest)
