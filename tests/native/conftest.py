"""Native FMUs, a C compiler, and a host that calls the library's functions one by one."""

import ctypes as c
import fcntl
import importlib.util
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from fmpy import extract, read_model_description

from gallop_fmu.fmu import export_fmu
from gallop_fmu.input.scene_files import load_scene

HERE = Path(__file__).parent
HEADERS = Path(importlib.util.find_spec("fmpy").origin).parent / "c-code"
OK, WARNING, DISCARD, ERROR = range(4)
LOGGER = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p)


class Callbacks(c.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOGGER),
        *(
            (name, c.c_void_p)
            for name in ("allocateMemory", "freeMemory", "stepFinished", "environment")
        ),
    )


class Unpacked:
    """An FMU unpacked into a folder."""

    def __init__(self, path, folder):
        extract(str(path), unzipdir=str(folder))
        self.path, self.folder, self.resources = path, folder, folder / "resources"
        self.description = read_model_description(str(path))
        self.guid = self.description.guid
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.outputs = [
            v.name for v in self.variables.values() if v.causality == "output" and v.type == "Real"
        ]
        self.library = next((folder / "binaries").glob("*64/*"))

    def reference(self, name):
        return self.variables[name].valueReference


class Instance:
    """One instance; `call` returns the status and keeps messages; other methods require fmi2OK."""

    def __init__(self, fmu, *, guid=None, resources=None):
        self.fmu, self.log = fmu, []
        self.library = c.CDLL(str(fmu.library))
        self.callbacks = Callbacks(logger=LOGGER(lambda *args: self.log.append(args[-1].decode())))
        instantiate = self.library.fmi2Instantiate
        instantiate.restype = c.c_void_p
        location = resources if resources is not None else fmu.resources.as_uri()
        location = location.encode() if isinstance(location, str) else location
        text = (guid or fmu.guid).encode()
        self.component = c.c_void_p(
            instantiate(b"span", 1, text, location, c.byref(self.callbacks), 0, 0)
        )
        self.time = 0.0

    def call(self, name, *arguments):
        return getattr(self.library, f"fmi2{name}")(self.component, *arguments)

    def insist(self, name, *arguments):
        assert self.call(name, *arguments) == OK, (name, self.log)

    def set_up(self, start=0.0, stop=None):
        return self.call(
            "SetupExperiment",
            0,
            c.c_double(0),
            c.c_double(start),
            stop is not None,
            c.c_double(stop or 0),
        )

    def start(self, start=0.0, **values):
        """Initialise; keywords with ``__`` in place of dots."""
        assert self.set_up(start) == OK
        self.insist("EnterInitializationMode")
        for name, value in values.items():
            self[name.replace("__", ".")] = value
        self.insist("ExitInitializationMode")
        self.time = start
        return self

    def _access(self, way, references, values, kind):
        array = (c.c_uint * len(references))(*references)
        numbers = (kind * len(references))(*values)
        status = self.call(way, array, c.c_size_t(len(references)), numbers)
        return status, list(numbers)

    def set_real(self, references, values):
        return self._access("SetReal", references, values, c.c_double)[0]

    def get_real(self, references):
        return self._access("GetReal", references, [0.0] * len(references), c.c_double)

    def set_integer(self, references, values):
        return self._access("SetInteger", references, values, c.c_int)[0]

    def get_integer(self, references):
        return self._access("GetInteger", references, [0] * len(references), c.c_int)

    def __setitem__(self, name, value):
        variable = self.fmu.variables[name]
        setter = self.set_real if variable.type == "Real" else self.set_integer
        assert setter([variable.valueReference], [value]) == OK, (name, value, self.log)

    def __getitem__(self, name):
        variable = self.fmu.variables[name]
        getter = self.get_real if variable.type == "Real" else self.get_integer
        status, values = getter([variable.valueReference])
        assert status == OK, (name, self.log)
        return values[0]

    def outputs(self):
        """The bits of all outputs."""
        return {
            name: float(self[name]).hex()
            for name, v in self.fmu.variables.items()
            if v.causality == "output"
        }

    def do_step(self, time, size):
        return self.call("DoStep", c.c_double(time), c.c_double(size), 1)

    def step(self, size, count=1):
        for _ in range(count):
            assert self.do_step(self.time, size) == OK, self.log
            self.time += size
        return self

    def input_rates(self, **rates):
        references = (c.c_uint * len(rates))(
            *(self.fmu.reference(name.replace("__", ".")) for name in rates)
        )
        orders = (c.c_int * len(rates))(*[1] * len(rates))
        values = (c.c_double * len(rates))(*rates.values())
        self.insist("SetRealInputDerivatives", references, c.c_size_t(len(rates)), orders, values)

    def output_rates(self, names):
        count, values = len(names), (c.c_double * len(names))()
        references = (c.c_uint * count)(*(self.fmu.reference(name) for name in names))
        status = self.call(
            "GetRealOutputDerivatives",
            references,
            c.c_size_t(count),
            (c.c_int * count)(*[1] * count),
            values,
        )
        return status, dict(zip(names, values, strict=True))

    def directional(self, outputs, inputs, seed):
        unknown = (c.c_uint * len(outputs))(*(self.fmu.reference(name) for name in outputs))
        known = (c.c_uint * len(inputs))(*(self.fmu.reference(name) for name in inputs))
        seeds, found = (c.c_double * len(inputs))(*seed), (c.c_double * len(outputs))()
        sizes = c.c_size_t(len(outputs)), c.c_size_t(len(inputs))
        status = self.call(
            "GetDirectionalDerivative", unknown, sizes[0], known, sizes[1], seeds, found
        )
        return status, dict(zip(outputs, found, strict=True))

    def save(self):
        state = c.c_void_p()
        self.insist("GetFMUstate", c.byref(state))
        return state

    def restore(self, state):
        return self.call("SetFMUstate", state)

    def drop(self, state):
        self.insist("FreeFMUstate", c.byref(state))

    def to_bytes(self, state):
        size = c.c_size_t()
        self.insist("SerializedFMUstateSize", state, c.byref(size))
        room = c.create_string_buffer(size.value)
        self.insist("SerializeFMUstate", state, room, size)
        return room.raw

    def from_bytes(self, content):
        state = c.c_void_p()
        status = self.call("DeSerializeFMUstate", content, c.c_size_t(len(content)), c.byref(state))
        return status, state

    def close(self):
        self.call("FreeInstance")


