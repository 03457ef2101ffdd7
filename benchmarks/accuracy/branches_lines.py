"""All motions of lines over the wind speed, against simulations with the full model.

Prints, for spans of example 2 (a reconstructed curve):

- a section of one span between rigid ends beside the same span as a scene of one span;
- a section of three spans on strings: motions, and the wind in which its strings begin to swing,
  beside that of simulations that start on the motion with a small sideways disturbance;
- a twin bundle in 4.1 m/s beside a lumped explicit chain written apart from this project;
- CPU times of the motions of sections of three and five spans and of a quad bundle, of their
  equilibria and onsets alone, and of their screening.

Usage: python benchmarks/accuracy/branches_lines.py [one|three|twin|times ...] (about four minutes)
"""

import math
import sys
import time

import numpy as np

import gallop_fmu as gf
import modal
from gallop_fmu import Model
from gallop_fmu.scene.line_scene import LineScene
from modal.continuation.path import Settings
from modal.continuation.starts import equilibria
from modal.foundation.one_thread import one_thread
from modal.motions.full_model import CHANNELS, full_scene
from modal.motions.motion_models import motion_model
from modal.motions.span_problem import SpanProblem, WindFamily

ONE_SPAN = gf.load_scene("example2").model_dump(mode="json", exclude_none=True)
STRING = {"kind": "string", "length": 2.1, "weight": 490.0}
LOWEST, WIND, HIGHEST = 0.3, 4.1, 4.2
"""Range [m/s] of the branches, and the wind of the tables."""

SEED, RECORD, WINDOW, FIRST_RECORD = 1e-5, 0.1, 400, 500
"""Sideways disturbance [m]; interval [s] of records; records in the window of one amplitude; first
record of the first window."""

SWING_HZ = (0.2, 0.34)
"""Band [Hz] in which the swing of the strings is measured."""


def damping(rate, low, high):
    """Two ratios at two frequencies that make a damping in proportion to the mass alone [1/s]."""
    pairs = (("low_ratio", "low_frequency", low), ("high_ratio", "high_frequency", high))
    return {
        key: value
        for ratio, frequency, hertz in pairs
        for key, value in ((ratio, rate / (4.0 * math.pi * hertz)), (frequency, hertz))
    }


DAMPING = {"translation": damping(0.0044, 0.275, 0.55), "twist": damping(2.52, 5.29, 10.58)}


def section(spans, elements=10, **parts):
    """Make a section of so many spans; `parts` are more sections of the scene, such as bundle."""
    return LineScene.from_dict(
        {name: ONE_SPAN[name] for name in ("conductor", "ice", "wind", "aerodynamics")}
        | {
            "title": f"{spans} spans of example 2",
            "section": {
                "horizontal_tension": 21730.0,
                "strung_with_ice": True,
                "spans": [{"length": 125.88}] * spans,
                "suspensions": [STRING] * (spans - 1),
            },
            "damping": DAMPING,
            "numerics": {"elements": elements, "time_step": 0.01},
        }
        | parts
    )


def bundle(subconductors):
    """Bundle of so many subconductors, 400 mm apart, with four spacers a span."""
    return {
        "subconductors": subconductors,
        "spacing": 0.4,
        "spacers": 4,
        "clamp_torsional_stiffness": 500.0,
    }


def amplitudes(found, number, wind):
    """Amplitudes of a branch in a wind, interpolated: u2, u3 [m], theta [rad], clamps [m]."""
    data = found.dataset
    at = data.isel(point=np.flatnonzero(data.branch_of_point.values == number)).sortby("value")
    names = ("u2_amplitude", "u3_amplitude", "theta_amplitude", "clamp_amplitude")
    return [float(np.interp(wind, at.value.values, at[name].values)) for name in names]


def number_of(found, name):
    """Number of the first branch with a name."""
    return found.dataset["name"].values.tolist().index(name)


