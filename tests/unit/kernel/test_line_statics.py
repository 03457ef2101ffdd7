"""Equilibria of lines with strings in the kernel: towers' forces, refusals, starts, seeds."""

import math

import numpy as np
import pytest

from gallop_fmu.engine.model import State
from gallop_fmu.foundation.outcome import Outcome, SimulationError
from tests.support.kernel_line import DRAKE, LEAN_ACROSS, PULL, KernelLine, String

INTEGRATORS = {
    "newmark": {"integrator": 0},
    "generalised alpha": {"integrator": 2},
    "gauss": {"integrator": 1},
    "tolerance": {"integrator": 1, "tolerance": 1e-5},
}
SPANS = [300.0, 350.0, 280.0]
STRINGS = [String(3.0, 800.0, 1), String(2.4, 600.0), String(2.4, 600.0)]


def line(**values):
    given = {"spans": SPANS, "towers": [*STRINGS, None], "tension": 25e3, "elements": 10}
    return KernelLine(**(given | values))


def forces(model, state):
    return np.array([state.observe_junction(k) for k in range(model.junctions)])


def total_weight(of):
    """Of conductor, ice and strings [N]."""
    lengths = strung_lengths(of)
    masses = [of.conductor["mass"] + ice for ice in (of.ice or [0.0] * len(of.spans))]
    strings = sum(tower.weight for tower in of.towers if isinstance(tower, String))
    return of.gravity * float(np.dot(lengths, masses)) + strings


def strung_lengths(of):
    place, _ = of.clamps()
    parameter = of.tension / (of.conductor["mass"] * of.gravity)
    lengths = []
    for k in range(len(of.spans)):
        span, rise = (place[k + 1] - place[k])[:2]
        lengths.append(math.hypot(2.0 * parameter * math.sinh(0.5 * span / parameter), rise))
    return lengths


@pytest.mark.parametrize("change", [0.0, -40.0])
def test_the_towers_carry_weight_and_wind(change):
    """Conductor, ice and strings weigh what they did in the strung state; wind meets its length."""
    for wind in (0.0, 18.0):
        of = line(ice=[0.0, 2.0, 0.7], wind=wind, drag=1.1, rises=[20.0, 0.0, -35.0])
        model = of.model(temperature_change=change)
        drag = 0.5 * 1.2 * wind**2 * DRAKE["diameter"] * 1.1 * sum(strung_lengths(of))
        weight, force = total_weight(of), forces(model, model.rest())
        assert force.sum(axis=0) == pytest.approx([0.0, -weight, drag], abs=2e-6 * weight)
        if wind:
            continue
        for end in range(2):
            assert list(model.derived().support_force[end]) == pytest.approx(force[-end], abs=1e-5)


def test_a_chain_reports_its_own_numbers():
    """Sag, length and end forces follow from the nodes and from the balance of each span."""
    of = line(ice=[0.0, 2.0, 0.7], rises=[20.0, 0.0, -35.0])
    model = of.model()
    x = model.equilibrium().x
    for k, length in enumerate(strung_lengths(of)):
        chain, nodes = model.chain(k), x[21 * k : 21 * (k + 1)]
        ends = np.array([list(row) for row in chain.end_force])
        weight = (DRAKE["mass"] + of.ice[k]) * of.gravity * length
        assert ends.sum(axis=0) == pytest.approx([0.0, -weight, 0.0], rel=2e-6, abs=1e-5)
        assert ends[0][0] == pytest.approx(chain.horizontal_tension, rel=1e-9)
        polygon = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
        assert polygon < chain.length < 1.0001 * polygon
        chord = nodes[-1] - nodes[0]
        below = nodes[0, 1] + chord[1] * (nodes[:, 0] - nodes[0, 0]) / chord[0] - nodes[:, 1]
        assert chain.sag == pytest.approx(below.max(), rel=0.02)
    assert model.derived().sag == model.chain(0).sag


def test_a_spring_holds_the_strung_state_without_displacement():
    of = line(towers=[(3e4, 3e4), *STRINGS[1:], None])
    strung, iced = of.model(), line(towers=of.towers, ice=[2.0] * 3).model()
    assert np.abs(strung.clamps()[0]).max() < 1e-3  # the suspension strings stretch
    moved, pull = iced.clamps()[0][0], forces(iced, iced.start())[0][0]
    assert pull == pytest.approx(of.tension + 3e4 * moved, rel=1e-9)
    assert iced.chain(0).horizontal_tension == pytest.approx(pull, rel=1e-9)


# ---- refusals ----


@pytest.mark.parametrize("string", [0, 1])
def test_a_string_that_would_be_pushed_up_is_named(string):
    """A low tower between two high ones: the conductor lifts its clamp."""
    rises = [[-40.0, 40.0, 0.0], [0.0, -60.0, 60.0]][string]
    of = line(towers=[None, *STRINGS[1:], None], rises=rises)
    with pytest.raises(SimulationError, match=r"pull of a string \[N\]") as caught:
        of.model()
    assert caught.value.report.outcome is Outcome.EQUILIBRIUM_NOT_FOUND
    assert caught.value.report.device == string
    assert caught.value.report.value < 0.0


