"""Ice that falls: energy, continuity, states, times and limits of acceleration."""

import copy
import math

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import probes_of, system_probe

STEP = 0.01
FALL = 0.5037
"""Time [s] off the grid of the steps."""

NEVER = 1e6
ENERGIES = probes_of([system_probe("kinetic_energy"), system_probe("potential_energy")])
ICE = {
    "mass_per_length": 1.2,
    "torsional_inertia": 4e-4,
    "first_moment_x2": 3e-3,
    "first_moment_x3": -8e-3,
    "attack_angle_deg": 35.0,
}


def line(*shedding, **tables):
    """Three uneven spans with eccentric ice, undamped, moving from the start."""
    tables = {"ice": ICE} | tables
    numerics = {"elements": 6, "time_step": STEP, "newton_tolerance": 1e-11}
    return gf.LineScene.from_dict(
        {
            "title": "ice that falls",
            "section": {
                "horizontal_tension": 25e3,
                "spans": [
                    {"length": 120.0},
                    {"length": 160.0, "height_difference": 12.0},
                    {"length": 120.0},
                ],
                "suspensions": [{"kind": "string", "length": 2.4, "weight": 600.0, "damping": 0.0}]
                * 2,
            },
            "conductor": {
                "diameter": 0.028,
                "mass_per_length": 1.628,
                "axial_stiffness": 29e6,
                "torsional_stiffness": 159.0,
                "torsional_inertia": 2e-4,
            },
            "initial": {"seed_vertical": 0.3, "seed_horizontal": 0.2, "seed_twist": 0.1},
            **tables,
            "shedding": list(shedding),
            "numerics": numerics | tables.get("numerics", {}),
        }
    )


def one(**changes):
    return {"span": 2, "from_station": 0.25, "to_station": 0.8, "time": FALL} | changes


def started(scene):
    return Model(scene, inputs=False).start()


def energies(state):
    return state.observe(ENERGIES)


def motion_of(state):
    return np.array(state.motion())


def energy_of_ice(state, piece):
    """Kinetic and potential energy of the ice of a stretch, summed over three Gauss points."""
    chain = state.model.map.chain(piece.span)
    first, last = (
        chain.first_element + chain.corners[int(np.argmin(np.abs(np.array(chain.fractions) - x)))]
        for x in (piece.from_station, piece.to_station)
    )
    sections = Mesh(state.model).sections
    u, v, _ = (
        np.einsum("pn,eni->epi", sections.shape, y[sections.nodes]).reshape(-1, 4)
        for y in state.motion()
    )
    at = slice(3 * first, 3 * last)
    u, v, length, normal = u[at], v[at], sections.length[at], sections.normal[at]
    m2, m3 = ICE["first_moment_x2"], ICE["first_moment_x3"]
    sine, cosine = np.sin(u[:, 3]), np.cos(u[:, 3])
    c2, c3 = m2 * cosine - m3 * sine, m2 * sine + m3 * cosine
    v2, spin = (normal * v[:, :2]).sum(axis=1), v[:, 3]
    kinetic = 0.5 * ICE["mass_per_length"] * (v[:, :3] ** 2).sum(axis=1)
    kinetic += spin * (c2 * v[:, 2] - c3 * v2) + 0.5 * ICE["torsional_inertia"] * spin**2
    potential = 9.81 * (ICE["mass_per_length"] * u[:, 1] + normal[:, 1] * (c2 - m2))
    return np.array([length @ kinetic, length @ potential])


METHODS = {
    "newmark": {"integrator": "newmark"},
    "generalised_alpha": {"integrator": "generalised_alpha"},
    "gauss6": {"integrator": "gauss6"},
    "tolerance": {"integrator": "gauss6", "tolerance": 1e-5},
}


@pytest.fixture(params=METHODS)
def numerics(request):
    return METHODS[request.param]


