"""Run tower-cable.ssp with Ecos, an independent master, and compare with example 08's Jacobi loop.

    python run_ssp.py [tower-cable.ssp]

Ecos is no dependency of gallop-fmu: `pip install ecospy`; on Debian it also needs the package
libtbb12. The towers are Python FMUs, so run this with a Python that has pythonfmu.
"""

import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

try:
    from ecospy import EcosLib, EcosSimulation
except ImportError:
    sys.exit("ecospy is not installed: `pip install ecospy`")
except OSError as problem:
    sys.exit(
        f"the library of ecospy cannot be loaded ({problem}); on Debian, `apt-get install libtbb12`"
    )

sys.path.append(str(Path(__file__).resolve().parents[1]))

from make_ssp import CABLE_STEP, PARAMETER_SET, STEP, STOP, make_ssp
from towers.coupling import couple, galloping_span, preload

OBSERVED = ("cable::midspan.x2", "left_tower::x1")


def run_ecos(ssp: Path, steps: int) -> np.ndarray:
    """Mid-span u2 and the left tower's x1 [m] at the start and after each step."""
    EcosLib.set_log_level("warn")
    with EcosSimulation(ssp_path=str(ssp), step_size=STEP) as simulation:
        if not simulation.init(parameter_set=PARAMETER_SET):
            sys.exit(f"Ecos cannot initialise {ssp}: {EcosLib.get_last_error()}")
        records = [[simulation.get_real(name) for name in OBSERVED]]
        for _ in range(steps):
            simulation.step()
            records.append([simulation.get_real(name) for name in OBSERVED])
        simulation.terminate()
    return np.array(records)


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="ssp-"))
    ssp = Path(sys.argv[1]) if len(sys.argv) > 1 else make_ssp(folder)
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder / "parts")
    fmus = [folder / "parts" / "resources" / name for name in ("cable.fmu", "tower.fmu")]
    ours = np.array(
        couple(*fmus, "Jacobi", STEP, STOP, STEP, preload(galloping_span(CABLE_STEP))).values
    )
    theirs = run_ecos(ssp, round(STOP / STEP))
    print(
        f"Ecos {EcosLib.version()} and the Jacobi loop, {len(ours) - 1} steps of {1000 * STEP:g} ms"
    )
    for column, name in enumerate(OBSERVED):
        difference = np.max(np.abs(ours[:, column] - theirs[:, column]))
        print(
            f"{name:18} largest {np.max(np.abs(ours[:, column])):.6f} m, largest difference"
            f" {difference:.1e} m"
        )


if __name__ == "__main__":
    main()
