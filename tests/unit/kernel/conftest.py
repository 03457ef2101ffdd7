"""A span that C calls, with all its arguments."""

import pytest

import gallop_fmu as gf
from support.c_span import Span


@pytest.fixture(scope="module")
def scene():
    springs = {"kind": "springs", "stiffness_x1": 1e5, "stiffness_x3": 1e4}
    supports = {"supports.left": springs, "supports.right": springs}
    return gf.load_scene("example3").with_values({"numerics.elements": 4} | supports)


@pytest.fixture
def span(scene):
    return Span(scene).started()
