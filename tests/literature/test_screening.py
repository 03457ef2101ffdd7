"""Screening for 2:1 internal resonance against the simulation and Liu et al. (2009), example 3."""

import json
from pathlib import Path

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from modal.linear.mode_basis import still_air_modes
from modal.motions.reduced_model import reduced_model
from modal.screening.beating import beating_cycle
from modal.screening.other_modes import first_other_mode
from support.simulated_swing import FULL_RUN, SEED, drawn_scene, simulated

SPRING = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": 1e9}
PUSHED = 700.0


@pytest.fixture(scope="module")
def third():
    return gf.load_scene("example3")


@pytest.fixture(scope="module")
def screened(third):
    return modal.screen(third)


def pushed_swing(scene, wind, vertical_seed):
    """Amplitudes [m] of the simulated swing after a small push into galloping, and 240 s later."""
    law = {
        "kind": "pulse",
        "peak": 1.0,
        "start": PUSHED,
        "rise": 0.25,
        "fall_start": PUSHED + 0.25,
        "fall": 0.25,
    }
    values = {
        "wind.speed": wind, "numerics.elements": 10, "numerics.time_step": 0.02,
        "initial.seed_horizontal": 0.0,
        "initial.seed_vertical": -vertical_seed, "loads": [{"force": [0.0, 0.0, 1.0],
        "position": 0.5, "law": law}],
    }  # fmt: skip
    motion = gf.simulate(
        scene.with_values(values), stop_time=PUSHED + 302.0, record_every=4
    ).midspan()

    def half_frequency(start):
        part = motion.sel(time=slice(start, start + 60.0))
        window = np.blackman(part.sizes["time"])
        u3 = part.u3.values - part.u3.values @ window / window.sum()
        frequency = np.fft.rfftfreq(len(u3), 0.08)
        vertical = frequency[np.argmax(np.abs(np.fft.rfft(part.u2.values * window))[3:]) + 3]
        near = (frequency > 0.4 * vertical) & (frequency < 0.6 * vertical)
        return np.max(np.abs(np.fft.rfft(u3 * window))[near]) * 2.0 / window.sum()

    return half_frequency(PUSHED + 1.0), half_frequency(PUSHED + 241.0)


def test_example_3_swings_and_saturates_as_in_the_paper(screened):
    assert screened.risk == "certain"
    assert screened.swings
    assert screened.frequencies.ratio == pytest.approx(0.69541 / 0.37752, rel=1e-4)
    # the prototype's steady state, extrapolated from tests/literature/test_example3.py
    assert screened.saturated.vertical == pytest.approx(
        0.4417, rel=3e-3
    )  # observed 0.44125, -0.1 %
    assert screened.saturated.horizontal == pytest.approx(
        0.1915, rel=6e-3
    )  # observed 0.19202, 0.3 %
    assert screened.saturated.twist == pytest.approx(0.1842, rel=3e-3)  # observed 0.18420
    assert screened.saturated.multiplier < 1.0
    # the vertical-only plateau, which the simulation leaves before it has quite settled
    assert screened.galloping.vertical == pytest.approx(0.577, rel=0.02)  # observed 0.5847
    assert "2:1" in screened.reason
    assert "0.405 m" in screened.reason


def test_below_the_onset_example_3_gallops_without_swing(third):
    found = modal.screen(third.with_values({"wind.speed": 5.0}))
    assert found.risk == "possible"
    assert found.galloping.vertical == pytest.approx(0.3865, rel=3e-3)  # observed 0.3862
    assert found.galloping.horizontal == pytest.approx(0.0106, rel=0.01)  # observed 0.01057
    assert found.galloping.multiplier < 1.0


@pytest.mark.parametrize("stiffness_x3", [1e9, 1361.6])
def test_on_the_springs_of_table_1_there_is_no_swing(third, stiffness_x3):
    spring = SPRING | {"stiffness_x3": stiffness_x3}
    found = modal.screen(third.with_values({"supports.left": spring, "supports.right": spring}))
    assert found.risk == "detuned"
    assert found.onset_wind_speed is None
    assert not found.estimate.swings
    assert found.galloping.vertical == pytest.approx(1.90, rel=5e-3)  # observed 1.897 and 1.905
    assert found.galloping.horizontal == pytest.approx(
        0.0944 if stiffness_x3 == 1e9 else 0.0215, rel=0.01
    )


def test_example_2_gallops_as_printed_and_is_detuned():
    found = modal.screen(gf.load_scene("example2"))
    assert found.risk == "detuned"
    assert found.galloping.vertical == pytest.approx(1.548, rel=2e-3)  # observed 1.5476
    assert found.galloping.horizontal == pytest.approx(0.0579, rel=5e-3)  # observed 0.05785
    assert found.galloping.twist == pytest.approx(0.111, rel=5e-3)  # observed 0.11110


