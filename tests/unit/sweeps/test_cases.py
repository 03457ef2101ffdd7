"""Grids and tables of spans: what is read, what is refused."""

import json
import math

import numpy as np
import pandas as pd
import pytest

import gallop_fmu as gf
from gallop_fmu.scene.scene import Scene
from gallop_fmu.sweeps.cases import cases


def test_grid_has_every_combination_in_order():
    found = cases("example3", {"wind.speed": np.array([4.0, 5.0]), "numerics.elements": (6, 8, 10)})
    assert [tuple(case.changes.values()) for case in found.every] == [
        (u, n) for u in (4.0, 5.0) for n in (6, 8, 10)
    ]
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
        "span.horizontal_tension": "none",
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
        {
            "type": "Feature",
            "id": 17,
            "geometry": line,
            "properties": {"span.sag": 2.0, "wind.speed": None},
        },
        {
            "type": "Feature",
            "geometry": None,
            "properties": {"span.horizontal_tension": "none", "name": "B"},
        },
        {"type": "Feature", "properties": {"wind.speed": 6}},
    )
    assert gf.read_spans(path) == [
        {"name": "17", "label.geometry": json.dumps(line), "span.sag": 2.0},
        {"name": "B", "span.horizontal_tension": "none"},
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
    assert [(case.run, case.labels["name"],
        case.changes["wind.speed"]) for case in found.every] == [
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
    found = cases("example3", {"wind.speed": [5.0, 151.0]})
    assert found.every[0].scene().wind.speed == 5.0
    with pytest.raises(gf.SceneError, match=r"wind.speed = 151.0: must be at least -150"):
        found.every[1].scene()


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        (
            "name,sag\nA,2\n",
            (
                "sag: unknown key; the closest valid one is span.sag; "
                "a column that is only copied to the results must"
            ),
        ),
        ("name,wind.sped\nA,2\n", "wind.sped: unknown key; the closest valid one is wind.speed"),
        ("<gpx>\n</gpx>\n", "an XML or HTML file; export the table as CSV"),
        ("span.sag,span.sag\n2,2\n", "column 'span.sag' is given twice"),
        ("name,span.sag\nA,2\nB\n", "row 3 has 1 cells, the first row has 2"),
        ("name,span.sag\nA,2\nB,2\nA,3\n", "spans 1 and 3 have the same name 'A'"),
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
        (
            '{"type": "FeatureCollection", "features": [{"properties": null}]}',
            "not a GeoJSON FeatureCollection",
        ),
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
    with pytest.raises(gf.SceneError, match=r"wind.speed: given in the table and in over"):
        cases("example3", {"wind.speed": [1.0]}, [{"wind.speed": 2.0}])
    with pytest.raises(gf.SceneError, match=r"is a .csv or a .geojson file"):
        gf.read_spans("spans.xlsx")


IDS = [
    "12_34",
    "1E5",
    "0x1F",
    "007",
    "nan",
    "1.10",
    "1.1",
    "2024-01-01",
    "07:30:00",
    "true",
    "none",
    "#12",
    " a ",
    "9" * 40,
]


def test_a_named_index_of_a_data_frame_is_a_column():
    frame = pd.DataFrame({"name": ["north 4", "north 5"], "span.sag": [2.0, 2.1]})
    found = cases("example3", table=frame.set_index("name"))
    assert [case.labels["name"] for case in found.every] == [
        "north 4",
        "north 5",
    ]  # were "row 1", "row 2"
    with pytest.raises(gf.SceneError, match="column 'name' is given twice"):
        cases("example3", table=frame.set_index("name", drop=False))


def test_labels_of_other_types_come_back_as_json(geojson):
    labels = {"label.list": ["a", "b"], "label.object": {"x": 1}, "label.truth": True}
    (row,) = gf.read_spans(geojson({"properties": {"span.sag": 2.1, **labels}}))
    assert {key: row[key] for key in labels} == {
        key: json.dumps(value) for key, value in labels.items()
    }


def test_labels_and_names_come_back_as_they_were(table, geojson):
    """They are texts: no TOML, no numbers, no dates (e\\u0301 is é in two characters)."""
    names = [f"{text}e\u0301" for text in IDS]
    cells = "\n".join(f'"{name}","{text}",2.1' for name, text in zip(names, IDS, strict=True))
    features = [
        {"properties": {"name": name, "label.id": text}}
        for name, text in zip(names, IDS, strict=True)
    ]
    frame = pd.DataFrame({"name": names, "label.id": IDS})
    for given in (table("name,label.id,span.sag\n" + cells), geojson(*features), frame):
        rows = [case.columns() for case in cases("example3", table=given).every]
        assert [row["label.id"] for row in rows] == IDS
        assert [row["name"] for row in rows] == [f"{text}é" for text in IDS]


def test_a_name_that_begins_with_a_number_sign_is_a_span(table):
    """Comments are above the header only; a pole may be called #12."""
    path = table('# comment, with "quotes\n\nname,span.sag\n"#12",2.1\n#13,2.2\nB,2.2\n')
    assert [row["name"] for row in gf.read_spans(path)] == ["#12", "#13", "B"]


def test_a_line_break_in_a_cell_is_kept_and_rows_are_counted_as_the_file_does(table):
    path = table('name,label.note,span.sag\nA,"line one\nline two",2.1\nB,\u2028x,2.2\nC,x\n')
    with pytest.raises(gf.SceneError, match="row 5 has 2 cells, the first row has 3"):
        gf.read_spans(path)
    path = table('name,label.note,span.sag\r\nA,"line one\r\nline two",2.1\r\nB,a\u2028b,2.2\r\n')
    assert [row["label.note"] for row in gf.read_spans(path)] == ["line one\nline two", "a\u2028b"]


def test_a_quotation_mark_that_is_not_closed_joins_no_rows(table):
    path = table('name,label.note,span.sag\nA,"12 in,2.1\nB,"y,2.2\nC,z,2.3\n')
    with pytest.raises(gf.SceneError, match=r"not a CSV file in row 2 .*close each quotation mark"):
        gf.read_spans(path)


@pytest.mark.parametrize(
    "text",
    [
        "name;span.sag;label.x\nA;2.1;u,v\nB;2.2;\n",
        "name\tspan.sag\tlabel.x\nA\t2.1\tu,v\nB\t2.2\t\n",
        'Name,SPAN.sag,Label.x,,\r\nA,2.1,"u,v",,\r\nB,2.2,,,\r\n,,,,\r\n',
    ],
)
def test_tables_as_spreadsheets_write_them(table, text):
    path = table(text, "SPANS.CSV")
    for encoding in ("utf-8-sig", "utf-16"):
        path.write_bytes(text.encode(encoding))
        found = gf.read_spans(path)
        assert [row.pop("name") for row in found] == ["A", "B"]
        assert found == [{"span.sag": 2.1, "label.x": "u,v"}, {"span.sag": 2.2}]


def test_missing_values_leave_those_of_the_scene(geojson):
    """NaN, NA, None and null are the empty cell of a CSV file; only none removes a value."""
    frame = pd.DataFrame(
        {
            "name": ["A", "B", "C"],
            "span.horizontal_tension": [15000.0, np.nan, np.nan],
            "numerics.elements": pd.array([10, None, 12], dtype="Int64"),
            "wind.speed": [5, None, pd.NaT],
            "span.sag": [None, "2.1", "none"],
        }
    )
    expected = [
        {"name": "A", "span.horizontal_tension": 15000.0, "numerics.elements": 10, "wind.speed": 5},
        {"name": "B", "span.sag": 2.1},
        {"name": "C", "numerics.elements": 12, "span.sag": None},
    ]
    for given in (frame, frame.to_dict("records")):
        found = cases("example3", table=given)
        assert [{**case.labels, **case.changes} for case in found.every] == expected
    assert (
        found.every[1].scene().span.horizontal_tension
        == gf.load_scene("example3").span.horizontal_tension
    )
    path = geojson({"properties": {"span.sag": math.nan, "wind.speed": None}})
    assert gf.read_spans(path) == [{"name": "feature 1"}]


def test_labels_that_are_no_texts_come_back_as_json(geojson):
    values = [["a", "b"], {"k": [1]}, True, 3, 2.5, 2**63, 10**400, "x"]
    rows = gf.read_spans(geojson(*({"properties": {"label.v": value}} for value in values)))
    assert [row["label.v"] for row in rows] == [v if v == "x" else json.dumps(v) for v in values]


def test_a_data_frame_of_polars_is_its_rows():
    class Frame:
        columns = ("name", "span.sag")

        def to_dicts(self):
            return [{"name": "A", "span.sag": 2.1}]

        def __iter__(self):
            return iter(self.columns)

    assert cases("example3", table=Frame()).every[0].columns() == {
        "run": 0,
        "name": "A",
        "span.sag": 2.1,
    }


@pytest.mark.parametrize("scene", [["example3"], {"a": 1}, 3, True])
def test_a_scene_that_is_no_text_is_refused(geojson, scene):
    path = geojson({"properties": {"span.sag": 2.1, "scene": scene}})
    with pytest.raises(
        gf.SceneError, match=r"scene = .*: must be a packaged name, or the path of a scene file"
    ):
        cases("example3", table=path)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            pd.DataFrame([[1, 2]], columns=["span.sag", "span.sag"]),
            "column 'span.sag' is given twice",
        ),
        ([{"span.sag": 1, "Span.Sag": 2}], "column 'span.sag' is given twice"),
        (pd.DataFrame({0: [1]}), "the name of column 0 is not a text"),
        (pd.DataFrame({"span.sag": []}), "has no spans"),
        ("spans.xlsx", "is a .csv or a .geojson file"),
        ([1, 2], "rows that are dictionaries"),
        (3, "rows that are dictionaries"),
    ],
)
def test_tables_in_memory_that_are_refused(table, message):
    with pytest.raises(gf.SceneError, match=message):
        cases("example3", table=table)


