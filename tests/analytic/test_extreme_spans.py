"""Deep sag, slopes, storms, displaced towers and fine meshes against independent solutions."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import fsolve

import modal
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.scene.scene import Scene
from support.taut_span import taut_span

DRAG = {
    "kind": "polynomial", "valid_from_deg": -180.0, "valid_to_deg": 180.0, "outside": "periodic",
    "lift": [0.0], "drag": [1.1], "moment": [0.0],
}  # fmt: skip
LEFT = [SPAN_INDEX[f"left_f{axis}"] for axis in (1, 2, 3)]
STEEP = {
    "level": 0.0,
    "30 deg": 300.0 * math.tan(math.radians(30.0)),
    "44.9 deg": 300.0 * math.tan(math.radians(44.9)),
}


def hung(span, height, sag=300.0 / 8.0, **values):
    return span | {"span": {"length": 300.0, "height_difference": height, "sag": sag}} | values


@pytest.mark.parametrize("height", STEEP.values(), ids=STEEP)
def test_deep_and_steep_catenary(span, exact_cable, height):
    """A sag of an eighth of the span: horizontal tension, length and the shape of every node."""
    model = Model(Scene.from_dict(hung(span, height, numerics={"elements": 40})))
    found, cable = model.equilibrium(), exact_cable(model.scene)
    # the middle of a steep span lies between nodes, where a quadratic interpolates with a
    # third-order error
    assert found.horizontal_tension == pytest.approx(
        cable.horizontal_tension, rel=1.5e-6 if height else 5e-9
    )
    assert found.length == pytest.approx(
        cable.arc, rel=7e-8
    )  # observed 2.3e-8; the tension 5.0e-7 and 1.6e-9
    c = cable.horizontal_tension / cable.weight
    y = c * (np.cosh((found.x[:, 0] - cable.lowest) / c) - np.cosh(cable.lowest / c))
    assert np.abs(y - found.x[:, 1]).max() < (
        6e-5 if height else 2e-7
    )  # m; observed 1.9e-5 and 6.7e-8


@pytest.mark.parametrize("speed", [30.0, 60.0])
@pytest.mark.parametrize("height", STEEP.values(), ids=STEEP)
def test_blow_out_in_a_storm(span, exact_cable, height, speed):
    """Weight and wind in one inclined plane, up to 75 degrees from the vertical; sag up to 37 m."""
    wind = {"speed": speed, "air_density": 1.25}
    tension = exact_cable(Scene.from_dict(hung(span, height))).horizontal_tension
    deep = {"length": 300.0, "height_difference": height, "horizontal_tension": tension}
    scene = Scene.from_dict(
        span | {"span": deep, "wind": wind, "aerodynamics": DRAG, "numerics": {"elements": 40}}
    )
    model = Model(scene)
    drag = 0.5 * 1.25 * 0.028 * speed**2 * 1.1
    cable, state = exact_cable(model.scene), model.rest()
    force, _, (place,) = cable.solve(at=(0.5,), load=(0.0, 0.0, drag))
    found = model.equilibrium().x[model.middle] + state.observe_node(model.middle)[:3]
    assert np.linalg.norm(found - place) < 6e-7  # m; observed up to 2.1e-7
    assert np.linalg.norm(state.observe_span()[LEFT] - force) < 2e-8 * np.linalg.norm(
        force
    )  # observed 7e-9
    swing = math.atan2(found[2], 0.5 * height - found[1])
    if height == 0.0:
        assert swing == pytest.approx(math.atan2(drag, 1.6 * 9.81), rel=1e-9)


@pytest.mark.parametrize(
    "move",
    [(-3.0, 0.0, 0.0), (-120.0, 0.0, 0.0), (0.0, 60.0, 0.0), (-20.0, -50.0, 80.0), (2.0, 0.0, 9.0)],
)
def test_a_tower_far_out_of_place(span, exact_cable, move):
    """Towards the other tower, where the cable nearly goes slack, and away from it."""
    model = Model(Scene.from_dict(span | {"numerics": {"elements": 60}}))
    cable = exact_cable(model.scene)
    state = model.rest(inputs=Inputs(0.0, 0.0, 0.0, np.array([[0.0, 0.0, 0.0], move])))
    force, _, (place,) = cable.solve(at=(0.5,), right=np.array(move))
    found = model.equilibrium().x[model.middle] + state.observe_node(model.middle)[:3]
    assert np.linalg.norm(found - place) < 2e-5  # m; observed up to 5.6e-6
    assert np.linalg.norm(state.observe_span()[LEFT] - force) < 1.5e-8 * np.linalg.norm(
        force
    )  # observed up to 4.7e-9


@cache
def chain_frequencies(bars, length, height, tension, mass, stiffness):
    """Natural frequencies [Hz] of masses between bars: in plane, out of plane."""

    def hang(unknowns):
        step, start = unknowns[0] / bars, unknowns[1]
        vertical = start + mass * 9.81 * step * np.arange(bars)
        pull = np.hypot(tension, vertical)
        return step, pull, np.column_stack([np.full(bars, tension), vertical]) / pull[:, None]

    arc = math.hypot(length, height) * 1.04
    guess = [arc, tension * height / length - 0.5 * mass * 9.81 * arc]
    end = np.array([length, height])
    step, pull, slope = hang(
        fsolve(lambda y: hang(y)[0] * hang(y)[2].sum(axis=0) - end, guess, xtol=1e-13)
    )
    in_plane = stiffness / step * slope[:, :, None] * slope[:, None, :] + (pull / step)[
        :, None, None
    ] * np.eye(2)
    found = []
    for blocks in (in_plane, (pull / step)[:, None, None]):
        n = blocks.shape[1]
        matrix = np.zeros((n * (bars + 1), n * (bars + 1)))
        for k, block in enumerate(blocks):
            here = slice(n * k, n * (k + 2))
            matrix[here, here] += np.block([[block, -block], [-block, block]])
        squares = eigh(matrix[n:-n, n:-n], eigvals_only=True, subset_by_index=[0, 5])
        found.append(np.sqrt(squares / (mass * step)) / (2.0 * math.pi))
    return found


@pytest.mark.parametrize("height", STEEP.values(), ids=STEEP)
def test_modes_of_deep_and_steep_spans(span, height):
    """Against chains of 100 and 200 bars, extrapolated; six modes in the plane, six out of it."""
    model = Model(Scene.from_dict(hung(span, height, numerics={"elements": 40})))
    tension = model.equilibrium().horizontal_tension
    coarse, fine = (
        chain_frequencies(bars, 300.0, height, tension, 1.6, 3e7) for bars in (100, 200)
    )
    in_plane, across = ((4.0 * f - c) / 3.0 for c, f in zip(coarse, fine, strict=True))
    modes = [
        mode for mode in modal.natural_modes(model.scene, count=40) if mode.family != "torsional"
    ]
    found = [
        [
            mode.frequency_hz
            for mode in modes
            if (mode.family == "horizontal") == sideways and mode.family != "torsional"
        ]
        for sideways in (False, True)
    ]
    assert found[0][:6] == pytest.approx(
        in_plane, rel=1e-4
    )  # observed 6.2e-5, of the chain's extrapolation
    assert found[1][:6] == pytest.approx(across, rel=1e-4)  # observed 3.6e-5


def test_a_thousand_elements_at_rest(span, exact_cable):
    """Round-off grows with the mesh, but remains negligible: blow-out in a wind of 25 m/s."""
    wind = {"speed": 25.0, "air_density": 1.25}
    model = Model(
        Scene.from_dict(span | {"wind": wind, "aerodynamics": DRAG, "numerics": {"elements": 1000}})
    )
    cable, state = exact_cable(model.scene), model.rest()
    force, _, (place,) = cable.solve(at=(0.5,), load=(0.0, 0.0, 0.5 * 1.25 * 0.028 * 25.0**2 * 1.1))
    found = model.equilibrium().x[model.middle] + state.observe_node(model.middle)[:3]
    assert np.linalg.norm(found - place) < 1e-11  # m; observed 1e-13
    assert np.linalg.norm(state.observe_span()[LEFT] - force) < 2e-14 * np.linalg.norm(
        force
    )  # observed 4e-15


def string(**numerics):
    """Nearly weightless, so that its modes are sines."""
    return taut_span(
        span={"gravity": 0.01},
        initial={"seed_horizontal": 1e-4},
        numerics={"elements": 1000, "newton_tolerance": 1e-14, **numerics},
    )


def test_modes_of_a_thousand_elements():
    modes = [
        mode for mode in modal.natural_modes(string(), count=12) if mode.family == "horizontal"
    ]
    found = np.array([mode.frequency_hz for mode in modes[:3]])
    assert found == pytest.approx(
        np.arange(1, 4) * math.sqrt(92000.0 / 1.5) / 200.0, rel=2e-11
    )  # observed 3.4e-12


@pytest.mark.parametrize("integrator", ["newmark", "gauss6"])
def test_a_thousand_elements_in_motion(integrator):
    """A released string vibrates as a cosine at the frequency of the integration rule."""
    step = 0.01
    model = Model(string(time_step=step, integrator=integrator))
    state = model.start()
    u3 = np.array([NODE_INDEX["u3"]], np.int32)
    found = state.run(200, 1, u3, np.array([model.middle], np.int32)).node_values[:, 0, 0]
    omega = math.pi / 100.0 * math.sqrt(92000.0 / 1.5)
    if integrator == "newmark":
        omega = 2.0 / step * math.atan(0.5 * step * omega)
    time = step * np.arange(1, 201)
    assert np.abs(found - 1e-4 * np.cos(omega * time)).max() < 2e-12  # m; observed 5.7e-13
