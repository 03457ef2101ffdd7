"""Inputs of a co-simulation host, which replace the laws of a scene."""

from __future__ import annotations

import ctypes as c
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gallop_fmu.engine.ctypes_structs import CInputs, Pointer
from gallop_fmu.foundation.argument_checks import finite, numbers
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

Array = NDArray[np.float64]


class InputLayout(NamedTuple):
    """What a host can set of a model: counts of the kernel's tables, and junctions by tower.

    Attributes
    ----------
    fields, junctions : int
        Fields of wind, one for each span; junctions.
    towers : sequence of sequence of int
        Indices of the junctions that move with each tower, from the left end to the right end.
    """

    fields: int
    junctions: int
    towers: Sequence[Sequence[int]]


@dataclass(slots=True)
class Inputs:
    """Inputs of a co-simulation host, which replace the laws of the scene.

    From `time` on, each changes linearly in time.

    Attributes
    ----------
    time : float
        Time [s] to which the values belong.
    wind_speed : float or ndarray, shape (span,)
        Wind speed [m/s], of all spans or of each.
    attack_angle : float
        Initial angle of the ice [rad]; of a line that of the first span, and the ice of the others
        turns by the same change.
    support : ndarray, shape (tower, 3)
        Displacement [m] of the towers along x1, x2, x3, from the left end to the right end: two of
        a single span.
    wind_speed_rate, attack_angle_rate, support_rate
        Their rates [unit/s].
    wind_direction : float or ndarray, shape (span,), or None
        Direction [rad] of the wind, of all spans or of each; None: the scene's laws hold. Wind that
        a scene describes by its speed alone is always normal to the line.
    wind_direction_rate : float or ndarray
        Its rate [rad/s].
    """

    time: float
    wind_speed: float | Array
    attack_angle: float
    support: Array
    wind_speed_rate: float | Array = 0.0
    attack_angle_rate: float = 0.0
    support_rate: Array | None = None
    wind_direction: float | Array | None = None
    wind_direction_rate: float | Array = 0.0

    @classmethod
    def still(
        cls,
        scene: Scene | LineScene,
        attack_angle: float | None = None,
        wind_speed: float | Array = 0.0,
    ) -> Inputs:
        """Towers at rest, and no wind unless it is given; the ice at the scene's attack angle.

        Parameters
        ----------
        scene
            The scene.
        attack_angle
            Another attack angle [rad]; None: the scene's, of a line that of its first span.
        wind_speed
            Steady wind [m/s], of all spans or of each.
        """
        ice, towers = scene.ice, 2
        if isinstance(scene, LineScene):
            ice, towers = scene.ice_of_span(1), len(scene.section.spans) + 1
        if attack_angle is None:
            attack_angle = float(np.radians(ice.attack_angle_deg))
        return cls(0.0, wind_speed, attack_angle, np.zeros((towers, 3)))

    def packed(self, layout: InputLayout) -> CInputs:
        """The kernel's form of the inputs.

        Parameters
        ----------
        layout
            What can be set of the model.

        Raises
        ------
        TypeError, ValueError
            If a field is not made of finite numbers, or does not have its shape.
        """
        packed = CInputs(fields=layout.fields, junctions=layout.junctions)
        for name in ("time", "attack_angle", "attack_angle_rate"):
            setattr(packed, name, finite(f"inputs.{name}", getattr(self, name)))
        wind = self._with_rate("wind_speed", layout)
        motion = np.zeros((2, layout.junctions, 3))
        for row, name in enumerate(("support", "support_rate")):
            if name == "support" or self.support_rate is not None:
                shape = (len(layout.towers), 3)
                moves = numbers(f"inputs.{name}", getattr(self, name), shape)
                for move, junctions in zip(moves, layout.towers, strict=True):
                    motion[row, junctions] = move
        packed.wind, packed.motion = wind.ctypes.data_as(Pointer), motion.ctypes.data_as(Pointer)
        packed.arrays = wind, motion  # the pointers do not keep them
        if self.wind_direction is not None:
            direction = self._with_rate("wind_direction", layout)
            packed.direction = direction.ctypes.data_as(Pointer)
            packed.arrays += (direction,)
        return packed

    def _with_rate(self, name: str, layout: InputLayout) -> Array:
        """Values of the fields of wind, and their rates; shape (2, field)."""
        rows = np.empty((2, layout.fields))
        for row, one in enumerate((name, f"{name}_rate")):
            rows[row] = _of_spans(one, getattr(self, one), layout.fields)
        return rows


def _of_spans(name: str, value: ArrayLike, fields: int) -> Array | float:
    """One number, or one for each span."""
    if fields == 1 or np.ndim(value) == 0:
        return finite(f"inputs.{name}", value)
    return numbers(f"inputs.{name}", value, (fields,))


def inputs_pointer(inputs: Inputs | None, layout: InputLayout) -> Any:
    """Pointer to the kernel's form of the inputs; None: there are none.

    Raises
    ------
    TypeError, ValueError
        If the inputs are of another type, or a field cannot be used.
    """
    if inputs is None:
        return None
    if not isinstance(inputs, Inputs):
        raise TypeError(f"inputs must be Inputs or None, not {inputs!r:.60}")
    return c.byref(inputs.packed(layout))
