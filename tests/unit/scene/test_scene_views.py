"""A scene: repr, table for notebooks, names for completion; it refuses changes."""

import copy
import pickle

import pytest

import gallop_fmu as gf


def test_repr_is_one_line_with_title_and_key_figures(scene):
    text = repr(scene)
    assert text.splitlines() == [text]
    assert scene.title in text
    assert "span of 125.88 m, wind 5.5 m/s" in text


def test_repr_of_a_line_counts_its_parts(line_scene):
    assert "section of 2 spans, 650 m, 1 phase of 1 subconductor, 0 devices" in repr(line_scene)


def test_table_has_each_value_with_unit_and_source_and_is_escaped(scene):
    changed = scene.with_values({"title": "<script>x</script>"})
    html = changed._repr_html_()
    assert "<script>" not in html
    assert "<td>span.length</td>" in html
    assert ">125.88</td><td>m</td>" in html
    assert scene.sources["span"].replace("<", "&lt;") in html
    assert ">set by the user<" not in html  # the title has no row


@pytest.mark.parametrize("part", ["scene", "wind"])
def test_a_change_in_place_is_refused_with_the_cure(scene, part):
    owner = scene if part == "scene" else scene.wind
    with pytest.raises(gf.SceneError, match="with_values"):
        owner.speed = 1.0
    with pytest.raises(gf.SceneError, match="with_values"):
        del owner.speed


def test_completion_offers_no_names_of_pydantic(scene):
    names = {name for name in dir(scene) if not name.startswith("_")}
    assert {"wind", "with_values", "warnings", "to_toml", "save"} <= names
    assert not {"construct", "model_dump", "schema", "copy"} & names
    of_class = {name for name in dir(type(scene)) if not name.startswith("_")}  # IPython adds them
    assert not {"construct", "model_dump", "schema", "copy"} & of_class


def test_copies_and_pickles_are_equal(scene):
    assert copy.deepcopy(scene) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene


@pytest.fixture(scope="module")
def scene():
    return gf.load_scene("example3")


@pytest.fixture(scope="module")
def line_scene():
    return gf.LineScene.from_dict(
        {
            "title": "two spans",
            "section": {
                "horizontal_tension": 25e3,
                "spans": [{"length": 300.0}, {"length": 350.0}],
                "suspensions": [{"kind": "string", "length": 2.4, "weight": 600.0}],
            },
            "conductor": {
                "diameter": 0.028,
                "mass_per_length": 1.6,
                "axial_stiffness": 29e6,
                "torsional_stiffness": 159.0,
                "torsional_inertia": 2e-4,
            },
        }
    )
