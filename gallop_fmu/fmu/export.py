"""Export of a scene as an FMU.

Equal scenes give equal files, byte for byte, on any machine with the same packages: entries in
order, without time stamps, uncompressed. The Python module in an FMU is named after its content,
because several FMUs can be in one process, and Python identifies modules by name.
"""

from __future__ import annotations

import io
import os
import platform as machine
import sys
import zipfile
from collections.abc import Collection, Sequence
from importlib import metadata, resources
from pathlib import Path

import numpy as np

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.library import library_path
from gallop_fmu.engine.model import Model
from gallop_fmu.fmu import fmi2_xml, fmi3_xml
from gallop_fmu.fmu.cross_compile import PLATFORMS, CompilerError, cross_library
from gallop_fmu.fmu.description import SCENE_FILE, Identity, describe, identify
from gallop_fmu.fmu.documentation import PAGE, documentation
from gallop_fmu.fmu.model_bin import MODEL_FILE, model_bin
from gallop_fmu.fmu.ports import QUARTERS, Ports, wind_speed_at_start
from gallop_fmu.fmu.reference import REFERENCE_FILE, reference_result
from gallop_fmu.fmu.sources import kernel_sources
from gallop_fmu.fmu.variable import Variable
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.foundation.atomic_write import check_target, write_whole
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.version import version
from gallop_fmu.input.scene_like import SceneLike, as_scene
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

RUNTIMES = ("native", "python")
DESCRIPTION = "modelDescription.xml"
ARTWORK = Path(__file__).with_name("artwork")
SLAVE_SCRIPT = '''\
"""A span for pythonfmu. Its code is in the package gallop-fmu, of the version that exported it."""

import ctypes
import sys
from importlib.metadata import PackageNotFoundError, version

# For every instance, pythonfmu 0.7.0 runs this text in the module's namespace, and then releases a
# reference to the namespace that it does not own. Without this one, the host crashes later.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))

try:
    found = "version " + version("gallop-fmu")
except PackageNotFoundError:
    found = "none"
if found != "version {version}":
    message = (
        "this FMU needs the Python package gallop-fmu=={version} in "
        f"{{sys.prefix}}, where there is {{found}}; "
        "run `pip install gallop-fmu=={version}` there, or export the scene again"
    )
    print(f"gallop-fmu: {{message}}", file=sys.stderr)
    raise ImportError(message)

from gallop_fmu.fmu.slave import SpanSlave


class {name}(SpanSlave):
    content = "{content}"
'''


class ExportError(ValueError):
    """A scene cannot be written as an FMU; the message says why, then the remedy."""


def export_fmu(
    scene: SceneLike,
    path: str | os.PathLike[str],
    runtime: str = "native",
    platforms: Collection[str] | None = None,
    *,
    wind: str = "line",
    stations: Collection[float] = QUARTERS,
    fmi: int = 2,
) -> Path:
    """Write a scene as an FMU for co-simulation.

    Parameters
    ----------
    scene
        The scene.
    path
        File to write, with suffix ``.fmu``; an existing file is replaced.
    runtime
        Run-time of the FMU. "native": the kernel's own library, for the platform of this
        installation; the host needs nothing else. "python": pythonfmu 0.7 (Linux and Windows,
        64 bit), for hosts with a Python in which this version of gallop-fmu is installed, which
        unpack the FMU under a path of plain letters, digits and spaces, and instantiate from one
        thread at a time (a limitation of pythonfmu; steps may run in several).
    platforms
        Platforms of the libraries in a native FMU, compiled here with the extra ``cross``:
        "linux64" (glibc 2.17 or later), "win64", "darwin64" (Intel and Apple silicon). None or
        empty: the installed library, for this one.
    wind
        Of a line: "line" for one wind speed, "span" for one of each span.
    stations
        Places in each span, besides its middle, of which the FMU has outputs: fractions of the
        span, greater than 0 and less than 1.
    fmi
        Version of FMI: 2 (FMI 2.0, which more hosts take) or 3 (FMI 3.0, with a terminal for each
        tower; native only). Library, variables and results are the same.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ExportError
        Unknown run-time, platform, version or kind of wind, a station outside of the span, wrong
        suffix, missing folder, the file cannot be written, or the kernel cannot be compiled for a
        platform.
    SimulationError
        The scene has no initial equilibrium.
    """
    target = Path(path)
    if runtime not in RUNTIMES:
        raise ExportError(f"runtime = {runtime!r}: must be one of {', '.join(map(repr, RUNTIMES))}")
    for name in platforms or ():
        if name not in PLATFORMS:
            raise ExportError(f"platforms: {name!r} is unknown; there are {', '.join(PLATFORMS)}")
    if platforms and runtime != "native":
        raise ExportError(
            'platforms are for the native runtime only; omit them, or use runtime="native"'
        )
    try:
        check_target(target, (".fmu",))
    except SceneError as problem:
        raise ExportError(str(problem)) from None
    if fmi not in (2, 3):
        raise ExportError(f"fmi = {fmi!r}: must be 2 or 3")
    if fmi == 3 and runtime != "native":
        raise ExportError(
            'fmi = 3: the Python runtime has FMI 2.0 only; use runtime="native", or omit fmi'
        )
    scene = as_scene(scene)
    ports = _ports_of(scene, wind, stations)
    _require_start(scene)
    if runtime == "python":
        files = _python_files(scene, ports)
    else:
        files = _native_files(scene, ports, fmi) | _binaries(scene, ports, platforms, fmi)
    _write(target, files)
    return target


