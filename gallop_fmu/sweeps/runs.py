"""Results of many runs: rows, failures, and the same over a grid."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.sweeps.results_file import HEADER
from gallop_fmu.sweeps.row_store import read
from gallop_fmu.sweeps.rows import Header, as_cell

if TYPE_CHECKING:
    import xarray as xr

COMPLETED = Outcome.COMPLETED.name.lower()


@dataclass(frozen=True)
class Runs:
    """The results of many runs.

    Attributes
    ----------
    dataset : xarray.Dataset
        One row for each finished run, over the dimension ``run``: varied values, ``outcome``,
        ``message``, ``seconds``, and results, with ``units`` and ``long_name``. Results of the
        spans and towers of lines are also over ``span`` or ``tower``, and ``phase`` if there are
        several. Missing numbers are NaN.
    """

    dataset: xr.Dataset

    @property
    def total(self) -> int:
        """Number of all runs, finished or not."""
        return int(self._header["runs"])

    @property
    def done(self) -> int:
        """Number of finished runs."""
        return int(self.dataset.sizes["run"])

    @property
    def varied(self) -> list[str]:
        """Columns that distinguish the runs: the name of a span, and the parameters of the grid."""
        return list(self._header["grid"])

    @property
    def failed(self) -> xr.Dataset:
        """Rows of runs that did not complete."""
        return self.dataset.isel(run=self.dataset.outcome.values != COMPLETED)

    def grid(self) -> xr.Dataset:
        """Results over one dimension for each parameter, and ``name`` for the spans of a table.

        Results of the spans and towers of lines have also their dimensions. Runs that are not
        finished are NaN or ``""``.
        """
        import xarray as xr

        axes = self._header["grid"]
        shape = tuple(map(len, axes.values()))
        index = self.dataset.run.values
        gridded = xr.Dataset(
            coords={name: [as_cell(value) for value in values] for name, values in axes.items()}
        ).assign_coords(self.dataset.drop_vars("run").coords)
        for name, column in self.dataset.data_vars.items():
            if name in axes:
                gridded[name].attrs = column.attrs
                continue
            text = column.dtype == object
            places = column.shape[1:]  # spans or towers, and phases
            values = np.full(
                (int(np.prod(shape)), *places),
                "" if text else np.nan,
                dtype=object if text else np.float64,
            )
            values[index] = column.values
            dimensions = (*axes, *column.dims[1:])
            gridded[name] = (dimensions, values.reshape(*shape, *places), column.attrs)
        return gridded

    @property
    def _header(self) -> Header:
        header: Header = json.loads(self.dataset.attrs[HEADER])
        return header


def read_runs(path: Path | str) -> Runs:
    """Read the results of a sweep or screening, also while it runs or after it was killed.

    Parameters
    ----------
    path
        File of the sweep. Its journal ``FILE.journal`` is read if it exists, otherwise the file
        itself.

    Raises
    ------
    SceneError
        Neither exists, or it holds something else.
    """
    return Runs(read(path))


class RunsStoppedError(RuntimeError):
    """Many runs that ended early; ``result`` holds the finished ones."""

    def __init__(self, message: str, result: Runs) -> None:
        super().__init__(message)
        self.result = result
