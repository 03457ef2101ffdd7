"""Verdict of a screening: the risk of a swing, and its reason as a sentence."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from modal.continuation.branch import Branch
from modal.continuation.events import Event
from modal.continuation.path import Point
from modal.motions.motion_words import name_of_motion
from modal.motions.table import event_sentence
from modal.screening.cycles import Cycle, StableState, Transfer
from modal.screening.multipliers import (
    antisymmetric_multiplier,
    disturbances,
    name_of_disturbance,
    starts_swing,
)
from modal.screening.other_modes import OtherMode, first_pair, other_mode
from modal.screening.settled import Settled, amplitudes, settled_states, vertical_frequency
from modal.screening.span_diagram import CRITICAL_LEVEL, SpanDiagram
from modal.stability.frequency_ratio import FrequencyRatio

Risk = Literal["none", "other", "detuned", "possible", "certain", "turns over", "undetermined"]

RISK_OF = "risk of a 2:1 swing or of turning over"
"""Title of a risk in all output."""

MIN_TRANSFER = 1e-5
"""Growth rate [1/s] of a disturbance above which it is reported: tenfold in 64 h."""


@dataclass(frozen=True)
class Judgement:
    """What a screening found.

    Attributes are those of `modal.screening.screen.Screening`.
    """

    risk: Risk
    reason: str
    galloping_from: float | None
    galloping_until: float | None
    limit_cycle: tuple[Cycle, ...]
    galloping: Cycle | None
    onset: Cycle | None
    until_wind_speed: float | None
    saturated: Cycle | None
    antisymmetric_growth: float | None
    other_mode: OtherMode | None
    divergence_from: float | None
    states: tuple[StableState, ...]
    transfers: tuple[Transfer, ...]
    unresolved: tuple[str, ...]


def with_turning(
    risk: Risk, divergence: float | None, states_turned: Iterable[bool], rest_is_unstable: bool
) -> Risk:
    """Risk of a swing, or that of turning over if no swing starts.

    Parameters
    ----------
    risk
        Risk of a swing.
    divergence
        Wind speed [m/s] from which rest is statically unstable; None: it is not.
    states_turned
        For each stable state in the wind, True if it is turned over.
    rest_is_unstable
        True if a disturbance of rest grows in the wind: it can lead to any of the states.
    """
    turns = divergence is not None or (rest_is_unstable and any(states_turned))
    return "turns over" if turns and risk in ("none", "other", "detuned") else risk


@dataclass(frozen=True)
class _Pair:
    """Galloping in the first symmetric vertical mode: its branch and events."""

    begin: Event
    branch: Branch | None
    starts: tuple[Event, ...]
    """Period doublings, at which a swing starts or no longer starts."""


def judge(diagram: SpanDiagram, frequencies: FrequencyRatio) -> Judgement:
    """Draw the verdict from all motions of a span.

    Parameters
    ----------
    diagram
        Its branches.
    frequencies
        Natural frequencies of the pair.
    """
    rest = diagram.branches[0] if diagram.branches else None
    hopf = [event for event in rest.events if event.kind == "Hopf"] if rest else []
    hopf = _beginning(hopf)
    begin = first_pair(hopf, diagram.model)
    others = [event for event in hopf if event is not begin]
    pair = None if begin is None else _pair(diagram, begin)
    settled = settled_states(diagram)
    galloping = _galloping(diagram, pair)
    onset = _onset(diagram, pair)
    saturated = _saturated(diagram, settled)
    doubts = (*settled.doubts, *_limits(diagram))
    ends = [event.parameter for event in (begin and _ends(diagram, begin)) or []]
    known = Judgement(
        risk="none",
        reason="",
        galloping_from=None if begin is None else begin.parameter,
        galloping_until=min(ends, default=None),
        limit_cycle=_table(diagram, pair),
        galloping=galloping,
        onset=onset,
        until_wind_speed=_until(diagram, pair),
        saturated=saturated,
        antisymmetric_growth=_antisymmetric_growth(diagram, pair),
        other_mode=other_mode(min(others, key=lambda one: one.parameter), diagram.model)
        if others
        else None,
        divergence_from=_divergence(diagram),
        states=settled.states,
        transfers=_transfers(diagram),
        unresolved=doubts,
    )
    turned = [state.is_turned_over for state in known.states]
    unstable = _rest_is_unstable(diagram)
    swing = _risk(diagram, known)
    risk = with_turning(swing, known.divergence_from, turned, unstable)
    return replace(known, risk=risk, reason=_reason(diagram, known, swing, frequencies))


def _beginning(events: Sequence[Event]) -> list[Event]:
    """Hopf points at which an oscillation of rest begins to grow with the wind."""
    return [event for event in events if grows_with_wind(event)]


def grows_with_wind(event: Event) -> bool:
    """True if the critical eigenvalue crosses to the right with the wind."""
    point = event.point
    problem = point.equations.problem
    change = 1e-4 * point.parameter
    omega = abs(event.value.imag)
    rates = []
    for wind in (point.parameter - change, point.parameter + change):
        values = np.linalg.eigvals(problem.rates(point.states, wind).by_state[0])
        rates.append(values[np.argmin(np.abs(values - 1j * omega))].real)
    return bool(rates[1] > rates[0])


def _pair(diagram: SpanDiagram, begin: Event) -> _Pair:
    """Branch of galloping in the first symmetric vertical mode, and where a swing starts on it."""
    branch = next(
        (one for one in diagram.orbits if one.origin is not None and one.origin is begin), None
    )
    doublings = [one for one in branch.events if one.kind == "period doubling"] if branch else []
    return _Pair(
        begin, branch, tuple(one for one in doublings if starts_swing(one.point, diagram.model))
    )


def _ends(diagram: SpanDiagram, begin: Event) -> list[Event]:
    """Where the galloping that begins at a Hopf point ends at rest."""
    branch = _pair(diagram, begin).branch
    return [] if branch is None else branch.of_kind("rest")


def cycle_of(diagram: SpanDiagram, point: Point, multiplier: float) -> Cycle:
    """Amplitudes and vertical frequency of an orbit."""
    u2, u3, theta, _ = amplitudes(point, diagram.model).tolist()
    frequency = vertical_frequency(point, diagram.model)
    return Cycle(point.parameter, u2, u3, theta, frequency, multiplier)


def _table(diagram: SpanDiagram, pair: _Pair | None) -> tuple[Cycle, ...]:
    """Galloping without swing over the wind speed."""
    if pair is None or pair.branch is None:
        return ()
    return tuple(
        cycle_of(diagram, point, abs(diagram.swing_of(point)))
        for point in pair.branch.points
        if id(point.x) in diagram.swing
    )


def _galloping(diagram: SpanDiagram, pair: _Pair | None) -> Cycle | None:
    """Largest stable galloping without swing at the scene's wind; if there is none, the largest."""
    if pair is None or pair.branch is None:
        return None
    points = diagram.at_wind(pair.branch)
    if not points:
        return None
    point = min(points, key=lambda one: (one.unstable, -float(np.max(one.amplitude))))
    found = cycle_of(diagram, point, abs(diagram.swing_of(point)))
    return replace(found, wind_speed=diagram.wind)


