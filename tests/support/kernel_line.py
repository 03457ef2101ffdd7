"""Lines as tables of the kernel, for tests that do without scenes: spans, strings, ends."""

import ctypes as c
import math
from dataclasses import dataclass, field

import numpy as np

from gallop_fmu.engine.ctypes_structs import (
    CChain,
    CCrossSection,
    CCurve,
    CDerived,
    CDerivedChain,
    CDevice,
    CField,
    CJunction,
    CLaw,
    CProbe,
    CSettings,
    CStation,
    Three,
)
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.strung_state import clamp_of_end_string
from gallop_fmu.engine.tables import Tables, double_pointer
from tests.support.line_models import LineModel

STRING, PULL, LEAN_ALONG, LEAN_ACROSS = 2, 3, 4, 5
DRAKE = {
    "diameter": 0.02814,
    "mass": 1.628,
    "axial_stiffness": 29.0e6,
    "torsional_stiffness": 159.0,
    "torsional_inertia": 2e-4,
    "thermal_expansion": 1.89e-5,
}
NONE = -1
STIFFNESS = 5e7
"""Axial stiffness of a string [N/m]."""


@dataclass
class String:
    """A string; of an end string `end` is +1 at the left end of the line, -1 at the right one."""

    length: float
    weight: float
    end: int = 0
    stiffness: float = STIFFNESS


@dataclass
class KernelLine:
    """A line of one conductor; towers count from 0 at the left end.

    Attributes
    ----------
    spans, rises
        Lengths and height differences [m].
    towers
        A string, None (rigid) or the stiffness of springs along x1 and x3 [N/m] for each.
    tension
        Horizontal tension [N] of the strung state.
    ice
        Mass [kg/m] on each span.
    wind, drag
        Speed [m/s] and coefficient; None: there is no curve.
    motion
        Displacement [m] of the tower's point by (tower, axis).
    """

    spans: list
    towers: list
    tension: float
    rises: list | None = None
    conductor: dict = field(default_factory=lambda: dict(DRAKE))
    ice: list | None = None
    elements: int = 20
    gravity: float = 9.80665
    wind: float = 0.0
    drag: float | None = None
    motion: dict = field(default_factory=dict)

    def __post_init__(self):
        self.rises = self.rises or [0.0] * len(self.spans)

    def tower_points(self):
        """Where strings hang, or the conductor is fixed, with the conductor level at 0 there."""
        x = np.concatenate([[0.0], np.cumsum(self.spans)])
        y = np.concatenate([[0.0], np.cumsum(self.rises)])
        return np.column_stack([x, y, np.zeros(len(x))])

    def end_clamp(self, string, length, rise):
        """Clamp of an end string in the strung state, from its tower along x1 and up."""
        weight = self.conductor["mass"] * self.gravity
        parameter = self.tension / weight
        return clamp_of_end_string(length, rise, parameter, string.length, string.weight / weight)

    def clamps(self):
        """Positions of the junctions in the strung state, and towers' points from there."""
        position, towers = self.tower_points(), np.zeros((len(self.towers), 3))
        for k, string in enumerate(self.towers):
            if not isinstance(string, String) or not string.end:
                continue
            left = string.end > 0
            length, rise = (
                (self.spans[0], self.rises[0]) if left else (self.spans[-1], -self.rises[-1])
            )
            along, down = self.end_clamp(string, length, rise)
            towers[k] = (-string.end * along, down, 0.0)
            position[k] -= towers[k]
        return position, towers

    def _junction(self, k, place):
        """A string leaves its clamp free, springs hold the vertical displacement."""
        tower, names = self.towers[k], list(self.motion)
        junction = CJunction(position=Three(*place))
        junction.fixed[:] = (tower is None, not isinstance(tower, String), tower is None, 1)
        junction.motion[:] = [
            1 + names.index((k, axis)) if (k, axis) in names else NONE for axis in range(3)
        ]
        return junction

    def _device(self, k, offset):
        tower = self.towers[k]
        device = CDevice(kind=0, junctions=1)
        device.junction[:] = (k, *(NONE,) * 7)
        if isinstance(tower, String):
            device.kind = STRING
            device.parameter[:3] = (tower.length, tower.weight, tower.stiffness)
            device.parameter[5:8] = list(offset)
        else:
            device.parameter[0], device.parameter[2] = tower
        return device

    def _span(self, k):
        """Its cross-section and its chain."""
        ice = self.ice[k] if self.ice else 0.0
        curve = NONE if self.drag is None else 0
        section = CCrossSection(curve=curve, ice_mass=ice, **self.conductor)
        chain = CChain(cross_section=k, horizontal_tension=self.tension, elements=self.elements)
        chain.junction[:] = (k, k + 1)
        return section, chain

    def tables(self, shift=(0.0, 0.0, 0.0)):
        """The tables of the kernel, moved by `shift`, and the numbers of the curve."""
        position, towers = self.clamps()
        spans = [self._span(k) for k in range(len(self.spans))]
        values = (self.wind, *self.motion.values())
        tables = {
            "cross_section": [section for section, _ in spans],
            "field": [CField(law=0)],
            "junction": [self._junction(k, place) for k, place in enumerate(position + shift)],
            "chain": [chain for _, chain in spans],
            "device": [self._device(k, towers[k]) for k, tower in enumerate(self.towers) if tower],
            "law": [CLaw(initial=value, fall_start=math.inf) for value in values],
        }
        if self.drag is None:
            return tables, []
        tables["curve"] = [CCurve(pieces=1, outside=1)]
        return tables, [-math.pi, math.pi, 0.0, *(0.0,) * 4, self.drag, *(0.0,) * 7]

    @staticmethod
    def with_station(tables, chain, corner):
        """The tables with a junction at a corner of a chain, whose twist is fixed."""
        first, elements = chain + 1, tables["chain"][chain].elements
        junction = CJunction()
        junction.fixed[:] = (0, 0, 0, 1)
        junction.motion[:] = (NONE, NONE, NONE)
        junctions = tables["junction"]
        for other in tables["chain"]:
            other.junction[:] = [j + (j >= first) for j in other.junction]
        for device in tables["device"]:
            device.junction[0] += device.junction[0] >= first
        station = CStation(chain, corner, first, NONE, corner / elements)
        return tables | {
            "junction": [*junctions[:first], junction, *junctions[first:]],
            "station": [station],
        }

    def model(self, **changes):
        """The model; `changes` are settings, or `temperature_change`.  Raises SimulationError."""
        if "temperature_change" in changes:
            changes["temperature"] = changes.pop("temperature_change")
        shift = changes.pop("shift", (0.0, 0.0, 0.0))
        return LineTablesModel(self, shift, changes)


