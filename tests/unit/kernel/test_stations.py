"""Stations within a conductor: points at which junctions lie or the cross-section changes."""

import numpy as np
import pytest

from gallop_fmu.engine.ctypes_structs import CCrossSection, CJunction, CStation
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.pack import Packed
from tests.unit.kernel.test_coupled_chains import (
    BOUNDS,
    CHANNELS,
    ELEMENTS,
    INTEGRATORS,
    LineModel,
    level_span,
    records,
)

PLACES = {"two": [4, 8], "uneven": [1, 2, 7], "at every corner": list(range(1, ELEMENTS))}


def with_stations(scene, corners, *, junctions=True, cross_sections=False):
    """The same span with stations at some corners that change nothing."""
    packed = Packed(scene)
    left, right = packed.tables["junction"]
    between = []
    for corner in corners:
        junction = CJunction()
        junction.motion[:] = (-1, -1, -1)
        station = CStation(0, corner, -1, -1, corner / ELEMENTS)
        if junctions:
            between.append(junction)
            station.junction = len(between)
        if cross_sections:
            same = CCrossSection.from_buffer_copy(packed.tables["cross_section"][0])
            packed.tables["cross_section"].append(same)
            station.cross_section = len(packed.tables["cross_section"]) - 1
        packed.tables["station"].append(station)
    packed.tables["junction"] = [left, *between, right]
    packed.tables["chain"][0].junction[1] = len(between) + 1
    for device in packed.tables["device"]:
        device.junction[0] = len(between) + 1 if device.junction[0] == 1 else 0
    packed.scene = packed.c_scene()
    return LineModel(scene, packed)


@pytest.mark.parametrize("corners", PLACES.values(), ids=PLACES)
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_junctions_on_a_conductor_change_nothing(integrator, corners):
    """The banded solver of the kept corners solves the same equations."""
    scene = level_span(**INTEGRATORS[integrator])
    nodes = np.arange(2 * ELEMENTS + 1)
    wanted = records(Model(scene), nodes)
    found = records(with_stations(scene, corners), nodes)
    for k in range(len(CHANNELS)):
        scale = np.abs(wanted[:, k]).max()
        assert np.abs(found[:, k] - wanted[:, k]).max() < BOUNDS[integrator] * scale


@pytest.mark.parametrize("corners", PLACES.values(), ids=PLACES)
def test_equal_cross_sections_side_by_side_change_nothing(corners):
    """Intervals fill strips of their own; forces are added in another order."""
    scene = level_span()
    nodes = np.arange(2 * ELEMENTS + 1)
    wanted = records(Model(scene), nodes)
    model = with_stations(scene, corners, junctions=False, cross_sections=True)
    assert np.abs(records(model, nodes) - wanted).max() < 1e-8 * np.abs(wanted).max()


def test_both_at_once_change_nothing():
    scene = level_span()
    nodes = np.arange(2 * ELEMENTS + 1)
    wanted = records(Model(scene), nodes)
    model = with_stations(scene, [1, 2, 7], cross_sections=True)
    assert np.abs(records(model, nodes) - wanted).max() < 1e-8 * np.abs(wanted).max()
