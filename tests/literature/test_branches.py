"""Branches of galloping spans: closed form of Parkinson and Smith's prism, and example 2."""

from pathlib import Path

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from modal.continuation.path import Settings
from modal.continuation.starts import equilibria, switched
from modal.linear.mode_basis import still_air_modes
from modal.motions.rotated import rotated_equilibria
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import SpanProblem, WindFamily
from support.square_prism import fold_winds, limit_cycles, onset_wind_speed, prism


def test_span_with_the_prisms_curve_has_its_hysteresis():
    onset = onset_wind_speed()
    scene = prism(onset, 1e-3)
    model = SpanModel(scene, still_air_modes(scene, 8))
    problem = SpanProblem(WindFamily(model), model, onset)
    settings = Settings(
        0.8 * onset, 2.2 * onset, tolerance=1e-4, first_step=0.05, max_step=0.3, max_points=60
    )
    rest = equilibria(problem, np.zeros(problem.size), 0.9 * onset, settings)
    first = rest.of_kind("Hopf")[0]
    # observed 1.0015: PCHIP lowers the slope of the curve at 0
    assert first.parameter == pytest.approx(onset, rel=2e-3)
    (found,) = switched(first, settings)
    # the same kinks cause a fold beside the onset, at an amplitude of 0.3 mm
    high, low = (fold.parameter / onset for fold in found.of_kind("fold")[-2:])
    expected = fold_winds()
    assert (low, high) == pytest.approx(expected, rel=1e-3)  # observed 4.0e-4 and 2.6e-4
    middle = 0.5 * sum(expected)
    for point, stable in zip(found.at(middle * onset), (True, False, True), strict=True):
        assert point.is_stable == stable
    n = model.size
    for point in found.points:
        amplitude = 0.5 * np.ptp(point.states[:, :n] @ model.middle[:, 1])
        wind = point.parameter / onset
        if wind > 1.2 and min(abs(wind / fold - 1.0) for fold in expected) > 0.02:
            nearest = min(limit_cycles(wind), key=lambda one: abs(one - amplitude))
            assert amplitude == pytest.approx(nearest, rel=1e-3)  # observed 7e-4


def test_example_2_gallops_in_one_or_in_two_loops():
    """One loop: 1.548 / 0.0579 m and 0.111 rad in 4.1 m/s (a prototype; the paper 1.544 / 0.058 m).

    Two loops are stable, too: a state that coexists, which no simulation from rest shows.
    """
    found = modal.branches(gf.load_scene("example2"), "wind.speed", 3.9, 4.3)
    data = found.dataset
    assert data["name"].values.tolist() == ["rest", "one loop", "two loops"]
    assert "range was extended" in found.remarks[0]
    at = [
        data.isel(point=np.flatnonzero(data.branch_of_point.values == number)).sortby("value")
        for number in (1, 2)
    ]

    def amplitude(number, name):
        return float(np.interp(4.1, at[number].value.values, at[number][name].values))

    assert amplitude(0, "u2_amplitude") == pytest.approx(1.548, rel=1e-3)  # observed 1.5476
    assert amplitude(0, "u3_amplitude") == pytest.approx(0.0579, rel=2e-3)
    assert amplitude(0, "theta_amplitude") == pytest.approx(0.111, rel=5e-3)
    assert amplitude(1, "u2_amplitude") < 1e-3
    assert amplitude(1, "quarter_amplitude") == pytest.approx(0.708, rel=1e-3)  # regression
    assert all(bool(branch.is_stable.values[-1]) for branch in at)
    assert np.nanmax(data.reduction_error.values) < 2e-3


FULL_CIRCLE = gf.load_scene(Path(__file__).parent / "data" / "full_circle_350m.toml")
"""Drake with 15 mm of crescent ice over 350 m; the curve covers a whole turn."""


def test_the_long_span_ends_at_the_only_stable_state_turned_over():
    """Of its equilibria in 6 m/s one is stable: that at which simulations end."""
    scene = FULL_CIRCLE.with_values(
        {
            "wind.speed": 6.0,
            "initial.wind": "mean_wind_equilibrium",
            "initial.seed_vertical": 0.3,
            "numerics.elements": 8,
        }
    )
    model = SpanModel(scene, still_air_modes(scene))
    problem = SpanProblem(WindFamily(model), model, 6.0)
    stable = []
    for state, wind in rotated_equilibria(problem, 5.5, 6.5):
        rates = np.linalg.eigvals(problem.rates(state[None], wind).by_state[0])
        if wind == 6.0 and np.max(rates.real) < 0.0:
            stable.append(float(state[: model.size] @ model.middle[:, 3]))
    run = gf.simulate(scene, stop_time=900.0, record_every=50, span_channels=())
    assert stable == [pytest.approx(run.dataset.theta.values[-1].item(), abs=0.02)]
    assert np.degrees(stable[0]) == pytest.approx(-243.0, abs=1.0)
