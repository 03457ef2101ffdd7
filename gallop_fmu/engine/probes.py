"""Probes: tables of the quantities that the kernel records or observes."""

from __future__ import annotations

import enum
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.ctypes_structs import CProbe
from gallop_fmu.foundation.channels import END_FORCES, SPAN_CHANNELS, SYSTEM_CHANNELS


class Object(enum.IntEnum):
    """Objects of which quantities can be observed: gallop_probe_object."""

    NODE = 0
    JUNCTION = 1
    FIELD = 2
    SYSTEM = 3
    DEVICE = 4


Probes = NDArray[np.void]
"""A table of gallop_probe."""

AXES = 3
"""Components of a force."""

_SYSTEM = tuple(channel.name for channel in SYSTEM_CHANNELS)
_LAST = -1
_ROW = np.dtype(CProbe)


def _span_probe(name: str) -> tuple[Object, int, int]:
    """Object, index and channel of a span channel."""
    if name in END_FORCES:
        end, axis = divmod(END_FORCES.index(name), AXES)
        return Object.JUNCTION, _LAST if end else 0, axis
    if name in _SYSTEM:
        return system_probe(name)
    return Object.FIELD, 0, 0


def system_probe(name: str) -> tuple[Object, int, int]:
    """Object, index and channel of a channel of the whole system."""
    return Object.SYSTEM, 0, _SYSTEM.index(name)


def _table(rows: Iterable[tuple[int, int, int]]) -> Probes:
    return np.array([(*row, 0, 0.0) for row in rows], dtype=_ROW)


_SPAN = _table(_span_probe(channel.name) for channel in SPAN_CHANNELS)


def span_probes(channels: NDArray[np.int32], junctions: int) -> Probes:
    """Probes of span channels, given by index, in a scene with a number of junctions."""
    probes = _SPAN[channels]
    probes["index"][probes["index"] == _LAST] = junctions - 1
    return probes


def node_probes(nodes: NDArray[np.int32], channels: NDArray[np.int32]) -> Probes:
    """Probes of every channel at every node, node after node."""
    probes = np.zeros((len(nodes), len(channels)), dtype=_ROW)
    probes["object"], probes["index"], probes["channel"] = Object.NODE, nodes[:, None], channels
    return probes.ravel()


def probes_of(rows: Iterable[tuple[Object, int, int]]) -> Probes:
    """Probes by object, index and channel."""
    return _table(rows)


def junction_probes(junction: int) -> Probes:
    """Probes of the force along x1, x2, x3 at a junction."""
    return _table((Object.JUNCTION, junction, axis) for axis in range(AXES))