def _ports_of(scene: Scene | LineScene, wind: str, stations: Collection[float]) -> Ports:
    """Return what is chosen of inputs and outputs."""
    if wind == "span" and not isinstance(scene, LineScene):
        raise ExportError('wind = "span": the scene is one span; omit it, or export a line')
    if wind == "line" and isinstance(scene, LineScene):
        for number, span in enumerate(scene.section.spans, start=1):
            if span.wind is not None:
                raise ExportError(
                    f'wind = "line": span {number} has its own wind, which one input of all spans'
                    ' would replace; use wind = "span" (--wind span), or remove its wind'
                )
    try:
        return Ports(wind, tuple(stations))  # type: ignore[arg-type]  # it checks
    except ValueError as problem:
        raise ExportError(str(problem)) from None


def _require_start(scene: Scene | LineScene) -> None:
    """Compute the initial state that the FMU has if its host sets nothing."""
    if isinstance(scene, LineScene):
        spans = range(1, len(scene.section.spans) + 1)
        speed = np.array([float(scene.wind_of_span(span).at(0.0)) for span in spans])
    else:
        speed = np.array([wind_speed_at_start(scene.wind)])
    at_start = Inputs.still(scene, wind_speed=speed if len(speed) > 1 else float(speed[0]))
    Model(scene).start(0.0, at_start)


def _identity(scene: Scene | LineScene, ports: Ports, runtime: str) -> Identity:
    return identify(scene.to_toml(), version(), runtime, ports.identity, scene.title)


def _native_files(scene: Scene | LineScene, ports: Ports, fmi: int) -> dict[str, bytes]:
    """Return the content of each file but the libraries by its name in the archive."""
    identity = _identity(scene, ports, "native")
    variables = fmu_variables(scene, ports)
    files = _common_files(scene, ports, identity, variables)
    for name, source in kernel_sources(fmi).items():
        files[f"sources/{name}"] = source
    description = describe(scene)
    if fmi == 2:
        files[DESCRIPTION] = fmi2_xml.model_description(
            scene, description, variables, identity, native=True
        )
        files["model.png"] = (ARTWORK / "model.png").read_bytes()
    else:
        files[DESCRIPTION] = fmi3_xml.model_description(scene, description, variables, identity)
        files["sources/buildDescription.xml"] = fmi3_xml.build_description(identity)
        folder = "terminalsAndIcons"
        files[f"{folder}/terminalsAndIcons.xml"] = fmi3_xml.terminals_and_icons(variables)
        files[f"{folder}/icon.png"] = (ARTWORK / "model.png").read_bytes()
        files[f"{folder}/tower.png"] = (ARTWORK / "tower.png").read_bytes()
    return files | _licences("gallop-fmu")


def _common_files(
    scene: Scene | LineScene,
    ports: Ports,
    identity: Identity,
    variables: Sequence[Variable],
    remarks: str = "",
) -> dict[str, bytes]:
    """Return the files that all FMUs have."""
    resource = model_bin(scene, identity.guid, version(), ports)
    reference = reference_result(scene, resource, identity.guid, variables)
    return {
        PAGE: documentation(scene.title, describe(scene, remarks), variables, reference),
        REFERENCE_FILE: reference.csv(),
        f"resources/{MODEL_FILE}": resource,
        f"resources/{SCENE_FILE}": scene.to_toml().encode(),
    }


