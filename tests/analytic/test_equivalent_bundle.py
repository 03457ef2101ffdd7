"""An equivalent conductor moves as its bundle."""

import pytest

import gallop_fmu as gf
import modal
from modal.linear.equivalent_bundle import RANGE, STRINGS
from tests.support.line_references import line_scene, stored
from tests.support.line_scenes import in_plane, of_family, section

CONDUCTOR = (25000.0, [300.0], 15.97, 29e6)


def bundle(**values):
    return {"subconductors": 4, "spacing": 0.45, "spacers": 6, **values}


@pytest.mark.parametrize(("count", "spacing"), [(2, 0.4), (3, 0.4), (4, 0.45), (6, 0.4)])
def test_frequencies_are_those_of_the_bundle(count, spacing):
    """Seen: 2e-5 of translation (sub-spans), 1.1e-3 of torsion with one loop."""
    scene = section(
        *CONDUCTOR,
        elements=14,
        torsion=(159.0, 2e-4),
        bundle=bundle(subconductors=count, spacing=spacing),
    )
    found = modal.equivalent_bundle(scene)
    full, single = (modal.natural_modes(s, 9) for s in (scene, found.scene))
    assert in_plane(single)[:2] == pytest.approx(in_plane(full)[:2], rel=3e-5)
    across = of_family(full, "horizontal")[:2]
    assert of_family(single, "horizontal")[:2] == pytest.approx(across, rel=3e-5)
    symmetric = next(m for m in full if m.family == "bundle torsion" and m.loops == (1,))
    assert of_family(single, "torsional")[0] == pytest.approx(symmetric.frequency_hz, rel=2e-3)
    assert found.sag_factor > 1.5
    assert found.range == RANGE
    assert any(RANGE in note for note in found.scene.notes)


def test_strings_leave_torsion_without_the_sag():
    scene = line_scene(stored("new_bundle_section_frequencies"), elements=10)
    found = modal.equivalent_bundle(scene)
    assert found.sag_factor == 1.0
    assert STRINGS in found.range
    full, single = (modal.natural_modes(s, 10) for s in (scene, found.scene))
    assert in_plane(single)[:2] == pytest.approx(in_plane(full)[:2], rel=3e-5)


def test_static_wind_and_ice_are_those_of_the_bundle():
    """Displacement at mid-span in the mean wind; forces add up, and so do the moments."""
    scene = line_scene(stored("bundle_galloping_twin_horizontal"), elements=8)
    found = modal.equivalent_bundle(scene).scene
    moved = []
    for each in (scene, found):
        model = gf.Model(each)
        inputs = gf.Inputs.still(each, wind_speed=each.wind.mean_speed)
        u, _, _ = model.rest(0.0, inputs).motion()
        moved.append(u[[chain.middle for chain in model.map.chains]].mean(axis=0))
    assert moved[1][:3] == pytest.approx(moved[0][:3], rel=2e-3, abs=1e-6)
    grows = [modal.natural_modes(s, 2, "mean")[1].eigenvalue for s in (scene, found)]
    assert grows[1].imag == pytest.approx(grows[0].imag, rel=1e-3)
    assert grows[1].real == pytest.approx(grows[0].real, rel=0.06)  # seen: 4 %, see the range


def test_masses_of_spacers_and_yokes_remain():
    scene = section(
        *(25000.0, [300.0, 300.0], 15.97, 29e6), bundle=bundle(spacer_mass=4.0, yoke_mass=12.0)
    )
    found = modal.equivalent_bundle(scene).scene
    assert sum(device.mass for device in found.devices) == pytest.approx(48.0)
    assert found.section.suspensions[0].weight == pytest.approx(490.0 + 2.0 * 12.0 * 9.81)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (section(*CONDUCTOR), "subconductors = 1: the line has no bundle"),
        (
            section(
                *CONDUCTOR,
                bundle=bundle(),
                devices=[{"kind": "pendulum", "span": 1, "station": 0.5, "mass": 10.0, "arm": 0.3}],
            ),
            r"device 1 \(pendulum\)",
        ),
        (
            section(
                *CONDUCTOR,
                bundle=bundle(),
                loads=[{"span": 1, "position": 0.5, "force": [0, 1, 0], "subconductor": 2}],
            ),
            "load 1 is on subconductor 2 alone",
        ),
    ],
)
def test_what_has_no_equivalent_is_refused(scene, message):
    with pytest.raises(gf.SceneError, match=message):
        modal.equivalent_bundle(scene)
