"""The finite elements as Python sees them, against formulas written down here."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.mesh import DOFS, Mesh, _pattern

SPRINGS = {"kind": "springs", "stiffness_x1": 76e3, "stiffness_x3": 1400.0}
SLOPE = {"span.height_difference": 30.0, "span.sag": None}
TABLE = {
    "kind": "table",
    "angle_deg": [100.0, 140.0, 180.0, 220.0, 260.0],
    "lift": [0.5, 2.0, 0.0, -2.0, -0.5],
    "drag": [1.5, 1.2, 1.0, 1.2, 1.5],
    "moment": [0.1, 0.2, 0.0, -0.2, -0.1],
}
LONG = np.longdouble
ROOT = np.sqrt(np.array([3.0, 1.0], LONG) / [5, 3])


def mesh(**values):
    values = {key.replace("__", "."): value for key, value in values.items()}
    scene = gf.load_scene("example3").with_values({"numerics.elements": 6, **values})
    return Mesh(gf.Model(scene))


@pytest.fixture(scope="module")
def sloping():
    return mesh(**SLOPE, supports__left=SPRINGS)


def shape(xi):
    """Quadratic shape functions (point, node), Liu et al. (2009), eq. (5)."""
    return np.stack([xi * (xi - 1) / 2, 1 - xi * xi, xi * (xi + 1) / 2], axis=-1)


def slope(xi):
    return np.stack([xi - LONG(0.5), -2 * xi, xi + LONG(0.5)], axis=-1)


def tangents(span, xi):
    """dX/dxi (point, 3) at abscissae of each element."""
    x = span.model.equilibrium().x.astype(LONG)
    elements = [x[2 * e : 2 * e + 3] for e in range(span.model.elements)]
    return np.concatenate([slope(xi) @ nodes for nodes in elements])


def test_sections_are_the_three_gauss_points_of_each_element(sloping):
    xi = np.array([-ROOT[0], LONG(0), ROOT[0]])
    along = tangents(sloping, xi)
    stretch = np.linalg.norm(along, axis=1)
    weight = np.tile(np.array([5, 8, 5], LONG) / 9, sloping.model.elements)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    found = sloping.sections
    assert found.shape == pytest.approx(shape(xi).astype(float), abs=1e-15)
    assert found.length == pytest.approx((weight * stretch).astype(float), rel=1e-15)
    assert found.normal == pytest.approx(normal.astype(float), abs=1e-15)
    length = sloping.model.equilibrium().length
    assert found.length.sum() == pytest.approx(length, rel=1e-9)


def test_strain_points_are_the_two_gauss_points_of_each_element(sloping):
    xi = np.array([-ROOT[1], ROOT[1]])
    along = tangents(sloping, xi)
    stretch = np.linalg.norm(along, axis=1)
    by_length = np.tile(slope(xi), (sloping.model.elements, 1)) / stretch[:, None]
    found = sloping.strain_points
    assert found.length == pytest.approx(stretch.astype(float), rel=1e-15)
    assert found.tangent == pytest.approx((along / stretch[:, None]).astype(float), abs=1e-15)
    assert found.shape_slope.reshape(-1, 3) == pytest.approx(by_length.astype(float), rel=4e-15)


def test_motion_is_interpolated_along_the_normal(sloping):
    nodal = np.random.default_rng(0).standard_normal((sloping.model.nodes, 4, 2))
    xi = np.array([-ROOT[0], LONG(0), ROOT[0]])
    u = np.concatenate(
        [np.einsum("pn,nik->pik", shape(xi), nodal[2 * e : 2 * e + 3]) for e in range(6)]
    )
    n1, n2 = sloping.sections.normal.T[:, :, None]
    expected = [n1 * u[:, 0] + n2 * u[:, 1], u[:, 2], u[:, 3]]
    assert sloping.sections.motion(nodal) == pytest.approx(np.array(expected, float), abs=1e-14)


def test_a_straight_motion_has_one_slope(sloping):
    """Where u is a multiple of X, du/dS is the same multiple of dX/dS."""
    x = sloping.model.equilibrium().x
    nodal = np.concatenate([0.1 * x, np.zeros((len(x), 1))], axis=1)
    points = sloping.strain_points
    assert points.slope(nodal)[:, :3] == pytest.approx(0.1 * points.tangent, abs=1e-14)


def test_normals_at_nodes_halve_the_kink_between_elements(sloping):
    x = sloping.model.equilibrium().x
    left, right = slope(np.array([LONG(1)])) @ x[2:5], slope(np.array([LONG(-1)])) @ x[4:7]
    mean = (left / np.linalg.norm(left) + right / np.linalg.norm(right))[0].astype(float)
    expected = np.array([-mean[1], mean[0]]) / np.hypot(mean[0], mean[1])
    assert sloping.node_normal[4] == pytest.approx(expected, abs=1e-15)


def test_ends_are_free_where_a_spring_holds_them(sloping):
    assert sloping.spring == pytest.approx(np.array([[76e3, 0.0, 1400.0], [0.0, 0.0, 0.0]]))
    prescribed = [list(place) for place in np.argwhere(~sloping.free)]
    assert prescribed == [[0, 1], [0, 3], [12, 0], [12, 1], [12, 2], [12, 3]]


def test_element_matrices_add_up_with_the_springs(sloping):
    u = 0.1 * np.random.default_rng(1).standard_normal((sloping.model.nodes, 4))
    expected = np.zeros((u.size, u.size))
    for e, block in enumerate(sloping.model.tangent(u, stiffness=2.0, inputs=sloping.still)):
        expected[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += block
    expected[0, 0] += 2.0 * 76e3
    expected[2, 2] += 2.0 * 1400.0
    found = sloping.tangent(u, stiffness=2.0, inputs=sloping.still).toarray()
    assert np.array_equal(found, expected)
    mass = sloping.tangent(mass=1.0, inputs=sloping.still).toarray()
    rigid = np.tile([0.0, 1.0, 0.0, 0.0], sloping.model.nodes)
    scene = sloping.model.scene
    per_length = scene.conductor.mass_per_length + scene.ice.mass_per_length
    whole = per_length * sloping.sections.length.sum()
    assert rigid @ mass @ rigid == pytest.approx(whole, rel=1e-14)


def cubic(curve, which, angle):
    """Coefficient and slope at angles within the curve, piece by piece."""
    value, rate = np.zeros_like(angle), np.zeros_like(angle)
    ends = curve.breakpoint
    for k, origin in enumerate(curve.origin):
        inside = (angle >= ends[k]) & (angle <= ends[k + 1])
        x, c = angle - LONG(origin), curve.coefficient[k, which].astype(LONG)
        value = np.where(inside, c[0] + c[1] * x + c[2] * x**2 + c[3] * x**3, value)
        rate = np.where(inside, c[1] + 2 * c[2] * x + 3 * c[3] * x**2, rate)
    return value, rate


def load_by_hand(scene, theta, v2, v3, omega, wind, radius):
    """Equations (20) and (21) of Liu et al. (2009) in extended precision."""
    d, rho = LONG(scene.conductor.diameter), LONG(scene.wind.air_density)
    w2, w3 = -v2 - radius * omega, wind - v3
    ur = np.hypot(w2, w3)
    alpha = LONG(np.radians(scene.ice.attack_angle_deg)) + theta + np.arctan2(w2, w3)
    curve = scene.aerodynamics.curve()
    cl, cd, cm = (cubic(curve, k, alpha)[0] for k in range(3))
    q = rho * d * ur / 2
    return np.array([q * (cl * w3 + cd * w2), q * (cd * w3 - cl * w2), q * ur * d * cm])


CURVES = {"polynomial": {}, "table": {"aerodynamics": TABLE}}


@pytest.mark.parametrize("values", CURVES.values(), ids=CURVES)
@pytest.mark.parametrize("radius", [None, 0.02])
def test_the_aerodynamic_load_is_that_of_the_paper(values, radius):
    """At more sections than the kernel computes at once, with a wind of its own at each."""
    span = mesh(**values)
    if radius is not None:
        span = mesh(**values | {"aerodynamics.reference_radius": radius})
    scene, draw = span.model.scene, np.random.default_rng(2)
    motion = (
        draw.uniform(-1.0, 1.0, (5, 2, 75)) * np.array([0.4, 2.0, 2.0, 8.0, 2.0])[:, None, None]
    )
    motion[4] += 6.0
    r = 0.5 * scene.conductor.diameter if radius is None else radius
    expected = load_by_hand(scene, *motion.astype(LONG), LONG(r))
    found = span.aero_load(*motion, slopes=True)
    bound = 2e-15 * np.abs(expected).max(axis=(1, 2))[:, None, None]
    assert np.all(np.abs(found.force - expected) < bound)  # observed up to 8e-16
    step = LONG(1e-6)
    for k in range(4):
        ahead, back = (
            load_by_hand(scene, *(motion + side * step * np.eye(5)[k][:, None, None]), LONG(r))
            for side in (1, -1)
        )
        by = (ahead - back) / (2 * step)
        near = np.abs(found.slopes[k] - by) < 1e-9 * np.abs(by).max(axis=(1, 2))[:, None, None]
        assert np.mean(near) > 0.99  # a difference across a breakpoint of the table is off
    w2, w3 = -motion[1] - r * motion[3], motion[4] - motion[2]
    alpha = np.radians(scene.ice.attack_angle_deg) + motion[0] + np.arctan2(w2, w3)
    assert found.angle == pytest.approx(alpha, abs=2e-15)
    assert np.all(found.excess == 0.0)


def test_the_load_adds_up_to_that_of_the_residual(sloping):
    """The virtual work of the load on the sections is the nodal force of the wind."""
    u, v = 0.1 * np.random.default_rng(3).standard_normal((2, sloping.model.nodes, 4))
    u[:, :3] = 0.0  # the difference of two residuals without the round-off of large tensions
    calm, blowing = sloping.still, gf.Inputs(0.0, 5.5, sloping.still.attack_angle, np.zeros((2, 3)))
    nodal = sloping.model.residual(u, v, inputs=calm) - sloping.model.residual(u, v, inputs=blowing)
    at_u, at_v = sloping.sections.motion(u), sloping.sections.motion(v)
    found = sloping.aero_load(at_u[2], at_v[0], at_v[1], at_v[2], 5.5)
    virtual = np.random.default_rng(4).standard_normal((sloping.model.nodes, 4))
    work = np.sum(sloping.sections.length * found.force * sloping.sections.motion(virtual))
    assert work == pytest.approx(np.vdot(virtual, nodal), rel=1e-11)


def test_angles_beyond_the_curve_are_counted_as_in_a_simulation():
    """Example 3 is valid from 100 to 260 deg, about an attack angle of 180 deg."""
    turns = np.radians([0.0, 90.0, -90.0, 360.0 + 90.0])
    expected = np.radians([0.0, 10.0, -10.0, 10.0])
    held, free = mesh(), mesh(aerodynamics__outside="hold")
    found = held.aero_load(turns, 0.0, 0.0, 0.0, 5.0)
    assert found.excess == pytest.approx(expected, abs=1e-14)
    assert found.angle == pytest.approx(np.pi + turns, abs=1e-14)
    assert np.all(free.aero_load(turns, 0.0, 0.0, 0.0, 5.0).excess == 0.0)
    assert np.all(held.aero_load(turns, 0.0, 0.0, 0.0, 1e-4).excess == 0.0)  # too weak to matter


def test_there_is_no_load_in_still_air_and_none_without_a_curve():
    span = mesh()
    found = span.aero_load(0.1, [1.0, 1.0], 2.0, 0.3, [0.0, 5.0], slopes=True)
    assert np.all(found.force[:, 0] == 0.0)
    assert np.all(found.slopes[:, :, 0] == 0.0)
    assert np.all(found.force[:, 1] != 0.0)
    bare = mesh(aerodynamics=None, wind__speed=None)
    found = bare.aero_load(0.1, 1.0, 2.0, 0.3, 5.0, slopes=True)
    assert found.force.shape == (3,)
    assert np.all(found.force == 0.0)
    assert np.all(found.slopes == 0.0)
    radius = 0.5 * bare.model.scene.conductor.diameter
    assert found.angle == pytest.approx(np.pi + 0.1 + np.arctan2(-1.0 - 0.3 * radius, 3.0))


def test_numbers_that_are_not_finite_are_refused():
    span = mesh()
    with pytest.raises(ValueError, match=r"motion must be finite; motion\[1, 2\] is nan"):
        span.aero_load(0.0, [0.0, 0.0, np.nan], 0.0, 0.0, 5.0)
    with pytest.raises(ValueError, match="attack_angle = inf must be finite"):
        span.aero_load(0.0, 0.0, 0.0, 0.0, 5.0, attack_angle=np.inf)
    assert span.aero_load([], 0.0, 0.0, 0.0, 5.0).force.shape == (3, 0)


def test_the_seed_is_half_a_wave_between_the_ends(sloping):
    """Liu et al. (2009) start from cos(pi x1/L) with x1 from mid-span."""
    seeds = {
        "initial.seed_vertical": 3.0,
        "initial.seed_horizontal": 0.2,
        "initial.seed_twist": 0.1,
    }
    scene = sloping.model.scene.with_values(seeds)
    x = sloping.model.equilibrium().x[:, 0] - 0.5 * scene.span.length
    expected = np.outer(np.cos(np.pi * x / scene.span.length), [0.0, 3.0, 0.2, 0.1])
    assert Mesh(gf.Model(scene)).seed() == pytest.approx(expected, abs=1e-14)
    calm = scene.with_values({"wind.speed": 0.0, "initial.seed_vertical": 0.01})
    started = gf.Model(calm).start().motion()[0]
    assert np.array_equal(Mesh(gf.Model(calm)).seed(), started)


def loaded_line():
    """Two spans of twin bundles with a yoke, spacers, a dead-end string and a pendulum."""
    scene = gf.LineScene.from_dict(
        {
            "title": "line",
            "section": {
                "horizontal_tension": 20e3,
                "spans": [{"length": 200.0}, {"length": 150.0, "height_difference": 8.0}],
                "suspensions": [
                    {"kind": "string", "length": 2.0, "weight": 400.0, "damping": 50.0}
                ],
                "right_end": {"kind": "springs", "stiffness_x1": 3e5, "stiffness_x3": 4e3},
            },
            "bundle": {
                "subconductors": 2,
                "spacing": 0.4,
                "spacers": 1,
                "spacer_mass": 3.0,
                "clamp_damping": 5.0,
                "yoke_mass": 8.0,
            },
            "conductor": {
                "diameter": 0.03,
                "mass_per_length": 1.6,
                "axial_stiffness": 30e6,
                "torsional_stiffness": 200.0,
                "torsional_inertia": 3e-4,
            },
            "devices": [{"kind": "pendulum", "span": 2, "station": 0.3, "mass": 10.0, "arm": 0.4}],
            "damping": {
                "translation": {
                    "low_ratio": 0.01,
                    "low_frequency": 0.3,
                    "high_ratio": 0.02,
                    "high_frequency": 2.0,
                }
            },
            "numerics": {"elements": 4},
        }
    )
    return Mesh(gf.Model(scene))


@pytest.mark.parametrize("part", ["stiffness", "damping", "mass"])
def test_matrices_of_a_line_are_the_derivatives_of_all_forces(part):
    """Elements and devices together, with forces on followers at their leaders."""
    line = loaded_line()
    model, random = line.model, np.random.default_rng(3)
    followers = line.leader != np.arange(model.nodes)
    assert followers.any()
    assert not line.free[followers].any()

    def forces(motion):
        total = model.residual(*motion, inputs=line.still)
        node = line.model.junction_nodes()[0]
        for device, junctions in enumerate(model.devices):
            total[node[list(junctions)]] += model.device_force(device, *motion, inputs=line.still)[
                0
            ]
        gathered = np.zeros_like(total)
        np.add.at(gathered, line.leader, total)
        return gathered

    scale = [0.02, 0.02, 0.02, 0.02]
    motion = [line.spread(random.standard_normal((model.nodes, 4)) * scale) for _ in range(3)]
    change = line.spread(random.standard_normal((model.nodes, 4)) * line.free)
    k, step = ["stiffness", "damping", "mass"].index(part), 1e-6
    ahead, back = (
        forces([y + side * step * change if i == k else y for i, y in enumerate(motion)])
        for side in (1.0, -1.0)
    )
    matrix = line.tangent(*motion, **{part: 1.0}, inputs=line.still)
    found = matrix @ (change * (line.leader == np.arange(model.nodes))[:, None]).ravel()
    wanted = ((ahead - back) / (2.0 * step)).ravel()
    assert found == pytest.approx(wanted, abs=1e-6 * np.abs(wanted).max())
    rows = np.repeat(followers, 4)
    assert np.abs(matrix[rows]).sum() == 0.0


def test_an_assembled_matrix_is_the_sum_of_its_elements(sloping):
    elements = np.random.default_rng(1).normal(size=(6, 12, 12))
    total = np.zeros((DOFS * sloping.model.nodes,) * 2)
    for e, matrix in enumerate(elements):
        total[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += matrix
    assert np.array_equal(sloping.assemble(elements).toarray(), total)


def test_meshes_of_equal_topology_share_the_pattern_of_their_matrices():
    _pattern.cache_clear()
    for length in (120.0, 121.0, 122.0):
        span = mesh(span__length=length, span__sag=None)
        span.assemble(np.ones((6, 12, 12)))
    assert (_pattern.cache_info().misses, _pattern.cache_info().hits) == (1, 2)


def test_dense_matrices_are_the_sparse_ones(sloping):
    for found in (sloping, loaded_line()):
        u = 1e-2 * np.random.default_rng(3).normal(size=(found.model.nodes, 4))
        for given in ({"stiffness": 1.0}, {"stiffness": 1.0, "mass": -2.0, "u": u}):
            expected = found.tangent(inputs=found.still, **given).toarray()
            assert np.array_equal(found.dense_tangent(**given), expected)
