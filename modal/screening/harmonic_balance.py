"""Periodic motions of a galloping span by harmonic balance, and their continuation in wind speed.

The coordinates of the reduced model (`modal.screening.reduced_model`) are a Fourier series,

    q(t) = c0 + sum over k of (c_2k-1 cos k t' + c_2k sin k t'),    t' = omega t,                (1)

and the residual r of the equations of motion vanishes in the mean over a period against each of the
functions 1, cos k t', sin k t' =: phi_i, evaluated at N equally spaced instants t_j:

    R_i = 2/N sum over j of phi_i(t_j) r(q, q', q''; t_j) = 0.                                   (2)

The unknowns y are the coefficients c, omega and the wind speed U. Two linear conditions close the
system: the phase (the first sine of one mode is zero) and the position along the family of motions
(`Track`). Families are followed by pseudo-arclength continuation, so that they may start at an
equilibrium and pass folds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modal.screening.reduced_model import Forces, ReducedModel

Array = NDArray[np.float64]

GALLOP_HARMONICS, GALLOP_INSTANTS = 4, 18
FINE_HARMONICS, FINE_INSTANTS = 6, 26
SWING_HARMONICS, SWING_INSTANTS = 6, 26
"""Harmonics and instants. Four harmonics suffice unless one of them meets a higher mode."""

MAX_HIGHEST_HARMONIC = 0.003
"""Largest share of the highest harmonic in a resolved motion.

With four harmonics the error of the amplitude is then 0.3 %.
"""

NEWTON_TOLERANCE = 1e-5
"""Relative correction at which Newton's iteration ends; the error left is of second order in it."""

NEWTON_ITERATIONS, STEP_ITERATIONS = 12, 6
"""Largest number of Newton iterations: for a single orbit, and for a step along a family."""

MIN_CORRECTION_SCALE = 1e-12
"""Lower bound of the motion that relative corrections refer to [modal coordinate]."""

FEW_ITERATIONS = 3
"""Newton iterations up to which the next step is longer, by `STEP_GROWTH`."""

STEP_GROWTH = 1.5
"""Largest ratio of a step to the one before."""

MIN_COSINE = 0.8
"""Smallest cosine between a step and its tangent; a step that turns more may have missed a fold."""

UNCHECKED_STEP = 0.02
"""Step length up to which this direction is not checked."""

MIN_STEP = 1e-3
"""Step length, relative to the scales of a family, below which the continuation ends."""

MAX_HALVINGS = 9
"""Halvings of two neighbours that enclose a wind speed, to find the orbit there."""

AMPLITUDE_INSTANTS = 128
"""Instants of a period at which the extremes of a motion are read."""


class NotConvergedError(ArithmeticError):
    """Newton's iteration did not find a periodic motion."""


@dataclass(frozen=True)
class Balance:
    """Fourier functions at the instants of harmonic balance.

    Attributes
    ----------
    harmonics, instants : int
        Number of harmonics and of instants.
    value, rate, curvature : ndarray, shape (instant, coefficient)
        1, cos, sin, cos 2, ... and their first and second derivative by the phase.
    """

    harmonics: int
    instants: int
    value: Array = field(init=False, repr=False)
    rate: Array = field(init=False, repr=False)
    curvature: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        phase = 2.0 * np.pi * np.arange(self.instants) / self.instants
        value, rate = fourier(phase, self.harmonics)
        squares = np.repeat(np.arange(self.harmonics + 1), 2)[1:] ** 2
        object.__setattr__(self, "value", value)
        object.__setattr__(self, "rate", rate)
        object.__setattr__(self, "curvature", -value * squares)


def fourier(phase: Array, harmonics: int) -> tuple[Array, Array]:
    """Evaluate 1, cos, sin, cos 2, sin 2, ... and their derivatives at phases [rad].

    Returns
    -------
    ndarray, ndarray, shape (phase, coefficient)
        Values and derivatives by the phase.
    """
    value, rate = [np.ones_like(phase)], [np.zeros_like(phase)]
    for k in range(1, harmonics + 1):
        cosine, sine = np.cos(k * phase), np.sin(k * phase)
        value += [cosine, sine]
        rate += [-k * sine, k * cosine]
    return np.stack(value, axis=1), np.stack(rate, axis=1)


