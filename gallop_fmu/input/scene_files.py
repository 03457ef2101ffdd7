"""Scene files: packaged ones by name, others by path."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import packaged_names, packaged_text, parse_toml, read_text
from gallop_fmu.scene.file_format import without_format
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene


def packaged_scenes() -> dict[str, str]:
    """Return the names of the packaged scenes and their titles."""
    return {name: str(tomllib.loads(text)["title"]) for name, text in _packaged().items()}


def load_scene(name_or_path: str | Path) -> Scene | LineScene:
    """Read a scene: a `LineScene` if the file has a table ``section``, otherwise a `Scene`.

    Parameters
    ----------
    name_or_path
        Name of a packaged scene (see `packaged_scenes`), or path of a TOML file.

    Raises
    ------
    SceneError
        The name is unknown, the file unreadable or not a scene, or the content invalid; the message
        names all problems.
    """
    return scene_of_file(*read_scene_file(name_or_path))


def read_scene_file(name_or_path: str | Path) -> tuple[dict[str, Any], Path, str]:
    """Read a scene file; return its content, its folder, and its name for messages.

    Raises
    ------
    SceneError
        The name is unknown, or the file is unreadable or not a scene. Values are not checked.
    """
    packaged = _packaged()
    if str(name_or_path) in packaged:
        return _parse(packaged[str(name_or_path)], str(name_or_path)), Path("."), str(name_or_path)
    path = Path(name_or_path)
    if not path.suffix and len(path.parts) == 1 and not path.exists():
        closest = difflib.get_close_matches(str(path), packaged, n=1, cutoff=0.0)
        raise SceneError(
            f"{path}: no packaged scene and no file has this name; packaged are"
            f" {', '.join(packaged)}; closest: {closest[0]}"
        )
    return _parse(read_text(path), str(path)), path.parent, str(path)


def scene_of_file(data: Mapping[str, Any], folder: Path, name: str) -> Scene | LineScene:
    """Return the scene of a file's content; messages begin with the name, if it is not empty.

    Raises
    ------
    SceneError
        The content is invalid; the message names all problems.
    """
    try:
        return (LineScene if "section" in data else Scene).from_dict(data, folder)
    except SceneError as problem:
        if not name:
            raise
        lines = str(problem).splitlines()
        raise SceneError(
            f"{name}: {lines[0]}" if len(lines) == 1 else "\n  ".join([f"{name}:", *lines])
        ) from None


def _packaged() -> dict[str, str]:
    return {
        name: packaged_text("scene/packaged", f"{name}.toml")
        for name in packaged_names("scene/packaged", ".toml")
    }


def _parse(text: str, name: str) -> dict[str, Any]:
    try:
        data = dict(without_format(parse_toml(text)))
    except SceneError as problem:
        raise SceneError(f"{name}: {problem}") from None
    if not {"line", "span", "section", "conductor"} & data.keys():
        raise SceneError(
            f"{name}: not a scene file, as it has none of [line], [span], [section] and"
            " [conductor]; see"
            " gallop-fmu new"
        )
    return data
