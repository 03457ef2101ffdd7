"""Scenes from files: the packaged ones by name, others by path."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import packaged_names, packaged_text, parse_toml, read_text
from gallop_fmu.scene.scene import Scene


def packaged_scenes() -> dict[str, str]:
    """Names of the scenes that come with the package, with their titles."""
    return {name: str(tomllib.loads(text)["title"]) for name, text in _packaged().items()}


def load_scene(name_or_path: str | Path) -> Scene:
    """Read a scene.

    Parameters
    ----------
    name_or_path
        Name of a packaged scene (see `packaged_scenes`), else the path of a TOML file.

    Raises
    ------
    SceneError
        Unknown name, unreadable or foreign file, or invalid content; the message names all
        problems.
    """
    return scene_of_file(*read_scene_file(name_or_path))


def read_scene_file(name_or_path: str | Path) -> tuple[dict[str, Any], Path, str]:
    """Content of the file of a scene as `load_scene` finds it, its folder, and what errors call it.

    Raises
    ------
    SceneError
        Unknown name, unreadable or foreign file; what the file holds is not looked at.
    """
    packaged = _packaged()
    if str(name_or_path) in packaged:
        return _parse(packaged[str(name_or_path)], str(name_or_path)), Path("."), str(name_or_path)
    path = Path(name_or_path)
    if not path.suffix and len(path.parts) == 1 and not path.exists():
        closest = difflib.get_close_matches(str(path), packaged, n=1, cutoff=0.0)
        raise SceneError(
            f"{path}: no packaged scene has this name (there are {', '.join(packaged)}) and there"
            f" is no such file; closest: {closest[0]}"
        )
    return _parse(read_text(path), str(path)), path.parent, str(path)


def scene_of_file(data: Mapping[str, Any], folder: Path, name: str) -> Scene:
    """The scene that the content of a file describes; errors begin with the name of the file, if it has one.

    Raises
    ------
    SceneError
        Invalid content; the message names all problems.
    """
    try:
        return Scene.from_dict(data, folder)
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
        data = parse_toml(text)
    except SceneError as problem:
        raise SceneError(f"{name}: {problem}") from None
    if not {"line", "span", "conductor"} & data.keys():
        raise SceneError(
            f"{name}: not a scene file; it has neither [line] nor [span] nor [conductor]"
        )
    return data
