"""Closed-form estimate of the 2:1 resonance from the first symmetric pair of modes.

Vertical galloping of amplitude a and angular frequency W changes the tension, and with it the
stiffness of the first symmetric horizontal mode. Its coordinate q obeys Mathieu's equation

    q'' + 2 xi w q' + w^2 (1 + e cos W t) q = 0,    e = m a,                                     (1)

where w is the horizontal frequency, xi the damping ratio (structure and wind) and m the relative
change of stiffness per metre (`Coupling.modulation`). Near W = 2 w the solution q = 0 loses its
stability, and the swing starts, above (Nayfeh and Mook 1979, section 5.3)

    e = 4 sqrt(xi^2 + D^2),    D = W / (2 w) - 1.                                                (2)

W and w depend on a; the corrections of order a^2 follow from a perturbation expansion
(`quadratic_coupling`). The amplitude of galloping without swing follows from the balance of energy
over one cycle (`_cycle`).
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from gallop_fmu.input.scene_like import SpanLike, as_span
from modal.foundation import one_span as instead
from modal.foundation.normal_wind import check_wind_is_normal
from modal.foundation.one_thread import one_thread
from modal.linear.mode_basis import (
    TANGENT_STEP,
    StillAirModes,
    stiffness_derivative,
    still_air_modes,
)
from modal.motions.reduced_model import ReducedModel
from modal.stability.mode_pairs import MAX_SPEED_RATIO

Array = NDArray[np.float64]

MESH_ELEMENTS = 6
"""Elements of the mesh; both mode shapes are much wider than an element."""

CYCLE_INSTANTS = 12
"""Instants of a cycle in the energy balance; more instants change the result by less than 0.1 %."""

AMPLITUDE_POINTS, WIND_POINTS = 16, 24
"""Amplitudes and wind speeds at which the energy balance is evaluated.

Both are denser towards 0, so that small limit cycles and low onsets are found: the smallest is
1/256 and 1/576 of the largest.
"""

REFINED_POINTS = 6
"""Amplitudes between two of these that contain a limit cycle."""

FINE_POINTS = 201
"""Points between two of these at which an interpolating parabola or line is evaluated."""

TWIST_ITERATIONS = 3
"""Fixed-point iterations for the quasi-static twist; each reduces the error about tenfold."""

SECOND_STEP_RATIO = 1e3
"""Step of the second difference of the tangent along the vertical mode, in units of `TANGENT_STEP`.

The tangent is quadratic in the displacement, so that any step is exact but for rounding.
"""

MIN_FREQUENCY_SQUARED = 1e-12
"""Lower bound of the squared horizontal frequency [rad2/s2] at large amplitudes."""


@dataclass(frozen=True)
class Coupling:
    """Quadratic coupling of the first symmetric pair of modes, and the frequency corrections.

    Attributes
    ----------
    modulation : float
        Relative change of the horizontal stiffness w^2 per metre of vertical mid-span displacement
        [1/m]. In a shallow span this is the dynamic tension per metre over the static tension.
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
    """Closed-form estimate of the 2:1 resonance.

    Attributes
    ----------
    coupling : Coupling
        Quadratic coupling of the pair.
    swing_damping : float
        Damping ratio of the swing (structure and wind) at the wind speed of the estimate.
    threshold_amplitude : float or None
        Vertical amplitude [m] at mid-span that starts the swing; None if no amplitude in the range
        of the energy balance does.
    threshold_detuning : float or None
        Detuning D at that amplitude.
    vertical_amplitude : float
        Amplitude [m] of vertical galloping without swing at the scene's wind; 0 if galloping
        decays, infinite if the energy balance has no limit cycle.
    onset_wind_speed : float or None
        Wind speed [m/s] at which galloping reaches the threshold; None if it does not below the
        highest wind speed.
    seconds : float
        Computing time [s].
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
        """True if the vertical amplitude at the scene's wind exceeds the threshold."""
        return (
            self.threshold_amplitude is not None
            and self.vertical_amplitude > self.threshold_amplitude
        )


