"""Check of an FMU: archive, model description, and a short run in a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from typing import IO, Any, NamedTuple

from gallop_fmu.fmu.archive_safety import archive_problem
from gallop_fmu.fmu.smoke_test import FINDINGS
from gallop_fmu.fmu.trial_instance import REALS

MAX_RUN_SECONDS = 300
"""Longest duration [s] of the short run, loading included."""
VERSIONS = ("2.0", "3.0")
"""Versions of FMI that can be checked."""
MAX_OUTPUT = 65_536
"""Bytes of the short run's output that are kept."""


class CheckRow(NamedTuple):
    """One check: its name, True if it was passed, and the finding."""

    name: str
    ok: bool
    detail: str


@dataclass
class FmuCheck:
    """Findings of `check_fmu`."""

    path: Path
    rows: list[CheckRow] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Return True if all checks were passed."""
        return all(row.ok for row in self.rows)

    def add(self, name: str, problem: str, good: str) -> bool:
        """Append a row; an empty problem means that the check was passed."""
        self.rows.append(CheckRow(name, not problem, problem or good))
        return not problem


def check_fmu(path: str | os.PathLike[str]) -> FmuCheck:
    """Check an FMU without trusting it.

    The archive is checked before anything is unpacked, the description is validated with FMPy,
    every real variable must have a unit, and a short run looks for finite outputs, for a rollback
    that repeats a step bit for bit, for the functions of the standard and, if the FMU has a
    reference result, for the same values. The run executes the FMU's code, in a process of its own,
    so a crash is a result like any other.

    Parameters
    ----------
    path
        The FMU.

    Returns
    -------
    FmuCheck
        The checks made; those that a failed one makes pointless are missing. For a file that is
        not an FMU a check fails, without an exception.
    """
    check = FmuCheck(Path(path))
    if not check.add("archive", archive_problem(check.path), "a sound ZIP archive"):
        return check
    description = _read_description(check)
    if description is None:
        return check
    reals = [variable for variable in description.modelVariables if variable.type in REALS]
    bare = [variable.name for variable in reals if _declared_unit(variable) is None]
    missing = f"{len(bare)} without, such as {', '.join(bare[:3])}" if bare else ""
    check.add("units", missing, f"all {len(reals)} real variables have one")
    if check.add("platform", _platform_problem(check.path), "has a binary for this one"):
        _check_run(check)
    return check


def _read_description(check: FmuCheck) -> Any:
    """Return FMPy's model description, or None if it cannot be used."""
    from fmpy import read_model_description
    from fmpy.validation import validate_fmu

    problems = validate_fmu(str(check.path))
    check.add("description", "; ".join(problems), "FMPy's validation finds nothing")
    try:
        description = read_model_description(str(check.path), validate=False)
    except Exception as problem:
        check.add("kind", f"the description cannot be read ({problem})", "")
        return None
    found = f"FMI {description.fmiVersion}" + (
        "" if description.coSimulation else ", not for co-simulation"
    )
    wrong = description.fmiVersion not in VERSIONS or description.coSimulation is None
    check.add(
        "kind",
        f"{found}; FMI 2.0 or 3.0 for co-simulation is needed" if wrong else "",
        f"FMI {description.fmiVersion} for co-simulation",
    )
    return None if wrong else description


def _declared_unit(variable: Any) -> str | None:
    unit = variable.unit or (
        variable.declaredType.unit if variable.declaredType is not None else None
    )
    return None if unit is None else str(unit)


def _platform_problem(path: Path) -> str:
    from fmpy import platform, supported_platforms

    platforms = supported_platforms(str(path))
    return (
        ""
        if platform in platforms
        else f"no binary for {platform}; there are {', '.join(platforms) or 'none'}"
    )


def _check_run(check: FmuCheck) -> None:
    """Make a short run in a process of its own, which writes its findings as lines of JSON."""
    with tempfile.TemporaryDirectory(prefix="fmu_", ignore_cleanup_errors=True) as folder:
        code, errors = _run_in_process(check.path, folder)
        with (
            suppress(FileNotFoundError),
            Path(folder, FINDINGS).open(encoding="utf-8", errors="replace") as file,
        ):
            for line in file.read(MAX_OUTPUT).splitlines():
                with suppress(ValueError, TypeError):  # the FMU can write into the file, too
                    check.add(*map(str, json.loads(line)))
    if code is None:
        check.add("run", f"not finished after {MAX_RUN_SECONDS} s", "")
        return
    if code == 0 and all(row.name != "run" for row in check.rows):
        check.add("run", "the FMU ended the process before its steps were made", "")
    ending = f"stopped by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
    check.add(
        "process", " ".join([ending, *errors.splitlines()[-1:]]) if code else "", "ended cleanly"
    )


def _run_in_process(path: Path, folder: str) -> tuple[int | None, str]:
    """Return the exit code, None after a timeout, and the end of the error stream.

    An FMU may print endlessly: its output is discarded, and of its error stream the last
    `MAX_OUTPUT` bytes are kept.
    """
    code = "import sys; from gallop_fmu.fmu.smoke_test import main; main(*sys.argv[1:])"
    command = [sys.executable, "-P", "-c", code, str(path.resolve()), folder]
    # The user's setting "warnings are errors" is not for the packages that the run imports.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONWARNINGS"}
    end = bytearray()

    def keep_the_end(stream: IO[bytes]) -> None:
        while chunk := stream.read1(MAX_OUTPUT):  # type: ignore[attr-defined]
            end.extend(chunk)
            del end[:-MAX_OUTPUT]

    with subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        reader = Thread(target=keep_the_end, args=(process.stderr,), daemon=True)
        reader.start()
        try:
            exit_code = process.wait(MAX_RUN_SECONDS)
        except subprocess.TimeoutExpired:
            exit_code = None
        finally:
            process.kill()
            reader.join(5.0)  # a process that the FMU started may keep the stream open
    return exit_code, end.decode(errors="replace").strip()
