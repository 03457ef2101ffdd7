"""2,000 random cells of tables (CSV, GeoJSON, data frames) through sweep and screening to disk."""

import csv
import datetime
import io
import json
import math
import random
import unicodedata

import pandas as pd
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.foundation.text_rules import read_number
from gallop_fmu.sweeps.cases import cases

SEED, ROWS = 11, 400
LABELS = ("label.id", "label.Größe e\u0301", "label.\U0001f469\u200d\U0001f527\nb")
VALUES = ("span.sag", "wind.speed")
# fmt: off
WORDS = [
    "2024-01-01", "07:30:00", "2024-01-01T10:00:00Z", "1979-05-27 07:32:00", "1.1.2024",
    "12_34", "1_0.5", "1E5", "1e-3", "+3", "-.5", "2.", ".5", "05", "0x1F", "0b1", "0o7", "1d3",
    "1e400", "-0", "2,1",
    "9223372036854775807", "9223372036854775808", "-9223372036854775809", "1" * 30, "1" * 5000,
    "T1/T2", "a\\b", "//", '"', "'", '"quoted"', '12 in"', "'a", '"""', "[1, 2]", "[", "{a=1}",
    "{", "[2024-01-01]",
    "nan", "NaN", "NA", "inf", "-inf", "null", "None", "none", "true", "False", "#12", "# x",
    "=A1+1", "@x", "%",
    "\U0001f600", "\U0001f469\u200d\U0001f527", "e\u0301", "Å", "\u2126", "ﬁ", "１２", "٣", "שלום",
    "\u2028", "\u00a0",
    "", " ", "  a ", "line one\nline two", "a\r\nb", "\t", "a,b", "a;b", "$x_{$", "[b]x[/b]",
    ":warning:", "<a&b>",
]
# fmt: on
REFUSED = [
    "\0",
    "\x1b[2J",
    "a\x0bb",
    "\x85",
    "\x1c",
    "\ud800",
    "\ufffe",
    "\ufdd0",
    "\U0001ffff",
    "\x7f",
]
NATIVE = [
    None,
    math.nan,
    math.inf,
    True,
    0,
    2.5,
    2**63,
    -(10**30),
    10**400,
    ["a", {"b": None}],
    {"k": [1, 2.0]},
]
IN_MEMORY = [
    *NATIVE,
    pd.NA,
    pd.NaT,
    pd.Timestamp("2024-01-01"),
    datetime.date(2024, 1, 1),
    datetime.time(7, 30),
]


def drawn(source, native):
    """Name to cells; every fourth one is no text where `native` gives some."""
    columns = {"name": [f"{source.choice(WORDS)} {row}" for row in range(ROWS)]}
    for key in (*LABELS, *VALUES):
        words = [
            source.choice(native if native and source.random() < 0.25 else WORDS)
            for _ in range(ROWS)
        ]
        columns[key] = words
    return columns


def rows_of(columns):
    return [dict(zip(columns, cells, strict=True)) for cells in zip(*columns.values(), strict=True)]


def as_csv(source, folder):
    columns, text = drawn(source, []), io.StringIO(newline="")
    writer = csv.writer(text, source.choice(["excel", "excel-tab", "unix"]))
    writer.writerows([list(columns), *(row.values() for row in rows_of(columns))])
    (folder / "spans.csv").write_text(
        text.getvalue(), source.choice(["utf-8", "utf-8-sig", "utf-16"]), newline=""
    )
    return columns, folder / "spans.csv"


def as_geojson(source, folder):
    columns = drawn(source, NATIVE)
    features = [
        {"type": "Feature", "geometry": None, "properties": row} for row in rows_of(columns)
    ]
    text = json.dumps(
        {"type": "FeatureCollection", "features": features}, ensure_ascii=source.random() < 0.5
    )
    (folder / "spans.geojson").write_text(text, "utf-8")
    return columns, folder / "spans.geojson"


def as_frame(source, folder):
    columns = drawn(source, IN_MEMORY)
    return columns, pd.DataFrame(columns, dtype=object)


FORMS = [as_csv, as_geojson, as_frame]


def expected(cell):
    """A label as it must be read back: text in normal form C, other values as JSON or as text."""
    if isinstance(cell, str):
        return unicodedata.normalize("NFC", cell.replace("\r\n", "\n"))
    if (
        cell is None
        or cell is pd.NA
        or cell is pd.NaT
        or (isinstance(cell, float) and math.isnan(cell))
    ):
        return ""
    return str(cell) if isinstance(cell, (datetime.date, datetime.time)) else json.dumps(cell)


