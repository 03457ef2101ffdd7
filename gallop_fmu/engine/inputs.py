"""Inputs of a co-simulation host, which replace the laws of a scene."""

from __future__ import annotations

import ctypes as c
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.ctypes_structs import CInputs, Three
from gallop_fmu.foundation.argument_checks import finite, numbers
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(slots=True)
class Inputs:
    """Inputs of a co-simulation host, which replace the laws of the scene.

    From `time` on, each changes linearly in time.

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

    @classmethod
    def still(
        cls, scene: Scene | LineScene, attack_angle: float | None = None, wind_speed: float = 0.0
    ) -> Inputs:
        """Towers at rest, and no wind unless it is given; the ice at the scene's attack angle.

        Parameters
        ----------
        scene
            The scene.
        attack_angle
            Another attack angle [rad]; None: the scene's, of a line that of its first span.
        wind_speed
            Steady wind [m/s].
        """
        if attack_angle is None:
            ice = scene.ice_of_span(1) if isinstance(scene, LineScene) else scene.ice
            attack_angle = float(np.radians(ice.attack_angle_deg))
        return cls(0.0, wind_speed, attack_angle, np.zeros((2, 3)))

    def packed(self) -> CInputs:
        """The kernel's form of the inputs.

        Raises
        ------
        TypeError, ValueError
            If a field is not a finite number, or `support` or `support_rate` does not have the
            shape (2, 3).
        """
        packed = CInputs(*(finite(f"inputs.{name}", getattr(self, name)) for name in _INPUT_VALUES))
        for name in _INPUT_RATES:
            setattr(packed, name, finite(f"inputs.{name}", getattr(self, name)))
        for name in ("support", "support_rate"):
            if name == "support" or self.support_rate is not None:
                rows = numbers(f"inputs.{name}", getattr(self, name), (2, 3)).tolist()
                setattr(packed, name, _Towers(*(Three(*row) for row in rows)))
        return packed


_INPUT_VALUES, _INPUT_RATES = (
    ("time", "wind_speed", "attack_angle"),
    ("wind_speed_rate", "attack_angle_rate"),
)
_Towers = Three * 2


def inputs_pointer(inputs: Inputs | None) -> Any:
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
    return c.byref(inputs.packed())
