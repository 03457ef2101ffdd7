"""All motions over the wind of the span that moves most, taken alone."""

from __future__ import annotations

from collections.abc import Sequence

from gallop_fmu import LineScene, Scene
from gallop_fmu.simulation.line_result import LineResult
from modal.motions.branches import Branches, branches


def governing_span(line: LineScene, span: int, tension: float) -> Scene | LineScene:
    """Return a span of a line alone, between rigid supports.

    Parameters
    ----------
    line
        The line.
    span
        Number of the span, from 1.
    tension
        Its horizontal tension [N] with ice, of one subconductor.

    Returns
    -------
    Scene or LineScene
        Of a single conductor a scene of one span; of a bundle a line of one span, with its spacers.

    Raises
    ------
    SceneError
        The span cannot stand alone.
    """
    data = line.model_dump(mode="json", exclude_none=True)
    own = line.section.spans[span - 1]
    ice = line.ice_of_span(span).model_dump(mode="json", exclude_none=True)
    place = {"length": own.length, "height_difference": own.height_difference}
    shared = ("wind", "aerodynamics", "damping")
    content = {
        "title": f"Span {span} alone, between rigid supports",
        "conductor": {k: v for k, v in data["conductor"].items() if k != "thermal_expansion"},
        "ice": ice,
        "numerics": {
            "elements": line.elements_of_span(span),
            "time_step": line.numerics.time_step,
        },
        **{name: data[name] for name in shared if name in data},
    }
    strung = {"horizontal_tension": tension, "gravity": line.section.gravity}
    if line.bundle.subconductors == 1:
        return Scene.from_dict({**content, "span": {**place, **strung}})
    section = {**strung, "strung_with_ice": True, "spans": [place]}
    return LineScene.from_dict({**content, "section": section, "bundle": data["bundle"]})


def branches_of_span(result: LineResult, span: int, winds: Sequence[float]) -> Branches:
    """Find all motions of a span alone over the winds of a study.

    Parameters
    ----------
    result
        A run of the line, which has the tension of the span.
    span
        Number of the span, from 1.
    winds
        Wind speeds [m/s] of the study.

    Raises
    ------
    SceneError
        As for `governing_span` and `modal.branches`.
    """
    tension = result.spans.set_index("span").horizontal_tension[[span]].iloc[0]
    scene = governing_span(result.scene, span, float(tension))
    low, high = min(map(abs, winds)), max(map(abs, winds))
    return branches(scene, start=low if low < high else 0.5 * high, stop=high)
