"""Libraries for other platforms.

Zig itself, a large download, runs only in benchmarks/hosts/cross_check.py.
"""

import re
import struct
import subprocess
import threading
import zipfile
from concurrent.futures import ThreadPoolExecutor
from importlib import metadata
from pathlib import Path

import pytest
from fmpy import supported_platforms
from typer.testing import CliRunner

from gallop_fmu.cli.main import app
from gallop_fmu.engine.library import library_path
from gallop_fmu.fmu import ExportError, cross_compile, export_fmu
from gallop_fmu.fmu.cross_compile import (
    PLATFORMS,
    CompilerError,
    arguments,
    cache_key,
    cross_library,
    universal_library,
)

ROOT = Path(__file__).resolve().parents[2]
X86_64, ARM64 = (0x01000007, 3), (0x0100000C, 0)
"""Processor and variant, as in Apple's mach/machine.h."""


def mach_o(processor, size):
    return struct.pack("<Iii", 0xFEEDFACF, *processor) + bytes(k % 251 for k in range(size - 12))


@pytest.fixture
def zig(monkeypatch, tmp_path):
    """A compiler that writes its target into the library, an empty cache; returns the calls."""
    calls = []

    def run(command, cwd, **_):
        calls.append(command)
        target = command[command.index("-target") + 1]
        processor = ARM64 if "aarch64" in target else X86_64
        content = mach_o(processor, 1000) if "macos" in target else target.encode()
        (Path(cwd) / command[command.index("-o") + 1]).write_bytes(content)
        assert sorted(file for file in command if file.endswith(".c")) == sorted(
            f.name for f in Path(cwd).glob("*.c")
        )
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(cross_compile, "zig_version", lambda: "1.2.3")
    monkeypatch.setattr(cross_compile, "cache_folder", lambda: tmp_path / "cache" / "gallop-fmu")
    monkeypatch.setattr(cross_compile.subprocess, "run", run)
    return calls


def kept(tmp_path):
    return sorted(file.suffix for file in (tmp_path / "cache" / "gallop-fmu").iterdir())


def test_universal_library_can_be_taken_apart():
    slices = [mach_o(X86_64, 5000), mach_o(ARM64, 20001)]
    library = universal_library(slices)
    assert struct.unpack_from(">II", library) == (0xCAFEBABE, 2)
    end = 8 + 2 * 20
    for index, (content, processor) in enumerate(zip(slices, (X86_64, ARM64), strict=True)):
        *kind, offset, size, alignment = struct.unpack_from(">iiIII", library, 8 + 20 * index)
        assert tuple(kind) == processor
        assert alignment == 14  # pages of 16 kB
        assert offset % 2**14 == 0
        assert offset >= end
        end = offset + size
        assert library[offset:end] == content


def test_universal_library_is_made_of_mach_o_files():
    with pytest.raises(ValueError, match="a slice starts with 0x464c457f"):
        universal_library([b"\x7fELF" + bytes(20)])


def test_flags_are_those_of_the_installed_library():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    release = text[text.index("$<$<CONFIG:Release>") : text.index("-Wall")]
    wanted = set(re.findall(r"-[fO][\w=-]+", release))
    assert len(wanted) == 4
    given = set(cross_compile.FLAGS)
    assert wanted < given
    assert {"-std=c11", "-fvisibility=hidden", "-fno-sanitize=undefined"} < given
    assert not any(flag.startswith(("-march", "-mcpu", "-ffast")) for flag in given)


def test_command_line_of_each_system():
    lines = {
        target: arguments(platform, target, headers="H", output="O")
        for platform in PLATFORMS.values()
        for target in platform.targets
    }
    assert list(lines) == [
        "x86_64-linux-gnu.2.17",
        "x86_64-windows-gnu",
        "x86_64-macos.11.0",
        "aarch64-macos.11.0",
    ]
    for target, line in lines.items():
        assert line[:3] == ["cc", "-target", target]
        assert {"-shared", "-IH", "fmi2.c", "time_march.c"} < set(line)
        assert line[line.index("-o") + 1] == "O"
        assert not any(word.endswith(".h") for word in line)
        assert ("-Wl,-Bsymbolic" in line) == ("linux" in target)
        assert ("-DGALLOP_ONE_PATH" in line) == ("linux" in target)
        assert ("-fPIC" in line) == ("windows" not in target)
        assert "-lm" not in line or line.index("-lm") > line.index("time_march.c")


def test_an_fmu_contains_the_requested_libraries(zig, gallop_scene, tmp_path):
    paths = [
        export_fmu(gallop_scene, tmp_path / f"{k}.fmu", platforms=tuple(PLATFORMS))
        for k in range(2)
    ]
    assert set(supported_platforms(str(paths[0]))) == {"c-code", "linux64", "win64", "darwin64"}
    with zipfile.ZipFile(paths[0]) as archive:
        found = {
            Path(name): archive.read(name)
            for name in archive.namelist()
            if name.startswith("binaries/")
        }
    assert {(path.parent.name, path.suffix) for path in found} == {
        ("linux64", ".so"),
        ("win64", ".dll"),
        ("darwin64", ".dylib"),
    }
    by_suffix = {path.suffix: content for path, content in found.items()}
    assert by_suffix[".so"] == b"x86_64-linux-gnu.2.17"
    assert by_suffix[".dll"] == b"x86_64-windows-gnu"
    assert by_suffix[".dylib"] == universal_library([mach_o(X86_64, 1000), mach_o(ARM64, 1000)])
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert len(zig) == 4  # not again for the second


