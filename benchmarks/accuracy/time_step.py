"""Error of a steady amplitude over the steps in a period, for each integrator with equal steps.

    python benchmarks/accuracy/time_step.py

Prints a table in Markdown. Its greatest constants are in `gallop_fmu.foundation.integrators`
(`amplitude_error`), from which the warning of a run whose steps are too long estimates the error.
Takes about a minute.
"""

from __future__ import annotations

import gallop_fmu as gf
from gallop_fmu.foundation.integrators import INTEGRATORS

STOP, WINDOW, RECORD = 1600.0, 200.0, 0.05
REFERENCE, STEPS = 0.005, (0.02, 0.04, 0.06, 0.1, 0.15, 0.2, 0.25)

CASES = {
    "example 2, 4.1 m/s": gf.load_scene("example2"),
    "example 3, 5.0 m/s": (
        gf.load_scene("example3").with_values({"wind.speed": 5.0, "initial.seed_vertical": 0.3})
    ),
    "example 3, 5.5 m/s": gf.load_scene("example3"),
}


def motion(scene: gf.Scene, integrator: str, step: float) -> gf.Oscillation:
    """Vertical motion at mid-span at the end of a long run."""
    values = {
        "numerics.integrator": integrator,
        "numerics.time_step": step,
        "numerics.elements": 10,
    }
    every = max(1, round(RECORD / step))
    return gf.simulate(scene.with_values(values), STOP, record_every=every).steady(WINDOW)["u2"]


def main() -> None:
    """Print the table."""
    print(
        "| Integrator | Limit cycle | Steps in a period: error of the amplitude | Error times steps"
        " to the order |"
    )
    print("| --- | --- | --- | ---: |")
    for name, integrator in INTEGRATORS.items():
        for case, scene in CASES.items():
            right = motion(scene, name, REFERENCE)
            cells, largest = [], 0.0
            for step in STEPS:
                found, count = motion(scene, name, step), 1.0 / (right.frequency_hz * step)
                error = found.amplitude / right.amplitude - 1.0
                cells.append(f"{count:.1f}: {error:+.2%}")
                if abs(error) > 1e-4 and found.motion.kind == "steady":
                    largest = max(largest, abs(error) * count**integrator.order)
            print(f"| {name} | {case} | {', '.join(cells)} | {largest:.3g} |", flush=True)


if __name__ == "__main__":
    main()
