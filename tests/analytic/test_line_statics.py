"""Statics of whole sections against elastic catenaries in closed form, and by symmetries."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import root

from tests.support.kernel_line import DRAKE, PULL, KernelLine, String

GRAVITY = 9.80665
WEIGHT = DRAKE["mass"] * GRAVITY
STIFFNESS = DRAKE["axial_stiffness"]


class ElasticCatenaries:
    """The same section by the closed form of the elastic catenary, N = EA (L / L0 - 1).

    Unknowns are the horizontal and vertical force at the left end of each span and the positions
    of the clamps; the equations close the spans and balance the clamps.
    """

    def __init__(self, line, temperature_change=0.0):
        self.line = line
        self.strung, towers = line.clamps()
        self.top = self.strung + towers
        for k, tower in enumerate(line.towers):
            if isinstance(tower, String) and not tower.end:
                self.top[k, 1] += tower.length
        expansion = 1.0 + DRAKE["thermal_expansion"] * temperature_change
        self.parameter = line.tension / WEIGHT
        ice = line.ice or [0.0] * len(line.spans)
        self.spans = []
        for k in range(len(line.spans)):
            length, rest = self._lengths(*(self.strung[k + 1] - self.strung[k])[:2])
            weight = length * (WEIGHT + ice[k] * GRAVITY)
            self.spans.append((rest * expansion, weight))
        self.free = [k for k, tower in enumerate(line.towers) if tower is not None]

    def _low(self, span, rise):
        c = self.parameter
        return 0.5 * span - c * math.asinh(rise / (2.0 * c * math.sinh(0.5 * span / c)))

    def _lengths(self, span, rise):
        """Length of the strung catenary, and without tension."""
        c, low = self.parameter, self._low(span, rise)
        length = c * (math.sinh((span - low) / c) + math.sinh(low / c))
        shape = lambda x: math.cosh((x - low) / c)  # noqa: E731
        rest = quad(
            lambda x: shape(x) / (1.0 + self.line.tension * shape(x) / STIFFNESS), 0.0, span,
            epsabs=1e-12, epsrel=1e-13,
        )[0]  # fmt: skip
        return length, rest

    def _clamp_force(self, k, place):
        """Force of the tower on a clamp, the weight of its string included."""
        tower, moved = self.line.towers[k], place - self.strung[k, :2]
        if not isinstance(tower, String):
            return np.array(
                [-tower[0] * moved[0] + (-1.0 if k == 0 else 1.0) * self.line.tension, 0.0]
            )
        bar = place - self.top[k, :2]
        length = np.hypot(*bar)
        pull = tower.stiffness * (length - tower.length)
        return -pull * bar / length - np.array([0.0, 0.5 * tower.weight])

    def equations(self, unknowns):
        count = len(self.spans)
        forces = unknowns[: 2 * count].reshape(count, 2) * self.line.tension
        place = self.strung[:, :2].copy()
        place[self.free] = unknowns[2 * count :].reshape(-1, 2) + self.strung[self.free, :2]
        miss, at = [], np.zeros((count + 1, 2))
        for k, (rest, weight) in enumerate(self.spans):
            h, v = forces[k]
            chord = place[k + 1] - place[k]
            ends = (v / h, (v - weight) / h)
            x = rest * h / STIFFNESS + rest * h / weight * (
                math.asinh(ends[0]) - math.asinh(ends[1])
            )
            y = -rest / STIFFNESS * (v - 0.5 * weight) - rest * h / weight * (
                math.hypot(1.0, ends[0]) - math.hypot(1.0, ends[1])
            )
            miss += [chord[0] - x, chord[1] - y]
            at[k] += (h, -v)
            at[k + 1] += (-h, -(weight - v))
        for k in self.free:
            balance = (at[k] + self._clamp_force(k, place[k])) / self.line.tension
            if not isinstance(self.line.towers[k], String):
                balance[1] = place[k, 1] - self.strung[k, 1]
            miss += list(balance)
        return np.array(miss)

    def solve(self, model):
        """Positions of the clamps and horizontal tensions, from those of a model on."""
        line, count = self.line, len(self.spans)
        chains = [model.chain(k) for k in range(count)]
        forces = [(chain.end_force[0][0], -chain.end_force[0][1]) for chain in chains]
        start = np.concatenate(
            [
                np.ravel(forces) / line.tension,
                (model.clamps() - self.strung)[self.free, :2].ravel(),
            ]
        )
        found = root(self.equations, start, tol=1e-14)
        assert np.abs(self.equations(found.x)).max() < 1e-9, found.message
        place = self.strung[:, :2].copy()
        place[self.free] += found.x[2 * count :].reshape(-1, 2)
        return place, found.x[0 : 2 * count : 2] * line.tension


def suspension(length=2.4, weight=600.0):
    return String(length, weight)


def ends(length=3.0, weight=800.0):
    return String(length, weight, 1), String(length, weight, -1)


UNEVEN = (300.0, 350.0, 280.0)
LEFT, RIGHT = ends()
CASES = {
    "uneven ice": (
        {"towers": [LEFT, suspension(), suspension(), RIGHT], "ice": [0.0, 3.0, 1.0]},
        0.0,
    ),
    "hot": ({"towers": [LEFT, suspension(), suspension(), None]}, 75.0),
    "very cold": ({"towers": [None, suspension(), suspension(5.0), None]}, -60.0),
    "rises of half the span": (
        {
            "spans": [300.0, 250.0, 380.0],
            "rises": [150.0, 120.0, 190.0],
            "towers": [None, suspension(), suspension(), None],
        },
        20.0,
    ),
    "one loaded span": (
        {
            "spans": [300.0] * 5,
            "towers": [None, *[suspension() for _ in range(4)], None],
            "ice": [0.0, 0.0, 8.0, 0.0, 0.0],
        },
        0.0,
    ),
    "springs": (
        {"towers": [(3e4, 3e4), suspension(), suspension(), (5e5, 3e4)], "ice": [0.0, 0.0, 4.0]},
        0.0,
    ),
    "one span between rigid ends": (
        {"spans": [300.0], "rises": [60.0], "towers": [None, None], "ice": [2.0]},
        -40.0,
    ),
    "short heavy strings": (
        {"towers": [None, suspension(0.6, 50.0), suspension(0.6, 3e3), None], "ice": [6, 0, 0]},
        10.0,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_section_hangs_as_elastic_catenaries(name):
    """Ten elements a span; seen: 9e-7 m, 1.4e-6 of the tension.

    The closed form has its mass evenly along the unstretched length, the kernel along the strung
    one; this makes the difference in tension.
    """
    values, change = CASES[name]
    line = KernelLine(**({"spans": list(UNEVEN), "tension": 25e3, "elements": 10} | values))
    model = line.model(temperature_change=change)
    place, tension = ElasticCatenaries(line, change).solve(model)
    found = [model.chain(k).horizontal_tension for k in range(len(line.spans))]
    assert np.abs(model.clamps()[:, :2] - place).max() < 2e-6
    assert found == pytest.approx(tension, rel=3e-6)
    assert model.derived().imbalance < 1e-6


def test_a_loaded_span_makes_its_strings_lean():
    """The case with the largest unbalanced pull: its clamps move by a metre along the line."""
    values, _ = CASES["one loaded span"]
    model = KernelLine(tension=25e3, **values).model()
    moved = model.clamps()[:, 0] - 300.0 * np.arange(6)
    assert moved[2] > 1.0
    assert moved == pytest.approx(-moved[::-1], abs=1e-9)
    assert min(model.observe_devices(model.start(), PULL)) > 0.0


def test_strings_of_equal_spans_hang_plumb():
    model = KernelLine([300.0] * 4, [None, *[suspension() for _ in range(3)], None], 25e3).model()
    assert np.abs(model.clamps()[:, 0] - 300.0 * np.arange(5)).max() < 1e-10


MIXED = {
    "spans": [300.0, 350.0, 280.0],
    "rises": [30.0, -10.0, 25.0],
    "towers": [String(3.0, 800.0, 1), suspension(2.0), suspension(3.0, 900.0), None],
    "ice": [0.5, 3.0, 0.0],
}


def turned_round(values):
    """The same section seen from the other side."""
    turned = {name: list(reversed(row)) for name, row in values.items()}
    turned["rises"] = [-rise for rise in turned["rises"]]
    turned["towers"] = [
        String(tower.length, tower.weight, -tower.end) if isinstance(tower, String) else tower
        for tower in turned["towers"]
    ]
    return turned


def test_a_section_seen_from_the_other_side_is_its_mirror_image():
    """Under wind, which comes from the other side too."""
    one = KernelLine(tension=25e3, drag=1.0, wind=15.0, **MIXED)
    two = KernelLine(tension=25e3, drag=1.0, wind=15.0, **turned_round(MIXED))
    models = [line.model(temperature_change=-20.0) for line in (one, two)]
    x = [model.clamps(model.rest()) for model in models]
    total, rise = sum(MIXED["spans"]), sum(MIXED["rises"])
    mirrored = x[1][::-1] * (-1.0, 1.0, 1.0) + (total, rise, 0.0)
    assert np.abs(mirrored - x[0]).max() < 1e-9
    forces = [np.array([model.rest().observe_junction(k) for k in range(4)]) for model in models]
    scale = np.abs(forces[0]).max()
    assert np.abs(forces[1][::-1] * (-1.0, 1.0, 1.0) - forces[0]).max() < 1e-8 * scale


def test_a_section_may_begin_anywhere():
    line = KernelLine(tension=25e3, **MIXED)
    here, there = line.model(), line.model(shift=(4096.0, -64.0, 16.0))
    moved = there.equilibrium().x - here.equilibrium().x
    assert np.abs(moved - (4096.0, -64.0, 16.0)).max() < 1e-8
    tension = [[m.chain(k).horizontal_tension for k in range(3)] for m in (here, there)]
    assert tension[1] == pytest.approx(tension[0], rel=1e-10)


def test_one_strung_span_is_the_single_span():
    """Without ice, devices and change of temperature the strung state is the equilibrium."""
    line = KernelLine([300.0], [None, None], 25e3, rises=[40.0], drag=1.0, wind=12.0)
    single, strung = line.model(strung=0), line.model()
    x = [model.equilibrium().x for model in (single, strung)]
    u = [model.rest().motion()[0] for model in (single, strung)]
    forces = [model.rest().observe_junction(1) for model in (single, strung)]
    assert x[1] == pytest.approx(x[0], rel=1e-10, abs=1e-9)
    assert u[1] == pytest.approx(u[0], rel=1e-10, abs=1e-9)
    assert forces[1] == pytest.approx(forces[0], rel=1e-10)
    for name in ("sag", "horizontal_tension", "length"):
        values = [getattr(model.derived(), name) for model in (single, strung)]
        assert values[1] == pytest.approx(values[0], rel=1e-10)


def test_long_strings_equalise_the_tension():
    """The ruling span is the limit: change of state on parabolas with sum L^3 / sum L."""
    spans, change = [200.0, 300.0, 400.0], 40.0
    towers = [None, suspension(400.0, 0.0), suspension(400.0, 0.0), None]
    model = KernelLine(spans, towers, 25e3, gravity=9.81).model(temperature_change=change)
    tension = [model.chain(k).horizontal_tension for k in range(3)]
    weight, ruling = DRAKE["mass"] * 9.81, math.sqrt(sum(L**3 for L in spans) / sum(spans))

    def strain(h):
        return h / STIFFNESS - (weight * ruling / h) ** 2 / 24.0

    wanted = root(
        lambda h: strain(h) - strain(25e3) + DRAKE["thermal_expansion"] * change, 20e3, tol=1e-12
    ).x[0]
    assert tension == pytest.approx([tension[1]] * 3, rel=2e-4)
    assert tension[1] == pytest.approx(wanted, rel=2e-3)


def test_the_mesh_converges():
    """Offsets of the clamps with few elements, against 80 a span."""
    values, change = CASES["uneven ice"]
    line = KernelLine(spans=list(UNEVEN), tension=25e3, elements=80, **values)
    fine = line.model(temperature_change=change).clamps()
    apart = []
    for line.elements in (4, 8):
        apart.append(np.abs(line.model(temperature_change=change).clamps() - fine).max())
    assert apart[0] < 8e-6  # seen: 4.1e-6
    assert math.log2(apart[0] / apart[1]) > 3.9
