"""Compares `modal.screen` with the nonlinear model on drawn scenes; prints a Markdown table.

Usage: OPENBLAS_NUM_THREADS=1 python benchmarks/accuracy/screening_table.py [SEED] >
benchmarks/accuracy/screening_table.md (a few minutes on two cores; with one thread for linear algebra the
CPU times are those of one core).

The scenes are not picked: a seeded generator varies length, sag, mass, ends, damping, coefficient
curve, attack angle and wind around the second and third example of Liu, Yan, Zhang, Zhou (2009);
both of these, example 3 below its onset and its sprung control come first. The nonlinear model
knows nothing of the prediction but where to begin its bisection.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

import gallop_fmu as gf
import modal
from gallop_fmu.simulation.result import dominant_frequency

Found = TypeVar("Found")

SEED, DRAWN = 2009, 22
ELEMENTS, TIME_STEP = 10, 0.02
"""Of the nonlinear model: amplitudes within 1 % of a finer mesh and step."""

BRIEF, PATIENT, LONG, LONGER = (1000.0, 350.0), (2500.0, 350.0), (400.0, 1200.0), (400.0, 4600.0)
"""Simulated time [s] for galloping to settle before the swing is kicked, and after the kick: of the runs of the
bisection, of those again that have not settled, and of the run at the scene's wind, which shows
what both settle in;
again longer where the swing comes and goes and has not settled."""

SETTLED = 0.01
"""Relative change of the vertical amplitude in the last 100 s before the kick, or of a swing that comes and goes from
one `BEAT` to the next, above which a run is repeated."""

DYING = 0.9
"""Vertical amplitude in the last window, relative to the one before, below which a motion is dying out."""

KICK = 1.0
"""Force [N] across the line at mid-span for half a second; the swing that it starts is of a millimetre or two."""

NARROW = 0.001
"""Relative width at which the bisection for the onset ends."""

VERTICAL_SEED, SWING_SEED = 0.15, 2e-3
"""Vertical start as a speed over the wind speed (a third of what galloping reaches), horizontal start [m]."""

BEAT = 600.0
"""Time [s] over which the amplitudes of a swing that comes and goes are read."""

LEAST_SWING = 5e-3
"""Amplitude [m] around half the vertical frequency above which the swing has started in any case."""

LEAST_GROWN = 3e-4
"""Amplitude [m] from which a growing swing has started; the kick is larger, spectral leakage smaller."""

LEAST_MOTION = 0.05
"""Vertical amplitude [m] below which the relative error says nothing: a start that has not quite died out yet."""

MIRROR = 0.02
"""Difference of the two quarter points, in parts of the motion, from which a motion is no longer its mirror image."""


def sprung(stiffness_x1: float, stiffness_x3: float) -> dict[str, object]:
    return {"kind": "springs", "stiffness_x1": stiffness_x1, "stiffness_x3": stiffness_x3}


def fixed_scenes() -> list[tuple[str, gf.Scene]]:
    third = gf.load_scene("example3")
    spring = sprung(75.97e3, 1e9)
    return [
        ("example 3", third),
        ("example 3, 5.0 m/s", third.with_values({"wind.speed": 5.0})),
        (
            "example 3, springs",
            third.with_values({"supports.left": spring, "supports.right": spring}),
        ),
        ("example 2", gf.load_scene("example2")),
    ]


def drawn_scene(draw: np.random.Generator) -> gf.Scene:
    """A span like example 3 (windward ice, rather slack) or example 2 (rather taut), everything that matters varied."""
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
    # Den Hartog's critical wind of one vertical degree of freedom at a frequency of 0.6 Hz, times a
    # factor
    feed = -(lift + drag) * 1.2929 * like.conductor.diameter / (8.0 * math.pi * 0.6 * mass)
    wind = draw.uniform(0.9, 2.2) * ratio / feed
    return like.with_values(
        {
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
        }
    )


@dataclass(frozen=True)
class Motion:
    """What a run ends in.

    Amplitudes [m] at mid-span, whether it swings, whether it comes and goes, whether it is dying
    out, and when [s] it lost its mirror symmetry.
    """

    vertical: float
    horizontal: float
    swings: bool
    beats: bool
    dying: bool
    lopsided_from: float | None


def swing_part(t: np.ndarray, u2: np.ndarray, u3: np.ndarray) -> float:
    """Largest spectral line [m] of u3 around half the vertical frequency."""
    interval = float(t[1] - t[0])
    window = np.blackman(
        len(t)
    )  # its side lobes fall fast: the vertical frequency is a hundred times stronger
    frequency = np.fft.rfftfreq(8 * len(t), interval)
    vertical = dominant_frequency(u2, interval)
    spectrum = (
        np.abs(np.fft.rfft((u3 - u3 @ window / window.sum()) * window, 8 * len(t)))
        * 2.0
        / window.sum()
    )
    return float(
        np.max(spectrum[(frequency > 0.4 * vertical) & (frequency < 0.6 * vertical)], initial=0.0)
    )


def simulated(scene: gf.Scene, wind: float, times: tuple[float, float]) -> Motion:
    """The nonlinear model at a wind speed.

    Galloping settles, the swing is kicked and either grows or dies out. In the bisection the
    amplitudes are those before the kick, in the long run those that both settle in. Round-off lets
    some symmetric motions turn lopsided after a long time, which is no 2:1 resonance any more:
    amplitudes are read before that.
    """
    given = scene
    calm, watched = times
    brief = times not in (LONG, LONGER)
    vertical = modal.frequency_ratio(scene).vertical_hz
    law = {
        "kind": "pulse",
        "peak": 1.0,
        "start": calm,
        "rise": 0.25,
        "fall_start": calm + 0.25,
        "fall": 0.25,
    }
    push = {"force": [0.0, 0.0, KICK], "position": 0.5, "law": law}
    scene = scene.with_values(
        {
            "wind.speed": wind, "numerics.elements": ELEMENTS, "numerics.time_step": TIME_STEP,
            "initial.seed_vertical": -VERTICAL_SEED * wind / (2.0 * math.pi * vertical),
            "initial.seed_horizontal": SWING_SEED, "loads": [push],
        }
    )  # fmt: skip
    stop_time = calm + watched
    quarter = ELEMENTS // 2
    nodes = [quarter, ELEMENTS, 2 * ELEMENTS - quarter]
    data = gf.simulate(scene, stop_time=stop_time, record_every=4, record_nodes=nodes).dataset
    t, (left, u2, right), u3 = data.time.values, data.u2.values.T, data.u3.values[:, 1]
    lopsided = np.abs(left - right) > MIRROR * np.max(np.abs(u2)) + 1e-4
    until = float(t[np.argmax(lopsided)]) if lopsided.any() else stop_time
    starts = np.arange(calm + 1.0, min(stop_time, until) - 59.0, 30.0)
    windows = [(t >= start) & (t < start + 60.0) for start in starts]
    swing = np.array([swing_part(t[window], u2[window], u3[window]) for window in windows] or [0.0])
    grows = swing[-1] > 1.2 * swing[0] and swing[-1] > LEAST_GROWN
    starts_swing = bool(grows or swing.max() > LEAST_SWING)
    beats = len(swing) > 6 and bool(
        np.ptp(swing[-6:]) > 0.1 * swing[-1] and swing.max() > LEAST_SWING
    )
    end = calm if brief else until
    length = 60.0 if brief else BEAT if beats else 100.0
    steady = (t > end - length) & (t <= end)
    earlier = (
        (t > end - length - 100.0) & (t <= end - 100.0)
        if brief
        else (t > end - 2.0 * length) & (t <= end - length)
    )
    vertical, before = (
        0.5 * float(np.ptp(u2[window])) if window.any() else 0.0 for window in (steady, earlier)
    )
    unsettled = abs(vertical - before) > SETTLED * before and before > LEAST_SWING
    if unsettled and (times == BRIEF or (times == LONG and beats and not lopsided.any())):
        patient = simulated(given, wind, PATIENT if times == BRIEF else LONGER)
        if patient.lopsided_from is None or times == LONG:
            return patient
    dying = vertical < max(DYING * before, 1e-3)
    return Motion(
        vertical,
        0.5 * float(np.ptp(u3[steady])),
        starts_swing,
        beats,
        dying,
        until if lopsided.any() else None,
    )


def bisected(scene: gf.Scene, guess: float, highest: float) -> tuple[float, float] | None:
    """Onset wind speed [m/s] of the swing in the nonlinear model, and vertical amplitude [m] there.

    Between the winds without swing the square of the amplitude is close to linear, as behind any
    onset of galloping.
    """
    calm: dict[float, float] = {}
    low, high = 0.96 * guess, 1.04 * guess
    below, above = simulated(scene, low, BRIEF), simulated(scene, high, BRIEF)
    while below.swings:
        high, low = low, 0.92 * low
        below = simulated(scene, low, BRIEF)
    calm[low] = below.vertical
    while not above.swings:
        calm[high] = above.vertical
        low, high = high, 1.08 * high
        if high > highest:
            return None
        above = simulated(scene, high, BRIEF)
    while high - low > NARROW * high:
        middle = 0.5 * (low + high)
        motion = simulated(scene, middle, BRIEF)
        if motion.swings:
            high = middle
        else:
            low = middle
            calm[low] = motion.vertical
    onset = 0.5 * (low + high)
    winds = sorted(calm)[-2:]
    if len(winds) == 1:
        return onset, calm[low]
    slope = (calm[winds[1]] ** 2 - calm[winds[0]] ** 2) / (winds[1] - winds[0])
    return onset, math.sqrt(calm[winds[1]] ** 2 + slope * (onset - winds[1]))


@dataclass(frozen=True)
class Row:
    """One scene: prediction and nonlinear model."""

    name: str
    cells: tuple[str, ...]
    verdict: str  # right, miss, false alarm, refused, or no reference
    seconds: tuple[float, float]  # CPU time of the screening and of the two-mode estimate
    errors: tuple[float | None, float | None, float | None, float | None] = (None,) * 4
    """Onset, threshold, vertical, horizontal."""
    left: Motion | None = None  # what the nonlinear model does where no galloping is foretold


def timed(function: Callable[[gf.Scene], Found], scene: gf.Scene) -> tuple[Found, float]:
    """What a function finds and the CPU time [s] that it took, least of three."""
    times = []
    for _ in range(3):
        began = time.thread_time()
        found = function(scene)
        times.append(time.thread_time() - began)
    return found, min(times)


def compared(name: str, scene: gf.Scene) -> Row:
    wind = scene.wind.mean_speed
    try:
        found, whole = timed(modal.screen, scene)
        seconds = whole, timed(modal.two_mode_estimate, scene)[1]
    except gf.SceneError as error:
        return Row(name, (f"{wind:.2f}", *[""] * 7, f"refused: {error}"), "refused", (0.0, 0.0))
    took = f"{seconds[0]:.2f}"
    start = (f"{wind:.2f}", f"{found.frequencies.ratio:.3f}", found.risk)
    if found.risk == "undetermined":
        return Row(name, (*start, *[""] * 5, took, found.reason), "refused", seconds)
    try:
        motion = simulated(scene, wind, LONG)
        onset = None
        if found.onset_wind_speed is not None:
            onset = bisected(scene, found.onset_wind_speed, 1.5 * wind)
    except gf.SimulationError as error:
        return Row(
            name, (*start, *[""] * 5, took, f"no reference: {error}"), "no reference", seconds
        )
    verdict = {
        (True, True): "right",
        (False, False): "right",
        (False, True): "miss",
        (True, False): "false alarm",
    }[found.swings, motion.swings]
    galloping = found.saturated if found.swings else found.galloping
    vertical, horizontal = (galloping.vertical, galloping.horizontal) if galloping else (0.0, 0.0)

    def deviation(predicted: float | None, reference: float | None, least: float) -> float | None:
        if predicted is None or reference is None or reference < least:
            return None
        return predicted / reference - 1.0

    errors = (
        deviation(found.onset_wind_speed, onset and onset[0], 0.0),
        deviation(found.threshold_amplitude, onset and onset[1], 0.0),
        deviation(vertical, motion.vertical, LEAST_MOTION) if galloping else None,
        deviation(horizontal, motion.horizontal, LEAST_SWING) if motion.swings else None,
    )
    notes = [
        "comes and goes" * motion.beats,
        "dies out" * (motion.dying and galloping is None),
        "" if motion.lopsided_from is None else f"lopsided from {motion.lopsided_from:.0f} s on",
    ]
    note = ", ".join(word for word in notes if word)
    cells = (
        *start,
        "yes" if motion.swings else "no",
        pair(found.onset_wind_speed, onset and onset[0], errors[0]),
        pair(found.threshold_amplitude, onset and onset[1], errors[1]),
        f"{vertical:.3f}/{horizontal:.3f} : {motion.vertical:.3f}/{motion.horizontal:.3f}",
        estimated(found.estimate),
        took,
        verdict + (f" ({note})" if note else ""),
    )
    return Row(name, cells, verdict, seconds, errors, None if galloping else motion)


def estimated(estimate: modal.TwoMode) -> str:
    onset, threshold = estimate.onset_wind_speed, estimate.threshold_amplitude
    return "" if onset is None or threshold is None else f"{threshold:.3f} m, {onset:.2f} m/s"


def pair(predicted: float | None, reference: float | None, error: float | None) -> str:
    if predicted is None:
        return ""
    if reference is None or error is None:
        return f"{predicted:.3f} : none"
    return f"{predicted:.3f} : {reference:.3f} ({error:+.1%})"


def reported(row: Row) -> Row:
    """Shows on the terminal how far it is."""
    print(row.name, *row.cells, sep=" | ", file=sys.stderr)
    return row


EXPLANATION = f"""Pairs read `modal.screen` : nonlinear model; the two-mode estimate stands beside them.

