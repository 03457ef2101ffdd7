"""Measures against galloping of a span or line, ranked: each is computed again."""

from __future__ import annotations

import math
import time as clock
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gallop_fmu import LineScene, Model, Scene, SceneError, SimulationError
from gallop_fmu.input.scene_like import SceneLike, as_scene
from modal.foundation.one_thread import one_thread
from modal.motions.branches import branches
from modal.motions.sensitivity import sensitivity
from modal.screening.screen import MAX_WIND_RATIO, screen
from modal.study.line_ranking import rank_line
from modal.study.ranked import Effect, Progress, Ranked, RankedMeasures, place_of
from modal.study.span_measures import SpanMeasure, line_of_span, measures_of_span
from modal.study.verification import effect_of, onset_of_small_motion, simulated

if TYPE_CHECKING:
    import xarray as xr

LOWEST_WIND = 0.5
"""Wind speed at which the search for motions begins, relative to the scene's."""


@one_thread
def rank_measures(
    scene: SceneLike,
    highest_wind: float | None = None,
    *,
    stop_time: float | None = None,
    progress: Progress | None = None,
) -> RankedMeasures:
    """Rank practicable measures against galloping of a span or line, each computed again.

    Measures for a span: tension, damping, added mass, a tower in the middle of the span, detuning
    pendulums, a tuned damper. The effect of those that change a number is predicted by
    `modal.sensitivity` and computed by `modal.screen`; a span with devices is simulated.

    Measures for a line: those of a study, that is tension, spacers of a bundle, interphase spacers,
    pendulums, tuned dampers, a tower in the middle of the longest span. Each is computed by
    `modal.screen`. Where that is not possible, the line is simulated, and `Ranked.reason` says why.

    Parameters
    ----------
    scene
        The span or line, as for `modal.screen`.
    highest_wind
        Highest wind speed [m/s] of the search (default: 1.5 times the scene's).
    stop_time
        Simulated time [s] where a simulation is necessary (default: from the scene).
    progress
        Called with the name of the part that is computed.

    Raises
    ------
    SceneError
        If the scene is not fit for the screening.

    Examples
    --------
    >>> import modal
    >>> found = modal.rank_measures("example3")  # doctest: +SKIP
    >>> found.rows[0].measure.name  # doctest: +SKIP
    'Split the span by a tower in its middle'
    """
    began = clock.process_time()
    shown = progress or (lambda name: None)
    span = as_scene(scene)
    wind = span.wind.mean_speed
    highest = MAX_WIND_RATIO * wind if highest_wind is None else highest_wind
    if isinstance(span, LineScene):
        return rank_line(span, highest, stop_time, shown)
    shown("screening")
    screening = screen(span, highest)
    before = effect_of(screening)
    frequency = math.nan if screening.galloping is None else screening.galloping.frequency_hz
    found = measures_of_span(span, frequency)
    shown("sensitivity")
    predictions = _predictions(span, wind, highest, before, found)
    rows = []
    for measure, predicted in zip(found, predictions, strict=True):
        shown(measure.name)
        rows.append(_computed(measure, before, predicted, highest))
    rows = _simulated(span, rows, highest, stop_time, shown)
    return RankedMeasures(
        title=span.title,
        wind_speed=wind,
        highest_wind=highest,
        screening=screening,
        rows=tuple(sorted(rows, key=place_of)),
        seconds=clock.process_time() - began,
    )


def _predictions(
    scene: Scene, wind: float, highest: float, before: Effect, found: list[SpanMeasure]
) -> list[Effect]:
    """Effect of each measure by derivatives; NaN where there is none."""
    paths = list(dict.fromkeys(each.path for each in found if each.path and each.scene is not None))
    if not (paths and math.isfinite(before.onset)):
        return [Effect() for _ in found]
    try:
        motions = branches(scene, start=LOWEST_WIND * wind, stop=highest)
        data = sensitivity(motions, paths).dataset
    except SceneError:
        return [Effect() for _ in found]
    return [_predicted(data, each) if each.path in paths else Effect() for each in found]


def _predicted(data: xr.Dataset, measure: SpanMeasure) -> Effect:
    """Effect of a measure by derivatives: the lowest onsets and the largest stable motion."""
    names = np.array(data["quantity"].values, dtype=str)
    slope = data["derivative"].sel(number=measure.path).values
    values = data["value"].values + slope * measure.change
    stable = data["is_stable"].values

    def of(kind: str, most: bool = False) -> float:
        alike = np.char.startswith(names, kind) & (stable if most else True)
        if not alike.any():
            return math.nan
        return max(float(values[alike].max()), 0.0) if most else float(values[alike].min())

    vertical, horizontal, two_loop = (
        of(f"{which} amplitude", most=True) for which in ("vertical", "horizontal", "two-loop")
    )
    sizes = [size for size in (vertical, horizontal, two_loop) if size == size]
    largest = max(sizes, default=math.nan)
    return Effect(of("Hopf"), of("period doubling"), vertical, horizontal, largest)


def _computed(measure: SpanMeasure, before: Effect, predicted: Effect, highest: float) -> Ranked:
    """Screen the span with a measure; devices are left for the simulation."""
    unknown = Ranked(measure, before, predicted, Effect(), "", math.nan, math.nan, measure.reason)
    if not isinstance(measure.scene, Scene):
        return unknown
    try:
        rest = Model(measure.scene).equilibrium()
        after = effect_of(screen(measure.scene, highest))
    except (SceneError, SimulationError) as problem:
        return replace(unknown, reason=str(problem))
    return replace(
        unknown,
        after=after,
        verified_by="screening",
        tension=rest.horizontal_tension,
        sag=rest.sag,
    )


def _simulated(
    scene: Scene, rows: list[Ranked], highest: float, stop_time: float | None, shown: Progress
) -> list[Ranked]:
    """Simulate the span without and with each device."""
    devices = [row.measure.scene for row in rows if isinstance(row.measure.scene, LineScene)]
    if not devices:
        return rows
    shown("simulations with devices")
    every = [line_of_span(scene), *devices]
    found = simulated(every, scene.run.stop_time if stop_time is None else stop_time)
    results = list[tuple[Effect, str]]()
    for line, (effect, doubt) in zip(every, found, strict=True):
        shown(f"critical wind, {len(results) + 1} of {len(every)}")
        onset, reason = onset_of_small_motion(line, highest)
        text = "; ".join(part for part in (doubt, reason) if part)
        results.append((replace(effect, onset=onset), text))
    before, later = results[0][0], iter(results[1:])
    done = []
    for row in rows:
        if isinstance(row.measure.scene, LineScene):
            after, reason = next(later)
            row = replace(row, before=before, after=after, verified_by="simulation", reason=reason)
        done.append(row)
    return done
