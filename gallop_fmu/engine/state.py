"""The motion of a model at one instant."""

from __future__ import annotations

import ctypes as c
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import CProbe, CReport
from gallop_fmu.engine.inputs import InputLayout, Inputs, inputs_pointer
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.line_map import LineMap
from gallop_fmu.engine.pack import double_pointer, unpacked
from gallop_fmu.engine.probes import Probes, junction_probes, node_probes, span_probes
from gallop_fmu.engine.team import team_of
from gallop_fmu.foundation.argument_checks import indices, number, whole
from gallop_fmu.foundation.channels import NODE_CHANNELS, SPAN_CHANNELS
from gallop_fmu.foundation.outcome import Outcome, Report, SimulationError

Array = NDArray[np.float64]
DOFS = 4
"""Unknowns a node: u1, u2, u3, theta."""

ALL_SPAN_CHANNELS = np.arange(len(SPAN_CHANNELS), dtype=np.int32)
"""Indices of all span channels."""

_NODE_CHANNELS = np.arange(len(NODE_CHANNELS), dtype=np.int32)
_ProbePointer = c.POINTER(CProbe)

VECTOR = 32
"""Alignment [bytes] of a state with which the kernel is fastest."""

MAX_THREADS = 2
"""Maximum number of threads that share a run."""

MOST_STEPS = 10**12
"""Maximum number of time steps of one call."""


def insist(outcome: int) -> None:
    """Raise SimulationError if a function without a report refused its state."""
    if outcome:
        fault = kernel.gallop_arithmetic_fault()
        field = (
            fault.decode()
            if fault
            else "state, which was not started; Model.start and Model.rest start one"
        )
        raise SimulationError(Report(Outcome.from_code(outcome), 0.0, field=field))


class CompiledModel:
    """What a state needs of its model: the kernel's model, its sizes, and the map of a line."""

    nodes: int
    junctions: int
    threads: int = 1
    state_size: int
    saved_size: int
    _handle: c.c_void_p | None
    _takes_inputs: bool
    _input_layout: InputLayout
    map: LineMap

    @property
    def handle(self) -> c.c_void_p:
        """Pointer to the kernel's model."""
        assert self._handle is not None
        return self._handle

    def accept(self, inputs: Inputs | None) -> Any:
        """Pointer to the inputs for the kernel.

        Raises
        ------
        ValueError
            If the model was made without inputs.
        """
        if inputs is not None and not self._takes_inputs:
            raise ValueError(
                "this model cannot take inputs, because parts of it are inactive; create it with"
                " Model(scene, inputs=True)"
            )
        return inputs_pointer(inputs, self._input_layout)


class _OneThread:
    """Guard that lets one thread at a time use a state; a second one gets an error at once."""

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise RuntimeError(
                "this State is in use by another thread; give each thread a State of its own"
            )

    def __exit__(self, *_: object) -> None:
        self._lock.release()


