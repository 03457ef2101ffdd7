"""The linear model against the kernel's tangents, the nonlinear simulation and itself."""

import control
import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.linalg

import gallop_fmu as gf
import modal
from modal.linear.state_space import INPUTS, OUTPUTS

SPRINGS = {"kind": "springs", "stiffness_x1": 76e3, "stiffness_x3": 1400.0}
U2, U3, THETA = 1, 2, 3


@pytest.fixture(scope="module")
def scene():
    """One rigid and one sprung end, eccentric ice, wind: everything that enters the matrices."""
    return gf.load_scene("example3").with_values(
        {
            "supports.right": SPRINGS,
            "initial.wind": "mean_wind_equilibrium",
            "numerics.time_step": 0.005,
        }
    )


@pytest.fixture(scope="module")
def model(scene):
    return modal.linear_model(scene)


def matrices_of(scene):
    """Mass, damping and stiffness of all unknowns, assembled here, and which of them are free."""
    span = gf.Model(scene)
    u = span.rest().motion()[0]
    free = np.ones((span.nodes, 4), dtype=bool)
    free[0] = False
    free[-1, [1, 3]] = False
    size = 4 * span.nodes
    matrices = []
    for part in ("mass", "damping", "stiffness"):
        total = np.zeros((size, size))
        for e, element in enumerate(span.tangent(u, **{part: 1.0})):
            total[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += element
        matrices.append(total)
    matrices[2][size - 4, size - 4] += SPRINGS["stiffness_x1"]
    matrices[2][size - 2, size - 2] += SPRINGS["stiffness_x3"]
    return matrices, free.ravel()


def eigenvalues_of_the_tangents(scene):
    """Eigenvalues of the generalised problem."""
    matrices, free = matrices_of(scene)
    mass, damping, stiffness = (part[free][:, free] for part in matrices)
    n = len(mass)
    left = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])
    return scipy.linalg.eigvals(left, scipy.linalg.block_diag(np.eye(n), mass))


def test_poles_are_the_eigenvalues_of_the_tangents(scene, model):
    expected, poles = eigenvalues_of_the_tangents(scene), model.poles()
    assert len(poles) == len(expected) == 236
    distance = np.abs(poles[:, None] - expected[None, :]).min(axis=1) / np.abs(poles)
    assert distance.max() < 1e-8  # observed 2.7e-9


@pytest.mark.parametrize("omega", [0.5, 4.2, 60.0])
def test_response_to_a_support_is_that_of_the_dynamic_stiffness(scene, omega):
    coarse = scene.with_values(
        {"numerics.elements": 8}
    )  # a support's inertia reaches further on a coarse mesh
    matrices, free = matrices_of(coarse)
    mass, damping, stiffness = matrices
    dynamic = -(omega**2) * mass + 1j * omega * damping + stiffness
    prescribed = [0, 1, 2]  # the left end
    expected = np.linalg.solve(dynamic[free][:, free], -dynamic[free][:, prescribed])
    at = np.searchsorted(np.flatnonzero(free), 4 * 8 + np.arange(4))
    model = modal.linear_model(coarse)
    outputs, inputs = list(OUTPUTS[:4]), [f"support_left_x{i}" for i in (1, 2, 3)]
    assert model[outputs, inputs](1j * omega) == pytest.approx(
        expected[at], rel=1e-9, abs=1e-9
    )  # observed 2.4e-10


def test_names(model):
    assert tuple(model.input_labels) == INPUTS
    assert tuple(model.output_labels) == OUTPUTS
    assert model.state_labels[0] == "u1_node1"
    assert model.state_labels[-1] == "v3_node30"


def simulated(scene, until=20.0):
    """Mid-span u1, u2, u3, theta about the equilibrium."""
    data = gf.simulate(scene, until).midspan()
    rest = gf.Model(scene).rest().motion()[0][15]
    return data.time.values, np.array(
        [data[name].values for name in ("u1", "u2", "u3", "theta")]
    ) - rest[:, None]


def differs(linear, nonlinear):
    """Root mean square of the difference, as a part of that of the motion."""
    return float(np.sqrt(np.mean((linear - nonlinear) ** 2) / np.mean(nonlinear**2)))


def test_free_motion_is_that_of_a_small_simulated_one(scene, model):
    start = {
        "initial.seed_vertical": 1e-4,
        "initial.seed_horizontal": 1e-4,
        "initial.seed_twist": 1e-4,
    }
    time, nonlinear = simulated(scene.with_values(start))
    x1 = gf.Model(scene).equilibrium().x[:, 0]
    shape = 1e-4 * np.cos(np.pi * (x1 / scene.span.length - 0.5))
    q = np.outer(shape, [0.0, 1.0, 1.0, 1.0])
    names = {
        f"{u}_node{k}": q[k, i]
        for i, u in enumerate(("u1", "u2", "u3", "theta"))
        for k in range(len(q))
    }
    state = np.array([names.get(name, 0.0) for name in model.state_labels])
    linear = control.initial_response(model, time, state).outputs[:4]
    # observed 7.8e-4, 2.1e-4, and 8.4e-3 for the fast twist: the period error of Newmark's method
    for which, bound in ((U2, 1.2e-3), (U3, 4e-4), (THETA, 0.01)):
        assert differs(linear[which], nonlinear[which]) < bound


