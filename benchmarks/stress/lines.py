"""Run random lines: outcomes, finite records, energy; see ../README.md.

Usage: python benchmarks/stress/lines.py [number of lines, default 2000] [seed]

Spans, rises, strings, ends, bundles, phases, devices, ice, temperature, wind and integrators are
drawn. A third of the lines move in still air without damping: their energy must stay the same.
"""

from __future__ import annotations

import collections
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from support.drawn_lines import drawn, run


def main() -> None:
    lines = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 20261128
    began, counts, drifts = time.perf_counter(), collections.Counter[str](), []
    examples: dict[str, str] = {}
    for number in range(lines):
        data = drawn(np.random.default_rng([seed, number]))
        outcome, message, drift = run(data)
        counts[outcome] += 1
        examples.setdefault(outcome, f"line {number}: {message}")
        if np.isfinite(drift):
            drifts.append((abs(drift), number, data["numerics"]["integrator"]))
    print(f"{lines} lines, seed {seed}, {time.perf_counter() - began:.0f} s")
    for outcome, count in counts.most_common():
        print(f"{outcome}: {count}; {examples[outcome]}")
    drifts.sort(reverse=True)
    sizes = np.array([drift for drift, *_ in drifts])
    print(
        f"energy of {len(drifts)} lines without losses: median drift {np.median(sizes):.1e},"
        f" above 1 %: {(sizes > 0.01).sum()}, largest {drifts[:5]}"
    )


if __name__ == "__main__":
    main()
