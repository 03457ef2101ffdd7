"""Lines: reading and writing, changing values, bundles, strung state."""

import math

import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.scene.bundle import Bundle
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.scene.sag_tension import catenary_sag, highest_tension, tension_of_sag
from support.lines import LINE


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


@pytest.mark.parametrize("sag", [0.1, 9.8, 60.0, 400.0])
def test_sag_and_tension_agree_with_a_catenary_through_both_ends(sag):
    """The catenary y = c cosh((x - x0)/c) is placed by bisection of its own equation."""
    span, weight, rise = 350.0, 15.97, 40.0
    tension = tension_of_sag(sag, span, weight, rise)
    c = tension / weight
    low, high = 0.5 * span - 10.0 * c, 0.5 * span + 10.0 * c
    for _ in range(200):
        x0 = 0.5 * (low + high)
        climbs = c * (math.cosh((span - x0) / c) - math.cosh(x0 / c)) > rise
        low, high = (x0, high) if climbs else (low, x0)
    left, middle, right = (c * math.cosh((x - x0) / c) for x in (0.0, 0.5 * span, span))
    assert 0.5 * (left + right) - middle == pytest.approx(sag, rel=1e-10)
    assert catenary_sag(span, weight, tension, rise) == pytest.approx(sag, rel=1e-14)
    # T = w y, with y from the directrix
    assert highest_tension(span, weight, tension, rise) == pytest.approx(weight * right, rel=1e-12)


def test_strung_tension_follows_from_the_sag_of_one_span(line):
    values = {"section.horizontal_tension": None, "section.sag": 9.0, "section.sag_span": 2}
    bare = line.with_values(values).strung_tension
    iced = line.with_values({**values, "section.strung_with_ice": True}).strung_tension
    assert iced / bare == pytest.approx((1.628 + 1.0) / 1.628, rel=1e-14)
    assert bare == pytest.approx(1.628 * 9.81 * 350.0**2 / (8 * 9.0), rel=3e-3)


def test_new_first_moments_of_a_span_refer_to_its_present_attack_angle(line):
    ice = "section.spans.1.ice"
    values = {f"{ice}.first_moment_x2": 0.01, f"{ice}.attack_angle_deg": 30.0}
    first = line.with_values(values)
    rotated = first.with_values({f"{ice}.attack_angle_deg": 60.0})
    given = first.with_values({f"{ice}.attack_angle_deg": 60.0, f"{ice}.first_moment_x2": 0.02})
    angles = [at.section.spans[1].ice.first_moment_angle_deg for at in (first, rotated, given)]
    assert angles == [30.0, 30.0, 60.0]


def test_change_of_state_names_what_a_line_has_in_its_place(line):
    with pytest.raises(gf.SceneError, match=r"3 spans .*set section\.temperature_deg_c"):
        modal.change_of_state(line, temperature_change=10.0)
