"""Half-waves of a displacement along a span."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIN_DISPLACEMENT = 1e-3
"""Displacement, relative to the largest one, above which it counts for the number of half-waves."""


def signs_along(wave: Array) -> Array:
    """Signs (-1 or 1) of a displacement along the span; points almost at zero are left out.

    A point is left out if its displacement is at most `MIN_DISPLACEMENT` times the largest one.
    """
    return np.asarray(np.sign(wave[np.abs(wave) > MIN_DISPLACEMENT * np.max(np.abs(wave))]))


def half_waves(wave: Array) -> int:
    """Number of half-waves of a displacement along the span."""
    return 1 + int(np.count_nonzero(np.diff(signs_along(wave))))