def one():
    """Print a section of one span beside the span."""
    span = gf.Scene.from_dict(
        {name: ONE_SPAN[name] for name in ("conductor", "ice", "wind", "aerodynamics")}
        | {
            "title": "a span of example 2",
            "span": {"length": 125.88, "horizontal_tension": 21730.0},
            "damping": DAMPING,
            "numerics": {"elements": 10, "time_step": 0.01},
        }
    )
    for scene in (span, section(1)):
        found = modal.branches(scene, "wind.speed", LOWEST, HIGHEST)
        u2, u3, theta, _ = amplitudes(found, number_of(found, "one loop"), WIND)
        onset = found.dataset.event_value.values[0]
        print(
            f"{type(scene).__name__}: onset {onset:.4f} m/s, in {WIND} m/s {u2:.4f} / {u3:.4f} m,"
            f" {theta:.4f} rad, {found.dataset.attrs['modes']} modes, {found.seconds:.1f} s"
        )


@one_thread
def three():
    """Print the section of three spans, and the onset of its swing by simulation."""
    scene = section(3)
    found = modal.branches(scene, "wind.speed", LOWEST, HIGHEST)
    print(found)
    print(f"{found.seconds:.1f} s of CPU time")
    number = number_of(found, "one loop")
    u2, u3, _, clamp = amplitudes(found, number, WIND)
    print(f"one loop in {WIND} m/s: {u2:.3f} / {u3:.3f} m, clamps {clamp:.3f} m")
    branch = found.diagram.branches[number]
    for torus in branch.of_kind("torus"):
        hertz = torus.rotation / torus.point.period
        print(f"torus at {torus.parameter:.4f} m/s: {hertz:.4f} of {1 / torus.point.period:.4f} Hz")
    onset = branch.of_kind("torus")[-1].parameter
    winds = [factor * onset for factor in (0.97, 1.01, 1.04, 1.08)]
    rates = [swing_rate(scene, branch, wind) for wind in winds]
    for wind, theirs, ours, hertz, our_hertz in rates:
        print(
            f"{wind:.3f} m/s: the swing grows by {theirs:.4f} 1/s in simulations ({hertz:.3f} Hz),"
            f" {ours:.4f} 1/s by its multiplier ({our_hertz:.3f} Hz)"
        )
    winds, theirs = np.array(rates)[:, :2].T
    assert theirs[0] < 0.0 < theirs[-1], "the onset is outside of the simulated winds"
    simulated = np.interp(0.0, theirs, winds)
    print(f"onset of the swing by simulations {simulated:.3f} m/s, by branches {onset:.3f} m/s")
    simulate(scene)


