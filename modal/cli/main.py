"""The command ``gallop-modal``.

Functions import what they need themselves, so that ``--help`` is fast.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    AsJson,
    Changes,
    SceneName,
    StopTime,
    Version,
    check_output,
    chosen_spec,
    example,
    new_app,
    new_table,
    real,
    start,
    whole,
)
from modal.cli.atlas_command import ATLAS_EXAMPLE, atlas
from modal.cli.branches_command import BRANCHES_EXAMPLE, branches
from modal.cli.line_output import LOCUS_POINTS, show_linear, show_pairs
from modal.cli.measures_command import MEASURES_EXAMPLE, measures
from modal.cli.modes_command import MODES_EXAMPLE, modes
from modal.cli.number_options import RANGE, Points, only_for_spans, varied_values
from modal.cli.output import Plot, line_or_span_to_draw, show
from modal.cli.screen_command import SCREEN_EXAMPLE, screen_span
from modal.cli.sensitivity_command import SENSITIVITY_EXAMPLE, sensitivity
from modal.cli.slope_command import SLOPE_EXAMPLE, slope
from modal.report.command import REPORT_EXAMPLE, report
from modal.study.command import STUDY_EXAMPLE, StudyCommand, study

if TYPE_CHECKING:
    import xarray as xr

    from gallop_fmu.scene.scene import Scene
    from modal.stability.criteria import Criterion
    from modal.stability.critical_wind import CriticalWind

app = new_app("gallop-modal")


@app.callback()
def _root(version: Version = False) -> None:
    """Compute modes, resonance, stability and risk of a swing of iced spans; write reports."""


VARIED = "span.horizontal_tension"
"""Number that the command ratio varies if none is given."""


app.command(epilog=example(MODES_EXAMPLE))(modes)


@app.command(
    epilog=example(
        "gallop-modal ratio example3 --over span.horizontal_tension=10e3:20e3 --plot map.png"
    )
)
def ratio(
    scene: SceneName,
    changes: Changes = None,
    over: Annotated[
        str | None,
        typer.Option(
            metavar=RANGE,
            help=(
                "Number to vary: a value of the scene, temperature_change in K, or"
                f" supports.stiffness_x1 (of both ends). Default: {VARIED}."
            ),
        ),
    ] = None,
    points: Points = 25,
    against: Annotated[
        str | None, typer.Option(metavar=RANGE, help="Second number, for a map over both.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Print the frequency ratio, design changes, and values of a number at which it is 2.

    Of a line: pairs of modes near 2:1 and 1:1, and the amplitude at which one starts the other.
    """
    from gallop_fmu.scene.line_scene import LineScene
    from modal.stability.frequency_ratio import (
        frequency_ratio,
        ratio_map,
        suggest_design_changes,
    )

    chosen = line_or_span_to_draw(scene, changes, plot)
    if isinstance(chosen, LineScene):
        only_for_spans({"--over": over, "--against": against})
        show_pairs(chosen, plot, as_json)
        return
    pair = frequency_ratio(chosen)
    over, values = varied_values(chosen, over or VARIED, points)
    suggested = [change.sentence for change in suggest_design_changes(chosen)]
    content: dict[str, Any] = {
        "title": chosen.title,
        "warnings": list(chosen.warnings),
        "vertical_hz": pair.vertical_hz,
        "horizontal_hz": pair.horizontal_hz,
        "ratio": pair.ratio,
        "detuning": pair.detuning,
        "one_to_one_detuning": pair.one_to_one_detuning,
        "over": over,
        "design_changes": suggested,
    }
    lines = [
        chosen.title,
        f"first symmetric vertical {pair.vertical_hz:.4f} Hz, horizontal {pair.horizontal_hz:.4f}"
        " Hz",
        f"ratio {pair.ratio:.4f}: {abs(pair.detuning):.1%}"
        f" {'above' if pair.detuning > 0 else 'below'} 2:1",
    ]
    if against is None:
        numbers, line = _crossings(chosen, over, values)
        content |= numbers

        def draw_data() -> xr.Dataset:
            return ratio_map(chosen, over, values)

    else:
        against, others = varied_values(chosen, against, points)
        data = ratio_map(chosen, over, values, against=(against, others))
        content |= {"values": values, "against": against, "against_values": others}
        content["ratios"] = [
            [None if r != r else r for r in row] for row in data.ratio.values.tolist()
        ]  # JSON has no NaN
        line = (
            f"ratio from {data.ratio.min().item():.4f} to {data.ratio.max().item():.4f} over {over}"
            f" and {against}"
        )

        def draw_data() -> xr.Dataset:
            return data

    def figure() -> Any:
        from modal.plots.span_figures import ratio_figure

        return ratio_figure(draw_data())

    show(content, [*lines, line, *suggested], figure, plot, as_json)


def _crossings(scene: Scene, over: str, values: list[float]) -> tuple[dict[str, Any], str]:
    """Values of a number at which the ratio is 2: as JSON and as a line for people.

    On a slope modes veer near 2:1, and the ratio is not known at every value; the reason is printed
    instead.
    """
    from gallop_fmu.foundation.errors import SceneError
    from modal.foundation.scene_variation import unit_of
    from modal.stability.frequency_ratio import crossings

    try:
        found = crossings(scene, over, values)
    except SceneError as problem:
        line = f"{over}: values at which the ratio is 2 cannot be listed: {problem}"
        return {"crossings": None, "crossings_problem": str(problem)}, line
    unit = unit_of(scene, over)
    if not found:
        line = f"{over}: the ratio is not 2 between {values[0]:g} and {values[-1]:g} {unit}"
        return {"crossings": found}, line
    line = f"{over}: the ratio is 2 at {', '.join(f'{value:.5g} {unit}' for value in found)}"
    return {"crossings": found}, line


