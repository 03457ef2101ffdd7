"""The container of an FMU's tables: sections by name, unknown ones skipped, fields validated."""

import ctypes as c
import struct
import subprocess

import pytest

from gallop_fmu.fmu.cosim import MESSAGE_SIZE
from gallop_fmu.fmu.model_bin import (
    ENTRY,
    HEADER,
    OF_CHAIN,
    OF_DEVICE,
    Identification,
    LabelItem,
    OutcomeItem,
    PlaceItem,
    Section,
    TargetItem,
    TermItem,
    VariableItem,
    resource_file,
)
from gallop_fmu.fmu.variable import CONSTANT, POINT, Origin, TargetKind
from support.checksum import fnv1a

OFFSETS = {"size": 16, "format": 24, "sections": 28}
"""Of fields of the header."""


def sections_of(content):
    """The sections of a file."""
    (count,) = struct.unpack_from("<I", content, OFFSETS["sections"])
    sections = []
    for i in range(count):
        id_, item_size, offset, items = ENTRY.unpack_from(content, HEADER.size + i * ENTRY.size)
        sections.append(Section(id_, item_size, content[offset : offset + items * item_size]))
    return sections


@pytest.fixture
def good(small):
    return (small.resources / "model.bin").read_bytes()


@pytest.fixture
def open_with(small, instance, tmp_path):
    """Instantiate with other bytes in model.bin."""

    def make(content):
        (tmp_path / "model.bin").write_bytes(content)
        return instance(small, resources=tmp_path.as_uri())

    return make


def refused(one, match):
    assert not one.component.value
    assert match in one.log[-1]


def changed(content, at, layout, value, seal):
    """A copy with one field changed, and its checksum right again."""
    room = c.create_string_buffer(content, len(content))
    struct.pack_into(layout, room, at, value)
    assert seal(room, len(content)) == 0
    return room.raw


@pytest.fixture
def seal(small):
    function = c.CDLL(str(small.library)).gallop_cosim_seal
    function.argtypes = (c.c_char_p, c.c_size_t)
    return function


MIRRORS = {
    "resource_identification": Identification,
    "resource_variable": VariableItem,
    "resource_also": PlaceItem,
    "resource_target": TargetItem,
    "resource_term": TermItem,
    "resource_label": LabelItem,
    "resource_outcome": OutcomeItem,
}
CONSTANTS = {
    "sizeof(resource_header)": HEADER.size,
    "sizeof(resource_entry)": ENTRY.size,
    **{f"RESOURCE_{origin.name}": origin.value for origin in Origin},
    **{f"RESOURCE_{kind.name}": kind.value for kind in TargetKind},
    "RESOURCE_OF_CHAIN": OF_CHAIN,
    "RESOURCE_OF_DEVICE": OF_DEVICE,
    "RESOURCE_POINT": POINT,
    "RESOURCE_CONSTANT": CONSTANT,
    "GALLOP_COSIM_MESSAGE_SIZE": MESSAGE_SIZE,
}


def test_python_has_the_layouts_and_constants_of_the_headers(compiled, kernel_sources, tmp_path):
    """Size of each structure, and offset and size of each field."""
    wanted = dict(CONSTANTS)
    for name, mirror in MIRRORS.items():
        wanted[f"sizeof({name})"] = c.sizeof(mirror)
        for field, _ in mirror._fields_:
            place = getattr(mirror, field)
            wanted[f"offsetof({name}, {field})"] = place.offset
            wanted[f"sizeof((({name} *)0)->{field})"] = place.size
    lines = [f'printf("%ld\\n", (long)({expression}));' for expression in wanted]
    source = tmp_path / "layout.c"
    headers = '#include "gallop_cosim.h"\n#include "resource.h"\n#include <stdio.h>\n'
    source.write_text(f"{headers}int main(void) {{ {' '.join(lines)} }}\n")
    program = compiled(tmp_path / "layout", source, flags=[f"-I{kernel_sources}"])
    found = subprocess.run([program], capture_output=True, check=True, text=True).stdout
    assert dict(zip(wanted, map(int, found.split()), strict=True)) == wanted


def test_the_writer_reproduces_the_bytes_that_were_read(good):
    assert resource_file(sections_of(good)) == good


