"""What a simulation returns: labelled histories with units, how the run ended, and where the numbers come from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.library import build
from gallop_fmu.engine.model import Equilibrium
from gallop_fmu.foundation.atomic_write import netcdf_bytes, write_whole
from gallop_fmu.foundation.channels import DESCRIBED, END_FORCES
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import Outcome, Report
from gallop_fmu.foundation.version import program
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.run_warnings import run_warnings
from gallop_fmu.simulation.steadiness import (
    FEWEST_SAMPLES,
    LEVER,
    SMALL,
    Motion,
    default_window,
    dominant_frequency,
    judge,
    judge_span,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Array = NDArray[np.float64]


MOVES = {"u2": "vertical", "u3": "horizontal", "theta": "twist"}
"""What the motion of a span is judged by, and its names in words."""

SMALL_OF = {
    "m": SMALL,
    "m/s": SMALL,
    "m/s2": SMALL,
    "rad": SMALL / LEVER,
    "rad/s": SMALL / LEVER,
    "rad/s2": SMALL / LEVER,
}
"""Amplitude below which a channel of this unit is at rest; of another unit, `SMALL` of its greatest value."""


class Oscillation(NamedTuple):
    """Motion of one channel over a window.

    Attributes
    ----------
    amplitude, mean
        Half peak-to-peak, and mean, in the channel's unit.
    frequency_hz
        Dominant frequency [Hz]; NaN where there is none, see
        `gallop_fmu.simulation.steadiness.dominant_frequency`.
    motion
        Whether it is steady, and what it does if it is not. Only of a steady motion do the numbers
        hold for longer than the window.
    """

    amplitude: float
    mean: float
    frequency_hz: float
    motion: Motion

    @property
    def is_steady(self) -> bool:
        """Whether the motion is steady, or at rest."""
        return self.motion.is_steady

    def as_dict(self) -> dict[str, float | str]:
        """The same as plain numbers and text, for JSON."""
        return {**self._asdict(), "motion": str(self.motion)}

    def text(self, unit: str, scale: float = 1.0, digits: str = ".3f") -> str:
        """The amplitude with its unit, and what the motion does unless it is steady: ``0.026 m, still growing``."""
        size = f"{self.amplitude * scale:{digits}} {unit}"
        return size if self.motion.kind == "steady" else f"{size}, {self.motion}"


class Oscillations(dict[str, Oscillation]):
    """Oscillation of each mid-span channel by name.

    Attributes
    ----------
    start, stop : float
        Window [s] that the oscillations are of.
    """

    def __init__(self, channels: Mapping[str, Oscillation], start: float, stop: float) -> None:
        super().__init__(channels)
        self.start, self.stop = start, stop

    def __repr__(self) -> str:
        rows = [
            f"  {name}: {each.amplitude:.5g} at {frequency_text(each.frequency_hz)} Hz,"
            f" {each.motion}"
            for name, each in self.items()
        ]
        return "\n".join(
            [f"Oscillations from {self.start:g} to {self.stop:g} s (half peak-to-peak)", *rows]
        )


def frequency_text(frequency_hz: float) -> str:
    """A dominant frequency for a table; a dash where there is none."""
    return f"{frequency_hz:.4f}" if math.isfinite(frequency_hz) else "-"


def slowest_frequency(data: xr.Dataset) -> float:
    """Dominant frequency [Hz] of the slower of u2 and u3 in the second half of a run; NaN where both are still.

    Parameters
    ----------
    data
        Dataset with u2 and u3 over ``time`` [s] at mid-span.
    """
    time = np.asarray(data.time.values)
    late = slice(len(time) // 2, None)
    interval = float(time[1] - time[0]) if len(time) > 1 else math.nan
    found = [
        dominant_frequency(np.asarray(data[name].values)[late], interval) for name in ("u2", "u3")
    ]
    return min((frequency for frequency in found if math.isfinite(frequency)), default=math.nan)


def oscillation(values: Array, interval: float, unit: str = "m") -> Oscillation:
    """Amplitude, mean, frequency and judgement of equally spaced samples of a unit."""
    amplitude, mean, frequency = measure(values, interval)
    floor = SMALL_OF.get(unit, SMALL * (abs(mean) + amplitude))
    return Oscillation(amplitude, mean, frequency, judge(values, interval, floor, frequency))


def measure(values: Array, interval: float) -> tuple[float, float, float]:
    """Half peak-to-peak, mean and dominant frequency [Hz] of equally spaced samples, whatever their motion."""
    return 0.5 * float(np.ptp(values)), float(np.mean(values)), dominant_frequency(values, interval)


@dataclass(frozen=True)
class Result:
    """Histories of a run.

    Attributes
    ----------
    dataset : xarray.Dataset
        Dimensions ``time`` [s] and ``node``; node channels (u1, u2, u3, theta, tension, ...) over
        both, span channels (wind_speed, support forces, energies, ...) over time.  Each variable
        has ``units`` and ``long_name``; ``dataset.attrs`` holds the provenance.
    scene : Scene
        What was computed.
    report : Report
        How the run ended and how much work it was.
    """

    dataset: xr.Dataset
    scene: Scene
    report: Report

    @property
    def outcome(self) -> Outcome:
        """How the run ended."""
        return self.report.outcome

    @property
    def started(self) -> bool:
        """Whether an initial state exists. If not, the only record, at 0 s, is NaN."""
        values = next(iter(self.dataset.data_vars.values())).values
        return len(self.dataset.time) > 1 or bool(np.isfinite(values).all())

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what limits the trust in the numbers; empty if nothing does."""
        return run_warnings(self.dataset, self.scene, self.report)

    def __repr__(self) -> str:
        times = self.dataset.time.values
        lines = [
            f"Result of {self.scene.title!r}: {self.report}",
            f"{len(times)} records to {times[-1]:g} s; motion: {self.motion}",
        ]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])

    def midspan(self) -> xr.Dataset:
        """The histories at the mid-span node alone.

        Raises
        ------
        SceneError
            If the mid-span node was not recorded.
        """
        middle = self.scene.numerics.elements
        if middle not in self.dataset.node:
            raise SceneError(
                f'the mid-span node {middle} was not recorded; ask for record_nodes="midspan" or'
                ' "all"'
            )
        return self.dataset.sel(node=middle)

    @cached_property
    def motion(self) -> Motion:
        """What the span does at the end of the run, from mid-span and, if recorded, its quarter points.

        See `gallop_fmu.simulation.steadiness` for the kinds and their bounds.
        """
        return self.judged()

    def judged(self, window: float | None = None) -> Motion:
        """Judge the motion of the span over the last `window` seconds; None takes 100 s, at most half of the run."""
        elements, nodes = self.scene.numerics.elements, self.dataset.node.values.tolist()
        if elements not in nodes:
            return Motion("undetermined", "mid-span was not recorded")
        places = {
            elements: "",
            round(0.5 * elements): " at a quarter",
            round(1.5 * elements): " at three quarters",
        }
        histories = {
            f"{title}{place}": self.dataset[name].values[:, nodes.index(node)]
            for node, place in places.items()
            if node in nodes
            for name, title in MOVES.items()
            if name in self.dataset
        }
        if not histories:
            return Motion("undetermined", "no displacement was recorded")
        return judge_span(self.dataset.time.values, histories, window)

    def window(self, wanted: float | None = None) -> tuple[float, float]:
        """Start and stop [s] of the last `wanted` seconds; None takes 100 s, at most half of the run.

        Raises
        ------
        SceneError
            If the run is shorter.
        """
        first, last = (float(self.dataset.time.values[k]) for k in (0, -1))
        length = wanted
        if length is None:
            length = (
                default_window(last - first)
                if len(self.dataset.time) >= FEWEST_SAMPLES
                else last - first
            )
        if not 0.0 < length <= last - first:
            asked = (
                ""
                if wanted is None
                else f"window = {wanted} s must be positive and no longer than the run: "
            )
            records = len(self.dataset.time)
            has = (
                f"{records} records over {last - first:g} s"
                if records > 1
                else f"one record, at {first:g} s"
            )
            why = "" if self.outcome is Outcome.COMPLETED else f". {self.report}"
            raise SceneError(f"{asked}the run has {has}{why}")
        return last - length, last

    def steady(self, window: float | None = None) -> Oscillations:
        """Oscillation of each mid-span channel at the end of the run.

        Each has its ``motion``: whether it is steady, still growing, and so on.

        Parameters
        ----------
        window
            Length [s] of the window; None takes 100 s, at most half of the run. ``start`` and
            ``stop`` of what is returned say which it was.

        Raises
        ------
        SceneError
            If the run is shorter than the window, or holds too few records.
        """
        return self.between(*self.window(window))

    def between(self, start: float, stop: float) -> Oscillations:
        """Oscillation of each mid-span channel from `start` to `stop` [s]."""
        part = self.midspan().sel(time=slice(start - 1e-9, stop + 1e-9))
        if part.sizes["time"] < 2:
            raise SceneError(f"fewer than two records lie between {start} s and {stop} s")
        interval = float(part.time[1] - part.time[0])
        units = {str(name): str(part[name].attrs.get("units", "")) for name in part.data_vars}
        found = {
            name: oscillation(part[name].values, interval, unit) for name, unit in units.items()
        }
        return Oscillations(found, start, stop)

    def save(self, path: Path | str) -> Path:
        """Write everything as NetCDF (``.nc``), or the mid-span histories as CSV or Parquet (``.csv``, ``.parquet``).

        Parquet needs the extra ``parquet``; units and provenance stand in the table's attributes.
        The file is replaced as a whole: if the new one cannot be written, an older one stays.

        Raises
        ------
        SceneError
            If the suffix is another one, or pyarrow is missing.
        OSError
            If the file cannot be written, such as on a full disk.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix == ".nc":
            content = netcdf_bytes(self.dataset.assign_attrs(self._verdict()))
        elif suffix == ".csv":
            frame, units = self._table()
            header = ",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in units.items())])
            table = np.column_stack([frame.index.to_numpy(), frame.to_numpy()])
            text = StringIO()
            np.savetxt(text, table, delimiter=",", header=header, comments="", fmt="%.12g")
            content = text.getvalue().encode()
        elif suffix == ".parquet":
            if find_spec("pyarrow") is None:
                raise SceneError(
                    f"{path}: Parquet needs pyarrow; install it with pip install"
                    ' "gallop-fmu[parquet]"'
                )
            frame, units = self._table()
            frame.attrs = {"units": {"time": "s", **units}, **self.dataset.attrs, **self._verdict()}
            content = frame.to_parquet(engine="pyarrow")
        else:
            raise SceneError(
                f"{path}: results are written as .nc (NetCDF), .csv or .parquet, not as"
                f" {path.suffix or 'no suffix'}"
            )
        write_whole(path, content)
        return path

    def _verdict(self) -> dict[str, str]:
        """What a file says about the motion, beside the histories."""
        return {"motion": str(self.motion), "warnings": " ".join(self.warnings)}

    def _table(self) -> tuple[pd.DataFrame, dict[str, str]]:
        """The mid-span histories by time, and the unit of each column."""
        frame = self.midspan().drop_vars(["node", "x1"]).to_dataframe()
        return frame, {str(name): self.dataset[name].attrs["units"] for name in frame.columns}


def histories(
    variables: Mapping[str, tuple[tuple[str, ...], Array]],
    time: NDArray[np.floating],
    nodes: NDArray[np.int32],
    x1: Array,
    scene: Scene,
    rest: Equilibrium | None,
    report: Report,
    seconds: float,
    **how: object,
) -> xr.Dataset:
    """The dataset of a `Result`: channels with units and meanings, and their provenance.

    Parameters
    ----------
    variables
        Channel to its dimensions and values.
    time : ndarray, shape (time,)
        Times of the records [s].
    nodes, x1 : ndarray, shape (node,)
        Numbers of the recorded nodes, and their positions [m] along the span.
    scene, rest, report, seconds
        What was computed, its initial equilibrium (None: it has none), how the run ended, and the
        wall-clock time [s] that it took.
    **how
        What else there is to say of how it was computed.
    """
    import xarray as xr  # a third of a second, which `import gallop_fmu` should not cost

    def meaning(name: str) -> str:
        remark = (
            scene.supports.remark_on_force(name.partition("_")[0]) if name in END_FORCES else ""
        )
        return f"{DESCRIBED[name].meaning}; {remark}" if remark else DESCRIBED[name].meaning

    described = {
        name: (*content, {"units": DESCRIBED[name].unit, "long_name": meaning(name)})
        for name, content in variables.items()
    }
    times = ("time", time, {"units": "s", "long_name": "time"})
    places = ("node", x1, {"units": "m", "long_name": "position of the node along the span"})
    dataset = xr.Dataset(described, {"time": times, "node": nodes, "x1": places})
    work = ("steps", "substeps", "iterations", "refactorisations", "halvings", "rejections")
    extremes = ("lowest_tension", "largest_turn")
    dataset.attrs.update(
        title=scene.title,
        source=program(),
        kernel=build(),
        **how,
        scene=scene.to_toml(),
        outcome=report.outcome.name.lower(),
        message=str(report),
        seconds=seconds,
        sag=math.nan if rest is None else rest.sag,
        horizontal_tension=math.nan if rest is None else rest.horizontal_tension,
        held_imbalance=math.nan if rest is None else rest.imbalance,
        **{name: getattr(report, name) for name in work + extremes},
    )
    return dataset


def summary(result: Result) -> dict[str, object]:
    """The run in a few plain numbers and words, for a terminal or as JSON."""
    report, time = result.report, result.dataset.time.values
    steady = (
        result.steady()
        if len(time) > 1 and "u2" in result.dataset
        else Oscillations({}, 0.0, float(time[-1]))
    )
    return {
        "title": result.scene.title,
        "outcome": report.outcome.name.lower(),
        "message": str(report),
        "warnings": list(result.warnings),
        "time": report.time,
        "motion": str(result.motion),
        "window": steady.stop - steady.start,
        "midspan": {
            name: {
                **o.as_dict(),
                "lowest": float(result.midspan()[name].min()),
                "highest": float(result.midspan()[name].max()),
            }
            for name, o in steady.items()
            if name in ("u2", "u3", "theta", "tension")
        },
        **{
            key: result.dataset.attrs[key]
            for key in ("steps", "iterations", "refactorisations", "seconds")
        },
        "real_time_factor": float(time[-1]) / max(float(result.dataset.attrs["seconds"]), 1e-9),
        "lowest_tension": report.lowest_tension,
    }
