"""The key `format` of scene files."""

import tomllib

import pytest

import gallop_fmu as gf
from gallop_fmu.foundation.version import version


@pytest.fixture
def data():
    return tomllib.loads(gf.load_scene("example3").to_toml())


def test_written_scenes_have_a_format(data, tmp_path):
    assert next(iter(data.items())) == ("format", 1)
    gf.load_scene("example3").save(tmp_path / "mine.toml")
    assert (tmp_path / "mine.toml").read_text().startswith("format = 1\n")
    assert gf.load_scene(tmp_path / "mine.toml") == gf.load_scene("example3")


def test_a_scene_without_format_has_format_1(data):
    del data["format"]
    assert gf.Scene.from_dict(data) == gf.load_scene("example3")


@pytest.mark.parametrize("extra", [{}, {"line": {"conductor": "Drake", "span": 300.0}}])
def test_a_newer_format_is_refused(data, extra):
    with pytest.raises(gf.SceneError) as refusal:
        gf.Scene.from_dict({**data, **extra, "format": 2})
    assert str(refusal.value) == (
        f"format = 2: a newer format of scene files; gallop-fmu {version()} reads formats up to 1:"
        " install the newest gallop-fmu (pip install --upgrade gallop-fmu)"
    )


def test_the_message_names_the_file(tmp_path):
    (tmp_path / "new.toml").write_text("format = 2\n[line]\n")
    with pytest.raises(gf.SceneError, match=r"new\.toml: format = 2"):
        gf.load_scene(tmp_path / "new.toml")
    with pytest.raises(gf.SceneError, match="format = 2"):
        gf.sweep(tmp_path / "new.toml", {"line.span": [300.0]}, stop_time=0.1)


@pytest.mark.parametrize("value", [0, True, 1.0, "1"])
def test_other_values_are_refused(data, value):
    with pytest.raises(gf.SceneError, match="must be a whole number from 1; write format = 1"):
        gf.Scene.from_dict({**data, "format": value})


def test_every_packaged_scene_has_a_format():
    from gallop_fmu.foundation.text_files import packaged_text

    for name in gf.packaged_scenes():
        assert packaged_text("scene/packaged", f"{name}.toml").startswith("format = 1\n")
