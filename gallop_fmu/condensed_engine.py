"""Condensed spans, computed by the compiled kernel: what `gallop_fmu.engine` is to the whole span."""

from __future__ import annotations

import ctypes as c
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine import Model
from gallop_fmu.library import kernel
from gallop_fmu.outcome import Outcome, Report, SimulationError
from gallop_fmu.structures import (
    CONDENSED_ARRAYS,
    CONDENSED_NUMBERS,
    CCondensed,
    CReport,
    double_pointer,
    unpacked,
)

Array = NDArray[np.float64]

CONDENSED_MODES, CONDENSED_SECTIONS = 16, 8
"""Modes of a condensed span, and sections along it."""


class CondensedModel:
    """The kernel's form of a condensed span, see `gallop_fmu.condensed`.

    Parameters
    ----------
    model
        The model whose coefficient curve, ice and laws are taken.
    values
        Numbers and arrays of ``gallop_condensed`` in ``gallop.h``, by name.
    """

    def __init__(self, model: Model, values: Mapping[str, float | Array]) -> None:
        self.model = model
        self._arrays = {name: np.ascontiguousarray(values[name]) for name in CONDENSED_ARRAYS}
        self._packed = CCondensed(len(self._arrays["load"]), 0, *(float(values[name]) for name in CONDENSED_NUMBERS))
        for name, array in self._arrays.items():
            setattr(self._packed, name, double_pointer(array))

    def forces(self, q: Array, v: Array, time: float = 0.0) -> tuple[Array, Array]:
        """Modal forces (mode,) beyond the linear ones, and accelerations (mode,)."""
        motion = [np.ascontiguousarray(y, dtype=np.float64) for y in (q, v)]
        a, f = np.zeros(CONDENSED_MODES), np.empty(CONDENSED_MODES)
        pointers = [double_pointer(y) for y in (*motion, a, f)]
        outcome = kernel.gallop_condensed_forces(self.model.handle, c.byref(self._packed), time, *pointers)
        if outcome:
            raise SimulationError(Report(Outcome.from_code(outcome), time))
        return f, a

    def run(
        self, q: Array, v: Array, first: int, steps: int, every: int, within: int, before: Report
    ) -> tuple[Array, Array, Report]:
        """Advance `q` and `v` by `steps` steps from step `first`: histories (record, 2, mode), (record,), and report.

        The second is the horizontal tension [N].

        Recorded is the end of each `every`-th step, or `within` instants of each step. `before` is the report so far.
        """
        count = steps // every * within
        history, tension = np.empty((count, 2, CONDENSED_MODES)), np.empty(count)
        records, raw = c.c_int64(), CReport(element=-1, lowest_tension=before.lowest_tension, steps=before.steps)
        kernel.gallop_condensed_run(
            self.model.handle, c.byref(self._packed), double_pointer(q), double_pointer(v), first, steps, every, within,
            double_pointer(history), double_pointer(tension), c.byref(records), c.byref(raw),
        )  # fmt: skip
        return history[: records.value], tension[: records.value], replace(unpacked(raw), substeps=raw.steps)
