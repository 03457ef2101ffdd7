"""Natural modes against closed formulas and against the matrices they come from."""

import math

import numpy as np
import pytest
from scipy.linalg import eigh

import gallop_fmu as gf
import modal

SPRINGS = {"kind": "springs", "stiffness_x1": 76e3, "stiffness_x3": 1400.0}


@pytest.fixture(scope="module")
def iced():
    """A rigid and a sprung end, and eccentric ice: everything that enters the matrices."""
    return gf.load_scene("example3").with_values({"supports.right": SPRINGS})


def modal_matrix(scene, modes, **part):
    """phi' A phi from the element matrices, without assembling them."""
    elements = gf.Model(scene.with_values({"wind.speed": 0.0})).tangent(**part)
    shapes = np.array([mode.shape.ravel() for mode in modes])
    pieces = np.array([shapes[:, 8 * e : 8 * e + 12] for e in range(len(elements))])
    return np.einsum("emi,eij,enj->mn", pieces, elements, pieces)


def test_shapes_are_orthonormal_in_the_mass(iced):
    modes = modal.natural_modes(iced)
    assert modal_matrix(iced, modes, mass=1.0) == pytest.approx(
        np.eye(12), abs=1e-13
    )  # observed 2.4e-15


def test_strain_energy_of_conductor_and_springs_gives_the_frequencies(iced):
    modes = modal.natural_modes(iced)
    at_spring = np.array([mode.shape[-1, [0, 2]] for mode in modes])
    energy = modal_matrix(iced, modes, stiffness=1.0) + at_spring * [76e3, 1400.0] @ at_spring.T
    squares = [(2.0 * math.pi * mode.frequency_hz) ** 2 for mode in modes]
    assert energy == pytest.approx(np.diag(squares), abs=1e-12 * squares[-1])  # observed 1.7e-14


def test_supported_unknowns_do_not_move(iced):
    for mode in modal.natural_modes(iced):
        assert not mode.shape[0].any()
        assert not mode.shape[-1, [1, 3]].any()
        assert mode.shape[-1, 2] != 0.0 or mode.family == "torsional"


def test_torsional_frequencies_are_those_of_a_shaft():
    scene = gf.load_scene("example1").with_values(
        {"conductor.torsional_stiffness": 1.0, "numerics.elements": 40}
    )
    shaft = math.sqrt(1.0 / scene.conductor.torsional_inertia) / (
        2.0 * gf.Model(scene).equilibrium().length
    )
    modes = [mode for mode in modal.natural_modes(scene) if mode.family == "torsional"]
    assert [mode.loops for mode in modes[:3]] == [1, 2, 3]
    assert [mode.symmetric for mode in modes[:3]] == [True, False, True]
    for loops, mode in enumerate(modes[:3], start=1):
        assert mode.frequency_hz == pytest.approx(
            loops * shaft, rel=3e-6
        )  # observed 2.6e-8, 4.2e-7, 2.1e-6


def test_longitudinal_frequencies_are_those_of_a_bar():
    # a nearly straight span; its tension stiffens it along the axis too
    scene = gf.load_scene("example1").with_values(
        {
            "span": {"length": 100.0, "sag": 0.2},
            "conductor.axial_stiffness": 4e6,
            "numerics.elements": 40,
        }
    )
    bar = (
        math.sqrt(
            (4e6 + gf.Model(scene).equilibrium().horizontal_tension)
            / scene.conductor.mass_per_length
        )
        / 200.0
    )
    modes = [mode for mode in modal.natural_modes(scene, count=50) if mode.family == "longitudinal"]
    assert [mode.loops for mode in modes[:2]] == [1, 2]
    assert [mode.symmetric for mode in modes[:2]] == [False, True]  # u1 changes sign in the mirror
    for loops, mode in enumerate(modes[:2], start=1):
        assert mode.frequency_hz == pytest.approx(loops * bar, rel=1e-5)  # observed 5e-6, -6e-6


def test_families_and_half_waves_of_a_line_span():
    modes = modal.natural_modes(gf.load_scene("example3"), count=6)
    assert [(mode.family, mode.loops, mode.symmetric) for mode in modes] == [
        ("horizontal", 1, True),
        ("vertical", 1, True),
        ("vertical", 2, False),
        ("horizontal", 2, False),
        ("horizontal", 3, True),
        ("vertical", 3, True),
    ]
    for mode in modes:
        assert sum(mode.shares.values()) == pytest.approx(1.0)
        assert mode.shares[mode.family] > 0.99


def test_the_wind_does_not_change_the_modes():
    scene = gf.load_scene("example3")
    windy, calm = (
        modal.natural_modes(scene),
        modal.natural_modes(scene.with_values({"wind.speed": 0.0})),
    )
    assert [mode.frequency_hz for mode in windy] == [mode.frequency_hz for mode in calm]


def test_both_eigensolvers_agree():
    scene = gf.load_scene("example3").with_values({"numerics.elements": 2})
    few, all_modes = modal.natural_modes(scene, count=4), modal.natural_modes(scene, count=12)
    for sparse, dense in zip(few, all_modes, strict=False):
        assert sparse.frequency_hz == pytest.approx(
            dense.frequency_hz, rel=5e-12
        )  # observed 1.1e-13
        assert sparse.shape == pytest.approx(dense.shape, abs=2e-11)  # observed 8e-13


def test_detuning_is_measured_from_two_to_one():
    ratio = modal.FrequencyRatio(vertical_hz=0.63, horizontal_hz=0.3)
    assert (ratio.ratio, ratio.detuning) == pytest.approx((2.1, 0.05))


