"""Published models with mode superposition: Desai et al. (1995) and Yu et al. (1993).

Desai et al. printed 1.58 m vertical and 0.04 m horizontal for example 2 of Liu, Yan, Zhang, Zhou
(2009), with the coefficients that the latter only show in a figure; here the curve is a
reconstruction.
"""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gallop_fmu as gf
import modal


@pytest.fixture(scope="module")
def galloping():
    scene = gf.load_scene("example2").with_values({"numerics.time_step": 0.02})
    return modal.compare(scene, 700.0)


@pytest.fixture(scope="module")
def resonance():
    scene = gf.load_scene("example3").with_values({
        "numerics.time_step": 0.02, "numerics.newton_tolerance": 1e-9, "run.record_every": 2,
    })  # fmt: skip
    return modal.compare(scene, 900.0)


def test_vertical_galloping_needs_no_nonlinear_structure(galloping, amplitudes):
    full, simple = amplitudes(galloping.nonlinear), amplitudes(galloping.superposition)
    assert simple[0] == pytest.approx(full[0], rel=0.012)  # observed 0.95 %: 1.5623 m, not 1.5476 m
    assert simple[2] == pytest.approx(full[2], rel=0.025)  # observed -1.9 %
    assert simple[1] == pytest.approx(full[1], rel=0.08)  # observed 6.1 %: 0.0614 m, not 0.0579 m
    assert simple[0] == pytest.approx(1.58, rel=0.015)  # Desai et al.; observed -1.1 %
    steady = galloping.superposition.steady()["u2"], galloping.nonlinear.steady()["u2"]
    assert (
        steady[0].frequency_hz < 0.99 * steady[1].frequency_hz
    )  # observed 0.4968, 0.5024: the stretch stiffens


def test_three_modes_in_each_direction_are_enough(galloping, amplitudes):
    scene = galloping.nonlinear.scene
    few = amplitudes(modal.mode_superposition(scene, 700.0, vertical=3, horizontal=3, torsional=3))
    # observed 2e-5, -2.4e-3, 7e-6
    assert few == pytest.approx(amplitudes(galloping.superposition), rel=4e-3)


def test_the_swing_exists_only_in_the_nonlinear_model(resonance):
    motion = resonance.amplitudes()
    full, simple = motion["nonlinear"], motion["superposition"]
    assert full["u3"].amplitude == pytest.approx(0.1918, rel=2e-3)
    assert full["u3"].frequency_hz == pytest.approx(0.5 * full["u2"].frequency_hz, rel=1e-3)
    assert simple["u3"].amplitude < 0.005  # observed 0.0039 m
    assert (
        simple["u3"].frequency_hz > 0.99 * simple["u2"].frequency_hz
    )  # observed: twice, from the drag
    assert simple["u2"].amplitude > 1.4 * full["u2"].amplitude  # observed 0.6296 and 0.4434 m
    assert resonance.linear.outcome is gf.Outcome.ANGLE_OUT_OF_RANGE
    assert motion["linear"]["u3"].amplitude < 0.001


def test_where_the_models_part(resonance):
    transfer = resonance.divergence("superposition", "u2", 0.2)
    assert 580.0 < transfer.amplitude < 640.0  # observed 612 s: when the swing starts
    assert (
        resonance.divergence("linear", "u2", 0.2).amplitude < 520.0
    )  # observed 500 s: nothing saturates
    assert transfer.history < 5.0  # the wind blows the span aside, which lifts it, at once


def test_linear_theory_names_the_galloping_mode(resonance):
    first = resonance.linear_modes[0]
    assert first.family == "vertical"
    assert first.frequency_hz == pytest.approx(0.6845, rel=1e-4)
    assert first.growth_rate == pytest.approx(0.01237, rel=1e-3)
    assert all(
        mode.growth_rate < 0.0 for mode in resonance.linear_modes if mode.family != "vertical"
    )


def test_a_comparison_is_plain_numbers(resonance):
    again = json.loads(json.dumps(resonance.as_dict(), allow_nan=False))
    assert set(again["models"]) == {"nonlinear", "superposition", "linear"}
    assert again["models"]["linear"]["outcome"] == "angle_out_of_range"
    assert len(again["divergences"]) == 2 * 3 * 2
    assert "superposition" in str(resonance)


