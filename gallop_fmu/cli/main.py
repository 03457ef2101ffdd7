"""The command ``gallop-fmu``.

Each command imports what it needs itself, so that ``--help`` is fast.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gallop_fmu.cli.curves_command import CURVES_EXAMPLE, curves
from gallop_fmu.cli.line_commands import NEW_EXAMPLE, LineCommand, conductors, new
from gallop_fmu.cli.line_output import print_line
from gallop_fmu.cli.modal_commands import add_modal_commands
from gallop_fmu.cli.shedding_output import print_sheddings
from gallop_fmu.cli.sweep_options import SweepOptions, takes_sweep_options
from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    AsJson,
    Changes,
    Exit,
    SceneName,
    StopTime,
    Version,
    check_output,
    chosen_scene,
    complain,
    complain_of,
    echo_json,
    example,
    new_app,
    new_console,
    new_table,
    print_warnings,
    progress_bar,
    real,
    start,
    whole,
    work_text,
)

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene
    from gallop_fmu.simulation.line_result import LineResult
    from gallop_fmu.simulation.result import Result
    from gallop_fmu.simulation.simulate import Progress

ModelName = Annotated[
    str,
    typer.Option(
        hidden=True, help="Kept for scripts of 0.1.0, which had a second model; to be removed."
    ),
]

RESULT_SUFFIXES = (".nc", ".csv", ".parquet")

app = new_app("gallop-fmu")


@app.callback()
def _root(version: Version = False) -> None:
    """Galloping of iced overhead-line conductors: simulate a span, or export it as an FMU."""


@app.command(epilog=example("gallop-fmu scenes --json"))
def scenes(as_json: AsJson = False) -> None:
    """List the packaged scenes."""
    from gallop_fmu.input.scene_files import packaged_scenes

    found = packaged_scenes()
    if as_json:
        echo_json(found)
        return
    table = new_table("scene", "title")
    for name, title in found.items():
        table.add_row(name, title)
    new_console().print(table)


app.command(epilog=example("gallop-fmu conductors"))(conductors)
app.command(epilog=example(CURVES_EXAMPLE))(curves)
app.command(cls=LineCommand, epilog=example(NEW_EXAMPLE))(new)


@app.command(
    epilog=example(
        "gallop-fmu run example3 --stop-time 900 --set wind.speed=5.5 --out run.nc --plot run.png"
    )
)
def run(  # noqa: PLR0913 - typer takes a parameter for each option
    scene: SceneName,
    stop_time: StopTime = None,
    changes: Changes = None,
    record_every: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            parser=whole(),
            help="Record every N-th time step (default: from the scene).",
        ),
    ] = None,
    record_nodes: Annotated[
        Literal["midspan", "all"], typer.Option(help="Nodes to record.")
    ] = "midspan",
    model: ModelName = "element",
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write the histories: .nc (NetCDF), or mid-span .csv, .parquet."
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a picture: .png, .svg or .pdf.")
    ] = None,
    inputs: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help=(
                "Prescribe wind and motion of the tower points by a CSV file as FMPy reads it:"
                " time and names of the FMU's inputs."
            ),
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            parser=whole(),
            help=(
                "Threads, 1 or 2, with the same results (default: 2 for a line of 400 elements or"
                " more, if two cores are available)."
            ),
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Simulate a span or line and print its motion at mid-span, of a line also its towers."""
    from gallop_fmu.input.input_csv import with_inputs
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.simulation.run_options import check_model

    check_model(model)
    chosen = chosen_scene(scene, changes)
    if inputs:
        chosen = with_inputs(chosen, inputs)
    check_output(out, RESULT_SUFFIXES)
    check_output(plot, PICTURE_SUFFIXES)
    result = _simulate(chosen, stop_time, record_every, record_nodes, threads, silent=as_json)
    written, unwritten = _write(result, out, plot)
    numbers = _numbers(result)
    if as_json:
        echo_json({**numbers, "files": list(map(str, written))})
    elif isinstance(chosen, LineScene):
        print_line(numbers, result.warnings, written)
    else:
        _print_summary(numbers, result.recorded.facts, result.warnings, written)
    _exit_unless_complete(result, written, unwritten)


