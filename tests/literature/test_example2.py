"""Example 2 of Liu et al. (2009): one-loop vertical galloping with little horizontal motion.

The coefficient curve is a reconstruction chosen to give the printed amplitudes, so agreement with
the paper says that the equations are the paper's, not that the curve is. The prototype is an
independent code of the same equations.
"""

import pytest

import gallop_fmu as gf


@pytest.fixture(scope="module")
def galloping():
    return gf.simulate(gf.load_scene("example2"))


def test_amplitudes_of_the_prototype(galloping, amplitudes):
    # observed 1.5476 m, 0.05787 m, 0.11103 rad: -0.03 %, -0.05 %, 0.03 %, the digits printed
    assert amplitudes(galloping) == pytest.approx([1.548, 0.0579, 0.111], rel=1.5e-3)


def test_amplitudes_of_the_paper(galloping, amplitudes):
    # observed 0.23 % and -0.22 %
    assert amplitudes(galloping)[:2] == pytest.approx([1.544, 0.058], rel=4e-3)


def test_one_frequency_for_both_directions(galloping):
    steady = galloping.steady(100.0)
    assert steady["u2"].frequency_hz == pytest.approx(
        0.5024, rel=1e-3
    )  # observed 0.50238, dt 0.02: 0.50226
    assert steady["u3"].frequency_hz == pytest.approx(steady["u2"].frequency_hz, rel=1e-4)


def test_the_amplitude_does_not_depend_on_the_time_step(galloping, amplitudes):
    coarse = gf.simulate(galloping.scene.with_values({"numerics.time_step": 0.02}))
    assert amplitudes(coarse) == pytest.approx(amplitudes(galloping), rel=2e-4)  # observed 4e-5