def test_the_swing_of_the_simulation_starts_at_the_predicted_wind(third, screened):
    """Bisected, the onset of the nonlinear model is 5.05 m/s; here it is enclosed within 1 %."""
    onset, threshold = screened.onset_wind_speed, screened.threshold_amplitude
    assert onset == pytest.approx(5.05, rel=4e-3)  # observed 5.041
    at_first, later = pushed_swing(third, 0.99 * onset, threshold)
    assert later < 0.2 * at_first < 1e-3
    assert pushed_swing(third, 1.01 * onset, threshold)[1] > 0.05  # observed 0.063


def test_at_the_onset_a_swing_does_not_grow_or_decay(third, screened):
    """Newton's orbit at the onset of the root search."""
    there = modal.screen(third.with_values({"wind.speed": screened.onset_wind_speed}))
    assert there.growth_per_cycle == pytest.approx(
        1.0, abs=3e-3
    )  # observed 1.7e-3: two methods, and LIMIT
    assert there.galloping.vertical == pytest.approx(screened.threshold_amplitude, rel=1e-4)


def test_a_simulation_of_a_steady_cycle_gives_the_same_amplitudes(third, screened):
    """The short simulation for a beating swing, here of one that does not beat."""
    again = beating_cycle(third, 5.5, screened.saturated)
    assert again.vertical == pytest.approx(
        screened.saturated.vertical, rel=5e-3
    )  # observed -0.24 %
    assert again.horizontal == pytest.approx(
        screened.saturated.horizontal, rel=0.02
    )  # observed -1.2 %: six elements
    assert again.twist == pytest.approx(screened.saturated.twist, rel=5e-3)  # observed -0.30 %
    assert (again.frequency_hz, again.multiplier) == (
        screened.saturated.frequency_hz,
        screened.saturated.multiplier,
    )


def test_the_result_does_not_depend_on_higher_winds(third, screened):
    found = modal.screen(
        third.with_values({"wind.speed": 5.0}), highest_wind=screened.onset_wind_speed - 0.01
    )
    assert found.limit_cycle[-1].wind_speed > screened.onset_wind_speed
    assert (found.risk, found.onset_wind_speed) == ("detuned", None)


def test_the_swing_starts_where_the_multiplier_passes_one(screened):
    """The table of limit cycles and the onset agree."""
    for cycle in screened.limit_cycle:
        assert (cycle.multiplier > 1.0) == (cycle.wind_speed > screened.onset_wind_speed)
        assert (cycle.vertical > screened.threshold_amplitude) == (
            cycle.wind_speed > screened.onset_wind_speed
        )


def test_the_analytic_estimate_is_near(screened):
    estimate = screened.estimate
    assert estimate.swings
    assert estimate.onset_wind_speed == pytest.approx(
        screened.onset_wind_speed, rel=0.01
    )  # observed 0.3 %
    assert estimate.threshold_amplitude == pytest.approx(
        screened.threshold_amplitude, rel=0.1
    )  # observed 8 %
    assert estimate.vertical_amplitude == pytest.approx(
        screened.galloping.vertical, rel=0.1
    )  # observed 6.9 %
    second = modal.two_mode_estimate(gf.load_scene("example2"))
    assert second.vertical_amplitude == pytest.approx(1.548, rel=0.015)  # observed 1.561
    assert not second.swings


def test_weak_wind_is_no_risk(third):
    found = modal.screen(third.with_values({"wind.speed": 2.0}))
    assert found.risk == "none"
    assert "does not gallop up to 3 m/s" in found.reason
    assert (found.galloping, found.limit_cycle, found.saturated) == (None, (), None)


def test_galloping_that_leaves_the_curve_is_undetermined(third):
    narrow = {"aerodynamics.valid_from_deg": 165.0, "aerodynamics.valid_to_deg": 195.0}
    found = modal.screen(third.with_values(narrow))
    assert found.risk == "undetermined"
    assert "leave the coefficient curve, which is valid from 165 to 195 deg" in found.reason
    assert found.galloping is None


