"""The 2:1 resonance of a span in two modes, by formulas: when vertical galloping starts the horizontal swing.

The first symmetric vertical mode changes the tension and with it the stiffness of the horizontal
one, whose equation is Mathieu's: ``q'' + 2 xi w q' + w^2 (1 + e cos W t) q = 0`` with ``e = h/H``,
the dynamic over the static tension. It is unstable from ``e = 4 sqrt(xi^2 + D^2)`` on, ``D = W/(2
w) - 1`` (Nayfeh and Mook 1979, section 5.3). Both frequencies depend on the amplitude: the first
corrections are those of Lindstedt and Poincare, with all other modes answering to the second order.
The vertical amplitude follows from the balance of energy over a cycle.
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Scene, SceneError
from modal.linear.mode_basis import PROBE, Rest, assemble, at_rest, tension_derivative
from modal.screening.reduced_model import ReducedModel

Array = NDArray[np.float64]

ELEMENTS = 6
"""Elements of the mesh: the two modes are wider than its elements by far."""

INSTANTS = 12
"""Instants of a cycle at which energy is balanced; more change nothing at 0.1 %."""

LARGEST_RATIO = 1.5
"""Largest vertical speed over wind speed that the balance looks at."""

AMPLITUDES, WINDS = 16, 16
"""Points at which the balance is read; parabolas through three of them refine it."""

TWIST_ROUNDS = 3
"""Rounds in which the twist settles to the wind's moment; each shrinks the error about tenfold."""


@dataclass(frozen=True)
class Coupling:
    """Quadratic coupling of the first symmetric pair and what follows from it to the second order.

    Attributes
    ----------
    modulation : float
        Relative change of the swing's stiffness w^2 per metre of vertical mid-span displacement
        [1/m]; in a shallow span this is the dynamic tension per metre over the static one.
    vertical_curve : float
        Change of the squared vertical frequency [rad2/s2] per square metre of vertical amplitude.
    swing_curve : float
        Change of the squared horizontal frequency [rad2/s2] per square metre of vertical amplitude.
    """

    modulation: float
    vertical_curve: float
    swing_curve: float


@dataclass(frozen=True)
class TwoMode:
    """Analytic estimate of the 2:1 resonance.

    Attributes
    ----------
    coupling : Coupling
        Quadratic coupling of the pair.
    swing_damping : float
        Damping ratio of the swing, structure and wind together, at the wind speed of the estimate.
    threshold_amplitude : float or None
        Vertical amplitude [m] at mid-span that starts the swing; None if none within the range
        looked at does.
    threshold_detuning : float or None
        D there.
    vertical_amplitude : float
        Vertical galloping amplitude [m] at the scene's wind without swing; 0 where galloping dies
        out, infinite where the balance finds no end to its growth.
    onset_wind_speed : float or None
        Wind speed [m/s] at which galloping reaches the threshold; None if not below the highest
        one.
    seconds : float
        Time it took.
    """

    coupling: Coupling
    swing_damping: float
    threshold_amplitude: float | None
    threshold_detuning: float | None
    vertical_amplitude: float
    onset_wind_speed: float | None
    seconds: float

    @property
    def swings(self) -> bool:
        """Whether the vertical amplitude at the scene's wind passes the threshold."""
        return (
            self.threshold_amplitude is not None
            and self.vertical_amplitude > self.threshold_amplitude
        )


def quadratic_coupling(scene: Scene, rest: Rest | None = None) -> Coupling:
    """Quadratic coupling of the first symmetric vertical and horizontal mode, from the kernel's tangent."""
    rest = at_rest(scene) if rest is None else rest
    still = Inputs.still(scene)
    v, h = rest.first("vertical"), rest.first("horizontal")
    free = np.flatnonzero(rest.free)
    block = np.ix_(free, free)
    shapes = rest.shapes.reshape(len(rest.shapes), -1)[:, free]
    up, across = shapes[v], shapes[h]
    vertical, horizontal = rest.frequencies[v] ** 2, rest.frequencies[h] ** 2
    first = tension_derivative(rest, v)[block]
    stretched, straight = (
        assemble(rest.model.tangent(u, stiffness=1.0, inputs=still))[block]
        for u in (rest.shapes[v] * 1e3 * PROBE, None)
    )
    second = 2.0 * (stretched - straight - 1e3 * PROBE * first) / (1e3 * PROBE) ** 2
    per_metre = 1.0 / rest.shapes[v, rest.model.middle, 1]
    squares = rest.frequencies**2

    def answer(force: Array, square: float, without: int | None = None) -> Array:
        """Steady answer of all modes, or all but one, to a force at a squared frequency."""
        part = (shapes @ force) / (squares - square)
        if without is not None:
            part[without] = 0.0
        return np.asarray(shapes.T @ part)

    bend, push = 0.5 * first @ up, first @ across
    mean, double = -answer(bend, 0.0), -answer(bend, 4.0 * vertical)
    vertical_curve = up @ first @ (0.5 * mean + 0.25 * double) + up @ second @ up / 8.0
    change = assemble(
        rest.model.tangent(_spread(mean, free, rest) * PROBE, stiffness=1.0, inputs=still)
        - rest.model.tangent(_spread(mean, free, rest) * -PROBE, stiffness=1.0, inputs=still)
    )[block] / (2.0 * PROBE)
    swing_curve = 0.5 * across @ change @ across + 0.25 * across @ second @ across
    swing_curve -= (
        0.25 * push @ (answer(push, 2.25 * vertical) + answer(push, 0.25 * vertical, without=h))
    )
    return Coupling(
        modulation=float(across @ push / horizontal * per_metre),
        vertical_curve=float(vertical_curve * per_metre**2),
        swing_curve=float(swing_curve * per_metre**2),
    )


