"""What a run records: variables with their dimensions, and the kernel's probes of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import LineMap
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import (
    AXES,
    Object,
    Probes,
    node_probes,
    probes_of,
    span_probes,
    system_probe,
)
from gallop_fmu.foundation.channels import (
    DEVICE_CHANNELS,
    LINE_INDEX,
    NODE_INDEX,
    SPAN_INDEX,
    SYSTEM_CHANNELS,
)

Array = NDArray[np.float64]
Values = dict[str, tuple[tuple[str, ...], Array]]
"""Variable to its dimensions and values."""

_Row = tuple[Object, int, int]


@dataclass(frozen=True)
class Variable:
    """A recorded variable.

    Attributes
    ----------
    name : str
        Its name.
    dimensions : tuple of str
        Its dimensions after time.
    shape : tuple of int
        Its lengths along these.
    probes : ndarray
        The kernel's quantities of which it is made.
    places : ndarray of int, shape (probe,), or None
        The entry to which each probe belongs, where several probes make an entry, or an entry has
        none and is NaN. None: each probe is one entry.
    weights : ndarray, shape (probe,), or None
        Factors of the probes.
    """

    name: str
    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    probes: Probes
    places: NDArray[np.intp] | None = None
    weights: Array | None = None

    def made_of(self, values: Array) -> Array:
        """Make the variable, of shape (record, ...), of its probes, of shape (record, probe)."""
        shape = (len(values), *self.shape)
        if self.places is None:
            return np.ascontiguousarray(values).reshape(shape)
        entries = np.full((int(np.prod(self.shape)), len(values)), np.nan)
        entries[self.places] = 0.0
        weighted = values if self.weights is None else values * self.weights
        np.add.at(entries, self.places, weighted.T)
        return np.ascontiguousarray(entries.T).reshape(shape)


@dataclass(frozen=True)
class Recording:
    """All variables of a run."""

    variables: tuple[Variable, ...]

    @cached_property
    def probes(self) -> Probes:
        """The probes of all variables."""
        return np.concatenate([variable.probes for variable in self.variables])

    def values(self, records: Array) -> Values:
        """Return the variables of records, of shape (record, probe)."""
        found: Values = {}
        if len(self.probes) == len(self.variables):  # then none needs a copy of its own
            records = np.ascontiguousarray(records.T).T
        start = 0
        for variable in self.variables:
            stop = start + len(variable.probes)
            dimensions = ("time", *variable.dimensions)
            found[variable.name] = (dimensions, variable.made_of(records[:, start:stop]))
            start = stop
        return found

    def unknown(self) -> Values:
        """Return one record of NaN."""
        return {
            v.name: (("time", *v.dimensions), np.full((1, *v.shape), np.nan))
            for v in self.variables
        }


def rest_values(recording: Recording, model: Model) -> Values:
    """Return the values of the towers' channels in still air, and sags and tensions of the spans.

    A channel of a tower, such as ``string_pull``, has the value ``string_pull_at_rest``.
    """
    mapped = model.map
    found: Values = {}
    for variable in recording.variables:
        if "tower" in variable.dimensions:
            values = model.observe_equilibrium(variable.probes)[np.newaxis]
            name = f"{variable.name}_at_rest"
            found[name] = (variable.dimensions, variable.made_of(values)[0])
    chains = [model.chain_equilibrium(index) for index in range(len(mapped.chains))]
    shape = (mapped.spans, mapped.phases, mapped.subconductors)
    for name in ("sag", "horizontal_tension"):
        values = np.array([getattr(chain, name) for chain in chains]).reshape(shape)
        found[name] = (("line_span", "line_phase"), values.mean(axis=2))
    return found


def span_recording(
    mapped: LineMap, nodes: NDArray[np.int32], channels: Sequence[str], others: Sequence[str]
) -> Recording:
    """Return the recording of a span.

    Parameters
    ----------
    mapped
        Map of the model.
    nodes
        Nodes to record.
    channels, others
        Names of node channels and of span channels.
    """
    return _span_recording(tuple(nodes.tolist()), tuple(channels), tuple(others), mapped.junctions)


@lru_cache(maxsize=8)  # the rows of a sweep record the same
def _span_recording(
    nodes: tuple[int, ...], channels: tuple[str, ...], others: tuple[str, ...], junctions: int
) -> Recording:
    of_span = (
        Variable(name, (), (), span_probes(_index(SPAN_INDEX[name]), junctions)) for name in others
    )
    return Recording((*_of_nodes(np.array(nodes, dtype=np.int32), channels), *of_span))


def line_recording(
    mapped: LineMap, nodes: NDArray[np.int32], channels: Sequence[str], others: Sequence[str] | None
) -> Recording:
    """Return the recording of a line.

    Parameters
    ----------
    mapped, nodes, channels
        As of `span_recording`.
    others
        Names of line channels; None: all that the line has.
    """
    wanted = LINE_INDEX if others is None else others
    made = [variable for name in wanted if (variable := _of_line(mapped, name))]
    return Recording((*_of_nodes(nodes, channels), *made))


def _of_nodes(nodes: NDArray[np.int32], channels: Sequence[str]) -> Iterator[Variable]:
    for name in channels:
        probes = node_probes(nodes, _index(NODE_INDEX[name]))
        yield Variable(name, ("node",), (len(nodes),), probes)


def _index(number: int) -> NDArray[np.int32]:
    return np.array([number], dtype=np.int32)


def _of_line(mapped: LineMap, name: str) -> Variable | None:
    """Return a line channel as a variable; None if the line has none."""
    if name == "wind_speed":
        rows = [(Object.FIELD, span, 0) for span in range(mapped.spans)]
        return Variable(name, ("line_span",), (mapped.spans,), probes_of(rows))
    if name == "spacer_turn":
        turn = DEVICE_CHANNELS.index("turn")
        rows = [(Object.DEVICE, spacer.device, turn) for spacer in mapped.spacers]
        return Variable(name, ("spacer",), (len(rows),), probes_of(rows)) if rows else None
    if any(channel.name == name for channel in SYSTEM_CHANNELS):
        return Variable(name, (), (), probes_of([system_probe(name)]))
    return _of_towers(mapped, name)


def _of_towers(mapped: LineMap, name: str) -> Variable | None:
    """Return a channel of the towers: the sum over subconductors, of angles the mean."""
    rows: list[_Row] = []
    places, weights = [], []
    for place, tower in enumerate(mapped.towers):
        if name.startswith("tower_force"):
            axis = int(name[-1]) - 1
            assert 0 <= axis < AXES
            own = [(Object.JUNCTION, junction, axis) for junction in tower.junctions]
        elif tower.has_string and (name != "yoke_turn" or tower.has_yoke):
            channel = DEVICE_CHANNELS.index("turn" if name == "yoke_turn" else name)
            own = [(Object.DEVICE, device, channel) for device in tower.devices]
        else:
            continue
        rows += own
        places += [place] * len(own)
        weights += [1.0 / len(own) if "lean" in name else 1.0] * len(own)
    if not rows:
        return None
    shape = (mapped.spans + 1, mapped.phases)
    at = np.array(places, dtype=np.intp)
    return Variable(name, ("tower", "line_phase"), shape, probes_of(rows), at, np.array(weights))
