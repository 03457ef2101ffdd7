"""Measures of a study: values of their lines."""

import math

import numpy as np
import pytest

from gallop_fmu import SceneError
from modal.study import measures
from support.two_spans import two_spans


@pytest.fixture(scope="module")
def scene():
    return two_spans()


def test_measures_have_the_stated_values(scene):
    bare = scene.with_values({"phases": [{"name": "1"}]})
    found = {each.name: each for each in measures.measures(bare, np.array([0.5, math.nan]))}
    raised = found["Raise the tension by 10%"]
    assert raised.scene.strung_tension == pytest.approx(1.1 * 21730.0)
    assert "30% of the rated strength" in raised.detail
    (damper,) = found["Hang a tuned damper at mid-span"].scene.devices
    assert "6 kg for each conductor, in 1 span; a spring would stretch by 1.1 m" in (
        found["Hang a tuned damper at mid-span"].detail
    )
    modal_mass = 0.5 * 1.83 * 125.88
    ratio = damper.hanging_mass / modal_mass
    assert ratio == pytest.approx(0.05)
    own = math.sqrt(damper.hanging_stiffness / damper.hanging_mass)
    assert own == pytest.approx(2.0 * math.pi * 0.5 / 1.05)
    assert damper.damping / (2.0 * damper.hanging_mass * own) == pytest.approx(
        math.sqrt(3.0 * 0.05 / (8.0 * 1.05**3))
    )
    split = found["Split span 1 by a tower in its middle"].scene.section
    assert [span.length for span in split.spans] == [62.94, 62.94, 110.0]
    assert len(split.suspensions) == 2


def test_a_split_keeps_the_line_through_the_new_clamp(scene):
    split = measures.split_span(scene, 2).section
    assert [span.height_difference for span in split.spans] == [0.0, 2.0, 2.0]
    assert sum(span.length for span in split.spans) == pytest.approx(235.88)
    with_device = scene.with_values(
        {"devices": [{"kind": "mass", "span": 2, "station": 0.5, "mass": 5.0}]}
    )
    with pytest.raises(SceneError, match="attached to span 2"):
        measures.split_span(with_device, 1)


def test_bundles_get_spacers_and_phases_get_bars(scene):
    twin = scene.with_values(
        {"bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 2}, "numerics.elements": 8}
    )
    names = [each.name for each in measures.measures(twin, np.array([0.5, 0.5]))]
    assert "Use 4 spacers in each span of the bundle instead of 2" in names
    assert "Connect the phases by interphase spacers" in names
    assert all(each.scene for each in measures.measures(twin, np.array([0.5, 0.5])))
