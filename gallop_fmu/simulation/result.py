"""Result of a simulation: histories with units, report, and provenance."""

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

from gallop_fmu.engine.equilibrium import Equilibrium
from gallop_fmu.engine.library import build
from gallop_fmu.foundation.atomic_write import netcdf_bytes, write_whole
from gallop_fmu.foundation.channels import DESCRIBED, END_FORCES
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import Outcome, Report
from gallop_fmu.foundation.version import program
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.run_warnings import run_warnings
from gallop_fmu.simulation.steadiness import (
    MIN_SAMPLES,
    REST_AMPLITUDE,
    TWIST_LEVER,
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
"""Channels for the judgement of a motion, and their names in words."""

SMALL_OF = {
    "m": REST_AMPLITUDE,
    "m/s": REST_AMPLITUDE,
    "m/s2": REST_AMPLITUDE,
    "rad": REST_AMPLITUDE / TWIST_LEVER,
    "rad/s": REST_AMPLITUDE / TWIST_LEVER,
    "rad/s2": REST_AMPLITUDE / TWIST_LEVER,
}
"""Unit to the amplitude below which a channel is at rest.

For other units it is `REST_AMPLITUDE` times the maximum of the channel."""


class Oscillation(NamedTuple):
    """Oscillation of one channel over a window.

    Attributes
    ----------
    amplitude, mean
        Half peak-to-peak, and mean, in the channel's unit.
    frequency_hz
        Dominant frequency [Hz]; NaN without one, see
        `gallop_fmu.simulation.steadiness.dominant_frequency`.
    motion
        Judgement of the motion. Only for a steady motion are the numbers valid beyond the window.
    """

    amplitude: float
    mean: float
    frequency_hz: float
    motion: Motion

    @property
    def is_steady(self) -> bool:
        """True if the motion is steady or at rest."""
        return self.motion.is_steady

    def as_dict(self) -> dict[str, float | str]:
        """Return plain numbers and text, for JSON."""
        return {**self._asdict(), "motion": str(self.motion)}

    def text(self, unit: str, scale: float = 1.0, digits: str = ".3f") -> str:
        """Return the amplitude, with the motion unless it is steady: ``0.026 m, still growing``."""
        size = f"{self.amplitude * scale:{digits}} {unit}"
        return size if self.motion.kind == "steady" else f"{size}, {self.motion}"


class Oscillations(dict[str, Oscillation]):
    """Oscillation of each mid-span channel by name.

    Attributes
    ----------
    start, stop : float
        Start and end [s] of the window.
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
    """Return a dominant frequency as text; a dash for NaN."""
    return f"{frequency_hz:.4f}" if math.isfinite(frequency_hz) else "-"


def slowest_frequency(data: xr.Dataset) -> float:
    """Return the lower dominant frequency [Hz] of u2 and u3 in the second half of a run, or NaN.

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
    """Return the oscillation of equally spaced samples with a unit."""
    amplitude, mean, frequency = measure(values, interval)
    floor = SMALL_OF.get(unit, REST_AMPLITUDE * (abs(mean) + amplitude))
    return Oscillation(amplitude, mean, frequency, judge(values, interval, floor, frequency))


def measure(values: Array, interval: float) -> tuple[float, float, float]:
    """Return half peak-to-peak, mean and dominant frequency [Hz] of equally spaced samples."""
    return 0.5 * float(np.ptp(values)), float(np.mean(values)), dominant_frequency(values, interval)


@dataclass(frozen=True)
class Result:
    """Result of a run.

    Attributes
    ----------
    dataset : xarray.Dataset
        Dimensions ``time`` [s] and ``node``; node channels (u1, u2, u3, theta, tension, ...) over
        both, span channels (wind_speed, support forces, energies, ...) over time.  Each variable
        has ``units`` and ``long_name``; ``dataset.attrs`` holds the provenance.
    scene : Scene
        The scene of the run.
    report : Report
        Outcome of the run, and counts of its work.
    """

    dataset: xr.Dataset
    scene: Scene
    report: Report

    @property
    def outcome(self) -> Outcome:
        """Outcome of the run."""
        return self.report.outcome

    @property
    def started(self) -> bool:
        """True if an initial state exists. Otherwise the only record, at 0 s, is NaN."""
        values = next(iter(self.dataset.data_vars.values())).values
        return len(self.dataset.time) > 1 or bool(np.isfinite(values).all())

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that limit the trust in the results, each a fact and a remedy."""
        return run_warnings(self.dataset, self.scene, self.report)

    def __repr__(self) -> str:
        times = self.dataset.time.values
        lines = [
            f"Result of {self.scene.title!r}: {self.report}",
            f"{len(times)} records to {times[-1]:g} s; motion: {self.motion}",
        ]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])

    def midspan(self) -> xr.Dataset:
        """Return the histories of the mid-span node.

        Raises
        ------
        SceneError
            The mid-span node was not recorded.
        """
        middle = self.scene.numerics.elements
        if middle not in self.dataset.node:
            raise SceneError(
                f"the mid-span node {middle} was not recorded; simulate with"
                ' record_nodes="midspan" or "all"'
            )
        return self.dataset.sel(node=middle)

    @cached_property
    def motion(self) -> Motion:
        """Judgement of the motion at the end of the run, from mid-span and quarter points.

        Quarter points are used if they were recorded. `gallop_fmu.simulation.steadiness` has the
        kinds and their bounds.
        """
        return self.judged()

    def judged(self, window: float | None = None) -> Motion:
        """Judge the motion over the last `window` s (default: 100 s, at most half of the run)."""
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
        """Return the start and end [s] of the last `wanted` s (default: 100 s or half of the run).

        Raises
        ------
        SceneError
            The run is shorter.
        """
        first, last = (float(self.dataset.time.values[k]) for k in (0, -1))
        length = wanted
        if length is None:
            length = (
                default_window(last - first)
                if len(self.dataset.time) >= MIN_SAMPLES
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
        """Return the oscillation of each mid-span channel at the end of the run.

        The ``motion`` of each is its judgement: steady, still growing, ...

        Parameters
        ----------
        window
            Length [s] of the window (default: 100 s, at most half of the run); the result has its
            ``start`` and ``stop``.

        Raises
        ------
        SceneError
            The run is shorter than the window, or has too few records.
        """
        return self.between(*self.window(window))

    def between(self, start: float, stop: float) -> Oscillations:
        """Return the oscillation of each mid-span channel from `start` to `stop` [s]."""
        part = self.midspan().sel(time=slice(start - 1e-9, stop + 1e-9))
        if part.sizes["time"] < 2:
            raise SceneError(
                f"there are fewer than two records from {start} s to {stop} s; give a longer window"
            )
        interval = float(part.time[1] - part.time[0])
        units = {str(name): str(part[name].attrs.get("units", "")) for name in part.data_vars}
        found = {
            name: oscillation(part[name].values, interval, unit) for name, unit in units.items()
        }
        return Oscillations(found, start, stop)

    def save(self, path: Path | str) -> Path:
        """Write all histories as ``.nc`` (NetCDF), or those at mid-span as ``.csv``, ``.parquet``.

        Parquet needs the extra ``parquet``; units and provenance are attributes of the table. The
        file is replaced atomically: if it cannot be written, an older file is unchanged.

        Raises
        ------
        SceneError
            The suffix is another one, or pyarrow is missing.
        OSError
            The file cannot be written, for example on a full disk.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix == ".nc":
            content = netcdf_bytes(self.dataset.assign_attrs(self._judgement()))
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
            frame.attrs = {
                "units": {"time": "s", **units},
                **self.dataset.attrs,
                **self._judgement(),
            }
            content = frame.to_parquet(engine="pyarrow")
        else:
            raise SceneError(
                f"{path}: results are not written as {path.suffix or 'files without suffix'};"
                " choose .nc (NetCDF), .csv or .parquet"
            )
        write_whole(path, content)
        return path

    def _judgement(self) -> dict[str, str]:
        """Attributes of a file about the motion."""
        return {"motion": str(self.motion), "warnings": " ".join(self.warnings)}

    def _table(self) -> tuple[pd.DataFrame, dict[str, str]]:
        """Return the mid-span histories by time, and the unit of each column."""
        frame = self.midspan().drop_vars(["node", "x1"]).to_dataframe()
        return frame, {str(name): self.dataset[name].attrs["units"] for name in frame.columns}


class Provenance(NamedTuple):
    """Origin of histories: scene, initial equilibrium, report, and details of the computation.

    Attributes
    ----------
    scene, equilibrium, report
        The scene, its initial equilibrium (None: it has none), and the report on the run.
    seconds
        Wall-clock time [s] of the run.
    details
        Further attributes of the dataset.
    """

    scene: Scene
    equilibrium: Equilibrium | None
    report: Report
    seconds: float
    details: Mapping[str, object]

    def attributes(self) -> dict[str, object]:
        """Return the attributes of the dataset."""
        equilibrium, report = self.equilibrium, self.report
        counts = ("steps", "substeps", "iterations", "refactorisations", "halvings", "rejections")
        extremes = ("lowest_tension", "largest_turn")
        nan = math.nan
        return {
            "title": self.scene.title,
            "source": program(),
            "kernel": build(),
            **self.details,
            "scene": self.scene.to_toml(),
            "outcome": report.outcome.name.lower(),
            "message": str(report),
            "seconds": self.seconds,
            "sag": nan if equilibrium is None else equilibrium.sag,
            "horizontal_tension": nan if equilibrium is None else equilibrium.horizontal_tension,
            "held_imbalance": nan if equilibrium is None else equilibrium.imbalance,
            **{name: getattr(report, name) for name in counts + extremes},
        }


def histories(
    variables: Mapping[str, tuple[tuple[str, ...], Array]],
    time: NDArray[np.floating],
    nodes: NDArray[np.int32],
    x1: Array,
    provenance: Provenance,
) -> xr.Dataset:
    """Return the dataset of a `Result`: channels with units and meanings, and their provenance.

    Parameters
    ----------
    variables
        Channel to its dimensions and values.
    time : ndarray, shape (time,)
        Times of the records [s].
    nodes, x1 : ndarray, shape (node,)
        Numbers of the recorded nodes, and their positions [m] along the span.
    provenance
        Origin of the values.
    """
    import xarray as xr  # a slow import (0.3 s)

    def meaning(name: str) -> str:
        text = DESCRIBED[name].meaning
        if name not in END_FORCES:
            return text
        remark = provenance.scene.supports.remark_on_force(name.partition("_")[0])
        return f"{text}; {remark}" if remark else text

    described = {
        name: (*content, {"units": DESCRIBED[name].unit, "long_name": meaning(name)})
        for name, content in variables.items()
    }
    times = ("time", time, {"units": "s", "long_name": "time"})
    places = ("node", x1, {"units": "m", "long_name": "position of the node along the span"})
    dataset = xr.Dataset(described, {"time": times, "node": nodes, "x1": places})
    return dataset.assign_attrs(provenance.attributes())


def summary(result: Result) -> dict[str, object]:
    """Summarise a run in plain numbers and words, for a terminal or as JSON."""
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
