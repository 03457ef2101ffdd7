"""Continuation of periodic orbits: known orbits, stability, events and switching.

Events that are not known in closed form are checked by integration with DOP853: the orbit closes,
and its monodromy matrix has the critical multiplier.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from modal.continuation.events import UserEvent
from modal.continuation.finer_mesh import mesh_doubt
from modal.continuation.path import GrowingLimit, Settings, spectrum_change
from modal.continuation.problem import ContinuationError
from modal.continuation.starts import equilibria, orbit, orbits, switched
from support import ode_systems as ode
from support.ode_systems import LANGFORD, PRISM, integrate, monodromy, system


def simulated_cycle(problem, state, parameter, start, period, instants=100):
    """States of a cycle at equally spaced instants, from a simulation."""
    run = integrate(problem, state, parameter, start + period, dense_output=True)
    return run.sol(start + period * np.arange(instants) / instants).T


def is_confirmed(point, multiplier=None, tolerance=1e-5):
    """Check by integration that an orbit closes and has a multiplier."""
    end, matrix = monodromy(point)
    scale = point.equations.problem.scale
    assert np.max(np.abs(end - point.states[0]) / scale) < tolerance
    values = np.linalg.eigvals(matrix)
    expected = point.spectrum if multiplier is None else [multiplier]
    for value in expected:
        assert np.min(np.abs(values - value)) < tolerance * (1.0 + abs(value))
    return True


def test_van_der_pol_period_and_relaxation():
    problem = system(ode.van_der_pol, [2.0, 2.0], is_second_order=True)
    settings = Settings(0.1, 5.0, tolerance=1e-6)
    first = orbit(
        problem, simulated_cycle(problem, [2.0, 0.0], 1.0, 40.0, 6.663), 6.663, 1.0, settings
    )
    assert first.period == pytest.approx(6.6632868593, rel=1e-8)  # Andersen and Geer (1982)
    found = orbits(problem, first.states, first.period, 1.0, settings)
    assert found.points[-1].period == pytest.approx(11.6122306674, rel=1e-7)  # mu = 5
    assert found.points[-1].amplitude[0] == pytest.approx(2.0215, rel=1e-4)
    assert not found.events
    assert is_confirmed(found.points[0])


def test_roessler_orbit_of_the_chaos_book_and_its_doublings():
    problem = system(ode.roessler, [5.0] * 3)
    settings = Settings(2.0, 5.7, tolerance=1e-7)
    cycle = simulated_cycle(problem, [1.0, 1.0, 0.0], 2.5, 300.0, 5.76)
    found = orbits(problem, cycle, 5.76, 2.5, settings)
    last = found.points[-1]
    # Cvitanovic et al., chaosbook.org, Roessler system, a = b = 0.2, c = 5.7, cycle "1"
    assert last.period == pytest.approx(5.88108845586, rel=1e-9)
    assert last.spectrum[0] == pytest.approx(-2.403953527, rel=1e-7)
    (doubling,) = found.events
    assert doubling.kind == "period doubling"
    assert doubling.parameter == pytest.approx(2.8324, abs=1e-4)
    assert is_confirmed(doubling.point, -1.0)
    (twice,) = switched(doubling, settings)
    assert twice.points[0].period == pytest.approx(2.0 * doubling.point.period, rel=1e-4)
    (again,) = twice.of_kind("period doubling")[1:]
    assert is_confirmed(again.point, -1.0)
    last = twice.points[-1]
    assert last.period == pytest.approx(11.7586260717, rel=1e-9)  # cycle "01"
    assert last.spectrum[0] == pytest.approx(-3.512006980, rel=1e-7)


def test_lorenz_orbits_end_at_the_homoclinic_orbit():
    problem = system(ode.lorenz, [10.0] * 3)
    settings = Settings(0.0, 30.0, max_period=10.0)
    side = equilibria(problem, np.array([8.0, 8.0, 23.0]), 24.0, settings)
    (hopf,) = side.of_kind("Hopf")
    (found,) = switched(hopf, settings)
    assert found.ends[1].kind == "period"
    assert found.ends[1].parameter == pytest.approx(13.926557, rel=1e-6)  # Sparrow (1982)
    assert "homoclinic" in found.ends[1].reason
    assert all(point.unstable == 1 for point in found.points)  # subcritical


def test_langford_torus_in_closed_form():
    """On the orbit, r' = (z - beta) r, so z = beta, and the rest is a plane system."""
    a, b, w, rho = LANGFORD.values()
    problem, settings = system(ode.langford, [1.0] * 3), Settings(-1.0, 2.0)
    rest = equilibria(problem, np.zeros(3), 0.0, settings)
    (found,) = switched(rest.of_kind("Hopf")[0], settings)
    (torus,) = found.events
    square = (a - b * b) / rho  # the trace a - b^2 - rho r^2 is zero
    assert torus.kind == "torus"
    expected = square * (1.0 + rho * b) - a * b + b**3 / 3.0
    assert torus.parameter == pytest.approx(expected, rel=1e-6)
    turns = np.sqrt(2.0 * square * (1.0 + rho * b)) / w
    assert torus.rotation == pytest.approx(1.0 - turns, rel=1e-5)
    for point in found.points:
        radius = np.sqrt((point.parameter + a * b - b**3 / 3.0) / (1.0 + rho * b))
        assert point.amplitude[0] == pytest.approx(radius, rel=1e-5)
        assert point.period == pytest.approx(2.0 * np.pi / w, rel=1e-7)
        trace, determinant = a - b * b - rho * radius**2, 2.0 * radius**2 * (1.0 + rho * b)
        rates = np.roots([1.0, -trace, determinant])
        expected = np.exp(rates.astype(complex) * point.period)
        assert spectrum_change(point.spectrum, expected) < 1e-6


