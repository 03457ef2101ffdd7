"""Natural frequencies about the static equilibrium against OpenSees.

OpenSeesPy 3.7.1.2, 160 two-node corotational truss elements, consistent mass; ends fixed, or free
along x1 against one or two prestressed springs of 75.97 kN/m. Printed to four decimals; its mesh
error in the third mode is 1.6e-4.
"""

import math

import pytest

import gallop_fmu as gf
import modal

# scene, what the initial state follows from, springs: first three in-plane frequencies [Hz]
VERTICAL = {
    ("example1", "sag", 0): (0.5463, 0.7822, 1.0979),
    ("example1", "sag", 1): (0.5462, 0.7467, 1.0671),
    ("example1", "sag", 2): (0.5462, 0.6800, 0.9122),
    ("example3", "sag", 0): (0.6976, 0.7596, 1.1648),
    ("example3", "sag", 1): (0.4916, 0.7596, 1.1459),
    ("example3", "sag", 2): (0.4489, 0.7596, 1.1438),
    ("example3", "horizontal_tension", 0): (0.7023, 0.7543, 1.1581),
    ("example3", "horizontal_tension", 1): (0.4923, 0.7543, 1.1381),
    ("example3", "horizontal_tension", 2): (0.4484, 0.7542, 1.1359),
    ("example2", "sag", 0): (0.5553, 0.9422, 1.4175),
    ("example2", "sag", 1): (0.5083, 0.9422, 1.4155),
    ("example2", "sag", 2): (0.4952, 0.9422, 1.4150),
    ("example2", "horizontal_tension", 0): (0.5558, 0.9470, 1.4245),
    ("example2", "horizontal_tension", 1): (0.5098, 0.9470, 1.4226),
    ("example2", "horizontal_tension", 2): (0.4970, 0.9470, 1.4221),
}
HORIZONTAL = {  # first three out-of-plane frequencies [Hz], the same with and without springs
    ("example1", "sag"): (0.2752, 0.5499, 0.8247),
    ("example3", "sag"): (0.3803, 0.7605, 1.1408),
    ("example3", "horizontal_tension"): (0.3776, 0.7552, 1.1328),
    ("example2", "sag"): (0.4713, 0.9427, 1.4141),
    ("example2", "horizontal_tension"): (0.4737, 0.9474, 1.4213),
}
TENSION = {
    ("example1", "sag"): 4582.5,
    ("example3", "sag"): 15211.0,
    ("example2", "sag"): 21512.0,
}  # [N]

# OpenSees' ends are fixed along x3; here a spring end needs a stiffness, so one that lets nothing
# through: 1e9 N/m against 2 H / L of some 200 N/m.
SPRINGS = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": 1e9}
RIGID = {"kind": "rigid"}


def as_in_opensees(name, given, springs):
    """Without eccentric ice, with the mass per unstretched metre, as in OpenSees."""
    bare = {"ice.first_moment_x2": 0.0, "ice.first_moment_x3": 0.0, "numerics.elements": 40}
    scene = gf.load_scene(name)
    one_given = {"span.sag": None, "span.horizontal_tension": None} | {
        f"span.{given}": getattr(scene.span, given)
    }
    ends = [SPRINGS] * springs + [RIGID] * (2 - springs)
    supports = {"supports.right": ends[0], "supports.left": ends[1]}
    scene = scene.with_values(bare | one_given | supports)
    strain = gf.Model(scene).equilibrium().horizontal_tension / scene.conductor.axial_stiffness
    return scene.with_values(
        {"conductor.mass_per_length": scene.conductor.mass_per_length / (1.0 + strain)}
    )


def frequencies(scene, family):
    return [mode.frequency_hz for mode in modal.natural_modes(scene) if mode.family == family]


@pytest.mark.parametrize(("name", "given", "springs"), VERTICAL)
def test_the_lowest_frequencies_are_those_of_opensees(name, given, springs):
    scene = as_in_opensees(name, given, springs)
    # observed at most 2.5e-4, in the third vertical mode of example 1
    assert frequencies(scene, "vertical")[:3] == pytest.approx(
        VERTICAL[name, given, springs], rel=3.5e-4
    )
    # observed at most 1.7e-4, in the third mode of example 2
    assert frequencies(scene, "horizontal")[:3] == pytest.approx(
        HORIZONTAL[name, given], rel=2.5e-4
    )


@pytest.mark.parametrize(("name", "given"), TENSION)
def test_the_tension_of_a_given_sag_is_that_of_opensees(name, given):
    tension = gf.Model(as_in_opensees(name, given, 0)).equilibrium().horizontal_tension
    assert tension == pytest.approx(
        TENSION[name, given], rel=4e-5
    )  # observed at most 2.8e-5, the digits printed


def test_zebra_has_the_published_frequencies():
    published = (0.171003521, 0.340307129, 0.341752038)  # github.com/Baiyu-Eplur/Pylon1, OpenSees
    found = [mode.frequency_hz for mode in modal.natural_modes(gf.load_scene("zebra"), count=3)]
    assert found == pytest.approx(published, rel=4.5e-4)  # observed 2.2e-4, 3.3e-4, 3.3e-4


def test_springs_destroy_the_two_to_one_ratio():
    """With the springs of Table 1 there is no internal resonance: example 3 has rigid ends."""
    ratios = [
        modal.frequency_ratio(as_in_opensees("example3", "sag", springs)).ratio
        for springs in range(3)
    ]
    expected = [0.6976 / 0.3803, 0.4916 / 0.3803, 0.4489 / 0.3803]  # 1.83, 1.29, 1.18
    assert ratios == pytest.approx(expected, rel=2e-4)  # observed at most 1e-4
    assert math.isclose(ratios[0], 2.0, rel_tol=0.1)
