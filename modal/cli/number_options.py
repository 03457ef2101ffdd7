"""Options of commands that vary a number of a scene, and their values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gallop_fmu.cli.sweep_options import range_of, values_of
from gallop_fmu.cli.terminal import whole

if TYPE_CHECKING:
    from gallop_fmu.scene.scene import Scene

RANGE = "KEY[=FIRST:LAST]"

OverNumber = Annotated[
    str | None,
    typer.Option(
        "--over",
        metavar=RANGE,
        help="Track the modes over this number (default range: 0.7 to 1.3 times its value).",
    ),
]
Points = Annotated[
    int, typer.Option("--points", metavar="N", parser=whole(2, 10000), help="Number of values.")
]


def only_for_spans(options: dict[str, str | None]) -> None:
    """Refuse options that a line does not have."""
    from gallop_fmu.foundation.errors import SceneError

    given = [name for name, value in options.items() if value is not None]
    if given:
        raise SceneError(
            f"{given[0]} is for scenes of one span, and this one is a line; leave it out, and"
            " change values of the line with --set"
        )


def varied_values(scene: Scene, option: str, points: int) -> tuple[str, list[float]]:
    """Path and values of an option such as ``--over``; by default values around the present one."""
    import numpy as np

    from modal.foundation.scene_variation import number_of

    path, equals, text = (part.strip() for part in option.partition("="))
    if not equals:
        now = number_of(scene, path)
        return path, np.linspace(0.7 * now, 1.3 * now, points).tolist()
    if text.count(":") != 1:
        return path, _numbers(path, text)
    first, last = range_of(path, text, ("FIRST", "LAST"), "span.sag=1.5:3")
    return path, np.linspace(first, last, points).tolist()


def _numbers(path: str, text: str) -> list[float]:
    """Numbers of a list such as ``2,2.5,3``."""
    from gallop_fmu.foundation.errors import SceneError

    values = values_of(path, text)
    wrong = [
        value for value in values if isinstance(value, bool) or not isinstance(value, (int, float))
    ]
    if wrong:
        raise SceneError(f"--over {path}={text}: {wrong[0]!r} is not a number")
    return [float(value) for value in values]