def _numbers(result: Result | LineResult) -> dict[str, Any]:
    """Return the summary of a run of a span or line."""
    from gallop_fmu.simulation.line_result import LineResult
    from gallop_fmu.simulation.line_tables import line_summary
    from gallop_fmu.simulation.result import summary

    return line_summary(result) if isinstance(result, LineResult) else summary(result)


@app.command(
    epilog=example(
        "gallop-fmu sweep example3 --over wind.speed=4:7:0.5 --stop-time 900 -o winds.parquet"
    )
    + "\n\n"
    + example("gallop-fmu sweep line.toml --over wind.speed=2:6:0.5 -o winds.nc")
)
@takes_sweep_options
def sweep(
    shared: SweepOptions,
    stop_time: StopTime = None,
    window: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            parser=real,
            help=(
                "Time in s at the end over which amplitudes are taken (default: 100, at most half"
                " of the run)."
            ),
        ),
    ] = None,
    model: ModelName = "element",
) -> None:
    """Simulate a scene over values of its parameters, every span of a table, or both.

    One row a run: amplitudes, frequencies, extremes, clearance, and the outcome. Runs that fail
    are rows too. Of a line ([section]), amplitudes of each span, forces on each tower, leans of
    the strings, and the smallest distance of the phases.

    The same command again continues a sweep that was stopped or killed, from the journal
    FILE.journal.
    """
    from gallop_fmu.sweeps.sweep import sweep as sweep_scenes

    columns = (
        "outcome",
        "motion",
        "u2_amplitude",
        "u2_frequency_hz",
        "u3_amplitude",
        "cigre_322_excess",
        "span_u2_amplitude",
        "span_u3_amplitude",
        "smallest_clearance",
    )
    compute = partial(sweep_scenes, stop_time=stop_time, window=window, model=model)
    shared.carry_out("gallop-fmu", compute, columns)


@app.command(
    epilog=example("gallop-fmu export example3 -o example3.fmu --set numerics.time_step=0.005")
)
def export(  # noqa: PLR0913 - typer takes a parameter for each option
    scene: SceneName,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="FMU to write.")],
    changes: Changes = None,
    runtime: Annotated[
        Literal["native", "python"],
        typer.Option(
            help=(
                "Code inside the FMU: the compiled kernel, or Python, which then must be installed"
                " on the host."
            )
        ),
    ] = "native",
    platforms: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help=(
                "Platforms to compile for, of linux64,win64,darwin64, separated by commas (default:"
                " this one); needs the extra cross, and minutes the first time."
            ),
        ),
    ] = None,
    wind: Annotated[
        Literal["line", "span"],
        typer.Option(help="Of a line: one input for the wind speed, or one for each span."),
    ] = "line",
    stations: Annotated[
        str,
        typer.Option(
            metavar="NUMBERS",
            help=(
                "Places in each span with outputs, besides its middle: fractions of the span,"
                ' separated by commas; "" for none.'
            ),
        ),
    ] = "0.25,0.75",
    fmi: Annotated[
        Literal["2", "3"],
        typer.Option(help="Version of FMI: 2.0, which more hosts take, or 3.0."),
    ] = "2",
    as_json: AsJson = False,
) -> None:
    """Write a span or line as an FMU for co-simulation."""
    from gallop_fmu.fmu import ExportError, export_fmu
    from gallop_fmu.foundation.errors import SceneError

    try:
        names = platforms.split(",") if platforms else None
        chosen = chosen_scene(scene, changes)
        complain_of(chosen)
        places = [real(text) for text in stations.split(",")] if stations else []
        path = export_fmu(chosen, out, runtime, names, wind=wind, stations=places, fmi=int(fmi))
    except ExportError as problem:
        raise SceneError(str(problem)) from None
    size = path.stat().st_size
    if as_json:
        echo_json({"file": str(path), "bytes": size, "runtime": runtime})
    else:
        new_console().print(f"wrote {path} ({size / 1e6:.2f} MB)")


