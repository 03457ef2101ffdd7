"""The commands ``gallop-fmu conductors`` and ``gallop-fmu new``: from a line's familiar numbers to a scene file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

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
    " 0.012 --attack-angle-deg 180 --wind-speed 4 --coefficients example3"
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
        table.add_row(
            wire.code_word,
            wire.construction,
            (
                f"{wire.aluminium_wires}/{wire.steel_wires}"
                if wire.steel_wires
                else f"{wire.aluminium_wires}"
            ),
            f"{1e3 * wire.diameter:.2f}",
            f"{wire.mass_per_length:.4f}",
            f"{1e-3 * wire.rated_strength:.1f}" if wire.rated_strength else "-",
            f"{1e-6 * wire.axial_stiffness:.2f}",
        )
    new_console().print(table)


def new(
    context: typer.Context,
    out: Annotated[Path, typer.Argument(metavar="FILE", help="Scene file to write (.toml).")],
    conductor: Annotated[
        str,
        typer.Option(
            metavar="WORD",
            autocompletion=code_words,
            help="Code word; gallop-fmu conductors lists them.",
        ),
    ],
    span: Annotated[
        float,
        typer.Option(metavar="M", parser=real, help="Horizontal distance between the supports."),
    ],
    height_difference: Annotated[
        float | None,
        typer.Option(metavar="M", parser=real, help="Right support above the left; else level."),
    ] = None,
    ruling_span: Annotated[
        float | None, typer.Option(metavar="M", parser=real, help="Ruling span; else the span.")
    ] = None,
    stringing_tension: Annotated[
        float | None,
        typer.Option(
            metavar="N", parser=real, help="Horizontal tension of the bare conductor when strung."
        ),
    ] = None,
    stringing_percent: Annotated[
        float | None,
        typer.Option(metavar="%", parser=real, help="The same in percent of the rated strength."),
    ] = None,
    stringing_temperature: Annotated[
        float | None,
        typer.Option(metavar="C", parser=real, help="Temperature when strung; else 15."),
    ] = None,
    temperature: Annotated[
        float | None,
        typer.Option(
            metavar="C", parser=real, help="Temperature of iced conductor and air; else 0."
        ),
    ] = None,
    ice_shape: Annotated[
        Literal["radial", "crescent", "eccentric_circle", "d_shape"] | None,
        typer.Option(help="Shape of the ice; else crescent."),
    ] = None,
    ice_thickness: Annotated[
        float | None,
        typer.Option(metavar="M", parser=real, help="Greatest thickness of the ice; else bare."),
    ] = None,
    ice_density: Annotated[
        float | None,
        typer.Option(metavar="KG/M3", parser=real, help="Density of the ice; else 900, glaze."),
    ] = None,
    attack_angle_deg: Annotated[
        float | None,
        typer.Option(
            metavar="DEG", parser=real, help="Attack angle, 0: wind onto the thickest ice."
        ),
    ] = None,
    wind_speed: Annotated[
        float | None,
        typer.Option(metavar="M/S", parser=real, help="Constant wind speed; else calm."),
    ] = None,
    coefficients: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Coefficient curve: a CSV file, or a packaged scene."),
    ] = None,
    insulator_length: Annotated[
        float | None,
        typer.Option(
            metavar="M", parser=real, help="Length of suspension strings; else dead ends."
        ),
    ] = None,
    insulator_weight: Annotated[
        float | None, typer.Option(metavar="N", parser=real, help="Weight of one string.")
    ] = None,
    adjacent_span: Annotated[
        float | None,
        typer.Option(
            metavar="M", parser=real, help="Spans beyond the strings; else the ruling span."
        ),
    ] = None,
    damping_percent: Annotated[
        float | None,
        typer.Option(metavar="%", parser=real, help="Damping ratio of translations; else 0.5."),
    ] = None,
    twist_damping_percent: Annotated[
        float | None, typer.Option(metavar="%", parser=real, help="Damping ratio of twist; else 4.")
    ] = None,
) -> None:
    """Write a scene from a line's familiar numbers, every value with unit, meaning and source."""
    from gallop_fmu.foundation.atomic_write import write_whole
    from gallop_fmu.input.annotated_toml import annotated_toml
    from gallop_fmu.scene.scene import Scene

    check_output(out, (".toml",))
    if out.exists():
        complain(f"{out}: exists already; choose another name, or remove it first")
        raise typer.Exit(Exit.BAD_INPUT)
    line = {
        name: value for name, value in context.params.items() if name != "out" and value is not None
    }
    scene = Scene.from_dict({"line": line})
    write_whole(out, annotated_toml(scene).encode())
    new_console().print(f"wrote {out}; gallop-fmu run {out} computes it", soft_wrap=True)
    print_warnings(scene.warnings)