@one_thread
def quadratic_coupling(scene: SpanLike, rest: StillAirModes | None = None) -> Coupling:
    """Compute the quadratic coupling of the first symmetric pair, from the kernel's tangent.

    Parameters
    ----------
    scene
        The span.
    rest
        Matrices and modes of the span in still air; None computes them.

    Returns
    -------
    Coupling
        Modulation and frequency corrections, per metre of vertical mid-span displacement.

    Notes
    -----
    Let v and h be the mass-normalised vertical and horizontal mode, w_v and w_h their frequencies,
    M and K the matrices in still air. Along the vertical mode the tangent stiffness is

        K(a v) = K + a k1 + a^2/2 k2,    and    K1(u) = dK/du . u,    so that k1 = K1(v).        (3)

    *Vertical frequency.* Insert u = a v cos t + a^2/2 (u20 + u22 cos 2t), t = W time, into
    M u'' + K u + K1(u) u / 2 + K2(u, u) u / 6 = 0. Order a^2, with cos^2 t = (1 + cos 2t)/2:

        K u20 = -k1 v / 2,    (K - 4 w_v^2 M) u22 = -k1 v / 2.                                   (4)

    Order a^3, projected on v and cos t (no secular term):

        W^2 = w_v^2 + a^2 [ v . k1 (u20/2 + u22/4) + v . k2 v / 8 ].                             (5)

    *Horizontal frequency.* A small motion q h cos(t/2) on top of it has the stiffness

        K + a k1 cos t + a^2/2 [ K1(u20) + K1(u22) cos 2t + k2 cos^2 t ].

    Its mean in time contributes h . K1(u20) h / 2 + h . k2 h / 4. The term a k1 cos t excites all
    modes at 3/2 W, and all modes but h itself at W/2; their response acts back on h through the
    same term. With R(s) f the response of the modes to a force f at the squared frequency s,
    R(s) = sum of (x . f) x / (w_x^2 - s) over the modes x, R' the same sum without h, and W = w_v:

        w^2 = w_h^2 + a^2 [ h . K1(u20) h / 2 + h . k2 h / 4
                            - k1 h . (R(9/4 w_v^2) + R'(w_v^2/4)) k1 h / 4 ].                    (6)

    *Modulation.* The term of (1) itself is m = h . k1 h / w_h^2.

    Examples
    --------
    >>> import gallop_fmu as gf, modal
    >>> round(modal.quadratic_coupling(gf.load_scene("example3")).modulation, 2)
    -0.97
    """
    span = as_span(scene, "quadratic_coupling", instead.SCREENING)
    rest = still_air_modes(span) if rest is None else rest
    number_v, number_h = rest.first("vertical"), rest.first("horizontal")
    free = np.flatnonzero(rest.free)
    block = np.ix_(free, free)
    shapes = rest.shapes.reshape(len(rest.shapes), -1)[:, free]
    squares = rest.frequencies**2
    v, h = shapes[number_v], shapes[number_h]
    square_v, square_h = squares[number_v], squares[number_h]

    # (3)
    k1 = stiffness_derivative(rest, rest.shapes[number_v])[block]
    k2 = _second_derivative(rest, number_v, k1, block)

    def response(force: Array, square: float, without: int | None = None) -> Array:
        """R(square) force, or the same without one mode."""
        part = (shapes @ force) / (squares - square)
        if without is not None:
            part[without] = 0.0
        return np.asarray(shapes.T @ part)

    # (4) and (5)
    u20 = -response(0.5 * k1 @ v, 0.0)
    u22 = -response(0.5 * k1 @ v, 4.0 * square_v)
    vertical_curve = v @ k1 @ (0.5 * u20 + 0.25 * u22) + v @ k2 @ v / 8.0

    # (6)
    k1_u20 = stiffness_derivative(rest, _of_all_unknowns(rest, u20, free))[block]
    k1_h = k1 @ h
    back = response(k1_h, 2.25 * square_v) + response(k1_h, 0.25 * square_v, without=number_h)
    swing_curve = 0.5 * h @ k1_u20 @ h + 0.25 * h @ k2 @ h - 0.25 * k1_h @ back

    per_metre = 1.0 / rest.shapes[number_v, rest.model.middle, 1]
    return Coupling(
        modulation=float(h @ k1_h / square_h * per_metre),
        vertical_curve=float(vertical_curve * per_metre**2),
        swing_curve=float(swing_curve * per_metre**2),
    )


def _second_derivative(
    rest: StillAirModes, mode: int, k1: Array, block: tuple[NDArray[np.intp], ...]
) -> Array:
    """Second derivative k2 of the stiffness along a mode: K(a v) = K + a k1 + a^2/2 k2."""
    step = SECOND_STEP_RATIO * TANGENT_STEP
    displaced = rest.mesh.dense_tangent(step * rest.shapes[mode], stiffness=1.0)
    return np.asarray(2.0 * (displaced[block] - rest.stiffness[block] - step * k1) / step**2)


def _of_all_unknowns(rest: StillAirModes, u: Array, free: NDArray[np.intp]) -> Array:
    """Displacement (node, 4) from that of the free unknowns."""
    full = np.zeros(rest.free.size)
    full[free] = u
    return full.reshape(rest.mesh.free.shape)


