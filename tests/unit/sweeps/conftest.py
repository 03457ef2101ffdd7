"""Tables of spans as files."""

import json

import pytest


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
    return lambda *features: table(
        json.dumps({"type": "FeatureCollection", "features": features}), "spans.geojson"
    )
