"""Refused calls: a message, no effect, no crash."""

import ctypes as c
import importlib.util
import math
import re
import subprocess
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from support.refused_calls import ERROR, H, refused

DISCARD = 2


@pytest.fixture
def fmu(small, instance):
    return instance(small)


@pytest.fixture
def stepping(fmu):
    return fmu.start().step(H, 3)


def reach(fmu, mode):
    if mode == "instantiated":
        return
    assert fmu.set_up() == 0
    fmu.insist("EnterInitializationMode")
    if mode == "initialising":
        return
    fmu.insist("ExitInitializationMode")
    if mode == "terminated":
        fmu.insist("Terminate")


MODES = ("instantiated", "initialising", "stepping", "terminated")
ALLOWED = {
    "SetupExperiment": ("instantiated",),
    "EnterInitializationMode": ("instantiated",),
    "ExitInitializationMode": ("initialising",),
    "DoStep": ("stepping",),
    "Terminate": ("stepping",),
    "Reset": MODES,
    "SetReal": MODES[:3],
    "SetRealInputDerivatives": MODES[:3],
    "GetRealOutputDerivatives": MODES[2:],
    "GetDirectionalDerivative": MODES[1:],
}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("function", ALLOWED)
def test_order_of_calls(fmu, function, mode):
    reach(fmu, mode)
    calls = {
        "SetupExperiment": fmu.set_up,
        "DoStep": lambda: fmu.do_step(0.0, H),
        "SetReal": lambda: fmu.set_real([0], [5.0]),
        "SetRealInputDerivatives": lambda: fmu.call(
            "SetRealInputDerivatives",
            (c.c_uint * 1)(0),
            c.c_size_t(1),
            (c.c_int * 1)(1),
            (c.c_double * 1)(0.5),
        ),
        "GetRealOutputDerivatives": lambda: fmu.output_rates(["midspan.x2"])[0],
        "GetDirectionalDerivative": lambda: fmu.directional(["midspan.x2"], ["wind_speed"], [1.0])[
            0
        ],
    }
    call = calls.get(function, lambda: fmu.call(function))
    if mode in ALLOWED[function]:
        assert call() == 0, fmu.log
    else:
        refused(fmu, call, " is not allowed ")


def test_no_instance_is_no_crash(fmu):
    for name in (
        "DoStep",
        "Terminate",
        "Reset",
        "GetReal",
        "SetReal",
        "GetFMUstate",
        "SetFMUstate",
        "GetStatus",
    ):
        assert getattr(fmu.library, f"fmi2{name}")(None, None, None, None, None) == ERROR
    fmu.library.fmi2FreeInstance(None)
    empty = c.c_void_p()
    assert fmu.call("FreeFMUstate", c.byref(empty)) == 0
    assert fmu.call("FreeFMUstate", None) == 0
    refused(fmu, lambda: fmu.call("SetFMUstate", None), "not a state of this FMU")
    refused(fmu, lambda: fmu.call("GetFMUstate", None), "no place")
    refused(
        fmu, lambda: fmu.call("GetReal", None, c.c_size_t(1), None), "an array is a null pointer"
    )
    assert fmu.call("GetReal", None, c.c_size_t(0), None) == 0


def test_outputs_are_not_known_before_initialisation(fmu):
    refused(
        fmu,
        lambda: fmu.get_real([fmu.fmu.reference("midspan.x2")])[0],
        "not known before initialization",
    )


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, -151.0, 151.0])
def test_values_that_no_wind_has(stepping, value):
    refused(stepping, lambda: stepping.set_real([0], [value]), "wind_speed")


def test_all_of_a_set_or_nothing(stepping):
    refused(stepping, lambda: stepping.set_real([0, 1, 0], [6.0, 3.0, math.nan]), "wind_speed")


