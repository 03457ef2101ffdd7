"""Random sequences of legal and illegal calls under the address and undefined-behaviour sanitizers.

The driver `sequence.c` knows the state machine of FMI 2.0 and aborts where the library does not
keep to it; the sanitizers abort at the first wrong access, undefined operation or leak.
"""

import random
import struct
import subprocess
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

SEQUENCES = 60  # in each batch, about 150 calls each
BATCHES = 3
FIXED = settings(max_examples=BATCHES, derandomize=True, deadline=None, phases=[Phase.generate])


@pytest.fixture(scope="module")
def driver(sanitized, small):
    program = sanitized(
        "sequence", *sorted((Path(__file__).parents[2] / "fuzz").glob("sequence*.c"))
    )

    def run(seed, *forgeries):
        chance = random.Random(seed)
        sizes = [chance.randrange(50, 2000) for _ in range(SEQUENCES)]
        batch = b"".join(struct.pack("<H", size) + chance.randbytes(size) for size in sizes)
        command = [program, small.resources.as_uri(), small.guid, *forgeries]
        done = subprocess.run(
            list(map(str, command)), input=batch, capture_output=True, timeout=120
        )
        assert done.returncode == 0, done.stderr.decode()
        calls, messages = (int(word) for word in done.stdout.split() if word.isdigit())
        assert calls > 4000
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
