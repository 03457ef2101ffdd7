"""Verdict of a screening: `judge` draws it from a branch of limit cycles, `explain` words it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Literal

import numpy as np

from modal.screening.beating import beating_cycle
from modal.screening.continuation import Cycle, LimitCycles, cycle_of
from modal.screening.floquet import multipliers
from modal.screening.harmonic_balance import NotConvergedError, Orbit
from modal.screening.swing_branch import antisymmetric_growth, stability_limits, swing_branch
from modal.stability.frequency_ratio import FrequencyRatio

Risk = Literal["none", "other", "detuned", "possible", "certain", "undetermined"]

MIN_REPORTED_GROWTH = 1.002
"""Growth per cycle above which an antisymmetric disturbance is reported: tenfold in 30 min."""


class Verdict(Enum):
    """Conclusion of a screening for the scene's wind."""

    NO_GALLOPING = "no galloping in the first symmetric vertical mode"
    NO_ONSET = "galloping without an onset of the swing"
    NO_SWING = "an onset of the swing, but not at the scene's wind"
    SWING = "galloping starts the swing"
    NO_CYCLE = "no limit cycle at the scene's wind"
    BROKEN_BRANCH = "no limit cycle between two computed ones"


RISKS: dict[Verdict, Risk] = {
    Verdict.NO_GALLOPING: "none",
    Verdict.NO_ONSET: "detuned",
    Verdict.NO_SWING: "possible",
    Verdict.SWING: "certain",
    Verdict.NO_CYCLE: "undetermined",
    Verdict.BROKEN_BRANCH: "undetermined",
}


@dataclass(frozen=True)
class Judgement:
    """A verdict with the data behind it.

    Attributes
    ----------
    verdict : Verdict
        The verdict.
    frequencies : FrequencyRatio
        Natural frequencies of the pair.
    wind_speed, highest_wind : float
        The scene's wind and the end of the search [m/s].
    galloping_from, galloping_until : float or None
        Wind speeds [m/s] between which galloping exists.
    limit_cycle : tuple of Cycle
        Galloping without swing over the wind speed.
    end_reason : str or None
        Reason why `limit_cycle` ends below the highest wind.
    is_unresolved : bool
        True if it ends because no motion stays near it.
    galloping : Cycle or None
        Galloping without swing at the scene's wind.
    onset : Cycle or None
        Galloping where the swing starts.
    until_wind_speed : float or None
        Wind speed [m/s] at which the swing no longer starts.
    saturated : Cycle or None
        Galloping with swing at the scene's wind.
    antisymmetric_growth : float or None
        Growth of an antisymmetric disturbance of that motion in one vertical cycle.
    """

    verdict: Verdict
    frequencies: FrequencyRatio
    wind_speed: float
    highest_wind: float
    galloping_from: float | None
    galloping_until: float | None
    limit_cycle: tuple[Cycle, ...]
    end_reason: str | None
    is_unresolved: bool
    galloping: Cycle | None = None
    onset: Cycle | None = None
    until_wind_speed: float | None = None
    saturated: Cycle | None = None
    antisymmetric_growth: float | None = None

    @property
    def risk(self) -> Risk:
        """The risk that follows from the verdict."""
        return RISKS[self.verdict]

    @property
    def has_ended(self) -> bool:
        """True if galloping has ended below the scene's wind."""
        return self.galloping_until is not None and self.wind_speed > self.galloping_until


def judge(branch: LimitCycles, frequencies: FrequencyRatio) -> Judgement:
    """Draw the verdict from the branch of limit cycles without swing.

    Parameters
    ----------
    branch
        Limit cycles from the onset of galloping to the highest wind.
    frequencies
        Natural frequencies of the pair.
    """
    known = Judgement(
        verdict=Verdict.NO_GALLOPING,
        frequencies=frequencies,
        wind_speed=branch.wind,
        highest_wind=branch.highest,
        galloping_from=branch.galloping_from,
        galloping_until=branch.galloping_until,
        limit_cycle=branch.table(),
        end_reason=branch.end_reason,
        is_unresolved=branch.is_unresolved,
    )
    if known.galloping_from is None:
        return known
    try:
        return _judge_galloping(branch, known)
    except NotConvergedError:
        return replace(known, verdict=Verdict.BROKEN_BRANCH)


def _judge_galloping(branch: LimitCycles, known: Judgement) -> Judgement:
    """Judge a span that gallops: limit cycle at the scene's wind, onset of the swing, swing.

    Raises
    ------
    NotConvergedError
        If Newton's iteration fails between two orbits of the branch.
    """
    galloping, onset, known = _with_onset(branch, known)
    expected = known.galloping_from is not None and known.wind_speed > known.galloping_from
    if galloping is None and expected and not known.has_ended:
        return replace(known, verdict=Verdict.NO_CYCLE)
    if onset is None:
        return replace(known, verdict=Verdict.NO_ONSET)
    settled, known = _with_swing(branch, onset, known)
    if known.galloping is None or known.galloping.multiplier <= 1.0:
        return replace(known, verdict=Verdict.NO_SWING)
    growth = None if settled is None else antisymmetric_growth(branch.model, settled, 2)
    return replace(known, verdict=Verdict.SWING, antisymmetric_growth=growth)


