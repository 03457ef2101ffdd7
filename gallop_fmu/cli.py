"""The command ``gallop-fmu``.  Whatever a command needs is imported inside it, so that ``--help`` answers at once."""

from __future__ import annotations

import json
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from typer.core import TyperGroup

if TYPE_CHECKING:
    from rich.console import Console

    from gallop_fmu.result import Result
    from gallop_fmu.scene import Scene
    from gallop_fmu.simulation import Progress


class Exit(IntEnum):
    """Exit codes, as told in ``--help``."""

    FINE = 0
    ENDED_EARLY = 1
    BAD_INPUT = 2


class Commands(TyperGroup):
    """The group of commands: turns what a user can cure into one message on standard error and an exit code."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        from gallop_fmu.errors import SceneError
        from gallop_fmu.outcome import SimulationError

        try:
            return super().invoke(ctx)
        except SimulationError as problem:
            _complain(str(problem))
            raise typer.Exit(Exit.ENDED_EARLY) from None
        except SceneError as problem:
            _complain(str(problem))
            raise typer.Exit(Exit.BAD_INPUT) from None
        except BrokenPipeError:  # `gallop-fmu scenes | head` is no error; typer ends quietly
            raise
        except OSError as problem:
            place = f"{problem.filename}: " if problem.filename else ""
            _complain(f"{place}{problem.strerror or problem}")
            raise typer.Exit(Exit.BAD_INPUT) from None
        except KeyboardInterrupt:
            _complain("stopped on request")
            raise typer.Exit(Exit.ENDED_EARLY) from None


EPILOGUE = (
    "Exit codes: 0 all is fine; 1 the calculation ended early or was stopped with Ctrl-C (what was computed is still "
    "written), or a check failed; 2 bad input, or a file that cannot be read or written."
)

RESULT_SUFFIXES = (".nc", ".csv")
PICTURE_SUFFIXES = (".png", ".svg", ".pdf")

app = typer.Typer(
    cls=Commands,
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    epilog=EPILOGUE,
    context_settings={"help_option_names": ["-h", "--help"]},
)

SceneName = Annotated[
    str, typer.Argument(metavar="SCENE", help="Name of a packaged scene, or path of a scene file (TOML).")
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change a value of the scene, as often as needed; values as in TOML, [bold]none[/bold] removes one.",
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of a table, and show no progress.")]


def _example(text: str) -> str:
    return f"[dim]Example:[/dim] [bold]{text}[/bold]"


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"gallop-fmu {version('gallop-fmu')}")
        raise typer.Exit(Exit.FINE)


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Galloping of iced overhead-line conductors: compute a span, or export it as an FMU."""


@app.command(epilog=_example("gallop-fmu scenes --json"))
def scenes(as_json: AsJson = False) -> None:
    """List the scenes that come with the package."""
    from gallop_fmu.scene import packaged_scenes

    found = packaged_scenes()
    if as_json:
        _echo_json(found)
        return
    table = _table("scene", "title")
    for name, title in found.items():
        table.add_row(name, title)
    _console().print(table)


@app.command(
    epilog=_example("gallop-fmu run example3 --until 900 --set wind.speed=5.5 --out swing.nc --plot swing.png")
)
def run(
    scene: SceneName,
    until: Annotated[float | None, typer.Option(metavar="S", help="Simulated time \\[s]; else the scene's.")] = None,
    changes: Changes = None,
    every: Annotated[
        int | None, typer.Option(metavar="N", help="Time steps from one record to the next; else the scene's.")
    ] = None,
    nodes: Annotated[Literal["midspan", "all"], typer.Option(help="Nodes to record.")] = "midspan",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the histories: .nc (NetCDF) or .csv (mid-span only).")
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Write a picture: .png, .svg or .pdf.")] = None,
    as_json: AsJson = False,
) -> None:
    """Compute the motion of a span and print what happened at mid-span."""
    from gallop_fmu.outcome import Outcome
    from gallop_fmu.result import summary
    from gallop_fmu.simulation import simulate

    chosen = _scene(scene, changes)
    _check_output(out, RESULT_SUFFIXES)
    _check_output(plot, PICTURE_SUFFIXES)
    with _progress(chosen.title, silent=as_json) as shown:
        result = simulate(
            chosen,
            until,
            record_every=every,
            record_nodes=nodes,
            progress=shown,
            on_failure="return",
        )
    written = _write(result, out, plot)
    if as_json:
        _echo_json({**summary(result), "files": list(map(str, written))})
    else:
        _print_summary(summary(result), result, written)
    if result.outcome is not Outcome.COMPLETED:
        kept = (
            f"what was computed until then is in {', '.join(map(str, written))}" if written else "nothing was written"
        )
        _complain(f"{result.report} The run ended early; {kept}.")
        raise typer.Exit(Exit.ENDED_EARLY)


