"""Each stored case of a line becomes a valid scene."""

import pytest

from support.line_references import FOLDER, line_scene, stored

NAMES = sorted(
    file.stem
    for file in FOLDER.glob("*.json")
    if "left_end" not in (scene := stored(file.stem)["scene"])
    and "spans" in scene
    and "axial_stiffness" in scene.get("conductor", {})
)


@pytest.mark.parametrize("name", NAMES)
def test_scene(name):
    case = stored(name)
    scene = line_scene(case)
    assert len(scene.section.spans) == len(case["scene"]["spans"])
