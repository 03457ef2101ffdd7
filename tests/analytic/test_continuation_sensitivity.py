"""Derivatives of events, orbits and growth by numbers of systems, against closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from modal.continuation import sensitivity
from modal.continuation.path import Settings
from modal.continuation.problem import ContinuationError
from modal.continuation.starts import equilibria, orbit, switched
from support import ode_systems as ode
from support.ode_systems import LANGFORD, system

STEP = 1e-3


def by_numbers(gradient, family, numbers):
    """Derivatives of a quantity by each of the numbers of a family of systems."""
    found = []
    for k in range(len(numbers)):
        sides = [list(numbers), list(numbers)]
        sides[0][k] -= STEP
        sides[1][k] += STEP
        factors = (-0.5 / STEP, 0.5 / STEP)
        found.append(
            gradient.by_number(
                [(family(*side), factor) for side, factor in zip(sides, factors, strict=True)]
            )
        )
    return np.array(found)


def differences(function, numbers):
    """Central differences of a closed form, exact to 1e-9."""
    h = 1e-5
    return [
        (function(*(numbers + h * unit)) - function(*(numbers - h * unit))) / (2.0 * h)
        for unit in np.eye(len(numbers))
    ]


def quintic(a, b, w, hopf, k=0.0):
    """r' = r (p - hopf + a r^2 - b r^4 + k x^2), r^2 = x^2 + v^2, rotating at w (1 + x/2)."""

    def function(y, p):
        square = y[0] * y[0] + y[1] * y[1]
        rate = p - hopf + a * square - b * square * square + k * y[0] * y[0]
        turn = w * (1.0 + 0.5 * y[0])  # the mesh is not uniform
        return [rate * y[0] - turn * y[1], turn * y[0] + rate * y[1]]

    return system(function, [1.0, 1.0])


def test_normal_form_with_hopf_point_fold_amplitude_period_and_growth():
    numbers = np.array([1.0, 1.2, 3.0, 0.1])
    settings = Settings(-0.5, 0.5, tolerance=1e-7)
    problem = quintic(*numbers)
    rest = equilibria(problem, np.zeros(2), -0.1, settings)
    (hopf,) = rest.events
    found = by_numbers(sensitivity.onset(hopf), quintic, numbers)
    assert found == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=1e-9)
    (branch,) = switched(hopf, settings)
    (fold,) = branch.events
    a, b = numbers[:2]
    found = by_numbers(sensitivity.onset(fold), quintic, numbers)
    # p = hopf - a^2/(4 b); observed 1e-9
    assert found == pytest.approx([-a / (2 * b), a**2 / (4 * b**2), 0.0, 1.0], abs=1e-7)

    # k acts on the mean of x^2 over time, which is slow where x is small
    slope = by_numbers(sensitivity.onset(fold), lambda k: quintic(*numbers, k), [0.0])
    x = np.sqrt(a / (2 * b)) * np.cos(2.0 * np.pi * np.arange(400) / 400)
    assert slope == pytest.approx([-np.average(x * x, weights=1.0 / (1.0 + 0.5 * x))], rel=1e-6)

    def square(a, b, w, hopf, p):
        return (a + np.sqrt(a * a + 4.0 * b * (p - hopf))) / (2.0 * b)

    def rate(a, b, w, hopf, p):
        s = square(a, b, w, hopf, p)
        return 2.0 * a * s - 4.0 * b * s * s

    def turn(a, b, w, hopf, p):
        return 2.0 * np.pi / w / np.sqrt(1.0 - 0.25 * square(a, b, w, hopf, p))

    point = branch.points[-1]
    at = np.append(numbers, point.parameter)
    for gradient, expected in (
        (sensitivity.amplitude(point, np.array([1.0, 0.0])), lambda *m: np.sqrt(square(*m))),
        (sensitivity.growth(point), rate),
        (sensitivity.period(point), turn),
    ):
        exact = differences(expected, at)
        assert gradient.value == pytest.approx(expected(*at), rel=1e-9)
        assert by_numbers(gradient, quintic, numbers) == pytest.approx(
            exact[:-1], rel=3e-6, abs=1e-8
        )
        assert gradient.by_parameter(problem) == pytest.approx(exact[-1], rel=1e-6, abs=1e-8)


def test_hopf_point_and_growth_of_an_equilibrium_that_moves():
    """Lorenz (1963): r = s (s + b + 3)/(s - b - 1) at a point away from the origin."""

    def lorenz(s, b):
        return system(
            lambda y, p: [s * (y[1] - y[0]), p * y[0] - y[1] - y[0] * y[2], y[0] * y[1] - b * y[2]],
            [10.0] * 3,
        )

    numbers = np.array([10.0, 8.0 / 3.0])
    rest = equilibria(lorenz(*numbers), np.array([8.0, 8.0, 23.0]), 24.0, Settings(20.0, 30.0))
    (hopf,) = rest.of_kind("Hopf")
    exact = differences(lambda s, b: s * (s + b + 3.0) / (s - b - 1.0), numbers)
    found = by_numbers(sensitivity.onset(hopf), lorenz, numbers)
    assert found == pytest.approx(exact, rel=1e-6)  # observed 2e-7

    def growth(s, b):  # roots of the characteristic polynomial at p = 26
        p = 26.0
        return np.max(np.roots([1.0, s + b + 1.0, b * (p + s), 2.0 * b * s * (p - 1.0)]).real)

    stepped = equilibria(lorenz(*numbers), np.array([8.0, 8.0, 25.0]), 26.0, Settings(25.9, 26.1))
    point = min(stepped.points, key=lambda one: abs(one.parameter - 26.0))
    assert point.parameter == 26.0
    found = by_numbers(sensitivity.growth(point), lorenz, numbers)
    assert found == pytest.approx(differences(growth, numbers), rel=1e-5)


