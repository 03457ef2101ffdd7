"""Stability criteria of galloping of each span of a line, with the ice of the span."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from gallop_fmu import LineScene, SceneError
from gallop_fmu.input.scene_like import LineLike, as_line
from modal.linear.line_modes import LineMode, line_modes
from modal.linear.linearise import SmallMotion
from modal.stability.criteria import (
    Criterion,
    SectionMotion,
    coupled_of,
    den_hartog,
    nigol,
    speed_of,
    unfit_for_coupled,
    wind_normal_to_chord,
)

SEARCHED_MODES = 24
"""Modes among which the vertical and the horizontal one of each span are looked for."""


@dataclass(frozen=True)
class SpanCriteria:
    """Criteria of one span of a line.

    Attributes
    ----------
    span : int
        Its number, from 1.
    attack_angle : float
        Initial attack angle of its ice [rad], turned by 180 deg in wind from the other side.
    criteria : list of Criterion
        Den Hartog, Nigol and, for single conductors in wind, coupled.
    unstable : list of str
        Names of the criteria that are unstable at the attack angle.
    remark : str
        Reason why the coupled criterion is missing; empty if it is not.
    """

    span: int
    attack_angle: float
    criteria: list[Criterion] = field(repr=False)
    unstable: list[str]
    remark: str


def line_criteria(scene: LineLike, wind_speed: float | None = None) -> list[SpanCriteria]:
    """Evaluate Den Hartog's, Nigol's and the coupled criterion for each span of a line.

    The first two depend on the curve alone; the span gives the attack angle of its ice. The coupled
    criterion uses the vertical and the horizontal mode of the line in which the mean displacement
    of the span is largest, and the torsional frequency of the conductor between fixed clamps; as on
    one span, it assumes one shape for the three motions. Intervals with their own ice or curve are
    not included, and bundles have no coupled criterion: use `modal.critical_wind_speed`, which
    computes the whole line.

    Parameters
    ----------
    scene
        The line.
    wind_speed
        Wind speed [m/s] of the coupled criterion; None takes the scene's mean, and 0 leaves the
        criterion out.

    Returns
    -------
    list of SpanCriteria
        By span.

    Raises
    ------
    SceneError
        If the scene has no coefficient curve, or the initial equilibrium is unstable.
    SimulationError
        If no initial equilibrium exists.
    """
    scene = as_line(scene, "line_criteria", "use modal.stability_criteria")
    simple = [den_hartog(scene), nigol(scene)]
    sections, remark = _sections(scene, wind_speed)
    speed = scene.wind.mean_speed if wind_speed is None else wind_speed
    across = speed * math.cos(math.radians(scene.wind.mean_direction))
    is_turned = across < 0.0  # from the other side
    found = []
    for span in range(1, len(scene.section.spans) + 1):
        angle = math.radians(scene.ice_of_span(span).attack_angle_deg)
        if is_turned:
            angle = math.remainder(angle + math.pi, 2.0 * math.pi)
        criteria = list(simple)
        if sections:
            criteria.append(coupled_of(sections[span - 1], speed_of(scene, wind_speed)))
        unstable = [
            criterion.name
            for criterion in criteria
            if any(first <= angle <= last for first, last in criterion.unstable)
        ]
        found.append(SpanCriteria(span, angle, criteria, unstable, remark))
    return found


def _sections(scene: LineScene, wind_speed: float | None) -> tuple[list[SectionMotion], str]:
    """The section of each span for the coupled criterion, or the reason why there is none."""
    speed = scene.wind.mean_speed if wind_speed is None else wind_speed
    if speed == 0.0:
        return [], "no coupled criterion: it needs wind; set wind.speed"
    if problem := unfit_for_coupled(scene, wind_speed):
        return [], f"no coupled criterion: {problem}"
    if scene.bundle.subconductors > 1:
        return [], (
            "no coupled criterion of a bundle: its rotation and the twist of each subconductor are"
            " different motions; use critical_wind_speed, which computes the whole line"
        )
    motion = SmallMotion(scene)
    equations = motion.in_still_air()
    count = min(SEARCHED_MODES, int(equations.free.sum()))
    modes = line_modes(equations, motion.mesh, count)
    line, made = motion.model.map, []
    for span, of_span in enumerate(scene.section.spans, start=1):
        ice, conductor = scene.ice_of_span(span), scene.conductor
        nodes = line.chain(span).nodes
        pair = [_main_mode(modes, nodes, axis).frequency_hz for axis in (1, 2)]
        inertia = conductor.torsional_inertia + ice.torsional_inertia
        chord = math.hypot(of_span.length, of_span.height_difference)
        torsional = 0.5 * math.sqrt(conductor.torsional_stiffness / inertia) / chord
        gravity = scene.section.gravity * of_span.length / chord
        element = line.chain(span).first_element
        hertz = (pair[0], pair[1], torsional)
        section = SectionMotion.made(scene, ice, hertz, gravity, motion.mesh, element)
        slope = of_span.height_difference / of_span.length
        made.append(replace(section, wind=wind_normal_to_chord(scene, slope)))
    return made, ""


def _main_mode(modes: list[LineMode], nodes: slice, axis: int) -> LineMode:
    """Mode with the largest mean displacement of a span along x2 (axis 1) or x3 (axis 2)."""
    moved = [abs(float(np.mean(mode.shape[nodes, axis]))) for mode in modes]
    best = modes[int(np.argmax(moved))]
    if max(moved) == 0.0:
        raise SceneError(
            f"no mode among the lowest {len(modes)} moves a span along x{axis + 1}; see"
            " natural_modes(scene, count=...) with a larger count"
        )
    return best
