"""Randomly drawn spans, and the nonlinear simulation that `modal.screen` is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

import gallop_fmu as gf
import modal
from gallop_fmu.simulation.result import dominant_frequency

SEED = 2009
"""Seed of the scenes on which the screening was developed."""

ELEMENTS, TIME_STEP = 10, 0.02
"""Elements and time step [s]: amplitudes are within 1 % of those of a finer mesh and step."""

Times = tuple[float, float]
"""Simulated time [s] before the push, in which galloping settles, and after it."""

BISECTION: Times = (1000.0, 350.0)
BISECTION_REPEAT: Times = (2500.0, 350.0)
FULL_RUN: Times = (400.0, 1200.0)
FULL_RUN_REPEAT: Times = (400.0, 4600.0)
"""Times of a run of the bisection and of a run at the scene's wind; the repeats are for runs whose
amplitude has not settled."""

MAX_CHANGE = 0.01
"""Relative change of the vertical amplitude between two windows above which a run is repeated."""

DYING_RATIO = 0.9
"""Ratio of the vertical amplitudes in the last two windows below which a motion dies out."""

PUSH = 1.0
"""Transverse force [N] at mid-span for half a second; it starts a swing of one or two mm."""

VERTICAL_SEED, SWING_SEED = 0.15, 2e-3
"""Initial vertical speed over the wind speed (a third of the final one); initial swing [m]."""

BEAT_WINDOW = 600.0
"""Time [s] over which the amplitudes of a beating motion are read."""

MIN_SWING = 5e-3
"""Amplitude [m] at about half the vertical frequency above which the swing has started."""

MIN_GROWN_SWING = 3e-4
"""Amplitude [m] above which a growing swing has started: above spectral leakage."""

MAX_ASYMMETRY = 0.02
"""Difference of the quarter points over the motion, above which symmetry is lost."""


def sprung(stiffness_x1: float, stiffness_x3: float) -> dict[str, object]:
    """Support with springs [N/m]."""
    return {"kind": "springs", "stiffness_x1": stiffness_x1, "stiffness_x3": stiffness_x3}


def drawn_scene(draw: np.random.Generator) -> gf.Scene:
    """Draw a variation of example 3 (windward ice, rather slack) or 2 (rather taut)."""
    like = gf.load_scene("example3" if draw.random() < 0.75 else "example2")
    length = like.span.length * draw.uniform(0.8, 1.3)
    sag = draw.uniform(0.012, 0.024) * length
    mass = like.conductor.mass_per_length * draw.uniform(0.8, 1.2)
    tension = mass * 9.81 * length**2 / (8.0 * sag)
    lift, drag, moment = -draw.uniform(2.5, 5.0), draw.uniform(0.8, 1.6), draw.uniform(-0.3, 0.1)
    cubic = draw.uniform(1.5, 3.5)
    centre = 180.0 if like.ice.attack_angle_deg == 180.0 else 0.0
    angle = centre + draw.uniform(-8.0, 8.0)
    ratio = draw.uniform(0.004, 0.02)
    pair = {"low_ratio": ratio, "low_frequency": 0.38, "high_ratio": ratio, "high_frequency": 0.7}
    end: dict[str, object] = {"kind": "rigid"}
    if draw.random() < 0.4:
        end = sprung(float(10.0 ** draw.uniform(4.7, 6.7)), float(10.0 ** draw.uniform(3.0, 6.0)))
    # Den Hartog's critical wind of one vertical degree of freedom at 0.6 Hz, times a factor.
    feed = -(lift + drag) * 1.2929 * like.conductor.diameter / (8.0 * math.pi * 0.6 * mass)
    wind = draw.uniform(0.9, 2.2) * ratio / feed
    return like.with_values({
        "span": {"length": length, "horizontal_tension": tension},
        "conductor.mass_per_length": mass,
        "damping.translation": pair,
        "aerodynamics.centre_deg": centre,
        "aerodynamics.valid_from_deg": centre - 80.0,
        "aerodynamics.valid_to_deg": centre + 80.0,
        "aerodynamics.lift": [0.0, lift, 0.0, cubic],
        "aerodynamics.drag": [drag, 0.0, 0.5],
        "aerodynamics.moment": [0.0, moment, 0.0, 0.1],
        "ice.attack_angle_deg": angle,
        "supports": {"left": end, "right": end},
        "wind.speed": wind,
    })  # fmt: skip


@dataclass(frozen=True)
class Motion:
    """Motion at the end of a run.

    Amplitudes [m] at mid-span, whether the span swings, whether it beats, whether it is dying out,
    and the time [s] at which it lost its symmetry about mid-span.
    """

    vertical: float
    horizontal: float
    swings: bool
    beats: bool
    dying: bool
    antisymmetric_from: float | None


def swing_part(t: np.ndarray, u2: np.ndarray, u3: np.ndarray) -> float:
    """Largest spectral line [m] of u3 around half the vertical frequency."""
    interval = float(t[1] - t[0])
    # Blackman's side lobes fall fast, as the vertical frequency is a hundred times stronger.
    window = np.blackman(len(t))
    frequency = np.fft.rfftfreq(8 * len(t), interval)
    vertical = dominant_frequency(u2, interval)
    deviation = (u3 - u3 @ window / window.sum()) * window
    spectrum = np.abs(np.fft.rfft(deviation, 8 * len(t))) * 2.0 / window.sum()
    near = (frequency > 0.4 * vertical) & (frequency < 0.6 * vertical)
    return float(np.max(spectrum[near], initial=0.0))


def simulated(scene: gf.Scene, wind: float, times: Times) -> Motion:
    """Simulate a scene at a wind speed [m/s] with the nonlinear model.

    Galloping settles, then a small push starts a swing, which grows or dies out. In the bisection
    the amplitudes are those before the push, in the full run those at the end. Round-off makes some
    symmetric motions antisymmetric after a long time, which is no 2:1 resonance any more:
    amplitudes are read before that.
    """
    before_push, after_push = times
    brief = times in (BISECTION, BISECTION_REPEAT)
    t, (left, u2, right), u3 = _histories(scene, wind, times)
    stop_time = before_push + after_push
    asymmetric = np.abs(left - right) > MAX_ASYMMETRY * np.max(np.abs(u2)) + 1e-4
    until = float(t[np.argmax(asymmetric)]) if asymmetric.any() else stop_time

    starts = np.arange(before_push + 1.0, min(stop_time, until) - 59.0, 30.0)
    windows = [(t >= start) & (t < start + 60.0) for start in starts]
    swing = np.array([swing_part(t[window], u2[window], u3[window]) for window in windows] or [0.0])
    grows = swing[-1] > 1.2 * swing[0] and swing[-1] > MIN_GROWN_SWING
    large = swing.max() > MIN_SWING
    beats = bool(len(swing) > 6 and np.ptp(swing[-6:]) > 0.1 * swing[-1] and large)

    end = before_push if brief else until
    length = 60.0 if brief else BEAT_WINDOW if beats else 100.0
    shift = 100.0 if brief else length
    last = (t > end - length) & (t <= end)
    earlier = (t > end - length - shift) & (t <= end - shift)
    vertical, previous = (
        0.5 * float(np.ptp(u2[window])) if window.any() else 0.0 for window in (last, earlier)
    )
    unsettled = abs(vertical - previous) > MAX_CHANGE * previous and previous > MIN_SWING
    if unsettled and (times == BISECTION or (times == FULL_RUN and beats and not asymmetric.any())):
        again = simulated(scene, wind, BISECTION_REPEAT if times == BISECTION else FULL_RUN_REPEAT)
        if again.antisymmetric_from is None or times == FULL_RUN:
            return again
    return Motion(
        vertical,
        0.5 * float(np.ptp(u3[last])),
        bool(grows or large),
        beats,
        vertical < max(DYING_RATIO * previous, 1e-3),
        until if asymmetric.any() else None,
    )


def _histories(
    scene: gf.Scene, wind: float, times: Times
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], u2 [m] at both quarter points and mid-span, and u3 [m] at mid-span."""
    before_push, after_push = times
    vertical = modal.frequency_ratio(scene).vertical_hz
    law = {"kind": "pulse", "peak": 1.0, "start": before_push, "rise": 0.25,
           "fall_start": before_push + 0.25, "fall": 0.25}  # fmt: skip
    pushed = scene.with_values({
        "wind.speed": wind, "numerics.elements": ELEMENTS, "numerics.time_step": TIME_STEP,
        "initial.seed_vertical": -VERTICAL_SEED * wind / (2.0 * math.pi * vertical),
        "initial.seed_horizontal": SWING_SEED,
        "loads": [{"force": [0.0, 0.0, PUSH], "position": 0.5, "law": law}],
    })  # fmt: skip
    quarter = ELEMENTS // 2
    data = gf.simulate(
        pushed,
        stop_time=before_push + after_push,
        record_every=4,
        record_nodes=[quarter, ELEMENTS, 2 * ELEMENTS - quarter],
    ).dataset
    return data.time.values, data.u2.values.T, data.u3.values[:, 1]


