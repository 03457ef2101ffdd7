"""Lines: reading and writing, changing values, bundles, strung state."""

import math

import pytest

import gallop_fmu as gf
from gallop_fmu.scene.bundle import Bundle
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.scene.sag_tension import tension_of_sag

LINE = """
title = "Three spans"
[section]
horizontal_tension = 25000.0
spans = [
    {length = 300.0, elements = 20},
    {length = 350.0, height_difference = 12.0, ice = {mass_per_length = 1.0}},
    {length = 280.0, ice = "none"},
]
suspensions = [
    {kind = "string", length = 2.4, weight = 600.0},
    {kind = "v_string", length = 2.4, weight = 300.0, half_spread = 1.5},
]
left_end = {kind = "string", length = 3.0, weight = 800.0}
[bundle]
subconductors = 4
spacing = 0.45
spacers = 6
[[phases]]
name = "a"
[[phases]]
name = "b"
offset = [0, 8.0]
[conductor]
diameter = 0.0281
mass_per_length = 1.628
axial_stiffness = 29.0e6
torsional_stiffness = 159.0
torsional_inertia = 2e-4
[ice]
mass_per_length = 0.5
[[devices]]
kind = "pendulum"
span = 2
station = 0.5
mass = 20
arm = 0.5
[[devices]]
kind = "interval"
span = 1
from_station = 0.25
to_station = 0.75
ice = "none"
[[loads]]
span = 2
force = [0, 400, 600]
position = 0.3
"""


@pytest.fixture
def line(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(LINE, encoding="utf-8")
    return gf.load_scene(path)


def test_a_file_with_a_section_is_a_line_and_survives_saving(line, tmp_path):
    assert isinstance(line, gf.LineScene)
    line.save(tmp_path / "copy.toml")
    assert gf.load_scene(tmp_path / "copy.toml") == line


def test_values_of_spans_and_devices_change_by_dotted_path(line):
    changed = line.with_values(
        {
            "section.spans.1.length": 400.0,
            "section.suspensions.0.length": 3.0,
            "devices.0.mass": 10.0,
        }
    )
    assert changed.section.spans[1].length == 400.0
    assert changed.section.suspensions[0].length == 3.0
    assert changed.devices[0].mass == 10.0


def test_ice_of_a_span_replaces_that_of_the_scene(line):
    masses = [line.ice_of_span(span).mass_per_length for span in (1, 2, 3)]
    assert masses == [0.5, 1.0, 0.0]
    assert [line.elements_of_span(span) for span in (1, 2, 3)] == [20, 15, 15]


def test_one_span_refuses_a_line(line):
    with pytest.raises(gf.SceneError, match=r"a section of 3 spans.*adjacent_span"):
        one_span(line, "this function")
    scene = gf.load_scene("example3")
    assert one_span(scene, "this function") is scene


def test_scene_of_one_span_refuses_data_of_a_line_and_the_reverse():
    with pytest.raises(gf.SceneError, match=r"LineScene\.from_dict"):
        gf.Scene.from_dict({"title": "", "section": {}})
    with pytest.raises(gf.SceneError, match=r"section\.spans; remove \[span\]"):
        gf.LineScene.from_dict({"title": "", "section": {}, "span": {}})


@pytest.mark.parametrize("count", [2, 3, 4, 6, 8])
def test_neighbouring_subconductors_of_a_bundle_have_the_spacing(count):
    places = Bundle(subconductors=count, spacing=0.45).positions
    distances = [math.dist(places[k - 1], places[k]) for k in range(count)]
    assert distances == pytest.approx([0.45] * count, rel=1e-14)
    assert math.fsum(x2 for x2, _ in places) == pytest.approx(0.0, abs=1e-15)
    assert places[0][1] < 0.0
    assert max(x2 for x2, _ in places) == places[0][0] == places[1][0]
    mirrored = {(x2, -x3 + 0.0) for x2, x3 in places}
    assert mirrored == set(places)


def test_tension_of_a_sag_agrees_with_the_catenary():
    """The sag is measured on a catenary through both ends, found by its own equation."""
    span, weight, rise = 350.0, 15.97, 40.0
    for sag in (1.0, 9.8, 60.0, 400.0):
        c = tension_of_sag(sag, span, weight, rise) / weight
        # y(x) = c cosh((x - x0)/c) with y(L) - y(0) = rise: x0 by bisection
        low, high = 0.5 * span - 40.0 * c, 0.5 * span + 40.0 * c
        for _ in range(200):
            x0 = 0.5 * (low + high)
            over = c * (math.cosh((span - x0) / c) - math.cosh(x0 / c)) > rise
            low, high = (x0, high) if over else (low, x0)
        ends = c * (math.cosh((span - x0) / c) + math.cosh(x0 / c))
        found = 0.5 * ends - c * math.cosh((0.5 * span - x0) / c)
        assert found == pytest.approx(sag, rel=1e-9)


def test_strung_tension_follows_from_the_sag_of_one_span(line):
    values = {"section.horizontal_tension": None, "section.sag": 9.0, "section.sag_span": 2}
    bare = line.with_values(values).strung_tension
    iced = line.with_values({**values, "section.strung_with_ice": True}).strung_tension
    assert iced / bare == pytest.approx((1.628 + 1.0) / 1.628, rel=1e-14)
    assert bare == pytest.approx(1.628 * 9.81 * 350.0**2 / (8 * 9.0), rel=3e-3)
