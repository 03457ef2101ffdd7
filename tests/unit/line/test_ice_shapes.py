"""Closed forms of the ice shapes against Green's theorem on their outlines."""

import numpy as np
import pytest

from gallop_fmu.line.ice_shapes import ice_section

D, T, RHO = 0.02813, 0.012, 900.0
R = 0.5 * D


def polygon(x, y):
    """Area, first moment along x and polar moment of a polygon, by Green's theorem."""
    x1, y1 = np.roll(x, -1), np.roll(y, -1)
    cross = x * y1 - x1 * y
    area, first = cross.sum() / 2.0, ((x + x1) * cross).sum() / 6.0
    polar = ((x**2 + x * x1 + x1**2 + y**2 + y * y1 + y1**2) * cross).sum() / 12.0
    return np.array([area, first, polar])


ANGLE = np.linspace(0.0, 2.0 * np.pi, 20001)[:-1]
HALF = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 10001)
CONDUCTOR = polygon(R * np.cos(ANGLE), R * np.sin(ANGLE))
WINDWARD_HALF = polygon(R * np.cos(HALF), R * np.sin(HALF))
OUTLINES = {  # nose along +x
    "radial": polygon((R + T) * np.cos(ANGLE), (R + T) * np.sin(ANGLE)) - CONDUCTOR,
    "crescent": polygon((R + T) * np.cos(HALF), R * np.sin(HALF)) - WINDWARD_HALF,
    "eccentric_circle": polygon(
        0.5 * T + (R + 0.5 * T) * np.cos(ANGLE), (R + 0.5 * T) * np.sin(ANGLE)
    )
    - CONDUCTOR,
    "d_shape": polygon(np.array([0.0, R + T, R + T, 0.0]), np.array([-R, -R, R, R]))
    - WINDWARD_HALF,
}


@pytest.mark.parametrize("shape", OUTLINES)
def test_the_integrals_are_those_of_the_outline(shape):
    expected = RHO * OUTLINES[shape]
    scale = RHO * np.array([R**2, R**3, R**4])
    assert (
        np.abs((np.array(ice_section(shape, D, T, RHO)) - expected) / scale).max() < 8e-7
    )  # of the polygon: 6e-7


@pytest.mark.parametrize("shape", ["radial", "crescent", "eccentric_circle"])
def test_no_thickness_is_no_ice(shape):
    assert np.abs(ice_section(shape, D, 0.0, RHO)).max() < 1e-18


def test_half_an_inch_of_radial_glaze_on_drake_has_the_published_weight():
    # Grigsby (ed.), Electric Power Generation, Transmission, and Distribution, Table 14.5: 2.094 -
    # 1.094 lb/ft
    glaze = 57.0 * 16.018463  # lb/ft3, the density that goes with it
    assert ice_section("radial", D, 0.0127, glaze).mass_per_length == pytest.approx(
        1.488164, rel=1.5e-3
    )  # 1e-3


def test_the_nose_faces_the_wind_and_a_positive_angle_lifts_it():
    ice = ice_section("crescent", D, T, RHO)
    x2, x3 = ice.first_moments(0.0)
    assert (x2, x3) == (0.0, -ice.first_moment)
    x2, x3 = ice.first_moments(np.radians(30.0))
    assert x2 == pytest.approx(0.5 * ice.first_moment)
    assert x3 < 0.0
