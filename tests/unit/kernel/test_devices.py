"""Devices at junctions: forces, tangents and energies agree with each other.

The junctions are bodies beside a short conductor: their motion is given, not computed.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.pack import Packed
from gallop_fmu.engine.probes import Object, probes_of
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.scene.time_functions import Harmonic
from support.line_models import LineModel
from support.sections import section

TIME = 0.3
"""Time [s] at which the towers move."""

G = 9.81
SPRING, STRING, V_STRING, FRAME, YOKE, MASS, PENDULUM, DAMPER, BAR = 0, *range(2, 10)


class Given(NamedTuple):
    """A device: kind, places of its junctions along x2 and x3, parameters."""

    kind: int
    places: tuple[tuple[float, float], ...]
    parameters: tuple[float, ...]


QUAD = ((0.2, -0.25), (0.25, 0.2), (-0.2, 0.2), (-0.2, -0.3))
TWIN = ((0.0, -0.2), (0.0, 0.25))
ONE = ((0.0, 0.0),)
CASES = {
    "spring": Given(SPRING, ONE, (30.0, 20.0, 50.0)),
    "string": Given(STRING, ONE, (2.1, 490.0, 300.0)),
    "string with damping": Given(STRING, ONE, (2.1, 490.0, 300.0, 40.0)),
    "string with a clamp that turns": Given(STRING, ONE, (1.4, 90.0, 200.0, 0.0, 60.0)),
    "end string": Given(STRING, ONE, (2.0, 300.0, 250.0, 30.0, 0.0, -1.9, 0.5, 0.1)),
    "stiff string": Given(STRING, ONE, (2.1, 490.0, 5e7)),
    "V-string": Given(V_STRING, ONE, (2.0, 200.0, 300.0, 20.0, 1.2)),
    "twin frame": Given(FRAME, TWIN, (4.0, 70.0, 0.0, 50.0)),
    "quad frame": Given(FRAME, QUAD, (8.0, 90.0, 0.0, 60.0)),
    "frame with damping": Given(FRAME, QUAD, (8.0, 90.0, 11.0, 60.0, 7.0)),
    "stiff frame": Given(FRAME, QUAD, (8.0, 1e7, 0.0, 500.0)),
    "yoke": Given(YOKE, QUAD, (8.0, 90.0, 0.0, 60.0, 0.0, 2.0, 400.0, 150.0, 0.0, 0.4)),
    "yoke with damping": Given(
        YOKE, TWIN, (8.0, 90.0, 8.0, 60.0, 5.0, 2.0, 400.0, 150.0, 20.0, 0.4)
    ),
    "point mass": Given(MASS, ONE, (7.0,)),
    "pendulum": Given(PENDULUM, ONE, (20.0, 0.5, 0.6)),
    "damper": Given(DAMPER, ONE, (3.0, 4.0, 5.0, 6.0, 7.0, 8.0)),
    "damper between two": Given(DAMPER, TWIN, (3.0, 4.0, 5.0, 6.0, 7.0, 8.0)),
    "interphase spacer": Given(BAR, ((1.0, 0.0), (-0.5, 0.7)), (200.0, 6.0)),
    "interphase spacer with damping": Given(BAR, ((1.0, 0.0), (-0.5, 0.7)), (200.0, 6.0, 9.0)),
}
DAMPED = [
    *("end string", "V-string", "damper", "damper between two"),
    *(name for name in CASES if name.endswith("with damping")),
]
UNDAMPED = [name for name in CASES if name not in DAMPED]


def bed(given, *, tower_moves=False, motion=True):
    """A model of a short conductor and one device, whose junctions move as the test prescribes."""
    packed = Packed(gf.load_scene("example1").with_values({"numerics.elements": 2}))
    laws = (-1, -1, -1)
    if tower_moves:
        laws = tuple(
            packed.add_law(Harmonic(amplitude=0.1 * (i + 1), frequency_hz=0.3 + 0.2 * i), "motion")
            for i in range(3)
        )
    fixed = (True,) * 4 if motion else (False, False, False, True)
    indices = [
        packed.add_junction((50.0 + 0.1 * k, *place), fixed, laws)
        for k, place in enumerate(given.places)
    ]
    packed.add_device(given.kind, indices, dict(enumerate(given.parameters)))
    packed.scene = packed.c_scene()
    packed.scene.settings.gravity = G
    return LineModel(None, packed)


class Bed:
    """A device, and functions of the motion (3, junction, 4) of its junctions: u, v, a."""

    def __init__(self, name, **options):
        self.model = bed(CASES[name], **options)
        self.node = self.model.junction_nodes()[0][list(self.model.devices[0])]
        self.junctions = len(self.node)

    def _nodes(self, y):
        motion = np.zeros((3, self.model.nodes, 4))
        motion[:, self.node] = y
        return motion

    def force(self, y):
        return self.model.device_force(0, *self._nodes(y), time=TIME)[0]

    def energy(self, y):
        return self.model.device_force(0, *self._nodes(y), time=TIME)[1:]

    def tangent(self, y, **weights):
        found = self.model.device_tangent(0, *self._nodes(y), time=TIME, **weights)
        size = 4 * self.junctions
        return found.transpose(0, 2, 1, 3).reshape(size, size)

    def drawn(self, seed, sizes=(0.3, 1.0, 4.0)):
        """A motion drawn at random, of about so many m or rad, and per s and s^2."""
        unit = np.random.default_rng(seed).uniform(-1.0, 1.0, (3, self.junctions, 4))
        return unit * np.reshape(sizes, (3, 1, 1))


def derivative(function, step):
    """Central difference of fourth order of a function of one number at 0."""
    near, far = (function(k * step) - function(-k * step) for k in (1, 2))
    return (8.0 * near - far) / (12.0 * step)


def differences(function, y, order):
    """Derivative of a function by displacement (order 0), velocity (1) or acceleration (2).

    Forces are at most of the second degree in velocities and accelerations.
    """
    columns, step = [], 0.1 if order else 2e-4
    for index in np.ndindex(y[order].shape):

        def moved(by, index=index):
            other = y.copy()
            other[(order, *index)] += by
            return function(other)

        columns.append(derivative(moved, step))
    return np.array(columns)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", CASES)
def test_the_tangent_is_the_derivative_of_the_force(name, seed):
    """To a fraction of the largest entry; seen: 5e-10, by the error of the differences."""
    device = Bed(name, tower_moves=True)
    y = device.drawn(seed)
    if "stiff" in name:
        y[0] *= 0.1
    for order, weight in enumerate(("stiffness", "damping", "mass")):
        found = device.tangent(y, **{weight: 1.0})
        wanted = differences(device.force, y, order).reshape(len(found), -1).T
        scale = max(np.abs(wanted).max(), 1.0)
        assert np.abs(found - wanted).max() < 2e-9 * scale


@pytest.mark.parametrize("name", CASES)
def test_loads_of_many_motions_are_those_of_each(name):
    device = Bed(name)
    motions = np.array([device.drawn(seed) for seed in range(3)])
    motions[:, 2] = 0.0
    force, *slopes = device.model.device_load(0, motions[:, 0], motions[:, 1])
    for i, y in enumerate(motions):
        assert (force[i] == device.force(y)).all()
        for slope, weight in zip(slopes, ("stiffness", "damping"), strict=True):
            size = 4 * device.junctions
            flat = slope[i].transpose(0, 2, 1, 3).reshape(size, size)
            assert (flat == device.tangent(y, **{weight: 1.0})).all()


@pytest.mark.parametrize("name", CASES)
def test_the_tangent_is_a_sum_by_its_weights(name):
    device = Bed(name)
    y = device.drawn(7)
    weights = {"stiffness": 1.5, "damping": 20.0, "mass": 300.0}
    parts = [value * device.tangent(y, **{key: 1.0}) for key, value in weights.items()]
    together = device.tangent(y, **weights)
    assert together == pytest.approx(sum(parts), abs=1e-12 * np.abs(together).max())


@pytest.mark.parametrize("name", UNDAMPED)
def test_stiffness_and_mass_are_symmetric(name):
    device = Bed(name)
    y = device.drawn(11)
    mass = device.tangent(y, mass=1.0)
    y[1:] = 0.0
    stiffness = device.tangent(y, stiffness=1.0)
    for matrix in (mass, stiffness):
        assert np.abs(matrix - matrix.T).max() <= 1e-14 * max(np.abs(matrix).max(), 1.0)


@pytest.mark.parametrize("name", DAMPED)
def test_damping_is_symmetric_and_takes_energy(name):
    device = Bed(name)
    y = device.drawn(13)
    damping = device.tangent(y, damping=1.0)
    if not name.startswith("yoke"):  # centrifugal terms of its string
        assert np.abs(damping - damping.T).max() <= 1e-13 * np.abs(damping).max()
    y[1] *= 1e-3
    y[2] = 0.0
    assert dissipation(device, y) > 0.0


def power(device, y):
    """Power of the forces that move the junctions."""
    return float((device.force(y) * y[1]).sum())


def energy_rate(device, y):
    """Rate of kinetic plus potential energy along a motion."""

    def energy(t):
        u, v, a = y
        return sum(device.energy(np.array([u + t * v + 0.5 * t * t * a, v + t * a, a])))

    return derivative(energy, 2e-4)


def dissipation(device, y):
    return power(device, y) - energy_rate(device, y)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", CASES)
def test_the_power_of_the_forces_is_the_rate_of_the_energy(name, seed):
    """It is larger by what damping takes; the tower is at rest.  Seen: 3e-12 of all power."""
    device = Bed(name)
    y = device.drawn(seed + 20)
    if "stiff" in name:
        y[0] *= 0.1
    scale = np.abs(device.force(y) * y[1]).sum()
    if name in DAMPED:
        assert dissipation(device, y) > 1e-5 * scale
    else:
        assert abs(dissipation(device, y)) < 2e-11 * scale


@pytest.mark.parametrize("name", ["twin frame", "quad frame", "stiff frame", "interphase spacer"])
def test_a_rigid_translation_needs_no_force_but_that_of_weight_and_mass(name):
    device = Bed(name)
    y = np.zeros((3, device.junctions, 4))
    weight = device.force(y)
    y[0, :, :3], y[1, :, :3] = (0.7, -2.0, 1.3), (3.0, 4.0, -5.0)
    assert device.force(y) == pytest.approx(weight, abs=1e-8)


@pytest.mark.parametrize("turn", [0.3, 1.7, 3.5, -9.0, 40.0])
@pytest.mark.parametrize("name", ["twin frame", "quad frame", "frame with damping", "stiff frame"])
def test_a_rigid_rotation_needs_no_force(name, turn):
    """Also of several whole turns, and while it rotates."""
    device = Bed(name)
    weight = device.force(np.zeros((3, device.junctions, 4)))
    place = np.array(CASES[name].places)
    r = place - place.mean(axis=0)
    cosine, sine = math.cos(turn), math.sin(turn)
    turned = r @ np.array([[cosine, sine], [-sine, cosine]])
    y = np.zeros((3, device.junctions, 4))
    y[0, :, 1:3], y[0, :, 3] = turned - r + (0.4, -0.2), turn
    y[1, :, 1:3], y[1, :, 3] = 2.0 * turned @ np.array([[0.0, 1.0], [-1.0, 0.0]]), 2.0
    assert np.abs(device.force(y) - weight).max() < 1e-15 * 40.0 * CASES[name].parameters[1]
    assert device.energy(y)[1] == pytest.approx(
        sum(weight[:, 1]) * 0.4, abs=1e-9 * CASES[name].parameters[1]
    )


def test_weight_and_inertia_of_a_string():
    """Half of its weight, a third of its mass; a sixth acts on the tower's acceleration."""
    device = Bed("string")
    y = np.zeros((3, 1, 4))
    assert device.force(y) == pytest.approx(np.array([[0.0, 245.0, 0.0, 0.0]]))
    y[2, 0, 0] = 1.5
    assert device.force(y)[0, 0] == pytest.approx(490.0 / G / 3.0 * 1.5)
    moving = Bed("string", tower_moves=True)
    omega = [2.0 * math.pi * f for f in (0.3, 0.5, 0.7)]
    tower = [0.1 * (i + 1) * math.sin(omega[i] * TIME) for i in range(3)]
    y = np.zeros((3, 1, 4))
    y[0, 0, :3] = tower
    acceleration = np.array([-(omega[i] ** 2) * tower[i] for i in range(3)])
    assert moving.force(y)[0, :3] == pytest.approx(
        490.0 / G / 6.0 * acceleration + [0.0, 245.0, 0.0]
    )