def test_prism_of_parkinson_and_smith_has_three_cycles_and_two_folds():
    """Averaging is exact to the order n^2: amplitude a with s = (a / U)^2 and, with the onset U0,

    1 - U0 / U = 3/4 (B/A) s - 5/8 (C/A) s^2 + 35/64 (D/A) s^3.
    """
    A, B, C, D, n, beta = PRISM.values()
    onset = 2.0 * beta / (n * A)
    loss = np.polynomial.Polynomial([0.0, 0.75 * B / A, -0.625 * C / A, 35.0 / 64.0 * D / A])
    problem = system(ode.prism, [0.2, 0.2], is_second_order=True)
    settings = Settings(0.5 * onset, 3.0 * onset)
    rest = equilibria(problem, np.zeros(2), 0.9 * onset, settings)
    (hopf,) = rest.events
    assert hopf.parameter == pytest.approx(onset, rel=1e-9)
    (found,) = switched(hopf, settings)
    assert [event.kind for event in found.events] == ["fold", "fold"]
    for event, s in zip(found.events, np.sort(loss.deriv().roots().real), strict=True):
        assert event.parameter == pytest.approx(onset / (1.0 - loss(s)), rel=1e-6)
    for point in found.points:
        s = (point.amplitude[0] / point.parameter) ** 2
        assert point.parameter == pytest.approx(onset / (1.0 - loss(s)), rel=1e-3)
    high, low = (event.parameter for event in found.events)
    cycles = found.at(0.5 * (low + high))  # hysteresis: small, unstable, large
    assert [point.is_stable for point in cycles] == [True, False, True]
    assert [len(found.at(wind)) for wind in (0.99 * low, 1.01 * high)] == [1, 1]


def test_orbits_that_shrink_to_rest_end_at_the_other_hopf_point():
    """r' = r ((1 - p^2) - r^2): orbits between p = -1 and 1."""

    def function(y, p):
        shrink = 1.0 - p * p - y[0] ** 2 - y[1] ** 2
        return [shrink * y[0] - 2.0 * y[1], 2.0 * y[0] + shrink * y[1]]

    problem, settings = system(function, [1.0, 1.0]), Settings(-2.0, 2.0)
    rest = equilibria(problem, np.zeros(2), -1.5, settings)
    assert [event.parameter for event in rest.events] == pytest.approx([-1.0, 1.0], rel=1e-7)
    (found,) = switched(rest.events[0], settings)
    assert (found.ends[1].kind, found.is_complete) == ("rest", True)
    assert found.ends[1].parameter == pytest.approx(1.0, rel=1e-7)
    assert max(point.amplitude[0] for point in found.points) == pytest.approx(1.0, rel=1e-3)


