"""Axial modes of a fine mesh, which no step resolves, do not break Newton's iteration."""

import numpy as np

from gallop_fmu.engine import Model
from gallop_fmu.scene import load_scene

NOTHING = np.zeros(0, np.int32)


def test_steps_are_not_halved_again_and_again():
    """Metres of motion from the start, by Gauss's method; Newmark's takes five sub-steps of 4 ms for one here."""
    model = Model(load_scene("example3").with_values({
        "numerics.integrator": "gauss6", "numerics.time_step": 0.025, "numerics.elements": 100,
        "initial.seed_vertical": 0.3, "initial.seed_horizontal": 0.1,
    }))  # fmt: skip
    report = model.start().run(1, 160, NOTHING, NOTHING).report
    assert report.substeps < 1.1 * report.steps  # observed 1.013