def _with_onset(
    branch: LimitCycles, known: Judgement
) -> tuple[Orbit | None, Orbit | None, Judgement]:
    """Find the limit cycle at the scene's wind, and the first orbit at which the swing starts."""
    at_wind = branch.galloping()
    if at_wind is not None:
        orbit, growth = at_wind
        known = replace(known, galloping=cycle_of(branch.model, orbit, abs(growth.swing)))
    limits = stability_limits(branch)
    onset = next((orbit for orbit, starts in limits if starts), None)
    if onset is not None:
        until = next((orbit.wind_speed for orbit, starts in limits if not starts), None)
        known = replace(known, onset=cycle_of(branch.model, onset, 1.0), until_wind_speed=until)
    return (None if at_wind is None else at_wind[0]), onset, known


def _with_swing(
    branch: LimitCycles, onset: Orbit, known: Judgement
) -> tuple[Orbit | None, Judgement]:
    """Follow the motions with swing from their onset to the scene's wind."""
    orbits, track = swing_branch(branch.model, onset, branch.wind)
    settled = track.first_at(orbits, branch.wind)
    if settled is None:
        return None, known
    # the multipliers are over two vertical cycles
    slowest = float(np.sqrt(np.max(np.abs(multipliers(branch.model, settled, 2).all))))
    saturated = cycle_of(branch.model, settled, slowest, 2)
    if slowest > 1.0:
        saturated = beating_cycle(branch.model.scene, branch.wind, saturated)
    return settled, replace(known, saturated=saturated)


def explain(judged: Judgement) -> str:
    """Word a judgement as one sentence."""
    return SENTENCES[judged.verdict](judged)


def _no_galloping(judged: Judgement) -> str:
    remark = f"; {judged.end_reason}" if judged.end_reason else ""
    return (
        "the first symmetric vertical mode does not gallop up to"
        f" {judged.highest_wind:.4g} m/s{remark}"
    )


def _no_onset(judged: Judgement) -> str:
    if judged.galloping is not None:
        gallops = (
            f"galloping at the scene's {_wind(judged)} has an amplitude of"
            f" {judged.galloping.vertical:.3g} m"
        )
    else:
        gallops = f"galloping begins at {judged.galloping_from:.4g} m/s"
        if judged.has_ended:
            gallops += (
                f", ends at {judged.galloping_until:.4g} m/s, below the scene's"
                f" {judged.wind_speed:.4g} m/s,"
            )
    caveat = f" ({judged.end_reason})" if judged.end_reason else ""
    last = judged.limit_cycle[-1].wind_speed
    return f"{_tuning(judged)}: {gallops} and starts no swing up to {last:.4g} m/s{caveat}"


def _no_swing(judged: Judgement) -> str:
    end = other = ""
    if judged.until_wind_speed is not None:
        end = f" and no longer from {judged.until_wind_speed:.4g} m/s on"
    if judged.saturated is not None:
        other = (
            f", where a swing of {judged.saturated.horizontal:.3g} m is possible after a strong"
            " disturbance"
        )
    return f"{_tuning(judged)}{_onset(judged)}{end}, but not at the scene's {_wind(judged)}{other}"


def _swing(judged: Judgement) -> str:
    assert judged.galloping is not None
    outcome = "no steady motion with swing was found"
    if judged.saturated is not None:
        ends = "beats, up to" if judged.saturated.multiplier > 1.0 else "settles at"
        outcome = (
            f"the motion {ends} {judged.saturated.vertical:.3g} m vertical and"
            f" {judged.saturated.horizontal:.3g} m horizontal"
        )
    growth = judged.antisymmetric_growth
    if growth is not None and growth > MIN_REPORTED_GROWTH:
        outcome += f"; an antisymmetric disturbance of it grows by {growth - 1.0:.1%} per cycle"
    return (
        f"{_tuning(judged)}{_onset(judged)}; at {_wind(judged)} galloping alone would reach"
        f" {judged.galloping.vertical:.3g} m, a small swing grows by"
        f" {judged.galloping.multiplier - 1.0:.1%} per cycle, and {outcome}"
    )


def _no_cycle(judged: Judgement) -> str:
    missing = judged.end_reason
    if not judged.is_unresolved:
        missing = (
            f"no periodic motion was found at {_wind(judged)}"
            f" ({judged.end_reason or 'no branch reaches it'})"
        )
    return f"{_tuning(judged)}{_onset(judged)}, but {missing}; {_remedy(judged)}"


def _broken_branch(judged: Judgement) -> str:
    return (
        f"{_tuning(judged)}, but the limit cycle is unresolved: no periodic motion was found"
        f" between two computed ones; {_remedy(judged)}"
    )


SENTENCES: dict[Verdict, Callable[[Judgement], str]] = {
    Verdict.NO_GALLOPING: _no_galloping,
    Verdict.NO_ONSET: _no_onset,
    Verdict.NO_SWING: _no_swing,
    Verdict.SWING: _swing,
    Verdict.NO_CYCLE: _no_cycle,
    Verdict.BROKEN_BRANCH: _broken_branch,
}


def _tuning(judged: Judgement) -> str:
    pair = judged.frequencies
    side = "above" if pair.detuning > 0.0 else "below"
    return f"frequency ratio {pair.ratio:.3f}, {abs(pair.detuning):.1%} {side} 2:1"


def _onset(judged: Judgement) -> str:
    if judged.onset is None:
        return ""
    return (
        f": galloping starts the swing at {judged.onset.wind_speed:.4g} m/s, where its vertical"
        f" amplitude passes {judged.onset.vertical:.3g} m"
    )


def _wind(judged: Judgement) -> str:
    return f"{judged.wind_speed:.4g} m/s"


def _remedy(judged: Judgement) -> str:
    return f"run a simulation at the scene's {_wind(judged)}"