def test_a_property_given_twice_is_refused(table):
    text = (
        '{"type": "FeatureCollection", "features": [{"properties": {"span.sag": 1, "span.sag":'
        " 2}}]}"
    )
    with pytest.raises(gf.SceneError, match=r"not a GeoJSON file \('span.sag' is given twice"):
        gf.read_spans(table(text, "spans.geojson"))


@pytest.mark.parametrize(
    "value", ["2024-01-01", "07:30:00", "2024-01-01T10:00:00", "12_34", "[2024-01-01]", "[1_0]"]
)
def test_a_date_as_a_value_is_refused_by_its_scene(value):
    for table, over in (([{"span.sag": value}], None), (None, {"span.sag": [value]})):
        case = cases("example3", over, table).every[0]
        json.dumps(case.columns())
        with pytest.raises(gf.SceneError, match=r"span.sag = .*: must be a finite number"):
            case.scene()


def test_integers_beyond_64_bits_are_refused_by_their_scene(tmp_path):
    keys = ("span.length", "numerics.elements", "run.record_every")
    values = (2**63, 10**400, -(2**63) - 1, "9" * 25, "9" * 5000)
    rows = [{"name": f"{key} {k}", key: value} for key in keys for k, value in enumerate(values)]
    for _ in range(2):  # the second call reads what the first has written
        found = gf.sweep(
            "example3", table=rows, stop_time=1.0, window=1.0, out=tmp_path / "o.nc"
        ).dataset
        assert found.outcome.values.tolist() == ["invalid_scene"] * len(rows)
        for name, message in zip(found.name.values, found.message.values, strict=True):
            assert message.startswith(f"{name.split()[0]} = ")


