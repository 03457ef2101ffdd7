"""Each integrator has the order and the stability that it declares."""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.input.scene_files import load_scene
from support.taut_span import taut_span

CHANNELS = np.array([NODE_INDEX[name] for name in ("u2", "u3", "theta")], np.int32)
LAW = {"kind": "pulse", "peak": 1.0, "rise": 2.0, "fall_start": 2.0, "fall": 2.0}
STEPS = {"newmark": (0.02, 0.01), "generalised_alpha": (0.02, 0.01), "gauss6": (0.05, 0.025)}
RESOLVING = {"newmark": (0.02, 0.01), "generalised_alpha": (0.005, 0.0025), "gauss6": (0.04, 0.02)}
"""Steps [s] for a mode of 5 Hz."""


def history(integrator, step, until=6.0, every=0.1):
    """Mid-span u2 and u3 every 0.1 s under a smooth pulse, no faster than the first modes."""
    load = {"evenly_spaced": 39, "force": [0.0, 1.0, 2.0], "torque": 1.0, "law": LAW}
    model = Model(load_scene("example1").with_values({
        "numerics.elements": 10, "numerics.newton_tolerance": 1e-13,
        "numerics.integrator": integrator,
        "numerics.time_step": step, "loads": [load],
    }))  # fmt: skip
    nodes = np.array([model.middle], np.int32)
    return (
        model.start()
        .run(round(until / every), round(every / step), CHANNELS[:2], nodes)
        .node_values[:, :, 0]
    )


@pytest.mark.parametrize("integrator", INTEGRATORS.values(), ids=INTEGRATORS)
def test_order_of_nonlinear_motion(integrator):
    """Kinks of the pulse's third derivative are at ends of steps; axial modes are not resolved."""
    reference = history("gauss6", 0.005)
    errors = [
        np.abs(history(integrator.name, step) - reference).max(axis=0)
        for step in STEPS[integrator.name]
    ]
    orders = np.log2(errors[0] / errors[1])
    # observed 2.049, 2.001 and 5.44, 6.15
    assert np.all(np.abs(orders - integrator.order) < 0.1 * integrator.order)


def frequency(integrator, step):
    """Frequency [Hz] of the first mode of a shaft's free twist."""
    nodes = np.arange(31, dtype=np.int32)
    run = shaft(integrator, step).start().run(200, 1, CHANNELS, nodes)
    theta = run.node_values[:, 2] @ np.sin(np.pi * nodes / 30.0)  # without traces of higher modes
    # y(n+1) + y(n-1) = 2 cos(omega h) y(n)
    cosine = 0.5 * (theta[1:-1] @ (theta[2:] + theta[:-2])) / (theta[1:-1] @ theta[1:-1])
    return np.arccos(cosine) / (2.0 * np.pi * step)


@pytest.mark.parametrize("integrator", INTEGRATORS.values(), ids=INTEGRATORS)
def test_order_of_the_frequency(integrator):
    """Against the same mesh at 2.5 ms; test_newmark_order.py checks the shaft's 5 Hz."""
    exact = frequency("gauss6", 0.0025)
    errors = [
        abs(frequency(integrator.name, step) / exact - 1.0) for step in RESOLVING[integrator.name]
    ]
    assert abs(np.log2(errors[0] / errors[1]) - integrator.order) < 0.1  # observed 1.939 and 5.929


def shaft(integrator, step):
    """Free twist of a taut undamped span, which is linear: modes at 5, 10, ... Hz."""
    return Model(
        taut_span(
            initial={"seed_twist": 1e-3},
            numerics={"time_step": step, "newton_tolerance": 1e-14, "integrator": integrator},
        )
    )


def energy(run):
    return (
        run.span_values[:, SPAN_INDEX["kinetic_energy"]]
        + run.span_values[:, SPAN_INDEX["potential_energy"]]
    )


CONSERVING = {
    name: integrator
    for name, integrator in INTEGRATORS.items()
    if integrator.spectral_radius == 1.0
}


@pytest.mark.parametrize("step", [0.02, 0.2, 1.0])
@pytest.mark.parametrize("integrator", CONSERVING.values(), ids=CONSERVING)
def test_spectral_radius(integrator, step):
    """Factor per step of free linear motion at omega h of 0.6, 6 and 31 in the first mode."""
    model = shaft(integrator.name, step)
    run = model.start().run(1000, 1, CHANNELS, np.array([model.middle], np.int32))
    levels = energy(run)
    radius = (levels[-1] / levels[0]) ** (0.5 / 999)
    assert integrator.unconditionally_stable
    assert abs(radius - integrator.spectral_radius) < 1e-12  # observed 6e-14


def alpha_oscillator(radius, omega_h, steps):
    """Displacements of an undamped oscillator released at 1, from the published equations."""
    m, f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    gamma, beta, square = 0.5 - m + f, 0.25 * (1.0 - m + f) ** 2, omega_h**2
    new = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 - f) * square, 0.0, 1.0 - m]])
    old = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [-f * square, 0.0, -m]])
    motion = [np.array([1.0, 0.0, -square])]  # u, h v, h^2 a
    for _ in range(steps):
        motion.append(np.linalg.solve(new, old @ motion[-1]))
    return np.array(motion)[1:, 0]


@pytest.mark.parametrize("step", [0.02, 0.2, 1.0])
@pytest.mark.parametrize("radius", [0.0, 0.5, 0.9, 1.0])
def test_motion_that_is_not_resolved_decays_as_chosen(radius, step):
    """Free linear motion at omega h of 0.6, 6 and 31 in the first mode."""
    scene = shaft("generalised_alpha", step).scene.with_values({"numerics.spectral_radius": radius})
    nodes = np.arange(31, dtype=np.int32)
    run = Model(scene).start().run(40, 1, CHANNELS, nodes)
    theta = run.node_values[:, 2] @ np.sin(np.pi * nodes / 30.0)
    found = theta / (1e-3 * np.sum(np.sin(np.pi * nodes / 30.0) ** 2))
    expected = alpha_oscillator(radius, 10.0 * np.pi * step, 40)
    assert np.abs(found - expected).max() < 5e-4  # observed 2e-4, what the mesh adds to the period


@pytest.mark.parametrize("integrator", CONSERVING.values(), ids=CONSERVING)
def test_energy_of_long_free_motion_does_not_drift(integrator):
    """Swing and galloping together, undamped and nonlinear: 300 s, some hundred periods."""
    values = {
        "loads": [],
        "initial.seed_vertical": 0.01,
        "initial.seed_horizontal": 0.3,
        "numerics.elements": 6,
    }
    values |= {
        "numerics.integrator": integrator.name,
        "numerics.time_step": STEPS[integrator.name][0],
    }
    model = Model(load_scene("example1").with_values(values))
    every = round(0.1 / STEPS[integrator.name][0])
    run = model.start().run(3000, every, CHANNELS, np.array([model.middle], np.int32))
    levels = energy(run)
    # observed 5e-8 and 1e-7
    assert abs(levels[-300:].mean() / levels[:300].mean() - 1.0) < 1e-6
