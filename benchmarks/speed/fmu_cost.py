"""Measure the cost of the FMI layer of a native FMU compared with the kernel.

Usage: python benchmarks/speed/fmu_cost.py

Needs the package installed, this source folder and a C compiler (`cc`, or the one named by the
environment variable CC). fmu_host.c loads the library of an exported FMU and calls its FMI
functions and the kernel's own, by turns. All times are wall-clock times; on a shared machine the
least is nearest to the cost of the work itself, and the speed-up by a second thread means little
without that of mere arithmetic, which is below it.
"""

from __future__ import annotations

import ctypes as c
import importlib.util
import os
import statistics
import subprocess
import tempfile
from pathlib import Path

from fmpy import extract, read_model_description

import gallop_fmu as gf
from gallop_fmu.engine.ctypes_structs import CScene
from gallop_fmu.engine.pack import Packed

REPEATS = 9
HERE = Path(__file__).resolve().parent
KERNEL = HERE.parents[1] / "gallop_fmu" / "kernel"


class Costs(c.Structure):
    """The struct `costs` of fmu_host.c."""

    _fields_ = [
        (name, c.c_double)
        for name in (
            "advance", "step", "save_restore", "copy", "first_step", "one_thread", "two_threads",
            "one_counter",
            "two_counters", "state_bytes"
        )
    ]  # fmt: skip


def compile_host(folder: Path) -> c.CDLL:
    """The library of fmu_host.c, built with the system's compiler."""
    fmpy = importlib.util.find_spec("fmpy")
    assert fmpy is not None
    assert fmpy.origin is not None
    headers, library = Path(fmpy.origin).parent / "c-code", folder / "fmu_host.so"
    flags = ["-std=gnu11", "-O2", "-fPIC", "-shared", f"-I{headers}", f"-I{KERNEL}"]
    command = [
        os.environ.get("CC", "cc"),
        *flags,
        HERE / "fmu_host.c",
        "-o",
        library,
        "-ldl",
        "-pthread",
    ]
    subprocess.run(command, check=True)
    host = c.CDLL(str(library))
    host.fmu_costs.argtypes = (
        c.c_char_p,
        c.c_char_p,
        c.c_char_p,
        c.POINTER(CScene),
        c.POINTER(Costs),
    )
    return host


def measure(folder: Path) -> list[Costs]:
    """All repeats."""
    scene = gf.load_scene("example3")
    path, unpacked = (
        gf.export_fmu(scene, folder / "span.fmu", runtime="native"),
        folder / "unpacked",
    )
    extract(str(path), unzipdir=str(unpacked))
    guid = read_model_description(str(path)).guid
    library = next((unpacked / "binaries").glob("*64/*"))
    host, packed, repeats = compile_host(folder), Packed(scene), []
    for _ in range(REPEATS):
        costs = Costs()
        texts = [text.encode() for text in (str(library), (unpacked / "resources").as_uri(), guid)]
        failed = host.fmu_costs(*texts, c.byref(packed.scene), c.byref(costs))
        if failed:
            raise RuntimeError(f"fmu_host.c failed at {failed}")
        repeats.append(costs)
    return repeats


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        repeats = measure(Path(folder))

    def row(name: str, values: list[float], aim: str) -> None:
        least, middle, most = min(values), statistics.median(values), max(values)
        print(f"| {name} | {least:.3g} | {middle:.3g} | {most:.3g} | {aim} |")

    print(
        f"example3, 15 elements, steps of 0.01 s, {REPEATS} repeats, {os.cpu_count()} cores; ",
        end="",
    )
    print(f"kernel state {repeats[0].state_bytes:.0f} bytes\n")
    print("| | least | median | greatest | aim |\n| --- | ---: | ---: | ---: | --- |")
    row("gallop_advance [us]", [r.advance for r in repeats], "")
    row("fmi2DoStep [us]", [r.step for r in repeats], "")
    row(
        "fmi2DoStep more than gallop_advance [us]",
        [r.step - r.advance for r in repeats],
        "0.5, or 3 %",
    )
    row("fmi2DoStep / gallop_advance", [r.step / r.advance for r in repeats], "1.03, or 0.5 us")
    row("save and restore [us]", [r.save_restore for r in repeats], "1")
    row("two plain copies of the kernel's state [us]", [r.copy for r in repeats], "")
    row("instantiate to first step [ms]", [r.first_step for r in repeats], "5")
    row(
        "speed-up of four instances on two threads",
        [r.one_thread / r.two_threads for r in repeats],
        "1.6",
    )
    row(
        "speed-up that the machine gave to mere arithmetic",
        [r.one_counter / r.two_counters for r in repeats],
        "",
    )


if __name__ == "__main__":
    main()
