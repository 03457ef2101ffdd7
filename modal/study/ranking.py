"""Measures against galloping of one span, ranked: what each does, predicted and computed again."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gallop_fmu import LineScene, Model, Scene, SceneError, SimulationError
from gallop_fmu.input.scene_like import SceneLike, as_span
from modal.motions.branches import branches
from modal.motions.sensitivity import sensitivity
from modal.motions.table import write_dataset
from modal.screening.screen import MAX_WIND_RATIO, Screening, screen
from modal.stability.critical_wind import critical_wind_speed
from modal.study.cases import Variant, run_cases
from modal.study.span_measures import SpanMeasure, line_of_span, measures_of_span

if TYPE_CHECKING:
    import xarray as xr

INSTEAD = "use modal.study_line, which simulates measures on a line"
"""What to do for a line."""

LINE_MODES = 8
"""Modes of a line with devices among which the lowest critical wind is looked for."""

LOWEST_WIND = 0.5
"""Wind speed at which the search for motions begins, relative to the scene's."""

Progress = Callable[[str], object]
"""Called with the name of the part that is computed."""


@dataclass(frozen=True)
class Effect:
    """Onsets and amplitudes of a span.

    Attributes
    ----------
    onset, swing : float
        Wind speed [m/s] at which galloping and the swing begin; infinite if not up to the highest
        wind, NaN if unknown.
    vertical, horizontal : float
        Amplitudes [m] at mid-span at the scene's wind, the largest of all stable states; NaN if
        unknown.
    largest : float
        Largest amplitude [m], also of two loops at the quarter points.
    """

    onset: float = math.nan
    swing: float = math.nan
    vertical: float = math.nan
    horizontal: float = math.nan
    largest: float = math.nan


@dataclass(frozen=True)
class Ranked:
    """A measure with its effect.

    Attributes
    ----------
    measure : SpanMeasure
        What is done.
    before, predicted, after : Effect
        The span as it is; with the measure, by derivatives; with the measure, computed again.
    verified_by : {"screening", "simulation", ""}
        How `before` and `after` were computed; with ``"simulation"``, onsets are those of small
        motion, and `before` is the line without the device. Empty: not computed.
    tension, sag : float
        Horizontal tension [N] and sag [m] in still air with the measure.
    reason : str
        Why it was not computed; empty otherwise.
    """

    measure: SpanMeasure
    before: Effect
    predicted: Effect
    after: Effect
    verified_by: str
    tension: float
    sag: float
    reason: str


@dataclass(frozen=True, repr=False)
class RankedMeasures:
    """Measures for a span, the most effective first.

    Attributes
    ----------
    title : str
        Title of the scene.
    wind_speed, highest_wind : float
        The scene's wind speed and the highest one of the search [m/s].
    screening : Screening
        The span as it is.
    rows : tuple of Ranked
        The measures, by the largest amplitude that is left at the scene's wind, then by the onset
        of galloping; those without a result are last.
    seconds : float
        CPU time [s].
    """

    title: str
    wind_speed: float
    highest_wind: float
    screening: Screening
    rows: tuple[Ranked, ...]
    seconds: float

    @property
    def dataset(self) -> xr.Dataset:
        """The table: over ``measure`` the values of `Ranked`, with units."""
        import xarray as xr

        data: dict[str, tuple[str, list[object], dict[str, str]]] = {
            "detail": ("measure", [row.measure.detail for row in self.rows], {}),
            "verified_by": ("measure", [row.verified_by for row in self.rows], {}),
            "reason": ("measure", [row.reason for row in self.rows], {}),
            "tension": ("measure", [row.tension for row in self.rows], {"units": "N"}),
            "sag": ("measure", [row.sag for row in self.rows], {"units": "m"}),
        }
        for when in ("before", "predicted", "after"):
            for what, unit in UNITS.items():
                values: list[object] = [getattr(getattr(row, when), what) for row in self.rows]
                data[f"{what}_{when}"] = ("measure", values, {"units": unit})
        return xr.Dataset(
            data,
            coords={"measure": [row.measure.name for row in self.rows]},
            attrs={"title": self.title, "wind_speed": self.wind_speed},
        )

    def __repr__(self) -> str:
        lines = [f"{self.title}: measures at {self.wind_speed:g} m/s"]
        return "\n".join([*lines, *(sentence_of(row) for row in self.rows)])

    def save(self, path: Path | str) -> Path:
        """Write the table as ``.nc`` (NetCDF) or ``.csv``.

        Raises
        ------
        SceneError
            The suffix is another one.
        OSError
            The file cannot be written.
        """
        rows = self.dataset.to_dataframe().reset_index
        return write_dataset(self.dataset, Path(path), rows)


