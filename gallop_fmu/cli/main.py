"""The command ``gallop-fmu``.  Whatever a command needs is imported inside it, so that ``--help`` answers at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gallop_fmu.cli.line_commands import NEW_EXAMPLE, conductors, new
from gallop_fmu.cli.sweep_options import (
    ClusterAddress,
    Over,
    RunsOut,
    SpanTable,
    WorkerCount,
    carry_out,
    check_given,
    grid_of,
)
from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    AnyScene,
    AsJson,
    Changes,
    Exit,
    SceneName,
    Version,
    check_output,
    chosen_scene,
    chosen_spec,
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
)

if TYPE_CHECKING:
    from gallop_fmu.simulation.result import Result
    from gallop_fmu.simulation.simulate import Progress
    from gallop_fmu.sweeps.runner import Progress as RunsProgress
    from gallop_fmu.sweeps.runs import Runs


ModelName = Annotated[
    str,
    typer.Option(
        hidden=True, help="Of 0.1.0, which had a second model; the next release drops it."
    ),
]

RESULT_SUFFIXES = (".nc", ".csv", ".parquet")

app = new_app("gallop-fmu")


@app.callback()
def _root(version: Version = False) -> None:
    """Galloping of iced overhead-line conductors: compute a span, or export it as an FMU."""


@app.command(epilog=example("gallop-fmu scenes --json"))
def scenes(as_json: AsJson = False) -> None:
    """List the scenes that come with the package."""
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
app.command(epilog=example(NEW_EXAMPLE))(new)


@app.command(
    epilog=example(
        "gallop-fmu run example3 --until 900 --set wind.speed=5.5 --out swing.nc --plot swing.png"
    )
)
def run(
    scene: SceneName,
    until: Annotated[
        float | None,
        typer.Option(metavar="S", parser=real, help="Simulated time \\[s]; else the scene's."),
    ] = None,
    changes: Changes = None,
    every: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            parser=whole(),
            help="Time steps from one record to the next; else the scene's.",
        ),
    ] = None,
    nodes: Annotated[Literal["midspan", "all"], typer.Option(help="Nodes to record.")] = "midspan",
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
                "Drive wind and tower points by a CSV file as FMPy reads it: time and names of the"
                " FMU's inputs."
            ),
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compute the motion of a span and print what happened at mid-span."""
    from gallop_fmu.foundation.outcome import Outcome, SimulationError
    from gallop_fmu.input.input_csv import with_inputs
    from gallop_fmu.simulation.result import summary
    from gallop_fmu.simulation.run_options import check_model
    from gallop_fmu.simulation.simulate import simulate

    check_model(model)
    chosen = chosen_scene(scene, changes)
    if inputs:
        chosen = with_inputs(chosen, inputs)
    check_output(out, RESULT_SUFFIXES)
    check_output(plot, PICTURE_SUFFIXES)
    with _progress(chosen.title, silent=as_json) as shown:
        result = simulate(
            chosen,
            until,
            record_every=every,
            record_nodes=nodes,
            progress=shown,
            on_failure="return",
        )
    if not result.started:
        raise SimulationError(result.report, result)
    written, unwritten = _write(result, out, plot)
    if as_json:
        echo_json({**summary(result), "files": list(map(str, written))})
    else:
        _print_summary(summary(result), result, written)
    if result.outcome is not Outcome.COMPLETED:
        kept = (
            f"what was computed until then is in {', '.join(map(str, written))}"
            if written
            else "nothing was written"
        )
        complain(f"{result.report} The run ended early; {kept}.")
    for problem in unwritten:
        complain(
            f"{problem.filename}: cannot be written ({problem.strerror}); a file that stood there"
            " is as it was"
        )
    if unwritten:
        raise typer.Exit(Exit.BAD_INPUT)
    if result.outcome is not Outcome.COMPLETED:
        raise typer.Exit(Exit.ENDED_EARLY)


@app.command(
    epilog=example(
        "gallop-fmu sweep example3 --over wind.speed=4:7:0.5 --until 900 -o winds.parquet"
    )
)
def sweep(
    scene: AnyScene = None,
    changes: Changes = None,
    over: Over = None,
    table: SpanTable = None,
    until: Annotated[
        float | None,
        typer.Option(metavar="S", parser=real, help="Simulated time \\[s]; else the scene's."),
    ] = None,
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
    out: RunsOut = None,
    workers: WorkerCount = None,
    cluster: ClusterAddress = None,
    as_json: AsJson = False,
) -> None:
    """Simulate a scene over values of its parameters, every span of a table, or both.

    One row a run: amplitudes, frequencies, extremes, clearance, and how it ended. Runs that fail
    are rows too.

    The same command again continues a sweep that was stopped or killed, from the journal
    FILE.journal.
    """
    from gallop_fmu.sweeps.sweep import sweep as sweep_scenes

    check_given(scene, over, table)
    base = chosen_spec(scene, changes) if scene else None
    columns = (
        "outcome",
        "motion",
        "u2_amplitude",
        "u2_frequency_hz",
        "u3_amplitude",
        "beyond_cigre_322",
    )

    def compute(progress: RunsProgress | None) -> Runs:
        return sweep_scenes(
            base,
            grid_of(over),
            table=table,
            stop_time=until,
            window=window,
            model=model,
            out=out,
            workers=workers,
            cluster=cluster,
            progress=progress,
        )

    carry_out("gallop-fmu", compute, columns, out, as_json=as_json)


