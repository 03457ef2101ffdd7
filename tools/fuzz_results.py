"""Fuzzes what reads the files of a sweep: NetCDF, Parquet and the journal, each with its bytes changed at random.

    python tools/fuzz_results.py --executions 2000      # of each kind
    python tools/fuzz_results.py --kind nc --seconds 600 --seed 7

Each file is read as the package does it, but in a fork of this process, which is much faster than a new one. A file
that is accepted must hold what was written, to the bit; else it must be refused. That HDF5 or Arrow crash, do not end
or want too much memory is counted: in the package that ends the process that reads, and refuses the file. An input
that breaks something stays in the working folder. The exit code is 1 then.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import h5py  # noqa: F401, before the fork
from pyarrow import parquet  # noqa: F401

from gallop_fmu import reading, store
from gallop_fmu.errors import SceneError

KINDS = {"nc": "runs.nc", "parquet": "runs.parquet", "journal": "runs.nc.journal"}
SECONDS = 5
"""Time that reading may take here."""
ODD = [b"\0", b"\xff", b"\x7f", b"\x80", b"\x01", b"\n", b"\t", b"9", b"\0" * 8, b"\xff" * 8, b"\xff\xff\xff\x7f"]


def sweep_rows(count: int) -> tuple[dict[str, Any], list[store.Row]]:
    """Header and rows with numbers, truths, texts and gaps."""
    winds = [4.0 + 0.1 * run for run in range(count)]
    header = {"format": store.FORMAT, "package": "p", "task": "t", "scenes": "s", "runs": count}
    header |= {"grid": {"wind.speed": winds}, "columns": {"sag": ["m", "sag"]}}
    rows = [
        {
            "run": run,
            "wind.speed": winds[run],
            "outcome": "slack" if run % 3 else "completed",
            "message": run * "no ",
            "sag": None if run % 4 == 0 else 1.0 / (run + 1.0),
            "steps": 10**run,
            "swings": run % 2 == 0,
        }
        for run in range(count)
    ]
    return header, rows


def changed(content: bytes, chance: random.Random) -> bytes:
    """Bits and bytes changed, copied, taken out, put in, or cut off."""
    bytes_now = bytearray(content)
    for _ in range(chance.choice([1, 1, 1, 2, 4, 16])):
        at, how = chance.randrange(len(bytes_now) + 1), chance.randrange(8)
        length = chance.choice([1, 1, 4, 8, 64])
        if how < 3 and at < len(bytes_now):
            bytes_now[at] ^= 1 << chance.randrange(8)
        elif how == 3:
            odd = chance.choice(ODD)
            bytes_now[at : at + len(odd)] = odd
        elif how == 4:
            bytes_now[at : at + length] = chance.randbytes(length)
        elif how == 5:
            start = chance.randrange(len(content))
            bytes_now[at : at + length] = content[start : start + length]
        elif how == 6:
            del bytes_now[at : at + length]
        elif chance.random() < 0.2:
            del bytes_now[at:]
    return bytes(bytes_now)


def read_and_judge(path: Path, kind: str, wanted: dict[int, store.Row]) -> str:
    """``refused``, ``same`` or what is wrong."""
    try:
        if kind == "journal":
            found = store._read_journal(path)
        else:
            found = store._found(b"".join(reading._lines(path)))
    except (SceneError, reading.UnreadableError):
        return "refused"
    except Exception:
        if kind == "journal":
            raise
        return "refused"  # the process that reads ends, and the file is refused
    if found is None:
        return "refused"
    cut = kind == "journal" and found.rows == {run: wanted[run] for run in found.rows}
    return "same" if cut or found.rows == wanted else "ANOTHER CONTENT"


def in_a_fork(path: Path, kind: str, wanted: dict[int, store.Row]) -> str:
    """The same where crashes and hangs harm nobody."""
    told, says = os.pipe()
    child = os.fork()
    if child == 0:
        answer = "AN ERROR THAT IS NONE OF OURS"
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            signal.alarm(SECONDS)
            reading._limit_memory(reading.ROOM)
            answer = read_and_judge(path, kind, wanted)
        finally:
            os.write(says, answer.encode())
            os._exit(0)
    os.close(says)
    with os.fdopen(told) as text:
        answer = text.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return answer if status == 0 else f"ended by {signal.Signals(-status).name}"


def fuzz(kind: str, folder: Path, chance: random.Random, executions: int, seconds: float) -> Counter[str]:
    """Change and read one kind of file; how often each answer came."""
    header, rows = sweep_rows(12)
    begun = store.Store(folder / (KINDS[kind] if kind != "journal" else "runs.nc"), header)
    begun.add(rows)
    if kind != "journal":
        begun.renew()
    begun.release()
    path = folder / KINDS[kind]
    good = path.read_bytes()
    lines = good if kind == "journal" else b"".join(reading._lines(path))
    wanted = store._found(lines).rows
    counted: Counter[str] = Counter()
    until = time.monotonic() + seconds
    while sum(counted.values()) < executions and time.monotonic() < until:
        content = changed(good, chance)
        path.write_bytes(content)
        answer = in_a_fork(path, kind, wanted)
        if answer.isupper() or (kind == "journal" and answer.startswith("ended")):
            (folder / f"{kind}-{sum(counted.values())}").write_bytes(content)
        counted[answer] += 1
    return counted


def main() -> int:
    """Run, and write the tally."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--kind", choices=KINDS, action="append", help="as often as needed; else all")
    parser.add_argument("--executions", type=int, default=10**9, help="of each kind; else until its time is over")
    parser.add_argument("--seconds", type=float, default=600.0, help="at most, for each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, help="for files and findings; else a new one")
    asked = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    folder = asked.folder or Path(tempfile.mkdtemp(prefix="results_"))
    broken = False
    for kind in asked.kind or KINDS:
        (folder / kind).mkdir(parents=True, exist_ok=True)
        counted = fuzz(kind, folder / kind, random.Random(f"{asked.seed} {kind}"), asked.executions, asked.seconds)
        wrong = any(answer.isupper() or (kind == "journal" and answer.startswith("ended")) for answer in counted)
        broken = broken or wrong
        told = ", ".join(f"{answer} {count}" for answer, count in counted.most_common())
        print(f"{kind:8s} {sum(counted.values()):8d} executions: {told}{f'  BROKEN: see {folder}' if wrong else ''}")
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