def test_unknown_sections_are_skipped(good, small, instance, open_with):
    """A later version may add tables that this one does not read."""
    known = sections_of(good)
    later = [Section(b"WIND", 24, bytes(range(48))), *known, Section(b"LATR", 1, b"x" * 9)]
    fmu = open_with(resource_file(later))
    assert fmu.start().step(0.02, 5).outputs() == instance(small).start().step(0.02, 5).outputs()


def test_the_order_of_sections_does_not_matter(good, open_with):
    open_with(resource_file(sections_of(good)[::-1])).start().step(0.02)


@pytest.mark.parametrize("id_", [b"IDEN", b"SETT", b"VARS", b"INPT"])
def test_a_required_section_that_is_missing_is_named(good, open_with, id_):
    left = [section for section in sections_of(good) if section.id != id_]
    one = open_with(resource_file(left))
    refused(one, f"has no section {id_.decode()}; export the scene again")


def test_a_section_must_be_there_once_and_with_known_items(good, open_with):
    sections = sections_of(good)
    refused(open_with(resource_file([*sections, sections[0]])), "it has a section twice")
    first = sections[0]
    longer = first._replace(item_size=first.item_size + 8, content=first.content + bytes(8))
    refused(open_with(resource_file([longer, *sections[1:]])), "items of another size")
    twice = first._replace(content=2 * first.content)
    refused(open_with(resource_file([twice, *sections[1:]])), "impossible number of items")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *(("item_size", value) for value in (0, 1, 2**31, 2**32 - 1)),
        *(("offset", value) for value in (0, 1, 2**31, 2**64 - 8)),
        *(("count", value) for value in (2**31, 2**60, 2**64 - 1)),
    ],
)
def test_a_forged_directory_is_refused(good, open_with, seal, field, value):
    """Sections that overlap, leave the file, or are misaligned, with a right checksum."""
    layout, at = {"item_size": ("<I", 4), "offset": ("<Q", 8), "count": ("<Q", 16)}[field]
    for entry in range(len(sections_of(good))):
        forged = changed(good, HEADER.size + entry * ENTRY.size + at, layout, value, seal)
        if forged != good:
            refused(open_with(forged), "resources/model.bin")


def test_a_forged_number_of_sections_is_refused(good, open_with, seal):
    for value in (0, 1, 2**16, 2**32 - 1):
        forged = changed(good, OFFSETS["sections"], "<I", value, seal)
        refused(open_with(forged), "resources/model.bin")


def test_another_format_is_refused(good, open_with):
    """With the right checksum, as a later version would write it."""
    content = bytearray(good)
    content[OFFSETS["format"]] += 1
    struct.pack_into("<Q", content, 8, fnv1a(content[OFFSETS["size"] :]))
    refused(open_with(bytes(content)), "has the format of another version; export the scene again")


