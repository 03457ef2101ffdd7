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
    packed = Packed(scene)
    identification = Identification(_text(guid, 48), _text(version, 16))
    variables = [_variable_item(variable, packed) for variable in fmu_variables(scene)]
    return resource_file(
        [
            _section(b"IDEN", [identification]),
            *_scene_sections(packed),
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


SECTION_IDS = {
    "settings": b"SETT",
    "cross_section": b"SECT",
    "curve": b"CURV",
    "field": b"FIEL",
    "junction": b"JUNC",
    "chain": b"CHAI",
    "station": b"STAT",
    "device": b"DEVI",
    "load": b"LOAD",
    "law": b"LAWS",
    "number": b"NUMB",
}
"""Tables of a packed scene, and the sections that hold them."""


def _scene_sections(packed: Packed) -> list[Section]:
    """Sections of the tables of a scene that have items."""
    tables = [_section(SECTION_IDS[name], items) for name, items in packed.tables.items() if items]
    return [*tables, Section(b"NUMB", 8, np.array(packed.numbers).tobytes())]


def _variable_item(variable: Variable, packed: Packed) -> VariableItem:
    section, item, offset, factor = b"", 0, 0, 1.0
    match variable.origin:
        case Origin.PARAMETER:
            [(table, item, offset, factor)] = packed.places[variable.key]
            section = SECTION_IDS[table]
        case Origin.INPUT:
            item = INPUTS.index(variable.key)
        case Origin.MIDSPAN:
            item = NODE_INDEX[variable.key]
        case Origin.SPAN:
            item = SPAN_INDEX[variable.key]
    return VariableItem(
        name=_text(variable.name, 64),
        origin=ORIGINS[variable.origin],
        whole=variable.type == "Integer",
        section=section,
        index=item,
        field=offset,
        excluded=variable.minimum_excluded + 2 * variable.maximum_excluded,
        factor=factor,
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
