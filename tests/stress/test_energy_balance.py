"""Work of wind, loads and towers against dissipation and change of stored energy, and what the report says of runs of
many halved steps."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.energy import MOTION_CHANNELS, energy_balance
from gallop_fmu.outcome import Outcome, Report

SWAY = {"kind": "pulse", "rise": 2.0, "fall_start": 3.0, "fall": 2.0, "peak": 0.02}
CALM = {"initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0, "numerics.newton_tolerance": 1e-12}
RISING = {"wind.speed": None, "wind.history": {"kind": "ramp", "initial": 0.0, "final": 6.0, "duration": 3.0}}
SWAYING = {"wind.speed": 0.0, "supports.left.motion": {"x1": SWAY, "x2": SWAY, "x3": SWAY}}
CASES = {
    "wind on springs": ("example2", RISING, "wind"),
    "wind between rigid ends": ("example3", RISING, "wind"),
    "loads": ("example1", {}, "loads"),
    "moving tower, springs": ("example2", SWAYING, "supports"),
    "moving tower, rigid": ("example3", SWAYING, "supports"),
}


def balanced(name, values, step):
    scene = gf.load_scene(name).with_values({**CALM, **values, "numerics.time_step": step})
    run = gf.simulate(scene, stop_time=5.0, record_nodes="all", record_every=1, channels=MOTION_CHANNELS)
    return energy_balance(run)


@pytest.mark.parametrize("case", CASES)
def test_the_balance_closes_with_the_square_of_the_step(case):
    name, values, work = CASES[case]
    coarse, fine = balanced(name, values, 0.02), balanced(name, values, 0.01)
    assert np.abs(getattr(fine, work)).max() > 0.3
    assert fine.worst < 5e-6  # observed 3e-8 to 1.5e-6
    assert coarse.worst / fine.worst == pytest.approx(4.0, rel=0.05)  # observed 3.99 to 4.09


def test_each_part_counts():
    """Leaving one of the parts out opens the balance by far more than the bound."""
    balance = balanced("example3", RISING, 0.01)
    for part in (balance.wind, balance.dissipated):
        assert np.abs(part).max() > 1e3 * np.abs(balance.imbalance).max()


def test_a_motion_that_was_not_recorded_has_no_balance():
    result = gf.simulate(gf.load_scene("example3"), stop_time=0.1)
    with pytest.raises(gf.SceneError, match="record_nodes"):
        energy_balance(result)


def test_rest_is_balanced():
    scene = gf.load_scene("example3").with_values({**CALM, "wind.speed": 0.0})
    run = gf.simulate(scene, stop_time=0.1, record_nodes="all", record_every=1, channels=MOTION_CHANNELS)
    assert energy_balance(run).worst < 1e-6  # observed 3e-8


def test_memory_order_of_a_motion_does_not_matter():
    """Transposed views were once read as if they lay in C order, silently."""
    scene = gf.load_scene("example3").with_values({"numerics.elements": 4})
    model = gf.Model(scene)
    u = 1e-3 * np.random.default_rng(1).standard_normal((model.nodes, 4))
    found = model.residual(np.asfortranarray(u), np.asfortranarray(u), np.asfortranarray(u))
    assert np.array_equal(found, model.residual(u, u, u))
    tangent = model.tangent(np.asfortranarray(u), stiffness=1.0)
    assert np.array_equal(tangent, model.tangent(u, stiffness=1.0))


def test_a_run_of_halved_steps_says_that_it_is_doubtful():
    """Let go out of equilibrium, with steps of several axial periods: it ends, and its energy is wrong."""
    rough = {"initial.seed_vertical": 0.3, "initial.seed_horizontal": 0.1, "initial.seed_twist": 0.2}
    scene = gf.load_scene("example3").with_values({**rough, "numerics.time_step": 0.2, "aerodynamics.outside": "hold"})
    result = gf.simulate(scene, stop_time=20.0, record_nodes="all", record_every=1, channels=MOTION_CHANNELS)
    assert result.outcome is Outcome.COMPLETED
    assert energy_balance(result).worst > 0.05  # observed 0.072; 3e-5 with steps of 10 ms
    assert result.report.doubtful
    assert "reduce numerics.time_step" in str(result.report)
    assert "halved" in result.dataset.attrs["message"]


@pytest.mark.parametrize(("steps", "halvings", "doubtful"), [(1000, 0, False), (1000, 10, False), (1000, 11, True)])
def test_a_jump_or_two_is_no_reason_for_doubt(steps, halvings, doubtful):
    assert Report(Outcome.COMPLETED, 1.0, steps=steps, halvings=halvings).doubtful is doubtful