@pytest.mark.parametrize(
    ("signal", "path", "mean", "size"),
    [
        ("wind_speed", "wind.history", 5.5, 1e-3),
        ("support_left_x1", "supports.left.motion.x1", 0.0, 1e-5),
        ("support_left_x2", "supports.left.motion.x2", 0.0, 1e-4),
        ("support_left_x3", "supports.left.motion.x3", 0.0, 1e-4),
        ("support_right_x1", "supports.right.motion.x1", 0.0, 1e-5),
        ("support_right_x2", "supports.right.motion.x2", 0.0, 1e-4),
        ("support_right_x3", "supports.right.motion.x3", 0.0, 1e-4),
    ],
)
def test_response_to_an_input_is_the_simulated_one(scene, model, signal, path, mean, size):
    law = {"kind": "ramp", "initial": mean, "final": mean + size, "start": 0.5, "duration": 1.0}
    changed = scene.with_values(
        {"wind.speed": None, path: law} if path == "wind.history" else {path: law}
    )
    changed = changed.with_values({"initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0})
    time, nonlinear = simulated(changed)
    x = np.clip((time - 0.5) / 1.0, 0.0, 1.0)
    drive = size * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    linear = control.forced_response(model[list(OUTPUTS[:4]), signal], time, drive).outputs
    largest = int(np.argmax(np.abs(nonlinear[1:3]).max(axis=1))) + 1
    assert differs(linear[largest], nonlinear[largest]) < 1.2e-3  # observed 1.4e-4 to 7.4e-4


def test_static_response_to_the_attack_angle_is_that_of_the_equilibrium(scene, model):
    middle = [
        gf.Model(scene.with_values({"ice.attack_angle_deg": a})).rest().motion()[0][15]
        for a in (179.9, 180.1)
    ]
    slope = (middle[1] - middle[0]) / np.radians(0.2)
    gain = model.dcgain()[:4, INPUTS.index("attack_angle")]
    assert gain[1:] == pytest.approx(slope[1:], rel=4e-6)  # observed 1.8e-6


def test_truncation_keeps_poles_and_static_gain(model, scene):
    small = modal.linear_model(scene, modes=6)
    assert small.nstates == 12
    lowest = sorted((pole for pole in model.poles() if pole.imag > 0), key=abs)[:6]
    assert sorted((pole for pole in small.poles() if pole.imag > 0), key=abs) == pytest.approx(
        lowest, rel=1e-9
    )
    assert small.dcgain() == pytest.approx(model.dcgain(), rel=1e-8, abs=1e-8)
    at = 4.2j  # close to the first vertical mode
    for output in ("midspan_u2", "midspan_u3"):
        for source in ("wind_speed", "attack_angle"):
            assert small[output, source](at) == pytest.approx(
                model[output, source](at), rel=0.01
            )  # observed 0.0056


def test_the_locus_crosses_at_the_critical_wind_speed():
    scene = gf.load_scene("example3")
    vertical = next(
        c
        for c in modal.critical_wind_speed(scene, count=2, highest_wind=6.0)
        if c.mode.family == "vertical"
    )
    locus = modal.root_locus(
        scene, [0.0, 2.0, vertical.wind_speed - 1e-3, vertical.wind_speed + 1e-3], count=2
    )
    branch = locus.eigenvalue.values[list(locus.family.values).index("vertical")]
    assert branch.real[2] < 0.0 < branch.real[3]
    assert abs(branch[2].imag) == pytest.approx(2 * np.pi * vertical.frequency_hz, rel=1e-4)


def test_step_response_and_bode_are_python_controls(scene):
    calm = modal.linear_model(scene.with_values({"wind.speed": 2.0}), modes=6)[
        "midspan_u3", "wind_speed"
    ]
    step = control.step_response(calm, np.linspace(0.0, 300.0, 3001)).outputs
    assert step[-1] == pytest.approx(calm.dcgain(), rel=1e-3)
    omega = np.array([0.5, 2.0, 4.0])
    response = control.frequency_response(calm, omega)
    assert response.complex == pytest.approx(calm(1j * omega), rel=1e-12)
    poles = control.pole_zero_map(calm).poles
    assert np.sort_complex(poles) == pytest.approx(np.sort_complex(calm.poles()))


def test_the_peak_of_the_bode_plot_is_the_mode(scene):
    """In 2 m/s nothing grows; the peak of a lightly damped mode is at w sqrt(1 - 2 xi^2)."""
    calm = scene.with_values({"wind.speed": 2.0})
    omega = np.geomspace(3.0, 6.0, 4001)
    drawn = control.bode_plot(modal.linear_model(calm, modes=6)["midspan_u2", "wind_speed"], omega)
    magnitude = drawn.axes[0, 0].get_lines()[0]
    found = magnitude.get_xdata()[np.argmax(magnitude.get_ydata())]
    plt.close(drawn.figure)
    modes = modal.natural_modes(calm, 6, "mean")
    first = next(mode for mode in modes if mode.family == "vertical" and mode.symmetric)
    expected = 2.0 * np.pi * first.frequency_hz * np.sqrt(1.0 - 2.0 * first.damping_ratio**2)
    assert found == pytest.approx(expected, rel=3e-4)  # observed 3e-5, the lines are 1.7e-4 apart


def test_a_coarse_mesh_is_refused(scene):
    with pytest.raises(gf.SceneError, match=r"numerics\.elements = 4: .* set 8 or more"):
        modal.linear_model(scene.with_values({"numerics.elements": 4}))


@pytest.mark.parametrize("modes", [0, 119, 2.5, True])
def test_an_impossible_number_of_modes_is_named(scene, modes):
    with pytest.raises(gf.SceneError, match="modes = "):
        modal.linear_model(scene, modes)


@pytest.mark.parametrize("speeds", [[], [-1.0], [2.0, 1.0]])
def test_wind_speeds_in_disorder_are_refused(scene, speeds):
    with pytest.raises(gf.SceneError, match="increasing wind speeds"):
        modal.root_locus(scene, speeds)
