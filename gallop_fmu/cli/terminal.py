"""Parts of both commands: arguments, tables, JSON, progress, error messages.

Functions import what they need themselves, so that ``--help`` is fast.
"""

from __future__ import annotations

import io
import json
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from gallop_fmu.input.scene_spec import SceneSpec
    from gallop_fmu.scene.line_scene import LineScene
    from gallop_fmu.scene.scene import Scene
    from gallop_fmu.scene.scene_base import SceneBase


class Exit(IntEnum):
    """Exit codes, as listed in ``--help``."""

    SUCCESS = 0
    ENDED_EARLY = 1
    BAD_INPUT = 2


RENAMED_OPTIONS = {
    "--until": "--stop-time",
    "--every": "--record-every",
    "--nodes": "--record-nodes",
    "--highest": "--highest-wind",
    "--saturation": "--saturation-deg",
    "--first-look": "--estimate-only",
    "--by": "--numbers",
    "--string-limit": "--string-pull",
    "--pull-limit": "--unbalanced-pull",
}
"""Names of options before 0.3.0, which have a warning for one release, and the names now."""


class Commands(TyperGroup):
    """Group of commands that prints each expected error as one message with an exit code."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Find the command, and replace options that have another name now."""
        name, found, rest = super().resolve_command(ctx, args)
        parameters = found.params if found else ()
        options = {option for parameter in parameters for option in parameter.opts}
        return name, found, [self._renamed(word, options, ctx) for word in rest]

    @staticmethod
    def _renamed(word: str, options: set[str], ctx: Any) -> str:
        old, equals, value = word.partition("=")
        new = RENAMED_OPTIONS.get(old)
        if new not in options:
            return word
        complain(f"warning: {old} is now called {new}", ctx.find_root().info_name)
        return f"{new}{equals}{value}"

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command; the paragraphs of its help are filled, and brackets are plain text."""
        found = super().get_command(ctx, cmd_name)
        if found is not None and found.help and "\\[" not in found.help:
            paragraphs = found.help.replace("[", "\\[").split("\n\n")
            found.help = "\n\n".join(" ".join(each.split()) for each in paragraphs)
        return found

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        from gallop_fmu.foundation.errors import SceneError
        from gallop_fmu.foundation.outcome import SimulationError

        program = ctx.find_root().info_name
        try:
            return super().invoke(ctx)
        except SimulationError as problem:
            complain(str(problem), program)
            raise typer.Exit(Exit.ENDED_EARLY) from None
        except SceneError as problem:
            complain(str(problem), program)
            raise typer.Exit(Exit.BAD_INPUT) from None
        except BrokenPipeError:  # `gallop-fmu scenes | head` is not an error; typer ends silently
            raise
        except OSError as problem:
            place = f"{problem.filename}: " if problem.filename else ""
            complain(f"{place}{problem.strerror or problem}", program)
            raise typer.Exit(Exit.BAD_INPUT) from None
        except KeyboardInterrupt:
            complain("stopped on request", program)
            raise typer.Exit(Exit.ENDED_EARLY) from None


def real(text: str | float) -> float:
    """Parse a number by the rule for files and tables; a default is a number already."""
    from gallop_fmu.foundation.text_rules import number_remedy, read_number

    number = read_number(text) if isinstance(text, str) else text
    if number is None:
        remedy = number_remedy(str(text))
        raise typer.BadParameter(f"{text!r} is not a number{f'; {remedy}' if remedy else ''}")
    return float(number)


def whole(lowest: int = 0, highest: int = 1_000_000) -> Callable[[str | int], int]:
    """Return a parser of whole numbers between bounds."""

    def parse(text: str | int) -> int:
        number = real(text)
        if not (number.is_integer() and lowest <= number <= highest):
            raise typer.BadParameter(f"{text} is not a whole number from {lowest} to {highest}")
        return int(number)

    return parse


EXIT_CODES = (
    "Exit codes: 0: success; 1: the calculation ended early or was stopped with Ctrl-C (the results"
    " until then are written), or a check failed; 2: invalid input, no result, or file error."
)


def new_app(name: str) -> typer.Typer:
    """Return a command line with tab completion and the exit codes below its help.

    Parameters
    ----------
    name
        Name of the command; its help begins with the docstring of the application's callback.
    """
    return typer.Typer(
        name=name,
        cls=Commands,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode="rich",
        epilog=EXIT_CODES,
        context_settings={"help_option_names": ["-h", "--help"]},
    )


def start(app: typer.Typer, name: str) -> None:
    """Run a command line."""
    os.environ["MPLBACKEND"] = (
        "Agg"  # figures go to files; Jupyter sets a backend that may be missing here
    )
    _repair_streams()
    app(prog_name=name)


def _repair_streams() -> None:
    """Open missing standard streams on the null device; escape characters they cannot encode."""
    # A file opened later would otherwise get the number of a missing stream, and its output.
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _show_version(context: typer.Context, wanted: bool) -> None:
    if wanted:
        from gallop_fmu.foundation.version import version

        typer.echo(f"{context.find_root().info_name} {version()}")
        raise typer.Exit(Exit.SUCCESS)


Version = Annotated[
    bool,
    typer.Option(
        "--version", callback=_show_version, is_eager=True, help="Print the version and exit."
    ),
]


def _scene_names(incomplete: str) -> list[str]:
    """Packaged scenes and scene files that begin with the typed text."""
    from gallop_fmu.input.scene_files import packaged_scenes

    typed = Path(incomplete)
    folder = typed if incomplete.endswith(("/", "\\")) else typed.parent
    files = sorted(map(str, folder.glob("*.toml"))) if folder.is_dir() else []
    return [name for name in [*packaged_scenes(), *files] if name.startswith(incomplete)]


def code_words(incomplete: str) -> list[str]:
    """Code words of conductors that begin with the typed text."""
    from gallop_fmu.line.conductors import conductors

    return [
        wire.code_word for wire in conductors().values() if wire.code_word.startswith(incomplete)
    ]


PICTURE_SUFFIXES = (".png", ".svg", ".pdf")

TABLE_SUFFIXES = (".nc", ".csv")

SceneName = Annotated[
    str,
    typer.Argument(
        metavar="SCENE",
        autocompletion=_scene_names,
        help="Name of a packaged scene, or path of a scene file (TOML).",
    ),
]
AnyScene = Annotated[
    str | None,
    typer.Argument(
        metavar="SCENE",
        autocompletion=_scene_names,
        help="Name or path of a scene; optional if each row of a table names its own.",
    ),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help=(
            "Change a value of the scene; may be repeated. A number, a text, or an array or table"
            " as in TOML; [bold]none[/bold] removes the value."
        ),
    ),
]
StopTime = Annotated[
    float | None,
    typer.Option(metavar="S", parser=real, help="Simulated time in s (default: from the scene)."),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print JSON instead of a table, and show no progress.")
]


def example(text: str) -> str:
    """Format the example below the help of a command."""
    return f"[dim]Example:[/dim] [bold]{text}[/bold]"


def chosen_scene(name: str, changes: list[str] | None) -> Scene | LineScene:
    """Load the named scene, of one span or of a line, and apply the changes of ``--set``."""
    return chosen_spec(name, changes).scene()


def chosen_spec(name: str, changes: list[str] | None) -> SceneSpec:
    """Load the named scene with its ``[line]`` unresolved, so that tables can change it."""
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.input.scene_spec import SceneSpec

    values: dict[str, Any] = {}
    for key, value in map(_change, changes or ()):
        if key in values:
            raise SceneError(f"--set {key}: given twice; give one value")
        values[key] = value
    return SceneSpec.of(name).with_values(values)


def _change(text: str) -> tuple[str, Any]:
    """Split ``key=value``; a value that is not TOML is a text."""
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.foundation.text_files import parse_value
    from gallop_fmu.input.scene_spec import is_text_key

    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals and value):
        raise SceneError(f"--set {text}: must be KEY=VALUE, such as --set wind.speed=6.0")
    try:
        return key, parse_value(value, as_text=is_text_key(key))
    except SceneError as problem:
        raise SceneError(f"--set {key}: {problem}") from None


def check_output(path: Path | None, suffixes: tuple[str, ...]) -> None:
    """Refuse a file that cannot be written, before a long run."""
    from gallop_fmu.foundation.atomic_write import check_target

    if path is not None:
        check_target(path, suffixes)


def new_table(*headings: str) -> Any:
    """Return a plain table with these columns."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    class WordTable(Table):
        """Table that breaks lines between words if the longest words of all columns fit."""

        def __rich_console__(self, console: Any, options: Any) -> Any:
            """Give each column the width of its longest word, and share the rest."""
            room = options.max_width - 3 * len(self.columns) + 1
            columns: list[Any] = self.columns
            for change in (str, _with_breaks):  # first without breaks inside names
                texts = [
                    [change(str(cell)) for cell in (column.header, *column.cells)]
                    for column in columns
                ]
                if widths := _column_widths(texts, room):
                    for column, width in zip(columns, widths, strict=True):
                        column.width = width
                        column.header, *column._cells = (
                            change(cell) if isinstance(cell, str) else cell  # else styled text
                            for cell in (column.header, *column.cells)
                        )
                    break
            yield from super().__rich_console__(console, options)

    made = WordTable(box=SIMPLE_HEAD, pad_edge=False)
    for heading in headings:
        made.add_column(heading, overflow="fold")  # fold: never cut a value
    return made


