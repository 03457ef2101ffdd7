"""Axial modes of a fine mesh, which no step resolves, do not break Newton's iteration."""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.input.scene_files import load_scene

NOTHING = np.zeros(0, np.int32)


def report_of(values, seconds):
    model = Model(load_scene("example3").with_values(values))
    return (
        model.start().run(1, round(seconds / values["numerics.time_step"]), NOTHING, NOTHING).report
    )


def test_steps_are_not_halved_again_and_again():
    """Large motion from the start, by Gauss's method; Newmark's needs five sub-steps of 4 ms."""
    values = {
        "numerics.integrator": "gauss6",
        "numerics.time_step": 0.025,
        "numerics.elements": 100,
    }
    report = report_of(values | {"initial.seed_vertical": 0.3, "initial.seed_horizontal": 0.1}, 4.0)
    assert report.substeps < 1.1 * report.steps  # observed 1.013


def test_generalised_alpha_does_not_halve_where_axial_modes_ring():
    """The same start, at which Newmark's method takes four sub-steps a step."""
    values = {"numerics.time_step": 0.02, "numerics.elements": 100, "initial.seed_vertical": 0.3}
    values |= {"initial.seed_horizontal": 0.1, "numerics.integrator": "generalised_alpha"}
    report = report_of(values, 4.0)
    assert report.substeps < 1.2 * report.steps  # observed 1.04; Newmark 4.0


@pytest.mark.parametrize("elements", [100, 1000])
def test_newmark_step_of_growing_galloping_costs_the_same_on_a_fine_mesh(elements):
    """Linear extrapolation of alternating accelerations would halve all steps of 1000 elements."""
    report = report_of({"numerics.time_step": 0.02, "numerics.elements": elements}, 2.0)
    assert report.substeps < 1.1 * report.steps  # observed 1.00 and 1.01; 2 by a straight line
    assert report.iterations < 4.0 * report.substeps  # observed 3.6 and 3.3
