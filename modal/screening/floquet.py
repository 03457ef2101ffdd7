"""Stability of periodic motions: Floquet multipliers from the variational equation along the orbit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from modal.screening.harmonic_balance import (
    SWING,
    Orbit,
    derivative,
    doubled,
    fourier,
    fourier_matrices,
)
from modal.screening.reduced_model import ReducedModel, lopsided_model

Array = NDArray[np.float64]

INSTANTS = 22
"""Instants of one period at which the coefficients of the variational equation are computed."""

STEPS = 64
"""Implicit steps of one period; the coefficients between the instants follow from their spectrum."""


def monodromy(stiffness: Array, damping: Array, mass: Array, period: float) -> Array:
    """What one period makes of a small disturbance (displacement, velocity).

    Parameters
    ----------
    stiffness, damping, mass : ndarray, shape (step, n, n)
        Periodic coefficients at the middle of equal steps over one period.
    period
        Period [s].

    Returns
    -------
    ndarray, shape (2 n, 2 n)
        Its eigenvalues are the Floquet multipliers.

    Notes
    -----
    Cayley form of the implicit midpoint rule: second order, stable for any step, no artificial
    damping.
    """
    steps, n, _ = stiffness.shape
    h = period / steps
    # midpoint rule: x1 = x0 + h v, with v the mean velocity; M (v1 - v0)/h + C v + K (x0 + x1)/2 =
    # 0
    left = mass + 0.5 * h * damping + 0.25 * h * h * stiffness
    mean = np.linalg.solve(left, np.concatenate([-0.5 * h * stiffness, mass], axis=2))
    total = np.concatenate([h * mean, 2.0 * mean], axis=1) + np.diag(np.repeat([1.0, -1.0], n))
    while len(total) > 1:  # neighbours first: few large products instead of many small ones
        pairs = total[1::2] @ total[: len(total) - 1 : 2]
        total = pairs if len(total) % 2 == 0 else np.concatenate([pairs, total[-1:]])
    return np.asarray(total[0])


LEAST_SHARE = 0.2
"""Participation of the first horizontal mode in a disturbance, relative to the largest, from which it is a swing."""


@dataclass(frozen=True)
class Multipliers:
    """Floquet multipliers of an orbit over one period of it.

    Attributes
    ----------
    swing : complex
        The multiplier of the horizontal swing: the largest of the disturbances in which the first
        horizontal mode participates. Beyond -1 the swing grows at half the frequency of the orbit.
    others : ndarray
        All others, without the one along the orbit, which is 1; largest first.
    """

    swing: complex
    others: NDArray[np.complex128]

    @property
    def all(self) -> NDArray[np.complex128]:
        """All but the one along the orbit."""
        return np.append(self.others, self.swing)


def multipliers(model: ReducedModel, orbit: Orbit, periods_per_orbit: int = 1) -> Multipliers:
    """Floquet multipliers of an orbit; of one that swings, over the two vertical cycles of it.

    How much a mode participates in a disturbance tell right and left vector together
    (Perez-Arriaga, Verghese, Schweppe 1982). Where multipliers of two modes meet, the right vectors
    alone look alike and hide the swing.
    """
    n = model.size
    values, vectors = np.linalg.eig(_monodromy(model, orbit, periods_per_orbit))
    trivial = int(np.argmin(np.abs(values - 1.0)))
    share = np.abs(vectors * np.linalg.inv(vectors).T)[
        [model.horizontal, n + model.horizontal]
    ].sum(axis=0)
    share[trivial] = 0.0
    candidates = np.flatnonzero(share > LEAST_SHARE * share.max())
    swing = int(candidates[np.argmax(np.abs(values[candidates]))])
    rest = np.delete(values, [trivial, swing])
    return Multipliers(complex(values[swing]), rest[np.argsort(-np.abs(rest))])


def lopsided_multiplier(model: ReducedModel, orbit: Orbit, periods_per_orbit: int = 1) -> float:
    """Largest growth over one period of what breaks the mirror symmetry of a span and its motion."""
    wide = lopsided_model(model)
    rest = np.zeros((len(orbit.coefficients), wide.size - model.size))
    embedded = Orbit(
        orbit.wind_speed, orbit.omega, np.concatenate([orbit.coefficients, rest], axis=1)
    )
    total = _monodromy(wide, embedded, periods_per_orbit)
    breaking = np.r_[model.size : wide.size, wide.size + model.size : 2 * wide.size]
    return float(np.max(np.abs(np.linalg.eigvals(total[np.ix_(breaking, breaking)]))))


def _monodromy(model: ReducedModel, orbit: Orbit, periods_per_orbit: int) -> Array:
    instants, steps = INSTANTS * periods_per_orbit, STEPS * periods_per_orbit
    forces = model.forces(*orbit.at(instants), orbit.wind_speed)
    between = _interpolation(instants, steps)
    period = 2.0 * np.pi / orbit.omega
    n = model.size

    def fine(matrix: Array) -> Array:
        return (between @ matrix.reshape(instants, -1)).reshape(steps, n, n)

    return monodromy(fine(forces.stiffness), fine(forces.damping), fine(forces.mass), period)


@lru_cache(maxsize=4)
def _interpolation(instants: int, steps: int) -> Array:
    """From values at the instants of a period to those at the middle of its steps, by their spectrum."""
    harmonics = (instants - 1) // 2
    phase = 2.0 * np.pi * (np.arange(steps) + 0.5) / steps
    return np.asarray(
        fourier(phase, harmonics)[0] @ np.linalg.pinv(fourier_matrices(harmonics, instants).value)
    )


def _odd() -> NDArray[np.intp]:
    """Coefficients of the odd harmonics of twice the period: those in which the swing starts."""
    number = np.arange(1, 2 * SWING.harmonics + 1)
    return np.asarray(number[(number + 1) // 2 % 2 == 1])


def _flip_matrix(model: ReducedModel, orbit: Orbit) -> Array:
    """Hill's matrix of disturbances of twice the period that change sign after one."""
    twice = doubled(orbit, SWING.harmonics)
    forces = model.forces(*twice.at(SWING.instants), orbit.wind_speed)
    odd = _odd()
    test = SWING.value[:, odd] * (2.0 / SWING.instants)
    return derivative(SWING, twice.omega, forces, test, odd).reshape(len(odd) * model.size, -1)


def flip_determinant(model: ReducedModel, orbit: Orbit) -> tuple[float, float]:
    """Sign of Hill's determinant, which changes where a Floquet multiplier passes -1, and the logarithm of its size."""
    sign, logarithm = np.linalg.slogdet(_flip_matrix(model, orbit))
    return float(sign), float(logarithm)


def flip_shape(model: ReducedModel, orbit: Orbit) -> tuple[Array, float]:
    """Fourier coefficients, over twice the period, of the swing that starts at an orbit, and their phase [rad] in it.

    The horizontal mode's first harmonic is cos, with coefficient 1, once orbit and swing are turned
    by the phase.
    """
    odd = _odd()
    shape = np.zeros((2 * SWING.harmonics + 1, model.size))
    shape[odd] = np.linalg.svd(_flip_matrix(model, orbit))[2][-1].reshape(len(odd), -1)
    phase = float(np.arctan2(shape[2, model.horizontal], shape[1, model.horizontal]))
    turned = Orbit(0.0, 1.0, shape).turned(phase).coefficients
    return np.asarray(turned / turned[1, model.horizontal]), phase