@pytest.mark.parametrize("count", [0, -1, True, 2.5, 117])
def test_an_impossible_count_is_named(count):
    with pytest.raises(gf.SceneError, match=r"count = .* from 1 to 116"):
        modal.natural_modes(gf.load_scene("example3"), count)


def test_ice_that_rotates_the_conductor_over_is_named():
    # unstable from GJ (pi/L)^2 / g = 0.0097 kg on
    scene = gf.load_scene("example3")
    assert modal.natural_modes(scene.with_values({"ice.first_moment_x2": 0.0096}))
    with pytest.raises(gf.SceneError, match=r"unstable.*first_moment_x2 = 0.0098"):
        modal.natural_modes(scene.with_values({"ice.first_moment_x2": 0.0098}), count=1)


def test_no_ratio_where_the_ice_mixes_twist_and_vertical_motion():
    scene = gf.load_scene("example3").with_values(
        {"ice.first_moment_x2": 0.0, "conductor.torsional_stiffness": 4.8}
    )
    with pytest.raises(
        gf.SceneError, match=r"vertical mode at 0\.64.* mixture .*vertical 50%.*torsional 50%"
    ):
        modal.frequency_ratio(scene)


def test_no_ratio_where_torsional_modes_bury_the_others():
    bare = {
        "conductor.torsional_stiffness": 0.002,
        "ice.first_moment_x2": 0.0,
        "ice.first_moment_x3": 0.0,
    }
    with pytest.raises(gf.SceneError, match="no symmetric vertical mode among the lowest 24"):
        modal.frequency_ratio(gf.load_scene("example3").with_values(bare))


def bars_on_a_catenary(scene, elements=400):
    """Frequencies of straight bars with lumped masses on a catenary: (in plane, out of plane).

    An own finite-element model: stiffness EA/l along each bar and T/l across it. In plane, each
    frequency is listed with the part of its motion across the chord that is symmetric, and with the
    part of its energy along the chord.
    """
    span, mass = scene.span, scene.conductor.mass_per_length
    c = span.horizontal_tension / (mass * span.gravity)
    lowest = 0.5 * span.length - c * np.arcsinh(
        span.height_difference / (2 * c * np.sinh(span.length / (2 * c)))
    )
    left, right = (c * np.sinh((end - lowest) / c) for end in (0.0, span.length))
    x = lowest + c * np.arcsinh(np.linspace(left, right, elements + 1) / c)
    y = c * np.cosh((x - lowest) / c)
    step = np.diff(np.stack([x, y]))
    size = np.hypot(*step)
    tension = mass * span.gravity * 0.5 * (y[1:] + y[:-1])
    lump = 0.5 * mass * (size[1:] + size[:-1])
    t, n = step / size, np.stack([-step[1], step[0]]) / size
    both = (
        scene.conductor.axial_stiffness / size * t[:, None] * t + tension / size * n[:, None] * n
    )  # (2, 2, bar)
    inner = elements - 1
    plane, across = np.zeros((inner, 2, inner, 2)), np.zeros((inner, inner))
    for k in range(inner):
        plane[k, :, k] += both[..., k] + both[..., k + 1]
        across[k, k] += tension[k] / size[k] + tension[k + 1] / size[k + 1]
        if k:
            plane[k, :, k - 1] = plane[k - 1, :, k] = -both[..., k]
            across[k, k - 1] = across[k - 1, k] = -tension[k] / size[k]
    weight = 1.0 / np.sqrt(lump)
    scaled = (plane * weight[:, None, None, None] * weight[None, None, :, None]).reshape(
        2 * inner, 2 * inner
    )
    squares, vectors = eigh(scaled, subset_by_index=(0, 7))
    out = eigh(across * weight[:, None] * weight, eigvals_only=True, subset_by_index=(0, 0))
    chord = np.array([span.length, span.height_difference]) / np.hypot(
        span.length, span.height_difference
    )
    found = []
    for square, vector in zip(squares, vectors.T, strict=True):
        moved = vector.reshape(inner, 2)
        along, up = moved @ chord, moved @ np.array([-chord[1], chord[0]])
        found.append((np.sqrt(square) / (2 * np.pi), up @ up[::-1] / (up @ up), along @ along))
    return found, float(np.sqrt(out[0])) / (2 * np.pi)


@pytest.mark.parametrize(("rise", "ratio"), [(0.0, None), (300.0, 2.296), (0.99 * 322.8, None)])
def test_the_ratio_of_a_steep_span_is_that_of_an_own_model(rise, ratio):
    scene = gf.load_scene("zebra").with_values({"span.height_difference": rise})
    found = modal.frequency_ratio(scene)
    plane, horizontal = bars_on_a_catenary(scene)
    vertical, _, along = next(row for row in plane if row[1] > 0.5)
    assert along < 0.02
    assert found.vertical_hz == pytest.approx(vertical, rel=3e-4)  # observed at most 1.7e-4
    assert found.horizontal_hz == pytest.approx(horizontal, rel=2e-5)  # observed at most 6e-6
    if ratio:
        assert found.ratio == pytest.approx(ratio, abs=5e-4)
    theory = modal.shallow_cable(scene)
    assert theory.ratio == pytest.approx(found.ratio, rel=1e-2)  # observed 9e-3 at 0.99 L
    families = [(mode.family, mode.shares[mode.family]) for mode in modal.natural_modes(scene, 6)]
    assert {family for family, _ in families} == {"vertical", "horizontal"}
    assert min(share for _, share in families) > 0.98