def test_a_string_pulls_along_itself():
    device = Bed("string")
    y = np.zeros((3, 1, 4))
    y[0, 0, :3] = (0.3, -0.2, 0.4)
    r = np.array([0.3, -2.3, 0.4])
    length = np.linalg.norm(r)
    pull = 300.0 * (length - 2.1)
    assert device.force(y)[0] == pytest.approx([*(pull * r / length + [0, 245, 0]), 0.0])


def test_a_clamp_that_turns_follows_the_lean_of_its_string():
    """The clamp has no moment where it has turned as the string leans: by -lean."""
    device = Bed("string with a clamp that turns")
    lean = 0.5
    y = np.zeros((3, 1, 4))
    y[0, 0, 1:] = 1.4 * (1.0 - math.cos(lean)), 1.4 * math.sin(lean), -lean
    assert device.force(y)[0] == pytest.approx([0.0, 45.0, 0.0, 0.0], abs=1e-12)
    y[0, 0, 3] = 0.1 - lean
    assert device.force(y)[0, 3] == pytest.approx(60.0 * 0.1)


def test_the_weight_of_a_pendulum_turns_the_conductor():
    """At 0.6 rad towards +x3 it turns the conductor towards its lowest place."""
    device = Bed("pendulum")
    y = np.zeros((3, 1, 4))
    moment = -20.0 * 0.5 * G * math.sin(0.6)
    assert device.force(y)[0] == pytest.approx([0.0, 20.0 * G, 0.0, moment])
    y[0, 0, 3] = 0.6
    assert device.force(y)[0, 3] == pytest.approx(0.0, abs=1e-12)
    y[1, 0, 3] = 3.0  # the centrifugal force pulls down
    assert device.force(y)[0, 1] == pytest.approx(20.0 * (G + 0.5 * 9.0))


