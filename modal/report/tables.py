"""Tables of text from the findings of a report, each number with its unit."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import numpy as np

from gallop_fmu import LineScene, Outcome, Result, Scene
from gallop_fmu.foundation.version import program
from gallop_fmu.scene.dotted_paths import leaves
from gallop_fmu.simulation.result import frequency_text, summary
from modal.linear.modes import Mode
from modal.report.findings import Findings, Missing, Statics
from modal.screening.screen import Screening
from modal.screening.verdict import RISK_OF
from modal.stability.critical_wind import CriticalWind

MAX_PRINTED_NUMBERS = 8
"""Length of an array up to which all its numbers are printed."""

SHOWN_ELSEWHERE = ("title", "description", "notes", "sources")
"""Entries of a scene that the page shows outside the tables."""

MIN_FINAL_RATIO = 0.05
"""Amplitude at the end of a run, relative to the range of the run, below which it has decayed."""

NOT_STATED = "not stated"
AS_ABOVE = "as above"
"""Text for a source equal to that of the row above."""

SHOWN = {"u2": "vertical u2", "u3": "horizontal u3", "theta": "twist", "tension": "tension"}


@dataclass(frozen=True)
class Table:
    """A table of text; the first column has the names of the rows."""

    caption: str
    headings: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


@dataclass(frozen=True)
class Card:
    """One result of the summary at the top, with the section that it links to."""

    name: str
    value: str
    remark: str
    section: str


def scene_tables(scene: Scene | LineScene) -> list[Table]:
    """One table for each section of a scene: every value that is set, unit, meaning, source."""
    groups: dict[str, list[tuple[str, ...]]] = {}
    last = ""
    for leaf in leaves(scene):
        if leaf.path in SHOWN_ELSEWHERE or leaf.value is None or leaf.value == ():
            continue
        section, name = leaf.path.split(".", 1)
        rows, source = groups.setdefault(section, []), source_of(scene, leaf.path)
        shown = AS_ABOVE if rows and source == last != NOT_STATED else source
        rows.append(
            (
                name,
                value_text(leaf.value),
                "" if leaf.unit == "1" else leaf.unit,
                leaf.meaning,
                shown,
            )
        )
        last = source
    return [
        Table(name, ("name", "value", "unit", "meaning", "source"), rows)
        for name, rows in groups.items()
    ]


def source_of(scene: Scene | LineScene, path: str) -> str:
    """Source of a value in the scene: its own, or that of its section."""
    parts = path.split(".")
    starts = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((scene.sources[start] for start in starts if start in scene.sources), NOT_STATED)


def value_text(value: Any) -> str:
    """Print a value of a scene; of a long array only the length, first and last value."""
    if isinstance(value, tuple):
        if len(value) > MAX_PRINTED_NUMBERS:
            return f"{len(value)} values, from {value_text(value[0])} to {value_text(value[-1])}"
        return ", ".join(map(value_text, value))
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def static_table(findings: Findings) -> Table:
    """Static states in still air and in the mean wind, side by side."""
    states = [
        state
        for state in (findings.static_in_still_air, findings.static_in_wind)
        if isinstance(state, Statics)
    ]
    quantities = {
        "sag in the plane of the span [m]": [f"{state.sag:.4f}" for state in states],
        "drop of mid-span below the chord [m]": [f"{state.drop:.4f}" for state in states],
        "swing out of the vertical plane [deg]": [
            f"{math.degrees(state.swing):z.2f}" for state in states
        ],
        "twist at mid-span [deg]": [f"{math.degrees(state.twist):z.2f}" for state in states],
        "tension at mid-span [kN]": [f"{state.tension / 1e3:.3f}" for state in states],
    }
    for end, number in (("left", 0), ("right", 1)):
        for axis, way in enumerate(("along the span", "upwards", "with the wind")):
            whole = (
                " (total force of the span)" if findings.scene.supports.remark_on_force(end) else ""
            )
            name = f"force on the {end} end, {way}{whole} [kN]"
            quantities[name] = [
                f"{state.support_force[number, axis] / 1e3:z.3f}" for state in states
            ]
    headings = [wind_text(state.wind_speed) for state in states]
    return Table(
        "Static state", ("", *headings), [(name, *cells) for name, cells in quantities.items()]
    )


def wind_text(speed: float) -> str:
    """Name of a static state."""
    return f"wind of {speed:.4g} m/s" if speed != 0.0 else "still air"


def mode_table(modes: list[Mode], caption: str) -> Table:
    """Table of modes in order of frequency."""
    rows = [
        (
            f"{mode.family}\N{NO-BREAK SPACE}{mode.loops}",
            f"{mode.frequency_hz:.4f}",
            f"{100.0 * mode.damping_ratio:.2f}",
            f"{100.0 * mode.shares[mode.family]:.1f}",
            "yes" if mode.symmetric else "no",
        )
        for mode in modes
    ]
    headings = (
        "family and loops",
        "frequency [Hz]",
        "damping ratio [%]",
        "share of the family [%]",
        "symmetric",
    )
    return Table(caption, headings, rows)


def screening_table(found: Screening) -> Table:
    """Predicted limit cycles at the scene's wind, without and with swing."""
    rows = [
        (
            name,
            f"{cycle.wind_speed:.4g}",
            f"{cycle.vertical:.3f}",
            f"{cycle.horizontal:.3f}",
            f"{math.degrees(cycle.twist):.2f}",
            f"{cycle.frequency_hz:.4f}",
            f"{100.0 * (cycle.multiplier - 1.0):+.1f}",
        )
        for name, cycle in (
            ("galloping without swing", found.galloping),
            ("galloping with swing", found.saturated),
        )
        if cycle is not None
    ]
    headings = (
        "motion",
        "wind [m/s]",
        "vertical [m]",
        "horizontal [m]",
        "twist [deg]",
        "frequency [Hz]",
    )
    return Table(
        "Predicted limit cycles, half peak-to-peak",
        (*headings, "growth of a disturbance per cycle [%]"),
        rows,
    )


