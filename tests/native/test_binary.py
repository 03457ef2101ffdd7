"""The library in a native FMU: which systems load it, and what it contains."""

import platform
import re
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.libc_ver()[0] != "glibc" or platform.machine() != "x86_64",
    reason="about ELF files for glibc on x86-64",
)


def readelf(library, *options):
    return subprocess.run(
        ["readelf", "-W", *options, str(library)], capture_output=True, text=True, check=True
    ).stdout


def test_the_library_loads_with_glibc_2_17(fmu):
    """That of 2012, which the FMUs for other platforms have as well."""
    versions = set(re.findall(r"GLIBC_(\d+)\.(\d+)", readelf(fmu.library, "--version-info")))
    assert max((int(major), int(minor)) for major, minor in versions) <= (2, 17), versions


def test_the_library_has_no_symbols_for_debuggers(fmu):
    sections = readelf(fmu.library, "--sections")
    assert ".dynsym" in sections
    if "asan" in readelf(fmu.library, "--dyn-syms"):
        pytest.skip("built with the sanitizers, which name functions by them")
    assert ".symtab" not in sections
    assert ".debug" not in sections
