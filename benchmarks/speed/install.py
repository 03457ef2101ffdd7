"""Time and size of `pip install .` in fresh environments, for revisions of this repository.

Each revision is exported by git, built and installed without pip's cache, with the newest
dependencies. The time includes the compilation of the kernel; most of it is the download and
unpacking of the dependencies.

Usage: python benchmarks/speed/install.py [REVISION ...]    (default: HEAD)
"""

from __future__ import annotations

import io
import subprocess
import sys
import tarfile
import tempfile
import time
import venv
from pathlib import Path

ROOT = Path(__file__).parents[2]
LARGEST = 6
OF_PIP = {"pip", "setuptools", "pkg_resources", "_distutils_hack"}


def main() -> None:
    """Print a row for each revision, then the largest packages of the last one."""
    print("| Revision | Packages | Size [MB] | Time [s] |\n| --- | --- | --- | --- |")
    sizes: dict[str, float] = {}
    for revision in sys.argv[1:] or ["HEAD"]:
        seconds, packages, sizes = install(revision)
        print(
            f"| {revision} | {packages} | {sum(sizes.values()):.0f} | {seconds:.0f} |", flush=True
        )
    largest = sorted(sizes, key=lambda name: -sizes[name])[:LARGEST]
    print("\nLargest: " + ", ".join(f"{name} {sizes[name]:.0f} MB" for name in largest))


def install(revision: str) -> tuple[float, int, dict[str, float]]:
    """Install a revision; return the seconds, the number of packages and MB by folder."""
    with tempfile.TemporaryDirectory() as folder:
        source, place = Path(folder, "source"), Path(folder, "venv")
        archive = subprocess.run(
            ["git", "-C", ROOT, "archive", revision], check=True, capture_output=True
        )
        with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as files:
            files.extractall(source, filter="data")
        venv.create(place, with_pip=True)
        python = place / ("Scripts" if sys.platform == "win32" else "bin") / "python"
        began = time.perf_counter()
        subprocess.run(
            [python, "-m", "pip", "install", "--quiet", "--no-cache-dir", source], check=True
        )
        seconds = time.perf_counter() - began
        (packages,) = place.rglob("site-packages")
        sizes: dict[str, float] = {}
        for file in packages.rglob("*"):
            name = file.relative_to(packages).parts[0].removesuffix(".libs")
            if file.is_file() and name.split("-")[0] not in OF_PIP:
                sizes[name] = sizes.get(name, 0.0) + file.stat().st_size / 1e6
        count = sum(
            1 for info in packages.glob("*.dist-info") if info.name.split("-")[0] not in OF_PIP
        )
        return seconds, count, sizes


if __name__ == "__main__":
    main()