@app.command(epilog=example("gallop-modal linear example3 --highest-wind 10 --plot locus.png"))
def linear(
    scene: SceneName,
    changes: Changes = None,
    count: Annotated[
        int, typer.Option(metavar="N", parser=whole(1, 10000), help="Number of modes.")
    ] = 6,
    highest_wind: Annotated[
        float,
        typer.Option(
            metavar="U", parser=real, help="Highest wind speed in m/s of the search for onsets."
        ),
    ] = 15.0,
    what: Annotated[
        Literal["locus", "criteria"], typer.Option("--show", help="Content of the picture.")
    ] = "locus",
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Print results of linear theory: unstable attack angles, critical wind of each mode."""
    import numpy as np

    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.scene.line_scene import LineScene
    from modal.stability.criteria import stability_criteria
    from modal.stability.critical_wind import critical_wind_speed

    chosen = line_or_span_to_draw(scene, changes, plot)
    if isinstance(chosen, LineScene):
        only_for_spans({"--show criteria": what if what == "criteria" else None})
        show_linear(chosen, count, highest_wind, plot, as_json)
        return
    criteria, onsets = stability_criteria(chosen), critical_wind_speed(chosen, count, highest_wind)

    def figure() -> Any:
        from modal.linear.state_space import root_locus
        from modal.plots.span_figures import criteria_figure, locus_figure

        if what == "criteria":
            return criteria_figure(criteria, math.radians(chosen.ice.attack_angle_deg))
        if onsets[0].searched_to == 0.0:
            raise SceneError(f"no root locus: {onsets[0].remark}")
        winds = np.linspace(0.0, onsets[0].searched_to, LOCUS_POINTS)
        return locus_figure(root_locus(chosen, list(winds), count))

    content = {
        "title": chosen.title,
        "warnings": list(chosen.warnings),
        **_linear_numbers(criteria, onsets),
    }
    lines = [chosen.title, *_linear_lines(criteria, onsets)]
    show(content, lines, figure, plot, as_json)


def _linear_numbers(criteria: list[Criterion], onsets: list[CriticalWind]) -> dict[str, Any]:
    """Criteria and critical winds as JSON."""
    return {
        "unstable_attack_angles_deg": {
            criterion.name: criterion.unstable_deg for criterion in criteria
        },
        "causes": {criterion.name: criterion.causes for criterion in criteria if criterion.causes},
        "critical_winds": [
            {
                "family": onset.mode.family,
                "loops": onset.mode.loops,
                "still_air_hz": onset.mode.frequency_hz,
                "wind_speed": onset.wind_speed,
                "frequency_hz": onset.frequency_hz,
                "den_hartog": onset.den_hartog,
                "searched_to": onset.searched_to,
                "remark": onset.remark,
            }
            for onset in onsets
        ],
    }


def _linear_lines(criteria: list[Criterion], onsets: list[CriticalWind]) -> list[Any]:
    """Criteria and critical winds for people: lines, a table, and remarks."""
    lines: list[Any] = []
    for criterion in criteria:
        ranges = ", ".join(f"{first:.1f} to {last:.1f}" for first, last in criterion.unstable_deg)
        lines.append(
            f"{criterion.name}: unstable at {ranges} deg" if ranges else f"{criterion.name}: stable"
        )
        lines += [f"  {line}" for line in criterion.explained]
    table = new_table("mode", "still air [Hz]", "critical wind [m/s]", "Den Hartog [m/s]")
    for onset in onsets:
        table.add_row(
            f"{onset.mode.family} {onset.mode.loops}",
            f"{onset.mode.frequency_hz:.4f}",
            (
                f"none up to {onset.searched_to:g}"
                if onset.wind_speed is None
                else f"{onset.wind_speed:.3f}"
            ),
            "-" if onset.den_hartog is None else f"{onset.den_hartog:.3f}",
        )
    return [*lines, table, *{onset.remark for onset in onsets if onset.remark}]


app.command(epilog=example(SLOPE_EXAMPLE))(slope)
app.command(epilog=example(BRANCHES_EXAMPLE))(branches)
app.command(epilog=example(SENSITIVITY_EXAMPLE))(sensitivity)
app.command(epilog=example(MEASURES_EXAMPLE))(measures)
app.command(name="screen", epilog=example(SCREEN_EXAMPLE))(screen_span)
app.command(epilog=example(ATLAS_EXAMPLE))(atlas)
app.command(epilog=example(REPORT_EXAMPLE))(report)
app.command(cls=StudyCommand, epilog=example(STUDY_EXAMPLE))(study)


@app.command(
    name="compare",
    epilog=example("gallop-modal compare example3 --stop-time 900 --plot compare.png"),
)
def compare_models(
    scene: SceneName,
    changes: Changes = None,
    stop_time: StopTime = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Compare the nonlinear simulation, mode superposition and linear theory."""
    from modal.superposition.comparison import compare

    check_output(plot, PICTURE_SUFFIXES)
    chosen = chosen_spec(scene, changes).scene()  # the comparison has its warnings
    found = compare(chosen, stop_time)

    def figure() -> Any:
        from modal.plots.comparison_figure import comparison_figure

        return comparison_figure(found)

    show(found.as_dict(), [chosen.title, str(found)], figure, plot, as_json)


def main() -> None:
    """Run the command ``gallop-modal``."""
    start(app, "gallop-modal")