UNITS = {"onset": "m/s", "swing": "m/s", "vertical": "m", "horizontal": "m", "largest": "m"}
"""Values of an effect and their units."""


def rank_measures(
    scene: SceneLike,
    highest_wind: float | None = None,
    *,
    stop_time: float | None = None,
    progress: Progress | None = None,
) -> RankedMeasures:
    """Rank practicable measures against galloping of a span, each computed again.

    Measures: tension, damping, added mass, a tower in the middle of the span, detuning pendulums, a
    tuned damper. The effect of those that change a number is predicted by `modal.sensitivity` and
    computed by `modal.screen`; a span with devices is simulated.

    Parameters
    ----------
    scene
        The span, as for `modal.screen`.
    highest_wind
        Highest wind speed [m/s] of the search (default: 1.5 times the scene's).
    stop_time
        Simulated time [s] of a span with devices (default: from the scene).
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
    span = as_span(scene, "rank_measures", INSTEAD)
    wind = span.wind.mean_speed
    highest = MAX_WIND_RATIO * wind if highest_wind is None else highest_wind
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
        rows=tuple(sorted(rows, key=_place)),
        seconds=clock.process_time() - began,
    )


def effect_of(found: Screening) -> Effect:
    """Onsets and amplitudes of a screening."""
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
    lines = {
        row.measure.name: row.measure.scene
        for row in rows
        if isinstance(row.measure.scene, LineScene)
    }
    if not lines:
        return rows
    shown("simulations with devices")
    every = {"": line_of_span(scene), **lines}
    cases = run_cases(
        [Variant(line, name, "") for name, line in every.items()],
        [(scene.wind.mean_speed, scene.ice.attack_angle_deg)],
        offsets=[(0.0, 0.0)],
        stop_time=scene.run.stop_time if stop_time is None else stop_time,
        workers=1,
    )
    effects: dict[str, Effect] = {}
    reasons: dict[str, str] = {}
    for case in cases:
        shown(f"critical wind: {case.ice}" if case.ice else "critical wind")
        onset, reasons[case.ice] = _critical_wind(every[case.ice], highest)
        if not case.has_result:
            effects[case.ice], reasons[case.ice] = Effect(onset), case.text
            continue
        vertical, horizontal = 0.5 * case.largest, 0.5 * float(np.nanmax(case.horizontal))
        largest = max(vertical, horizontal)
        effects[case.ice] = Effect(onset, math.nan, vertical, horizontal, largest)
    return [
        replace(
            row,
            before=effects[""],
            after=effects[row.measure.name],
            verified_by="simulation",
            reason=reasons[row.measure.name],
        )
        if row.measure.name in lines
        else row
        for row in rows
    ]


def _critical_wind(line: LineScene, highest: float) -> tuple[float, str]:
    """Lowest wind speed [m/s] at which a mode grows, and the reason if it is unknown."""
    try:
        found = [one.wind_speed for one in critical_wind_speed(line, LINE_MODES, highest)]
    except (SceneError, SimulationError) as problem:
        return math.nan, f"the critical wind is unknown, because {problem}"
    return min((one for one in found if one is not None), default=math.inf), ""


def _place(row: Ranked) -> tuple[bool, float, float]:
    """Place in the list."""
    known = row.after.largest == row.after.largest
    onset = row.after.onset if row.after.onset == row.after.onset else 0.0
    return not known, row.after.largest if known else 0.0, -onset


def sentence_of(row: Ranked) -> str:
    """Effect of a measure in a sentence."""
    name, before, after, predicted = row.measure.name, row.before, row.after, row.predicted
    if not row.verified_by:
        return f"{name}: no result; {row.reason}"
    text = (
        f"{name}: galloping from {_speed(after.onset)} in place of {_speed(before.onset)}"
        + (f" (predicted {_speed(predicted.onset)})" if predicted.onset == predicted.onset else "")
        + f", largest amplitude {_length(after.largest)} in place of {_length(before.largest)}"
    )
    if predicted.largest == predicted.largest:
        text += f" (predicted {_length(predicted.largest)})"
    return f"{text}; {row.verified_by}" + (f"; {row.reason}" if row.reason else "")


def _speed(value: float) -> str:
    if math.isinf(value):
        return "no wind of the range"
    return "unknown" if math.isnan(value) else f"{value:.2f} m/s"


def _length(value: float) -> str:
    return "unknown" if math.isnan(value) else f"{value:.3f} m"
