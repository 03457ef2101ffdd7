"""Every public function that takes a scene also takes the name of one, or a path."""

import inspect
import re
from pathlib import Path

import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.input.scene_like import as_line, as_scene
from support.lines import LINE

PUBLIC = {
    f"{package.__name__}.{name}": getattr(package, name)
    for package in (gf, modal)
    for name in package.__all__
    if inspect.isfunction(getattr(package, name))
    and next(iter(inspect.signature(getattr(package, name)).parameters), "") == "scene"
}
OTHER_ARGUMENTS = {
    "path": "x.fmu",
    "values": [1.0],
    "speeds": [1.0],
    "random": {"wind.speed": {"distribution": "uniform", "loc": 3.0, "scale": 1.0}},
}
OPTIONS = {
    "modal.write_report": {"path": "x.html"},
    "gallop_fmu.sweep": {"over": {"wind.speed": [1.0]}},
    "modal.screen_spans": {"over": {"wind.speed": [1.0]}},
}


def call(name, scene, **others):
    """Call a public function with a scene and what else it requires."""
    function = PUBLIC[name]
    required = [
        parameter.name
        for parameter in inspect.signature(function).parameters.values()
        if parameter.default is inspect.Parameter.empty and parameter.name != "scene"
    ]
    return function(scene, **{key: OTHER_ARGUMENTS[key] for key in required} | others)


def test_the_functions_are_found():
    assert {"gallop_fmu.simulate", "gallop_fmu.export_fmu", "modal.natural_modes"} <= set(PUBLIC)
    assert len(PUBLIC) >= 26


@pytest.mark.parametrize("name", PUBLIC)
def test_an_unknown_name_is_refused_with_the_names_that_exist(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    others = OPTIONS.get(name, {})
    message = "exampel3: no packaged scene and no file has this name; packaged are example1, .*"
    with pytest.raises(gf.SceneError, match=message + "closest: example3"):
        call(name, "exampel3", **others)
    with pytest.raises(gf.SceneError, match=re.escape("missing.toml")):
        call(name, Path("missing.toml"), **others)


def test_a_name_a_path_and_a_scene_give_the_same(tmp_path):
    scene = gf.load_scene("example3")
    scene.save(tmp_path / "mine.toml")
    runs = [gf.simulate(given, 0.5) for given in (scene, "example3", tmp_path / "mine.toml")]
    for run in runs[1:]:
        assert run.scene == scene
        assert run.dataset.u2.equals(runs[0].dataset.u2)
    assert as_scene(scene) is scene
    assert gf.Model(tmp_path / "mine.toml").elements == gf.Model("example3").elements == 15
    frequencies = [
        modal.natural_modes(given, 2)[1].frequency_hz
        for given in (scene, "example3", str(tmp_path / "mine.toml"))
    ]
    assert frequencies == [frequencies[0]] * 3


def test_a_path_of_a_line_gives_the_result_of_a_line(tmp_path):
    (tmp_path / "line.toml").write_text(LINE, encoding="utf-8")
    modes = modal.natural_modes(tmp_path / "line.toml", 1)
    assert isinstance(modes[0], modal.LineMode)
    with pytest.raises(gf.SceneError, match="two_mode_estimate takes a scene of one span"):
        modal.two_mode_estimate(tmp_path / "line.toml")


def test_inputs_are_added_to_a_named_scene(tmp_path):
    (tmp_path / "wind.csv").write_text("time,wind_speed\n0,4\n10,6\n", encoding="utf-8")
    scene = gf.with_inputs("example3", tmp_path / "wind.csv")
    assert scene.wind.history.at(5.0) == 5.0


@pytest.mark.parametrize("name", ["equivalent_bundle", "line_criteria", "mode_pairs"])
def test_functions_of_lines_refuse_one_span(name):
    with pytest.raises(gf.SceneError, match=f"{name} takes a line"):
        getattr(modal, name)("example3")
    with pytest.raises(gf.SceneError, match=r"x takes a line .* and this scene is one span; do y"):
        as_line(gf.load_scene("example3"), "x", "do y")


@pytest.mark.parametrize("given", [3, None, {"span": {}}])
def test_other_types_are_refused(given):
    with pytest.raises(TypeError, match="scene must be a Scene, a LineScene, the name of"):
        gf.simulate(given)
