"""Damping ratios, modes in mean wind and mode tracking against closed formulas."""

import math
from dataclasses import replace

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from modal.linear.linearise import linearised
from modal.linear.modes import modes_of


@pytest.fixture(scope="module")
def scene():
    return gf.load_scene("example3")


def rayleigh(pair, frequency):
    w = [2.0 * math.pi * f for f in (pair.low_frequency, pair.high_frequency, frequency)]
    x1, x2 = pair.low_ratio, pair.high_ratio
    b1 = 2.0 * w[0] * w[1] * (x1 * w[1] - x2 * w[0]) / (w[1] ** 2 - w[0] ** 2)
    b2 = 2.0 * (x2 * w[1] - x1 * w[0]) / (w[1] ** 2 - w[0] ** 2)
    return b1 / (2.0 * w[2]) + b2 * w[2] / 2.0


def test_damping_ratios_in_still_air_are_rayleighs(scene):
    # without eccentric ice, and in a state that is an equilibrium: C is then M and K of the same
    # state
    plain = scene.with_values(
        {"span.sag": None, "ice.first_moment_x2": 0.0, "ice.first_moment_x3": 0.0}
    )
    for mode in modal.natural_modes(plain, count=30):
        pair = plain.damping.twist if mode.family == "torsional" else plain.damping.translation
        assert mode.damping_ratio == pytest.approx(
            rayleigh(pair, mode.frequency_hz), rel=1e-12
        )  # observed 1.6e-14


def test_an_undamped_span_has_no_damping(scene):
    undamped = scene.with_values({"damping.translation": None, "damping.twist": None})
    assert [mode.damping_ratio for mode in modal.natural_modes(undamped)] == [0.0] * 12


@pytest.mark.parametrize("angle", [180.0, 130.0])
def test_aerodynamic_damping_of_vertical_motion_is_den_hartogs(scene, angle):
    # twist frozen by a stiff conductor, and so little wind that the span hangs as in still air
    wind = 0.2
    frozen = scene.with_values(
        {
            "conductor.torsional_stiffness": 1e6,
            "ice.first_moment_x2": 0.0,
            "ice.first_moment_x3": 0.0,
            "ice.attack_angle_deg": angle,
            "wind.speed": wind,
        }
    )
    curve, mass, d = (
        frozen.aerodynamics.curve(),
        frozen.conductor.mass_per_length,
        frozen.conductor.diameter,
    )
    still, blown = (
        {(m.family, m.loops): m for m in modal.natural_modes(frozen, 8, w)}
        for w in ("still", "mean")
    )
    tangent = np.gradient(gf.Model(frozen).equilibrium().x[:, :2], axis=0)
    for key in (("vertical", 1), ("vertical", 3)):
        expected = frozen.wind.air_density * wind * d * float(curve.den_hartog(math.radians(angle)))
        expected /= 4.0 * mass * 2.0 * math.pi * still[key].frequency_hz
        move = still[key].shape[:, :2]
        across = (tangent[:, 0] * move[:, 1] - tangent[:, 1] * move[:, 0]) / np.linalg.norm(
            tangent, axis=1
        )
        expected *= np.sum(across**2) / np.sum(
            move**2
        )  # the part along the conductor meets no wind
        aerodynamic = blown[key].damping_ratio - still[key].damping_ratio
        assert aerodynamic == pytest.approx(expected, rel=1e-3)  # observed 8.2e-4


def test_modes_in_wind_solve_the_eigenvalue_problem(scene):
    span = gf.Model(scene)
    u = span.rest().motion()[0]
    m, c, k = (span.tangent(u, **{part: 1.0}) for part in ("mass", "damping", "stiffness"))
    for mode in modal.natural_modes(scene, 8, wind="mean"):
        s, phi = mode.eigenvalue, mode.shape + 1j * mode.quadrature
        force = np.zeros(4 * span.nodes, dtype=complex)
        inertia = np.zeros_like(force)
        for e in range(span.elements):
            here = slice(8 * e, 8 * e + 12)
            inertia[here] += s**2 * m[e] @ phi.ravel()[here]
            force[here] += (s**2 * m[e] + s * c[e] + k[e]) @ phi.ravel()[here]
        inner = slice(4, -4)  # the ends are fixed
        assert np.abs(force[inner]).max() < 1e-10 * np.abs(inertia[inner]).max()  # observed 8e-12
        assert np.sum(phi.conj().ravel()[inner] * (inertia / s**2)[inner]) == pytest.approx(
            1.0, abs=1e-12
        )
        assert mode.damping_ratio == pytest.approx(-s.real / abs(s))


def test_sparse_and_dense_eigensolvers_agree_in_wind(scene):
    coarse = scene.with_values({"numerics.elements": 4})
    few, every = modal.natural_modes(coarse, 4, "mean"), modal.natural_modes(coarse, 20, "mean")
    for sparse, dense in zip(few, every, strict=False):
        assert sparse.eigenvalue == pytest.approx(dense.eigenvalue, rel=1e-13)  # observed 7.8e-15