def test_a_frame_turns_against_its_clamps():
    """All places as they were, one clamp turned: its moment turns the frame's arms by forces."""
    device = Bed("twin frame")
    weight = device.force(np.zeros((3, 2, 4)))
    y = np.zeros((3, 2, 4))
    y[0, 0, 3] = 0.2
    change = device.force(y) - weight
    assert change[:, 3] == pytest.approx([50.0 * 0.2, 0.0])
    couple = 50.0 * 0.2 / 0.45  # the arms are 0.45 m apart
    assert change[:, 1] == pytest.approx([-couple, couple]) or change[:, 1] == pytest.approx(
        [couple, -couple]
    )
    assert np.abs(change[:, [0, 2]]).max() < 1e-12


PULL, ALONG, ACROSS, TURN = 3, 4, 5, 6
"""Channels of a device: gallop_device_channel; the first three are the force on the tower."""


def displaced(suspension, **tables):
    """Two spans whose suspension's tower point has moved, in equilibrium; probes of a device."""
    motion = {
        axis: {"kind": "constant", "value": value}
        for axis, value in (("x1", 0.3), ("x2", 0.05), ("x3", 0.8))
    }
    model = Model(section((150.0, 110.0), suspension | {"motion": motion}, 12e3, **tables))
    state = model.start()
    tower = model.map.towers[1]

    def observed(device):
        return state.observe(probes_of([(Object.DEVICE, device, k) for k in range(7)]))

    def moved(clamp):
        """Of a clamp, from the strung state, in which the line was strung level."""
        return state.motion()[0][model.junction_nodes()[0][clamp], :3]

    return tower, observed, moved