def values(row):
    """Numbers of a row: None for no number, missing if empty, 0 for one that removes the value."""
    for key in VALUES:
        cell = row[key]
        if isinstance(cell, str):
            if cell.strip():
                yield key, 0.0 if cell.strip() == "none" else read_number(cell)
        elif expected(cell):
            yield (
                key,
                cell if isinstance(cell, (int, float)) and not isinstance(cell, bool) else None,
            )


@pytest.fixture(scope="module")
def base():
    numbers = {"numerics.elements": 4, "run.record_every": 1, "span.horizontal_tension": None}
    return gf.load_scene("example3").with_values(numbers)


@pytest.mark.parametrize("form", FORMS)
def test_labels_come_back_and_only_wrong_values_fail(form, base, tmp_path):
    """Each run is computed, if only for 0.02 s, and written to NetCDF and read again."""
    columns, table = form(random.Random(SEED), tmp_path)
    assert sum(map(len, columns.values())) - ROWS == 2000
    options = {"table": table, "stop_time": 0.02, "window": 0.02, "out": tmp_path / "o.nc"}
    gf.sweep(base, **options)
    gf.sweep(base, **options)  # takes all rows over
    found = gf.read_runs(tmp_path / "o.nc").dataset
    (tmp_path / "o.nc.journal").unlink()
    for dataset in (found, gf.read_runs(tmp_path / "o.nc").dataset):
        for key in ("name", *LABELS):
            column = unicodedata.normalize("NFC", key)
            assert dataset[column].values.tolist() == [expected(cell) for cell in columns[key]]
    outcomes = {"completed": 0, "invalid_scene": 0}
    for row, outcome, message in zip(
        rows_of(columns), found.outcome.values, found.message.values, strict=True
    ):
        outcomes[outcome] += 1
        wrong = [key for key, number in values(row) if number is None or not abs(number) < 1e300]
        assert outcome == "invalid_scene" or not wrong
        if outcome == "invalid_scene":
            assert any(key.split(".")[1] in message for key, _ in values(row)), message
    assert min(outcomes.values()) > 5


@pytest.mark.parametrize("form", FORMS)
def test_screening_reads_the_same_tables(form, base, tmp_path):
    columns, table = form(random.Random(SEED + 1), tmp_path)
    rows = rows_of(columns)[:25]
    found = modal.screen_spans(
        base, table=rows, estimate_only=True, workers=1, out=tmp_path / "o.parquet"
    ).dataset
    assert found["label.id"].values.tolist() == [expected(row["label.id"]) for row in rows]
    assert set(found.outcome.values) <= {"completed", "invalid_scene", "no_equilibrium"}
    whole = cases(base, table=table)
    assert [case.labels["name"] for case in whole.every] == [
        expected(name) for name in columns["name"]
    ]
    if form is not as_frame:
        assert cases(base, table=gf.read_spans(table)).fingerprint() == whole.fingerprint()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("compute", [gf.sweep, modal.screen_spans])
def test_values_that_cannot_be_written_are_refused_before_computing(form, compute, base, tmp_path):
    source = random.Random(SEED + 2)
    for refused in REFUSED:
        if form is as_csv and refused in ("\0", "\ud800"):
            continue  # no text file
        columns, table = form(source, tmp_path)
        columns[source.choice(["name", *LABELS])][source.randrange(ROWS)] = f"a{refused}b"
        if form is as_csv:
            text = io.StringIO(newline="")
            csv.writer(text).writerows([list(columns), *(row.values() for row in rows_of(columns))])
            table.write_text(text.getvalue(), "utf-8", newline="")
        elif form is as_geojson:
            features = [{"properties": row} for row in rows_of(columns)]
            table.write_text(
                json.dumps({"type": "FeatureCollection", "features": features}), "utf-8"
            )
        else:
            table = pd.DataFrame(columns, dtype=object)
        with pytest.raises(gf.SceneError, match=r"holds the character U\+"):
            compute(base, table=table, out=tmp_path / "o.nc")
    columns, _ = form(source, tmp_path)
    rows = [{"name": row["name"], "label.from/to": row["label.id"]} for row in rows_of(columns)]
    with pytest.raises(gf.SceneError, match="no slash in the name of a column"):
        compute(base, table=rows, out=tmp_path / "o.nc")
    assert not list(tmp_path.glob("o.nc*"))