@app.command(
    epilog=example("gallop-fmu export example3 -o example3.fmu --set numerics.time_step=0.005")
)
def export(
    scene: SceneName,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="FMU to write.")],
    changes: Changes = None,
    runtime: Annotated[
        Literal["native", "python"],
        typer.Option(
            help=(
                "What runs inside the FMU: the compiled kernel, or Python, which the host then"
                " needs."
            )
        ),
    ] = "native",
    platforms: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help=(
                "Platforms to compile for, of linux64,win64,darwin64, with commas; needs the extra"
                " cross, and minutes "
                "the first time. Else the FMU is for this one."
            ),
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write a scene as an FMI 2.0 co-simulation FMU."""
    from gallop_fmu.fmu import ExportError, export_fmu
    from gallop_fmu.foundation.errors import SceneError

    try:
        names = platforms.split(",") if platforms else None
        chosen = chosen_scene(scene, changes)
        complain_of(chosen)
        path = export_fmu(chosen, out, runtime=runtime, platforms=names)
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
    """Check an FMU against its standard, and that it runs."""
    if not fmu.is_file():
        state = "not a file" if fmu.exists() else "no such file"
        complain(
            f"{fmu}: {state}; to be checked is an FMU, as gallop-fmu export SCENE -o FILE.fmu"
            " writes it"
        )
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
            metavar="DIR", help="Folder for FMU, histories and picture; made if it does not exist."
        ),
    ] = Path("gallop-demo"),
) -> None:
    """Run example 3 as an FMU until galloping wakes the swing, and show what happened."""
    from gallop_fmu.cli.demo import run_demo

    if out_dir.exists() and not out_dir.is_dir():
        complain(f"{out_dir}: is a file; --out-dir takes a folder")
        raise typer.Exit(Exit.BAD_INPUT)
    out_dir.mkdir(parents=True, exist_ok=True)
    with _progress("example 3 in an FMU", silent=False) as shown:
        story = run_demo(out_dir, progress=shown)
    new_console().print(story.text(), soft_wrap=True)


@app.command(
    hidden=True, context_settings={"ignore_unknown_options": True, "help_option_names": []}
)
def report(words: Annotated[list[str] | None, typer.Argument()] = None) -> None:
    """Say where the command is that was here in 0.1.0."""
    from shlex import join

    complain(
        "report is a command of gallop-modal now:"
        f" {join(['gallop-modal', 'report', *(words or ())])}"
    )
    raise typer.Exit(Exit.BAD_INPUT)


def main() -> None:
    """Entry point of the command ``gallop-fmu``."""
    start(app, "gallop-fmu")


def _write(result: Result, out: Path | None, plot: Path | None) -> tuple[list[Path], list[OSError]]:
    """What was written, and what could not be: one full disk must not cost the other file, nor the summary."""
    written, unwritten = [], []
    try:
        written += [result.save(out)] if out else []
    except OSError as problem:
        unwritten.append(problem)
    if plot:
        from gallop_fmu.plots import overview, save_figure

        try:
            written.append(save_figure(overview(result), plot))
        except OSError as problem:
            unwritten.append(problem)
    return written, unwritten


@contextmanager
def _progress(title: str, *, silent: bool) -> Iterator[Progress | None]:
    """Simulated time on a bar."""
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


MIDSPAN_ROWS = {"u2": "vertical u2", "u3": "horizontal u3", "theta": "twist", "tension": "tension"}


def _print_summary(numbers: dict[str, Any], result: Result, written: list[Path]) -> None:
    from gallop_fmu.simulation.result import frequency_text

    attrs, console = result.dataset.attrs, new_console()
    console.print(numbers["title"], style="bold")
    console.print(
        f"sag {attrs['sag']:.3f} m, horizontal tension {attrs['horizontal_tension'] / 1000:.3f} kN"
    )
    console.print(f"motion: {numbers['motion']}", soft_wrap=True)
    headings = ("amplitude", "mean", "frequency [Hz]", "motion", "range in the run")
    table = new_table(f"mid-span, last {numbers['window']:g} s", *headings)
    for name, row in numbers["midspan"].items():
        unit = result.dataset[name].attrs["units"]
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
    console.print(
        f"{numbers['steps']} steps, {numbers['iterations']} Newton iterations,"
        f" {numbers['seconds']:.2f} s: {numbers['real_time_factor']:.0f} times real time; lowest"
        f" tension {numbers['lowest_tension'] / 1000:.3f} kN"
    )
    if attrs["left_out"]:
        console.print(
            f"inactive terms (no effect in this scene): {attrs['left_out']}",
            style="dim",
            soft_wrap=True,
        )
    print_warnings(result.warnings)
    for path in written:
        console.print(f"wrote {path}", soft_wrap=True)