fourier_matrices = lru_cache(maxsize=32)(Balance)
"""Cached `Balance`."""

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
        The coefficients c of (1).
    """

    wind_speed: float
    omega: float
    coefficients: Array = field(repr=False)

    def at(self, instants: int) -> tuple[Array, Array, Array]:
        """Coordinates, velocities and accelerations at instants of a period: (instant, mode)."""
        balance = fourier_matrices(len(self.coefficients) // 2, instants)
        return tuple(  # type: ignore[return-value]
            self.omega**order * basis @ self.coefficients
            for order, basis in enumerate((balance.value, balance.rate, balance.curvature))
        )

    def shifted(self, phase: float) -> Orbit:
        """Return the same motion with its origin of time shifted by a phase [rad]."""
        shifted = self.coefficients.copy()
        for k in range(1, len(shifted) // 2 + 1):
            c, s = self.coefficients[2 * k - 1], self.coefficients[2 * k]
            shifted[2 * k - 1] = c * np.cos(k * phase) + s * np.sin(k * phase)
            shifted[2 * k] = s * np.cos(k * phase) - c * np.sin(k * phase)
        return Orbit(self.wind_speed, self.omega, shifted)

    def widened(self, harmonics: int) -> Orbit:
        """Return the same motion with more harmonics, the new ones zero."""
        coefficients = np.zeros((2 * harmonics + 1, self.coefficients.shape[1]))
        coefficients[: len(self.coefficients)] = self.coefficients
        return Orbit(self.wind_speed, self.omega, coefficients)

    @property
    def is_resolved(self) -> bool:
        """True if the highest harmonic is small."""
        highest = np.linalg.norm(self.coefficients[-2:])
        return bool(highest <= MAX_HIGHEST_HARMONIC * np.linalg.norm(self.coefficients[1:]))

    def packed(self) -> Array:
        """Return the unknowns y: coefficients, omega, wind speed."""
        return np.concatenate([self.coefficients.ravel(), [self.omega, self.wind_speed]])


def doubled(orbit: Orbit, harmonics: int) -> Orbit:
    """Write a motion as one of twice its period."""
    coefficients = np.zeros((2 * harmonics + 1, orbit.coefficients.shape[1]))
    coefficients[0] = orbit.coefficients[0]
    for k in range(1, min(harmonics // 2, len(orbit.coefficients) // 2) + 1):
        coefficients[4 * k - 1 : 4 * k + 1] = orbit.coefficients[2 * k - 1 : 2 * k + 1]
    return Orbit(orbit.wind_speed, 0.5 * orbit.omega, coefficients)


def unpacked(y: Array, size: int) -> Orbit:
    """Convert the unknowns y to an orbit; `size` is the number of modes."""
    return Orbit(float(y[-1]), float(y[-2]), y[:-2].reshape(-1, size))


def amplitudes(model: ReducedModel, orbit: Orbit) -> Array:
    """Half peak-to-peak of u1, u2, u3 [m] and theta [rad] at mid-span."""
    q, _, _ = orbit.at(AMPLITUDE_INSTANTS)
    motion = q @ model.middle
    return np.asarray(0.5 * np.ptp(motion, axis=0))


def imbalance(model: ReducedModel, balance: Balance, orbit: Orbit) -> tuple[Array, Array]:
    """Evaluate the residual R of (2) and its derivatives by the unknowns y.

    With Q, Q', Q'' the Fourier matrices, q = Q c, q' = omega Q' c, q'' = omega^2 Q'' c, so that

        dR/domega = 2/N Q^T (C q' + 2 M q'') / omega,    dR/dU = 2/N Q^T dr/dU.                  (3)

    Returns
    -------
    ndarray, ndarray
        Residual (coefficient * mode) and derivatives (coefficient * mode, unknown).
    """
    q = balance.value @ orbit.coefficients
    v = orbit.omega * balance.rate @ orbit.coefficients
    a = orbit.omega**2 * balance.curvature @ orbit.coefficients
    forces = model.forces(q, v, a, orbit.wind_speed)
    test = balance.value * (2.0 / balance.instants)
    size, count = model.size, test.shape[1]
    jacobian = np.empty((count, size, count * size + 2))
    jacobian[:, :, :-2] = derivative(balance, orbit.omega, forces, test).reshape(count, size, -1)
    by_omega = np.einsum("tij,tj->ti", forces.damping, v)
    by_omega = by_omega + 2.0 * np.einsum("tij,tj->ti", forces.mass, a)
    jacobian[:, :, -2] = test.T @ by_omega / orbit.omega
    jacobian[:, :, -1] = test.T @ forces.by_wind
    return (test.T @ forces.residual).ravel(), jacobian.reshape(count * size, -1)


def derivative(
    balance: Balance,
    omega: float,
    forces: Forces,
    test: Array,
    columns: slice | NDArray[np.intp] = slice(None),
) -> Array:
    """Derivative of the balance by the coefficients.

    With the stiffness, damping and mass K, C, M at each instant,

        dR/dc = 2/N sum over j of phi(t_j) (K Q + omega C Q' + omega^2 M Q'')(t_j).              (4)

    Parameters
    ----------
    balance, omega
        Fourier matrices and angular frequency [rad/s].
    forces
        Forces and derivatives at the instants.
    test : ndarray, shape (instant, row)
        2/N phi.
    columns
        Coefficients by which the derivative is taken; all by default.

    Returns
    -------
    ndarray, shape (row, mode, column, mode)
        The derivative.
    """

    def term(basis: Array, matrix: Array) -> Array:
        """Sum over the instants of phi basis matrix: (row column, mode mode)."""
        basis = basis[:, columns]
        weights = (test[:, :, None] * basis[:, None, :]).reshape(len(test), -1)
        return np.asarray(weights.T @ matrix.reshape(len(test), -1))

    total = (
        term(balance.value, forces.stiffness)
        + term(omega * balance.rate, forces.damping)
        + term(omega**2 * balance.curvature, forces.mass)
    )
    size = forces.residual.shape[1]
    return total.reshape(test.shape[1], -1, size, size).transpose(0, 2, 1, 3)


def solve(
    model: ReducedModel,
    balance: Balance,
    start: Array,
    rows: Array,
    values: Array,
    iterations: int = NEWTON_ITERATIONS,
) -> tuple[Orbit, Array, int]:
    """Find an orbit by Newton's method, subject to two linear conditions ``rows @ y = values``.

    Returns
    -------
    Orbit, ndarray, int
        The orbit, the derivative there with the two rows below it, and the number of iterations.

    Raises
    ------
    NotConvergedError
        If the iteration does not converge to a positive frequency and wind speed.
    """
    y = start.copy()
    for iteration in range(1, iterations + 1):
        residual, jacobian = imbalance(model, balance, unpacked(y, model.size))
        matrix = np.vstack([jacobian, rows])
        change = np.linalg.solve(matrix, -np.concatenate([residual, rows @ y - values]))
        scale = max(float(np.max(np.abs(y[:-2]))), MIN_CORRECTION_SCALE)
        if not np.all(np.isfinite(change)):
            break
        y = y + change
        if y[-2] <= 0.0 or y[-1] <= 0.0:
            break
        if (
            np.max(np.abs(change[:-2])) < NEWTON_TOLERANCE * scale
            and np.max(np.abs(change[-2:] / y[-2:])) < NEWTON_TOLERANCE
        ):
            return unpacked(y, model.size), matrix, iteration
    raise NotConvergedError


@dataclass(frozen=True)
class Track:
    """Phase condition, size and metric of a family of orbits.

    Attributes
    ----------
    model, balance
        The reduced span, and the harmonics.
    mode : int
        The mode whose first harmonic is a pure cosine, and the size of an orbit.
    wind_scale, size_scale : float
        Wind speed [m/s] and modal amplitude that count as one unit of length along the family.
    """

    model: ReducedModel
    balance: Balance
    mode: int
    wind_scale: float
    size_scale: float

    @property
    def cosine(self) -> int:
        """Index of the unknown that measures the size."""
        return self.model.size + self.mode

    @property
    def sine(self) -> int:
        """Index of the unknown that the phase condition makes zero."""
        return 2 * self.model.size + self.mode

    def rows(self, condition: Array) -> Array:
        """Rows of the phase condition and of another condition."""
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
        """Metric g of arc length, ds^2 = sum of g dy^2.

        All oscillating coefficients and the wind speed count; mean state and frequency do not.
        """
        weights = np.full(
            (2 * self.balance.harmonics + 1) * self.model.size + 2, 1.0 / self.size_scale**2
        )
        weights[: self.model.size] = weights[-2] = 0.0
        weights[-1] = 1.0 / self.wind_scale**2
        return weights

    def size(self, orbit: Orbit) -> float:
        """First harmonic of the mode; it changes sign where the family passes an equilibrium."""
        return float(orbit.coefficients[1, self.mode])

    def near(
        self, guess: Array, direction: Array, iterations: int = NEWTON_ITERATIONS
    ) -> tuple[Orbit, Array, int]:
        """Find the orbit near a guess in the plane normal to a direction."""
        row = self.measure * direction
        values = np.array([0.0, row @ guess])
        return solve(self.model, self.balance, guess, self.rows(row), values, iterations)

    def of_size(self, start: Array, size: float) -> tuple[Orbit, Array, int]:
        """Find the orbit of a given size, at any wind speed."""
        guess = start.copy()
        guess[self.cosine] = size
        return self.near(guess, self.growing)

    def between(self, low: Array, high: Array, part: float = 0.5) -> Orbit:
        """Find the orbit between two neighbours of the family, at a part of their distance."""
        return self.near(low + part * (high - low), high - low)[0]

    def at_wind(self, start: Array, wind_speed: float) -> tuple[Orbit, Array, int]:
        """Find the orbit at a wind speed [m/s]."""
        guess, direction = start.copy(), np.zeros_like(start)
        guess[-1], direction[-1] = wind_speed, 1.0
        return self.near(guess, direction)

    def first_at(self, orbits: list[Orbit], wind_speed: float) -> Orbit | None:
        """Find the first orbit of a family that reaches a wind speed [m/s] from below.

        Returns None if no two neighbours enclose the wind speed, or Newton's method fails. Near a
        fold it fails from a guess between distant neighbours, so these are halved until it
        converges.
        """
        for low, high in pairwise(orbits):
            if low.wind_speed <= wind_speed < high.wind_speed:
                return self._enclosed(low, high, wind_speed)
        return None

    def _enclosed(self, low: Orbit, high: Orbit, wind_speed: float) -> Orbit | None:
        """Find the orbit at a wind speed between those of two neighbours."""
        for _ in range(MAX_HALVINGS):
            part = (wind_speed - low.wind_speed) / (high.wind_speed - low.wind_speed)
            guess = (1.0 - part) * low.packed() + part * high.packed()
            try:
                return self.at_wind(guess, wind_speed)[0]
            except NotConvergedError:
                middle = self.between(low.packed(), high.packed())
            low, high = (middle, high) if middle.wind_speed <= wind_speed else (low, middle)
        return None

    def tangent(self, matrix: Array, direction: Array) -> Array:
        """Unit tangent of the family, on the side of a direction.

        It solves dR/dy t = 0 with the phase condition, and is normalised to the metric.

        Parameters
        ----------
        matrix
            Derivative at the orbit, with the conditions below it.
        direction
            Any direction that is not normal to the tangent.
        """
        ahead = np.vstack([matrix[:-1], self.measure * direction])
        unit = np.zeros(len(direction))
        unit[-1] = 1.0
        tangent = np.linalg.solve(ahead, unit)
        return np.asarray(tangent / np.sqrt(tangent @ (self.measure * tangent)))

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
        """Follow a family from an orbit until `stop`, or until Newton's method finds no next one.

        With t_n the tangent at orbit n and s the step, the guess is that of Adams and Bashforth's
        second-order formula,

            y_n+1 = y_n + s (t_n + s/2 (t_n - t_n-1) / s_n-1).                                   (5)

        Parameters
        ----------
        first, matrix, direction
            First orbit, the derivative there (`solve`), and the direction to start in.
        stop
            Called with each orbit; True ends the family with it.
        step, longest
            First and longest step, in the metric of the family.
        most
            Largest number of steps.
        """
        yield first
        y, before, last_step = first.packed(), direction, np.inf
        for number in range(most):
            direction = self.tangent(matrix, direction)
            bend = np.zeros_like(y) if number == 0 else (direction - before) / last_step
            found = self._step(y, direction, bend, step)
            if found is None:
                return
            orbit, matrix, iterations, step = found
            yield orbit
            if stop(orbit):
                return
            y, before, last_step = orbit.packed(), direction, step
            if iterations <= FEW_ITERATIONS:
                step = min(STEP_GROWTH * step, longest)

    def _step(
        self, y: Array, direction: Array, bend: Array, step: float
    ) -> tuple[Orbit, Array, int, float] | None:
        """Take one step along the family, halved until it succeeds.

        Returns orbit, derivative, Newton iterations and step length; None below `MIN_STEP`.
        """
        while step >= MIN_STEP:
            guess = y + step * (direction + 0.5 * step * bend)
            try:
                orbit, matrix, iterations = self.near(guess, direction, STEP_ITERATIONS)
            except (NotConvergedError, np.linalg.LinAlgError):
                step *= 0.5
                continue
            if step <= UNCHECKED_STEP or self._cosine(orbit.packed() - y, direction) >= MIN_COSINE:
                return orbit, matrix, iterations, step
            step *= 0.5
        return None

    def _cosine(self, moved: Array, direction: Array) -> float:
        """Cosine of the angle between a move and a unit direction, in the metric of the family."""
        return float(direction @ (self.measure * moved) / np.sqrt(moved @ (self.measure * moved)))
