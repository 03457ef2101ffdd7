"""All branches from one equilibrium: each is found once, and every end is explained."""

import numpy as np

from modal.continuation.diagram import explore
from modal.continuation.path import Settings
from support import ode_systems as ode
from support.ode_systems import system


def kinds(diagram):
    return [(one.kind, one.ends[0].kind, one.ends[1].kind) for one in diagram.branches]


def test_two_to_one_resonance_has_three_branches():
    problem = system(
        ode.two_to_one, [0.5] * 4, symmetry=np.diag([1.0, -1.0, 1.0, -1.0]), is_second_order=True
    )
    found = explore(problem, np.zeros(4), -0.05, Settings(-0.1, 0.4))
    assert kinds(found) == [
        ("equilibrium", "range", "range"),
        ("orbit", "Hopf", "range"),
        ("orbit", "period doubling", "range"),
    ]
    assert found.is_complete


def test_a_branch_between_two_events_is_followed_once():
    """r' = r ((1 - p^2) - r^2), and the swing at half the frequency between p = -0.8 and 0.8."""

    def function(y, p):
        v, dv, s, ds = y
        gain = 1.0 - p * p
        return [
            dv,
            gain * dv - 4.0 * v - dv * (v * v + dv * dv / 4.0),
            ds,
            -0.2 * ds - s - 0.5 * v * s - s * s * ds,
        ]

    problem = system(function, [1.0] * 4, symmetry=np.diag([1.0, 1.0, -1.0, -1.0]))
    found = explore(problem, np.zeros(4), -1.5, Settings(-2.0, 2.0))
    assert kinds(found) == [
        ("equilibrium", "range", "range"),
        ("orbit", "Hopf", "rest"),
        ("orbit", "period doubling", "period halving"),
    ]
    assert found.is_complete
    twice = found.branches[2]
    assert abs(twice.ends[0].parameter + twice.ends[1].parameter) < 1e-6  # p and -p are alike


def test_limits_leave_events_unexplored():
    problem = system(ode.lorenz, [10.0] * 3, symmetry=np.diag([-1.0, -1.0, 1.0]))
    settings = Settings(0.0, 30.0, max_period=5.0)
    found = explore(problem, np.zeros(3), 0.5, settings, depth=1)
    assert kinds(found) == [
        ("equilibrium", "range", "range"),
        ("equilibrium", "symmetry breaking", "range"),
    ]
    assert [event.kind for event in found.unexplored] == ["Hopf"]
    assert not found.is_complete
