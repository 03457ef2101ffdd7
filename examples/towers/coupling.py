"""A span or line between two towers, and three ways of stepping them with FMPy's FMU2Slave.

All inputs are values reached at the end of a communication step, which are unknown at its
beginning. The three masters differ in what they take instead.
"""

import ctypes
import tempfile
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray
from pythonfmu.builder import FmuBuilder

import gallop_fmu as gf

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Names:
    """Names of the two ends in the cable's FMU, and of the output that is recorded."""

    ends: tuple[str, str]
    recorded: str

    @property
    def displacements(self) -> list[str]:
        return [f"{end}.{axis}" for end in self.ends for axis in ("x1", "x3")]

    @property
    def forces(self) -> list[str]:
        return [f"{end}.{force}" for end in self.ends for force in ("f1", "f3")]


SPAN = Names(("support.left", "support.right"), "midspan.x2")
LARGEST = 1.0
"""Displacement [m] of a tower point beyond which a run counts as unstable."""
TOLERANCE = 1e-9
"""Change [m] of the tower points between two iterations at which a step is accepted."""
MOST_ITERATIONS = 50


def galloping_span(cable_step: float) -> gf.Scene:
    """The span of example 3 with a large seed: it gallops at once; steps of `cable_step` [s]."""
    return gf.load_scene("example3").with_values(
        {
            "initial.seed_vertical": 0.1,
            "initial.seed_horizontal": 0.1,
            "numerics.time_step": cable_step,
        }
    )


def galloping_line(cable_step: float) -> gf.LineScene:
    """Three spans like that of example 3 on strings of 2.1 m, with steps of `cable_step` [s]."""
    data = tomllib.loads(galloping_span(cable_step).to_toml())
    span = data.pop("span")
    for name in ("supports", "sources", "line"):
        data.pop(name, None)
    string = {"kind": "string", "length": 2.1, "weight": 490.0}
    data["section"] = {
        "horizontal_tension": span["horizontal_tension"],
        "spans": [{"length": span["length"]}] * 3,
        "suspensions": [string, string],
    }
    data["title"] = "Three galloping spans between two towers"
    data["numerics"]["elements"] = 8
    return gf.LineScene.from_dict(data)


def preload(scene: gf.Scene | gf.LineScene) -> Array:
    """Static forces of the cable on the towers: left f1, f3, right f1, f3 [N]."""
    return gf.Model(scene).equilibrium().support_force[:, [0, 2]].ravel()


class UnstableError(RuntimeError):
    """A run that grows without bounds, or an FMU that refuses a step for that reason."""


def build_tower(folder: Path) -> Path:
    """The tower's FMU, written into `folder`."""
    script = Path(__file__).with_name("modal_tower.py")
    options = {"canGetAndSetFMUstate": True, "canSerializeFMUstate": True}
    return Path(FmuBuilder.build_FMU(script, dest=folder / "tower.fmu", **options))


class Log:
    """Log of the FMUs of one line; FMPy's own callbacks would print it."""

    def __init__(self) -> None:
        self.messages: list[str] = []
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda *call: self.messages.append(call[-1].decode())
        )
        self.callbacks.allocateMemory = defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = defaultCallbacks.freeMemory
        addLoggerProxy(ctypes.byref(self.callbacks))  # puts numbers and names into the messages


class Component:
    """One instance of an FMU, its variables by name."""

    def __init__(self, fmu: Path, name: str, log: Log) -> None:
        description = fmpy.read_model_description(str(fmu))
        self._reference = {
            variable.name: variable.valueReference for variable in description.modelVariables
        }
        self._folder = tempfile.TemporaryDirectory(prefix="fmu-")
        fmpy.extract(str(fmu), unzipdir=self._folder.name)
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self._folder.name,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmu.instantiate(callbacks=log.callbacks)
        self.fmu.setupExperiment(startTime=0.0)

    def reference(self, name: str) -> int:
        return self._reference[name]

    def set(self, names: list[str], values: Array) -> None:
        self.fmu.setReal(
            [self._reference[name] for name in names], [float(value) for value in values]
        )

    def get(self, names: list[str]) -> Array:
        return np.array(self.fmu.getReal([self._reference[name] for name in names]))

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        self._folder.cleanup()


@dataclass
class History:
    """Recorded by a master: mid-span u2, the left tower's x1 [m], iterations of each step."""

    time: list[float] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)


