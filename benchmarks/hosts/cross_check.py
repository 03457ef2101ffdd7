"""Compile the kernel for every platform with Zig, inspect the libraries, run those that can run.

    pip install ".[cross]"
    python benchmarks/hosts/cross_check.py

Linux on x86-64 only. The first run takes some minutes, most of them for the run-time library of
Windows. If `wine` is installed (Debian: `apt-get install --no-install-recommends wine64 wine`), the
library for Windows runs in it.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path

import numpy as np
from binaries import exports, newest_glibc, slices
from fmpy import extract, read_model_description

import gallop_fmu as gf
from gallop_fmu.engine.library import build
from gallop_fmu.fmu.cross_compile import PLATFORMS, cache_folder, cross_library

HERE = Path(__file__).resolve().parent
STEPS, STEP = 1000, 0.02
FMI_FUNCTIONS = 44 + 75
"""Functions of FMI 2.0 and FMI 3.0, which the library exports all."""
ADDED_BY_LINKER = {"__dso_handle", "_mh_dylib_header"}
"""Extra symbols that Zig's linker exports from a Mach-O library.

Names are looked up per library there, so they are harmless.
"""
HEADERS = str(metadata.distribution("fmpy").locate_file("fmpy/c-code"))


def main() -> None:
    folder = Path(tempfile.mkdtemp(prefix="gallop-cross-"))
    print(f"Zig {metadata.version('ziglang')}, installed kernel: {build()}\n")
    os.environ.setdefault("ZIG_GLOBAL_CACHE_DIR", str(cache_folder().parent / "zig"))
    os.environ["XDG_CACHE_HOME"] = str(
        folder / "cache"
    )  # so that the kernel is compiled, though not all of Zig's own
    libraries = {}
    for name in PLATFORMS:
        begin = time.perf_counter()
        libraries[name] = cross_library(name)
        print(
            f"{name:9} {len(libraries[name]):7} bytes, compiled in"
            f" {time.perf_counter() - begin:.1f} s"
        )
    print()
    look(libraries)
    scene = gf.load_scene("example3")
    crossed = gf.export_fmu(scene, folder / "crossed.fmu", platforms=tuple(PLATFORMS))
    run(gf.export_fmu(scene, folder / "installed.fmu"), crossed, folder)
    shutil.rmtree(folder)


def look(libraries: dict[str, bytes]) -> None:
    """Exports, glibc, processors."""
    kernel = Path(gf.__file__).parent / "kernel"
    headers = "".join(path.read_text(encoding="utf-8") for path in kernel.glob("gallop*.h"))
    ours = set(re.findall(r"^GALLOP_API [\w\s*]*?(gallop_\w+)\(", headers, re.MULTILINE))
    apple = slices(libraries["darwin64"])
    assert set(apple) == {"x86_64", "arm64"}
    parts = {"linux64": libraries["linux64"], "win64": libraries["win64"]}
    parts |= {f"darwin64 {processor}": library for processor, library in apple.items()}
    for name, library in parts.items():
        found = exports(library)
        fmi = {function for function in found if function.startswith(("fmi2", "fmi3"))}
        assert len(fmi) == FMI_FUNCTIONS, (
            f"{name}: {len(fmi)} FMI functions, {FMI_FUNCTIONS} are needed"
        )
        added = found & ADDED_BY_LINKER if "darwin" in name else set()
        assert found - fmi - added == ours, (
            f"{name}: {sorted((found - fmi - added) ^ ours)} on one side only"
        )
        besides = " and ".join(sorted(added)) or "nothing else"
        print(
            f"{name:15} exports {len(fmi)} FMI functions, the {len(ours)} of the public"
            f" headers, and {besides}"
        )
    major, minor = newest_glibc(libraries["linux64"])
    assert (major, minor) <= (2, 17)
    print(f"{'linux64':15} asks for glibc {major}.{minor}")
    print(
        f"{'darwin64':15} has two slices of the right processor; NOT run: there is no such machine"
        " here\n"
    )


def run(installed: Path, crossed: Path, folder: Path) -> None:
    """The same motion from the library that the C compiler of this machine made, and from Zig's."""
    program = folder / "cross_host"
    build = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        "-O3",
        "-s",
        "-fno-sanitize=undefined",
        f"-I{HEADERS}",
        str(HERE / "cross_host.c"),
    ]
    subprocess.run([*build, "-o", str(program)], check=True)
    names, wanted = _outputs([str(program)], installed, "linux64", ".so", folder)
    print(
        f"{STEPS} steps of {STEP} s of example 3, {len(names)} outputs, against the installed"
        " library:"
    )
    _compare(
        "linux64", names, wanted, _outputs([str(program)], crossed, "linux64", ".so", folder)[1]
    )
    if shutil.which("wine") is None:
        print("win64    not run: there is no wine here")
        return
    windows = folder / "cross_host.exe"
    subprocess.run([*build, "-target", "x86_64-windows-gnu", "-o", str(windows)], check=True)
    _compare(
        "win64",
        names,
        wanted,
        _outputs(["wine", str(windows)], crossed, "win64", ".dll", folder)[1],
    )


def _outputs(
    host: list[str], fmu: Path, platform: str, suffix: str, folder: Path
) -> tuple[list[str], np.ndarray]:
    """Names of the Reals, and a row for each step."""
    unpacked = folder / fmu.stem
    extract(str(fmu), unzipdir=str(unpacked))
    description = read_model_description(str(fmu))
    reals = [v for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
    drive = "Z:" if host[0] == "wine" else ""
    library = next((unpacked / "binaries" / platform).glob(f"*{suffix}"))
    resources = (
        f"file:///{drive}{unpacked / 'resources'}" if drive else (unpacked / "resources").as_uri()
    )
    words = [
        f"{drive}{library}",
        resources,
        description.guid,
        STEPS,
        STEP,
        *(v.valueReference for v in reals),
    ]
    environment = {
        **os.environ,
        "WINEPREFIX": str(folder / "wine"),
        "WINEDEBUG": "-all",
        "HOME": str(folder),
    }
    done = subprocess.run(
        [*host, *map(str, words)], env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, f"{platform}: {done.stderr}"
    rows = [[float.fromhex(word) for word in line.split()] for line in done.stdout.splitlines()]
    return [v.name for v in reals], np.array(rows)


def _compare(platform: str, names: list[str], wanted: np.ndarray, found: np.ndarray) -> None:
    assert found.shape == wanted.shape == (STEPS, len(names))
    if found.tobytes() == wanted.tobytes():
        print(f"{platform:8} runs: every bit is the same")
        return
    size = np.max(np.abs(wanted), axis=0)
    for kind in {
        _kind(name) for name in names
    }:  # some values are nought but for rounding, such as x1 at mid-span
        same_kind = [_kind(name) == kind for name in names]
        size[same_kind] = np.max(size[same_kind])
    share = np.max(np.abs(found - wanted), axis=0) / size
    worst = int(np.argmax(share))
    print(
        f"{platform:8} runs: largest difference {share[worst]:.1e} of the largest value of its"
        f" kind, in {names[worst]}"
    )
    assert share[worst] < 1e-9


def _kind(name: str) -> str:
    """Name without its axis."""
    return name.rstrip("0123456789")


if __name__ == "__main__":
    main()
