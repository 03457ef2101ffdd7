"""Cost over total error, of mesh and time together, for four scenes; see README.md in ../.

python benchmarks/peers/total.py               # measure everything, then report: 10 to 15 minutes
python benchmarks/peers/total.py SCENE SET     # measure one scene with one instruction set
python benchmarks/peers/total.py --report      # tables, claims and picture from stored results

SCENE: example1, galloping, section, twin or temporal; SET: AVX2 or AVX-512.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent / "results"
SCENES = ("example1", "galloping", "section", "twin", "temporal")
SETS = ("AVX2", "AVX-512")

REPEATS = 4
ENOUGH = 2.0
"""Processor time [s] after which a case is not repeated any more."""

NEAR = 1.5
"""Cases above this multiple of their code's best cost at their error are not repeated."""


def environment(instructions: str) -> dict[str, str]:
    """Variables for one thread, and for numba to compile for AVX2 and FMA only."""
    threads = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    chosen = {"NUMBA_CPU_NAME": "haswell"} if instructions == "AVX2" else {}
    return {**os.environ, **dict.fromkeys(threads, "1"), **chosen}


def has_avx512() -> bool:
    """True if gallop-fmu computes with AVX-512 here."""
    from gallop_fmu.engine.library import arithmetic

    return arithmetic(portable=False) == "fused"


def measure(scene: str, instructions: str) -> dict[str, Any]:
    """Measure all codes on a scene in this process."""
    import numpy as np
    import total_cases
    from analysis import best_total, relative_rms
    from run import Measured, machine

    portable = instructions == "AVX2"
    title, stop_time, reference, cases = total_cases.scene(scene, portable)
    kind = "temporal" if scene == "temporal" else "total"
    measured = [Measured(case) for case in cases]
    rows: list[dict[str, Any]] = []
    for repeat in range(REPEATS):
        print(f"{scene}, {instructions}: repeat {repeat + 1}", file=sys.stderr, flush=True)
        kept = {(row["family"], row["setting"]) for row in rows if row["near"]}
        for one in measured:
            wanted = repeat == 0 or (one.case.family, one.case.setting) in kept
            if wanted and not one.failure and sum(one.seconds) < ENOUGH:
                one.run()
        rows = []
        for one in measured:
            reached = not one.failure and one.history is not None
            error = None
            if reached:
                expected = reference[one.case.model] if kind == "temporal" else reference
                error = relative_rms(one.history, expected)
                reached = bool(np.isfinite(error).all())
            rows.append(
                {
                    "code": one.case.code,
                    "family": one.case.family,
                    "setting": one.case.setting,
                    "cost": min(one.seconds) / stop_time if reached else None,
                    "all": [seconds / stop_time for seconds in one.seconds],
                    kind: error if reached else None,
                    "failure": one.failure,
                }
            )
        for row in rows:
            least = best_total(rows, row["code"], max(row[kind]), kind) if row[kind] else 0.0
            row["near"] = row["cost"] is not None and row["cost"] <= NEAR * least
    return {"title": title, "machine": machine(), "rows": rows}


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    arguments = sys.argv[1:]
    if arguments and arguments[0] != "--report":
        scene, instructions = arguments
        if os.environ.get("NUMBA_NUM_THREADS") != "1":  # the libraries must be loaded with it
            command = [sys.executable, __file__, scene, instructions]
            sys.exit(subprocess.run(command, env=environment(instructions)).returncode)
        began = time.process_time()
        found = measure(scene, instructions)
        path = FOLDER / f"total_{scene}_{instructions}.json"
        path.write_text(json.dumps(found, indent=1), encoding="utf-8")
        print(f"{path.name}: {time.process_time() - began:.0f} s", file=sys.stderr)
        return
    if not arguments:
        for instructions in SETS if has_avx512() else SETS[:1]:
            for scene in SCENES:
                command = [sys.executable, __file__, scene, instructions]
                subprocess.run(command, env=environment(instructions), check=True)
    from total_report import report

    report(FOLDER)


if __name__ == "__main__":
    main()