class Line:
    """The cable between its towers: three instances of two FMUs, connected by the methods."""

    def __init__(self, cable: Path, tower: Path, names: Names = SPAN) -> None:
        self.log, self.names = Log(), names
        self.cable = Component(cable, "cable", self.log)
        self.towers = [Component(tower, f"{end} tower", self.log) for end in ("left", "right")]
        self.parts = [self.cable, *self.towers]
        self._saved: list[object] = [None] * len(self.parts)

    def start(self, static: Array) -> None:
        """Initialise; the cable's static forces are the towers' preload, in equilibrium."""
        for part in self.parts:
            part.fmu.enterInitializationMode()
        for tower, force in zip(self.towers, np.split(static, 2), strict=True):
            tower.set(["preload.f1", "preload.f3"], force)
        self.push_towers(self.forces())
        for part in self.parts:
            part.fmu.exitInitializationMode()

    def forces(self) -> Array:
        """Of the cable on the towers [N]."""
        return self.cable.get(self.names.forces)

    def displacements(self) -> Array:
        """Of the tower points [m]."""
        return np.concatenate([tower.get(["x1", "x3"]) for tower in self.towers])

    def push_towers(self, forces: Array) -> None:
        for tower, force in zip(self.towers, np.split(forces, 2), strict=True):
            tower.set(["f1", "f3"], force)

    def move_ends(self, displacements: Array) -> None:
        if not np.max(np.abs(displacements)) < LARGEST:
            raise UnstableError(f"a tower point moved by {np.max(np.abs(displacements)):.3g} m")
        self.cable.set(self.names.displacements, displacements)

    def step(self, parts: list[Component], time: float, h: float) -> None:
        for part in parts:
            try:
                part.fmu.doStep(time, h)
            except FMICallException as problem:
                raise UnstableError(" ".join(self.log.messages)) from problem

    def save(self) -> None:
        """Remember the present state of all parts."""
        self._saved = [part.fmu.getFMUstate() for part in self.parts]

    def rewind(self) -> None:
        """Back to what was remembered."""
        for part, state in zip(self.parts, self._saved, strict=True):
            part.fmu.setFMUstate(state)

    def forget(self) -> None:
        """Give back the memory of what was remembered."""
        for part, state in zip(self.parts, self._saved, strict=True):
            part.fmu.freeFMUstate(state)

    def observed(self) -> Array:
        return np.array([self.cable.get([self.names.recorded])[0], self.towers[0].get(["x1"])[0]])

    def close(self) -> None:
        for part in self.parts:
            part.close()


def jacobi(line: Line, time: float, h: float) -> int:
    """All parts step with the last known values of the others: both directions lag by a step."""
    forces, displacements = line.forces(), line.displacements()
    line.push_towers(forces)
    line.move_ends(displacements)
    line.step(line.parts, time, h)
    return 1


def gauss_seidel(line: Line, time: float, h: float) -> int:
    """The towers step with the last known forces, then the cable with their new positions."""
    line.push_towers(line.forces())
    line.step(line.towers, time, h)
    line.move_ends(line.displacements())
    line.step([line.cable], time, h)
    return 1


def iterated(line: Line, time: float, h: float) -> int:
    """Repeat the step of cable and towers from saved states until the tower positions converge."""
    line.save()
    guess = line.displacements() + h * np.concatenate(
        [tower.get(["v1", "v3"]) for tower in line.towers]
    )
    for iteration in range(1, MOST_ITERATIONS + 1):
        line.move_ends(guess)
        line.step([line.cable], time, h)
        line.push_towers(line.forces())
        line.step(line.towers, time, h)
        displacements = line.displacements()
        if np.max(np.abs(displacements - guess)) < TOLERANCE:
            line.forget()
            return iteration
        guess = displacements
        line.rewind()
    raise UnstableError(f"the iteration did not converge at {time:.3f} s")


SCHEMES = {"Jacobi": jacobi, "Gauss-Seidel": gauss_seidel, "iterated": iterated}


def couple(
    cable: Path,
    tower: Path,
    scheme: str,
    h: float,
    stop_time: float,
    every: float,
    static: Array,
    names: Names = SPAN,
) -> History:
    """Run the line with one of `SCHEMES` in steps of `h` [s], recorded at intervals of `every` [s].

    Raises
    ------
    UnstableError
        The run grows without bounds.
    """
    line, history = Line(cable, tower, names), History()
    stride = round(every / h)
    try:
        line.start(static)
        for n in range(round(stop_time / h) + 1):
            if n % stride == 0:
                history.time.append(n * h)
                history.values.append(line.observed())
            if n * h < stop_time - 0.5 * h:
                history.iterations.append(SCHEMES[scheme](line, n * h, h))
    finally:
        line.close()
    return history
