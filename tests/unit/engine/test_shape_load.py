"""The load of ice and wind that the kernel collects by shapes, against its formula."""

import copy
import ctypes as c

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.shape_load import ATTACK, GRAVITY, MOMENTS, WIND, ShapeLoad
from gallop_fmu.foundation.outcome import Outcome

MODES, INSTANTS = 3, 70
"""More instants than the kernel computes at once."""

BAD_CALL = Outcome.BAD_CALL.code


@pytest.fixture(scope="module", params=["fused", "portable"])
def mesh(request):
    values = {"numerics.elements": 3, "numerics.portable": request.param == "portable"}
    return Mesh(Model(gf.load_scene("example3").with_values(values)))


@pytest.fixture
def drawn(mesh):
    """Shapes, weights, numbers of the sections, and a motion."""
    draw = np.random.default_rng(18)
    sections = 3 * mesh.model.elements
    shape, weight = draw.normal(size=(3, MODES, sections)), draw.normal(size=(3, sections, MODES))
    table = draw.uniform(0.1, 1.0, size=(6, sections))
    table[ATTACK] += 3.0
    q, v, a = draw.normal(size=(3, INSTANTS, MODES)) * np.array([0.1, 0.5, 2.0])[:, None, None]
    wind = draw.uniform(3.0, 8.0, size=(INSTANTS, 1))
    return shape, weight, table, (q, v, a, wind)


def by_formula(mesh, shape, weight, table, motion):
    """Liu et al. 2009, eq. 8 and 17, less what is linear about rest, and the load of sections."""
    *moves, wind = motion
    (_, _, theta), (v2, v3, omega), (a2, a3, rate) = (
        np.einsum("fms,im->fis", shape, one) for one in moves
    )
    m2, m3 = table[MOMENTS]
    c2 = m2 * np.cos(theta) - m3 * np.sin(theta)
    c3 = m2 * np.sin(theta) + m3 * np.cos(theta)
    f2 = -(c3 - m3) * rate - c2 * omega**2
    f3 = (c2 - m2) * rate - c3 * omega**2
    twist = (c2 - m2) * a3 - (c3 - m3) * a2 - table[GRAVITY] * (c3 - m3 - m2 * theta)
    load = np.stack([f2, f3, twist])
    for section, (attack, of_wind) in enumerate(zip(table[ATTACK], table[WIND].T, strict=True)):
        along, across = (wind * of_wind).T
        moved = (theta, v2 - along[:, None], v3 - across[:, None], omega)
        air = mesh.aero_load(*(one[:, section] for one in moved), 1e-9, attack_angle=attack)
        load[:, :, section] -= np.where(wind[:, 0] == 0.0, 0.0, air.force)
    return np.einsum("fsm,fis->im", weight, load)


def collected(mesh, shape, weight, table, motion):
    element = np.zeros(shape.shape[2], dtype=np.intp)
    return ShapeLoad(mesh.model, shape, weight, table, element)(*motion)


def test_the_load_is_that_of_the_formula(mesh, drawn):
    """Observed: 5e-11 of the largest, as the reference has 1e-9 m/s more wind."""
    shape, weight, table, motion = drawn
    table[WIND] = np.array([[0.2], [1.0]])
    found, expected = (of(mesh, shape, weight, table, motion) for of in (collected, by_formula))
    assert found == pytest.approx(expected, abs=1e-9 * np.max(np.abs(expected)))


def test_without_wind_only_the_ice_has_a_load(mesh, drawn):
    shape, weight, table, (q, v, a, wind) = drawn
    wind[:35] = 0.0
    motion = q, v, a, wind
    found, expected = (of(mesh, shape, weight, table, motion) for of in (collected, by_formula))
    assert found == pytest.approx(expected, abs=1e-9 * np.max(np.abs(expected)))


def test_a_copy_has_its_own_arrays(mesh, drawn):
    shape, weight, table, motion = drawn
    load = ShapeLoad(mesh.model, shape, weight, table, np.zeros(shape.shape[2], dtype=np.intp))
    expected, other = load(*motion), copy.deepcopy(load)
    load._table[:] = 0.0
    assert np.array_equal(other(*motion), expected)


def test_numbers_that_are_not_finite_are_refused(mesh, drawn):
    shape, weight, table, (q, v, a, wind) = drawn
    v[3, 1] = np.nan
    with pytest.raises(ValueError, match=r"motion must be finite; motion\[4, 3\] is nan"):
        collected(mesh, shape, weight, table, (q, v, a, wind))
    v[3, 1], table[2, 0] = 0.0, np.inf
    with pytest.raises(RuntimeError, match="refused"):
        collected(mesh, shape, weight, table, (q, v, a, wind))


def test_arrays_of_other_sizes_are_refused(mesh, drawn):
    shape, weight, table, _ = drawn
    element = np.zeros(9, dtype=np.intp)
    for given in (
        (shape, weight, table[:5], element),
        (shape, weight[:, 1:], table, element),
        (shape, weight, table, element[1:]),
    ):
        with pytest.raises(ValueError, match="shape"):
            ShapeLoad(mesh.model, *given)


@pytest.mark.parametrize(
    "change",
    [{0: None}, *({k: None} for k in (2, 3, 5, 6, 8, 9)), {1: -1}, {4: -1}, {7: -1}, {2: 4}],
    ids=lambda change: str(change),
)
def test_arguments_that_cannot_be_used_are_refused(mesh, drawn, change):
    shape, weight, table, _ = drawn
    motion, force = np.zeros((3 * MODES + 1, 2)), np.full((MODES, 2), 7.0)
    element = np.zeros(9, dtype=np.int32)
    arrays = {3: table, 5: shape, 6: weight, 8: motion, 9: force}
    given = [mesh.model.handle, 9, element, None, MODES, None, None, 2, None, None]
    for place, array in arrays.items():
        given[place] = array.ctypes.data
    if change == {2: 4}:
        element[5] = mesh.model.elements
        change = {}
    given[2] = element.ctypes.data_as(c.POINTER(c.c_int32))
    for place, value in change.items():
        given[place] = value
    assert kernel.gallop_shape_load(*given) == BAD_CALL
    assert np.all(force == 7.0)
