"""Galloping ellipses as PLS-CADD prints them.

The numbers are from the report "Galloping Ellipses Summary" that is the sample file of the open
package plsxml (github.com/mpewsey/plsxml, plsxml/data/galloping.xml), in feet with one decimal.
"""

import math

import numpy as np
import pytest

from gallop_fmu.simulation.clearance import (
    FOOT,
    Ellipse,
    cigre_322_single_loop,
    davison_single_loop,
)

PRINTED = 0.05 + 0.00625
"""Half a unit of the printed decimal, and of the sag's second decimal times 1.25 [ft]."""
DIAMETER = 0.992 * FOOT / 12.0
"""Diameter [m] common to the nine rows of CIGRE's ellipse; the report omits the conductor."""


@pytest.mark.parametrize(
    ("sag", "major", "minor", "offset"),
    [(12.15, 16.2, 6.5, 3.0), (11.85, 15.8, 6.3, 3.0), (11.60, 15.5, 6.2, 2.9)],
)
def test_davison_single_loop(sag, major, minor, offset):
    ellipse = davison_single_loop(sag * FOOT)
    found = np.array([ellipse.major, ellipse.minor, ellipse.offset]) / FOOT
    assert found == pytest.approx([major, minor, offset], abs=PRINTED)  # observed: at most 0.038
    assert ellipse.rotation == 0.0


@pytest.mark.parametrize(
    ("sag", "major"),
    [
        (6.98, 17.2),
        (12.18, 20.9),
        (24.34, 25.5),
        (26.17, 26.0),
        (32.11, 27.3),
        (48.72, 30.1),
        (68.08, 32.3),
        (99.3, 34.8),
        (122.0, 36.1),
    ],
)
def test_cigre_322_single_loop(sag, major):
    ellipse = cigre_322_single_loop(sag * FOOT, DIAMETER)
    assert ellipse.major / FOOT == pytest.approx(
        major, abs=0.05
    )  # observed: at most 0.043, half a printed digit


@pytest.mark.parametrize(
    ("sag", "minor", "offset"), [(24.34, 10.2, 7.6), (48.72, 12.0, 9.0), (68.08, 12.9, 9.7)]
)
def test_cigre_322_proportions(sag, minor, offset):
    ellipse = cigre_322_single_loop(sag * FOOT, DIAMETER)
    found = np.array([ellipse.minor, ellipse.offset]) / FOOT
    assert found == pytest.approx([minor, offset], abs=0.05)  # observed: at most 0.043
    assert ellipse.rotation == 0.0


def test_the_offset_is_below_the_conductor():
    ellipse = davison_single_loop(4.0)
    assert ellipse.inside_ellipse([0.0, 0.0], [-0.999, -1.001]).tolist() == [True, False]
    top = 1.25 * 4.0 + FOOT - 1.0
    assert ellipse.inside_ellipse([0.0, 0.0], [top - 1e-3, top + 1e-3]).tolist() == [True, False]
    half_width = 0.2 * ellipse.major
    x = [half_width - 1e-3, half_width + 1e-3]
    assert ellipse.inside_ellipse(x, [ellipse.centre[1]] * 2).tolist() == [True, False]


def test_the_axis_leans_half_as_far_as_the_plane_of_the_span():
    swing = 0.6
    ellipse, upright = davison_single_loop(4.0, swing), davison_single_loop(4.0)
    # seen along the span, the swing carries a point on the plumb line above the conductor against
    # the wind
    x, y = -math.sin(0.5 * swing), math.cos(0.5 * swing)
    for reach in (-0.999, 4.3):
        assert ellipse.inside_ellipse(reach * x, reach * y)
        assert upright.inside_ellipse(0.0, reach)
        assert ellipse.distance(reach * x, reach * y) == pytest.approx(
            upright.distance(0.0, reach), abs=1e-12
        )
    assert ellipse.centre[0] < 0.0 < davison_single_loop(4.0, -swing).centre[0]


def test_distance_of_a_circle_and_along_the_axes():
    circle = Ellipse(major=4.0, minor=4.0, offset=2.0, rotation=0.3)
    assert circle.distance([3.0, 0.0, 0.6], [4.0, 0.0, 0.8]) == pytest.approx(
        [3.0, -2.0, -1.0], abs=1e-11
    )
    ellipse = Ellipse(major=10.0, minor=4.0, offset=5.0, rotation=0.0)
    x, y = [0.0, 0.0, 3.0, 0.0, 0.0], [7.0, -5.0, 0.0, 4.9, 0.0]
    assert ellipse.distance(x, y) == pytest.approx([2.0, 0.0, 1.0, -0.1, -2.0], abs=1e-11)


def test_distance_is_that_of_the_nearest_of_many_points():
    ellipse = davison_single_loop(3.0, 0.4)
    edge = np.array(ellipse.outline(20001))
    points = np.random.default_rng(1).uniform(-4.0, 6.0, size=(60, 2))
    nearest = np.min(np.hypot(edge[0] - points[:, :1], edge[1] - points[:, 1:]), axis=1)
    found = ellipse.distance(points[:, 0], points[:, 1])
    assert np.abs(found) == pytest.approx(
        nearest, abs=2e-6
    )  # observed: 8e-7, the spacing of the points on the edge
    inside = ellipse.inside_ellipse(points[:, 0], points[:, 1])
    assert np.array_equal(inside, found <= 0.0)
    assert 0 < inside.sum() < 60


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: cigre_322_single_loop(0.1, 0.02),
            r"sag = 0.1 m: must exceed 6.25 diameters, which is 0.125 m",
        ),
        (lambda: cigre_322_single_loop(1.0, 0.0), r"diameter = 0.0 m: must be a positive number"),
        (lambda: davison_single_loop(math.nan), r"sag = nan m: must be a positive number"),
        (
            lambda: davison_single_loop(1.0, 90.0),
            r"swing = 90.0 rad: must be less than a right angle",
        ),
    ],
)
def test_impossible_numbers_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
