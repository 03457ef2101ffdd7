"""Continuation of equilibria: events in closed form, branch switching, jumps."""

import numpy as np
import pytest

from modal.continuation import branch
from modal.continuation.events import UserEvent
from modal.continuation.path import Settings, Stepper
from modal.continuation.problem import ContinuationError
from modal.continuation.starts import equilibria, switched
from support.ode_systems import brusselator, langford, lorenz, system

MIRROR = np.diag([-1.0, -1.0, 1.0])


def test_lorenz_breaks_symmetry_at_1_and_has_its_hopf_point_where_known():
    problem, settings = system(lorenz, [10.0] * 3, symmetry=MIRROR), Settings(0.0, 30.0)
    rest = equilibria(problem, np.zeros(3), 0.5, settings)
    assert [event.kind for event in rest.events] == ["symmetry breaking"]
    assert rest.events[0].parameter == pytest.approx(1.0, rel=1e-8)
    assert [end.kind for end in rest.ends] == ["range", "range"]
    (side,) = switched(rest.events[0], settings)
    assert [event.kind for event in side.events] == ["Hopf"]
    hopf = side.events[0]
    # r = sigma (sigma + b + 3) / (sigma - b - 1), omega^2 = b (r + sigma)  (Lorenz 1963)
    assert hopf.parameter == pytest.approx(470.0 / 19.0, rel=1e-7)
    assert hopf.value.imag == pytest.approx(np.sqrt(8 / 3 * (470 / 19 + 10)), rel=1e-7)
    for point in side.points:  # x = y = sqrt(b (r - 1)), z = r - 1
        x, y, z = point.states[0]
        assert z == pytest.approx(point.parameter - 1.0, abs=1e-7)
        assert x == pytest.approx(y, abs=1e-7)


def test_folds_and_hopf_points_in_closed_form():
    found = equilibria(system(langford, [1.0] * 3), np.zeros(3), 0.0, Settings(-1.0, 2.0))
    fold = 2.0 / 3.0 * 0.95**1.5  # extremes of z^3/3 - 0.95 z
    expected = [("fold", -fold), ("Hopf", 0.7**3 / 3.0 - 0.95 * 0.7), ("fold", fold)]
    assert [event.kind for event in found.events] == [kind for kind, _ in expected]
    for event, (_, value) in zip(found.events, expected, strict=True):
        assert event.parameter == pytest.approx(value, rel=1e-7)
    stable = [point.is_stable for point in found.points]
    assert stable[0] != stable[-1]  # z > beta is unstable


def test_brusselator_hopf_point_and_the_growth_beside_it():
    found = equilibria(system(brusselator, [1.0] * 2), np.ones(2), 1.0, Settings(0.5, 4.0))
    (hopf,) = found.events
    assert hopf.parameter == pytest.approx(2.0, rel=1e-9)  # B = 1 + A^2, omega = A
    assert abs(hopf.value) == pytest.approx(1.0, rel=1e-9)
    for point in found.points:  # trace of the Jacobian: B - 2
        assert np.sum(point.spectrum).real == pytest.approx(point.parameter - 2.0, abs=1e-7)


def test_transcritical_branches_are_both_found():
    problem = system(lambda y, p: [y[0] * (p - y[0] - p * p)], [1.0])
    settings = Settings(-1.0, 0.9)
    rest = equilibria(problem, np.zeros(1), -0.5, settings)
    (crossing,) = rest.events
    assert (crossing.kind, crossing.parameter) == ("branch point", pytest.approx(0.0, abs=1e-7))
    both = switched(crossing, settings)
    assert len(both) == 2
    for side in both:
        for point in side.points:
            assert point.states[0, 0] == pytest.approx(
                point.parameter - point.parameter**2, abs=1e-7
            )
    assert {np.sign(side.points[-1].parameter) for side in both} == {-1.0, 1.0}


def test_a_users_event_ends_the_branch_where_its_function_is_zero():
    limit = UserEvent("leaves the curve", lambda states, p: 1.5 - float(states[:, 0].max()))
    problem = system(lambda y, p: [p - y[0] ** 3], [1.0])
    found = equilibria(problem, np.ones(1), 1.0, Settings(-5.0, 5.0), [limit])
    assert [end.kind for end in found.ends] == ["range", "leaves the curve"]
    assert found.ends[1].parameter == pytest.approx(1.5**3, rel=1e-8)


def test_a_closed_branch_is_recognised():
    problem = system(lambda y, p: [1.0 - y[0] ** 2 - p * p], [1.0])
    found = equilibria(problem, np.ones(1), 0.0, Settings(-2.0, 2.0))
    assert found.ends[1].kind == "closed"
    assert sorted(event.parameter for event in found.of_kind("fold")) == pytest.approx([-1.0, 1.0])


def sheets(height, distances):
    """Equilibria y = height(p) + each of the distances, and the same as a system."""

    def function(y, p):
        value = -1.0
        for distance in distances:
            value = value * (y[0] - height(p) - distance)
        return [value * 100.0]

    return system(function, [1.0])


@pytest.mark.parametrize("distances", [(0.0, 0.03), (-0.03, 0.0, 0.03)], ids=["two", "three"])
def test_no_step_jumps_to_a_close_branch(distances, monkeypatch):
    """Of 90 such pairs and triples (widths, distances, steps), 31 jump without the checks."""

    def height(p):
        return np.tanh(p / 0.1)

    settings = Settings(-2.0, 2.0, first_step=0.3, max_step=0.3)
    problem = sheets(height, distances)

    def followed():
        found = equilibria(problem, np.array([-1.0 + distances[-1]]), -1.5, settings)
        away = [point.states[0, 0] - height(point.parameter) for point in found.points]
        return np.abs(np.array(away) - distances[-1]), found

    away, found = followed()
    assert np.max(away) < 1e-6
    assert found.points[-1].parameter == pytest.approx(2.0)
    # Without the checks, the same steps do jump.
    monkeypatch.setattr(Stepper, "_check", lambda *_: None)
    monkeypatch.setattr(branch, "events_between", lambda *_: [])
    away, _ = followed()
    assert np.max(away) > 0.029


def test_a_branch_that_cannot_be_followed_ends_as_lost_with_the_reason():
    """Two branches with a kink of 90 degrees at p = 0: no smooth branch goes on."""

    def function(y, p):
        return [np.where(p.real < 0.0, 1.0, -10.0) * p - y[0]]

    found = equilibria(
        system(function, [1.0]), np.array([-1.0]), -1.0, Settings(-2.0, 2.0, min_step=1e-4)
    )
    lost = found.ends[1]
    assert (lost.kind, found.is_complete) == ("lost", False)
    assert lost.reason
    assert lost.parameter == pytest.approx(0.0, abs=1e-3)
    assert all(point.parameter < 0.0 for point in found.points)


def test_a_guess_without_an_equilibrium_is_refused():
    problem = system(lambda y, p: [1.0 + y[0] ** 2 + p * p], [1.0])
    with pytest.raises(ContinuationError, match="no equilibrium at a parameter near"):
        equilibria(problem, np.zeros(1), 0.5, Settings(0.0, 1.0))
