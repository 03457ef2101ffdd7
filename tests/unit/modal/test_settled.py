"""Ends of the simulations of a screening."""

from types import SimpleNamespace

import numpy as np
import pytest

from modal.motions.full_model import Band, FullRun
from modal.screening import settled

UNKNOWN = Band(np.nan, np.nan, np.nan, np.nan)


@pytest.mark.parametrize("periods", [0, 10 * settled.PERIODS[0]])
def test_a_simulation_that_ended_early_is_no_state(periods, monkeypatch):
    """However many records it has: a cable may go slack late."""
    end = FullRun(UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, "the cable went slack")
    monkeypatch.setattr(settled, "full_scene", lambda *_: None)
    monkeypatch.setattr(settled, "_disturbance", lambda _: 0.0)
    values = np.zeros((periods, 3, 3))
    monkeypatch.setattr(settled, "runs_from", lambda *_: iter([(end, values, 0.1)]))
    diagram = SimpleNamespace(model=SimpleNamespace(elements=8), scene=None, wind=5.0)
    state, doubt = settled.simulated_state(diagram, np.zeros(4))
    assert state is None
    assert doubt == "a simulation at 5 m/s ended early: the cable went slack"


STEADY = np.full(settled.WINDOWS, 0.4)
TIME = np.linspace(0.0, 1.0, settled.WINDOWS)


def end_of(vertical, quarter, irregular):
    """Kind of a motion with these amplitudes (window,) at mid-span and the quarter points."""
    count = 50  # records in a window, of 5 periods
    wave = np.tile(np.sin(2.0 * np.pi * np.arange(count) / 10.0), len(vertical))
    values = np.zeros((len(wave), 3, 3))
    tall, wide = np.repeat(vertical, count) * wave, np.repeat(quarter, count) * wave
    values[:, 0] = np.stack([tall + wide, tall, tall - wide], axis=1)
    return settled._end_of(values, 0.1, irregular).kind


@pytest.mark.parametrize("irregular", [False, True])
@pytest.mark.parametrize(
    ("quarter", "kind"),
    [
        (0.02 * STEADY, "periodic"),
        (0.019 * np.exp(0.25 * TIME), "not settled"),  # grows by 13 % between both halves
        (0.05 * np.exp(0.02 * TIME), "not settled"),
        (0.05 - 0.003 * np.exp(-6.0 * TIME), "periodic"),  # ends to grow
        (0.3 - 0.2 * np.exp(-3.0 * TIME), "not settled"),
        (0.1 + 0.1 * np.exp(-8.0 * TIME), "not settled"),  # a decay that varies early alone
        (np.where(TIME < 0.5, 0.1, 0.2), "not settled"),
    ],
)
def test_a_slow_change_is_not_settled(quarter, kind, irregular):
    assert end_of(STEADY, quarter, irregular) == kind


def test_an_irregular_motion_is_a_state_after_a_long_time():
    """Windows that differ at random: one motion in 40 seems to have a trend."""
    draw = np.random.default_rng(20261129)
    sizes = np.repeat(0.4 * draw.uniform(0.3, 1.0, (40, 12)), 5, axis=1)
    late = [end_of(one, STEADY, irregular=True) for one in sizes]
    early = [end_of(one, STEADY, irregular=False) for one in sizes]
    assert late.count("beating") >= 37
    assert early.count("not settled") >= 10


def test_an_irregular_motion_that_grows_is_not_settled():
    draw = np.random.default_rng(7)
    for _ in range(20):
        sizes = (0.2 + 0.4 * TIME) * draw.uniform(0.6, 1.0, len(TIME))
        assert end_of(sizes, STEADY, irregular=True) == "not settled"


def test_a_change_that_is_undone_is_no_trend():
    sizes = 0.3 + 0.2 * np.exp(-(((TIME - 0.6) / 0.15) ** 2))
    assert end_of(sizes, STEADY, irregular=True) == "beating"
