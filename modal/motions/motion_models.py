"""Reduced models of spans and lines, and the scenes that have one."""

from __future__ import annotations

from gallop_fmu import LineScene, Scene, SceneError
from modal.foundation.normal_wind import check_wind_is_normal
from modal.linear.mode_basis import still_air_modes
from modal.motions.line_basis import line_basis
from modal.motions.line_model import LineModel
from modal.motions.span_model import SpanModel


def motion_model(scene: Scene | LineScene) -> SpanModel:
    """Reduce a span or a line to its lowest modes."""
    if isinstance(scene, LineScene):
        return LineModel(scene)
    return SpanModel(scene, still_air_modes(scene))


def similar_model(scene: Scene | LineScene, like: SpanModel) -> SpanModel:
    """Reduce a scene like another one, so that coordinates mean the same."""
    if isinstance(scene, LineScene):
        assert isinstance(like, LineModel)
        return LineModel(scene, line_basis(scene, like.basis), like)
    return SpanModel(scene, still_air_modes(scene, like.elements), like)


def check_scene(scene: Scene | LineScene, wind: float) -> None:
    """Refuse a scene whose motions cannot be found in a steady wind [m/s].

    Raises
    ------
    SceneError
        It has no coefficient curve, its wind is not uniform or not normal to the line, a span has
        its own wind, or ice falls.
    """
    if scene.aerodynamics is None:
        raise SceneError(
            "aerodynamics is not given: without a coefficient curve the wind has no effect; give"
            " one"
        )
    check_wind_is_normal(scene, "branches", wind)
    if not isinstance(scene, LineScene):
        return
    for number, span in enumerate(scene.section.spans):
        if span.wind is not None:
            raise SceneError(
                f"section.spans.{number}.wind is given, and branches take the same wind in all"
                " spans; remove it, or simulate the line"
            )
    if scene.shedding:
        raise SceneError(
            "shedding is given, and periodic motions keep their ice; remove it, or simulate the"
            " line"
        )
