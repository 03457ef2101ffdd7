"""Coupling of modes of a line, against integrals over the strain and closed forms."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from modal.linear.line_modes import line_modes
from modal.linear.linearise import SmallMotion
from modal.stability.mode_pairs import Expansion, mode_pairs, one_to_one_changes
from tests.support.line_references import line_scene, stored
from tests.support.line_scenes import section, zebra

DAMPED = {
    "translation": {
        "low_ratio": 0.005,
        "low_frequency": 0.2,
        "high_ratio": 0.005,
        "high_frequency": 1.0,
    }
}


def expansion_of(scene, count):
    motion = SmallMotion(scene)
    equations = motion.in_still_air()
    return Expansion(motion, equations, line_modes(equations, motion.mesh, count))


@pytest.fixture(scope="module")
def posts():
    """Two spans of which one is sprung: no strings, so that the strain has all the coupling."""
    return expansion_of(section(19785.0, [300.0, 260.0], 15.9, 44.4e6, string=None, elements=8), 12)


def pairs_of(expansion):
    return [(i, j) for i in range(len(expansion.modes)) for j in range(len(expansion.modes))]


def test_coupling_is_the_integral_of_strain_and_slopes(posts):
    """Equation (2) of the module for i, j, j: int EA (e_i p_j'.p_j' + 2 e_j p_i'.p_j') dS."""
    points = posts.mesh.strain_points
    slope = np.array([points.slope(mode.shape)[:, :3] for mode in posts.modes])
    strain = np.einsum("mpk,pk->mp", slope, points.tangent)
    weight = 44.4e6 * points.length
    for i, j in pairs_of(posts):
        expected = np.sum(
            weight
            * (
                strain[i] * np.sum(slope[j] ** 2, axis=1)
                + 2.0 * strain[j] * np.sum(slope[i] * slope[j], axis=1)
            )
        )
        found = posts.shapes[j] @ (posts.first(i) @ posts.shapes[j])
        assert found == pytest.approx(expected, abs=1e-9)  # seen: 2e-11; the largest is 0.4


def test_quartic_coupling_is_the_second_difference_of_the_stiffness(posts):
    """The stiffness of conductors is quadratic in the displacement, so that any step is exact."""
    for i, j in pairs_of(posts):
        moved = 0.1 / posts.modes[i].largest * posts.modes[i].shape
        ahead, here, back = (posts.stiffness(k * moved) for k in (1.0, 0.0, -1.0))
        second = (ahead + back - 2.0 * here) * (posts.modes[i].largest / 0.1) ** 2
        expected = posts.shapes[j] @ (second @ posts.shapes[j])
        found = posts.quartic(i, np.array([j]))[0]
        assert found == pytest.approx(expected, rel=1e-7, abs=1e-9)


def test_coupling_is_the_mixed_difference_of_the_residual(posts):
    """Forces of the moved line along a mode: the product of both coordinates has c_ijj."""
    model = posts.mesh.model
    i, j = next(
        (i, j)
        for i, j in pairs_of(posts)
        if posts.modes[i].family == "vertical"
        and posts.modes[j].family == "horizontal"
        and abs(posts.shapes[j] @ (posts.first(i) @ posts.shapes[j])) > 0.1
    )
    a, b = (0.05 / posts.modes[k].largest for k in (i, j))
    total = 0.0
    for s, t in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        u = s * a * posts.modes[i].shape + t * b * posts.modes[j].shape
        force = model.residual(u, inputs=posts.mesh.still)
        total += s * t * float(np.sum(force * posts.modes[j].shape))
    found = posts.shapes[j] @ (posts.first(i) @ posts.shapes[j])
    assert found == pytest.approx(total / (4.0 * a * b), rel=1e-7)


def test_modulation_is_that_of_one_span():
    """The first symmetric pair of Example 3, computed as a span and as a line."""
    span = gf.load_scene("example3").with_values(
        {
            "span.horizontal_tension": 15000.0,
            "span.sag": None,
            "supports.left": {"kind": "rigid"},
            "supports.right": {"kind": "rigid"},
            "numerics.elements": 6,
        }
    )
    data = span.model_dump(mode="json", exclude_none=True)
    line = gf.LineScene.from_dict(
        {
            "title": "line",
            "section": {
                "horizontal_tension": 15000.0,
                "strung_with_ice": True,
                "gravity": data["span"]["gravity"],
                "spans": [{"length": data["span"]["length"]}],
            },
            **{name: data[name] for name in ("conductor", "ice", "damping", "numerics")},
        }
    )
    wanted = modal.quadratic_coupling(span).modulation
    pair = next(
        pair
        for pair in modal.frequency_ratio(line)
        if (pair.kind, pair.driving_mode.loops, pair.driven_mode.loops) == ("2:1", (1,), (1,))
        and pair.driven_mode.family == "horizontal"
        and pair.driving_mode.family == "vertical"
    )
    assert abs(pair.modulation) == pytest.approx(abs(wanted), rel=1e-6)


def test_one_to_one_coupling_is_that_of_a_taut_string():
    """q'' + w2 q + G (q.q) q = 0 in two directions, G = EA pi^4 / (2 m2 L5): S_i = S_c = 3/4 G,
    S_s = G/4, less the inertia of the longitudinal motion at twice the frequency."""
    tension, length, stiffness, mass = 20000.0, 200.0, 30e6, 1.5
    scene = gf.LineScene.from_dict(
        {
            "title": "taut",
            "section": {
                "horizontal_tension": tension,
                "gravity": 1e-4,
                "spans": [{"length": length}],
            },
            "conductor": {
                "diameter": 0.03,
                "mass_per_length": mass,
                "axial_stiffness": stiffness,
                "torsional_stiffness": 1e6,
                "torsional_inertia": 1e-4,
            },
            "numerics": {"elements": 12},
        }
    )
    expansion = expansion_of(scene, 2)
    strength = stiffness * math.pi**4 / (2.0 * mass**2 * length**5)
    for i in (0, 1):
        changes = one_to_one_changes(expansion, i, np.array([1 - i]))[0]
        assert np.array(changes) / strength == pytest.approx([0.75, 0.75, 0.25], rel=2e-3)


STIFF = {
    "strings": ("section.suspensions.0.stiffness", [5e7, 5e8], zebra(2, elements=6)),
    "spacers": (
        "bundle.arm_stiffness",
        [1e7, 1e8],
        zebra(elements=6, bundle={"subconductors": 4, "spacing": 0.45, "spacers": 2}),
    ),
}


@pytest.mark.parametrize("name", STIFF)
def test_stiff_devices_have_no_effect_on_the_changes_of_frequency(name):
    """Their large terms cancel. Seen: differences of 0.3 % of the largest change."""
    path, values, scene = STIFF[name]
    found = []
    for value in values:
        expansion = expansion_of(scene.with_values({path: value}), 6)
        others = [np.delete(np.arange(6), i) for i in range(6)]
        found.append([one_to_one_changes(expansion, i, others[i]) for i in range(6)])
    first, second = np.array(found)
    assert np.abs(first - second).max() < 0.01 * np.abs(first).max()


def test_pairs_are_sorted_and_say_what_matters():
    found = mode_pairs(zebra(elements=8, damping=DAMPED), count=12)
    kinds = [pair.kind for pair in found if pair.matters]
    assert kinds == sorted(kinds, reverse=True)
    severity = [p.threshold / p.largest_galloping for p in found if p.matters and p.kind == "2:1"]
    assert severity == sorted(severity)
    assert {pair.kind for pair in found} == {"2:1", "1:1"}
    first = next(pair for pair in found if pair.kind == "2:1")
    damping = first.driven_mode.damping_ratio
    assert first.threshold == pytest.approx(
        4.0 * math.hypot(damping, first.detuning) / abs(first.modulation), rel=1e-12
    )
    assert first.matters
    assert "this pair matters" in first.sentence
    assert first == found[0]
    swings = [pair for pair in found if pair.driving_mode.family == "horizontal"]
    assert not any(pair.matters for pair in swings)


@pytest.mark.parametrize("band", [0.0, 1.0, math.nan])
def test_a_band_that_is_not_between_0_and_1_is_refused(band):
    with pytest.raises(gf.SceneError, match="must be greater than 0 and less than 1"):
        mode_pairs(zebra(elements=4), band=band)


def test_the_swing_of_the_strings_is_found_by_its_threshold():
    """LINE: three spans of Example 2 gallop up to 1.38 m, and then the strings swing sideways at
    half the frequency; the vertical mode in phase and the lowest swing are 15 % off 2:1."""
    scene = line_scene(stored("section_galloping_example2_3_spans"), elements=8)
    pair = next(
        pair
        for pair in modal.frequency_ratio(scene)
        if pair.kind == "2:1" and pair.driven == 1 and pair.driving_mode.family == "vertical"
    )
    assert pair.driving_mode.loops == (1, 1, 1)
    assert pair.detuning == pytest.approx(-0.146, abs=1e-3)
    assert pair.matters
    assert 1.1 < pair.threshold < 1.38  # 1.23: the first approximation
