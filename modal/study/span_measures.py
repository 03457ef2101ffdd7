"""Measures against galloping of one span.

A measure that changes a number of the scene stays a span, which the screening can judge. Devices
make it a line of one span: they are those of `modal.study.measures`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gallop_fmu import LineScene, Model, Scene, SceneError, SimulationError
from modal.foundation.scene_variation import ICE_MASS, number_of, varied
from modal.study.measures import Measure, dampers, pendulums

TENSION_STEPS = (0.1, 0.2, -0.1, -0.2)
"""Relative changes of the tension."""

MORE_DAMPING = 0.5
"""Relative increase of the structural damping ratios of translation."""

ADDED_MASS = 0.1
"""Mass that is spread along the span, relative to the conductor's."""

TENSION, DAMPING = "span.horizontal_tension", "damping.translation"


@dataclass(frozen=True)
class SpanMeasure:
    """A change of the span.

    Attributes
    ----------
    name : str
        What to do, as an imperative.
    detail : str
        Values, and what they assume.
    scene : Scene, LineScene or None
        The changed span; None if the span cannot have it.
    path : str
        Number that is changed by `change`, so that a derivative predicts the effect; may be empty.
    change : float
        Its change.
    reason : str
        Why the span cannot have it; empty otherwise.
    """

    name: str
    detail: str
    scene: Scene | LineScene | None
    path: str = ""
    change: float = 0.0
    reason: str = ""


def measures_of_span(scene: Scene, frequency_hz: float) -> list[SpanMeasure]:
    """Return all measures for a span.

    Parameters
    ----------
    scene
        The span.
    frequency_hz
        Frequency of galloping [Hz], to which a damper is tuned; NaN if the span does not gallop.
    """
    found = [_tension(scene, step) for step in TENSION_STEPS]
    found += [_damping(scene), _mass(scene), _split(scene)]
    try:
        line = line_of_span(scene)
    except SceneError as problem:
        return [
            *found,
            SpanMeasure("Hang a pendulum or a tuned damper", "", None, reason=str(problem)),
        ]
    devices = (pendulums(line), dampers(line, np.array([frequency_hz])))
    return [*found, *(_of_line(measure) for measure in devices)]


def _of_line(measure: Measure) -> SpanMeasure:
    return SpanMeasure(measure.name, measure.detail, measure.scene, reason=measure.reason)


def _made(
    name: str, detail: str, path: str, change: float, made: Callable[[], Scene]
) -> SpanMeasure:
    """Return a measure, or the reason why the span cannot have it."""
    try:
        return SpanMeasure(name, detail, made(), path, change)
    except (SceneError, SimulationError) as problem:
        return SpanMeasure(name, detail, None, path, change, str(problem))


def _tension(scene: Scene, step: float) -> SpanMeasure:
    """Change the tension at constant mass."""
    before = number_of(scene, TENSION)
    change = step * before
    way = "Raise" if step > 0.0 else "Lower"
    return _made(
        f"{way} the tension by {abs(step):.0%}",
        f"{(before + change) / 1e3:.2f} kN with the ice; "
        + ("check aeolian vibration" if step > 0.0 else "check the ground clearance"),
        TENSION,
        change,
        lambda: varied(scene, TENSION, before + change),
    )


def _damping(scene: Scene) -> SpanMeasure:
    """Raise the damping ratios."""
    return _made(
        f"Raise the damping of vertical and horizontal motion by {MORE_DAMPING:.0%}",
        "as dampers along the span would; which ones do so at galloping frequencies must be shown",
        DAMPING,
        MORE_DAMPING,
        lambda: varied(scene, DAMPING, 1.0 + MORE_DAMPING),
    )


def _mass(scene: Scene) -> SpanMeasure:
    """Hang mass on the strung conductor."""
    added = ADDED_MASS * scene.conductor.mass_per_length
    return _made(
        f"Spread weights of {ADDED_MASS:.0%} of the conductor's mass along the span",
        f"{added:.3g} kg/m on the strung conductor, whose tension and sag grow",
        ICE_MASS,
        added,
        lambda: varied(scene, ICE_MASS, scene.ice.mass_per_length + added),
    )


def _split(scene: Scene) -> SpanMeasure:
    """Place a tower in the middle."""
    half = 0.5 * scene.span.length
    return _made(
        "Split the span by a tower in its middle",
        f"two spans of {half:g} m with the same tension and the ends of the old one; here one of"
        " them alone",
        "",
        0.0,
        lambda: scene.with_values(
            {
                "span.length": half,
                "span.height_difference": 0.5 * scene.span.height_difference,
                "span.sag": None,
                "span.horizontal_tension": number_of(scene, TENSION),
            }
        ),
    )


def line_of_span(scene: Scene) -> LineScene:
    """Write a span as a line of one span, in the state with its ice.

    Raises
    ------
    SceneError
        The span has what a line of one span cannot have.
    """
    data = scene.model_dump(mode="json", exclude_none=True)
    ends = {end: data["supports"].get(end, {"kind": "rigid"}) for end in ("left", "right")}
    for end, support in ends.items():
        if support["kind"] not in ("rigid", "springs"):
            raise SceneError(
                f"supports.{end}.kind = {support['kind']!r}: devices need a line, whose ends are"
                " rigid or springs"
            )
    if data.get("loads") or data.get("shedding"):
        raise SceneError("loads or shedding are given: remove them")
    span = data["span"]
    section = {
        "horizontal_tension": Model(scene).equilibrium().horizontal_tension,
        "strung_with_ice": True,
        "gravity": span["gravity"],
        "spans": [{key: span[key] for key in ("length", "height_difference") if key in span}],
        "left_end": ends["left"],
        "right_end": ends["right"],
    }
    kept = ("conductor", "ice", "wind", "aerodynamics", "damping", "initial", "numerics", "run")
    return LineScene.from_dict(
        {"title": scene.title, "section": section} | {key: data[key] for key in kept if key in data}
    )
