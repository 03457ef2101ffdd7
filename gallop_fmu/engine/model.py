"""Spans and their motion, computed by the compiled kernel.

`Model` is a span ready to compute; `State` is its motion at one instant.  Both release the
interpreter lock while the kernel works, so several states may run in several threads on one model.
"""

from __future__ import annotations

import ctypes as c
import enum
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import CDerived, CProbe, CReport
from gallop_fmu.engine.equilibrium import Equilibrium
from gallop_fmu.engine.inputs import Inputs, inputs_pointer
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.pack import Packed, double_pointer, unpacked
from gallop_fmu.engine.probes import Probes, junction_probes, node_probes, span_probes
from gallop_fmu.foundation.argument_checks import finite, indices, number, numbers, whole
from gallop_fmu.foundation.channels import NODE_CHANNELS, SPAN_CHANNELS
from gallop_fmu.foundation.outcome import Outcome, Report, SimulationError
from gallop_fmu.scene.scene import Scene

Array = NDArray[np.float64]
DOFS = 4
"""Unknowns a node: u1, u2, u3, theta."""

ALL_SPAN_CHANNELS = np.arange(len(SPAN_CHANNELS), dtype=np.int32)
"""Indices of all span channels."""

_NODE_CHANNELS = np.arange(len(NODE_CHANNELS), dtype=np.int32)
_ProbePointer = c.POINTER(CProbe)

MOST_STEPS = 10**12
"""Maximum number of time steps of one call."""


def _insist(outcome: int) -> None:
    """Raise SimulationError if a function without a report refused its state."""
    if outcome:
        fault = kernel.gallop_arithmetic_fault()
        field = (
            fault.decode()
            if fault
            else "state, which was not started; Model.start and Model.rest start one"
        )
        raise SimulationError(Report(Outcome.from_code(outcome), 0.0, field=field))


class Part(enum.IntFlag):
    """Parts of the equations that some scenes do not need; an inactive part stays zero."""

    AERODYNAMICS = 1
    ECCENTRIC_ICE = 2
    TWIST = 4
    LATERAL_MOTION = 8