@app.command(epilog=example("gallop-fmu check example3.fmu"))
def check(
    fmu: Annotated[Path, typer.Argument(metavar="FMU", help="FMU to check.")],
    as_json: AsJson = False,
) -> None:
    """Check that an FMU follows the standard, and that it runs."""
    if not fmu.is_file():
        state = "not a file" if fmu.exists() else "no such file"
        complain(f"{fmu}: {state}; gallop-fmu export SCENE -o FILE.fmu writes an FMU to check")
        raise typer.Exit(Exit.BAD_INPUT)
    from gallop_fmu.fmu import check_fmu

    found = check_fmu(fmu).rows
    if as_json:
        echo_json([{"name": name, "ok": ok, "detail": detail} for name, ok, detail in found])
    else:
        from rich.text import Text

        table = new_table("check", "", "detail")
        for name, ok, detail in found:
            table.add_row(name, Text("passed", "green") if ok else Text("FAILED", "red"), detail)
        new_console().print(table)
    failed = [name for name, ok, _ in found if not ok]
    if failed:
        complain(f"{fmu}: {len(failed)} of {len(found)} checks failed: {', '.join(failed)}")
        raise typer.Exit(Exit.ENDED_EARLY)


@app.command(epilog=example("gallop-fmu demo --out-dir demo"))
def demo(
    out_dir: Annotated[
        Path,
        typer.Option(
            metavar="DIR", help="Folder for FMU, histories and picture; created if missing."
        ),
    ] = Path("gallop-demo"),
) -> None:
    """Run example 3 as an FMU until galloping excites the swing, and print the motion."""
    from gallop_fmu.cli.demo import run_demo

    if out_dir.exists() and not out_dir.is_dir():
        complain(f"{out_dir}: is a file; --out-dir takes a folder")
        raise typer.Exit(Exit.BAD_INPUT)
    out_dir.mkdir(parents=True, exist_ok=True)
    with _progress("example 3 in an FMU", silent=False) as shown:
        lines = run_demo(out_dir, shown)
    new_console().print("\n".join(lines), soft_wrap=True)


add_modal_commands(app)


def main() -> None:
    """Entry point of the command ``gallop-fmu``."""
    start(app, "gallop-fmu")


def _simulate(
    scene: Scene | LineScene,
    stop_time: float | None,
    record_every: int | None,
    record_nodes: Literal["midspan", "all"],
    threads: int | None,
    *,
    silent: bool,
) -> Result | LineResult:
    """Simulate a scene with progress.

    Raises
    ------
    SimulationError
        The run could not start.
    """
    from gallop_fmu.foundation.outcome import SimulationError
    from gallop_fmu.simulation.simulate import simulate

    with _progress(scene.title, silent=silent) as shown:
        result = simulate(
            scene,
            stop_time,
            record_every=record_every,
            record_nodes=record_nodes,
            progress=shown,
            on_failure="return",
            threads=threads,
        )
    if not result.started:
        raise SimulationError(result.report, result)
    return result


def _write(
    result: Result | LineResult, out: Path | None, plot: Path | None
) -> tuple[list[Path], list[OSError]]:
    """Write both files; return the written paths and the errors.

    An error in one file does not prevent the other, or the summary.
    """
    written, unwritten = [], []
    try:
        written += [result.save(out)] if out else []
    except OSError as problem:
        unwritten.append(problem)
    if plot:
        from gallop_fmu.line_plots import line_overview
        from gallop_fmu.plots import overview, save_figure
        from gallop_fmu.simulation.result import Result

        try:
            figure = overview(result) if isinstance(result, Result) else line_overview(result)
            written.append(save_figure(figure, plot))
        except OSError as problem:
            unwritten.append(problem)
    return written, unwritten