def duffing_fold(near):
    """Frequency at which q'' + 0.1 q' + q + q^3 = 0.5 cos wt has a fold.

    Harmonic balance at 64 instants: F(c, w) = 0 and F_c n = 0 with the coefficients c of the odd
    harmonics, a null vector n of length 1, and w.
    """
    order = np.arange(1, 16, 2)
    phase = 2.0 * np.pi * np.arange(64) / 64
    basis = np.hstack([np.cos(np.outer(phase, order)), np.sin(np.outer(phase, order))])
    square, rate = np.tile(order**2, 2), 0.1 * np.concatenate([order, order])
    size, half = 2 * len(order), len(order)

    def both(z):
        c, null, w = z[:size], z[size:-1], z[-1]
        q = basis @ c
        turned = np.concatenate([c[half:], -c[:half]]) * w * rate
        value = (1.0 - w * w * square) * c + turned + basis.T @ q**3 / 32.0
        value[0] -= 0.5
        turned = np.concatenate([null[half:], -null[:half]]) * w * rate
        slope = (1.0 - w * w * square) * null + turned
        slope = slope + basis.T @ (3.0 * q * q * (basis @ null)) / 32.0
        return np.concatenate([value, slope, [null @ null - 1.0]])

    for amplitude, angle in product(np.linspace(0.3, 3.0, 28), np.linspace(-np.pi, np.pi, 9)):
        start = np.zeros(2 * size + 1)
        start[0], start[half] = amplitude * np.cos(angle), amplitude * np.sin(angle)
        start[size], start[-1] = 1.0, near
        solved = root(both, start)
        if solved.success and abs(solved.x[-1] - near) < 0.1:
            return solved.x[-1]
    raise AssertionError(f"no fold near {near}")


def test_folds_of_a_forced_duffing_oscillator():
    problem, settings = system(ode.forced_duffing, [1.0] * 4), Settings(0.3, 3.0)
    period = 2.0 * np.pi / 0.5
    cycle = simulated_cycle(problem, [0.0, 0.0, 1.0, 0.0], 0.5, 29 * period, period)
    found = orbits(problem, cycle, period, 0.5, settings)
    assert [event.kind for event in found.events] == ["fold", "fold"]
    # harmonic balance, which shares no code with collocation;
    # observed 7e-10
    found_at = sorted(event.parameter for event in found.events)
    assert found_at == pytest.approx([duffing_fold(1.4), duffing_fold(2.2)], rel=1e-7)
    for event in found.events:
        _, matrix = monodromy(event.point)
        values = np.sort(np.abs(np.linalg.eigvals(matrix) - 1.0))
        assert values[1] < 2e-3  # round-off 1e-7 splits a double multiplier by its root


def test_doublings_of_the_double_well():
    problem, settings = system(ode.double_well, [1.0] * 4), Settings(0.05, 0.3)
    period = 2.0 * np.pi
    cycle = simulated_cycle(problem, [1.0, 0.0, 1.0, 0.0], 0.1, 40 * period, period)
    found = orbits(problem, cycle, period, 0.1, settings)
    assert [event.kind for event in found.events] == ["fold", "fold", "period doubling"]
    assert is_confirmed(found.events[2].point, -1.0)
    (twice,) = switched(found.events[2], settings)
    assert is_confirmed(twice.events[0].point, -1.0)


@pytest.mark.parametrize(
    ("kind", "value"),
    [("period doubling", -1.0 + 0.0j), ("symmetry breaking", 1.0 + 0.0j), ("torus", 1.0j)],
)
def test_an_event_that_a_finer_mesh_does_not_have_is_refused(kind, value):
    """The torus point of Langford's system has its multipliers at 0.5 of a right angle from -1."""
    problem, settings = system(ode.langford, [1.0] * 3), Settings(-1.0, 2.0)
    rest = equilibria(problem, np.zeros(3), 0.0, settings)
    (found,) = switched(rest.of_kind("Hopf")[0], settings)
    assert mesh_doubt(found.events[0], settings) == ""
    false = replace(found.events[0], kind=kind, value=value)
    assert "belongs to the mesh: with 22 intervals" in mesh_doubt(false, settings)
    if kind != "torus":
        with pytest.raises(ContinuationError, match="belongs to the mesh: with 22 intervals"):
            switched(false, settings)