def two_mode_estimate(
    scene: Scene, wind_speed: float | None = None, highest_wind: float | None = None
) -> TwoMode:
    """Analytic two-mode estimate of the threshold and of the wind at which the swing starts.

    Parameters
    ----------
    scene
        The span; it needs a coefficient curve and structural damping.
    wind_speed
        Wind speed [m/s] of the estimate; None takes the scene's.
    highest_wind
        Highest wind speed [m/s] at which the onset is looked for; None takes 1.5 times
        `wind_speed`.

    Raises
    ------
    SceneError
        Without wind, or coefficient curve, or where the pair does not exist.
    """
    wind = scene.wind.mean_speed if wind_speed is None else wind_speed
    if not wind > 0.0:
        raise SceneError(
            f"wind_speed = {wind} m/s: must be positive; give wind.speed or wind_speed"
        )
    return estimate(scene, wind, 1.5 * wind if highest_wind is None else highest_wind)


def estimate(scene: Scene, wind: float, highest: float) -> TwoMode:
    """`two_mode_estimate` with all its arguments known."""
    began = clock.perf_counter()
    rest = at_rest(scene, ELEMENTS)
    coupling = quadratic_coupling(scene, rest)
    chosen = [rest.first("vertical"), rest.first("horizontal"), rest.first("torsional")]
    model = ReducedModel(scene, rest, chosen, rest.shapes[chosen])
    largest = LARGEST_RATIO * highest / model.frequencies[0]
    sizes = largest * np.arange(1, AMPLITUDES + 1) / AMPLITUDES
    power, square = _cycle(model, coupling, sizes, np.full(AMPLITUDES, wind))
    within = sizes <= LARGEST_RATIO * wind / model.frequencies[0]
    reached = _first_rise(sizes[within], power[within])
    still = np.zeros((1, 3))
    damping = model.forces(still, still, still, wind).damping[0, 1, 1] / (
        2.0 * model.frequencies[1]
    )

    def excess(amplitude: Array, vertical_square: Array) -> Array:
        swing = np.sqrt(
            np.maximum(model.frequencies[1] ** 2 + coupling.swing_curve * amplitude**2, 1e-12)
        )
        detuning = np.sqrt(np.maximum(vertical_square, 0.0)) / (2.0 * swing) - 1.0
        modulation = np.abs(coupling.modulation) * amplitude * (model.frequencies[1] / swing) ** 2
        return np.stack([modulation - 4.0 * np.hypot(damping, detuning), detuning])

    above = excess(sizes, square)[0]
    threshold = threshold_detuning = onset = None
    crossing = np.flatnonzero(above > 0.0)
    if len(crossing):
        k = int(crossing[0])
        low = 0.0 if k == 0 else float(sizes[k - 1])
        # between two points the squared vertical frequency is nearly linear in the amplitude
        fine = np.linspace(low, sizes[k], 201)[1:]
        squares = np.interp(fine, sizes, square)
        level, fine_detuning = excess(fine, squares)
        first = int(np.argmax(level > 0.0))
        threshold, threshold_detuning = float(fine[first]), float(fine_detuning[first])
        winds = highest * np.arange(1, WINDS + 1) / WINDS
        here = np.full(WINDS, threshold)
        onset = _first_rise(winds, -_cycle(model, coupling, here, winds)[0])
    amplitude = (0.0 if power[0] > 0.0 else np.inf) if reached is None else reached
    return TwoMode(
        coupling, float(damping), threshold, threshold_detuning, float(amplitude), onset, clock.perf_counter() - began
    )  # fmt: skip


def _spread(values: Array, free: NDArray[np.intp], rest: Rest) -> Array:
    full = np.zeros(rest.free.size)
    full[free] = values
    return full.reshape(-1, 4)


def _cycle(
    model: ReducedModel, coupling: Coupling, amplitude: Array, wind: Array
) -> tuple[Array, Array]:
    """Mean power that a vertical cycle loses, and the squared frequency that its in-phase force gives.

    The twist follows wind, ice and its own stiffness at every instant without inertia.
    """
    frequency = model.frequencies[0]
    phase = 2.0 * np.pi * np.arange(INSTANTS) / INSTANTS
    size = np.repeat(amplitude / model.middle[0, 1], INSTANTS)
    cosine, sine = np.tile(np.cos(phase), len(amplitude)), np.tile(np.sin(phase), len(amplitude))
    q = np.zeros((len(size), 3))
    v, a = np.zeros_like(q), np.zeros_like(q)
    q[:, 0], v[:, 0], a[:, 0] = (
        size * cosine,
        -size * frequency * sine,
        -size * frequency**2 * cosine,
    )
    blowing = np.repeat(wind, INSTANTS)[:, None]
    for _ in range(TWIST_ROUNDS):
        force = model.unstretched(q, v, a, blowing)
        q[:, 2] -= force[:, 2] / model.stiffness[2, 2]
    force = model.unstretched(q, v, a, blowing)
    power = np.mean((force[:, 0] * v[:, 0]).reshape(-1, INSTANTS), axis=1)
    in_phase = 2.0 * np.mean((force[:, 0] * cosine / size).reshape(-1, INSTANTS), axis=1)
    return power, frequency**2 + in_phase + coupling.vertical_curve * amplitude**2


def _first_rise(x: Array, y: Array) -> float | None:
    """First place where y turns from negative to positive, on the parabola through the three points around it."""
    found = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
    if not len(found):
        return None
    k = int(found[0])
    middle = min(max(k, 1), len(x) - 2)
    near = slice(middle - 1, middle + 2)
    fine = np.linspace(x[k], x[k + 1], 201)
    values = np.polyval(np.polyfit(x[near] - x[k], y[near], 2), fine - x[k])
    return float(fine[np.argmin(np.abs(values))])