def test_effective_masses_add_up_to_the_span(scene):
    modes = modal.natural_modes(scene.with_values({"numerics.elements": 8}), 60)
    mass = scene.conductor.mass_per_length
    for family in ("vertical", "horizontal"):
        effective = sum(mode.participation[family] ** 2 for mode in modes) * mass
        length = gf.Model(scene).equilibrium().length
        assert effective == pytest.approx(
            length, rel=0.04
        )  # observed 0.027, which is in the modes above


def test_participation_gives_the_response_to_a_uniform_load(scene):
    # the modes' share of a static deflection against that of the nonlinear model under many small
    # loads
    calm = scene.with_values(
        {
            "ice.first_moment_x2": 0.0,
            "ice.first_moment_x3": 0.0,
            "wind.speed": 0.0,
            "span.sag": None,
        }
    )
    per_metre, points = 1e-3, 239
    arc = gf.Model(calm).equilibrium().length
    for family, direction in (("vertical", 1), ("horizontal", 2)):
        force = [0.0, 0.0, 0.0]
        force[direction] = per_metre * arc / (points + 1)
        loaded = calm.with_values({"loads": [{"evenly_spaced": points, "force": force}]})
        expected = gf.Model(loaded).rest().motion()[0][15, direction]
        modes = modal.natural_modes(calm, 40)
        deflection = per_metre * sum(
            mode.participation[family]
            / (2.0 * np.pi * mode.frequency_hz) ** 2
            * mode.shape[15, direction]
            for mode in modes
        )
        assert deflection == pytest.approx(expected, rel=3e-4)  # observed 1.5e-4: 40 modes


def test_two_modes_that_cross_keep_their_names(scene):
    free = scene.with_values({"span.sag": None})
    values = [12000.0, 13000.0, 14000.0, 15000.0]
    tracked = modal.track_modes(free, "span.horizontal_tension", values, count=4)
    share = tracked.share.sel(family="vertical").values
    assert np.ptp(share, axis=1).max() < 0.05
    order = np.argsort(tracked.frequency_hz.values, axis=0)
    assert not np.array_equal(order[:, 0], order[:, -1])  # the symmetric vertical mode is overtaken


def test_veering_stays_veering(scene):
    # an inclined span has no symmetry that would let its vertical modes cross
    inclined = scene.with_values({"span.sag": None, "span.height_difference": 40.0})
    values = np.linspace(11000.0, 17000.0, 7)
    tracked = modal.track_modes(inclined, "span.horizontal_tension", list(values), count=4)
    vertical = tracked.share.sel(family="vertical").values[:, 0] > 0.5
    lower, upper = np.sort(tracked.frequency_hz.values[vertical], axis=0)
    assert np.all(upper - lower > 0.01)
    first, second = tracked.frequency_hz.values[vertical]
    assert np.all((first > second) == (first > second)[0])  # neither passes the other
    assert float(tracked.likeness.min()) > 0.8


def test_the_wind_speed_can_be_swept(scene):
    tracked = modal.track_modes(scene, "wind.speed", [0.0, 3.0, 6.0], count=2, wind="mean")
    vertical = tracked.damping_ratio.values[1]
    assert vertical[0] == pytest.approx(0.016, rel=1e-3)
    assert vertical[2] < 0.0 < vertical[1]


def test_divergence_in_twist_is_named(scene):
    # (rho U^2 d^2/2) CM' against GJ (pi/L)^2: 40 per rad at 2.5 m/s leaves 6 %, 45 is 5 % too much
    flat = scene.with_values(
        {"wind.speed": 2.5, "ice.first_moment_x2": 0.0, "ice.first_moment_x3": 0.0}
    )
    assert modal.natural_modes(flat.with_values({"aerodynamics.moment": [0.0, 40.0]}), wind="mean")
    with pytest.raises(gf.SceneError, match=r"no equilibrium in wind of 2.5 m/s.*twist divergence"):
        modal.natural_modes(flat.with_values({"aerodynamics.moment": [0.0, 45.0]}), wind="mean")


def test_a_wind_that_leaves_the_curve_is_named(scene):
    with pytest.raises(
        gf.SceneError,
        match=r"no equilibrium in wind of 40 m/s.*below the curve's lower limit of 100 deg",
    ):
        modal.natural_modes(
            scene.with_values({"ice.attack_angle_deg": 100.5, "wind.speed": 40.0}), wind="mean"
        )


def test_an_equilibrium_that_is_none_to_stay_in_is_named(scene):
    equations = linearised(scene, "mean")
    softened = replace(
        equations, stiffness=equations.stiffness - 10.0 * equations.mass
    )  # the first mode has 5.6 1/s2
    with pytest.raises(gf.SceneError, match=r"in wind of 5\.5 m/s is statically unstable"):
        modes_of(softened, scene, 4)


def test_an_unknown_state_of_the_wind_is_named(scene):
    with pytest.raises(gf.SceneError, match="wind = 'strong'"):
        modal.natural_modes(scene, wind="strong")
