"""Natural modes of lines against OpenSees, closed forms and exact relations.

Numbers marked OpenSees are those of an independent model of straight bars (LINE: level sections,
conductors of mass per unstretched length, no twist), in Hz. Its meshes of 80 to 320 elements a span
are up to 0.04 % too stiff for the modes listed here; ours of 30 elements are within 0.002 % of
finer ones.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import gallop_fmu as gf
import modal
from tests.support.line_references import line_scene, stored
from tests.support.line_scenes import in_plane, of_family, section, zebra

OPENSEES = 5e-4
"""Bound on relative deviations from OpenSees; observed below."""


@pytest.fixture(scope="module")
def one_span():
    return modal.natural_modes(zebra(), 8)


def test_one_span_has_the_frequencies_of_opensees(one_span):
    """Observed: 4.2e-4, of a mode with three loops."""
    vertical, across = in_plane(one_span), of_family(one_span, "horizontal")
    assert vertical[:3] == pytest.approx([0.36672, 0.49544, 0.68960], rel=OPENSEES)
    assert across[:2] == pytest.approx([0.18410, 0.36807], rel=OPENSEES)


def test_a_line_of_one_span_has_the_modes_of_the_span():
    line = zebra(elements=8)
    span = gf.Scene.from_dict(
        {
            "title": "span",
            "span": {"length": 300.0, "horizontal_tension": 19785.0, "gravity": 9.81},
            "supports": {"left": {"kind": "rigid"}, "right": {"kind": "rigid"}},
            "conductor": line.conductor.model_dump(mode="json", exclude_none=True),
            "numerics": {"elements": 8},
        }
    )
    wanted, found = modal.natural_modes(span, 12), modal.natural_modes(line, 12)
    for one, other in zip(wanted, found, strict=True):
        assert other.frequency_hz == pytest.approx(one.frequency_hz, rel=1e-10)  # seen: 1e-12
        assert (other.family, other.loops) == (one.family, (one.loops,))


def test_spans_between_posts_do_not_take_part_in_each_other():
    """Equal frequencies of three equal spans do not mix their modes."""
    found = modal.natural_modes(zebra(3, string=None, elements=8), 12)
    for three in (found[k : k + 3] for k in range(0, 12, 3)):
        assert len({mode.family for mode in three}) == 1
        taking_part = np.sort([np.argmax(mode.span_shares) for mode in three])
        assert taking_part.tolist() == [0, 1, 2]
        for mode in three:
            assert mode.span_shares.max() > 1.0 - 1e-12
            assert sum(loops > 0 for loops in mode.loops) == 1
            assert mode.frequency_hz == pytest.approx(three[0].frequency_hz, rel=1e-11)


def test_modes_have_unit_mass_and_shares_add_up():
    from gallop_fmu.engine.mesh import Mesh

    scene = zebra(2, string=None, elements=6)
    mesh = Mesh(gf.Model(scene))
    mass = mesh.assemble(mesh.model.tangent(mass=1.0, inputs=mesh.still))
    for mode in modal.natural_modes(scene, 6):
        shape = mode.shape.ravel()
        assert shape @ (mass @ shape) == pytest.approx(1.0, rel=1e-12)
        for shares in (mode.span_shares, mode.phase_shares, mode.subconductor_shares):
            assert shares.sum() == pytest.approx(1.0, rel=1e-12)
        assert sum(mode.shares.values()) == pytest.approx(1.0, rel=1e-12)
        assert mode.device_share < 1e-12


def test_tension_share_of_a_mode_is_its_stiffening_by_the_sag(one_span):
    """Antisymmetric modes have no first-order change of tension; the stiffened ones have."""
    shares = {mode.loops[0]: mode.tension_share for mode in one_span if mode.family == "vertical"}
    assert shares[2] < 1e-4
    symmetric = [m.tension_share for m in one_span if m.family == "vertical" and m.loops[0] == 3]
    assert symmetric == pytest.approx([0.208, 0.636], abs=0.01)  # between one and three loops


@pytest.mark.parametrize("count", [0, True, 10000, 2.0])
def test_an_impossible_number_of_modes_is_refused(count):
    with pytest.raises(gf.SceneError, match="must be a whole number from 1 to"):
        modal.natural_modes(zebra(elements=4), count)


REFUSALS = {
    "two_mode_estimate": (modal.two_mode_estimate, "modal.screen, which takes lines"),
    "shallow_cable": (modal.shallow_cable, "natural_modes"),
    "suggest_design_changes": (modal.suggest_design_changes, "with_values"),
    "ratio_map": (lambda scene: modal.ratio_map(scene, "span.sag", [1.0]), "with_values"),
    "track_modes": (lambda scene: modal.track_modes(scene, "wind.speed", [1.0]), "with_values"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_functions_of_one_span_say_what_to_use_for_a_line(name):
    function, instead = REFUSALS[name]
    with pytest.raises(gf.SceneError, match=f"{name} takes a scene of one span") as found:
        function(zebra(2, string=None, elements=4))
    assert "a section of 2 spans" in str(found.value)
    assert instead in str(found.value)


def planes(modes):
    """Frequencies [Hz] in the vertical plane, and across it."""
    return in_plane(modes), of_family(modes, "horizontal")


SECTIONS = {
    "section_frequencies_zebra_2_spans": 1e-5,
    "section_frequencies_zebra_3_spans": 1e-5,
    "section_frequencies_example2_3_spans": 2e-5,
    "section_frequencies_drake_3_spans": 2e-5,
    "new_section_frequencies_1": 1e-5,
    "new_section_frequencies_2": 3e-5,
    "new_section_frequencies_3": 3e-5,
}
"""Stored sections, and bounds on the deviation from values extrapolated to fine meshes; seen: up to
7e-6, 5e-6, 1.2e-5, 1.3e-5, 5e-6, 1.7e-5, 2.3e-5."""


@pytest.mark.parametrize("name", SECTIONS)
def test_sections_have_the_frequencies_of_opensees(name):
    case = stored(name)
    scene = line_scene(case, elements=30).with_values({"conductor.torsional_stiffness": 1e5})
    found = planes(modal.natural_modes(scene, 18))
    given = case["results"]
    fine = case.get("repeated") or given
    suffix = "_extrapolated" if "repeated" in case else ""
    for frequencies, plane in zip(found, ("in_plane", "out_of_plane"), strict=True):
        count = len(given[plane])
        assert frequencies[:count] == pytest.approx(given[plane], rel=6e-4)  # 5.4e-4: three loops
        assert frequencies[:count] == pytest.approx(fine[plane + suffix], rel=SECTIONS[name])


BUNDLES = {
    "bundle_frequencies_quad_200m": ("bundle torsion", "torsion", 1e-5, 20),
    "bundle_frequencies_triple_300m": ("bundle torsion", "torsion", 1e-5, 28),
    "bundle_frequencies_twin_drake": ("bundle torsion", "torsion", 5e-5, 24),
}
"""Stored bundles: bounds on the deviation of torsion from extrapolated values, elements a span;
seen: 7e-6, 8e-6, 3.9e-5 (lumped masses of 96 bars)."""


@pytest.mark.parametrize("name", BUNDLES)
def test_bundles_have_the_frequencies_of_other_programs(name):
    family, key, bound, elements = BUNDLES[name]
    case = stored(name)
    scene = line_scene(case, elements=elements)
    if not case["scene"]["conductor"]["torsional_stiffness"]:  # trusses do not twist
        free = {"bundle.clamp_torsional_stiffness": 1e-9, "conductor.torsional_stiffness": 1e5}
        scene = scene.with_values(free)
    found = modal.natural_modes(scene, 16)
    fine = case["repeated"]
    torsion = fine[f"{key}_extrapolated"]
    assert of_family(found, family)[: len(torsion)] == pytest.approx(torsion, rel=bound)
    for plane in ("vertical", "horizontal"):
        wanted = fine[f"{plane}_extrapolated"]
        assert of_family(found, plane)[: len(wanted)] == pytest.approx(wanted, rel=3e-5)


def test_bundle_torsion_has_the_closed_forms():
    """Irvine's equation with the lambda of the rotating bundle; within 0.1 %."""
    for name in ("bundle_frequencies_quad_200m", "bundle_frequencies_triple_300m"):
        case = stored(name)
        free = {"bundle.clamp_torsional_stiffness": 1e-9, "conductor.torsional_stiffness": 1e5}
        found = modal.natural_modes(line_scene(case, elements=16).with_values(free), 4)
        first = of_family(found, "bundle torsion")[0]
        assert first == pytest.approx(case["results"]["closed_form"]["torsion"], rel=1e-3)


