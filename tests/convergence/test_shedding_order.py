"""A fall of ice at a time off the grid of the steps does not change the order of an integrator."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.integrators import INTEGRATORS

UNTIL, FALL = 0.8, 0.3037
STEPS = {"newmark": (4e-3, 2e-3), "generalised_alpha": (4e-3, 2e-3), "gauss6": (10e-3, 5e-3)}


def displacement(integrator, step):
    """Of all nodes of a soft span, whose axial modes the steps resolve, after half its ice fell."""
    scene = gf.LineScene.from_dict(
        {
            "title": "order",
            "section": {"horizontal_tension": 25e3, "spans": [{"length": 160.0}]},
            "conductor": {
                "diameter": 0.028,
                "mass_per_length": 1.628,
                "axial_stiffness": 1e6,
                "torsional_stiffness": 159.0,
                "torsional_inertia": 2e-4,
            },
            "ice": {"mass_per_length": 1.2},
            "shedding": [{"span": 1, "to_station": 0.5, "time": FALL}],
            "numerics": {
                "elements": 4,
                "integrator": integrator,
                "time_step": step,
                "newton_tolerance": 1e-13,
            },
        }
    )
    state = Model(scene, inputs=False).start()
    state.advance(UNTIL)
    return state.motion()[0]


@pytest.mark.parametrize("integrator", INTEGRATORS.values(), ids=INTEGRATORS)
def test_order_with_a_fall_within_a_step(integrator):
    reference = displacement("gauss6", 1e-3)
    errors = [
        np.abs(displacement(integrator.name, step) - reference).max()
        for step in STEPS[integrator.name]
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(
        integrator.order, abs=0.1
    )  # observed 1.995, 5.93