def test_folds_of_equilibria():
    """z^3/3 - a z has its extremes at 2/3 a^1.5."""

    def cubic(a):
        return system(lambda y, p: [p + a * y[0] - y[0] ** 3 / 3.0], [1.0])

    found = equilibria(cubic(0.95), np.array([-2.0]), -0.3, Settings(-1.0, 1.0))
    folds = found.of_kind("fold")
    slopes = [by_numbers(sensitivity.onset(one), cubic, [0.95])[0] for one in folds]
    assert sorted(slopes) == pytest.approx([-np.sqrt(0.95), np.sqrt(0.95)], rel=1e-6)


def test_torus_of_langford_in_closed_form():
    def langford(a, b, w, r):
        def function(y, p):
            x, v, z = y
            square = x * x + v * v
            last = p + a * z - z**3 / 3.0 - square * (1.0 + r * z)
            return [(z - b) * x - w * v, w * x + (z - b) * v, last]

        return system(function, [1.0] * 3)

    numbers = np.array(list(LANGFORD.values()))
    settings = Settings(-1.0, 2.0)
    rest = equilibria(langford(*numbers), np.zeros(3), 0.0, settings)
    (branch,) = switched(rest.of_kind("Hopf")[0], settings)
    (torus,) = branch.of_kind("torus")

    def parameter(a, b, w, r):
        return (a - b * b) / r * (1.0 + r * b) - a * b + b**3 / 3.0

    found = by_numbers(sensitivity.onset(torus), langford, numbers)
    # observed 4e-6
    assert found == pytest.approx(differences(parameter, numbers), rel=2e-5, abs=1e-6)


def test_doubling_of_mathieus_equation():
    """An oscillation x = sqrt(p) cos 2t drives s'' + c s' + (k + x) s + s^3 = 0."""

    def mathieu(c, k):
        def function(y, p):
            x, z, s, ds = y
            rate = p - x * x - z * z
            stiffness = k + x + s * s
            return [rate * x - 2.0 * z, 2.0 * x + rate * z, ds, -c * ds - stiffness * s]

        return system(function, [0.3] * 4)

    def onset(c, k):
        def beyond(square):  # trace of the monodromy matrix, less that at a multiplier -1
            trace = 0.0
            for j in range(2):
                run = solve_ivp(
                    lambda t, y: [y[1], -c * y[1] - (k + np.sqrt(square) * np.cos(2 * t)) * y[0]],
                    (0.0, np.pi), np.eye(2)[j], rtol=1e-10, atol=1e-12, method="DOP853",
                )  # fmt: skip
                trace += run.y[j, -1]
            return trace + 1.0 + np.exp(-c * np.pi)

        return brentq(beyond, 0.005, 0.2, xtol=1e-13)

    numbers = np.array([0.1, 1.02])
    settings = Settings(-0.1, 0.3, tolerance=1e-6)
    rest = equilibria(mathieu(*numbers), np.zeros(4), -0.05, settings)
    (branch,) = switched(rest.events[0], settings)
    doubling = branch.of_kind("period doubling")[0]
    found = by_numbers(sensitivity.onset(doubling), mathieu, numbers)
    h = 1e-3
    exact = [
        (onset(*(numbers + h * unit)) - onset(*(numbers - h * unit))) / (2.0 * h)
        for unit in np.eye(2)
    ]
    assert found == pytest.approx(exact, rel=1e-4)


def test_period_of_van_der_pol_by_its_scaling():
    """With the frequency w, T(mu, w) = T(mu/w)/w, so that w dT/dw = -T - mu dT/dmu."""

    def van_der_pol(w):
        return system(
            lambda y, p: [y[1], p * (1.0 - y[0] * y[0]) * y[1] - w * w * y[0]],
            [2.0, 2.0],
            is_second_order=True,
        )

    problem, times = van_der_pol(1.0), 2.0 * np.pi * np.arange(60) / 60
    circle = 2.0 * np.stack([np.cos(times), -np.sin(times)], axis=1)
    point = orbit(problem, circle, 2.0 * np.pi, 0.5, Settings(0.1, 5.0, tolerance=1e-7))
    gradient = sensitivity.period(point)
    expected = -point.period - 0.5 * gradient.by_parameter(problem)
    assert by_numbers(gradient, van_der_pol, [1.0])[0] == pytest.approx(expected, rel=1e-7)
    # Andersen and Geer (1982): w = 1 - mu^2/16 + 17 mu^4/3072 + 35 mu^6/884736 - ...
    frequency = np.polynomial.Polynomial(
        [1.0, 0.0, -1 / 16, 0.0, 17 / 3072, 0.0, 35 / 884736, 0.0, -678899 / 5096079360]
    )
    slope = -2.0 * np.pi * frequency.deriv()(0.5) / frequency(0.5) ** 2
    assert gradient.by_parameter(problem) == pytest.approx(
        slope, rel=1e-5
    )  # observed 4e-6: the series


def test_other_events_have_no_derivative():
    problem = system(ode.lorenz, [10.0] * 3, symmetry=np.diag([-1.0, -1.0, 1.0]))
    rest = equilibria(problem, np.zeros(3), 0.5, Settings(0.0, 30.0))
    with pytest.raises(ContinuationError, match="derivative of a symmetry breaking is not known"):
        sensitivity.onset(rest.events[0])