@app.command(epilog=_example("gallop-fmu export example3 -o example3.fmu --set numerics.time_step=0.005"))
def export(
    scene: SceneName,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="FMU to write.")],
    changes: Changes = None,
    runtime: Annotated[
        Literal["native", "python"],
        typer.Option(help="What runs inside the FMU: the compiled kernel, or Python, which the host then needs."),
    ] = "native",
    platforms: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="Platforms to compile for, of linux64,win64,darwin64, with commas; needs the extra cross, and minutes "
            "the first time. Else the FMU is for this one.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write a scene as an FMI 2.0 co-simulation FMU."""
    from gallop_fmu.errors import SceneError
    from gallop_fmu.fmu import ExportError, export_fmu

    try:
        names = platforms.split(",") if platforms else None
        path = export_fmu(_scene(scene, changes), out, runtime=runtime, platforms=names)
    except ExportError as problem:
        raise SceneError(str(problem)) from None
    size = path.stat().st_size
    if as_json:
        _echo_json({"file": str(path), "bytes": size, "runtime": runtime})
    else:
        _console().print(f"wrote {path} ({size / 1e6:.2f} MB)")


@app.command(epilog=_example("gallop-fmu check example3.fmu"))
def check(
    fmu: Annotated[Path, typer.Argument(metavar="FMU", help="FMU to check.")],
    as_json: AsJson = False,
) -> None:
    """Check an FMU against its standard, and that it runs."""
    if not fmu.is_file():
        _complain(f"{fmu}: {'not a file' if fmu.exists() else 'no such file'}")
        raise typer.Exit(Exit.BAD_INPUT)
    from gallop_fmu.fmu import check_fmu

    found = check_fmu(fmu).rows
    if as_json:
        _echo_json([{"name": name, "ok": ok, "detail": detail} for name, ok, detail in found])
    else:
        from rich.text import Text

        table = _table("check", "", "detail")
        for name, ok, detail in found:
            table.add_row(name, Text("passed", "green") if ok else Text("FAILED", "red"), detail)
        _console().print(table)
    failed = [name for name, ok, _ in found if not ok]
    if failed:
        _complain(f"{fmu}: {len(failed)} of {len(found)} checks failed: {', '.join(failed)}")
        raise typer.Exit(Exit.ENDED_EARLY)


@app.command(epilog=_example("gallop-fmu demo --out-dir demo"))
def demo(
    out_dir: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for FMU, histories and picture; made if it does not exist.")
    ] = Path("gallop-demo"),
) -> None:
    """Run example 3 as an FMU until galloping wakes the swing, and show what happened."""
    from gallop_fmu.demo import run_demo

    out_dir.mkdir(parents=True, exist_ok=True)
    with _progress("example 3 in an FMU", silent=False) as shown:
        story = run_demo(out_dir, progress=shown)
    _console().print(story.text(), soft_wrap=True)


def main() -> None:
    """Entry point of the command ``gallop-fmu``."""
    app(prog_name="gallop-fmu")


def _scene(name: str, changes: list[str] | None) -> Scene:
    from gallop_fmu.scene import load_scene

    scene = load_scene(name)
    return scene.with_values(dict(map(_change, changes))) if changes else scene


