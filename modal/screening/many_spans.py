"""Screening many spans: every span of a table, or a scene over values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gallop_fmu import Runs, Scene
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.sweeps.cases import SpanTable, cases
from gallop_fmu.sweeps.pool import Kind
from gallop_fmu.sweeps.rows import Row
from gallop_fmu.sweeps.runner import CarryOn, Progress, compute, one_by_one
from modal.screening.screen import REACH, Screening, check_wind, screen
from modal.screening.two_mode_estimate import two_mode_estimate
from modal.stability.frequency_ratio import frequency_ratio

SCREENING_COLUMNS = {
    "risk": (
        "",
        "whether galloping starts the swing: none, other, detuned, possible, certain, undetermined",
    ),
    "reason": ("", "why, in words"),
    "wind_speed": ("m/s", "the scene's wind"),
    "highest_wind": ("m/s", "up to where was looked"),
    "vertical_hz": ("Hz", "first symmetric vertical natural frequency"),
    "horizontal_hz": ("Hz", "first horizontal natural frequency"),
    "ratio": ("1", "vertical over horizontal natural frequency"),
    "detuning": ("1", "relative distance of the ratio from 2"),
    "galloping_from": ("m/s", "wind at which galloping begins"),
    "other_galloping_from": (
        "m/s",
        "wind at which another mode than the first symmetric vertical one gallops",
    ),
    "onset_wind_speed": ("m/s", "wind at which the swing starts"),
    "until_wind_speed": ("m/s", "wind at which it no longer starts"),
    "threshold_amplitude": ("m", "vertical amplitude at which the swing starts"),
    "galloping_vertical": (
        "m",
        "vertical amplitude of galloping without swing at the scene's wind",
    ),
    "growth_per_cycle": ("1", "growth of a small swing in a vertical cycle at the scene's wind"),
    "saturated_vertical": ("m", "vertical amplitude that galloping and swing settle at"),
    "saturated_horizontal": ("m", "horizontal amplitude that they settle at"),
    "warnings": ("", "what is unusual about the span, or contradicts itself"),
}

NEAR = 0.1
"""Detuning below which a span is suspect whatever the estimate says."""

FIRST_LOOK_COLUMNS = {
    "suspect": (
        "",
        (
            "whether the estimate knows a threshold of the swing, reached or not, or the ratio is"
            " near 2"
        ),
    ),
    **{
        key: SCREENING_COLUMNS[key]
        for key in ("wind_speed", "highest_wind", "vertical_hz", "horizontal_hz")
    },
    **{key: SCREENING_COLUMNS[key] for key in ("ratio", "detuning")},
    "estimated_vertical": (
        "m",
        "estimate of the vertical amplitude of galloping without swing at the scene's wind",
    ),
    "estimated_threshold": ("m", "estimate of the vertical amplitude at which the swing starts"),
    "estimated_onset": ("m/s", "estimate of the wind at which the swing starts"),
    "warnings": SCREENING_COLUMNS["warnings"],
}


@dataclass(frozen=True)
class ScreeningTask:
    """The task of `screen_spans`."""

    highest_wind: float | None
    kind: Kind = "processes"  # NumPy in small pieces holds the interpreter lock

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Column to unit and meaning."""
        return SCREENING_COLUMNS

    def __str__(self) -> str:
        reach = "1.5 times the wind" if self.highest_wind is None else f"{self.highest_wind:g} m/s"
        return f"screen to {reach}"

    def __call__(self, scenes: Sequence[Scene], carry_on: CarryOn) -> list[Row]:
        """Screen a group of scenes, each by itself."""
        return one_by_one(lambda scene: row_of(screen(scene, self.highest_wind)), scenes, carry_on)


def row_of(found: Screening) -> Row:
    """What is kept of a screening: the columns of `SCREENING_COLUMNS`."""
    pair, galloping, saturated = found.frequencies, found.galloping, found.saturated
    return {
        "risk": found.risk,
        "reason": found.reason,
        "wind_speed": found.wind_speed,
        "highest_wind": found.highest_wind,
        "vertical_hz": pair.vertical_hz,
        "horizontal_hz": pair.horizontal_hz,
        "ratio": pair.ratio,
        "detuning": pair.detuning,
        "galloping_from": found.galloping_from,
        "other_galloping_from": found.other_mode and found.other_mode.wind_speed,
        "onset_wind_speed": found.onset_wind_speed,
        "until_wind_speed": found.until_wind_speed,
        "threshold_amplitude": found.threshold_amplitude,
        "galloping_vertical": galloping and galloping.vertical,
        "growth_per_cycle": found.growth_per_cycle,
        "saturated_vertical": saturated and saturated.vertical,
        "saturated_horizontal": saturated and saturated.horizontal,
        "warnings": " ".join(found.warnings),
    }


@dataclass(frozen=True)
class FirstLookTask:
    """The task of `screen_spans` that takes a first look."""

    highest_wind: float | None
    kind: Kind = "processes"

    @property
    def columns(self) -> Mapping[str, tuple[str, str]]:
        """Column to unit and meaning."""
        return FIRST_LOOK_COLUMNS

    def __str__(self) -> str:
        return f"first look, {ScreeningTask(self.highest_wind)}"

    def __call__(self, scenes: Sequence[Scene], carry_on: CarryOn) -> list[Row]:
        """Estimate for a group of scenes, each by itself."""
        return one_by_one(self._look, scenes, carry_on)

    def _look(self, scene: Scene) -> Row:
        wind = scene.wind.mean_speed
        highest = REACH * wind if self.highest_wind is None else self.highest_wind
        check_wind(scene, wind, highest)
        pair, found = frequency_ratio(scene), two_mode_estimate(scene, wind, highest)
        gallops = found.vertical_amplitude > 0.0
        return {
            "suspect": found.threshold_amplitude is not None or abs(pair.detuning) < NEAR,
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


def screen_spans(
    scene: Scene | SceneSpec | str | Path | None = None,
    over: Mapping[str, Sequence[Any]] | None = None,
    *,
    table: SpanTable | None = None,
    highest_wind: float | None = None,
    first_look: bool = False,
    out: Path | str | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> Runs:
    """`modal.screen` for a scene over values of its parameters, or every span of a table, or both.

    Parameters
    ----------
    scene, over, table, out, cluster, progress
        As for `gallop_fmu.sweep`.
    highest_wind
        Highest wind speed [m/s] looked at; None takes 1.5 times each scene's.
    first_look
        In place of `modal.screen` only `modal.two_mode_estimate`, about thirty times as fast: for
        thousands of spans, of which the ``suspect`` ones are then screened. The estimate may miss
        an onset, mostly above 2:1; so a span is suspect as soon as it has a threshold in sight
        (`benchmarks/speed/corridor.py` compares).
    workers
        Number of processes; None takes one for each core. With 1, and where no process can be
        started, all is computed in this one.

    Returns
    -------
    Runs
        One row a span with the columns of `SCREENING_COLUMNS` or `FIRST_LOOK_COLUMNS`, also for
        those that could not be screened: ``outcome`` and ``message`` tell why.

    Raises
    ------
    SceneError, RunsStoppedError
        As for `gallop_fmu.sweep`.

    Examples
    --------
    >>> import modal
    >>> found = modal.screen_spans("example3", {"span.sag": [2.08, 2.12]}, highest_wind=5.6)
    >>> found.dataset.risk.values.tolist()
    ['certain', 'certain']
    """
    task = FirstLookTask(highest_wind) if first_look else ScreeningTask(highest_wind)
    return compute(
        cases(scene, over, table), task, out=out, count=workers, cluster=cluster, progress=progress
    )