FORGED = {
    "factor of a whole number": ({"factor": 1e300}, "a variable is unknown"),
    "section": ({"section": b"VARS"}, "a parameter has no place"),
    "unknown section": ({"section": b"NONE"}, "a parameter has no place"),
    "index": ({"index": 2**32 - 1}, "a parameter has no place"),
    "field": ({"field": 2**32 - 4}, "a parameter has no place"),
    "field between two": ({"field": 2}, "a parameter has no place"),
    "excluded": ({"excluded": 4}, "a variable is unknown"),
    "minimum": ({"minimum": float("nan")}, "a variable is unknown"),
    "name": ({"name": b"x" * 64}, "a variable is unknown"),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_variable_is_refused(good, open_with, name):
    values, message = FORGED[name]
    sections = sections_of(good)
    at = next(i for i, section in enumerate(sections) if section.id == b"VARS")
    table = (VariableItem * (len(sections[at].content) // c.sizeof(VariableItem))).from_buffer_copy(
        sections[at].content
    )
    whole = next(variable for variable in table if variable.origin == 0 and variable.whole)
    for field, value in values.items():
        setattr(whole, field, value)
    sections[at] = sections[at]._replace(content=bytes(table))
    refused(open_with(resource_file(sections)), message)


def with_items(sections, id_, kind, change):
    """The file with changed items of one section."""
    at = next(i for i, section in enumerate(sections) if section.id == id_)
    content = sections[at].content
    items = (kind * (len(content) // c.sizeof(kind))).from_buffer_copy(content)
    change(items)
    return resource_file(
        [*sections[:at], sections[at]._replace(content=bytes(items)), *sections[at + 1 :]]
    )


def set_item(item, **values):
    """A change of one item."""

    def change(items):
        for field, value in values.items():
            owner = items[item]
            *parents, name = field.split("__")
            for parent in parents:
                owner = getattr(owner, parent)
            setattr(owner, name, value)

    return change


NOTHING_SET = "an input sets nothing"
UNKNOWN_OUTPUT = "an output is unknown"
FORGED_TABLES = {
    "field": (b"INPT", TargetItem, set_item(0, index=1), NOTHING_SET),
    "kind": (b"INPT", TargetItem, set_item(0, kind=5), NOTHING_SET),
    "junction": (b"INPT", TargetItem, set_item(7, index=2), NOTHING_SET),
    "negative junction": (b"INPT", TargetItem, set_item(7, index=-1), NOTHING_SET),
    "axis": (b"INPT", TargetItem, set_item(7, axis=3), NOTHING_SET),
    "axis of the wind": (b"INPT", TargetItem, set_item(0, axis=1), NOTHING_SET),
    "number that is left out": (b"INPT", TargetItem, set_item(3, input=4), NOTHING_SET),
    "two kinds": (b"INPT", TargetItem, set_item(1, input=0), NOTHING_SET),
    "weight": (b"TERM", TermItem, set_item(0, weight=float("nan")), UNKNOWN_OUTPUT),
    "object": (b"TERM", TermItem, set_item(0, probe__object=-3), UNKNOWN_OUTPUT),
    "index": (b"TERM", TermItem, set_item(-1, probe__index=-1), UNKNOWN_OUTPUT),
    "chain": (b"TERM", TermItem, set_item(0, probe__index=1), UNKNOWN_OUTPUT),
    "station": (b"TERM", TermItem, set_item(0, probe__station=1.5), UNKNOWN_OUTPUT),
    "channel": (b"TERM", TermItem, set_item(0, probe__channel=14), UNKNOWN_OUTPUT),
    "terms": (b"VARS", VariableItem, set_item(8, field=2**32 - 1), "a variable is unknown"),
    "no terms": (b"VARS", VariableItem, set_item(8, field=0), "a variable is unknown"),
    "first term": (b"VARS", VariableItem, set_item(8, index=2**32 - 1), "a variable is unknown"),
    "odd terms": (b"VARS", VariableItem, set_item(8, origin=3), "a variable is unknown"),
    "input": (b"VARS", VariableItem, set_item(0, index=14), "a variable is unknown"),
}


@pytest.mark.parametrize("name", FORGED_TABLES)
def test_forged_inputs_and_outputs_are_refused(good, open_with, name):
    id_, kind, change, message = FORGED_TABLES[name]
    refused(open_with(with_items(sections_of(good), id_, kind, change)), message)


def test_an_output_of_a_node_that_the_span_does_not_have_fails(good, open_with):
    """Numbers of nodes follow from parameters, so that only an observation finds it."""
    change = set_item(0, probe__object=0, probe__index=9, probe__station=0.0)
    one = open_with(with_items(sections_of(good), b"TERM", TermItem, change)).start()
    with pytest.raises(AssertionError):
        one["midspan.x1"]
    assert "midspan.x1 cannot be computed" in one.log[-1]


def test_further_places_must_be_those_of_parameters(good, open_with):
    variables = [i for i, s in enumerate(sections_of(good)) if s.id == b"VARS"]
    assert len(variables) == 1
    for place, message in (
        (PlaceItem(0, b"SECT", 0, 0), "a parameter has no place"),  # an input
        (PlaceItem(10**6, b"SECT", 0, 0), "a parameter has no place"),
        (PlaceItem(30, b"SECT", 1, 0), "a parameter has no place"),
    ):
        section = Section(b"PLCS", c.sizeof(PlaceItem), bytes(place))
        refused(open_with(resource_file([*sections_of(good), section])), message)


def test_texts_must_end(good, open_with):
    for id_, kind, field in (
        (b"IDEN", Identification, "version"),
        (b"OUTC", OutcomeItem, "remedy"),
    ):
        sections = sections_of(good)
        at = next(i for i, section in enumerate(sections) if section.id == id_)
        content = bytearray(sections[at].content)
        place = getattr(kind, field)
        content[place.offset : place.offset + place.size] = b"x" * place.size
        sections[at] = sections[at]._replace(content=bytes(content))
        refused(open_with(resource_file(sections)), "is not text")
