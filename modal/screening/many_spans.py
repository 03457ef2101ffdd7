"""Screening of many spans or lines: those of a table, or a scene over values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import local
from typing import Any

from gallop_fmu import LineScene, Runs, Scene
from gallop_fmu.foundation.deprecation import warn_renamed
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.sweeps.cases import SpanTable, cases
from gallop_fmu.sweeps.pool import Kind
from gallop_fmu.sweeps.rows import Row
from gallop_fmu.sweeps.runner import CarryOn, Progress, compute, one_by_one
from modal.foundation import one_span as instead
from modal.foundation.one_thread import one_thread
from modal.screening.line_screen import LineScreening
from modal.screening.screen import MAX_WIND_RATIO, Screening, check_wind, screen
from modal.screening.two_mode_estimate import PairModel, estimate, pair_of
from modal.stability.frequency_ratio import FrequencyRatio, frequency_ratio

SCREENING_COLUMNS = {
    "risk": (
        "",
        "risk of a swing or of turning over: none, other, detuned, possible, certain, turns over,"
        " undetermined",
    ),
    "reason": ("", "reason for the risk"),
    "wind_speed": ("m/s", "the scene's wind speed"),
    "highest_wind": ("m/s", "highest wind speed of the search"),
    "vertical_hz": ("Hz", "first symmetric vertical natural frequency"),
    "horizontal_hz": ("Hz", "first horizontal natural frequency"),
    "ratio": ("1", "vertical over horizontal natural frequency"),
    "detuning": ("1", "relative distance of the ratio from 2"),
    "galloping_from": ("m/s", "wind speed at which galloping begins"),
    "other_galloping_from": (
        "m/s",
        "wind speed at which a mode other than the first symmetric vertical one gallops",
    ),
    "onset_wind_speed": ("m/s", "wind speed at which the swing starts"),
    "divergence_from": ("m/s", "wind speed from which rest is statically unstable"),
    "until_wind_speed": ("m/s", "wind speed from which the swing no longer starts"),
    "threshold_amplitude": ("m", "vertical amplitude at which the swing starts"),
    "galloping_vertical": (
        "m",
        "vertical amplitude of galloping without swing at the scene's wind",
    ),
    "growth_per_cycle": ("1", "growth of a small swing in a vertical cycle at the scene's wind"),
    "saturated_vertical": ("m", "vertical amplitude of saturated galloping with swing"),
    "saturated_horizontal": ("m", "horizontal amplitude of saturated galloping with swing"),
    "largest_vertical": (
        "m",
        "largest vertical amplitude of the states at the scene's wind, in any span",
    ),
    "largest_horizontal": ("m", "the same of the horizontal amplitude, also of clamps on strings"),
    "states": ("", "stable states at the scene's wind, and motions that had not settled"),
    "unresolved": ("", "what could not be found out"),
    "warnings": ("", "unusual or contradictory values of the span"),
}

SUSPECT_DETUNING = 0.1
"""Detuning below which a span is suspect even if the estimate finds no threshold."""

ESTIMATE_COLUMNS = {
    "suspect": (
        "",
        "true if the estimate finds a threshold of the swing, reached or not, or the ratio is near"
        " 2",
    ),
    **{
        key: SCREENING_COLUMNS[key]
        for key in (
            "wind_speed",
            "highest_wind",
            "vertical_hz",
            "horizontal_hz",
            "ratio",
            "detuning",
        )
    },
    "estimated_vertical": (
        "m",
        "estimated vertical amplitude of galloping without swing at the scene's wind",
    ),
    "estimated_threshold": ("m", "estimated vertical amplitude at which the swing starts"),
    "estimated_onset": ("m/s", "estimated wind speed at which the swing starts"),
    "warnings": SCREENING_COLUMNS["warnings"],
}


@dataclass(frozen=True)
class ScreeningTask:
    """The task of `screen_spans`."""

    highest_wind: float | None
    kind: Kind = "processes"  # NumPy on small arrays holds the interpreter lock

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Unit and meaning of each column."""
        return SCREENING_COLUMNS

    def __str__(self) -> str:
        """Text that identifies the task; a resumed table must match it."""
        reach = (
            f"{MAX_WIND_RATIO:g} times the wind"
            if self.highest_wind is None
            else f"{self.highest_wind:g} m/s"
        )
        return f"screen to {reach}"

    def __call__(self, scenes: Sequence[Scene | LineScene], carry_on: CarryOn) -> list[Row]:
        """Screen a group of scenes one by one."""
        return one_by_one(self._screen, scenes, carry_on)

    def _screen(self, scene: Scene | LineScene) -> Row:
        return row_of(screen(scene, self.highest_wind))


