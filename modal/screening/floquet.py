"""Stability of periodic motions: Floquet multipliers from the variational equation of an orbit.

With the stiffness, damping and mass K, C, M along an orbit of period T, a small disturbance x obeys

    M(t) x'' + C(t) x' + K(t) x = 0,    (x, x')(T) = Phi (x, x')(0).                             (1)

The eigenvalues of the monodromy matrix Phi are the Floquet multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from modal.motions.reduced_model import ReducedModel, with_antisymmetric_modes
from modal.screening.harmonic_balance import (
    SWING,
    Orbit,
    derivative,
    doubled,
    fourier,
    fourier_matrices,
)

Array = NDArray[np.float64]

PERIOD_INSTANTS = 22
"""Instants of a period at which the coefficients of the variational equation are evaluated."""

PERIOD_STEPS = 64
"""Time steps of a period; coefficients between the instants follow by Fourier interpolation."""

MIN_PARTICIPATION = 0.2
"""Participation of the horizontal mode in a disturbance, relative to the largest, in a swing."""


def monodromy(stiffness: Array, damping: Array, mass: Array, period: float) -> Array:
    """Compute the monodromy matrix of the variational equation.

    Parameters
    ----------
    stiffness, damping, mass : ndarray, shape (step, n, n)
        Periodic coefficients at the middle of equal steps over one period.
    period
        Period [s].

    Returns
    -------
    ndarray, shape (2 n, 2 n)
        Maps displacement and velocity at the start of a period to those at its end.

    Notes
    -----
    Implicit midpoint rule: second order, stable for any step, without numerical damping. With the
    mean velocity v of a step,

        x1 = x0 + h v,    M (v1 - v0)/h + C v + K (x0 + x1)/2 = 0,    v = (v0 + v1)/2,

    so that  (M + h/2 C + h^2/4 K) v = -h/2 K x0 + M v0.
    """
    steps, n, _ = stiffness.shape
    h = period / steps
    left = mass + 0.5 * h * damping + 0.25 * h * h * stiffness
    mean = np.linalg.solve(left, np.concatenate([-0.5 * h * stiffness, mass], axis=2))
    total = np.concatenate([h * mean, 2.0 * mean], axis=1) + np.diag(np.repeat([1.0, -1.0], n))
    while len(total) > 1:  # products of neighbours: few large operations, not many small ones
        pairs = total[1::2] @ total[: len(total) - 1 : 2]
        total = pairs if len(total) % 2 == 0 else np.concatenate([pairs, total[-1:]])
    return np.asarray(total[0])


@dataclass(frozen=True)
class Multipliers:
    """Floquet multipliers of an orbit over its period.

    Attributes
    ----------
    swing : complex
        Multiplier of the horizontal swing: the largest of the disturbances in which the first
        horizontal mode participates. Beyond -1 the swing grows at half the frequency of the orbit.
    others : ndarray
        All others, largest first, except the one along the orbit, which is 1.
    """

    swing: complex
    others: NDArray[np.complex128]

    @property
    def all(self) -> NDArray[np.complex128]:
        """All multipliers except the one along the orbit."""
        return np.append(self.others, self.swing)


def multipliers(model: ReducedModel, orbit: Orbit, periods_per_orbit: int = 1) -> Multipliers:
    """Compute the Floquet multipliers of an orbit.

    The participation of a mode in a disturbance follows from the right and the left eigenvector
    together (Perez-Arriaga, Verghese, Schweppe 1982). Where the multipliers of two modes meet,
    their right eigenvectors alone are nearly parallel and do not identify the swing.

    Parameters
    ----------
    model
        The reduced span.
    orbit
        The periodic motion.
    periods_per_orbit
        Vertical cycles in the orbit: 2 for a motion with swing.
    """
    n = model.size
    values, vectors = np.linalg.eig(_monodromy(model, orbit, periods_per_orbit))
    along_orbit = int(np.argmin(np.abs(values - 1.0)))
    participation = np.abs(vectors * np.linalg.inv(vectors).T)
    share = participation[[model.horizontal, n + model.horizontal]].sum(axis=0)
    share[along_orbit] = 0.0
    candidates = np.flatnonzero(share > MIN_PARTICIPATION * share.max())
    swing = int(candidates[np.argmax(np.abs(values[candidates]))])
    others = np.delete(values, [along_orbit, swing])
    return Multipliers(complex(values[swing]), others[np.argsort(-np.abs(others))])


def antisymmetric_multiplier(
    model: ReducedModel, orbit: Orbit, periods_per_orbit: int = 1
) -> float:
    """Largest multiplier of antisymmetric disturbances of a symmetric orbit.

    Symmetric and antisymmetric disturbances are uncoupled, so that the antisymmetric block of the
    monodromy matrix has the multipliers of the latter.
    """
    wide = with_antisymmetric_modes(model)
    added = np.zeros((len(orbit.coefficients), wide.size - model.size))
    coefficients = np.concatenate([orbit.coefficients, added], axis=1)
    total = _monodromy(wide, Orbit(orbit.wind_speed, orbit.omega, coefficients), periods_per_orbit)
    antisymmetric = np.r_[model.size : wide.size, wide.size + model.size : 2 * wide.size]
    block = total[np.ix_(antisymmetric, antisymmetric)]
    return float(np.max(np.abs(np.linalg.eigvals(block))))


def _monodromy(model: ReducedModel, orbit: Orbit, periods_per_orbit: int) -> Array:
    """Monodromy matrix of an orbit."""
    instants, steps = PERIOD_INSTANTS * periods_per_orbit, PERIOD_STEPS * periods_per_orbit
    forces = model.forces(*orbit.at(instants), orbit.wind_speed)
    between = _interpolation(instants, steps)
    period = 2.0 * np.pi / orbit.omega
    n = model.size

    def fine(matrix: Array) -> Array:
        return (between @ matrix.reshape(instants, -1)).reshape(steps, n, n)

    return monodromy(fine(forces.stiffness), fine(forces.damping), fine(forces.mass), period)


@lru_cache(maxsize=4)
def _interpolation(instants: int, steps: int) -> Array:
    """Fourier interpolation from the instants of a period to the middle of its steps."""
    harmonics = (instants - 1) // 2
    phase = 2.0 * np.pi * (np.arange(steps) + 0.5) / steps
    return np.asarray(
        fourier(phase, harmonics)[0] @ np.linalg.pinv(fourier_matrices(harmonics, instants).value)
    )


def _odd_coefficients() -> NDArray[np.intp]:
    """Coefficients of the odd harmonics of twice the period, in which the swing starts."""
    number = np.arange(1, 2 * SWING.harmonics + 1)
    return np.asarray(number[(number + 1) // 2 % 2 == 1])


def _flip_matrix(model: ReducedModel, orbit: Orbit) -> Array:
    """Hill's matrix of the disturbances with multiplier -1.

    They have twice the period of the orbit and odd harmonics only; equation (4) of
    `modal.screening.harmonic_balance` restricted to these.
    """
    twice = doubled(orbit, SWING.harmonics)
    forces = model.forces(*twice.at(SWING.instants), orbit.wind_speed)
    odd = _odd_coefficients()
    test = SWING.value[:, odd] * (2.0 / SWING.instants)
    return derivative(SWING, twice.omega, forces, test, odd).reshape(len(odd) * model.size, -1)


def flip_determinant(model: ReducedModel, orbit: Orbit) -> tuple[float, float]:
    """Sign of Hill's determinant, and logarithm of its absolute value.

    The sign changes where a Floquet multiplier passes -1.
    """
    sign, logarithm = np.linalg.slogdet(_flip_matrix(model, orbit))
    return float(sign), float(logarithm)


def flip_shape(model: ReducedModel, orbit: Orbit) -> tuple[Array, float]:
    """Fourier coefficients, over twice the period, of the swing that starts at an orbit.

    Returns
    -------
    ndarray, float
        Coefficients, and the phase [rad] by which orbit and swing are shifted to make the first
        harmonic of the horizontal mode a cosine with coefficient 1.
    """
    odd = _odd_coefficients()
    shape = np.zeros((2 * SWING.harmonics + 1, model.size))
    shape[odd] = np.linalg.svd(_flip_matrix(model, orbit))[2][-1].reshape(len(odd), -1)
    phase = float(np.arctan2(shape[2, model.horizontal], shape[1, model.horizontal]))
    shifted = Orbit(0.0, 1.0, shape).shifted(phase).coefficients
    return np.asarray(shifted / shifted[1, model.horizontal]), phase
