"""Self-contained HTML page from the findings of a report on a line."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from gallop_fmu import Model
from gallop_fmu.simulation.line_result import LineResult
from modal.linear.line_modes import LineMode
from modal.report import line_tables, tables
from modal.report.animation import played
from modal.report.findings import Missing
from modal.report.line_animation import line_animation, part_of_line
from modal.report.line_findings import LineFindings
from modal.report.line_screening import states_table
from modal.report.line_verdict import verdict
from modal.report.template import render

DRAWN_MODES = 8
"""Number of modes whose shapes are drawn, the lowest ones."""

DRAWN_PHASES = 3
"""Most phases with pictures of their histories and paths."""


def line_page(findings: LineFindings) -> str:
    """Fill in the template; every text from the scene is escaped."""
    return render("line_report.html", line_content(findings), Missing)


def line_content(findings: LineFindings) -> dict[str, Any]:
    """Values of all names in the template."""
    scene, modes, pairs = findings.scene, findings.modes, findings.pairs
    filled: dict[str, Any] = {
        "findings": findings,
        "scene": scene,
        "toml": scene.to_toml(),
        "verdict": list(verdict(findings)),
        "scene_tables": tables.scene_tables(scene),
        "pictures": [],
        "animation": None,
        "motion_tables": [],
        "modes_figure": None,
        "modes_table": None,
        "pairs_table": None,
        "onset_table": None,
        "states_table": None,
        "criteria_table": None,
        "provenance_table": line_tables.provenance_table(findings),
    }
    if isinstance(findings.result, LineResult):
        filled |= _run_content(findings.result)
    if not isinstance(modes, Missing):
        filled["modes_figure"] = _modes_figure(findings, modes)
        filled["modes_table"] = line_tables.modes_table(modes)
    if not isinstance(pairs, Missing) and pairs:
        filled["pairs_table"] = line_tables.pairs_table(pairs)
    if not isinstance(findings.onsets, Missing):
        filled["onset_table"] = tables.onset_table(findings.onsets)
    if not isinstance(findings.screening, Missing):
        filled["states_table"] = states_table(findings.screening)
    if not isinstance(findings.criteria, Missing):
        filled["criteria_table"] = line_tables.criteria_table(findings.criteria)
    return filled


def _run_content(result: LineResult) -> dict[str, Any]:
    """Pictures and tables of the simulation."""
    motion = [line_tables.spans_table(result)]
    if not result.strings.empty:
        motion.append(line_tables.strings_table(result))
    motion.append(line_tables.towers_table(result))
    if clearances := line_tables.clearances_table(result):
        motion.append(clearances)
    motion.append(line_tables.ellipses_table(result))
    return {
        "pictures": _pictures(result),
        "animation": _animation_content(result),
        "motion_tables": motion,
    }


def _animation_content(result: LineResult) -> dict[str, Any] | None:
    """The moving line, by the period of the span that moves most; None without a motion."""
    if result.dataset.sizes["time"] < 2:
        return None
    frames = line_animation(result, _largest_span(result))
    height, across = frames.moved[..., 0], frames.moved[..., 1]
    return played(frames.part, frames.time, (height, across), frames.packed())


def _largest_span(result: LineResult) -> int:
    """Number of the span that moves most."""
    sizes = [
        float(np.ptp(result.bundle(span, 1)["u2"].values))
        for span in range(1, result.map.spans + 1)
    ]
    return int(np.argmax(sizes)) + 1


def _pictures(result: LineResult) -> list[Any]:
    """The line in elevation and plan, histories and paths of each phase."""
    from gallop_fmu.line_plots import line_histories, line_paths, line_shape
    from modal.report.plots import picture

    drawn = [
        picture(
            "shape",
            "The section in elevation and in plan, at rest and farthest downwind",
            "The section with its strings (thick lines). Towers are numbered from 0.",
            lambda: line_shape(result),
        )
    ]
    if result.dataset.sizes["time"] < 2:
        return drawn
    part, frames = part_of_line(result, _largest_span(result))
    time = np.asarray(result.dataset.time.values)
    window = float(time[frames[0]]), float(time[frames[-1]])
    when = f"{window[0]:.0f} to {window[1]:.0f} s: {part}"
    for phase in range(1, min(result.map.phases, DRAWN_PHASES) + 1):
        name = f", phase {phase}" if result.map.phases > 1 else ""
        drawn.append(
            picture(
                f"histories-{phase}",
                f"Histories of mid-spans and strings{name}",
                f"Displacement of mid-spans from rest, and lean of strings{name}.",
                partial(line_histories, result, phase),
            )
        )
        drawn.append(
            picture(
                f"paths-{phase}",
                f"Paths of mid-spans{name}",
                f"Paths of mid-spans across the line, seen along the line{name}, {when}.",
                partial(line_paths, result, phase, window),
                once=True,
            )
        )
    return drawn


def _modes_figure(findings: LineFindings, modes: list[LineMode]) -> Any:
    """Shapes of the lowest modes."""
    from modal.plots.line_figures import line_mode_shapes
    from modal.report.plots import picture

    drawn = modes[:DRAWN_MODES]
    return picture(
        "modes",
        "Shapes of the lowest modes in elevation and plan",
        "Shapes of the lowest modes: elevation on the left, plan on the right; grey at rest.",
        lambda: line_mode_shapes(Model(findings.scene), drawn),
        once=True,
    )