def test_a_push_that_the_conductor_withstands_is_reported_as_pull():
    """A slight push leaves the string where it is; its pull is negative."""
    of = line(
        spans=[300.0, 300.0], towers=[None, String(2.4, 100.0), None], rises=[-29.3, 29.3]
    )  # fmt: skip
    model = of.model()
    pull = model.observe_devices(model.start(), PULL)[0]
    assert -60.0 < pull < -20.0
    assert np.abs(model.clamps()[1] - [300.0, -29.3, 0.0]).max() < 1e-3


def test_a_string_that_the_wind_lifts_over_is_named():
    """On a low tower more pull means less weight: in a storm the clamp would rise to its tower."""
    of = line(towers=[None, *STRINGS[1:], None], rises=[-22.0, 22.0, 0.0], drag=1.0, wind=60.0)
    model = of.model()
    with pytest.raises(SimulationError, match=r"turn of a string \[rad\]") as caught:
        model.rest()
    assert caught.value.report.value > 0.5 * math.pi


def test_both_sag_and_tension_of_a_strung_span_are_refused():
    of = line()
    tables, numbers = of.tables()
    for chain in tables["chain"]:
        chain.sag = 5.0
    of.tables = lambda shift: (tables, numbers)
    with pytest.raises(SimulationError, match="sag of a strung span"):
        of.model()


# ---- starts and motion ----


@pytest.mark.parametrize("name", INTEGRATORS)
def test_a_line_starts_in_mean_wind_and_stays_there(name):
    """Strings lean as the wind and the weight that they carry want it; nothing moves."""
    of = line(ice=[0.0, 1.0, 0.5], wind=15.0, drag=1.0, motion={(1, 1): 0.3, (2, 2): 0.5})
    model = of.model(start_in_mean_wind=1, **INTEGRATORS[name])
    state = model.start()
    lean = model.observe_devices(state, LEAN_ACROSS)
    force = forces(model, state)
    for k in (1, 2):  # the bar's direction is that of its pull, half of its weight at the tower
        wanted = math.atan2(force[k][2], -force[k][1] - 0.5 * STRINGS[k].weight)
        assert lean[k] == pytest.approx(wanted, abs=1e-9)
    before = state.motion()[0]
    state.advance(2.0)
    assert np.abs(state.motion()[0] - before).max() < 1e-6


@pytest.mark.parametrize("name", INTEGRATORS)
def test_a_saved_state_of_a_line_continues_alike(name):
    model = line(wind=15.0, drag=1.0).model(seed_vertical=0.05, **INTEGRATORS[name])
    state = model.start()
    state.advance(1.0)
    other = State(model)
    other.restore(state.save())
    for each in (state, other):
        each.advance(2.0)
    assert other.save() == state.save()


def test_a_step_that_fails_is_halved_or_undone():
    """A gust that strikes at once: steps of 0.5 s are halved; without halvings the state stays."""
    of = line(wind=60.0, drag=1.0)
    model = of.model(time_step=0.5, max_newton_iterations=5)
    report = model.start().advance(4.0)
    assert report.halvings > 0
    strict = of.model(time_step=0.5, max_newton_iterations=5, max_halvings=0)
    state = strict.start()
    saved = state.save()
    with pytest.raises(SimulationError) as caught:
        state.advance(4.0)
    assert caught.value.report.outcome is Outcome.NEWTON_STALLED
    assert state.save() == saved


def test_the_seed_is_a_half_wave_in_every_span():
    """Between its clamps as they hang with ice, which have moved along the line."""
    of = line(ice=[0.0, 4.0, 0.0], towers=[None, *STRINGS[1:], None])
    model = of.model(seed_vertical=0.05, seed_horizontal=0.02, seed_twist=0.1)
    u = model.seed()
    x = model.equilibrium().x
    clamps = model.clamps()
    assert abs(clamps[1][0] - 300.0) > 0.1
    for k in range(3):
        own = slice(21 * k, 21 * (k + 1))
        at = (x[own, 0] - clamps[k][0]) / (clamps[k + 1][0] - clamps[k][0])
        for unknown, size in ((1, 0.05), (2, 0.02), (3, 0.1)):
            assert u[own, unknown] == pytest.approx(size * np.sin(math.pi * at), abs=1e-12)


def test_a_seed_leaves_fixed_unknowns_of_a_station_alone():
    of = line()
    tables, numbers = of.tables()
    of.tables = lambda shift: (of.with_station(tables, 1, 4), numbers)
    model = of.model(seed_vertical=0.05, seed_twist=0.1)
    u = model.seed()
    node = model.end_node(1) + 8
    assert u[node, 3] == 0.0
    assert u[node, 1] == pytest.approx(0.05 * math.sin(0.4 * math.pi), rel=1e-3)
    assert u[node - 1, 3] > 0.05
