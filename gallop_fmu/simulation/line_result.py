"""Result of a line: histories by span, phase, subconductor and tower, and what follows from them.

Spans, phases, subconductors and spacers count from 1, towers from 0 (left end) to the number of
spans.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import LineMap, MappedChain
from gallop_fmu.engine.pack import map_of
from gallop_fmu.foundation.channels import DESCRIBED, NODE_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.simulation.line_warnings import line_warnings
from gallop_fmu.simulation.oscillation import MOVES, Oscillations, oscillations
from gallop_fmu.simulation.provenance import Provenance, dataset_of
from gallop_fmu.simulation.recording import Values
from gallop_fmu.simulation.result_base import ResultBase
from gallop_fmu.simulation.steadiness import Motion, judge_span

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Array = NDArray[np.float64]

CENTRE = ("u1", "u2", "u3", "v1", "v2", "v3", "a1", "a2", "a3", "tension", "angle_of_attack")
"""Channels of a bundle that are the mean of its subconductors."""

OWN_TWIST = {"theta": "section_twist", "omega": "section_twist_rate"}
"""Channels of the subconductors about their own axes, and their names in a bundle."""

AT_REST = "_at_rest"
"""End of the names of values in the initial equilibrium."""

STATIC = {
    "sag": ("m", "sag at mid-span below the chord, in the initial equilibrium"),
    "horizontal_tension": ("N", "horizontal tension of a subconductor, in the initial equilibrium"),
}
"""Unit and meaning of further values of the initial equilibrium."""


@dataclass(frozen=True, repr=False)
class LineResult(ResultBase[LineScene]):
    """Result of a run of a line.

    Attributes
    ----------
    dataset : xarray.Dataset
        Node channels (u1, u2, u3, theta, tension, ...) over ``time`` [s] and ``node``; the
        coordinates ``span``, ``phase``, ``subconductor``, ``station`` (fraction of the conductor's
        length), ``x1``, ``x2`` and ``x3`` (initial equilibrium [m]) belong to the nodes. Forces on
        the towers and leans and pulls of the strings over time, ``tower`` and ``line_phase``; the
        wind speed over time and ``line_span``; rotations of the spacers over time and ``spacer``.
        Each variable has ``units`` and ``long_name``; ``dataset.attrs`` holds the provenance.
    scene : LineScene
        The scene of the run.
    report : Report
        Outcome of the run, and counts of its work.
    """

    @cached_property
    def map(self) -> LineMap:
        """Which nodes, junctions and devices are which part of the line."""
        return map_of(self.scene)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that limit the trust in the results, each a fact and a remedy."""
        return line_warnings(self.dataset, self.scene, self.report, self.map)

    # ---- histories ----

    def midspan(self, span: int | None = None, phase: int = 1, subconductor: int = 1) -> xr.Dataset:
        """Return the histories of a conductor at mid-span.

        Parameters
        ----------
        span, phase, subconductor
            Its numbers, from 1; the span may be omitted if the line has one.

        Raises
        ------
        SceneError
            There is no such conductor, or it was not recorded at mid-span.
        """
        chain = self._chains(span, phase)[self._subconductor(subconductor)]
        return self._of_nodes().isel(node=self._columns([chain])[0])

    def bundle(self, span: int | None = None, phase: int = 1) -> xr.Dataset:
        """Return the histories of the bundle's centre and of its twist at mid-span.

        Parameters
        ----------
        span, phase
            Their numbers, from 1; the span may be omitted if the line has one.

        Returns
        -------
        xarray.Dataset
            ``theta`` and ``omega`` are those of the rigid rotation that fits the positions of the
            subconductors best; ``section_twist`` and ``section_twist_rate`` the mean of their
            twists about their own axes; all other channels are the mean of the subconductors. Of a
            single conductor they are its own.

        Raises
        ------
        SceneError
            There is no such span or phase, or it was not recorded at mid-span.
        """
        columns = self._columns(self._chains(span, phase))
        part = self._of_nodes().isel(node=columns)
        if len(columns) == 1:
            return part.isel(node=0)
        made = {name: part[name].mean("node", keep_attrs=True) for name in CENTRE if name in part}
        made |= {
            own: part[name].mean("node", keep_attrs=True)
            for name, own in OWN_TWIST.items()
            if name in part
        }
        for name, values in zip(("theta", "omega"), _rotation(part), strict=True):
            attributes = {"units": DESCRIBED[name].unit, "long_name": f"{name} of the bundle"}
            if values is not None:
                made[name] = part["u2"].isel(node=0, drop=True).copy(data=values)
                made[name].attrs = attributes
        return part.drop_vars(list(part.data_vars)).drop_dims("node").assign(made)

    def _history(self, channel: str) -> xr.DataArray:
        """Return a recorded channel; of a channel of the nodes, that of mid-spans as `bundle`.

        It is over time, ``line_span`` and ``line_phase``; the last two only if there are several.
        """
        import xarray as xr

        history = self.dataset[channel]
        if "node" not in history.dims:
            return history
        spans, phases = (range(1, count + 1) for count in (self.map.spans, self.map.phases))
        by_phase = [
            [self.bundle(span, phase)[channel].reset_coords(drop=True) for span in spans]
            for phase in phases
        ]
        found = xr.concat([xr.concat(row, "line_span") for row in by_phase], "line_phase")
        found = found.assign_coords(line_span=list(spans), line_phase=list(phases))
        single = [name for name in ("line_span", "line_phase") if found.sizes[name] == 1]
        return found.squeeze(single, drop=True).transpose("time", ...)

    def _of_nodes(self) -> xr.Dataset:
        """Histories of the nodes alone."""
        names = [name for name in self.dataset.data_vars if name in NODE_INDEX]
        return self.dataset[names]

    def _chains(self, span: int | None, phase: int) -> tuple[MappedChain, ...]:
        """The conductors of a phase in a span."""
        if span is None and self.map.spans > 1:
            raise SceneError(f"span is missing; give a number from 1 to {self.map.spans}")
        try:
            return self.map.bundle(span or 1, phase)
        except IndexError as problem:
            raise SceneError(str(problem)) from None

    def _subconductor(self, number: int) -> int:
        """Index of a subconductor."""
        if 1 <= number <= self.map.subconductors:
            return number - 1
        raise SceneError(
            f"subconductor {number} does not exist; give a number from 1 to"
            f" {self.map.subconductors}"
        )

    def _columns(self, chains: Sequence[MappedChain]) -> list[int]:
        """Indices of the mid-span nodes of conductors among the recorded nodes."""
        recorded = self.dataset.node.values.tolist()
        missing = [chain.middle for chain in chains if chain.middle not in recorded]
        if missing:
            raise SceneError(
                f"the mid-span node {missing[0]} was not recorded; simulate with"
                ' record_nodes="midspan" or "all"'
            )
        return [recorded.index(chain.middle) for chain in chains]

    # ---- judgement ----

    def steady(
        self, window: float | None = None, span: int | None = None, phase: int = 1
    ) -> Oscillations:
        """Return the oscillation of a bundle's centre and twist at mid-span, at the end of the run.

        The ``motion`` of each is its judgement: steady, still growing, ...

        Parameters
        ----------
        window
            Length [s] of the window (default: 100 s, at most half of the run); the result has its
            ``start`` and ``stop``.
        span, phase
            Their numbers, from 1; the span may be omitted if the line has one.

        Raises
        ------
        SceneError
            The run is shorter than the window or has too few records, or there is no such span or
            phase.
        """
        return self.between(*self.window(window), span, phase)

    def between(
        self, start: float, stop: float, span: int | None = None, phase: int = 1
    ) -> Oscillations:
        """Return the oscillation of a bundle's centre and twist from `start` to `stop` [s]."""
        bundle = self.bundle(span, phase)
        channels = {str(name): (one.values, one.attrs["units"]) for name, one in bundle.items()}
        time = bundle.time.values
        return oscillations(time, channels, start, stop, is_gusty=self.scene.wind.is_gusty)

    def motion_of(
        self, span: int | None = None, phase: int = 1, window: float | None = None
    ) -> Motion:
        """Judge the motion of one span over the last `window` s, as `judged` that of all."""
        if not set(MOVES) & set(self.dataset.data_vars):
            return Motion("undetermined", "no displacement was recorded")
        histories = self._moves(self.bundle(span, phase), "")
        return judge_span(
            self.dataset.time.values, histories, window, is_gusty=self.scene.wind.is_gusty
        )

    def judged(self, window: float | None = None) -> Motion:
        """Judge the motion over the last `window` s, from mid-spans and strings.

        Parameters
        ----------
        window
            Length [s] (default: 100 s, at most half of the run).
        """
        histories: dict[str, Array] = {}
        try:
            for span in range(1, self.map.spans + 1):
                for phase in range(1, self.map.phases + 1):
                    name = self.label(span, phase)
                    histories |= self._moves(self.bundle(span, phase), f"{name} ")
        except SceneError:
            return Motion("undetermined", "mid-spans were not recorded")
        histories |= self._swings()
        if not histories:
            return Motion("undetermined", "no displacement was recorded")
        return judge_span(
            self.dataset.time.values, histories, window, is_gusty=self.scene.wind.is_gusty
        )

    def _moves(self, bundle: xr.Dataset, start: str) -> dict[str, Array]:
        return {f"{start}{title}": bundle[n].values for n, title in MOVES.items() if n in bundle}

    def _swings(self) -> dict[str, Array]:
        """Swing of the strings across and along the line [m]: lean times length."""
        found: dict[str, Array] = {}
        for tower in self.map.towers:
            length = self._string_length(tower.tower)
            for way in ("along", "across"):
                name = f"string_lean_{way}"
                if tower.has_string and length and name in self.dataset:
                    lean = self.dataset[name].values[:, tower.tower, tower.phase - 1]
                    phase = f" phase {tower.phase}" if self.map.phases > 1 else ""
                    found[f"tower {tower.tower}{phase} {way}"] = length * lean
        return found

    def _string_length(self, tower: int) -> float:
        """Length of the string of a suspension [m]; 0 where there is none."""
        if not 0 < tower < self.map.spans:
            return 0.0
        return float(getattr(self.scene.section.suspensions[tower - 1], "length", 0.0))

    def label(self, span: int, phase: int) -> str:
        """Name of a span and phase for texts: ``span 2``, ``span 2 phase 1``."""
        return f"span {span} phase {phase}" if self.map.phases > 1 else f"span {span}"

    # ---- tables ----

    @cached_property
    def strings(self) -> pd.DataFrame:
        """Table of all strings: their pull [N] and lean [rad] at rest, their mean and extremes."""
        from gallop_fmu.simulation.line_tables import strings

        return strings(self)

    @cached_property
    def towers(self) -> pd.DataFrame:
        """Table of the forces [N] on all towers: preload, mean and extremes, by phase."""
        from gallop_fmu.simulation.line_tables import towers

        return towers(self)

    @cached_property
    def spans(self) -> pd.DataFrame:
        """Table of the motion of all spans and phases, with clearance ellipses."""
        from gallop_fmu.simulation.line_tables import spans

        return spans(self)

    @cached_property
    def clearances(self) -> pd.DataFrame:
        """Table of the smallest distance [m] of each two phases in each span."""
        from gallop_fmu.simulation.line_tables import clearances

        return clearances(self)

    def _table(self) -> tuple[pd.DataFrame, dict[str, str]]:
        """Return the histories of mid-spans, towers and strings by time, and their units."""
        import pandas as pd

        columns: dict[str, Array] = {}
        units: dict[str, str] = {}

        def add(name: str, values: Array, unit: str) -> None:
            columns[name], units[name] = values, unit

        for span in range(1, self.map.spans + 1):
            for phase in range(1, self.map.phases + 1):
                start = self._column(f"span[{span}]", phase)
                for name, history in self.bundle(span, phase).data_vars.items():
                    add(f"{start}.{name}", history.values, history.attrs["units"])
        for name, variable in self.dataset.data_vars.items():
            if variable.dims == ("time",):
                add(str(name), variable.values, variable.attrs["units"])
            elif variable.dims == ("time", "tower", "line_phase"):
                for tower in self.map.towers:
                    values = variable.values[:, tower.tower, tower.phase - 1]
                    start = self._column(f"tower[{tower.tower}]", tower.phase)
                    if np.isfinite(values).any():
                        add(f"{start}.{name}", values, variable.attrs["units"])
        index = pd.Index(self.dataset.time.values, name="time")
        return pd.DataFrame(columns, index=index), units

    def _column(self, place: str, phase: int) -> str:
        return f"{place}.phase[{phase}]" if self.map.phases > 1 else place


