"""The kernel's own sine, cosine, arctangent and hypotenuse, against 50-digit arithmetic."""

import ctypes
import math
import shlex
import subprocess
import sysconfig
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

HEADER_FOLDER = Path(__file__).parents[3] / "gallop_fmu" / "kernel"
SHIM = """
#include "base_math.h"
void sine_cosines(int n, const double *x, double *sine, double *cosine)
{
    for (int i = 0; i < n; i++) sine_cosine(x[i], sine + i, cosine + i);
}
void arctangents(int n, const double *y, const double *x, double *out)
{
    for (int i = 0; i < n; i++) out[i] = arctangent(y[i], x[i]);
}
void hypotenuses(int n, const double *y, const double *x, double *out)
{
    for (int i = 0; i < n; i++) out[i] = hypotenuse(y[i], x[i]);
}
"""
PI = Decimal(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803"
)


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    """The header's functions over arrays, compiled with the system's compiler."""
    folder = tmp_path_factory.mktemp("shim")
    (folder / "shim.c").write_text(SHIM)
    compiler = shlex.split(sysconfig.get_config_var("CC") or "cc")
    flags = ["-std=c11", "-O3", "-ffp-contract=off", "-shared", "-fPIC", f"-I{HEADER_FOLDER}"]
    subprocess.run(
        [*compiler, *flags, "-o", str(folder / "shim.so"), str(folder / "shim.c")], check=True
    )
    return ctypes.CDLL(str(folder / "shim.so"))


def call(function, *arrays, outputs):
    size = len(arrays[0])
    out = [np.empty(size) for _ in range(outputs)]
    pointers = [
        np.ascontiguousarray(y).ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        for y in (*arrays, *out)
    ]
    function(size, *pointers)
    return out


def exact_sine_cosine(x):
    """Taylor series after reduction by full turns, in 50 digits."""
    with localcontext() as context:
        context.prec = 60
        r = Decimal(x) % (2 * PI)
        sine, cosine, term, k = Decimal(0), Decimal(0), Decimal(1), 0
        while abs(term) > Decimal("1e-50") or k < 10:
            sign = 1 if k % 4 < 2 else -1
            if k % 2:
                sine += sign * term
            else:
                cosine += sign * term
            k += 1
            term *= r / k
        return sine, cosine


def units_in_last_place(value, exact):
    return float(abs(Decimal(float(value)) - exact) / Decimal(math.ulp(float(exact))))


def test_sine_and_cosine_over_many_turns(shim):
    random = np.random.default_rng(1)
    x = np.concatenate([
        random.uniform(-4.0, 4.0, 2000),
        random.uniform(-1e6, 1e6, 1000),
        10.0 ** random.uniform(-300, -1, 200),
        np.arange(-16, 17) * math.pi / 8.0,
    ])  # fmt: skip
    sine, cosine = call(shim.sine_cosines, x, outputs=2)
    worst = 0.0
    for value, s, c in zip(x, sine, cosine, strict=True):
        exact_s, exact_c = exact_sine_cosine(float(value))
        # Near a zero of sine or cosine the argument's own rounding does not count: absolute
        # error there.
        for found, exact in ((s, exact_s), (c, exact_c)):
            if abs(exact) > Decimal("1e-4") or abs(value) < 1e-2:
                worst = max(worst, units_in_last_place(found, exact))
            else:
                assert abs(Decimal(float(found)) - exact) < Decimal("1e-20") + Decimal(
                    "2.3e-16"
                ) * abs(exact)
    assert worst < 2.0  # observed 1.65


def test_sine_and_cosine_of_zero_are_exact(shim):
    sine, cosine = call(shim.sine_cosines, np.array([0.0]), outputs=2)
    assert (sine[0], cosine[0]) == (0.0, 1.0)


def exact_arctangent(y, x):
    """The library's value, corrected in 50 digits by the remaining angle."""
    guess = math.atan2(y, x)
    with localcontext() as context:
        context.prec = 60
        a, dy, dx = Decimal(guess), Decimal(y), Decimal(x)
        sine, cosine = exact_sine_cosine(guess)
        error = (dy * cosine - dx * sine) / (dx * cosine + dy * sine)
        return a + error - error**3 / 3


def test_arctangent_in_all_quadrants(shim):
    random = np.random.default_rng(2)
    angle, radius = random.uniform(-math.pi, math.pi, 2000), 10.0 ** random.uniform(-3, 3, 2000)
    y = np.concatenate(
        [radius * np.sin(angle), random.uniform(-1, 1, 300), 10.0 ** random.uniform(-12, 0, 300)]
    )
    x = np.concatenate(
        [radius * np.cos(angle), 10.0 ** random.uniform(-12, 0, 300), random.uniform(-1, 1, 300)]
    )
    (found,) = call(shim.arctangents, y, x, outputs=1)
    worst = max(
        units_in_last_place(f, exact_arctangent(float(b), float(a)))
        for f, a, b in zip(found, x, y, strict=True)
    )
    assert worst < 2.0  # observed 1.92


def test_arctangent_on_the_axes_and_at_the_origin(shim):
    y, x = np.array([0.0, 1.0, -1.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0, -1.0, 0.0])
    (found,) = call(shim.arctangents, y, x, outputs=1)
    assert list(found) == [0.0, math.pi / 2, -math.pi / 2, math.pi, 0.0]


def test_hypotenuse(shim):
    random = np.random.default_rng(3)
    y = np.concatenate([random.uniform(-1e3, 1e3, 1000), 10.0 ** random.uniform(-20, 20, 1000)])
    x = np.concatenate([random.uniform(-1e3, 1e3, 1000), 10.0 ** random.uniform(-20, 20, 1000)])
    (found,) = call(shim.hypotenuses, y, x, outputs=1)
    with localcontext() as context:
        context.prec = 50
        worst = max(
            units_in_last_place(f, (Decimal(float(a)) ** 2 + Decimal(float(b)) ** 2).sqrt())
            for f, a, b in zip(found, y, x, strict=True)
        )
    assert worst < 1.01  # observed 1.00
    (edges,) = call(shim.hypotenuses, [0.0, -2.0, 0.0], [0.0, 0.0, -3.0], outputs=1)
    assert list(edges) == [0.0, 2.0, 3.0]
