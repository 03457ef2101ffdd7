"""Self-contained HTML page from the findings of a report."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gallop_fmu import LineScene, Result
from gallop_fmu.foundation.atomic_write import check_target, write_whole
from gallop_fmu.input.scene_like import SceneLike, as_scene
from modal.foundation.one_thread import one_thread
from modal.linear.modes import Mode
from modal.report import tables
from modal.report.animation import Animation, animation, played
from modal.report.findings import Findings, Missing, Progress, Statics, examine
from modal.report.line_findings import LineFindings, examine_line
from modal.report.line_page import line_page
from modal.report.template import render

SUFFIXES = (".html", ".htm")
MIN_MOTION = 1e-9
"""Displacement [m] and twist [rad] below which a motion is only rounding."""

SHAPE_BOX = 100.0, 20.0
"""Half width and half height of the box of a mode shape."""


@dataclass(frozen=True)
class Shape:
    """Name, frequency, family and SVG points of a mode shape."""

    name: str
    frequency: str
    family: str
    points: str


@one_thread
def write_report(
    scene: SceneLike,
    path: Path | str,
    *,
    stop_time: float | None = None,
    progress: Progress | None = None,
) -> Path:
    """Examine a span or a line and write a report as one self-contained HTML page.

    The page shows the scene with units and sources, static state, modes, frequency ratio and risk
    of a 2:1 swing, critical winds, a simulation with an animation, the clearance ellipses of two
    design rules, numerics and provenance. Items that could not be computed are listed with the
    reason; a simulation that ended early is shown up to its end.

    The page on a line has a verdict, pictures of the section with its strings, histories, paths and
    mode shapes, tables of spans, strings, towers, clearances, modes, resonant pairs and critical
    winds, and the scene. Limit cycles over the wind speed and the risk are not computed for lines.

    Parameters
    ----------
    scene
        The span or line.
    path
        File to write (.html).
    stop_time
        Simulated time [s]; None takes the scene's.
    progress
        Called with the name of the current part and the share of it that is done.

    Raises
    ------
    SceneError
        If the suffix or the simulated time is not allowed.
    """
    path = Path(path)
    check_target(path, SUFFIXES)
    scene = as_scene(scene)
    if isinstance(scene, LineScene):
        return write_page(examine_line(scene, stop_time, progress), path)
    return write_page(examine(scene, stop_time, progress), path)


def write_page(findings: Findings | LineFindings, path: Path) -> Path:
    """Write findings as a page."""
    text = line_page(findings) if isinstance(findings, LineFindings) else page(findings)
    write_whole(path, text.encode())
    return path


def page(findings: Findings) -> str:
    """Fill in the template; every text from the scene is escaped."""
    return render("report.html", content(findings), Missing)


ABSENT = dict.fromkeys(
    (
        "static_table",
        "static_figure",
        "coefficient_figure",
        "criteria_figure",
        "onset_table",
        "screening_table",
        "screening_figure",
        "motion_table",
        "histories_figure",
        "trace_figure",
        "animation",
        "clearance_table",
        "clearance_figure",
    )
)
"""Names in the template that stay None unless a section fills them in."""


def content(findings: Findings) -> dict[str, Any]:
    """Values of all names in the template."""
    return {
        **ABSENT,
        **_scene_content(findings),
        **_static_content(findings),
        **_mode_content(findings),
        **_linear_content(findings),
        **_screening_content(findings),
        **_simulation_content(findings),
        "findings": findings,
        "cards": list(tables.cards(findings)),
        "numerics_table": tables.numerics_table(findings),
        "provenance_table": tables.provenance_table(findings),
    }


def _scene_content(findings: Findings) -> dict[str, Any]:
    """Tables of the scene, and its coefficient curve."""
    from gallop_fmu.plots import curve_figure
    from modal.report.plots import picture

    scene = findings.scene
    filled: dict[str, Any] = {
        "scene": scene,
        "toml": scene.to_toml(),
        "scene_tables": tables.scene_tables(scene),
    }
    if scene.aerodynamics is not None:
        curve, angle = scene.aerodynamics.curve(), math.radians(scene.ice.attack_angle_deg)
        filled["coefficient_figure"] = picture(
            "coefficients",
            "Lift, drag and moment coefficient over the attack angle",
            "Aerodynamic coefficients, based on the diameter of the bare conductor. Curve:"
            f" {scene.aerodynamics.label}.",
            lambda: curve_figure(curve, "vertical line: initial attack angle of the scene", angle),
        )
    return filled


def _static_content(findings: Findings) -> dict[str, Any]:
    """Table and figure of the static states that were found."""
    from modal.report.plots import picture, static_shape

    states = {
        tables.wind_text(state.wind_speed): state
        for state in (findings.static_in_still_air, findings.static_in_wind)
        if isinstance(state, Statics)
    }
    if not states:
        return {}
    return {
        "static_table": tables.static_table(findings),
        "static_figure": picture(
            "static",
            "Static shape of the span from the side and from above",
            "Static shape of the span; dots are the supports.",
            lambda: static_shape(states),
        ),
    }


def _mode_content(findings: Findings) -> dict[str, Any]:
    """Tables of modes (or `Missing`), and mode shapes."""
    pairs = (
        (findings.modes, "In still air"),
        (findings.modes_in_wind, "In the mean wind"),
    )
    return {
        "mode_tables": [
            modes if isinstance(modes, Missing) else tables.mode_table(modes, name)
            for modes, name in pairs
        ],
        "shapes": (
            [] if isinstance(findings.modes, Missing) else [_shape(mode) for mode in findings.modes]
        ),
    }


def _linear_content(findings: Findings) -> dict[str, Any]:
    """Stability criteria and critical winds."""
    from modal.plots.span_figures import criteria_figure
    from modal.report.plots import picture

    filled: dict[str, Any] = {}
    if isinstance(findings.criteria, list):
        criteria, angle = findings.criteria, math.radians(findings.scene.ice.attack_angle_deg)
        filled["criteria_figure"] = picture(
            "criteria",
            "Stability criteria over the attack angle",
            "Criteria of linear theory; dashed: the scene's attack angle.",
            lambda: criteria_figure(criteria, angle),
        )
    if isinstance(findings.onsets, list):
        filled["onset_table"] = tables.onset_table(findings.onsets)
    return filled


def _screening_content(findings: Findings) -> dict[str, Any]:
    """Table and figure of the predicted limit cycles."""
    from modal.plots.span_figures import screening_figure
    from modal.report.plots import picture

    found = findings.screening
    if isinstance(found, Missing) or not (found.limit_cycle or found.saturated):
        return {}
    return {
        "screening_table": tables.screening_table(found),
        "screening_figure": picture(
            "screening",
            "Predicted galloping amplitude and growth of a swing over the wind speed",
            "Vertical galloping without swing, and growth of a small swing, over the wind speed.",
            lambda: screening_figure(found),
        ),
    }


def _simulation_content(findings: Findings) -> dict[str, Any]:
    """Motion, animation and clearance of the simulation; nothing if it ended with its start."""
    from gallop_fmu.plots import histories, trace
    from modal.report.plots import NARROW, picture, resize

    result = findings.result
    if isinstance(result, Missing) or result.dataset.sizes["time"] < 2:
        return {"still": False}
    if all(
        float(np.abs(result.dataset[name].values).max()) < MIN_MOTION
        for name in ("u2", "u3", "theta")
    ):
        return {"still": True}
    return {
        "still": False,
        "motion_table": tables.motion_table(result),
        "animation": _animation_content(animation(result)),
        "histories_figure": picture(
            "histories",
            "Histories of vertical and horizontal displacement, twist and tension at mid-span",
            "Histories at mid-span.",
            lambda: histories(result, ("u2", "u3", "theta", "tension")),
        ),
        "trace_figure": picture(
            "trace",
            "Path of mid-span in the plane across the line",
            "Path of mid-span, seen along the line.",
            lambda: resize(trace(result), NARROW, 3.6),
            once=True,
        ),
        **_clearance_content(findings, result),
    }


def _clearance_content(findings: Findings, result: Result) -> dict[str, Any]:
    """Motion of mid-span compared with the ellipses of design rules."""
    from modal.report.plots import clearance_figure, picture

    ellipses = {
        name: found for name, found in findings.ellipses.items() if not isinstance(found, Missing)
    }
    if not ellipses:
        return {}
    place, places = (0.0, 0.0), {"static in still air": (0.0, 0.0)}
    still_air, in_wind = findings.static_in_still_air, findings.static_in_wind
    if isinstance(still_air, Statics) and isinstance(in_wind, Statics):
        _, up, across = (in_wind.x - still_air.x)[findings.scene.elements]
        place = places["static in the mean wind"] = (float(across), float(up))
    return {
        "clearance_table": tables.clearance_table(findings, result, place),
        "clearance_figure": picture(
            "clearance",
            "Area that mid-span reached, and the ellipses of CIGRE and Davison",
            "Mid-span in the plane across the line, downwind to the right.",
            lambda: clearance_figure(result.midspan(), ellipses, places),
            once=True,
        ),
    }


def _shape(mode: Mode) -> Shape:
    """Convert a mode shape to points in the coordinates of its SVG picture."""
    wave = mode.wave / np.abs(mode.wave).max()
    across, up = np.linspace(-SHAPE_BOX[0], SHAPE_BOX[0], len(wave)), -SHAPE_BOX[1] * wave
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, up, strict=True))
    return Shape(f"{mode.family} {mode.loops}", f"{mode.frequency_hz:.4f} Hz", mode.family, points)


def _animation_content(frames: Animation) -> dict[str, Any]:
    """Frames of the animation, their times [s] and their ranges [m]."""
    return played(frames.part, frames.time, (frames.height, frames.across), frames.packed())