class Model:
    """A span with its mesh, initial equilibrium and coefficient curve.

    A model does not change. A copy of a model is the model itself; unpickling creates it again from
    its scene.

    Parameters
    ----------
    scene
        The scene to compute.
    inputs
        True: `Inputs` can replace the laws of the scene, as in an FMU. False: they cannot, and what
        the laws never excite is inactive, such as the aerodynamic load if the wind never blows, and
        lateral motion. The twist is inactive in both cases if no ice, aerodynamic moment or torque
        excites it.

    Attributes
    ----------
    parts : Part
        Active parts.
    devices : tuple of tuple of int
        Indices of the junctions of each device.

    Raises
    ------
    SimulationError
        If no initial equilibrium exists.
    """

    def __init__(self, scene: Scene, *, inputs: bool = True) -> None:
        if not isinstance(scene, Scene):
            raise TypeError(
                f"scene must be a Scene, not {scene!r:.60}; load_scene and Scene.from_dict make one"
            )
        packed, raw, handle = Packed(scene), CReport(), c.c_void_p()
        packed.scene.settings.laws_only = not inputs
        self._handle: c.c_void_p | None = None
        if kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(raw)):
            raise SimulationError(unpacked(raw))
        self._handle = handle
        self.scene = scene
        self.elements = scene.numerics.elements
        self.nodes = 2 * self.elements + 1
        self.junctions = int(packed.scene.junction_count)
        self.devices = packed.device_junctions
        self.state_size = int(kernel.gallop_state_size(handle))
        self.saved_size = int(kernel.gallop_saved_size(handle))
        self._takes_inputs = inputs
        derived = CDerived()
        _insist(kernel.gallop_model_derived(handle, c.byref(derived)))
        self.parts = Part(derived.parts)

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            kernel.gallop_model_free(self._handle)
            self._handle = None

    def __copy__(self) -> Model:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Model:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _model_of, (self.scene, self._takes_inputs)

    @property
    def handle(self) -> c.c_void_p:
        """Pointer to the kernel's model."""
        assert self._handle is not None
        return self._handle

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Active unknowns of a node; the others stay zero."""
        lateral = ("u3",) if Part.LATERAL_MOTION in self.parts else ()
        return ("u1", "u2", *lateral, *(("theta",) if Part.TWIST in self.parts else ()))

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
        return inputs_pointer(inputs)

    @property
    def middle(self) -> int:
        """Index of the mid-span node."""
        return self.nodes // 2

    def equilibrium(self) -> Equilibrium:
        """The initial equilibrium and the numbers derived from the scene."""
        raw, x = CDerived(), np.empty((self.nodes, 3))
        _insist(kernel.gallop_model_derived(self.handle, c.byref(raw)))
        _insist(kernel.gallop_model_nodes(self.handle, double_pointer(x)))
        return Equilibrium(
            x=x,
            sag=raw.sag,
            horizontal_tension=raw.horizontal_tension,
            length=raw.length,
            support_force=np.array([list(row) for row in raw.support_force]),
            support_stiffness=np.array([list(row) for row in raw.support_stiffness]),
            translation_damping=(raw.translation_damping[0], raw.translation_damping[1]),
            twist_damping=(raw.twist_damping[0], raw.twist_damping[1]),
            imbalance=raw.imbalance,
        )

    def _motion(self, u: ArrayLike | None, v: ArrayLike | None, a: ArrayLike | None) -> list[Array]:
        shape = (self.nodes, DOFS)
        return [
            np.zeros(shape) if y is None else numbers(name, y, shape)
            for name, y in zip("uva", (u, v, a), strict=True)
        ]

    def residual(
        self,
        u: ArrayLike | None = None,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        time: float = 0.0,
        inputs: Inputs | None = None,
    ) -> Array:
        """Residual forces of the free body (without support springs).

        Parameters
        ----------
        u, v, a : array_like, shape (node, 4)
            Displacement, velocity and acceleration [m, rad, s]; None is zero.
        time
            Time [s] at which the scene's laws are read.
        inputs
            Values that replace the scene's laws.

        Returns
        -------
        ndarray, shape (node, 4)
            Internal + inertia + damping - aerodynamic - applied forces [N, N m].

        Raises
        ------
        TypeError, ValueError
            If an argument is not made of finite numbers, or has another shape.
        """
        motion, out = self._motion(u, v, a), np.empty((self.nodes, DOFS))
        pointers = [double_pointer(y) for y in motion]
        work = State(self)  # for its scratch memory alone
        _insist(
            kernel.gallop_residual(
                self.handle,
                work._pointer,
                finite("time", time),
                self.accept(inputs),
                *pointers,
                double_pointer(out),
            )
        )
        return out

    def tangent(
        self,
        u: ArrayLike | None = None,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        stiffness: float = 0.0,
        damping: float = 0.0,
        mass: float = 0.0,
        time: float = 0.0,
        inputs: Inputs | None = None,
    ) -> Array:
        """Element matrices ``stiffness dR/du + damping dR/dv + mass dR/da`` of `residual`.

        Returns
        -------
        ndarray, shape (element, 12, 12)
            Rows and columns: left, middle, right node, each u1 u2 u3 theta.
        """
        motion, out = self._motion(u, v, a), np.empty((self.elements, 3 * DOFS, 3 * DOFS))
        pointers = [double_pointer(y) for y in motion]
        given = {"stiffness": stiffness, "damping": damping, "mass": mass}
        factors = [finite(name, factor) for name, factor in given.items()]
        work = State(self)  # for its scratch memory alone
        _insist(
            kernel.gallop_tangent(
                self.handle,
                work._pointer,
                finite("time", time),
                self.accept(inputs),
                *pointers,
                *factors,
                double_pointer(out),
            )
        )
        return out

    def _call_device(
        self,
        function: Any,
        device: int,
        motion: tuple[ArrayLike | None, ...],
        time: float,
        inputs: Inputs | None,
        *arguments: Any,
        factors: tuple[float, ...] = (),
    ) -> None:
        """Call a function of one device in a given motion."""
        arrays = self._motion(*motion)
        work = State(self)  # for its scratch memory alone
        _insist(
            function(
                self.handle,
                work._pointer,
                finite("time", time),
                self.accept(inputs),
                *(double_pointer(y) for y in arrays),
                *factors,
                device,
                *arguments,
            )
        )

    def device_force(
        self,
        device: int,
        u: ArrayLike | None = None,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        time: float = 0.0,
        inputs: Inputs | None = None,
    ) -> tuple[Array, float, float]:
        """Forces and energy of a device in a given motion.

        Parameters
        ----------
        device
            Index into `devices`.
        u, v, a, time, inputs
            As in `residual`.

        Returns
        -------
        force : ndarray, shape (junction, 4)
            Forces and moment [N, N m] of its stiffness, damping and mass, and against its weight;
            they add to `residual`.
        kinetic, potential : float
            Energy [J]; the potential one from the initial equilibrium.

        Raises
        ------
        TypeError, ValueError
            As in `residual`, or if there is no such device.
        """
        device = whole("device", device, 0, len(self.devices) - 1)
        force, energy = np.empty((len(self.devices[device]), DOFS)), np.empty(2)
        out = (double_pointer(force), double_pointer(energy))
        self._call_device(kernel.gallop_device_force, device, (u, v, a), time, inputs, *out)
        return force, float(energy[0]), float(energy[1])

    def device_tangent(  # noqa: PLR0913 - all but four are keyword arguments
        self,
        device: int,
        u: ArrayLike | None = None,
        v: ArrayLike | None = None,
        a: ArrayLike | None = None,
        *,
        stiffness: float = 0.0,
        damping: float = 0.0,
        mass: float = 0.0,
        time: float = 0.0,
        inputs: Inputs | None = None,
    ) -> Array:
        """Matrix ``stiffness dF/du + damping dF/dv + mass dF/da`` of the forces of a device.

        Parameters
        ----------
        device
            Index into `devices`.
        u, v, a, stiffness, damping, mass, time, inputs
            As in `tangent`.

        Returns
        -------
        ndarray, shape (junction, junction, 4, 4)
            Junction of the force, junction of the motion; rows and columns u1 u2 u3 theta.

        Raises
        ------
        TypeError, ValueError
            As in `tangent`, or if there is no such device.
        """
        device = whole("device", device, 0, len(self.devices) - 1)
        count = len(self.devices[device])
        out = np.empty((count, count, DOFS, DOFS))
        given = {"stiffness": stiffness, "damping": damping, "mass": mass}
        factors = tuple(finite(name, factor) for name, factor in given.items())
        self._call_device(
            *(kernel.gallop_device_tangent, device, (u, v, a), time, inputs, double_pointer(out)),
            factors=factors,
        )
        return out

    def junction_nodes(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Nodes of the junctions, and nodes that are the same point.

        Returns
        -------
        node : ndarray of int, shape (junction,)
            Node whose motion is that of the junction.
        leader : ndarray of int, shape (node,)
            Node whose motion a node has: at a junction where several chains end, that of the first
            of them; elsewhere its own.
        """
        node = np.empty(self.junctions, dtype=np.int32)
        leader = np.empty(self.nodes, dtype=np.int32)
        integers = c.POINTER(c.c_int32)
        pointers = [array.ctypes.data_as(integers) for array in (node, leader)]
        _insist(kernel.gallop_junction_nodes(self.handle, *pointers))
        return node, leader

    def start(self, time: float = 0.0, inputs: Inputs | None = None) -> State:
        """The scene's initial state: equilibrium, seed, consistent accelerations.

        Raises
        ------
        SimulationError
            If the attack angle is out of range, or no equilibrium under wind or support
            displacement exists.
        """
        state = State(self)
        state._call(kernel.gallop_state_init, number("time", time), self.accept(inputs))
        return state

    def rest(self, time: float = 0.0, inputs: Inputs | None = None) -> State:
        """Find the static equilibrium under wind, loads and support displacement at `time` [s]."""
        state = State(self)
        state._call(kernel.gallop_equilibrium, number("time", time), self.accept(inputs))
        return state