def _starting(pair: _Pair | None) -> list[Event]:
    """Period doublings at which a swing starts, with no other growing disturbance first."""
    if pair is None:
        return []
    return sorted(pair.starts, key=lambda event: event.parameter)


def _onset(diagram: SpanDiagram, pair: _Pair | None) -> Cycle | None:
    """Galloping where a swing starts."""
    starts = _starting(pair)
    return cycle_of(diagram, starts[0].point, 1.0) if starts else None


def _until(diagram: SpanDiagram, pair: _Pair | None) -> float | None:
    """Wind speed above the onset from which a swing no longer starts."""
    starts = _starting(pair)
    for event in starts[1:]:
        growing = int(np.sum(event.point.levels > CRITICAL_LEVEL))
        after = [p for p in pair.branch.points if p.parameter > event.parameter][:1]  # type: ignore[union-attr]
        if after and after[0].unstable <= growing:
            return event.parameter
    return None


def _saturated(diagram: SpanDiagram, settled: Settled) -> Cycle | None:
    """Stable motion with swing at half the frequency, in the scene's wind."""
    swinging = [state for state in settled.states if state.has_swing]
    if not swinging:
        return None
    best = max(swinging, key=lambda state: state.horizontal)
    rate, frequency = best.growth_rate, best.frequency_hz or 0.0
    multiplier = 1.0 if rate is None else float(np.exp(rate / frequency))
    return Cycle(diagram.wind, best.vertical, best.horizontal, best.twist, frequency, multiplier)


def _antisymmetric_growth(diagram: SpanDiagram, pair: _Pair | None) -> float | None:
    """Growth of an antisymmetric disturbance of the motion with swing in a vertical cycle."""
    if diagram.problem.symmetry is None or pair is None:
        return None
    starts = {id(event.point.x) for event in pair.starts}
    sizes = [
        antisymmetric_multiplier(point, diagram.model)
        for branch in diagram.orbits
        if branch.origin is not None and id(branch.origin.point.x) in starts
        for point in diagram.at_wind(branch)
    ]
    # the period of a swing is two vertical cycles
    return max((float(np.sqrt(size)) for size in sizes if size is not None), default=None)


