"""Tables of text from the findings of a report on a line, each number with its unit."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable, Mapping
from datetime import datetime
from typing import Any

import numpy as np

from gallop_fmu.foundation.version import program
from gallop_fmu.simulation.line_result import LineResult
from gallop_fmu.simulation.oscillation import frequency_text
from modal.linear.line_modes import LineMode
from modal.report.line_findings import LineFindings
from modal.report.tables import Table
from modal.stability.line_criteria import SpanCriteria
from modal.stability.mode_pairs import ModePair

LISTED_SHARE = 0.1
"""Share of the kinetic energy from which a span is listed."""

MAX_PAIRS = 20
"""Most pairs in the table."""

WAYS = {"x1": "along the line", "x2": "upwards", "x3": "with the wind"}
Row = Mapping[str, Any]


def number(value: float, scale: float = 1.0, digits: str = ".3f") -> str:
    """A value as text, a dash for NaN."""
    if not math.isfinite(value):
        return "-"
    return f"{value * scale:{digits.replace('.', 'z.')}}"  # z: no minus before zero


def _range(row: Row, name: str, scale: float, digits: str = ".2f") -> str:
    low, high = (number(row[f"{name}_{end}"], scale, digits) for end in ("min", "max"))
    return f"{low} to {high}"


def _place(row: Row, name: str, phases: bool) -> str:
    return f"{name} {row[name]}, phase {row['phase']}" if phases else f"{name} {row[name]}"


def spans_table(result: LineResult) -> Table:
    """Motion of the spans at mid-span, peak to peak, with sag and tensions."""
    phases, rows = result.map.phases > 1, []
    for row in result.spans.to_dict("records"):
        size = {
            name: 2.0 * row.get(f"{name}_amplitude", math.nan) for name in ("u2", "u3", "theta")
        }
        rows.append(
            (
                _place(row, "span", phases),
                f"{result.scene.section.spans[row['span'] - 1].length:.1f}",
                number(row["sag"], digits=".2f"),
                number(row["horizontal_tension"], 1e-3, ".2f"),
                number(row.get("largest_tension", math.nan), 1e-3, ".2f"),
                number(size["u2"], digits=".2f"),
                number(size["u3"], digits=".2f"),
                number(size["theta"], math.degrees(1.0), ".1f"),
                frequency_text(row.get("u2_frequency_hz", math.nan)),
                row["motion"].partition(" (")[0],
            )
        )
    headings = (
        "span",
        "length [m]",
        "sag at rest [m]",
        "horizontal tension at rest [kN]",
        "largest tension in the run [kN]",
        "vertical, peak to peak [m]",
        "horizontal, peak to peak [m]",
        "twist, peak to peak [deg]",
        "frequency, vertical [Hz]",
        "motion",
    )
    caption = (
        f"Spans: motion of mid-span{_last(result)}; tensions are those of one conductor, and the"
        " largest one that of the whole run"
    )
    return Table(caption, headings, rows)


def _last(result: LineResult) -> str:
    if len(result.dataset.time) < 2:
        return ""
    start, stop = result.window()
    return f" in the last {stop - start:.3g} s"


def strings_table(result: LineResult) -> Table:
    """Pull and lean of the strings at rest, and their extremes in the whole run."""
    degree, phases = math.degrees(1.0), result.map.phases > 1
    rows = [
        (
            _place(row, "tower", phases),
            str(row["kind"]).replace("v_string", "V-string"),
            number(row["pull_at_rest"], 1e-3, ".2f"),
            _range(row, "pull", 1e-3),
            number(row["lean_along_at_rest"], degree, ".2f"),
            _range(row, "lean_along", degree),
            number(row["lean_across_at_rest"], degree, ".2f"),
            _range(row, "lean_across", degree),
            number(2.0 * row.get("lean_across_amplitude", math.nan), degree, ".2f"),
            frequency_text(row.get("lean_across_frequency_hz", math.nan)),
        )
        for row in result.strings.to_dict("records")
    ]
    headings = (
        "string at",
        "kind",
        "pull at rest [kN]",
        "pull in the run [kN]",
        "lean along, at rest [deg]",
        "lean along, in the run [deg]",
        "lean across, at rest [deg]",
        "lean across, in the run [deg]",
        "swing across at the end, peak to peak [deg]",
        "frequency of the swing [Hz]",
    )
    return Table("Strings: pull, and lean along and across the line", headings, rows)


def towers_table(result: LineResult) -> Table:
    """Preload and extremes of the force on each tower."""
    phases, rows = result.map.phases > 1, []
    for row in result.towers.to_dict("records"):
        cells = [
            text
            for axis in WAYS
            for text in (
                number(row[f"preload_{axis}"], 1e-3, ".2f"),
                _range(row, f"force_{axis}", 1e-3),
            )
        ]
        kind = str(row["kind"]).replace("v_string", "V-string")
        rows.append((_place(row, "tower", phases), kind, *cells))
    headings = [
        f"{what}, {way} [kN]" for way in WAYS.values() for what in ("preload", "lowest to highest")
    ]
    caption = (
        "Towers: force of the conductors on each tower and phase. The preload is that at rest in"
        " still air; the extremes of the whole run include it"
    )
    return Table(caption, ("tower", "kind", *headings), rows)


def clearances_table(result: LineResult) -> Table | None:
    """Smallest distances of phases; None of a single phase."""
    table = result.clearances
    if table.empty:
        return None
    rows = [
        (
            f"span {row['span']}, phases {row['phase']} and {row['other_phase']}",
            number(row["at_rest"], digits=".2f"),
            number(row["smallest"], digits=".2f"),
            number(row["time"], digits=".2f"),
            number(row["x1"], digits=".1f"),
        )
        for row in table.to_dict("records")
    ]
    headings = (
        "span and phases",
        "smallest distance at rest [m]",
        "smallest in the run [m]",
        "at time [s]",
        "at place along the line [m]",
    )
    return Table("Clearances between phases, between centres of conductors", headings, rows)


def ellipses_table(result: LineResult) -> Table:
    """Distances of the motion from the ellipses of design rules."""
    phases = result.map.phases > 1
    rows = [
        (
            _place(row, "span", phases),
            number(row.get("cigre_322_excess", math.nan), digits="+.2f"),
            number(row.get("davison_excess", math.nan), digits="+.2f"),
        )
        for row in result.spans.to_dict("records")
    ]
    headings = ("span", "CIGRE 322 [m]", "Davison [m]")
    caption = (
        f"Largest distance of mid-span outside the single-loop ellipse{_last(result)}; negative"
        " inside, a dash where the rule has no ellipse"
    )
    return Table(caption, headings, rows)


def modes_table(modes: list[LineMode]) -> Table:
    """Natural modes with family and participation of the spans."""
    rows = [
        (
            str(k),
            mode.family,
            f"{mode.frequency_hz:.4f}",
            f"{100.0 * mode.damping_ratio:.2f}",
            " ".join(str(loops) if loops else "-" for loops in mode.loops),
            _numbered(mode.span_shares.tolist()),
            _numbered(mode.phase_shares.tolist()),
            f"{100.0 * mode.tension_share:.0f}",
        )
        for k, mode in enumerate(modes, start=1)
    ]
    headings = (
        "mode",
        "family",
        "frequency [Hz]",
        "damping ratio [%]",
        "loops in each span",
        "spans that take part",
        "phases that take part",
        "share of tension in the energy [%]",
    )
    kept = [k for k in range(len(headings)) if k != 6 or len(modes[0].phase_shares) > 1]
    return Table(
        f"Natural modes in still air, with spans of at least {LISTED_SHARE:.0%} of the energy",
        tuple(headings[k] for k in kept),
        [tuple(row[k] for k in kept) for row in rows],
    )


def _numbered(shares: Iterable[float]) -> str:
    listed = [
        f"{k}: {share:.0%}" for k, share in enumerate(shares, start=1) if share >= LISTED_SHARE
    ]
    return ", ".join(listed)


def pairs_table(pairs: list[ModePair]) -> Table:
    """Pairs of modes near resonance; those that matter first."""
    rows = [
        (
            f"{pair.kind}, {pair.driving} and {pair.driven}",
            f"{pair.driving_mode.family}, {pair.driving_mode.frequency_hz:.4f} Hz",
            f"{pair.driven_mode.family}, {pair.driven_mode.frequency_hz:.4f} Hz",
            f"{100.0 * pair.detuning:+.1f}",
            "none" if pair.threshold is None else f"{pair.threshold:.3g} {_unit(pair)}",
            f"{pair.largest_galloping:.3g} {_unit(pair)}" if pair.largest_galloping else "-",
            "yes" if pair.matters else "no",
        )
        for pair in pairs[:MAX_PAIRS]
    ]
    headings = (
        "pair of modes",
        "driving mode",
        "driven mode",
        "distance from resonance [%]",
        "threshold of the driving mode",
        "galloping may reach",
        "matters",
    )
    more = f"; the first {MAX_PAIRS} of {len(pairs)}" if len(pairs) > MAX_PAIRS else ""
    return Table(f"Resonant pairs of modes; amplitudes, not peak to peak{more}", headings, rows)


def _unit(pair: ModePair) -> str:
    return "rad" if pair.driving_mode.family == "torsional" else "m"


def criteria_table(criteria: list[SpanCriteria]) -> Table:
    """Criteria of each span at its attack angle."""
    rows = [
        (
            f"span {span.span}",
            f"{math.degrees(span.attack_angle):.1f}",
            "unstable by " + ", ".join(span.unstable) if span.unstable else "stable",
        )
        for span in criteria
    ]
    headings = ("span", "attack angle [deg]", "judgement")
    return Table("Stability criteria of each span", headings, rows)


def provenance_table(findings: LineFindings) -> Table:
    """Numerics, program, versions, machine and computing time."""
    scene, seconds = findings.scene, findings.seconds
    rows = [
        ("program", program()),
        ("Python, NumPy", f"{platform.python_version()}, {np.__version__}"),
        ("machine", f"{platform.system()} {platform.machine()}"),
        ("written", datetime.now().astimezone().isoformat(timespec="seconds")),
        ("time step", f"{scene.numerics.time_step:g} s"),
        ("computing time", ", ".join(f"{name} {spent:.1f} s" for name, spent in seconds.items())),
    ]
    if isinstance(findings.result, LineResult):
        attributes, report = findings.result.dataset.attrs, findings.result.report
        rows += [
            ("kernel", str(attributes["kernel"])),
            ("integrator", str(attributes["integrator"])),
            ("elements of all conductors", f"{findings.result.map.elements}"),
            ("time steps, sub-steps", f"{report.steps}, {report.substeps}"),
        ]
    return Table("Numerics and provenance", ("", ""), rows)
