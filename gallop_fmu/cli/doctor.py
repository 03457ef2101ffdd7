"""The command ``gallop-fmu doctor``: what is installed, what is missing, and what it is for."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution, version
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, NamedTuple

PROGRAM = "gallop-fmu"
EXTRAS = {
    "parquet": "results and sweeps as .parquet files",
    "cluster": "sweeps on a Dask cluster",
    "cross": "FMUs for other platforms (export --platforms)",
}
"""Extras for users, and what they are for."""

State = Literal["ok", "missing", "fault"]


class Check(NamedTuple):
    """What was found about one thing.

    Attributes
    ----------
    name : str
        The thing that was checked.
    state : {"ok", "missing", "fault"}
        ``missing``: an optional package; ``fault``: the program does not work as installed.
    found : str
        What was found, and what to do if it is not in order.
    """

    name: str
    state: State
    found: str


def check_installation() -> list[Check]:
    """Check packages, kernel and FMU export; every fault comes with its remedy."""
    return [
        Check("Python", "ok", f"{platform.python_version()} at {sys.executable}"),
        Check("system", "ok", f"{platform.system()} {platform.release()}, {platform.machine()}"),
        *_packages(),
        _modal(),
        _kernel(),
        _simulation(),
        _fmu(),
    ]


def _packages() -> Iterator[Check]:
    """Check the required packages, then those of the extras for users."""
    from packaging.requirements import Requirement

    try:
        wanted = [Requirement(text) for text in distribution(PROGRAM).requires or ()]
    except PackageNotFoundError:
        yield Check(PROGRAM, "fault", "not installed; run `pip install .` in the source folder")
        return
    yield Check(PROGRAM, "ok", version(PROGRAM))
    for need in wanted:
        extra = next(
            (name for name in EXTRAS if need.marker and need.marker.evaluate({"extra": name})), None
        )
        if need.marker and extra is None:
            continue
        try:
            found = version(need.name)
        except PackageNotFoundError:
            found = ""
        yield _package(need.name, str(need.specifier), found, extra)


def _package(name: str, wanted: str, found: str, extra: str | None) -> Check:
    """Judge a package: its installed version, empty if there is none, and the wanted ones."""
    from packaging.specifiers import SpecifierSet

    purpose = f"for {EXTRAS[extra]}" if extra else "required"
    remedy = f'pip install "{PROGRAM}[{extra}]"' if extra else f'pip install "{name}{wanted}"'
    if not found:
        return Check(name, "missing" if extra else "fault", f"not installed ({purpose}): {remedy}")
    if not SpecifierSet(wanted).contains(found, prereleases=True):
        return Check(name, "fault", f"{found}, but {wanted} is needed ({purpose}): {remedy}")
    return Check(name, "ok", found)


def _modal() -> Check:
    """Check that the import name ``modal`` is this program's and not the cloud client's."""
    import gallop_fmu

    spec = find_spec("modal")
    places = (
        [Path(place).parent for place in (spec.submodule_search_locations or ())] if spec else []
    )
    ours = [Path(place).parent for place in gallop_fmu.__path__]
    if any(place in ours for place in places):
        return Check("modal", "ok", "the toolkit of this program")
    found = f"is {places[0] / 'modal'}" if places else "is not found"
    return Check(
        "modal",
        "fault",
        f"{found}, not the toolkit of this program; another package has this import name, too:"
        " use an environment without it",
    )


def _kernel() -> Check:
    """Check that the kernel can be loaded."""
    try:
        from gallop_fmu.engine.library import API_VERSION, arithmetic, library_path

        path = library_path()
        numbers = f"{arithmetic(portable=False)} arithmetic"
    except (ImportError, OSError) as problem:
        return Check("kernel", "fault", str(problem))
    size = path.stat().st_size / 1024
    return Check("kernel", "ok", f"API {API_VERSION}, {numbers}, {size:.0f} kB, {path}")


def _simulation() -> Check:
    """Check a run of 100 s."""
    try:
        from gallop_fmu.input.scene_files import load_scene
        from gallop_fmu.simulation.simulate import simulate

        result = simulate(load_scene("example3"), stop_time=100.0)
    except Exception as problem:  # whatever is wrong, the other checks go on
        return Check("simulation", "fault", f"example3 does not run: {problem}")
    factor = float(result.numbers()["real_time_factor"])  # type: ignore[arg-type]
    return Check("simulation", "ok", f"100 s of example3, {factor:.0f} times as fast as real time")


def _fmu() -> Check:
    """Check that an FMU can be exported, and passes the checks of ``gallop-fmu check``."""
    from tempfile import TemporaryDirectory

    try:
        from gallop_fmu.fmu import check_fmu, export_fmu
        from gallop_fmu.input.scene_files import load_scene

        with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            found = check_fmu(export_fmu(load_scene("example3"), Path(folder) / "example3.fmu"))
    except Exception as problem:
        return Check("FMU", "fault", f"example3 cannot be exported: {problem}")
    failed = "; ".join(f"{row.name}: {row.detail}" for row in found.rows if not row.ok)
    if failed:
        return Check("FMU", "fault", f"the FMU of example3 fails a check: {failed}")
    return Check("FMU", "ok", "example3 exported and run in a process of its own")
