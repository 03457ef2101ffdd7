"""The motion of a span as a system y' = f(y, p) with one number of its scene as the parameter.

The state y = (q, v) has the coordinates of `modal.motions.span_model` and their velocities.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene
from modal.continuation.events import UserEvent
from modal.continuation.problem import Rates
from modal.foundation.scene_variation import varied
from modal.motions.motion_models import similar_model
from modal.motions.span_model import SpanModel

Array = NDArray[np.float64]

WIND_SPEED = "wind.speed"
"""The number whose derivatives are exact, and for which one reduced model holds."""

DIFFERENCE = 1e-4
"""Step of the difference by another number, relative to the range."""

KEPT_MODELS = 12
"""Number of reduced models that are kept for further evaluations."""

TYPICAL_ROTATION = 0.15
"""Typical part of the wind speed that the conductor's velocity has when it gallops."""

TYPICAL_TWIST = 0.3
"""Typical twist [rad]."""

LEAVES_CURVE = "leaves the curve"
"""Kind of the event at which the attack angle reaches the end of the coefficient curve."""


class Family(Protocol):
    """Reduced models over the parameter."""

    def at(self, parameter: float) -> tuple[SpanModel, float]:
        """Model and wind speed [m/s] at a value of the parameter."""

    def by_parameter(self, q: Array, v: Array, parameter: float, by_wind: Array) -> Array:
        """Derivative of the accelerations (instant, mode) by the parameter."""


class WindFamily:
    """One model in any wind."""

    def __init__(self, model: SpanModel) -> None:
        self.model = model

    def at(self, parameter: float) -> tuple[SpanModel, float]:
        """Return the model, and the parameter as its wind speed."""
        return self.model, parameter

    def by_parameter(self, q: Array, v: Array, parameter: float, by_wind: Array) -> Array:
        """Return the derivative by the wind speed."""
        return by_wind


class NumberFamily:
    """A model for each value of a number of the scene, in the scene's wind.

    Parameters
    ----------
    scene
        The span.
    path
        Name of the number, as in `Scene.with_values`.
    model
        Reduced model of the scene, whose coordinates the others have.
    step
        Step of the difference.
    """

    def __init__(self, scene: Scene | LineScene, path: str, model: SpanModel, step: float) -> None:
        self.scene, self.path, self.model, self.step = scene, path, model, step
        self._known: OrderedDict[float, SpanModel] = OrderedDict()

    def at(self, parameter: float) -> tuple[SpanModel, float]:
        """Model and wind speed [m/s] at a value of the number.

        Raises
        ------
        SceneError, SimulationError
            If the value is not allowed, or the span has no equilibrium.
        """
        if parameter not in self._known:
            scene = varied(self.scene, self.path, parameter)
            self._known[parameter] = similar_model(scene, self.model)
            if len(self._known) > KEPT_MODELS:
                self._known.popitem(last=False)
        return self._known[parameter], self.scene.wind.mean_speed

    def by_parameter(self, q: Array, v: Array, parameter: float, by_wind: Array) -> Array:
        """Central difference of the accelerations."""
        sides = []
        for side in (self.step, -self.step):
            model, wind = self.at(parameter + side)
            sides.append(model.motion(q, v, wind).acceleration)
        return np.asarray((sides[0] - sides[1]) / (2.0 * self.step))


class SpanProblem:
    """The span as a `modal.continuation.problem.Problem`.

    Parameters
    ----------
    family
        Reduced models over the parameter.
    model
        One of them, for typical sizes and for the symmetry.
    wind
        A typical wind speed [m/s].

    Attributes
    ----------
    size, scale, symmetry, is_second_order
        As in `modal.continuation.problem.Problem`. The typical displacement is that of a conductor
        that moves at `TYPICAL_ROTATION` of the wind speed at the first vertical frequency.
    """

    is_second_order = True

    def __init__(self, family: Family, model: SpanModel, wind: float) -> None:
        self.family, self.model = family, model
        self.modes = model.size
        frequency = model.frequencies[0]
        largest = np.max(np.abs(model.shapes), axis=1)  # of each mode: u1, u2, u3, theta
        moves = np.max(largest[:, :3], axis=1) / (TYPICAL_ROTATION * wind / frequency)
        typical = 1.0 / np.maximum(moves, largest[:, 3] / TYPICAL_TWIST)
        self.scale: Array = np.concatenate([typical, frequency * typical])
        mirror = model.symmetry
        self.symmetry: Array | None = None
        if mirror is not None:
            self.symmetry = np.asarray(np.kron(np.eye(2), mirror))

    @property
    def size(self) -> int:
        """Number of equations."""
        return 2 * self.modes

    def rates(self, states: Array, parameter: float) -> Rates:
        """Evaluate f and its derivatives at states (state, 2 mode)."""
        n = self.modes
        q, v = states[:, :n], states[:, n:]
        model, wind = self.family.at(parameter)
        motion = model.motion(q, v, wind)
        by_state = np.zeros((len(states), 2 * n, 2 * n))
        by_state[:, :n, n:] = np.eye(n)
        by_state[:, n:, :n], by_state[:, n:, n:] = motion.by_displacement, motion.by_velocity
        by_parameter = np.zeros_like(states)
        by_parameter[:, n:] = self.family.by_parameter(q, v, parameter, motion.by_wind)
        return Rates(np.hstack([v, motion.acceleration]), by_state, by_parameter)

    def defect(self, states: Array, slopes: Array, parameter: float) -> Array | None:
        """Approximate f(y, p) - y' with the mass at rest; None over another number than the wind.

        Then, each value of the number needs a reduced model.
        """
        if not isinstance(self.family, WindFamily):
            return None
        n, model = self.modes, self.model
        force = model.residual(states[:, :n], states[:, n:], slopes[:, n:], parameter)
        return np.hstack([states[:, n:] - slopes[:, :n], -np.linalg.solve(model.mass, force.T).T])

    def end_of_curve(self) -> list[UserEvent]:
        """Event at which the attack angle leaves the coefficient curve; none if it cannot."""
        curve = self.model.scene.aerodynamics
        assert curve is not None  # a reduced model has a curve
        if curve.beyond != "error":
            return []
        first, last = np.radians(curve.range_deg)
        middle, half = 0.5 * (first + last), 0.5 * (last - first)

        def margin(states: Array, parameter: float) -> float:
            model, wind = self.family.at(parameter)
            angle = model.attack_angle(states[:, : self.modes], states[:, self.modes :], wind)
            turns = np.round((angle - middle) / (2.0 * np.pi))
            return float(half - np.max(np.abs(angle - middle - 2.0 * np.pi * turns)))

        return [UserEvent(LEAVES_CURVE, margin)]
