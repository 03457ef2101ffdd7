"""Names of commands of ``gallop-modal`` that users look for in ``gallop-fmu``."""

from __future__ import annotations

from shlex import join
from typing import Annotated

import typer

from gallop_fmu.cli.terminal import Exit, complain

MODAL_COMMANDS = {
    "report": "report is now a command of gallop-modal",
    "study": "study is a command of gallop-modal",
}
"""Command to the fact; ``report`` was a command of ``gallop-fmu`` in 0.1.0."""


def add_modal_commands(app: typer.Typer) -> None:
    """Add hidden commands that print the command to run instead."""
    settings = {"ignore_unknown_options": True, "help_option_names": []}
    for name in MODAL_COMMANDS:
        app.command(name=name, hidden=True, context_settings=settings)(_point)


def _point(
    context: typer.Context, words: Annotated[list[str] | None, typer.Argument()] = None
) -> None:
    """Print the command of ``gallop-modal``."""
    name = context.info_name or ""
    complain(f"{MODAL_COMMANDS[name]}; run {join(['gallop-modal', name, *(words or ())])}")
    raise typer.Exit(Exit.BAD_INPUT)
