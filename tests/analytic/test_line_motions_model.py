"""The reduced model of a line whose branches are followed, against the kernel and differences."""

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from modal.motions.device_forms import device_forms
from modal.motions.line_model import LineModel
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
    print(large, small)
    assert small < 3e-3
    assert 3.0 < large / small  # the error of the fourth order, relative to the second: 4
