"""The command ``gallop-modal``.  Whatever a command needs is imported inside it, so that ``--help`` answers at once."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gallop_fmu.cli.sweep_options import range_of, values_of
from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    AsJson,
    Changes,
    SceneName,
    Version,
    check_output,
    chosen_scene,
    example,
    new_app,
    new_table,
    real,
    start,
    whole,
)
from modal.cli.output import Plot, scene_to_draw, tell
from modal.cli.screen_command import SCREEN_EXAMPLE, screen_span
from modal.report.command import REPORT_EXAMPLE, report

if TYPE_CHECKING:
    from gallop_fmu.scene.scene import Scene

app = new_app("gallop-modal")


@app.callback()
def _root(version: Version = False) -> None:
    """Modes, resonance and stability of an iced span, without simulating it."""


RANGE = "KEY[=FIRST:LAST]"
Followed = Annotated[
    str | None,
    typer.Option(
        "--over",
        metavar=RANGE,
        help="Follow the modes over this number; else 0.7 to 1.3 times what it is.",
    ),
]
Points = Annotated[
    int, typer.Option("--points", metavar="N", parser=whole(2, 10000), help="Number of values.")
]


@app.command(
    epilog=example("gallop-modal modes example3 --over span.horizontal_tension --plot veering.png")
)
def modes(
    scene: SceneName,
    changes: Changes = None,
    count: Annotated[
        int, typer.Option(metavar="N", parser=whole(0, 10000), help="Number of modes.")
    ] = 12,
    wind: Annotated[
        Literal["still", "mean"],
        typer.Option(help="About still air, or about equilibrium in the scene's mean wind."),
    ] = "still",
    over: Followed = None,
    points: Points = 25,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Print the lowest natural modes: frequency, damping, family and loops; or follow them while a number changes."""
    from modal.linear.modes import natural_modes

    chosen = scene_to_draw(scene, changes, plot)
    if over is not None:
        _follow_modes(chosen, count, wind, *_varied(chosen, over, points), plot, as_json)
        return
    found = natural_modes(chosen, count, wind)
    rows = [
        {
            "frequency_hz": mode.frequency_hz,
            "damping_ratio": mode.damping_ratio,
            "family": mode.family,
            "symmetric": mode.symmetric,
            "loops": mode.loops,
            "shares": mode.shares,
            "participation": mode.participation,
        }
        for mode in found
    ]
    table = new_table("frequency [Hz]", "damping ratio", "family", "share", "loops", "symmetric")
    for mode in found:
        table.add_row(
            f"{mode.frequency_hz:.4f}",
            f"{mode.damping_ratio:.3%}",
            mode.family,
            f"{mode.shares[mode.family]:.1%}",
            str(mode.loops),
            "yes" if mode.symmetric else "no",
        )

    def figure() -> Any:
        from modal.plots.span_figures import mode_shapes

        return mode_shapes(found, chosen.title)

    told = {"title": chosen.title, "warnings": list(chosen.warnings), "wind": wind, "modes": rows}
    tell(told, [chosen.title, table], figure, plot, as_json)


def _follow_modes(
    scene: Scene,
    count: int,
    wind: Literal["still", "mean"],
    over: str,
    values: list[float],
    plot: Path | None,
    as_json: bool,
) -> None:
    """Tell how frequencies and families change while a number does."""
    from modal.linear.mode_tracking import track_modes

    data = track_modes(scene, over, values, count, wind)
    frequency, shares = data.frequency_hz.values, data.share.values
    families = data.family.values[shares.argmax(axis=2)]
    unit = data[over].attrs["units"]
    rows = [
        {
            "frequency_hz": frequency[k].tolist(),
            "damping_ratio": data.damping_ratio.values[k].tolist(),
            "family": families[k].tolist(),
            "shares": {
                name: shares[k, :, f].tolist() for f, name in enumerate(data.family.values.tolist())
            },
            "likeness": data.likeness.values[k].tolist(),
        }
        for k in range(len(frequency))
    ]
    ends = [f"at {value:g} {unit}" for value in (values[0], values[-1])]
    table = new_table("mode", f"{ends[0]} [Hz]", "family", f"{ends[1]} [Hz]", "family")
    for k, (wave, family) in enumerate(zip(frequency, families, strict=True)):
        table.add_row(str(k + 1), f"{wave[0]:.4f}", family[0], f"{wave[-1]:.4f}", family[-1])

    def figure() -> Any:
        from modal.plots.span_figures import tracking_figure

        return tracking_figure(data)

    told = {
        "title": scene.title,
        "warnings": list(scene.warnings),
        "wind": wind,
        "over": over,
        "unit": unit,
    }
    told |= {"values": values, "modes": rows}
    tell(told, [scene.title, table], figure, plot, as_json)


