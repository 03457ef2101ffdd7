"""Wind on a slope acts in the plane of the section: closed forms, and an independent model.

The wind blows across the line and meets the conductor at right angles whatever its slope, so Den
Hartog's critical wind 4 m w xi / (rho d |CD + dCL/dalpha|) of pure vertical galloping holds on a
slope as on the level.
"""

import math

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.foundation.channels import SPAN_INDEX
from support.sloping_spans import DRAG, SLOPE_OF_LIFT, growth, proportional_to_mass, sloping


@pytest.mark.parametrize("rise", [0.0, 0.2, 0.3, 0.5, 0.7])
def test_critical_wind_of_the_linear_model(rise):
    scene = sloping(rise)
    onset = next(c for c in modal.critical_wind_speed(scene, 2) if c.mode.family == "vertical")
    mass, air = scene.conductor.mass_per_length + scene.ice.mass_per_length, scene.wind.air_density
    right = 4.0 * mass * 2.0 * math.pi * onset.mode.frequency_hz * onset.mode.damping_ratio
    right /= air * scene.conductor.diameter * -(SLOPE_OF_LIFT + DRAG)
    assert onset.wind_speed == pytest.approx(
        right, rel=1e-3
    )  # observed 2e-4 to 5e-4; 1/cos^2: 1.49 at 0.7


@pytest.mark.parametrize(
    ("rise", "right"), [(0.0, 4.423), (0.2, 4.259), (0.3, 4.077), (0.5, 3.622), (0.7, 3.173)]
)
def test_critical_wind_of_the_full_model(rise, right):
    """The growth rate passes zero between winds 6 % below and above the closed form."""
    winds = np.array([0.94, 1.06]) * right
    common = {
        "initial__wind": "mean_wind_equilibrium",
        "initial__seed_horizontal": 0.0,
        "numerics__elements": 16,
    }
    rates = [
        growth(sloping(rise, wind__speed=float(wind), **common), 50.0, 250.0) for wind in winds
    ]
    assert rates[0] < 0.0 < rates[1]
    zero = winds[0] - rates[0] * (winds[1] - winds[0]) / (rates[1] - rates[0])
    assert zero == pytest.approx(right, rel=1.5e-3)  # observed 3e-4 to 6e-4


def test_branches_begin_at_the_same_critical_wind():
    found = modal.branches(sloping(0.5, numerics__elements=12), "wind.speed", 3.0, 3.7)
    onset = float(found.dataset.event_value[0])
    assert onset == pytest.approx(3.622, rel=1e-3)  # observed 3e-4


@pytest.mark.parametrize(("rise", "wind", "lumped"), [(0.0, 4.4, 0.0204), (0.5, 4.2, 0.0174)])
def test_growth_of_a_lumped_chain(rise, wind, lumped):
    """Straight bars with lumped masses and central differences, independent code, 120 elements.

    Release 0.1.0, with vertical forces, gave 0.0040 at the rise of 0.5 L.
    """
    scene = sloping(
        rise,
        wind__speed=wind,
        damping__translation=proportional_to_mass(0.1, 0.5, 1.0),
        damping__twist=proportional_to_mass(10.0, 5.0, 10.0),
        initial__seed_vertical=1e-3,
        initial__seed_horizontal=0.0,
    )
    assert growth(scene) == pytest.approx(lumped, rel=0.03)  # observed -1.1 and -1.6 %


def test_motion_along_the_conductor_meets_no_wind():
    """A nearly straight span that slides along itself: the load of a fixed span, normal to it."""
    scene = sloping(
        0.6, span__horizontal_tension=2e6, span__sag=None, wind__speed=8.0, numerics__elements=8
    )
    model = gf.Model(scene)
    tangent = np.array([1.0, 0.6]) / math.hypot(1.0, 0.6)
    sliding = np.zeros((model.nodes, 4))
    sliding[:, :2] = 3.0 * tangent
    undamped = gf.Model(scene.with_values({"damping.translation": None, "damping.twist": None}))
    still, calm = gf.Inputs.still(scene), np.zeros_like(sliding)
    blowing = gf.Inputs(0.0, 8.0, still.attack_angle, still.support)
    rising = np.zeros_like(sliding)
    rising[:, 1] = 1.0
    loads = [
        undamped.residual(v=v, inputs=still) - undamped.residual(v=v, inputs=blowing)
        for v in (calm, sliding, rising)
    ]
    force = np.abs(loads[0][1:-1, 1:3]).max()
    assert np.abs(loads[1] - loads[0]).max() < 1e-3 * force  # the rest of the sag; observed 4e-4
    across, along = (
        np.abs(loads[2][:, :2] @ way).max() for way in ([-tangent[1], tangent[0]], tangent)
    )
    assert across > 0.1 * force
    assert along < 1e-3 * across  # observed 4e-4; a force straight up would give 0.6


def test_energy_is_kept_on_a_slope():
    """Eccentric ice that rotates in the plane of the section; without damping and wind."""
    scene = gf.load_scene("example3").with_values(
        {
            "span.height_difference": 90.0,
            "span.sag": None,
            "wind.speed": 0.0,
            "damping.translation": None,
            "damping.twist": None,
            "initial.seed_vertical": 0.0,
            "initial.seed_horizontal": 0.0,
            "numerics.integrator": "gauss6",
            "numerics.newton_tolerance": 1e-11,
            "numerics.time_step": 0.005,
            "loads": [
                {
                    "evenly_spaced": 29,
                    "force": [0.0, 15.0, 5.0],
                    "torque": 0.08,
                    "law": {"kind": "ramp", "initial": 1.0, "final": 0.0, "duration": 0.5},
                }
            ],
        }
    )
    model = gf.Model(scene)
    state = model.rest()
    state.advance(0.5)
    run = state.run(
        400, 10, nodes=np.array([model.middle], np.int32), channels=np.array([3], np.int32)
    )
    names = SPAN_INDEX
    energy = (
        run.span_values[:, names["kinetic_energy"]] + run.span_values[:, names["potential_energy"]]
    )
    assert np.ptp(run.node_values) > 0.15  # rad: the ice turns
    assert np.ptp(energy) / energy.mean() < 2e-9  # observed 4e-10


def test_the_fmu_is_the_simulation(tmp_path):
    """A sloping span that gallops at 4.2 m/s; in release 0.1.0 its critical wind was 4.54 m/s."""
    import fmpy

    scene = sloping(0.5, wind__speed=4.2, numerics__elements=12)
    gf.export_fmu(scene, tmp_path / "slope.fmu")
    records = fmpy.simulate_fmu(
        str(tmp_path / "slope.fmu"),
        stop_time=40.0,
        output_interval=0.05,
        start_values={"wind_speed": 4.2},
        output=["midspan.x2"],
    )
    result = gf.simulate(scene, stop_time=40.0, record_every=5)
    assert np.array_equal(records["midspan.x2"][1:], result.midspan()["u2"].values[1:])
    u2 = records["midspan.x2"]
    assert np.ptp(u2[600:]) > 1.1 * np.ptp(u2[200:400])
