"""Map of a model: which chains, nodes, junctions and devices are which part of the line.

Spans, phases, subconductors and spacers count from 1, towers from 0 (left end) to the number of
spans (right end); nodes, elements, junctions and devices are the kernel's, from 0. A scene of one
span has the map of a line of one span with one conductor.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MappedChain:
    """One subconductor in one span.

    Attributes
    ----------
    span, phase, subconductor : int
        Its numbers.
    first_node, first_element, elements : int
        Its nodes are ``first_node`` to ``first_node + 2 elements``.
    corners : tuple of int
        Number of its elements before each of its stations, with both ends.
    fractions : tuple of float
        The stations as fractions of the conductor's length in the strung state.
    junctions : tuple of int
        Junction at each station; -1: none.
    """

    span: int
    phase: int
    subconductor: int
    first_node: int
    first_element: int
    elements: int
    corners: tuple[int, ...]
    fractions: tuple[float, ...]
    junctions: tuple[int, ...]

    @property
    def nodes(self) -> slice:
        """Its nodes, from left to right."""
        return slice(self.first_node, self.first_node + 2 * self.elements + 1)

    @cached_property
    def stations(self) -> Array:
        """Each node's place as a fraction of the conductor's length in the strung state."""
        nodes = np.arange(2 * self.elements + 1)
        return np.interp(nodes, 2.0 * np.array(self.corners), self.fractions)

    def nearest_node(self, station: float) -> int:
        """The node nearest to a fraction of the conductor's length."""
        # Round-off must not decide between two nodes at the same distance.
        distance = np.round(np.abs(self.stations - station), 12)
        return self.first_node + int(np.argmin(distance))

    @property
    def middle(self) -> int:
        """The node at, or nearest to, mid-span."""
        return self.nearest_node(0.5)

    @property
    def ends(self) -> tuple[int, int]:
        """The nodes at its ends."""
        return self.first_node, self.first_node + 2 * self.elements


@dataclass(frozen=True, slots=True)
class MappedTower:
    """What holds one phase at one tower.

    Attributes
    ----------
    tower, phase : int
        Their numbers.
    kind : str
        Kind of the suspension or end in the scene.
    junctions : tuple of int
        The clamps, by subconductor.
    devices : tuple of int
        Strings, V-strings, yokes or springs: none, one, or one for each subconductor.
    """

    tower: int
    phase: int
    kind: str
    junctions: tuple[int, ...]
    devices: tuple[int, ...]

    @property
    def has_string(self) -> bool:
        """True if a string or V-string carries the conductors."""
        return self.kind in ("string", "v_string")

    @property
    def has_yoke(self) -> bool:
        """True if one string carries several subconductors."""
        return self.has_string and len(self.devices) < len(self.junctions)


@dataclass(frozen=True, slots=True)
class MappedSpacer:
    """A spacer of a bundle.

    Attributes
    ----------
    span, phase, number : int
        Its numbers; spacers of a span count from the left.
    station : float
        Its place as a fraction of the conductors' length.
    device : int
        The kernel's device.
    junctions : tuple of int
        Its clamps, by subconductor.
    """

    span: int
    phase: int
    number: int
    station: float
    device: int
    junctions: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MappedShedding:
    """A stretch of one conductor that loses its ice.

    Attributes
    ----------
    number : int
        Its number in the scene, from 1; several stretches can have the same.
    span, phase, subconductor : int
        Its conductor.
    from_station, to_station : float
        Its ends as fractions of the conductor's length.
    ice : float
        Mass of its ice per unit length [kg/m].
    """

    number: int
    span: int
    phase: int
    subconductor: int
    from_station: float
    to_station: float
    ice: float


