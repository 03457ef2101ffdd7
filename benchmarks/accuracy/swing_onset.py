"""Wind in which galloping starts a swing: branches, against growth in simulations.

For example 3 and the span at risk of `examples/12_corridor.py`, prints

- the wind in which galloping begins, from the reduced model and the eigenvalues of the full one;
- the wind in which the swing begins, a period doubling of the branch, and that from which it grows
  in the kernel: the zero of growth rates, each by the difference of two runs that start on the
  branch, one with a small disturbance, with the scene's time step and with a quarter of it.

Usage: python benchmarks/accuracy/swing_onset.py (about a minute)
"""

import math
import tempfile
from pathlib import Path

import numpy as np

import gallop_fmu as gf
import modal
from gallop_fmu import Model
from modal.continuation.path import Settings
from modal.continuation.starts import orbit
from modal.foundation.one_thread import one_thread
from modal.motions.full_model import CHANNELS

CORRIDOR = """\
[line]
conductor = "Drake"
span = 310.0
height_difference = -4.0
stringing_percent = 20.0
ice_thickness = 0.010
attack_angle_deg = 178.0
wind_speed = 4.0
coefficients = "example3"

[numerics]
time_step = 0.02
"""

FACTORS = (0.995, 1.0, 1.005)
"""Winds of the simulations relative to the onset by branches."""

SEED, RECORD, FIRST, WINDOW, RECORDS = 1e-6, 0.2, 1000, 200, 3000
"""Sideways disturbance [m]; interval [s] of records; the first that counts; records in the window
of one amplitude; number of records."""


def growth(scene, model, point, time_step):
    """Growth rate [1/s] of a sideways disturbance of an orbit in the kernel."""
    n = model.size
    full = Model(
        scene.with_values(
            {
                "wind.speed": point.parameter,
                "numerics.time_step": time_step,
                "numerics.newton_tolerance": 1e-9,
            }
        ),
        inputs=False,
    )
    histories = []
    for seed in (0.0, SEED):
        state = point.states[0].copy()
        state[model.horizontal] += seed / np.max(np.abs(model.shapes[model.horizontal]))
        u, v = model.nodal(state[None, :n], state[None, n:])
        coarse = slice(None, None, (u.shape[1] - 1) // (full.nodes - 1))
        started = full.place(u[0, coarse], v[0, coarse])
        run = started.run(RECORDS, round(RECORD / time_step), CHANNELS, np.array([full.middle]))
        histories.append(run.node_values[:, 1, 0])
    difference = histories[1] - histories[0]
    first = range(FIRST, len(difference) - WINDOW, WINDOW // 4)
    sizes = [math.sqrt(np.mean(difference[k : k + WINDOW] ** 2)) for k in first]
    return np.polyfit(RECORD * np.array(first), np.log(sizes), 1)[0]


@one_thread
def compare(scene, start, stop):
    """Print all onsets of a span."""
    critical = min(one.wind_speed or math.inf for one in modal.critical_wind_speed(scene))
    found = modal.branches(scene, "wind.speed", start, stop)
    branch = next(one for one in found.diagram.branches if one.of_kind("period doubling"))
    onset = branch.of_kind("period doubling")[0].parameter
    print(f"{scene.title}:")
    print(f"  galloping begins at {branch.ends[0].parameter:.4f} m/s by branches,")
    print(f"  {critical:.4f} m/s by the full model; its swing at {onset:.3f} m/s by branches,")
    problem = branch.points[0].equations.problem
    points = []
    for wind in (factor * onset for factor in FACTORS):
        near = min(branch.points, key=lambda one: abs(one.parameter - wind))
        states = near.at(np.arange(200) / 200)
        settings = Settings(start, stop, tolerance=1e-5)
        points.append(orbit(problem, states, near.period, wind, settings))
    for part in (1.0, 0.25):
        time_step = part * scene.numerics.time_step
        winds = [one.parameter for one in points]
        rates = [growth(scene, problem.model, one, time_step) for one in points]
        assert rates[0] < 0.0 < rates[-1], "the onset is outside of the simulated winds"
        kernel = np.interp(0.0, rates, winds)
        print(f"  {kernel:.3f} m/s by the kernel with a time step of {time_step:g} s")


if __name__ == "__main__":
    compare(gf.load_scene("example3"), 4.0, 5.4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "span.toml"
        path.write_text(CORRIDOR)
        compare(gf.load_scene(path), 0.6, 3.5)