@one_thread
def two_mode_estimate(
    scene: SpanLike, wind_speed: float | None = None, highest_wind: float | None = None
) -> TwoMode:
    """Estimate the threshold amplitude and the wind speed at which the swing starts.

    Parameters
    ----------
    scene
        The span; it needs a coefficient curve and structural damping.
    wind_speed
        Wind speed [m/s] of the estimate; None takes the scene's.
    highest_wind
        Highest wind speed [m/s] of the search for the onset; None takes 1.5 times `wind_speed`.

    Raises
    ------
    SceneError
        If the scene has no wind or no coefficient curve, or the pair of modes does not exist.
    """
    scene = as_span(scene, "two_mode_estimate", instead.SCREENING)
    wind = scene.wind.mean_speed if wind_speed is None else wind_speed
    return estimate(scene, wind, 1.5 * wind if highest_wind is None else highest_wind)


@dataclass(frozen=True)
class PairModel:
    """What an estimate needs of a span, at any wind speed: `pair_of` computes it.

    Attributes
    ----------
    model : ReducedModel
        The first symmetric vertical, horizontal and torsional mode.
    coupling : Coupling
        Quadratic coupling of the first two.
    swing_damping, swing_damping_by_wind : float
        Damping ratio of the second in still air, and its increase per m/s of wind.
    """

    model: ReducedModel
    coupling: Coupling
    swing_damping: float
    swing_damping_by_wind: float

    def swing(self, wind: float) -> _Swing:
        """Equation of the swing in a wind [m/s]."""
        damping = self.swing_damping + wind * self.swing_damping_by_wind
        return _Swing(self.model.frequencies[1], damping, self.coupling)


def pair_of(scene: Scene) -> PairModel:
    """Compute the modes of a span and their coupling."""
    rest = still_air_modes(scene, MESH_ELEMENTS)
    coupling = quadratic_coupling(scene, rest)
    chosen = [rest.first("vertical"), rest.first("horizontal"), rest.first("torsional")]
    model = ReducedModel(scene, rest, chosen, rest.shapes[chosen])
    still, windy = (_swing_damping(model, wind) for wind in (0.0, 1.0))
    return PairModel(model, coupling, still, windy - still)


def estimate(scene: Scene, wind: float, highest: float, pair: PairModel | None = None) -> TwoMode:
    """Compute `two_mode_estimate` at `wind`, with a search for the onset up to `highest` [m/s].

    A `pair` of the same span at another wind speed saves most of the time.
    """
    began = clock.perf_counter()
    check_wind_is_normal(scene, "the two-mode estimate", wind, oblique=True)
    if not wind > 0.0:
        raise SceneError(
            f"wind_speed = {wind} m/s: must be positive; give wind.speed or wind_speed"
        )
    pair = pair_of(scene) if pair is None else pair
    model, coupling = pair.model, pair.coupling
    swing = pair.swing(wind)

    largest = MAX_SPEED_RATIO * highest / model.frequencies[0]
    amplitudes = largest * (np.arange(1, AMPLITUDE_POINTS + 1) / AMPLITUDE_POINTS) ** 2
    power, squares = _cycle(model, coupling, amplitudes, np.full(AMPLITUDE_POINTS, wind))
    threshold = swing.threshold(amplitudes, squares)
    onset = None
    if threshold is not None:
        winds = highest * (np.arange(1, WIND_POINTS + 1) / WIND_POINTS) ** 2
        constant = np.full(WIND_POINTS, threshold[0])
        onset = _first_rise(winds, -_cycle(model, coupling, constant, winds)[0])

    # galloping grows while its cycle gains power, up to the amplitude at which it loses some
    within = amplitudes <= MAX_SPEED_RATIO * wind / model.frequencies[0]
    lasting = _rise(power[within])
    if lasting is None:
        galloping = 0.0 if power[0] > 0.0 else np.inf
    else:
        near = np.linspace(amplitudes[lasting], amplitudes[lasting + 1], REFINED_POINTS)
        refined = _cycle(model, coupling, near, np.full(REFINED_POINTS, wind))[0]
        galloping = _first_rise(near, refined) or float(amplitudes[lasting])
    return TwoMode(
        coupling=coupling,
        swing_damping=swing.damping,
        threshold_amplitude=None if threshold is None else threshold[0],
        threshold_detuning=None if threshold is None else threshold[1],
        vertical_amplitude=float(galloping),
        onset_wind_speed=onset,
        seconds=clock.perf_counter() - began,
    )


def _swing_damping(model: ReducedModel, wind: float) -> float:
    """Damping ratio of the horizontal mode (coordinate 1) in a wind [m/s]; linear in the wind.

    At rest the angle of the wind does not depend on its speed, so that the derivatives of the load
    by velocities are proportional to it.
    """
    still = np.zeros((1, 3))
    damping = model.forces(still, still, still, wind).damping[0, 1, 1]
    return float(damping / (2.0 * model.frequencies[1]))