def test_the_motion_is_continuous_and_the_energy_drops_by_that_of_the_ice(numerics):
    shed, iced = (started(line(one(time=time), numerics=numerics)) for time in (FALL, NEVER))
    for state in (shed, iced):
        state.advance(FALL)
    (u, v, a), (iced_u, iced_v, iced_a) = shed.motion(), iced.motion()
    assert np.array_equal(u, iced_u)
    assert np.array_equal(v, iced_v)
    assert np.abs(a - iced_a).max() > 1.0
    lost = energy_of_ice(iced, shed.model.map.sheddings[0])
    assert np.abs(lost).min() > 10.0
    # round-off; observed 6e-14
    assert energies(iced) - energies(shed) == pytest.approx(lost, abs=1e-11)
    assert shed.shedding_energies()[0] == pytest.approx(lost, abs=1e-11)
    assert np.array_equal(iced.shedding_energies(), [[0.0, 0.0]])
    assert shed.shedding_times() == [FALL]
    assert iced.shedding_times() == [np.inf]


def test_energy_is_kept_before_and_after_the_fall():
    state = started(line(one(), numerics={"integrator": "gauss6", "time_step": 1e-3}))
    values, _ = state.record(100, 10, ENERGIES)
    total = values.sum(axis=1)
    before, after = total[:50], total[50:]
    turnover = np.ptp(values[:, 0])
    assert abs(before[0] - after[0]) > 0.1 * turnover
    for part in (before, after):
        assert np.ptp(part) < 1e-9 * turnover  # observed 9e-11


def test_ice_that_falls_gives_the_equation_of_motion_of_the_bare_conductor(numerics):
    """The accelerations after the fall balance the forces of a line without the ice."""
    scene = line(one(time=FALL, from_station=0.0, to_station=1.0), numerics=numerics)
    state = started(scene)
    state.advance(FALL)
    u, v, a = state.motion()
    residual = state.model.residual(u, v, a, time=FALL)
    chain = state.model.map.chain(2)
    assert np.abs(residual[chain.nodes][1:-1]).max() < 1e-6


def test_records_before_the_fall_have_the_ice():
    """With a tolerance a step ends at the fall, and earlier records are interpolated within it."""
    scene = line(one(), numerics=METHODS["tolerance"])
    whole, _ = started(scene).record(100, 1, ENERGIES)
    iced, _ = started(line(one(time=NEVER), numerics=METHODS["tolerance"])).record(100, 1, ENERGIES)
    total, of_iced = whole.sum(axis=1), iced.sum(axis=1)
    fall = int(FALL / STEP)
    assert total[:fall] == pytest.approx(of_iced[:fall], abs=1.0)
    assert np.abs(total[fall:] - of_iced[fall:]).min() > 50.0


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha", "gauss6"])
def test_a_step_is_split_without_moving_the_grid(method):
    """Records lie on the grid; the run equals one by hand: to the fall, then to the grid."""
    scene = line(one(), numerics=METHODS[method])
    run, by_hand = started(scene), started(scene)
    run.record(51, 1, ENERGIES)
    by_hand.record(50, 1, ENERGIES)
    by_hand.advance(FALL)
    by_hand.advance(run.time)
    assert run.time == 51 * STEP
    assert np.array_equal(motion_of(run), motion_of(by_hand))


@pytest.mark.parametrize("shift", [-1e-13, 0.0, 1e-13])
def test_a_fall_at_a_step_of_the_grid_splits_nothing(shift):
    state = started(line(one(time=0.5 + shift)))
    _, report = state.record(60, 1, ENERGIES)
    assert report.steps == 60
    assert state.shedding_times() == pytest.approx([0.5], abs=1e-12)


def test_several_falls_within_a_step():
    falls = [
        one(time=0.503, to_station=0.4),
        one(time=0.507, from_station=0.4),
        one(span=1, time=0.0),
    ]
    state = started(line(*falls))
    assert list(state.shedding_times()) == [np.inf, np.inf, 0.0]
    _, report = state.record(51, 1, ENERGIES)
    assert list(state.shedding_times()) == [0.503, 0.507, 0.0]
    assert report.steps == 53


def test_two_states_of_a_model_shed_by_themselves(numerics):
    model = Model(line(one(), numerics=numerics), inputs=False)
    first, second = model.start(), model.start()
    first.advance(1.0)
    assert first.shedding_times() == [FALL]
    assert second.shedding_times() == [np.inf]
    second.advance(1.0)
    assert np.array_equal(motion_of(first), motion_of(second))


