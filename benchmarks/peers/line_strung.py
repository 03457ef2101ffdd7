"""The strung state of a span: equal straight bars between two points at a horizontal tension."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Strung:
    """Nodes (2, elements + 1) from the left end, rest length [m] of a bar.

    `left`, `right`: vertical forces [N] on the supports (down positive), half a bar included.
    """

    position: Array
    rest: float
    left: float
    right: float


def hang(
    length: float, rise: float, tension: float, weight: float, stiffness: float, elements: int
) -> Strung:
    """Equilibrium; `weight` [N] is per metre of rest length, `stiffness` EA [N]."""
    n = elements

    def bars(unknown: Array) -> tuple[Array, float, Array]:
        rest, first = unknown * scale
        vertical = first + weight * rest * np.arange(n)
        pull = np.hypot(tension, vertical)
        stretched = rest * (1.0 + pull / stiffness)
        return np.array([stretched * tension, stretched * vertical]) / pull, rest, vertical

    def gap(unknown: Array) -> Array:
        d = bars(unknown)[0].sum(axis=1)
        return np.array([d[0] - length, d[1] - rise]) / length

    chord = float(np.hypot(length, rise))
    scale = np.array([chord / n, tension])
    start = np.array([1.0, rise / length - 0.5 * weight * chord / tension])
    found = root(gap, start, tol=1e-15)
    assert np.abs(gap(found.x)).max() < 1e-13, found.message
    steps, rest, vertical = bars(found.x)
    position = np.concatenate([np.zeros((2, 1)), np.cumsum(steps, axis=1)], axis=1)
    half = 0.5 * weight * rest
    return Strung(position, float(rest), float(half - vertical[0]), float(half + vertical[-1]))