FOLDERS_3 = {
    "linux64": ("x86_64-linux",),
    "win64": ("x86_64-windows",),
    "darwin64": ("x86_64-darwin", "aarch64-darwin"),
}
"""Folders of FMI 3.0 by the platform of FMI 2.0; the library for macOS is for both processors."""


def _binaries(
    scene: Scene | LineScene, ports: Ports, platforms: Collection[str] | None, fmi: int
) -> dict[str, bytes]:
    """Return the libraries by their names in the archive."""
    name = _identity(scene, ports, "native").model_identifier
    if not platforms:
        library = library_path()
        folder = platform() if fmi == 2 else platform_3()
        return {f"binaries/{folder}/{name}{library.suffix}": library.read_bytes()}
    files = {}
    for chosen in platforms:
        try:
            content = cross_library(chosen)
        except CompilerError as problem:
            raise ExportError(str(problem)) from None
        for folder in (chosen,) if fmi == 2 else FOLDERS_3[chosen]:
            files[f"binaries/{folder}/{name}{PLATFORMS[chosen].suffix}"] = content
    return files


def platform() -> str:
    """Return the name of this platform in FMI 2.0."""
    return {"win32": "win64", "darwin": "darwin64"}.get(sys.platform, "linux64")


def platform_3() -> str:
    """Return the name of this platform in FMI 3.0."""
    processor = {"arm64": "aarch64", "aarch64": "aarch64"}.get(machine.machine(), "x86_64")
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    return f"{processor}-{system}"


def _python_files(scene: Scene | LineScene, ports: Ports) -> dict[str, bytes]:
    """Return the content of each file by its name in the archive."""
    from gallop_fmu.fmu.slave import RUNTIME

    release = version()
    identity = _identity(scene, ports, RUNTIME)
    name = identity.model_identifier
    remarks = (
        "After a refused value steps fail until it is set right. Needs a"
        f" Python with gallop-fmu {release} in the host (pythonfmu 0.7), and an unpacking path in"
        " plain ASCII."
    )
    script = SLAVE_SCRIPT.format(version=release, name=name, content=identity.content)
    variables = fmu_variables(scene, ports)
    files = _common_files(scene, ports, identity, variables, remarks) | {
        DESCRIPTION: fmi2_xml.model_description(
            scene, describe(scene, remarks), variables, identity, native=False
        ),
        "model.png": (ARTWORK / "model.png").read_bytes(),
        f"resources/{name}.py": script.encode(),
        "resources/slavemodule.txt": name.encode(),
        "resources/requirements.txt": f"gallop-fmu=={release}\n".encode(),
        "documentation/externalDependencies.txt": (
            f"A Python in the host with the package gallop-fmu=={release}.\n".encode()
        ),
    }
    return files | _pythonfmu_binaries(identity) | _licences("gallop-fmu", "pythonfmu")


def _pythonfmu_binaries(identity: Identity) -> dict[str, bytes]:
    """Return the libraries of pythonfmu for all its platforms, under the names of FMI."""
    files = {}
    for platform in resources.files("pythonfmu").joinpath("resources", "binaries").iterdir():
        for library in platform.iterdir() if platform.is_dir() else ():
            suffix = Path(library.name).suffix
            if suffix in (".so", ".dll", ".dylib"):
                files[f"binaries/{platform.name}/{identity.model_identifier}{suffix}"] = (
                    library.read_bytes()
                )
    return files


def _licences(*distributions: str) -> dict[str, bytes]:
    """Return the licences of the packages whose files are in the FMU.

    FMI calls the one to begin with license.txt.
    """
    files = {}
    for distribution in distributions:
        for file in metadata.files(distribution) or ():
            if "licenses" in file.parts and file.name.startswith("LICENSE"):
                name = "license" if distribution == "gallop-fmu" else distribution
                files[f"documentation/licenses/{name}.txt"] = file.read_binary()
    return files


def _write(target: Path, files: dict[str, bytes]) -> None:
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name)  # its time stamp is 1980
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            archive.writestr(entry, files[name])
    try:
        write_whole(target, memory.getvalue())
    except OSError as problem:
        raise ExportError(
            f"{target} cannot be written ({problem.strerror}); choose another place"
        ) from None