def test_wrong_references_and_causality(stepping):
    real, whole = stepping.fmu.reference("midspan.x2"), stepping.fmu.reference("status")
    refused(stepping, lambda: stepping.get_real([4000000000])[0], "value reference 4000000000")
    refused(stepping, lambda: stepping.get_real([whole])[0], "no Real variable")
    refused(stepping, lambda: stepping.get_integer([real])[0], "no Integer variable")
    refused(stepping, lambda: stepping.set_real([real], [0.0]), "midspan.x2 is an output")
    refused(stepping, lambda: stepping.set_integer([whole], [0]), "status is an output")
    length = stepping.fmu.reference("span.length")
    refused(
        stepping, lambda: stepping.set_real([length], [120.0]), "span.length is a fixed parameter"
    )
    refused(
        stepping,
        lambda: stepping.directional(["wind_speed"], ["wind_speed"], [1.0])[0],
        "is not an output",
    )
    refused(
        stepping,
        lambda: stepping.directional(["midspan.x2"], ["midspan.x2"], [1.0])[0],
        "is not an input",
    )
    refused(
        stepping,
        lambda: stepping.directional(["midspan.x2"], ["wind_speed"], [math.nan])[0],
        "finite",
    )
    refused(stepping, lambda: stepping.output_rates(["wind_speed"])[0], "is not an output")


@pytest.mark.parametrize(
    ("shift", "size", "match"),
    [
        (0.0, 0.0, "must be positive"),
        (0.0, -H, "must be positive"),
        (0.0, math.nan, "must be positive"),
        (math.nan, H, "must be positive"),
        (0.0, math.inf, "must be positive"),
        (0.0, 1e-30, "lost in round-off"),
        (0.0, 1e7, "too long"),
        (H, H, "the FMU is at"),
        (-1e-4, H, "the FMU is at"),
    ],
)
def test_steps_that_are_none(stepping, shift, size, match):
    refused(stepping, lambda: stepping.do_step(stepping.time + shift, size), match)


def test_round_off_in_the_host_s_clock_is_none_of_the_step(small, instance):
    exact, sloppy = instance(small).start().step(H, 3), instance(small).start().step(H, 3)
    exact.step(H)
    assert sloppy.do_step(sloppy.time + 1e-15, H) == 0
    assert sloppy["midspan.x2"] == pytest.approx(exact["midspan.x2"], rel=1e-9)


def test_no_step_beyond_the_stop_time(fmu):
    assert fmu.set_up(stop=3 * H) == 0
    fmu.insist("EnterInitializationMode")
    fmu.insist("ExitInitializationMode")
    fmu.step(H, 3)
    refused(fmu, lambda: fmu.do_step(fmu.time, H), "after the stop time")


@pytest.mark.parametrize(
    ("start", "stop"), [(math.nan, None), (math.inf, None), (1.0, 1.0), (1.0, 0.5), (0.0, math.nan)]
)
def test_times_of_no_experiment(fmu, start, stop):
    refused(fmu, lambda: fmu.set_up(start, stop), "time")


def test_a_failed_step_names_the_place_and_keeps_the_motion(stepping):
    before = {name: bits for name, bits in stepping.outputs().items() if name != "status"}
    stepping["attack_angle"] = 0.0  # the coefficients hold from 100 to 260 degrees
    assert stepping.do_step(stepping.time, H) == ERROR
    assert "the step could not be carried out: at 0.07 s in element" in stepping.log[-1]
    assert "What to do" in stepping.log[-1]
    assert stepping["status"] == 3
    assert {name: bits for name, bits in stepping.outputs().items() if name != "status"} == before
    stepping["attack_angle"] = math.pi
    stepping.step(H)
    assert stepping["status"] == 0