@pytest.mark.parametrize("name", list(PLATFORMS))
def test_an_fmu_brings_no_other_library(zig, gallop_scene, tmp_path, name):
    path = export_fmu(gallop_scene, tmp_path / "x.fmu", platforms=[name])
    assert set(supported_platforms(str(path))) == {"c-code", name}


@pytest.mark.parametrize("platforms", [None, (), []])
def test_no_platforms_means_the_installed_library(zig, gallop_scene, tmp_path, platforms):
    path = export_fmu(gallop_scene, tmp_path / "x.fmu", platforms=platforms)
    with zipfile.ZipFile(path) as archive:
        (name,) = (name for name in archive.namelist() if name.startswith("binaries/"))
        assert archive.read(name) == library_path().read_bytes()
    assert zig == []


def test_the_command_line_takes_names_with_commas(zig, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(
        app, ["export", "example1", "-o", "x.fmu", "--platforms", "win64,linux64"]
    )
    assert result.exit_code == 0, result.output
    assert set(supported_platforms("x.fmu")) == {"c-code", "linux64", "win64"}
    refused = CliRunner().invoke(
        app, ["export", "example1", "-o", "y.fmu", "--platforms", "win64,beos"]
    )
    assert refused.exit_code == 2
    assert "platforms: 'beos' is unknown; there are linux64, win64, darwin64" in refused.stderr


def test_the_key_depends_on_all_that_is_compiled(monkeypatch):
    keys = {cache_key(name, "1.2.3") for name in PLATFORMS} | {cache_key("win64", "1.2.4")}
    assert cache_key("win64", "1.2.3") in keys
    sources = cross_compile.kernel_sources()
    monkeypatch.setattr(
        cross_compile, "kernel_sources", lambda: sources | {"gallop.h": sources["gallop.h"] + b"\n"}
    )
    keys.add(cache_key("win64", "1.2.3"))
    monkeypatch.setattr(cross_compile, "FLAGS", (*cross_compile.FLAGS, "-g"))
    keys.add(cache_key("win64", "1.2.3"))
    assert len(keys) == 6


def test_a_library_is_compiled_once(zig, tmp_path):
    assert cross_library("win64") == cross_library("win64") == b"x86_64-windows-gnu"
    assert len(zig) == 1
    assert kept(tmp_path) == [".dll"]


def test_two_at_once_do_not_disturb_each_other(zig, tmp_path, monkeypatch):
    both, compile_one = threading.Barrier(2, timeout=30), cross_compile._compile

    def compile_together(*given):
        both.wait()
        library = compile_one(*given)
        both.wait()
        return library

    monkeypatch.setattr(cross_compile, "_compile", compile_together)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(cross_library, ["linux64"] * 2)) == [b"x86_64-linux-gnu.2.17"] * 2
    assert len(zig) == 2
    assert kept(tmp_path) == [".so"]


def test_a_compiler_error_is_reported_and_no_file_is_left(zig, tmp_path, monkeypatch):
    failed = subprocess.CompletedProcess([], 1, "", "time_march.c:3:1: error: no such thing\n")
    monkeypatch.setattr(cross_compile.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(
        CompilerError, match=r"for x86_64-windows-gnu:\ntime_march.c:3:1: error: no such thing"
    ):
        cross_library("win64")
    assert kept(tmp_path) == []


def test_an_unusable_cache_is_reported(zig, tmp_path):
    (tmp_path / "cache").write_text("a file where the folder should be")
    with pytest.raises(CompilerError, match=r"the cache folder .* cannot be used"):
        cross_library("linux64")


@pytest.mark.parametrize(
    ("system", "variable", "wanted"),
    [
        ("linux", "XDG_CACHE_HOME", "V"),
        ("linux", None, "H/.cache"),
        ("win32", "LOCALAPPDATA", "V"),
        ("win32", None, "H/AppData/Local"),
        ("darwin", "XDG_CACHE_HOME", "H/Library/Caches"),
    ],
)
def test_the_cache_is_the_user_s(monkeypatch, tmp_path, system, variable, wanted):
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    if variable:
        monkeypatch.setenv(variable, str(tmp_path / "V"))
    monkeypatch.setattr(cross_compile.sys, "platform", system)
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "H")
    assert cross_compile.cache_folder() == tmp_path / wanted / "gallop-fmu"


def test_without_zig_the_extra_is_named(gallop_scene, tmp_path, monkeypatch):
    version = metadata.version

    def without_zig(name):
        if name == "ziglang":
            raise metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(metadata, "version", without_zig)
    with pytest.raises(ExportError, match=r'pip install "gallop-fmu\[cross\]"'):
        export_fmu(gallop_scene, tmp_path / "x.fmu", platforms=["win64"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("runtime", "platforms", "message"),
    [
        ("native", ["win64", "win32"], "'win32' is unknown; there are linux64, win64, darwin64"),
        ("python", ["win64"], "for the native runtime only"),
    ],
)
def test_platforms_are_checked(gallop_scene, tmp_path, runtime, platforms, message):
    with pytest.raises(ExportError, match=message):
        export_fmu(gallop_scene, tmp_path / "x.fmu", runtime=runtime, platforms=platforms)
    with pytest.raises(CompilerError, match="'win32' is unknown"):
        cross_library("win32")
    assert list(tmp_path.iterdir()) == []
