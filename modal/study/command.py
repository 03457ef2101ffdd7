"""The command ``gallop-modal study``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.sweep_options import values_of
from gallop_fmu.cli.terminal import (
    Changes,
    Exit,
    SceneName,
    Until,
    check_output,
    chosen_spec,
    complain,
    complain_of,
    new_console,
    real,
    whole,
)
from modal.report.command import shown_parts

if TYPE_CHECKING:
    from modal.study.study import LineStudy

STUDY_EXAMPLE = (
    "gallop-modal study line.toml --wind 4:12:2 --angle -20:20:10 --ice 10,15,20 -o study.html"
)

VALUES = "VALUES"


def study(  # noqa: PLR0913 - typer takes a parameter for each option
    scene: SceneName,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE", help="File to write (.html).")
    ],
    wind: Annotated[
        str,
        typer.Option(
            metavar=VALUES, help="Wind speeds in m/s: 4,8,12 or FIRST:LAST:STEP (4:12:2)."
        ),
    ] = "4:12:2",
    angle: Annotated[
        str | None,
        typer.Option(metavar=VALUES, help="Attack angles in deg (default: that of the scene)."),
    ] = None,
    ice: Annotated[
        str | None,
        typer.Option(
            metavar=VALUES, help="Largest ice thicknesses in mm (default: the scene's ice)."
        ),
    ] = None,
    ice_shape: Annotated[
        str,
        typer.Option(
            metavar="SHAPE", help="Shape for --ice: crescent, eccentric_circle, d_shape or radial."
        ),
    ] = "crescent",
    ice_density: Annotated[
        float,
        typer.Option(metavar="KG/M3", parser=real, help="Density for --ice in kg/m3."),
    ] = 900.0,
    curve: Annotated[
        list[str] | None,
        typer.Option(
            "--curve",
            metavar="FILE",
            help=(
                "Coefficient curve: a CSV file with the columns angle_deg,lift,drag,moment, or a"
                " packaged scene; may be repeated (default: that of the scene)."
            ),
        ),
    ] = None,
    clearance: Annotated[
        float | None,
        typer.Option(metavar="M", parser=real, help="Distance in m that phases must keep."),
    ] = None,
    until: Until = None,
    changes: Changes = None,
    workers: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            parser=whole(1, 1000),
            help="Cases computed at a time (default: one for each core).",
        ),
    ] = None,
    author: Annotated[str, typer.Option(metavar="TEXT", help="Author, for the report.")] = "",
    project: Annotated[str, typer.Option(metavar="TEXT", help="Project, for the report.")] = "",
    revision: Annotated[str, typer.Option(metavar="TEXT", help="Revision, for the report.")] = "",
) -> None:
    """Study a line: does it gallop, how high, clashes, forces, and which measures help.

    Every combination of wind, attack angle, ice and curve is simulated. Measures (tension, spacers,
    pendulums, dampers, a split span) are simulated with the worst ice and curve. The report begins
    with a verdict on one page.
    """
    from gallop_fmu.foundation.text_rules import clean_text
    from modal.report.page import SUFFIXES
    from modal.study.page import Signature, write_study
    from modal.study.study import study_line

    chosen: Any = chosen_spec(scene, changes).scene()
    complain_of(chosen, "gallop-modal")
    check_output(out, SUFFIXES)
    varied = _conditions(wind, angle, ice, (ice_shape, ice_density), curve)
    signature = Signature(*(clean_text(text) for text in (author, project, revision)))
    with shown_parts(chosen.title) as shown:
        found = study_line(
            chosen,
            varied,
            stop_time=until,
            clearance=clearance,
            workers=workers,
            progress=shown,
        )
        if shown:
            shown("page", 0.0)
        write_study(found, out, signature)
    _print(found, out)
    if not found.known:
        complain("no case has a result; the report has the reasons.", "gallop-modal")
        raise typer.Exit(Exit.ENDED_EARLY)


def _conditions(
    wind: str,
    angle: str | None,
    ice: str | None,
    of_ice: tuple[str, float],
    curves: list[str] | None,
) -> Any:
    """Return the conditions of the options."""
    from typing import get_args

    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.line.ice_shapes import IceShape
    from modal.study.conditions import StudyConditions

    shape, density = of_ice
    if shape not in get_args(IceShape):
        raise SceneError(
            f"--ice-shape {shape}: must be one of {', '.join(sorted(get_args(IceShape)))}"
        )
    shaped: Any = shape
    return StudyConditions(
        winds=_numbers("wind", wind),
        angles_deg=() if angle is None else _numbers("angle", angle),
        ices=() if ice is None else tuple(1e-3 * value for value in _numbers("ice", ice)),
        curves=tuple(curves or ()),
        ice_shape=shaped,
        ice_density=density,
    )


def _numbers(name: str, text: str) -> tuple[float, ...]:
    """Return the numbers of a list or range."""
    from gallop_fmu.foundation.errors import SceneError

    try:
        values = values_of("wind.speed", text)
    except SceneError as problem:
        message = str(problem).replace("--over wind.speed=", f"--{name} ")
        raise SceneError(message) from None
    wrong = [
        value for value in values if isinstance(value, bool) or not isinstance(value, (int, float))
    ]
    if wrong:
        raise SceneError(f"--{name} {text}: {wrong[0]!r} is not a number; write 4,8 or 4:12:2")
    return tuple(map(float, values))


def _print(found: LineStudy, out: Path) -> None:
    """Print the answers without their evidence."""
    from modal.study.verdict import answers

    console = new_console()
    for each in answers(found):
        console.print(each.question, style="dim", soft_wrap=True)
        console.print(f"  {each.answer}", soft_wrap=True)
    console.print(f"wrote {out} ({out.stat().st_size / 1e6:.2f} MB)", soft_wrap=True)