def test_frequencies_of_a_section_of_twin_bundles_with_yokes():
    """All families, in order; seen: 8e-5 (the stored values have a mesh error of 4e-4)."""
    case = stored("new_bundle_section_frequencies")
    found = [m.frequency_hz for m in modal.natural_modes(line_scene(case, elements=18), 14)]
    assert found == pytest.approx(case["results"]["all"], rel=2e-4)


@pytest.mark.parametrize(
    ("orientation", "other"), [("horizontal", "vertical"), ("vertical", "horizontal")]
)
def test_a_twin_rotates_as_it_swings(orientation, other):
    """Without clamp stiffness, each subconductor moves as in the translation of its direction."""
    scene = section(
        *(25000.0, [300.0], 15.97, 29e6),
        elements=12,
        torsion=(1e5, 1e-4),
        bundle={
            "subconductors": 2,
            "spacing": 0.457,
            "orientation": orientation,
            "spacers": 5,
            "clamp_torsional_stiffness": 1e-9,
        },
    )
    found = modal.natural_modes(scene, 12)
    torsion, translation = of_family(found, "bundle torsion"), of_family(found, other)
    assert len(torsion) >= 3
    assert torsion[:3] == pytest.approx(translation[:3], rel=3e-10)  # seen: 1e-10


def test_spans_in_phase_move_as_between_rigid_ends():
    """Exact for inextensible strings; with 5e7 N/m the difference is 4e-6."""
    rigid = zebra(3, elements=10).with_values(
        {f"section.suspensions.{k}.stiffness": 1e14 for k in (0, 1)}
    )
    every = np.array([mode.frequency_hz for mode in modal.natural_modes(rigid, 24)])
    for mode in modal.natural_modes(zebra(elements=10), 6):
        assert np.min(np.abs(every / mode.frequency_hz - 1.0)) < 1e-10  # seen: 2e-11


