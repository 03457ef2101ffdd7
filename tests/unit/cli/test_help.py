"""The help of every command fits a terminal of 80 columns, and describes every option."""

import inspect
from itertools import pairwise
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from gallop_fmu.cli import main as simulation_cli
from gallop_fmu.cli.line_commands import line_options
from gallop_fmu.cli.terminal import RENAMED_OPTIONS
from modal.cli import main as modal_cli

APPS = {"gallop-fmu": simulation_cli.app, "gallop-modal": modal_cli.app}
COMMANDS = [
    (program, name)
    for program, app in APPS.items()
    for name, command in typer.main.get_command(app).commands.items()
    if not command.hidden
]


@pytest.mark.parametrize(("program", "name"), COMMANDS)
def test_help_fits_80_columns(program, name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERMINAL_WIDTH", "80")
    shown = CliRunner().invoke(APPS[program], [name, "--help"])
    assert shown.exit_code == 0
    lines = shown.stdout.splitlines()
    assert max(len(line) for line in lines) <= 80
    assert "…" not in shown.stdout  # nothing is cut off
    assert "()" not in shown.stdout  # no word in brackets was taken for markup
    text = [line for line in lines if line.startswith(" ")]
    filled = [" ".join(line.split()) for line in text]
    for line, after in pairwise(filled):
        if after and line and not after.startswith("Usage"):
            assert len(f" {line} {after.split()[0]} ") > 80, line  # no break within a paragraph


@pytest.mark.parametrize(("program", "name"), COMMANDS)
def test_every_option_is_described(program, name):
    command = typer.main.get_command(APPS[program]).commands[name]
    shown = [option for option in command.params if not getattr(option, "hidden", False)]
    assert [option.name for option in shown if not getattr(option, "help", "")] == []


PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "commands.md").read_text("utf-8")
FUNCTION_ROWS, OPTION_ROWS = (
    [line for line in table.splitlines() if line.startswith("| `")]
    for table in PAGE.split("alone:")
)
LINE_OPTIONS = {option.opts[0] for option in line_options()}  # of `gallop-fmu new`
PACKAGES = {"gallop_fmu": gf, "modal": modal}


def _functions(row):
    """Return the functions that a row names."""
    words = [word.split(".") for word in row.split("`")[3::2] if "." in word]
    assert all(name in PACKAGES[package].__all__ for package, name in words), row
    return [getattr(PACKAGES[package], name) for package, name in words]


def test_the_table_of_functions_names_what_exists():
    named = {tuple(row.split("`")[1].split()) for row in FUNCTION_ROWS}
    only_there = {("gallop-fmu", name) for name in ("curves", "new", "demo", "doctor")}
    assert named == set(COMMANDS) - only_there
    assert all(_functions(row) for row in FUNCTION_ROWS)


def _only_options(name):
    """Return the options that the page lists as of the command line alone."""
    found = set()
    for row in OPTION_ROWS:
        words = row.split("|")[1].replace("`", "").replace(",", "").split()
        commands = {word for word in words if word in {name for _, name in COMMANDS}}
        if not commands or name in commands:
            found |= {word for word in words if word.startswith("--")}
    return found


@pytest.mark.parametrize("row", FUNCTION_ROWS, ids=lambda row: row.split("`")[1])
def test_options_are_named_as_arguments(row):
    """Unless the page lists them as options of the command line alone."""
    program, name = row.split("`")[1].split()
    arguments = {each for one in _functions(row) for each in inspect.signature(one).parameters}
    command = typer.main.get_command(APPS[program]).commands[name]
    options = {
        max(option.opts, key=len)
        for option in command.params
        if option.param_type_name == "option" and not option.hidden
    }
    same = {option for option in options if option[2:].replace("-", "_") in arguments}
    line_data = {option for option in options if name == "study"} & LINE_OPTIONS
    assert options - same - line_data == (options - same - line_data) & _only_options(name)


def test_renamed_options_exist_and_work(tmp_path):
    found = {
        option
        for program, name in COMMANDS
        for parameter in typer.main.get_command(APPS[program]).commands[name].params
        for option in parameter.opts
    }
    assert set(RENAMED_OPTIONS.values()) <= found
    assert not set(RENAMED_OPTIONS) & found
    words = ["run", "example3", "--until", "0.2", "--every=2", "--out", str(tmp_path / "a.csv")]
    done = CliRunner().invoke(APPS["gallop-fmu"], words)
    assert done.exit_code == 0
    assert done.stderr == (
        "gallop-fmu: warning: --until is now called --stop-time\n"
        "gallop-fmu: warning: --every is now called --record-every\n"
    )
    # the name of a file is not an option
    asked = CliRunner().invoke(APPS["gallop-fmu"], ["check", "--until"])
    assert "now called" not in asked.stderr