def row_of(found: Screening | LineScreening) -> Row:
    """Convert a screening to the columns of `SCREENING_COLUMNS`."""
    own = _of_line(found) if isinstance(found, LineScreening) else _of_span(found)
    return {
        "risk": found.risk,
        "reason": found.reason,
        "wind_speed": found.wind_speed,
        "highest_wind": found.highest_wind,
        "galloping_from": found.galloping_from,
        "onset_wind_speed": found.onset_wind_speed,
        "divergence_from": found.divergence_from,
        **own,
        "states": "; ".join(str(state) for state in found.states),
        "unresolved": "; ".join(found.unresolved),
        "warnings": " ".join(found.warnings),
    }


def _of_span(found: Screening) -> Row:
    """Columns of a span."""
    pair, galloping, saturated = found.frequencies, found.galloping, found.saturated
    return {
        "vertical_hz": pair.vertical_hz,
        "horizontal_hz": pair.horizontal_hz,
        "ratio": pair.ratio,
        "detuning": pair.detuning,
        "other_galloping_from": found.other_mode and found.other_mode.wind_speed,
        "until_wind_speed": found.until_wind_speed,
        "threshold_amplitude": found.threshold_amplitude,
        "galloping_vertical": galloping and galloping.vertical,
        "growth_per_cycle": found.growth_per_cycle,
        "saturated_vertical": saturated and saturated.vertical,
        "saturated_horizontal": saturated and saturated.horizontal,
        **_largest([((one.vertical, one.quarter), (one.horizontal,)) for one in found.states]),
    }


def _of_line(found: LineScreening) -> Row:
    """Columns of a line, which has no pair of modes."""
    sizes = [((*one.vertical, *one.quarter), (*one.horizontal, *one.clamp)) for one in found.states]
    return {"other_galloping_from": found.other_galloping_from, **_largest(sizes)}


def _largest(sizes: Sequence[tuple[Sequence[float], Sequence[float]]]) -> Row:
    """Largest vertical and horizontal amplitudes [m] of states, also of those not settled."""
    return {
        "largest_vertical": max((max(vertical) for vertical, _ in sizes), default=None),
        "largest_horizontal": max((max(horizontal) for _, horizontal in sizes), default=None),
    }


class _LastSpan(local):
    """The span of the last estimate of a thread, whose modes hold at other wind speeds, too."""

    def __init__(self) -> None:
        self._scene: Scene | None = None
        self._found: tuple[FrequencyRatio, PairModel]

    def of(self, scene: Scene) -> tuple[FrequencyRatio, PairModel]:
        """Frequency ratio and modes of a scene."""
        if self._scene is None or not _differ_by_wind_speed(self._scene, scene):
            self._found = frequency_ratio(scene), pair_of(scene)
            self._scene = scene
        return self._found


_LAST = _LastSpan()
"""Kept from one group of scenes to the next: the draws of a risk atlas share few spans."""


def _differ_by_wind_speed(one: Scene, other: Scene) -> bool:
    """True if two scenes have the same values but for the wind speed, texts and sources."""
    return all(
        getattr(one, name) == getattr(other, name)
        for name in Scene.model_fields
        if name not in ("wind", "title", "description", "notes", "sources")
    ) and one.wind == other.wind.model_copy(update={"speed": one.wind.speed})