def test_two_to_one_resonance_wakes_the_swing_where_averaging_says():
    problem = system(
        ode.two_to_one, [0.5] * 4, symmetry=np.diag([1.0, -1.0, 1.0, -1.0]), is_second_order=True
    )
    settings = Settings(-0.1, 0.4)
    rest = equilibria(problem, np.zeros(4), -0.05, settings)
    (vertical,) = switched(rest.events[0], settings)
    (onset,) = vertical.events
    assert onset.kind == "period doubling"
    # amplitude sqrt(p); s'' + 0.04 s' + (1 + 0.4 sqrt(p) cos 2t) s = 0 grows from p = 0.04
    assert onset.parameter == pytest.approx(0.04, rel=1e-3)
    assert is_confirmed(onset.point, -1.0)
    (swing,) = switched(onset, settings)
    at = swing.at(0.2)[0]
    assert at.is_stable
    simulated = ode.settled_amplitude(problem, at.states[0] * 0.9, at.parameter, 600.0, at.period)
    assert at.amplitude == pytest.approx(simulated, rel=1e-3)


def test_one_to_one_resonance_breaks_the_symmetry_of_in_plane_motion():
    problem = system(
        ode.one_to_one, [0.5] * 4, symmetry=np.diag([1.0, -1.0, 1.0, -1.0]), is_second_order=True
    )
    settings = Settings(-0.1, 0.6)
    rest = equilibria(problem, np.zeros(4), -0.05, settings)
    (plane,) = switched(rest.events[0], settings)
    (breaking,) = plane.events
    assert breaking.kind == "symmetry breaking"
    _, matrix = monodromy(breaking.point)
    block = matrix[np.ix_([1, 3], [1, 3])]  # out-of-plane disturbances alone
    assert np.min(np.abs(np.linalg.eigvals(block) - 1.0)) < 1e-6
    (whirl,) = switched(breaking, settings)
    at = whirl.points[-2]
    assert at.is_stable
    simulated = ode.settled_amplitude(problem, at.states[0] * 0.9, at.parameter, 600.0, at.period)
    assert at.amplitude == pytest.approx(simulated, rel=1e-3)