def test_a_table_as_a_value_is_a_cell_of_json(tmp_path):
    ramp = {"kind": "ramp", "initial": 4.0, "final": 5.0, "duration": 1.0}
    rows = [
        {
            "wind.speed": "none",
            "wind.history": '{kind="ramp", initial=4.0, final=5.0, duration=1.0}',
        }
    ]
    for over in ({"numerics.elements": [6]}, {"wind.history": [ramp], "wind.speed": [None]}):
        given = {"table": rows} if "wind.speed" not in over else {}
        for _ in range(2):  # the second call reads what the first has written
            runs = gf.sweep(
                "example3",
                over,
                **given,
                stop_time=1.0,
                window=1.0,
                out=tmp_path / f"{len(given)}.nc",
            )
        assert json.loads(runs.dataset["wind.history"].item()) == ramp
        assert runs.grid().u2_mean.size == 1


@pytest.mark.parametrize("suffix", [".nc", ".NC"])
def test_a_column_that_the_file_cannot_contain_is_refused_early(table, tmp_path, suffix):
    path = table("name,label.from/to,span.sag\nA,T1/T2,2.1\n")
    with pytest.raises(
        gf.SceneError, match=r"no slash in the name of a column, as in 'label.from/to'; call it"
    ):
        gf.sweep("example3", table=path, out=tmp_path / f"o{suffix}")
    assert not list(tmp_path.glob("o*"))
    runs = gf.sweep("example3", table=path, stop_time=1.0, window=1.0, out=tmp_path / "o.PARQUET")
    assert gf.read_runs(tmp_path / "o.PARQUET").dataset["label.from/to"].values.tolist() == [
        "T1/T2"
    ]
    assert runs.done == 1


def test_so_many_runs_are_refused_before_they_are_listed():
    half = [float(k) for k in range(2000)]
    with pytest.raises(gf.SceneError, match="4000000 runs are more than 1000000"):
        cases("example3", {"span.sag": half, "wind.speed": half})


def test_a_scene_with_many_unknown_keys_is_refused_soon():
    keys = {f"k{number}": 1 for number in range(2000)}
    with pytest.raises(gf.SceneError) as caught:
        Scene.from_dict(
            {**gf.load_scene("example3").model_dump(mode="json", exclude_none=True), **keys}
        )
    lines = str(caught.value).splitlines()
    assert (len(lines), lines[-1]) == (21, "and 1980 more problems")