def _rotation(part: xr.Dataset) -> tuple[Array | None, Array | None]:
    """Best rigid rotation of points about x1 and its rate.

    The angle phi that minimises sum |p - R(phi) r|^2 of the points r, p across the line before and
    after is atan2(sum r x p, sum r.p), both from their centres.
    """
    if not {"u2", "u3"} <= set(part.data_vars):
        return None, None
    x2, x3 = part.x2.values, part.x3.values
    r2, r3 = x2 - x2.mean(), x3 - x3.mean()
    p2, p3 = (place + _from_mean(part[name].values) for place, name in ((r2, "u2"), (r3, "u3")))
    cross, dot = (r2 * p3 - r3 * p2).sum(axis=1), (r2 * p2 + r3 * p3).sum(axis=1)
    angle = np.unwrap(np.arctan2(cross, dot))
    if not {"v2", "v3"} <= set(part.data_vars):
        return angle, None
    v2, v3 = _from_mean(part["v2"].values), _from_mean(part["v3"].values)
    rates = (r2 * v3 - r3 * v2).sum(axis=1), (r2 * v2 + r3 * v3).sum(axis=1)
    return angle, (rates[0] * dot - cross * rates[1]) / (cross**2 + dot**2)


def _from_mean(values: Array) -> Array:
    return np.asarray(values - values.mean(axis=1, keepdims=True))


