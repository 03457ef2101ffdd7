"""The commands ``gallop-fmu conductors`` and ``gallop-fmu new``: from line data to a scene file."""

from __future__ import annotations

import inspect
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from gallop_fmu.cli.terminal import (
    AsJson,
    Exit,
    check_output,
    code_words,
    complain,
    echo_json,
    new_console,
    new_table,
    print_warnings,
    real,
)

NEW_EXAMPLE = (
    "gallop-fmu new mine.toml --conductor Drake --span 300 --stringing-percent 20 --ice-thickness"
    " 0.012 --attack-angle-deg 10 --wind-speed 4"
)


def conductors(as_json: AsJson = False) -> None:
    """List the conductors that a scene can name by their code word."""
    from gallop_fmu.line.conductors import conductors as packaged

    found = packaged().values()
    if as_json:
        echo_json([vars(wire) for wire in found])
        return
    table = new_table(
        "code word", "type", "strands", "d [mm]", "mass [kg/m]", "strength [kN]", "EA [MN]"
    )
    for wire in found:
        steel = f"/{wire.steel_wires}" if wire.steel_wires else ""
        table.add_row(
            wire.code_word,
            wire.construction,
            f"{wire.aluminium_wires}{steel}",
            f"{1e3 * wire.diameter:.2f}",
            f"{wire.mass_per_length:.4f}",
            f"{1e-3 * wire.rated_strength:.1f}" if wire.rated_strength else "-",
            f"{1e-6 * wire.axial_stiffness:.2f}",
        )
    new_console().print(table)


class LineCommand(TyperCommand):
    """The command ``new``: adds an option for each field of `Line` and `SectionTable` when used.

    So ``gallop-fmu --help`` does not import the scene.
    """

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the argument FILE, the options of a line, and ``--help``."""
        file, *others = super().get_params(ctx)
        return [file, *line_options(), *others]

    def invoke(self, ctx: Any) -> Any:
        """Run the command with the given values of the line in ``ctx.obj``."""
        values = {option.name: ctx.params.pop(option.name) for option in line_options()}
        ctx.obj = {name: value for name, value in values.items() if value is not None}
        if not {"span", "section"} & ctx.obj.keys():
            raise typer.BadParameter(
                "neither --span nor --section is given; give the length of one span, or a table of"
                " towers and spans",
                ctx=ctx,
            )
        return super().invoke(ctx)


_CHOICES = ("ice_shape", "orientation")
"""Options with a choice of texts."""
_FILES = ("section", "catalogue")
"""Options that name a file."""


@cache
def line_options() -> list[Any]:
    """Options of typer, one for each field of a line or section; None: not given."""
    from gallop_fmu.line.line_table import Line
    from gallop_fmu.line.section_table import SectionTable
    from gallop_fmu.scene.fields import unit_of_field

    def line(**_values: Any) -> None:
        pass

    parameters = []
    for name, field in (*Line.model_fields.items(), *SectionTable.model_fields.items()):
        is_required = field.is_required() and name not in ("span", "section")
        unit, meaning = unit_of_field(field), field.description or ""
        default = "" if field.is_required() or field.default is None else _default(field.default)
        option = typer.Option(
            metavar=_metavar(name, unit),
            parser=real if unit else None,
            help=f"{meaning[0].upper()}{meaning[1:]}{default}.",
            autocompletion=code_words if name == "conductor" else None,
        )
        kind: Any = float if unit else field.annotation if name in _CHOICES else str
        parameters.append(
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=... if is_required else None,
                annotation=Annotated[kind if is_required else kind | None, option],
            )
        )
    line.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    app = typer.Typer(add_completion=False)
    app.command(add_help_option=False)(line)
    return list(typer.main.get_command(app).params)


def _metavar(name: str, unit: str) -> str:
    """Return the name of the value of an option: its unit, or its kind."""
    if unit:
        return "NUMBER" if unit == "1" else {"degC": "C"}.get(unit, unit).upper()
    return "WORD" if name in _CHOICES else "FILE" if name in _FILES else "TEXT"


def _default(value: Any) -> str:
    return f" (default: {value:g})" if isinstance(value, float) else f" (default: {value})"


def new(
    context: typer.Context,
    out: Annotated[Path, typer.Argument(metavar="FILE", help="Scene file to write (.toml).")],
) -> None:
    """Write a scene from line data, every value with its unit, meaning and source.

    With --span a scene of one span, with --section a section of several spans.
    """
    from gallop_fmu.foundation.atomic_write import write_whole
    from gallop_fmu.input.annotated_toml import annotated_toml
    from gallop_fmu.line.section_table import SectionTable, section_data
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene

    check_output(out, (".toml",))
    if out.exists():
        complain(f"{out}: exists already; choose another name, or remove it first")
        raise typer.Exit(Exit.BAD_INPUT)
    scene: Scene | LineScene
    if "section" in context.obj:
        scene = LineScene.from_dict(section_data(context.obj, Path()))
    elif of_section := [name for name in context.obj if name in SectionTable.model_fields]:
        option = of_section[0].replace("_", "-")
        complain(f"--{option}: only a section has it; give --section with a table of towers, too")
        raise typer.Exit(Exit.BAD_INPUT)
    else:
        scene = Scene.from_dict({"line": context.obj})
    write_whole(out, annotated_toml(scene).encode())
    new_console().print(f"wrote {out}; to simulate it: gallop-fmu run {out}", soft_wrap=True)
    print_warnings(scene.warnings)
