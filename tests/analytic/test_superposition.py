"""Mode superposition against the kernel's loads and tangents, exact solutions, and its order."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gallop_fmu as gf
import modal
from modal.superposition.comparison import running_amplitude
from modal.superposition.modal_model import ModalModel
from modal.superposition.mode_superposition import linear_motion, nonlinear_motion, propagators

TABLE = {
    "kind": "table",
    "angle_deg": [0.0, 60.0, 130.0, 180.0, 240.0, 300.0, 360.0],
    "lift": [0.1, 0.9, 0.8, 0.0, -0.9, -0.4, 0.1],
    "drag": [1.0, 1.2, 1.4, 1.1, 1.3, 1.0, 1.0],
    "moment": [0.1, -0.1, 0.05, 0.02, -0.04, 0.2, 0.1],
    "outside": "periodic",
    "reference_radius": 0.02,
}


def example3(**values):
    return gf.load_scene("example3").with_values(
        {key.replace("__", "."): value for key, value in values.items()}
    )


def some_modes(scene, vertical=3, horizontal=3, torsional=3):
    return ModalModel.of(scene, vertical=vertical, horizontal=horizontal, torsional=torsional)


def inputs(span, speed):
    return gf.Inputs(0.0, speed, math.radians(span.scene.ice.attack_angle_deg), np.zeros((2, 3)))


@pytest.mark.parametrize(
    "curve", [None, TABLE, TABLE | {"outside": "hold"}], ids=["polynomial", "periodic", "hold"]
)
def test_the_wind_load_is_that_of_the_simulation(curve):
    span = some_modes(example3() if curve is None else example3(aerodynamics=curve))
    random = np.random.default_rng(4)
    for scale in (0.1, 1.0, 10.0):
        q, rate = scale * random.standard_normal((2, len(span.modes)))
        if curve is None:
            q, rate = 0.1 * q, 0.1 * rate  # stays on the curve
        u, v = span.shapes @ q, span.shapes @ rate
        by_kernel = span.mesh.model.residual(
            u, v, inputs=inputs(span, 0.0)
        ) - span.mesh.model.residual(u, v, inputs=inputs(span, 6.0))
        wanted = np.einsum("nim,ni->m", span.shapes, by_kernel)
        found = span.wind_load(np.concatenate([q, rate]), 6.0).force
        assert np.abs(found - wanted).max() < 1e-11 * np.abs(wanted).max()  # observed 7e-13
    assert span.wind_load(np.concatenate([q, rate]), 0.0).force == pytest.approx(
        0.0, abs=0.0
    )  # still air


def test_the_attack_angle_in_weak_wind_is_not_judged():
    """A ramp from calm once ended at once: the span's own motion rotates a wind of nearly zero."""
    ramp = {"kind": "ramp", "initial": 0.0, "final": 5.5, "duration": 5.0}
    runs = [
        nonlinear_motion(
            some_modes(
                example3(wind__speed=None, wind__history=ramp, aerodynamics__outside=outside)
            ),
            stop_time=6.0,
        )
        for outside in ("error", "hold")
    ]
    assert all(run.report.outcome is gf.Outcome.COMPLETED for run in runs)
    assert np.array_equal(*(run.dataset["u2"].values for run in runs))


def test_the_slopes_are_derivatives_of_the_wind_load():
    span = some_modes(example3())
    count = len(span.modes)
    rest = np.concatenate([span.equilibrium(5.5), np.zeros(count)])
    step = 1e-6
    differences = np.array(
        [
            (
                span.wind_load(rest + step * e, 5.5).force
                - span.wind_load(rest - step * e, 5.5).force
            )
            / (2.0 * step)
            for e in np.eye(2 * count)
        ]
    ).T
    slopes = np.hstack(span.wind_slopes(rest[:count], 5.5))
    assert np.abs(slopes - differences).max() < 1e-8 * np.abs(slopes).max()  # observed 2e-10