def test_status_of_steps(stepping):
    real, truth, whole = c.c_double(), c.c_int(), c.c_int()
    last, terminated = 2, 3
    assert stepping.call("GetRealStatus", last, c.byref(real)) == 0
    assert real.value == stepping.time
    assert stepping.call("GetBooleanStatus", terminated, c.byref(truth)) == 0
    assert truth.value == 0
    assert stepping.call("GetStatus", 0, c.byref(whole)) == DISCARD
    assert stepping.call("GetIntegerStatus", 0, c.byref(whole)) == DISCARD
    assert stepping.call("GetStringStatus", 1, c.byref(whole)) == DISCARD
    assert stepping.call("CancelStep") == ERROR


def test_wrong_instantiation(small, instance):
    for settings, match in (
        ({"guid": "{another}"}, "GUID"),
        ({"resources": "file:///nowhere/resources"}, "cannot be opened"),
        ({"resources": ""}, "cannot be opened"),
    ):
        one = instance(small, **settings)
        assert not one.component.value
        assert match in one.log[-1]


@pytest.mark.parametrize(
    "kind", ["file:{}", "file://{}", "file://localhost{}", "FILE://{}", "{}", "{}/"]
)
def test_ways_to_name_the_resources(small, instance, kind):
    assert instance(small, resources=kind.format(small.resources)).component.value


@pytest.mark.parametrize("name", ["größe λ 電線", "100 % ice", "a%41b", "#?&+"])
def test_folders_with_odd_names(small, instance, tmp_path, name):
    folder = tmp_path / name
    folder.mkdir()
    (folder / "model.bin").write_bytes((small.resources / "model.bin").read_bytes())
    assert instance(small, resources=folder.as_uri()).component.value
    assert instance(small, resources=str(folder)).component.value  # a plain path is taken as it is


PATHS = """
#include "{kernel}/fmi_location.c"
#include <stdio.h>
int main(int count, char **argument)
{{
    char *path = path_of(argument[count - 1], "model.bin", true);
    puts(path);
    free(path);
    return 0;
}}
"""


@pytest.mark.parametrize(
    ("location", "path"),
    [
        ("file:///C:/fmu/resources", "C:/fmu/resources/model.bin"),
        ("file:///C%3A/fmu/res%20%C3%BC", "C:/fmu/res ü/model.bin"),
        ("file:///C|/fmu/resources/", "C:/fmu/resources/model.bin"),
        ("file:/C:/fmu", "C:/fmu/model.bin"),
        ("file://localhost/C:/fmu", "C:/fmu/model.bin"),
        ("file://C:/fmu", "C:/fmu/model.bin"),
        ("file://server/share/fmu", "//server/share/fmu/model.bin"),
        ("file:////server/share/fmu", "//server/share/fmu/model.bin"),
        (r"C:\fmu\100%25", r"C:\fmu\100%25/model.bin"),
    ],
)
def test_paths_with_drives(compiled, kernel_sources, tmp_path_factory, location, path):
    folder = tmp_path_factory.getbasetemp() / "paths"
    folder.mkdir(exist_ok=True)
    program, source = folder / "paths", folder / "paths.c"
    if not program.exists():
        source.write_text(PATHS.format(kernel=kernel_sources))
        compiled(
            program,
            source,
            flags=[f"-I{kernel_sources}", "-Wno-unused-function"],
        )
    assert (
        subprocess.run([program, location], capture_output=True, check=True).stdout.decode().strip()
        == path
    )


def with_model(small, instance, folder, content):
    (folder / "model.bin").write_bytes(content)
    return instance(small, resources=folder.as_uri())


@pytest.mark.parametrize("left", [0, 1, 100, 111, 112, 1000, -8, -1])
def test_model_bin_cut_off(small, instance, tmp_path, left):
    good = (small.resources / "model.bin").read_bytes()
    one = with_model(small, instance, tmp_path, good[:left])
    assert not one.component.value
    assert "cut off" in one.log[-1]


