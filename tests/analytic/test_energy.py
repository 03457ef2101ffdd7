"""Energy of the undamped span without wind, with eccentric ice, over a thousand periods."""

import numpy as np
import pytest

from gallop_fmu.engine.inputs import Inputs
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.input.scene_files import load_scene

UNDAMPED = load_scene("example3").with_values({
    "wind.speed": 0.0, "damping.translation": None, "damping.twist": None,
    "initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0, "numerics.newton_tolerance": 1e-9,
})  # fmt: skip
PERIOD = 1.0 / 0.378  # first mode, horizontal [s]
MOTION = np.array([NODE_INDEX[name] for name in ("u2", "u3", "theta")], np.int32)


def total(span):
    return span[..., SPAN_INDEX["kinetic_energy"]] + span[..., SPAN_INDEX["potential_energy"]]


def released(step, duration, values=()):
    """Energy and mid-span motion after static loads have been removed within 0.5 s.

    Smoothly, so that the axial waves, whose period is shorter than the step, stay small.
    """
    let_go = {"kind": "ramp", "initial": 1.0, "final": 0.0, "duration": 0.5}
    load = {"evenly_spaced": 29, "force": [0.0, 21.0, 3.2], "torque": 0.032, "law": let_go}
    model = Model(
        UNDAMPED.with_values({"numerics.time_step": step, "loads": [load], **dict(values)})
    )
    state = model.rest()
    state.advance(0.5)
    start = total(state.observe_span())
    run = state.run(round(duration / step / 4), 4, MOTION, np.array([model.middle], np.int32))
    return total(run.span_values) / start - 1.0, run.node_values[:, :, 0]


def drift_and_oscillation(energy):
    """Relative change of the mean trend over the record, and root mean square of the remainder."""
    time = np.linspace(0.0, 1.0, len(energy))
    trend = np.polyfit(time, energy, 1)
    return trend[0], np.std(energy - np.polyval(trend, time))


def test_energy_does_not_drift_in_a_thousand_periods():
    energy, motion = released(UNDAMPED.numerics.time_step, 1000 * PERIOD)
    drift, oscillation = drift_and_oscillation(energy)
    assert np.all(np.abs(motion).max(axis=0) > [0.2, 0.1, 0.1])  # m, m, rad: a real motion
    assert abs(drift) < 1e-6  # observed 2.3e-8
    assert oscillation < 1.5e-4  # observed 4.8e-5
    assert np.abs(energy).max() < 5e-4  # observed 1.4e-4


def test_oscillation_of_the_energy_falls_with_the_square_of_the_step():
    oscillations = np.array(
        [drift_and_oscillation(released(step, 100.0)[0])[1] for step in (0.02, 0.01, 0.005)]
    )
    orders = np.log2(oscillations[:-1] / oscillations[1:])
    assert np.all(np.abs(orders - 2.0) < 0.1)  # observed 2.000, 2.004


def test_energy_of_a_span_on_springs_is_kept():
    """With the energy of the springs, of which a tenth would be visible."""
    springs = {"kind": "springs", "stiffness_x1": 80000.0, "stiffness_x3": 1500.0}
    values = {"supports.left": springs, "supports.right": springs}
    energy, _ = released(UNDAMPED.numerics.time_step, 60.0, values)
    assert np.abs(energy).max() < 1.5e-4  # observed 4e-5


def seeded(values, duration):
    model = Model(UNDAMPED.with_values(values))
    state = model.start()
    start = total(state.observe_span())
    run = state.run(
        round(duration / model.scene.numerics.time_step), 1, MOTION, np.array([0], np.int32)
    )
    return total(run.span_values) / start - 1.0


def test_energy_of_a_rough_start_is_kept_as_the_step_falls():
    """A vertical seed starts axial waves that steps of 10 ms cannot resolve: use smaller steps."""
    values = {
        "initial.seed_vertical": 0.2,
        "initial.seed_horizontal": 0.1,
        "initial.seed_twist": 0.1,
    }
    found = [
        np.abs(seeded(values | {"numerics.time_step": step}, 10.0)).max()
        for step in (0.01, 0.0025, 0.001)
    ]
    assert found[1] < 0.02  # observed 0.005; 0.1 at 10 ms
    assert found[2] < 1e-4  # observed 1.3e-5
    assert found[0] > found[1] > found[2]


def test_twist_alone_keeps_its_energy():
    """At the default tolerance: an early end of the iteration would excite or damp the twist."""
    energy = seeded({"initial.seed_twist": 0.1}, 100.0)
    assert np.abs(energy).max() < 1e-3  # observed 3e-4 with numerics.newton_tolerance = 1e-13


def test_wind_does_the_work_that_the_energy_gains():
    """Energy gained = work of lift, drag and moment, from the residual."""
    scene = UNDAMPED.with_values(
        {"wind.speed": 5.5, "numerics.time_step": 0.0025, "numerics.newton_tolerance": 1e-12}
    )
    model = Model(scene)
    calm = Model(scene.with_values({"wind.speed": 0.0}))
    state = model.start()
    energy, power = [total(state.observe_span())], []
    for i in range(801):
        u, v, a = state.motion()
        aerodynamic = calm.residual(u, v, a) - model.residual(u, v, a)
        power.append(np.sum(aerodynamic * v))
        energy.append(total(state.observe_span()))
        state.advance((i + 1) * 0.0025)
    gained, work = energy[-1] - energy[0], np.trapezoid(power, dx=0.0025)
    assert gained == pytest.approx(work, rel=5e-6)  # observed 1e-6


def test_potential_energy_leaves_out_the_static_reactions_on_moved_towers():
    """Both towers 1 m up: the span gains its weight times 1 m, the work of the reactions."""
    model = Model(UNDAMPED)
    lifted = model.rest(
        inputs=Inputs(0.0, 0.0, np.pi, np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]))
    )
    reactions = model.equilibrium().support_force[:, 1].sum()
    weight = UNDAMPED.conductor.mass_per_length * UNDAMPED.span.gravity * model.equilibrium().length
    assert abs(reactions) == pytest.approx(
        weight, rel=0.02
    )  # observed 0.8 %: sag and tension are both prescribed
    assert lifted.observe_span()[SPAN_INDEX["potential_energy"]] == pytest.approx(
        0.0, abs=1e-6 * weight
    )
