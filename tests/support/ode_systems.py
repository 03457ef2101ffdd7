"""Systems of ordinary differential equations whose bifurcations are known, and checks of orbits.

The checks integrate with scipy's DOP853, which shares no code with `modal.continuation`.
"""

import numpy as np
from scipy.integrate import solve_ivp

from modal.continuation.problem import Rates, System

COMPLEX_STEP = 1e-30


def system(function, scale, **options):
    """System with derivatives by complex steps, which are exact to round-off.

    ``function(y, p)`` takes the components y (a sequence of arrays) and returns those of y'.
    """
    scale = np.asarray(scale, dtype=float)

    def rates(states, parameter):
        y = states.T.astype(complex)
        value = np.array(function(y, parameter)).real
        slopes = np.empty((len(states), len(scale), len(scale)))
        for k in range(len(scale)):
            moved = y.copy()
            moved[k] += 1j * COMPLEX_STEP
            slopes[:, :, k] = np.array(function(moved, parameter)).imag.T / COMPLEX_STEP
        by_parameter = np.array(function(y, parameter + 1j * COMPLEX_STEP)).imag / COMPLEX_STEP
        return Rates(value.T, slopes, by_parameter.T)

    found = System(rates, scale, **options)
    object.__setattr__(found, "of_one_state", lambda y, p: np.array(function(y, p)))
    return found


def integrate(problem, state, parameter, duration, **options):
    """Integrate from a state; tolerances 1e-11 unless given."""
    options = {"rtol": 1e-11, "atol": 1e-11, "method": "DOP853", **options}
    return solve_ivp(
        lambda t, y: problem.of_one_state(y, parameter), (0.0, duration), state, **options
    )


def monodromy(point):
    """State after a period, and the monodromy matrix by the variational equations."""
    problem, n = point.equations.problem, point.equations.problem.size

    def both(t, z):
        rates = problem.rates(z[None, :n], point.parameter)
        return np.concatenate([rates.value[0], (rates.by_state[0] @ z[n:].reshape(n, n)).ravel()])

    start = np.concatenate([point.states[0], np.eye(n).ravel()])
    end = solve_ivp(both, (0, point.period), start, method="DOP853", rtol=1e-11, atol=1e-11).y[
        :, -1
    ]
    return end[:n], end[n:].reshape(n, n)


def settled_amplitude(problem, state, parameter, duration, window):
    """Half peak-to-peak of each component in the last window of a long simulation."""
    run = integrate(problem, state, parameter, duration, rtol=1e-9, atol=1e-9)
    state = run.y[:, -1]
    run = integrate(problem, state, parameter, window, dense_output=True)
    values = run.sol(np.linspace(0.0, window, 40001))
    return 0.5 * np.ptp(values, axis=1)


def lorenz(y, p):
    a, b, c = y
    return [10.0 * (b - a), p * a - b - a * c, a * b - 8.0 / 3.0 * c]


def roessler(y, p):
    a, b, c = y
    return [-b - c, a + 0.2 * b, 0.2 + c * (a - p)]


def van_der_pol(y, p):
    x, v = y
    return [v, p * (1.0 - x * x) * v - x]


def brusselator(y, p):
    x, z = y
    return [1.0 + x * x * z - (p + 1.0) * x, p * x - x * x * z]


LANGFORD = {"alpha": 0.95, "beta": 0.7, "omega": 3.5, "rho": 0.25}


def langford(y, p):
    """Langford (1979): orbits x^2 + y^2 = r^2, z = beta in closed form."""
    x, v, z = y
    a, b, w, r = LANGFORD.values()
    return [
        (z - b) * x - w * v,
        w * x + (z - b) * v,
        p + a * z - z**3 / 3.0 - (x * x + v * v) * (1.0 + r * z),
    ]


PRISM = {"A": 2.69, "B": 168.0, "C": 6270.0, "D": 59900.0, "n": 4.3e-4, "beta": 1.07e-3}
"""Square prism of Parkinson and Smith (1964): C_Fy = A tan - B tan^3 + C tan^5 - D tan^7."""


def prism(y, p):
    """Galloping of the prism (Parkinson and Smith 1964, eq. 6); p is the reduced wind speed."""
    q, v = y
    A, B, C, D, n, beta = PRISM.values()
    slope = v / p
    force = A * slope - B * slope**3 + C * slope**5 - D * slope**7
    return [v, -q - 2.0 * beta * v + n * p * p * force]


def forced_duffing(y, p):
    """Duffing oscillator, driven by an oscillator whose frequency is p: u = cos p t."""
    q, v, u, w = y
    shrink = 1.0 - u * u - w * w
    return [v, -0.1 * v - q - q**3 + 0.5 * u, shrink * u - p * w, p * u + shrink * w]


def double_well(y, p):
    """Duffing oscillator with two wells (Guckenheimer and Holmes 1983), driven by p cos t."""
    q, v, u, w = y
    shrink = 1.0 - u * u - w * w
    return [v, -0.25 * v + q - q**3 + p * u, shrink * u - w, u + shrink * w]


def two_to_one(y, p):
    """Galloping mode v of frequency 2 and swing s of frequency 1, coupled by stretching."""
    v, s, dv, ds = y
    return [dv, ds, -4.0 * v + p * dv - dv**3 / 3.0 - 0.2 * s * s, -s - 0.04 * ds - 0.4 * v * s]


def one_to_one(y, p):
    """In-plane galloping mode v and out-of-plane mode w of nearly the same frequency."""
    v, w, dv, dw = y
    square = v * v + w * w
    return [
        dv,
        dw,
        -v - 0.3 * v * square + p * dv - dv**3,
        -1.05 * w - 0.3 * w * square - 0.02 * dw,
    ]
