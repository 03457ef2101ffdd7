"""Ranked measures against galloping: what each does, as objects, table and sentences."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modal.motions.saved_table import SavedTable
from modal.screening.line_screen import LineScreening
from modal.screening.screen import Screening
from modal.study.measures import Measure
from modal.study.span_measures import SpanMeasure

if TYPE_CHECKING:
    import xarray as xr


Progress = Callable[[str], object]
"""Called with the name of the part that is computed."""


@dataclass(frozen=True)
class Effect:
    """Onsets and amplitudes of a span or line.

    Attributes
    ----------
    onset, swing : float
        Wind speed [m/s] at which galloping and the swing begin; infinite if not up to the highest
        wind, NaN if unknown.
    vertical, horizontal : float
        Amplitudes [m] at mid-span at the scene's wind, the largest of all stable states and of all
        spans; NaN if unknown.
    largest : float
        Largest amplitude [m], also of two loops at the quarter points, of clamps, and of rotating
        bundles at their subconductors.
    by_span : tuple of float
        Largest vertical amplitude [m] of each span of a line, at mid-span or the quarter points;
        empty for one span, or if unknown.
    is_at_least : bool
        True if amplitudes may be larger: a state was not resolved, or had not settled.
    turns_over : bool
        True if a span or bundle turns over in a stable state, which may be at rest.
    """

    onset: float = math.nan
    swing: float = math.nan
    vertical: float = math.nan
    horizontal: float = math.nan
    largest: float = math.nan
    by_span: tuple[float, ...] = ()
    is_at_least: bool = False
    turns_over: bool = False

    @property
    def is_known(self) -> bool:
        """True if the amplitude is known."""
        return self.largest == self.largest


@dataclass(frozen=True)
class Ranked:
    """A measure with its effect.

    Attributes
    ----------
    measure : SpanMeasure or Measure
        What is done, to a span or a line.
    before, predicted, after : Effect
        The line as it is; with the measure, by derivatives (not of a line); with the measure,
        computed again.
    verified_by : {"screening", "simulation", ""}
        How `before` and `after` were computed; with ``"simulation"``, onsets are those of small
        motion, and `before` is a simulation, too. Empty: not computed.
    tension, sag : float
        Horizontal tension [N] and sag [m] in still air with the measure; of a line the tension of
        its first span and the largest sag.
    reason : str
        Why it was not computed or not screened, and what could not be resolved; may be empty.
    """

    measure: SpanMeasure | Measure
    before: Effect
    predicted: Effect
    after: Effect
    verified_by: str
    tension: float
    sag: float
    reason: str


@dataclass(frozen=True, repr=False)
class RankedMeasures(SavedTable):
    """Measures for a span or line, the most effective first.

    Attributes
    ----------
    title : str
        Title of the scene.
    wind_speed, highest_wind : float
        The scene's wind speed and the highest one of the search [m/s].
    screening : Screening or LineScreening
        The span or line as it is; one phase of a line whose phases move alike.
    rows : tuple of Ranked
        The measures: first those with which nothing begins to gallop up to the highest wind, then
        by the largest amplitude that is left at the scene's wind, then by the onset of galloping.
        Behind these are measures whose amplitude may be larger or with which a span turns over;
        measures without a result are last.
    seconds : float
        CPU time [s].
    """

    title: str
    wind_speed: float
    highest_wind: float
    screening: Screening | LineScreening
    rows: tuple[Ranked, ...]
    seconds: float

    @property
    def dataset(self) -> xr.Dataset:
        """The table: over ``measure`` the values of `Ranked`, with units."""
        import xarray as xr

        columns = self._columns()
        sizes = self._by_span()
        coords: dict[str, object] = {"measure": [row.measure.name for row in self.rows]}
        if sizes.shape[1]:
            coords["span"] = np.arange(1, sizes.shape[1] + 1)
            columns["vertical_by_span_after"] = (("measure", "span"), sizes, {"units": "m"})
        return xr.Dataset(
            columns, coords=coords, attrs={"title": self.title, "wind_speed": self.wind_speed}
        )

    def _columns(self) -> dict[str, tuple[object, object, dict[str, str]]]:
        """Values with one number or text for each measure."""
        columns: dict[str, tuple[object, object, dict[str, str]]] = {}
        columns["detail"] = ("measure", [row.measure.detail for row in self.rows], {})
        for name, unit in (("verified_by", ""), ("reason", ""), ("tension", "N"), ("sag", "m")):
            values = [getattr(row, name) for row in self.rows]
            columns[name] = ("measure", values, {"units": unit} if unit else {})
        for name in ("is_at_least", "turns_over"):
            columns[name] = ("measure", [getattr(row.after, name) for row in self.rows], {})
        for when in ("before", "predicted", "after"):
            for what, unit in UNITS.items():
                values = [getattr(getattr(row, when), what) for row in self.rows]
                columns[f"{what}_{when}"] = ("measure", values, {"units": unit})
        return columns

    def _by_span(self) -> NDArray[np.float64]:
        """Amplitudes [m] (measure, span) with the measures; no column for single spans."""
        spans = max((len(row.after.by_span) for row in self.rows), default=0)
        sizes = np.full((len(self.rows), spans), np.nan)
        for number, row in enumerate(self.rows):
            sizes[number, : len(row.after.by_span)] = row.after.by_span
        return sizes

    def __repr__(self) -> str:
        lines = [f"{self.title}: measures at {self.wind_speed:g} m/s"]
        return "\n".join([*lines, *(sentence_of(row) for row in self.rows)])


UNITS = {"onset": "m/s", "swing": "m/s", "vertical": "m", "horizontal": "m", "largest": "m"}
"""Values of an effect and their units."""


def place_of(row: Ranked) -> tuple[bool, bool, bool, float, float]:
    """Place in the list; unsure amplitudes and lines that turn over are behind others."""
    known, onset = row.after.is_known, row.after.onset
    is_unsure = row.after.is_at_least or row.after.turns_over
    size = row.after.largest if known else 0.0
    return (
        not known,
        not math.isinf(onset),
        is_unsure,
        size,
        0.0 if math.isnan(onset) else -onset,
    )


def sentence_of(row: Ranked) -> str:
    """Effect of a measure in a sentence."""
    name, before, after, predicted = row.measure.name, row.before, row.after, row.predicted
    if not row.verified_by:
        return f"{name}: no result; {row.reason}"
    text = (
        f"{name}: galloping from {_speed(after.onset)} in place of {_speed(before.onset)}"
        + (f" (predicted {_speed(predicted.onset)})" if predicted.onset == predicted.onset else "")
        + f", largest amplitude {_size(after)} in place of {_size(before)}"
    )
    if predicted.largest == predicted.largest:
        text += f" (predicted {_length(predicted.largest)})"
    return f"{text}; {row.verified_by}" + (f"; {row.reason}" if row.reason else "")


def _speed(value: float) -> str:
    if math.isinf(value):
        return "no wind of the range"
    return "unknown" if math.isnan(value) else f"{value:.2f} m/s"


def _size(effect: Effect) -> str:
    turned = " (turned over)" if effect.turns_over else ""
    return ("at least " if effect.is_at_least else "") + _length(effect.largest) + turned


def _length(value: float) -> str:
    return "unknown" if math.isnan(value) else f"{value:.3f} m"
