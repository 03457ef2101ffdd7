"""A line of one span moves as that span; a section and its mirror image move as one another."""

import numpy as np
import pytest

import gallop_fmu as gf
from support.sections import DRAKE, STRING, section

PUSH = {"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 0.5, "fall_start": 1.0, "fall": 0.5}
BOUND = 1e-11
"""Of the largest value; 4e-13 seen."""


def test_a_line_of_one_span_moves_as_the_span():
    load = {"position": 0.3, "force": [0.0, 300.0, 400.0], "torque": 10.0, "law": PUSH}
    numerics = {"elements": 12, "time_step": 0.01, "newton_tolerance": 1e-11}
    line = section((300.0,), loads=[{**load, "span": 1}], numerics=numerics)
    span = gf.Scene.from_dict(
        {
            "title": "the same as a span",
            "span": {"length": 300.0, "horizontal_tension": 25e3},
            **{"conductor": DRAKE, "loads": [load], "numerics": numerics},
        }
    )
    ours, theirs = (gf.simulate(s, 3.0, record_nodes="all").dataset for s in (line, span))
    for name in ("u1", "u2", "u3", "theta", "tension"):
        size = np.abs(theirs[name]).max().item()
        assert ours[name].values == pytest.approx(theirs[name].values, abs=BOUND * size)
    for axis in (1, 2, 3):
        force = ours[f"tower_force_x{axis}"].values[:, :, 0]
        for end, name in enumerate(("left", "right")):
            expected = theirs[f"{name}_f{axis}"].values
            assert force[:, end] == pytest.approx(expected, abs=BOUND * 25e3)


def mirrored(turned):
    """Mid-span motion and tower forces of a section, or of its mirror image."""
    lengths, places, heights = (150.0, 110.0, 130.0), (0.3, 0.45), (8.0, -3.0, 5.0)
    strings = [STRING, {**STRING, "length": 1.8, "weight": 400.0}]
    loads = [{"span": 1, "position": places[0]}, {"span": 3, "position": places[1]}]
    sense = -1.0 if turned else 1.0
    step = -1 if turned else 1
    loads = [
        {
            "span": 4 - load["span"] if turned else load["span"],
            "position": 1.0 - load["position"] if turned else load["position"],
            **{"force": [sense * 50.0, 150.0, 200.0], "law": PUSH},
        }
        for load in loads
    ]
    scene = section(lengths[::step], loads=loads, numerics={"newton_tolerance": 1e-11})
    values = {f"section.suspensions.{k}": string for k, string in enumerate(strings[::step])}
    values |= {
        f"section.spans.{k}.height_difference": sense * height
        for k, height in enumerate(heights[::step])
    }
    result = gf.simulate(scene.with_values(values), 4.0)
    spans = [result.bundle(span) for span in (1, 2, 3)][::step]
    signs = {"u1": sense, "u2": 1.0, "u3": 1.0}
    found = [signs[name] * span[name].values for span in spans for name in signs]
    for axis, sign in ((1, sense), (2, 1.0), (3, 1.0)):
        force = result.dataset[f"tower_force_x{axis}"].values[:, ::step, 0]
        found += [1e-4 * sign * force[:, tower] for tower in range(4)]
    return np.array(found)


def test_a_section_and_its_mirror_image_move_as_one_another():
    plain, turned = mirrored(False), mirrored(True)
    assert np.abs(plain[:9]).max() > 0.1
    assert turned == pytest.approx(plain, abs=BOUND * np.abs(plain).max())
