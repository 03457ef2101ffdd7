"""The reduced model of a line whose branches are followed, against the kernel and differences."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from modal.motions.line_model import LineModel
from modal.motions.span_model import SpanModel
from support.galloping_lines import section_of_example2

LINES = {
    "section": lambda: section_of_example2(3, elements=4),
    "twin": lambda: section_of_example2(
        2,
        elements=4,
        bundle={
            "subconductors": 2,
            "spacing": 0.4,
            "spacers": 1,
            "clamp_torsional_stiffness": 500.0,
        },
        devices=[
            {"kind": "pendulum", "span": 1, "station": 0.5, "mass": 5.0, "arm": 0.5},
            {"kind": "damper", "span": 2, "station": 0.5, "damping": 20.0},
        ],
    ),
}


@pytest.fixture(scope="module", params=LINES)
def line(request):
    return LineModel(LINES[request.param]())


def drawn(model, size, seed=0):
    """Random coordinates: displacements of about `size` metres, rotations of a tenth of it."""
    draw = np.random.default_rng(seed)
    largest = np.max(np.abs(model.shapes), axis=1)
    weight = size / np.maximum(np.max(largest[:, :3], axis=1), 10.0 * largest[:, 3])
    return draw.uniform(-1.0, 1.0, (3, model.size)) * weight / np.sqrt(model.size)


def residual(mesh, u):
    """Forces of conductors and devices on the leaders, flat."""
    found = np.zeros_like(u)
    np.add.at(found, mesh.leader, mesh.model.residual(u, inputs=mesh.still))
    nodes, _ = mesh.model.junction_nodes()
    for device, junctions in enumerate(mesh.model.devices):
        force, _, _ = mesh.model.device_force(device, u, inputs=mesh.still)
        np.add.at(found, mesh.leader[nodes[list(junctions)]], force)
    return found.ravel()


def relaxed(model, q):
    """Displacement of all nodes in the coordinates q, without any force on the other motions."""
    mesh, equations = model.mesh, model.basis.equations
    at = np.flatnonzero(equations.free)
    flat = model.shapes.reshape(model.size, -1)
    u = q @ flat
    rows = (flat @ equations.stiffness)[:, at]
    for _ in range(8):
        tangent = mesh.tangent(u.reshape(-1, 4), stiffness=1.0, inputs=mesh.still)
        factors = splu(tangent[at][:, at].tocsc())
        free, push = (factors.solve(x) for x in (residual(mesh, u.reshape(-1, 4))[at], rows.T))
        # V'K w = 0 is kept by forces K V x
        change = np.zeros_like(u)
        change[at] = -free + push @ np.linalg.solve(rows @ push, rows @ free)
        u = u + mesh.spread(change.reshape(-1, 4)).ravel()
    return u


def test_static_forces_agree_with_the_kernel_up_to_the_fourth_order(line):
    """The kernel's other motions are relaxed by Newton's method; its force on the kept remains."""
    flat, errors = line.shapes.reshape(line.size, -1), []
    for size in (0.2, 0.1):
        q = drawn(line, size)
        calm = np.zeros_like(q)
        ours = line.forces(q, calm, calm, 0.0).residual
        for row, force in zip(q, ours, strict=True):
            theirs = flat @ residual(line.mesh, relaxed(line, row).reshape(-1, 4))
            linear = row @ line.stiffness
            errors.append(np.linalg.norm(force - theirs) / np.linalg.norm(theirs - linear))
    large, small = np.max(np.reshape(errors, (2, -1)), axis=1)
    assert small < 1e-3  # observed 7.6e-4 and 4.0e-4
    assert 3.5 < large / small < 4.5  # the error is of the fourth order, relative to the second


def test_following_displacements_relax_the_other_motions(line):
    flat, mesh = line.shapes.reshape(line.size, -1), line.mesh
    at = np.flatnonzero(line.basis.equations.free)
    held = (flat @ line.basis.equations.stiffness)[:, at]
    left = []
    for size in (0.2, 0.1):
        u, _ = line.nodal(drawn(line, size), np.zeros((3, line.size)))
        forces = np.array([residual(mesh, one)[at] for one in u])
        rest = forces - forces @ np.linalg.pinv(held) @ held
        left.append(np.linalg.norm(rest))
    assert 6.0 < left[0] / left[1] < 10.0  # third order


def test_derivatives_are_those_of_differences(line):
    q, v = drawn(line, 0.3), 4.0 * drawn(line, 0.3, 1)
    found = line.motion(q, v, 4.1)
    direction = drawn(line, 1.0, 2)
    scale, step = np.max(np.abs(line.shapes), axis=(1, 2)), 1e-5
    for slopes, dq, dv, dw in (
        (found.by_displacement, direction, 0.0, 0.0),
        (found.by_velocity, 0.0, direction, 0.0),
        (None, 0.0, 0.0, 1.0),
    ):
        ahead, back = (
            line.motion(q + h * dq, v + h * dv, 4.1 + h * dw).acceleration for h in (step, -step)
        )
        along = found.by_wind if slopes is None else (slopes @ direction[:, :, None])[:, :, 0]
        difference = ((ahead - back) / (2.0 * step) - along) * scale
        assert np.max(np.abs(difference)) < 1e-5 * max(1.0, np.max(np.abs(along * scale)))


def test_the_residual_of_a_motion_is_zero(line):
    q, v = drawn(line, 0.3), 4.0 * drawn(line, 0.3, 1)
    acceleration = line.motion(q, v, 4.1).acceleration
    size = np.max(np.abs(line.residual(q, v, 0.0 * q, 4.1)))
    assert np.max(np.abs(line.residual(q, v, acceleration, 4.1))) < 1e-13 * size


def test_strings_have_their_exact_force_at_any_lean():
    """A bar of stiffness k and unstretched length l along r pulls with k (|r| - l) r/|r|."""
    model, k, length = LineModel(LINES["section"]()), 1e7, 2.1
    mesh = model.mesh
    nodes, leader = mesh.model.junction_nodes()
    q = drawn(model, 0.3)
    expected = np.zeros_like(q)
    for tower in mesh.model.map.towers[1:3]:
        shapes = model.shapes[:, leader[nodes[tower.junctions[0]]], :3]
        x = q @ shapes
        assert np.max(np.abs(x[:, 2])) > 0.05
        pull = 0.5 * 490.0 - mesh.model.device_force(tower.devices[0])[0][0, 1]
        strung = length + pull / k
        r = x - [0.0, strung, 0.0]
        size = np.linalg.norm(r, axis=1, keepdims=True)
        at_rest, linear = [0.0, -pull, 0.0], x * [pull / strung, k, pull / strung]
        force = k * (size - length) * r / size - at_rest - linear
        expected += force @ shapes.T
    found = model.stretching(q)[0] - SpanModel.stretching(model, q)[0]
    assert found == pytest.approx(expected, abs=1e-6 * np.max(np.abs(expected)))
