"""Scene files that cannot be read: missing, binary, foreign, too long."""

import pytest

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.input.scene_files import load_scene


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
