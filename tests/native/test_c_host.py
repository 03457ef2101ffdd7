"""The FMU in a C host gives simulate()'s bits: alone, in threads, and from saved states."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

import gallop_fmu as gf

STOP, STEP = 20.0, 0.01
CHANNELS = {
    "midspan.x2": "u2",
    "midspan.x3": "u3",
    "midspan.theta": "theta",
    "midspan.tension": "tension",
}


@pytest.fixture(scope="module")
def host(compiled, tmp_path_factory, fmu):
    program = compiled(tmp_path_factory.mktemp("host") / "host", Path(__file__).with_name("host.c"))

    def run(what, steps, *arguments):
        command = [program, what, fmu.library, fmu.resources.as_uri(), fmu.guid, steps, *arguments]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return np.array(
            [[float.fromhex(word) for word in line.split()] for line in done.stdout.splitlines()]
        )

    return run


@pytest.fixture(scope="module")
def references(fmu):
    return [fmu.reference(name) for name in CHANNELS]


@pytest.fixture(scope="module")
def simulated(example3):
    """The same motion, from simulate()."""
    midspan = gf.simulate(example3, stop_time=STOP, record_every=1).midspan()
    return np.column_stack([midspan[name].values for name in CHANNELS.values()])[1:]


def test_c_host_equals_simulate(host, references, simulated):
    found = host("run", round(STOP / STEP), *references)
    assert np.ptp(found[:, 0]) > 1e-3  # it moves
    assert np.array_equal(found, simulated)  # observed: every bit; the same code runs


def test_fmpy_equals_simulate(fmu, simulated):
    found = simulate_fmu(str(fmu.path), stop_time=STOP, output_interval=STEP, output=list(CHANNELS))
    assert np.array_equal(np.column_stack([found[name] for name in CHANNELS])[1:], simulated)


def test_the_description_is_valid(fmu):
    assert validate_fmu(str(fmu.path)) == []


def test_threads_do_not_disturb_one_another(host, references):
    host("threads", 300, *references)


def test_restored_states_repeat_every_bit(host, references):
    host("states", 60, *references)


@pytest.mark.parametrize("steps", [0, 1, 250])
def test_another_process_resumes_from_a_file(host, references, simulated, tmp_path, steps):
    file = tmp_path / f"state.{steps}"
    host("save", steps, file)
    assert np.array_equal(host("resume", 100, file, *references), simulated[steps : steps + 100])
