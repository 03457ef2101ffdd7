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
    found = run(line, "--stop-time", "0.2")
    assert found.exit_code == 0
    for part in ("2, phase 1", "string at", "force x2 [kN]", "1 and 2", "times real time"):
        assert part in found.stdout


def test_the_json_has_their_numbers(run, line, tmp_path):
    out = tmp_path / "line.nc"
    found = json.loads(run(line, "--stop-time", "0.2", "--json", "--out", str(out)).stdout)
    assert [row["span"] for row in found["spans"]] == [1, 1, 2, 2, 3, 3]
    assert [row["kind"] for row in found["strings"]] == ["string"] * 4
    assert len(found["towers"]) == 8
    assert found["files"] == [str(out)]


def test_a_picture_has_the_histories_of_all_spans(run, line, tmp_path):
    path = tmp_path / "line.svg"
    found = run(line, "--stop-time", "1", "--plot", str(path))
    assert found.exit_code == 0
    text = path.read_text()
    for part in ("section for a test (phase 1 of 2)", "span 3 phase 1, mid-span", "Motion: "):
        assert part in text
    assert f"wrote {path.name}" in found.stdout.replace("\n", "").replace(f"{tmp_path}/", "")


def test_inputs_move_the_towers_of_a_line(run, line, tmp_path):
    file = tmp_path / "inputs.csv"
    file.write_text("time,tower[1].x3\n0,0\n1,0.5\n")
    still, moved = (
        json.loads(run(line, "--stop-time", "2", "--json", *options).stdout)
        for options in ((), ("--inputs", str(file)))
    )
    assert still["strings"][0]["lean_across_max"] == 0.0
    lean = moved["strings"][0]
    assert max(-lean["lean_across_min"], lean["lean_across_max"]) > 0.02  # 0.037
    file.write_text("time,tower[7].x3\n0,0\n")
    found = run(line, "--inputs", str(file))
    assert found.exit_code == 2
    assert "tower[7].x3" in found.stderr
    assert "tower[0].x1" in found.stderr
