"""Numbers of recorded histories, computed by the kernel: size, frequency, change of the cycles."""

from __future__ import annotations

import ctypes as c
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.library import address, kernel
from gallop_fmu.engine.state import insist

Array = NDArray[np.float64]


class HistoryNumbers(NamedTuple):
    """Numbers of a history, in the order of gallop_history_number (gallop_history.h).

    Attributes
    ----------
    lowest, highest, mean, deviation : float
        Extremes, mean and standard deviation; NaN if a value is not a number.
    frequency : float
        Largest spectral line [cycles a sample]; NaN without one.
    blocks, spacing : float
        Number of blocks of the envelope, and from one to the next over the length of the window;
        without enough cycles there are 0 blocks, and the following numbers are NaN.
    log_1, log_2, log_3 : float
        Mean logarithm of the envelope over each third of the blocks.
    trend : float
        Share of the variance of these logarithms that a parabola explains.
    range : float
        Least range of the envelope over its mean, of blocks of one to four cycles.
    fall : float
        1 - smallest / largest value of the envelope of single cycles.
    hidden_1, hidden_2, hidden_3 : float
        Part that does not repeat from cycle to cycle, over the amplitude, in each third.
    half_1, half_2 : float
        Half of the range in each half of the window, over the amplitude.
    """

    lowest: float
    highest: float
    mean: float
    deviation: float
    frequency: float
    blocks: float
    spacing: float
    log_1: float
    log_2: float
    log_3: float
    trend: float
    range: float
    fall: float
    hidden_1: float
    hidden_2: float
    hidden_3: float
    half_1: float
    half_2: float

    def frequency_hz(self, interval: float) -> float:
        """Return the largest spectral line [Hz] of samples `interval` [s] apart, or `math.nan`."""
        return math.nan if math.isnan(self.frequency) else self.frequency / interval


def history_numbers(
    values: Sequence[Array] | Array, even: float = math.nan
) -> list[HistoryNumbers]:
    """Return the numbers of histories of equal length, one or more.

    Parameters
    ----------
    values : array_like, shape (history, time)
        Equally spaced samples.
    even
        Range of the envelope over its mean for which longer blocks are not tried; NaN: the numbers
        from ``blocks`` on are not computed.
    """
    given = np.asarray(values, dtype=np.float64, order="C")
    histories, samples = given.shape
    work, numbers = _work(samples), np.empty((histories, len(HistoryNumbers._fields)))
    insist(
        kernel.gallop_history_numbers(
            samples, histories, address(given), even, address(work), address(numbers)
        )
    )
    return [HistoryNumbers(*row) for row in numbers.tolist()]


def history_sizes(values: Sequence[Array] | Array) -> Array:
    """Return the size of each history: lowest and highest value, mean, standard deviation.

    All four are NaN if a value is not a number.

    Parameters
    ----------
    values : array_like, shape (history, time)
        Histories of equal length, one or more.

    Returns
    -------
    ndarray, shape (history, 4)
    """
    given = np.asarray(values, dtype=np.float64, order="C")
    histories, samples = given.shape
    found = np.empty((histories, 4))
    insist(kernel.gallop_history_sizes(samples, histories, address(given), address(found)))
    return found


def energy_line(spectra: NDArray[np.complex128], share: float) -> int:
    """Return the highest line above which, itself included, a share of the kinetic energy lies.

    Parameters
    ----------
    spectra : ndarray, shape (history, line)
        Spectra of displacements.
    share
        Share of the energy; that of a line is the square of its value times its number.
    """
    given = np.asarray(spectra, order="C")
    histories, lines = given.shape
    return int(kernel.gallop_history_energy_line(lines, histories, address(given), share))


def ellipse_distances(x: Array, y: Array, ellipse: tuple[float, ...]) -> Array:
    """Return the distances [m] of points from an ellipse, negative inside.

    Parameters
    ----------
    x, y : ndarray
        Coordinates [m], of equal shape.
    ellipse
        Centre x, y, half axes [m], major first, and cosine and sine of its rotation.
    """
    across, up = (np.asarray(part, dtype=np.float64, order="C") for part in (x, y))
    numbers, found = np.array(ellipse), np.empty(across.shape)
    insist(
        kernel.gallop_history_distances(
            across.size, *(address(part) for part in (across, up, numbers, found))
        )
    )
    return found


def beat_share(values: Array, numbers: HistoryNumbers) -> float:
    """Return the share of the envelope's variance that a spectral line and its double explain.

    Parameters
    ----------
    values : ndarray, shape (time,)
        A history with blocks.
    numbers
        Its numbers.
    """
    given, found = np.asarray(values, dtype=np.float64, order="C"), np.array(numbers)
    work, share = _work(len(given)), c.c_double()
    insist(
        kernel.gallop_history_beats(
            len(given), address(given), address(found), address(work), c.byref(share)
        )
    )
    return share.value


def _work(samples: int) -> NDArray[np.uint8]:
    return np.empty(kernel.gallop_history_size(samples), dtype=np.uint8)
