"""Families of periodic motions over the wind speed, by pseudo-arclength continuation.

The position of an orbit is measured along the family and not by the wind speed, so that a family
may start at an equilibrium and pass folds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modal.motions.reduced_model import ReducedModel
from modal.screening.harmonic_balance import (
    NEWTON_ITERATIONS,
    Balance,
    NotConvergedError,
    Orbit,
    solve,
)

Array = NDArray[np.float64]

STEP_ITERATIONS = 6
"""Largest number of Newton iterations in a step along a family."""

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

            y_n+1 = y_n + s (t_n + s/2 (t_n - t_n-1) / s_n-1).

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
