"""Malicious scene files and tables: a message, no long wait, nothing is executed."""

import ast
from pathlib import Path

import pytest

import gallop_fmu as gf
from gallop_fmu.foundation.text_files import MAX_FILE_SIZE, parse_value, read_table
from gallop_fmu.sweeps.cases import read_spans

DEEP = 20_000
LONG = 1_000_000
"""Parts of a dotted key: a parser whose time grows with their square, as tomllib's, takes hours."""


def refused(call, match):
    with pytest.raises(gf.SceneError, match=match):
        call()


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("a = " + "[" * DEEP, "nested more than 40 levels"),
        ("a = " + "[" * 100 + "]" * 100, "nested more than 40 levels"),
        ("a = " + "{b = " * 100 + "1" + "}" * 100, "nested more than 40 levels"),
        ("a" + ".a" * LONG + " = 1", "nested more than 40 levels"),
        ("a" + " . 'a'" * DEEP + " = 1", "nested more than 40 levels"),
        ("[a" + ".a" * DEEP + "]", "nested more than 40 levels"),
        ("a = {" + "a." * DEEP + "a = 1}", "nested more than 40 levels"),
        ("[line]\na" + ".a" * 3000 + " = 1", "nested more than 40 levels"),
        ("a = " + "1" * 5000, "not a TOML file .*4300 digits"),
        ("a" * 1_000_000, "not a TOML file"),
        ("\0", "a binary file"),
        ("# " + "x" * MAX_FILE_SIZE, f"at most {MAX_FILE_SIZE} are allowed"),
    ],
    ids=[
        "open",
        "closed",
        "inline",
        "key",
        "spaced",
        "header",
        "in a table",
        "line",
        "digits",
        "word",
        "binary",
        "large",
    ],
)
def test_scene_files(tmp_path, text, match):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    refused(lambda: gf.load_scene(path), match)


def test_a_description_may_have_many_full_stops():
    text = "1.2.3.4.5.6.7.8.9.10.11.12.13. A sentence. " * 100
    assert gf.load_scene("example3").with_values({"description": text}).description == text


@pytest.mark.parametrize("value", ["1" * 5000, "[" * DEEP, "{a" + ".a" * DEEP + " = 1}"])
def test_values_of_cells_that_are_no_toml_stay_text(value):
    assert parse_value(value) == value


@pytest.mark.parametrize("read", [read_spans, lambda path: read_table(path, {"span.length": "m"})])
def test_a_cell_without_end(tmp_path, read):
    path = tmp_path / "spans.csv"
    path.write_text("span.length\n" + "2" * 200_000)
    refused(lambda: read(path), "not a CSV file in row 2 .*field larger")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("[" * 100_000, "not a GeoJSON file"),
        ("1" * 5000, "not a GeoJSON file .*4300 digits"),
        ('{"type": "FeatureCollection", "features": [[]]}', "whose features have properties"),
        ('{"type": "FeatureCollection", "features": []}', "has no spans"),
    ],
)
def test_geojson_files(tmp_path, text, match):
    path = tmp_path / "spans.geojson"
    path.write_text(text)
    refused(lambda: read_spans(path), match)


def test_values_nested_without_end():
    nested = 1
    for _ in range(5000):
        nested = [nested]
    scene = gf.load_scene("example3")
    refused(lambda: scene.with_values({"aerodynamics.lift": nested}), "nested too deeply")
    refused(lambda: scene.with_values({"wind" + ".a" * 5000: 1.0}), "nested too deeply|unknown key")


EXECUTING = {
    "eval",
    "exec",
    "compile",
    "pickle",
    "marshal",
    "shelve",
    "yaml",
    "dill",
    "cloudpickle",
    "joblib",
}


@pytest.mark.parametrize("package", ["gallop_fmu", "modal"])
def test_no_module_can_execute_data(package):
    """The sources use no function that executes data; loky and Dask pickle for themselves."""
    folder = Path(__file__).parents[2] / package
    files = sorted(folder.rglob("*.py"))
    assert len(files) > 20
    for file in files:
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            called = (
                node.func.id
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
                else ""
            )
            imported = (
                [alias.name.split(".")[0] for alias in node.names]
                if isinstance(node, ast.Import)
                else []
            )
            source = [(node.module or "").split(".")[0]] if isinstance(node, ast.ImportFrom) else []
            found = EXECUTING & {called, *imported, *source}
            assert not found, (file.name, node.lineno, found)
