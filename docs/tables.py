"""MkDocs hook: tables made from the program itself, so that they match it, and equations."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, get_args, get_origin

import typer
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from gallop_fmu.cli.main import app as gallop
from gallop_fmu.fmu.variables import variable_table
from gallop_fmu.line.line_table import Line
from gallop_fmu.scene.dotted_paths import section_classes
from gallop_fmu.scene.fields import Section, unit_of_field
from gallop_fmu.scene.validation_messages import BOUNDS
from modal.cli.main import app as toolkit

TRUST = Path(__file__).parents[1] / "benchmarks" / "accuracy" / "trust.md"

README = Path(__file__).parents[1] / "README.md"

MARK = re.compile(r"\{\{ (\w+) \}\}")
EQUATIONS = re.compile(r"^```math\n(.*?)^```$", re.DOTALL | re.MULTILINE)
"""Equations in LaTeX, in the form that GitHub shows."""


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace each mark such as ``{{ fmu }}`` by its table; a mark without a table is an error."""
    tables = {
        "readme": readme,
        "scene": scene_tables,
        "line": line_table,
        "line_scene": line_scene_tables,
        "fmu": fmu_table,
        "commands": command_help,
        "trust": trust_table,
        "gallop_fmu": partial(public_names, gf),
        "modal": partial(public_names, modal),
    }
    markdown = EQUATIONS.sub(lambda found: typeset(found[1]), markdown)
    return MARK.sub(lambda mark: "\n".join(tables[mark[1]]()), markdown)


def readme() -> Iterator[str]:
    """The README; its links to files that are not pages become text."""
    text = README.read_text(encoding="utf-8").replace("](docs/", "](")
    yield re.sub(
        r"\[([^\]]+)\]\((?!https?://)(?!(?:tutorial|how-to|concepts|reference)/|[\w-]+\.png)[^)]*\)",
        r"\1",
        text,
    )


def typeset(latex: str) -> str:
    """Return equations as MathML, which browsers show without a program."""
    from latex2mathml.converter import convert

    return f'<div class="equations">{convert(latex.strip(), display="block")}</div>\n'


def public_names(package: ModuleType) -> Iterator[str]:
    """Reference of each public name of a package, for mkdocstrings: functions, then classes."""
    for is_function in (True, False):
        names = [name for name in package.__all__ if name.islower() is is_function]
        yield from (
            f"::: {package.__name__}",
            "    options:",
            f"      members: [{', '.join(names)}]",
            "",
        )


def scene_tables() -> Iterator[str]:
    """One heading and table for each kind of section of a scene, in order of declaration."""
    yield from _tables(_places("", gf.Scene))


def line_scene_tables() -> Iterator[str]:
    """Headings and tables of a line for what a scene of one span does not have."""
    known = _places("", gf.Scene)
    found = _places("", gf.LineScene)
    yield from _tables({kind: places for kind, places in found.items() if kind not in known})


def line_table() -> Iterator[str]:
    """The line data from which a scene can be computed."""
    yield from _tables(_places("line", Line))


def _places(
    path: str, section: type[Section], found: dict[type[Section], list[str]] | None = None
) -> dict[type[Section], list[str]]:
    """Return the paths at which each kind of section stands, in order of declaration."""
    found = {} if found is None else found
    places = found.setdefault(section, [])
    if path not in places:
        places.append(path)
    for name, field in section.model_fields.items():
        item = "[]" if get_origin(field.annotation) is tuple else ""
        for inside in section_classes(field.annotation):
            _places(f"{path}.{name}{item}".lstrip("."), inside, found)
    return found


def _tables(found: dict[type[Section], list[str]]) -> Iterator[str]:
    """Heading and table of each kind of section; the heading has its first path."""
    for section, (path, *others) in found.items():
        rows = [
            f"| `{name}` | {unit_of_field(field)} | {_default(field)} | {_range(field)} |"
            f" {_cell(field.description)} |"
            for name, field in section.model_fields.items()
            if not section_classes(field.annotation) or unit_of_field(field)
        ]
        if not rows:
            continue
        kind = section.model_fields["kind"].default if "kind" in section.model_fields else None
        title = f"`{path}`" if path else "The scene itself"
        yield f"\n## {title}{f', kind = `{kind}`' if kind else ''}\n"
        yield f"{(section.__doc__ or '').strip().splitlines()[0]}\n"
        if others:
            yield f"Also at {', '.join(f'`{each}`' for each in others)}.\n"
        yield from (
            "| Name | Unit | Default | Range | Meaning |",
            "| --- | --- | --- | --- | --- |",
            *rows,
        )


def _default(field: FieldInfo) -> str:
    if field.default is PydanticUndefined:
        return "**needed**"
    return "" if field.default in (None, "", (), {}) else f"`{field.default}`"


def _range(field: FieldInfo) -> str:
    choices = get_args(field.annotation)
    if choices and all(isinstance(choice, str) for choice in choices):
        return ", ".join(f"`{choice}`" for choice in choices)
    return ", ".join(
        f"{word} {getattr(rule, name):g}"
        for rule in field.metadata
        for name, word in BOUNDS.items()
        if hasattr(rule, name)
    )


def fmu_table() -> Iterator[str]:
    """The variables of example3's FMU."""
    yield (
        "| Name | Causality | Type | Unit | Start | Description |\n| --- | --- | --- | --- | --- |"
        " --- |"
    )
    for row in variable_table(gf.load_scene("example3")):
        start = _cell(row["start"])
        yield (
            f"| `{row['name']}` | {row['causality']} | {row['type']} | {row['unit']} | {start} | "
            f"{_cell(row['description'])} |"
        )


def trust_table() -> Iterator[str]:
    """The comparisons that ``benchmarks/accuracy/trust.py`` wrote."""
    yield TRUST.read_text(encoding="utf-8")


def command_help() -> Iterator[str]:
    """The output of `--help` of every command of both programs."""
    plain = CliRunner(env={"COLUMNS": "84", "TERM": "dumb", "NO_COLOR": "1"})
    for program, app in (("gallop-fmu", gallop), ("gallop-modal", toolkit)):
        for name, command in sorted(typer.main.get_command(app).commands.items()):
            if command.hidden:
                continue
            shown = plain.invoke(app, [name, "--help"], prog_name=program, catch_exceptions=False)
            yield f"\n## {program} {name}\n\n```text\n{shown.stdout.strip()}\n```"


def _cell(text: str | None) -> str:
    return (text or "").replace("|", "\\|").replace("\n", " ")
