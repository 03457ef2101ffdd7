"""What the commands of ``gallop-modal`` share: a scene, a picture of what was found, and the telling of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    check_output,
    chosen_scene,
    complain_of,
    echo_json,
    new_console,
)

if TYPE_CHECKING:
    from gallop_fmu.scene.scene import Scene

Plot = Annotated[
    Path | None, typer.Option("--plot", metavar="FILE", help="Write a picture: .png, .svg or .pdf.")
]


def scene_to_draw(name: str, changes: list[str] | None, plot: Path | None) -> Scene:
    """The scene with its changes, once it is sure that the picture can be written; its warnings are printed."""
    check_output(plot, PICTURE_SUFFIXES)
    chosen = chosen_scene(name, changes)
    complain_of(chosen, "gallop-modal")
    return chosen


def tell(
    told: dict[str, Any], lines: list[Any], figure: Any, plot: Path | None, as_json: bool
) -> None:
    """Print as JSON or as lines and tables, and draw if asked to."""
    if plot:
        from gallop_fmu.plots import save_figure

        save_figure(figure(), plot)
    if as_json:
        echo_json({**told, "files": [str(plot)] if plot else []})
        return
    for line in lines:
        new_console().print(line, soft_wrap=isinstance(line, str))
    if plot:
        new_console().print(f"wrote {plot}", soft_wrap=True)
