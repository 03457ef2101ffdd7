"""Test if the amplitudes of an irregular motion still change, or only scatter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLOCKS, MIN_TREND = 6, 3.0
"""Number of blocks in each half whose mean amplitudes show the scatter, and standard errors above
which the means of both halves differ."""

UNDONE = 0.3
"""Part of a change that is undone, above which it is no trend."""

MIN_STEP = 0.005
"""Relative change below which there is no trend."""

MIN_WINDOWS = 4 * BLOCKS
"""Number of windows below which a trend is not distinguished from scatter."""

LARGE, MIN_TREND_OF_MANY = 0.1, 4.0
"""Amplitude, relative to the largest, from which one of many histories counts, and the number of
standard errors for each of them."""


def has_trend(sizes: Array, least: float = MIN_TREND) -> bool:
    """True if the mean amplitudes of both halves of a history differ by more than their scatter.

    The largest amplitude of an irregular motion differs in any two halves, its mean does not. The
    standard error follows from the means of blocks of windows, in the half that varies less, since
    a motion that still changes varies most where it does. A change from the first to the second
    third that is partly undone in the third is no trend.

    Parameters
    ----------
    sizes : ndarray, shape (window,)
        Amplitudes in equal windows of time.
    least
        Least number of standard errors.
    """
    first, second = np.diff([third.mean() for third in np.array_split(sizes, 3)]).tolist()
    one, other = sorted((abs(first), abs(second)))
    if first * second < 0.0 and one > UNDONE * other:
        return False
    halves = [np.array_split(half, BLOCKS) for half in np.array_split(sizes, 2)]
    means = np.array([[block.mean() for block in half] for half in halves])
    error = float(np.sqrt(2.0 * means.var(axis=1, ddof=1).min() / BLOCKS))
    change = abs(float(np.diff(means.mean(axis=1))[0]))
    return change > max(least * error, MIN_STEP * float(means.mean()))


def have_trend(sizes: Array, largest: float) -> bool:
    """True if one of many histories of amplitudes has a trend.

    Parameters
    ----------
    sizes : ndarray, shape (window, place)
        Amplitudes in equal windows of time.
    largest
        Largest amplitude of the motion; places with less than a tenth of it do not count.
    """
    large = sizes[:, sizes.max(axis=0) > LARGE * largest]
    return any(has_trend(one, MIN_TREND_OF_MANY) for one in large.T)
