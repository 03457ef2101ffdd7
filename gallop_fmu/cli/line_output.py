"""Text about the run of a line: its spans, strings, towers and clearances."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gallop_fmu.cli.shedding_output import print_sheddings
from gallop_fmu.cli.terminal import new_console, new_table, print_warnings, work_text

KILO = 1e-3
NEGLIGIBLE = 5e-5
"""Value in m, rad, deg or kN below which a table has 0."""

AXES = ("x1", "x2", "x3")
Row = Mapping[str, Any]


def print_line(
    numbers: Mapping[str, Any], warnings: Iterable[str], written: Sequence[Path]
) -> None:
    """Print the summary of a run of a line.

    Parameters
    ----------
    numbers
        From `gallop_fmu.simulation.line_tables.line_summary`.
    warnings
        Warnings of the run.
    written
        Files that were written.
    """
    console = new_console()
    console.print(numbers["title"], style="bold")
    console.print(f"motion: {numbers['motion']}", soft_wrap=True)
    console.print(_spans(numbers))
    console.print(
        "sag and horizontal tension H at rest; u2, u3, twist: half peak-to-peak at mid-span in the"
        f" last {numbers['window']:g} s",
        style="dim",
        soft_wrap=True,
    )
    if numbers["strings"]:
        console.print(_strings(numbers["strings"]))
    console.print(_towers(numbers["towers"]))
    console.print("force of the conductors on the tower: preload, range in the run", style="dim")
    if numbers.get("clearances"):
        console.print(_clearances(numbers["clearances"]))
    print_sheddings(console, numbers.get("sheddings", ()))
    console.print(work_text(numbers))
    print_warnings(warnings)
    for path in written:
        console.print(f"wrote {path}", soft_wrap=True)


def _place(row: Row, name: str, phases: bool) -> str:
    """Number of a span or tower, with its phase if there are several."""
    return f"{row[name]}, phase {row['phase']}" if phases else f"{row[name]}"


def _has_phases(rows: Sequence[Row]) -> bool:
    return any(row["phase"] > 1 for row in rows)


def _spans(numbers: Mapping[str, Any]) -> Any:
    from gallop_fmu.simulation.oscillation import frequency_text

    rows = numbers["spans"]
    table = new_table(
        *("span", "sag [m]", "H [kN]", "u2 [m]", "u3 [m]", "twist [rad]", "f of u2 [Hz]", "motion")
    )
    for row in rows:
        amplitudes = (row.get(f"{name}_amplitude", math.nan) for name in ("u2", "u3", "theta"))
        table.add_row(
            _place(row, "span", _has_phases(rows)),
            f"{row['sag']:.3f}",
            f"{row['horizontal_tension'] * KILO:.3f}",
            *(_number(amplitude, ".3g") for amplitude in amplitudes),
            frequency_text(row.get("u2_frequency_hz", math.nan)),
            row["motion"].partition(" (")[0],
        )
    return table


def _strings(rows: Sequence[Row]) -> Any:
    table = new_table(
        "string at tower",
        "pull at rest [kN]",
        "range [kN]",
        "lean along [deg]",
        "lean across [deg]",
    )
    for row in rows:
        table.add_row(
            _place(row, "tower", _has_phases(rows)),
            f"{row['pull_at_rest'] * KILO:.3f}",
            _range(row, "pull", KILO),
            _range(row, "lean_along", math.degrees(1.0)),
            _range(row, "lean_across", math.degrees(1.0)),
        )
    return table


def _towers(rows: Sequence[Row]) -> Any:
    table = new_table("tower", *(f"force {axis} [kN]" for axis in AXES))
    for row in rows:
        cells = [
            f"{_number(row[f'preload_{axis}'] * KILO)}\n{_range(row, f'force_{axis}', KILO)}"
            for axis in AXES
        ]
        table.add_row(_place(row, "tower", _has_phases(rows)), *cells)
    return table


def _clearances(rows: Sequence[Row]) -> Any:
    table = new_table("span", "phases", "distance at rest [m]", "smallest [m]", "at [s]")
    for row in rows:
        table.add_row(
            str(row["span"]),
            f"{row['phase']} and {row['other_phase']}",
            f"{row['at_rest']:.3f}",
            f"{row['smallest']:.3f}",
            f"{row['time']:.2f}",
        )
    return table


def _range(row: Row, name: str, factor: float) -> str:
    return f"{_number(row[f'{name}_min'] * factor)} to {_number(row[f'{name}_max'] * factor)}"


def _number(value: float, digits: str = ".4g") -> str:
    """Value as text: 0 for a negligible one, a dash for NaN."""
    if not math.isfinite(value):
        return "-"
    return f"{value:{digits}}" if abs(value) >= NEGLIGIBLE else "0"
