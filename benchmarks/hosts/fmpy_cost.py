"""Cost of an FMU in FMPy: of the kernel, of FMPy itself, and of both together (example3, Linux).

    python benchmarks/hosts/fmpy_cost.py

Times are CPU times, the least of several runs. FMPy's own cost is that of a step whose function of
the library is replaced by one that does nothing.
"""

import ctypes
import sys
import tempfile
import time
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

import gallop_fmu as gf

STEPS, STEP, RUNS, LOADS = 4000, 0.01, 5, 20
KINDS = {2: FMU2Slave, 3: FMU3Slave}


def start(fmu, fmi):
    fmu.instantiate()
    if fmi == 2:
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()


def free(fmu, fmi):
    getattr(fmu, f"fmi{fmi}FreeInstance")(fmu.component)  # FMPy's own would unload the library


def cpu_time(action, count):
    """Least CPU time of `action` [us], per `count`."""
    spent = []
    for _ in range(RUNS):
        began = time.process_time()
        action()
        spent.append((time.process_time() - began) / count)
    return 1e6 * min(spent)


def costs(path, fmi, folder):
    description = read_model_description(str(path))
    fmu = KINDS[fmi](
        guid=description.guid,
        unzipDirectory=extract(str(path), unzipdir=str(folder)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="span",
    )

    def load():
        for _ in range(LOADS):
            start(fmu, fmi)
            free(fmu, fmi)

    def run(size, count):
        start(fmu, fmi)
        for k in range(count):
            fmu.doStep(k * size, size)
        free(fmu, fmi)

    def steps_of_nothing():
        for k in range(STEPS):
            fmu.doStep(k * STEP, STEP)

    load_time = cpu_time(load, LOADS)
    kernel = cpu_time(lambda: run(STEPS * STEP, 1), STEPS)
    both = cpu_time(lambda: run(STEP, STEPS), STEPS)
    name = f"fmi{fmi}DoStep"
    real, nothing = fmu._functions[name], ctypes.CDLL("libm.so.6").fegetround  # which returns 0
    nothing.argtypes, nothing.restype, nothing.argnames = (
        real.argtypes, real.restype, real.argnames
    )  # fmt: skip
    nothing.__name__ = name
    start(fmu, fmi)
    fmu._functions[name] = nothing
    own = cpu_time(steps_of_nothing, STEPS)
    fmu._functions[name] = real
    free(fmu, fmi)
    return load_time, kernel, own, both


def main():
    if sys.platform != "linux":
        sys.exit("this script is for Linux")
    with tempfile.TemporaryDirectory() as folder:
        for fmi in KINDS:
            path = gf.export_fmu(gf.load_scene("example3"), Path(folder, f"{fmi}.fmu"), fmi=fmi)
            load, kernel, own, both = costs(path, fmi, Path(folder, str(fmi)))
            print(
                f"FMI {fmi}.0: load, initialise and free {load:.0f} us; step: kernel {kernel:.2f},"
                f" FMPy {own:.2f} us, both {both:.2f} us = {both / (kernel + own):.2f} x the sum"
            )


if __name__ == "__main__":
    main()