def onset_table(onsets: list[CriticalWind]) -> Table:
    """Critical wind speed of each mode."""
    rows = [
        (
            f"{onset.mode.family} {onset.mode.loops}",
            f"{onset.mode.frequency_hz:.4f}",
            (
                f"none up to {onset.searched_to:g}"
                if onset.wind_speed is None
                else f"{onset.wind_speed:.3f}"
            ),
            "-" if onset.frequency_hz is None else f"{onset.frequency_hz:.4f}",
            "-" if onset.den_hartog is None else f"{onset.den_hartog:.3f}",
        )
        for onset in onsets
    ]
    headings = (
        "mode",
        "still air [Hz]",
        "critical wind [m/s]",
        "frequency there [Hz]",
        "Den Hartog's wind [m/s]",
    )
    return Table("Critical wind speed of each mode", headings, rows)


def motion_table(result: Result) -> Table:
    """Motion at mid-span at the end of the run, and its extremes over the whole run."""
    numbers = summary(result)
    midspan, window = numbers["midspan"], numbers["window"]
    assert isinstance(midspan, dict)
    rows = []
    for name, row in midspan.items():
        scale, unit = {"theta": (180.0 / math.pi, "deg"), "tension": (1e-3, "kN")}.get(
            name, (1.0, "m")
        )
        sizes = [f"{row[key] * scale:.4g}" for key in ("amplitude", "mean", "lowest", "highest")]
        frequency = frequency_text(row["frequency_hz"])
        rows.append((f"{SHOWN[name]} [{unit}]", *sizes[:2], frequency, row["motion"], *sizes[2:]))
    last = f"last {window:g} s"
    sizes = [f"amplitude, {last}", f"mean, {last}"]
    headings = ("mid-span", *sizes, "frequency [Hz]", "motion", "lowest in the run", "highest")
    return Table("Motion at mid-span; amplitudes are half peak-to-peak", headings, rows)


def clearance_table(findings: Findings, result: Result, place: tuple[float, float]) -> Table:
    """Distance of mid-span beyond each ellipse.

    Parameters
    ----------
    findings, result
        The ellipses and the motion.
    place
        Static position x3, x2 [m] of mid-span, at which the ellipses are placed.
    """
    data = result.midspan()
    x, y = np.asarray(data.u3.values) - place[0], np.asarray(data.u2.values) - place[1]
    rows = []
    for name, ellipse in findings.ellipses.items():
        if isinstance(ellipse, Missing):
            continue
        beyond = ellipse.distance(x, y)
        farthest = int(np.argmax(beyond))
        rows.append(
            (
                name,
                f"{ellipse.major:.3f}",
                f"{ellipse.minor:.3f}",
                f"{ellipse.offset:.3f}",
                f"{math.degrees(ellipse.rotation):.2f}",
                f"{beyond[farthest]:+.3f}",
                f"{float(data.time[farthest]):.2f}",
                f"{100.0 * float(np.mean(beyond > 0.0)):.1f}",
            )
        )
    ellipse_headings = ("rule", "major axis [m]", "minor axis [m]", "offset [m]", "rotation [deg]")
    headings = (
        *ellipse_headings,
        "largest distance outside [m]",
        "at time [s]",
        "share of time outside [%]",
    )
    return Table("Distance of mid-span from the ellipses of two design rules", headings, rows)


