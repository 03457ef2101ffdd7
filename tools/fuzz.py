"""Fuzz the compiled kernel with libFuzzer under the address and undefined-behaviour sanitizers.

    python tools/fuzz.py --executions 100000            # of each target
    python tools/fuzz.py --target state --seconds 3600
    python tools/fuzz.py --executions 1000 --keep       # replace the corpus of the tests

Targets: the files fuzz/*_target.c. Each starts from its corpus there. An input
that breaks something is named at the end and stays in the working folder. The exit code is 1 then.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import gallop_fmu as gf
from gallop_fmu.fmu.description import identify
from gallop_fmu.foundation.version import version

ROOT = Path(__file__).resolve().parent.parent
KERNEL, FUZZING = ROOT / "gallop_fmu" / "kernel", ROOT / "fuzz"
CORPUS = FUZZING / "corpus"
TARGETS = {
    "resource": ["resource_target.c"],
    "state": ["state_target.c"],
    "scene": ["scene_target.c"],
    "face": ["face_target.c"],
    "sequence": [file.name for file in sorted(FUZZING.glob("sequence*.c"))],
    "sequence3": [file.name for file in sorted(FUZZING.glob("sequence*.c"))],
}
DEFINITIONS = {"sequence3": ["-DFMI3"]}
"""Of the target for FMI 3.0, which starts from the inputs of `sequence`."""
FLAGS = ("-std=c11", "-D_DEFAULT_SOURCE", "-g", "-O2", "-ffp-contract=off", "-Wno-pass-failed")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
LONGEST = 300
"""Bytes of an input; of a sequence of calls, ten times as many."""
KEPT = 100
"""Inputs of one target in the repository."""


def find_clang() -> str:
    """The newest clang there is."""
    names = ["clang", *(f"clang-{version}" for version in range(30, 13, -1))]
    found = next(filter(None, map(shutil.which, names)), None)
    if not found:
        sys.exit(
            "fuzz: no clang; apt-get install clang libclang-rt-14-dev, or what it is called on your"
            " system"
        )
    return found


def compile_targets(names: list[str], folder: Path) -> None:
    """Compile the kernel once, and each target with it."""
    clang, objects = find_clang(), list[Path]()
    found = importlib.util.find_spec("fmpy")
    assert found is not None
    assert found.origin is not None
    flags: list[str] = [
        *FLAGS,
        *SANITIZERS,
        f"-I{KERNEL}",
        f"-I{FUZZING}",
        f"-I{Path(found.origin).parent / 'c-code'}",
    ]
    for source in sorted(KERNEL.glob("*.c")):
        objects.append(folder / f"{source.stem}.o")
        subprocess.run(
            [clang, *flags, "-fsanitize=fuzzer-no-link", "-c", source, "-o", objects[-1]],
            check=True,
        )
    for name in names:
        sources = [FUZZING / file for file in TARGETS[name]]
        command: list[str | Path] = [
            clang,
            *flags,
            "-DLIBFUZZER",
            "-fsanitize=fuzzer",
            *DEFINITIONS.get(name, []),
            *sources,
            *objects,
        ]
        subprocess.run([*command, "-o", folder / name, "-lm"], check=True)


def resources(folder: Path) -> dict[str, str]:
    """Environment with the smallest span's resources, unpacked."""
    scene = gf.load_scene("example3").with_values({"numerics.elements": 2})
    with zipfile.ZipFile(gf.export_fmu(scene, folder / "span.fmu")) as archive:
        archive.extract("resources/model.bin", folder)
    guid = identify(scene.to_toml(), version(), "native").guid
    return {**os.environ, "RESOURCES": (folder / "resources").as_uri(), "GUID": guid}


def fuzz(
    name: str, folder: Path, environment: dict[str, str], executions: int, seconds: int
) -> tuple[int, bool]:
    """Run one target; executions done, and whether nothing broke."""
    grown = folder / f"{name}.corpus"
    grown.mkdir(exist_ok=True)
    corpus = CORPUS / name.rstrip("3")
    seeds = [corpus] if corpus.is_dir() else []
    length = LONGEST * (10 if name.startswith("sequence") else 1)
    options = [
        f"-max_len={length}",
        "-timeout=60",
        "-print_final_stats=1",
        f"-artifact_prefix={folder / name}-",
    ]
    limits = [f"-runs={executions}" if executions else "-runs=-1", f"-max_total_time={seconds}"]
    command: list[str | Path] = [folder / name, grown, *seeds, *options, *limits]
    done = subprocess.run(command, env=environment, stderr=subprocess.PIPE, text=True)
    counted = re.search(r"number_of_executed_units: (\d+)", done.stderr)
    if done.returncode:
        print(done.stderr[-3000:], file=sys.stderr)
    return int(counted[1]) if counted else 0, done.returncode == 0


def keep(name: str, folder: Path, environment: dict[str, str]) -> None:
    """Replace the corpus by the smallest set with the same coverage, short inputs first."""
    merged, place = folder / f"{name}.merged", CORPUS / name
    merged.mkdir(exist_ok=True)
    place.mkdir(parents=True, exist_ok=True)
    command: list[str | Path] = [
        folder / name,
        "-merge=1",
        merged,
        place,
        folder / f"{name}.corpus",
    ]
    subprocess.run(command, env=environment, stderr=subprocess.DEVNULL, check=True)
    for file in place.iterdir():
        file.unlink()
    files = sorted(merged.iterdir(), key=lambda file: (file.stat().st_size, file.name))
    for k in range(min(KEPT, len(files))):
        file = files[k * len(files) // min(KEPT, len(files))]
        shutil.copy(file, place / file.name[:12])


def main() -> int:
    """Build, run, and write the tally."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--target", choices=TARGETS, action="append", help="as often as needed; else all"
    )
    parser.add_argument(
        "--executions", type=int, default=0, help="of each target; else until its time is over"
    )
    parser.add_argument("--seconds", type=int, default=600, help="at most, for each target")
    parser.add_argument(
        "--folder", type=Path, default=Path("fuzzing"), help="for programs, inputs and findings"
    )
    parser.add_argument("--keep", action="store_true", help="replace the corpus in the repository")
    asked = parser.parse_args()
    names, folder = asked.target or list(TARGETS), asked.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    environment = resources(folder)
    compile_targets(names, folder)
    tally = {
        name: fuzz(name, folder, environment, asked.executions, asked.seconds) for name in names
    }
    if asked.keep:
        for name in names:
            keep(name, folder, environment)
    for name, (executions, sound) in tally.items():
        print(
            f"{name:10s} {executions:10d} executions "
            f" {'nothing found' if sound else f'BROKEN: see {folder}'}"
        )
    print(f"{'all':10s} {sum(executions for executions, _ in tally.values()):10d} executions")
    return int(not all(sound for _, sound in tally.values()))


if __name__ == "__main__":
    sys.exit(main())