@dataclass(frozen=True)
class End:
    """End of a long run with a push that is not symmetric.

    Largest amplitudes [m] at mid-span in the last third, of the antisymmetric part at the quarter
    points, mean twist [rad] at mid-span, relative change of the largest amplitude from the middle
    third to the last one, and the part at half the vertical frequency [m].
    """

    vertical: float
    horizontal: float
    quarter: float
    twist: float
    change: float
    swing: float


ANTISYMMETRIC_PUSH = 20.0
"""Force [N], up and with the wind, at 0.3 of the span for half a second."""


def ended(scene: gf.Scene, seed: float, swing: float, duration: float) -> End:
    """Simulate a scene at its wind for a duration [s] from a vertical and a horizontal seed [m]."""
    law = {"kind": "pulse", "peak": 1.0, "start": 5.0, "rise": 0.25,
           "fall_start": 5.25, "fall": 0.25}  # fmt: skip
    force = [0.0, ANTISYMMETRIC_PUSH, ANTISYMMETRIC_PUSH]
    pushed = scene.with_values({
        "numerics.elements": ELEMENTS, "numerics.time_step": TIME_STEP,
        "initial.seed_vertical": seed, "initial.seed_horizontal": swing,
        "loads": [{"force": force, "position": 0.3, "law": law}],
    })  # fmt: skip
    quarter = ELEMENTS // 2
    data = gf.simulate(
        pushed,
        stop_time=duration,
        record_every=8,
        record_nodes=[quarter, ELEMENTS, 2 * ELEMENTS - quarter],
    ).dataset
    t, u2, u3 = data.time.values, data.u2.values, data.u3.values[:, 1]
    series = (u2[:, 1], u3, 0.5 * (u2[:, 0] - u2[:, 2]))
    thirds = [t > duration * 2.0 / 3.0, (t > duration / 3.0) & (t <= duration * 2.0 / 3.0)]
    late, before = ([0.5 * float(np.ptp(one[part])) for one in series] for part in thirds)
    largest = max(late)
    last = thirds[0]
    main = series[0] if late[0] >= late[2] else series[2]
    return End(
        *late,
        float(data.theta.values[last, 1].mean()),
        max(abs(a - b) for a, b in zip(late, before, strict=True)) / max(largest, 1e-3),
        swing_part(t[last], main[last], u3[last]),
    )
