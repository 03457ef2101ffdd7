"""Equilibrium under loads and mean wind against the exact cable; twist against a shaft."""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.scene.scene import Scene

FORCES = [SPAN_INDEX[f"{end}_f{axis}"] for end in ("left", "right") for axis in (1, 2, 3)]
DRAG_ONLY = {
    "kind": "polynomial", "valid_from_deg": -180.0, "valid_to_deg": 180.0, "outside": "periodic",
    "lift": [0.0], "drag": [1.1], "moment": [0.0],
}  # fmt: skip


def compared(scene, cable, **loads):
    """Mid-span position and end force against the exact cable, relative to the load's effect."""
    model = Model(scene)
    state = model.rest()
    place = model.equilibrium().x[model.middle] + state.observe_node(model.middle)[:3]
    force = state.observe_span()[FORCES[:3]]
    at_rest = cable.solve(at=(0.5,))
    exact_force, _, exact_place = cable.solve(at=(0.5,), **loads)
    moved, changed = (
        np.linalg.norm(exact_place[0] - at_rest[2][0]),
        np.linalg.norm(exact_force - at_rest[0]),
    )
    return (
        np.linalg.norm(place - exact_place[0]) / moved,
        np.linalg.norm(force - exact_force) / changed,
        state,
    )


@pytest.mark.parametrize("height", [0.0, 40.0])
def test_blow_out_in_a_uniform_wind(span, exact_cable, height):
    """Mean wind with drag only: the cable hangs in the inclined plane of the resultant load."""
    span["span"]["height_difference"] = height
    scene = Scene.from_dict(
        span | {"wind": {"speed": 25.0, "air_density": 1.25}, "aerodynamics": DRAG_ONLY}
    )
    drag = 0.5 * 1.25 * 0.028 * 25.0**2 * 1.1  # 12 N/m against 15.7 N/m of weight
    cable = exact_cable(scene)
    place, force, state = compared(scene, cable, load=(0.0, 0.0, drag))
    assert place < 3e-8  # observed 6e-9
    assert force < 5e-8  # observed 1.1e-8
    model = state.model
    middle = model.equilibrium().x[model.middle] + state.observe_node(model.middle)[:3]
    if height == 0.0:
        assert np.arctan2(middle[2], -middle[1]) == pytest.approx(
            np.arctan2(drag, 1.6 * 9.81), rel=1e-9
        )


def test_blow_out_by_the_elastic_catenary(span, exact_cable):
    """Hooke's law on the unstretched length is close to axial Green strain at small strain."""
    scene = Scene.from_dict(
        span | {"wind": {"speed": 25.0, "air_density": 1.25}, "aerodynamics": DRAG_ONLY}
    )
    drag = 0.5 * 1.25 * 0.028 * 25.0**2 * 1.1
    place, force, _ = compared(scene, exact_cable(scene, law="engineering"), load=(0.0, 0.0, drag))
    assert place < 4e-5  # observed 9e-6
    assert force < 1e-4  # observed 3e-5


@pytest.mark.parametrize(
    ("count", "force"),
    [(29, (0.0, -60.0, 25.0)), (9, (10.0, 40.0, -80.0)), (1, (0.0, -900.0, 0.0))],
)
def test_point_loads(span, exact_cable, count, force):
    """At corner nodes of 30 elements the kinks are exact; loads stay at their material points."""
    loads = [{"evenly_spaced": count, "force": list(force)}]
    scene = Scene.from_dict(span | {"loads": loads, "numerics": {"elements": 30}})
    cable = exact_cable(scene, points=[])
    points = [(k / (count + 1), np.array(force)) for k in range(1, count + 1)]
    model = Model(scene)
    state = model.rest()
    u = state.observe_node(model.middle)[:3]
    cable.points = points
    left, right, places = cable.solve(at=(0.5,))
    cable.points = []
    start = cable.solve(at=(0.5,))
    moved, changed = np.linalg.norm(places[0] - start[2][0]), np.linalg.norm(left - start[0])
    found = state.observe_span()[FORCES]
    errors = (
        np.linalg.norm(u - (places[0] - start[2][0])) / moved,
        np.linalg.norm(found[:3] - left) / changed,
        np.linalg.norm(found[3:] + right) / changed,
    )
    assert max(errors) < 2e-8  # observed 5e-9


def test_loads_and_weight_are_carried_by_the_supports(span):
    loads = [
        {"position": 0.37, "force": [3.0, -50.0, 20.0]},
        {"evenly_spaced": 7, "force": [0.0, 5.0, -9.0]},
    ]
    model = Model(Scene.from_dict(span | {"loads": loads}))
    total = model.rest().observe_span()[FORCES].reshape(2, 3).sum(axis=0)
    expected = model.equilibrium().support_force.sum(axis=0) + np.array(
        [3.0, -50.0 + 35.0, 20.0 - 63.0]
    )
    assert np.abs(total - expected).max() < 1e-10  # observed 1e-11 N


@pytest.mark.parametrize("count", [14, 29])
def test_twist_under_a_distributed_torque(span, count):
    """n equal torques M at k/(n + 1), odd n: mid-span twist M L (n + 1) / (8 GJ)."""
    loads = [{"evenly_spaced": count, "force": [0.0, 0.0, 0.0], "torque": 0.2}]
    model = Model(Scene.from_dict(span | {"loads": loads, "numerics": {"elements": 30}}))
    length = model.equilibrium().length
    points = np.arange(1, count + 1) / (count + 1)
    exact = 0.2 * length / 250.0 * np.sum(0.5 * np.minimum(points, 1.0 - points))
    found = model.rest().observe_node(model.middle)[NODE_INDEX["theta"]]
    if count == 29:
        assert exact == pytest.approx(0.2 * length * 30 / (8 * 250.0), rel=1e-12)
    assert found == pytest.approx(exact, rel=1e-11)  # observed 3e-12


def test_twist_under_the_aerodynamic_moment(span):
    """A constant moment coefficient is a uniform torque t = q d^2 CM: twist t L^2 / (8 GJ)."""
    moment_only = DRAG_ONLY | {"drag": [0.0], "moment": [0.4]}
    scene = Scene.from_dict(
        span | {"wind": {"speed": 12.0, "air_density": 1.25}, "aerodynamics": moment_only}
    )
    model = Model(scene)
    torque = 0.5 * 1.25 * 12.0**2 * 0.028**2 * 0.4
    found = model.rest().observe_node(model.middle)[NODE_INDEX["theta"]]
    assert found == pytest.approx(
        torque * model.equilibrium().length ** 2 / (8 * 250.0), rel=1e-7
    )  # observed 1.8e-8
