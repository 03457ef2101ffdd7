"""The reference result of an FMU: its outputs with the inputs at their start values, as CSV.

A host runs the FMU with the same communication steps and compares. On the same platform the digits
are the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gallop_fmu.fmu.cosim import Cosim, CosimError
from gallop_fmu.fmu.variable import Variable
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

REFERENCE_FILE = "documentation/reference_result.csv"
"""Its name in the FMU."""

DURATION = 20.0
"""Longest duration [s] of the reference result."""

INTERVAL = 0.1
"""Communication step [s], rounded to whole time steps."""


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference result.

    Attributes
    ----------
    step
        Communication step [s]; row k is at k times this.
    names
        Names of the Real outputs.
    rows
        Their values at the start and after every step.
    problem
        Why the run ended early; empty if it did not.
    """

    step: float
    names: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]
    problem: str = ""

    def column(self, name: str) -> list[float]:
        """Return the values of an output."""
        at = self.names.index(name)
        return [row[at] for row in self.rows]

    def csv(self) -> bytes:
        """Return the file: a line of names, then the values, with all digits."""
        lines = [",".join(("time", *self.names))]
        lines += [",".join(map(repr, (k * self.step, *row))) for k, row in enumerate(self.rows)]
        return "\n".join([*lines, ""]).encode()


def reference_result(
    scene: Scene | LineScene, resource: bytes, guid: str, variables: Sequence[Variable]
) -> Reference:
    """Run an FMU from its resource file for `DURATION`, or the scene's stop time if it is less.

    Parameters
    ----------
    scene
        The scene.
    resource, guid
        Content of ``resources/model.bin`` and its GUID.
    variables
        The table of variables.
    """
    outputs = [v for v in variables if v.causality == "output" and v.type == "Real"]
    references = [v.reference for v in outputs]
    time_step = scene.numerics.time_step
    step = max(round(INTERVAL / time_step), 1) * time_step
    count = max(int(min(DURATION, scene.run.stop_time) / step + 1e-9), 1)
    rows, problem = [], ""
    try:
        cosim = Cosim(resource, guid)
        cosim.set_up(0.0, None)
        cosim.enter_initialization()
        cosim.exit_initialization()
        rows.append(tuple(cosim.get("real", references)))
        for k in range(count):
            cosim.step(k * step, step)
            rows.append(tuple(cosim.get("real", references)))
    except CosimError as failure:
        problem = str(failure)
    return Reference(step, tuple(v.name for v in outputs), tuple(rows), problem)
