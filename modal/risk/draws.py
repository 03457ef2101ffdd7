"""Draws of random quantities: points in the unit cube, in independent repeats.

Each repeat is a Sobol sequence or a Latin hypercube with its own randomisation. The spread of the
repeats gives confidence intervals, which one such set of points cannot (Owen, *Monte Carlo Theory,
Methods and Examples*, chapter 17).

For Sobol shares a repeat has the matrices A, B and, for each quantity i, A with the column i of B
(Saltelli et al. 2010, *Computer Physics Communications* 181, 259-270).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from gallop_fmu import SceneError

Array = NDArray[np.float64]
Sampling = Literal["sobol", "latin_hypercube"]
SAMPLINGS = ("sobol", "latin_hypercube")

REPEATS = 8
"""Independent repeats; the confidence interval has one degree of freedom less."""

MIN_DRAWS_OF_REPEAT = 4
"""Minimum number of draws of a repeat."""

SMALLEST_SHARE = 1e-12
"""Distance of all points from 0 and 1, where distributions may be infinite."""

FIRST, SECOND = "A", "B"
"""Matrices of independent draws; others are named after the quantity that they exchange."""


@dataclass(frozen=True)
class Draws:
    """Points in the unit cube.

    Attributes
    ----------
    points : (draws, quantities) array
        Shares of the distribution functions, in (0, 1).
    repeat : (draws,) int array
        Number of the repeat, from 0.
    matrix : list of str
        ``"A"`` or ``"B"`` for independent draws; ``"A1"``, ``"A2"``, ... for A with the column of
        that quantity from B.
    """

    points: Array
    repeat: NDArray[np.int64]
    matrix: list[str]


def draw(
    quantities: int, count: int, seed: int, sampling: Sampling = "sobol", *, shares: bool = False
) -> Draws:
    """Draw points.

    Parameters
    ----------
    quantities
        Number of random quantities.
    count
        Number of independent draws; a power of two, at least `REPEATS * MIN_DRAWS_OF_REPEAT`.
    seed
        Seed of the randomisation.
    sampling
        ``"sobol"`` or ``"latin_hypercube"``.
    shares
        True adds the matrices for Sobol shares: ``count / 2`` draws for each quantity.

    Raises
    ------
    SceneError
        An argument is not allowed.
    """
    least = REPEATS * MIN_DRAWS_OF_REPEAT * (2 if shares else 1)
    if count < least or count & (count - 1):
        raise SceneError(f"draws = {count}: must be a power of two, at least {least}")
    if sampling not in SAMPLINGS:
        raise SceneError(f"sampling = {sampling!r}: must be {' or '.join(SAMPLINGS)}")
    each, width = count // REPEATS, quantities
    if shares:
        each, width = each // 2, 2 * quantities
    points, repeat, matrix = [], [], []
    for number, source in enumerate(np.random.SeedSequence(seed).spawn(REPEATS)):
        generator = np.random.default_rng(source)
        if sampling == "sobol":
            unit = qmc.Sobol(width, scramble=True, seed=generator).random(each)
        else:
            unit = qmc.LatinHypercube(width, seed=generator).random(each)
        unit = np.clip(unit, SMALLEST_SHARE, 1.0 - SMALLEST_SHARE)
        first = unit[:, :quantities]
        parts = {FIRST: first}
        if shares:
            second = unit[:, quantities:]
            parts[SECOND] = second
            for k in range(quantities):
                mixed = first.copy()
                mixed[:, k] = second[:, k]
                parts[exchanged(k)] = mixed
        for name, part in parts.items():
            points.append(part)
            repeat += [number] * each
            matrix += [name] * each
    return Draws(np.concatenate(points), np.array(repeat, dtype=np.int64), matrix)


def exchanged(quantity: int) -> str:
    """Return the name of A with the column of a quantity (from 0) from B."""
    return f"{FIRST}{quantity + 1}"
