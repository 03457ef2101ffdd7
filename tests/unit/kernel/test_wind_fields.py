"""Wind with a direction, a profile and gusts in the kernel: against numpy, bits, symmetries."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.simulation.energy_balance import MOTION_CHANNELS, energy_balance
from support.line_scenes import section
from support.windy_spans import LOGARITHMIC, POWER, TURBULENCE, wind_at, wind_force, windy_span

TABLE = {
    "time": [-1.0, 0.5, 1.5, 2.0],
    "stations": [10.0, 60.0, 61.0, 110.0],
    "speed": [[5, 6, 7, 5], [7, 8, 6, 4], [5, 5, 6, 8], [6, 4, 5, 7]],
    "upwards": [[0, 1, 0, 1], [1, 0, 1, 0], [-1, 0, 1, 0], [0, 0, 0, 1]],
}
TURNING = {"kind": "harmonic", "mean": 20.0, "amplitude": 35.0, "frequency_hz": 0.3}
WINDS = {
    "yaw": {"wind.direction_deg": -50.0},
    "turning": {"wind.direction_history": TURNING},
    "power": {"wind.profile": POWER, "wind.direction_deg": 20.0},
    "logarithmic": {"wind.profile": LOGARITHMIC},
    "turbulence": {
        "wind.turbulence": TURBULENCE,
        "wind.direction_deg": 30.0,
        "wind.profile": POWER,
        "wind.history": {"kind": "ramp", "initial": 3.0, "final": 9.0, "duration": 2.0},
        "wind.speed": None,
    },
    "along": {"wind.turbulence": TURBULENCE | {"intensity_across": 0, "intensity_upwards": 0}},
    "held table": {"wind.table": TABLE, "wind.speed": None},
    "repeated table": {"wind.table": TABLE | {"beyond": "repeat"}, "wind.speed": None},
    "other side": {"wind.speed": -6.0, "wind.direction_deg": 10.0},
}
TIMES = (0.0, 0.7, 1.999, 3.4, 11.3)
"""Between and at the times of gusts, after their end, and in later periods."""


def motion(model, seed):
    random = np.random.default_rng(seed)
    sizes = ([0.1, 0.5, 0.5, 0.3], [0.1, 0.5, 0.5, 0.5], [1.0, 5.0, 5.0, 30.0])
    return [random.uniform(-1.0, 1.0, (model.nodes, 4)) * size for size in sizes]


@pytest.mark.parametrize("name", WINDS)
def test_wind_force_is_that_of_numpy(name):
    """Interpolation in place and time, repetition and hold, profile and direction."""
    model = gf.Model(windy_span(WINDS[name]))
    mesh, (u, v, a) = Mesh(model), motion(model, 4)
    for time in TIMES:
        calm = gf.Inputs.still(model.scene)
        found = model.residual(u, v, a, time=time, inputs=calm) - model.residual(u, v, a, time=time)
        expected = wind_force(mesh, u, v, time)
        internal = np.abs(model.residual(u, v, a, time=time, inputs=calm)).max()
        error = np.abs(found - expected).max()
        # round-off of the internal forces, which the difference cancels; observed 0.14 of it
        assert error < 1e-15 * internal + 1e-12 * np.abs(expected).max()
        assert np.abs(expected).max() > 1.0


def test_spans_of_a_line_have_their_own_speed_in_the_same_gusts():
    scene = section(
        15000.0,
        (125.0, 100.0),
        15.0,
        2.0e7,
        elements=4,
        aerodynamics=windy_span().aerodynamics.model_dump(),
        wind={"speed": 5.0, "direction_deg": 25.0, "turbulence": TURBULENCE},
        ice={"attack_angle_deg": 170.0},
    )
    scene = scene.with_values({"section.spans.1.wind": {"speed": -8.0}})
    model, time = gf.Model(scene), 1.23
    mesh, (u, v, a) = Mesh(model), motion(model, 5)
    found = model.residual(u, v, a, inputs=gf.Inputs.still(scene), time=time) - model.residual(
        u, v, a, time=time
    )
    for chain, speed in zip(model.map.chains, (5.0, -8.0), strict=True):
        expected = wind_force(mesh, u, v, time, speed)
        own = slice(chain.first_node + 1, chain.first_node + 2 * chain.elements)
        assert np.abs(expected[own]).max() > 1.0
        assert np.abs(found - expected)[own].max() < 2e-10  # observed 3e-11


UNKNOWNS = ("stiffness", "damping")
OFFSETS, WEIGHTS = (-3, -2, -1, 1, 2, 3), (-1 / 60, 9 / 60, -45 / 60, 45 / 60, -9 / 60, 1 / 60)
STEP = 0.02


@pytest.mark.parametrize("name", ["turning", "turbulence", "held table"])
def test_tangent_is_the_derivative_of_the_residual(name):
    """By differences of sixth order, as in tests/property/test_tangent.py."""
    model, random = gf.Model(windy_span(WINDS[name])), np.random.default_rng(6)
    uva, time = motion(model, 7), 1.3
    forces = np.abs(model.residual(*uva, time=time)).max()
    for which, part in enumerate(UNKNOWNS):
        elements = model.tangent(*uva, time=time, **{part: 1.0})
        whole = np.zeros((4 * model.nodes,) * 2)
        for e, block in enumerate(elements):
            whole[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += block
        for unknown in range(4):
            direction = np.zeros((model.nodes, 4))
            direction[:, unknown] = random.uniform(-1.0, 1.0, model.nodes)
            expected = 0.0
            for offset, weight in zip(OFFSETS, WEIGHTS, strict=True):
                moved = [y.copy() for y in uva]
                moved[which] += offset * STEP * direction
                expected = expected + weight / STEP * model.residual(*moved, time=time)
            error = np.abs((whole @ direction.ravel()).reshape(-1, 4) - expected).max(axis=0)
            scale = np.abs(expected).max(axis=0)
            assert np.all(error < 1e-7 * scale + 3e-16 * forces / STEP)  # observed 0.3 of it


INTEGRATORS = {
    "newmark": {},
    "gauss6": {"numerics.integrator": "gauss6"},
    "tolerance": {"numerics.integrator": "gauss6", "numerics.tolerance": 1e-3},
    "alpha": {"numerics.integrator": "generalised_alpha"},
}
SHORT = {"numerics.elements": 6, "numerics.time_step": 0.02}


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_wind_that_is_uniform_has_the_bits_of_a_uniform_field(integrator):
    """A profile that does not change the speed makes the field varied, and nothing else."""
    steady = gf.load_scene("example3").with_values(SHORT | INTEGRATORS[integrator])
    flat = {"kind": "power", "exponent": 0.0, "attachment_height": 30.0}
    calm = {"wind.turbulence": TURBULENCE | dict.fromkeys(
        ("intensity", "intensity_across", "intensity_upwards"), 0.0)}  # fmt: skip
    runs = [
        gf.simulate(steady.with_values(values), stop_time=3.0).dataset
        for values in ({}, {"wind.profile": flat}, calm)
    ]
    for name in ("u1", "u2", "u3", "theta", "angle_of_attack", "tension"):
        assert np.array_equal(runs[0][name], runs[1][name])
        assert np.array_equal(runs[0][name], runs[2][name])


def test_mirrored_wind_moves_the_mirror_image():
    """The span is symmetric about mid-span; wind from the left is the image of that from the right.

    The angles of attack are the same, so that no coefficient changes.
    """
    scene = gf.load_scene("example3").with_values(SHORT | {"wind.profile": POWER})
    one, other = (
        gf.simulate(
            scene.with_values({"wind.direction_deg": yaw}),
            stop_time=4.0,
            record_nodes="all",
        ).dataset
        for yaw in (35.0, -35.0)
    )
    for name, sign in {"u1": -1.0, "u2": 1.0, "u3": 1.0, "theta": 1.0}.items():
        first, second = one[name].values, other[name].values[:, ::-1]
        error = np.abs(first - sign * second).max()
        assert error < 1e-12 * max(np.abs(first).max(), 1e-3)  # observed 4e-16
    assert np.abs(one.u2.values - one.u2.values[:, ::-1]).max() > 1e-6


@pytest.mark.parametrize("name", ["yaw", "turbulence"])
def test_negative_speed_is_wind_from_the_other_side(name):
    wind = WINDS[name] | {"wind.history": None, "wind.turbulence": None}
    yaw = wind["wind.direction_deg"]
    back = windy_span(wind | {"wind.speed": -7.0})
    turned = windy_span(wind | {"wind.speed": 7.0, "wind.direction_deg": yaw + 180.0})
    models = [gf.Model(scene) for scene in (back, turned)]
    u, v, a = motion(models[0], 8)
    found = [model.residual(u, v, a) - model.residual(u, v, a, inputs=gf.Inputs.still(model.scene))
             for model in models]  # fmt: skip
    assert np.abs(found[0]).max() > 1.0
    assert np.abs(found[0] - found[1]).max() < 1e-12  # observed 1e-17


def test_inputs_set_the_direction():
    """Held and at a rate; without a direction the laws of the scene hold."""
    scene = windy_span({"wind.direction_deg": 20.0, "wind.turbulence": TURBULENCE})
    model, time = gf.Model(scene), 1.7
    u, v, a = motion(model, 9)
    same = gf.Inputs.still(scene, wind_speed=scene.wind.mean_speed)
    by_laws = model.residual(u, v, a, time=time)
    assert np.array_equal(model.residual(u, v, a, time=time, inputs=same), by_laws)
    same.wind_direction = np.radians(20.0)
    assert np.array_equal(model.residual(u, v, a, time=time, inputs=same), by_laws)
    same.wind_direction, same.wind_direction_rate = np.radians(3.0), np.radians(10.0)
    same.wind_speed = np.float64(scene.wind.mean_speed)
    moved = model.residual(u, v, a, time=time, inputs=same)
    assert np.abs(moved - by_laws).max() < 1e-9  # observed 0
    same.wind_direction_rate = 0.0
    assert np.abs(model.residual(u, v, a, time=time, inputs=same) - by_laws).max() > 1.0


def test_equilibrium_is_that_of_the_mean_wind():
    gusty = windy_span(WINDS["turbulence"] | {"wind.history": None, "wind.speed": 8.0})
    steady = gusty.with_values({"wind.turbulence": None})
    motions = [gf.Model(scene).rest().motion()[0] for scene in (gusty, steady)]
    assert np.array_equal(*motions)
    starts = [
        gf.Model(scene.with_values({"initial.wind": "mean_wind_equilibrium"})).start().motion()
        for scene in (gusty, steady)
    ]
    assert np.array_equal(starts[0][0], starts[1][0])
    assert np.abs(starts[0][2]).max() > 0.01  # the gusts at t = 0 accelerate it


def test_angle_of_attack_sees_the_wind_at_its_node():
    scene = windy_span(WINDS["turbulence"])
    result = gf.simulate(scene, stop_time=2.0, record_nodes="all", channels=["u2", "u3", "theta",
        "v1", "v2", "v3", "omega", "angle_of_attack"])  # fmt: skip
    model, data = gf.Model(scene), result.dataset.isel(time=-1)
    normal, x = Mesh(model).node_normal, model.equilibrium().x
    wind = wind_at(scene, x, float(data.time))
    radius = 0.5 * scene.conductor.diameter
    w2 = (normal * (wind[:, :2] - np.stack([data.v1, data.v2], axis=1))).sum(axis=1)
    w2 -= radius * data.omega.values
    expected = np.radians(scene.ice.attack_angle_deg) + data.theta.values
    expected += np.arctan2(w2, wind[:, 2] - data.v3.values)
    assert np.abs(data.angle_of_attack.values - expected).max() < 1e-12  # observed 0


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_saved_state_continues_with_the_same_bits(integrator):
    scene = windy_span(SHORT | WINDS["turbulence"] | INTEGRATORS[integrator])
    model = gf.Model(scene)
    whole = model.start()
    for step in range(60):
        whole.advance(0.05 * (step + 1))
    part = model.start()
    for step in range(30):
        part.advance(0.05 * (step + 1))
    saved, other = part.save(), gf.Model(scene).start()
    part.advance(9.0)
    other.restore(saved)
    for step in range(30, 60):
        other.advance(0.05 * (step + 1))
    for one, two in zip(whole.motion(), other.motion(), strict=True):
        assert np.array_equal(one, two)


def test_steps_by_tolerance_end_at_the_times_of_gusts():
    """Gusts are linear between; steps across their kinks had an error of 5e-4 at 657 steps."""
    gusty = gf.load_scene("example3").with_values(
        {"numerics.integrator": "gauss6", "numerics.elements": 6, "wind.turbulence": TURBULENCE}
    )
    rough, fine = (
        gf.simulate(
            gusty.with_values({"numerics.tolerance": tolerance, "numerics.time_step": 0.1}),
            stop_time=20.0,
            record_every=1,
        )
        for tolerance in (1e-2, 1e-5)
    )
    error = np.abs(rough.midspan().u2.values - fine.midspan().u2.values).max()
    assert error < 2e-5 * np.abs(fine.midspan().u2.values).max()  # observed 6.5e-6
    assert 200 < rough.report.steps < 1000  # gusts are 0.1 s apart; observed 616


def test_energy_balance_closes_in_gusts():
    scene = windy_span(
        {
            "numerics.time_step": 0.005,
            "wind.turbulence": TURBULENCE,
            "wind.direction_deg": 30.0,
            "wind.profile": POWER,
            "initial.wind": "mean_wind_equilibrium",
        }
    )
    result = gf.simulate(
        scene, stop_time=3.0, record_nodes="all", record_every=1, channels=MOTION_CHANNELS
    )
    balance = energy_balance(result)
    assert np.abs(balance.wind).max() > 10.0 * np.abs(balance.imbalance).max()
    assert balance.worst < 1e-6  # observed 1.0e-7


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({"wind.profile": POWER | {"attachment_height": 0.5}, "span.height_difference": 0.0},
         "height of a conductor above ground"),
    ],
)  # fmt: skip
def test_conductor_below_the_ground(values, problem):
    with pytest.raises(gf.SimulationError, match=problem):
        gf.Model(windy_span(values))


def test_a_seed_gives_the_same_bits_in_a_sweep():
    scene = gf.load_scene("example3").with_values(SHORT | {"wind.turbulence": TURBULENCE})
    over = {"wind.turbulence.seed": [1, 2], "wind.direction_deg": [25.0]}
    found = gf.sweep(scene, over, stop_time=2.0, workers=1).dataset.lowest_tension.values
    for seed, lowest in zip(over["wind.turbulence.seed"], found, strict=True):
        alone = {"wind.turbulence.seed": seed, "wind.direction_deg": 25.0}
        assert gf.simulate(scene.with_values(alone), stop_time=2.0).report.lowest_tension == lowest
    assert found[0] != found[1]
