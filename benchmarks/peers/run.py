"""Error against run time, for gallop-fmu and for other programs; see README.md in the folder above.

python benchmarks/peers/run.py             # measure, about 10 minutes on a free core
python benchmarks/peers/run.py --quick     # a check: two repeats, expensive settings once
python benchmarks/peers/run.py --redraw    # tables and picture from the stored results
"""

# ruff: noqa: E402 - the number of threads must be set before the libraries are loaded

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Hashable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"  # before any of the libraries is loaded

import chain
import explicit
import general_solvers
import moordyn_line
import numpy as np
import opensees
import ours
from analysis import Row, case_table, claims, relative_rms, temporal_table
from cases import Case, NotReachedError
from picture import draw
from scenes import Array, Problem, example1, galloping, opensees_reference

import gallop_fmu.engine.library

REPEATS = 5
ENOUGH = 3.0
"""CPU time [s] after which a case is not repeated any more."""

QUICK_REPEATS, QUICK_ENOUGH = 2, 0.3

PACKAGES = ("gallop-fmu", "openseespy", "moordyn", "scipy", "scikit-sundae", "numba", "numpy")


@dataclass
class Measured:
    """Result of one case."""

    case: Case
    seconds: list[float] = field(default_factory=list)
    history: Array | None = None
    failure: str = ""

    def run(self) -> None:
        try:
            advance = self.case.prepare()
            began = time.process_time()
            history = advance()
            self.seconds.append(time.process_time() - began)
        except NotReachedError as problem:
            self.failure = str(problem)[:80]
            return
        if np.isfinite(history).all():
            self.history = history
        else:
            self.failure = "not finite"


def measure(problem: Problem, quick: bool) -> list[Row]:
    """Run all codes on one scene; repeats of the cases alternate, the minimum CPU time counts."""
    print(f"{problem.title}: converged solutions", file=sys.stderr)
    converged = references(problem)
    total = (
        opensees_reference(problem)
        if problem.wind is None
        else chain.extrapolated(problem, 160, 1e-4)
    )
    sources = (ours, opensees, moordyn_line, general_solvers, explicit)
    measured = [Measured(case) for source in sources for case in source.cases(problem)]
    limit = QUICK_ENOUGH if quick else ENOUGH
    for repeat in range(QUICK_REPEATS if quick else REPEATS):
        print(f"  repeat {repeat + 1}", file=sys.stderr)
        for one in measured:
            if not one.failure and sum(one.seconds) < limit:
                one.run()
    return [_row(one, converged, total, problem.stop_time) for one in measured]


def references(problem: Problem) -> dict[Hashable, Array]:
    """For each mesh and mass, the solution converged in time."""
    found: dict[Hashable, Array] = {
        ("gallop-fmu", 41): ours.converged(problem),
        ("chain", False): explicit.converged(problem, consistent=False),
        ("chain", True): explicit.converged(problem, consistent=True),
    }
    if problem.wind is None:
        found["MoorDyn"] = moordyn_line.converged(problem)
    return found


def _row(one: Measured, converged: dict[Hashable, Array], total: Array, stop_time: float) -> Row:
    case = one.case
    reached = not one.failure and one.history is not None
    return {
        "code": case.code,
        "family": case.family,
        "setting": case.setting,
        "cost": min(one.seconds) / stop_time if reached else None,
        "all": [seconds / stop_time for seconds in one.seconds],
        "temporal": (
            relative_rms(one.history, converged[case.model]) if reached and case.model else None
        ),
        "total": relative_rms(one.history, total) if reached else None,
        "failure": one.failure,
    }


def machine() -> dict[str, Any]:
    name = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next((line.split(": ")[1] for line in lines if line.startswith("model name")), name)
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    return {
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "processor": name,
        "load_average": load,
        "python": platform.python_version(),
        "kernel": gallop_fmu.engine.library.build(),
        "versions": {package: version(package) for package in PACKAGES},
    }


def report(results: dict[str, Any], folder: Path) -> None:
    """Write results.md and the picture; print costs and claims."""
    about = results["machine"]
    versions = ", ".join(f"{name} {number}" for name, number in about["versions"].items())
    text = [
        (
            f"{about['date']}, {about['processor']}, load average {about['load_average']:.1f},"
            f" Python {about['python']}, kernel {about['kernel']}; {versions}."
        ),
        (
            "CPU ms per simulated second of the time loop alone, one core; in brackets the multiple"
            " of ours."
        ),
    ]
    for name, scene in results["scenes"].items():
        text += [f"## {scene['title']}", temporal_table(scene["rows"])]
        if name == "example1":
            text += ["Claims for example 1, 41 nodes, in this run:", claims(scene["rows"])]
    print("\n\n".join(text))
    text += [
        f"## Every case: {scene['title']}\n\n{case_table(scene['rows'])}"
        for scene in results["scenes"].values()
    ]
    folder.joinpath("results.md").write_text(
        "# Error against run time\n\n" + "\n\n".join(text) + "\n", encoding="utf-8"
    )
    draw(results, folder / "work_precision")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="a check that everything runs")
    parser.add_argument("--redraw", action="store_true", help="use the stored results.json")
    parser.add_argument(
        "--folder", type=Path, default=Path(__file__).parent / "results", help="for the results"
    )
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    stored = options.folder / "results.json"
    if not options.redraw:
        results: dict[str, Any] = {"machine": machine(), "scenes": {}}
        for problem in (example1(), galloping()):
            results["scenes"][problem.name] = {
                "title": problem.title,
                "rows": measure(problem, options.quick),
            }
            stored.write_text(json.dumps(results, indent=1), encoding="utf-8")
    report(json.loads(stored.read_text(encoding="utf-8")), options.folder)


if __name__ == "__main__":
    main()
