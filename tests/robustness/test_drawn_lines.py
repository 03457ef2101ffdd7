"""Lines drawn by a seed end with a named outcome, finite records, and their energy.

`benchmarks/stress/lines.py` runs thousands of them.
"""

import numpy as np
import pytest

from support.drawn_lines import drawn, run

OUTCOMES = ("COMPLETED", "refused", "SLACK", "EQUILIBRIUM_NOT_FOUND", "ANGLE_OUT_OF_RANGE")
SECONDS = 1.0


@pytest.mark.parametrize("number", range(32))
def test_a_drawn_line(number):
    data = drawn(np.random.default_rng([20261128, number]))
    outcome, message, drift = run(data, SECONDS)
    assert outcome in OUTCOMES, message
    assert message
    if np.isfinite(drift):
        assert abs(drift) < 1e-3, data["numerics"]["integrator"]
