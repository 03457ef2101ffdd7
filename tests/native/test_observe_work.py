"""An observation computes only what its probes name, and once for all of them."""

import subprocess
from pathlib import Path

EXPECTED = {  # forces at a junction, energies, tensions, attack angles
    "motion, wind, counts of the last step": "0 0 0 0",
    "tension of a middle node": "0 0 1 0",
    "attack angle": "0 0 0 1",
    "two junctions in turn": "2 0 0 0",
    "a junction between others": "1 0 0 0",
    "both energies, one twice": "0 1 0 0",
}


def test_an_observation_computes_only_what_its_probes_name(compiled, kernel_sources, tmp_path):
    source = Path(__file__).with_name("observe_work.c")
    program = compiled(tmp_path / "observe_work", source, flags=[f"-I{kernel_sources}"])
    done = subprocess.run([program], capture_output=True, text=True, check=True)
    assert dict(zip(EXPECTED, done.stdout.splitlines(), strict=True)) == EXPECTED
