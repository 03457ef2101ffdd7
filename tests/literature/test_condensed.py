"""The condensed span gallops as the paper's examples do in the element and an independent prototype."""

import pytest

import gallop_fmu as gf

SPRING = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": 1e9}
CASES = {
    "example 2": ("example2", {}, (1.548, 0.0579, 0.111)),
    "example 3": ("example3", {}, (0.4417, 0.1915, 0.1842)),
    "example 3, 5.0 m/s": ("example3", {"wind.speed": 5.0}, (0.386, 0.0106, 0.164)),
    "example 3, springs": ("example3", {"supports.left": SPRING, "supports.right": SPRING}, (1.896, 0.0936, 0.3428)),
}


@pytest.mark.parametrize("case", CASES)
def test_steady_amplitudes(case, amplitudes):
    """Without the damping of quadratic stretching, the last case would reach 2.12 m."""
    name, changes, right = CASES[case]
    scene = gf.load_scene(name).with_values({"initial.seed_vertical": -0.3, **changes})
    assert amplitudes(gf.simulate_condensed(scene, 2000.0)) == pytest.approx(right, rel=0.012)


def test_the_swing_has_half_the_vertical_frequency():
    steady = gf.simulate_condensed(gf.load_scene("example3"), 2000.0).steady(100.0)
    assert steady["u3"].frequency_hz / steady["u2"].frequency_hz == pytest.approx(0.5, abs=1e-4)
