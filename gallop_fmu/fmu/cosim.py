"""One span in co-simulation: the kernel's instance behind the FMU in Python, through ctypes.

The functions and their rules are those of ``kernel/gallop_cosim.h``; the native FMU uses the same.
"""

from __future__ import annotations

import ctypes as c
import math
from collections.abc import Sequence
from typing import Any

from gallop_fmu.engine.library import kernel

MESSAGE_SIZE = 1024
"""GALLOP_COSIM_MESSAGE_SIZE."""

_POINTER, _DOUBLE, _SIZE, _BYTES = c.c_void_p, c.c_double, c.c_size_t, c.c_char_p
_REFERENCES = c.POINTER(c.c_uint32)
_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "create": (_POINTER, (_BYTES, _SIZE, _BYTES, _BYTES)),
    "free": (None, (_POINTER,)),
    "message": (_BYTES, (_POINTER,)),
    "set_up": (c.c_int, (_POINTER, _DOUBLE, _DOUBLE)),
    "enter_initialization": (c.c_int, (_POINTER,)),
    "exit_initialization": (c.c_int, (_POINTER,)),
    "step": (c.c_int, (_POINTER, _DOUBLE, _DOUBLE)),
    "terminate": (c.c_int, (_POINTER,)),
    "get_real": (c.c_int, (_POINTER, _REFERENCES, _SIZE, c.POINTER(_DOUBLE))),
    "set_real": (c.c_int, (_POINTER, _REFERENCES, _SIZE, c.POINTER(_DOUBLE))),
    "get_integer": (c.c_int, (_POINTER, _REFERENCES, _SIZE, c.POINTER(c.c_int32))),
    "set_integer": (c.c_int, (_POINTER, _REFERENCES, _SIZE, c.POINTER(c.c_int32))),
    "save": (c.c_int, (_POINTER, c.POINTER(_POINTER))),
    "restore": (c.c_int, (_POINTER, _POINTER)),
    "free_saved": (None, (_POINTER,)),
    "serialized_size": (c.c_int, (_POINTER, _POINTER, c.POINTER(_SIZE))),
    "serialize": (c.c_int, (_POINTER, _POINTER, _BYTES, _SIZE)),
    "deserialize": (c.c_int, (_POINTER, _BYTES, _SIZE, c.POINTER(_POINTER))),
}
_TYPES: dict[str, Any] = {"real": _DOUBLE, "integer": c.c_int32}


def _function(name: str) -> Any:
    function = getattr(kernel, f"gallop_cosim_{name}")
    function.restype, function.argtypes = _SIGNATURES[name]
    return function


_FUNCTIONS = {name: _function(name) for name in _SIGNATURES}


class CosimError(ValueError):
    """A call was refused or failed; the message states the fact, then the remedy.

    The `Cosim` instance is as it was before the call.
    """


class Cosim:
    """One instance of a span in co-simulation.

    Parameters
    ----------
    resource
        Content of ``resources/model.bin``, see `gallop_fmu.fmu.model_bin`.
    guid
        GUID of the model description.

    Raises
    ------
    CosimError
        The resource is damaged or belongs to another FMU, or there is not enough memory. All
        methods raise it for calls that are refused or fail.
    """

    def __init__(self, resource: bytes, guid: str) -> None:
        message = c.create_string_buffer(MESSAGE_SIZE)
        self._handle = _FUNCTIONS["create"](resource, len(resource), guid.encode(), message)
        if not self._handle:
            raise CosimError(message.value.decode(errors="replace"))

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            _FUNCTIONS["free"](self._handle)
            self._handle = None

    def _call(self, name: str, *arguments: Any) -> None:
        if _FUNCTIONS[name](self._handle, *arguments):
            raise CosimError(_FUNCTIONS["message"](self._handle).decode(errors="replace"))

    def set_up(self, start: float, stop: float | None) -> None:
        """Set start and stop time [s]; a stop time of None is none."""
        self._call("set_up", start, math.inf if stop is None else stop)

    def enter_initialization(self) -> None:
        """Begin initialization: outputs follow inputs and parameters from now on."""
        self._call("enter_initialization")

    def exit_initialization(self) -> None:
        """End initialization: compute the initial state and fix the parameters."""
        self._call("exit_initialization")

    def step(self, time: float, size: float) -> None:
        """Advance from `time` by `size` [s]."""
        self._call("step", time, size)

    def terminate(self) -> None:
        """End the run."""
        self._call("terminate")

    def get(self, kind: str, references: Sequence[int]) -> list[Any]:
        """Return the values of variables of a kind: "real" or "integer"; others do not exist."""
        values = self._array(kind, [0] * len(references))
        self._call(f"get_{kind}", self._references(references), len(references), values)
        return list(values)

    def set(self, kind: str, references: Sequence[int], values: Sequence[Any]) -> None:
        """Set variables: all of them or, if one is refused, none."""
        array = self._array(kind, values)
        self._call(f"set_{kind}", self._references(references), len(references), array)

    @staticmethod
    def _references(references: Sequence[int]) -> Any:
        return (c.c_uint32 * len(references))(*references)

    @staticmethod
    def _array(kind: str, values: Sequence[Any]) -> Any:
        if kind not in _TYPES:
            raise CosimError(
                "this FMU has no Boolean and no String variables; use Reals and Integers"
            )
        return (_TYPES[kind] * len(values))(*values)

    def save(self) -> bytes:
        """Return all that the future depends on, as bytes; equal states give equal bytes."""
        saved, size = _POINTER(), _SIZE()
        self._call("save", c.byref(saved))
        try:
            self._call("serialized_size", saved, c.byref(size))
            room = c.create_string_buffer(size.value)
            self._call("serialize", saved, room, size)
        finally:
            _FUNCTIONS["free_saved"](saved)
        return room.raw

    def restore(self, state: bytes) -> None:
        """Return to a state that `save` gave, bit for bit."""
        saved = _POINTER()
        self._call("deserialize", state, len(state), c.byref(saved))
        try:
            self._call("restore", saved)
        finally:
            _FUNCTIONS["free_saved"](saved)