def _limits(diagram: SpanDiagram) -> tuple[str, ...]:
    """Sentences about branches that could not be followed."""
    found = []
    for branch in diagram.branches:
        for event in branch.ends[1:]:
            sentence = event_sentence(event, "m/s") if event.kind != "torus" else ""
            if sentence:
                name = name_of_motion(branch.points[len(branch.points) // 2], diagram.model)
                found.append(f"{name}: {sentence}")
    return tuple(found)


def _transfers(diagram: SpanDiagram) -> tuple[Transfer, ...]:
    """Growing disturbances of rest and of the orbits at the scene's wind."""
    model, found = diagram.model, list[Transfer]()
    for branch in diagram.orbits:
        for point in diagram.at_wind(branch):
            name = name_of_motion(point, model)
            for one in disturbances(point, model):
                rate = float(np.log(abs(one.multiplier))) / point.period
                if rate < MIN_TRANSFER:
                    break
                if one.multiplier.imag < 0.0:
                    continue  # the other of a pair
                turns = abs(float(np.angle(one.multiplier))) / (2.0 * np.pi)
                frequency = turns / point.period
                found.append(Transfer(name, name_of_disturbance(one, model), rate, frequency))
    return tuple(found)


def _risk(diagram: SpanDiagram, known: Judgement) -> Risk:
    """Risk of a swing that follows from what was found."""
    has_begun = known.galloping_from is not None
    resolved = [state for state in known.states if state.kind != "not settled"]
    if not resolved and known.galloping is None and _rest_is_unstable(diagram):
        return "undetermined"
    if not has_begun:
        return "none" if known.other_mode is None else "other"
    swinging = any(state.has_swing for state in known.states)
    gallops = known.galloping_from <= diagram.wind  # type: ignore[operator]
    if known.onset is not None or swinging:
        alone = known.galloping
        starts = swinging if alone is None else alone.multiplier > 1.0
        return "certain" if gallops and starts else "possible"
    return "detuned"


def _rest_is_unstable(diagram: SpanDiagram) -> bool:
    """True if a disturbance of rest grows in the scene's wind, or rest is not known there."""
    if not diagram.branches:
        return False
    points = diagram.at_wind(diagram.branches[0])
    first = diagram.branches[0].points[0].parameter
    return diagram.wind > first and not any(point.is_stable for point in points)


def _divergence(diagram: SpanDiagram) -> float | None:
    """Lowest wind speed [m/s] from which rest is statically unstable."""
    kinds = ("fold", "branch point", "symmetry breaking")
    events = diagram.branches[0].events if diagram.branches else []
    return min((event.parameter for event in events if event.kind in kinds), default=None)


def divergence_sentence(wind: float) -> str:
    """Say from which wind speed [m/s] rest is statically unstable."""
    return f"rest is statically unstable from {wind:.4g} m/s (divergence)"


def _reason(diagram: SpanDiagram, known: Judgement, risk: Risk, frequencies: FrequencyRatio) -> str:
    """Word the verdict as a sentence."""
    parts = [_pair_sentence(diagram, known, frequencies)]
    if risk == "other":
        parts = [f"the 2:1 pair is not at risk ({parts[0]}), but {known.other_mode}"]
    if known.divergence_from is not None:
        parts.append(divergence_sentence(known.divergence_from))
    moving = [state for state in known.states if state.kind != "rest" or "over" in state.name]
    if moving:
        listed = " or ".join(str(state) for state in moving)
        parts.append(f"stable at {diagram.wind:.4g} m/s: {listed}")
    if risk == "undetermined":
        why = "; ".join(known.unresolved) or "no stable motion was found"
        parts.append(f"unresolved at {diagram.wind:.4g} m/s: {why}; run a simulation")
    if risk != "other" and known.other_mode is not None:
        parts.append(f"also, {known.other_mode}")
    return "; ".join(parts)


def _pair_sentence(diagram: SpanDiagram, known: Judgement, frequencies: FrequencyRatio) -> str:
    """Sentence about galloping in the first symmetric vertical mode, and its swing."""
    if known.galloping_from is None:
        remark = f"; {diagram.end_reason}" if diagram.end_reason else ""
        return (
            "the first symmetric vertical mode does not gallop up to"
            f" {diagram.highest:.4g} m/s{remark}"
        )
    side = "above" if frequencies.detuning > 0.0 else "below"
    tuning = f"frequency ratio {frequencies.ratio:.3f}, {abs(frequencies.detuning):.1%} {side} 2:1"
    begins = f"{tuning}: galloping begins at {known.galloping_from:.4g} m/s"
    if known.galloping_until is not None:
        begins += f", ends at {known.galloping_until:.4g} m/s"
    galloping = known.galloping
    if known.onset is None:
        size = f" and has an amplitude of {galloping.vertical:.3g} m" if galloping else ""
        return f"{begins}{size}, and starts no swing up to {diagram.highest:.4g} m/s"
    text = (
        f"{tuning}: galloping starts the swing at {known.onset.wind_speed:.4g} m/s, where its"
        f" vertical amplitude passes {known.onset.vertical:.3g} m"
    )
    if known.until_wind_speed is not None:
        text += f", and no longer from {known.until_wind_speed:.4g} m/s on"
    if galloping is not None and galloping.multiplier > 1.0:
        text += (
            f"; at {diagram.wind:.4g} m/s galloping alone would reach {galloping.vertical:.3g} m,"
            f" and a small swing grows by {galloping.multiplier - 1.0:.1%} per cycle"
        )
    return text
