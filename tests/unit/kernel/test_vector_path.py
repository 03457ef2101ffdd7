"""Portable vector code gives the bits of plain code; fused multiply-add differs by rounding."""

import ctypes as c
import platform
import re
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest

import gallop_fmu
from gallop_fmu.engine import model as engine
from gallop_fmu.foundation.channels import NODE_INDEX
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.input.scene_files import load_scene

FLAGS = [
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-shared",
    "-fPIC",
    "-w",
]
CHANNELS = np.array([NODE_INDEX[name] for name in ("u2", "u3", "theta", "tension")], np.int32)


@pytest.fixture(scope="module")
def plain_kernel(tmp_path_factory):
    """The kernel compiled for any x86-64, with one path only."""
    sources = sorted(Path(gallop_fmu.__file__).parent.glob("kernel/*.c"))
    headers = Path(fmpy.__file__).parent / "c-code"
    library = tmp_path_factory.mktemp("kernel") / "plain.so"
    command = ["cc", "-std=c11", *FLAGS, "-DGALLOP_ONE_PATH", f"-I{headers}", *map(str, sources)]
    subprocess.run([*command, "-o", str(library), "-lm"], check=True)
    loaded = c.CDLL(str(library))
    for name in dir(engine.kernel):
        if name.startswith("gallop_"):
            known = getattr(engine.kernel, name)
            getattr(loaded, name).restype, getattr(loaded, name).argtypes = (
                known.restype,
                known.argtypes,
            )
    return loaded


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the loader picks a path with glibc")
@pytest.mark.skipif(platform.machine() != "x86_64", reason="AVX2 is of x86-64")
def test_functions_along_the_span_are_compiled_for_avx2(tmp_path):
    """The header decides independently of what is included before it, and so in every file."""
    source = tmp_path / "lanes.c"
    source.write_text('#include "base_lanes.h"\nTWO_PATHS double f(double x) { return x; }\n')
    kernel = Path(gallop_fmu.__file__).parent / "kernel"
    command = ["cc", "-std=c11", "-E", f"-I{kernel}", str(source)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert re.search(r'target_clones\("avx2", "default"\)\)\) double f', text)


def motion(scene):
    model = engine.Model(scene)
    run = model.start().run(200, 5, CHANNELS, np.arange(model.nodes, dtype=np.int32))
    return run.node_values, run.span_values


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", ["example1", "example2", "example3", "zebra"])
def test_bits_do_not_depend_on_the_path(plain_kernel, monkeypatch, name, integrator):
    values = (
        {} if name == "example1" else {"initial.seed_vertical": 0.1, "initial.seed_horizontal": 0.1}
    )
    values |= {"numerics.integrator": integrator, "numerics.portable": True}
    scene = load_scene(name).with_values(values)
    fast = motion(scene)
    monkeypatch.setattr(engine, "kernel", plain_kernel)
    plain = motion(scene)
    assert np.abs(plain[0][:, 0]).max() > 1e-3
    for one, other in zip(fast, plain, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.skipif(
    not engine.kernel.gallop_has_fused_path(), reason="the processor has no AVX-512"
)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize(
    ("name", "bound"),
    [("example1", 1e-11), ("example3", 2e-14)],  # observed at most 4.4e-12, 5.4e-15
)
def test_fused_multiply_add_differs_by_rounding(name, bound, integrator):
    """A tight Newton tolerance: otherwise one iteration more or less is the larger difference."""
    values = {"numerics.integrator": integrator, "numerics.newton_tolerance": 1e-13}
    if name != "example1":
        values |= {"initial.seed_vertical": 0.1, "initial.seed_horizontal": 0.1}
    scene = load_scene(name).with_values(values)
    fused = motion(scene)[0][:, 0]
    portable = motion(scene.with_values({"numerics.portable": True}))[0][:, 0]
    difference = np.abs(fused - portable).max() / np.abs(portable).max()
    assert 0.0 < difference < bound
