"""All motions over the wind of the span that moves most, taken alone."""

from __future__ import annotations

from collections.abc import Sequence

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.simulation.line_result import LineResult
from modal.motions.branches import Branches, branches


def governing_span(line: LineScene, span: int, tension: float) -> Scene:
    """Return a span of a line alone, between rigid supports.

    Parameters
    ----------
    line
        The line, with single conductors.
    span
        Number of the span, from 1.
    tension
        Its horizontal tension [N] with ice.

    Raises
    ------
    SceneError
        The line has bundles, or the span cannot stand alone.
    """
    if line.bundle.subconductors > 1:
        raise SceneError(
            "all motions over the wind are found for single conductors; this line has bundles"
        )
    data = line.model_dump(mode="json", exclude_none=True)
    own = line.section.spans[span - 1]
    conductor = {k: v for k, v in data["conductor"].items() if k != "thermal_expansion"}
    return Scene.from_dict(
        {
            "title": f"Span {span} alone, between rigid supports",
            "span": {
                "length": own.length,
                "height_difference": own.height_difference,
                "horizontal_tension": tension,
            },
            "conductor": conductor,
            "ice": line.ice_of_span(span).model_dump(mode="json", exclude_none=True),
            "numerics": {
                "elements": line.elements_of_span(span),
                "time_step": line.numerics.time_step,
            },
            **{name: data[name] for name in ("wind", "aerodynamics", "damping") if name in data},
        }
    )


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