def test_modes_without_wind_have_the_scenes_damping():
    """The ratios at their own frequencies; the ice is centred, as else the families are coupled."""
    scene = example3(ice__first_moment_x2=0.0, ice__first_moment_x3=0.0)
    span = some_modes(scene)
    frequency = np.sqrt(span.squares) / (2.0 * np.pi)
    ratio = np.diag(span.damping) / (2.0 * np.sqrt(span.squares))
    for family, given, at in (
        ("horizontal", 0.016, 0.378),
        ("vertical", 0.016, 0.695),
        ("torsional", 0.057, 3.93),
    ):
        first = next(k for k, mode in enumerate(span.modes) if mode.family == family)
        assert frequency[first] == pytest.approx(at, rel=2e-3)
        assert ratio[first] == pytest.approx(given, rel=2e-3)


def test_a_step_is_exact_under_a_load_that_is_a_parabola():
    """A damped oscillator under f = 1 - 2 t + 3 t^2, against its closed form."""
    square, damping, step = 9.0, 0.3, 0.4
    matrix = np.array([[0.0, 1.0], [-square, -damping]])
    transition, constant, linear, parabolic = propagators(matrix, step)
    c = 3.0 / square
    b = (-2.0 - damping * 2.0 * c) / square
    a = (1.0 - damping * b - 2.0 * c) / square  # a + b t + c t^2 is a particular solution
    start = np.array([0.7, -0.2])
    decay, turn = damping / 2.0, math.sqrt(square - damping**2 / 4.0)
    x0, v0 = start[0] - a, start[1] - b
    free = math.exp(-decay * step) * (
        x0 * math.cos(turn * step) + (v0 + decay * x0) / turn * math.sin(turn * step)
    )
    found = (
        transition @ start + constant @ [1.0] + linear @ [-2.0 * step] + parabolic @ [3.0 * step**2]
    )
    assert found[0] == pytest.approx(free + a + b * step + c * step**2, rel=1e-13)


def test_the_error_falls_with_the_third_power_of_the_step():
    scene = example3(initial__seed_vertical=0.4, initial__seed_horizontal=0.1, wind__speed=8.0)

    def last(step):
        values = {"numerics.time_step": step}
        data = modal.mode_superposition(
            scene.with_values(values), 8.0, vertical=1, horizontal=1, torsional=1
        ).midspan()
        return np.array([data[name].values[-1] for name in ("u2", "u3", "theta")])

    exact = last(0.00125)
    coarse, middle, fine = (np.linalg.norm(last(step) - exact) for step in (0.04, 0.02, 0.01))
    assert 2.7 < math.log2(coarse / middle) < 3.3  # observed 2.79
    assert 2.85 < math.log2(middle / fine) < 3.15  # observed 2.96


