"""Scene files that cannot be read: missing, binary, foreign, too long."""

import pytest

from gallop_fmu.cli.terminal import chosen_spec
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import parse_toml
from gallop_fmu.input.annotated_toml import annotated_toml
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.scene.line_scene import LineScene
from support.lines import LINE


def test_unknown_name_lists_the_packaged_scenes():
    with pytest.raises(
        SceneError, match=r"exmaple3: .*example1, example2, example3, zebra.*closest: example3"
    ):
        load_scene("exmaple3")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\x89PNG\r\n\x1a\n\x00\xff", "not a text file in UTF-8"),
        (b"PK\x03\x04\x00\x00", "a binary file"),
        (b"<html>", "not a TOML file"),
        (b"a = " + b"[" * 100_000, "not a TOML file"),
        (
            b'[project]\nname = "other"\n',
            r"not a scene file, as it has none of \[line\], \[span\], \[section\]",
        ),
        (b"", "not a scene file"),
        (b"#" * 10_000_001, "has 10000001 bytes, at most 10000000"),
    ],
)
def test_unreadable_or_foreign_file(content, message, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=f"scene.toml: {message}"):
        load_scene(path)


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(SceneError, match=r"none\.toml: no such file"):
        load_scene(tmp_path / "none.toml")
    with pytest.raises(SceneError, match="not a file"):
        load_scene(tmp_path)
    with pytest.raises(SceneError, match=r"cannot be read|no such file"):
        load_scene("a\0.toml")


def test_annotated_line_numbers_its_spans_suspensions_and_devices():
    text = annotated_toml(LineScene.from_dict(parse_toml(LINE)))
    assert "[[section.spans]]  # span 2\nlength = 350.0  # horizontal distance" in text
    assert '    { kind = "post" },  # suspension 2\n' in text
    assert "# weight: weight of the string [N]\n" in text
    assert '[[devices]]  # device 2\nkind = "interval"  # kind of device' in text
    assert "[section.spans.ice]\nmass_per_length = 1.0  # mass of ice" in text


def test_values_of_a_line_are_set_as_on_the_command_line(tmp_path):
    (tmp_path / "line.toml").write_text(LINE, encoding="utf-8")
    changes = ["devices.0.mass=3", "phases.1.name=7", "section.suspensions.1.kind=post"]
    spec = chosen_spec(str(tmp_path / "line.toml"), changes)
    line = spec.scene({"section.spans.2.length": 250.0})
    assert (line.devices[0].mass, line.phases[1].name) == (3.0, "7")
    assert line.section.spans[2].length == 250.0
    assert SceneSpec.of(line).scene() == line
    assert SceneSpec.of(line).fingerprint() == line.to_toml()
    spec.check(["wind.speed"])
    with pytest.raises(SceneError, match=r"line\.toml.*span = 4, but the line has 3 spans"):
        load_scene(_changed(tmp_path, "span = 2\nstation", "span = 4\nstation"))


def _changed(folder, old, new):
    assert old in LINE
    path = folder / "changed_line.toml"
    path.write_text(LINE.replace(old, new), encoding="utf-8")
    return path
