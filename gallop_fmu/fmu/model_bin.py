"""The resource file of an FMU: tables of the scene, the table of variables, texts for outcomes.

The layouts are those of ``kernel/resource_file.h`` and ``kernel/resource.h``. Both the native FMU
and the one in Python read this file.
"""

from __future__ import annotations

import ctypes as c
import math
import struct
from typing import Any, NamedTuple

import numpy as np

from gallop_fmu.engine.ctypes_structs import CLoad, CScene
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.pack import Packed
from gallop_fmu.fmu.variables import SUPPORT_INPUTS, Origin, Variable, fmu_variables
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.scene.scene import Scene

MODEL_FILE = "model.bin"
"""Its name in the FMU's resources."""

INPUTS = ("wind_speed", "attack_angle", *SUPPORT_INPUTS)
ORIGINS = {
    Origin.PARAMETER: 0,
    Origin.INPUT: 1,
    Origin.MIDSPAN: 2,
    Origin.SPAN: 3,
    Origin.STATUS: 4,
}

HEADER = struct.Struct("<24sII")
"""What `gallop_cosim_seal` fills in, format, number of sections."""

ENTRY = struct.Struct("<4sIQQ")
"""Id, size of an item, offset, number of items."""


class Identification(c.Structure):
    """resource_identification."""

    _fields_ = (("guid", c.c_char * 48), ("version", c.c_char * 16))


class VariableItem(c.Structure):
    """resource_variable."""

    _fields_ = (
        ("name", c.c_char * 64),
        ("origin", c.c_int32),
        ("whole", c.c_int32),
        ("section", c.c_char * 4),
        ("index", c.c_uint32),
        ("field", c.c_uint32),
        ("excluded", c.c_uint32),
        ("factor", c.c_double),
        ("minimum", c.c_double),
        ("maximum", c.c_double),
    )


class OutcomeItem(c.Structure):
    """resource_outcome."""

    _fields_ = (
        ("code", c.c_int32),
        ("reserved", c.c_int32),
        ("sentence", c.c_char * 128),
        ("remedy", c.c_char * 184),
    )


class Section(NamedTuple):
    """A table of the file."""

    id: bytes
    item_size: int
    content: bytes


class Place(NamedTuple):
    """Where a value of the scene is stored: section, item, byte in the item; and its factor."""

    section: bytes
    item: int
    field: int
    factor: float


def model_bin(scene: Scene, guid: str, version: str) -> bytes:
    """Return the content of ``resources/model.bin``.

    Parameters
    ----------
    scene
        The scene.
    guid
        GUID of the model description, which the library compares.
    version
        Version of this package.
    """
    tables = _SceneTables(Packed(scene))
    identification = Identification(_text(guid, 48), _text(version, 16))
    variables = [_variable_item(variable, tables) for variable in fmu_variables(scene)]
    return resource_file(
        [
            _section(b"IDEN", [identification]),
            *tables.sections(),
            _section(b"VARS", variables),
            _section(b"OUTC", [_outcome_item(outcome) for outcome in Outcome]),
        ]
    )


