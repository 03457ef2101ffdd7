"""Spans and their motion, computed by the compiled kernel.

`Model` is a span ready to compute; `State` is its motion at one instant.  Both release the interpreter lock while the
kernel works, so several states may run in several threads on one model.
"""

from __future__ import annotations

import ctypes as c
import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.channels import NODE_CHANNELS, SPAN_CHANNELS
from gallop_fmu.library import kernel
from gallop_fmu.outcome import Report, SimulationError
from gallop_fmu.scene import Scene
from gallop_fmu.structures import CDerived, CInputs, CReport, Packed, Three, double_pointer, unpacked

Array = NDArray[np.float64]
DOFS = 4
"""Unknowns a node: u1, u2, u3, theta."""

ALL_SPAN_CHANNELS = np.arange(len(SPAN_CHANNELS), dtype=np.int32)
"""Indices of what can be recorded once per state."""

STATE_MAGIC = b"GALLOP1\0"
"""First bytes of a saved state."""


@dataclass(slots=True)
class Inputs:
    """What a co-simulation host sets instead of the scene's laws; each changes linearly in time from `time` on.

    Attributes
    ----------
    time : float
        Time [s] to which the values belong.
    wind_speed, attack_angle : float
        Wind speed [m/s] and initial angle of the ice [rad].
    support : ndarray, shape (2, 3)
        Displacement [m] of the left and right tower point along x1, x2, x3.
    wind_speed_rate, attack_angle_rate, support_rate
        Their rates [unit/s].
    """

    time: float
    wind_speed: float
    attack_angle: float
    support: Array
    wind_speed_rate: float = 0.0
    attack_angle_rate: float = 0.0
    support_rate: Array | None = None

    def packed(self) -> CInputs:
        """The kernel's form of the inputs."""
        packed = CInputs(self.time, self.wind_speed, self.attack_angle)
        packed.wind_speed_rate, packed.attack_angle_rate = self.wind_speed_rate, self.attack_angle_rate
        for end in range(2):
            packed.support[end] = Three(*self.support[end])
            if self.support_rate is not None:
                packed.support_rate[end] = Three(*self.support_rate[end])
        return packed


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """The initial equilibrium and the numbers derived from the scene.

    Attributes
    ----------
    x : ndarray, shape (node, 3)
        Positions [m] of the nodes.
    sag, horizontal_tension, length : float
        Sag [m] below the chord, horizontal tension [N], length [m] of the conductor.
    support_force : ndarray, shape (2, 3)
        Static force [N] of the cable on the left and right tower.
    support_stiffness : ndarray, shape (2, 2)
        Spring stiffness [N/m] along x1 and x3; 0 where the support is rigid.
    translation_damping, twist_damping : tuple of float
        Rayleigh b1 [1/s] and b2 [s].
    imbalance : float
        Largest nodal force [N] that holds an initial state of which both sag and tension were given.
    """

    x: Array
    sag: float
    horizontal_tension: float
    length: float
    support_force: Array
    support_stiffness: Array
    translation_damping: tuple[float, float]
    twist_damping: tuple[float, float]
    imbalance: float


def _inputs_pointer(inputs: Inputs | None) -> Any:
    return None if inputs is None else c.byref(inputs.packed())


class Part(enum.IntFlag):
    """What a scene may not need; a model computes a part if anything can wake it."""

    AERODYNAMICS = 1
    ECCENTRIC_ICE = 2
    TWIST = 4
    LATERAL_MOTION = 8


