"""Statistics of draws in repeats: probabilities, quantiles, convergence and Sobol shares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from modal.risk.draws import FIRST, REPEATS, SECOND, Draws, exchanged

Array = NDArray[np.float64]

CONFIDENCE = 0.95
"""Confidence of all intervals."""

MIN_DRAWS_BEYOND = 10
"""Minimum number of draws beyond a quantile; with fewer it is not given."""

MIN_ERROR = 1.0 - (1.0 - CONFIDENCE) ** (1.0 / REPEATS)
"""Lower bound of the half width of an interval, in draws of a repeat: 0.31.

Of n stratified draws of one quantity, n p rounded up or down have the event. All repeats may round
alike, although n p differs by up to this number (binomial distribution).
"""

MAX_UNRESOLVED = 0.01
"""Maximum share of unresolved draws for Sobol shares, which need a number for each draw."""


@dataclass(frozen=True)
class Interval:
    """An estimate and its confidence interval."""

    value: float
    lowest: float
    highest: float


def probability(event: Array, draws: Draws) -> Interval:
    """Estimate the probability of an event.

    Parameters
    ----------
    event : (draws,) array
        1 where it occurs, 0 where not, NaN where this is unknown.

    Returns
    -------
    Interval
        The probability among the known draws. The interval includes that of sampling and both
        extremes of the unknown draws: none or all have the event. It is that of Student's t over
        the repeats, at least `MIN_ERROR` draws of a repeat to both sides; if all draws are alike,
        the one-sided interval of a binomial variable.
    """
    known = ~np.isnan(event) & _is_independent(draws)
    if not np.any(known):
        return Interval(np.nan, 0.0, 1.0)
    low, _ = _mean(np.where(np.isnan(event), 0.0, event), draws)
    high, error = _mean(np.where(np.isnan(event), 1.0, event), draws)
    value = float(np.mean(event[known]))
    error = max(error, MIN_ERROR * REPEATS / np.count_nonzero(_is_independent(draws)))
    if value in (0.0, 1.0):
        error = 1.0 - (1.0 - CONFIDENCE) ** (1.0 / np.count_nonzero(known))
    return Interval(value, max(0.0, low - error), min(1.0, high + error))


def quantile(values: Array, share: float, draws: Draws) -> Interval:
    """Estimate the value that a variable exceeds in `1 - share` of all draws.

    The estimate is NaN if fewer than `MIN_DRAWS_BEYOND` known draws are beyond. Unknown values are
    left out. The interval is that of the order statistics of independent draws (binomial), which
    is wide for Sobol points.

    Parameters
    ----------
    values : (draws,) array
        Values; NaN where they are unknown, infinite where they exceed what can be computed.
    share
        Value of the distribution function.
    """
    known = np.sort(values[~np.isnan(values) & _is_independent(draws)])
    count = len(known)
    if count * (1.0 - share) < MIN_DRAWS_BEYOND:
        return Interval(np.nan, np.nan, np.nan)
    tail = 0.5 * (1.0 - CONFIDENCE)
    ends = stats.binom.ppf((tail, 1.0 - tail), count, share)
    lowest, highest = known[np.clip(ends.astype(int), 0, count - 1)]
    return Interval(_between(known, share * count - 0.5), float(lowest), float(highest))


def _between(ordered: Array, rank: float) -> float:
    """Value at a rank, from 0; linear between finite values (Hazen's rule)."""
    k = min(max(int(rank), 0), len(ordered) - 2)
    low, high = float(ordered[k]), float(ordered[k + 1])
    share = min(max(rank - k, 0.0), 1.0)
    if np.isfinite(high):
        return low + share * (high - low)
    return high if share >= 0.5 else low


def convergence(event: Array, draws: Draws) -> dict[int, Interval]:
    """Estimate a probability from the first 2^k draws of each repeat, by the number of draws."""
    found = {}
    order = np.zeros(len(event), dtype=np.int64)
    for repeat in range(REPEATS):
        order[draws.repeat == repeat] = np.arange(np.count_nonzero(draws.repeat == repeat))
    each = int(np.count_nonzero(_is_independent(draws))) // REPEATS
    if SECOND in draws.matrix:
        each //= 2  # B stands behind A
    size = 2
    while size <= each:
        first = order < size
        part = Draws(
            draws.points[first],
            draws.repeat[first],
            [name for name, is_used in zip(draws.matrix, first, strict=True) if is_used],
        )
        found[size * REPEATS] = probability(event[first], part)
        size *= 2
    return found


def sobol_shares(values: Array, draws: Draws) -> tuple[list[Interval], list[Interval]] | None:
    """Estimate the first-order and total Sobol shares of a variable, for each quantity.

    Returns
    -------
    tuple of list of Interval, or None
        First-order and total shares. None without the draws for them, if more than
        `MAX_UNRESOLVED` of the values are unknown or infinite, or if the variable is constant.

    Notes
    -----
    `scipy.stats.sobol_indices` (Saltelli et al. 2010) for each repeat; mean over the repeats, and
    interval of Student's t.
    """
    is_known = np.isfinite(values)
    if SECOND not in draws.matrix or np.mean(~is_known) > MAX_UNRESOLVED:
        return None
    filled = np.where(is_known, values, np.mean(values[is_known]))
    if np.ptp(filled) == 0.0:
        return None
    names = np.array(draws.matrix)
    count = draws.points.shape[1]
    first, total = np.empty((REPEATS, count)), np.empty((REPEATS, count))
    for repeat in range(REPEATS):
        of = {name: filled[(draws.repeat == repeat) & (names == name)] for name in set(names)}
        mixed = np.array([of[exchanged(k)] for k in range(count)])[:, None, :]
        if np.ptp(np.concatenate([of[FIRST], of[SECOND]])) == 0.0:
            return None
        shares = stats.sobol_indices(
            func={"f_A": of[FIRST][None], "f_B": of[SECOND][None], "f_AB": mixed},
            n=len(of[FIRST]),
        )
        first[repeat], total[repeat] = shares.first_order.ravel(), shares.total_order.ravel()
    return _of_columns(first), _of_columns(total)


def _of_columns(values: Array) -> list[Interval]:
    return [
        Interval(mean, mean - error, mean + error) for mean, error in map(_of_repeats, values.T)
    ]


def _mean(values: Array, draws: Draws) -> tuple[float, float]:
    """Mean of independent draws, and half width of its confidence interval."""
    used = _is_independent(draws)
    return _of_repeats(
        np.array([np.mean(values[used & (draws.repeat == k)]) for k in range(REPEATS)])
    )


def _of_repeats(values: Array) -> tuple[float, float]:
    """Mean of the repeats, and half width of its confidence interval."""
    factor = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, REPEATS - 1))
    return float(np.mean(values)), factor * float(np.std(values, ddof=1)) / REPEATS**0.5


def _is_independent(draws: Draws) -> NDArray[np.bool_]:
    return np.isin(draws.matrix, (FIRST, SECOND))