def compile_c(target, *sources, flags=()):
    """Compile with the system's compiler, which the installation needs as well."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    assert compiler, "no C compiler: install one, or name it in the environment variable CC"
    command = [
        compiler,
        "-std=c11",
        "-D_DEFAULT_SOURCE",
        "-Wall",
        "-Wextra",
        "-Werror",
        *flags,
        f"-I{HEADERS}",
    ]
    subprocess.run(
        [*command, *map(str, sources), "-o", str(target), "-ldl", "-lm", "-pthread"], check=True
    )
    return target


@pytest.fixture(scope="session")
def compiled():
    return compile_c


@pytest.fixture(scope="session")
def unpack(tmp_path_factory):
    """Export a scene as a native FMU and unpack it."""

    def export(scene):
        folder = tmp_path_factory.mktemp("native")
        return Unpacked(
            export_fmu(scene, folder / "span.fmu", runtime="native"), folder / "unpacked"
        )

    return export


@pytest.fixture(scope="session")
def example3():
    """Example 3 of Liu et al. (2009): rigid ends, wind, eccentric ice, a seed."""
    return load_scene("example3")


@pytest.fixture(scope="session")
def fmu(example3, unpack):
    return unpack(example3)


@pytest.fixture(scope="session")
def small_scene(example3):
    return example3.with_values({"numerics.elements": 4})


@pytest.fixture(scope="session")
def small(small_scene, unpack):
    return unpack(small_scene)


@pytest.fixture
def instance():
    """Instantiate an FMU; freed at the end of the test."""
    opened = []

    def open_fmu(unpacked, **settings):
        opened.append(Instance(unpacked, **settings))
        return opened[-1]

    yield open_fmu
    for one in opened:
        one.close()


@pytest.fixture(scope="session")
def kernel_sources():
    """The kernel's C files, which are in the source tree and not installed."""
    folder = HERE.parent.parent / "gallop_fmu" / "kernel"
    assert (folder / "gallop.h").exists(), f"{folder} is missing: run the tests in a source tree"
    return folder


SANITIZERS = (
    "-g",
    "-O1",
    "-ffp-contract=off",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
)


@pytest.fixture(scope="session")
def sanitized_objects(compiled, kernel_sources, tmp_path_factory):
    """The kernel with sanitizers, compiled once for all processes of a run (25 s of CPU)."""
    base, run = tmp_path_factory.getbasetemp(), os.environ.get("PYTEST_XDIST_TESTRUNUID")
    folder = base.parent / f"sanitized-{run}" if run else base / "sanitized-objects"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        sources = sorted(kernel_sources.glob("*.c"))
        objects = [folder / f"{source.stem}.o" for source in sources]
        if not (folder / "complete").exists():
            for source, target in zip(sources, objects, strict=True):
                compiled(target, source, flags=[*SANITIZERS, "-c", f"-I{kernel_sources}"])
            (folder / "complete").touch()
    return objects


@pytest.fixture(scope="session")
def sanitized(compiled, kernel_sources, sanitized_objects, tmp_path_factory):
    """Compile a program with the kernel under the address and undefined-behaviour sanitizers."""
    folder, fuzzing = tmp_path_factory.mktemp("sanitized"), HERE.parents[1] / "fuzz"

    def build(name, *programs, flags=()):
        includes = [f"-I{kernel_sources}", f"-I{fuzzing}"]
        return compiled(
            folder / name, *programs, *sanitized_objects, flags=[*SANITIZERS, *includes, *flags]
        )

    return build
