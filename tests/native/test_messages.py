"""Messages of the FMU: Python's words, a decimal point in every locale, right limits."""

import ctypes as c
import math
import os
import subprocess
import threading

import pytest

import gallop_fmu as gf
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.foundation.outcome import Outcome, SimulationError

H = 0.02
ERROR = 3
UP, DOWN, TOWARDS_ZERO = 0x800, 0x400, 0xC00  # of fesetround on x86


@pytest.mark.parametrize("angle", [99.0, 261.0, -91.0, 99.96])
def test_an_angle_out_of_range_is_reported_in_the_words_of_python(
    small, small_scene, instance, angle
):
    """-91 deg is 269 deg, above the upper limit: the message once named the lower one."""
    wanted = (
        "below the curve's lower limit of 100 deg"
        if 0.0 < angle < 100.0
        else "above the curve's upper limit of 260"
    )
    inputs = Inputs(0.0, 5.5, math.radians(angle), [[0.0] * 3] * 2)
    with pytest.raises(SimulationError, match=wanted) as python:
        Model(small_scene).start(inputs=inputs)
    fmu = instance(small)
    assert fmu.set_up() == 0
    fmu.insist("EnterInitializationMode")
    fmu["attack_angle"] = math.radians(angle)
    assert fmu.call("ExitInitializationMode") == ERROR
    assert fmu.log[-1] == f"there is no initial state: a{str(python.value)[1:]}"


def test_a_limit_that_is_zero_is_printed_as_zero(example3):
    """A full turn from 0 deg at 0 deg once gave "-0.00 deg, allowed up to 0.00 deg"."""
    table = {"kind": "table", "angle_deg": [0.0, 120.0, 240.0, 350.0], "lift": [0.0] * 4,
        "drag": [1.0] * 4,
             "moment": [0.0] * 4}  # fmt: skip
    scene = gf.Scene.from_dict(example3.model_dump() | {"aerodynamics": table})
    turned = scene.with_values(
        {"ice.attack_angle_deg": 0.0, "initial.seed_twist": -1e-6, "initial.seed_vertical": 0.0}
    )
    with pytest.raises(SimulationError) as caught:
        Model(turned).start()
    assert " deg below the curve's lower limit of 0 deg" in str(caught.value)
    assert "-0.00" not in str(caught.value)
    report = caught.value.report
    assert -1.1e-6 < report.value < report.limit == 0.0


def test_failures_are_reported_in_the_words_of_python(small, small_scene, instance):
    """A value but no angle: the span goes slack, or Newton's iteration stalls."""
    fmu, state = instance(small).start(), Model(small_scene).start()
    fmu["wind_speed"] = 140.0
    with pytest.raises(SimulationError) as python:
        state.advance(20.0, Inputs(0.0, 140.0, fmu["attack_angle"], [[0.0] * 3] * 2))
    assert fmu.do_step(0.0, 20.0) == ERROR
    assert fmu.log[-1] == f"the step could not be carried out: a{str(python.value)[1:]}"


