"""From findings to one HTML page that needs nothing else."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gallop_fmu import Result, Scene
from gallop_fmu.foundation.atomic_write import check_target, write_whole
from modal.linear.modes import Mode
from modal.report import tables
from modal.report.animation import Animation, animation
from modal.report.findings import Findings, Missing, Progress, Statics, examine
from modal.screening.screen import Screening

SUFFIXES = (".html", ".htm")
STILL = 1e-9
"""Displacement [m] and twist [rad] below which a run shows nothing but rounding."""

SHAPE_BOX = 100.0, 20.0
"""Half width and half height of the box that a mode shape is drawn in."""


@dataclass(frozen=True)
class Shape:
    """A mode shape: the points of its line, and a name."""

    name: str
    frequency: str
    family: str
    points: str


def write_report(
    scene: Scene,
    path: Path | str,
    *,
    stop_time: float | None = None,
    progress: Progress | None = None,
) -> Path:
    """Examine a span and write what was found as one self-contained HTML page.

    The page holds the scene with units and sources, static state, modes, frequency ratio and risk
    of a 2:1 swing, critical winds, a simulation with an animation, the clearance ellipses of two
    design rules, numerics and provenance. What could not be found out stands there with the reason;
    a simulation that ended early is shown up to its end.

    Parameters
    ----------
    scene
        The span.
    path
        File to write (.html).
    stop_time
        Simulated time [s]; None takes the scene's.
    progress
        Called with the name of what is being computed and the share of it that is done.

    Raises
    ------
    SceneError
        If the suffix or the simulated time is not allowed.
    """
    path = Path(path)
    check_target(path, SUFFIXES)
    return write_page(examine(scene, stop_time, progress), path)


def write_page(findings: Findings, path: Path) -> Path:
    """Write findings as a page."""
    write_whole(path, page(findings).encode())
    return path


def page(findings: Findings) -> str:
    """The whole page; every text from the scene is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("modal.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["missing"] = lambda value: isinstance(value, Missing)
    return environment.get_template("report.html").render(content(findings))


def content(findings: Findings) -> dict[str, Any]:
    """What the template fills in."""
    from modal.report.plots import coefficient_figure, picture, static_shape

    scene, result = findings.scene, findings.result
    rests = {
        tables.wind_text(s.wind_speed): s
        for s in (findings.still, findings.blown)
        if isinstance(s, Statics)
    }
    filled: dict[str, Any] = {
        "findings": findings,
        "scene": scene,
        "toml": scene.to_toml(),
        "cards": list(tables.cards(findings)),
        "scene_tables": tables.scene_tables(scene),
        "static_table": tables.static_table(findings) if rests else None,
        "static_figure": None,
        "coefficient_figure": None,
        "mode_tables": _mode_tables(findings),
        "shapes": (
            [] if isinstance(findings.modes, Missing) else [_shape(mode) for mode in findings.modes]
        ),
        "screening_table": None,
        "screening_figure": None,
        "onset_table": None,
        "criteria_figure": None,
        "still": False,
        "motion_table": None,
        "histories_figure": None,
        "trace_figure": None,
        "animation": None,
        "clearance_table": None,
        "clearance_figure": None,
        "numerics_table": tables.numerics_table(findings),
        "provenance_table": tables.provenance_table(findings),
    }
    if rests:
        filled["static_figure"] = picture(
            "static",
            "Span at rest from the side and from above",
            "The span at rest; dots are the supports.",
            lambda: static_shape(rests),
        )
    if scene.aerodynamics is not None:
        curve, angle = scene.aerodynamics.curve(), np.radians(scene.ice.attack_angle_deg)
        filled["coefficient_figure"] = picture(
            "coefficients",
            "Lift, drag and moment coefficient over the attack angle",
            "Aerodynamic coefficients, referred to the diameter of the bare conductor.",
            lambda: coefficient_figure(curve, float(angle)),
        )
    if isinstance(findings.criteria, list):
        from modal.plots.span_figures import criteria_figure

        criteria, angle = findings.criteria, np.radians(scene.ice.attack_angle_deg)
        filled["criteria_figure"] = picture(
            "criteria",
            "Stability criteria over the attack angle",
            "Criteria of linear theory; dashed: the scene's attack angle.",
            lambda: criteria_figure(criteria, float(angle)),
        )
    if isinstance(findings.onsets, list):
        filled["onset_table"] = tables.onset_table(findings.onsets)
    if isinstance(findings.screening, Screening):
        filled |= _screened(findings.screening)
    if isinstance(result, Result):
        filled |= _simulated(findings, result)
    return filled


def _mode_tables(findings: Findings) -> list[Any]:
    pairs = (
        (findings.modes, "In still air"),
        (findings.modes_in_wind, "About rest in the mean wind"),
    )
    return [
        modes if isinstance(modes, Missing) else tables.mode_table(modes, name)
        for modes, name in pairs
    ]


def _screened(found: Screening) -> dict[str, Any]:
    from modal.plots.span_figures import screening_figure
    from modal.report.plots import picture

    if not (found.limit_cycle or found.saturated):
        return {}
    return {
        "screening_table": tables.screening_table(found),
        "screening_figure": picture(
            "screening",
            "Predicted galloping amplitude and growth of a swing over the wind speed",
            "Vertical galloping without swing over the wind speed, and how a small swing grows"
            " on it.",
            lambda: screening_figure(found),
        ),
    }


def _simulated(findings: Findings, result: Result) -> dict[str, Any]:
    """What a run is shown as; a run that ended with its first record has nothing to draw."""
    from gallop_fmu.plots import histories, trace
    from modal.report.plots import NARROW, clearance_figure, picture, resize

    if result.dataset.sizes["time"] < 2:
        return {}
    if all(
        float(np.abs(result.dataset[name].values).max()) < STILL for name in ("u2", "u3", "theta")
    ):
        return {"still": True}
    frames = animation(result)
    filled: dict[str, Any] = {
        "motion_table": tables.motion_table(result),
        "animation": _stage(frames),
        "histories_figure": picture(
            "histories",
            "Histories of vertical and horizontal displacement, twist and tension at mid-span",
            "Histories at mid-span.",
            lambda: histories(result, ("u2", "u3", "theta", "tension")),
        ),
        "trace_figure": picture(
            "trace",
            "Path of mid-span across the span",
            "Path of mid-span, seen along the span.",
            lambda: resize(trace(result), NARROW, 3.6),
            once=True,
        ),
    }
    ellipses = {
        name: found for name, found in findings.ellipses.items() if not isinstance(found, Missing)
    }
    if ellipses:
        place, places = (0.0, 0.0), {"rest in still air": (0.0, 0.0)}
        if isinstance(findings.still, Statics) and isinstance(findings.blown, Statics):
            _, up, across = (findings.blown.x - findings.still.x)[findings.scene.numerics.elements]
            place = places["rest in the mean wind"] = (float(across), float(up))
        filled["clearance_table"] = tables.clearance_table(findings, result, place)
        filled["clearance_figure"] = picture(
            "clearance",
            "Area that mid-span reached, and the ellipses of CIGRE and Davison",
            "Across the span at its middle, downwind to the right.",
            lambda: clearance_figure(result.midspan(), ellipses, places),
            once=True,
        )
    return filled


def _shape(mode: Mode) -> Shape:
    wave = mode.wave / np.abs(mode.wave).max()
    across, up = np.linspace(-SHAPE_BOX[0], SHAPE_BOX[0], len(wave)), -SHAPE_BOX[1] * wave
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, up, strict=True))
    return Shape(f"{mode.family} {mode.loops}", f"{mode.frequency_hz:.4f} Hz", mode.family, points)


def _stage(frames: Animation) -> dict[str, Any]:
    """The frames, and the boxes that their pictures stand in [m]: x, y, width, height, y downwards."""
    low, high = float(frames.height.min()), float(frames.height.max())
    ends = frames.across.min(), frames.across.max()
    return {
        "part": frames.part,
        "start": float(frames.time[0]),
        "stop": float(frames.time[-1]),
        "low": low,
        "high": high,
        "left": float(ends[0]),
        "right": float(ends[1]),
        "data": json.dumps(frames.packed(), separators=(",", ":")),
    }
