"""Results of many runs: labelled rows, failures, and the grid that they fill."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.sweeps.row_store import HEADER, as_cell, read

if TYPE_CHECKING:
    import xarray as xr

COMPLETED = Outcome.COMPLETED.name.lower()


@dataclass(frozen=True)
class Runs:
    """The results of many runs.

    Attributes
    ----------
    dataset : xarray.Dataset
        One row a run that is done, over the dimension ``run``: what was varied, ``outcome`` and
        ``message``, ``seconds``, and what was computed, with ``units`` and ``long_name``. Missing
        numbers are NaN.
    """

    dataset: xr.Dataset

    @property
    def total(self) -> int:
        """How many runs there are in all, done or not."""
        return int(self._header["runs"])

    @property
    def done(self) -> int:
        """How many are done."""
        return int(self.dataset.sizes["run"])

    @property
    def varied(self) -> list[str]:
        """What tells the runs apart: the name of a span, and the parameters of the grid."""
        return list(self._header["grid"])

    @property
    def failed(self) -> xr.Dataset:
        """The rows of runs that did not complete."""
        return self.dataset.isel(run=self.dataset.outcome.values != COMPLETED)

    def grid(self) -> xr.Dataset:
        """The same over one dimension for each parameter, and ``name`` for the spans of a table.

        Runs that are not done are NaN, or an empty text.
        """
        import xarray as xr

        axes: dict[str, list[Any]] = self._header["grid"]
        shape = tuple(map(len, axes.values()))
        place = self.dataset.run.values
        gridded = xr.Dataset(
            coords={name: [as_cell(value) for value in values] for name, values in axes.items()}
        )
        for name, column in self.dataset.data_vars.items():
            if name in axes:
                gridded[name].attrs = column.attrs
                continue
            text = column.dtype == object
            values = np.full(
                int(np.prod(shape)), "" if text else np.nan, dtype=object if text else np.float64
            )
            values[place] = column.values
            gridded[name] = (tuple(axes), values.reshape(shape), column.attrs)
        return gridded

    @property
    def _header(self) -> dict[str, Any]:
        return dict(json.loads(self.dataset.attrs[HEADER]))


def read_runs(path: Path | str) -> Runs:
    """The results of a sweep or screening, also while it is under way or after it was killed.

    Parameters
    ----------
    path
        The file that the sweep wrote, or was to write. Its journal ``FILE.journal`` is read if it
        is there, otherwise the file itself.

    Raises
    ------
    SceneError
        If there is neither, or it holds something else.
    """
    return Runs(read(path))


class RunsStoppedError(RuntimeError):
    """Many runs that ended early; ``result`` holds those that are done."""

    def __init__(self, message: str, result: Runs) -> None:
        super().__init__(message)
        self.result = result