@pytest.mark.parametrize("seed", range(6))
def test_drawn_systems_against_integration(seed):
    """Random linear part and quadratic terms that do no work, with cubic damping."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(3, 7))
    linear = draw.standard_normal((n, n)) - 1.5 * np.eye(n)
    form = draw.standard_normal((n, n, n))
    form -= form.swapaxes(0, 2)  # y . Q(y, y) = 0

    def function(y, p):
        y = np.asarray(y)
        square = np.sum(y * y, axis=0)
        return linear @ y + p * y + 0.3 * np.einsum("ijk,jt,kt->it", form, y, y) - y * square

    problem = system(function, np.ones(n))
    settings = Settings(-2.0, 4.0, max_points=60)
    rest = equilibria(problem, np.zeros(n), -2.0, settings)
    growing = np.linalg.eigvals(linear)
    expected = sorted(-value.real for value in growing if value.imag > 0.0)
    hopf = [event for event in rest.events if event.kind == "Hopf" and is_at_rest(event.point)]
    assert [event.parameter for event in hopf] == pytest.approx(
        [value for value in expected if -2.0 < value < 4.0], abs=1e-6
    )
    if not hopf:
        return
    (found,) = switched(hopf[0], settings)
    tame = [point for point in found.points if np.max(np.abs(point.spectrum)) < 30.0]
    if tame:
        assert is_confirmed(tame[len(tame) // 2])
    for event in found.events[:2]:
        if event.kind != "fold" and np.max(np.abs(event.point.spectrum)) < 30.0:
            assert is_confirmed(event.point)


def is_at_rest(point):
    return np.max(np.abs(point.states)) < 1e-9


def test_error_estimate_bounds_the_error_and_falls_with_the_tolerance():
    problem = system(ode.van_der_pol, [2.0, 2.0], is_second_order=True)
    cycle = simulated_cycle(problem, [2.0, 0.0], 3.0, 60.0, 8.859)
    fine = orbit(problem, cycle, 8.859, 3.0, Settings(0.1, 5.0, tolerance=1e-8))
    phases = np.linspace(0.0, 1.0, 999)
    for tolerance in (1e-3, 1e-5, 1e-7):
        point = orbit(problem, cycle, 8.859, 3.0, Settings(0.1, 5.0, tolerance=tolerance))
        shift = phases + best_shift(point, fine)
        error = np.max(np.abs(point.at(phases) - fine.at(shift)) / np.max(fine.amplitude))
        assert error < 3.0 * point.error  # observed 0.2 to 1.5
        assert point.error < tolerance
        assert abs(point.period / fine.period - 1.0) < 0.1 * point.error


def best_shift(point, fine):
    """Phase of the fine orbit at the first node of another."""
    phases = np.linspace(0.0, 1.0, 20001)
    start = phases[np.argmin(np.sum((fine.at(phases) - point.states[0]) ** 2, axis=1))]
    near = start + np.linspace(-1e-4, 1e-4, 20001)
    return near[np.argmin(np.sum((fine.at(near) - point.states[0]) ** 2, axis=1))]


def test_an_orbit_that_is_not_resolved_ends_the_branch_and_says_so(monkeypatch):
    monkeypatch.setattr("modal.continuation.collocation.MAX_INTERVALS", 30)
    problem = system(ode.van_der_pol, [2.0, 2.0], is_second_order=True)
    cycle = simulated_cycle(problem, [2.0, 0.0], 1.0, 40.0, 6.663)
    found = orbits(problem, cycle, 6.663, 1.0, Settings(0.5, 10.0))
    assert (found.ends[1].kind, found.is_complete) == ("lost", False)
    assert "not resolved by 30 mesh intervals" in found.ends[1].reason


def test_second_order_elimination_gives_the_same_orbit():
    cycles = []
    for is_second_order in (False, True):
        problem = system(ode.van_der_pol, [2.0, 2.0], is_second_order=is_second_order)
        cycle = simulated_cycle(problem, [2.0, 0.0], 1.0, 40.0, 6.663)
        cycles.append(orbit(problem, cycle, 6.663, 1.0, Settings(0.1, 5.0)))
    assert cycles[0].x == pytest.approx(cycles[1].x, abs=1e-10)
    assert cycles[0].spectrum == pytest.approx(cycles[1].spectrum, abs=1e-12)


def test_a_branch_is_a_labelled_table():
    problem = system(ode.langford, [1.0] * 3)
    settings = Settings(-1.0, 2.0)
    limit = UserEvent("large", lambda states, p: 1.0 - float(states[:, 0].max()), False)
    rest = equilibria(problem, np.zeros(3), 0.0, settings)
    (found,) = switched(rest.of_kind("Hopf")[0], settings, [limit])
    table = found.dataset()
    assert dict(table.sizes) == {
        "point": len(found.points),
        "component": 3,
        "multiplier_number": 2,
    }
    labels = [label for label in table.event.values if label]
    assert labels == ["large", "torus", "range"]
    assert table.attrs == {"kind": "orbit", "begin": "Hopf", "end": "range"}
    stable = table.parameter.values[table.is_stable.values]
    assert np.all(stable > found.of_kind("torus")[0].parameter - 1e-9)
    assert table.highest.values[:, 2] == pytest.approx(0.7, abs=1e-6)


def test_subcritical_hopf_point_and_fold_in_closed_form():
    """r' = r (p + r^2 - r^4) with r^2 = x^2 + v^2: folds at p = -1/4, r^2 = 1/2."""

    def function(y, p):
        square = y[0] * y[0] + y[1] * y[1]
        rate = p + square - square * square
        return [rate * y[0] - 3.0 * y[1], 3.0 * y[0] + rate * y[1]]

    problem, settings = system(function, [1.0, 1.0]), Settings(-0.5, 0.5)
    rest = equilibria(problem, np.zeros(2), -0.1, settings)
    (hopf,) = rest.events
    assert hopf.parameter == pytest.approx(0.0, abs=1e-9)
    (found,) = switched(hopf, settings)
    (fold,) = found.events
    assert (fold.kind, fold.parameter) == ("fold", pytest.approx(-0.25, rel=1e-7))
    assert fold.point.amplitude[0] == pytest.approx(np.sqrt(0.5), rel=1e-5)
    small, large = found.at(-0.125)
    assert (small.is_stable, large.is_stable) == (False, True)
    # The small cycles have one growing disturbance: they are given up if none is allowed
    limit = GrowingLimit(0, 3, 0.9)
    (short,) = switched(hopf, replace(settings, max_growing=limit))
    last = short.points[-1].parameter
    assert {one.unstable for one in short.points} == {1}
    assert len(short.points) >= 3
    assert abs(short.points[0].parameter) < 0.1 * abs(last) < 0.025
    assert (short.ends[1].kind, short.is_complete) == ("given up", True)
    assert "more than 0 disturbances grow from" in short.ends[1].reason
    (whole,) = switched(hopf, replace(settings, max_growing=limit._replace(disturbances=1)))
    assert whole.ends[1].kind == found.ends[1].kind == "range"
    # The parameter changes by less than five times itself on them
    (brief,) = switched(hopf, replace(settings, max_growing=limit._replace(change=5.0)))
    assert brief.ends[1].kind == "range"


