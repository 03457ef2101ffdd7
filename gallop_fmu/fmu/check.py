"""Checking an FMU: archive, model description, and a short run in a process of its own."""

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

TRIAL_SECONDS = 300
"""Time given to the short run, loading included."""
MOST_OUTPUT = 65_536
"""Bytes that are kept of what the short run says."""


class CheckRow(NamedTuple):
    """One check: its name, whether it was passed, and what was found."""

    name: str
    ok: bool
    detail: str


@dataclass
class FmuCheck:
    """What `check_fmu` found."""

    path: Path
    rows: list[CheckRow] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Whether all checks were passed."""
        return all(row.ok for row in self.rows)

    def add(self, name: str, problem: str, good: str) -> bool:
        """Append a row; an empty problem is a pass."""
        self.rows.append(CheckRow(name, not problem, problem or good))
        return not problem


def check_fmu(path: str | os.PathLike[str]) -> FmuCheck:
    """Check an FMU without trusting it.

    The archive is looked at before anything is unpacked, the description is validated with FMPy,
    every Real must have a unit, and a short run looks for finite outputs and for a rollback that
    repeats a step bit for bit. The run executes the FMU's code, in a process of its own, so a crash
    is a result like any other.

    Parameters
    ----------
    path
        The FMU.

    Returns
    -------
    FmuCheck
        The checks made; those that a failed one makes pointless are missing. A file that is no FMU
        is a failed check, not an exception.
    """
    check = FmuCheck(Path(path))
    if not check.add("archive", archive_problem(check.path), "a sound ZIP archive"):
        return check
    description = _read_description(check)
    if description is None:
        return check
    reals = [variable for variable in description.modelVariables if variable.type == "Real"]
    bare = [variable.name for variable in reals if _declared_unit(variable) is None]
    missing = f"{len(bare)} without, such as {', '.join(bare[:3])}" if bare else ""
    check.add("units", missing, f"all {len(reals)} Reals have one")
    if check.add("platform", _platform_problem(check.path), "has a binary for this one"):
        _try_out(check)
    return check


def _read_description(check: FmuCheck) -> Any:
    """FMPy's model description, or None if it is of no use."""
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
    wrong = description.fmiVersion != "2.0" or description.coSimulation is None
    check.add(
        "kind",
        f"{found}; FMI 2.0 for co-simulation is needed" if wrong else "",
        "FMI 2.0 for co-simulation",
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


def _try_out(check: FmuCheck) -> None:
    """A short run in a process of its own, which leaves its findings in a file as lines of JSON."""
    with tempfile.TemporaryDirectory(prefix="fmu_", ignore_cleanup_errors=True) as folder:
        code, said = _run_trial(check.path, folder)
        with (
            suppress(FileNotFoundError),
            Path(folder, FINDINGS).open(encoding="utf-8", errors="replace") as file,
        ):
            for line in file.read(MOST_OUTPUT).splitlines():
                with suppress(ValueError, TypeError):  # the FMU, too, can write into the file
                    check.add(*map(str, json.loads(line)))
    if code is None:
        check.add("run", f"not finished after {TRIAL_SECONDS} s", "")
        return
    if code == 0 and all(row.name != "run" for row in check.rows):
        check.add("run", "the FMU ended the process before its steps were made", "")
    ending = f"stopped by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
    check.add(
        "process", " ".join([ending, *said.splitlines()[-1:]]) if code else "", "ended cleanly"
    )


def _run_trial(path: Path, folder: str) -> tuple[int | None, str]:
    """Exit code, None if the time is over, and the end of what was said on the error stream.

    An FMU may print without end: its output is not kept, and of its error stream only the last
    `MOST_OUTPUT` bytes are.
    """
    code = "import sys; from gallop_fmu.fmu.smoke_test import main; main(*sys.argv[1:])"
    command = [sys.executable, "-P", "-c", code, str(path.resolve()), folder]
    # A user who makes warnings errors does not mean those of the packages that the trial imports.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONWARNINGS"}
    end = bytearray()

    def keep_the_end(stream: IO[bytes]) -> None:
        while chunk := stream.read1(MOST_OUTPUT):  # type: ignore[attr-defined]
            end.extend(chunk)
            del end[:-MOST_OUTPUT]

    with subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        reader = Thread(target=keep_the_end, args=(process.stderr,), daemon=True)
        reader.start()
        try:
            exit_code = process.wait(TRIAL_SECONDS)
        except subprocess.TimeoutExpired:
            exit_code = None
        finally:
            process.kill()
            reader.join(5.0)  # a process that the FMU started may hold the stream open
    return exit_code, end.decode(errors="replace").strip()