@dataclass(frozen=True)
class EstimateTask:
    """The task of `screen_spans` with `estimate_only`."""

    highest_wind: float | None
    kind: Kind = "processes"

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Unit and meaning of each column."""
        return ESTIMATE_COLUMNS

    def __str__(self) -> str:
        """Text that identifies the task; a resumed table must match it."""
        return f"estimate only, {ScreeningTask(self.highest_wind)}"

    def __call__(self, scenes: Sequence[Scene | LineScene], carry_on: CarryOn) -> list[Row]:
        """Estimate a group of scenes one by one; modes are computed once for all wind speeds."""
        return one_by_one(self._estimate, scenes, carry_on)

    def _estimate(self, given: Scene | LineScene) -> Row:
        scene = one_span(given, "estimate_only", instead.ESTIMATE)
        wind = scene.wind.mean_speed
        highest = MAX_WIND_RATIO * wind if self.highest_wind is None else self.highest_wind
        check_wind(scene, wind, highest)
        pair, modes = _LAST.of(scene)
        found = estimate(scene, wind, highest, modes)
        has_threshold = found.threshold_amplitude is not None
        gallops = found.vertical_amplitude > 0.0
        return {
            "suspect": has_threshold or abs(pair.detuning) < SUSPECT_DETUNING,
            "wind_speed": wind,
            "highest_wind": highest,
            "vertical_hz": pair.vertical_hz,
            "horizontal_hz": pair.horizontal_hz,
            "ratio": pair.ratio,
            "detuning": pair.detuning,
            "estimated_vertical": found.vertical_amplitude if gallops else None,
            "estimated_threshold": found.threshold_amplitude,
            "estimated_onset": found.onset_wind_speed,
            "warnings": " ".join(scene.warnings),
        }


@one_thread
def screen_spans(  # noqa: PLR0913 - all but two are keyword arguments
    scene: Scene | SceneSpec | str | Path | None = None,
    over: Mapping[str, Sequence[Any]] | None = None,
    *,
    table: SpanTable | None = None,
    highest_wind: float | None = None,
    estimate_only: bool = False,
    out: Path | str | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
    first_look: bool | None = None,
) -> Runs:
    """Screen (`modal.screen`) a scene over values of its parameters, a table of scenes, or both.

    Scenes are spans, sections or bundles, in any mixture.

    Parameters
    ----------
    scene, over, table, out, cluster, progress
        As for `gallop_fmu.sweep`.
    highest_wind
        Highest wind speed [m/s] of the search; None takes 1.5 times each scene's.
    estimate_only
        Compute only `modal.two_mode_estimate` instead of `modal.screen`, which is far
        faster: for thousands of spans (not lines), of which the ``suspect`` ones are screened
        afterwards. The estimate may miss an onset, mostly above 2:1; therefore a span is suspect
        as soon as a threshold exists in the range of amplitudes (`benchmarks/speed/corridor.py`
        compares).
    workers
        Number of processes; None takes one for each core. With 1, and where no process can be
        started, everything is computed in the calling process.
    first_look
        Deprecated name of `estimate_only`.

    Returns
    -------
    Runs
        One row for each span or line with the columns of `SCREENING_COLUMNS` or `ESTIMATE_COLUMNS`.
        Those of the 2:1 pair of modes are empty for lines. What could not be screened has a row,
        too; ``outcome`` and ``message`` give the reason.

    Raises
    ------
    SceneError, RunsStoppedError
        As for `gallop_fmu.sweep`; or `estimate_only` is given for a line.

    Examples
    --------
    >>> import modal
    >>> found = modal.screen_spans("example3", {"span.sag": [2.08, 2.12]}, highest_wind=5.6)
    >>> found.dataset.risk.values.tolist()
    ['certain', 'certain']
    """
    if first_look is not None:
        warn_renamed("screen_spans(first_look=...)", "estimate_only")
        estimate_only = first_look
    task = EstimateTask(highest_wind) if estimate_only else ScreeningTask(highest_wind)
    found = cases(scene, over, table)
    for base in found.bases if estimate_only else ():
        if base.is_section:
            one_span(base.scene(), "estimate_only", instead.ESTIMATE)
    return compute(found, task, out=out, count=workers, cluster=cluster, progress=progress)