def test_one_mode_in_each_direction_against_a_solver_of_ordinary_differential_equations():
    """Three equations with their own integrals over the span; scipy's Runge-Kutta of order 8."""
    scene = example3(
        ice__first_moment_x2=0.0,
        ice__first_moment_x3=0.0,
        initial__seed_vertical=0.4,
        initial__seed_horizontal=0.1,
    )
    modes, families = modal.natural_modes(scene, 24), ("vertical", "horizontal", "torsional")
    shapes = {family: next(mode for mode in modes if mode.family == family) for family in families}
    model = gf.Model(scene)
    equilibrium = model.equilibrium()
    points, weights = np.polynomial.legendre.leggauss(6)
    shape = np.stack([points * (points - 1) / 2, 1 - points**2, points * (points + 1) / 2], axis=1)
    slope = np.stack([points - 0.5, -2 * points, points + 0.5], axis=1)
    nodes = 2 * np.arange(model.elements)[:, None] + np.arange(3)
    tangent = np.einsum("qn,enk->eqk", slope, equilibrium.x[nodes]).reshape(-1, 3)
    length = np.tile(weights, model.elements) * np.linalg.norm(tangent, axis=1)
    normal = tangent[:, :2][:, ::-1] * [-1.0, 1.0] / np.linalg.norm(tangent, axis=1)[:, None]
    x, y = (
        np.einsum("qn,en->eq", shape, shapes["vertical"].shape[nodes, k]).ravel() for k in (0, 1)
    )
    y = normal[:, 0] * x + normal[:, 1] * y  # across the conductor
    z, t = (
        np.einsum("qn,en->eq", shape, shapes[family].shape[nodes, k]).ravel()
        for k, family in ((2, "horizontal"), (3, "torsional"))
    )
    squares = np.array([(2 * np.pi * mode.frequency_hz) ** 2 for mode in shapes.values()])
    (b1, b2), (t1, t2) = equilibrium.translation_damping, equilibrium.twist_damping
    damping = np.array([b1, b1, t1]) + np.array([b2, b2, t2]) * squares
    d, rho, speed = scene.conductor.diameter, scene.wind.air_density, 5.5
    lift, drag, moment = (
        np.polynomial.Polynomial(getattr(scene.aerodynamics, n)) for n in ("lift", "drag", "moment")
    )

    def rates(_, state):
        q, v = state[:3], state[3:]
        w2, w3 = -(y * v[0] + d / 2 * t * v[2]), speed - z * v[1]
        a = t * q[2] + np.arctan2(w2, w3)  # from 180 degrees, where the powers count from
        half = 0.5 * rho * d * np.hypot(w2, w3)
        force = [
            length @ (y * half * (lift(a) * w3 + drag(a) * w2)),
            length @ (z * half * (drag(a) * w3 - lift(a) * w2)),
            length @ (t * half * np.hypot(w2, w3) * d * moment(a)),
        ]
        return np.concatenate([v, force - damping * v - squares * q])

    wave = np.sin(np.pi * equilibrium.x[:, 0] / scene.span.length)
    seed = np.outer(wave, [0.0, 0.4, 0.1, 0.0])
    mass = np.einsum("eij,ej->ei", model.tangent(mass=1.0), seed[nodes].reshape(-1, 12))
    start = [np.sum(mode.shape[nodes].reshape(-1, 12) * mass) for mode in shapes.values()]
    stop = 20.0
    exact = solve_ivp(
        rates, (0.0, stop), [*start, 0, 0, 0], "DOP853", rtol=1e-10, atol=1e-12, dense_output=True
    )
    result = modal.mode_superposition(
        scene.with_values({"numerics.time_step": 0.005}),
        stop,
        vertical=1,
        horizontal=1,
        torsional=1,
        record_every=20,
    )
    data, q = result.midspan(), exact.sol(result.dataset.time.values)[:3]
    for k, (name, mode) in enumerate(zip(("u2", "u3", "theta"), shapes.values(), strict=True)):
        wanted = q[k] * mode.shape[model.middle, k + 1]
        error = np.abs(data[name].values - wanted).max() / np.ptp(wanted)
        assert error < 3e-6, name  # observed 3e-7, 4e-7, 1.1e-6


def growth_by_finite_elements(scene, speed, u):
    """Eigenvalue with the largest real part of the full model about the displacement u."""
    model = gf.Model(scene)
    size = 4 * model.nodes
    unknown = 8 * np.arange(model.elements)[:, None] + np.arange(12)
    blowing = gf.Inputs(0.0, speed, math.radians(scene.ice.attack_angle_deg), np.zeros((2, 3)))

    def assembled(**part):
        total = np.zeros((size, size))
        for places, block in zip(unknown, model.tangent(u, inputs=blowing, **part), strict=True):
            total[np.ix_(places, places)] += block
        return total

    mass, damping, stiffness = assembled(mass=1.0), assembled(damping=1.0), assembled(stiffness=1.0)
    free = np.ones((model.nodes, 4), dtype=bool)
    for end, springs in zip((0, -1), model.equilibrium().support_stiffness, strict=True):
        free[end] = [springs[0] > 0.0, False, springs[1] > 0.0, False]
        at = 4 * (model.nodes - 1) if end else 0
        stiffness[[at, at + 2], [at, at + 2]] += springs
    kept = np.ix_(free.ravel(), free.ravel())
    mass, damping, stiffness = mass[kept], damping[kept], stiffness[kept]
    below = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    values = np.linalg.eigvals(
        np.vstack([np.hstack([np.zeros_like(mass), np.eye(len(mass))]), below])
    )
    return values[values.real.argmax()]