def test_the_figure_of_a_comparison(resonance, tmp_path):
    from gallop_fmu.plots import save_figure
    from modal.plots.comparison_figure import comparison_figure

    figure = comparison_figure(resonance)
    assert "nonlinear simulation: " + str(
        resonance.nonlinear.motion
    ) in figure.get_supxlabel().replace("\n", " ")
    for sentence in resonance.linear.warnings:
        assert f"Warning: {sentence}" in figure.get_supxlabel().replace("\n", " ")
    panels = [axes for part in figure.subfigs for axes in part.axes]
    assert len(panels) == 9
    assert all(axes.lines for axes in panels)
    assert save_figure(figure, tmp_path / "comparison.png").stat().st_size > 20_000


def test_three_equations_of_motion_of_a_taut_span():
    """Yu et al.: half sines with masses, stiffnesses and couplings by hand; eccentric ice."""
    tension, length, radius = 150e3, 125.88, 0.5 * 0.0235
    scene = gf.load_scene("example3").with_values(
        {
            "span.sag": None,
            "span.horizontal_tension": tension,
            "wind.speed": 8.0,
            "damping.translation.low_ratio": 0.002,
            "damping.translation.high_ratio": 0.002,
            "initial.seed_vertical": 0.3,
            "initial.seed_horizontal": 0.1,
            "initial.seed_twist": 0.2,
        }
    )
    c, wave_number, curvature = (
        scene.conductor,
        np.pi / length,
        scene.conductor.mass_per_length * 9.81 / tension,
    )
    m2, m3 = scene.ice.first_moment_x2, scene.ice.first_moment_x3
    mass = np.array(
        [[c.mass_per_length, 0, -m3], [0, c.mass_per_length, m2], [-m3, m2, c.torsional_inertia]]
    )
    elastic = np.array([tension, tension, c.torsional_stiffness]) * wave_number**2
    elastic[0] += (
        8.0 / np.pi**2 * c.axial_stiffness * curvature**2
    )  # the sag, by its curvature, makes the span stretch
    stiffness = np.diag(elastic) - 9.81 * np.diag([0.0, 0.0, m2])
    derived = gf.Model(scene).equilibrium()
    (b1, b2), (t1, t2) = derived.translation_damping, derived.twist_damping
    damping = np.diag([b1, b1, t1] * np.diag(mass) + [b2, b2, t2] * elastic)
    x, w = np.polynomial.legendre.leggauss(
        20
    )  # weights that sum to 2, as the square of a half sine has a mean of 1/2
    wave = np.sin(np.pi * (1 + x) / 2)
    lift, drag, moment = (
        np.polynomial.Polynomial(getattr(scene.aerodynamics, n)) for n in ("lift", "drag", "moment")
    )

    def rates(_, state):
        q, v = state[:3], state[3:]
        w2, w3 = -wave * (v[0] + radius * v[2]), 8.0 - wave * v[1]
        speed, angle = np.hypot(w2, w3), wave * q[2] + np.arctan2(w2, w3)
        half = scene.wind.air_density * radius * speed
        cl, cd, cm = lift(angle), drag(angle), moment(angle)
        force = (w * wave * half) @ np.stack(
            [cl * w3 + cd * w2, cd * w3 - cl * w2, speed * 2 * radius * cm], axis=1
        )
        return np.concatenate([v, np.linalg.solve(mass, force - damping @ v - stiffness @ q)])

    exact = solve_ivp(
        rates, (0, 12), [0.3, 0.1, 0.2, 0, 0, 0], "DOP853", rtol=1e-9, atol=1e-10, dense_output=True
    )
    result = modal.mode_superposition(scene, 12.0, vertical=1, horizontal=1, torsional=1)
    data, wanted = result.midspan(), exact.sol(result.dataset.time.values)[:3]
    for name, values in zip(("u2", "u3", "theta"), wanted, strict=True):
        error = np.abs(data[name].values - values).max() / np.ptp(values)
        assert error < 2.5e-4  # observed 1.3e-4, 1.5e-5, 1.3e-4
