"""What an FMU of a span does, whatever tool runs it: phases, values in and out, steps, saved states.

A session raises `RefusedError` for a value or call that is not allowed, and `SimulationError` for a
step that cannot be carried out; in both cases it stays as it was.
"""

from __future__ import annotations

import math
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.model import Inputs, Model, State
from gallop_fmu.fmu.variables import SUPPORT_INPUTS, Origin, Variable, fmu_variables
from gallop_fmu.foundation.argument_checks import finite, numbers, whole
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.scene.scene import Scene

INT32 = (-(2**31), 2**31 - 1)
"""Range of FMI's Integer."""

SAVED_PARTS = {
    "content",
    "phase",
    "status",
    "start_time",
    "inputs",
    "parameters",
    "refused",
    "tower",
    "motion",
}
"""What `Session.save` gives."""

TIME_TOLERANCE = 1e-6
"""Difference between the host's time and the session's that is put down to round-off, as a fraction of the step."""


class RefusedError(ValueError):
    """A value or a call that FMI or the scene does not allow; the message says what would be."""


class Phase(Enum):
    """Where a session stands in FMI's order of calls."""

    INSTANTIATED = "instantiated"
    INITIALISING = "initialising"
    STEPPING = "stepping"
    TERMINATED = "terminated"


class Session:
    """One instance of a span in co-simulation.

    Parameters
    ----------
    scene
        The exported scene.
    content
        Identity of the FMU, which a saved state must share.
    """

    def __init__(self, scene: Scene, content: str = "") -> None:
        self.scene = scene
        self.content = content
        self.variables = fmu_variables(scene)
        self.phase = Phase.INSTANTIATED
        self.status = Outcome.COMPLETED
        self._start_time = 0.0
        self._by_name = {variable.name: variable for variable in self.variables}
        self._inputs = {
            v.name: float(v.start or 0.0) for v in self.variables if v.origin is Origin.INPUT
        }
        self._parameters: dict[str, float | int] = {}
        self._refused: dict[str, str] = {}
        self._tower = np.zeros((2, 3))
        self._model: Model | None = None
        self._state: State | None = None
        self._no_start: RefusedError | SimulationError | None = None
        self._observed: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

    def set_up(self, start_time: float) -> None:
        """Take the start time [s]."""
        if self.phase is not Phase.INSTANTIATED:
            raise RefusedError(f"the start time cannot be set while {self.phase.value}")
        if not math.isfinite(start_time):
            raise self._refuse(
                "the start time", f"the start time {start_time} is not a finite number"
            )
        self._refused.pop("the start time", None)
        self._start_time = start_time
        self._state = self._no_start = None

    def enter_initialisation(self) -> None:
        """Begin to initialise: outputs follow inputs and parameters from now on."""
        if self.phase is not Phase.INSTANTIATED:
            raise RefusedError(f"initialisation cannot begin while {self.phase.value}; reset first")
        self.phase = Phase.INITIALISING

    def leave_initialisation(self) -> None:
        """End it: parameters are fixed, and steps may follow."""
        if self.phase is not Phase.INITIALISING:
            raise RefusedError(f"initialisation cannot end while {self.phase.value}")
        self.phase = Phase.STEPPING
        self.start()

    def terminate(self) -> None:
        """No step may follow."""
        self.phase = Phase.TERMINATED

    def start(self) -> None:
        """Solve for the initial state, unless it is already that of the present inputs and parameters.

        Raises
        ------
        RefusedError
            The parameters do not fit together.
        SimulationError
            There is no equilibrium.
        """
        if self._no_start is not None:
            raise self._no_start
        if self._state is not None:
            return
        try:
            model = self._model or self._build(self._parameters)
            tower = self._tower_targets()
            at_rest = Inputs(
                self._start_time, self._inputs["wind_speed"], self._inputs["attack_angle"], tower
            )
            state = model.start(self._start_time, at_rest)
        except (RefusedError, SimulationError) as error:
            self.status = (
                error.report.outcome
                if isinstance(error, SimulationError)
                else Outcome.INVALID_SCENE
            )
            self._no_start = error
            raise
        self._model, self._state, self._tower, self._observed = model, state, tower, None
        self.status = Outcome.COMPLETED

    def refresh(self) -> None:
        """Let the outputs follow inputs and parameters, as FMI demands until initialisation has ended; as `start`."""
        if self.phase in (Phase.INSTANTIATED, Phase.INITIALISING):
            self.start()

    def _build(self, parameters: dict[str, float | int]) -> Model:
        if not parameters:
            return Model(self.scene)
        try:
            return Model(self.scene.with_values(parameters))
        except SceneError as error:
            raise RefusedError(f"the parameters cannot be used: {error}") from None

    def get(self, variable: Variable) -> float | int:
        """Present value; NaN, or 0 for an Integer, where there is no equilibrium to read it from."""
        match variable.origin:
            case Origin.INPUT:
                return self._inputs[variable.key]
            case Origin.PARAMETER:
                return self._parameter(variable)
            case Origin.STATUS:
                return Outcome.BAD_CALL.code if self._refused else self.status.code
        if self._state is None:
            return math.nan if variable.type == "Real" else 0
        if self._observed is None:
            self._observed = (
                self._state.observe_node(self._state.model.middle),
                self._state.observe_span(),
            )
        node, span = self._observed
        if variable.origin is Origin.MIDSPAN:
            return float(node[NODE_INDEX[variable.key]])
        value = span[SPAN_INDEX[variable.key]]
        return float(value) if variable.type == "Real" else int(value)

    def set(self, variable: Variable, value: float | int) -> None:
        """Take a value from the host.

        Raises
        ------
        RefusedError
            An output, a parameter after initialisation, a value that is not finite or out of range.
            The value is kept out, and steps fail until the variable is given one that is allowed.
        """
        reason = self._why_not(variable, value)
        if reason:
            raise self._refuse(variable.name, f"{variable.name} = {value!r} is refused: {reason}")
        self._refused.pop(variable.name, None)
        if variable.origin is Origin.INPUT:
            changed = self._inputs[variable.key] != value
            self._inputs[variable.key] = float(value)
        else:
            changed = self._parameter(variable) != value
            if changed:
                self._parameters[variable.key] = float(value) if variable.type == "Real" else value
                self._model = None
        if changed and self.phase in (Phase.INSTANTIATED, Phase.INITIALISING):
            self._state = self._no_start = None

    def refuse_reference(self, reference: int, kind: str) -> RefusedError:
        """The error for a value reference that no variable of this type has; steps fail from now on."""
        return self._refuse(
            f"#{reference}", f"there is no {kind} variable with value reference {reference}"
        )

    def refuse_state(self, reason: str) -> RefusedError:
        """The error for a saved state that cannot be used; steps fail until one that can is restored."""
        return self._refuse("the saved state", f"the saved state is refused: {reason}")

    def _parameter(self, variable: Variable) -> float | int:
        start = variable.start if variable.start is not None else 0
        return self._parameters.get(variable.key, start)

    def _why_not(self, variable: Variable, value: float | int) -> str:
        if variable.causality == "output":
            return "it is an output"
        if not math.isfinite(value):
            return "it is not a finite number"
        if not variable.allows(value):
            calm = variable.name == "wind_speed" and self.scene.aerodynamics is None
            cause = "; the scene has no aerodynamic curve" if calm else ""
            return f"it must be {variable.allowed} [{variable.unit or 1}]{cause}"
        fixed = (
            self.phase in (Phase.STEPPING, Phase.TERMINATED) and variable.origin is Origin.PARAMETER
        )
        if fixed and value != self._parameter(variable):
            return (
                f"the parameter stays {self._parameter(variable)!r} after initialisation; reset the"
                " FMU to change it"
            )
        return ""

    def _refuse(self, what: str, message: str) -> RefusedError:
        self._refused[what] = message
        return RefusedError(message)

    def _tower_targets(self) -> NDArray[np.float64]:
        return np.array([self._inputs[name] for name in SUPPORT_INPUTS]).reshape(2, 3)

    def step(self, time: float, size: float) -> None:
        """Advance from `time` by `size` [s], in equal steps no longer than the scene's time step.

        Raises
        ------
        RefusedError
            Wrong time, no positive step, values refused before, or not initialised.
        SimulationError
            The step cannot be carried out.
        """
        try:
            state = self._ready(time, size)
            until, tower = time + size, self._tower_targets()
            rate = (tower - self._tower) / (until - state.time)
            wind, attack = self._inputs["wind_speed"], self._inputs["attack_angle"]
            state.advance(until, Inputs(until, wind, attack, tower, support_rate=rate))
        except SimulationError as error:
            self.status = error.report.outcome
            raise
        except RefusedError:
            self.status = Outcome.BAD_CALL
            raise
        self._tower, self._observed = tower, None
        self.status = Outcome.COMPLETED

    def _ready(self, time: float, size: float) -> State:
        if self.phase is not Phase.STEPPING:
            raise RefusedError(f"no step can be made while {self.phase.value}")
        if self._refused:
            raise RefusedError(
                "no step is made while there are refused values:"
                f" {'; '.join(self._refused.values())}"
            )
        self.start()  # fails again, and says why, where no initial state was found
        state = self._state
        assert state is not None
        if not (math.isfinite(size) and size > 0.0):
            raise RefusedError(
                f"the communication step {size!r} s is refused: it must be a positive number"
            )
        if not abs(time - state.time) <= TIME_TOLERANCE * size + 4.0 * math.ulp(state.time):
            raise RefusedError(
                f"a step from {time!r} s is refused: the FMU stands at {state.time!r} s"
            )
        if not time + size > state.time:
            raise RefusedError(
                f"the communication step {size!r} s is refused: it is lost in round-off at"
                f" {time!r} s"
            )
        return state

    def save(self) -> dict[str, Any]:
        """Everything the future depends on, as plain data."""
        return {
            "content": self.content,
            "phase": self.phase.value,
            "status": self.status.code,
            "start_time": self._start_time,
            "inputs": dict(self._inputs),
            "parameters": dict(self._parameters),
            "refused": dict(self._refused),
            "tower": self._tower.tolist(),
            "motion": b"" if self._state is None else self._state.save(),
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Return to what `save` gave, bit for bit.

        Raises
        ------
        RefusedError
            The data are of another FMU, or cannot be those of a session; it stays as it was.
        """
        if saved.get("content") != self.content:
            raise self.refuse_state("it belongs to another FMU")
        try:
            found = self._checked(saved)
            model, state = self._model, None
            if saved["motion"]:
                if model is None or found["parameters"] != self._parameters:
                    model = self._build(found["parameters"])
                state = State(model)
                state.restore(saved["motion"])
            elif found["parameters"] != self._parameters:
                model = None
        except (AttributeError, KeyError, TypeError, ValueError) as problem:
            raise self.refuse_state(f"it is damaged: {problem}") from None
        self._model, self._state, self._observed, self._no_start = model, state, None, None
        self.phase, self.status = Phase(saved["phase"]), Outcome.from_code(saved["status"])
        self._start_time, self._tower = found["start_time"], found["tower"]
        self._inputs, self._parameters = found["inputs"], found["parameters"]
        self._refused = dict(saved["refused"])

    def _checked(self, saved: dict[str, Any]) -> dict[str, Any]:
        """Values of a saved session; an error where one is missing or impossible."""
        if set(saved) != SAVED_PARTS:
            raise ValueError(f"it has the parts {', '.join(sorted(map(str, saved)))}")
        Phase(saved["phase"])
        Outcome.from_code(saved["status"])
        known = {(v.origin, v.key): v for v in self.variables}
        found: dict[str, Any] = {
            "start_time": finite("start_time", saved["start_time"]),
            "tower": numbers("tower", saved["tower"], (2, 3)),
        }
        if set(saved["inputs"]) != set(self._inputs):
            raise ValueError("its inputs are not those of this FMU")
        for part, origin in (("inputs", Origin.INPUT), ("parameters", Origin.PARAMETER)):
            found[part] = {}
            for key, value in saved[part].items():
                variable = known[origin, key]
                if not variable.allows(finite(key, value)):
                    raise ValueError(f"{key} = {value!r} is not {variable.allowed}")
                found[part][key] = (
                    whole(key, value, *INT32) if variable.type == "Integer" else float(value)
                )
        if not all(isinstance(text, str) for pair in saved["refused"].items() for text in pair):
            raise ValueError("its reasons of refusal are no texts")
        return found
