"""Whether a span is the same on both sides of mid-span, so that one half of it tells of the other."""

from __future__ import annotations

from collections.abc import Sequence

from gallop_fmu.errors import SceneError
from gallop_fmu.loads import Load
from gallop_fmu.supports import Supports

WHOLE = 'or set numerics.mesh = "whole_span"'


def check_symmetric(elements: int, height_difference: float, supports: Supports, loads: Sequence[Load]) -> None:
    """Raise SceneError unless a span moves symmetrically about mid-span, as ``numerics.mesh = "half_span"`` assumes.

    Wind, ice and seeds are the same on both sides in every scene, so that these four decide.

    Parameters
    ----------
    elements
        Number of elements of the whole span.
    height_difference
        Height of the right support above the left [m].
    supports
        Both ends.
    loads
        Loads on the conductor.
    """
    asks = 'numerics.mesh = "half_span" needs'
    if elements % 2 or elements < 4:
        raise SceneError(
            f"numerics.elements = {elements}: {asks} an even number of 4 or more, half of them on each side; "
            f"choose {max(4, elements + elements % 2)}, {WHOLE}"
        )
    if height_difference != 0.0:
        raise SceneError(
            f"span.height_difference = {height_difference} m: {asks} a level span, 0 m; change it, {WHOLE}"
        )
    left, right = supports.left, supports.right
    for name, support in (("left", left), ("right", right)):
        if support.motion is not None:
            raise SceneError(f"supports.{name}.motion is given: {asks} towers that stand still; remove it, {WHOLE}")
    if left != right:
        raise SceneError(f"supports.left and supports.right differ: {asks} equal ends; make them equal, {WHOLE}")
    for index, load in enumerate(loads):
        if load.force[0] != 0.0:
            raise SceneError(
                f"loads.{index}.force = {list(load.force)} N: {asks} no force along the span (the first); make it 0, "
                f"{WHOLE}"
            )
        if load.position is not None and load.position != 0.5:
            raise SceneError(
                f"loads.{index}.position = {load.position}: {asks} loads at mid-span, position = 0.5, or "
                f"evenly_spaced; change it, {WHOLE}"
            )