def test_model_bin_with_flipped_bits(small, instance, tmp_path):
    good = (small.resources / "model.bin").read_bytes()
    for at in np.unique(np.geomspace(1, len(good), 300).astype(int) - 1):
        bad = bytearray(good)
        bad[at] ^= 1 << (at % 8)
        one = with_model(small, instance, tmp_path, bytes(bad))
        assert not one.component.value, at
        assert "model.bin" in one.log[-1]


def test_model_bin_of_others(small, instance, tmp_path, fmu):
    assert "cut off" in with_model(small, instance, tmp_path, b"").log[-1]
    assert (
        "not a file of this program"
        in with_model(small, instance, tmp_path, b"from another tool" * 99).log[-1]
    )
    (tmp_path / "model.bin").unlink()
    (tmp_path / "model.bin").mkdir()
    assert not instance(small, resources=tmp_path.as_uri()).component.value


@pytest.mark.parametrize("kind", ["Boolean", "String"])
def test_there_are_no_variables_of_other_types(fmu, kind):
    """No variable has these types; an empty list is accepted."""
    references, values = (c.c_uint * 1)(0), (c.c_void_p * 1)()
    for access in ("Get", "Set"):
        assert fmu.call(f"{access}{kind}", references, c.c_size_t(0), values) == 0
        call = partial(fmu.call, f"{access}{kind}", references, c.c_size_t(1), values)
        refused(fmu, call, "no Boolean and no String variables")


CATEGORIES = (
    b"logEvents",
    b"logSingularLinearSystems",
    b"logNonlinearSystems",
    b"logDynamicStateSelection",
    b"logStatusWarning",
    b"logStatusDiscard",
    b"logStatusError",
    b"logStatusFatal",
    b"logStatusPending",
    b"logAll",
)
"""The names that FMI 2.0, section 2.2.4, gives to categories."""


def test_functions_of_model_exchange_exist_and_are_refused(fmu):
    """Some hosts look up all functions of FMI 2.0 in any FMU."""
    calls = {
        "EnterEventMode": (),
        "NewDiscreteStates": (None,),
        "EnterContinuousTimeMode": (),
        "CompletedIntegratorStep": (1, None, None),
        "SetTime": (c.c_double(0.0),),
        "SetContinuousStates": (None, c.c_size_t(0)),
        "GetDerivatives": (None, c.c_size_t(0)),
        "GetEventIndicators": (None, c.c_size_t(0)),
        "GetContinuousStates": (None, c.c_size_t(0)),
        "GetNominalsOfContinuousStates": (None, c.c_size_t(0)),
    }
    for name, arguments in calls.items():
        refused(fmu, partial(fmu.call, name, *arguments), "for co-simulation only")
    headers = Path(importlib.util.find_spec("fmpy").origin).parent / "c-code"
    header = (headers / "fmi2FunctionTypes.h").read_text()
    declared = set(re.findall(r"\b(fmi2\w+)TYPE\b", header))
    assert len(declared) == 44
    assert all(hasattr(fmu.library, name) for name in declared)


def test_logging_knows_its_categories_and_the_library_its_version(fmu):
    names = (c.c_char_p * 2)(b"logStatusError", b"logStatusDiscard")
    assert fmu.call("SetDebugLogging", 1, c.c_size_t(2), names) == 0
    for name in CATEGORIES:
        names[1] = name
        assert fmu.call("SetDebugLogging", 1, c.c_size_t(2), names) == 0
    for wrong in (b"logall", None):
        names[1] = wrong
        refused(
            fmu,
            lambda: fmu.call("SetDebugLogging", 1, c.c_size_t(2), names),
            "the log category is unknown",
        )
    refused(
        fmu,
        lambda: fmu.call("SetDebugLogging", 1, c.c_size_t(2), None),
        "the log category is unknown",
    )
    for name, answer in (("GetVersion", b"2.0"), ("GetTypesPlatform", b"default")):
        function = getattr(fmu.library, f"fmi2{name}")
        function.restype = c.c_char_p
        assert function() == answer
