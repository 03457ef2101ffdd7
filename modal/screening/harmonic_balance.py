"""Periodic motions of a galloping span by harmonic balance.

The coordinates of the reduced model (`modal.motions.reduced_model`) are a Fourier series,

    q(t) = c0 + sum over k of (c_2k-1 cos k t' + c_2k sin k t'),    t' = omega t,                (1)

and the residual r of the equations of motion vanishes in the mean over a period against each of the
functions 1, cos k t', sin k t' =: phi_i, evaluated at N equally spaced instants t_j:

    R_i = 2/N sum over j of phi_i(t_j) r(q, q', q''; t_j) = 0.                                   (2)

The unknowns y are the coefficients c, omega and the wind speed U. Two linear conditions close the
system: the phase (the first sine of one mode is zero) and the position along the family of motions
(`modal.screening.orbit_family`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from modal.motions.reduced_model import Forces, ReducedModel

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

NEWTON_ITERATIONS = 12
"""Largest number of Newton iterations for an orbit."""

MIN_CORRECTION_SCALE = 1e-12
"""Lower bound of the motion that relative corrections refer to [modal coordinate]."""

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
