"""Run FMPy's command on FMUs of all kinds many times, and count how the processes end.

    python benchmarks/hosts/exits.py [times]

The exit code is 1 if a process ends with another code than 0 or writes to its error stream.
"""

import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import gallop_fmu as gf

TIMES = 50
COMMAND = "import sys; from fmpy.cli import main; sys.argv[0] = 'fmpy'; main()"


def main() -> int:
    times = int(sys.argv[1]) if len(sys.argv) > 1 else TIMES
    scene = gf.load_scene("example3")
    sound = True
    with tempfile.TemporaryDirectory() as folder:
        for runtime, fmi in (("native", 2), ("native", 3), ("python", 2)):
            path = Path(folder) / f"{runtime}{fmi}.fmu"
            gf.export_fmu(scene, path, runtime=runtime, fmi=fmi)
            for action in (["validate"], ["simulate", "--stop-time", "1"]):
                command = [sys.executable, "-P", "-c", COMMAND, *action, str(path)]
                ends: Counter[str] = Counter()
                for _ in range(times):
                    done = subprocess.run(command, capture_output=True, text=True)
                    ends[f"exit {done.returncode}{', with errors' if done.stderr else ''}"] += 1
                sound = sound and set(ends) == {"exit 0"}
                counts = "; ".join(f"{count} x {end}" for end, count in ends.items())
                print(f"fmpy {action[0]:8} FMI {fmi}.0 {runtime:6} {counts}", flush=True)
    return int(not sound)


if __name__ == "__main__":
    sys.exit(main())
