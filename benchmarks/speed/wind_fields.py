"""CPU time of a step in gusty and oblique wind over that in uniform wind, in one interleaved run.

    python benchmarks/speed/wind_fields.py [--repeat 15]

Example 3 with Newmark steps of 0.01 s in uniform wind, in oblique wind, and in gusts at 100
stations with three components. Each scene starts in the same state; the CPU time of a step is the
minimum over the repetitions. Motion in gusts is less smooth and needs more Newton iterations, in
uniform wind as well; the last column leaves that out.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import gallop_fmu as gf

CHANNELS = np.array([1], np.int32)
STATIONS, STEP, SECONDS = 100, 0.1, 30.0


def gusts(components: int) -> dict[str, object]:
    """Return a table of 10 % gusts that are random at each station and time."""
    random = np.random.default_rng(1)
    times = np.arange(0.0, SECONDS + STEP, STEP)
    rows = 5.5 * 0.1 * random.standard_normal((3, len(times), STATIONS))
    table = {
        "time": times.tolist(),
        "stations": np.linspace(0.0, 125.0, STATIONS).tolist(),
        "speed": (5.5 + rows[0]).tolist(),
    }
    if components == 3:
        table |= {"across": rows[1].tolist(), "upwards": rows[2].tolist()}
    return {"wind.speed": None, "wind.table": table}


def uniform_gusts() -> dict[str, object]:
    """Return the gusts of one station as the history of uniform wind."""
    table = gusts(1)["wind.table"]
    values = [row[0] for row in table["speed"]]
    return {
        "wind.speed": None,
        "wind.history": {"kind": "table", "time": table["time"], "value": values},
    }


SCENES = {
    "uniform": {},
    "uniform, gusts in time": uniform_gusts(),
    "oblique, 30 deg": {"wind.direction_deg": 30.0, "wind.speed": 5.5 / np.cos(np.pi / 6.0)},
    f"{STATIONS} stations, 1 component": gusts(1),
    f"{STATIONS} stations, 3 components": gusts(3),
}


def main() -> None:
    """Print the CPU time of a step and its ratio to that in uniform wind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=15)
    repeat = parser.parse_args().repeat
    base = gf.load_scene("example3")
    models = {
        name: gf.Model(base.with_values(values), inputs=False) for name, values in SCENES.items()
    }
    best = {name: (np.inf, np.inf) for name in models}
    for _ in range(repeat):
        for name, model in models.items():
            state = model.start()
            start = time.process_time()
            run = state.run(300, 10, nodes=np.array([model.middle], np.int32), channels=CHANNELS)
            spent, report = time.process_time() - start, run.report
            best[name] = min(best[name], (spent / report.steps, report.iterations / report.steps))
    reference, usual = best["uniform"]
    print(f"{'wind':28s} us a step  ratio  iterations a step  ratio for equal iterations")
    for name, (spent, iterations) in best.items():
        equal = spent / reference * usual / iterations
        print(
            f"{name:28s} {1e6 * spent:9.2f} {spent / reference:6.3f}"
            f" {iterations:18.3f} {equal:10.3f}"
        )


if __name__ == "__main__":
    main()
