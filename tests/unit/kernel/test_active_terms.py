"""What a scene does not need is left out, and the answer is that of the full computation.

The full computation is that of the same scene with a disturbance of 1e-200, which wakes a part and
moves nothing.
"""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model, Part
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX
from gallop_fmu.scene.loads import Load

OUT_OF_PLANE = Part.LATERAL_MOTION | Part.TWIST  # computed together or not at all
EVERYTHING = Part.AERODYNAMICS | Part.ECCENTRIC_ICE | OUT_OF_PLANE
NOTHING = 1e-200
CALM = {
    "wind.speed": 0.0,
    "ice.first_moment_x2": 0.0,
    "ice.first_moment_x3": 0.0,
    "initial.seed_vertical": 0.2,
}


def example3(*changes):
    """Portable: a compiler fuses other products in code for fewer unknowns."""
    values = {
        "numerics.time_step": 0.02,
        "numerics.newton_tolerance": 1e-12,
        "numerics.portable": True,
    }
    for change in changes:
        values |= change
    return gf.load_scene("example3").with_values(values)


def springs(scene):
    support = gf.load_scene("example2").supports
    return scene.model_copy(update={"supports": support})


IN_PLANE = example3(CALM, {"initial.seed_horizontal": 0.0})
WAKE_LATERAL, WAKE_TWIST = {"initial.seed_horizontal": NOTHING}, {"initial.seed_twist": NOTHING}
CASES = {
    "in the plane, seed of u3": (IN_PLANE, WAKE_LATERAL),
    "in the plane, seed of theta": (IN_PLANE, WAKE_TWIST),
    "springs, in the plane": (springs(IN_PLANE), WAKE_TWIST),
}


def computed(scene):
    result = gf.simulate(scene, 10.0, record_nodes="all")
    data = result.dataset
    channels = (
        "u1",
        "u2",
        "u3",
        "theta",
        "v2",
        "tension",
        "left_f1",
        "left_f2",
        "kinetic_energy",
        "potential_energy",
    )
    return Model(scene, inputs=False).parts, {name: data[name].values for name in channels}


@pytest.mark.parametrize("name", CASES)
def test_same_answer_as_the_full_computation(name):
    scene, wake = CASES[name]
    parts, fast = computed(scene)
    all_parts, full = computed(scene.with_values(wake))
    assert parts == Part(0)
    assert all_parts == OUT_OF_PLANE
    assert np.ptp(fast["u2"]) > 0.01
    for channel, values in fast.items():
        scale = np.abs(full[channel]).max() + 1e-30
        assert np.abs(values - full[channel]).max() <= 1e-12 * scale + 1e-30, channel  # observed 0


def test_no_wind_in_a_model_that_could_have_some():
    """A model for inputs keeps aerodynamics and all unknowns, but its laws give no wind."""
    channels = np.arange(len(NODE_CHANNELS), dtype=np.int32)
    calm, ready = (Model(IN_PLANE, inputs=inputs) for inputs in (False, True))
    assert ready.parts & ~calm.parts == Part.AERODYNAMICS | OUT_OF_PLANE
    nodes = np.arange(calm.nodes, dtype=np.int32)
    one, other = (model.start().run(50, 10, channels, nodes) for model in (calm, ready))
    assert np.ptp(one.node_values[:, NODE_INDEX["u2"], calm.middle]) > 0.1
    assert np.array_equal(one.node_values, other.node_values)
    assert np.array_equal(one.span_values, other.span_values)


WAKING = {
    "lateral seed": ({"initial.seed_horizontal": 1e-3}, OUT_OF_PLANE),
    "twist seed": ({"initial.seed_twist": 1e-3}, OUT_OF_PLANE),
    "wind": ({"wind.speed": 1.0}, OUT_OF_PLANE | Part.AERODYNAMICS),
    "ice": ({"ice.first_moment_x2": -1e-4}, OUT_OF_PLANE | Part.ECCENTRIC_ICE),
    "ice to the side": (
        {"ice.first_moment_x3": 1e-4},
        OUT_OF_PLANE | Part.ECCENTRIC_ICE,
    ),
}


@pytest.mark.parametrize("name", WAKING)
def test_what_wakes_a_part(name):
    change, woken = WAKING[name]
    assert Model(IN_PLANE, inputs=False).parts == Part(0)
    assert Model(IN_PLANE.with_values(change), inputs=False).parts == woken


@pytest.mark.parametrize(
    ("load", "woken"),
    [
        (Load(position=0.3, force=(0.0, 5.0, 0.0)), Part(0)),
        (Load(position=0.3, force=(0.0, 0.0, 5.0)), OUT_OF_PLANE),
        (Load(position=0.3, force=(0.0, 0.0, 0.0), torque=2.0), OUT_OF_PLANE),
        (
            Load(position=0.3, force=(0.0, 0.0, 5.0), law={"kind": "constant", "value": 0.0}),
            Part(0),
        ),
        (
            Load(
                position=0.3,
                force=(0.0, 0.0, 5.0),
                law={"kind": "ramp", "initial": 0.0, "final": 1.0, "start": 0.0, "duration": 1.0},
            ),
            OUT_OF_PLANE,
        ),
    ],
)
def test_loads_wake_what_they_drive(load, woken):
    scene = IN_PLANE.model_copy(update={"loads": (load,)})
    assert Model(scene, inputs=False).parts == woken


def test_lateral_motion_of_a_tower_wakes_the_span():
    motion = {"x3": {"kind": "harmonic", "amplitude": 0.1, "frequency_hz": 0.4}}
    left = type(IN_PLANE.supports.left).model_validate({"kind": "rigid", "motion": motion})
    scene = IN_PLANE.model_copy(
        update={"supports": IN_PLANE.supports.model_copy(update={"left": left})}
    )
    assert Model(scene, inputs=False).parts == OUT_OF_PLANE


def test_an_fmu_keeps_what_its_inputs_can_wake():
    assert Model(IN_PLANE).parts == Part.AERODYNAMICS | OUT_OF_PLANE
    assert Model(gf.load_scene("example3")).parts == EVERYTHING


def test_inputs_are_refused_where_they_could_wake_what_is_left_out():
    model = Model(IN_PLANE, inputs=False)
    blowing = Inputs(0.0, 5.0, 3.0, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="inputs=True"):
        model.start(inputs=blowing)
    with pytest.raises(ValueError, match="inputs=True"):
        model.start().advance(0.1, blowing)


def test_residual_and_tangent_are_always_complete():
    """The modal toolkit asks for twist and lateral motion of scenes that excite neither."""
    small, whole = (
        Model(IN_PLANE, inputs=False),
        Model(IN_PLANE.with_values(WAKE_TWIST), inputs=False),
    )
    u = np.random.default_rng(1).uniform(-0.1, 0.1, (small.nodes, 4))
    assert np.array_equal(small.residual(u), whole.residual(u))
    assert np.abs(small.residual(u)[:, 2:]).min(axis=0).max() > 0.0
    assert np.array_equal(
        small.tangent(u, stiffness=1.0, mass=1e4), whole.tangent(u, stiffness=1.0, mass=1e4)
    )


def test_provenance_names_what_was_left_out():
    attrs = gf.simulate(IN_PLANE, 0.1).dataset.attrs
    assert attrs["unknowns"] == "u1 u2"
    assert attrs["inactive_terms"] == "aerodynamics, eccentric ice, twist, lateral motion"
    whole = gf.simulate(example3(), 0.1).dataset.attrs
    assert whole["unknowns"] == "u1 u2 u3 theta"
    assert whole["inactive_terms"] == ""
