"""`gallop-fmu run` with the scene of a line: tables, JSON, refusals."""

import json

import pytest

from gallop_fmu.cli.main import app
from support.sections import section


@pytest.fixture(scope="module")
def line(tmp_path_factory):
    path = tmp_path_factory.mktemp("line") / "line.toml"
    section(phases=[{"name": "a"}, {"name": "b", "offset": [4.0, 0.0]}]).save(path)
    return str(path)


@pytest.fixture
def run():
    from typer.testing import CliRunner

    return lambda *words: CliRunner().invoke(app, ["run", *words])


def test_the_text_has_spans_strings_towers_and_clearances(run, line):
    found = run(line, "--until", "0.2")
    assert found.exit_code == 0
    for part in ("2, phase 1", "string at", "force x2 [kN]", "1 and 2", "times real time"):
        assert part in found.stdout


def test_the_json_has_their_numbers(run, line, tmp_path):
    out = tmp_path / "line.nc"
    found = json.loads(run(line, "--until", "0.2", "--json", "--out", str(out)).stdout)
    assert [row["span"] for row in found["spans"]] == [1, 1, 2, 2, 3, 3]
    assert [row["kind"] for row in found["strings"]] == ["string"] * 4
    assert len(found["towers"]) == 8
    assert found["files"] == [str(out)]


def test_a_picture_is_refused_before_the_run(run, line):
    found = run(line, "--plot", "line.png")
    assert found.exit_code == 2
    assert "--plot takes a scene of one span" in found.stderr
