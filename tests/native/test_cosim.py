"""The exported functions of gallop_cosim.h, called without FMI."""

import ctypes as c

import pytest

from gallop_fmu.engine.library import kernel
from gallop_fmu.fmu.cosim import MESSAGE_SIZE, Cosim, CosimError

OK, WARNING, REFUSED, FAILED = range(4)
H = 0.02


@pytest.fixture(scope="module")
def resource(small):
    return (small.resources / "model.bin").read_bytes()


@pytest.fixture
def cosim(small, resource):
    return Cosim(resource, small.guid)


def start(cosim):
    cosim.set_up(0.0, None)
    cosim.enter_initialization()
    cosim.exit_initialization()
    return cosim


def test_it_gives_the_digits_of_the_native_fmu(small, cosim, instance):
    fmu = instance(small).start().step(H, 5)
    start(cosim)
    for k in range(5):
        cosim.step(k * H, H)
    reals = [small.reference(name) for name in small.outputs]
    assert cosim.get("real", reals) == fmu.get_real(reals)[1]


@pytest.mark.parametrize(
    "name",
    [
        "reset", "set_up", "enter_initialization", "exit_initialization", "step", "terminate",
        "time", "get_real", "get_integer", "set_real", "set_integer", "set_input_rates",
        "get_output_rates", "directional_derivative", "save", "restore", "serialized_size",
        "serialize", "deserialize",
    ],
)  # fmt: skip
def test_without_an_instance_a_call_is_refused(name):
    call = c.CDLL(kernel._name)[f"gallop_cosim_{name}"]
    assert call(*[None] * 7) == REFUSED


def test_without_an_instance_there_is_a_message():
    assert kernel.gallop_cosim_message(None) == b"there is no instance; create one"
    kernel.gallop_cosim_free(None)
    kernel.gallop_cosim_free_saved(None)
    assert kernel.gallop_cosim_seal(None, 100) != 0


@pytest.mark.parametrize(
    ("content", "guid", "message"),
    [
        (None, b"", "the content of resources/model.bin is missing"),
        (b"", b"", "is cut off"),
        ("good", None, "the GUID is missing"),
        ("good", b"{other}", "the GUID of modelDescription.xml is not that of"),
    ],
)
def test_a_creation_that_fails_says_why(resource, content, guid, message):
    content = resource if content == "good" else content
    room = c.create_string_buffer(MESSAGE_SIZE)
    create = kernel.gallop_cosim_create
    assert not create(content, len(content or b""), guid, room)
    assert message in room.value.decode()
    assert not create(content, len(content or b""), guid, None)


def test_refused_and_failed_calls_differ_in_their_status(cosim):
    step = kernel.gallop_cosim_step
    assert step(cosim._handle, 0.0, H) == REFUSED
    start(cosim)
    assert kernel.gallop_cosim_message(cosim._handle).startswith(b"a step is not allowed")
    assert step(cosim._handle, 0.0, -H) == REFUSED
    cosim.set("real", [0], [140.0])
    assert step(cosim._handle, 0.0, 20.0) == FAILED
    cosim.set("real", [0], [5.0])
    assert step(cosim._handle, 0.0, H) == OK


def test_saved_states_outlive_their_instance(small, resource):
    first = start(Cosim(resource, small.guid))
    first.step(0.0, H)
    saved = c.c_void_p()
    assert kernel.gallop_cosim_save(first._handle, c.byref(saved)) == OK
    wanted = first.get("real", [small.reference("midspan.x2")])
    del first
    second = Cosim(resource, small.guid)
    assert kernel.gallop_cosim_restore(second._handle, saved) == OK
    kernel.gallop_cosim_free_saved(saved)
    assert second.get("real", [small.reference("midspan.x2")]) == wanted
    second.step(H, H)


def test_bytes_of_a_state_need_no_alignment(cosim):
    start(cosim).step(0.0, H)
    content = cosim.save()
    room = c.create_string_buffer(b"x" + content)
    saved = c.c_void_p()
    at = c.cast(c.addressof(room) + 1, c.c_char_p)
    deserialize = kernel.gallop_cosim_deserialize
    assert deserialize(cosim._handle, at, len(content), c.byref(saved)) == OK
    assert kernel.gallop_cosim_restore(cosim._handle, saved) == OK
    kernel.gallop_cosim_free_saved(saved)
    assert cosim.save() == content


def test_messages_state_the_remedy(cosim):
    with pytest.raises(CosimError, match="it is allowed while stepping"):
        cosim.terminate()
    with pytest.raises(CosimError, match="no Boolean and no String variables; use"):
        cosim.get("boolean", [0])
