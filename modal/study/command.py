"""The command ``gallop-modal study``."""

from __future__ import annotations

import copy
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from gallop_fmu.cli.line_commands import line_options
from gallop_fmu.cli.sweep_options import values_of
from gallop_fmu.cli.terminal import (
    Changes,
    Exit,
    StopTime,
    check_output,
    chosen_spec,
    complain,
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

OF_ICE = ("ice_shape", "ice_density")
"""Line data that also hold for the ice of ``--ice``."""


class StudyCommand(TyperCommand):
    """The command ``study``: adds the options of ``gallop-fmu new --section`` when used."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the command's own options, and those of line data in a panel of their own."""
        return [*super().get_params(ctx), *_line_data()]

    def invoke(self, ctx: Any) -> Any:
        """Run the command with the given line data in ``ctx.obj``."""
        values = {option.name: ctx.params.pop(option.name) for option in _line_data()}
        ctx.obj = {name: value for name, value in values.items() if value is not None}
        return super().invoke(ctx)


@cache
def _line_data() -> list[Any]:
    """Options of line data, none of them required."""
    from gallop_fmu.line.section_table import ONE_SPAN_ONLY

    found = []
    for option in line_options():
        if option.name not in ONE_SPAN_ONLY:
            option = copy.copy(option)
            option.required = False
            option.rich_help_panel = "A line from a table of towers, in place of SCENE"
            found.append(option)
    return found


def study(  # noqa: PLR0913 - typer takes a parameter for each option
    context: typer.Context,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE", help="File to write (.html).")
    ],
    scene: Annotated[
        str | None, typer.Argument(metavar="SCENE", help="Path of the scene file of a line (TOML).")
    ] = None,
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
    curve: Annotated[
        list[str] | None,
        typer.Option(
            "--curve",
            metavar="FILE",
            help=(
                "Coefficient curve: a CSV file with the columns angle_deg,lift,drag,moment, a"
                " packaged curve, or assumed; may be repeated (default: that of the scene)."
            ),
        ),
    ] = None,
    clearance: Annotated[
        float | None,
        typer.Option(metavar="M", parser=real, help="Distance in m that phases must keep."),
    ] = None,
    string_pull: Annotated[
        float | None,
        typer.Option(
            metavar="KN", parser=real, help="Design value of the pull of a string in kN, one phase."
        ),
    ] = None,
    unbalanced_pull: Annotated[
        float | None,
        typer.Option(
            metavar="KN",
            parser=real,
            help="Design value of the unbalanced pull on a suspension tower in kN, one phase.",
        ),
    ] = None,
    stop_time: StopTime = None,
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
    """Study a line: galloping, height, clashes, forces, and measures, in one report.

    Every combination of wind, attack angle, ice and curve is simulated, then measures (tension,
    spacers, pendulums, dampers, a split span) at the worst. The report has a verdict on page one.
    The folder FILE.runs keeps all runs: after a stop, the same command computes only the rest.
    """
    from gallop_fmu.foundation.text_rules import clean_text
    from modal.report.page import SUFFIXES
    from modal.study.conditions import StudyLimits
    from modal.study.page import Signature, write_study
    from modal.study.study import StudyStoppedError, study_line

    data = context.obj or {}
    chosen: Any = chosen_spec(_line(scene, data), changes).scene()
    check_output(out, SUFFIXES)
    shaped = {name: data[name] for name in OF_ICE if name in data}
    varied = _conditions(wind, angle, ice, curve, shaped)
    newtons = (None if each is None else 1e3 * each for each in (string_pull, unbalanced_pull))
    limits = StudyLimits(clearance, *newtons)
    signature = Signature(*(clean_text(text) for text in (author, project, revision)))
    stopped = ""
    with shown_parts(chosen.title) as shown:
        try:
            found = study_line(
                chosen,
                varied,
                stop_time=stop_time,
                limits=limits,
                out=runs_folder(out),
                workers=workers,
                progress=shown,
            )
        except StudyStoppedError as problem:
            stopped, found = str(problem), problem.result
        if shown:
            shown("page", 0.0)
        write_study(found, out, signature)
    _print(found, out)
    for text in found.warnings:
        complain(f"warning: {text}", "gallop-modal")
    if stopped:
        complain(stopped, "gallop-modal")
        raise typer.Exit(Exit.ENDED_EARLY)
    if not found.known:
        complain("no case has a result; the report has the reasons.", "gallop-modal")
        raise typer.Exit(Exit.ENDED_EARLY)


def runs_folder(report: Path) -> Path:
    """Folder that keeps the runs of a study, beside its report."""
    return report.with_suffix(".runs")


def _line(scene: str | None, data: dict[str, Any]) -> Any:
    """Return the name of the scene, or the line of a table of towers.

    Raises
    ------
    SceneError
        Both or neither are given, or line data without a table.
    """
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.line.section_table import section_data
    from gallop_fmu.scene.line_scene import LineScene

    if "section" in data:
        if scene is not None:
            raise SceneError(f"{scene} and --section are both given; give only one of them")
        return LineScene.from_dict(section_data(data, Path()))
    if others := [name for name in data if name not in OF_ICE]:
        option = others[0].replace("_", "-")
        raise SceneError(
            f"--{option}: line data need a table of towers; give --section, or change the scene"
            " with --set"
        )
    if scene is None:
        raise SceneError("no line: give a scene file, or a table of towers with --section")
    return scene


def _conditions(
    wind: str,
    angle: str | None,
    ice: str | None,
    curves: list[str] | None,
    of_ice: dict[str, Any],
) -> Any:
    """Return the conditions of the options."""
    from modal.study.conditions import StudyConditions

    return StudyConditions(
        winds=_numbers("wind", wind),
        angles_deg=() if angle is None else _numbers("angle", angle),
        ices=() if ice is None else tuple(1e-3 * value for value in _numbers("ice", ice)),
        curves=tuple(curves or ()),
        **of_ice,
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
    from gallop_fmu.foundation.text_rules import counted
    from modal.study.verdict import answers

    console = new_console()
    for each in answers(found):
        console.print(each.question, style="dim", soft_wrap=True)
        console.print(f"  {each.answer}", soft_wrap=True)
    count = len(found.cases) + sum(len(each.cases) for each in found.tried)
    size = f"{out.stat().st_size / 1e6:.2f} MB"
    console.print(
        f"wrote {out} ({size}); {counted(count, 'case')} in {found.seconds / 60.0:.1f} min",
        soft_wrap=True,
    )