def _varied(scene: Scene, option: str, points: int) -> tuple[str, list[float]]:
    """The number that an option names, and the values that it asks for: by default around what the number is now."""
    import numpy as np

    from modal.foundation.scene_variation import number_of

    path, given, text = (part.strip() for part in option.partition("="))
    if not given:
        now = number_of(scene, path)
        return path, np.linspace(0.7 * now, 1.3 * now, points).tolist()
    if text.count(":") != 1:
        return path, _numbers(path, text)
    first, last = range_of(path, text, ("FIRST", "LAST"), "span.sag=1.5:3")
    return path, np.linspace(first, last, points).tolist()


def _numbers(path: str, text: str) -> list[float]:
    from gallop_fmu.foundation.errors import SceneError

    values = values_of(path, text)
    wrong = [
        value for value in values if isinstance(value, bool) or not isinstance(value, (int, float))
    ]
    if wrong:
        raise SceneError(f"--over {path}={text}: {wrong[0]!r} is no number")
    return [float(value) for value in values]


@app.command(
    epilog=example(
        "gallop-modal ratio example3 --over span.horizontal_tension=10e3:20e3 --plot map.png"
    )
)
def ratio(
    scene: SceneName,
    changes: Changes = None,
    over: Annotated[
        str,
        typer.Option(
            metavar=RANGE,
            help=(
                "Number to vary: a value of the scene, temperature_change \\[K], or"
                " supports.stiffness_x1 (both)."
            ),
        ),
    ] = "span.horizontal_tension",
    points: Points = 25,
    against: Annotated[
        str | None, typer.Option(metavar=RANGE, help="A second number, for a map over both.")
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Print the 2:1 frequency ratio, what changes it, and where it is 2; over one number or two."""
    from gallop_fmu.foundation.errors import SceneError
    from modal.foundation.scene_variation import unit_of
    from modal.stability.frequency_ratio import (
        crossings,
        frequency_ratio,
        ratio_map,
        suggest_design_changes,
    )

    chosen = scene_to_draw(scene, changes, plot)
    here = frequency_ratio(chosen)
    over, values = _varied(chosen, over, points)
    changes_of_design = suggest_design_changes(chosen)
    unit, first, last = unit_of(chosen, over), values[0], values[-1]
    told: dict[str, Any] = {
        "title": chosen.title,
        "warnings": list(chosen.warnings),
        "vertical_hz": here.vertical_hz,
        "horizontal_hz": here.horizontal_hz,
        "ratio": here.ratio,
        "detuning": here.detuning,
        "one_to_one_detuning": here.one_to_one_detuning,
        "over": over,
        "design_changes": [change.sentence for change in changes_of_design],
    }
    lines = [
        chosen.title,
        (
            f"first symmetric vertical {here.vertical_hz:.4f} Hz, horizontal"
            f" {here.horizontal_hz:.4f} Hz"
        ),
        (
            f"ratio {here.ratio:.4f}: {abs(here.detuning):.1%}"
            f" {'above' if here.detuning > 0 else 'below'} 2:1"
        ),
    ]
    if against is None:
        try:
            at_two = crossings(chosen, over, values)
        except (
            SceneError
        ) as problem:  # on a slope modes veer near 2:1; the ratio of the scene itself is known
            lines.append(f"{over}: values at which the ratio is 2 cannot be listed: {problem}")
            told |= {"crossings": None, "crossings_problem": str(problem)}
        else:
            nowhere = f"nowhere from {first:g} to {last:g} {unit}"
            crossed = ", ".join(f"{value:.5g} {unit}" for value in at_two) or nowhere
            lines.append(f"{over}: the ratio is 2 at {crossed}")
            told["crossings"] = at_two

        def figure() -> Any:
            from modal.plots.span_figures import ratio_figure

            return ratio_figure(ratio_map(chosen, over, values))

    else:
        against, others = _varied(chosen, against, points)
        data = ratio_map(chosen, over, values, against=(against, others))
        told |= {"values": values, "against": against, "against_values": others}
        told["ratios"] = [
            [None if r != r else r for r in row] for row in data.ratio.values.tolist()
        ]  # NaN is no JSON
        lines.append(
            f"ratio from {data.ratio.min().item():.4f} to {data.ratio.max().item():.4f} over {over}"
            f" and {against}"
        )

        def figure() -> Any:
            from modal.plots.span_figures import ratio_figure

            return ratio_figure(data)

    tell(told, [*lines, *(change.sentence for change in changes_of_design)], figure, plot, as_json)


@app.command(epilog=example("gallop-modal linear example3 --highest 10 --plot locus.png"))
def linear(
    scene: SceneName,
    changes: Changes = None,
    count: Annotated[
        int, typer.Option(metavar="N", parser=whole(1, 10000), help="Number of modes.")
    ] = 6,
    highest: Annotated[
        float,
        typer.Option(
            metavar="U", parser=real, help="Wind speed \\[m/s] up to which onsets are looked for."
        ),
    ] = 15.0,
    what: Annotated[
        Literal["locus", "criteria"], typer.Option("--show", help="What --plot draws.")
    ] = "locus",
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Print what linear theory says: unstable attack angles, and the wind speed at which each mode begins to grow."""
    import numpy as np

    from gallop_fmu.foundation.errors import SceneError
    from modal.stability.criteria import stability_criteria
    from modal.stability.critical_wind import critical_wind_speed

    chosen = scene_to_draw(scene, changes, plot)
    criteria, onsets = stability_criteria(chosen), critical_wind_speed(chosen, count, highest)
    told = {
        "title": chosen.title,
        "warnings": list(chosen.warnings),
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
    table = new_table("mode", "still air [Hz]", "critical wind [m/s]", "Den Hartog [m/s]")
    for onset in onsets:
        table.add_row(
            f"{onset.mode.family} {onset.mode.loops}",
            f"{onset.mode.frequency_hz:.4f}",
            (
                f"none to {onset.searched_to:g}"
                if onset.wind_speed is None
                else f"{onset.wind_speed:.3f}"
            ),
            "-" if onset.den_hartog is None else f"{onset.den_hartog:.3f}",
        )
    lines = [chosen.title]
    for criterion in criteria:
        ranges = ", ".join(f"{first:.1f} to {last:.1f}" for first, last in criterion.unstable_deg)
        lines.append(
            f"{criterion.name}: unstable at {ranges} deg" if ranges else f"{criterion.name}: stable"
        )
        lines += [f"  {line}" for line in criterion.explained]

    def figure() -> Any:
        from modal.linear.state_space import root_locus
        from modal.plots.span_figures import criteria_figure, locus_figure

        if what == "criteria":
            return criteria_figure(criteria, float(np.radians(chosen.ice.attack_angle_deg)))
        if onsets[0].searched_to == 0.0:
            raise SceneError(f"no root locus: {onsets[0].remark}")
        return locus_figure(
            root_locus(chosen, list(np.linspace(0.0, onsets[0].searched_to, 31)), count)
        )

    tell(
        told,
        [*lines, table, *{onset.remark for onset in onsets if onset.remark}],
        figure,
        plot,
        as_json,
    )


app.command(name="screen", epilog=example(SCREEN_EXAMPLE))(screen_span)
app.command(epilog=example(REPORT_EXAMPLE))(report)


@app.command(
    name="compare", epilog=example("gallop-modal compare example3 --until 900 --plot compare.png")
)
def compare_models(
    scene: SceneName,
    changes: Changes = None,
    until: Annotated[
        float | None,
        typer.Option(metavar="S", parser=real, help="Simulated time \\[s]; else the scene's."),
    ] = None,
    plot: Plot = None,
    as_json: AsJson = False,
) -> None:
    """Set the nonlinear model, mode superposition and linear theory side by side."""
    from modal.superposition.comparison import compare

    check_output(plot, PICTURE_SUFFIXES)
    chosen = chosen_scene(scene, changes)  # the comparison tells its warnings
    found = compare(chosen, until)

    def figure() -> Any:
        from modal.plots.comparison_figure import comparison_figure

        return comparison_figure(found)

    tell(found.as_dict(), [chosen.title, str(found)], figure, plot, as_json)


def main() -> None:
    """Entry point of the command ``gallop-modal``."""
    start(app, "gallop-modal")
