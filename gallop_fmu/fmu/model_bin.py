"""Contents of a native FMU: the kernel's own library, and ``resources/model.bin`` with the scene's numbers.

The library holds the FMI functions too, so that the FMU needs no Python on the host and its export
no compiler. ``model.bin`` is the memory of the packed scene, its pointers replaced by offsets in
the file, followed by the table of variables and the words for outcomes; the layouts are those of
``kernel/resource.h``.
"""

from __future__ import annotations

import ctypes as c
import math
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from gallop_fmu.engine.ctypes_structs import CLoad, CScene
from gallop_fmu.engine.pack import Packed
from gallop_fmu.fmu.variables import SUPPORT_INPUTS, Origin, Variable, fmu_variables
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.scene.scene import Scene

MODEL_FILE = "model.bin"
"""Its name in the FMU's resources."""

MAGIC = b"GALLOPM4"
HEADER = struct.Struct("<8sQQ48s16s6I")
VARIABLE = struct.Struct("<64siiIIddd")
OUTCOME = struct.Struct("<ii128s184s")
COVERED_FROM = struct.calcsize("<8sQQ")
"""The checksum covers what follows it."""

INPUTS = ("wind_speed", "attack_angle", *SUPPORT_INPUTS)
ORIGINS = {
    Origin.PARAMETER: 0,
    Origin.INPUT: 1,
    Origin.MIDSPAN: 2,
    Origin.SPAN: 3,
    Origin.STATUS: 4,
}


def model_bin(scene: Scene, guid: str, version: str) -> bytes:
    """Content of ``resources/model.bin``.

    Parameters
    ----------
    scene
        The scene.
    guid
        GUID of the model description, which the library compares.
    version
        Version of this package.
    """
    memory = _Memory(Packed(scene), at=HEADER.size)
    variables = [_variable(variable, memory) for variable in fmu_variables(scene)]
    outcomes = [_outcome(outcome) for outcome in Outcome]
    first_variable = memory.end
    first_outcome = first_variable + len(variables) * VARIABLE.size
    body = memory.content() + b"".join(variables) + b"".join(outcomes)
    size = HEADER.size + len(body)
    parts = (HEADER.size, first_variable, len(variables), first_outcome, len(outcomes), 0)
    named = _text(guid, 48), _text(version, 16)
    unsigned = HEADER.pack(MAGIC, size, 0, *named, *parts) + body
    return HEADER.pack(MAGIC, size, checksum(unsigned[COVERED_FROM:]), *named, *parts) + body


def checksum(content: bytes) -> int:
    """FNV-1a, 64 bit."""
    value = 1469598103934665603
    for byte in content:
        value = ((value ^ byte) * 1099511628211) & 0xFFFFFFFFFFFFFFFF
    return value


class _Memory:
    """The packed scene, its loads and its arrays, laid out one after the other from `at` on."""

    def __init__(self, packed: Packed, at: int) -> None:
        self._packed = packed
        self._blocks: list[tuple[int, bytes, int]] = []  # address here, content, offset there
        self.end = at
        self._add(c.addressof(packed.scene), bytes(packed.scene))
        self._add(c.addressof(packed.loads), bytes(packed.loads))
        for array in packed.arrays:
            self._add(array.ctypes.data, array.tobytes())

    def _add(self, address: int, content: bytes) -> None:
        if content:
            self._blocks.append((address, content, self.end))
            self.end += len(content) + -len(content) % 8

    def offset(self, address: int) -> int:
        """Offset in the file of something at an address here."""
        for start, content, there in self._blocks:
            if start <= address < start + len(content):
                return there + address - start
        raise AssertionError("an address outside the packed scene")

    def place(self, path: str) -> tuple[int, float]:
        """Offset of the value with a dotted path, and the factor it is stored with."""
        target, field, factor = self._packed.places[path]
        if isinstance(target, np.ndarray):
            return self.offset(target.ctypes.data + target.itemsize * int(field)), factor
        return self.offset(c.addressof(target) + getattr(type(target), str(field)).offset), factor

    def content(self) -> bytes:
        """All blocks, with pointers replaced by offsets."""
        parts = []
        for address, content, _ in self._blocks:
            block = bytearray(content + bytes(-len(content) % 8))
            for at in self._pointers(address):
                (pointer,) = struct.unpack_from("<Q", block, at)
                struct.pack_into("<Q", block, at, self.offset(pointer) if pointer else 0)
            parts.append(bytes(block))
        return b"".join(parts)

    def _pointers(self, address: int) -> Iterator[int]:
        if address == c.addressof(self._packed.scene):
            yield from pointer_offsets(CScene)
        elif self._packed.loads and address == c.addressof(self._packed.loads):
            for index in range(len(self._packed.loads)):
                yield from (index * c.sizeof(CLoad) + at for at in pointer_offsets(CLoad))


def pointer_offsets(kind: Any) -> Iterator[int]:
    """Offsets of all pointers in a structure or array type."""
    if issubclass(kind, c.Structure):
        for name, part, *_ in kind._fields_:
            yield from (getattr(kind, name).offset + at for at in pointer_offsets(part))
    elif issubclass(kind, c.Array):
        for index in range(kind._length_):
            yield from (index * c.sizeof(kind._type_) + at for at in pointer_offsets(kind._type_))
    elif issubclass(kind, c._Pointer):
        yield 0


def _variable(variable: Variable, memory: _Memory) -> bytes:
    place, factor = 0, 1.0
    match variable.origin:
        case Origin.PARAMETER:
            place, factor = memory.place(variable.key)
        case Origin.INPUT:
            place = INPUTS.index(variable.key)
        case Origin.MIDSPAN:
            place = NODE_INDEX[variable.key]
        case Origin.SPAN:
            place = SPAN_INDEX[variable.key]
    low = -math.inf if variable.minimum is None else float(variable.minimum)
    high = math.inf if variable.maximum is None else float(variable.maximum)
    excluded = variable.minimum_excluded + 2 * variable.maximum_excluded
    whole = variable.type == "Integer"
    return VARIABLE.pack(
        _text(variable.name, 64),
        ORIGINS[variable.origin],
        whole,
        place,
        excluded,
        factor,
        low,
        high,
    )


def _outcome(outcome: Outcome) -> bytes:
    return OUTCOME.pack(
        outcome.code, 0, _text(outcome.sentence, 128), _text(outcome.cure or "nothing", 184)
    )


def _text(text: str, room: int) -> bytes:
    content = text.encode()
    if len(content) >= room:
        raise ValueError(f"{text!r} needs {len(content)} bytes; there is room for {room - 1}")
    return content
