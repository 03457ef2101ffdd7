"""Cost of sections and bundles against single spans of as many elements; see ../README.md.

Usage: python benchmarks/speed/lines.py
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.scene.line_scene import LineScene

ELEMENTS, STEP, SECONDS, REPEATS = 15, 0.02, 20.0, 5
STRING = {"kind": "string", "length": 2.4, "weight": 600.0}
BOUNDS = {
    "5 spans / 5 single spans": 1.15,
    "10 spans / 10 single spans": 1.15,
    "quad with 6 spacers / single conductor": 6.0,
}


def line(spans: int, bundle: dict[str, Any] | None = None) -> LineScene:
    """The conductor of example 3 in equal spans, galloping in its wind."""
    base = gf.load_scene("example3")
    data = base.model_dump(mode="json", exclude_none=True)
    length, tension = data.pop("span")["length"], Model(base).equilibrium().horizontal_tension
    for name in ("supports", "sources", "title", "description", "notes", "loads"):
        data.pop(name, None)
    data["section"] = {
        "horizontal_tension": tension,
        "strung_with_ice": True,
        "spans": [{"length": length}] * spans,
        "suspensions": [STRING] * (spans - 1),
    }
    data["numerics"] |= {"elements": ELEMENTS, "time_step": STEP}
    data["initial"] |= {"seed_vertical": 0.1, "seed_horizontal": 0.01}
    return LineScene.from_dict({**data, "title": f"{spans} spans", "bundle": bundle or {}})


def run_time(model: Model, seconds: float = SECONDS) -> float:
    """Processor time [s] of a run, without its start."""
    state = model.start()
    began = time.process_time()
    state.advance(seconds)
    return time.process_time() - began


def main() -> None:
    quad = {"subconductors": 4, "spacing": 0.45, "spacers": 6}
    models = {
        "single": Model(line(1)),
        "5 spans": Model(line(5)),
        "10 spans": Model(line(10)),
        "quad": Model(line(1, quad)),
        "10 spans x quad": Model(line(10, quad)),
    }
    times: dict[str, list[float]] = {name: [] for name in models}
    for _ in range(REPEATS):
        for name, model in models.items():
            times[name].append(run_time(model))
    each = {name: statistics.median(of) for name, of in times.items()}
    for name, model in models.items():
        state = model.start()
        state.advance(SECONDS)
        work = state.report if hasattr(state, "report") else ""
        low, high = min(times[name]), max(times[name])
        print(
            f"{name:16} {model.nodes:5} nodes {model.saved_size / 1e3:8.0f} kB a state"
            f" {each[name] * 1e3:8.1f} ms ({low * 1e3:.1f} to {high * 1e3:.1f}),"
            f" {SECONDS / each[name]:8.0f} x real time {work}"
        )
    found = {
        "5 spans / 5 single spans": each["5 spans"] / each["single"] / 5.0,
        "10 spans / 10 single spans": each["10 spans"] / each["single"] / 10.0,
        "quad with 6 spacers / single conductor": each["quad"] / each["single"],
    }
    for name, ratio in found.items():
        print(f"{name}: {ratio:.2f} (bound {BOUNDS[name]})")
    assert np.isfinite(list(each.values())).all()


if __name__ == "__main__":
    main()
