"""The span as a slave of pythonfmu 0.7, which calls these methods from its binary.

The state machine is the kernel's, as in the native FMU (`gallop_fmu.fmu.cosim`). Only the answer to
a refused call differs: pythonfmu's setters can report neither an error nor a warning, and an
exception that leaves a method becomes fmi2Fatal, after which the host may call no instance any
more. So a refused call is logged and printed to stderr (hosts show the log only on request), and
steps return False (fmi2Discard) until the call was repeated with success.
"""

from __future__ import annotations

import atexit
import ctypes
import math
import sys
from collections.abc import Callable, Hashable, Iterable, Sequence
from pathlib import Path
from typing import Any, ClassVar

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from gallop_fmu.fmu.cosim import Cosim, CosimError
from gallop_fmu.fmu.description import Identity
from gallop_fmu.fmu.model_bin import MODEL_FILE

RUNTIME = "python"


class SpanSlave(Fmi2Slave):  # type: ignore[misc]
    """Base of the class that each exported FMU defines in a module named after its content."""

    content: ClassVar[str] = ""
    """Identity of the FMU, set by the generated class."""

    _resource: ClassVar[bytes | None] = None
    """The resource file, read by the first instance: the host may remove the unpacked files."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        _leave_search_path(self.resources)
        _release_before_exit(Path(self.resources).parent, type(self).__name__)
        self._printed = ""
        self._refused: dict[Hashable, str] = {}
        cls = type(self)
        try:
            if cls._resource is None:
                cls._resource = Path(self.resources, MODEL_FILE).read_bytes()
            self._cosim = Cosim(cls._resource, Identity(self.content).guid)
        except (CosimError, OSError) as problem:
            self._print(str(problem))
            raise

    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Take start and stop time; the tolerance is the scene's."""
        self._attempt(["times"], self._cosim.set_up, start_time, stop_time)

    def enter_initialization_mode(self) -> None:
        """Begin initialization."""
        self._attempt(["initialization"], self._cosim.enter_initialization)

    def exit_initialization_mode(self) -> None:
        """Compute the initial state."""
        self._attempt(["initialization"], self._cosim.exit_initialization)

    def terminate(self) -> None:
        """End the run."""
        self._attempt([], self._cosim.terminate)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance; False (fmi2Discard) if that is impossible, or a call before was refused."""
        if self._refused:
            reasons = "; ".join(dict.fromkeys(self._refused.values()))
            self._log(f"no step is made after a refused call: {reasons}")
            return False
        return self._attempt([], self._cosim.step, current_time, step_size)

    def get_real(self, references: Sequence[int]) -> list[float]:
        """Return the values of Reals; NaN if one of them cannot be read."""
        return self._get("real", references, math.nan)

    def get_integer(self, references: Sequence[int]) -> list[int]:
        """Return the values of Integers; 0 if one of them cannot be read."""
        return self._get("integer", references, 0)

    def get_boolean(self, references: Sequence[int]) -> list[bool]:
        """Return False and log that there are no Booleans."""
        return self._get("boolean", references, False)

    def get_string(self, references: Sequence[int]) -> list[str]:
        """Return "" and log that there are no Strings."""
        return self._get("string", references, "")

    def set_real(self, references: Sequence[int], values: Sequence[float]) -> None:
        """Take Reals from the host: all of them or, if one is refused, none."""
        self._attempt(references, self._cosim.set, "real", references, values)

    def set_integer(self, references: Sequence[int], values: Sequence[int]) -> None:
        """Take Integers from the host: all of them or, if one is refused, none."""
        self._attempt(references, self._cosim.set, "integer", references, values)

    def set_boolean(self, references: Sequence[int], values: Sequence[Any]) -> None:
        """Refuse: there are no Booleans."""
        self._attempt(references, self._cosim.set, "boolean", references, values)

    def set_string(self, references: Sequence[int], values: Sequence[Any]) -> None:
        """Refuse: there are no Strings."""
        self._attempt(references, self._cosim.set, "string", references, values)

    def _get(self, kind: str, references: Sequence[int], missing: Any) -> list[Any]:
        try:
            return self._cosim.get(kind, references)
        except CosimError as problem:
            self._log(str(problem))
            return [missing] * len(references)

    def _attempt(
        self, keys: Iterable[Hashable], call: Callable[..., None], *arguments: Any
    ) -> bool:
        """Call; if refused, log the reason and keep it until a call with these keys succeeds."""
        try:
            call(*arguments)
        except CosimError as problem:
            self._log(str(problem))
            self._refused.update(dict.fromkeys(keys, str(problem)))
            return False
        for key in keys:
            self._refused.pop(key, None)
        return True

    def _print(self, message: str) -> None:
        """Show a message on stderr; not twice in a row, as hosts may repeat a call many times."""
        if message != self._printed:
            print(f"gallop-fmu: {message}", file=sys.stderr, flush=True)
        self._printed = message

    def _log(self, message: str) -> None:
        self._print(message)
        text = message.replace("%", " percent")  # hosts read the message as a format of printf
        self.log(text, Fmi2Status.error, "logStatusError")

    def _get_fmu_state(self) -> bytes:
        return self._cosim.save()

    def _set_fmu_state(self, state: bytes) -> None:
        if self._attempt(["state"], self._cosim.restore, state):
            self._refused.clear()

    @staticmethod
    def _fmu_state_to_bytes(state: bytes) -> bytes:
        return state

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> bytes:
        return state


def _leave_search_path(folder: str) -> None:
    """Remove the folder of an instance, which pythonfmu adds to Python's search path."""
    if folder in sys.path:
        sys.path.remove(folder)


def _release_before_exit(folder: Path, name: str) -> None:
    """Make pythonfmu's library in an unpacked FMU release its Python state while Python still runs.

    On Linux its static shared pointer is destroyed at exit, and its unloading function then assigns
    to it once more: freed memory is used, and the program may abort. Once the state is released,
    the library has none. The reference to the library keeps it loaded until then.
    """
    library = folder / "binaries" / "linux64" / f"{name}.so"
    if sys.platform == "linux" and library.is_file():
        atexit.register(ctypes.CDLL(str(library)).finalizePythonInterpreter)