def _change(text: str) -> tuple[str, Any]:
    """Key and value of ``key=value``; what is not TOML is taken as text, for the scene to accept or refuse."""
    from gallop_fmu.errors import SceneError

    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals and value):
        raise SceneError(f"--set {text}: must be KEY=VALUE, such as --set wind.speed=6.0")
    if value == "none":
        return key, None
    try:
        parsed = tomllib.loads(f"value = {value}")
    except tomllib.TOMLDecodeError:
        return key, value
    return key, parsed["value"] if len(parsed) == 1 else value


def _check_output(path: Path | None, suffixes: tuple[str, ...]) -> None:
    """Find out before a long run, not after it, that its results cannot be written."""
    from gallop_fmu.errors import SceneError

    if path is None:
        return
    if path.suffix not in suffixes:
        raise SceneError(f"{path}: must end in {' or '.join(suffixes)}, which decides the format")
    if path.is_dir():
        raise SceneError(f"{path}: is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise SceneError(f"{path}: there is no folder {path.parent}; make it first")


def _write(result: Result, out: Path | None, plot: Path | None) -> list[Path]:
    written = [result.save(out)] if out else []
    if plot:
        from gallop_fmu.plots import overview, save_figure

        written.append(save_figure(overview(result), plot))
    return written


@contextmanager
def _progress(title: str, *, silent: bool) -> Iterator[Progress | None]:
    """A bar with the time left on standard error, if somebody is there to watch."""
    if silent or not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    with Progress(*columns, console=_console(stderr=True), transient=True) as bar:
        bar.console.print(title, style="dim")
        task = bar.add_task("starting", total=None)

        def show(time: float, stop_time: float) -> bool:
            bar.update(task, completed=time, total=stop_time, description=f"{time:.0f} of {stop_time:.0f} s")
            return True

        yield show


MIDSPAN_ROWS = {"u2": "vertical u2", "u3": "horizontal u3", "theta": "twist", "tension": "tension"}


def _print_summary(numbers: dict[str, Any], result: Result, written: list[Path]) -> None:
    attrs, console = result.dataset.attrs, _console()
    console.print(numbers["title"], style="bold")
    console.print(f"sag {attrs['sag']:.3f} m, horizontal tension {attrs['horizontal_tension'] / 1000:.3f} kN")
    table = _table(f"mid-span, last {numbers['window']:g} s", "amplitude", "mean", "frequency [Hz]")
    for name, row in numbers["midspan"].items():
        unit = result.dataset[name].attrs["units"]
        table.add_row(
            f"{MIDSPAN_ROWS[name]} [{unit}]",
            f"{row['amplitude']:.5g}",
            f"{row['mean']:.5g}",
            f"{row['frequency_hz']:.4f}" if row["frequency_hz"] else "-",
        )
    if numbers["midspan"]:
        console.print(table)
        console.print("amplitude: half peak-to-peak", style="dim")
    console.print(
        f"{numbers['steps']} steps, {numbers['iterations']} Newton iterations, {numbers['seconds']:.2f} s: "
        f"{numbers['real_time_factor']:.0f} times real time; lowest tension {numbers['lowest_tension'] / 1000:.3f} kN"
    )
    for path in written:
        console.print(f"wrote {path}", soft_wrap=True)


def _table(*headings: str) -> Any:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    for heading in headings:
        table.add_column(heading)
    return table


def _console(*, stderr: bool = False) -> Console:
    from rich.console import Console

    return Console(stderr=stderr, highlight=False, markup=False)  # titles and paths may hold brackets


def _echo_json(data: Any) -> None:
    """Print JSON; what is not finite becomes null, since JSON has no NaN."""
    finite = json.loads(json.dumps(data), parse_constant=lambda _: None)
    typer.echo(json.dumps(finite, indent=2))


def _complain(message: str) -> None:
    typer.echo(f"gallop-fmu: {message}", err=True)
