"""Shared CLI helpers: scene argument, picture, output."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    check_output,
    chosen_spec,
    complain_of,
    echo_json,
    new_console,
)

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene

Plot = Annotated[
    Path | None, typer.Option("--plot", metavar="FILE", help="Write a picture: .png, .svg or .pdf.")
]


def line_or_span_to_draw(
    name: str, changes: list[str] | None, plot: Path | None
) -> Scene | LineScene:
    """Load the scene of a command, check that its picture can be written, and print warnings."""
    check_output(plot, PICTURE_SUFFIXES)
    chosen = chosen_spec(name, changes).scene()
    complain_of(chosen, "gallop-modal")
    return chosen


def show(
    content: dict[str, Any],
    lines: list[Any],
    figure: Callable[[], Any],
    plot: Path | None,
    as_json: bool,
) -> None:
    """Print the output of a command and write its picture.

    Parameters
    ----------
    content
        Output as JSON.
    lines
        Output for people: lines and tables.
    figure
        Function that draws the picture.
    plot
        File of the picture; None draws nothing.
    as_json
        True prints JSON.
    """
    if plot:
        from gallop_fmu.plots import save_figure

        save_figure(figure(), plot)
    if as_json:
        echo_json({**content, "files": [str(plot)] if plot else []})
        return
    for line in lines:
        new_console().print(line, soft_wrap=isinstance(line, str))
    if plot:
        new_console().print(f"wrote {plot}", soft_wrap=True)
