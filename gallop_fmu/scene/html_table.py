"""The values of a scene as a table in HTML, for notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

from gallop_fmu.scene.dotted_paths import leaves

if TYPE_CHECKING:
    from gallop_fmu.scene.scene_base import SceneBase

ABOUT = ("title", "description", "notes", "sources")
"""Fields that are not rows of the table."""

SHOWN_NUMBERS = 4
"""Numbers of an array that are shown."""


def scene_table(scene: SceneBase) -> str:
    """Return the values that differ from none, with units and sources, as HTML.

    Parameters
    ----------
    scene
        The scene. Its texts are escaped.
    """
    sources = scene.sources
    rows = [
        (leaf.path, _text(leaf.value), "" if leaf.unit == "1" else leaf.unit)
        for leaf in leaves(scene)
        if leaf.value is not None and leaf.path not in ABOUT
    ]
    body = "".join(
        f"<tr><td>{escape(path)}</td><td style='text-align:right'>{escape(value)}</td>"
        f"<td>{escape(unit)}</td><td style='text-align:left'>{escape(_source(path, sources))}</td>"
        "</tr>"
        for path, value, unit in rows
    )
    return (
        f"<b>{escape(scene.title)}</b>"
        f"<details><summary>{escape(scene._key_figures())}; {len(rows)} values</summary>"
        "<table><thead><tr><th>value</th><th></th><th>unit</th><th>source</th></tr></thead>"
        f"<tbody>{body}</tbody></table></details>"
    )


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, tuple) and len(value) > SHOWN_NUMBERS:
        return f"{', '.join(_text(item) for item in value[:SHOWN_NUMBERS])}, ... ({len(value)})"
    if isinstance(value, tuple):
        return ", ".join(_text(item) for item in value)
    return str(value)


def _source(path: str, sources: Mapping[str, str]) -> str:
    """Source of a value: its own, or that of the closest section."""
    parts = path.split(".")
    for length in range(len(parts), 0, -1):
        source = sources.get(".".join(parts[:length]))
        if source is not None:
            return source
    return ""