def test_a_state_restored_before_the_fall_sheds_again_alike(numerics):
    state = started(line(one(), numerics=numerics))
    state.advance(0.5)
    saved, copied = state.save(), copy.copy(state)
    state.advance(0.6)
    found = motion_of(state), state.save()
    state.restore(saved)
    assert state.shedding_times() == [np.inf]
    for again in (state, copied):
        again.advance(0.6)
        assert np.array_equal(motion_of(again), found[0])
        assert again.save() == found[1]


def test_a_damaged_time_of_a_fall_is_refused():
    state = started(line(one()))
    state.advance(0.6)
    content = np.frombuffer(state.save(), dtype=np.float64).copy()
    last = len(content) - 4  # an array begins at every fourth number
    assert content[last] == FALL
    for damaged in (math.nan, 0.7):
        content[last] = damaged
        with pytest.raises(ValueError, match="damaged"):
            state.restore(content.tobytes())


def test_a_symmetric_fall_is_mirrored():
    found = []
    for start, stop in ((0.0, 0.4), (0.6, 1.0)):
        scene = line(one(from_station=start, to_station=stop, span=2), initial={})
        scene = scene.with_values({"section.spans.1.height_difference": 0.0})
        state = started(scene)
        state.advance(1.2)
        found.append(state.motion()[0][:, 1])
    assert np.abs(found[0]).max() > 0.3
    assert found[0] == pytest.approx(found[1][::-1], abs=1e-8)


# ---- limits of acceleration ----


def test_ice_falls_where_the_conductor_accelerates(numerics):
    """A fall at a time shakes the neighbour loose; the second fall equals one at its time."""
    first = one(to_station=0.5)
    second = one(from_station=0.5, time=None, acceleration=3.0)
    state = started(line(first, second, initial={}, numerics=numerics))
    state.advance(1.0)
    when = state.shedding_times()[1]
    assert FALL < when < 1.0
    if "tolerance" not in numerics:  # at the end of a step
        timed = started(
            line(first, one(from_station=0.5, time=float(when)), initial={}, numerics=numerics)
        )
        timed.advance(1.0)
        assert timed.motion()[0] == pytest.approx(state.motion()[0], abs=1e-7)


def test_ice_stays_below_the_limit_of_acceleration():
    state = started(line(one(time=None, acceleration=1e4)))
    state.advance(1.0)
    iced = started(line(one(time=NEVER)))
    iced.advance(1.0)
    assert state.shedding_times() == [np.inf]
    assert np.array_equal(motion_of(state), motion_of(iced))


# ---- equilibria ----


def test_equilibrium_and_residual_have_lost_the_ice_by_their_time():
    """The unbalanced line once the ice has fallen: three ways to the same equilibrium."""
    scene = line(one(span=1, from_station=0.0, to_station=1.0), ice={"mass_per_length": 1.2})
    model = Model(scene)
    assert np.abs(model.rest(time=0.4).motion()[0]).max() < 1e-9
    u = model.rest(time=0.6).motion()[0]
    assert u[model.map.chain(1).middle, 1] > 0.5
    assert u[model.map.chain(2).middle, 1] < -0.1
    state = model.start()
    state.advance(0.6)
    state.settle()
    assert state.time == 0.6
    assert state.motion()[0] == pytest.approx(u, abs=1e-7)
    assert np.abs(state.motion()[2]).max() < 1e-5
    bare = scene.with_values({"shedding": [], "section.spans.0.ice": "none"})
    other = Model(bare)
    at = [model.equilibrium().x[:, :2] + u[:, :2], other.equilibrium().x[:, :2]]
    assert at[0] == pytest.approx(at[1], abs=2e-4)  # tension by another law; observed 5e-5


def test_a_moment_of_ice_untwists_the_conductor_when_it_falls():
    """The moment of the weight, which the equilibrium balanced, stays: GJ theta'' = g S_x3."""
    scene = line(one(span=1, from_station=0.0, to_station=1.0), initial={})
    scene = scene.with_values({"section.suspensions.0": {"kind": "post"}})
    state = started(scene)
    state.advance(0.6)
    state.settle()
    chain = state.model.map.chain(1)
    twist = state.motion()[0][chain.nodes, 3]
    length = state.model.chain_equilibrium(0).length
    expected = -9.81 * ICE["first_moment_x3"] * length**2 / (8.0 * 159.0)
    assert twist[len(twist) // 2] == pytest.approx(expected, rel=2e-3)