def test_two_modes_of_duffing_type_with_known_folds_and_doublings():
    """r' = r (p + r^2 - r^4) has a fold at p = -1/4; its x = r cos 2t drives Mathieu's equation.

    s'' + 0.1 s' + (1 + x/4) s + s^3 = 0, whose doubling is found by integration of the linear part.
    """

    def function(y, p):
        x, z, s, ds = y
        square = x * x + z * z
        rate = p + square - square * square
        stiffness = 1.0 + 0.25 * x + s * s
        return [rate * x - 2.0 * z, 2.0 * x + rate * z, ds, -0.1 * ds - stiffness * s]

    def beyond(r):
        """Trace of the monodromy matrix over a period pi, less that at a multiplier -1."""
        columns = []
        for start in np.eye(2):
            run = solve_ivp(
                lambda t, y: [y[1], -0.1 * y[1] - (1.0 + 0.25 * r * np.cos(2.0 * t)) * y[0]],
                (0.0, np.pi),
                start,
                rtol=1e-11,
                atol=1e-12,
            )
            columns.append(run.y[:, -1])
        return np.trace(columns) + 1.0 + np.exp(-0.1 * np.pi)

    square = brentq(beyond, 0.4, 1.2) ** 2
    problem = system(function, [0.5] * 4, symmetry=np.diag([1.0, 1.0, -1.0, -1.0]))
    settings = Settings(-0.4, 0.3)
    rest = equilibria(problem, np.zeros(4), -0.1, settings)
    (found,) = switched(rest.events[0], settings)
    fold, doubling = found.events
    assert (fold.kind, doubling.kind) == ("fold", "period doubling")
    assert fold.parameter == pytest.approx(-0.25, rel=1e-6)
    assert doubling.parameter == pytest.approx(square**2 - square, rel=1e-5)
    stable = [point.parameter for point in found.points if point.is_stable]
    assert -0.25 <= min(stable) < max(stable) <= doubling.parameter + 1e-9
    (swing,) = switched(doubling, settings)
    at = swing.points[-1]
    assert at.is_stable
    simulated = ode.settled_amplitude(problem, at.states[0] * 0.98, at.parameter, 300.0, at.period)
    assert at.amplitude == pytest.approx(simulated, rel=1e-3)


def test_a_spectrum_that_is_not_finite_is_a_jump():
    """It ended a screening in a ValueError."""
    known = np.array([2.0 + 0.0j, 0.5 + 0.0j])
    for value in (np.inf, np.nan):
        beyond = np.array([value, 0.5], dtype=complex)
        assert spectrum_change(known, beyond) == spectrum_change(beyond, beyond) == np.inf