def resource_file(sections: list[Section]) -> bytes:
    """Join header, directory and sections, and seal them with the checksum."""
    offset = HEADER.size + len(sections) * ENTRY.size
    directory, body = b"", b""
    for id_, item_size, content in sections:
        directory += ENTRY.pack(id_, item_size, offset + len(body), len(content) // item_size)
        body += content + bytes(-len(content) % 8)
    file = HEADER.pack(b"", 0, len(sections)) + directory + body
    room = c.create_string_buffer(file, len(file))
    seal = kernel.gallop_cosim_seal
    seal.argtypes = (c.c_char_p, c.c_size_t)
    assert seal(room, len(file)) == 0
    return room.raw


def _section(id_: bytes, items: list[Any]) -> Section:
    """Section of structures of one type."""
    return Section(id_, c.sizeof(type(items[0])), b"".join(map(bytes, items)))


class _SceneTables:
    """The packed scene as sections SCEN, LOAD and NUMB; pointers are 1 + an index in NUMB."""

    def __init__(self, packed: Packed) -> None:
        self._packed = packed
        self._numbers = [(array.ctypes.data, len(array.ravel())) for array in packed.arrays]

    def sections(self) -> list[Section]:
        loads = self._packed.loads
        return [
            Section(b"SCEN", c.sizeof(CScene), self._with_indices(self._packed.scene)),
            Section(b"LOAD", c.sizeof(CLoad), b"".join(map(self._with_indices, loads))),
            Section(b"NUMB", 8, b"".join(array.tobytes() for array in self._packed.arrays)),
        ]

    def place(self, path: str) -> Place:
        """Place of the value with a dotted path."""
        target, field, factor = self._packed.places[path]
        if isinstance(target, np.ndarray):
            return Place(b"NUMB", self._number(target.ctypes.data + 8 * int(field)), 0, factor)
        at = c.addressof(target) + getattr(type(target), str(field)).offset
        for id_, table in ((b"SCEN", [self._packed.scene]), (b"LOAD", self._packed.loads)):
            for index, item in enumerate(table):
                if 0 <= at - c.addressof(item) < c.sizeof(item):
                    return Place(id_, index, at - c.addressof(item), factor)
        raise AssertionError("a value outside the packed scene")

    def _number(self, address: int) -> int:
        """Index in NUMB of the number at an address here."""
        before = 0
        for start, count in self._numbers:
            if start <= address < start + 8 * count:
                return before + (address - start) // 8
            before += count
        raise AssertionError("a number outside the packed scene")

    def _with_indices(self, item: c.Structure) -> bytes:
        """Content of a structure, with its pointers to numbers replaced by 1 + their indices."""
        block = bytearray(item)
        for at in _pointers(type(item)):
            (address,) = struct.unpack_from("<Q", block, at)
            known = address and any(s <= address < s + 8 * n for s, n in self._numbers)
            struct.pack_into("<Q", block, at, 1 + self._number(address) if known else 0)
        return bytes(block)


def _pointers(kind: Any) -> list[int]:
    """Offsets of all pointers in a structure or array type."""
    if issubclass(kind, c.Structure):
        fields = [(getattr(kind, name).offset, part) for name, part, *_ in kind._fields_]
    elif issubclass(kind, c.Array):
        fields = [(index * c.sizeof(kind._type_), kind._type_) for index in range(kind._length_)]
    else:
        return [0] if issubclass(kind, c._Pointer) else []
    return [offset + at for offset, part in fields for at in _pointers(part)]


def _variable_item(variable: Variable, tables: _SceneTables) -> VariableItem:
    place = Place(b"", 0, 0, 1.0)
    match variable.origin:
        case Origin.PARAMETER:
            place = tables.place(variable.key)
        case Origin.INPUT:
            place = place._replace(item=INPUTS.index(variable.key))
        case Origin.MIDSPAN:
            place = place._replace(item=NODE_INDEX[variable.key])
        case Origin.SPAN:
            place = place._replace(item=SPAN_INDEX[variable.key])
    return VariableItem(
        name=_text(variable.name, 64),
        origin=ORIGINS[variable.origin],
        whole=variable.type == "Integer",
        section=place.section,
        index=place.item,
        field=place.field,
        excluded=variable.minimum_excluded + 2 * variable.maximum_excluded,
        factor=place.factor,
        minimum=-math.inf if variable.minimum is None else variable.minimum,
        maximum=math.inf if variable.maximum is None else variable.maximum,
    )


def _outcome_item(outcome: Outcome) -> OutcomeItem:
    return OutcomeItem(
        outcome.code, 0, _text(outcome.sentence, 128), _text(outcome.cure or "nothing", 184)
    )


def _text(text: str, room: int) -> bytes:
    content = text.encode()
    if len(content) >= room:
        raise ValueError(f"{text!r} needs {len(content)} bytes; there is room for {room - 1}")
    return content
