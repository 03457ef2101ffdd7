"""The span as a slave of pythonfmu 0.7, which calls these methods from its binary.

An exception that leaves a method becomes fmi2Fatal, after which the host may call no instance any
more, and pythonfmu then releases its objects twice. A setter can report neither an error nor a
warning. So nothing is raised once the slave exists: what is refused is kept out, logged, printed to
stderr (hosts show the log only where they were asked to), and makes the next steps fail; a step
that fails returns False (fmi2Discard) and leaves the state untouched.
"""

from __future__ import annotations

import atexit
import ctypes
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from gallop_fmu.fmu.description import SCENE_FILE, identify
from gallop_fmu.fmu.session import RefusedError, Session
from gallop_fmu.fmu.state_bytes import from_bytes, to_bytes
from gallop_fmu.fmu.variables import Variable
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from gallop_fmu.foundation.text_files import read_text
from gallop_fmu.foundation.version import version
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.scene import Scene

RUNTIME = "python"
UNREADABLE = "unreadable"
"""Key of a state that could not be read from bytes; its value says why."""


class SpanSlave(Fmi2Slave):  # type: ignore[misc]
    """Base of the class that each exported FMU defines in a module of its own, named after its content."""

    content: ClassVar[str] = ""
    """Identity of the FMU, set by the generated class."""

    _scene: ClassVar[Scene | None] = None

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        _leave_search_path(self.resources)
        _release_before_exit(Path(self.resources).parent, type(self).__name__)
        self._printed = ""
        try:
            self._session = Session(self._scene_of(Path(self.resources)), self.content)
        except ValueError as problem:
            self._print(str(problem))
            raise
        self._by_reference = {variable.reference: variable for variable in self._session.variables}

    @classmethod
    def _scene_of(cls, resources: Path) -> Scene:
        """The scene, read by the first instance: a later one may find that its host removed the unpacked files."""
        if cls._scene is None:
            file = resources / SCENE_FILE
            if identify(read_text(file), version(), RUNTIME).content != cls.content:
                raise ValueError(
                    f"{SCENE_FILE} was changed after the export; change the scene and export it"
                    " again"
                )
            cls._scene = load_scene(file)
        return cls._scene

    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Take the start time; the stop time does not matter, and the tolerance is the scene's."""
        self._guard(self._session.set_up, start_time)

    def enter_initialization_mode(self) -> None:
        """Begin to initialise."""
        self._guard(self._session.enter_initialisation)

    def exit_initialization_mode(self) -> None:
        """Solve for the initial state, if that has not been done."""
        self._guard(self._session.leave_initialisation)

    def terminate(self) -> None:
        """End the run."""
        self._guard(self._session.terminate)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance; False (fmi2Discard) if that is impossible."""
        return self._guard(self._session.step, current_time, step_size, category="logStatusDiscard")

    def get_real(self, references: Sequence[int]) -> list[float]:
        """Values of Reals; NaN where there is none."""
        return [
            math.nan if value is None else float(value) for value in self._read(references, "Real")
        ]

    def get_integer(self, references: Sequence[int]) -> list[int]:
        """Values of Integers; 0 where there is none."""
        return [int(value or 0) for value in self._read(references, "Integer")]

    def get_boolean(self, references: Sequence[int]) -> list[bool]:
        """Nothing: no variable is a Boolean."""
        return [value is not None for value in self._read(references, "Boolean")]

    def get_string(self, references: Sequence[int]) -> list[str]:
        """Nothing: no variable is a String."""
        return ["" for _ in self._read(references, "String")]

    def set_real(self, references: Sequence[int], values: Sequence[float]) -> None:
        """Take Reals from the host."""
        self._write(references, values, "Real")

    def set_integer(self, references: Sequence[int], values: Sequence[int]) -> None:
        """Take Integers from the host."""
        self._write(references, values, "Integer")

    def set_boolean(self, references: Sequence[int], values: Sequence[Any]) -> None:
        """Refuse: no variable is a Boolean."""
        self._write(references, values, "Boolean")

    def set_string(self, references: Sequence[int], values: Sequence[Any]) -> None:
        """Refuse: no variable is a String."""
        self._write(references, values, "String")

    def _variable(self, reference: int, kind: str) -> Variable:
        variable = self._by_reference.get(reference)
        if variable is None or variable.type != kind:
            raise self._session.refuse_reference(reference, kind)
        return variable

    def _read(self, references: Sequence[int], kind: str) -> list[float | int | None]:
        self._guard(self._session.refresh)
        values: list[float | int | None] = []
        for reference in references:
            values.append(None)
            self._guard(self._read_one, values, reference, kind)
        return values

    def _read_one(self, values: list[float | int | None], reference: int, kind: str) -> None:
        values[-1] = self._session.get(self._variable(reference, kind))

    def _write(self, references: Sequence[int], values: Sequence[Any], kind: str) -> None:
        for reference, value in zip(references, values, strict=True):
            self._guard(self._write_one, reference, kind, value)

    def _write_one(self, reference: int, kind: str, value: Any) -> None:
        self._session.set(self._variable(reference, kind), value)

    def _guard(
        self, call: Callable[..., None], *arguments: Any, category: str = "logStatusError"
    ) -> bool:
        """Whether a call went well; if not, the log says why."""
        try:
            call(*arguments)
        except (RefusedError, SimulationError) as problem:
            self._log(str(problem), category)
        except Exception as problem:  # a fault of this package must not kill the host's other FMUs
            self._session.status = Outcome.BAD_CALL
            self._log(f"unexpected {type(problem).__name__}: {problem}", category)
        else:
            return True
        return False

    def _print(self, message: str) -> None:
        """Show a message on stderr; not twice in a row, as hosts may repeat a call many times."""
        if message != self._printed:
            print(f"gallop-fmu: {message}", file=sys.stderr, flush=True)
        self._printed = message

    def _log(self, message: str, category: str) -> None:
        self._print(message)
        status = Fmi2Status.discard if category == "logStatusDiscard" else Fmi2Status.error
        text = message.replace("%", " percent")  # hosts read the message as a format of printf
        self.log(text, status, category)

    def _get_fmu_state(self) -> dict[str, Any]:
        return self._session.save()

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self._guard(self._restore, state)

    def _restore(self, state: dict[str, Any]) -> None:
        if UNREADABLE in state:
            raise self._session.refuse_state(state[UNREADABLE])
        self._session.restore(state)

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        return to_bytes(state, version())

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        """The state; one that cannot be read is refused, with the reason, when it is set."""
        try:
            return from_bytes(state, version())
        except ValueError as problem:
            return {UNREADABLE: str(problem)}


def _leave_search_path(folder: str) -> None:
    """Undo that pythonfmu puts the folder of every instance in front of Python's search path, for good."""
    if folder in sys.path:
        sys.path.remove(folder)


def _release_before_exit(folder: Path, name: str) -> None:
    """Make pythonfmu's library in an unpacked FMU release its Python state while Python still runs.

    On Linux its static shared pointer is destroyed at exit, and its unloading function then assigns
    to it once more: freed memory is used, and the program aborts or not, as the memory happens to
    lie. Once the state is released, the library finds none. The reference to the library keeps it
    loaded until then.
    """
    library = folder / "binaries" / "linux64" / f"{name}.so"
    if sys.platform == "linux" and library.is_file():
        atexit.register(ctypes.CDLL(str(library)).finalizePythonInterpreter)
