"""Find functions that are too complex or have too many parameters, in Python and in C.

    python tools/check_complexity.py

Complexity is cyclomatic, as lizard counts it. A function above a limit needs a line in `EXCEPTIONS`
with the reason; a line whose function is below the limits again must go.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

import lizard

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("gallop_fmu", "modal", "tools")
MAX_COMPLEXITY, MAX_PARAMETERS = 15, 8

OPTIONS = "each parameter is an option, given by its name"
C_FACE = "an exported C function, which has no parameters by name; its header describes each"

FMI_FACE = "a function of FMI, whose standard gives its parameters"

EXCEPTIONS = {
    "gallop_fmu/cli/main.py:export": OPTIONS,
    "gallop_fmu/cli/main.py:run": OPTIONS,
    "gallop_fmu/engine/mesh.py:aero_load": OPTIONS,
    "gallop_fmu/engine/model.py:device_tangent": OPTIONS,
    "gallop_fmu/engine/model.py:tangent": OPTIONS,
    "gallop_fmu/kernel/analysis.c:gallop_aero_load": C_FACE,
    "gallop_fmu/kernel/analysis.c:gallop_device_force": C_FACE,
    "gallop_fmu/kernel/analysis.c:gallop_device_tangent": C_FACE,
    "gallop_fmu/kernel/analysis.c:gallop_shape_load": C_FACE,
    "gallop_fmu/kernel/analysis.c:gallop_tangent": C_FACE,
    "gallop_fmu/kernel/fmi3.c:fmi3InstantiateCoSimulation": FMI_FACE,
    "gallop_fmu/kernel/fmi3_absent.c:fmi3InstantiateScheduledExecution": FMI_FACE,
    "gallop_fmu/kernel/time_march.c:gallop_run": C_FACE,
    "gallop_fmu/kernel/time_march.c:gallop_run_in_team": C_FACE,
    "gallop_fmu/simulation/simulate.py:simulate": OPTIONS,
    "gallop_fmu/sweeps/sweep.py:sweep": OPTIONS,
    "modal/cli/atlas_command.py:atlas": OPTIONS,
    "modal/risk/atlas.py:risk_atlas": OPTIONS,
    "modal/screening/many_spans.py:screen_spans": OPTIONS,
    "modal/study/command.py:study": OPTIONS,
}
"""Path and name of a function, and why it may be above a limit."""


def above_limits(root: Path, folders: tuple[str, ...]) -> dict[str, str]:
    """Functions above a limit: path and name, and by how much."""
    found = {}
    files = [
        file
        for folder in folders
        for kind in ("py", "c", "h")
        for file in (root / folder).rglob(f"*.{kind}")
    ]
    for file in sorted(files):
        for function in lizard.analyze_file(str(file)).function_list:
            complexity, parameters = function.cyclomatic_complexity, function.parameter_count
            if complexity > MAX_COMPLEXITY or parameters > MAX_PARAMETERS:
                name = f"{file.relative_to(root).as_posix()}:{function.name}"
                found[name] = f"complexity {complexity}, {parameters} parameters"
    return found


def problems(root: Path, folders: tuple[str, ...], exceptions: Mapping[str, str]) -> list[str]:
    """Functions above a limit without a reason, and reasons that are no longer needed."""
    above = above_limits(root, folders)
    found = [
        f"{name}: {size}; split it, or give a reason in EXCEPTIONS"
        for name, size in above.items()
        if name not in exceptions
    ]
    found += [
        f"{name} is below the limits now; remove it from EXCEPTIONS"
        for name in exceptions
        if name not in above
    ]
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.parse_args()
    found = problems(ROOT, FOLDERS, EXCEPTIONS)
    if found:
        sys.exit("\n".join(found))
    print(
        f"no function above complexity {MAX_COMPLEXITY} or {MAX_PARAMETERS} parameters, "
        f"except {len(EXCEPTIONS)} with a reason"
    )


if __name__ == "__main__":
    main()
