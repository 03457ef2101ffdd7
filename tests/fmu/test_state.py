"""Saved states: rollback, bytes, reset, and instances that share nothing."""

import shutil

import pytest
from fmpy.fmi1 import FMICallException


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


def test_equal_instances_give_equal_bytes(gallop_fmu, host):
    saved = []
    for _ in range(2):
        fmu = host(gallop_fmu).start(wind_speed=4.4)
        drive(fmu, 3)
        saved.append(fmu.fmu.serializeFMUstate(fmu.fmu.getFMUstate()))
    assert saved[0] == saved[1]


@pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session")
def test_damaged_bytes_are_refused_and_the_next_step_fails(gallop_fmu, rigid_fmu, host):
    """Refusals and their messages are tested in tests/native."""
    fmu, other = host(gallop_fmu).start(), host(rigid_fmu).start()
    state = fmu.fmu.getFMUstate()
    good = fmu.fmu.serializeFMUstate(state)
    foreign = other.fmu.serializeFMUstate(other.fmu.getFMUstate())
    there = bits(fmu.read())
    for bad, message in (
        (good[:-100], "the bytes are cut off"),
        (foreign, "the bytes are a state of another FMU"),
    ):
        fmu.fmu.setFMUstate(fmu.fmu.deSerializeFMUstate(bad))
        assert message in fmu.log[-1]
        assert bits(fmu.read()) == there
        with pytest.raises(FMICallException):
            fmu.step(0.01)
        assert message in fmu.log[-1]
    fmu.fmu.setFMUstate(state)
    fmu.step(0.01)


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
