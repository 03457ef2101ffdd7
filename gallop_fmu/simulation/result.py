"""Result of a simulation: histories with units, report, and provenance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.channels import DESCRIBED
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.scene import Scene
from gallop_fmu.simulation.oscillation import (
    MAIN_CHANNELS,
    MOVES,
    Oscillation,
    Oscillations,
    frequency_text,
    measure,
    oscillation,
    oscillations,
    slowest_frequency,
)
from gallop_fmu.simulation.provenance import Provenance, histories, histories_alone
from gallop_fmu.simulation.result_base import ResultBase
from gallop_fmu.simulation.run_warnings import run_warnings
from gallop_fmu.simulation.steadiness import Motion, dominant_frequency, judge_span

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Array = NDArray[np.float64]

__all__ = [
    "MOVES",
    "Oscillation",
    "Oscillations",
    "Provenance",
    "Result",
    "dominant_frequency",
    "frequency_text",
    "histories",
    "measure",
    "oscillation",
    "slowest_frequency",
    "summary",
]


@dataclass(frozen=True, repr=False)
class Result(ResultBase[Scene]):
    """Result of a run of one span.

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

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that limit the trust in the results, each a fact and a remedy."""
        data = self.dataset if self.scene.shedding else None
        return run_warnings(self.recorded, self.scene, self.report, data)

    def midspan(self) -> xr.Dataset:
        """Return the histories of the mid-span node.

        Raises
        ------
        SceneError
            The mid-span node was not recorded.
        """
        self._column_of_midspan()  # raises the error
        return histories_alone(self.dataset).sel(node=self.scene.elements)

    def _column_of_midspan(self) -> int:
        """Return the place of the mid-span node in the arrays; raise SceneError if it has none."""
        middle, nodes = self.scene.elements, self.recorded.nodes.tolist()
        if middle not in nodes:
            raise SceneError(
                f"the mid-span node {middle} was not recorded; simulate with"
                ' record_nodes="midspan" or "all"'
            )
        return int(nodes.index(middle))

    def _at_midspan(self) -> dict[str, Array]:
        """Return the histories of the mid-span node and of the span."""
        column = self._column_of_midspan()
        return {
            name: values[:, column] if values.ndim > 1 else values
            for name, values in self.recorded.values.items()
            if name in DESCRIBED
        }

    def judged(self, window: float | None = None) -> Motion:
        """Judge the motion over the last `window` s, from mid-span and quarter points.

        Quarter points are used if they were recorded. `gallop_fmu.simulation.steadiness` has the
        kinds and their bounds.

        Parameters
        ----------
        window
            Length [s] (default: 100 s, at most half of the run).
        """
        recorded = self.recorded
        elements, nodes = self.scene.elements, recorded.nodes.tolist()
        if elements not in nodes:
            return Motion("undetermined", "mid-span was not recorded")
        places = {
            elements: "",
            round(0.5 * elements): " at a quarter",
            round(1.5 * elements): " at three quarters",
        }
        histories = {
            f"{title}{place}": recorded.values[name][:, nodes.index(node)]
            for node, place in places.items()
            if node in nodes
            for name, title in MOVES.items()
            if name in recorded.values
        }
        if not histories:
            return Motion("undetermined", "no displacement was recorded")
        return judge_span(recorded.time, histories, window, is_gusty=self.scene.wind.is_gusty)

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
        channels = {
            name: (values, DESCRIBED[name].unit) for name, values in self._at_midspan().items()
        }
        time = self.recorded.time
        return oscillations(time, channels, start, stop, is_gusty=self.scene.wind.is_gusty)

    def _history(self, channel: str) -> xr.DataArray:
        """Return a recorded channel; of a channel of the nodes, its history at mid-span."""
        history = self.dataset[channel]
        return self.midspan()[channel] if "node" in history.dims else history

    def _table(self) -> tuple[pd.DataFrame, dict[str, str]]:
        """Return the mid-span histories by time, and the unit of each column."""
        frame = self.midspan().drop_vars(["node", "x1"]).to_dataframe()
        return frame, {str(name): self.dataset[name].attrs["units"] for name in frame.columns}


def summary(result: Result) -> dict[str, object]:
    """Summarise a run in plain numbers and words, for a terminal or as JSON."""
    time = result.recorded.time
    steady, values = Oscillations({}, 0.0, float(time[-1])), dict[str, Array]()
    if len(time) > 1 and "u2" in result.recorded.values:
        steady, values = result.steady(), result._at_midspan()
    return {
        **result.numbers(),
        "window": steady.stop - steady.start,
        "midspan": {
            name: {
                **o.as_dict(),
                "lowest": float(np.min(values[name])),
                "highest": float(np.max(values[name])),
            }
            for name, o in steady.items()
            if name in MAIN_CHANNELS
        },
    }
