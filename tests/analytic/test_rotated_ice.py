"""The attack angle rotates the first mass moments of the ice as well as the coefficient curve."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal

X2, X3 = "ice.first_moment_x2", "ice.first_moment_x3"
LINE = {"conductor": "Drake", "span": 250.0, "stringing_percent": 20.0, "ice_thickness": 0.012}


def example3(**values):
    return gf.load_scene("example3").with_values(
        {key.replace("__", "."): value for key, value in values.items()}
    )


def turned_by_hand(scene, angle):
    """The same section with first moments that are rotated by hand to an attack angle [deg]."""
    turn = np.radians(angle - scene.ice.attack_angle_deg)
    m2, m3 = scene.ice.first_moment_x2, scene.ice.first_moment_x3
    return scene.with_values(
        {
            "ice.attack_angle_deg": angle,
            X2: float(m2 * np.cos(turn) - m3 * np.sin(turn)),
            X3: float(m2 * np.sin(turn) + m3 * np.cos(turn)),
        }
    )


def test_moments_given_with_an_attack_angle_belong_to_it():
    scene = example3()
    assert scene.ice.first_moment_angle_deg == 180.0
    given = scene.with_values({"ice.attack_angle_deg": 150.0, X2: 1e-3})
    assert given.ice.first_moment_angle_deg == 150.0
    assert given.ice.first_moments() == pytest.approx((1e-3, scene.ice.first_moment_x3), rel=1e-15)


@pytest.mark.parametrize("angle", [150.0, 200.0, -170.0])
def test_a_changed_attack_angle_rotates_the_moments(angle):
    """As a twist by the same angle: x2 and x3 of a mass point rotate, right-handed about x1."""
    scene = example3(ice__attack_angle_deg=angle)
    assert scene.ice.first_moments() == pytest.approx(
        turned_by_hand(example3(), angle).ice.first_moments(), rel=1e-12
    )
    step = {"stop_time": 5.0, "record_every": 100}
    motion = [
        gf.simulate(s, **step).midspan()["theta"].values
        for s in (scene, turned_by_hand(example3(), angle))
    ]
    assert motion[0] == pytest.approx(motion[1], rel=1e-8, abs=1e-12)
    unturned = scene.with_values({"ice.first_moment_angle_deg": angle})
    other = gf.simulate(unturned, **step).midspan()["theta"].values
    assert np.abs(other - motion[0]).max() > 0.02 * np.ptp(motion[0])


@pytest.mark.parametrize("angle", [160.0, 215.0])
def test_a_line_built_at_an_angle_is_a_line_rotated_to_it(angle):
    """The moments of a line's ice come from its shape at the attack angle."""
    built = gf.Scene.from_dict({"line": {**LINE, "attack_angle_deg": angle}})
    turned = gf.Scene.from_dict({"line": {**LINE, "attack_angle_deg": 180.0}}).with_values(
        {"ice.attack_angle_deg": angle}
    )
    assert turned.ice.first_moments() == pytest.approx(built.ice.first_moments(), rel=1e-12)


def test_an_explicit_attack_angle_rotates_the_ice_of_the_line():
    """Moments of [line] belong to its angle; those of [ice] belong to the angle in [ice]."""
    line = {**LINE, "attack_angle_deg": 180.0}
    explicit = gf.Scene.from_dict({"line": line, "ice": {"attack_angle_deg": 150.0}})
    built = gf.Scene.from_dict({"line": {**LINE, "attack_angle_deg": 150.0}})
    assert explicit.ice.first_moments() == pytest.approx(built.ice.first_moments(), rel=1e-12)
    own = {"attack_angle_deg": 150.0, "first_moment_x2": 1e-3, "first_moment_x3": 2e-3}
    assert gf.Scene.from_dict({"line": line, "ice": own}).ice.first_moments() == (1e-3, 2e-3)


def test_a_host_that_sets_the_angle_rotates_the_ice_too():
    """Bit for bit that of a scene at this angle; in between, that scene's residual."""
    scene, other = example3(), example3(ice__attack_angle_deg=165.0)
    inputs = gf.Inputs(0.0, 5.5, np.radians(165.0), np.zeros((2, 3)))
    one, two = gf.Model(scene), gf.Model(other)
    left, right = one.start(0.0, inputs), two.start(0.0, inputs)
    for state in (left, right):
        state.advance(1.0, inputs)
    assert np.array_equal(left.motion()[0], right.motion()[0])
    random = np.random.default_rng(6)
    u, v, a = (random.uniform(-0.1, 0.1, (one.nodes, 4)) for _ in range(3))
    assert np.array_equal(
        one.residual(u, v, a, inputs=inputs), two.residual(u, v, a, inputs=inputs)
    )


def test_the_coupled_criterion_rotates_the_ice_over_the_curve():
    """Its value at an angle is that of the span with its ice at this angle."""
    criterion = modal.coupled(example3(), 6.0)
    for angle in (140.0, 165.0, 205.0):
        own = modal.coupled(turned_by_hand(example3(), angle), 6.0)
        value = np.interp(np.radians(angle), criterion.attack_angle, criterion.value)
        assert value == pytest.approx(
            np.interp(np.radians(angle), own.attack_angle, own.value), rel=2e-3, abs=2e-5
        )  # own frequencies
    unturned = modal.coupled(example3(ice__first_moment_x2=0.0, ice__first_moment_x3=0.0), 6.0)
    assert np.abs(unturned.value - criterion.value).max() > 1e-3


def test_slopes_by_the_attack_angle_against_differences():
    """Modes of the linear model about the equilibrium in wind, where eccentric ice has rotated."""
    from modal.linear.linearise import SmallMotion

    scene = example3(
        ice__attack_angle_deg=160.0, wind__speed=12.0, numerics__newton_tolerance=1e-12
    )
    motion = SmallMotion(scene)
    found, model = motion.in_mean_wind(), motion.model
    step = 1e-4

    def force(change):
        angle = np.radians(160.0) + change
        return -model.residual(
            found.displacement, inputs=gf.Inputs(0.0, 12.0, angle, np.zeros((2, 3)))
        ).ravel()

    slope = (force(step) - force(-step)) / (2.0 * step)
    inner = found.free.ravel()
    assert np.abs(found.displacement[:, 3]).max() > 0.05
    assert np.abs((found.by_attack_angle - slope)[inner]).max() < 1e-6 * np.abs(slope[inner]).max()
