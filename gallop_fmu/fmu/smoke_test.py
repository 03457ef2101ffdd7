"""A short run of an FMU with FMPy, which writes one line for each check into the file `FINDINGS`.

Each line is a JSON list: name of the check, the problem (empty if there is none), the text if it
is passed.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import quote

from gallop_fmu.fmu.reference import REFERENCE_FILE
from gallop_fmu.fmu.trial_instance import REALS, Instance, missing_functions, open_instance

STEPS = 20
"""Communication steps of the run."""

FINDINGS = "findings"
"""Name of the file with the findings; the output of an FMU does not go there."""

AddFinding = Callable[[str, str, str], None]
"""Called with the three items of a finding."""

DEFAULT_STEP = 0.01
"""Communication step [s] if the FMU gives none."""

UNPACKED = "with space \u00fc"
"""Folder of the unpacked FMU: libraries often find no resources under such names."""

MAX_REFERENCE = 500
"""Most rows of a reference result that are compared."""

ALLOWED_DIFFERENCE = 1e-6
"""Largest difference from the reference result, as a fraction of the largest range of outputs with
the same unit: an output that symmetry keeps at zero has only round-off. Round-off accumulates, on
other platforms more than on that of the export."""


def main(path: str, folder: str) -> None:
    """Run the FMU, unpacked into a folder, and write the findings there."""
    with Path(folder, FINDINGS).open("w", encoding="utf-8") as file:

        def add(name: str, problem: str, good: str) -> None:
            print(json.dumps([name, problem, good]), file=file, flush=True)

        _run(path, folder, add)


def _run(path: str, folder: str, add: AddFinding) -> None:
    from fmpy import extract, read_model_description

    description = read_model_description(path, validate=False)
    unpacked = str(Path(folder, UNPACKED))
    extract(path, unzipdir=unpacked)
    if (Path(unpacked) / "resources" / "slavemodule.txt").exists():
        unpacked = str(Path(unpacked).rename(Path(folder, "unpacked")))
        if not readable_by_pythonfmu(unpacked):
            add(
                "run",
                f"pythonfmu cannot read the temporary folder {unpacked!r}; set TMPDIR to a path in"
                " plain ASCII",
                "",
            )
            return
    messages: list[str] = []
    step = _step_size(description)
    try:
        fmu = open_instance(description, unpacked, messages)
        outputs = _Outputs(fmu, description)
        for k in range(STEPS):
            fmu.step(k * step, step)
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
        add("rollback", "the FMU offers no saved states", "")
    missing = missing_functions(fmu)
    add(
        "functions",
        f"{len(missing)} missing, such as {', '.join(missing[:3])}" if missing else "",
        f"all of FMI {description.fmiVersion} for co-simulation",
    )
    add("logging", fmu.logging_problem(), "takes the standard's categories")
    fmu.end()
    file = Path(unpacked, REFERENCE_FILE)
    if file.is_file():
        try:
            _check_reference(add, file, open_instance(description, unpacked, messages), description)
        except Exception as problem:
            add("reference", "; ".join([str(problem), *messages[-2:]]), "")


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


class _Outputs:
    """The numeric outputs of an FMU."""

    def __init__(self, fmu: Instance, description: Any) -> None:
        self.fmu = fmu
        self.variables = [
            variable
            for variable in description.modelVariables
            if variable.causality == "output" and variable.type in fmu.getters
        ]
        self.names = [variable.name for variable in self.variables]

    def read(self) -> dict[str, float]:
        return {variable.name: self.fmu.get(variable) for variable in self.variables}


def _check_rollback(
    add: AddFinding, fmu: Instance, outputs: _Outputs, step: float, serialises: bool
) -> None:
    """Make a step twice from one state, then once more from the serialised state."""
    now = STEPS * step
    state = fmu.save()
    fmu.step(now, step)
    first = outputs.read()
    fmu.restore(state)
    fmu.step(now, step)
    add("rollback", _difference(first, outputs.read()), "a repeated step gives the same bits")
    if serialises:
        again = fmu.copy(state)
        fmu.restore(again)
        fmu.step(now, step)
        add(
            "serialised state",
            _difference(first, outputs.read()),
            "a step from it gives the same bits",
        )
        fmu.free(again)
    fmu.free(state)


def _check_reference(add: AddFinding, file: Path, fmu: Instance, description: Any) -> None:
    """Repeat the run of the reference result, with the inputs at their start values."""
    with file.open(encoding="utf-8", newline="") as stream:
        names, *rows = list(csv.reader(stream))[: MAX_REFERENCE + 1]
    wanted = [[float(number) for number in row] for row in rows]
    known = {v.name: v for v in description.modelVariables if v.type in REALS}
    columns = [(at, known[name]) for at, name in enumerate(names) if at and name in known]
    found = _rows(fmu, [row[0] for row in wanted], [variable for _, variable in columns])
    ranges = _ranges(wanted, columns)
    shares = {
        variable.name: _share(
            [row[column] for row in found], [row[at] for row in wanted], ranges[variable.unit]
        )
        for column, (at, variable) in enumerate(columns)
    }
    place, worst = max(shares.items(), key=lambda item: item[1], default=("", 0.0))
    good = f"differs by {worst:.1e} at most" if worst else f"the same digits in {len(wanted)} rows"
    problem = f"{place} differs from {REFERENCE_FILE} by {worst:.1e} of the range of its unit"
    add("reference", "" if worst <= ALLOWED_DIFFERENCE else problem, good)


def _ranges(rows: list[list[float]], columns: list[tuple[int, Any]]) -> dict[str | None, float]:
    """Return the largest range of the columns of each unit."""
    ranges: dict[str | None, float] = {}
    for at, variable in columns:
        values = [row[at] for row in rows] or [0.0]
        size = (max(values) - min(values)) or max(map(abs, values))
        ranges[variable.unit] = max(ranges.get(variable.unit, 0.0), size)
    return ranges


def _rows(fmu: Instance, times: list[float], variables: list[Any]) -> list[list[float]]:
    """Return values of variables at some times, of which the first is that of the instance."""
    found = [[fmu.get(variable) for variable in variables]]
    for begin, end in pairwise(times):
        fmu.step(begin, end - begin)
        found.append([fmu.get(variable) for variable in variables])
    fmu.end()
    return found


def _share(found: list[float], wanted: list[float], size: float) -> float:
    """Return the largest difference as a fraction of a range; infinite if it is no number."""
    if not wanted:
        return 0.0
    difference = max(abs(a - b) for a, b in zip(found, wanted, strict=True))
    share = difference / (size or 1.0)
    return share if math.isfinite(share) else math.inf


def _difference(first: dict[str, float], second: dict[str, float]) -> str:
    different = [
        name for name, value in first.items() if float(value).hex() != float(second[name]).hex()
    ]
    return f"a repeated step differs in {', '.join(different)}" if different else ""
