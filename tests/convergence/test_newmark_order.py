"""Order of the time integration on smooth motion, and of the mesh in motion."""

import numpy as np

from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX
from gallop_fmu.input.scene_files import load_scene
from support.taut_span import taut_span

CHANNELS = np.array([NODE_INDEX[name] for name in ("u2", "u3", "theta")], np.int32)
SCENE = load_scene("example1").with_values(
    {"numerics.elements": 10, "numerics.newton_tolerance": 1e-13}
)
LAW = {"kind": "pulse", "peak": 1.0, "rise": 2.0, "fall_start": 2.0, "fall": 2.0}


def history(step, until=6.0, every=0.1):
    """Mid-span u2, u3 and twist every 0.1 s under a pulse no faster than the first modes."""
    load = {"evenly_spaced": 39, "force": [0.0, 1.0, 2.0], "torque": 1.0, "law": LAW}
    model = Model(SCENE.with_values({"numerics.time_step": step, "loads": [load]}))
    nodes = np.array([model.middle], np.int32)
    return (
        model.start()
        .run(round(until / every), round(every / step), CHANNELS, nodes)
        .node_values[:, :, 0]
    )


def test_newmark_is_of_second_order_in_the_step():
    """Order in u2 and u3; the twist is quasi-static here, with modes from 16 Hz."""
    reference = history(0.0005)
    errors = np.array(
        [np.abs(history(step) - reference).max(axis=0) for step in (0.02, 0.01, 0.005)]
    )[:, :2]
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(np.abs(orders - 2.0) < 0.1)  # observed 2.005 to 2.051


def test_damped_motion_in_wind_is_of_second_order():
    """Eccentric ice, damping, springs and a wind that rises smoothly."""
    wind = {"kind": "ramp", "initial": 0.0, "final": 8.0, "duration": 3.0}
    scene = load_scene("example2").with_values({
        "wind.speed": None, "wind.history": wind, "numerics.elements": 8,
        "numerics.newton_tolerance": 1e-13,
        "initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0,
    })  # fmt: skip

    def run(step):
        model = Model(scene.with_values({"numerics.time_step": step}))
        return (
            model.start()
            .run(50, round(0.1 / step), CHANNELS, np.array([model.middle], np.int32))
            .node_values[..., 0]
        )

    reference = run(0.00025)
    errors = np.array([np.abs(run(step) - reference).max(axis=0) for step in (0.01, 0.005, 0.0025)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(np.abs(orders - 2.0) < 0.1)  # observed 1.990 to 2.022


def test_frequency_of_a_shaft_is_of_second_order():
    """Free twist of a taut span, sqrt(GJ/I) / (2 L) = 5 Hz: period longer by (omega h)^2 / 12."""
    errors = []
    for step in (0.01, 0.005, 0.0025):
        model = Model(
            taut_span(
                initial={"seed_twist": 1e-3},
                numerics={"time_step": step, "newton_tolerance": 1e-14},
            )
        )
        theta = (
            model.start()
            .run(400, 1, CHANNELS, np.array([model.middle], np.int32))
            .node_values[:, 2, 0]
        )
        # y(n+1) + y(n-1) = 2 cos(omega h) y(n)
        cosine = 0.5 * (theta[1:-1] @ (theta[2:] + theta[:-2])) / (theta[1:-1] @ theta[1:-1])
        exact = np.sqrt(150.0 / 1.5e-4) / (2.0 * model.equilibrium().length)
        errors.append(np.arccos(cosine) / (2.0 * np.pi * step) / exact - 1.0)
    errors = np.array(errors)
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 2.0) < 0.1)  # observed 1.985, 1.998
