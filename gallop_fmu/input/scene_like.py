"""Scenes as functions take them: an object, the name of a packaged scene, or a path."""

from __future__ import annotations

import os
from typing import overload

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.line_scene import ONE_SPAN_INSTEAD, LineScene, one_span
from gallop_fmu.scene.scene import Scene

SceneName = str | os.PathLike[str]
"""Name of a packaged scene, or path of a scene file."""

SpanLike = Scene | SceneName
LineLike = LineScene | SceneName
SceneLike = Scene | LineScene | SceneName
"""A scene of one span, of a line, or of either kind, or what names one."""


@overload
def as_scene(scene: Scene) -> Scene: ...


@overload
def as_scene(scene: LineScene) -> LineScene: ...


@overload
def as_scene(scene: SceneLike) -> Scene | LineScene: ...


def as_scene(scene: SceneLike) -> Scene | LineScene:
    """Return a scene as it is, or read it by its name or path.

    Raises
    ------
    SceneError
        The name is unknown (the message lists the packaged scenes), or the file is unreadable or
        invalid.
    TypeError
        It is of another type.
    """
    if isinstance(scene, Scene | LineScene):
        return scene
    if isinstance(scene, str | os.PathLike):
        return load_scene(os.fspath(scene))
    raise TypeError(
        "scene must be a Scene, a LineScene, the name of a packaged scene or the path of a scene"
        f" file, not {scene!r:.60}"
    )


def as_span(scene: SceneLike, purpose: str, instead: str = ONE_SPAN_INSTEAD) -> Scene:
    """Return a scene of one span as `as_scene`; refuse a line as `one_span`."""
    return one_span(as_scene(scene), purpose, instead)


def as_line(scene: SceneLike, purpose: str, instead: str) -> LineScene:
    """Return the scene of a line as `as_scene`; refuse one of a single span.

    Parameters
    ----------
    scene
        The scene.
    purpose
        What needs a line, as the subject of the message.
    instead
        What to do instead, as an imperative.

    Raises
    ------
    SceneError
        The scene is one of a single span.
    """
    found = as_scene(scene)
    if isinstance(found, LineScene):
        return found
    raise SceneError(f"{purpose} takes a line ([section]), and this scene is one span; {instead}")