@pytest.mark.parametrize("name", ["example2", "example3"])
def test_small_motion_grows_as_in_the_full_model(name):
    scene = gf.load_scene(name)
    speed = scene.wind.mean_speed
    span = some_modes(scene, 5, 5, 5)
    values = np.linalg.eigvals(span.linear_system(speed)[0])
    fastest = values[values.real.argmax()]
    model = gf.Model(scene)
    full = growth_by_finite_elements(scene, speed, model.rest().motion()[0])
    assert fastest.real == pytest.approx(
        full.real, rel=0.01
    )  # observed -0.24 %, 0.92 %: the span blown aside
    assert abs(fastest.imag) == pytest.approx(abs(full.imag), rel=2e-3)  # observed 1.0e-3, 2.9e-4
    hanging = span.shapes @ span.equilibrium(speed)
    hanging[:, :3] = (
        0.0  # the twist counts for the wind load; the displacement only for the structure
    )
    same = growth_by_finite_elements(scene, speed, hanging)
    assert fastest.real == pytest.approx(same.real, rel=2e-4)  # observed 3.5e-5, 7.1e-5
    assert abs(fastest.imag) == pytest.approx(abs(same.imag), rel=1e-5)  # observed 1.4e-6, 2e-7


def test_linear_theory_is_mode_superposition_at_small_amplitude():
    scene = example3(
        initial__wind="mean_wind_equilibrium",
        initial__seed_vertical=1e-5,
        initial__seed_horizontal=1e-5,
    )
    span = some_modes(scene)
    linear, nonlinear = linear_motion(span, 5.5, 20.0), nonlinear_motion(span, 20.0)
    for name in ("u2", "u3", "theta"):
        a, b = (result.midspan()[name].values for result in (linear, nonlinear))
        assert np.abs(a - b).max() < 2e-4 * np.ptp(a), name  # observed 6e-6, 9e-7, 6e-5


def test_an_unstable_linear_motion_ends_where_the_curve_ends():
    span = some_modes(example3(initial__seed_vertical=0.3))
    result = linear_motion(span, 5.5, 1000.0)
    assert result.outcome is gf.Outcome.ANGLE_OUT_OF_RANGE
    assert result.report.time == pytest.approx(144.45, abs=0.06)
    assert 80.0 < abs(math.degrees(result.report.value) - 180.0) < 85.0


def test_it_rests_in_the_mean_wind():
    scene = example3(
        initial__wind="mean_wind_equilibrium",
        initial__seed_vertical=0.0,
        initial__seed_horizontal=0.0,
    )
    data = modal.mode_superposition(scene, 5.0).midspan()
    assert np.ptp(data.u3.values) < 1e-12  # observed 1e-17
    full, _, _ = gf.Model(scene).rest().motion()
    middle = scene.numerics.elements
    assert data.u3.values[0] == pytest.approx(full[middle, 2], rel=5e-3)  # observed 2.4e-3