def test_spans_that_cannot_be_screened_are_refused(third):
    refused = {
        "without damping": (
            {"damping.translation": None},
            r"damping ratio of the first vertical mode is 8e-06.*no thresh",
        ),
        "without wind": ({"wind.speed": 0.0}, r"wind.speed = 0 m/s.*set wind.speed"),
        "without curve": ({"wind.speed": 0.0, "aerodynamics": None}, "aerodynamics is not given"),
        "turned out of the curve": (
            {"ice.attack_angle_deg": 250.0, "aerodynamics.moment": [3.0]},
            "turned out of the",
        ),
        "divergence below any galloping": (
            {"aerodynamics.moment": [0.0, 12.0], "aerodynamics.lift": [0.0]},
            r"statically unstable in a wind of 5.5 m/s \(divergence\)",
        ),
        "no pair": ({"ice.first_moment_x2": 0.0098}, "unstable"),
    }
    for values, message in refused.values():
        with pytest.raises(gf.SceneError, match=message):
            modal.screen(third.with_values(values))
    with pytest.raises(
        gf.SceneError, match=r"highest_wind = 5.0 m/s: must be at least the scene's wind, 5.5"
    ):
        modal.screen(third, highest_wind=5.0)
    with pytest.raises(gf.SceneError, match=r"wind_speed = 0.0 m/s: must be positive"):
        modal.two_mode_estimate(third, wind_speed=0.0)


def test_divergence_begins_where_the_wind_overcomes_the_twist(third):
    """A shaft of length L under the moment q d^2 CM' theta diverges at q d^2 CM' = GJ (pi/L)^2."""
    slope = 12.0
    calm = third.with_values(
        {
            "aerodynamics.moment": [0.0, slope],
            "ice.first_moment_x2": 0.0,
            "ice.first_moment_x3": 0.0,
        }
    )
    arc = gf.Model(calm).equilibrium().length
    pressure = 153.0 * (np.pi / arc) ** 2 / (0.0235**2 * slope)
    speed = float(np.sqrt(2.0 * pressure / 1.2929))
    below, above = (
        modal.screen(calm.with_values({"wind.speed": part * speed})) for part in (0.999, 1.001)
    )
    assert "divergence" not in below.reason
    assert "statically unstable in a wind of 4.718 m/s (divergence)" in above.reason
    # galloping begins below the divergence, whatever the scene's wind
    assert below.risk == above.risk == "undetermined"
    assert above.galloping_from == pytest.approx(below.galloping_from, rel=1e-3)
    assert above.onset_wind_speed == pytest.approx(below.onset_wind_speed, rel=1e-3)


def drawn(number, seed=SEED):
    """Random scene `number` of a seed, as benchmarks/accuracy/screening_table.py draws it."""
    draw = np.random.default_rng(seed)
    return [drawn_scene(draw) for _ in range(number)][-1]


@pytest.mark.parametrize(("seed", "number"), [(2009, 11), (20261122, 14)])
def test_drawn_scenes_settle_at_the_screened_amplitudes(seed, number):
    """The first swings; in the other the third vertical mode takes part: the cycle jumps twice."""
    scene = drawn(number, seed)
    found, motion = modal.screen(scene), simulated(scene, scene.wind.mean_speed, FULL_RUN)
    assert found.swings == motion.swings == (number == 11)
    cycle = found.saturated if found.swings else found.galloping
    assert cycle.vertical == pytest.approx(motion.vertical, rel=0.006)  # observed -0.1 % and -0.2 %
    assert cycle.horizontal == pytest.approx(
        motion.horizontal, rel=0.03
    )  # observed 1.5 % and -0.9 %


def test_galloping_that_has_ended_below_the_scenes_wind_is_no_cycle_of_zero_amplitude():
    """A scene of the blind draw: it gallops from 9.5 m/s, but no longer at its 19.6 m/s."""
    found = modal.screen(drawn(8, seed=20261122))
    assert (found.risk, found.galloping) == ("detuned", None)
    assert found.galloping_until == pytest.approx(18.185, abs=0.005)
    assert "ends at 18.19 m/s, below the scene's 19.63 m/s" in found.reason


def test_a_beating_swing_beats_in_the_nonlinear_model():
    """Simulated for 6000 s with ten elements from four seeds: beats up to 0.360 and 0.253 m.

    The screening follows the unstable motion about which they beat, and reports it.
    """
    found = modal.screen(drawn(20, seed=20261122))
    assert found.saturated.multiplier == pytest.approx(1.0027, abs=2e-4)
    assert "the motion beats, up to" in found.reason
    assert found.saturated.vertical == pytest.approx(0.360, rel=0.15)  # observed -13 %
    assert found.saturated.horizontal == pytest.approx(0.253, rel=0.28)  # observed -25 %


def test_the_swing_is_distinguished_from_instabilities_of_equal_growth():
    """At 5.8 m/s the multipliers of swing, third vertical mode and another meet at -2.1."""
    found = modal.screen(drawn(4))
    growth = np.array([cycle.multiplier for cycle in found.limit_cycle])
    assert found.until_wind_speed is None
    assert np.diff(growth[3:]).min() > 0.0  # the swing grows ever faster


