"""Run FMUs of FMI 2.0 and 3.0 in other masters and checkers; compare with simulate().

    pip install ".[hosts]"
    python benchmarks/hosts/masters.py [SCENE [STOP_TIME]]

The exit code is 1 if a master or checker is missing, refuses an FMU, or gives other digits. Ecos
needs the system library libtbb12 (Debian: `apt-get install libtbb12`).
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import gallop_fmu as gf

OUTPUTS = {"midspan.x2": "u2", "midspan.x3": "u3", "midspan.tension": "tension"}
STEP = 0.01

Master = Callable[[Path, int], list[float]]
"""From the FMU and the number of steps to the last values of the outputs."""


def in_fmpy(fmu: Path, steps: int) -> list[float]:
    from fmpy import simulate_fmu

    found = simulate_fmu(
        str(fmu), stop_time=steps * STEP, output_interval=STEP, output=list(OUTPUTS)
    )
    return [float(found[name][-1]) for name in OUTPUTS]


def in_libcosimpy(fmu: Path, steps: int) -> list[float]:
    from fmpy import read_model_description
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    reference = {v.name: v.valueReference for v in read_model_description(str(fmu)).modelVariables}
    execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="span"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    if not execution.step(step_count=steps):
        raise RuntimeError("libcosim could not make the steps")
    wanted = [reference[name] for name in OUTPUTS]
    return [float(value) for value in observer.last_real_values(slave, wanted)]


def in_ecospy(fmu: Path, steps: int) -> list[float]:
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    structure.add_model("span", str(fmu))
    with EcosSimulation(step_size=STEP, structure=structure) as simulation:
        simulation.init()
        simulation.step(steps)
        values = [float(simulation.get_real(f"span::{name}")) for name in OUTPUTS]
        simulation.terminate()
    return values


def in_fmucontainer(fmu: Path, steps: int) -> list[float]:
    """Run in a container FMU, whose master is in C; FMPy runs the container."""
    container = {
        "name": "container.fmu",
        "fmu": [fmu.name],
        "output": [[fmu.name, name, name] for name in OUTPUTS],
        "step_size": STEP,
        **dict.fromkeys(("auto_input", "auto_output", "auto_link", "auto_parameter"), False),
    }
    plan = fmu.with_name("container.json")
    plan.write_text(json.dumps(container), encoding="utf-8")
    version = fmu.stem[-1]
    _tool(
        "fmucontainer", "-fmi", version, "-fmu-directory", str(fmu.parent), "-container", plan.name
    )
    return in_fmpy(fmu.with_name("container.fmu"), steps)


def check_by_fmutool(fmu: Path) -> str:
    """The checks of the FMU Manipulation Toolbox, with the schemas of the standard; problems."""
    said = _tool("fmutool", "-input", str(fmu), "-check")
    good = "seems to be compliant" in said and "No semantic error" in said
    return "" if good and "ERROR" not in said and "WARNING" not in said else said


def check_by_fmpy(fmu: Path) -> str:
    from fmpy.validation import validate_fmu

    return "; ".join(validate_fmu(str(fmu)))


def _tool(*command: str) -> str:
    program = Path(sys.executable).parent / command[0]
    done = subprocess.run([program, *command[1:]], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{command[0]} ended with {done.returncode}: {done.stderr[-500:]}")
    return done.stdout + done.stderr


MASTERS: dict[str, tuple[str, tuple[int, ...], Master]] = {
    # package, versions of FMI, function
    "FMPy": ("fmpy", (2, 3), in_fmpy),
    "libcosimpy": ("libcosimpy", (2,), in_libcosimpy),
    "ecospy": ("ecospy", (2, 3), in_ecospy),
    "fmucontainer": ("fmu_manipulation_toolbox", (2, 3), in_fmucontainer),
}
CHECKERS = {"fmpy": check_by_fmpy, "fmu_manipulation_toolbox": check_by_fmutool}


def is_installed(package: str) -> bool:
    return importlib.util.find_spec(package) is not None


def simulated(scene: str, steps: int) -> list[float]:
    midspan = gf.simulate(gf.load_scene(scene), stop_time=steps * STEP).midspan()
    return [float(midspan[channel][-1]) for channel in OUTPUTS.values()]


def compare(scene: str, steps: int, folder: Path) -> bool:
    """Run all masters and checkers; True if everything is there and equal."""
    wanted, sound = simulated(scene, steps), True
    fmus = {n: gf.export_fmu(scene, folder / f"span{n}.fmu", fmi=n) for n in (2, 3)}
    for name, (package, versions, run) in MASTERS.items():
        if not is_installed(package):
            print(f"{name:12} is not installed")
            sound = False
            continue
        for version in versions:
            began = time.perf_counter()
            found = run(fmus[version], steps)
            spent = 1e6 * (time.perf_counter() - began) / steps
            equal = found == wanted
            sound = sound and equal
            words = "the digits of simulate()" if equal else f"{found}, simulate() {wanted}"
            release = metadata.version(package)
            print(f"{name:12} {release:7} FMI {version}.0: {words}, {spent:.0f} us per step in all")
    python = gf.export_fmu(scene, folder / "python2.fmu", runtime="python")
    for package, check in CHECKERS.items():
        for fmu in (*fmus.values(), python) if is_installed(package) else ():
            problems = check(fmu)
            sound = sound and not problems
            print(f"{package} finds in {fmu.name}: {problems or 'nothing'}")
    return sound


def main(scene: str = "example3", stop_time: float = 5.0) -> int:
    with tempfile.TemporaryDirectory(prefix="gallop-masters-") as folder:
        return int(not compare(scene, round(stop_time / STEP), Path(folder)))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:2], *map(float, sys.argv[2:3])))
