"""Print the table of docs/how-to/time_step.md: cost and energy drift of newton_tolerance.

Usage: python benchmarks/stress/newton_tolerance.py (about half a minute)
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from report import table

from support.conservation import MOTION, VERTICAL_HZ, energy, released

TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
STEPS = (0.01, 0.02)
SIZES = (0.5, 1.0, 1.5)
"""Of the loads that are removed: vertical amplitudes of 0.12, 0.26 and 0.44 m."""

PERIODS, EVERY = 1000, 10


def drift(tolerance: float, step: float, size: float) -> tuple[float, float]:
    """Relative change of the energy over `PERIODS` vertical periods; Newton iterations per step."""
    state = released({"numerics.newton_tolerance": tolerance, "numerics.time_step": step}, size)
    before, start = state.advance(state.time + step), float(energy(state.observe_span()))
    records = round(PERIODS / (VERTICAL_HZ * step * EVERY))
    run = state.run(records, EVERY, MOTION, np.array([state.model.middle], np.int32))
    error = energy(run.span_values) / start - 1.0
    tenth = records // 10
    change = float(error[-tenth:].mean() - error[:tenth].mean()) / 0.9
    return change, (run.report.iterations - before.iterations) / (run.report.steps - before.steps)


def main() -> None:
    rows = []
    for tolerance in TOLERANCES:
        row = [f"{tolerance:.0e}"]
        for step in STEPS:
            found = [drift(tolerance, step, size) for size in SIZES]
            row.append(f"{max(abs(change) for change, _ in found):.0e}")
            row.append(
                f"{min(count for _, count in found):.1f} to {max(count for _, count in found):.1f}"
            )
        rows.append(row)
    head = [
        "newton_tolerance [m]",
        *(f"{what} at {step:g} s" for step in STEPS for what in ("drift", "iterations")),
    ]
    print(table(head, rows))


if __name__ == "__main__":
    main()