def line_histories(
    values: Values,
    time: NDArray[np.floating],
    nodes: NDArray[np.int32],
    x: Array,
    mapped: LineMap,
    provenance: Provenance,
) -> xr.Dataset:
    """Return the dataset of a `LineResult`.

    Parameters
    ----------
    values
        Channel to its dimensions and values.
    time : ndarray, shape (time,)
        Times of the records [s].
    nodes : ndarray, shape (node,)
        Numbers of the recorded nodes.
    x : ndarray, shape (node, 3)
        Their positions [m] in the initial equilibrium.
    mapped
        Map of the model.
    provenance
        Origin of the values.
    """
    described = {name: (*content, _attributes(name)) for name, content in values.items()}
    found = {dimension for dimensions, _ in values.values() for dimension in dimensions}
    coordinates: dict[str, Any] = {"node": nodes}
    coordinates |= {
        name: ("node", label[nodes], {"units": "1", "long_name": f"{name} of the node"})
        for name, label in mapped.labels.items()
    }
    for axis, positions in enumerate(x.T, start=1):
        meaning = {"units": "m", "long_name": f"position of the node along x{axis}"}
        coordinates[f"x{axis}"] = ("node", positions, meaning)
    if "tower" in found:
        coordinates["tower"] = np.arange(mapped.spans + 1)
    if "line_phase" in found:
        coordinates["line_phase"] = np.arange(1, mapped.phases + 1)
    if "line_span" in found:
        coordinates["line_span"] = np.arange(1, mapped.spans + 1)
    if "spacer" in found:
        for name in ("span", "phase", "number", "station"):
            numbers = np.array([getattr(spacer, name) for spacer in mapped.spacers])
            coordinates[f"spacer_{name}"] = ("spacer", numbers)
    return dataset_of(described, time, coordinates, provenance)


def _attributes(name: str) -> dict[str, str]:
    """Unit and meaning of a variable."""
    if name in STATIC:
        unit, meaning = STATIC[name]
        return {"units": unit, "long_name": meaning}
    channel = DESCRIBED[name.removesuffix(AT_REST)]
    remark = ", in the initial equilibrium in still air" if name.endswith(AT_REST) else ""
    return {"units": channel.unit, "long_name": channel.meaning + remark}
