"""The resource file of an FMU: tables of the scene, the table of variables, texts for outcomes.

The layouts are those of ``kernel/resource_file.h`` and ``kernel/resource.h``. Both the native FMU
and the one in Python read this file.
"""

from __future__ import annotations

import ctypes as c
import math
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from gallop_fmu.engine.ctypes_structs import CProbe
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.line_map import LineMap
from gallop_fmu.engine.pack import Packed
from gallop_fmu.fmu.ports import Ports
from gallop_fmu.fmu.variable import Origin, Term, Variable
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.foundation.outcome import Outcome
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

MODEL_FILE = "model.bin"
"""Its name in the FMU's resources."""

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


class PlaceItem(c.Structure):
    """resource_also."""

    _fields_ = (
        ("variable", c.c_uint32),
        ("section", c.c_char * 4),
        ("index", c.c_uint32),
        ("field", c.c_uint32),
    )


class TargetItem(c.Structure):
    """resource_target."""

    _fields_ = (
        ("input", c.c_uint32),
        ("kind", c.c_int32),
        ("index", c.c_int32),
        ("axis", c.c_int32),
    )


class TermItem(c.Structure):
    """resource_term."""

    _fields_ = (("probe", CProbe), ("weight", c.c_double))


class LabelItem(c.Structure):
    """resource_label."""

    _fields_ = (("object", c.c_int32), ("index", c.c_int32), ("text", c.c_char * 56))


class OutcomeItem(c.Structure):
    """resource_outcome."""

    _fields_ = (
        ("code", c.c_int32),
        ("reserved", c.c_int32),
        ("sentence", c.c_char * 128),
        ("remedy", c.c_char * 184),
    )


OF_CHAIN, OF_DEVICE = 0, 1
"""Objects of a label."""


class Section(NamedTuple):
    """A table of the file."""

    id: bytes
    item_size: int
    content: bytes


def model_bin(
    scene: Scene | LineScene, guid: str, version: str, ports: Ports | None = None
) -> bytes:
    """Return the content of ``resources/model.bin``.

    Parameters
    ----------
    scene
        The scene.
    guid
        GUID of the model description, which the library compares.
    version
        Version of this package.
    ports
        What is chosen of inputs and outputs; None: the usual.
    """
    packed = Packed(scene)
    identification = Identification(_text(guid, 48), _text(version, 16))
    return resource_file(
        [
            _section(b"IDEN", [identification]),
            *_scene_sections(packed),
            *_variable_sections(fmu_variables(scene, ports, packed), packed),
            *_labels(packed.map),
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
    "shedding": b"SHED",
    "number": b"NUMB",
}
"""Tables of a packed scene, and the sections that hold them."""


def _scene_sections(packed: Packed) -> list[Section]:
    """Sections of the tables of a scene that have items."""
    tables = [_section(SECTION_IDS[name], items) for name, items in packed.tables.items() if items]
    return [*tables, Section(b"NUMB", 8, packed.numbers.tobytes())]


def _labels(parts: LineMap) -> list[Section]:
    """Places of a line in words, for messages; none for a single span."""
    if len(parts.chains) == 1:
        return []
    labels = [
        LabelItem(OF_CHAIN, index, _text(parts.words_of_chain(chain), 56))
        for index, chain in enumerate(parts.chains)
    ]
    labels += [
        LabelItem(OF_DEVICE, device, _text(parts.words_of_tower(tower), 56))
        for tower in parts.towers
        for device in tower.devices
    ]
    return [_section(b"NAME", labels)]


def _variable_sections(variables: Sequence[Variable], packed: Packed) -> list[Section]:
    """The table of variables, and the tables that it refers to."""
    items: list[VariableItem] = []
    targets: list[TargetItem] = []
    terms: list[TermItem] = []
    also: list[PlaceItem] = []
    inputs = 0
    for variable in variables:
        item = VariableItem(
            name=_text(variable.name, 64),
            origin=variable.origin,
            whole=variable.type != "Real",
            excluded=variable.minimum_excluded + 2 * variable.maximum_excluded,
            factor=1.0,
            minimum=-math.inf if variable.minimum is None else variable.minimum,
            maximum=math.inf if variable.maximum is None else variable.maximum,
        )
        match variable.origin:
            case Origin.PARAMETER:
                place, *further = packed.places[variable.key]
                table, item.index, item.field, item.factor = place
                item.section = SECTION_IDS[table]
                also += [PlaceItem(len(items), SECTION_IDS[at[0]], *at[1:3]) for at in further]
            case Origin.INPUT:
                item.index = inputs
                targets += [TargetItem(inputs, *target) for target in variable.targets]
                inputs += 1
            case Origin.SUM | Origin.TURN | Origin.STATIC:
                item.index, item.field = len(terms), len(variable.terms)
                terms += [_term_item(term) for term in variable.terms]
        items.append(item)
    tables: dict[bytes, list[Any]] = {
        b"VARS": items,
        b"PLCS": also,
        b"INPT": targets,
        b"TERM": terms,
    }
    return [_section(id_, table) for id_, table in tables.items() if table]


def _term_item(term: Term) -> TermItem:
    probe = CProbe(term.object, term.item, term.channel, 0, term.station)
    return TermItem(probe, term.weight)


def _outcome_item(outcome: Outcome) -> OutcomeItem:
    return OutcomeItem(
        outcome.code, 0, _text(outcome.sentence, 128), _text(outcome.cure or "nothing", 184)
    )


def _text(text: str, room: int) -> bytes:
    content = text.encode()
    if len(content) >= room:
        raise ValueError(f"{text!r} needs {len(content)} bytes; there is room for {room - 1}")
    return content
