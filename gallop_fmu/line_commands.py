"""The commands ``gallop-fmu conductors`` and ``gallop-fmu new``: from a line's familiar numbers to a scene file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gallop_fmu.terminal import AsJson, Exit, check_output, complain, echo_json, new_console, new_table

NEW_EXAMPLE = (
    "gallop-fmu new mine.toml --conductor Drake --span 300 --percent 20 --ice 0.012 --attack-angle 180 --wind 6 "
    "--coefficients example3"
)


def conductors(as_json: AsJson = False) -> None:
    """List the conductors that a scene can name by their code word."""
    from gallop_fmu.conductors import conductors as packaged

    found = packaged().values()
    if as_json:
        echo_json([vars(wire) for wire in found])
        return
    table = new_table("code word", "type", "strands", "diameter [mm]", "mass [kg/m]", "rated strength [kN]", "EA [MN]")
    for wire in found:
        table.add_row(
            wire.code_word,
            wire.construction,
            f"{wire.aluminium_wires}/{wire.steel_wires}" if wire.steel_wires else f"{wire.aluminium_wires}",
            f"{1e3 * wire.diameter:.2f}",
            f"{wire.mass_per_length:.4f}",
            f"{1e-3 * wire.rated_strength:.1f}" if wire.rated_strength else "-",
            f"{1e-6 * wire.axial_stiffness:.2f}",
        )
    new_console().print(table)


def new(
    out: Annotated[Path, typer.Argument(metavar="FILE", help="Scene file to write (.toml).")],
    conductor: Annotated[str, typer.Option(metavar="WORD", help="Code word; gallop-fmu conductors lists them.")],
    span: Annotated[float, typer.Option(metavar="M", help="Horizontal distance between the supports \\[m].")],
    height_difference: Annotated[float, typer.Option(metavar="M", help="Right support above the left \\[m].")] = 0.0,
    ruling_span: Annotated[float | None, typer.Option(metavar="M", help="Ruling span \\[m]; else the span.")] = None,
    tension: Annotated[
        float | None, typer.Option(metavar="N", help="Stringing tension, bare conductor, horizontal \\[N].")
    ] = None,
    percent: Annotated[
        float | None, typer.Option(metavar="%", help="Stringing tension in percent of the rated strength.")
    ] = None,
    stringing_temperature: Annotated[float, typer.Option(metavar="C", help="Temperature when strung.")] = 15.0,
    temperature: Annotated[float, typer.Option(metavar="C", help="Temperature of the iced conductor.")] = 0.0,
    ice: Annotated[float, typer.Option(metavar="M", help="Greatest thickness of the ice \\[m].")] = 0.0,
    ice_shape: Annotated[
        Literal["radial", "crescent", "eccentric_circle", "d_shape"], typer.Option(help="Shape of the ice.")
    ] = "crescent",
    ice_density: Annotated[float, typer.Option(metavar="KG/M3", help="Density of the ice.")] = 900.0,
    attack_angle: Annotated[float, typer.Option(metavar="DEG", help="Attack angle of the wind on the ice.")] = 0.0,
    wind: Annotated[float | None, typer.Option(metavar="M/S", help="Wind speed \\[m/s].")] = None,
    coefficients: Annotated[
        str | None, typer.Option(metavar="NAME", help="Coefficient curve: a CSV file, or a packaged scene.")
    ] = None,
    insulator_length: Annotated[
        float | None, typer.Option(metavar="M", help="Length of suspension strings \\[m]; else dead ends.")
    ] = None,
    insulator_weight: Annotated[float | None, typer.Option(metavar="N", help="Weight of one string \\[N].")] = None,
    adjacent_span: Annotated[
        float | None, typer.Option(metavar="M", help="Spans beyond the strings \\[m]; else the ruling span.")
    ] = None,
) -> None:
    """Write a scene from a line's familiar numbers, every value with unit, meaning and source."""
    from gallop_fmu.annotated import annotated_toml
    from gallop_fmu.scene import Scene

    check_output(out, (".toml",))
    if out.exists():
        complain(f"{out}: exists already; choose another name, or remove it first")
        raise typer.Exit(Exit.BAD_INPUT)
    line = {
        "conductor": conductor,
        "span": span,
        "height_difference": height_difference,
        "ruling_span": ruling_span,
        "stringing_tension": tension,
        "stringing_percent": percent,
        "stringing_temperature": stringing_temperature,
        "temperature": temperature,
        "ice_thickness": ice,
        "ice_shape": ice_shape,
        "ice_density": ice_density,
        "attack_angle_deg": attack_angle,
        "wind_speed": wind,
        "coefficients": coefficients,
        "insulator_length": insulator_length,
        "insulator_weight": insulator_weight,
        "adjacent_span": adjacent_span,
    }
    scene = Scene.from_dict({"line": {key: value for key, value in line.items() if value is not None}})
    out.write_text(annotated_toml(scene), encoding="utf-8", newline="\n")
    new_console().print(f"wrote {out}; gallop-fmu run {out} computes it", soft_wrap=True)