def swing_rate(scene, branch, wind):
    """Wind of the nearest motion; growth rate [1/s] of the swing by the difference of two runs that
    start on it, one with a small disturbance, and by its multiplier; its frequency [Hz] in both."""
    point = min(branch.points, key=lambda one: abs(one.parameter - wind))
    model = point.equations.problem.model
    n, wind = model.size, point.parameter
    hertz = np.abs(np.angle(point.spectrum)) / (2.0 * np.pi * point.period)
    near = (hertz > SWING_HZ[0]) & (hertz < SWING_HZ[1])
    fastest = np.argmax(np.where(near, np.abs(point.spectrum), 0.0))
    ours = math.log(abs(point.spectrum[fastest])) / point.period
    full = Model(
        full_scene(scene, "wind.speed", wind, model).with_values({"numerics.time_step": 0.01}),
        inputs=False,
    )
    clamps = []
    for seed in (0.0, SEED):
        state = point.states[0].copy()
        state[0] += seed / np.max(np.abs(model.shapes[0, :, 2]))
        u, v = model.nodal(state[None, :n], state[None, n:])
        run = full.place(u[0], v[0]).run(2000, round(RECORD / 0.01), CHANNELS, model.watched_nodes)
        clamps.append(model.watched(run.node_values).clamp[:, 0])
    clamp = clamps[1] - clamps[0]
    times, sizes = [], []
    spectral = np.fft.rfftfreq(20 * WINDOW, RECORD)
    band = (spectral > SWING_HZ[0]) & (spectral < SWING_HZ[1])
    for first in range(FIRST_RECORD, len(clamp) - WINDOW, WINDOW // 4):
        part = clamp[first : first + WINDOW]
        spectrum = np.abs(np.fft.rfft((part - part.mean()) * np.hanning(WINDOW), 20 * WINDOW))
        times.append(RECORD * first)
        sizes.append(np.sqrt(np.sum(spectrum[band] ** 2)))
        strongest = spectral[band][spectrum[band].argmax()]
    rate = np.polyfit(times, np.log(sizes), 1)[0]
    return wind, rate, ours, strongest, hertz[fastest]


def simulate(scene):
    """Print the motion of the section from a small seed."""
    seeds = {"seed_vertical": 1e-3, "seed_horizontal": 1e-3}
    result = gf.simulate(
        scene.with_values({f"initial.{name}": value for name, value in seeds.items()}),
        stop_time=600.0,
        record_every=5,
    )
    lean = result.dataset.string_lean_across.sel(tower=1, line_phase=1)
    for start, stop in ((250.0, 300.0), (300.0, 350.0), (550.0, 600.0)):
        u2 = result.between(start, stop, span=2)["u2"].amplitude
        clamp = 1.05 * float(np.ptp(np.sin(lean.sel(time=slice(start, stop)).values)))
        print(
            f"simulated from a seed, {start:g} to {stop:g} s: u2 {u2:.3f} m, clamps {clamp:.3f} m"
        )
    for start, stop in ((300.0, 400.0), (400.0, 500.0)):
        lines = strongest_hertz(lean.sel(time=slice(start, stop)))
        print(f"lean of the strings, {start:g} to {stop:g} s: below 0.4 Hz, {lines} Hz")


def strongest_hertz(history):
    """Frequencies of the peaks below 0.4 Hz that have at least half of the largest amplitude."""
    values, finer = history.values, 16 * len(history)
    size = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)), finer))
    hertz = np.fft.rfftfreq(finer, float(history.time[1] - history.time[0]))
    size = size[hertz < 0.4]
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
    return " and ".join(f"{hertz[i]:.3f}" for i in peaks if size[i] > 0.5 * np.max(size))


def twin():
    """Print the twin bundle."""
    found = modal.branches(section(1, bundle=bundle(2)), "wind.speed", LOWEST, HIGHEST)
    print(found)
    u2, u3, theta, _ = amplitudes(found, number_of(found, "one loop"), WIND)
    print(
        f"one loop in {WIND} m/s: {u2:.4f} / {u3:.4f} m, twist {theta:.4f} rad; a lumped chain"
        " 1.471 / 0.0974 m, 0.112 rad"
    )


@one_thread
def times():
    """Print CPU times of sections of three and five spans and of a quad."""
    for name, scene in (
        ("three spans", section(3)),
        ("five spans", section(5)),
        ("quad", section(1, bundle=bundle(4))),
    ):
        began = time.process_time()
        model = motion_model(scene)
        problem = SpanProblem(WindFamily(model), model, WIND)
        settings = Settings(LOWEST, HIGHEST, max_unstable=2 * model.bundles, max_step=0.3)
        rest = equilibria(problem, np.zeros(problem.size), LOWEST + 1e-5, settings)
        alone = time.process_time() - began
        found = modal.branches(scene, "wind.speed", LOWEST, HIGHEST)
        print(found)
        errors = found.dataset.reduction_error.values
        began = time.process_time()
        modal.screen(scene)
        print(f"{name}: screening {time.process_time() - began:.1f} s of CPU time")
        print(
            f"{name}: {model.size} coordinates, equilibria and {len(rest.of_kind('Hopf'))} onsets"
            f" {alone:.1f} s, all motions {found.seconds:.1f} s of CPU time, error of the reduction"
            f" {np.nanmin(errors):.1%} to {np.nanmax(errors):.1%}"
        )


if __name__ == "__main__":
    known = {"one": one, "three": three, "twin": twin, "times": times}
    for name in sys.argv[1:] or known:
        print(f"\n# {name}")
        known[name]()
