"""Oblique and sheared wind against closed forms, and a lumped chain of other code.

A straight conductor with the unit tangent t = (cos b, sin b, 0) meets the part of the wind U (sin
psi, 0, cos psi) along n2 = (-sin b, cos b, 0) and n3 = (0, 0, 1): w2 = -U sin psi sin b and w3 = U
cos psi. Its load is that of the speed sqrt(w2^2 + w3^2) at an attack angle greater by atan2(w2,
w3); on the level that is the speed U cos psi.
"""

import math

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.engine.mesh import Mesh
from modal.linear.linearise import SmallMotion
from support.sloping_spans import growth, proportional_to_mass, sloping
from support.windy_spans import LOGARITHMIC, POWER

LENGTH, RADIUS, DIAMETER, AIR = 100.0, 0.014, 0.028, 1.225
CURVE = {
    "kind": "polynomial",
    "valid_from_deg": -90,
    "valid_to_deg": 270,
    "outside": "hold",
    "lift": [0.1, -2.0, 0.3],
    "drag": [1.1, 0.2],
    "moment": [0.05, 0.4],
}


def straight(rise=0.0, **values):
    """A conductor without ice in so little gravity that it is straight, by sag and tension."""
    return gf.Scene.from_dict(
        {
            "title": "a straight conductor",
            "span": {
                "length": LENGTH,
                "height_difference": rise,
                "horizontal_tension": 92000.0,
                "sag": 1.5e-12 * LENGTH * math.hypot(LENGTH, rise) / (8.0 * 92000.0),
                "gravity": 1e-12,
            },
            "conductor": {
                "diameter": DIAMETER,
                "mass_per_length": 1.5,
                "axial_stiffness": 4e7,
                "torsional_stiffness": 150.0,
                "torsional_inertia": 1.5e-4,
            },
            "aerodynamics": CURVE,
            "wind": {"speed": 8.0},
            "numerics": {"elements": 4},
        }
    ).with_values(values)


def forces(scene):
    """Nodal forces of the wind [N, N m] on the conductor at rest."""
    model = gf.Model(scene)
    return model.residual(inputs=gf.Inputs.still(scene)) - model.residual()


def per_length(speed, angle):
    """Lift, drag and moment per length of a section in wind [m/s] at an attack angle [rad]."""
    q = 0.5 * AIR * DIAMETER * speed**2
    if angle < math.radians(-90.0):
        angle += 2.0 * math.pi
    powers = angle ** np.arange(3)
    curves = ([*CURVE["lift"]], [*CURVE["drag"], 0.0], [*CURVE["moment"], 0.0])
    lift, drag, moment = (q * np.dot(curve, powers) for curve in curves)
    return lift, drag, moment * DIAMETER


@pytest.mark.parametrize("yaw", [-70.0, -30.0, 45.0, 60.0, 100.0, 150.0])
def test_cosine_law_on_the_level(yaw):
    oblique = straight(**{"wind.direction_deg": yaw})
    normal = straight(**{"wind.speed": 8.0 * math.cos(math.radians(yaw))})
    found, expected = forces(oblique), forces(normal)
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()  # observed 1e-15


@pytest.mark.parametrize("rise", [0.0, 30.0, -70.0])
@pytest.mark.parametrize("yaw", [-60.0, 25.0, 130.0])
def test_load_of_a_straight_inclined_conductor(rise, yaw):
    slope, psi = math.atan2(rise, LENGTH), math.radians(yaw)
    w2, w3 = -8.0 * math.sin(psi) * math.sin(slope), 8.0 * math.cos(psi)
    speed, turn = math.hypot(w2, w3), math.atan2(w2, w3)
    lift, drag, moment = per_length(speed, turn)
    f2 = lift * math.cos(turn) + drag * math.sin(turn)
    f3 = drag * math.cos(turn) - lift * math.sin(turn)
    per = np.array([-f2 * math.sin(slope), f2 * math.cos(slope), f3, moment])
    found = forces(straight(rise, **{"wind.direction_deg": yaw})).sum(axis=0)
    expected = per * math.hypot(LENGTH, rise)
    # round-off of the tension of 92 kN; observed 0.33 of it
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max() + 92e-12


@pytest.mark.parametrize("yaw", [0.0, 40.0, -65.0])
def test_static_swing_out_in_yaw(yaw):
    """Drag alone turns a span as a pendulum: tan(swing) = force / weight of the speed U cos psi.

    The span is taut, so that its tangent is almost along x1, and the swing small, so that the
    tension does not change.
    """
    scene = gf.load_scene("zebra").with_values(
        {
            "span.sag": None,
            "span.horizontal_tension": 100000.0,
            "wind.speed": 3.0,
            "wind.direction_deg": yaw,
            "aerodynamics": CURVE | {"lift": [0.0], "drag": [1.1], "moment": [0.0]},
            "numerics.elements": 20,
        }
    )
    model = gf.Model(scene)
    u = model.rest().motion()[0][model.middle]
    equilibrium = model.equilibrium()
    speed = 3.0 * math.cos(math.radians(yaw))
    drag = 0.5 * scene.wind.air_density * scene.conductor.diameter * 1.1 * speed**2
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    tangent = drag / (mass * scene.span.gravity)
    assert u[2] / (equilibrium.sag - u[1]) == pytest.approx(tangent, rel=5e-4)  # observed 2.5e-4