class KernelTables(Tables):
    """The tables of a line, as `Packed` has them."""

    def __init__(self, line, shift, changes):
        super().__init__()
        tables, numbers = line.tables(shift)
        self.tables |= tables
        self.add_numbers(numbers)
        settings = {
            "gravity": line.gravity,
            "air_density": 1.2,
            "time_step": 0.02,
            "newton_tolerance": 1e-9,
            "max_newton_iterations": 20,
            "max_halvings": 8,
            "strung": 1,
            "spectral_radius": 0.8,
        }
        self.add("settings", CSettings(**(settings | changes)))
        self.scene = self.c_scene()
        self.device_junctions = tuple((d.junction[0],) for d in self.tables["device"])


class LineTablesModel(LineModel):
    """A model of tables; it has no scene."""

    def __init__(self, line, shift, changes):
        packed = KernelTables(line, shift, changes)
        self.tables = packed.tables
        super().__init__(None, packed)

    def chain(self, index):
        """gallop_derived_chain of a chain."""
        out = CDerivedChain()
        assert kernel.gallop_chain_derived(self.handle, index, c.byref(out)) == 0
        return out

    def derived(self):
        out = CDerived()
        assert kernel.gallop_model_derived(self.handle, c.byref(out)) == 0
        return out

    def seed(self):
        """The initial disturbance."""
        u = np.empty((self.nodes, 4))
        assert kernel.gallop_seed(self.handle, double_pointer(u)) == 0
        return u

    def end_node(self, junction):
        """A node of the chains at a junction."""
        chains = self.tables["chain"]
        if junction == len(chains):
            return self.nodes - 1
        return sum(2 * chain.elements + 1 for chain in chains[:junction])

    def clamps(self, state=None):
        """Positions of the junctions, in the initial equilibrium or in a state."""
        x = self.equilibrium().x
        if state is not None:
            x = x + state.motion()[0][:, :3]
        return x[[self.end_node(k) for k in range(self.junctions)]]

    def observe_devices(self, state, channel):
        """One channel of all devices."""
        count = len(self.tables["device"])
        probes = np.zeros(count, dtype=np.dtype(CProbe))
        probes["object"], probes["index"], probes["channel"] = 4, np.arange(count), channel
        return state.observe(probes)