def _with_breaks(text: str) -> str:
    return re.sub(r"(?<=[a-z])[._](?=[a-z])", r"\g<0>\n", text)


def _column_widths(texts: Sequence[Sequence[str]], room: int) -> list[int] | None:
    """Return widths that do not break words, or None if there is not enough room."""
    from rich.cells import cell_len

    def longest(parts: Iterable[str]) -> int:
        return max(map(cell_len, parts), default=0)

    widths = [longest(word for text in column for word in text.split()) for column in texts]
    room -= sum(widths)
    if room < 0:
        return None
    for part in slice(1, None), slice(0, 1):  # first widen for cells, then for headings
        lacking = [
            max(0, longest(line for text in column[part] for line in text.splitlines()) - width)
            for column, width in zip(texts, widths, strict=True)
        ]
        for k in sorted(range(len(texts)), key=lacking.__getitem__):
            more = min(room, lacking[k])
            widths[k], room = widths[k] + more, room - more
    return widths


def new_console(*, stderr: bool = False) -> Console:
    """Return a console for human-readable output that escapes control characters."""
    from rich.console import Console

    from gallop_fmu.foundation.text_rules import printable

    class PlainConsole(Console):
        """Console that prints text without markup and escapes control characters."""

        def render_str(self, text: str, **options: Any) -> Any:
            """Render a text or a cell of a table."""
            return super().render_str(printable(text), **options)

    return PlainConsole(stderr=stderr, highlight=False, markup=False, emoji=False)