def test_a_string_leans_and_pulls_at_its_tower():
    """Pull, lean and force on the tower agree with the place of the clamp."""
    tower, observed, moved = displaced({"kind": "string", "length": 1.8, "weight": 700.0})
    values = observed(tower.devices[0])
    r = moved(tower.junctions[0]) - (0.3, 0.05, 0.8) - (0.0, 1.8, 0.0)
    force = values[PULL] * r / np.linalg.norm(r) - (0.0, 350.0, 0.0)
    assert values[:3] == pytest.approx(force, abs=1e-3 * values[PULL])
    assert values[ALONG] == pytest.approx(math.atan2(r[0], -r[1]), abs=1e-3)
    assert values[ACROSS] == pytest.approx(math.atan2(r[2], -r[1]), abs=1e-3)
    assert values[ACROSS] < -0.05
    assert values[TURN] == 0.0


def test_the_bars_of_a_v_string_share_the_load():
    """The one on the side to which the clamp is pulled carries less."""
    suspension = {"kind": "v_string", "length": 1.8, "weight": 200.0, "half_spread": 1.0}
    tower, observed, _ = displaced(suspension)
    values = observed(tower.devices[0])
    height, half = math.sqrt(1.8**2 - 1.0), 1.0
    down, back = np.hypot(values[0], values[1] + 200.0), -values[2]  # what both bars hold
    assert back > 100.0
    pull = 1.8 / 2.0 * (down / height - back / half)
    assert values[PULL] == pytest.approx(pull, rel=1e-3)
    assert abs(values[ACROSS]) < 1e-3  # held by both bars


