"""Datasets of histories: units, meanings, and the origin of the values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.equilibrium import Equilibrium
from gallop_fmu.engine.library import arithmetic, build
from gallop_fmu.foundation.channels import DESCRIBED, END_FORCES
from gallop_fmu.foundation.outcome import Report
from gallop_fmu.foundation.version import program
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.turbulence import DIRECTIONS
from gallop_fmu.scene.wind_consistency import gusts_of

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


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

    scene: Scene | LineScene
    equilibrium: Equilibrium | None
    report: Report
    seconds: float
    details: Mapping[str, object]

    def attributes(self) -> dict[str, object]:
        """Return the attributes of the dataset."""
        return {**self.facts(), "scene": self.scene.to_toml()}

    def facts(self) -> dict[str, object]:
        """Return the attributes of the dataset without the text of the scene."""
        equilibrium, report = self.equilibrium, self.report
        counts = ("steps", "substeps", "iterations", "refactorisations", "halvings", "rejections")
        extremes = ("lowest_tension", "largest_turn")
        nan = math.nan
        return {
            "title": self.scene.title,
            "source": program(),
            "kernel": build(),
            "arithmetic": arithmetic(self.scene.numerics.portable),
            **self.details,
            "outcome": report.outcome.name.lower(),
            "message": str(report),
            "seconds": self.seconds,
            "sag": nan if equilibrium is None else equilibrium.sag,
            "horizontal_tension": nan if equilibrium is None else equilibrium.horizontal_tension,
            "held_imbalance": nan if equilibrium is None else equilibrium.imbalance,
            **{name: getattr(report, name) for name in counts + extremes},
        }


@dataclass(frozen=True)
class Histories:
    """Histories of a run as arrays, and their dataset, which takes a millisecond to make.

    Attributes
    ----------
    time : ndarray, shape (time,)
        Times [s] of the records.
    nodes : ndarray of int, shape (node,)
        Recorded nodes.
    values : mapping
        Variable to its values.
    facts : mapping
        Attributes of the dataset; those of `Provenance.facts`.
    dataset : callable
        Returns the dataset.
    """

    time: Array
    nodes: NDArray[np.integer]
    values: Mapping[str, Array]
    facts: Mapping[str, Any]
    dataset: Callable[[], xr.Dataset]

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Histories:
        """Return the histories of a dataset."""
        return cls(
            time=dataset.time.values,
            nodes=dataset.node.values,
            values={str(name): one.values for name, one in dataset.data_vars.items()},
            facts=dataset.attrs,
            dataset=lambda: dataset,
        )


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

    def meaning(name: str) -> str:
        text = DESCRIBED[name].meaning
        if name not in END_FORCES or not isinstance(provenance.scene, Scene):
            return text
        remark = provenance.scene.supports.remark_on_force(name.partition("_")[0])
        return f"{text}; {remark}" if remark else text

    described = {
        name: (*content, {"units": DESCRIBED[name].unit, "long_name": meaning(name)})
        for name, content in variables.items()
    }
    places = ("node", x1, {"units": "m", "long_name": "position of the node along the span"})
    return dataset_of(described, time, {"node": nodes, "x1": places}, provenance)


def dataset_of(
    variables: Mapping[str, object],
    time: NDArray[np.floating],
    coordinates: Mapping[str, object],
    provenance: Provenance,
) -> xr.Dataset:
    """Return a dataset over time [s] with its provenance, and the gusts of the run."""
    import xarray as xr  # a slow import (0.3 s)

    times = ("time", time, {"units": "s", "long_name": "time"})
    gusts, places = _gusts(provenance.scene)
    dataset = xr.Dataset({**variables, **gusts}, {"time": times, **coordinates, **places})
    return dataset.assign_attrs(provenance.attributes())


GUST_DIMENSIONS = ("gust_time", "gust_station")
"""Dimensions of the gusts in a dataset."""


def _gusts(scene: Scene | LineScene) -> tuple[dict[str, object], dict[str, object]]:
    """Return the gusts of a scene as variables, and their coordinates; both empty without gusts."""
    gusts = gusts_of(scene.wind, scene.length, scene.run.stop_time)
    if gusts is None:
        return {}, {}
    variables: dict[str, object] = {}
    for number, direction in enumerate(DIRECTIONS[: gusts.values.shape[2]]):
        way = "upwards" if direction == "upwards" else f"{direction} the wind"
        meaning = {"units": "1", "long_name": f"gust {way} over the mean speed"}
        variables[f"gust_{direction}"] = (GUST_DIMENSIONS, gusts.values[:, :, number], meaning)
    end = "repeats" if gusts.repeat else "is constant outside"
    places: dict[str, object] = {
        "gust_time": ("gust_time", gusts.times, {"units": "s", "long_name": f"time; {end}"}),
        "gust_station": ("gust_station", gusts.stations, {"units": "m", "long_name": "x1"}),
    }
    return variables, places


def histories_alone(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset without what is not over time, such as the table of gusts."""
    others = [name for name, one in dataset.data_vars.items() if "time" not in one.dims]
    dimensions = (*GUST_DIMENSIONS, "shedding")
    return dataset.drop_vars(others).drop_dims(dimensions, errors="ignore")
