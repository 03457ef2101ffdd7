"""Conservation in an undamped span in still air: energy, time reversal, bits."""

from __future__ import annotations

import hashlib
import time as clock
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

import gallop_fmu as gf
from gallop_fmu.engine.model import Model, State
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.integrators import INTEGRATORS

Array = NDArray[np.float64]

MOTION = np.array([NODE_INDEX[name] for name in ("u1", "u2", "u3", "theta")], np.int32)
ROUGH = {"initial.seed_vertical": 0.2, "initial.seed_horizontal": 0.1, "initial.seed_twist": 0.1}
"""A start out of equilibrium: axial waves run that steps of 10 ms do not resolve."""

VERTICAL_HZ = 0.6954
"""First vertical frequency of example 3, whose period is the unit of energy losses."""

RELEASE = 0.5
"""Time [s] in which the loads of a smooth start are removed; slower than the axial waves."""


def undamped(values: dict[str, Any] | None = None) -> gf.Scene:
    """Example 3 without wind, damping and seed, with the default Newton tolerance."""
    return gf.load_scene("example3").with_values({
        "wind.speed": 0.0, "damping.translation": None, "damping.twist": None,
        "initial.seed_vertical": 0.0,
        "initial.seed_horizontal": 0.0, "numerics.newton_tolerance": 1e-9, **(values or {}),
    })  # fmt: skip


def released(values: dict[str, Any] | None = None, size: float = 1.0) -> State:
    """A span in motion in its first modes and twist, after static loads were removed smoothly."""
    law = {"kind": "ramp", "initial": 1.0, "final": 0.0, "duration": RELEASE}
    load = {
        "evenly_spaced": 29,
        "force": [0.0, 21.0 * size, 3.2 * size],
        "torque": 0.032 * size,
        "law": law,
    }
    state = Model(undamped({"loads": [load], **(values or {})})).rest()
    state.advance(RELEASE)
    return state


def integrators() -> dict[str, dict[str, Any]]:
    """Name of each integrator to the values that choose it."""
    return {name: {"numerics.integrator": name} for name in INTEGRATORS}


def conserving() -> dict[str, dict[str, Any]]:
    """Each integrator; the dissipative one also with a spectral radius of 1."""
    alpha = {"numerics.integrator": "generalised_alpha", "numerics.spectral_radius": 1.0}
    return {**integrators(), "generalised_alpha, spectral radius 1": alpha}


def energy(span: Array) -> Array:
    return np.asarray(
        span[..., SPAN_INDEX["kinetic_energy"]] + span[..., SPAN_INDEX["potential_energy"]]
    )


def energy_error(state: State, steps: int, every: int) -> dict[str, float]:
    """Relative energy error over many steps: maximum in the first and last tenth, trend, scatter.

    `loss` is the share of the energy lost per vertical period, from the means over both tenths.
    """
    began = clock.process_time()
    start = float(energy(state.observe_span()))
    run = state.run(steps // every, every, MOTION, np.array([state.model.middle], np.int32))
    error = energy(run.span_values) / start - 1.0
    tenth = max(1, len(error) // 10)
    place = np.linspace(0.0, 1.0, len(error))
    trend = np.polyfit(place, error, 1)
    periods = 0.9 * run.report.steps * state.model.scene.numerics.time_step * VERTICAL_HZ
    return {
        "steps": run.report.steps,
        "halvings": run.report.halvings,
        "first_tenth": float(np.abs(error[:tenth]).max()),
        "last_tenth": float(np.abs(error[-tenth:]).max()),
        "largest": float(np.abs(error).max()),
        "trend": float(trend[0]),
        "loss": (
            1.0
            - float((1.0 + error[-tenth:].mean()) / (1.0 + error[:tenth].mean())) ** (1.0 / periods)
        ),
        "scatter": float(np.std(error - np.polyval(trend, place))),
        "amplitude": float(np.abs(run.node_values[:, 1, 0]).max()),
        "seconds": clock.process_time() - began,
    }


def reverse(state: State) -> None:
    """Reverse all velocities."""
    _, velocity, _ = state.motion()
    state.restore(state.save().replace(velocity.tobytes(), (-velocity).tobytes()))


def way_back(state: State, steps: int) -> float:
    """Distance from the start after steps forth and back over the distance moved: maximum."""
    step, start = state.model.scene.numerics.time_step, state.time
    there, _, _ = state.motion()
    gone = np.zeros_like(there[0])
    for i in range(10):
        state.advance(start + (i + 1) * steps // 10 * step)
        gone = np.maximum(gone, np.abs(state.motion()[0] - there).max(axis=0))
    reverse(state)
    state.advance(start + 2 * steps * step)
    return float((np.abs(state.motion()[0] - there).max(axis=0) / gone).max())


def fingerprint(scene: gf.Scene, steps: int, every: int) -> str:
    """Digest of all bits of the last record of a run; for a failed run, of its report."""
    step = scene.numerics.time_step
    result = gf.simulate(
        scene, stop_time=steps * step, record_every=every, record_nodes="all", on_failure="return"
    )
    if result.outcome is not gf.Outcome.COMPLETED:
        return str(result.report)
    last = result.dataset.isel(time=-1)
    names = sorted(str(name) for name in last.data_vars)
    return hashlib.sha256(b"".join(last[name].values.tobytes() for name in names)).hexdigest()


def same_bits(scenes: list[gf.Scene], steps: int, threads: int = 2) -> dict[str, bool]:
    """Compare the bits of all scenes when repeated, recorded rarely, and run in threads."""
    first = [fingerprint(scene, steps, 1) for scene in scenes]
    with ThreadPoolExecutor(threads) as pool:
        at_once = list(pool.map(lambda scene: fingerprint(scene, steps, 1), scenes))
    return {
        "repeated": first == [fingerprint(scene, steps, 1) for scene in scenes],
        "recorded rarely": first == [fingerprint(scene, steps, steps) for scene in scenes],
        "in threads": first == at_once,
    }