def test_a_yoke_turns_where_its_tower_moves():
    """Its string leans as that of a single conductor does, and twice the weight pulls."""
    bundle = {"subconductors": 2, "spacing": 0.4, "yoke_height": 0.2}
    string = {"kind": "string", "length": 1.8, "weight": 100.0}
    tower, observed, moved = displaced(string, bundle=bundle)
    values = observed(tower.devices[0])
    place = np.array([moved(clamp) for clamp in tower.junctions])
    turn = math.atan2(place[1, 1] - place[0, 1], 0.4 + place[1, 2] - place[0, 2])
    assert values[TURN] == pytest.approx(-turn, abs=2e-3)
    assert abs(values[TURN]) > 0.05
    force = np.hypot(values[1] + 50.0, np.hypot(values[0], values[2]))
    assert values[PULL] == pytest.approx(force, rel=1e-6)


def torsional_frequencies(mass, arm):
    """Lowest frequencies [Hz] of the twist alone, of Example 3's conductor between rigid ends."""
    length, elements = 125.88, 30
    scene = section(
        (length,),
        tension=30e3,
        conductor={"torsional_stiffness": 153.0, "torsional_inertia": 1.56e-4},
        numerics={"elements": elements},
        devices=[
            {"kind": "pendulum", "span": 1, "station": 0.5, "mass": mass, "arm": arm},
        ],
    )
    model = Model(scene)
    stiffness, inertia = (np.zeros((model.nodes, model.nodes)) for _ in range(2))
    for matrix, weight in ((stiffness, "stiffness"), (inertia, "mass")):
        for e, block in enumerate(model.tangent(**{weight: 1.0})):
            own = slice(2 * e, 2 * e + 3)
            matrix[own, own] += block[3::4, 3::4]
        middle = model.junction_nodes()[0][1]
        matrix[middle, middle] += model.device_tangent(0, **{weight: 1.0})[0, 0, 3, 3]
    inner = slice(1, -1)
    squares = eigh(stiffness[inner, inner], inertia[inner, inner], eigvals_only=True)
    return np.sqrt(squares[:4]) / math.tau, model.equilibrium().length