@pytest.mark.parametrize("yaw", [20.0, 45.0, -60.0])
def test_critical_wind_grows_as_one_over_the_cosine(yaw):
    scene = sloping(0.0, span__horizontal_tension=100000.0, numerics__elements=12)
    normal, oblique = (
        next(
            critical
            for critical in modal.critical_wind_speed(
                scene.with_values({"wind.direction_deg": angle}), 2
            )
            if critical.mode.family == "vertical"
        )
        for angle in (0.0, yaw)
    )
    ratio = oblique.wind_speed / normal.wind_speed
    assert ratio == pytest.approx(1.0 / math.cos(math.radians(yaw)), rel=2e-5)  # observed 9e-6


def test_modes_in_oblique_mean_wind_are_those_of_its_normal_part():
    scene = gf.load_scene("example3").with_values(
        {"span.sag": None, "span.horizontal_tension": 150000.0, "numerics.elements": 12}
    )
    found = [
        modal.natural_modes(scene.with_values(wind), 4, "mean")
        for wind in (
            {"wind.speed": 5.0},
            {"wind.speed": 5.0 / math.cos(math.radians(40.0)), "wind.direction_deg": 40.0},
        )
    ]
    for one, other in zip(*found, strict=True):
        assert other.frequency_hz == pytest.approx(one.frequency_hz, rel=3e-7)  # observed 1e-7
        assert other.damping_ratio == pytest.approx(one.damping_ratio, rel=3e-5)  # observed 1e-5


def test_growth_of_a_lumped_chain_in_oblique_wind():
    """Level, 4.4 / cos 30 m/s at 30 degrees: 0.0204 1/s of straight bars with lumped masses.

    As test_growth_of_a_lumped_chain in test_wind_on_a_slope.py, whose scene this is.
    """
    scene = sloping(
        0.0,
        wind__speed=4.4 / math.cos(math.radians(30.0)),
        wind__direction_deg=30.0,
        damping__translation=proportional_to_mass(0.1, 0.5, 1.0),
        damping__twist=proportional_to_mass(10.0, 5.0, 10.0),
        initial__seed_vertical=1e-3,
        initial__seed_horizontal=0.0,
    )
    assert growth(scene) == pytest.approx(0.0204, rel=0.02)  # observed -1.0 %


@pytest.mark.parametrize("profile", [POWER, LOGARITHMIC])
def test_drag_of_a_profile_on_an_inclined_conductor(profile):
    """The load of each section follows from the hand formula at its height; drag only."""
    drag = CURVE | {"lift": [0.0], "drag": [1.1], "moment": [0.0]}
    scene = straight(40.0, **{"wind.profile": profile, "aerodynamics": drag})
    sections = Mesh(gf.Model(scene)).sections
    x = gf.Model(scene).equilibrium().x
    x1, x2 = (
        np.einsum("pn,en->ep", sections.shape, x[sections.nodes][:, :, i]).ravel() for i in (0, 1)
    )
    if profile is POWER:
        factor = ((x2 + 18.0) / 10.0) ** 0.2
    else:
        factor = np.log((x2 + 22.0 - 9.0 * x1 / LENGTH) / 0.3) / math.log(10.0 / 0.3)
    load = 0.5 * AIR * DIAMETER * 1.1 * (8.0 * factor) ** 2
    found = forces(scene)[:, 2].sum()
    assert found == pytest.approx(np.dot(load, sections.length), rel=1e-12)  # observed 1e-16
    assert np.ptp(factor) > 0.1


@pytest.mark.parametrize("values", [{"wind.direction_deg": 40.0}, {"wind.profile": POWER}])
def test_slope_of_the_force_by_the_wind_speed(values):
    """Of the linear model, against differences of the residual."""
    scene = gf.load_scene("example3").with_values(
        {"numerics.elements": 6, "span.sag": None, "span.height_difference": 20.0} | values
    )
    small = SmallMotion(scene)
    equations = small.in_mean_wind()
    ahead, behind = (
        small.model.residual(equations.displacement, inputs=small.inputs(5.5 + step))
        for step in (1e-3, -1e-3)
    )
    expected = (behind - ahead).ravel() / 2e-3
    found = equations.by_wind
    # a profile is interpolated by the shape functions here; observed 3e-10 and 2e-7
    assert np.abs(found - expected)[4:-4].max() < 1e-6 * np.abs(expected).max()


def test_screening_in_oblique_wind_finds_the_onset_of_its_normal_part():
    normal = gf.load_scene("example3").with_values({"wind.speed": 5.0})
    oblique = normal.with_values(
        {"wind.speed": 5.0 / math.cos(math.radians(30.0)), "wind.direction_deg": 30.0}
    )
    one, other = modal.screen(normal), modal.screen(oblique)
    assert one.risk == other.risk
    assert other.onset_wind_speed * math.cos(math.radians(30.0)) == pytest.approx(
        one.onset_wind_speed, rel=1e-3
    )  # observed 4e-4: the sag slopes the conductor