class Model:
    """A span ready to compute: mesh, initial equilibrium, aerodynamic curve.

    Parameters
    ----------
    scene
        The scene to compute.
    inputs
        Whether `Inputs` may replace the scene's laws, as in an FMU.  False: they may not, and what the laws alone leave
        at rest is left out: wind that never blows, and lateral motion that nothing wakes.  Twist that neither ice nor
        an aerodynamic moment nor a torque wakes is left out in any case, since no input can wake it.

    Attributes
    ----------
    parts : Part
        What is computed.

    Raises
    ------
    SimulationError
        If no initial equilibrium exists.
    """

    def __init__(self, scene: Scene, *, inputs: bool = True) -> None:
        packed, raw, handle = Packed(scene), CReport(), c.c_void_p()
        packed.scene.laws_only = not inputs
        self._handle: c.c_void_p | None = None
        if kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(raw)):
            raise SimulationError(unpacked(raw))
        self._handle = handle
        self.scene = scene
        self.elements = scene.numerics.elements
        self.nodes = 2 * self.elements + 1
        self.state_size = int(kernel.gallop_state_size(handle))
        self.saved_size = int(kernel.gallop_saved_size(handle))
        self._takes_inputs = inputs
        derived = CDerived()
        kernel.gallop_model_derived(handle, c.byref(derived))
        self.parts = Part(derived.parts)

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            kernel.gallop_model_free(self._handle)
            self._handle = None

    @property
    def handle(self) -> c.c_void_p:
        """Pointer to the kernel's model."""
        assert self._handle is not None
        return self._handle

    @property
    def unknowns(self) -> tuple[str, ...]:
        """The unknowns of a node that are computed; the others stay zero."""
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
            raise ValueError("this model leaves out what inputs could wake; make it with Model(scene, inputs=True)")
        return _inputs_pointer(inputs)

    @property
    def middle(self) -> int:
        """Index of the mid-span node."""
        return self.nodes // 2

    def equilibrium(self) -> Equilibrium:
        """The initial equilibrium and the numbers derived from the scene."""
        raw, x = CDerived(), np.empty((self.nodes, 3))
        kernel.gallop_model_derived(self.handle, c.byref(raw))
        kernel.gallop_model_nodes(self.handle, double_pointer(x))
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
            np.zeros(shape) if y is None else np.array(y, dtype=np.float64, order="C").reshape(shape) for y in (u, v, a)
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
        """Out-of-balance forces of the free body (without support springs).

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
        """
        motion, out = self._motion(u, v, a), np.empty((self.nodes, DOFS))
        pointers = [double_pointer(y) for y in motion]
        work = State(self)  # for its scratch memory alone
        kernel.gallop_residual(
            self.handle, work._pointer, time, _inputs_pointer(inputs), *pointers, double_pointer(out)
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
        factors = (stiffness, damping, mass)
        work = State(self)  # for its scratch memory alone
        kernel.gallop_tangent(
            self.handle, work._pointer, time, _inputs_pointer(inputs), *pointers, *factors, double_pointer(out)
        )
        return out

    def start(self, time: float = 0.0, inputs: Inputs | None = None) -> State:
        """The scene's initial state: equilibrium, seed, consistent accelerations.

        Raises
        ------
        SimulationError
            If the attack angle is out of range, or no equilibrium under wind or support displacement exists.
        """
        state = State(self)
        state._call(kernel.gallop_state_init, time, self.accept(inputs))
        return state

    def rest(self, time: float = 0.0, inputs: Inputs | None = None) -> State:
        """Static equilibrium under wind, loads and support displacement at `time`, found by load stepping."""
        state = State(self)
        state._call(kernel.gallop_equilibrium, time, self.accept(inputs))
        return state


class State:
    """The motion of a model at one instant: one flat block of memory, which can be saved and restored bit for bit."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._block = np.zeros(model.state_size // 8 + 1)
        self._pointer = self._block.ctypes.data_as(c.c_void_p)

    def _call(self, function: Any, *arguments: Any) -> Report:
        raw = CReport()
        code = function(self.model.handle, self._pointer, *arguments, c.byref(raw))
        report = unpacked(raw)
        if code:
            raise SimulationError(report)
        return report

    @property
    def time(self) -> float:
        """Time [s]."""
        return float(kernel.gallop_state_time(self._pointer))

    def save(self) -> bytes:
        """Everything that the future of the motion depends on."""
        return c.string_at(self._pointer, self.model.saved_size)

    def restore(self, saved: bytes) -> None:
        """Return to a saved state of the same model, bit for bit.

        Raises
        ------
        ValueError
            If the bytes are not a saved state of this model.
        """
        size = self.model.saved_size
        if len(saved) != size or saved[:8] != STATE_MAGIC:
            raise ValueError(f"not a saved state of this model: {len(saved)} bytes given, {size} expected")
        c.memmove(self._pointer, saved, size)

    def advance(self, until: float, inputs: Inputs | None = None) -> Report:
        """Step to `until` [s], in equal steps no longer than the scene's or by its tolerance.

        On failure the state is what it was.

        Raises
        ------
        SimulationError
            If a step cannot be carried out.
        """
        return self._call(kernel.gallop_advance, self.model.accept(inputs), until)

    def run(
        self,
        records: int,
        every: int,
        channels: NDArray[np.int32],
        nodes: NDArray[np.int32],
        span_channels: NDArray[np.int32] = ALL_SPAN_CHANNELS,
        first: int = 0,
    ) -> Run:
        """Advance `records` times by `every` steps and observe after each; `first` counts the records already made."""
        node_values = np.empty((records, len(channels), len(nodes)))
        span_values = np.empty((records, len(span_channels)))
        done, raw = c.c_int64(), CReport()
        integers = c.POINTER(c.c_int32)
        kernel.gallop_run(
            self.model.handle, self._pointer, first, records, every,
            channels.ctypes.data_as(integers), len(channels), nodes.ctypes.data_as(integers), len(nodes),
            span_channels.ctypes.data_as(integers), len(span_channels),
            double_pointer(node_values), double_pointer(span_values), c.byref(done), c.byref(raw),
        )  # fmt: skip
        return Run(node_values[: done.value], span_values[: done.value], unpacked(raw))

    def observe_node(self, node: int) -> Array:
        """All node channels at one node, in the order of `NODE_CHANNELS`."""
        if not 0 <= node < self.model.nodes:
            raise IndexError(f"node {node} does not exist; the mesh has nodes 0 to {self.model.nodes - 1}")
        values = np.empty(len(NODE_CHANNELS))
        kernel.gallop_observe_node(self.model.handle, self._pointer, node, double_pointer(values))
        return values

    def observe_span(self) -> Array:
        """All span channels, in the order of `SPAN_CHANNELS`."""
        values = np.empty(len(SPAN_CHANNELS))
        kernel.gallop_observe_span(self.model.handle, self._pointer, double_pointer(values))
        return values

    def motion(self) -> tuple[Array, Array, Array]:
        """Displacement, velocity and acceleration, each of shape (node, 4)."""
        values = np.array([self.observe_node(node)[: 3 * DOFS] for node in range(self.model.nodes)])
        return values[:, :DOFS], values[:, DOFS : 2 * DOFS], values[:, 2 * DOFS :]


@dataclass(frozen=True, slots=True)
class Run:
    """Records of `State.run`: node values (record, channel, node), span values (record, channel), and the report."""

    node_values: Array
    span_values: Array
    report: Report
