"""The C files in a native FMU: complete, and compiled by another tool they give the same motion."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu, supported_platforms

from gallop_fmu.fmu import export_fmu
from gallop_fmu.fmu.export import platform
from gallop_fmu.fmu.sources import HISTORIES

KERNEL = Path(__file__).resolve().parents[2] / "gallop_fmu" / "kernel"


@pytest.fixture(scope="module")
def native_fmu(gallop_scene, tmp_path_factory):
    """Portable: which products are fused depends on the options of the compiler."""
    scene = gallop_scene.with_values({"numerics.portable": True})
    return export_fmu(scene, tmp_path_factory.mktemp("fmu") / "native.fmu")


@pytest.fixture
def source_fmu(native_fmu, tmp_path):
    """The FMU without a library."""
    path = tmp_path / "source.fmu"
    with zipfile.ZipFile(native_fmu) as whole, zipfile.ZipFile(path, "w") as stripped:
        for name in whole.namelist():
            if not name.startswith("binaries/"):
                stripped.writestr(name, whole.read(name))
    return path


def test_all_c_files_are_there_and_the_description_names_them(native_fmu):
    wanted = {
        f"sources/{file.name}": file.read_bytes()
        for file in KERNEL.iterdir()
        if file.suffix in (".c", ".h") and not file.name.startswith(("fmi3", *HISTORIES))
    }
    assert len(wanted) > 10
    with zipfile.ZipFile(native_fmu) as archive:
        found = {
            name: archive.read(name) for name in archive.namelist() if name.startswith("sources/")
        }
    assert found == wanted
    (configuration,) = read_model_description(str(native_fmu)).buildConfigurations
    named = configuration.sourceFileSets[0].sourceFiles
    assert named == sorted(name.removeprefix("sources/") for name in wanted if name.endswith(".c"))


def test_compiled_by_fmpy_it_gives_the_same_bits(native_fmu, source_fmu):
    assert supported_platforms(str(source_fmu)) == ["c-code"]
    # cmake and ninja come with the extra "test", into the folder of this Python
    folder = str(Path(sys.executable).parent)
    environment = {
        **os.environ,
        "PATH": os.pathsep.join([folder, os.environ["PATH"]]),
        "CMAKE_GENERATOR": "Ninja",
    }
    command = [sys.executable, "-m", "fmpy", "compile", str(source_fmu)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert platform() in supported_platforms(str(source_fmu))
    runs = [
        simulate_fmu(str(path), stop_time=5.0, output_interval=0.01)
        for path in (native_fmu, source_fmu)
    ]
    assert np.ptp(runs[0]["midspan.x2"]) > 1e-3
    assert (
        runs[0].tobytes() == runs[1].tobytes()
    )  # observed: every bit, with the flags of CMake's release