def _exit_unless_complete(
    result: Result | LineResult, written: list[Path], unwritten: list[OSError]
) -> None:
    """Report a run that ended early and files that could not be written; end with their code."""
    from gallop_fmu.foundation.outcome import Outcome

    is_complete = result.outcome is Outcome.COMPLETED
    if not is_complete:
        files = ", ".join(map(str, written))
        kept = f"the results until then are in {files}" if written else "nothing was written"
        complain(f"{result.report} The run ended early; {kept}.")
    for problem in unwritten:
        complain(
            f"{problem.filename}: cannot be written ({problem.strerror}); an older file of this"
            " name is unchanged"
        )
    if unwritten:
        raise typer.Exit(Exit.BAD_INPUT)
    if not is_complete:
        raise typer.Exit(Exit.ENDED_EARLY)


@contextmanager
def _progress(title: str, *, silent: bool) -> Iterator[Progress | None]:
    """Show the simulated time on a bar."""
    with progress_bar(title, silent=silent) as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task("starting", total=None)

        def show(time: float, stop_time: float) -> bool:
            bar.update(
                task,
                completed=time,
                total=stop_time,
                description=f"{time:.0f} of {stop_time:.0f} s",
            )
            return True

        yield show


@app.command(epilog=example("gallop-fmu doctor"))
def doctor(as_json: AsJson = False) -> None:
    """Check the installation: packages, kernel, a short run, and an FMU in FMPy."""
    from gallop_fmu.cli.doctor import check_installation

    checks = check_installation()
    if as_json:
        echo_json([check._asdict() for check in checks])
    else:
        table = new_table("", "state", "found")
        for check in checks:
            table.add_row(*check)
        new_console().print(table)
    if any(check.state == "fault" for check in checks):
        raise typer.Exit(Exit.BAD_INPUT)


MIDSPAN_ROWS = {"u2": "vertical u2", "u3": "horizontal u3", "theta": "twist", "tension": "tension"}


def _print_summary(
    numbers: dict[str, Any],
    facts: Mapping[str, Any],
    warnings: Iterable[str],
    written: list[Path],
) -> None:
    from gallop_fmu.foundation.channels import DESCRIBED
    from gallop_fmu.simulation.result import frequency_text

    console = new_console()
    console.print(numbers["title"], style="bold")
    console.print(
        f"sag {facts['sag']:.3f} m, horizontal tension {facts['horizontal_tension'] / 1000:.3f} kN"
    )
    console.print(f"motion: {numbers['motion']}", soft_wrap=True)
    headings = ("amplitude", "mean", "frequency [Hz]", "motion", "range in the run")
    table = new_table(f"mid-span, last {numbers['window']:g} s", *headings)
    for name, row in numbers["midspan"].items():
        unit = DESCRIBED[name].unit
        table.add_row(
            f"{MIDSPAN_ROWS[name]} [{unit}]",
            f"{row['amplitude']:.4g}",
            f"{row['mean']:.4g}",
            frequency_text(row["frequency_hz"]),
            row["motion"].partition(" (")[0],
            f"{row['lowest']:.4g} to {row['highest']:.4g}",
        )
    if numbers["midspan"]:
        console.print(table)
        console.print("amplitude: half peak-to-peak", style="dim")
    print_sheddings(console, numbers.get("sheddings", ()))
    console.print(work_text(numbers))
    if facts["inactive_terms"]:
        console.print(
            f"inactive terms (no effect in this scene): {facts['inactive_terms']}",
            style="dim",
            soft_wrap=True,
        )
    print_warnings(warnings)
    for path in written:
        console.print(f"wrote {path}", soft_wrap=True)
