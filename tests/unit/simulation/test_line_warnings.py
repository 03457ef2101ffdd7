"""Warnings about runs of lines: uplift, strength, steps, histories that end early."""

import gallop_fmu as gf
from support.sections import STRING, section

TABLE = {"kind": "table", "time": [0.0, 0.05], "value": [0.0, 0.0]}


def warnings(scene, stop=0.1):
    return gf.simulate(scene, stop).warnings


def test_an_ordinary_line_has_none():
    assert warnings(section()) == ()


def test_uplift_names_the_tower_and_a_remedy():
    """The second attachment is 45 m below the others: the conductor would rise from it."""
    light = {**STRING, "weight": 100.0}
    heights = {
        "section.spans.0.height_difference": -45.0,
        "section.spans.1.height_difference": 45.0,
    }
    scene = section(suspension=light, tension=30e3).with_values(heights)
    (found,) = warnings(scene)
    assert found.startswith("tower 1: uplift, the string's pull is -")
    assert "at the start" in found
    assert "make it heavier" in found


def test_a_tension_above_the_rated_strength_names_span_and_place():
    scene = section().with_values({"section.rated_strength": 25200.0})
    up = {"span": 2, "position": 0.5, "force": [0.0, -800.0, 0.0]}
    up["law"] = {"kind": "ramp", "initial": 0.0, "final": 1.0, "start": 0.0, "duration": 0.5}
    found = warnings(scene.with_values({"loads": [up]}), 1.5)
    assert any(
        text.startswith("span 2: the tension reaches 2") and "rated_strength = 25200 N" in text
        for text in found
    )


def test_long_steps_are_warned_of_by_the_fastest_span():
    """The second span alone moves, and no step of 0.2 s resolves its motion."""
    push = {"span": 2, "position": 0.5, "force": [0.0, 4000.0, 0.0]}
    push["law"] = {"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 0.2, "fall_start": 0.3}
    push["law"]["fall"] = 0.2
    scene = section(loads=[push], numerics={"time_step": 0.2})
    assert any("time steps in a period" in text for text in warnings(scene, 30.0))


def test_a_history_that_ends_early_is_named():
    scene = section(loads=[{"span": 1, "position": 0.5, "force": [0, 0, 1], "law": TABLE}])
    assert any(text.startswith("loads.0.law covers 0.05 s") for text in warnings(scene))
    motion = {"section.suspensions.1.motion": {"x3": TABLE}}
    assert any(
        text.startswith("section.suspensions.1.motion.x3 covers")
        for text in warnings(section().with_values(motion))
    )
