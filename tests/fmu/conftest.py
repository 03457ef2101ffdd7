"""Exported scenes, and a host that can call an FMU function by function."""

import shutil
from contextlib import suppress

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

from gallop_fmu.fmu import export_fmu
from gallop_fmu.input.scene_files import load_scene


class Host:
    """One instance of an FMU, its variables by name, and what it logged."""

    def __init__(self, path, folder):
        self.description = read_model_description(str(path))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.outputs = [
            name for name, variable in self.variables.items() if variable.causality == "output"
        ]
        self.log = []
        self.folder = folder
        extract(str(path), unzipdir=str(folder))
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="span",
        )

        def keep(environment, name, status, category, message):
            self.log.append(message.decode())

        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(keep)
        self.callbacks.allocateMemory = defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = defaultCallbacks.freeMemory
        self.fmu.instantiate(callbacks=self.callbacks, loggingOn=True)
        self.time = 0.0

    def start(self, time=0.0, **values):
        self.fmu.setupExperiment(startTime=time)
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time = time
        return self

    def set(self, **values):
        """Keywords with ``__`` in place of dots."""
        for name, value in values.items():
            self[name.replace("__", ".")] = value

    def __setitem__(self, name, value):
        variable = self.variables[name]
        setter = self.fmu.setReal if variable.type == "Real" else self.fmu.setInteger
        setter([variable.valueReference], [value])

    def __getitem__(self, name):
        variable = self.variables[name]
        getter = self.fmu.getReal if variable.type == "Real" else self.fmu.getInteger
        return getter([variable.valueReference])[0]

    def read(self):
        return {name: self[name] for name in self.outputs}

    def step(self, size, count=1):
        for _ in range(count):
            self.fmu.doStep(self.time, size)
            self.time += size
        return self

    def close(self):
        with suppress(Exception):
            self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


@pytest.fixture(scope="session", params=["native", "python"])
def runtime(request):
    """Runtime inside the FMU.

    A module about one of them is parametrised with `indirect=True`: with an override the session
    would keep the files of the other.
    """
    return request.param


@pytest.fixture(scope="session")
def gallop_scene():
    """Example 2 of Liu et al. (2009), coarse mesh: springs at both ends, wind, damping, a seed."""
    return load_scene("example2").with_values({"numerics.elements": 6})


@pytest.fixture(scope="session")
def gallop_fmu(gallop_scene, runtime, tmp_path_factory):
    return export_fmu(gallop_scene, tmp_path_factory.mktemp("fmu") / "gallop.fmu", runtime=runtime)


@pytest.fixture(scope="session")
def rigid_scene():
    """Example 3 of Liu et al. (2009), coarse mesh: rigid ends, which feel the towers at once."""
    return load_scene("example3").with_values({"numerics.elements": 6})


@pytest.fixture(scope="session")
def rigid_fmu(rigid_scene, runtime, tmp_path_factory):
    return export_fmu(rigid_scene, tmp_path_factory.mktemp("fmu") / "rigid.fmu", runtime=runtime)


@pytest.fixture
def host(tmp_path):
    """Instantiate an FMU; released at the end of the test."""
    hosts = []

    def open_fmu(path):
        hosts.append(Host(path, tmp_path / f"unpacked{len(hosts)}"))
        return hosts[-1]

    yield open_fmu
    for one in hosts:
        one.close()
