"""The library matches the Python mirrors of its structures, field by field, and its API version."""

import ctypes as c

import pytest

from gallop_fmu.engine import library
from gallop_fmu.engine.ctypes_structs import (
    MIRRORS,
    mirrored_layout,
)
from gallop_fmu.foundation.outcome import Outcome

BAD_CALL = Outcome.BAD_CALL.code
kernel = c.CDLL(str(library.library_path()))  # without the types of engine.library


def test_every_field_of_the_mirrors_is_compared(monkeypatch):
    """Fields of a structure leave no gap, so that none is missing in the table of the library."""
    compiled = library.compiled_layout(kernel)
    assert compiled == mirrored_layout()
    for name in MIRRORS:
        size = compiled[name, None][1]
        fields = [place for (of, field), place in compiled.items() if of == name and field]
        covered = sum(bytes_ for _, bytes_ in fields)
        assert size - covered in (0, 4), name  # 4: after an odd number of integers
    wrong = {**mirrored_layout(), ("gallop_chain", "sag"): (0, 8)}
    monkeypatch.setattr(library, "mirrored_layout", lambda: wrong)
    with pytest.raises(ImportError, match=r"gallop_chain\.sag is at .* install the package again"):
        library._compare(kernel)


def test_a_field_beyond_the_last_is_refused():
    text, size = c.c_char_p(), c.c_size_t()
    places = [c.byref(text), c.byref(text), c.byref(size), c.byref(size)]
    count = len(mirrored_layout())
    assert kernel.gallop_structure_field(count - 1, text, text, size, size) == 0
    for index in (-1, count):
        assert kernel.gallop_structure_field(index, text, text, size, size) == BAD_CALL
    for k in range(4):
        given = [None if i == k else place for i, place in enumerate(places)]
        assert kernel.gallop_structure_field(0, *given) == BAD_CALL


def test_a_library_of_another_api_version_is_refused(monkeypatch):
    monkeypatch.setattr(library, "API_VERSION", library.API_VERSION + 1)
    with pytest.raises(ImportError, match="API version 6; these modules need 7; install"):
        library._compare(kernel)
