"""Columns of a sweep about ice that falls; only scenes with shedding have them."""

from __future__ import annotations

import numpy as np

from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.result import Result
from gallop_fmu.sweeps.rows import Row

SHEDDING_COLUMNS: dict[str, tuple[str, str]] = {
    "shed_time": ("s", "time at which ice fell first"),
    "highest_rise": (
        "m",
        "maximum rise of a part after its ice fell, from the equilibrium with all ice",
    ),
    "highest_rise_time": ("s", "time of the maximum rise"),
    "final_rise": (
        "m",
        "maximum rise of a part at rest in still air, with the ice left at the end of the run",
    ),
    "unbalanced_pull": (
        "N",
        "maximum force along the line on a suspension tower after ice fell",
    ),
}
"""Column to unit and meaning; rises are at the recorded nodes, of all parts the largest."""


def shedding_columns(result: Result | LineResult) -> Row:
    """Return the columns of a run; empty if nothing sheds in its scene."""
    if not result.scene.shedding:
        return {}
    table = result.sheddings
    row: Row = dict.fromkeys(SHEDDING_COLUMNS)
    fell = table[np.isfinite(table["time"])]
    if not len(fell):
        return row
    row["shed_time"] = float(fell["time"].min())
    for name in ("highest_rise", "final_rise", "unbalanced_pull"):
        if name in fell and fell[name].notna().any():
            row[name] = float(fell[name].max())
    if row["highest_rise"] is not None:
        row["highest_rise_time"] = float(fell["highest_rise_time"][fell["highest_rise"].idxmax()])
    return row
