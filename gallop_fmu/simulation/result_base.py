"""What the results of a span and of a line share: report, window, warnings, files."""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from html import escape
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.atomic_write import netcdf_bytes, write_whole
from gallop_fmu.foundation.channels import DESCRIBED
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.foundation.outcome import Outcome, Report
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.provenance import Histories
from gallop_fmu.simulation.steadiness import MIN_SAMPLES, Motion, default_window

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

WORK = ("steps", "iterations", "refactorisations", "seconds")
"""Attributes of a dataset on the work of the run."""

AnyScene = TypeVar("AnyScene", bound=Scene | LineScene)


@dataclass(frozen=True)
class ResultBase(ABC, Generic[AnyScene]):
    """Result of a run.

    Each recorded channel is an attribute, too: ``result.u2`` is its history at mid-span.

    Attributes
    ----------
    dataset : xarray.Dataset
        Histories over ``time`` [s]. Each variable has ``units`` and ``long_name``;
        ``dataset.attrs`` holds the provenance.
    scene : Scene or LineScene
        The scene of the run.
    report : Report
        Outcome of the run, and counts of its work.
    """

    dataset: xr.Dataset
    scene: AnyScene
    report: Report

    @classmethod
    def of_histories(cls, recorded: Histories, scene: AnyScene, report: Report) -> Self:
        """Return a result whose dataset is made when it is used."""
        result = cls.__new__(cls)
        vars(result).update(recorded=recorded, scene=scene, report=report)
        return result

    @cached_property
    def recorded(self) -> Histories:
        """The histories as arrays."""
        return Histories.of(self.dataset)

    @property
    def outcome(self) -> Outcome:
        """Outcome of the run."""
        return self.report.outcome

    @property
    def started(self) -> bool:
        """True if an initial state exists. Otherwise the only record, at 0 s, is NaN."""
        values = next(iter(self.recorded.values.values()))
        return len(self.recorded.time) > 1 or bool(np.isfinite(values).all())

    @cached_property
    @abstractmethod
    def warnings(self) -> tuple[str, ...]:
        """Warnings that limit the trust in the results, each a fact and a remedy."""

    @cached_property
    def motion(self) -> Motion:
        """Judgement of the motion at the end of the run."""
        return self.judged()

    @abstractmethod
    def judged(self, window: float | None = None) -> Motion:
        """Judge the motion over the last `window` s (default: 100 s, at most half of the run)."""

    @cached_property
    def sheddings(self) -> pd.DataFrame:
        """Table of ice that falls: time, jump, final rise; of a line also pulls and clearance.

        A row for each part of a conductor; ``table.attrs["units"]`` has the units. The time is NaN
        where the ice did not fall.
        """
        from gallop_fmu.simulation.shedding import sheddings

        return sheddings(self)  # type: ignore[arg-type]

    @abstractmethod
    def _history(self, channel: str) -> xr.DataArray:
        """Return a recorded channel; of a channel of the nodes, its history at mid-span."""

    @abstractmethod
    def _table(self) -> tuple[pd.DataFrame, dict[str, str]]:
        """Return the histories of a table by time, and the unit of each column."""

    def __getattr__(self, name: str) -> Any:
        """Return the history of a channel, such as ``result.u2`` at mid-span.

        Raises
        ------
        AttributeError
            There is no such channel, or it was not recorded.
        """
        if name == "dataset" and "recorded" in vars(self):
            vars(self)["dataset"] = self.recorded.dataset()
            return vars(self)["dataset"]
        if hasattr(type(self), name):
            object.__getattribute__(self, name)  # raises the error that led here
        if name not in DESCRIBED:
            kind = type(self).__name__
            known = [] if name.startswith("_") else dir(self)
            near = difflib.get_close_matches(name, known, n=1)
            closest = f"; closest: {near[0]}" if near else ""
            raise AttributeError(f"{kind} has no attribute or channel {name!r}{closest}")
        if name not in self.recorded.values:
            recorded = ", ".join(self.recorded.values)
            raise AttributeError(f"{name} was not recorded; the run has {recorded}")
        try:
            return self._history(name)
        except SceneError as problem:
            raise AttributeError(str(problem)) from None

    def __dir__(self) -> list[str]:
        """Public attributes and recorded channels, for completion by the tab key."""
        own = {name for name in super().__dir__() if not name.startswith("_")}
        return sorted(own | {str(name) for name in self.dataset.data_vars if name in DESCRIBED})

    def to_dataframe(self) -> pd.DataFrame:
        """Return the histories at mid-span, of a line also of towers and strings, as a table.

        Returns
        -------
        pandas.DataFrame
            By time [s]. Columns are those of a CSV file that `save` writes;
            ``frame.attrs["units"]`` has their units.
        """
        frame, units = self._table()
        frame.attrs["units"] = units
        return frame

    def plot(self, **options: Any) -> Any:
        """Draw the run: `gallop_fmu.plots.overview`, of a line `line_plots.line_histories`.

        Parameters
        ----------
        **options
            Of the function.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn(f"{type(self).__name__}.plot", self, **options)

    def trace(self, **options: Any) -> Any:
        """Draw the path of mid-span: `gallop_fmu.plots.trace`, of a line `line_plots.line_paths`.

        Parameters
        ----------
        **options
            Of the function.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn(f"{type(self).__name__}.trace", self, **options)

    def __repr__(self) -> str:
        times = self.recorded.time
        lines = [
            f"Result of {self.scene.title!r}: {self.report}",
            f"{len(times)} records to {times[-1]:g} s; motion: {self.motion}",
        ]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])

    def _repr_html_(self) -> str:
        """The text of ``repr`` and the dataset's own view, for notebooks."""
        return f"<pre>{escape(repr(self))}</pre>{self.dataset._repr_html_()}"

    def window(self, wanted: float | None = None) -> tuple[float, float]:
        """Return the start and end [s] of the last `wanted` s (default: 100 s or half of the run).

        Raises
        ------
        SceneError
            The run is shorter.
        """
        time = self.recorded.time
        first, last = float(time[0]), float(time[-1])
        length = wanted
        if length is None:
            length = default_window(last - first) if len(time) >= MIN_SAMPLES else last - first
        if not 0.0 < length <= last - first:
            asked = (
                ""
                if wanted is None
                else f"window = {wanted} s must be positive and no longer than the run: "
            )
            records = len(time)
            has = (
                f"{records} records over {last - first:g} s"
                if records > 1
                else f"one record, at {first:g} s"
            )
            why = "" if self.outcome is Outcome.COMPLETED else f". {self.report}"
            raise SceneError(f"{asked}the run has {has}{why}")
        return last - length, last

    def in_window(self, wanted: float | None = None) -> NDArray[np.bool_]:
        """Return which records are in the `window` at the end of the run.

        Raises
        ------
        SceneError
            The run is shorter, or the window contains fewer than two records.
        """
        start, stop = self.window(wanted)
        time = self.recorded.time
        found: NDArray[np.bool_] = time >= start - 1e-9
        if np.count_nonzero(found) < 2:
            raise SceneError(
                f"window = {stop - start} s: contains fewer than two records, which are"
                f" {time[1] - time[0]:g} s apart; give a longer window"
            )
        return found

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

    def numbers(self) -> dict[str, object]:
        """Return what a summary of each run has, in plain numbers and words."""
        facts, end = self.recorded.facts, float(self.recorded.time[-1])
        return {
            "title": self.scene.title,
            "outcome": self.report.outcome.name.lower(),
            "message": str(self.report),
            "warnings": list(self.warnings),
            "time": self.report.time,
            "motion": str(self.motion),
            **{key: facts[key] for key in WORK},
            "real_time_factor": end / max(float(facts["seconds"]), 1e-9),
            "lowest_tension": self.report.lowest_tension,
            **({"sheddings": self.sheddings.to_dict("records")} if self.scene.shedding else {}),
        }
