"""An instance of an FMU of FMI 2.0 or 3.0 in FMPy, with the same functions for both."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any, Protocol

REALS = ("Real", "Float64", "Float32")
"""Types of real numbers."""

MODEL_EXCHANGE = re.compile(
    r"fmi2(EnterEventMode|NewDiscreteStates|EnterContinuousTimeMode|CompletedIntegratorStep|SetTime"
    r"|SetContinuousStates|GetDerivatives|GetEventIndicators|GetContinuousStates"
    r"|GetNominalsOfContinuousStates)"
)
"""Functions that an FMU of FMI 2.0 for co-simulation may lack; one of FMI 3.0 needs all."""


class Instance(Protocol):
    """What a trial needs of an instance."""

    fmu: Any
    getters: dict[str, Any]
    version: int

    def step(self, time: float, size: float) -> None:
        """Make a communication step."""

    def get(self, variable: Any) -> float:
        """Return the value of a variable."""

    def save(self) -> Any:
        """Return a saved state."""

    def restore(self, state: Any) -> None:
        """Return to a saved state."""

    def copy(self, state: Any) -> Any:
        """Return a saved state that was serialised and read again."""

    def free(self, state: Any) -> None:
        """Free a saved state."""

    def logging_problem(self) -> str:
        """Return the problem with the standard's log categories; empty: none."""

    def end(self) -> None:
        """Terminate and free the instance."""


def open_instance(description: Any, folder: str, messages: list[str]) -> Instance:
    """Return an instance that is ready to step; what it logs is appended to `messages`."""
    kind = _Instance2 if description.fmiVersion == "2.0" else _Instance3
    return kind(description, folder, messages)


def missing_functions(instance: Instance) -> list[str]:
    """Return the functions of the standard that a library lacks."""
    spec = importlib.util.find_spec("fmpy")
    assert spec is not None
    assert spec.origin is not None
    prefix = f"fmi{instance.version}"
    header = Path(spec.origin).parent / "c-code" / f"{prefix}FunctionTypes.h"
    names = sorted(set(re.findall(rf"\b({prefix}[A-Z]\w+)TYPE\b", header.read_text())))
    return [
        name
        for name in names
        if not hasattr(instance.fmu.dll, name) and not MODEL_EXCHANGE.fullmatch(name)
    ]


class _Instance2:
    version = 2

    def __init__(self, description: Any, folder: str, messages: list[str]) -> None:
        from fmpy.fmi2 import (
            FMU2Slave,
            defaultCallbacks,
            fmi2CallbackFunctions,
            fmi2CallbackLoggerTYPE,
        )

        def keep(
            _environment: Any, _name: bytes, _status: int, _category: bytes, message: bytes
        ) -> None:
            messages.append(message.decode(errors="replace"))

        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="trial",
        )
        self.getters = {"Real": self.fmu.getReal} | dict.fromkeys(
            ("Integer", "Enumeration"), self.fmu.getInteger
        )
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(keep)
        callbacks.allocateMemory = defaultCallbacks.allocateMemory
        callbacks.freeMemory = defaultCallbacks.freeMemory
        self.kept = callbacks  # the FMU has a pointer to them
        self.fmu.instantiate(callbacks=callbacks, loggingOn=True)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, time: float, size: float) -> None:
        self.fmu.doStep(time, size)

    def get(self, variable: Any) -> float:
        return float(self.getters[variable.type]([variable.valueReference])[0])

    def save(self) -> Any:
        return self.fmu.getFMUstate()

    def restore(self, state: Any) -> None:
        self.fmu.setFMUstate(state)

    def copy(self, state: Any) -> Any:
        return self.fmu.deSerializeFMUstate(self.fmu.serializeFMUstate(state))

    def free(self, state: Any) -> None:
        self.fmu.freeFMUstate(state)

    def logging_problem(self) -> str:
        try:
            self.fmu.setDebugLogging(True, ["logStatusError", "logStatusFatal", "logAll"])
        except Exception as problem:
            return f"refuses the categories of FMI 2.0 ({problem})"
        return ""

    def end(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


class _Instance3:
    version = 3

    def __init__(self, description: Any, folder: str, messages: list[str]) -> None:
        from fmpy.fmi3 import FMU3Slave

        self.fmu = FMU3Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="trial",
        )
        self.getters = {
            "Float64": self.fmu.getFloat64,
            "Float32": self.fmu.getFloat32,
            "Int32": self.fmu.getInt32,
            "Int64": self.fmu.getInt64,
            "Enumeration": self.fmu.getInt64,
        }

        def keep(*arguments: Any) -> None:
            messages.append(arguments[-1].decode(errors="replace"))

        self.fmu.instantiate(loggingOn=True, logMessage=keep)
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()

    def step(self, time: float, size: float) -> None:
        self.fmu.doStep(time, size)

    def get(self, variable: Any) -> float:
        return float(self.getters[variable.type]([variable.valueReference])[0])

    def save(self) -> Any:
        return self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        self.fmu.setFMUState(state)

    def copy(self, state: Any) -> Any:
        return self.fmu.deserializeFMUState(self.fmu.serializeFMUState(state))

    def free(self, state: Any) -> None:
        self.fmu.freeFMUState(state)

    def logging_problem(self) -> str:
        """FMI 3.0 has no categories of its own."""
        return ""

    def end(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
