"""Continuation of a galloping span against the closed form of Parkinson and Smith's prism."""

import numpy as np
import pytest

from modal.continuation.path import Settings
from modal.continuation.starts import equilibria, switched
from modal.linear.mode_basis import still_air_modes
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
