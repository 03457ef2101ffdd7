"""Measures against galloping of a line, ranked: each is screened, or simulated where it must be."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Model, SceneError, SimulationError
from modal.foundation.alike_phases import one_phase
from modal.linear.line_modes import LineMode
from modal.linear.modes import natural_modes
from modal.motions.line_basis import BUNDLE_FACTOR, MAX_MODES
from modal.screening.line_screen import LineScreening
from modal.screening.screen import screen
from modal.screening.verdict import divergence_sentence
from modal.study.conditions import steady_wind
from modal.study.measures import Measure, measures
from modal.study.push import pushed
from modal.study.ranked import Effect, Progress, Ranked, RankedMeasures, place_of
from modal.study.verification import (
    EACH_FURTHER,
    LINE_MODES,
    effect_on_line,
    onset_of_small_motion,
    simulated,
)

GALLOPS = 0.5
"""Amplitude of a span, relative to the largest one, from which it has a damper."""

TAKES_PART = 0.7
"""Energy of a span in a mode, relative to that of the span with the most, from which the mode is
one of this span."""

LEAST_TIME = 1200.0
"""Least simulated time [s], if none is given: the default of a scene, 60 s, is too short."""


def rank_line(
    scene: LineScene, highest: float, stop_time: float | None, shown: Progress
) -> RankedMeasures:
    """Rank measures for a line; see `modal.study.ranking.rank_measures`.

    Parameters
    ----------
    scene
        The line, with all phases that it has.
    highest
        Highest wind speed [m/s] of the search.
    stop_time
        Simulated time [s] where the screening does not hold; None: from the scene.
    shown
        Called with the name of the part that is computed.

    Raises
    ------
    SceneError
        The line is not fit for the screening.
    """
    began = clock.process_time()
    whole = steady_wind(scene)
    alone = one_phase(whole)
    shown("screening")
    screening = screen(alone, highest)
    before = effect_on_line(screening, len(scene.section.spans))
    found = measures(whole, _frequencies(alone, screening))
    rows = []
    for number, measure in enumerate(found, start=1):
        shown(f"{number} of {len(found)}: {measure.name}")
        rows.append(_screened(measure, before, highest))
    rows = _simulated(alone, rows, highest, stop_time, shown)
    return RankedMeasures(
        title=scene.title,
        wind_speed=scene.wind.mean_speed,
        highest_wind=highest,
        screening=screening,
        rows=tuple(sorted(rows, key=place_of)),
        seconds=clock.process_time() - began,
    )


def _frequencies(scene: LineScene, screening: LineScreening) -> NDArray[np.float64]:
    """Frequency [Hz] of galloping of each span; NaN where it moves little.

    Of the modes in one loop in which a span takes part most, that next to the simulated frequency.
    """
    spans = len(scene.section.spans)
    found = np.full(spans, np.nan)
    tall = effect_on_line(screening, spans).by_span
    moving = [one for one in screening.states if one.frequency_hz is not None]
    if not (tall and moving):
        return found
    largest = max(moving, key=lambda one: one.largest)
    assert largest.frequency_hz is not None
    modes = natural_modes(scene, LINE_MODES + EACH_FURTHER * (spans - 1))
    for span in range(spans):
        if tall[span] >= GALLOPS * max(tall):
            found[span] = _frequency_of_span(modes, span, largest.frequency_hz)
    return found


def _frequency_of_span(modes: Sequence[LineMode], span: int, simulated_hz: float) -> float:
    """Frequency [Hz] of the vertical mode of a span in one loop, next to a simulated one."""
    upright = ("vertical", "tension-neutral")
    shares = {
        one.frequency_hz: float(one.span_shares[span] / np.max(one.span_shares))
        for one in modes
        if one.family in upright and one.loops[span] == 1
    }
    own = [hertz for hertz, share in shares.items() if share >= TAKES_PART]
    return min(own or [simulated_hz], key=lambda hertz: abs(hertz - simulated_hz))


def _screened(measure: Measure, before: Effect, highest: float) -> Ranked:
    """Screen the line with a measure; what cannot be screened has the reason, and no result."""
    row = Ranked(measure, before, Effect(), Effect(), "", math.nan, math.nan, measure.reason)
    if measure.scene is None:
        return row
    line = one_phase(measure.scene)
    try:
        tension, sag = _strung(line)
        row = replace(row, tension=tension, sag=sag)
        if reason := _too_many_bundles(line):
            return replace(row, reason=reason)
        found = screen(line, highest)
    except (SceneError, SimulationError) as problem:
        return replace(row, reason=f"not screened: {problem}")
    after = effect_on_line(found, len(line.section.spans))
    doubts = [f"unresolved: {text}" for text in found.unresolved]
    if found.divergence_from is not None:
        doubts.append(divergence_sentence(found.divergence_from))
    by = "screening" if after.is_known else ""
    return replace(row, after=after, verified_by=by, reason="; ".join(doubts))


def _strung(line: LineScene) -> tuple[float, float]:
    """Tension [N] of the first span and largest sag [m] in still air."""
    model = Model(line)
    rest = [model.chain_equilibrium(number) for number in range(len(model.map.chains))]
    sag = max(one.sag for one in rest)
    return rest[0].horizontal_tension, sag


def _too_many_bundles(line: LineScene) -> str:
    """Reason why several phases cannot be screened together; empty if they can."""
    phases, spans = len(line.phases), len(line.section.spans)
    each = EACH_FURTHER * (BUNDLE_FACTOR if line.bundle.subconductors > 1 else 1.0)
    most = int(MAX_MODES / each)
    if phases == 1 or phases * spans <= most:
        return ""
    return (
        f"not screened: {phases} phases that move together in {spans} spans have more modes than"
        f" the {MAX_MODES} of the screening, which takes {most} spans times phases"
    )


def _simulated(
    base: LineScene,
    rows: list[Ranked],
    highest: float,
    stop_time: float | None,
    shown: Progress,
) -> list[Ranked]:
    """Simulate the line as it is, and with each measure that was not screened."""
    if all(row.verified_by or row.measure.scene is None for row in rows):
        return rows
    seconds = max(base.run.stop_time, LEAST_TIME) if stop_time is None else stop_time
    shown("simulation of the line as it is")
    ((before, _),) = simulated([pushed(base)], seconds)
    return [
        row
        if row.verified_by or row.measure.scene is None
        else _simulated_row(row, before, highest, seconds, shown)
        for row in rows
    ]


def _simulated_row(
    row: Ranked, before: Effect, highest: float, seconds: float, shown: Progress
) -> Ranked:
    """Row of a measure whose amplitude is that of a simulation."""
    shown(f"simulation: {row.measure.name}")
    assert isinstance(row.measure.scene, LineScene)
    line = one_phase(row.measure.scene)
    ((after, doubt),) = simulated([pushed(line)], seconds)
    # The screening has the onset of all motions, where it was possible.
    onset, reason = row.after.onset, ""
    if math.isnan(onset):
        shown(f"critical wind: {row.measure.name}")
        onset, reason = onset_of_small_motion(line, highest)
    return replace(
        row,
        before=replace(before, onset=row.before.onset),
        after=replace(after, onset=onset),
        verified_by="simulation",
        reason="; ".join(part for part in (row.reason, doubt, reason) if part),
    )
