"""Effects of measures: onsets and amplitudes, by the screening or by simulations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gallop_fmu import LineScene, SceneError, SimulationError
from modal.screening.line_screen import LineScreening
from modal.screening.screen import Screening
from modal.stability.critical_wind import lowest_critical_wind
from modal.study.cases import Case, Variant, run_cases
from modal.study.ranked import Effect

LINE_MODES = 8
"""Modes of a span of a line among which the lowest critical wind is looked for."""

EACH_FURTHER = 4
"""The same of each further span and phase: one and two loops, vertical and horizontal."""


def effect_of(found: Screening) -> Effect:
    """Onsets and amplitudes of a screening of a span."""
    onset = math.inf if found.galloping_from is None else found.galloping_from
    if found.other_mode is not None:
        onset = min(onset, found.other_mode.wind_speed)
    swing = math.inf if found.onset_wind_speed is None else found.onset_wind_speed
    if not found.states:
        return Effect(onset, swing)
    return Effect(
        onset,
        swing,
        max(one.vertical for one in found.states),
        max(one.horizontal for one in found.states),
        max(one.largest for one in found.states),
        turns_over=any(one.is_turned_over for one in found.states),
    )


def effect_on_line(found: LineScreening, spans: int) -> Effect:
    """Onsets and amplitudes of a screening of a line; onsets of any motion.

    Parameters
    ----------
    found
        The screening.
    spans
        Number of spans.
    """
    none = math.nan if found.unresolved else math.inf
    onset = min((one.wind_speed for one in found.onsets), default=none)
    swing = none if found.onset_wind_speed is None else found.onset_wind_speed
    if not found.states:
        return Effect(onset, swing)
    tall = 0.5 * np.array([one.peak_to_peak for one in found.states])
    return Effect(
        onset,
        swing,
        max(max(one.vertical) for one in found.states),
        max(max(one.horizontal) for one in found.states),
        max(one.largest for one in found.states),
        tuple(tall.max(axis=0).reshape(spans, -1).max(axis=1).tolist()),
        bool(found.unresolved_states),
        any(one.is_turned_over for one in found.states),
    )


def simulated(lines: Sequence[LineScene], stop_time: float) -> list[tuple[Effect, str]]:
    """Simulate lines with the same numbers of phases in their wind.

    Parameters
    ----------
    lines
        The lines.
    stop_time
        Simulated time [s].

    Returns
    -------
    list of tuple of (Effect, str)
        Of each line the effect without onsets, and what did not settle in words.
    """
    first = lines[0]
    cases = run_cases(
        [Variant(line, str(number), "") for number, line in enumerate(lines)],
        [(first.wind.mean_speed, first.ice.attack_angle_deg)],
        offsets=[(0.0, 0.0)] * len(first.phases),
        stop_time=stop_time,
        workers=1,
    )
    return [_effect_of_case(case, first) for case in cases]


def _effect_of_case(case: Case, line: LineScene) -> tuple[Effect, str]:
    """Effect by a simulated case, and what did not settle in words."""
    if not case.has_result:
        return Effect(), case.text
    by_span = 0.5 * case.peak_to_peak
    swung = case.horizontal[np.isfinite(case.horizontal)]
    vertical, horizontal = 0.5 * case.largest, 0.5 * float(np.max(swung, initial=0.0))
    effect = Effect(
        vertical=vertical,
        horizontal=horizontal,
        largest=max(vertical, horizontal),
        by_span=tuple(by_span.tolist()) if len(line.section.spans) > 1 else (),
        is_at_least=case.kind != "steady",
    )
    return effect, "" if case.kind == "steady" else f"{case.kind}: {case.text}"


def onset_of_small_motion(line: LineScene, highest: float) -> tuple[float, str]:
    """Lowest wind speed [m/s] at which a mode grows, and the reason if it is unknown.

    Infinite if none grows up to the highest wind.
    """
    count = LINE_MODES + EACH_FURTHER * (len(line.section.spans) * len(line.phases) - 1)
    try:
        found = lowest_critical_wind(line, count, highest)
    except (SceneError, SimulationError) as problem:
        return math.nan, f"the critical wind is unknown, because {problem}"
    return math.inf if found is None else found, ""