@dataclass(frozen=True)
class _Swing:
    """The Mathieu equation (1) of the swing: frequency [rad/s], damping ratio, coupling."""

    frequency: float
    damping: float
    coupling: Coupling

    def excess(self, amplitude: Array, vertical_square: Array) -> tuple[Array, Array]:
        """Excess of the modulation e over its threshold, equation (2), and detuning D.

        Parameters
        ----------
        amplitude
            Vertical amplitude a [m].
        vertical_square
            Squared vertical frequency W^2 [rad2/s2] at that amplitude.
        """
        corrected = self.frequency**2 + self.coupling.swing_curve * amplitude**2
        frequency = np.sqrt(np.maximum(corrected, MIN_FREQUENCY_SQUARED))
        detuning = np.sqrt(np.maximum(vertical_square, 0.0)) / (2.0 * frequency) - 1.0
        # m refers to the uncorrected frequency
        relative = (self.frequency / frequency) ** 2
        modulation = np.abs(self.coupling.modulation) * amplitude * relative
        return modulation - 4.0 * np.hypot(self.damping, detuning), detuning

    def threshold(self, amplitude: Array, vertical_square: Array) -> tuple[float, float] | None:
        """Lowest amplitude [m] above the threshold and its detuning; None if there is none."""
        above = np.flatnonzero(self.excess(amplitude, vertical_square)[0] > 0.0)
        if not len(above):
            return None
        k = int(above[0])
        low = 0.0 if k == 0 else float(amplitude[k - 1])
        # between two points W^2 is nearly linear in the amplitude
        fine = np.linspace(low, amplitude[k], FINE_POINTS)[1:]
        excess, detuning = self.excess(fine, np.interp(fine, amplitude, vertical_square))
        first = int(np.argmax(excess > 0.0))
        return float(fine[first]), float(detuning[first])


def _cycle(
    model: ReducedModel, coupling: Coupling, amplitude: Array, wind: Array
) -> tuple[Array, Array]:
    """Mean power lost in a vertical cycle, and squared vertical frequency.

    For q = a cos(w_v t), with f the force on the vertical mode (structure, wind, ice):

        power = mean of f q',    W^2 = w_v^2 + 2 mean(f cos(w_v t)) / a + vertical_curve a^2.

    The twist follows wind, ice and its own stiffness without inertia.

    Parameters
    ----------
    model
        The vertical, horizontal and torsional mode (coordinates 0, 1, 2).
    coupling
        Of the pair.
    amplitude, wind : ndarray, shape (case,)
        Vertical amplitude [m] at mid-span and wind speed [m/s].

    Returns
    -------
    ndarray, ndarray, shape (case,)
        Power [W], negative if galloping grows, and W^2 [rad2/s2].
    """
    frequency = model.frequencies[0]
    phase = 2.0 * np.pi * np.arange(CYCLE_INSTANTS) / CYCLE_INSTANTS
    size = np.repeat(amplitude / model.middle[0, 1], CYCLE_INSTANTS)
    cosine, sine = np.tile(np.cos(phase), len(amplitude)), np.tile(np.sin(phase), len(amplitude))
    blowing = np.repeat(wind, CYCLE_INSTANTS)[:, None]
    q = np.zeros((len(size), 3))
    v, a = np.zeros_like(q), np.zeros_like(q)
    q[:, 0] = size * cosine
    v[:, 0] = -size * frequency * sine
    a[:, 0] = -size * frequency**2 * cosine

    for _ in range(TWIST_ITERATIONS):
        force = model.unstretched(q, v, a, blowing)
        q[:, 2] -= force[:, 2] / model.stiffness[2, 2]

    force = model.unstretched(q, v, a, blowing)
    power = np.mean((force[:, 0] * v[:, 0]).reshape(-1, CYCLE_INSTANTS), axis=1)
    in_phase = 2.0 * np.mean((force[:, 0] * cosine / size).reshape(-1, CYCLE_INSTANTS), axis=1)
    return power, frequency**2 + in_phase + coupling.vertical_curve * amplitude**2


def _rise(y: Array) -> int | None:
    """First point at which y is negative and at the next one not; None if there is none."""
    found = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
    return int(found[0]) if len(found) else None


def _first_rise(x: Array, y: Array) -> float | None:
    """First zero of y with positive slope, on the parabola through three points around it."""
    k = _rise(y)
    if k is None:
        return None
    middle = min(max(k, 1), len(x) - 2)
    (a, b, c), (at_a, at_b, at_c) = (one[middle - 1 : middle + 2].tolist() for one in (x, y))
    first, second = (at_b - at_a) / (b - a), (at_c - at_b) / (c - b)  # divided differences
    fine = np.linspace(x[k], x[k + 1], FINE_POINTS)
    values = at_a + (fine - a) * (first + (fine - b) * (second - first) / (c - a))
    return float(fine[np.argmin(np.abs(values))])