def test_a_branch_that_ends_in_half_its_period_does_not_die_out():
    found = modal.screen(drawn(11, seed=20261122))
    assert "at 6.097 m/s the motion changes to a higher mode at twice the frequency" in found.reason
    assert found.galloping_until is None
    assert found.limit_cycle[-1].vertical > 0.1  # observed 0.41 m


DATA = Path(__file__).parent / "data"


def test_the_pair_that_is_not_at_risk_does_not_hide_two_loops_that_gallop():
    """A drawn span (Drake, 299 m, 12 mm of ice) whose first symmetric vertical mode is stable."""
    scene = gf.Scene.from_dict(json.loads((DATA / "two_loops_only.json").read_text()))
    found = modal.screen(scene)
    assert (found.risk, found.galloping_from) == ("other", None)
    assert "the 2:1 pair is not at risk" in found.reason
    assert "but two loops gallop from 2.91 m/s" in found.reason
    assert (found.other_mode.family, found.other_mode.loops) == ("vertical", 2)
    two_loops = modal.critical_wind_speed(scene, count=2, highest=3.0)[1]
    assert found.other_mode.wind_speed == pytest.approx(
        two_loops.wind_speed, rel=1e-3
    )  # observed 1e-4
    assert found.other_mode.frequency_hz == pytest.approx(two_loops.frequency_hz, rel=1e-3)
    calm = modal.screen(scene.with_values({"wind.speed": 1.9}))  # up to 2.85 m/s
    assert (calm.risk, calm.other_mode) == ("none", None)


def test_another_mode_is_reported_in_addition_to_a_swing(screened):
    assert screened.other_mode.wind_speed == pytest.approx(
        4.930, rel=1e-3
    )  # of critical_wind_speed(example3)
    assert screened.reason.endswith("; also, two loops gallop from 4.93 m/s")


def test_a_mode_that_passes_another_is_not_called_another_mode():
    """A slope with rotated ice: above 6 m/s the swing has more of the vertical shape."""
    scene = gf.Scene.from_dict(json.loads((DATA / "veering_in_wind.json").read_text()))
    others = [
        mode
        for mode in modal.critical_wind_speed(scene, count=4, highest=12.0)
        if mode.mode.loops != 1
    ]
    onset = min(mode.wind_speed for mode in others if mode.wind_speed is not None)
    rest = still_air_modes(scene)
    assert (
        first_other_mode(reduced_model(scene, rest), 11.5) is None
    )  # before: one loop from 6.18 m/s
    found = first_other_mode(reduced_model(scene, rest), 12.0)
    assert found.wind_speed == pytest.approx(onset, rel=2e-3)


@pytest.mark.parametrize("wind", [8.0, 10.0])
def test_a_limit_cycle_that_no_motion_stays_near_gives_no_onset(wind):
    """A fictitious curve over the full circle. From 4 to 10 m/s the section rotates over.

    Release 0.1.0 reported onsets of 6.1 to 9.9 m/s, depending on the scene's wind, from a branch
    with a growth of 1000 in a cycle.
    """
    found = modal.screen(
        gf.load_scene(DATA / "full_circle_350m.toml").with_values({"wind.speed": wind})
    )
    assert found.risk == "undetermined"
    assert (found.onset_wind_speed, found.galloping) == (None, None)
    assert found.galloping_from == pytest.approx(1.8648, abs=2e-4)  # at each of 6, 8, 10 m/s
    assert "the limit cycle is unresolved above 2.4" in found.reason
    assert ": a disturbance other than the swing grows by" in found.reason
    assert f"run a simulation at the scene's {wind:g} m/s" in found.reason
    assert max(cycle.wind_speed for cycle in found.limit_cycle) < 2.5


def test_a_branch_on_which_newtons_iteration_fails_is_unresolved():
    """A steep span on which it fails between two orbits, at the onset of the swing."""
    line = {
        "conductor": "Drake",
        "span": 399.0,
        "height_difference": 199.5,
        "stringing_percent": 20.0,
        "ice_thickness": 0.012,
        "attack_angle_deg": 180.0,
        "wind_speed": 4.0,
        "coefficients": "example3",
    }
    scene = gf.Scene.from_dict({"line": line}).with_values({"numerics.elements": 8})
    found = modal.screen(scene)
    assert (found.risk, found.onset_wind_speed, found.saturated) == ("undetermined", None, None)
    assert "the limit cycle is unresolved" in found.reason
    assert found.galloping_from == pytest.approx(
        modal.critical_wind_speed(scene, 4, 2.0)[1].wind_speed, rel=0.05
    )
