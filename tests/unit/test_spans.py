"""Grids and tables of spans: what is read, what is refused."""

import json

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.spans import cases


@pytest.fixture
def table(tmp_path):
    """Write a table and return its path."""

    def write(text, name="spans.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def geojson(table):
    """Write a FeatureCollection of these features."""
    return lambda *features: table(json.dumps({"type": "FeatureCollection", "features": features}), "spans.geojson")


def test_grid_has_every_combination_in_order():
    found = cases("example3", {"wind.speed": np.array([4.0, 5.0]), "numerics.elements": (6, 8, 10)})
    assert [tuple(case.changes.values()) for case in found.every] == [(u, n) for u in (4.0, 5.0) for n in (6, 8, 10)]
    assert found.grid == {"wind.speed": [4.0, 5.0], "numerics.elements": [6, 8, 10]}
    scene = found.every[4].scene()
    assert (scene.wind.speed, scene.numerics.elements) == (5.0, 8)


def test_csv_cells_become_values(table):
    path = table(
        "# from the line's records\n"
        "name,label.line,span.sag,span.horizontal_tension,aerodynamics.outside,aerodynamics.lift\n"
        'A,"north, 2",2.0,none,hold,"[0.0, -4.0]"\n'
        "\n"
        "7,,,,,\n"
    )
    first, second = gf.read_spans(path)
    assert first == {
        "name": "A",
        "label.line": "north, 2",
        "span.sag": 2.0,
        "span.horizontal_tension": None,
        "aerodynamics.outside": "hold",
        "aerodynamics.lift": [0.0, -4.0],
    }
    assert second == {"name": "7"}
    scene = cases("example3", table=path).every[0].scene()
    assert (scene.span.initial_state, scene.aerodynamics.lift) == ("from_sag", (0.0, -4.0))


def test_rows_without_a_name_are_called_after_their_place(table):
    rows = gf.read_spans(table("span.sag\n2.0\n\n2.1\n"))
    assert [row["name"] for row in rows] == ["row 2", "row 4"]


def test_geojson_properties_are_the_columns(geojson):
    line = {"type": "LineString", "coordinates": [[8.0, 47.0], [8.1, 47.0]]}
    path = geojson(
        {"type": "Feature", "id": 17, "geometry": line, "properties": {"span.sag": 2.0, "wind.speed": None}},
        {"type": "Feature", "geometry": None, "properties": {"span.horizontal_tension": "none", "name": "B"}},
        {"type": "Feature", "properties": {"wind.speed": 6}},
    )
    assert gf.read_spans(path) == [
        {"name": "17", "span.sag": 2.0},
        {"name": "B", "span.horizontal_tension": None},
        {"name": "feature 3", "wind.speed": 6},
    ]


def test_each_row_may_name_its_scene(table):
    gf.load_scene("example3").with_values({"span.sag": 2.1}).save(table("").parent / "own.toml")
    path = table("name,scene,wind.speed\nA,own.toml,5\nB,example2,\nC,,4\n")
    first, second, third = (case.scene() for case in cases("example3", table=path).every)
    assert (first.span.sag, first.wind.speed) == (2.1, 5.0)
    assert second == gf.load_scene("example2")
    assert third == gf.load_scene("example3").with_values({"wind.speed": 4.0})


def test_every_span_of_a_table_at_every_point_of_a_grid(table):
    found = cases("example3", {"wind.speed": [4.0, 5.0]}, table("name,span.sag\nA,2.12\nB,2.1\n"))
    assert [(case.run, case.labels["name"], case.changes["wind.speed"]) for case in found.every] == [
        (0, "A", 4.0), (1, "A", 5.0), (2, "B", 4.0), (3, "B", 5.0)
    ]  # fmt: skip
    assert list(found.grid) == ["name", "wind.speed"]


def test_fingerprint_sees_every_change(table):
    base = gf.load_scene("example3")
    prints = [
        cases(base, {"wind.speed": [4.0, 5.0]}).fingerprint(),
        cases(base, {"wind.speed": [5.0, 4.0]}).fingerprint(),
        cases(base, {"wind.speed": [4.0, 5.000001]}).fingerprint(),
        cases(base.with_values({"span.sag": 2.13}), {"wind.speed": [4.0, 5.0]}).fingerprint(),
        cases(base, {"numerics.elements": [4, 5]}).fingerprint(),
        cases(base, table=[{"name": "A"}]).fingerprint(),
        cases(base, table=[{"name": "B"}]).fingerprint(),
    ]
    assert len(set(prints)) == len(prints)
    assert cases("example3", {"wind.speed": (4.0, 5.0)}).fingerprint() == prints[0]


def test_a_value_that_is_not_allowed_concerns_its_own_run_only():
    found = cases("example3", {"wind.speed": [5.0, -1.0]})
    assert found.every[0].scene().wind.speed == 5.0
    with pytest.raises(gf.SceneError, match=r"wind.speed = -1.0: must be at least 0"):
        found.every[1].scene()


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        (
            "name,sag\nA,2\n",
            "sag: unknown key; the closest valid one is span.sag; what is only to be carried along must",
        ),
        ("name,wind.sped\nA,2\n", "wind.sped: unknown key; the closest valid one is wind.speed"),
        ("span.sag,span.sag\n2,2\n", "column 'span.sag' is there twice"),
        ("name,span.sag\nA,2\nB\n", "row 3 has 1 cells, the first row has 2"),
        ("name,span.sag\nA,2\nB,2\nA,3\n", "spans 1 and 3 are both called 'A'"),
        ("name,span.sag\n", "has no spans"),
        ("", "has no spans"),
    ],
)
def test_tables_that_are_refused(table, text, fragment):
    path = table(text)
    with pytest.raises(gf.SceneError) as problem:
        gf.read_spans(path)
    assert str(problem.value).startswith(f"{path}: ")
    assert fragment in str(problem.value)


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        ("{", "not a GeoJSON file"),
        ("[" * 100000, "not a GeoJSON file"),
        ("[]", "not a GeoJSON FeatureCollection"),
        ('{"type": "Feature", "properties": {}}', "not a GeoJSON FeatureCollection"),
        ('{"type": "FeatureCollection", "features": [{"properties": null}]}', "not a GeoJSON FeatureCollection"),
        ('{"type": "FeatureCollection", "features": []}', "has no spans"),
    ],
)
def test_geojson_that_is_refused(table, text, fragment):
    with pytest.raises(gf.SceneError, match=fragment):
        gf.read_spans(table(text, "spans.geojson"))


def test_other_refusals(table):
    with pytest.raises(gf.SceneError, match="nothing to vary"):
        cases("example3")
    with pytest.raises(gf.SceneError, match=r"over: wind.speed has no values"):
        cases("example3", {"wind.speed": []})
    with pytest.raises(gf.SceneError, match=r"wind.sped: unknown key"):
        cases("example3", {"wind.sped": [1.0]})
    with pytest.raises(gf.SceneError, match="'A' has no scene"):
        cases(None, table=table("name\nA\n"))
    with pytest.raises(gf.SceneError, match=r"wind.speed is both in the table and in over"):
        cases("example3", {"wind.speed": [1.0]}, [{"wind.speed": 2.0}])
    with pytest.raises(gf.SceneError, match=r"is a .csv or a .geojson file"):
        gf.read_spans("spans.xlsx")