class State:
    """The motion of a model at one instant, which can be saved and restored bit for bit.

    `Model.start` and `Model.rest` create one. A state from the constructor must be restored before
    use. A state can be copied and pickled. One thread at a time can use it; another one gets a
    RuntimeError.
    """

    def __init__(self, model: CompiledModel) -> None:
        if not isinstance(model, CompiledModel):
            raise TypeError(f"model must be a Model, not {model!r:.60}")
        self.model = model
        block = np.zeros(model.state_size + VECTOR, dtype=np.uint8)
        self._block = block[-block.ctypes.data % VECTOR :]
        self._pointer = self._block.ctypes.data_as(c.c_void_p)
        self._alone = _OneThread()

    def __copy__(self) -> State:
        return _state_of(self.model, self.save())

    def __deepcopy__(self, memo: dict[int, Any]) -> State:
        return self.__copy__()

    def __reduce__(self) -> tuple[Any, ...]:
        return _state_of, (self.model, self.save())

    def _call(self, function: Any, *arguments: Any) -> Report:
        raw = CReport()
        with self._alone:
            code = function(self.model.handle, self._pointer, *arguments, c.byref(raw))
        report = unpacked(raw, self.model.map)
        if code:
            raise SimulationError(report)
        return report

    @property
    def time(self) -> float:
        """Time [s]; NaN in a state from the constructor that was not restored."""
        with self._alone:
            return float(kernel.gallop_state_time(self._pointer))

    def save(self) -> bytes:
        """Return the bytes that `restore` needs to continue the motion."""
        with self._alone:
            return c.string_at(self._pointer, self.model.saved_size)

    def restore(self, saved: bytes) -> None:
        """Return to a saved state of the same model, bit for bit.

        Raises
        ------
        ValueError
            If the bytes are not a saved state of this model, or are damaged.
        """
        size = self.model.saved_size
        content = memoryview(saved).tobytes()
        wrong = f"not a saved state of this model: {len(content)} bytes given, {size} expected"
        if len(content) != size:
            raise ValueError(wrong)
        block = np.frombuffer(content.ljust(-(-size // 8) * 8, b"\0"), dtype=np.float64).copy()
        if kernel.gallop_state_check(self.model.handle, block.ctypes.data_as(c.c_void_p)):
            raise ValueError(f"{wrong}, but they belong to another model or are damaged")
        with self._alone:
            c.memmove(self._pointer, content, size)

    def advance(self, until: float, inputs: Inputs | None = None) -> Report:
        """Step to `until` [s], in equal steps no longer than the scene's or by its tolerance.

        On failure the state does not change.

        Raises
        ------
        SimulationError
            If a step fails.
        """
        return self._call(kernel.gallop_advance, self.model.accept(inputs), number("until", until))

    def settle(self) -> Report:
        """Go to the static equilibrium in still air, without loads, with the ice left by now.

        On failure the state does not change.

        Raises
        ------
        SimulationError
            There is no such equilibrium.
        """
        return self._call(kernel.gallop_settle)

    def shedding_times(self) -> Array:
        """Times [s] at which ice fell, in the order of `map.sheddings`; infinite: it has not.

        Raises
        ------
        SimulationError
            The state was not started.
        """
        times = np.empty(len(self.model.map.sheddings))
        with self._alone:
            insist(
                kernel.gallop_shedding_times(
                    self.model.handle, self._pointer, double_pointer(times)
                )
            )
        return times

    def shedding_energies(self) -> Array:
        """Kinetic and potential energy [J] of the ice when it fell, shape (shedding, 2).

        The energy of the motion was reduced by it; 0 where the ice has not fallen.

        Raises
        ------
        SimulationError
            The state was not started.
        """
        energies = np.empty((len(self.model.map.sheddings), 2))
        with self._alone:
            insist(
                kernel.gallop_shedding_energies(
                    self.model.handle, self._pointer, double_pointer(energies)
                )
            )
        return energies

    def run(
        self,
        records: int,
        every: int,
        channels: ArrayLike,
        nodes: ArrayLike,
        span_channels: ArrayLike = ALL_SPAN_CHANNELS,
        first: int = 0,
    ) -> Run:
        """Advance and record.

        Parameters
        ----------
        records
            Number of records.
        every
            Number of time steps before each record.
        first
            Number of earlier records since the start of the motion.
        channels, nodes, span_channels
            Indices into `NODE_CHANNELS`, of nodes, and into `SPAN_CHANNELS`.

        Raises
        ------
        TypeError, ValueError, IndexError
            If an argument is not made of whole numbers, or out of range.
        SimulationError
            If the state was not started. A step that fails ends the run; the report says why.
        """
        asked = indices("channels", channels, len(NODE_CHANNELS))
        places = indices("nodes", nodes, self.model.nodes)
        of_span = indices("span_channels", span_channels, len(SPAN_CHANNELS))
        probes = np.concatenate(
            [node_probes(places, asked), span_probes(of_span, self.model.junctions)]
        )
        made, report = self.record(records, every, probes, first)
        of_nodes = len(places) * len(asked)
        by_node = made[:, :of_nodes].reshape(len(made), len(places), len(asked))
        return Run(by_node.transpose(0, 2, 1), made[:, of_nodes:], report)

    def record(
        self, records: int, every: int, probes: Probes, first: int = 0, threads: int = 1
    ) -> tuple[Array, Report]:
        """Advance and record any probes, see `gallop_fmu.engine.probes`.

        Parameters
        ----------
        records, every, first
            As of `run`.
        probes
            What to record.
        threads
            1 or 2; more than `model.threads` are not used. The values are the same.

        Returns
        -------
        tuple
            Values of the records that were made, of shape (record, probe), and the report.

        Raises
        ------
        TypeError, ValueError, SimulationError
            As `run`.
        """
        every = whole("every", every, 1, MOST_STEPS)
        first = whole("first", first, 0, MOST_STEPS // every)
        records = whole("records", records, 0, MOST_STEPS // every - first)
        values = np.empty((records, len(probes)))
        done, raw = c.c_int64(), CReport()
        threads = min(whole("threads", threads, 1, MAX_THREADS), self.model.threads)
        with self._alone, team_of(threads) as team:
            kernel.gallop_run_in_team(
                self.model.handle, self._pointer, first, records, every, *counted(probes),
                double_pointer(values), c.byref(done), team, c.byref(raw),
            )  # fmt: skip
        report = unpacked(raw, self.model.map)
        if report.outcome is Outcome.BAD_CALL:
            raise SimulationError(report)
        return values[: done.value], report

    def observe(self, probes: Probes) -> Array:
        """Values of any probes, see `gallop_fmu.engine.probes`.

        Raises
        ------
        SimulationError
            The state was not started, or a probe does not exist.
        """
        values = np.empty(len(probes))
        with self._alone:
            insist(
                kernel.gallop_observe(
                    self.model.handle, self._pointer, *counted(probes), double_pointer(values)
                )
            )
        return values

    def observe_node(self, node: int) -> Array:
        """All node channels at one node, in the order of `NODE_CHANNELS`."""
        place = whole("node", node, -(2**63), 2**63 - 1)
        if not 0 <= place < self.model.nodes:
            raise IndexError(
                f"node {place} does not exist; give a node from 0 to {self.model.nodes - 1}"
            )
        return self.observe(node_probes(np.array([place], dtype=np.int32), _NODE_CHANNELS))

    def observe_span(self) -> Array:
        """All span channels, in the order of `SPAN_CHANNELS`."""
        return self.observe(span_probes(ALL_SPAN_CHANNELS, self.model.junctions))

    def observe_junction(self, junction: int) -> Array:
        """Force [N] of the cables on the tower at a junction, along x1, x2, x3.

        Raises
        ------
        ValueError
            If there is no junction of this index.
        """
        last = self.model.junctions - 1
        return self.observe(junction_probes(whole("junction", junction, 0, last)))

    def motion(self) -> tuple[Array, Array, Array]:
        """Displacement, velocity and acceleration, each of shape (node, 4)."""
        nodes = np.arange(self.model.nodes, dtype=np.int32)
        values = self.observe(node_probes(nodes, _NODE_CHANNELS[: 3 * DOFS]))
        u, v, a = values.reshape(self.model.nodes, 3, DOFS).transpose(1, 0, 2)
        return u, v, a


def counted(probes: Probes) -> tuple[Any, int]:
    """Pointer to probes, and their number."""
    return probes.ctypes.data_as(_ProbePointer), len(probes)


def _state_of(model: CompiledModel, saved: bytes) -> State:
    state = State(model)
    if any(saved):
        state.restore(saved)
    return state


@dataclass(frozen=True, slots=True)
class Run:
    """Records of `State.run`: (record, channel, node) and (record, channel) arrays, report."""

    node_values: Array
    span_values: Array
    report: Report
