"""Checks of the values of a line against each other, and warnings about unusual combinations."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene


def check_line(scene: LineScene) -> None:
    """Refuse values that contradict each other.

    Raises
    ------
    SceneError
        The message names the span, tower, phase or device by number, the values and a remedy.
    """


def unusual_in_line(scene: LineScene) -> list[str]:
    """Warnings about values that are unusual together, each a fact and a remedy."""
    return []