@pytest.mark.parametrize(("mass", "arm"), [(10.0, 0.3), (20.0, 0.5)])
def test_a_pendulum_lowers_the_torsional_frequencies(mass, arm):
    """Symmetric modes of a bar of length L: 2 GJ b cos(b L/2) = (w^2 m l^2 - m g l) sin(b L/2),

    b = w sqrt(I/GJ); by balance of moments at its middle. The antisymmetric ones stay.
    """
    found, length = torsional_frequencies(mass, arm)

    def missing(frequency):
        omega = math.tau * frequency
        b = omega * math.sqrt(1.56e-4 / 153.0)
        moment = omega**2 * mass * arm**2 - mass * G * arm
        return 2.0 * 153.0 * b * math.cos(b * length / 2.0) - moment * math.sin(b * length / 2.0)

    antisymmetric = math.sqrt(153.0 / 1.56e-4) / length
    wanted = [brentq(missing, 0.3, 1.5), brentq(missing, 7.7, 8.2), antisymmetric]
    assert found[:3] == pytest.approx(sorted(wanted), rel=4e-5)


REFUSED = {
    "length of a string": Given(STRING, ONE, (0.0, 490.0, 300.0)),
    "weight of a string": Given(STRING, ONE, (2.0, -1.0, 300.0)),
    "stiffness of a string": Given(STRING, ONE, (2.0, 490.0)),
    "damping of a string": Given(STRING, ONE, (2.0, 490.0, 300.0, -1.0)),
    "torsional stiffness of the clamp of a string": Given(
        STRING, ONE, (2.0, 490.0, 300.0, 0.0, -2.0)
    ),
    "half the spread of a V-string": Given(V_STRING, ONE, (2.0, 200.0, 300.0, 20.0, 2.0)),
    "mass of a frame": Given(FRAME, TWIN, (-1.0, 70.0)),
    "stiffness of an arm of a frame": Given(FRAME, TWIN, (4.0, 0.0)),
    "damping of an arm of a frame": Given(FRAME, TWIN, (4.0, 70.0, -1.0)),
    "torsional stiffness of a clamp of a frame": Given(FRAME, TWIN, (4.0, 70.0, 0.0, -5.0)),
    "torsional damping of a clamp of a frame": Given(FRAME, TWIN, (4.0, 70.0, 0.0, 5.0, -1.0)),
    "mass of a point mass": Given(MASS, ONE, (0.0,)),
    "mass of a pendulum": Given(PENDULUM, ONE, (0.0, 0.5)),
    "arm of a pendulum": Given(PENDULUM, ONE, (20.0, -0.5)),
    "damping of a damper": Given(DAMPER, ONE, (1.0, -2.0)),
    "stiffness of a damper": Given(DAMPER, ONE, (1.0, 0.0, 0.0, 0.0, -3.0)),
    "stiffness of an interphase spacer": Given(BAR, TWIN, (0.0,)),
    "mass of an interphase spacer": Given(BAR, TWIN, (200.0, -1.0)),
    "damping of an interphase spacer": Given(BAR, TWIN, (200.0, 1.0, -1.0)),
    "number of junctions of a device": Given(FRAME, ONE, (4.0, 70.0)),
}


@pytest.mark.parametrize(
    ("parameters", "field"),
    [((1.0, 1.0, 1.0, 0.0, 1.0, 1.0), "stiffness of a support"), ((1.0,) * 6, "mass of a body")],
)
def test_a_body_is_held_and_has_mass(parameters, field):
    with pytest.raises(SimulationError, match=rf": {field}"):
        bed(Given(DAMPER, ONE, parameters), motion=False)


@pytest.mark.parametrize("field", REFUSED)
def test_impossible_parameters_are_refused(field):
    with pytest.raises(SimulationError, match=rf": {field} \("):
        bed(REFUSED[field])


def test_a_device_that_does_not_exist_is_refused():
    model = Model(gf.load_scene("example2"))
    for call in (model.device_force, model.device_tangent):
        with pytest.raises(ValueError, match=r"device = 2 must be at least 0 and at most 1"):
            call(2)
