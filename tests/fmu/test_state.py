"""Saved states: rollback, bytes, reset, and instances that share nothing."""

import copy
import math
import shutil

import numpy as np
import pytest

from gallop_fmu.fmu.session import RefusedError, Session
from gallop_fmu.fmu.state_bytes import from_bytes, to_bytes
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.input.scene_files import load_scene


def bits(values):
    return {name: float(value).hex() for name, value in values.items()}


def drive(fmu, steps):
    """Steps with moving inputs; the outputs after each."""
    rows = []
    for k in range(steps):
        fmu.set(
            wind_speed=4.0 + 0.3 * (k % 5),
            attack_angle=0.17 + 0.01 * (k % 3),
            support__left__x1=1e-3 * (k % 4),
        )
        fmu.step(0.03)
        rows.append(bits(fmu.read()))
    return rows


@pytest.mark.parametrize("before", [0, 1, 7, 40])
def test_rollback_repeats_every_bit(gallop_fmu, host, before):
    fmu = host(gallop_fmu).start()
    drive(fmu, before)
    state, time, there = fmu.fmu.getFMUstate(), fmu.time, bits(fmu.read())
    first = drive(fmu, 12)
    fmu.fmu.setFMUstate(state)
    fmu.time = time
    assert bits(fmu.read()) == there
    assert drive(fmu, 12) == first
    fmu.fmu.freeFMUstate(state)


def test_an_iterated_step_leaves_no_trace(gallop_fmu, host):
    plain, iterated = host(gallop_fmu).start(), host(gallop_fmu).start()
    drive(plain, 5), drive(iterated, 5)
    state, time = iterated.fmu.getFMUstate(), iterated.time
    for guess in (9.0, 2.0):
        iterated.set(wind_speed=guess, support__right__x3=0.1)
        iterated.step(0.03)
        iterated.fmu.setFMUstate(state)
        iterated.time = time
    assert drive(iterated, 5) == drive(plain, 5)


def test_another_instance_resumes_from_bytes(gallop_fmu, host):
    first = host(gallop_fmu).start(span__length=125.0, conductor__mass_per_length=1.5)
    drive(first, 9)
    saved = first.fmu.serializeFMUstate(first.fmu.getFMUstate())
    second = host(gallop_fmu)
    second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(saved))
    second.time = first.time
    assert second["span.length"] == 125.0
    assert bits(second.read()) == bits(first.read())
    assert drive(second, 9) == drive(first, 9)


def test_equal_sessions_give_equal_bytes(gallop_fmu, host):
    saved = []
    for _ in range(2):
        fmu = host(gallop_fmu).start(wind_speed=4.4)
        drive(fmu, 3)
        saved.append(fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate()))
    assert saved[0] == saved[1]


@pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session")
@pytest.mark.parametrize("spoil", ["bit", "cut", "foreign", "empty"])
def test_damaged_bytes_are_refused_and_the_next_step_fails(gallop_fmu, host, spoil):
    fmu = host(gallop_fmu).start()
    state = fmu.fmu.getFMUstate()
    good = fmu.fmu.serializeFMUstate(state)
    flipped = bytes([good[len(good) // 2] ^ 4])
    bad = {
        "bit": good[: len(good) // 2] + flipped + good[len(good) // 2 + 1 :],
        "cut": good[:-100],
        "foreign": b"from another tool" * 100,
        "empty": b"\0",
    }[spoil]
    there = bits(fmu.read())
    fmu.fmu.setFMUstate(fmu.fmu.deSerializeFMUstate(bad))
    assert "the saved state is refused" in fmu.log[-1]
    assert bits(fmu.read()) == there | bits({"status": Outcome.BAD_CALL.code})
    with pytest.raises(Exception, match="fmi2DoStep"):
        fmu.step(0.01)
    fmu.fmu.setFMUstate(state)
    fmu.step(0.01)
    assert fmu["status"] == 0


@pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session")
def test_the_state_of_another_fmu_is_refused(gallop_fmu, rigid_fmu, host):
    fmu, other = host(gallop_fmu).start(), host(rigid_fmu).start()
    saved = other.fmu.serializeFMUstate(other.fmu.getFMUstate())
    fmu.fmu.setFMUstate(fmu.fmu.deSerializeFMUstate(saved))
    assert "belongs to another FMU" in fmu.log[-1]


def test_bytes_of_another_version_are_refused():
    saved = {"content": "", "motion": b"12345678"}
    data = to_bytes(saved, "1.0")
    assert from_bytes(data, "1.0") == saved
    with pytest.raises(ValueError, match=r"another version of gallop-fmu; this is 2\.0"):
        from_bytes(data, "2.0")


def test_reset_equals_fresh(gallop_fmu, host):
    fmu = host(gallop_fmu).start(span__length=124.0, wind_speed=6.0)
    drive(fmu, 6)
    fmu.fmu.reset()
    fmu.start()
    fresh = host(gallop_fmu).start()
    assert fmu["span.length"] == fresh["span.length"]
    assert bits(fmu.read()) == bits(fresh.read())
    assert drive(fmu, 6) == drive(fresh, 6)


def test_reset_needs_no_unpacked_files(gallop_fmu, host):
    fmu = host(gallop_fmu).start()
    there = bits(fmu.read())
    shutil.rmtree(fmu.folder / "resources")
    fmu.fmu.reset()
    assert bits(fmu.start().read()) == there


def test_instances_of_one_fmu_share_nothing(gallop_fmu, host):
    alone = host(gallop_fmu).start()
    wanted = drive(alone, 6)
    one, other = (
        host(gallop_fmu).start(),
        host(gallop_fmu).start(wind_speed=8.0, span__length=124.0),
    )
    found = []
    for _ in range(6):
        other.step(0.05)
    for k in range(6):
        one.set(
            wind_speed=4.0 + 0.3 * (k % 5),
            attack_angle=0.17 + 0.01 * (k % 3),
            support__left__x1=1e-3 * (k % 4),
        )
        one.step(0.03)
        other.step(0.05)
        found.append(bits(one.read()))
    assert found == wanted


IMPOSSIBLE = {
    "a part too few": lambda saved: saved.pop("tower"),
    "a part too many": lambda saved: saved.update(more=1),
    "phase": lambda saved: saved.update(phase="asleep"),
    "status": lambda saved: saved.update(status=77),  # StopIteration before
    "start": lambda saved: saved.update(start_time="z"),
    "start is not finite": lambda saved: saved.update(start_time=math.nan),
    "tower": lambda saved: saved.update(tower="x"),
    "tower of another shape": lambda saved: saved.update(tower=[[0.0, 0.0], [0.0, 0.0]]),
    "no inputs": lambda saved: saved.update(inputs={}),
    "an input out of range": lambda saved: saved["inputs"].update(wind_speed=-1.0),
    "an input that is a text": lambda saved: saved["inputs"].update(wind_speed="5"),
    "an unknown parameter": lambda saved: saved["parameters"].update({"span.depth": 1.0}),
    "a parameter out of range": lambda saved: saved["parameters"].update({"span.length": 0.0}),
    "a parameter that is no whole number": lambda saved: saved["parameters"].update(
        {"numerics.elements": 8.5}
    ),
    "parameters that are a list": lambda saved: saved.update(parameters=[]),
    "refusals": lambda saved: saved.update(refused={"a": 1}),
    "motion": lambda saved: saved.update(motion=saved["motion"][:-8]),
    "motion is not finite": lambda saved: saved.update(motion=with_nan(saved["motion"])),
}


def with_nan(motion):
    """A displacement, near the seed of 1 mm, is not a number."""
    values = np.frombuffer(motion, np.float64).copy()
    values[np.argmin(np.abs(values - 1e-3))] = math.nan
    return values.tobytes()


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_sealed_bytes_with_impossible_content_are_refused(name):
    """Whoever can seal bytes by their checksum cannot bring a session into an impossible state."""
    session = Session(load_scene("example3").with_values({"numerics.elements": 4}), "content")
    session.set_up(0.0)
    session.enter_initialisation()
    session.leave_initialisation()
    session.step(0.0, 0.02)
    good = from_bytes(to_bytes(session.save(), "1"), "1")
    bad = copy.deepcopy(good)
    IMPOSSIBLE[name](bad)
    with pytest.raises(RefusedError, match="the saved state is refused: it is damaged: "):
        session.restore(bad)
    before = session.save()
    assert before | {"refused": {}} == good
    session.restore(good)
    assert session.save() == good
    session.step(0.02, 0.02)
