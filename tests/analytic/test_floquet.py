"""Floquet multipliers against Mathieu's equation; of an orbit against the simulation's growth."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import mathieu_a, mathieu_b

from modal.screening.floquet import monodromy

STEPS = 400


def mathieu(stiffness, damping, modulation, frequency, steps=STEPS):
    """Multipliers of q'' + c q' + k (1 + e cos W t) q = 0 over one period of the modulation."""
    phase = 2.0 * np.pi * (np.arange(steps) + 0.5) / steps
    k = (stiffness * (1.0 + modulation * np.cos(phase)))[:, None, None]
    ones = np.ones((steps, 1, 1))
    return np.linalg.eigvals(monodromy(k, damping * ones, ones, 2.0 * np.pi / frequency))


def test_constant_coefficients_give_the_exponential():
    decay, omega, period = 0.3, np.sqrt(4.0 - 0.3**2), 2.0 * np.pi
    exact = np.exp((-decay + 1j * omega) * period)
    found = mathieu(4.0, 2.0 * decay, 0.0, 1.0)
    assert np.min(np.abs(found - exact)) < 4e-4  # observed 1.6e-4


@pytest.mark.parametrize("steps", [400, 401, 403])
def test_two_coupled_coordinates_without_any_symmetry_in_time(steps):
    """Against Runge-Kutta of order eight: the order of convergence, and the error of every step."""

    def coefficients(t):
        c, s = np.cos(t), np.sin(2.0 * t + 0.4)
        return np.array([[2.0 + c, 0.5 * s], [0.3, 1.0 + 0.4 * s]]), np.array(
            [[0.1, 0.3 * c], [-0.2 * s, 0.05]]
        )

    def rate(t, y):
        stiffness, damping = coefficients(t)
        q, v = y.reshape(2, 2, 4)
        return np.concatenate([v, -damping @ v - stiffness @ q]).ravel()

    period = 2.0 * np.pi
    exact = solve_ivp(
        rate, (0.0, period), np.eye(4).ravel(), method="DOP853", rtol=1e-11, atol=1e-12
    ).y[:, -1]
    both = [coefficients(t) for t in period * (np.arange(steps) + 0.5) / steps]
    stiffness, damping = (np.array(part) for part in zip(*both, strict=True))
    found = monodromy(stiffness, damping, np.broadcast_to(np.eye(2), (steps, 2, 2)), period)
    assert found == pytest.approx(exact.reshape(4, 4), abs=7e-4)  # observed 3.6e-4


def test_the_error_shrinks_with_the_square_of_the_step():
    fine = np.trace(np.diag(mathieu(1.0, 0.1, 0.3, 1.9, steps=6400))).real
    errors = [
        abs(np.trace(np.diag(mathieu(1.0, 0.1, 0.3, 1.9, steps=steps))).real - fine)
        for steps in (100, 200)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.05)  # observed 4.0006


@pytest.mark.parametrize("q", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("characteristic", [mathieu_a, mathieu_b])
def test_multipliers_pass_minus_one_at_mathieus_characteristic_values(q, characteristic):
    """x'' + (a - 2 q cos 2t) x = 0 has solutions of twice the period at a = a1(q) and b1(q)."""
    a = characteristic(1, q)
    found = mathieu(a, 0.0, -2.0 * q / a, 2.0)
    assert found.sum().real == pytest.approx(-2.0, abs=3e-4)  # observed up to 1.7e-4, for q = 1


@pytest.mark.parametrize("detuning", [-0.02, 0.0, 0.03])
def test_the_threshold_is_four_times_damping_and_detuning(detuning):
    ratio = 0.01
    frequency = 2.0 * (1.0 + detuning)
    threshold = 4.0 * np.hypot(ratio, detuning)

    def growth(factor):
        return np.max(np.abs(mathieu(1.0, 2.0 * ratio, factor * threshold, frequency)))

    # observed at 0.993, 1.00003 and 1.0096 of it: the formula is the first order in detuning and
    # modulation
    assert growth(0.985) < 1.0 < growth(1.015)