def work_text(numbers: Mapping[str, Any]) -> str:
    """Return the work and the speed of a run as text."""
    return (
        f"{numbers['steps']} steps, {numbers['iterations']} Newton iterations,"
        f" {numbers['seconds']:.2f} s: {numbers['real_time_factor']:.0f} times real time; lowest"
        f" tension {numbers['lowest_tension'] / 1000:.3f} kN"
    )


def print_warnings(sentences: Iterable[str]) -> None:
    """Print the warnings of a result below its numbers."""
    console = new_console()
    for sentence in sentences:
        console.print(f"warning: {sentence}", style="yellow", soft_wrap=True)


@contextmanager
def progress_bar(title: str, *, silent: bool = False) -> Iterator[Progress | None]:
    """Show a bar with the time left on standard error, if it is a terminal."""
    if silent or not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}", markup=False), BarColumn(), TimeRemainingColumn()
    with Progress(*columns, console=new_console(stderr=True), transient=True) as bar:
        bar.console.print(title, style="dim")
        yield bar


def echo_json(data: Any) -> None:
    """Print JSON; NaN and infinity become null."""
    finite = json.loads(json.dumps(data), parse_constant=lambda _: None)
    typer.echo(json.dumps(finite, indent=2))


def complain_of(scene: SceneBase, program: str | None = None) -> None:
    """Print the warnings of a scene on standard error."""
    for sentence in scene.warnings:
        complain(f"warning: {sentence}", program)


def complain(message: str, program: str | None = None) -> None:
    """Print a message on standard error, after the name of the command."""
    complain_more(f"{program or 'gallop-fmu'}: {message}")


def complain_more(line: str) -> None:
    """Print one more line on standard error."""
    from gallop_fmu.foundation.text_rules import printable

    typer.echo(printable(line), err=True)
