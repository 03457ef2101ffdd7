"""Branches of lines of example 2 against a lumped explicit chain written apart from this project,
and against simulations."""

import numpy as np
import pytest

from modal.continuation.path import Settings
from modal.continuation.starts import equilibria, switched
from modal.motions.line_model import LineModel
from modal.motions.motion_words import name_of_branch, name_of_disturbance
from modal.motions.span_problem import SpanProblem, WindFamily
from support.galloping_lines import section_of_example2

ONE_LOOP_HZ = 0.5556
"""Frequency at which the spans gallop in one loop, all in phase."""


def one_loop(scene, highest):
    """Model and branch of the galloping in one loop."""
    model = LineModel(scene)
    problem = SpanProblem(WindFamily(model), model, highest)
    settings = Settings(
        0.3,
        highest,
        tolerance=1e-4,
        first_step=0.05,
        max_step=0.4,
        max_points=60,
        max_unstable=2,
        max_unstable_at_rest=8,
    )
    rest = equilibria(problem, np.zeros(problem.size), 0.301, settings.at_rest)
    hertz = [abs(event.value.imag) / (2.0 * np.pi) for event in rest.of_kind("Hopf")]
    onset = rest.of_kind("Hopf")[int(np.argmin(np.abs(np.array(hertz) - ONE_LOOP_HZ)))]
    (branch,) = switched(onset, settings)
    return model, branch


def test_a_twin_bundle_gallops_as_a_chain_of_another_code():
    """1.471 / 0.0974 m, twist 0.112 rad at 0.560 Hz; 40 and 80 elements agree within 0.2 %."""
    scene = section_of_example2(
        1,
        bundle={
            "subconductors": 2,
            "spacing": 0.4,
            "spacers": 4,
            "clamp_torsional_stiffness": 500.0,
        },
    )
    model, branch = one_loop(scene, 4.1)
    end = branch.points[-1]
    moves = model.watched_at(end.at(np.arange(128) / 128)[:, : model.size])
    u2, u3, twist = (0.5 * np.ptp(one) for one in (moves.u2, moves.u3, moves.theta))
    assert end.parameter == pytest.approx(4.1)
    assert end.is_stable
    assert name_of_branch(branch, model) == "one loop"
    assert u2 == pytest.approx(1.471, rel=0.003)  # observed 1.4695
    assert u3 == pytest.approx(0.0974, rel=0.006)  # observed 0.0971
    assert twist == pytest.approx(0.112, rel=0.04)  # observed 0.1091
    assert 1.0 / end.period == pytest.approx(0.560, rel=0.02)  # observed 0.5506


def test_galloping_spans_make_the_strings_of_a_section_swing():
    """Another code: 1.44 m in 4.1 m/s, and then clamps swing at about half the frequency.

    Simulations that start on the motion with a small sideways disturbance return to it below
    3.40 m/s and leave it above (benchmarks/accuracy/branches_lines.py). The swing begins with two
    frequencies whose sum is that of the galloping; in simulations, they later become one.
    """
    model, branch = one_loop(section_of_example2(3), 4.1)
    swing = branch.of_kind("torus")[-1]
    assert swing.parameter == pytest.approx(3.40, rel=0.003)  # observed 3.399
    assert name_of_disturbance(swing, model) == "string swing"
    assert swing.rotation == pytest.approx(0.5, abs=0.04)  # observed 0.467
    end = branch.points[-1]
    u2 = model.watched_at(end.at(np.arange(128) / 128)[:, : model.size]).u2
    assert 0.5 * np.ptp(u2, axis=0) == pytest.approx([1.44] * 3, rel=0.02)  # observed
    assert not end.is_stable
    assert all(point.is_stable for point in branch.points if 0.5 < point.parameter < 3.3)