BOUNDS = {
    "span.length": (0.0, "span.length = 0 is refused: it must be greater than 0 and at most 10000"),
    "wind_speed": (-150.5, "wind_speed = -150.5 is refused: it must be at least -150 and at most"),
    "numerics.time_step": (-1.0, "it must be greater than 0 and at most"),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_bounds_are_named_as_they_are(small, instance, name):
    """An excluded limit was once "between 4.94066e-324 and 10000"."""
    value, message = BOUNDS[name]
    fmu = instance(small)
    assert fmu.set_real([fmu.fmu.reference(name)], [value]) == ERROR
    assert message in fmu.log[-1]


def test_bounds_are_in_the_words_of_python(small, small_scene, instance):
    fmu = instance(small)
    for variable in fmu_variables(small_scene):
        if variable.causality == "output" or variable.type != "Real" or not variable.allowed:
            continue
        low = -math.inf if variable.minimum is None else variable.minimum
        beyond = low - 1.0 if math.isfinite(low) else variable.maximum + 1.0
        assert not variable.allows(beyond)
        assert fmu.set_real([variable.reference], [beyond]) == ERROR
        assert fmu.log[-1].endswith(f"is refused: it must be {variable.allowed}")


def test_an_excluded_bound_is_stated_in_the_model_description(small):
    length, wind = (small.variables[name] for name in ("span.length", "wind_speed"))
    assert float(length.min) == 0.0
    assert length.description.endswith("; > 0")
    assert "must be" not in wind.description


COMMA = r"""
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
static int with_comma(char *to, size_t size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(to, size, format, arguments);
    va_end(arguments);
    char *point = strchr(to, '.');
    if (!point) return length;
    memmove(point + strlen(SIGN), point + 1, strlen(point));
    memcpy(point, SIGN, strlen(SIGN));
    return length;
}
#define snprintf with_comma
#include "cosim_message.c"
int main(void)
{
    const double number[] = {-1.5, 0.0, 1e-300, 2.5e17, 1.0 / 3.0, INFINITY, 140.0};
    for (int i = 0; i < 7; i++) puts(cosim_number_text(6, number[i]).text);
    return 0;
}
"""


@pytest.mark.parametrize("sign", [",", "\u066b"])
def test_numbers_have_a_point_in_every_locale(compiled, kernel_sources, tmp_path, sign):
    """A host with a comma locale got "wind_speed = -1,5" from the library's snprintf."""
    text, source = "".join(f"\\x{byte:02x}" for byte in sign.encode()), tmp_path / "comma.c"
    source.write_text(COMMA.replace("SIGN", f'"{text}"'))
    flags = [f"-I{kernel_sources}", "-ffunction-sections", "-Wl,--gc-sections", "-w"]
    program = compiled(tmp_path / "comma", source, flags=flags)
    found = subprocess.run([program], capture_output=True, check=True).stdout.decode().split()
    assert found == ["-1.5", "0", "1e-300", "2.5e+17", "0.333333", "inf", "140"]


@pytest.mark.parametrize("mode", [UP, DOWN, TOWARDS_ZERO])
def test_other_rounding_modes_are_named(small, instance, mode):
    """`doStep` once gave a false reason: "left the validity range (3.14175, limit 4.53786)"."""
    libm, fmu = c.CDLL(None), instance(small).start().step(H)
    before = fmu.outputs()
    reference = fmu.fmu.reference("midspan.x2")
    try:
        libm.fesetround(mode)
        stepped, read = fmu.do_step(H, H), fmu.get_real([reference])[0]
        other = fmu.library.fmi2Instantiate
        component = other(
            b"x",
            1,
            small.guid.encode(),
            small.resources.as_uri().encode(),
            c.byref(fmu.callbacks),
            0,
            0,
        )
    finally:
        libm.fesetround(0)
    assert (stepped, read, component) == (ERROR, 0, None)  # read: computed before the mode changed
    assert "rounding mode, which must be to nearest" in fmu.log[-2]
    assert fmu.log[-1].startswith("this FMU cannot compute; check the processor's rounding mode")
    assert fmu.outputs() == before | {"status": float(Outcome.BAD_CALL.code).hex()}
    fmu.step(H)


def test_a_pipe_in_place_of_the_model_is_refused_at_once(small, instance, tmp_path):
    """Instantiation once never returned."""
    os.mkfifo(tmp_path / "model.bin")
    opened = []
    thread = threading.Thread(
        target=lambda: opened.append(instance(small, resources=tmp_path.as_uri())), daemon=True
    )
    thread.start()
    thread.join(5.0)
    assert not thread.is_alive()
    assert not opened[0].component.value
    assert "not a regular file" in opened[0].log[-1]


COMPILE = {
    "fast-math": (["-ffast-math"], "compile without -ffast-math"),
    "Ofast": (["-Ofast"], "compile without -ffast-math"),
    "finite": (["-ffinite-math-only"], "compile without -ffast-math"),
    "taken back": (["-ffast-math", "-fno-fast-math"], ""),
    "x87": (["-mfpmath=387"], "compile with -msse2 -mfpmath=sse"),
    "plain": (["-O2"], ""),
}


@pytest.mark.parametrize("name", COMPILE)
def test_options_that_break_the_arithmetic_stop_the_compiler(kernel_sources, name):
    """A kernel compiled with -ffast-math gave u2 = 0.000626 m instead of 0.007835 m."""
    flags, message = COMPILE[name]
    command = [
        os.environ.get("CC", "cc"),
        "-std=c11",
        "-fsyntax-only",
        *flags,
        str(kernel_sources / "time_newmark.c"),
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode != 0) == bool(message)
    assert message in done.stderr


FAULT = r"""
#include "check.c"
#include <stdio.h>
int main(void)
{
    const char *fault = gallop_arithmetic_fault();
    puts(fault ? fault : "none");
    return 0;
}
"""


def test_options_that_the_compiler_does_not_report_are_found_at_run_time(
    compiled, kernel_sources, tmp_path
):
    source = tmp_path / "fault.c"
    source.write_text(FAULT)
    flags = [f"-I{kernel_sources}", "-ffunction-sections", "-Wl,--gc-sections", "-w", "-O2"]
    for more, expected in (
        (["-funsafe-math-optimizations"], "compiled with -ffast-math"),
        ([], "none"),
    ):
        program = compiled(tmp_path / "fault", source, flags=[*flags, *more])
        assert (
            expected in subprocess.run([program], capture_output=True, check=True, text=True).stdout
        )