- The swing of the nonlinear model is kicked by {KICK:g} N into settled galloping. Its onset is bisected to
  {NARROW:.1%}, and its threshold is the vertical amplitude extrapolated to there. Close above the critical wind the
  amplitude rises steeply and settles slowly, so the threshold of the nonlinear model is itself uncertain by some per
  cent where the onset follows the critical wind closely.
- "lopsided from": round-off has grown until the motion was no longer symmetric about mid-span (two-loop galloping
  takes part); amplitudes are read before that. `lopsided_growth` of the screening foretells it.
- "comes and goes": both columns give the largest amplitudes of some hundred seconds.
- Where no galloping is predicted there is no relative error: the nonlinear model shows what is left of its start, or
  two-loop galloping, and is counted by itself below the table.
- CPU is that of `modal.screen` on one core in seconds, the least of three calls.
"""

HEAD = ("Scene", "Wind, m/s", "f_v/f_h", "Risk", "Swings", "Onset wind, m/s", "Threshold, m",
        "Steady vertical/horizontal, m", "Two-mode estimate", "CPU, s", "Verdict")  # fmt: skip


def main() -> None:
    began = time.perf_counter()
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else SEED
    draw = np.random.default_rng(seed)
    scenes = fixed_scenes() + [
        (f"drawn {number}", drawn_scene(draw)) for number in range(1, DRAWN + 1)
    ]
    modal.screen(scenes[0][1])  # imports take their time once
    with ThreadPoolExecutor(2) as pool:
        rows = list(pool.map(lambda item: reported(compared(*item)), scenes))
    print(f"# Screening against the nonlinear model: seed {seed}\n")
    print((__doc__ or "").split("\n\n", 2)[2])
    print(EXPLANATION)
    print("| " + " | ".join(HEAD) + " |\n|" + " --- |" * len(HEAD))
    for row in rows:
        print(f"| {row.name} | " + " | ".join(row.cells) + " |")
    print()
    summarise(rows)
    print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)


def summarise(rows: list[Row]) -> None:
    """Print the counts and the largest errors."""
    for verdict in ("right", "miss", "false alarm", "refused", "no reference"):
        print(f"- {verdict}: {sum(row.verdict == verdict for row in rows)}")
    for index, (name, allowed) in enumerate(
        (("onset wind", 0.05), ("threshold", 0.1), ("vertical", 0.15), ("horizontal", 0.15))
    ):
        errors = [abs(row.errors[index]) for row in rows if row.errors[index] is not None]  # type: ignore[arg-type]
        if errors:
            print(
                f"- {name}: largest error {max(errors):.1%}, median {np.median(errors):.1%}, "
                f"{sum(error > allowed for error in errors)} of {len(errors)} above {allowed:.0%}"
            )
    calm = [(row.name, row.left) for row in rows if row.left is not None]
    moving = [f"{name} by {left.vertical:.3f} m" for name, left in calm if not left.dying]
    told = f"all but {', '.join(moving)}" if moving else "all"
    print(f"- no galloping foretold: {len(calm)}, of which {told} die out in the nonlinear model")
    for name, index in (("screening", 0), ("two-mode estimate", 1)):
        times = [1e3 * row.seconds[index] for row in rows]
        print(
            f"- CPU time of the {name}: at most {max(times):.0f} ms, median"
            f" {np.median(times):.0f} ms"
        )


if __name__ == "__main__":
    main()