def numerics_table(findings: Findings) -> Table:
    """Numerical settings and counters of the simulation."""
    scene, rows = findings.scene, [("elements", f"{findings.scene.elements}")]
    step = scene.numerics.time_step
    rows.append(("time step", f"{step:g} s"))
    if not isinstance(findings.frequencies, Missing):
        steps = 1.0 / (findings.frequencies.vertical_hz * step)
        rows.append(("time steps in a period of the first vertical mode", f"{steps:.0f}"))
    if isinstance(findings.result, Result):
        report, attrs = findings.result.report, findings.result.dataset.attrs
        time = findings.result.dataset.time.values
        interval = float(time[1] - time[0]) if len(time) > 1 else step
        rows += [
            ("integrator", str(attrs["integrator"])),
            ("time steps, sub-steps", f"{report.steps}, {report.substeps}"),
            ("Newton iterations per step", f"{report.iterations / max(report.steps, 1):.2f}"),
            ("step halvings", f"{report.halvings}"),
            ("lowest tension in the span", f"{report.lowest_tension / 1e3:.3f} kN"),
            (
                "largest residual force of the initial state",
                f"{attrs['held_imbalance']:.3g} N",
            ),
            ("records, and time between them", f"{len(time)}, {interval:g} s"),
        ]
    return Table("Numerics", ("", ""), rows)


def provenance_table(findings: Findings) -> Table:
    """Program, versions, machine, date and computing time."""
    rows = [
        ("program", program()),
        ("Python, NumPy", f"{platform.python_version()}, {np.__version__}"),
        ("machine", f"{platform.system()} {platform.machine()}"),
        ("written", datetime.now().astimezone().isoformat(timespec="seconds")),
        (
            "computing time",
            ", ".join(f"{name} {seconds:.1f} s" for name, seconds in findings.seconds.items()),
        ),
    ]
    if isinstance(findings.result, Result):
        rows.insert(1, ("kernel", str(findings.result.dataset.attrs["kernel"])))
    return Table("Provenance", ("", ""), rows)


def cards(findings: Findings) -> Iterator[Card]:
    """Summary of the findings; a missing part has no card."""
    still, frequencies, result = (
        findings.static_in_still_air,
        findings.frequencies,
        findings.result,
    )
    if isinstance(still, Statics):
        yield Card(
            "Sag in still air",
            f"{still.sag:.3f} m",
            f"tension {still.tension / 1e3:.2f} kN",
            "static",
        )
    if not isinstance(frequencies, Missing):
        pair = (
            f"{frequencies.vertical_hz:.4f} / {frequencies.horizontal_hz:.4f} Hz, vertical /"
            " horizontal"
        )
        yield Card("Frequency ratio", f"{frequencies.ratio:.3f}", pair, "ratio")
    if isinstance(findings.onsets, list):
        yield _onset_card(findings.onsets)
    if isinstance(findings.screening, Screening):
        yield _risk_card(findings.screening)
    if isinstance(result, Result):
        if result.outcome is not Outcome.COMPLETED:
            ended = f"at {result.report.time:.4g} s"
            yield Card("Simulation", "ended early", ended, "simulation")
        if result.dataset.sizes["time"] > 1:
            yield _motion_card(result)


def _onset_card(onsets: list[CriticalWind]) -> Card:
    """Lowest critical wind speed."""
    speeds = [onset.wind_speed for onset in onsets if onset.wind_speed is not None]
    if speeds:
        return Card("Lowest critical wind", f"{min(speeds):.2f} m/s", "linear theory", "critical")
    highest = f"up to {onsets[0].searched_to:g} m/s"
    return Card("Lowest critical wind", "none", highest, "critical")


def _risk_card(found: Screening) -> Card:
    """Risk of a swing or of turning over, and its onset."""
    remark = "no onset found"
    if found.risk == "other" and found.other_mode is not None:
        remark = f"but {found.other_mode}"
    elif found.risk == "turns over":
        least = found.divergence_from
        remark = "stable only when turned over" if least is None else f"from {least:.2f} m/s"
    elif found.onset_wind_speed is not None:
        remark = f"from {found.onset_wind_speed:.2f} m/s"
    return Card(RISK_OF.capitalize(), found.risk, remark, "ratio")


def _motion_card(result: Result) -> Card:
    """Motion of mid-span: amplitude at the end of the run, or range if it has decayed by then."""
    midspan, motion = summary(result)["midspan"], result.motion
    assert isinstance(midspan, dict)
    vertical, low, high = (
        midspan["u2"]["amplitude"],
        midspan["u2"]["lowest"],
        midspan["u2"]["highest"],
    )
    warned = "; with warnings" if result.warnings else ""
    if motion.kind == "turned over" or vertical < MIN_FINAL_RATIO * (high - low):
        remark = (
            f"peak to peak over the whole run, from {low:.2f} to {high:.2f} m; {motion}{warned}"
        )
        return Card("Vertical range", f"{high - low:.3f} m", remark, "simulation")
    end = "at the end of the run" if motion.is_steady else f"at the end of the run: {motion}"
    remark = (
        f"{'steady; ' if motion.kind == 'steady' else ''}horizontal"
        f" {midspan['u3']['amplitude']:.3f} m, {end}{warned}"
    )
    return Card("Vertical amplitude", f"{vertical:.3f} m", remark, "simulation")
