"""Motion is reversible, and has the same bits however it is run (docs/reference/stability.md)."""

import pytest

from gallop_fmu import Model, Scene, SceneError, SimulationError
from support.conservation import (
    conserving,
    energy_error,
    integrators,
    released,
    reverse,
    same_bits,
    way_back,
)
from support.random_spans import stress_scene


def possible(seed, count):
    """The first random scenes that have an initial equilibrium."""
    found, number = [], 0
    while len(found) < count:
        stress = stress_scene(seed, number, {"max_halvings": 3})
        number += 1
        try:
            scene = Scene.from_dict(stress.data)
            Model(scene).start()
        except (SceneError, SimulationError):
            continue
        found.append(scene)
    return found


def test_random_spans_have_the_same_bits_repeated_recorded_rarely_and_in_threads():
    assert same_bits(possible(5, 5), steps=16) == {
        "repeated": True,
        "recorded rarely": True,
        "in threads": True,
    }


@pytest.mark.parametrize("integrator", ["newmark", "gauss6"])
def test_a_smooth_motion_runs_back_to_where_it_came_from(integrator):
    found = way_back(
        released({"numerics.newton_tolerance": 1e-13, **integrators()[integrator]}), steps=1000
    )
    assert found < 1e-7  # observed 7e-10 after 2000 steps


def test_without_reversed_velocities_it_does_not():
    state = released()
    reverse(state)
    reverse(state)
    there, _, _ = state.motion()
    state.advance(state.time + 10.0)
    assert abs(state.motion()[0] - there).max() > 0.05


@pytest.mark.parametrize(
    ("integrator", "bound"),
    [
        ("newmark", 3e-4),  # observed 1.3e-4, as large at the end as at the begin
        ("generalised_alpha, spectral radius 1", 1.5e-4),  # observed 6.6e-5
        (
            "gauss6",
            1e-8,
        ),  # observed 3e-9 at the end, 6e-10 at the begin: what Newton's tolerance leaves adds up
    ],
)
def test_energy_error_is_bounded(integrator, bound):
    found = energy_error(released(conserving()[integrator]), steps=5000, every=10)
    assert found["amplitude"] > 0.2
    assert found["largest"] < bound
    assert found["last_tenth"] < max(1.5 * found["first_tenth"], 5e-9)


def test_generalised_alpha_dissipates_little_and_nothing_at_radius_1():
    """Share of the energy lost per vertical period of 144 steps."""
    loss = [
        energy_error(released(conserving()[name]), steps=50_000, every=50)["loss"]
        for name in ("generalised_alpha", "generalised_alpha, spectral radius 1")
    ]
    assert (
        1.1e-7 < loss[0] < 1.9e-7
    )  # observed 1.4e-7; 7.6e-8 of an oscillator of 0.695 Hz, more of faster modes
    assert abs(loss[1]) < 2e-8  # observed 4e-9