def _model_of(scene: Scene, inputs: bool) -> Model:
    return Model(scene, inputs=inputs)


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

    def __init__(self, model: Model) -> None:
        if not isinstance(model, Model):
            raise TypeError(f"model must be a Model, not {model!r:.60}")
        self.model = model
        self._block = np.zeros(model.state_size // 8 + 1)
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
        report = unpacked(raw)
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
        every = whole("every", every, 1, MOST_STEPS)
        first = whole("first", first, 0, MOST_STEPS // every)
        records = whole("records", records, 0, MOST_STEPS // every - first)
        asked = indices("channels", channels, len(NODE_CHANNELS))
        places = indices("nodes", nodes, self.model.nodes)
        of_span = indices("span_channels", span_channels, len(SPAN_CHANNELS))
        probes = np.concatenate(
            [node_probes(places, asked), span_probes(of_span, self.model.junctions)]
        )
        values, of_nodes = np.empty((records, len(probes))), len(places) * len(asked)
        done, raw = c.c_int64(), CReport()
        with self._alone:
            kernel.gallop_run(
                self.model.handle, self._pointer, first, records, every, *_counted(probes),
                double_pointer(values), c.byref(done), c.byref(raw),
            )  # fmt: skip
        report = unpacked(raw)
        if report.outcome is Outcome.BAD_CALL:
            raise SimulationError(report)
        made = values[: done.value]
        by_node = made[:, :of_nodes].reshape(len(made), len(places), len(asked))
        return Run(by_node.transpose(0, 2, 1), made[:, of_nodes:], report)

    def _observe(self, probes: Probes) -> Array:
        values = np.empty(len(probes))
        with self._alone:
            _insist(
                kernel.gallop_observe(
                    self.model.handle, self._pointer, *_counted(probes), double_pointer(values)
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
        return self._observe(node_probes(np.array([place], dtype=np.int32), _NODE_CHANNELS))

    def observe_span(self) -> Array:
        """All span channels, in the order of `SPAN_CHANNELS`."""
        return self._observe(span_probes(ALL_SPAN_CHANNELS, self.model.junctions))

    def observe_junction(self, junction: int) -> Array:
        """Force [N] of the cables on the tower at a junction, along x1, x2, x3.

        Raises
        ------
        ValueError
            If there is no junction of this index.
        """
        last = self.model.junctions - 1
        return self._observe(junction_probes(whole("junction", junction, 0, last)))

    def motion(self) -> tuple[Array, Array, Array]:
        """Displacement, velocity and acceleration, each of shape (node, 4)."""
        nodes = np.arange(self.model.nodes, dtype=np.int32)
        values = self._observe(node_probes(nodes, _NODE_CHANNELS[: 3 * DOFS]))
        u, v, a = values.reshape(self.model.nodes, 3, DOFS).transpose(1, 0, 2)
        return u, v, a


def _counted(probes: Probes) -> tuple[Any, int]:
    """Pointer to probes, and their number."""
    return probes.ctypes.data_as(_ProbePointer), len(probes)


def _state_of(model: Model, saved: bytes) -> State:
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
