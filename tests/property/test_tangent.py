"""The tangent is the derivative of the residual, with the symmetry of the mechanics."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.input.scene_files import load_scene

SCENES = {
    "example1": load_scene("example1"),
    "example2": load_scene("example2"),   # springs, wind, eccentric ice, damping
    "example3": load_scene("example3"),
    "zebra": load_scene("zebra"),
    "inclined": load_scene("example2").with_values(
        {"span.height_difference": 20.0, "span.sag": None, "wind.speed": 9.0}
    ),
}  # fmt: skip
MODELS = {
    name: Model(scene.with_values({"numerics.elements": 5})) for name, scene in SCENES.items()
}
CALM = {name: Model(model.scene.with_values({"wind.speed": 0.0})) for name, model in MODELS.items()}
PARTS = ("stiffness", "damping", "mass")
SEEDS = st.integers(0, 2**32 - 1)
FEW = settings(max_examples=6)

# Sixth-order central difference: exact for the cubic structural forces at any step, so the step can
# be large enough to keep round-off away.
OFFSETS, WEIGHTS = (-3, -2, -1, 1, 2, 3), (-1 / 60, 9 / 60, -45 / 60, 45 / 60, -9 / 60, 1 / 60)
STEP = 0.02


def motion(model, seed):
    """A random u, v, a in which every term matters; attack angles are inside the curve."""
    random = np.random.default_rng(seed)
    sizes = ([0.1, 0.5, 0.5, 0.3], [0.1, 0.5, 0.5, 0.5], [1.0, 5.0, 5.0, 30.0])
    return [random.uniform(-1.0, 1.0, (model.nodes, 4)) * size for size in sizes]


def assembled(model, uva, part):
    elements = model.tangent(*uva, time=0.7, **{part: 1.0})
    size = 4 * model.nodes
    whole = np.zeros((size, size))
    for e, block in enumerate(elements):
        whole[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += block
    return whole


def differenced(model, uva, part, direction):
    which, total = PARTS.index(part), 0.0
    for offset, weight in zip(OFFSETS, WEIGHTS, strict=True):
        moved = [y.copy() for y in uva]
        moved[which] += offset * STEP * direction
        total = total + weight / STEP * model.residual(*moved, time=0.7)
    return total


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", MODELS)
@FEW
@given(seed=SEEDS)
def test_tangent_is_the_derivative_of_the_residual(name, part, seed):
    """Each kind of unknown is moved separately; each kind of force has its own scale."""
    model, random = MODELS[name], np.random.default_rng(seed)
    uva = motion(model, seed)
    tangent = assembled(model, uva, part)
    forces = np.abs(model.residual(*uva, time=0.7)).max()
    for unknown in range(4):
        direction = np.zeros((model.nodes, 4))
        direction[:, unknown] = random.uniform(-1.0, 1.0, model.nodes)
        expected = differenced(model, uva, part, direction)
        found = (tangent @ direction.ravel()).reshape(-1, 4)
        for force in range(4):
            scale = np.abs(expected[:, force]).max()
            error = np.abs(found - expected)[:, force].max()
            round_off = 3e-16 * forces / STEP
            assert error < 1e-7 * scale + round_off  # observed 0.24 of it


@pytest.mark.parametrize("name", CALM)
@FEW
@given(seed=SEEDS)
def test_symmetry_without_wind(name, seed):
    """Mass always; structural damping always; stiffness where no eccentric ice is accelerated."""
    model = CALM[name]
    u, v, a = motion(model, seed)
    still = np.zeros_like(u)
    for part, uva in (
        ("mass", (u, v, a)),
        ("damping", (u, still, a)),
        ("stiffness", (u, still, still)),
    ):
        matrix = assembled(model, uva, part)
        assert np.abs(matrix - matrix.T).max() <= 1e-15 * np.abs(matrix).max()  # observed 0


@pytest.mark.parametrize("name", CALM)
@FEW
@given(seed=SEEDS)
def test_mass_is_positive_definite(name, seed):
    """Independent of units, as the matrix is scaled to a unit diagonal."""
    model = CALM[name]
    mass = assembled(model, motion(model, seed), "mass")
    scale = 1.0 / np.sqrt(np.diag(mass))
    assert np.linalg.eigvalsh(mass * np.outer(scale, scale)).min() > 0.25  # observed 0.41


@pytest.mark.parametrize("name", CALM)
def test_mass_of_a_translation_is_the_whole_mass(name):
    model = CALM[name]
    mass = assembled(model, motion(model, 1), "mass")
    for axis in range(3):
        shift = np.zeros((model.nodes, 4))
        shift[:, axis] = 1.0
        total = (
            model.scene.conductor.mass_per_length + model.scene.ice.mass_per_length
        ) * model.equilibrium().length
        assert shift.ravel() @ mass @ shift.ravel() == pytest.approx(total, rel=1e-13)


@pytest.mark.parametrize("name", CALM)
@FEW
@given(shift=st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_rigid_translation_causes_no_force(name, shift):
    model = CALM[name]
    u = np.zeros((model.nodes, 4))
    u[:, :3] = shift
    tension = np.abs(model.equilibrium().horizontal_tension)
    change = np.abs(model.residual(u) - model.residual())
    assert change.max() < 2e-11 * tension  # observed 2e-12


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


@pytest.mark.parametrize("name", CALM)
@FEW
@given(
    axis=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    angle=st.floats(-3.1, 3.1),
)
def test_rigid_rotation_rotates_the_internal_force(name, axis, angle):
    """The constant forces C keep their direction, the internal forces rotate: (Q - 1) C remains."""
    model = CALM[name]
    x = model.equilibrium().x

    def turned(q):
        u = np.zeros((model.nodes, 4))
        u[:, :3] = x @ (q - np.eye(3)).T
        return model.residual(u)[:, :3] - model.residual()[:, :3]

    half_turn_1, half_turn_2 = (
        turned(np.diag([1.0, -1.0, -1.0])),
        turned(np.diag([-1.0, 1.0, -1.0])),
    )
    constant = -0.5 * np.column_stack([half_turn_2[:, 0], half_turn_1[:, 1], half_turn_1[:, 2]])
    q = rotation(axis, angle)
    tension = model.equilibrium().horizontal_tension
    assert (
        np.abs(turned(q) - constant @ (q - np.eye(3)).T).max() < 2e-10 * tension
    )  # observed 2e-11


def test_inputs_replace_the_laws_in_the_residual():
    model = MODELS["example3"]
    u, v, a = motion(model, 3)
    same = Inputs(
        0.7,
        model.scene.wind.mean_speed,
        np.radians(model.scene.ice.attack_angle_deg),
        np.zeros((2, 3)),
    )
    assert np.array_equal(
        model.residual(u, v, a, inputs=same, time=0.7), model.residual(u, v, a, time=0.7)
    )
    growing = Inputs(0.2, 1.0, same.attack_angle, np.zeros((2, 3)), wind_speed_rate=9.0)
    np.testing.assert_allclose(
        model.residual(u, v, a, inputs=growing, time=0.7),
        model.residual(u, v, a, time=0.7),
        rtol=0,
        atol=1e-9,
    )
