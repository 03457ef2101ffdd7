"""Shared readings of a galloping run."""

import numpy as np
import pytest


@pytest.fixture
def amplitudes():
    """Half peak-to-peak of u2 [m], u3 [m] and theta [rad] over the last 100 s."""

    def read(result):
        steady = result.steady(100.0)
        return np.array([steady[name].amplitude for name in ("u2", "u3", "theta")])

    return read
