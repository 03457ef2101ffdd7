"""Build one wheel per platform; test the one for this platform in an empty environment.

    pip install ".[cross,wheels]"
    python tools/wheels.py dist

The kernel knows nothing of Python, so a wheel is tagged py3-none and serves every Python 3. That of
this platform is built by its own compiler; on Linux, auditwheel finds the oldest glibc that it runs
with. The others are the same wheel with the library that Zig compiles, as for `gallop-fmu export
--platforms`; they are not run here.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import venv
from pathlib import Path

from gallop_fmu.fmu.cross_compile import PLATFORMS, cross_library

ROOT = Path(__file__).parent.parent
TAGS = {"win64": "win_amd64", "darwin64": "macosx_11_0_universal2"}
HERE = {"linux": "linux64", "win32": "win64", "darwin": "darwin64"}[sys.platform]
TRIAL = """
import gallop_fmu as gf, modal
result = gf.simulate(gf.load_scene("example3"), stop_time=1.0)
ratio = modal.frequency_ratio(gf.load_scene("example3")).ratio
print(gf.__file__, result.outcome.name, round(ratio, 3))
"""


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    target = Path(sys.argv[1]).absolute()
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        own = own_wheel(work, target)
        print(own.name)
        for platform, tag in TAGS.items():
            if platform != HERE:
                print(other_wheel(own, platform, tag, work, target).name)
        try_out(own, work)


def own_wheel(work: Path, target: Path) -> Path:
    """The wheel of this platform."""
    run(
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--quiet",
        "--no-deps",
        "--wheel-dir",
        str(work / "built"),
        str(ROOT),
    )
    (built,) = (work / "built").glob("*-py3-none-*.whl")
    if HERE != "linux64":
        return built.replace(target / built.name)
    run(
        sys.executable,
        "-m",
        "auditwheel",
        "repair",
        "--plat",
        "auto",
        "--wheel-dir",
        str(work / "linux"),
        str(built),
    )
    (repaired,) = (work / "linux").glob("*-py3-none-manylinux*.whl")
    return repaired.replace(target / repaired.name)


def other_wheel(own: Path, platform: str, tag: str, work: Path, target: Path) -> Path:
    """The same wheel with the library of another platform."""
    run(sys.executable, "-m", "wheel", "unpack", "--dest", str(work / platform), str(own))
    (content,) = (work / platform).iterdir()
    (content / "gallop_fmu" / f"gallop_kernel{PLATFORMS[HERE].suffix}").unlink()
    (content / "gallop_fmu" / f"gallop_kernel{PLATFORMS[platform].suffix}").write_bytes(
        cross_library(platform)
    )
    (work / f"{platform}-packed").mkdir()
    run(
        sys.executable,
        "-m",
        "wheel",
        "pack",
        "--dest-dir",
        str(work / f"{platform}-packed"),
        str(content),
    )
    (packed,) = (work / f"{platform}-packed").iterdir()
    run(sys.executable, "-m", "wheel", "tags", "--remove", "--platform-tag", tag, str(packed))
    (tagged,) = (work / f"{platform}-packed").iterdir()
    return tagged.replace(target / tagged.name)


def try_out(wheel: Path, work: Path) -> None:
    """Install into an empty environment, and use it from a folder where the sources are not."""
    venv.create(work / "empty", with_pip=True)
    scripts = work / "empty" / ("Scripts" if sys.platform == "win32" else "bin")
    run(str(scripts / "pip"), "install", "--quiet", str(wheel))
    print(run(str(scripts / "python"), "-c", TRIAL, folder=work).strip())
    run(str(scripts / "gallop-fmu"), "export", "example3", "-o", "tried.fmu", folder=work)
    print(
        run(str(scripts / "gallop-fmu"), "check", "tried.fmu", folder=work).strip().splitlines()[-1]
    )


def run(*command: str, folder: Path | None = None) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


if __name__ == "__main__":
    main()