def test_applied_loads_move_it_as_they_move_the_simulation():
    """The pulse of example 1 divided by 1000: at full size the response is not linear.

    In the plane a sagging span resists a load that is the same everywhere by its stretch, in many
    modes; some of them are longitudinal and not taken.
    """
    scene = gf.load_scene("example1")
    scene = scene.with_values(
        {"loads": [scene.loads[0].model_dump() | {"force": (0.0, 1e-3, 2e-3), "torque": 1e-3}]}
    )
    data = modal.mode_superposition(scene, 3.0, vertical=20, horizontal=8, torsional=8).midspan()
    full = gf.simulate(scene, 3.0).midspan()
    for name, bound in (
        ("u2", 0.025),
        ("u3", 1.5e-3),
        ("theta", 2.5e-3),
    ):  # observed 1.9e-2, 7e-4, 1.3e-3
        assert np.abs(data[name].values - full[name].values).max() < bound * np.ptp(
            full[name].values
        ), name


def test_linear_theory_feels_applied_loads():
    """Without wind mode superposition is linear; only the load within a step differs."""
    span = some_modes(gf.load_scene("example1"))
    linear, other = linear_motion(span, 0.0, 2.0), nonlinear_motion(span, 2.0)
    for name in ("u2", "u3", "theta"):
        a, b = (result.midspan()[name].values for result in (linear, other))
        assert np.abs(a - b).max() < 2e-5 * np.ptp(b), name  # observed 6e-6, 2e-6, 1.5e-5


def test_the_wind_may_change():
    scene = gf.load_scene("example3")
    history = {"kind": "ramp", "initial": 0.0, "final": 5.5, "start": 2.0, "duration": 5.0}
    scene = scene.with_values(
        {
            "wind.speed": None,
            "wind.history": history,
            "initial.seed_vertical": 0.0,
            "initial.seed_horizontal": 0.0,
        }
    )
    data, full = modal.mode_superposition(scene, 10.0), gf.simulate(scene, 10.0)
    assert data.dataset.wind_speed.values == pytest.approx(full.dataset.wind_speed.values)
    assert data.midspan().u3.sel(time=2.0) == 0.0  # still air
    assert np.ptp(data.midspan().u3.values) == pytest.approx(
        np.ptp(full.midspan().u3.values),
        rel=5e-3,  # observed 2.2e-3
    )


def test_running_amplitude_looks_back():
    values = np.array([0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0])
    assert running_amplitude(values, 3).tolist() == [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    assert running_amplitude(values, 4).tolist() == [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"vertical": -1}, "vertical = -1: must be a whole number of modes, 0 or more"),
        ({"torsional": 1.5}, "torsional = 1.5: must be a whole number"),
        ({"vertical": 0, "horizontal": 0, "torsional": 0}, "take at least one mode"),
        ({"horizontal": 40}, "this mesh has only"),
        ({"stop_time": -1.0}, "stop_time = -1.0: must be a positive number of seconds"),
        ({"record_every": 0}, "record_every = 0: must be a whole number of time steps"),
    ],
)
def test_arguments_that_are_refused(arguments, message):
    with pytest.raises(gf.SceneError, match=message):
        modal.mode_superposition(example3(), **{"stop_time": 1.0} | arguments)


def test_moving_towers_are_refused():
    motion = {"x2": {"kind": "harmonic", "amplitude": 0.01, "frequency_hz": 1.0}}
    scene = example3(supports__left={"kind": "rigid", "motion": motion})
    with pytest.raises(gf.SceneError, match=r"supports\.left\.motion is given"):
        modal.mode_superposition(scene, 1.0)


def test_leaving_the_curve_is_an_error_with_the_result():
    scene = example3(initial__seed_vertical=3.0, wind__speed=2.0)
    with pytest.raises(gf.SimulationError) as caught:
        modal.mode_superposition(scene, 60.0)
    report, result = caught.value.report, caught.value.result
    assert report.outcome is gf.Outcome.ANGLE_OUT_OF_RANGE
    assert result.dataset.time.values[-1] < report.time < 60.0
    assert min(abs(math.degrees(report.limit) - end) for end in (100.0, 260.0)) < 1e-9
