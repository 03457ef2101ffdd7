"""The reduced model of a span whose branches are followed, against the kernel and differences."""

import numpy as np
import pytest

import gallop_fmu as gf
from modal.linear.mode_basis import still_air_modes
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import NumberFamily, SpanProblem, WindFamily


@pytest.fixture(scope="module")
def span():
    scene = gf.load_scene("example3")
    return SpanModel(scene, still_air_modes(scene, 8))


def drawn(model, size, seed=0):
    """Random coordinates: displacements of about `size` metres, rotations of a tenth of it."""
    draw = np.random.default_rng(seed)
    largest = np.max(np.abs(model.shapes), axis=1)
    weight = size / np.maximum(np.max(largest[:, :3], axis=1), 10.0 * largest[:, 3])
    return draw.uniform(-1.0, 1.0, (5, model.size)) * weight / np.sqrt(model.size)


def test_static_forces_agree_with_the_kernel_up_to_the_fourth_order(span):
    """The kernel's other modes are relaxed by Newton's method; its force on the kept ones remains.

    The energy (2) is exact to the fourth order, so the force has an error of the fourth.
    """
    model, modes = span.modes.model, span.modes
    flat = modes.shapes.reshape(len(modes.shapes), -1)
    kept = flat[span.chosen]
    others = flat[np.setdiff1d(np.arange(len(flat)), span.chosen)]
    errors = []
    for size in (0.4, 0.2):
        q = drawn(span, size)
        calm = np.zeros_like(q)
        ours = span.forces(q, calm, calm, 0.0).residual
        for row, force in zip(q, ours, strict=True):
            u = (row @ kept).copy()
            for _ in range(8):
                residual = model.residual(u.reshape(-1, 4), inputs=modes.mesh.still).ravel()
                tangent = modes.mesh.tangent(
                    u.reshape(-1, 4), stiffness=1.0, inputs=modes.mesh.still
                ).toarray()
                u -= others.T @ np.linalg.solve(others @ tangent @ others.T, others @ residual)
            theirs = kept @ model.residual(u.reshape(-1, 4), inputs=modes.mesh.still).ravel()
            linear = row * modes.frequencies[span.chosen] ** 2
            errors.append(np.linalg.norm(force - theirs) / np.linalg.norm(theirs - linear))
    large, small = np.max(np.reshape(errors, (2, -1)), axis=1)
    assert small < 3e-4
    assert 3.0 < large / small  # the error of the fourth order, relative to the second: 4


def test_following_displacements_relax_the_other_modes(span):
    """What is left of the kernel's force on them is of third order."""
    modes = span.modes
    flat = modes.shapes.reshape(len(modes.shapes), -1)
    others = flat[np.setdiff1d(np.arange(len(flat)), span.chosen)]
    left = []
    for size in (0.2, 0.1):
        q = drawn(span, size)
        u, v = span.nodal(q, q)
        left.append(
            np.linalg.norm(others @ modes.model.residual(u[0], inputs=modes.mesh.still).ravel())
        )
        step = 1e-6
        ahead, back = (span.nodal(q * (1 + side), q)[0] for side in (step, -step))
        assert v == pytest.approx((ahead - back) / (2.0 * step), abs=1e-9)
    assert 6.0 < left[0] / left[1] < 10.0


@pytest.mark.parametrize("path", ["wind.speed", "conductor.torsional_stiffness"])
def test_derivatives_are_those_of_differences(span, path):
    scene = span.scene
    is_wind = path == "wind.speed"
    family = WindFamily(span) if is_wind else NumberFamily(scene, path, span, 0.01)
    problem = SpanProblem(family, span, 5.5)
    value = 5.5 if is_wind else 153.0
    q = drawn(span, 0.3)
    y = np.hstack([q, 4.0 * drawn(span, 0.3, 1)])
    rates = problem.rates(y, value)
    direction = np.random.default_rng(2).standard_normal(y.shape) * problem.scale
    step = 1e-5
    ahead, back = (problem.rates(y + side * direction, value).value for side in (step, -step))
    along = (rates.by_state @ direction[:, :, None])[:, :, 0]
    # observed 1e-9
    assert np.max(np.abs((ahead - back) / (2.0 * step) - along) / problem.scale) < 1e-6
    step *= value
    ahead, back = (problem.rates(y, value + side).value for side in (step, -step))
    by_number = (ahead - back) / (2.0 * step)
    assert rates.by_parameter == pytest.approx(by_number, rel=1e-3, abs=1e-5 * np.max(by_number))


def test_symmetry_of_a_level_span(span):
    problem = SpanProblem(WindFamily(span), span, 5.5)
    mirror = problem.symmetry
    y = np.hstack([drawn(span, 0.3), 4.0 * drawn(span, 0.3, 1)])
    mirrored = problem.rates(y @ mirror, 6.0).value
    expected = problem.rates(y, 6.0).value @ mirror
    assert mirrored / problem.scale == pytest.approx(expected / problem.scale, abs=1e-8)
    slope = gf.load_scene("example3").with_values(
        {"span.sag": None, "span.height_difference": 10.0}
    )
    model = SpanModel(slope, still_air_modes(slope, 8))
    assert SpanProblem(WindFamily(model), model, 5.5).symmetry is None


def test_coordinates_are_continuous_where_modes_are_computed_again(span):
    scene = span.scene.with_values({"conductor.torsional_stiffness": 150.0})
    other = SpanModel(scene, still_air_modes(scene, 8), like=span)
    mass = span.modes.mass
    likeness = span.shapes.reshape(span.size, -1) @ mass @ other.shapes.reshape(span.size, -1).T
    assert likeness == pytest.approx(np.eye(span.size), abs=0.02)