def test_families_of_a_section():
    found = modal.natural_modes(zebra(3, elements=12), 10)
    neutral = [mode for mode in found if mode.family == "tension-neutral"]
    assert [mode.loops[0] for mode in neutral] == [1, 1]
    assert max(mode.tension_share for mode in neutral) < 0.01
    assert sum(mode.family == "vertical" for mode in found) == 3
    # The first swing moves the middle span most, the second the outer ones against each other.
    assert found[0].family == "horizontal"
    assert found[0].span_shares[1] > 0.6
    assert found[1].span_shares[1] < 0.01
    assert 0.0 < found[0].device_share < 0.01


def chain_determinant(omega, tension, lengths, mass, stiffness, string, gravity=9.81):
    """Determinant of the clamps of a section in its symmetric in-plane motion.

    In each span h = k(w) (u_right - u_left) with 1/k = Le/EA - (64 d2/(L3 m w2)) (1 -
    tan(W/2)/(W/2)), W = w L sqrt(m/H), d = m g L2/(8 H), Le = L (1 + 8 (d/L)2); a string has
    (V + Ws/2)/ls - w2 Ms/3, with V the weight of the conductor that it carries.
    """
    inverse = []
    for length in lengths:
        sag = mass * gravity * length**2 / (8.0 * tension)
        half = 0.5 * omega * length * np.sqrt(mass / tension)
        stretched = length * (1.0 + 8.0 * (sag / length) ** 2)
        inverse.append(
            stretched / stiffness
            - 64.0 * sag**2 / (length**3 * mass * omega**2) * (1.0 - np.tan(half) / half)
        )
    k = 1.0 / np.array(inverse)
    matrix = np.zeros((len(lengths) - 1,) * 2)
    for j in range(len(lengths) - 1):
        carried = 0.5 * mass * gravity * (lengths[j] + lengths[j + 1])
        held = (carried + 0.5 * string[1]) / string[0] - omega**2 * string[1] / gravity / 3.0
        matrix[j, j] = held + k[j] + k[j + 1]
        if j:
            matrix[j, j - 1] = matrix[j - 1, j] = -k[j]
    return np.linalg.det(matrix)


CHAIN = {2: 4e-3, 3: 6e-4, 4: 2e-3}
"""Equal spans, and bounds on the deviation of the lowest mode from the closed form, which has no
inertia along the line; seen: 3.5e-3, 3.9e-4, 1.4e-3."""


@pytest.mark.parametrize("spans", CHAIN)
def test_tension_neutral_modes_have_the_tridiagonal_determinant(spans):
    lengths, weight, tension, stiffness = [300.0] * spans, 15.90, 19785.0, 44.389e6
    string, mass = (2.1, 490.0), weight / 9.81 / (1.0 + tension / stiffness)
    scene = section(tension, lengths, weight, stiffness, string=string, elements=12)
    neutral = of_family(modal.natural_modes(scene, 14), "tension-neutral")
    assert len(neutral) == spans - 1

    def determinant(hertz):
        return chain_determinant(2.0 * np.pi * hertz, tension, lengths, mass, stiffness, string)

    for k, hertz in enumerate(neutral):
        bound = CHAIN[spans] if k == 0 else 0.04  # seen: 0.03, of the third mode of four spans
        found = brentq(determinant, (1.0 - min(bound, 0.01)) * hertz, (1.0 + bound) * hertz)
        assert found == pytest.approx(hertz, rel=bound)
