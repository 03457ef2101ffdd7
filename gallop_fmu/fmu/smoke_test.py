"""A short run of an FMU with FMPy, which writes one line for each check into the file `FINDINGS`.

Each line is a JSON list: name of the check, the problem (empty if there is none), the text if it
is passed.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import quote

STEPS = 20
"""Communication steps of the run."""

FINDINGS = "findings"
"""Name of the file with the findings; the output of an FMU does not go there."""

AddFinding = Callable[[str, str, str], None]
"""Called with the three items of a finding."""

DEFAULT_STEP = 0.01
"""Communication step [s] if the FMU gives none."""


def main(path: str, folder: str) -> None:
    """Run the FMU, unpacked into a folder, and write the findings there."""
    with Path(folder, FINDINGS).open("w", encoding="utf-8") as file:

        def add(name: str, problem: str, good: str) -> None:
            print(json.dumps([name, problem, good]), file=file, flush=True)

        _run(path, str(Path(folder, "unpacked")), add)


def _run(path: str, folder: str, add: AddFinding) -> None:
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    description = read_model_description(path, validate=False)
    extract(path, unzipdir=folder)
    if (Path(folder) / "resources" / "slavemodule.txt").exists() and not readable_by_pythonfmu(
        folder
    ):
        add(
            "run",
            f"pythonfmu cannot read the temporary folder {folder!r}; set TMPDIR to a path in plain"
            " ASCII",
            "",
        )
        return
    messages: list[str] = []
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="trial",
    )
    step = _step_size(description)
    try:
        _initialise(fmu, description, messages)
        outputs = _Outputs(fmu, description)
        for k in range(STEPS):
            fmu.doStep(k * step, step)
    except Exception as problem:
        add("run", "; ".join([str(problem), *messages[-2:]]), "")
        return
    add("run", "", f"{STEPS} steps of {step:g} s")
    infinite = [name for name, value in outputs.read().items() if not math.isfinite(value)]
    add(
        "finite",
        f"not finite: {', '.join(infinite)}" if infinite else "",
        f"all {len(outputs.names)} outputs",
    )
    if description.coSimulation.canGetAndSetFMUstate:
        _check_rollback(add, fmu, outputs, step, description.coSimulation.canSerializeFMUstate)
    else:
        add("rollback", "the FMU offers no fmi2GetFMUstate", "")
    fmu.terminate()
    fmu.freeInstance()


def readable_by_pythonfmu(folder: str) -> bool:
    """Return True if pythonfmu 0.7 finds a folder by its URI: it decodes only %20."""
    plain = folder.replace(" ", "").replace("\\", "/")
    return quote(plain, safe="/:~") == plain


def _step_size(description: Any) -> float:
    experiment = description.defaultExperiment
    return (
        float(experiment.stepSize)
        if experiment is not None and experiment.stepSize
        else DEFAULT_STEP
    )


def _initialise(fmu: Any, description: Any, messages: list[str]) -> None:
    from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

    def keep(
        _environment: Any, _name: bytes, _status: int, _category: bytes, message: bytes
    ) -> None:
        messages.append(message.decode(errors="replace"))

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(keep)
    callbacks.allocateMemory = defaultCallbacks.allocateMemory
    callbacks.freeMemory = defaultCallbacks.freeMemory
    fmu.instantiate(callbacks=callbacks, loggingOn=True)
    fmu.kept_callbacks = callbacks  # the FMU has a pointer to them
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()


class _Outputs:
    """The numeric outputs of an FMU."""

    def __init__(self, fmu: Any, description: Any) -> None:
        outputs = [
            variable for variable in description.modelVariables if variable.causality == "output"
        ]
        self.fmu = fmu
        self.reals = [variable for variable in outputs if variable.type == "Real"]
        self.integers = [variable for variable in outputs if variable.type == "Integer"]
        self.names = [variable.name for variable in self.reals + self.integers]

    def read(self) -> dict[str, float]:
        values = (
            self.fmu.getReal([variable.valueReference for variable in self.reals])
            if self.reals
            else []
        )
        values += (
            self.fmu.getInteger([variable.valueReference for variable in self.integers])
            if self.integers
            else []
        )
        return dict(zip(self.names, values, strict=True))


def _check_rollback(
    add: AddFinding, fmu: Any, outputs: _Outputs, step: float, serialises: bool
) -> None:
    """Make a step twice from one state, then once more from the serialised state."""
    now = STEPS * step
    state = fmu.getFMUstate()
    fmu.doStep(now, step)
    first = outputs.read()
    fmu.setFMUstate(state)
    fmu.doStep(now, step)
    add("rollback", _difference(first, outputs.read()), "a repeated step gives the same bits")
    if serialises:
        again = fmu.deSerializeFMUstate(fmu.serializeFMUstate(state))
        fmu.setFMUstate(again)
        fmu.doStep(now, step)
        add(
            "serialised state",
            _difference(first, outputs.read()),
            "a step from it gives the same bits",
        )
        fmu.freeFMUstate(again)
    fmu.freeFMUstate(state)


def _difference(first: dict[str, float], second: dict[str, float]) -> str:
    different = [
        name for name, value in first.items() if float(value).hex() != float(second[name]).hex()
    ]
    return f"a repeated step differs in {', '.join(different)}" if different else ""
