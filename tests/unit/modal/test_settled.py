"""Ends of the simulations of a screening."""

from types import SimpleNamespace

import numpy as np
import pytest

from modal.motions.full_model import Band, FullRun
from modal.screening import settled

UNKNOWN = Band(np.nan, np.nan, np.nan, np.nan)


@pytest.mark.parametrize("periods", [0, 10 * settled.PERIODS])
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
