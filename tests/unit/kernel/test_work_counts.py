"""Rules that save work, by counting it: sub-steps grow again, slow tangents are refactorised.

Bounds are two-sided; the comment is the count of a kernel in which the rule was changed.
"""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.model import Model

EXAMPLE3 = gf.load_scene("example3").with_values({"numerics.elements": 8})
SWAY = {"kind": "harmonic", "mean": 0.0, "amplitude": 1.0, "frequency_hz": 0.7}


def loaded(law, force, **numerics):
    load = {"position": 0.4, "force": [0.0, force, force], "law": law}
    values = {f"numerics.{name}": value for name, value in numerics.items()}
    return Model(EXAMPLE3.with_values({"loads": [load], "aerodynamics.outside": "hold"} | values))


def test_halved_steps_grow_back():
    """A load jumps at the start of a step: short sub-steps there and longer ones later."""
    jump = {"kind": "ramp", "initial": 0.0, "final": 1.0, "start": 0.201, "duration": 0.0}
    report = (
        loaded(jump, 3000.0, time_step=0.1, max_newton_iterations=4, max_halvings=10)
        .start()
        .advance(0.6)
    )
    assert report.steps == 6
    assert 20 <= report.halvings <= 32  # 26
    assert 36 <= report.substeps <= 54  # 44; without growing back 84


@pytest.mark.parametrize(("integrator", "iterations", "refactorisations"), [
    # refactorised at a rate of 0.3; at 0.2: 1683, 266; at 0.4: 2045, 200; at 0.99: 3868, 161
    ("newmark", 1828, 234),
    ("gauss6", 1560, 206),  # at 0.2: 1521, 241; at 0.4: 1610, 175; at 0.99: 2173, 22
])  # fmt: skip
def test_a_tangent_is_renewed_where_the_iteration_converges_slowly(
    integrator, iterations, refactorisations
):
    report = loaded(SWAY, 100.0, time_step=0.1, integrator=integrator).start().advance(30.0)
    allowed = 0.06 if integrator == "newmark" else 0.03
    assert report.halvings == 0
    assert report.iterations == pytest.approx(iterations, rel=allowed)
    assert report.refactorisations == pytest.approx(refactorisations, rel=2 * allowed)


def test_a_factorised_tangent_turns_with_the_cable():
    """Gauss's method, in a load that moves the span far: one tangent serves for all steps."""
    scene = gf.load_scene("example1").with_values(
        {
            "numerics.integrator": "gauss6",
            "numerics.time_step": 0.05,
            "numerics.newton_tolerance": 1e-9,
        }
    )
    report = Model(scene).start().advance(10.0)
    assert report.steps == 200
    assert report.refactorisations == 1  # without turning: 71
    # without turning: 911; with corrections that are not turned back: 692
    assert report.iterations == pytest.approx(591, rel=0.05)


@pytest.mark.parametrize(("tolerance", "fewest", "most"), [
    (None, 1, 1),  # otherwise 9: once in every few steps
    (1e-4, 8, 20),  # 12, as motion and step size change; otherwise 65
])  # fmt: skip
def test_round_off_of_a_clock_costs_no_factorisation(tolerance, fewest, most):
    """A host adds up 1/30 s, which is no multiple of the step."""
    state, time = Model(EXAMPLE3.with_values({"numerics.tolerance": tolerance})).start(), 0.0
    sizes = set()
    for _ in range(200):
        sizes.add(time + 1 / 30 - time)
        time += 1 / 30
        report = state.advance(time)
    assert len(sizes) > 3
    assert fewest <= report.refactorisations <= most


def test_a_step_of_another_size_costs_a_factorisation():
    """A difference of a thousandth is not round-off: it is a step."""
    step = EXAMPLE3.numerics.time_step
    state, time = Model(EXAMPLE3).start(), 0.0
    for size in [step, 0.999 * step] * 20:
        time += size
        report = state.advance(time)
    assert report.refactorisations == report.steps == 40


def test_the_time_step_is_met_within_round_off():
    """Steps of a host that equal the scene's but for round-off give the same bits as a run."""
    step, time = EXAMPLE3.numerics.time_step, 0.1
    stepped, ran = (Model(EXAMPLE3).start(time) for _ in range(2))
    assert time + step - time != step
    for _ in range(100):
        time += step
        stepped.advance(time)
    ran.run(1, 100, [], [])
    for found, expected in zip(stepped.motion(), ran.motion(), strict=True):
        assert np.array_equal(found, expected)
