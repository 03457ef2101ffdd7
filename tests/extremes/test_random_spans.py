"""Random spans far from comfort: every run ends in a typed outcome, and what completes is physics.

In processes of their own, so that a crash or a hang is a failed test; the long run is
benchmarks/stress/run.py.
"""

import math
import signal
import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from gallop_fmu import Model, Scene
from gallop_fmu.foundation.channels import NODE_INDEX
from support.checks import ALL, judge, judge_scene, tension_error
from support.isolated_workers import answers
from support.random_spans import AXES, BLOCK, STEEPEST, _hypercube, stress_scene

SEED, COUNT = 6, 40
TYPED = {"completed", "slack", "angle_out_of_range", "equilibrium_not_found", "newton_stalled"}


@pytest.fixture(scope="module")
def verdicts():
    return list(
        answers(
            judge_scene, [(SEED, number, {}) for number in range(COUNT)], processes=1, limit=300.0
        )
    )


def test_every_run_ends_in_a_typed_outcome(verdicts):
    assert [answer.lost for answer in verdicts if answer.lost] == []
    found = Counter(answer.value.outcome for answer in verdicts)
    assert set(found) <= TYPED
    assert found["completed"] >= COUNT // 3  # observed 24


def test_no_run_is_a_silent_fantasy(verdicts):
    assert [
        (answer.value.name, answer.value.faults) for answer in verdicts if answer.value.faults
    ] == []


@pytest.mark.parametrize("name", ["1-241", "1-1692"])
def test_slack_at_the_end_of_a_step_is_seen(name, kept_scene):
    """Methods that balance forces within the step: once recorded with a tension below zero."""
    found = judge(kept_scene(name))
    assert (found.outcome, found.faults) == ("slack", [])


def test_energy_of_unhalved_runs_is_accounted_for(verdicts):
    """Most imbalances are far below the bound."""
    whole = [
        v.value.imbalance
        for v in verdicts
        if v.value.outcome == "completed" and not v.value.halvings
    ]
    assert len(whole) >= 10
    assert np.median(whole) < 1e-5  # observed 1.4e-6
    assert max(whole) < 5e-3  # observed 8e-4


def test_scenes_are_named_by_seed_and_number():
    one, again, other = stress_scene(SEED, 3), stress_scene(SEED, 3), stress_scene(SEED + 1, 3)
    assert one == again
    assert one.data != other.data
    assert stress_scene(SEED, BLOCK + 3).data != one.data


def begins_and_ends_calm(history):
    return (
        bool(history)
        and history["kind"] == "table"
        and history["value"][0] == history["value"][-1] == 0.0
    )


def test_the_hypercube_covers_its_ranges():
    """Every coordinate is spread evenly: spans short to long, taut to deep, calm to storm."""
    cube = np.sort(_hypercube(SEED, 0), axis=0)
    assert cube.shape == (BLOCK, len(AXES))
    assert np.abs(cube - (np.arange(BLOCK)[:, np.newaxis] + 0.5) / BLOCK).max() < 1.0 / BLOCK
    data = [stress_scene(SEED, number).data for number in range(BLOCK)]
    ranges = {
        "length": [d["span"]["length"] for d in data],
        "elements": [d["numerics"]["elements"] for d in data],
        "step": [d["numerics"]["time_step"] for d in data],
        "speed": [d["wind"].get("speed", 0.0) for d in data],
        "ice": [d["ice"]["mass_per_length"] / d["conductor"]["mass_per_length"] for d in data],
        "attack": [d["ice"]["attack_angle_deg"] for d in data],
        "rise": [d["span"]["height_difference"] / d["span"]["length"] for d in data],
    }
    wanted = {
        "length": (20.0, 1500.0), "elements": (2, 200), "step": (1e-4, 0.2), "speed": (0.0, 60.0),
        "ice": (0.0, 3.0),
        "attack": (-180.0, 180.0), "rise": (-STEEPEST, STEEPEST),
    }  # fmt: skip
    for name, (low, high) in wanted.items():
        assert low <= min(ranges[name]) < low + 0.05 * (high - low), name
        assert high - 0.05 * (high - low) < max(ranges[name]) <= high, name
    kinds = {(d["wind"].get("history") or {"kind": "none"})["kind"] for d in data}
    assert kinds == {"none", "ramp", "pulse", "harmonic", "table"}
    assert sum(begins_and_ends_calm(d["wind"].get("history")) for d in data) > BLOCK // 10
    assert sum(stress_scene(SEED, number).reversal > 0.0 for number in range(BLOCK)) > BLOCK // 10


def test_a_wrong_tension_is_seen():
    stress = replace(stress_scene(SEED, 1), steps=3)
    model = Model(Scene.from_dict(stress.data))
    run = model.start().run(3, 1, ALL, np.arange(model.nodes, dtype=np.int32))
    nodes = run.node_values.transpose(0, 2, 1).copy()
    assert tension_error(model, nodes) < 1e-8
    nodes[..., NODE_INDEX["tension"]] *= 1.0001
    assert tension_error(model, nodes) > 1e-5


@pytest.mark.parametrize(
    ("work", "task", "said"),
    [
        (signal.raise_signal, signal.SIGSEGV, f"crash, exit code {-signal.SIGSEGV}"),
        (time.sleep, 60.0, "hang, not finished after 1 s"),
        (math.sqrt, -1.0, "exception ValueError"),
    ],
)
def test_a_lost_worker_is_named_and_the_rest_continues(work, task, said):
    ordinary = signal.SIGCONT if work is signal.raise_signal else 0.0
    found = list(answers(work, [ordinary, task, ordinary], processes=1, limit=1.0))
    assert [answer.task for answer in found] == [ordinary, task, ordinary]
    assert [bool(answer.lost) for answer in found] == [False, True, False]
    assert found[1].lost.startswith(said)
    assert found[2].memory > 1.0