@dataclass(frozen=True)
class LineMap:
    """Parts of a model by their numbers.

    Attributes
    ----------
    spans, phases, subconductors : int
        Their numbers.
    chains : tuple of MappedChain
        By span, then phase, then subconductor.
    towers : tuple of MappedTower
        By tower, then phase.
    spacers : tuple of MappedSpacer
        By span, then place, then phase.
    devices : tuple of tuple of int
        For each device of the scene the kernel's devices; none for an interval.
    bodies : tuple of int
        Junctions with a node of their own, in the order of these nodes.
    junctions : int
        Number of junctions.
    sheddings : tuple of MappedShedding
        Ice that falls, in the order of the kernel's table.
    """

    spans: int
    phases: int
    subconductors: int
    chains: tuple[MappedChain, ...]
    towers: tuple[MappedTower, ...]
    spacers: tuple[MappedSpacer, ...]
    devices: tuple[tuple[int, ...], ...]
    bodies: tuple[int, ...]
    junctions: int
    sheddings: tuple[MappedShedding, ...] = ()

    @property
    def elements(self) -> int:
        """Number of elements of all chains."""
        return sum(chain.elements for chain in self.chains)

    @property
    def nodes(self) -> int:
        """Number of nodes of all chains and bodies."""
        return 2 * self.elements + len(self.chains) + len(self.bodies)

    def chain(self, span: int, phase: int = 1, subconductor: int = 1) -> MappedChain:
        """The chain with these numbers.

        Raises
        ------
        IndexError
            There is none; the message names the number that is wrong.
        """
        index = 0
        for name, number, count in (
            ("span", span, self.spans),
            ("phase", phase, self.phases),
            ("subconductor", subconductor, self.subconductors),
        ):
            index = index * count + _checked(name, number, 1, count) - 1
        return self.chains[index]

    def bundle(self, span: int, phase: int = 1) -> tuple[MappedChain, ...]:
        """The chains of a phase in a span, by subconductor; raises IndexError as `chain`."""
        return tuple(self.chain(span, phase, k + 1) for k in range(self.subconductors))

    def tower(self, tower: int, phase: int = 1) -> MappedTower:
        """What holds a phase at a tower; raises IndexError as `chain`."""
        _checked("tower", tower, 0, self.spans)
        return self.towers[tower * self.phases + _checked("phase", phase, 1, self.phases) - 1]

    @cached_property
    def junctions_of_towers(self) -> tuple[tuple[int, ...], ...]:
        """The clamps at each tower, of all phases: what moves with its points."""
        return tuple(
            tuple(
                junction
                for held in self.towers
                if held.tower == tower
                for junction in held.junctions
            )
            for tower in range(self.spans + 1)
        )

    def place_of(self, element: int | None, device: int | None) -> str | None:
        """An element or a device at a tower, in words; None in a span without numbers."""
        if len(self.chains) == 1:
            return None
        for tower in self.towers:
            if device is not None and device in tower.devices:
                return self.words_of_tower(tower)
        for chain in self.chains:
            if element is None or not 0 <= element - chain.first_element < chain.elements:
                continue
            number = element - chain.first_element + 1
            return f"{self.words_of_chain(chain)}, element {number} of {chain.elements}"
        return None

    def words_of_tower(self, tower: MappedTower) -> str:
        """Where a tower is, in words."""
        return f"at tower {tower.tower}" + (f", phase {tower.phase}" if self.phases > 1 else "")

    def words_of_chain(self, chain: MappedChain) -> str:
        """Where a chain is, in words."""
        place = f"in span {chain.span}" + (f", phase {chain.phase}" if self.phases > 1 else "")
        own = f", subconductor {chain.subconductor}" if self.subconductors > 1 else ""
        return place + own

    @cached_property
    def node_of_junction(self) -> NDArray[np.intp]:
        """A node of each junction; of several chains that meet there, that of the first one."""
        node = np.full(self.junctions, -1, dtype=np.intp)
        for chain in reversed(self.chains):
            for corner, junction in zip(chain.corners, chain.junctions, strict=True):
                if junction >= 0:
                    node[junction] = chain.first_node + 2 * corner
        first = 2 * self.elements + len(self.chains)
        node[list(self.bodies)] = np.arange(first, first + len(self.bodies))
        return node

    @cached_property
    def usual_nodes(self) -> NDArray[np.int32]:
        """The nodes at mid-span of every chain and at all clamps, increasing."""
        clamps = [self.node_of_junction[j] for tower in self.towers for j in tower.junctions]
        return np.unique([*(chain.middle for chain in self.chains), *clamps]).astype(np.int32)

    @cached_property
    def labels(self) -> dict[str, NDArray[np.float64] | NDArray[np.int32]]:
        """Span, phase, subconductor and station of each node; 0 and NaN of a body."""
        numbers = {
            name: np.zeros(self.nodes, dtype=np.int32) for name in ("span", "phase", "subconductor")
        }
        station = np.full(self.nodes, np.nan)
        for chain in self.chains:
            for name, array in numbers.items():
                array[chain.nodes] = getattr(chain, name)
            station[chain.nodes] = chain.stations
        return {**numbers, "station": station}


def one_span_map(
    corners: tuple[int, ...],
    fractions: tuple[float, ...],
    kinds: tuple[str, str],
    devices: tuple[int, ...],
) -> LineMap:
    """The map of a scene of one span.

    Parameters
    ----------
    corners, fractions
        As of `MappedChain`.
    kinds
        Kinds of both supports.
    devices
        Ends that have a device.
    """
    junctions = (0, *(-1,) * (len(corners) - 2), 1)
    chain = MappedChain(1, 1, 1, 0, 0, corners[-1], corners, fractions, junctions)
    towers = tuple(
        MappedTower(end, 1, kind, (end,), (devices.index(end),) if end in devices else ())
        for end, kind in enumerate(kinds)
    )
    return LineMap(1, 1, 1, (chain,), towers, (), (), (), 2)


def _checked(name: str, number: int, first: int, last: int) -> int:
    if not first <= number <= last:
        raise IndexError(f"{name} {number} does not exist; give a number from {first} to {last}")
    return number
