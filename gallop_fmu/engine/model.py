"""Spans and lines, computed by the compiled kernel.

`Model` is a span or line ready to compute; `State` is its motion at one instant.  Both release the
interpreter lock while the kernel works, so several states may run in several threads on one model.
"""

from __future__ import annotations

import ctypes as c
import enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import CDerived, CDerivedChain, CReport
from gallop_fmu.engine.equilibrium import ChainEquilibrium, Equilibrium
from gallop_fmu.engine.inputs import InputLayout, Inputs
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.pack import Packed, double_pointer, unpacked
from gallop_fmu.engine.probes import Probes
from gallop_fmu.engine.state import DOFS, CompiledModel, Run, State, counted, insist
from gallop_fmu.foundation.argument_checks import finite, number, numbers, whole
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.input.scene_like import SceneLike, as_scene

__all__ = ["DOFS", "Model", "Part", "Run", "State"]

Array = NDArray[np.float64]


class Part(enum.IntFlag):
    """Parts of the equations that some scenes do not need; an inactive part stays zero."""

    AERODYNAMICS = 1
    ECCENTRIC_ICE = 2
    TWIST = 4
    LATERAL_MOTION = 8


class Model(CompiledModel):
    """A span or line with its mesh, initial equilibrium and coefficient curves.

    A model does not change. A copy of a model is the model itself; unpickling creates it again from
    its scene.

    Parameters
    ----------
    scene
        The scene to compute, its name or its path.
    inputs
        True: `Inputs` can replace the laws of the scene, as in an FMU. False: they cannot, and what
        the laws never excite is inactive, such as the aerodynamic load if the wind never blows, and
        lateral motion. The twist is inactive in both cases if no ice, aerodynamic moment or torque
        excites it.
    shedding_times : array_like, shape (shedding,)
        Times [s] at which ice falls, in the order of `map.sheddings`, in place of the scene's times
        and limits of acceleration; infinite: never. None: those of the scene.
    packed
        The packed scene, if it exists already; it must be that of `scene`.

    Attributes
    ----------
    scene : Scene or LineScene
        Its scene.
    map : LineMap
        Which chains, nodes, junctions and devices are which part of the line.
    elements, nodes, junctions : int
        Their total numbers.
    parts : Part
        Active parts.
    threads : int
        Number of threads that can share a run: 2 of a long line, else 1.
    devices : tuple of tuple of int
        Indices of the junctions of each device.
    section_of_element : ndarray of int, shape (element,)
        Cross-section of each element: elements with the same number have the same conductor, ice
        and coefficient curve.
    attack_of_element : ndarray, shape (element,)
        Initial attack angle [rad] of the ice on each element.
    shedding_times
        As given.

    Raises
    ------
    SimulationError
        If no initial equilibrium exists.
    """

    def __init__(
        self,
        scene: SceneLike,
        *,
        inputs: bool = True,
        shedding_times: ArrayLike | None = None,
        packed: Packed | None = None,
    ) -> None:
        scene = as_scene(scene)
        packed, raw, handle = packed or Packed(scene), CReport(), c.c_void_p()
        packed.scene.settings.laws_only = not inputs
        self.shedding_times = shedding_times
        if shedding_times is not None:
            packed.set_shedding_times(shedding_times)
        self._handle: c.c_void_p | None = None
        if kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(raw)):
            raise SimulationError(unpacked(raw, packed.map))
        self._handle = handle
        self.scene = scene
        self.map = packed.map
        self.elements, self.nodes = self.map.elements, self.map.nodes
        self.junctions = self.map.junctions
        self.devices = packed.device_junctions
        self.section_of_element, self.attack_of_element = packed.sections_of_elements()
        self.state_size = int(kernel.gallop_state_size(handle))
        self.saved_size = int(kernel.gallop_saved_size(handle))
        self._takes_inputs = inputs
        self._input_layout = InputLayout(
            int(packed.scene.field_count), self.junctions, self.map.junctions_of_towers
        )
        derived = CDerived()
        insist(kernel.gallop_model_derived(handle, c.byref(derived)))
        self.parts, self.threads = Part(derived.parts), int(derived.threads)

    def __del__(self) -> None:
        if getattr(self, "_handle", None) is not None:
            kernel.gallop_model_free(self._handle)
            self._handle = None

    def __copy__(self) -> Model:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Model:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _model_of, (self.scene, self._takes_inputs, self.shedding_times)

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Active unknowns of a node; the others stay zero."""
        lateral = ("u3",) if Part.LATERAL_MOTION in self.parts else ()
        return ("u1", "u2", *lateral, *(("theta",) if Part.TWIST in self.parts else ()))

    @property
    def middle(self) -> int:
        """Index of the mid-span node; of a line that of its first chain."""
        return self.map.chains[0].middle

    def equilibrium(self) -> Equilibrium:
        """The initial equilibrium and the numbers derived from the scene."""
        raw, x = CDerived(), np.empty((self.nodes, 3))
        insist(kernel.gallop_model_derived(self.handle, c.byref(raw)))
        insist(kernel.gallop_model_nodes(self.handle, double_pointer(x)))
        return Equilibrium(
            x=x,
            sag=raw.sag,
            horizontal_tension=raw.horizontal_tension,
            length=raw.length,
            support_force=np.frombuffer(raw.support_force).reshape(2, 3),
            support_stiffness=np.frombuffer(raw.support_stiffness).reshape(2, 2),
            translation_damping=(raw.translation_damping[0], raw.translation_damping[1]),
            twist_damping=(raw.twist_damping[0], raw.twist_damping[1]),
            imbalance=raw.imbalance,
        )

    def chain_equilibrium(self, chain: int) -> ChainEquilibrium:
        """The initial equilibrium of a chain, by its index in `map.chains`.

        Raises
        ------
        TypeError, ValueError
            There is no such chain.
        """
        raw = CDerivedChain()
        index = whole("chain", chain, 0, len(self.map.chains) - 1)
        insist(kernel.gallop_chain_derived(self.handle, index, c.byref(raw)))
        force = np.array([list(row) for row in raw.end_force])
        return ChainEquilibrium(raw.sag, raw.horizontal_tension, raw.length, force)

    def observe_equilibrium(self, probes: Probes) -> Array:
        """Values of probes of junctions and devices in the initial equilibrium, in still air.

        Raises
        ------
        SimulationError
            A probe is of another object, or does not exist.
        """
        values = np.empty(len(probes))
        insist(
            kernel.gallop_observe_equilibrium(self.handle, *counted(probes), double_pointer(values))
        )
        return values

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
        insist(
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
        insist(
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
        insist(
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

    def device_load(self, device: int, u: ArrayLike, v: ArrayLike) -> tuple[Array, Array, Array]:
        """Forces of a device in many motions of its junctions, without inertia, towers at rest.

        Parameters
        ----------
        device
            Index into `devices`.
        u, v : array_like, shape (motion, junction, 4)
            Displacements [m, rad] and velocities [m/s, rad/s].

        Returns
        -------
        ndarray, shape (motion, junction, 4)
            Forces and moment [N, N m].
        ndarray, ndarray, shape (motion, junction, junction, 4, 4)
            Their derivatives by u and v: junction of the force, junction of the motion; rows and
            columns u1 u2 u3 theta.

        Raises
        ------
        TypeError, ValueError
            If an argument is not made of finite numbers or has another shape, or there is no such
            device.
        """
        device = whole("device", device, 0, len(self.devices) - 1)
        count, junctions = len(np.asarray(u)), len(self.devices[device])
        shape = (count, junctions, DOFS)
        given = [numbers(name, y, shape) for name, y in (("u", u), ("v", v))]
        force = np.empty(shape)
        by_u, by_v = np.empty((2, count, junctions, junctions, DOFS, DOFS))
        arrays = [double_pointer(y) for y in (*given, force, by_u, by_v)]
        insist(kernel.gallop_device_load(self.handle, device, count, *arrays))
        return force, by_u, by_v

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
        insist(kernel.gallop_junction_nodes(self.handle, *pointers))
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

    def place(
        self, u: ArrayLike, v: ArrayLike, time: float = 0.0, inputs: Inputs | None = None
    ) -> State:
        """Start in a given motion, with consistent accelerations.

        Parameters
        ----------
        u, v : array_like, shape (node, 4)
            Displacements [m, rad] from the initial equilibrium, and velocities [m/s, rad/s]. Where
            supports prescribe the motion, that is used.
        time
            Time [s].
        inputs
            Values that replace the scene's laws.

        Raises
        ------
        TypeError, ValueError
            If u or v have another shape or are not finite.
        SimulationError
            If the cable is slack or the attack angle is out of range.
        """
        state = State(self)
        motion = [double_pointer(y) for y in self._motion(u, v, None)[:2]]
        state._call(kernel.gallop_state_place, number("time", time), self.accept(inputs), *motion)
        return state


def _model_of(scene: SceneLike, inputs: bool, shedding_times: ArrayLike | None = None) -> Model:
    return Model(scene, inputs=inputs, shedding_times=shedding_times)
