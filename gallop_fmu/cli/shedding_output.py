"""Text about ice that fell in the run of a span or line."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from gallop_fmu.cli.terminal import new_table

KILO = 1e-3


def print_sheddings(console: Console, rows: Sequence[Mapping[str, Any]]) -> None:
    """Print when and where ice fell, and how far the conductor jumped.

    Parameters
    ----------
    console
        Where to print.
    rows
        Of `gallop_fmu.simulation.shedding.sheddings`; of the subconductors of a bundle that lose
        their ice together, the one with the highest rise is printed.
    """
    if not rows:
        return
    has_pull = any("unbalanced_pull" in row for row in rows)
    has_clearance = any("smallest_clearance" in row for row in rows)
    table = new_table(
        *("ice", "span", "part", "fell at [s]", "rise [m]", "at [s]", "final [m]"),
        *(("pull [kN]", "final [kN]") if has_pull else ()),
        *(("clearance [m]",) if has_clearance else ()),
    )
    for row in _highest(rows):
        fell = math.isfinite(row["time"])
        phase = f", phase {row['phase']}" if any(r["phase"] > 1 for r in rows) else ""
        cells = [f"{row['shedding']}", f"{row['span']}{phase}"]
        cells.append(f"{row['from_station']:g}-{row['to_station']:g}")
        cells.append(f"{row['time']:.4g}" if fell else "not")
        names = [("highest_rise", 1.0), ("highest_rise_time", 1.0), ("final_rise", 1.0)]
        if has_pull:
            names += [("unbalanced_pull", KILO), ("final_unbalanced_pull", KILO)]
        if has_clearance:
            names.append(("smallest_clearance", 1.0))
        cells += [_text(row.get(name, math.nan) * factor) for name, factor in names]
        table.add_row(*cells)
    console.print(table)
    what = "rise: highest at the recorded nodes, from the equilibrium with all ice in still air"
    if has_pull:
        what += "; pull: largest along the line on a suspension tower"
    console.print(f"{what}; final: at rest in still air with the ice that is left", style="dim")


def _highest(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Rows without the subconductors that lose the same part at the same time and rise less."""
    best: dict[Any, Mapping[str, Any]] = {}
    for row in rows:
        names = ("shedding", "span", "phase", "from_station", "to_station", "time")
        key = tuple(str(row[name]) for name in names)
        rise = row.get("highest_rise", math.nan)
        if key not in best or rise > best[key].get("highest_rise", math.nan):
            best[key] = row
    return list(best.values())


def _text(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "-"
