"""Run an FMU in whichever of fmpy, libcosimpy and ecospy is installed, and compare with simulate().

Usage: python benchmarks/hosts/masters.py SCENE FMU [STOP_TIME]

SCENE is the packaged name or file that the FMU was exported from. ECOS and libcosim pin packages
that differ, so each master may have an environment of its own; one without gallop-fmu prints the
last values only.
"""

from __future__ import annotations

import importlib.util
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

OUTPUTS = {"midspan.x2": "u2", "midspan.x3": "u3", "midspan.tension": "tension"}
STEP = 0.01

Master = Callable[[Path, dict[str, int], int], list[float]]


def references(fmu: Path) -> dict[str, int]:
    """Value references of the outputs."""
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    found = {v.get("name"): int(v.get("valueReference", -1)) for v in root.iter("ScalarVariable")}
    return {name: found[name] for name in OUTPUTS}


def in_fmpy(fmu: Path, outputs: dict[str, int], steps: int) -> list[float]:
    from fmpy import simulate_fmu

    found = simulate_fmu(
        str(fmu), stop_time=steps * STEP, output_interval=STEP, output=list(outputs)
    )
    return [float(found[name][-1]) for name in outputs]


def in_libcosimpy(fmu: Path, outputs: dict[str, int], steps: int) -> list[float]:
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu), instance_name="span"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    if not execution.step(step_count=steps):
        raise RuntimeError("libcosim could not make the steps")
    return [float(value) for value in observer.last_real_values(slave, list(outputs.values()))]


def in_ecospy(fmu: Path, outputs: dict[str, int], steps: int) -> list[float]:
    from ecospy import EcosSimulation, EcosSimulationStructure

    structure = EcosSimulationStructure()
    structure.add_model("span", str(fmu))
    with EcosSimulation(step_size=STEP, structure=structure) as simulation:
        simulation.init()
        simulation.step(steps)
        values = [float(simulation.get_real(f"span::{name}")) for name in outputs]
        simulation.terminate()
    return values


MASTERS: dict[str, Master] = {"fmpy": in_fmpy, "libcosimpy": in_libcosimpy, "ecospy": in_ecospy}


def simulated(scene: str, steps: int) -> list[float] | None:
    if importlib.util.find_spec("gallop_fmu") is None:
        return None
    import gallop_fmu as gf

    midspan = gf.simulate(gf.load_scene(scene), stop_time=steps * STEP).midspan()
    return [float(midspan[channel][-1]) for channel in OUTPUTS.values()]


def main(scene: str, fmu: Path, stop_time: float = 20.0) -> None:
    steps = round(stop_time / STEP)
    wanted, outputs = simulated(scene, steps), references(fmu)
    for name, master in MASTERS.items():
        if importlib.util.find_spec(name) is None:
            print(f"{name}: not installed")
            continue
        began = time.perf_counter()
        found = master(fmu, outputs, steps)
        spent = 1e6 * (time.perf_counter() - began) / steps
        for index, output in enumerate(outputs):
            difference = (
                "" if wanted is None else f", from simulate(): {found[index] - wanted[index]:.3g}"
            )
            print(f"{name}: {output} = {found[index]!r}{difference}")
        print(f"{name}: {spent:.1f} us per step in total")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]).resolve(), *map(float, sys.argv[3:4]))
