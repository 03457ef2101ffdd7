"""Random sequences of legal and illegal calls under the address and undefined-behaviour sanitizers.

The driver `sequence.c` knows the state machine of both versions of FMI and aborts where the library
does not keep to it; the sanitizers abort at the first wrong access, undefined operation or leak.
"""

import random
import struct
import subprocess
import tomllib
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from gallop_fmu.scene.line_scene import LineScene

SEQUENCES, BATCHES = 65, 3
"""Of one test; each version of FMI gets more than 2 * 3 * 65 * 130 = 50,000 calls in a run."""
FIXED = settings(max_examples=BATCHES, derandomize=True, deadline=None, phases=[Phase.generate])


LINE = {
    "title": "Two spans of a twin bundle",
    "section": {
        "horizontal_tension": 15000.0,
        "spans": [{"length": 125.88}, {"length": 110.0, "height_difference": 4.0}],
        "suspensions": [{"kind": "string", "length": 2.1, "weight": 490.0}],
    },
    "bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 1},
    "wind": {"speed": 5.5},
}
"""With the conductor, coefficient curve and numerics of example 3."""


CASES = {"FMI 2.0, a span": (2, "span"), "FMI 2.0, a line": (2, "line"), "FMI 3.0": (3, "span")}


@pytest.fixture(scope="module")
def programs(sanitized):
    """The driver for each version of FMI."""
    sources = sorted((Path(__file__).parents[2] / "fuzz").glob("sequence*.c"))
    return {
        2: sanitized("sequence", *sources),
        3: sanitized("sequence3", *sources, flags=["-DFMI3"]),
    }


@pytest.fixture(scope="module", params=CASES)
def exported(request, programs, small, small_scene, unpack):
    """Driver, FMU, and the number of sequences in a batch; those of a line take longer."""
    version, kind = CASES[request.param]
    program = programs[version]
    if kind == "span":
        return program, small, SEQUENCES
    data = tomllib.loads(small_scene.to_toml())
    scene = LineScene.from_dict(
        {name: data[name] for name in ("conductor", "ice", "aerodynamics", "numerics")} | LINE
    )
    return program, unpack(scene.with_values({"numerics.elements": 2})), SEQUENCES // 5


@pytest.fixture(scope="module")
def driver(exported):
    program, fmu, sequences = exported

    def run(seed, *forgeries):
        chance = random.Random(seed)
        sizes = [chance.randrange(50, 2000) for _ in range(sequences)]
        batch = b"".join(struct.pack("<H", size) + chance.randbytes(size) for size in sizes)
        command = [program, fmu.resources.as_uri(), fmu.guid, *forgeries]
        done = subprocess.run(
            list(map(str, command)), input=batch, capture_output=True, timeout=120
        )
        assert done.returncode == 0, done.stderr.decode()
        calls, messages = (int(word) for word in done.stdout.split() if word.isdigit())
        assert calls > 130 * sequences  # 138 at least
        assert 0.2 * calls < messages < 0.9 * calls  # both legal and illegal ones

    return run


@FIXED
@given(seed=st.integers(0, 2**32))
def test_calls_are_accepted_and_refused_as_in_the_standard(driver, seed):
    driver(seed)


@FIXED
@given(seed=st.integers(0, 2**32))
def test_forged_resources_break_nothing(driver, tmp_path_factory, seed):
    driver(seed, tmp_path_factory.mktemp("forged"))
