"""The help of every command fits a terminal of 80 columns, and describes every option."""

from itertools import pairwise
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from gallop_fmu.cli import main as simulation_cli
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


def test_the_table_of_functions_names_what_exists():
    page = (Path(__file__).parents[3] / "docs" / "reference" / "commands.md").read_text("utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    named = {tuple(row.split("`")[1].split()) for row in rows}
    only_there = {("gallop-fmu", name) for name in ("curves", "new", "demo", "doctor")}
    assert named == set(COMMANDS) - only_there
    packages = {"gallop_fmu": gf, "modal": modal}
    for row in rows:
        for word in row.split("`")[3::2]:
            if "." in word:
                package, name = word.split(".")
                assert name in packages[package].__all__, word
