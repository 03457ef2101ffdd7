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

from gallop_fmu.channels import DESCRIBED
from gallop_fmu.engine import Equilibrium
from gallop_fmu.errors import SceneError
from gallop_fmu.files import netcdf_bytes, write_whole
from gallop_fmu.library import build
from gallop_fmu.outcome import Outcome, Report
from gallop_fmu.release import program
from gallop_fmu.run_warnings import run_warnings
from gallop_fmu.scene import Scene

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Array = NDArray[np.float64]


FEWEST_SAMPLES = 8
"""Below it no spectral line is told from another."""


class Oscillation(NamedTuple):
    """A steady oscillation: half peak-to-peak, mean (both in the channel's unit) and dominant frequency [Hz].

    The frequency is NaN where there is none, see `dominant_frequency`.
    """

    amplitude: float
    mean: float
    frequency_hz: float


def dominant_frequency(values: Array, interval: float) -> float:
    """Frequency [Hz] of the largest spectral line; NaN where there is none.

    That is so for a channel that does not move, and for fewer than `FEWEST_SAMPLES` samples.

    Parameters
    ----------
    values : ndarray, shape (time,)
        Samples.
    interval
        Time [s] between them.

    Notes
    -----
    Hann window, fourfold zero padding, and a parabola through the logarithms of the three largest lines.
    """
    if len(values) < FEWEST_SAMPLES or not np.ptp(values) > 1e-12 * max(1.0, float(np.max(np.abs(values)))):
        return math.nan
    samples = (values - np.mean(values)) * np.hanning(len(values))
    count = 4 * len(samples)
    spectrum = np.abs(np.fft.rfft(samples, count))
    peak = int(np.argmax(spectrum[1:-1])) + 1
    below, top, above = np.log(spectrum[peak - 1 : peak + 2] + 1e-300)
    curvature = below - 2.0 * top + above
    if not curvature < 0.0:  # no line stands out: what moved did so at the ends only, where the window is zero
        return math.nan
    return float((peak + 0.5 * (below - above) / curvature) / (count * interval))


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
    found = [dominant_frequency(np.asarray(data[name].values)[late], interval) for name in ("u2", "u3")]
    return min((frequency for frequency in found if math.isfinite(frequency)), default=math.nan)


def oscillation(values: Array, interval: float) -> Oscillation:
    """Amplitude, mean and frequency of equally spaced samples."""
    low, high = float(np.min(values)), float(np.max(values))
    return Oscillation(0.5 * (high - low), float(np.mean(values)), dominant_frequency(values, interval))


@dataclass(frozen=True)
class Result:
    """Histories of a run.

    Attributes
    ----------
    dataset : xarray.Dataset
        Dimensions ``time`` [s] and ``node``; node channels (u1, u2, u3, theta, tension, ...) over both, span channels
        (wind_speed, support forces, energies, ...) over time.  Each variable has ``units`` and ``long_name``;
        ``dataset.attrs`` holds the provenance.
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

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what limits the trust in the numbers; empty if nothing does."""
        return run_warnings(self.dataset, self.scene, self.report)

    def __repr__(self) -> str:
        times = self.dataset.time.values
        lines = [f"Result of {self.scene.title!r}: {self.report}", f"{len(times)} records to {times[-1]:g} s"]
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
            raise SceneError(f'the mid-span node {middle} was not recorded; ask for record_nodes="midspan" or "all"')
        return self.dataset.sel(node=middle)

    def steady(self, window: float = 100.0) -> dict[str, Oscillation]:
        """Oscillation of each mid-span channel over the last `window` seconds.

        Raises
        ------
        SceneError
            If the run is shorter than the window.
        """
        time = self.dataset.time.values
        if not 0.0 < window <= time[-1] - time[0]:
            raise SceneError(
                f"window = {window} s must be positive and no longer than the run of {time[-1] - time[0]} s"
            )
        return self.between(float(time[-1]) - window, float(time[-1]))

    def between(self, start: float, stop: float) -> dict[str, Oscillation]:
        """Oscillation of each mid-span channel from `start` to `stop` [s]."""
        part = self.midspan().sel(time=slice(start - 1e-9, stop + 1e-9))
        if part.sizes["time"] < 2:
            raise SceneError(f"fewer than two records lie between {start} s and {stop} s")
        interval = float(part.time[1] - part.time[0])
        return {str(name): oscillation(part[name].values, interval) for name in part.data_vars}

    def save(self, path: Path | str) -> Path:
        """Write everything as NetCDF (``.nc``), or the mid-span histories as CSV or Parquet (``.csv``, ``.parquet``).

        Parquet needs the extra ``parquet``; units and provenance stand in the table's attributes. The file is replaced
        as a whole: if the new one cannot be written, an older one stays.

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
                raise SceneError(f'{path}: Parquet needs pyarrow; install it with pip install "gallop-fmu[parquet]"')
            frame, units = self._table()
            frame.attrs = {"units": {"time": "s", **units}, **self.dataset.attrs, **self._verdict()}
            content = frame.to_parquet(engine="pyarrow")
        else:
            raise SceneError(
                f"{path}: results are written as .nc (NetCDF), .csv or .parquet, not as {path.suffix or 'no suffix'}"
            )
        write_whole(path, content)
        return path

    def _verdict(self) -> dict[str, str]:
        """What a file says about the motion, beside the histories."""
        return {"warnings": " ".join(self.warnings)}

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
    rest: Equilibrium,
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
        What was computed, its initial equilibrium, how the run ended, and the wall-clock time [s] that it took.
    **how
        What else there is to say of how it was computed.
    """
    import xarray as xr  # a third of a second, which `import gallop_fmu` should not cost

    described = {
        name: (*content, {"units": DESCRIBED[name].unit, "long_name": DESCRIBED[name].meaning})
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
        sag=rest.sag,
        horizontal_tension=rest.horizontal_tension,
        held_imbalance=rest.imbalance,
        **{name: getattr(report, name) for name in work + extremes},
    )
    return dataset


def summary(result: Result) -> dict[str, object]:
    """The run in a few plain numbers, for a terminal or as JSON."""
    report, time = result.report, result.dataset.time.values
    last = min(100.0, float(time[-1] - time[0]))
    steady = result.steady(last) if last > 0.0 and "u2" in result.dataset else {}
    return {
        "title": result.scene.title,
        "outcome": report.outcome.name.lower(),
        "message": str(report),
        "warnings": list(result.warnings),
        "time": report.time,
        "window": last,
        "midspan": {
            name: {"amplitude": o.amplitude, "mean": o.mean, "frequency_hz": o.frequency_hz}
            for name, o in steady.items()
            if name in ("u2", "u3", "theta", "tension")
        },
        **{key: result.dataset.attrs[key] for key in ("steps", "iterations", "refactorisations", "seconds")},
        "real_time_factor": float(time[-1]) / max(float(result.dataset.attrs["seconds"]), 1e-9),
        "lowest_tension": report.lowest_tension,
    }
